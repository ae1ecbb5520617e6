"""Conversion of Python values to numbers, expressions and terms of the model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real
from typing import Any, Final, SupportsFloat

from fuzzyctl.building import fragments
from fuzzyctl.diagnostics.diagnostic import ArgumentError, ValueOutOfBoundsError
from fuzzyctl.expr import Expr, Name, Number, Where, walk
from fuzzyctl.model.variable import Membership
from fuzzyctl.support import arguments

#: A number, or the text of an expression over params.
Value = float | int | str | Expr

#: What a term may be given as: a number or the text of an expression (a constant), a kind with its parameters, such as
#: ("triangle", 0, 1, 2) or "triangle(0, 1, 2)".
TermSpec = float | int | str | Sequence[Any] | Membership

_NUMBER: Final = "a number or the text of an expression"
_TERM: Final = "a number, the text of a membership function or of an expression, or a kind with its parameters"


def expression(name: str, value: object) -> Expr:
    """Return an expression; `name` says of what."""
    if isinstance(value, Expr):
        return _writable(name, value)
    if isinstance(value, str):
        _require_written(name, _NUMBER, value)
        return fragments.expression(value)
    if isinstance(value, bool) or not isinstance(value, Real):
        raise arguments.wrong(name, _NUMBER, value)
    number = _float(name, value)
    if math.isinf(number):  # a name, as in a file
        return Name("inf") if number > 0 else -Name("inf")
    return Number(number)


def _require_written(name: str, due: str, given: str) -> None:
    if not given.strip():
        raise ArgumentError(f"{name} must be {due}, got an empty text")


def _float(name: str, value: SupportsFloat) -> float:
    try:
        number = float(value)
    except OverflowError:  # its text may be as long
        raise ValueOutOfBoundsError(name, type(value), "within the range of floats") from None
    if math.isnan(number):
        raise ValueOutOfBoundsError(name, number, "a number, not NaN")
    return number


def _writable(name: str, value: Expr) -> Expr:
    """Return an expression made by hand if a file could say it."""
    for node in walk(value):
        if isinstance(node, Where) or (isinstance(node, Number) and not isinstance(node.value, float)):
            raise ArgumentError(f"{name} contains an element that cannot be expressed in .fz: {type(node).__name__}")
        if isinstance(node, Number):
            _float(name, node.value)
    return value


def membership(name: str, spec: object) -> Membership:
    """Return the membership function of a term or of a cell; `name` says which."""
    if isinstance(spec, Membership):
        return spec
    if isinstance(spec, str):
        _require_written(name, _TERM, spec)
        return fragments.membership(spec) or _constant(name, spec)
    if isinstance(spec, Sequence) and not isinstance(spec, bytes | bytearray | memoryview):
        if not spec or not isinstance(spec[0], str):
            raise ArgumentError(f"{name} must begin with its kind, such as ('triangle', 0, 1, 2)")
        return Membership(kind=spec[0], arguments=tuple(expression(f"a parameter of {name}", p) for p in spec[1:]))
    if isinstance(spec, bool) or not isinstance(spec, Real | Expr):
        raise arguments.wrong(name, _TERM, spec)
    return _constant(name, spec)


def _constant(name: str, value: object) -> Membership:
    return Membership(kind="constant", arguments=(expression(name, value),))


def texts(**given: object) -> dict[str, Any]:
    """Return fields that are texts, by their names."""
    return {name: arguments.text(f"{name!r}", value) for name, value in given.items()}
