"""Columns by name: data frames, structured arrays and mappings, recognised by what they offer."""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence
from typing import Any

from fuzzyctl.errors import ArgumentError
from fuzzyctl.misspelt import did_you_mean


def column_names(values: Any) -> list[Any] | None:
    """Return the names of the columns of a value, None for a value without named columns.

    Structured arrays have `dtype.names`; mappings, pandas and xarray data sets `keys()`; tables of Arrow
    `column_names`; data frames of polars `columns`. A pandas Series has the labels of its rows as keys.
    """
    fields = getattr(getattr(values, "dtype", None), "names", None)
    if fields:
        return list(fields)
    for attribute in ("keys", "column_names", "columns"):
        found = getattr(values, attribute, None)
        if found is not None:
            return list(found() if callable(found) else found)
    return None


def columns_by_name(inputs: Sequence[str], values: Any) -> list[Any] | None:
    """Return the column of each input in the order of the inputs, None for values without named columns.

    Args:
        inputs: The names of the inputs.
        values: What a caller gives as points.

    Raises:
        ArgumentError: For columns that are missing, repeated or no inputs, all of them by name; for a list of records.
    """
    _refuse_records(values)
    names = column_names(values)
    if names is None:
        return None
    # As rule files are read: letters with accents have one form.
    known = [unicodedata.normalize("NFC", name) if isinstance(name, str) else name for name in names]
    mistakes = [f"no input {name!r}{_hint(name, inputs)}" for name in dict.fromkeys(known) if name not in inputs]
    mistakes += [f"column {name!r} occurs {known.count(name)} times" for name in inputs if known.count(name) > 1]
    missing = [repr(name) for name in inputs if name not in known]
    mistakes += [f"a column is missing for: {', '.join(missing)}"] if missing else []
    if mistakes:
        wanted = f"points with named columns must have exactly the inputs {', '.join(inputs)}"
        raise ArgumentError(f"{wanted}; {'; '.join(mistakes)}")
    try:
        return [values[names[known.index(name)]] for name in inputs]
    except TypeError:  # such as a lazy frame, which holds no values yet
        raise ArgumentError(f"points must hold the values of their columns, got {type(values).__name__}") from None


def require_same_index(names: Sequence[str], values: Sequence[Any]) -> None:
    """Refuse Series whose row labels differ: their rows would be combined by position.

    Raises:
        ArgumentError: For the first one whose labels are not those of the Series before.
    """
    labelled = [(n, v.index) for n, v in zip(names, values, strict=True) if hasattr(v, "index") and _has_labels(v)]
    for name, index in labelled[1:]:
        first, labels = labelled[0]
        if not labels.equals(index):
            hint = "align them, or give arrays, such as those of to_numpy()"
            raise ArgumentError(f"{first!r} and {name!r} have different row labels; {hint}")


def _has_labels(value: Any) -> bool:
    return hasattr(value.index, "equals")  # of a list, `index` is a method


def _refuse_records(values: Any) -> None:
    """Refuse a list whose items name their values: an array of it would take them by position."""
    if not isinstance(values, list | tuple):
        return
    first = values if hasattr(values, "_fields") else values[0] if values else None
    if hasattr(first, "_fields") or column_names(first) is not None:
        form = "an array, or columns by name such as {'a': [...], 'b': [...]}"
        raise ArgumentError(f"points must be {form}; got {type(first).__name__} records, whose names would be ignored")


def _hint(name: object, inputs: Sequence[str]) -> str:
    hint = did_you_mean(name, inputs) if isinstance(name, str) else ""
    return f" ({hint})" if hint else ""
