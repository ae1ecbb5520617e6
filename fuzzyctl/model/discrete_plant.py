"""Plants as difference equations: steps of the classical method of Runge and Kutta, with inputs held."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from fuzzyctl.expr import Expr, Name, Number, names_in, replace_names
from fuzzyctl.model.controller import Controller, Definition, Result, State
from fuzzyctl.model.loop import TIME
from fuzzyctl.model.plant import Plant

#: Of the stages of the classical method of fourth order the divisor of the step for their weights, and where in the
#: step they lie. `RunSource` prints the same method into loops, fmu_rk4.h has it in C, dwmr.plant in compiled Python; a
#: test holds all of them to the same bits.
STAGES: Final = ((6.0, 0.0), (3.0, 0.5), (3.0, 0.5), (6.0, 1.0))
#: Stages end within the step: a signal that jumps at the next sample has not jumped yet.
BEFORE: Final = 1.0 - 1e-15


def discretised(plant: Plant, step: float, substeps: int = 1) -> Controller:
    """Return a plant as a controller whose states are those of the plant at its samples.

    Its outputs are those at the sample. A plant that reads the time `t` has it as a state.

    Args:
        plant: A well-formed plant with equations and without dead time, its params set.
        step: The sample time [s].
        substeps: Steps of integration in it.
    """
    length = Number(step / substeps)
    items: list[Definition | Result] = [*plant.definitions, *plant.derivatives, *plant.results]
    reads_time = any(n.name == TIME for item in items for n in names_in(item.value))
    definitions: list[Definition] = []

    def let(name: str, value: Expr) -> Name:
        definitions.append(Definition(name=name, value=value))
        return Name(name)

    begin: dict[str, Expr] = {s.name: Name(s.name) for s in plant.states}
    for k in range(substeps):
        at, following = begin, dict(begin)
        for stage, (divisor, share) in enumerate(STAGES):
            label = f"#{k}.{stage}" if k or stage else ""
            moment: Expr = Name(TIME)
            if label:
                moment = moment + Number(k + share) * length
                moment = moment * Number(BEFORE) if share == 1.0 else moment
            rates = _rates(plant, {**at, TIME: moment}, label, definitions)
            weight = Number(length.value / divisor)
            following = {n: x + weight * rates[n] for n, x in following.items()}
            if stage < 3:
                ahead = Number(STAGES[stage + 1][1] * length.value)
                at = {n: let(f"{n}#{k}.{stage + 1}", x + ahead * rates[n]) for n, x in begin.items()}
        begin = {n: let(f"{n}#{k + 1}", x) for n, x in following.items()}
    states = tuple(replace(s, bounds=None) for s in plant.states)
    updates = [Definition(name=n, value=x) for n, x in begin.items()]
    if reads_time:
        states = (*states, State(name=TIME, unit="s", start=Number(0.0)))
        updates.append(Definition(name=TIME, value=Name(TIME) + Number(step)))
    return Controller(
        **{n: getattr(plant, n) for n in ("name", "citation", "params", "functions", "inputs", "systems")},
        title=f"{plant.title or plant.name}, integrated by Runge and Kutta in steps of {length.value:.12g} s",
        states=states, definitions=tuple(definitions), results=plant.results, updates=tuple(updates),
        period=Number(step), path=plant.path, span=plant.span,
    )  # fmt: skip


def _rates(plant: Plant, known: Mapping[str, Expr], label: str, definitions: list[Definition]) -> dict[str, Expr]:
    """Write the definitions and derivatives of a plant at one stage; return the names of the derivatives."""
    env: dict[str, Expr] = dict(known)
    env |= {d.name: Name(f"{d.name}{label}") for d in plant.definitions}
    definitions += [Definition(name=f"{d.name}{label}", value=replace_names(d.value, env)) for d in plant.definitions]
    rates = {d.name: f"{d.name}#rate{label}" for d in plant.derivatives}
    definitions += [Definition(name=rates[d.name], value=replace_names(d.value, env)) for d in plant.derivatives]
    return {name: Name(rate) for name, rate in rates.items()}
