"""Columns by name: data frames, structured arrays and mappings, recognised by their interfaces."""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.diagnostics.suggestions import did_you_mean

#: Most names of columns in a message.
SHOWN: Final = 5


def column_names(values: Any) -> list[Any] | None:
    """Return the names of the columns of a value, None for a value without named columns.

    Structured arrays have `dtype.names`; mappings, pandas and xarray data sets `keys()`; tables of Arrow
    `column_names`; data frames of polars `columns`. A pandas Series has the labels of its rows as keys.
    """
    fields = getattr(getattr(values, "dtype", None), "names", None)
    if fields:
        return list(fields)
    if _has_named_axes(values):  # its attributes may be coordinates
        return None
    for attribute in ("keys", "column_names", "columns"):
        found = getattr(values, attribute, None)
        if found is not None:
            return list(found() if callable(found) else found)
    return None


def axis_names(inputs: Sequence[str], values: Any) -> list[Any] | None:
    """Return the labels of the last axis of an array with named axes, such as a DataArray of xarray; None without them.

    Raises:
        ArgumentError: For inputs that label another axis.
    """
    if not _has_named_axes(values):
        return None
    labels = {axis: list(values.indexes[axis]) for axis in values.dims if axis in values.indexes}
    for axis in values.dims[:-1]:
        if any(name in labels.get(axis, ()) for name in inputs):
            raise ArgumentError(f"the inputs must label the last axis of points, got them on axis {axis!r}")
    return labels.get(values.dims[-1]) if values.dims else None


def _has_named_axes(values: Any) -> bool:
    return hasattr(values, "dims") and hasattr(values, "indexes") and hasattr(values, "shape")


def columns_by_name(inputs: Sequence[str], values: Any, what: str = "points") -> list[Any] | None:
    """Return the column of each input in the order of the inputs, None for values without named columns.

    Args:
        inputs: The names of the inputs.
        values: What a caller gives as points.
        what: What messages call them.

    Raises:
        ArgumentError: For columns that are missing, repeated or no inputs, all of them by name; for a list of records.
    """
    _refuse_records(values)
    labels = axis_names(inputs, values)
    names = column_names(values) if labels is None else labels
    if names is None:
        return None
    # As rule files are read: letters with accents have one form.
    known = [unicodedata.normalize("NFC", name) if isinstance(name, str) else name for name in names]
    kind = "state" if what.startswith("state") else "input"
    others = [name for name in dict.fromkeys(known) if name not in inputs]
    mistakes = [f"no {kind} {name!r}{_hint(name, inputs)}" for name in others[:SHOWN]]
    mistakes += [f"and {len(others) - SHOWN} more"] if len(others) > SHOWN else []
    mistakes += [f"column {name!r} occurs {known.count(name)} times" for name in inputs if known.count(name) > 1]
    missing = [repr(name) for name in inputs if name not in known]
    mistakes += [f"a column is missing for: {', '.join(missing)}"] if missing else []
    if mistakes:
        if getattr(values, "ndim", None) == 1 and hasattr(values, "iloc"):
            mistakes.append(f"a Series is one point, and its labels are the {kind}s: several are a data frame")
        wanted = f"{what} with named columns must have exactly the {kind}s {', '.join(inputs)}"
        raise ArgumentError(f"{wanted}; {'; '.join(mistakes)}")
    if labels is not None:
        return [values[..., known.index(name)] for name in inputs]
    try:
        return [values[names[known.index(name)]] for name in inputs]
    except TypeError:  # such as a lazy frame, which holds no values yet
        raise ArgumentError(f"points must hold the values of their columns, got {type(values).__name__}") from None


def require_same_index(names: Sequence[str], values: Sequence[Any]) -> None:
    """Refuse Series whose row labels differ, and arrays whose named axes do: they would be combined by position.

    Raises:
        ArgumentError: For the first one whose labels are not those of the one before.
    """
    _require_same_axes(names, values)
    labelled = [(n, v.index) for n, v in zip(names, values, strict=True) if hasattr(v, "index") and _has_labels(v)]
    for name, index in labelled[1:]:
        first, labels = labelled[0]
        if not labels.equals(index):
            hint = "align them, or give arrays, such as those of to_numpy()"
            raise ArgumentError(f"{first!r} and {name!r} have different row labels; {hint}")


def _require_same_axes(names: Sequence[str], values: Sequence[Any]) -> None:
    """Do the same for arrays with named axes; those without axes are numbers, which broadcast."""
    named = [(n, v) for n, v in zip(names, values, strict=True) if _has_named_axes(v) and v.dims]
    for name, value in named[1:]:
        first, other = named[0]
        if other.dims != value.dims:
            axes = f"{', '.join(map(str, other.dims))} and {', '.join(map(str, value.dims))}"
            raise ArgumentError(f"{first!r} and {name!r} have different axes: {axes}; give arrays of the same axes")
        for axis in value.dims:
            both = [list(v.indexes[axis]) for v in (other, value) if axis in v.indexes]
            if len(both) == 2 and both[0] != both[1]:
                raise ArgumentError(f"{first!r} and {name!r} have different labels along {axis!r}; align them")


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
