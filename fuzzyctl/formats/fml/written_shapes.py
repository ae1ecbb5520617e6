"""FML text of terms: the equal shape, or the nearest one."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from dataclasses import replace as replace_fields
from typing import Final

from fuzzyctl.expr import TOO_LARGE, Binary, Call, Compare, Expr, ExprError, Number, Where, evaluate, replace
from fuzzyctl.formats.fml.vocabulary import TAGS
from fuzzyctl.formulas import MEMBERSHIP, Parameters, is_straight
from fuzzyctl.model.variable import Membership

Ends = tuple[float, float]

#: Points that approximate a curve that FML has no shape for.
_SAMPLES: Final = 101

#: Shape of point sets that `tsukamoto` can invert.
_MONOTONE: Final = "pointSetMonotonicShape"


@dataclass(frozen=True)
class WrittenShape:
    """A term as FML.

    Args:
        tag: Name of the element.
        parameters: Its numbers; of a set of points the coordinates one after the other.
        said: How it is said, where it is not the same function under another name; empty where it is.
        exact: Whether it is the same function within the range of its variable.
    """

    tag: str
    parameters: Parameters
    said: str = ""
    exact: bool = True


def written_consequent(membership: Membership, values: Mapping[str, float], domain: Ends) -> WrittenShape:
    """Return a monotone term of Tsukamoto's method as FML: a monotone shape."""
    kind = membership.kind
    given = tuple(evaluate(a, values) for a in membership.arguments)
    if kind in ("triangle", "trapezoid") and (jumps := _jump(MEMBERSHIP[kind].vertices(given))):
        return WrittenShape(_MONOTONE, jumps, "it is written as points")
    shape = written_shape(membership, values, domain)
    if shape.tag == "pointSetShape":
        return replace_fields(shape, tag=_MONOTONE)
    return shape


def _jump(corners: tuple[tuple[float, float], ...]) -> Parameters:
    """Return the corners of a step, empty for any other term: the linear shapes have none that could be inverted."""
    return tuple(v for corner in corners for v in corner) if len({x for x, _ in corners}) < len(corners) else ()


def written_shape(membership: Membership, values: Mapping[str, float], domain: Ends) -> WrittenShape:
    """Return a term that is a fuzzy set as FML."""
    kind = membership.kind
    given = tuple(evaluate(a, values) for a in membership.arguments)
    height = evaluate(membership.height, values)
    finite = all(map(math.isfinite, given))
    if height == 1.0 and finite and (tag := TAGS.get("singleton" if kind == "constant" else kind)) is not None:
        return WrittenShape(tag, given)
    if kind == "piecewise":
        return _points(given, height)
    if kind == "gaussian2" and height == 1.0 and (sided := _sided(given, domain)) is not None:
        return sided
    if kind == "pi_shape" and height == 1.0 and _is_even(given):
        return WrittenShape("piShape", given[:2])
    if kind == "pi_shape" and height == 1.0 and (edge := _edge(given)) is not None:
        return edge
    if is_straight(kind):
        return _straight(kind, given, height, domain)
    return _sampled(kind, given, height, domain)


def _points(given: Parameters, height: float) -> WrittenShape:
    scaled = tuple(v if i % 2 == 0 else v * height for i, v in enumerate(given))
    return WrittenShape("pointSetShape", scaled, "" if height == 1.0 else "it is written as points with its height")


def _sided(given: Parameters, domain: Ends) -> WrittenShape | None:
    """Return a Gaussian that is 1 up to an end of the domain."""
    mean_left, sigma_left, mean_right, sigma_right = given
    if mean_left == -math.inf or (mean_left == min(domain[0], mean_right) and sigma_left == sigma_right):
        return WrittenShape("leftGaussianShape", (mean_right, sigma_right))
    if mean_right == math.inf or (mean_right == max(domain[1], mean_left) and sigma_left == sigma_right):
        return WrittenShape("rightGaussianShape", (mean_left, sigma_left))
    return None


def _edge(given: Parameters) -> WrittenShape | None:
    """Return a curved trapezoid with one infinite foot."""
    left, left_top, right_top, right = given
    if right == math.inf and -math.inf < left < left_top:
        return WrittenShape("sShape", (left, left_top))
    if left == -math.inf and right_top < right < math.inf:
        return WrittenShape("zShape", (right_top, right))
    return None


def _is_even(given: Parameters) -> bool:
    left, top, right_top, right = given
    return top == right_top and right == top + (top - left) and left < top


def _straight(kind: str, given: Parameters, height: float, domain: Ends) -> WrittenShape:
    """Return a straight term as a linear shape; as points if it is none.

    A step is a trapezoid whose flat side reaches the end of the domain.
    """
    corners = MEMBERSHIP[kind].vertices(given)
    if height == 1.0 and kind != "rectangle" and {y for _, y in corners} == {0.0, 1.0}:
        if len(corners) == 2 and corners[0][0] < corners[1][0]:
            tag = "rightLinearShape" if corners[1][1] == 1.0 else "leftLinearShape"
            return WrittenShape(tag, (corners[0][0], corners[1][0]))
        if corners[0][1] == 1.0 and len(corners) == 2:
            low = min(domain[0], corners[0][0])
            block: Parameters = (low, low, corners[0][0], corners[1][0])
            return WrittenShape("trapezoidShape", block, "its flat side ends where the range does")
        if corners[-1][1] == 1.0 and len(corners) == 2:
            high = max(domain[1], corners[1][0])
            block = (corners[0][0], corners[1][0], high, high)
            return WrittenShape("trapezoidShape", block, "its flat side ends where the range does")
    if len(corners) == 1:  # 1 everywhere
        corners = (corners[0], (corners[0][0] + 1.0, corners[0][1]))
    parameters = tuple(v for x, y in corners for v in (x, y * height))
    return WrittenShape("pointSetShape", parameters, "it is written as points")


def _sampled(kind: str, given: Parameters, height: float, domain: Ends) -> WrittenShape:
    low, high = domain
    found: list[float] = []
    for i in range(_SAMPLES):
        x = low + (high - low) * i / (_SAMPLES - 1)
        found += [x, height * _degree(kind, given, x)]
    said = f"FML has no such shape; it is written as {_SAMPLES} points"
    return WrittenShape("pointSetShape", tuple(found), said, exact=False)


#: What comparisons of numbers say.
_HOLDS: Final[dict[str, Callable[[float, float], bool]]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
}


def _degree(kind: str, given: Parameters, x: float) -> float:
    """Return the degree at a value; formulas choose by comparisons of numbers."""

    def settled(expr: Expr) -> Expr:
        match expr:
            case Where(condition=Compare(op=op, left=left, right=right), then=then, otherwise=otherwise):
                return then if _HOLDS[op](evaluate(left, {}), evaluate(right, {})) else otherwise
            case Call(function="exp") | Binary(op="^") if _is_too_large(expr):
                return Number(math.inf)  # as in a steep sigmoid, far from its middle
        return expr

    return min(1.0, max(0.0, evaluate(replace(MEMBERSHIP[kind].degree(Number(x), given), settled), {})))


def _is_too_large(expr: Expr) -> bool:
    """Return whether no double holds the value of an expression."""
    try:
        evaluate(expr, {})
    except ExprError as error:
        return error.message == TOO_LARGE
    return False
