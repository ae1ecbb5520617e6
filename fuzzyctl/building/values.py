"""Python values as numbers, expressions, terms, partitions and methods of the model."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from numbers import Real
from typing import Any, Final, SupportsFloat

from fuzzyctl.building import fragments
from fuzzyctl.diagnostics.diagnostic import ArgumentError, ValueOutOfBoundsError
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Expr, Name, Number, Where, walk
from fuzzyctl.model.method import Activation, Defuzzifier, Method, Semantics
from fuzzyctl.model.profiles import PROFILES, Profile
from fuzzyctl.model.variable import Membership
from fuzzyctl.support import arguments

#: A number, or the text of an expression over params.
Value = float | int | str | Expr

#: Forms of a term: a number or the text of an expression (a constant), a kind with its parameters, such as
#: ("triangle", 0, 1, 2) or "triangle(0, 1, 2)".
TermSpec = float | int | str | Sequence[Any] | Membership

_NUMBER: Final = "a number or the text of an expression"
_TERM: Final = "a number, the text of a membership function or of an expression, or a kind with its parameters"


def expression(name: str, value: object) -> Expr:
    """Return an expression; `name` is for messages."""
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


def _require_written(name: str, due: str, text: str) -> None:
    if not text.strip():
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
    """Return the membership function of a term or of a cell; `name` is for messages."""
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


class Partition:
    """Triangular terms that meet at each other's peaks.

    Args:
        names: The terms, in order.
        peaks: Their peaks; None spreads them evenly over the range of the variable.
    """

    def __init__(self, names: tuple[str, ...], peaks: tuple[Expr, ...] | None) -> None:
        self.names, self.peaks = names, peaks

    def terms(self, lower: object, upper: object) -> list[tuple[str, Membership]]:
        """Return terms in order; one that is named twice is kept, for the checks to find as in a file."""
        peaks = self.peaks if self.peaks is not None else _even(lower, upper, len(self.names))
        feet = [-Name("inf"), *peaks, Name("inf")]
        triangles = (Membership(kind="triangle", arguments=(feet[k], p, feet[k + 2])) for k, p in enumerate(peaks))
        return list(zip(self.names, triangles, strict=True))


def partition(names: str | Sequence[str], peaks: Sequence[Value] | None = None) -> Partition:
    """Return a triangular partition: terms that meet at each other's peaks, with shoulders at the ends.

    Args:
        names: The terms, in a text separated by blanks or as a sequence.
        peaks: Their peaks; None spreads them evenly over the range of the variable.

    Raises:
        ArgumentError: For fewer than two terms, or another number of peaks.
    """
    terms = arguments.names("'names'", names)
    at = None if peaks is None else arguments.items("'peaks'", "a list of numbers", peaks)
    if len(terms) < 2 or (at is not None and len(at) != len(terms)):
        got = f"{counted(len(terms), 'term')}{'' if at is None else ' and ' + counted(len(at), 'peak')}"
        raise ArgumentError(f"a partition needs two terms or more and a peak for each, got {got}")
    return Partition(terms, None if at is None else tuple(expression("a peak", p) for p in at))


def _even(lower: object, upper: object, count: int) -> tuple[Expr, ...]:
    """Return peaks spread evenly from end to end."""
    ends = [float(e) for e in (lower, upper) if isinstance(e, Real)]
    if len(ends) < 2 or not all(map(math.isfinite, ends)):
        raise ArgumentError("an even partition needs a range of finite numbers; give the peaks")
    last = count - 1
    return tuple(expression("a peak", (ends[0] * (last - k) + ends[1] * k) / last) for k in range(count))


def defuzzifier_of(value: object, profile: Profile = PROFILES["exact"]) -> Defuzzifier:
    """Return a defuzzifier; whether there is one of that name is for the checks, which find all mistakes at once."""
    if isinstance(value, Defuzzifier):
        return value
    name = arguments.instance("'defuzzifier'", str, "the text of a defuzzifier, or a Defuzzifier", value)
    return fragments.defuzzifier(name, profile) if "(" in name else profile.defuzzifier(name)


def method_of(semantics: object, defuzzifier: object, activation: object, norms: Mapping[str, str | None]) -> Method:
    """Return a method of the arguments, completed from the profile in force."""
    knobs = semantics
    if not isinstance(knobs, Semantics):
        knobs = fragments.semantics(
            arguments.instance("'semantics'", str, "the text of a profile, or a Semantics", knobs)
        )
    profile = PROFILES[knobs.profile]
    default = profile.defuzzifier("centroid") if defuzzifier is None else defuzzifier_of(defuzzifier, profile)
    norm_texts = texts(**{name: norm for name, norm in norms.items() if norm is not None})
    return replace(
        profile.method, **norm_texts, semantics=knobs, defuzzifier=default, activation=activation_of(activation)
    )


def activation_of(value: object) -> Activation:
    """Return an activation method; that of all systems for None."""
    if value is None or isinstance(value, Activation):
        return value or Activation()
    due = "the text of an activation method, or an Activation"
    return fragments.activation(arguments.instance("'activation'", str, due, value))
