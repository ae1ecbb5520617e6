"""Checks of the parameters of membership functions."""

from __future__ import annotations

from collections.abc import Callable

from fuzzyctl.formulas.formula import Parameters

#: Returns the mistake in parameters, or None.
Check = Callable[[Parameters], str | None]


def ordered(names: tuple[str, ...]) -> Check:
    """Check that parameters do not decrease."""

    def mistake(p: Parameters) -> str | None:
        for i in range(len(p) - 1):
            if not p[i] <= p[i + 1]:
                return f"{names[i]} = {p[i]:.6g} is greater than {names[i + 1]} = {p[i + 1]:.6g}"
        return None

    return mistake


def rising(names: tuple[str, str]) -> Check:
    """Check that the first parameter is less than the second."""

    def mistake(p: Parameters) -> str | None:
        return None if p[0] < p[1] else f"{names[0]} = {p[0]:.6g} must be less than {names[1]} = {p[1]:.6g}"

    return mistake


def different(names: tuple[str, str]) -> Check:
    """Check that two parameters differ."""

    def mistake(p: Parameters) -> str | None:
        return None if p[0] != p[1] else f"{names[0]} and {names[1]} are both {p[0]:.6g}"

    return mistake


def positive(**places: int) -> Check:
    """Check that the parameters at some places are above 0; not so NaN."""

    def mistake(p: Parameters) -> str | None:
        return next((f"{name} = {p[i]:.6g} must be > 0" for name, i in places.items() if not p[i] > 0), None)

    return mistake


def not_zero(**places: int) -> Check:
    """Check that the parameters at some places differ from 0."""

    def mistake(p: Parameters) -> str | None:
        return next((f"{name} must not be 0" for name, i in places.items() if p[i] == 0), None)

    return mistake
