"""Rules looked up by cell: of a full table of k terms for each of n inputs only 2^n of k^n rules can act.

Where at most two terms of each input meet, the cell between the corners of the terms says which rules can act. Tables
hold the two degrees of each input in a cell, as lines, and for each cell the weights and consequents of its rules,
constants or linear ones. Cost grows with the number of inputs and not with that of the terms.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from functools import reduce
from itertools import pairwise, product
from typing import Final

from fuzzyctl.expr import ZERO, Binary, Call, Expr, Logic, Name, Number, Where, minus, plus, times
from fuzzyctl.kernels.algorithms.grid import ROUNDING, degree_at, is_continuous, knots_of, rounded, too_close
from fuzzyctl.kernels.inference.defuzzify.defuzzify import average, consequent_hull
from fuzzyctl.kernels.inference.inference import raw_names
from fuzzyctl.kernels.plan.build import OutputPlan, Plan, SetPlan, degree_name
from fuzzyctl.kernels.program.builder import Builder, any_nan, clip
from fuzzyctl.kernels.program.program import NAN, Item, Locate, Offset, Place, Program, Refuse
from fuzzyctl.records import record

#: Most numbers of all tables together: 1 MiB.
MOST_NUMBERS: Final = 1 << 17
#: Fewer rules for each that can act at a time are evaluated as fast all together.
LEAST_GAIN: Final = 2
#: So it is in generated Python and with numpy, where a table costs more to look into.
LEAST_GAIN_INTERPRETED: Final = 4
#: So it is in compiled loops over many points, where all rules become vector instructions.
LEAST_GAIN_MANY: Final = 20
#: Where corners that differ by rounding count as one, a degree as large as this decides whether a rule acts.
_LARGE: Final = 1e-3
#: There a rule counts for nothing whose weight is less than this part of the largest one: what is off by rounding of a
#: rule with the largest weight would be more than it says.
_WEIGHTY: Final = 0.1
#: Slopes below this have not all digits of a number.
_FLATTEST: Final = 2.0**-1000


#: Name, foot, slope and base of a term in a cell.
_Line = tuple[str | None, float, float, float]
_NO_TERM: Final[_Line] = (None, 0.0, 0.0, 0.0)


@record(frozen=True)
class Side:
    """One of the two terms of an input that meet in a cell: degree = slope · (x - foot) + base, held at 0.

    Each has a number for every cell, which begins at a knot; a term that is not there has the slope and base 0.
    """

    foot: tuple[float, ...]
    slope: tuple[float, ...]
    base: tuple[float, ...]


@record(frozen=True)
class Axis:
    """An input with at most two terms active at any point.

    Args:
        position: Its position.
        knots: Corners of its terms, rising; beyond the outer ones nothing changes.
        sides: The two terms of each cell.
        terms: Their names in each cell, None for a missing term.
        is_rounded: Whether there are corners that differ by rounding and count as one.
        is_covered: Whether everywhere some term has a degree far above rounding. Else minima may be as small as what
            corners of other inputs are off by.
    """

    position: int
    knots: tuple[float, ...]
    sides: tuple[Side, Side]
    terms: tuple[tuple[str | None, ...], tuple[str | None, ...]]
    is_rounded: bool
    is_covered: bool


@record(frozen=True)
class Sums:
    """Contributions of the rules of an output, for each cell, the last input's varying fastest, and each pair of sides.

    Args:
        weights: Σ w of the rules, by pair of sides and cell.
        constants: Σ w · c of the constants of the consequents.
        factors: Σ w · c of their factors, by input; empty for inputs that no consequent reads.
        hull: Bounds of the average.
    """

    weights: tuple[tuple[float, ...], ...]
    constants: tuple[tuple[float, ...], ...]
    factors: dict[str, tuple[tuple[float, ...], ...]]
    hull: tuple[float, float]

    @property
    def is_finite(self) -> bool:
        """Whether no number is infinite: times a rule that does not act, such a one would be NaN."""
        tables = (*self.weights, *self.constants, *(t for factors in self.factors.values() for t in factors))
        return all(math.isfinite(x) for table in tables for x in table)


@record(frozen=True)
class Active:
    """A system whose outputs are averages over one table of rules.

    Args:
        axes: The inputs that rules read.
        norm: The norm of their degrees, "min" or "product".
        outputs: One for each output.
        gain: How many rules there are for each that can act at a time.
    """

    axes: tuple[Axis, ...]
    norm: str
    outputs: tuple[Sums, ...]
    gain: float


def active_of(plan: Plan, *, least_gain: float = LEAST_GAIN) -> Active | str:
    """Return the tables of a system, or why it has none.

    Args:
        plan: The plan.
        least_gain: Rules that there must be for each that can act at a time.
    """
    reason = _unsuited(plan)
    if reason:
        return reason
    read = sorted({d.variable for d in plan.degrees})
    if len(plan.rules) < least_gain * (1 << len(read)):
        return f"{len(plan.rules)} rules are too few"
    rules = _Rules(plan)
    if rules.norm is None:
        return "rules are no conjunctions of one term of each input by 'min' or 'product'"
    axes: list[Axis] = []
    for position in read:
        axis = _axis(plan, position)
        if isinstance(axis, str):
            return axis
        axes.append(axis)
    if any(a.is_rounded for a in axes):
        if not _is_full(plan, rules):
            return "corners differ by rounding, and rules are missing"
        if rules.norm == "min" and not all(a.is_covered for a in axes):
            return "corners of one input differ by rounding, and another one has gaps"
    columns = sum(2 + len(_read_by(output)) for output in plan.outputs)
    numbers = math.prod(len(a.knots) for a in axes) * columns << len(axes)
    if numbers > MOST_NUMBERS:
        return f"its tables would have {numbers:,} numbers, more than {MOST_NUMBERS:,}"
    outputs = tuple(_sums(plan, output, axes, rules) for output in plan.outputs)
    if not all(s.is_finite for s in outputs):
        return "consequents of one cell add up to more than a number can be"
    return Active(tuple(axes), rules.norm, outputs, len(plan.rules) / (1 << len(axes)))


def _unsuited(plan: Plan) -> str:
    """Return why outputs are not averages of constants and linear functions over rules that act as they are."""
    if not plan.degrees:
        return "no rule reads an input"
    if plan.states or plan.held:
        return "it has a state"
    if plan.has_formulas:
        return "lets, or outputs that are formulas, are not looked up"
    if plan.chains or any(d.variable >= len(plan.inputs) for d in plan.degrees):
        return "rules read outputs"
    if plan.steps:
        return "rules share parts of their antecedents"
    if not plan.all_act or plan.least not in (None, 0.0):
        return "not every rule acts as far as its antecedent holds"
    other = next((d for d in plan.degrees if not is_continuous(d.set)), None)
    if other is not None:
        return f"term '{other.term}' of '{plan.variable(other.variable).name}' has no straight sides or jumps"
    output = next((o for o in plan.outputs if not _is_average(o)), None)
    if output is not None:
        return f"'{output.name}' is no average over rules of constants or bounded linear functions"
    return ""


def _is_average(output: OutputPlan) -> bool:
    return (
        output.averages
        and (output.merge, output.total, output.rate) == ("rules", "activations", None)
        and not (output.reads or output.clamped)
        and all(e.change is None and e.factor == 1.0 for e in output.implied)
        and all(linear_parts(output.terms[e.term]) is not None for e in output.implied)
    )


def _read_by(output: OutputPlan) -> set[str]:
    """Return the inputs that consequents of an output read."""
    parts = [linear_parts(output.terms[e.term]) for e in output.implied]
    return {name for part in parts if part is not None for name in part[0]}


def linear_parts(term: SetPlan) -> tuple[dict[str, float], float] | None:
    """Return the factors, by input, and the constant of a consequent; None for one that is not a bounded linear one."""
    if term.expression is None:
        return None if math.isinf(term.peak) else ({}, term.peak)
    if term.kind != "linear" or term.reach is None:
        return None
    factors: dict[str, float] = {}
    constant, left = 0.0, [term.expression]
    while left:
        match left.pop():
            case Number(value=value):
                constant += value
            case Binary(op="*", left=Number(value=value), right=Name(name=name)):
                factors[name] = value
            case Binary(op="+", left=a, right=b):
                left += [a, b]
            case _:
                return None
    return factors, constant


class _Rules:
    """The rules as combinations of terms.

    Attributes:
        norm: Their norm, "min" or "product"; None if they are not conjunctions of all inputs by one of these.
        terms: For each firing strength the term of each input that rules read, by position.
    """

    def __init__(self, plan: Plan) -> None:
        degrees = {degree_name(k): (d.variable, d.term) for k, d in enumerate(plan.degrees)}
        read = {d.variable for d in plan.degrees}
        norms: set[str] = set()
        self.terms = [_combination(strength, degrees, norms) for strength in plan.strengths]
        whole = all(t is not None and t.keys() == read for t in self.terms)
        self.norm = (norms or {"product"}).pop() if whole and len(norms) <= 1 else None


def _combination(strength: Expr, degrees: dict[str, tuple[int, str]], norms: set[str]) -> dict[int, str] | None:
    """Return the term of each input in a firing strength, None where it is not a conjunction of different inputs."""
    terms: dict[int, str] = {}
    left = [strength]
    while left:
        match left.pop():
            case Name(name=name) if name in degrees and degrees[name][0] not in terms:
                variable, term = degrees[name]
                terms[variable] = term
            case Call(function="min", arguments=(a, b)):
                norms.add("min")
                left += [a, b]
            case Binary(op="*", left=a, right=b):
                norms.add("product")
                left += [a, b]
            case _:
                return None
    return terms


def _axis(plan: Plan, position: int) -> Axis | str:
    """Return an input as an axis, or the reason against it."""
    terms = {d.term: d.set for d in plan.degrees if d.variable == position}
    knots = knots_of(plan.inputs[position], list(terms.values()))
    name = plan.inputs[position].name
    if too_close(knots, list(terms.values())):
        return f"corners of '{name}' lie too close to each other"
    is_rounded = bool(rounded(knots, list(terms.values())))
    least = ROUNDING if is_rounded else 0.0
    first: list[_Line] = []
    second: list[_Line] = []
    for left, right in pairwise((*knots, knots[-1])):
        there = [t for t, s in terms.items() if degree_at(s, left) > least or degree_at(s, right) > least]
        if len(there) > 2:
            return f"more than two terms of '{name}' meet between {left!r} and {right!r}"
        lines = [_line(t, terms[t], left, right, least) for t in there]
        pair = [line for line in lines if line is not None] + [_NO_TERM] * (2 - len(there))
        if len(pair) < 2:
            return f"terms of '{name}' are too flat or too steep"
        first.append(pair[0])
        second.append(pair[1])
    names = tuple(n for n, *_ in first), tuple(n for n, *_ in second)
    covered = all(max(degree_at(s, x) for s in terms.values()) > _LARGE for x in knots)
    if is_rounded and not covered:
        return f"corners of '{name}' differ by rounding, and next to them are gaps"
    return Axis(position, knots, (_side(first), _side(second)), names, is_rounded, covered)


def _is_full(plan: Plan, rules: _Rules) -> bool:
    """Return whether each output has a rule that can act for each combination of terms."""
    terms = {(d.variable, d.term) for d in plan.degrees}
    whole = math.prod(Counter(variable for variable, _ in terms).values())
    least = _WEIGHTY * max((r.weight for r in plan.rules), default=0.0)
    named = [[plan.rules[e.rule] for e in o.implied] for o in plan.outputs]
    acting = [{rule.strength for rule in group if rule.weight > least} for group in named]
    combinations = [{frozenset((rules.terms[s] or {}).items()) for s in group} for group in acting]
    return all(len(group) == whole for group in combinations)


def _side(lines: Sequence[_Line]) -> Side:
    return Side(tuple(line[1] for line in lines), tuple(line[2] for line in lines), tuple(line[3] for line in lines))


def _line(name: str, term: SetPlan, left: float, right: float, least: float) -> _Line | None:
    """Return foot, slope and base of a term in a cell, None where the slope has not all digits of a number.

    It is counted from where the degree is smallest, which avoids cancellation there. Degrees of at most `least` at the
    ends are 0 but for rounding.
    """
    at_left, at_right = (d if d > least else 0.0 for d in (degree_at(term, left), degree_at(term, right)))
    if at_left == at_right:
        return name, left, 0.0, at_left
    slope = (at_right - at_left) / (right - left)
    if not _FLATTEST <= abs(slope) < math.inf:
        return None
    return (name, right, slope, at_right) if at_right < at_left else (name, left, slope, at_left)


def _sums(plan: Plan, output: OutputPlan, axes: Sequence[Axis], rules: _Rules) -> Sums:
    """Return the contributions of an output's rules in each cell."""
    parts: dict[tuple[str | None, ...], tuple[float, float, dict[str, float]]] = {}
    for entry in output.implied:
        rule, consequent = plan.rules[entry.rule], linear_parts(output.terms[entry.term])
        terms = rules.terms[rule.strength]
        assert consequent is not None, "others are left to the rules"
        assert terms is not None, "others have no norm"
        key = tuple(terms[a.position] for a in axes)
        weight, constant, factors = parts.get(key, (0.0, 0.0, {}))
        changes = {n: factors.get(n, 0.0) + rule.weight * c for n, c in consequent[0].items()}
        parts[key] = weight + rule.weight, constant + rule.weight * consequent[1], factors | changes
    read = _read_by(output)
    names = [i.name for i in plan.inputs if i.name in read]
    none = (0.0, 0.0, dict[str, float]())
    rows = [
        [parts.get(combination, none) for combination in product(*cell)]
        for cell in product(*(list(zip(*a.terms, strict=True)) for a in axes))
    ]
    by_sides = list(zip(*rows, strict=True))
    used = [e.term for e in output.implied if plan.rules[e.rule].weight > 0.0]
    return Sums(
        weights=tuple(tuple(p[0] for p in changes) for changes in by_sides),
        constants=tuple(tuple(p[1] for p in changes) for changes in by_sides),
        factors={n: tuple(tuple(p[2].get(n, 0.0) for p in changes) for changes in by_sides) for n in names},
        hull=consequent_hull(output, used),
    )


def lookup(plan: Plan, active: Active) -> Program:
    """Write the program that adds up over the rules of a cell."""
    builder, raw = Builder(), raw_names(plan)
    degrees, places = _degrees(builder, active, raw)
    norm = _min if active.norm == "min" else times
    strengths = [reduce(lambda a, b: builder.let(norm(a, b)), combination) for combination in product(*degrees)]
    strides = [math.prod(len(a.knots) for a in active.axes[k + 1 :]) for k in range(len(active.axes))]
    cell = builder.fresh()
    builder.statements.append(Offset(cell, tuple(zip(places, strides, strict=True))))
    clamped = {
        i.name: x if i.extrapolate else builder.let(clip(x, i.lower, i.upper))
        for i, x in zip(plan.inputs, raw, strict=True)
    }
    results: list[Expr] = []
    for output, sums in zip(plan.outputs, active.outputs, strict=True):
        above = _total(builder, strengths, sums.constants, cell)
        for name, factors in sums.factors.items():
            above = plus(above, times(clamped[name], builder.let(_total(builder, strengths, factors, cell))))
        below = builder.let(_total(builder, strengths, sums.weights, cell))
        value, fires = average(builder, output, builder.let(above), below, sums.hull)
        if output.otherwise == "error":
            quiet = Logic("and", (Logic("not", (fires,)), Logic("not", (any_nan(raw),))))
            builder.statements.append(Refuse(quiet, output.name))
        results.append(Where(any_nan(raw), NAN, value))
    return builder.program(raw, results)


def _min(a: Expr, b: Expr) -> Expr:
    return Call("min", (a, b))


def _degrees(builder: Builder, active: Active, raw: Sequence[Expr]) -> tuple[list[list[Expr]], list[str]]:
    """Write the two degrees of each input, and where its cell is."""
    degrees: list[list[Expr]] = []
    places: list[str] = []
    for axis in active.axes:
        place, rest = builder.fresh(), builder.fresh()
        x = builder.let(clip(raw[axis.position], axis.knots[0], axis.knots[-1]))
        builder.statements.append(Locate(place, rest, x, builder.table(axis.knots), axis.knots, 1, wants_rest=False))
        places.append(place)
        degrees.append([_degree(builder, side, x, place) for side in axis.sides])
    return degrees, places


def _degree(builder: Builder, side: Side, x: Expr, place: str) -> Expr:
    foot, slope, base = (_looked_up(builder, values, place) for values in (side.foot, side.slope, side.base))
    return builder.let(plus(times(slope, minus(x, foot)), base))


def _looked_up(builder: Builder, values: Sequence[float], place: str) -> Expr:
    """Return a number of a table, or the number that all of them are."""
    if len(set(values)) == 1:
        return Number(values[0])
    return Item(builder.table(values), Place(place))


def _total(builder: Builder, strengths: Sequence[Expr], tables: Sequence[Sequence[float]], cell: str) -> Expr:
    """Return Σ strength · number of the cell."""
    parts = []
    for strength, values in zip(strengths, tables, strict=True):
        factor = _looked_up(builder, values, cell)
        parts.append(ZERO if factor == ZERO else times(factor, strength))
    return builder.total(parts)
