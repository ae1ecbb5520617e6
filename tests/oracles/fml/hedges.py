"""FML modifiers without an equivalent here: hedges of the system, and sets beside a term."""

from __future__ import annotations

import math
from typing import Final, Literal

from fuzzyctl.expr import Call, Expr, Name, Number
from fuzzyctl.model.block import Hedge
from fuzzyctl.model.variable import Membership

Side = Literal["above", "below"]

_X: Final = Name("x")

#: Of a set that has every degree, the largest degree of `plus` and not `very`: of min(d^(5/4), 1 - d²).
_SLIGHTLY_PEAK: Final = 0.580790459486683


def _contrast(x: Expr) -> Expr:
    """Return 2x² up to 1/2 and 1 - 2(1 - x)² above, as 1/2 + 2u - 2u|u| with u = x - 1/2."""
    u = x - 0.5
    doubled = 2.0 * u
    return 0.5 + doubled - doubled * Call("abs", (u,))


_PLUS: Final = _X**1.25
_NOT_VERY: Final = 1.0 - _X**2.0
_SLIGHTLY: Final = _contrast(Call("min", (_PLUS, _NOT_VERY)) / _SLIGHTLY_PEAK)

#: Hedges of a system's own by modifier: x^(5/4); what `extremely` is in its usual meaning, for a system that has the
#: standard's `extremely`, too; and plus and not very, made to reach 1 and intensified.
OWN_HEDGES: Final[dict[str, Hedge]] = {
    "plus": Hedge(name="plus", parameter="x", expression=_PLUS),
    "intensify": Hedge(name="intensify", parameter="x", expression=_contrast(_X)),
    "slightly": Hedge(name="slightly_1855", parameter="x", expression=_SLIGHTLY),
}

#: Modifiers that ask for the largest degree of a set, and are what is said here only where that is 1.
NEED_ONE: Final = ("norm", "slightly")


def reaches_one(membership: Membership) -> bool:
    """Whether the largest degree of a term is 1; only lists of points may stay below."""
    if membership.kind != "piecewise":
        return True
    return max(_numbers(membership)[1::2]) == 1.0


def up_to(membership: Membership, side: Side) -> Membership | None:
    """Return the set whose complement is `above` or `below` a term: 1 up to where the term is largest, then the term.

    Returns:
        The set; None for a term of several peaks, or of a peak below 1, where the standard says nothing.
    """
    kind, p = membership.kind, _numbers(membership)
    made = _points_up_to(p, side) if kind == "piecewise" else _set_up_to(kind, p, side)
    if made is None:
        return None
    return membership.model_copy(update={"kind": made[0], "arguments": tuple(map(Number, made[1]))})


def _numbers(membership: Membership) -> tuple[float, ...]:
    return tuple(a.value for a in membership.arguments if isinstance(a, Number))


def _set_up_to(kind: str, p: tuple[float, ...], side: Side) -> tuple[str, tuple[float, ...]] | None:
    above = side == "above"
    everywhere = "trapezoid", (-math.inf, p[0], p[0], math.inf)
    match kind:
        case "triangle" | "trapezoid" | "pi_shape":
            return kind, ((-math.inf, *p[1:]) if above else (*p[:-1], math.inf))
        case "gaussian":
            return "gaussian2", ((-math.inf, p[1], p[0], p[1]) if above else (p[0], p[1], math.inf, p[1]))
        case "gaussian2":
            return kind, ((-math.inf, *p[1:]) if above else (p[0], p[1], math.inf, p[3]))
        case "z_shape" | "s_shape":
            return (kind, p) if (kind == "z_shape") == above else everywhere
        case "ramp":
            return (kind, p) if (p[0] > p[1]) == above else everywhere
        case "rectangle" | "singleton":
            return "rectangle", ((-math.inf, p[-1]) if above else (p[0], math.inf))
    return None


def _points_up_to(p: tuple[float, ...], side: Side) -> tuple[str, tuple[float, ...]] | None:
    points = list(zip(p[::2], p[1::2], strict=True))
    peaks = [i for i, (_, y) in enumerate(points) if y == 1.0]
    if not peaks or peaks[-1] - peaks[0] + 1 != len(peaks):
        return None
    kept = points[peaks[-1] :] if side == "above" else points[: peaks[0] + 1]
    if len(kept) == 1:
        kept.append((kept[0][0] + 1.0, 1.0))
    return "piecewise", tuple(v for point in kept for v in point)
