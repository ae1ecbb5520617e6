"""Method of inference: norms, implication, aggregation and defuzzifier."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, fields
from typing import Final, Literal, get_args

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Expr
from fuzzyctl.model.block import Node
from fuzzyctl.records import dataclass


@dataclass(frozen=True, kw_only=True)
class Semantics(Node):
    """The knobs of inference that no norm, activation method or defuzzifier names; the defaults are `exact`.

    Args:
        profile: Name of the profile the knobs came from.
        weight: Whether a rule's weight multiplies its firing strength before implication, or the implied set after it.
        merge: The parts of a sum over rules: `rules`; `terms`, where rules of one consequent term are first joined by
            the aggregation; or `places`, the same for consequents at one place.
        total: The divisor of an average: the `activations` of the rules summed over; their firing `strengths`, weights
            left out; or the activations of `all_rules`, those included that do not name the output.
        least: A rule acts only if its activation is above it; None for rules that always act. A rule of activation 0
            that acts has an effect only if a hedge in its consequent makes something of it.
        equal: Degrees that differ by less count as equal where a drastic, nilpotent or Hamacher norm asks for equality.
        chained: An output in an antecedent counts with its crisp `value`, or with the `degree` up to which its term has
            been activated by the rules before.
        consequent_hedges: A hedge in a consequent changes the `set`; the `activation`; or the activation of this and of
            all later consequents of the rule, `carried`. `undone` changes the set too, but where an output sums over
            rules the activation, by the inverse of the hedge.
        extremely: What that hedge is: `contrast`, 2x² up to ½ and 1 - 2(1 - x)² above; or `cube`, x³.
        sigmoid_difference: The degree of a negative difference of two sigmoids: its `magnitude`, or 0,
            `clamped`.
        places: Places that `tsukamoto` finds are `clamped` to the range of the output, or `free`.
        none_active: The maxima of a set that is 0 everywhere: none, so that the output is as if no rule fires,
            `otherwise`; or all of the `range`.
        fallback: When an output has the value of its `else`: when no rule fires, `unfired`; or whenever it has no
            value, `undefined`, for instance because a function in a consequent has none.
    """

    profile: str = "exact"
    weight: Literal["before", "after"] = "before"
    merge: Literal["rules", "terms", "places"] = "rules"
    total: Literal["activations", "strengths", "all_rules"] = "activations"
    least: float | None = 0.0
    equal: float = 0.0
    chained: Literal["value", "degree"] = "value"
    consequent_hedges: Literal["set", "activation", "carried", "undone"] = "set"
    extremely: Literal["contrast", "cube"] = "contrast"
    sigmoid_difference: Literal["magnitude", "clamped"] = "magnitude"
    places: Literal["clamped", "free"] = "clamped"
    none_active: Literal["otherwise", "range"] = "otherwise"
    fallback: Literal["unfired", "undefined"] = "unfired"

    @property
    def joins_rules(self) -> bool:
        """Whether the aggregation matters to sums over rules and to conditions that read the activation of a term."""
        return self.merge != "rules" or self.chained == "degree"

    def text(self, knob: str) -> str:
        """Return the value of a knob as rule files write it."""
        value = getattr(self, knob)
        return "none" if value is None else value if isinstance(value, str) else repr(float(value))


#: Names of the knobs.
KNOBS = tuple(f.name for f in fields(Semantics) if f.name not in ("span", "profile"))


Grid = Literal["midpoint", "endpoints", "left"]

_GRIDS: Final = get_args(Grid)
_MAXIMA: Final = {"resolution": (), "grid": _GRIDS, "rule": ("all", "running"), "tolerance": ()}
_BISECTIONS: Final = ("interpolated", "first", "nearest", "walk", "two_sided", "between", "polygon")


@dataclass(frozen=True)
class DefuzzifierKind:
    """The properties of a defuzzifier.

    Args:
        title: Its usual name in the literature.
        takes: A number of the set (`area` or `maximum`), or the number by which a rule counts, weighted by its
            activation: the `middle` of the core of its consequent term, the `place` where the monotone membership
            function of its consequent has the degree of the activation, or the `degree` that the consequent has at
            the activation. For the last three implication and aggregation have no effect.
        divides: Whether it is divided by the sum of the activations.
        options: Its options, with the words that each of them takes; no words for a number.
    """

    title: str
    takes: Literal["area", "maximum", "middle", "place", "degree"]
    divides: bool = True
    options: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


#: All defuzzifiers by name. `center_average` is the name that Mamdani systems use, `weighted_average` the one of
#: Takagi-Sugeno systems; the formula is the same, Eq. (18) of Goto, Bertol, Martins.
DEFUZZIFIERS: Final[Mapping[str, DefuzzifierKind]] = {
    "centroid": DefuzzifierKind(
        "centroid", "area", options={"resolution": (), "grid": _GRIDS, "rule": ("plain", "trapezoid", "polygon")}
    ),
    "bisector": DefuzzifierKind(
        "bisector", "area", options={"resolution": (), "grid": _GRIDS, "rule": _BISECTIONS, "tolerance": ()}
    ),
    "som": DefuzzifierKind("smallest of maxima", "maximum", options={**_MAXIMA, "by": ("value", "magnitude")}),
    "lom": DefuzzifierKind("largest of maxima", "maximum", options={**_MAXIMA, "by": ("value", "magnitude")}),
    "mom": DefuzzifierKind("mean of maxima", "maximum", options=_MAXIMA),
    "center_average": DefuzzifierKind("center average", "middle"),
    "weighted_average": DefuzzifierKind("weighted average", "middle"),
    "weighted_sum": DefuzzifierKind("weighted sum", "middle", divides=False),
    "tsukamoto": DefuzzifierKind("Tsukamoto's method", "place"),
    "tsukamoto_sum": DefuzzifierKind("Tsukamoto's method without division", "place", divides=False),
    "inverse_tsukamoto": DefuzzifierKind("inverse Tsukamoto method", "degree"),
    "inverse_tsukamoto_sum": DefuzzifierKind("inverse Tsukamoto method without division", "degree", divides=False),
}
#: Smallest, largest and mean of the places where the aggregated set is largest.
MAXIMA: Final = tuple(n for n, k in DEFUZZIFIERS.items() if k.takes == "maximum")
#: Defuzzifiers that look at a set.
OVER_SETS: Final = tuple(n for n, k in DEFUZZIFIERS.items() if k.takes in ("area", "maximum"))
#: Defuzzifiers whose result is a sum over rules.
OVER_RULES: Final = tuple(n for n in DEFUZZIFIERS if n not in OVER_SETS)
#: Of these, the ones over middles of cores.
OVER_MIDDLES: Final = tuple(n for n, k in DEFUZZIFIERS.items() if k.takes == "middle")
AVERAGES: Final = tuple(n for n in OVER_MIDDLES if DEFUZZIFIERS[n].divides)
TSUKAMOTO: Final = tuple(n for n in OVER_RULES if n not in OVER_MIDDLES)

#: Activation methods: which rules act, given the activations of all. `first`, `last`: the first or last COUNT rules,
#: in the order written, whose activation is above 0 and at least THRESHOLD; `highest`, `lowest`: the COUNT rules of
#: highest or lowest activation above 0, of equal ones the earlier; `proportional`: activations divided by their sum;
#: `threshold`: those that compare with THRESHOLD as said.
ACTIVATIONS: Final = ("general", "first", "last", "highest", "lowest", "proportional", "threshold")
#: Those that look at one rule at a time.
EACH_ALONE: Final = frozenset({"general", "threshold"})

#: How samples make an integral or its half. Centroid: `plain` sums, or `trapezoid` sums. Bisector: `interpolated`,
#: where the area to the left is half, inside a cell too; `first`, the first sample up to which the sum is half or more;
#: `nearest`, the mean of all samples up to which the sum is nearest to half; `walk`, from the left by trapezoids while
#: the left part is the smaller one, then the nearer end; `two_sided`, from both ends, always on the smaller side;
#: `between`, the same with all samples, then between the two where they stop, by their sums. Maxima: `all` samples that
#: are largest; `running`, a largest degree so far from left to right, which `tolerance` more exceeds. Centroid and
#: bisector: `polygon`, whose corners are the samples, without a resolution the corners of the terms, and the places
#: where terms meet their activations; where two terms cross between corners it has none.
Rule = Literal[
    "plain",
    "trapezoid",
    "interpolated",
    "first",
    "nearest",
    "walk",
    "two_sided",
    "between",
    "all",
    "running",
    "polygon",
]


@dataclass(frozen=True, kw_only=True)
class Defuzzifier(Node):
    """A defuzzifier.

    Args:
        kind: One of `DEFUZZIFIERS`.
        resolution: Number of sample points of a set; None for an exact result.
        grid: The places of the samples: the middles of equal cells, their left ends, or equal steps from end to end.
        rule: The rule over the samples; None for the usual one: `plain` for a centroid, `interpolated` for a
            bisector, `all` for maxima.
        tolerance: Degrees that fall short of the largest by at most this part of it count as maxima; None for 1e-9.
            For the rules `running` and `between` the largest difference of degrees, or of sums of them, that count
            as equal; None for 0.
        by: The order of `som` and `lom`: by the value or by its magnitude.
    """

    kind: str = "centroid"
    resolution: int | None = None
    grid: Grid = "midpoint"
    rule: Rule | None = None
    tolerance: float | None = None
    by: Literal["value", "magnitude"] = "value"

    @property
    def averages(self) -> bool:
        """Whether it is an average over rules."""
        return self.kind in AVERAGES

    @property
    def over_rules(self) -> bool:
        """Whether it sums over rules rather than over a fuzzy set."""
        return self.kind in OVER_RULES


@dataclass(frozen=True, kw_only=True)
class Activation(Node):
    """An activation method.

    Args:
        kind: One of `ACTIVATIONS`.
        count: Number of rules for `first`, `last`, `highest`, `lowest`; else None.
        threshold: Least activation for `first`, `last`, the bound for `threshold`; else None.
        comparison: For `threshold` one of `<`, `<=`, `==`, `!=`, `>=`, `>`; else None.
    """

    kind: str = "general"
    count: int | None = None
    threshold: Expr | None = None
    comparison: str | None = None

    @property
    def compares(self) -> bool:
        """Whether it compares rules with each other, so that the activations of all must be known."""
        return self.kind not in EACH_ALONE


@dataclass(frozen=True)
class RuleMethod:
    """The methods of one rule: those of its block, and where that says nothing, those of the system.

    Args:
        block: Position of its rule block, -1 for a rule of none.
        conjunction: How it joins by `and`.
        disjunction: How it joins by `or`.
        implication: That of its block; None if the block has none: then each output has one.
        activation: Which rules of the block act.
    """

    block: int
    conjunction: str
    disjunction: str
    implication: str | None
    activation: Activation


@dataclass(frozen=True, kw_only=True, repr=False)
class Method(Node):
    """The inference method of a system; the defaults are those of the profile `exact`.

    Args:
        spans: Where each setting was written, by its word in rule files; those that were not have none.
    """

    conjunction: str = "min"
    disjunction: str = "max"
    implication: str = "min"
    aggregation: str = "max"
    activation: Activation = Activation()
    defuzzifier: Defuzzifier = Defuzzifier()
    semantics: Semantics = field(default_factory=Semantics)
    spans: Mapping[str, Span] = field(default_factory=dict, compare=False, repr=False)
