"""Every membership function, written once as an expression, with its corners, its core and its inverse."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

from fuzzyctl.expr import ONE, ZERO, Binary, Call, Compare, Expr, Number, Where

Vertex = tuple[float, float]
Parameters = tuple[float, ...]


def _no_vertices(_: Parameters) -> tuple[Vertex, ...]:
    return ()


def _never(_w: Expr, _p: Parameters) -> Expr | None:
    return None


@dataclass(frozen=True)
class MembershipFormula:
    """Define one kind of membership function.

    Args:
        name: As rule files write it.
        parameters: Names of its parameters, in order; of a variadic one the names of the first group.
        summary: One line for the reference.
        degree: The degree of x as an expression, for given parameters; within [0, 1] for every x but NaN.
        mistake: What is wrong with given parameters, or None.
        core: The interval where the degree is largest; its middle is what averages take (Eq. (18)). Where the largest
            degree stays up to infinity it is the finite end of that stretch, and infinite where the degree only tends
            to 1 (a sigmoid): such a term has no place in an average.
        vertices: Corners of a piecewise-linear function from left to right, an empty tuple for a curved one. Beyond
            the outer corners the degree stays as there. A corner given twice is a jump; the larger degree holds there.
        inverse: Where a monotone function has the degree w, an expression of w; None for parameters of a function that
            is not monotone. Where the function jumps it is the place of the jump, at a shoulder its finite end.
        infinite: Which parameters may be infinite: feet, and the means of one-sided Gaussians.
        variadic: Whether the group of parameters may be repeated.
        pieces: Points besides the corners of the core where the formula changes or bends.
        fuzzy: Whether it is a fuzzy set with an area.
    """

    name: str
    parameters: tuple[str, ...]
    summary: str
    degree: Callable[[Expr, Parameters], Expr]
    mistake: Callable[[Parameters], str | None]
    core: Callable[[Parameters], tuple[float, float]]
    vertices: Callable[[Parameters], tuple[Vertex, ...]] = _no_vertices
    inverse: Callable[[Expr, Parameters], Expr | None] = _never
    infinite: frozenset[str] = frozenset()
    variadic: bool = False
    pieces: Callable[[Parameters], tuple[float, ...]] = lambda p: p
    fuzzy: bool = True

    def monotone(self, p: Parameters) -> bool:
        """Return whether the function with these parameters is monotone, so that `tsukamoto` can invert it."""
        return self.inverse(ONE, p) is not None


# --- straight sides ----------------------------------------------------------------------------------------------


def _trapezoid_degree(x: Expr, p: Parameters) -> Expr:
    """Rise from left foot to left top, stay at 1, fall from right top to right foot; an infinite foot is a shoulder."""
    left, left_top, right_top, right = p
    expr: Expr = ONE
    if right < math.inf:
        fall: Expr = ZERO
        if right > right_top:
            slope = Binary("/", Binary("-", Number(right), x), Number(right - right_top))
            fall = Where(Compare("<", x, Number(right)), slope, ZERO)
        expr = Where(Compare("<=", x, Number(right_top)), expr, fall)
    if left > -math.inf:
        rise: Expr = ZERO
        if left < left_top:
            slope = Binary("/", Binary("-", x, Number(left)), Number(left_top - left))
            rise = Where(Compare(">", x, Number(left)), slope, ZERO)
        expr = Where(Compare(">=", x, Number(left_top)), expr, rise)
    return expr


def _trapezoid_vertices(p: Parameters) -> tuple[Vertex, ...]:
    left, left_top, right_top, right = p
    corners: list[Vertex] = []
    if left > -math.inf:
        corners.append((left, 0.0))
    corners.append((left_top, 1.0))
    if right_top > left_top:
        corners.append((right_top, 1.0))
    if right < math.inf:
        corners.append((right, 0.0))
    return tuple(corners)


def _trapezoid_inverse(w: Expr, p: Parameters) -> Expr | None:
    left, left_top, right_top, right = p
    if left > -math.inf and right == math.inf:
        return _ramp_inverse(w, (left, left_top))
    if left == -math.inf and right < math.inf:
        return _ramp_inverse(w, (right, right_top))
    return None


def _as_trapezoid(p: Parameters) -> Parameters:
    left, peak, right = p
    return (left, peak, peak, right)


def _as_shoulder(p: Parameters) -> Parameters:
    """Return a ramp as a trapezoid with an infinite foot."""
    start, end = p
    return (start, end, end, math.inf) if start < end else (-math.inf, end, end, start)


def _as_block(p: Parameters) -> tuple[float, float, float, float]:
    """Return a rectangle as a trapezoid; an infinite side stays a foot, and the top ends at the finite one."""
    left, right = p
    return (left, left if left > -math.inf else right, right if right < math.inf else left, right)


def _ramp_inverse(w: Expr, p: Parameters) -> Expr:
    start, end = p
    return Binary("+", Number(start), Binary("*", Number(end - start), w))


def _piecewise_degree(x: Expr, p: Parameters) -> Expr:
    """Search the stretch of x by halves and go straight between its ends; at a jump the largest degree holds."""
    corners = _corners(p)
    places = sorted({u for u, _ in corners})
    degrees = [[y for u, y in corners if u == place] for place in places]
    stretches: list[Expr] = [Number(degrees[0][0])]
    for i, place in enumerate(places):
        side: Expr = Number(degrees[i][-1])
        if i + 1 < len(places) and degrees[i][-1] != degrees[i + 1][0]:
            run = Binary("/", Binary("-", x, Number(place)), Number(places[i + 1] - place))
            side = Binary("+", side, Binary("*", Number(degrees[i + 1][0] - degrees[i][-1]), run))
        if max(degrees[i]) > degrees[i][-1]:
            side = Where(Compare("==", x, Number(place)), Number(max(degrees[i])), side)
        stretches.append(side)
    return _search(x, places, stretches)


def _search(x: Expr, places: Sequence[float], stretches: Sequence[Expr], before_it: Literal["<", "<="] = "<") -> Expr:
    """Choose the stretch before, between or after some places."""
    if not places:
        return stretches[0]
    half = len(places) // 2
    before = _search(x, places[:half], stretches[: half + 1], before_it)
    after = _search(x, places[half + 1 :], stretches[half + 1 :], before_it)
    return Where(Compare(before_it, x, Number(places[half])), before, after)


def _corners(p: Parameters) -> tuple[Vertex, ...]:
    return tuple(zip(p[::2], p[1::2], strict=True))


def _piecewise_core(p: Parameters) -> tuple[float, float]:
    corners = _corners(p)
    top = max(y for _, y in corners)
    places = [x for x, y in corners if y == top]
    return min(places), max(places)


def _piecewise_inverse(w: Expr, p: Parameters) -> Expr | None:
    """Search the stretch of w by halves; a degree that is never reached lies at the nearest end, one of a flat stretch
    at the end of it that lower degrees are next to."""
    corners = _corners(p)
    degrees = [y for _, y in corners]
    if degrees[0] == degrees[-1]:
        return None
    if degrees[0] > degrees[-1]:
        corners, degrees = corners[::-1], degrees[::-1]
    if degrees != sorted(degrees):
        return None
    levels = sorted(set(degrees))
    entries = [next(x for x, y in corners if y == level) for level in levels]
    exits = [next(x for x, y in reversed(corners) if y == level) for level in levels]
    stretches: list[Expr] = [Number(exits[0])]
    for i in range(len(levels) - 1):
        stretches.append(_between(w, (levels[i], exits[i]), (levels[i + 1], entries[i + 1])))
    stretches.append(Number(entries[-1]))
    return _search(w, levels, stretches, "<=")


def _between(w: Expr, before: Vertex, after: Vertex) -> Expr:
    """Return the place on a straight side, by rounding never beyond its upper end."""
    (low, start), (high, end) = before, after
    if start == end:
        return Number(end)
    run = Binary("/", Binary("-", w, Number(low)), Number(high - low))
    place = Binary("+", Number(start), Binary("*", Number(end - start), run))
    return Call("min" if start < end else "max", (Number(end), place))


def _piecewise_mistake(p: Parameters) -> str | None:
    if len(p) < 4 or len(p) % 2:
        return "it takes pairs x1, y1, x2, y2, ..., two or more of them"
    for (x0, _), (x1, _) in zip(_corners(p), _corners(p)[1:], strict=False):
        if x0 > x1:
            return f"x = {x0:.6g} is greater than the next x = {x1:.6g}"
    for _, y in _corners(p):
        if not 0.0 <= y <= 1.0:
            return f"the degree {y:.6g} lies outside [0, 1]"
    if max(y for _, y in _corners(p)) == 0.0:
        return "its degree is 0 everywhere"
    return None


# --- curved sides ------------------------------------------------------------------------------------------------


def _scaled(x: Expr, origin: float, width: float) -> Expr:
    return Binary("/", Binary("-", x, Number(origin)), Number(width))


def _square(x: Expr) -> Expr:
    return Binary("*", x, x)


def _gaussian_degree(x: Expr, p: Parameters) -> Expr:
    """Compute exp(-z²/2) with z = (x - mean) / sigma; a product, since a general power is slower and less exact.

    The division is done beforehand where all numbers, of 32 bits too, can hold what that takes.
    """
    mean, sigma = p
    if 1e-15 < sigma < 1e15:
        return Call("exp", (Binary("*", Number(-0.5 / sigma**2), _square(Binary("-", x, Number(mean)))),))
    return Call("exp", (Binary("*", Number(-0.5), _square(_scaled(x, mean, sigma))),))


def _gaussian2_degree(x: Expr, p: Parameters) -> Expr:
    left = Where(Compare("<", x, Number(p[0])), _gaussian_degree(x, p[:2]), ONE)
    right = Where(Compare(">", x, Number(p[2])), _gaussian_degree(x, p[2:]), ONE)
    if math.isinf(p[0]):
        return right
    return left if math.isinf(p[2]) else Binary("*", left, right)


def _gaussian2_inverse(w: Expr, p: Parameters) -> Expr | None:
    """Invert the one side that is left where the other mean is infinite; the degree 0 lies infinitely far away."""
    mean_left, sigma_left, mean_right, sigma_right = p
    if math.isinf(mean_left) == math.isinf(mean_right):
        return None
    odds = Where(Compare(">", w, ZERO), Binary("/", ONE, w), Number(math.inf))
    away = Call("sqrt", (Binary("*", Number(2.0), Call("max", (ZERO, Call("log", (odds,))))),))
    if math.isinf(mean_right):
        return Binary("-", Number(mean_left), Binary("*", Number(sigma_left), away))
    return Binary("+", Number(mean_right), Binary("*", Number(sigma_right), away))


def _gaussian2_mistake(p: Parameters) -> str | None:
    if p[0] == math.inf or p[2] == -math.inf:
        return "an infinite mean_left is -inf, an infinite mean_right inf"
    if math.isinf(p[0]) and math.isinf(p[2]):
        return "mean_left and mean_right are both infinite"
    return _positive(sigma_left=1, sigma_right=3)(p)


def _gaussian2_core(p: Parameters) -> tuple[float, float]:
    """Return the stretch between the means; where they cross, the place where the product is largest."""
    mean_left, sigma_left, mean_right, sigma_right = p
    if math.isinf(mean_left):
        return mean_right, mean_right
    if math.isinf(mean_right):
        return mean_left, mean_left
    if mean_left <= mean_right:
        return mean_left, mean_right
    ratio = (sigma_right / sigma_left) ** 2
    peak = mean_right + (mean_left - mean_right) * (ratio / (1.0 + ratio))
    return peak, peak


def _bell_degree(x: Expr, p: Parameters) -> Expr:
    distance = Call("abs", (_scaled(x, p[0], p[1]),))
    return Binary("/", ONE, Binary("+", ONE, Binary("^", distance, Number(2.0 * p[2]))))


def _sigmoid_degree(x: Expr, p: Parameters) -> Expr:
    exponent = Binary("*", Number(-p[1]), Binary("-", x, Number(p[0])))
    return Binary("/", ONE, Binary("+", ONE, Call("exp", (exponent,))))


def _sigmoid_inverse(w: Expr, p: Parameters) -> Expr:
    odds = Where(Compare(">", w, ZERO), Binary("/", Binary("-", ONE, w), w), Number(math.inf))
    return Binary("-", Number(p[0]), Binary("/", Call("log", (odds,)), Number(p[1])))


def _sigmoid_core(p: Parameters) -> tuple[float, float]:
    limit = math.copysign(math.inf, p[1])
    return limit, limit


def _sigmoids(p: Parameters) -> tuple[Parameters, Parameters]:
    left, rising, falling, right = p
    return (left, rising), (right, falling)


def _sigmoid_difference_degree(x: Expr, p: Parameters) -> Expr:
    first, second = (_sigmoid_degree(x, q) for q in _sigmoids(p))
    return Call("abs", (Binary("-", first, second),))


def _clamped_difference_degree(x: Expr, p: Parameters) -> Expr:
    first, second = (_sigmoid_degree(x, q) for q in _sigmoids(p))
    return Call("max", (ZERO, Binary("-", first, second)))


def _sigmoid_product_degree(x: Expr, p: Parameters) -> Expr:
    first, second = (_sigmoid_degree(x, q) for q in _sigmoids(p))
    return Binary("*", first, second)


def _between_inflections(p: Parameters) -> tuple[float, float]:
    middle = 0.5 * p[0] + 0.5 * p[3]
    return middle, middle


def _s_degree(x: Expr, p: Parameters) -> Expr:
    """Rise from 0 at the first to 1 at the second parameter along two parabolas; from right to left if it is less."""
    start, end = p
    after, before = (">=", "<=") if start < end else ("<=", ">=")
    foot = Binary("*", Number(2.0), _square(_scaled(x, start, end - start)))
    top = Binary("-", ONE, Binary("*", Number(2.0), _square(_scaled(x, end, end - start))))
    rise = Where(
        _compare(before, x, 0.5 * start + 0.5 * end), Call("min", (Number(0.5), foot)), Call("max", (Number(0.5), top))
    )
    return Where(_compare(after, x, end), ONE, Where(_compare(before, x, start), ZERO, rise))


def _compare(op: str, x: Expr, place: float) -> Expr:
    return Compare(op, x, Number(place))  # type: ignore[arg-type]


def _s_inverse(w: Expr, p: Parameters) -> Expr:
    start, end = p
    half, width = Number(0.5), Number(end - start)
    foot = Binary("+", Number(start), Binary("*", width, Call("sqrt", (Binary("*", half, w),))))
    top = Binary("-", Number(end), Binary("*", width, Call("sqrt", (Binary("*", half, Binary("-", ONE, w)),))))
    return Where(Compare("<", w, half), foot, top)


def _swapped(p: Parameters) -> Parameters:
    return (p[1], p[0])


def _pi_degree(x: Expr, p: Parameters) -> Expr:
    left, left_top, right_top, right = p
    rise: Expr = ONE
    if left > -math.inf:
        rise = _edge(x, left, left_top, ">=")
    fall: Expr = ONE
    if right < math.inf:
        fall = _edge(x, right, right_top, "<=")
    return Where(_compare("<", x, left_top), rise, fall)


def _edge(x: Expr, foot: float, top: float, reached: str) -> Expr:
    return _s_degree(x, (foot, top)) if foot != top else Where(_compare(reached, x, top), ONE, ZERO)


def _pi_inverse(w: Expr, p: Parameters) -> Expr | None:
    left, left_top, right_top, right = p
    if left > -math.inf and right == math.inf:
        return _s_inverse(w, (left, left_top))
    if left == -math.inf and right < math.inf:
        return _s_inverse(w, (right, right_top))
    return None


def _cosine_degree(x: Expr, p: Parameters) -> Expr:
    center, width = p
    wave = Call("cos", (Binary("*", Number(2.0 * math.pi), _scaled(x, center, width)),))
    inside = Compare("<", Call("abs", (_scaled(x, center, width),)), Number(0.5))
    return Where(inside, Binary("*", Number(0.5), Binary("+", ONE, wave)), ZERO)


def _spike_degree(x: Expr, p: Parameters) -> Expr:
    return Call("exp", (Binary("*", Number(-10.0), Call("abs", (_scaled(x, p[0], p[1]),))),))


def _concave_degree(x: Expr, p: Parameters) -> Expr:
    """Compute (end - inflection) / (2 end - inflection - x) before the end; both directions share the formula."""
    inflection, end = p
    before = "<" if inflection < end else ">"
    rest = Binary("+", ONE, _scaled(x, end, inflection - end))
    return Where(_compare(before, x, end), Binary("/", ONE, rest), ONE)


def _concave_inverse(w: Expr, p: Parameters) -> Expr:
    inflection, end = p
    away = Where(Compare(">", w, ZERO), Binary("/", Binary("-", ONE, w), w), Number(math.inf))
    return Binary("-", Number(end), Binary("*", Number(end - inflection), away))


def _arc_degree(x: Expr, p: Parameters) -> Expr:
    start, end = p
    after = ">=" if start < end else "<="
    return Where(_compare(after, x, end), ONE, _circle(_scaled(x, end, end - start)))


def _circle(u: Expr) -> Expr:
    inside = Compare("<", Call("abs", (u,)), ONE)
    return Where(inside, Call("sqrt", (Binary("-", ONE, _square(u)),)), ZERO)


def _arc_inverse(w: Expr, p: Parameters) -> Expr:
    start, end = p
    return Binary("-", Number(end), Binary("*", Number(end - start), Call("sqrt", (Binary("-", ONE, _square(w)),))))


def _semi_ellipse_degree(x: Expr, p: Parameters) -> Expr:
    start, end = p
    return _circle(_scaled(x, 0.5 * start + 0.5 * end, 0.5 * (end - start)))


def _singleton_degree(x: Expr, p: Parameters) -> Expr:
    return Where(Compare("==", x, Number(p[0])), ONE, ZERO)


# --- checks of parameters ----------------------------------------------------------------------------------------


def _ordered(names: tuple[str, ...]) -> Callable[[Parameters], str | None]:
    def mistake(p: Parameters) -> str | None:
        for i in range(len(p) - 1):
            if not p[i] <= p[i + 1]:
                return f"{names[i]} = {p[i]:.6g} is greater than {names[i + 1]} = {p[i + 1]:.6g}"
        return None

    return mistake


def _rising(names: tuple[str, str]) -> Callable[[Parameters], str | None]:
    def mistake(p: Parameters) -> str | None:
        return None if p[0] < p[1] else f"{names[0]} = {p[0]:.6g} must be less than {names[1]} = {p[1]:.6g}"

    return mistake


def _rectangle_mistake(p: Parameters) -> str | None:
    if p == (-math.inf, math.inf):
        return "left and right are both infinite"
    return _rising(("left", "right"))(p)


def _different(names: tuple[str, str]) -> Callable[[Parameters], str | None]:
    def mistake(p: Parameters) -> str | None:
        return None if p[0] != p[1] else f"{names[0]} and {names[1]} are both {p[0]:.6g}"

    return mistake


def _positive(**places: int) -> Callable[[Parameters], str | None]:
    def mistake(p: Parameters) -> str | None:
        return next((f"{name} = {p[i]:.6g} must be > 0" for name, i in places.items() if not p[i] > 0), None)

    return mistake


def _not_zero(**places: int) -> Callable[[Parameters], str | None]:
    def mistake(p: Parameters) -> str | None:
        return next((f"{name} must not be 0" for name, i in places.items() if p[i] == 0), None)

    return mistake


_TRIANGLE: Final = ("left", "peak", "right")
_TRAPEZOID: Final = ("left", "left_top", "right_top", "right")
_EDGE: Final = ("start", "end")
_SIGMOIDS: Final = ("left", "rising", "falling", "right")
_FEET: Final = frozenset({"left", "right"})


def _first(p: Parameters) -> tuple[float, float]:
    return p[0], p[0]


def _second(p: Parameters) -> tuple[float, float]:
    return p[1], p[1]


def _tops(p: Parameters) -> tuple[float, float]:
    return p[1], p[2]


def _middle(p: Parameters) -> tuple[float, float]:
    return 0.5 * p[0] + 0.5 * p[1], 0.5 * p[0] + 0.5 * p[1]


def _spot(p: Parameters) -> tuple[Vertex, ...]:
    return (p[0], 0.0), (p[0], 1.0), (p[0], 0.0)


#: The kinds of membership functions a rule file may use.
MEMBERSHIP: Final[dict[str, MembershipFormula]] = {
    f.name: f
    for f in (
        MembershipFormula(
            name="triangle",
            parameters=_TRIANGLE,
            summary="0 at the feet, 1 at the peak; an infinite foot makes a shoulder",
            degree=lambda x, p: _trapezoid_degree(x, _as_trapezoid(p)),
            mistake=_ordered(_TRIANGLE),
            core=_second,
            vertices=lambda p: _trapezoid_vertices(_as_trapezoid(p)),
            inverse=lambda w, p: _trapezoid_inverse(w, _as_trapezoid(p)),
            infinite=_FEET,
        ),
        MembershipFormula(
            name="trapezoid",
            parameters=_TRAPEZOID,
            summary="0 at the feet, 1 between the tops; an infinite foot makes a shoulder",
            degree=_trapezoid_degree,
            mistake=_ordered(_TRAPEZOID),
            core=_tops,
            vertices=_trapezoid_vertices,
            inverse=_trapezoid_inverse,
            infinite=_FEET,
        ),
        MembershipFormula(
            name="rectangle",
            parameters=("left", "right"),
            summary="1 from left to right, ends included, 0 elsewhere; with one infinite side a step",
            degree=lambda x, p: _trapezoid_degree(x, _as_block(p)),
            mistake=_rectangle_mistake,
            core=lambda p: _as_block(p)[1:3],
            vertices=lambda p: _trapezoid_vertices(_as_block(p)),
            infinite=_FEET,
        ),
        MembershipFormula(
            name="ramp",
            parameters=_EDGE,
            summary="0 at start and before, 1 at end and beyond, straight between; falling where end < start",
            degree=lambda x, p: _trapezoid_degree(x, _as_shoulder(p)),
            mistake=_different(_EDGE),
            core=_second,
            vertices=lambda p: _trapezoid_vertices(_as_shoulder(p)),
            inverse=_ramp_inverse,
        ),
        MembershipFormula(
            name="piecewise",
            parameters=("x1", "y1"),
            summary="straight from (x1, y1) to (x2, y2) and so on, constant beyond the ends; an x given twice is a "
            "jump, where the larger degree holds",
            degree=_piecewise_degree,
            mistake=_piecewise_mistake,
            core=_piecewise_core,
            vertices=_corners,
            inverse=_piecewise_inverse,
            variadic=True,
            pieces=lambda p: p[::2],
        ),
        MembershipFormula(
            name="gaussian",
            parameters=("mean", "sigma"),
            summary="exp(-((x - mean) / sigma)² / 2)",
            degree=_gaussian_degree,
            mistake=_positive(sigma=1),
            core=_first,
            pieces=lambda p: p[:1],
        ),
        MembershipFormula(
            name="gaussian2",
            parameters=("mean_left", "sigma_left", "mean_right", "sigma_right"),
            summary="a Gaussian left of mean_left times a Gaussian right of mean_right; 1 between them; an infinite "
            "mean makes a shoulder",
            degree=_gaussian2_degree,
            mistake=_gaussian2_mistake,
            core=_gaussian2_core,
            inverse=_gaussian2_inverse,
            infinite=frozenset({"mean_left", "mean_right"}),
            pieces=lambda p: (p[0], p[2]),
        ),
        MembershipFormula(
            name="bell",
            parameters=("center", "width", "slope"),
            summary="1 / (1 + |(x - center) / width|^(2 slope))",
            degree=_bell_degree,
            mistake=_positive(width=1, slope=2),
            core=_first,
            pieces=lambda p: p[:1],
        ),
        MembershipFormula(
            name="sigmoid",
            parameters=("inflection", "slope"),
            summary="1 / (1 + exp(-slope (x - inflection))); falling for slope < 0",
            degree=_sigmoid_degree,
            mistake=_not_zero(slope=1),
            core=_sigmoid_core,
            inverse=_sigmoid_inverse,
            pieces=lambda p: p[:1],
        ),
        MembershipFormula(
            name="sigmoid_difference",
            parameters=_SIGMOIDS,
            summary="|sigmoid(left, rising) - sigmoid(right, falling)|",
            degree=_sigmoid_difference_degree,
            mistake=_not_zero(rising=1, falling=2),
            core=_between_inflections,
            pieces=lambda p: (p[0], p[3]),
        ),
        MembershipFormula(
            name="sigmoid_product",
            parameters=_SIGMOIDS,
            summary="sigmoid(left, rising) times sigmoid(right, falling); a hill for rising > 0 and falling < 0",
            degree=_sigmoid_product_degree,
            mistake=_not_zero(rising=1, falling=2),
            core=_between_inflections,
            pieces=lambda p: (p[0], p[3]),
        ),
        MembershipFormula(
            name="s_shape",
            parameters=_EDGE,
            summary="0 up to start, 2 u² and then 1 - 2 (1 - u)² with u = (x - start) / (end - start), 1 from end on",
            degree=_s_degree,
            mistake=_rising(_EDGE),
            core=_second,
            inverse=_s_inverse,
        ),
        MembershipFormula(
            name="z_shape",
            parameters=_EDGE,
            summary="1 - s_shape(start, end): 1 up to start, 0 from end on",
            degree=lambda x, p: _s_degree(x, _swapped(p)),
            mistake=_rising(_EDGE),
            core=_first,
            inverse=lambda w, p: _s_inverse(w, _swapped(p)),
        ),
        MembershipFormula(
            name="pi_shape",
            parameters=_TRAPEZOID,
            summary="s_shape(left, left_top) up to the tops, z_shape(right_top, right) after them; an infinite foot "
            "makes a shoulder",
            degree=_pi_degree,
            mistake=_ordered(_TRAPEZOID),
            core=_tops,
            inverse=_pi_inverse,
            infinite=_FEET,
        ),
        MembershipFormula(
            name="cosine",
            parameters=("center", "width"),
            summary="(1 + cos(2π (x - center) / width)) / 2 within width / 2 of the center, 0 elsewhere",
            degree=_cosine_degree,
            mistake=_positive(width=1),
            core=_first,
            pieces=lambda p: (p[0] - 0.5 * p[1], p[0], p[0] + 0.5 * p[1]),
        ),
        MembershipFormula(
            name="spike",
            parameters=("center", "width"),
            summary="exp(-10 |x - center| / width)",
            degree=_spike_degree,
            mistake=_positive(width=1),
            core=_first,
            pieces=lambda p: p[:1],
        ),
        MembershipFormula(
            name="concave",
            parameters=("inflection", "end"),
            summary="(end - inflection) / (2 end - inflection - x) before the end, 1 beyond; falling where "
            "end < inflection",
            degree=_concave_degree,
            mistake=_different(("inflection", "end")),
            core=_second,
            inverse=_concave_inverse,
        ),
        MembershipFormula(
            name="arc",
            parameters=_EDGE,
            summary="a quarter of an ellipse from 0 at start to 1 at end, 1 beyond: sqrt(1 - u²) with "
            "u = (x - end) / (end - start); falling where end < start",
            degree=_arc_degree,
            mistake=_different(_EDGE),
            core=_second,
            inverse=_arc_inverse,
        ),
        MembershipFormula(
            name="semi_ellipse",
            parameters=_EDGE,
            summary="half an ellipse from start to end: sqrt(1 - u²) with u = (2 x - start - end) / (end - start)",
            degree=_semi_ellipse_degree,
            mistake=_rising(_EDGE),
            core=_middle,
            pieces=lambda p: (p[0], 0.5 * p[0] + 0.5 * p[1], p[1]),
        ),
        MembershipFormula(
            name="singleton",
            parameters=("value",),
            summary="1 at the value, 0 elsewhere",
            degree=_singleton_degree,
            mistake=lambda p: None,
            core=_first,
            vertices=_spot,
            fuzzy=False,
        ),
        MembershipFormula(
            name="constant",
            parameters=("value",),
            summary="a Takagi-Sugeno consequent of order 0; in an average the same as a singleton",
            degree=_singleton_degree,
            mistake=lambda p: None,
            core=_first,
            vertices=_spot,
            fuzzy=False,
        ),
    )
}

#: Functions as other tools compute them, by the kind that rule files write and what is different.
VARIANTS: Final[dict[str, MembershipFormula]] = {
    "sigmoid_difference clamped": replace(MEMBERSHIP["sigmoid_difference"], degree=_clamped_difference_degree),
}


def formula_of(kind: str) -> MembershipFormula:
    """Return the formula of a membership function or a variant of one."""
    return VARIANTS[kind] if kind in VARIANTS else MEMBERSHIP[kind]
