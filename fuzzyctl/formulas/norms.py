"""Every norm, written once as an expression.

Operands may be mentioned several times, so callers pass names. Formulas are arranged so that results stay within
[0, 1], the laws of the unit hold exactly in floating point, and quotients of the form 0/0 have their limits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final, Literal

from fuzzyctl.expr import ONE, ZERO, Call, Compare, Expr, Logic, Number, Where
from fuzzyctl.records import dataclass

#: The degree that two degrees give.
Combination = Callable[[Expr, Expr], Expr]


@dataclass(frozen=True)
class Norm:
    """Define how two degrees are combined: a triangular norm, a conorm, or the plain sum.

    Args:
        combine: The combination as an expression of two degrees.
        jumps: Whether it is discontinuous.
        straight: Whether sets with straight sides stay such sets, so that they have closed forms; by an implication
            a degree is cut or scaled.
        bends: Where a combined set bends or jumps between the corners of its parts: where both degrees are equal, or
            where their sum is 1; None if nowhere.
        tolerant: The combination if degrees that differ by less than a number are taken for equal; None if it does
            not compare degrees.
    """

    combine: Combination
    jumps: bool = False
    straight: bool = False
    bends: Literal["equal", "sum"] | None = None
    tolerant: Callable[[float], Combination] | None = None

    def __call__(self, a: Expr, b: Expr) -> Expr:
        """Combine two degrees."""
        return self.combine(a, b)

    def within(self, equal: float) -> Norm:
        """Return the norm that takes degrees for equal if they differ by less than a number."""
        return replace(self, combine=self.tolerant(equal)) if equal > 0.0 and self.tolerant is not None else self


def one_minus(a: Expr) -> Expr:
    """Complement of a degree: the truth of `not`."""
    return 1.0 - a


def _minimum(a: Expr, b: Expr) -> Expr:
    return Call("min", (a, b))


def _maximum(a: Expr, b: Expr) -> Expr:
    return Call("max", (a, b))


def _product(a: Expr, b: Expr) -> Expr:
    return a * b


def _bounded_difference(a: Expr, b: Expr) -> Expr:
    """Compute a + b - 1 as a - (1 - b), which is exactly a for b = 1."""
    return Call("max", (ZERO, a - one_minus(b)))


def _drastic_product(a: Expr, b: Expr) -> Expr:
    return Where(Compare("==", a, ONE), b, Where(Compare("==", b, ONE), a, ZERO))


def _einstein_product(a: Expr, b: Expr) -> Expr:
    """Compute ab / (2 - (a + b - ab)); the denominator is 1 + (1 - a)(1 - b)."""
    return a * b / (1.0 + one_minus(a) * one_minus(b))


def _hamacher_product(a: Expr, b: Expr) -> Expr:
    """Compute ab / (a + b - ab), 0 for a = b = 0."""
    whole = a + b * one_minus(a)
    return Call("min", (b, Where(Compare(">", whole, ZERO), a * (b / whole), ZERO)))


def _nilpotent_minimum(a: Expr, b: Expr) -> Expr:
    """Return min(a, b) where a + b > 1, else 0; two comparisons, so that rounding of 1 - b does not lose a tiny b."""
    beyond = Logic("or", (Compare(">", a, one_minus(b)), Compare(">", b, one_minus(a))))
    return Where(beyond, Where(Compare("<", a, b), a, b), ZERO)


def _probabilistic_sum(a: Expr, b: Expr) -> Expr:
    """Compute a + b - ab as a + b(1 - a), which stays within [0, 1] in floating point."""
    return a + b * one_minus(a)


def _bounded_sum(a: Expr, b: Expr) -> Expr:
    return Call("min", (ONE, a + b))


def _drastic_sum(a: Expr, b: Expr) -> Expr:
    return Where(Compare("==", a, ZERO), b, Where(Compare("==", b, ZERO), a, ONE))


def _einstein_sum(a: Expr, b: Expr) -> Expr:
    return Call("min", (ONE, (a + b) / (1.0 + a * b)))


def _hamacher_sum(a: Expr, b: Expr) -> Expr:
    """Compute (a + b - 2ab) / (1 - ab), 1 for a = b = 1; the denominator is (1 - a) + a(1 - b)."""
    whole = one_minus(a) + a * one_minus(b)
    part = a * one_minus(b) + b * one_minus(a)
    return Call("min", (ONE, Where(Compare(">", whole, ZERO), part / whole, ONE)))


def _nilpotent_maximum(a: Expr, b: Expr) -> Expr:
    """Return max(a, b) where a + b < 1, else 1."""
    below = Logic("and", (Compare("<", a, one_minus(b)), Compare("<", b, one_minus(a))))
    return Where(below, Where(Compare(">", a, b), a, b), ONE)


def _near(a: Expr, b: Expr, equal: float) -> Expr:
    """Return whether two degrees differ by less than a number."""
    return Logic("and", (Compare("<", a - b, Number(equal)), Compare("<", b - a, Number(equal))))


def _tolerant_drastic_product(equal: float) -> Combination:
    return lambda a, b: Where(_near(_maximum(a, b), ONE, equal), _minimum(a, b), ZERO)


def _tolerant_drastic_sum(equal: float) -> Combination:
    return lambda a, b: Where(_near(_minimum(a, b), ZERO, equal), _maximum(a, b), ONE)


def _tolerant_nilpotent_minimum(equal: float) -> Combination:
    """Return min(a, b) where a + b is above 1, and not equal to it."""
    return lambda a, b: Where(Compare(">=", a - one_minus(b), Number(equal)), _minimum(a, b), ZERO)


def _tolerant_nilpotent_maximum(equal: float) -> Combination:
    """Return max(a, b) where a + b is below 1, and not equal to it."""
    return lambda a, b: Where(Compare("<=", a - one_minus(b), Number(-equal)), _maximum(a, b), ONE)


def _tolerant_hamacher_product(equal: float) -> Combination:
    return lambda a, b: Where(Compare("<", a + b, Number(equal)), ZERO, _hamacher_product(a, b))


def _tolerant_hamacher_sum(equal: float) -> Combination:
    return lambda a, b: Where(_near(a * b, ONE, equal), ONE, _hamacher_sum(a, b))


Conjunction = Literal[
    "min",
    "product",
    "bounded_difference",
    "drastic_product",
    "einstein_product",
    "hamacher_product",
    "nilpotent_minimum",
]
#: Triangular norms: what `and` may name.
CONJUNCTIONS: Final[dict[str, Norm]] = {
    "min": Norm(_minimum, straight=True, bends="equal"),
    "product": Norm(_product, straight=True),
    "bounded_difference": Norm(_bounded_difference, bends="sum"),
    "drastic_product": Norm(_drastic_product, jumps=True, tolerant=_tolerant_drastic_product),
    "einstein_product": Norm(_einstein_product),
    "hamacher_product": Norm(_hamacher_product, tolerant=_tolerant_hamacher_product),
    "nilpotent_minimum": Norm(_nilpotent_minimum, jumps=True, bends="sum", tolerant=_tolerant_nilpotent_minimum),
}

Disjunction = Literal[
    "max",
    "probabilistic_sum",
    "bounded_sum",
    "drastic_sum",
    "einstein_sum",
    "hamacher_sum",
    "nilpotent_maximum",
]
#: Triangular conorms: what `or` may name.
DISJUNCTIONS: Final[dict[str, Norm]] = {
    "max": Norm(_maximum, straight=True),
    "probabilistic_sum": Norm(_probabilistic_sum),
    "bounded_sum": Norm(_bounded_sum),
    "drastic_sum": Norm(_drastic_sum, jumps=True, tolerant=_tolerant_drastic_sum),
    "einstein_sum": Norm(_einstein_sum),
    "hamacher_sum": Norm(_hamacher_sum, tolerant=_tolerant_hamacher_sum),
    "nilpotent_maximum": Norm(_nilpotent_maximum, jumps=True, bends="sum", tolerant=_tolerant_nilpotent_maximum),
}

#: How an activation cuts or scales a consequent set: any triangular norm.
IMPLICATIONS: Final = CONJUNCTIONS

Aggregation = Literal["sum"] | Disjunction
#: How the implied sets of all rules are joined: the plain sum, which may exceed 1, or any triangular conorm.
AGGREGATIONS: Final[dict[str, Norm]] = {"sum": Norm(lambda a, b: a + b, straight=True), **DISJUNCTIONS}


def conjunction(name: str, equal: float = 0.0) -> Norm:
    """Return a triangular norm; `equal` is the largest difference of degrees that count as equal."""
    return CONJUNCTIONS[name].within(equal)


def disjunction(name: str, equal: float = 0.0) -> Norm:
    """Return a triangular conorm; see `conjunction`."""
    return DISJUNCTIONS[name].within(equal)


def aggregation(name: str, equal: float = 0.0) -> Norm:
    """Return how implied sets are joined; see `conjunction`."""
    return AGGREGATIONS[name].within(equal)


def held(x: Expr) -> Expr:
    """Return an expression of the user's own held within [0, 1]; 0 where it has no value, such as 0/0."""
    return Call("held", (x,))
