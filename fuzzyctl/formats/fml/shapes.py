"""Membership functions from the shapes of FML terms."""

from __future__ import annotations

import math
from typing import Final

from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.expr import Number
from fuzzyctl.formats.fml.document import Element
from fuzzyctl.formats.fml.markup import Markup
from fuzzyctl.formats.fml.vocabulary import DRAFT_SHAPES, POINT_SETS, SHAPE_TAGS, SHAPES
from fuzzyctl.formulas import MEMBERSHIP, is_straight
from fuzzyctl.model.variable import Membership

Ends = tuple[float, float]

_SIDES: Final = "'left' shapes are 1 on the left and fall, as in JFML; drafts and FuzzyLogic.jl mirror left and right"
_MIRRORED: Final = "'Left' shapes rise on their left side, as in drafts of FML; JFML mirrors left and right"
_PI: Final = "piShape rises from param1 to param2 and falls as far, as in JFML; drafts mean center and width"
_PI_WIDTH: Final = "piShape has a center and a width, as in drafts; JFML means where it begins and where it is 1"

_CURVES: Final = "curves through points may leave [0, 1] between them, and the standard does not say what holds there"
_STRAIGHT: Final = 'write points so close that straight lines between them do: interpolationMethod="linear"'


def shape_of(element: Element, markup: Markup, domain: Ends) -> Membership | None:
    """Return the membership function that a shape stands for; None, with an error, for one that cannot be had."""
    name = element.name
    if name in POINT_SETS:
        return _points(element, markup)
    word = (DRAFT_SHAPES if markup.draft else SHAPES).get(name)
    if word is None:
        code, message = "FZ601", f"no shape <{element.tag}>"
        if name in ("customshape", "custommonotonicshape"):
            code, message = "FZ602", "a custom shape is not available"
        facts, help_text = (f"shapes: {listed(SHAPE_TAGS)}",), did_you_mean(element.tag, SHAPE_TAGS)
        markup.error(code, message, element.span, facts=facts, help=help_text if code == "FZ601" else "")
        return None
    attributes = [f"param{i}" for i in range(1, (word.count or 0) + 1)]
    markup.known(element, attributes, ())
    given = [markup.value(element, attribute) for attribute in attributes]
    if any(g is None for g in given):
        return None
    p = tuple(g.value for g in given if g is not None)
    if name == "pishape":
        markup.unsure.setdefault(_PI_WIDTH if markup.draft or p[0] >= p[1] else _PI, element.span)
    elif word.read is not None:
        markup.unsure.setdefault(_MIRRORED if markup.draft else _SIDES, element.span)
    kind, parameters = word.shape(p)
    if kind == "gaussian2":  # the flat side reaches to the end of the domain, to which inputs are held
        left, sigma, right, _ = parameters
        if left == -math.inf:
            left = min(domain[0], right)
        else:
            right = max(domain[1], left)
        parameters = left, sigma, right, sigma
    return Membership(kind=kind, arguments=tuple(map(Number, parameters)), span=element.span)


def _points(element: Element, markup: Markup) -> Membership | None:
    markup.known(element, ("interpolationmethod", "degree"), ("point",))
    method = element.attributes.get("interpolationmethod", "linear").strip().lower()
    if method != "linear":
        message = f"the interpolation '{method}' is not available"
        markup.error("FZ602", message, element.place("interpolationmethod"), facts=(_CURVES,), help=_STRAIGHT)
        return None
    points: list[tuple[float, float]] = []
    for point in element.all("point"):
        x, y = markup.value(point, "x"), markup.value(point, "y")
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


def complement(membership: Membership) -> Membership | None:
    """Return one minus a membership function, None where no function of its own is that."""
    given = tuple(a.value for a in membership.arguments if isinstance(a, Number))
    kind = membership.kind
    if kind in ("s_shape", "z_shape"):
        return membership.model_copy(update={"kind": "z_shape" if kind == "s_shape" else "s_shape"})
    if kind == "ramp":
        return membership.model_copy(update={"arguments": membership.arguments[::-1]})
    if not is_straight(kind) or kind == "rectangle" or MEMBERSHIP[kind].mistake(given) is not None:
        return None
    corners = MEMBERSHIP[kind].vertices(given)
    if len({x for x, _ in corners}) < len(corners):
        return None  # at a jump the larger degree holds, in the complement the smaller one
    return membership.model_copy(
        update={"kind": "piecewise", "arguments": tuple(Number(v) for x, y in corners for v in (x, 1.0 - y))}
    )
