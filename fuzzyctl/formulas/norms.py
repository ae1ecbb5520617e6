"""Every norm, written once as an expression.

Operands may be mentioned several times, so callers pass names. Formulas are arranged so that results stay within
[0, 1], the laws of the unit hold exactly in floating point, and quotients of the form 0/0 have their limits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, Literal

from fuzzyctl.expr import ONE, ZERO, Call, Compare, Expr, Logic, Number, Where

Norm = Callable[[Expr, Expr], Expr]


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
    "min": _minimum,
    "product": _product,
    "bounded_difference": _bounded_difference,
    "drastic_product": _drastic_product,
    "einstein_product": _einstein_product,
    "hamacher_product": _hamacher_product,
    "nilpotent_minimum": _nilpotent_minimum,
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
    "max": _maximum,
    "probabilistic_sum": _probabilistic_sum,
    "bounded_sum": _bounded_sum,
    "drastic_sum": _drastic_sum,
    "einstein_sum": _einstein_sum,
    "hamacher_sum": _hamacher_sum,
    "nilpotent_maximum": _nilpotent_maximum,
}

#: How an activation cuts or scales a consequent set: any triangular norm.
IMPLICATIONS: Final = CONJUNCTIONS

Aggregation = Literal["sum"] | Disjunction
#: How the implied sets of all rules are joined: the plain sum, which may exceed 1, or any triangular conorm.
AGGREGATIONS: Final[dict[str, Norm]] = {"sum": lambda a, b: a + b, **DISJUNCTIONS}


def _near(a: Expr, b: Expr, equal: float) -> Expr:
    """Return whether two degrees differ by less than a number."""
    return Logic("and", (Compare("<", a - b, Number(equal)), Compare("<", b - a, Number(equal))))


def _lenient(name: str, equal: float) -> Norm | None:
    """Return a norm that takes degrees for equal which differ by less than a number; None for one that does not ask."""
    beyond = Number(equal)

    def above(a: Expr, b: Expr) -> Expr:
        """Return whether a + b is above 1, and not equal to it."""
        return Compare(">=", a - one_minus(b), beyond)

    def below(a: Expr, b: Expr) -> Expr:
        """Return whether a + b is below 1, and not equal to it."""
        return Compare("<=", a - one_minus(b), Number(-equal))

    norms: dict[str, Norm] = {
        "drastic_product": lambda a, b: Where(_near(_maximum(a, b), ONE, equal), _minimum(a, b), ZERO),
        "drastic_sum": lambda a, b: Where(_near(_minimum(a, b), ZERO, equal), _maximum(a, b), ONE),
        "nilpotent_minimum": lambda a, b: Where(above(a, b), _minimum(a, b), ZERO),
        "nilpotent_maximum": lambda a, b: Where(below(a, b), _maximum(a, b), ONE),
        "hamacher_product": lambda a, b: Where(Compare("<", a + b, beyond), ZERO, _hamacher_product(a, b)),
        "hamacher_sum": lambda a, b: Where(_near(a * b, ONE, equal), ONE, _hamacher_sum(a, b)),
    }
    return norms.get(name)


def conjunction(name: str, equal: float = 0.0) -> Norm:
    """Return a triangular norm; `equal` is what degrees may differ by that count as equal."""
    return (_lenient(name, equal) if equal > 0.0 else None) or CONJUNCTIONS[name]


def disjunction(name: str, equal: float = 0.0) -> Norm:
    """Return a triangular conorm; see `conjunction`."""
    return (_lenient(name, equal) if equal > 0.0 else None) or DISJUNCTIONS[name]


def aggregation(name: str, equal: float = 0.0) -> Norm:
    """Return how implied sets are joined; see `conjunction`."""
    return (_lenient(name, equal) if equal > 0.0 else None) or AGGREGATIONS[name]


def held(x: Expr) -> Expr:
    """Return an expression of the user's own held within [0, 1]; 0 where it has no value, such as 0/0."""
    return Call("held", (x,))
