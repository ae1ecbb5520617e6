"""Errors of pydantic about a value, in words."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

#: By the type of an error the name of its bound, and the relation that the value must have to it.
BOUNDS = {
    "greater_than": ("gt", ">"),
    "greater_than_equal": ("ge", ">="),
    "less_than": ("lt", "<"),
    "less_than_equal": ("le", "<="),
}
_KINDS = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "text in quotes",
    "bool_type": "true or false",
    "finite_number": "a finite number",
    "tuple_type": "a list",
    "dict_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
}


def length(error: Any) -> str:
    """Describe an error in the number of elements of a list, or of characters of a text."""
    if error["type"] == "string_too_short":
        return "must not be empty"
    few = error["type"] == "too_short"
    number = error["ctx"]["min_length" if few else "max_length"]
    words = f"must have at {'least' if few else 'most'} {number} element{'s' if number != 1 else ''}"
    actual = error["ctx"]["actual_length"]  # None of a table that is too long
    return f"{words}, has {'more' if actual is None else actual or 'none'}"


def requirement(error: Any, number: Callable[[float], str] = "{:g}".format) -> str:
    """Describe a valid value.

    Args:
        error: Of pydantic.
        number: Writes a bound.
    """
    kind, about = error["type"], error.get("ctx", {})
    if kind in BOUNDS:
        name, symbol = BOUNDS[kind]
        return f"{symbol} {number(about[name])}"
    if kind in _KINDS:
        return _KINDS[kind]
    if kind == "literal_error":
        return str(about["expected"])
    return f"right ({error['msg']})"


def show(value: Any) -> str:
    """Return a value of a scenario as a short text."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        return "a list"
    try:
        text = repr(value)
    except ValueError:
        return "a whole number of thousands of digits"
    return text if len(text) <= 60 else f"{text[:57]}..."
