"""Membership functions from the shapes of FML terms."""

from __future__ import annotations

import math
from typing import Final

from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.expr import Expr, Number
from fuzzyctl.formulas import MEMBERSHIP, is_straight
from fuzzyctl.model.variable import Membership
from tests.oracles.fml.document import Element
from tests.oracles.fml.names import POINT_SETS, SHAPE_TAGS, SHAPES
from tests.oracles.fml.scope import Scope

Ends = tuple[float, float]
_Made = tuple[str, tuple[float, ...]]


def shape_of(element: Element, scope: Scope, domain: Ends) -> Membership | None:
    """Return the membership function that a shape stands for; None, with an error, for one that cannot be had."""
    name = element.name
    if name in POINT_SETS:
        return _points(element, scope)
    if name not in SHAPES:
        facts = (f"shapes: {listed(SHAPE_TAGS)}",)
        if name in ("customshape", "custommonotonicshape"):
            scope.error("FZ602", "a custom shape is not available", element.span, facts=facts)
        else:
            help_text = did_you_mean(element.tag, SHAPE_TAGS)
            scope.error("FZ601", f"no shape <{element.tag}>", element.span, facts=facts, help=help_text)
        return None
    own, count = SHAPES[name]
    scope.known(element, [f"param{i}" for i in range(1, count + 1)], ())
    given = [scope.number(element, f"param{i}") for i in range(1, count + 1)]
    if any(g is None for g in given):
        return None
    values = tuple(g.value for g in given if g is not None)
    kind, parameters = (own, values) if own is not None else _sided(element, values, scope, domain)
    return Membership(kind=kind, arguments=tuple(map(Number, parameters)), span=element.span)


_SIDES: Final = "'left' shapes are 1 on the left and fall, as in JFML; drafts and FuzzyLogic.jl mirror left and right"
_MIRRORED: Final = "'Left' shapes rise on their left side, as in drafts of FML; JFML mirrors left and right"
_PI: Final = "piShape rises from param1 to param2 and falls as far, as in JFML; drafts mean center and width"
_PI_WIDTH: Final = "piShape has a center and a width, as in drafts; JFML means where it begins and where it is 1"


def _sided(element: Element, p: tuple[float, ...], scope: Scope, domain: Ends) -> _Made:
    """Return what a shape is whose meaning differs between the standard's library and earlier drafts."""
    name = element.name
    if name == "pishape":
        by_width = scope.draft or p[0] >= p[1]
        scope.unsure.setdefault(_PI_WIDTH if by_width else _PI, element.span)
        if by_width:
            return "pi_shape", (p[0] - p[1], p[0], p[0], p[0] + p[1])
        return "pi_shape", (p[0], p[1], p[1], p[1] + (p[1] - p[0]))
    scope.unsure.setdefault(_MIRRORED if scope.draft else _SIDES, element.span)
    falls = name.startswith("left") != scope.draft
    if name.endswith("linearshape"):
        first, last = p
        if first == last:  # a step
            return "rectangle", (-math.inf, first) if falls else (first, math.inf)
        return "ramp", (last, first) if falls else (first, last)
    center, deviation = p
    # The flat side reaches to the end of the domain, to which inputs are held.
    if falls:
        return "gaussian2", (min(domain[0], center), deviation, center, deviation)
    return "gaussian2", (center, deviation, max(domain[1], center), deviation)


_CURVES: Final = "curves through points may leave [0, 1] between them, and the standard does not say what holds there"
_STRAIGHT: Final = 'write points so close that straight lines between them do: interpolationMethod="linear"'


def _points(element: Element, scope: Scope) -> Membership | None:
    scope.known(element, ("interpolationmethod", "degree"), ("point",))
    method = element.attributes.get("interpolationmethod", "linear").strip().lower()
    if method != "linear":
        message = f"the interpolation '{method}' is not available"
        scope.error("FZ602", message, element.place("interpolationmethod"), facts=(_CURVES,), help=_STRAIGHT)
        return None
    found: list[tuple[float, float]] = []
    for point in element.all("point"):
        x, y = scope.number(point, "x"), scope.number(point, "y")
        if x is None or y is None:
            return None
        found.append((x.value, y.value))
    if not found:
        scope.error("FZ303", f"<{element.tag}> has no points", element.span, help='write <point x="0" y="1"/>')
        return None
    found.sort(key=lambda p: p[0])
    if len(found) == 1:
        found.append((found[0][0] + 1.0, found[0][1]))
    arguments: tuple[Expr, ...] = tuple(Number(v) for point in found for v in point)
    return Membership(kind="piecewise", arguments=arguments, span=element.span)


def complement(membership: Membership) -> Membership | None:
    """Return one minus a membership function, None where no function of its own is that."""
    given = tuple(a.value for a in membership.arguments if isinstance(a, Number))
    kind = membership.kind
    if kind in ("s_shape", "z_shape"):
        other = "z_shape" if kind == "s_shape" else "s_shape"
        return membership.model_copy(update={"kind": other})
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
