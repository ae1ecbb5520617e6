"""Trace of one evaluation: degrees, activations, contributions of rules, slopes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, Self

from fuzzyctl.diagnostics.diagnostic import ArgumentError, NoRuleFiresError, UnknownNameError
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.expr import Expr, names_in
from fuzzyctl.formats.fz import membership_text, rule_text
from fuzzyctl.kernels.backends.arguments import input_number
from fuzzyctl.kernels.forms import known_at, value_of
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.inference.defuzzify.defuzzify import consequent_hull
from fuzzyctl.kernels.plan.build import OutputPlan, Plan, SetPlan, chain_name, degree_name, plan, step_name
from fuzzyctl.kernels.program import scalar
from fuzzyctl.model.method import TSUKAMOTO
from fuzzyctl.model.rule import Consequent
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.operations import Printed, operation
from fuzzyctl.support import arguments

if TYPE_CHECKING:
    from fuzzyctl.annotations import Axes, Panels

#: Slopes are those of parabolas through the point and two beside it, this part of an input's range apart.
STEP: Final = 1e-6
#: Smallest change of an output over an input's range, relative to the output: rounding gives smaller ones.
_FLAT: Final = 1e-8
#: By so much, as a part of the largest value, an output may differ from the mean of the values of its rules:
#: far more than by rounding, and less than the printed digits.
_SAME: Final = 1e-9


@dataclass(frozen=True)
class Contribution:
    """The contribution of a rule to one output.

    Args:
        output: The output.
        term: The consequent's name with its hedges, or its text for one without a name.
        value: Its value in an average over rules, None for a fuzzy set or where it changes with the activation.
        effective_activation: The activation applied to the consequent, after hedges and weight.
        share: The rule's part of all activations that move the output, from 0 to 1.
        influence: Its effect on the output compared with the average of the others, share · (value - output); None as
            for `value`, and where the output is not the mean of the values by their shares: a sum, held within its
            range, of rules that are joined first, or divided by something else.
    """

    output: str
    term: str
    value: float | None
    effective_activation: float
    share: float
    influence: float | None


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


@dataclass(frozen=True, repr=False)
class Trace(Printed):
    """An evaluation taken apart.

    Args:
        system: The system.
        inputs: The point.
        outputs: The outputs there.
        degrees: The degrees that rules read, by variable and term; NaN where the variable has no value.
        rules: Those that act, by activation, the highest first; none that reads a variable without a value.
        silent: Number of rules that do not.
        lets: Values of the lets at the point, by name.
        slopes: Change of each output per unit of each input, to the left and to the right of the point; they differ
            where the surface has an edge.
    """

    system: FuzzySystem = field(compare=False)
    inputs: dict[str, float]
    outputs: dict[str, float]
    degrees: dict[str, dict[str, float]]
    rules: tuple[FiredRule, ...]
    silent: int
    slopes: dict[str, dict[str, tuple[float, float]]]
    lets: dict[str, float]

    def __repr__(self) -> str:
        values = [", ".join(f"{n} = {x:.6g}" for n, x in part.items()) for part in (self.inputs, self.outputs)]
        acting = f"{counted(len(self.rules), 'rule')} {'acts' if len(self.rules) == 1 else 'act'}"
        return printable(f"Trace({self.system.name} at {values[0]}: {values[1]}; {acting})")

    def as_dict(self) -> dict[str, Any]:
        """Return the trace as plain data, without the system."""
        data = {f.name: getattr(self, f.name) for f in fields(self) if f.compare}
        return data | {"rules": [asdict(r) for r in self.rules]}

    def plot(self, *, most: int = 12, ax: Axes | None = None) -> Panels:
        """Draw the rules that act, see `fuzzyctl.plot.rules`."""
        panels: Panels = operation("plot_trace")(self, most, ax)
        return panels


def trace(system: FuzzySystem, values: Mapping[str, float], state: Sequence[float] | None = None) -> Trace:
    """Take an evaluation apart.

    Args:
        system: A well-formed system.
        values: A number for every input.
        state: Its state; None for initial consequents of adaptive outputs, and first values of held ones.

    Raises:
        UnknownNameError: For a name that is not an input.
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
    point = [input_number(n, values[n]) for n in names]
    program = inference.trace(flat)
    function = scalar.compile_source(scalar.evaluation_source(program), program, names)
    traced = _Traced(function, flat.initial_state if state is None else state)
    results = traced.at(point)
    count, width = len(flat.degrees), len(flat.outputs)
    activations, outputs = results[count : count + len(flat.rules)], results[-width:]
    without_value = {k for k, value in enumerate((*point, *outputs)) if math.isnan(value)}
    silent = _silent(flat, without_value)
    effective = _effective(flat, results[count + len(flat.rules) : -width], silent)
    active = {r for r, a in enumerate(activations) if a > 0.0} - silent
    for output, effects in zip(flat.outputs, effective, strict=True):
        active |= {e.rule for e, effect in zip(output.implied, effects, strict=True) if effect > 0.0}
    acting = sorted(active, key=lambda r: (-activations[r], r))
    numbers = known_at(flat, point) | dict(zip((o.name for o in flat.outputs), outputs, strict=True))
    parts = [_Contributions.of(flat, o, effective[k], outputs[k], numbers, active) for k, o in enumerate(flat.outputs)]
    return Trace(
        system=system,
        inputs=dict(zip(names, point, strict=True)),
        outputs=dict(zip((o.name for o in flat.outputs), outputs, strict=True)),
        degrees=_degrees(flat, results[:count], without_value),
        rules=tuple(_fired(system, r, activations[r], parts) for r in acting),
        silent=len(flat.rules) - len(acting),
        slopes=_slopes(flat, traced, point),
        lets={let.name: numbers[let.name] for let in flat.lets},
    )


def _silent(flat: Plan, missing: set[int]) -> set[int]:
    """Return the rules that read a variable without a value, or how far such rules have activated a term."""
    if not missing:
        return set()
    lost = {degree_name(k) for k, d in enumerate(flat.degrees) if d.variable in missing}
    silent: set[int] = set()

    def reads(expr: Expr) -> bool:
        return any(n.name in lost for n in names_in(expr))

    while True:
        for k, step in enumerate(flat.steps):
            if reads(step):
                lost.add(step_name(k))
        more = {r for r, rule in enumerate(flat.rules) if reads(flat.strengths[rule.strength])} - silent
        if not more:
            return silent
        silent |= more
        for k, chain in enumerate(flat.chains):
            if any(flat.outputs[chain.output].implied[e].rule in silent for e in chain.entries):
                lost.add(chain_name(k))


def _effective(flat: Plan, effects: tuple[float, ...], silent: set[int]) -> list[list[float]]:
    """Return for each output the activation applied to each of its consequents; 0 for a silent rule."""
    rest = iter(effects)
    every = [[(entry.rule, next(rest)) for entry in output.implied] for output in flat.outputs]
    return [[0.0 if rule in silent else effect for rule, effect in row] for row in every]


class _Traced:
    """The compiled trace of a plan, called with one state."""

    def __init__(self, function: Any, state: Sequence[float]) -> None:
        self.function = function
        self.state = (state,) if state else ()

    def at(self, point: list[float]) -> tuple[float, ...]:
        results = self.function(*point, *self.state)
        return results if isinstance(results, tuple) else (results,)


def _degrees(flat: Plan, degrees: tuple[float, ...], missing: set[int]) -> dict[str, dict[str, float]]:
    tables: dict[str, dict[str, float]] = {}
    for d, value in zip(flat.degrees, degrees, strict=True):
        tables.setdefault(flat.variable(d.variable).name, {})[d.term] = math.nan if d.variable in missing else value
    return tables


@dataclass(frozen=True)
class _Contributions:
    """The effects of consequents on an output.

    Args:
        output: The output.
        effects: The activation applied to each of its consequents.
        values: The value of each in an average; None for sets, for silent rules, and if it changes with the activation.
        whole: The sum of the shares.
        mean: The output, where it is the mean of the values by their shares, else None.
    """

    output: OutputPlan
    effects: list[float]
    values: list[float | None]
    whole: float
    mean: float | None

    @classmethod
    def of(
        cls,
        flat: Plan,
        output: OutputPlan,
        effects: list[float],
        result: float,
        numbers: dict[str, float],
        active: set[int],
    ) -> Self:
        """Take an output apart."""
        values = [_value(output, output.terms[e.term], numbers) if e.rule in active else None for e in output.implied]
        whole = sum(effects)
        pairs = [(w / whole, v) for w, v in zip(effects, values, strict=True) if w and v is not None]
        off = abs(sum(share * v for share, v in pairs) - result)
        # No comparison holds where something is NaN.
        is_mean = not output.sums and off <= _SAME * max((abs(v) for _, v in pairs), default=0.0)
        return cls(output, effects, values, whole, result if is_mean else None)

    @cached_property
    def _entries(self) -> dict[int, list[int]]:
        """The positions of the consequents of each rule."""
        entries: dict[int, list[int]] = {}
        for k, entry in enumerate(self.output.implied):
            entries.setdefault(entry.rule, []).append(k)
        return entries

    def by(self, rule: int, consequents: Sequence[Consequent]) -> list[Contribution]:
        """Return the contributions of a rule whose consequents are given."""
        entries = self._entries.get(rule, [])
        # A rule may set an output several times; its entries stand in the order of its consequents.
        named = [c for c in consequents if c.output == self.output.name]
        parts = []
        for k, consequent in zip(entries, named, strict=True):
            effect, value = self.effects[k], self.values[k]
            share = effect / self.whole if self.whole else 0.0
            influence = None if value is None or self.mean is None else share * (value - self.mean)
            parts.append(Contribution(self.output.name, _named(consequent), value, effect, share, influence))
        return parts


def _fired(system: FuzzySystem, position: int, activation: float, outputs: Sequence[_Contributions]) -> FiredRule:
    rule = system.rules[position]
    parts = tuple(c for output in outputs for c in output.by(position, rule.consequents))
    block = system.rule_methods[position].block
    name = system.rule_blocks[block].name if block >= 0 else ""
    return FiredRule(position + 1, rule_text(rule), activation, parts, name)


def _value(output: OutputPlan, term: SetPlan, values: dict[str, float]) -> float | None:
    """Return the value of a consequent in an average, None for a set and for what changes with the activation."""
    if not output.over_rules or output.kind in TSUKAMOTO:
        return None
    if term.expression is None:
        return term.peak if output.rate is not None else consequent_hull(output, [output.terms.index(term)])[0]
    return value_of(term.expression, values)


def _named(consequent: Consequent) -> str:
    term = consequent.term if isinstance(consequent.term, str) else membership_text(consequent.term)
    return " ".join((*consequent.hedges, term))


def _slopes(flat: Plan, traced: _Traced, point: list[float]) -> dict[str, dict[str, tuple[float, float]]]:
    width = len(flat.outputs)

    def outputs(changed: list[float]) -> tuple[float, ...]:
        try:
            return traced.at(changed)[-width:]
        except NoRuleFiresError:
            return (math.nan,) * width

    here = outputs(point)
    slopes: dict[str, dict[str, tuple[float, float]]] = {o.name: {} for o in flat.outputs}
    for k, variable in enumerate(flat.inputs):
        x, step = point[k], STEP * (variable.upper - variable.lower)
        if math.isfinite(x):
            step = max(step, math.ulp(x))
        # Far from 0 the neighbours are rounded, and so is how far they are.
        moves = [(x + d) - x if math.isfinite(x) else d for d in (-step, -2 * step, step, 2 * step)]
        values = [outputs([*point[:k], x + d, *point[k + 1 :]]) for d in moves]
        for o, output in enumerate(flat.outputs):
            ends = [abs(end) for end in (output.lower, output.upper) if math.isfinite(end)]
            flattest = _FLAT * max(abs(here[o]), *ends) / max(variable.upper - variable.lower, step)
            a, b, c, d = ((value[o] - here[o]) / move for value, move in zip(values, moves, strict=True))
            pair = [_extrapolated(*of) for of in ((a, b, *moves[:2]), (c, d, *moves[2:]))]
            left, right = (0.0 if abs(slope) <= flattest else slope for slope in pair)
            slopes[output.name][variable.name] = (left, right)
    return slopes


def _extrapolated(near: float, far: float, step: float, larger: float) -> float:
    """Return the slope at a point from those of two secants, without their error of first order."""
    return near + (near - far) * step / (larger - step)
