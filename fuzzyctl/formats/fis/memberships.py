"""Writer of membership functions as `'trimf',[0 1 2]`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final

from fuzzyctl.expr import Number, number_text
from fuzzyctl.formats.common.clamped_inputs import simplest
from fuzzyctl.formats.common.words import words_by_kind
from fuzzyctl.formats.fis.vocabulary import MEMBERSHIP_WORDS, OF_FUZZYLITE
from fuzzyctl.formats.fll.shapes import as_written
from fuzzyctl.model.variable import Membership

Values = Sequence[float]

#: A function of a `.fis` file with its parameters.
Written = tuple[str, Values]


def number(value: float, infinite: str = "Inf") -> str:
    """Return a number as MATLAB reads it; fuzzylite reads another word for what is infinite."""
    if math.isinf(value):
        return infinite if value > 0 else f"-{infinite}"
    return number_text(value)


def vector(values: Values, infinite: str = "Inf") -> str:
    """Return numbers between brackets."""
    return f"[{' '.join(number(v, infinite) for v in values)}]"


def _trapezoid(p: Values, words: tuple[str, str, str] = ("trapmf", "linzmf", "linsmf")) -> Written:
    """Return a trapezoid; shoulders that never end are the functions that MATLAB has for them."""
    left, left_top, right_top, right = p
    if math.isinf(left) and math.isinf(right):
        return "trapmf", (-math.inf, -math.inf, math.inf, math.inf)
    if math.isinf(left):
        return words[1], (right_top, right)
    if math.isinf(right):
        return words[2], (left, left_top)
    return words[0], p


def _triangle(p: Values) -> Written:
    left, peak, right = p
    return ("trimf", p) if math.isfinite(left) and math.isfinite(right) else _trapezoid((left, peak, peak, right))


def _rectangle(p: Values) -> Written:
    left, right = p
    return _trapezoid((left, left if math.isfinite(left) else right, right if math.isfinite(right) else left, right))


def _ramp(p: Values) -> Written:
    return ("linsmf", p) if p[0] < p[1] else ("linzmf", (p[1], p[0]))


#: How kinds are written that have several words, or another one where they never end.
_WRITERS: Final[dict[str, Callable[[Values], Written]]] = {
    "triangle": _triangle,
    "trapezoid": _trapezoid,
    "rectangle": _rectangle,
    "ramp": _ramp,
    "pi_shape": lambda p: _trapezoid(p, ("pimf", "zmf", "smf")),
    "singleton": lambda p: ("constant", p),
    "linear": lambda p: ("linear", p),
}

_WORDS: Final = words_by_kind(MEMBERSHIP_WORDS)


def written(kind: str, parameters: Values, *, fuzzylite: bool) -> Written | None:
    """Return a membership function as a file has it; None for a kind that no `.fis` file has.

    Args:
        kind: The kind.
        parameters: Its parameters.
        fuzzylite: Whether the file is for fuzzylite, which has functions of its own for some kinds.
    """
    if fuzzylite and kind in ("rectangle", "ramp"):
        return ("rectmf" if kind == "rectangle" else "rampmf"), parameters
    shown = tuple(as_written(kind, parameters) if fuzzylite else parameters)
    if kind in _WRITERS:
        found = _WRITERS[kind](shown)
        return _shoulder_of_fuzzylite(*found) if fuzzylite else found
    name, word = _WORDS.get(kind, ("", None))
    return (name, word.parameters(shown)) if word is not None else None


def _shoulder_of_fuzzylite(function: str, parameters: Values) -> Written:
    """Return a shoulder as fuzzylite has it, which knows no word of MATLAB's, and no ramp without width."""
    if function not in ("linsmf", "linzmf"):
        return function, parameters
    start, end = parameters
    if start == end:
        return "rectmf", (start, math.inf) if function == "linsmf" else (-math.inf, end)
    return "rampmf", (start, end) if function == "linsmf" else (end, start)


def is_of_matlab(function: str) -> bool:
    """Whether MATLAB has a function, and not fuzzylite alone."""
    return function not in OF_FUZZYLITE


def as_matlab_has_it(own: Membership, parameters: Values) -> tuple[Membership, float]:
    """Return points as a triangle, a trapezoid or a shoulder with its height, where they are one; else as they are."""
    points = list(zip(parameters[::2], parameters[1::2], strict=True))
    height = 1.0
    if len(points) == 3 and points[0][1] == points[2][1] == 0.0 < points[1][1]:
        height = points[1][1]  # a low peak
        points[1] = (points[1][0], 1.0)
    found = simplest(points)
    if found is None:
        return own, 1.0
    return Membership(kind=found[0], arguments=tuple(map(Number, found[1]))), height
