"""Why a system gives what it gives at a point: degrees, rules that act, what each contributes, slopes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from fuzzyctl import arguments
from fuzzyctl.errors import ArgumentError, NoRuleFiresError, UnknownNameError
from fuzzyctl.formats.fz import membership_text, rule_text
from fuzzyctl.kernels import inference, python_backend
from fuzzyctl.kernels.defuzzify import consequent_hull
from fuzzyctl.kernels.plan import OutputPlan, Plan, SetPlan, plan
from fuzzyctl.model.method import TSUKAMOTO
from fuzzyctl.model.rule import Consequent
from fuzzyctl.model.system import FuzzySystem

#: Slopes are differences over this part of an input's range.
STEP: Final = 1e-6


@dataclass(frozen=True)
class Contribution:
    """What a rule does to one output.

    Args:
        output: The output.
        term: The consequent's name with its hedges, or its text for one without a name.
        value: What it is in an average over rules, None for a fuzzy set or where it changes with the activation.
        felt: How far the output feels the rule: its activation, or what hedges of the consequent make of that.
        share: The rule's part of all activations that move the output, from 0 to 1.
        pull: What it adds to the output compared with the average of the others, share · (value - output); None as for
            `value`.
    """

    output: str
    term: str
    value: float | None
    felt: float
    share: float
    pull: float | None


@dataclass(frozen=True)
class FiredRule:
    """A rule that acts.

    Args:
        number: Its number, from 1 on, in the order written.
        text: The rule as `.fz` text; a cell of a table as the rule it stands for.
        activation: Weight times firing strength, as the activation method lets it act.
        contributions: One for each consequent, in the order of the outputs; of one output in the order written.
        block: Name of its rule block, nothing for a rule of none.
    """

    number: int
    text: str
    activation: float
    contributions: tuple[Contribution, ...]
    block: str = ""


@dataclass(frozen=True)
class Trace:
    """An evaluation taken apart.

    Args:
        inputs: The point.
        outputs: The outputs there.
        degrees: The degrees that rules read, by variable and term.
        rules: Those that act, by activation, the highest first.
        silent: Number of rules that do not.
        slopes: Change of each output per unit of each input, to the left and to the right of the point; they differ
            where the surface has an edge.
    """

    inputs: dict[str, float]
    outputs: dict[str, float]
    degrees: dict[str, dict[str, float]]
    rules: tuple[FiredRule, ...]
    silent: int
    slopes: dict[str, dict[str, tuple[float, float]]]


def trace(system: FuzzySystem, values: Mapping[str, float]) -> Trace:
    """Take an evaluation apart.

    Args:
        system: A well-formed system; adaptive outputs have their initial consequents, held ones their first values.
        values: A number for every input.

    Raises:
        UnknownNameError: For a name that is no input.
        ArgumentError: When an input is missing or no number.
        NoRuleFiresError: Where no rule fires for an output that says `else error`.
    """
    arguments.instance("the system", FuzzySystem, "a FuzzySystem", system)
    values = arguments.mapping("'values'", "numbers by name of the input", values)
    flat = plan(system)
    names = [i.name for i in flat.inputs]
    for name in values:
        if name not in names:
            raise UnknownNameError("input", name, names)
    missing = [n for n in names if n not in values]
    if missing:
        raise ArgumentError(f"a value is missing for: {', '.join(missing)}")
    point = [python_backend.as_number(values[n]) for n in names]
    program = inference.trace(flat)
    found = _Traced(flat, python_backend.compile_source(python_backend.evaluation_source(program), program, names))
    results = found.at(point)
    count, width = len(flat.degrees), len(flat.outputs)
    activations, outputs = results[count : count + len(flat.rules)], results[-width:]
    felt = _felt(flat, results[count + len(flat.rules) : -width])
    active = {r for r, a in enumerate(activations) if a > 0.0}
    for output, effects in zip(flat.outputs, felt, strict=True):
        active |= {e.rule for e, effect in zip(output.implied, effects, strict=True) if effect > 0.0}
    acting = sorted(active, key=lambda r: (-activations[r], r))
    return Trace(
        inputs=dict(zip(names, point, strict=True)),
        outputs=dict(zip((o.name for o in flat.outputs), outputs, strict=True)),
        degrees=_degrees(flat, results[:count]),
        rules=tuple(_fired(system, flat, r, activations[r], felt, outputs, dict(values)) for r in acting),
        silent=len(flat.rules) - len(acting),
        slopes=_slopes(flat, found, point),
    )


def _felt(flat: Plan, effects: tuple[float, ...]) -> list[list[float]]:
    """Return for each output how far it feels each consequent that names it."""
    rest = iter(effects)
    return [[next(rest) for _ in output.implied] for output in flat.outputs]


class _Traced:
    """The compiled trace of a plan, called with its initial state."""

    def __init__(self, flat: Plan, function: Any) -> None:
        self.function = function
        self.state = (flat.initial_state,) if flat.initial_state else ()

    def at(self, point: list[float]) -> tuple[float, ...]:
        results = self.function(*point, *self.state)
        return results if isinstance(results, tuple) else (results,)


def _degrees(flat: Plan, degrees: tuple[float, ...]) -> dict[str, dict[str, float]]:
    found: dict[str, dict[str, float]] = {}
    for d, value in zip(flat.degrees, degrees, strict=True):
        found.setdefault(flat.variable(d.variable).name, {})[d.term] = value
    return found


def _fired(
    system: FuzzySystem,
    flat: Plan,
    position: int,
    activation: float,
    felt: list[list[float]],
    outputs: tuple[float, ...],
    inputs: dict[str, float],
) -> FiredRule:
    rule = system.rules[position]
    known = inputs | dict(zip((o.name for o in flat.outputs), outputs, strict=True))
    parts = []
    for output, effects, value in zip(flat.outputs, felt, outputs, strict=True):
        total = sum(effects)
        entries = [(e, effect) for e, effect in zip(output.implied, effects, strict=True) if e.rule == position]
        # A rule may set an output several times; its entries stand in the order of its consequents.
        named = [c for c in rule.consequents if c.output == output.name]
        for (entry, effect), consequent in zip(entries, named, strict=True):
            share = effect / total if total else 0.0
            own = _value(flat, output, output.terms[entry.term], known)
            pull = None if own is None or output.sums else share * (own - value)
            parts.append(Contribution(output.name, _named(consequent), own, effect, share, pull))
    block = system.rule_methods[position].block
    name = system.rule_blocks[block].name if block >= 0 else ""
    return FiredRule(position + 1, rule_text(rule), activation, tuple(parts), name)


def _value(flat: Plan, output: OutputPlan, term: SetPlan, known: dict[str, float]) -> float | None:
    """Return what a consequent is in an average, None for a set and for what changes with the activation."""
    if not output.over_rules or output.kind in TSUKAMOTO:
        return None
    if term.expression is None:
        return term.peak if output.rate is not None else consequent_hull(output, [output.terms.index(term)])[0]
    held = {i.name: known[i.name] if i.extrapolate else min(max(known[i.name], i.lower), i.upper) for i in flat.inputs}
    held |= {o.name: known[o.name] for o in flat.outputs}
    function = python_backend.scalar_function(term.expression)
    return float(function(**{n: held[n] for n in held if n in function.__code__.co_varnames}))


def _named(consequent: Consequent) -> str:
    term = consequent.term if isinstance(consequent.term, str) else membership_text(consequent.term)
    return " ".join((*consequent.hedges, term))


def _slopes(flat: Plan, found: _Traced, point: list[float]) -> dict[str, dict[str, tuple[float, float]]]:
    width = len(flat.outputs)

    def outputs(changed: list[float]) -> tuple[float, ...]:
        try:
            return found.at(changed)[-width:]
        except NoRuleFiresError:
            return (math.nan,) * width

    here = outputs(point)
    slopes: dict[str, dict[str, tuple[float, float]]] = {o.name: {} for o in flat.outputs}
    for k, variable in enumerate(flat.inputs):
        step = STEP * (variable.upper - variable.lower)
        left, right = (outputs([x + (side * step if i == k else 0.0) for i, x in enumerate(point)]) for side in (-1, 1))
        for o, output in enumerate(flat.outputs):
            slopes[output.name][variable.name] = ((here[o] - left[o]) / step, (right[o] - here[o]) / step)
    return slopes
