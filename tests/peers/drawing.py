"""Draws systems over everything that a peer supports, from a source of random choices.

The source is a `random.Random`: seeded for the long runs, hypothesis's own where failures are to shrink.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from random import Random

from fuzzyctl import (
    Activation,
    And,
    Antecedent,
    Consequent,
    Defuzzifier,
    FuzzySystem,
    Hold,
    Input,
    Is,
    Membership,
    Method,
    Not,
    Or,
    Output,
    Rule,
    RuleBlock,
    Term,
)
from fuzzyctl.expr import Binary, Call, Expr, Name, Number
from fuzzyctl.model.profiles import PROFILES

STRAIGHT = ("triangle", "trapezoid", "rectangle", "ramp", "piecewise")
CURVED = tuple(
    "gaussian gaussian2 bell sigmoid sigmoid_difference sigmoid_product s_shape z_shape pi_shape cosine spike "
    "concave".split()
)
MONOTONE = ("ramp", "sigmoid", "s_shape", "z_shape", "concave")
CONJUNCTIONS = tuple(
    "min product bounded_difference drastic_product einstein_product hamacher_product nilpotent_minimum".split()
)
DISJUNCTIONS = tuple(
    "max probabilistic_sum bounded_sum drastic_sum einstein_sum hamacher_sum nilpotent_maximum".split()
)
MAXIMA = ("som", "lom", "mom")
#: Implications by which an activation above 0 leaves something of any set.
LEAVING = ("min", "product", "einstein_product", "hamacher_product")


@dataclass(frozen=True)
class Abilities:
    """What a peer can evaluate.

    Args:
        kinds: Membership functions of inputs, and of outputs that have sets.
        sets: Those of outputs that have sets, where they are others.
        monotone: Those of outputs of Tsukamoto's method; empty for peers without it.
        tall: Whether these have heights.
        conjunctions, disjunctions, implications, aggregations: Norms by their names here.
        defuzzifiers: Those over sets.
        consequents: Kinds of Takagi-Sugeno consequents.
        sums: Defuzzifiers over rules.
        hedges: In antecedents.
        consequent_hedges: In consequents.
        empties: Whether an output whose rules act, but leave an empty set, is what its `else` says.
        activations: Activation methods.
        infinite: Whether feet may be infinite.
        negates: Whether `not` may stand before parts of an antecedent.
        inside: Whether inputs must be within their ranges.
        whole_slopes: Whether slopes of bells must be whole numbers.
        crosses: Whether the means of a double Gaussian may stand in reverse.
        fewest_rules: Least number of rules.
        heights, weights, holds, chains, own_methods, blocks: Whether there are such.
        jumps: Whether neighbouring corners may be equal.
        nested: Whether `and` and `or` may stand in one antecedent; else all of it is joined by one of them.
        resolutions: Numbers of samples; None for the usual one.
        extrapolates: Whether inputs outside their range go through the formulas; None where the file says it.
        specials: Numbers besides those of the range that are inputs, such as NaN.
    """

    kinds: Sequence[str] = (*STRAIGHT, *CURVED)
    sets: Sequence[str] | None = None
    monotone: Sequence[str] = ()
    tall: bool = True
    conjunctions: Sequence[str] = CONJUNCTIONS
    disjunctions: Sequence[str] = DISJUNCTIONS
    implications: Sequence[str] = CONJUNCTIONS
    aggregations: Sequence[str] = (*DISJUNCTIONS, "sum")
    defuzzifiers: Sequence[str] = ("centroid", "bisector", *MAXIMA)
    consequents: Sequence[str] = ("constant", "linear", "function")
    sums: Sequence[str] = ("weighted_average", "weighted_sum")
    hedges: Sequence[str] = ("very", "somewhat", "extremely", "seldom", "not", "any")
    consequent_hedges: Sequence[str] = ()
    empties: bool = True
    activations: Sequence[str] = ("general",)
    infinite: bool = False
    negates: bool = False
    fewest_rules: int = 1
    inside: bool = False
    whole_slopes: bool = False
    crosses: bool = True
    heights: bool = False
    weights: bool = True
    holds: bool = False
    chains: bool = False
    own_methods: bool = False
    blocks: bool = False
    jumps: bool = True
    nested: bool = True
    resolutions: Sequence[int | None] = (None,)
    extrapolates: bool | None = None
    specials: Sequence[float] = ()


class Draw:
    """Draw one system.

    Args:
        random: The source of all choices.
        profile: Name of the profile of the peer.
        can: What the peer can evaluate.
    """

    def __init__(self, random: Random, profile: str, can: Abilities) -> None:
        self.random, self.profile, self.can = random, PROFILES[profile], can

    def system(self) -> FuzzySystem:
        """Draw a system with one to three inputs and one or two outputs."""
        self.activation = self._activation()
        self.inputs = tuple(self._input(name) for name in "abc"[: self._between(1, 3)])
        method = Method(
            conjunction=self._choice(self.can.conjunctions),
            disjunction=self._choice(self.can.disjunctions),
            implication=self._choice(self.can.implications),
            aggregation=self._choice(self.can.aggregations),
            activation=self.activation,
            semantics=self.profile.semantics,
        )
        sugeno = None if self.can.own_methods else self._likely(0.4)
        self.outputs = tuple(self._output(name, sugeno) for name in "yz"[: self._between(1, 2)])
        if not self.can.own_methods:
            method = method.model_copy(update={"defuzzifier": self.outputs[0].defuzzifier})
            self.outputs = tuple(o.model_copy(update={"defuzzifier": None}) for o in self.outputs)
            if (self.outputs[0].defuzzifier or method.defuzzifier).over_rules and len(self.can.aggregations) > 1:
                method = method.model_copy(update={"aggregation": self._choice(("sum", "max"))})
        if not self.can.empties and any(self._must_leave(o, method) for o in self.outputs):
            method = method.model_copy(update={"implication": self._choice(LEAVING)})
        # What is compared must not depend on what is chosen.
        self.chained = self.can.chains and self.activation.kind in ("general", "threshold") and self._likely(0.3)
        self.aggregation = method.aggregation
        rules = tuple(self._rule() for _ in range(self._between(self.can.fewest_rules, 7)))
        blocks = self._blocks(rules) if self.can.blocks and len(rules) > 1 and self._likely(0.3) else rules
        return FuzzySystem(name="drawn", method=method, inputs=self.inputs, outputs=self.outputs, blocks=blocks)

    def _blocks(self, rules: Sequence[Rule]) -> tuple[RuleBlock, ...]:
        """Put rules into two or three blocks, each with some methods of its own."""
        cuts = sorted({self._between(1, len(rules) - 1) for _ in range(2)})
        made = []
        for k, (a, b) in enumerate(pairwise([0, *cuts, len(rules)])):
            own = {
                "conjunction": self._choice(self.can.conjunctions),
                "disjunction": self._choice(self.can.disjunctions),
                "implication": self._choice(LEAVING if not self.can.empties else self.can.implications),
                "activation": self._activation(),
            }
            if self.chained and own["activation"].kind not in ("general", "threshold"):
                own["activation"] = Activation()
            said = {name: value for name, value in own.items() if self._likely(0.6)}
            made.append(RuleBlock(name=f"b{k}", rules=tuple(rules[a:b]), **said))
        return tuple(made)

    def points(self, system: FuzzySystem, count: int) -> list[list[float]]:
        """Draw points: corners of terms, ends of ranges, numbers around the range, and special ones."""
        return [[self._coordinate(i) for i in system.inputs] for _ in range(count)]

    def _coordinate(self, variable: Input) -> float:
        low, high = variable.lower.value, variable.upper.value
        width = high - low
        if self.can.inside:
            places = [low, high, *(a.value for t in variable.terms for a in t.membership.arguments)]
            known = [p for p in places if low <= p <= high]
            return self._choice(known) if self._likely(0.15) else self.random.uniform(low, high)
        if self.can.specials and self._likely(0.02):
            return self._choice(self.can.specials)
        if self._likely(0.15):
            places = [low, high, *(a.value for t in variable.terms for a in t.membership.arguments)]
            return self._choice([p for p in places if low - width <= p <= high + width])
        return self.random.uniform(low - 0.1 * width, high + 0.1 * width)

    def _choice(self, among: Sequence) -> object:
        return among[self.random.randrange(len(among))]

    def _likely(self, share: float) -> bool:
        return self.random.random() < share

    def _between(self, low: int, high: int) -> int:
        return self.random.randint(low, high)

    def _number(self, low: float, high: float) -> float:
        """Draw a number of few digits."""
        return float(f"{self.random.uniform(low, high):.4g}")

    def _range(self) -> tuple[float, float]:
        low = self._choice((0.0, -1.0, -10.0, 5.0, self._number(-3, 3)))
        return low, low + self._choice((1.0, 2.0, 10.0, self._number(0.5, 30)))

    def _input(self, name: str) -> Input:
        low, high = self._range()
        extrapolate = self.can.extrapolates
        terms = tuple(self._term(f"{name}{k}", self.can.kinds, low, high) for k in range(self._between(2, 4)))
        return Input(
            name=name,
            lower=Number(low),
            upper=Number(high),
            terms=terms,
            extrapolate=self._likely(0.7) if extrapolate is None else extrapolate,
        )

    def _must_leave(self, output: Output, method: Method) -> bool:
        """Return whether it shows if rules act but leave an empty set."""
        own = output.defuzzifier or method.defuzzifier
        return not own.over_rules and (own.kind in MAXIMA or output.otherwise != self.profile.otherwise)

    def _output(self, name: str, sugeno: bool | None) -> Output:
        low, high = self._range()
        method, kinds = self._defuzzifier(sugeno)
        terms = tuple(self._term(f"{name}{k}", kinds, low, high) for k in range(self._between(2, 4)))
        fields = {}
        if self.can.own_methods:
            joins = self.can.aggregations
            fields = {"aggregation": self._choice(("sum", *joins) if method.over_rules else joins)}
        return Output(
            name=name,
            lower=Number(low),
            upper=Number(high),
            terms=terms,
            otherwise=self._otherwise(low, high),
            clamped=self.can.holds and self._likely(0.3),
            defuzzifier=method,
            **fields,
        )

    def _defuzzifier(self, sugeno: bool | None) -> tuple[Defuzzifier, Sequence[str]]:
        over_rules = self._likely(0.4) if sugeno is None else sugeno
        if over_rules and self.can.sums and self.can.consequents:
            if self.can.monotone and self._likely(0.4):
                return Defuzzifier(kind=self._choice(("tsukamoto", "tsukamoto_sum"))), self.can.monotone
            kind = self._choice(self.can.sums)
            return Defuzzifier(kind=kind), self.can.kinds if kind.startswith("inverse") else self.can.consequents
        method = self.profile.defuzzifier(self._choice(self.can.defuzzifiers))
        resolution = self._choice(self.can.resolutions)
        return (method if resolution is None else method.model_copy(update={"resolution": resolution})), (
            self.can.sets or self.can.kinds
        )

    def _otherwise(self, low: float, high: float) -> Expr | str | Hold | None:
        if not self.can.holds:
            return self.profile.otherwise
        start = Number(self._number(low, high))
        return self._choice(("nan", start, Hold(start="nan"), Hold(start=start)))

    def _term(self, name: str, kinds: Sequence[str], low: float, high: float) -> Term:
        kind = self._choice(kinds)
        height = Number(self._number(0.2, 1.0)) if self.can.heights and self._likely(0.25) else Number(1.0)
        if kind in ("constant", "linear", "function") or (kinds is self.can.monotone and not self.can.tall):
            height = Number(1.0)
        arguments = tuple(a if isinstance(a, Expr) else Number(a) for a in self._shape(kind, low, high))
        return Term(name=name, membership=Membership(kind=kind, arguments=arguments, height=height))

    def _shape(self, kind: str, low: float, high: float) -> Sequence[float | Expr]:
        width = high - low

        def places(count: int, *, distinct: bool = True) -> list[float]:
            while True:
                found = sorted(self._number(low - 0.2 * width, high + 0.2 * width) for _ in range(count))
                if not distinct or len(set(found)) == count:
                    return found

        def scale(share: float = 0.5) -> float:
            return self._number(0.05 * width, share * width)

        def slope() -> float:
            return self._choice((1.0, -1.0)) * self._number(2.0 / width, 40.0 / width)

        shapes: dict[str, Callable[[], Sequence[float | Expr]]] = {
            "triangle": lambda: self._corners(places(3)),
            "trapezoid": lambda: self._corners(places(4)),
            "pi_shape": lambda: places(4),
            "rectangle": lambda: places(2),
            "ramp": lambda: self._either(places(2)),
            "piecewise": lambda: self._polygon(places(self._between(2, 6))),
            "gaussian": lambda: (places(1)[0], scale()),
            "gaussian2": lambda: self._means(places(2), scale(), scale()),
            "bell": lambda: (places(1)[0], scale(), self._slope()),
            "sigmoid": lambda: (places(1)[0], slope()),
            "sigmoid_difference": lambda: self._between_sigmoids(places(2), slope(), slope()),
            "sigmoid_product": lambda: self._between_sigmoids(places(2), slope(), -slope()),
            "s_shape": lambda: places(2),
            "z_shape": lambda: places(2),
            "cosine": lambda: (places(1)[0], scale(1.0)),
            "spike": lambda: (places(1)[0], scale(1.0)),
            "concave": lambda: self._either(places(2)),
            "arc": lambda: self._either(places(2)),
            "semi_ellipse": lambda: places(2),
            "constant": lambda: (self._number(low, high),),
            "linear": lambda: [self._number(-2, 2) for _ in range(len(self.inputs) + 1)],
            "function": lambda: (self._function(),),
        }
        return shapes[kind]()

    def _slope(self) -> float:
        return float(self._between(1, 5)) if self.can.whole_slopes else self._number(0.6, 6.0)

    def _either(self, places: Sequence[float]) -> Sequence[float]:
        return places if self._likely(0.5) else places[::-1]

    def _corners(self, places: list[float]) -> list[float]:
        """Return corners of a triangle or trapezoid, now and then with a jump or an infinite foot."""
        if self.can.jumps and self._likely(0.15):
            places[self._choice((0, -1))] = places[1] if self._likely(0.5) else places[-2]
            places.sort()
        if self.can.infinite and self._likely(0.15):
            places[self._choice((0, -1))] *= 1.0
            places = [-math.inf, *places[1:]] if self._likely(0.5) else [*places[:-1], math.inf]
        return places

    def _polygon(self, places: Sequence[float]) -> list[float]:
        degrees = [self._choice((0.0, 1.0, self._number(0.0, 1.0))) for _ in places]
        if max(degrees) == 0.0:
            degrees[0] = 1.0
        return [n for corner in zip(places, degrees, strict=True) for n in corner]

    def _means(self, means: Sequence[float], left: float, right: float) -> Sequence[float]:
        first, second = means if not self.can.crosses or self._likely(0.8) else means[::-1]
        return first, left, second, right

    def _between_sigmoids(self, places: Sequence[float], rising: float, falling: float) -> Sequence[float]:
        return places[0], rising, falling, places[1]

    def _function(self) -> Expr:
        a, b = (Name(self._choice(self.inputs).name) for _ in range(2))
        factor = Number(self._number(0.1, 3))
        return self._choice(
            (
                Binary("+", Binary("*", factor, a), Call("sin", (b,))),
                Binary("-", Binary("*", a, b), Call("exp", (Binary("/", a, Number(20.0)),))),
                Binary("/", a, Binary("+", Number(1.0), Call("abs", (b,)))),
                Call("max", (Binary("*", factor, a), Call("min", (b, factor)))),
            )
        )

    def _activation(self) -> Activation:
        kind = self._choice(("general", "general", *self.can.activations))
        if kind in ("first", "last"):
            return Activation(kind=kind, count=self._between(1, 3), threshold=Number(self._choice((0.0, 0.25))))
        if kind in ("highest", "lowest"):
            return Activation(kind=kind, count=self._between(1, 3))
        if kind == "threshold":
            comparison = self._choice(("<", "<=", "==", "!=", ">=", ">"))
            return Activation(kind=kind, threshold=Number(self._choice((0.1, 0.5))), comparison=comparison)
        return Activation(kind=kind)

    def _rule(self) -> Rule:
        outputs = self._some(self.outputs)
        consequents = tuple(
            Consequent(
                output=o.name,
                term=self._choice(o.terms).name,
                hedges=self._hedges(self.can.consequent_hedges, 0.15),
            )
            for o in outputs
        )
        weight = Number(self._number(0.05, 1.0)) if self.can.weights and self._likely(0.3) else Number(1.0)
        return Rule(antecedent=self._antecedent(2), consequents=consequents, weight=weight)

    def _some(self, among: Sequence) -> Sequence:
        return among if self._likely(0.5) else (self._choice(among),)

    def _hedges(self, among: Sequence[str], share: float) -> tuple[str, ...]:
        if not among or not self._likely(share):
            return ()
        first = self._choice(among)
        if not self.can.nested:  # one hedge, and perhaps a negation of it
            return ("not", first) if first != "not" and self._likely(0.3) else (first,)
        if first == "any":
            return (first,)
        more = [h for h in among if h != "any"]
        return (first, self._choice(more)) if self._likely(0.2) and more else (first,)

    def _antecedent(self, depth: int) -> Antecedent:
        if not self.can.nested:
            joined = tuple(self._is(v) for v in self.inputs if self._likely(0.8)) or (self._is(self.inputs[0]),)
            if len(joined) == 1:
                return joined[0]
            return (And if self._likely(0.6) else Or)(operands=joined)
        if depth == 0 or self._likely(0.35):
            return self._is(self._choice(self.inputs))
        parts = tuple(self._antecedent(depth - 1) for _ in range(self._between(2, 3)))
        return (And if self._likely(0.6) else Or)(operands=parts)

    def _is(self, variable: Input | Output) -> Antecedent:
        # Degrees above 1 are none, and tools make of them what they please.
        read = [o for o in self.outputs if (o.aggregation or self.aggregation) != "sum"] if self.chained else []
        if read and self._likely(0.25):
            variable = self._choice(read)
        found = Is(
            variable=variable.name,
            term=self._choice(variable.terms).name,
            hedges=self._hedges(self.can.hedges, 0.2),
        )
        negates = self.can.negates and self._likely(0.15)
        return Not(operand=found) if negates else found
