"""Loops whose controller is taken out, so that somebody else closes them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from fuzzyctl.diagnostics.diagnostic import ArgumentError, UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.expr import Expr, Keyword, Name, Number, replace_names
from fuzzyctl.model.controller import Controller, Definition, Instance
from fuzzyctl.model.guarantee import Param
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.plant import Plant
from fuzzyctl.simulation.loop_params import block_params
from fuzzyctl.simulation.sample_times import sample_times


@dataclass(frozen=True)
class OpenedLoop:
    """A loop that is open at a controller.

    Args:
        loop: It has a param for each output of the controller, and a signal for each of its inputs.
        actions: The params.
        action_ranges: Their ends.
        observations: Names of the signals.
        observation_ranges: Their ends.
        shown: Names that a run has for the actions and observations, `BLOCK.SIGNAL`.
        every: Samples in each period of the controller.
        prefix: What stands before the names of states in the loop, but not for the user.
    """

    loop: Loop
    actions: tuple[str, ...]
    action_ranges: tuple[tuple[float, float], ...]
    observations: tuple[str, ...]
    observation_ranges: tuple[tuple[float, float], ...]
    shown: Mapping[str, str]
    every: int = 1
    prefix: str = ""


def opened_loop(loop: Loop, block: str) -> OpenedLoop:
    """Take a controller out of a loop.

    Args:
        loop: The loop.
        block: Name of its block.

    Raises:
        UnknownNameError: For a name of no block.
        ArgumentError: For a block that is a plant.
        DiagnosticError: For sample times that do not fit together.
    """
    instance = next((i for i in loop.instances if i.name == block), None)
    if instance is None:
        raise UnknownNameError("block", block, tuple(i.name for i in loop.instances))
    controller = next((c for c in loop.controllers if c.name == instance.controller), None)
    if controller is None:
        raise ArgumentError(f"block '{block}' is a plant: an agent takes the place of a controller")
    step, every = sample_times(loop)
    taken = {p.name for p in loop.params} | {d.name for d in loop.definitions} | {i.name for i in loop.instances}
    actions = _fresh(block, [r.name for r in controller.results], taken)
    observations = _fresh(block, [s.name for s in controller.inputs], taken | set(actions))
    values: dict[str, Expr] = {
        f"{block}.{r.name}": Name(action) for r, action in zip(controller.results, actions, strict=True)
    }
    given = _inputs(instance, controller)
    seen = tuple(Definition(name=n, value=e) for n, e in zip(observations, given, strict=True))
    set_params = dataclasses.replace(controller, params=tuple(
        dataclasses.replace(p, expression=Number(v))
        for p, v in zip(controller.params, block_params(loop, instance).values(), strict=True)
    ))  # fmt: skip
    others = tuple(i for i in loop.instances if i is not instance)
    changed = dataclasses.replace(
        loop,
        params=(*loop.params, *(Param(name=n, expression=Number(0.0)) for n in actions)),
        instances=tuple(
            dataclasses.replace(i, arguments=tuple(replace_names(a, values) for a in i.arguments)) for i in others
        ),
        definitions=tuple(
            dataclasses.replace(d, value=replace_names(d.value, values)) for d in (*loop.definitions, *seen)
        ),
        measures=tuple(dataclasses.replace(m, value=replace_names(m.value, values)) for m in loop.measures),
        controllers=tuple(c for c in loop.controllers if c.name in {i.controller for i in others}),
        step=Number(step),
    )
    return OpenedLoop(
        changed,
        actions,
        tuple(set_params.range_of(r) for r in controller.results),
        observations,
        tuple(set_params.range_of(s) for s in controller.inputs),
        dict(
            zip(
                (*actions, *observations),
                (f"{block}.{s.name}" for s in (*controller.results, *controller.inputs)),
                strict=True,
            )
        ),
        every[block],
    )


def opened_plant(plant: Plant, dt: float, duration: float) -> OpenedLoop:
    """Return a plant alone, its inputs open.

    Args:
        plant: The plant.
        dt: Sample time [s].
        duration: Length of a run [s].

    Raises:
        ValueOutOfBoundsError: For a duration of less than `dt`.
    """
    if duration < dt:
        raise ValueOutOfBoundsError("duration", duration, f">= dt = {dt:g}", "s")
    block = "plant"
    actions = _fresh(block, [s.name for s in plant.inputs], set())
    loop = Loop(
        name=plant.name, params=tuple(Param(name=n, expression=Number(0.0)) for n in actions),
        instances=(Instance(name=block, controller=plant.name, arguments=tuple(map(Name, actions)), span=plant.span),),
        duration=Number(float(duration)), step=Number(float(dt)), plants=(plant,), path=plant.path, span=plant.span,
    )  # fmt: skip
    return OpenedLoop(
        loop,
        actions,
        tuple(plant.range_of(s) for s in plant.inputs),
        tuple(f"{block}.{r.name}" for r in plant.results),
        tuple(plant.range_of(r) for r in plant.results),
        dict(zip(actions, (f"{block}.{s.name}" for s in plant.inputs), strict=True)),
        prefix=f"{block}.",
    )


def with_action_ranges(opened: OpenedLoop, given: Mapping[str, tuple[float, float]]) -> OpenedLoop:
    """Return an open loop whose actions have finite ranges, as agents draw them from these.

    Args:
        opened: The loop.
        given: Ranges by the names that the user has for the actions; the others are those of the text.

    Raises:
        UnknownNameError: For a name of no action.
        ArgumentError: For actions without a finite range.
    """
    known = [opened.shown[a].removeprefix(opened.prefix) for a in opened.actions]
    for name in given:
        if name not in known:
            raise UnknownNameError("action", name, known)
    ranges = tuple(given.get(n, ends) for n, ends in zip(known, opened.action_ranges, strict=True))
    without = [n for n, ends in zip(known, ranges, strict=True) if not all(map(math.isfinite, ends))]
    if without:
        what = "inputs of the plant" if opened.prefix else "outputs of the controller"
        raise ArgumentError(
            f"agents draw actions from finite ranges, which the {what} do not have: {', '.join(without)}; declare them "
            f'in the text, or give them, as actions={{"{without[0]}": (-10, 10)}}'
        )
    return dataclasses.replace(opened, action_ranges=ranges)


def _fresh(block: str, names: Sequence[str], taken: set[str]) -> tuple[str, ...]:
    """Return names `BLOCK_NAME` that the loop does not have."""
    found = []
    for name in names:
        new = f"{block}_{name}"
        while new in taken:
            new += "_"
        found.append(new)
        taken = taken | {new}
    return tuple(found)


def _inputs(instance: Instance, controller: Controller) -> list[Expr]:
    """Return what the inputs of a block are connected with, in order."""
    given = [a for a in instance.arguments if not isinstance(a, Keyword)]
    named = {a.name: a.value for a in instance.arguments if isinstance(a, Keyword)}
    names = [s.name for s in controller.inputs]
    by_name = dict(zip(names, given, strict=False)) | named
    return [by_name[name] for name in names]
