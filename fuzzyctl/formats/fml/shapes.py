"""Shapes of FML terms: one table, which reads and writes them, and the sets that modifiers derive from a term."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.expr import Number, evaluate
from fuzzyctl.formats.common.losses import cannot
from fuzzyctl.formats.common.words import one_sided
from fuzzyctl.formats.fml.document import Element, Markup
from fuzzyctl.formulas import MEMBERSHIP, is_straight
from fuzzyctl.kernels.compile import degree_function
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Membership, Output, Term

Ends = tuple[float, float]
Values = tuple[float, ...]
Set = tuple[str, Values]  # a kind of membership function with its parameters

#: Points that approximate a curve without a shape in FML.
_SAMPLES: Final = 101


# --- the table -------------------------------------------------------------------------------------------------------


def _as_kind(p: Values, _ends: Ends) -> Values | None:
    return p if all(map(math.isfinite, p)) else None


@dataclass(frozen=True)
class Shape:
    """A shape of FML with parameters; reading and writing also get the range of the variable.

    Args:
        kind: Its kind in the model.
        count: Number of its parameters.
        read: The kind and its parameters; None if they are those of the file.
        write: The parameters in the file; None if the shape cannot express a term.
    """

    kind: str
    count: int
    read: Callable[[Values, Ends], Set] | None = None
    write: Callable[[Values, Ends], Values | None] = _as_kind


def _linear(*, falls: bool) -> Shape:
    def read(p: Values, _ends: Ends) -> Set:
        first, last = p
        if first == last:  # a step
            return "rectangle", (-math.inf, first) if falls else (first, math.inf)
        return "ramp", (last, first) if falls else p

    def write(p: Values, _ends: Ends) -> Values | None:
        return None if (p[0] > p[1]) != falls else p[::-1] if falls else p

    return Shape("ramp", 2, read, write)


def _gaussian_side(*, falls: bool) -> Shape:
    """Return a Gaussian whose other side is 1 up to the end of the range, where inputs are clamped."""

    def read(p: Values, ends: Ends) -> Set:
        center, deviation = p
        left, right = (min(ends[0], center), center) if falls else (center, max(ends[1], center))
        return "gaussian2", (left, deviation, right, deviation)

    def write(p: Values, ends: Ends) -> Values | None:
        left, left_deviation, right, right_deviation = p
        end, limit = (left, min(ends[0], right)) if falls else (right, max(ends[1], left))
        if math.isinf(end) or (end == limit and left_deviation == right_deviation):
            return p[2:] if falls else p[:2]
        return None

    return Shape("gaussian2", 2, read, write)


def _pi_of_width(p: Values, _ends: Ends) -> Set:
    return "pi_shape", (p[0] - p[1], p[0], p[0], p[0] + p[1])


def _read_pi(p: Values, ends: Ends) -> Set:
    """Return a curve that rises and falls equally far; it has a center and a width if it cannot rise."""
    return _pi_of_width(p, ends) if p[0] >= p[1] else ("pi_shape", (p[0], p[1], p[1], p[1] + (p[1] - p[0])))


def _write_pi(p: Values, ends: Ends) -> Values | None:
    left, top, right_top, right = p
    is_even = left < top == right_top and right == top + (top - left)
    return p[:2] if is_even and _as_kind(p, ends) else None


#: Shapes as JFML interprets and the standard spells them.
SHAPES: Final[dict[str, Shape]] = {
    "triangularShape": Shape("triangle", 3),
    "trapezoidShape": Shape("trapezoid", 4),
    "gaussianShape": Shape("gaussian", 2),
    "leftGaussianShape": _gaussian_side(falls=True),
    "rightGaussianShape": _gaussian_side(falls=False),
    "leftLinearShape": _linear(falls=True),
    "rightLinearShape": _linear(falls=False),
    "piShape": Shape("pi_shape", 2, _read_pi, _write_pi),
    "zShape": Shape("z_shape", 2),
    "sShape": Shape("s_shape", 2),
    "rectangularShape": Shape("rectangle", 2),
    "singletonShape": Shape("singleton", 1),
}

#: The same by their names in small letters; drafts have another word for a trapezoid.
_BY_NAME: Final = {tag.lower(): shape for tag, shape in SHAPES.items()}
_BY_NAME["trapezoidalshape"] = SHAPES["trapezoidShape"]

#: The shapes of drafts, which mirror left and right.
_OF_DRAFTS: Final = {
    **_BY_NAME,
    **{f"left{side}shape": _BY_NAME[f"right{side}shape"] for side in ("gaussian", "linear")},
    **{f"right{side}shape": _BY_NAME[f"left{side}shape"] for side in ("gaussian", "linear")},
    "pishape": Shape("pi_shape", 2, _pi_of_width),
}

_POINT_SETS: Final = ("pointsetshape", "pointsetmonotonicshape", "usershape", "pointsshape")

#: Names in small letters of all shapes.
SHAPE_NAMES: Final = frozenset({*_BY_NAME, *_POINT_SETS})

#: All shapes as the standard spells them, for messages.
_TAGS: Final = (*SHAPES, "pointSetShape", "circularDefinition")


# --- reading ---------------------------------------------------------------------------------------------------------

_SIDES: Final = "'left' shapes are 1 on the left and fall, as in JFML; drafts and FuzzyLogic.jl mirror left and right"
_MIRRORED: Final = "'Left' shapes rise on their left side, as in drafts of FML; JFML mirrors left and right"
_PI: Final = "piShape rises from param1 to param2 and falls as far, as in JFML; drafts mean center and width"
_PI_WIDTH: Final = "piShape has a center and a width, as in drafts; JFML means where it begins and where it is 1"

_CURVES: Final = "curves through points may leave [0, 1] between them, and the standard does not say what holds there"
_STRAIGHT: Final = 'write points so close that straight lines between them do: interpolationMethod="linear"'


def read_shape(element: Element, markup: Markup, ends: Ends) -> Membership | None:
    """Return the membership function of a shape over a range; None after an error."""
    name = element.name
    if name in _POINT_SETS:
        return _read_points(element, markup)
    shape = (_OF_DRAFTS if markup.draft else _BY_NAME).get(name)
    if shape is None:
        code, message, help_text = "FZ601", f"no shape <{element.tag}>", did_you_mean(element.tag, _TAGS)
        if name in ("customshape", "custommonotonicshape"):
            code, message, help_text = "FZ602", "a custom shape is not available", ""
        markup.error(code, message, element.span, facts=(f"shapes: {listed(_TAGS)}",), help=help_text)
        return None
    attributes = [f"param{i}" for i in range(1, shape.count + 1)]
    markup.check_parts(element, attributes, ())
    numbers = [markup.number_of(element, attribute) for attribute in attributes]
    p = tuple(n.value for n in numbers if n is not None)
    if len(p) < len(numbers):
        return None
    if name == "pishape":
        markup.doubt(_PI_WIDTH if markup.draft or p[0] >= p[1] else _PI, element.span)
    elif shape.read is not None:
        markup.doubt(_MIRRORED if markup.draft else _SIDES, element.span)
    kind, parameters = (shape.kind, p) if shape.read is None else shape.read(p, ends)
    return Membership(kind=kind, arguments=tuple(map(Number, parameters)), span=element.span)


def _read_points(element: Element, markup: Markup) -> Membership | None:
    markup.check_parts(element, ("interpolationmethod", "degree"), ("point",))
    method = element.attributes.get("interpolationmethod", "linear").strip().lower()
    if method != "linear":
        message = f"the interpolation '{method}' is not available"
        markup.error("FZ602", message, element.place("interpolationmethod"), facts=(_CURVES,), help=_STRAIGHT)
        return None
    points: list[tuple[float, float]] = []
    for point in element.all("point"):
        x, y = markup.number_of(point, "x"), markup.number_of(point, "y")
        if x is None or y is None:
            return None
        points.append((x.value, y.value))
    if not points:
        markup.error("FZ303", f"<{element.tag}> has no points", element.span, help='write <point x="0" y="1"/>')
        return None
    points.sort(key=lambda p: p[0])
    if len(points) == 1:
        points.append((points[0][0] + 1.0, points[0][1]))
    return Membership(kind="piecewise", arguments=tuple(Number(v) for p in points for v in p), span=element.span)


# --- sets derived from a term ----------------------------------------------------------------------------------------


def _with(membership: Membership, kind: str, parameters: Values) -> Membership:
    return membership.model_copy(update={"kind": kind, "arguments": tuple(map(Number, parameters))})


def _numbers(membership: Membership) -> Values:
    return tuple(a.value for a in membership.arguments if isinstance(a, Number))


def complement(membership: Membership) -> Membership | None:
    """Return one minus a membership function; None if no kind expresses it."""
    kind, p = membership.kind, _numbers(membership)
    if kind in ("s_shape", "z_shape"):
        return _with(membership, "z_shape" if kind == "s_shape" else "s_shape", p)
    if kind == "ramp":
        return _with(membership, kind, p[::-1])
    if not is_straight(kind) or kind == "rectangle" or MEMBERSHIP[kind].mistake(p) is not None:
        return None
    corners = MEMBERSHIP[kind].vertices(p)
    if len({x for x, _ in corners}) < len(corners):
        return None  # at a jump the larger degree holds, in the complement the smaller one
    return _with(membership, "piecewise", tuple(v for x, y in corners for v in (x, 1.0 - y)))


def reaches_one(membership: Membership) -> bool:
    """Return whether the largest degree of a term is 1; only lists of points may stay below."""
    return membership.kind != "piecewise" or max(_numbers(membership)[1::2]) == 1.0


def up_to(membership: Membership, *, above: bool) -> Membership | None:
    """Return the set whose complement is `above` or `below` a term: 1 up to the peak of the term, then the term.

    Returns:
        The set; None for a term with several peaks or none of 1, which the standard does not define.
    """
    kind, p = membership.kind, _numbers(membership)
    if kind in ("z_shape", "s_shape", "ramp"):
        falls = kind == "z_shape" or (kind == "ramp" and p[0] > p[1])
        return membership if falls == above else _with(membership, "trapezoid", (-math.inf, p[0], p[0], math.inf))
    if kind in ("rectangle", "singleton"):
        return _with(membership, "rectangle", (-math.inf, p[-1]) if above else (p[0], math.inf))
    if kind == "piecewise":
        return _points_up_to(membership, above=above)
    if kind == "gaussian":
        kind, p = "gaussian2", (*p, *p)
    if kind not in ("triangle", "trapezoid", "pi_shape", "gaussian2"):
        return None  # a function of the inputs
    foot = 0 if above else 2 if kind == "gaussian2" else len(p) - 1
    return _with(membership, kind, (*p[:foot], -math.inf if above else math.inf, *p[foot + 1 :]))


def _points_up_to(membership: Membership, *, above: bool) -> Membership | None:
    p = _numbers(membership)
    points = list(zip(p[::2], p[1::2], strict=True))
    peaks = [i for i, (_, y) in enumerate(points) if y == 1.0]
    if not peaks or peaks[-1] - peaks[0] + 1 != len(peaks):
        return None
    side = points[peaks[-1] :] if above else points[: peaks[0] + 1]
    if len(side) == 1:
        side.append((side[0][0] + 1.0, 1.0))
    return _with(membership, "piecewise", tuple(v for point in side for v in point))


# --- writing ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class WrittenShape:
    """A term as FML.

    Args:
        tag: Name of the element.
        parameters: Its numbers; those of a set of points are coordinates, one after the other.
        note: How it is written if not by an equal shape.
        exact: Whether it is the same function within the range of its variable.
    """

    tag: str
    parameters: Values
    note: str = ""
    exact: bool = True


def written_shape(system: FuzzySystem, variable: Input | Output, term: Term, *, monotone: bool) -> WrittenShape:
    """Return a term as FML: the equal shape, or points.

    Args:
        system: The system.
        variable: The variable of the term.
        term: The term.
        monotone: Whether it must be a shape that Tsukamoto's method can invert, which excludes steps.

    Raises:
        DiagnosticError: For a term without a shape and without finite degrees, such as a bell of the width 0.
    """
    kind, ends = term.membership.kind, (system.number(variable.lower), system.number(variable.upper))
    # A function of an input has no parameters, so that it becomes points.
    p = tuple(evaluate(a, system.values) for a in term.membership.arguments) if kind in MEMBERSHIP else ()
    height = evaluate(term.membership.height, system.values)
    corners = MEMBERSHIP[kind].vertices(p) if is_straight(kind) else ()
    has_step = len({x for x, _ in corners}) < len(corners)
    shape = _equal_shape(kind, p, corners, ends) if height == 1.0 and not (monotone and has_step) else None
    if shape is not None:
        return shape
    note, points = "it is written as points", [(x, y * height) for x, y in corners]
    if kind == "piecewise":
        note = "" if height == 1.0 else f"{note} with its height"
    elif not points:
        note = f"FML has no such shape; it is written as {_SAMPLES} points"
        points = _sampled(system, variable, term, ends)
    elif len(points) == 1:  # 1 everywhere
        points.append((points[0][0] + 1.0, points[0][1]))
    if not all(math.isfinite(v) for point in points for v in point):
        raise _without_points(system, variable, term)
    tag = "pointSetMonotonicShape" if monotone else "pointSetShape"
    return WrittenShape(tag, tuple(v for point in points for v in point), note, exact=bool(corners))


def _equal_shape(kind: str, p: Values, corners: tuple[tuple[float, float], ...], ends: Ends) -> WrittenShape | None:
    """Return a shape that is the same function in the range; a step is a trapezoid that is flat up to its end.

    A trapezoid with a shoulder stays points, which all tools read alike: drafts of the standard mirror left and right.
    """
    if kind != "trapezoid" or p[1] == p[2]:
        kind, p = one_sided(kind, p)
    if kind == "constant":
        kind = "singleton"
    elif kind in ("triangle", "trapezoid") and len(corners) == 2 and corners[0][0] == corners[1][0]:
        place, degree = corners[0]
        low, high = min(ends[0], place), max(ends[1], place)
        block = (low, low, place, place) if degree == 1.0 else (place, place, high, high)
        return WrittenShape("trapezoidShape", block, "its flat side ends where the range does")
    for tag, shape in SHAPES.items():
        if shape.kind == kind and (parameters := shape.write(p, ends)) is not None:
            return WrittenShape(tag, parameters)
    return None


def _sampled(system: FuzzySystem, variable: Input | Output, term: Term, ends: Ends) -> list[tuple[float, float]]:
    low, high = ends
    degree = degree_function(system, variable, term)
    if degree is None:  # a consequent that is a function of the inputs
        raise _without_points(system, variable, term)
    places = (low + (high - low) * i / (_SAMPLES - 1) for i in range(_SAMPLES))
    try:
        return [(x, degree(x)) for x in places]
    except (ArithmeticError, ValueError):  # parameters that the checks of a file refuse
        raise _without_points(system, variable, term) from None


def _without_points(system: FuzzySystem, variable: Input | Output, term: Term) -> DiagnosticError:
    reason = f"term '{term.name}' of '{variable.name}' has no shape in FML, and no finite degrees to write as points"
    return cannot(system, ".fml", [reason])
