"""Argument conversion of kernels: real numbers in any array-like form."""

from __future__ import annotations

import sys
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from numbers import Real
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError, UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.program.scalar import as_number

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]


def in_order(names: Sequence[str], arguments: tuple[Any, ...], named: Mapping[str, Any]) -> tuple[Any, ...]:
    """Return all arguments of a call by position.

    Args:
        names: Of the arguments, in their order.
        arguments: Those without a name.
        named: The others; Python writes µ and some other letters in another form (NFKC).

    Raises:
        UnknownNameError: For a name that is not an input.
        ArgumentError: For an argument that is missing or given twice.
    """
    normal = [unicodedata.normalize("NFKC", name) for name in names]
    for name in named:
        if name not in normal:
            raise UnknownNameError("input", name, names)
        if name in normal[: len(arguments)]:
            raise ArgumentError(f"{name!r} is given by position and by name")
    rest = normal[len(arguments) :]
    missing = [name for name in rest if name not in named]
    if missing:
        raise ArgumentError(f"a value is missing for: {', '.join(missing)}")
    return (*arguments, *(named[name] for name in rest))


def argument_error(names: Sequence[str], states: int, arguments: tuple[Any, ...], error: Exception) -> ArgumentError:
    """Return the error for the arguments of a call.

    Args:
        names: Of the arguments, in their order.
        states: Length of the state, which is the last one; 0 for none.
        arguments: Arguments of the call.
        error: The exception of the function.
    """
    if isinstance(error, ArgumentError):
        return error
    if len(arguments) != len(names):
        several = not states and any(hasattr(a, "__len__") for a in arguments)
        hint = "; kernel.batch takes arrays" if several else ""
        return ArgumentError(
            f"the kernel takes {len(names)} arguments ({', '.join(names)}), got {len(arguments)}{hint}"
        )
    kinds = ", ".join(f"{n}: {type(a).__name__}" for n, a in zip(names, arguments, strict=True))
    return ArgumentError(f"each input must be a real number; got {kinds}; kernel.batch takes arrays")


def input_number(name: str, value: object) -> float:
    """Return the value of one input.

    Raises:
        ArgumentError: If a value is not a real number.
        ValueOutOfBoundsError: For an integer beyond all floats.
    """
    try:
        return as_number(value, f"input {name!r}")
    except OverflowError:
        raise too_large([name], [value]) from None


def too_large(names: Sequence[str], arguments: Sequence[Any]) -> ValueOutOfBoundsError:
    """Name the input that is too large for a float."""
    for name, value in zip(names, arguments, strict=False):
        if overflows(value):
            return ValueOutOfBoundsError(f"input {name!r}", type(value), "within the range of floats")
    return ValueOutOfBoundsError("an input", type(arguments), "within the range of floats")


def as_floats(arguments: Sequence[Any], inputs: int, expected: int) -> list[Any]:
    """Return the arguments of a call with the inputs, which come first, as floats.

    Raises:
        ArgumentError: If a value is not a real number.
        TypeError: For another number of arguments than expected.
    """
    if len(arguments) != expected:
        raise TypeError("wrong number of arguments")
    return [*map(as_number, arguments[:inputs]), *arguments[inputs:]]


def overflows(value: Any) -> bool:
    """Return whether a number is too large for a float."""
    try:
        if isinstance(value, Real):
            float(value)
    except OverflowError:
        return True
    return False


def writable(array: FloatArray) -> FloatArray:
    """Return an array as compiled code takes it: it declares arrays that could be written to, though it only reads.

    Such an array is contiguous and aligned, and of no class derived from numpy's.
    """
    import numpy as np

    return np.require(array, requirements=["C", "W", "A"])


def row_array(names: Sequence[str], rows: Any, what: str) -> FloatArray:
    """Return rows as an array of floats, shape (..., names); columns by name are put in the order of the names.

    Raises:
        ArgumentError: For columns of other names, or values that are not arrays of real numbers.
    """
    import numpy as np

    if type(rows) is np.ndarray:  # the usual case
        return float_array(rows, what)
    has_names = isinstance(rows, Mapping) or (getattr(rows, "ndim", 0) == 2 and hasattr(rows, "columns"))
    if getattr(rows, "ndim", 0) == 1 and hasattr(rows, "iloc"):  # a Series: positions have no names
        has_names = any(isinstance(label, str) for label in rows.index)
    columns = columns_by_name(names, rows, what) if has_names and len(names) else None
    return float_array(rows, what) if columns is None else stacked(names, columns)


def point_array(names: Sequence[str], points: Any) -> Any:
    """Return points as an array of shape (..., inputs); columns with names are put in the order of the inputs.

    Args:
        names: Of the inputs.
        points: Points of a caller; for one input also without the last axis.

    Raises:
        ArgumentError: For columns that are not those of the inputs, for an array of another shape, and for what is no
            array of real numbers.
    """
    import numpy as np

    plain = type(points) is np.ndarray and points.dtype.names is None  # the usual case, without a search
    is_series = len(names) == 1 and getattr(points, "ndim", 0) == 1 and hasattr(points, "iloc")
    columns = None if plain or is_series or not names else columns_by_name(names, points)
    array = number_array(points, "points") if columns is None else stacked(names, columns)
    if len(names) == 1 and (array.ndim == 0 or array.shape[-1] != 1):
        array = array[..., np.newaxis]
    if array.ndim == 0 or array.shape[-1] != len(names):
        wanted = f"(..., {len(names)}) for {', '.join(names)}"
        raise ArgumentError(f"points must have the shape {wanted}, got {array.shape}")
    return array


def stacked(names: Sequence[str], columns: Sequence[Any]) -> FloatArray:
    """Return the values of each input, which broadcast, as points of shape (..., inputs).

    Raises:
        ArgumentError: For values that are not real numbers or do not broadcast, and for Series with other row labels.
    """
    import numpy as np

    require_same_index(names, columns)
    arrays = [float_array(c, f"input {n!r}") for n, c in zip(names, columns, strict=True)]
    try:
        return np.stack(np.broadcast_arrays(*arrays), axis=-1)
    except ValueError:
        shapes = ", ".join(f"{n} {a.shape}" for n, a in zip(names, arrays, strict=True))
        raise ArgumentError(f"the inputs do not broadcast; they have the shapes {shapes}") from None


def number_array(values: Any, what: str) -> Any:
    """Return an array of numbers of any type, as it is: a large one is converted block by block.

    Raises:
        ArgumentError: If it is not an array of real numbers.
    """
    import numpy as np

    if isinstance(values, np.ndarray) and values.dtype.kind in "biuf" and not isinstance(values, np.ma.MaskedArray):
        return np.asarray(values)
    return float_array(values, what)


def float_array(values: Any, what: str) -> FloatArray:
    """Return an array of floats.

    Raises:
        ArgumentError: If it is not an array of real numbers.
        ValueOutOfBoundsError: For numbers beyond the range of floats.
    """
    import numpy as np

    try:
        if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
            raise ArgumentError(f"{what} has masked entries; fill them first")
        array = np.asarray(values)
        if array.ndim > 1 and not isinstance(values, list | tuple) and (named := column_names(values)) is not None:
            raise ArgumentError(f"{what} must be an array, got a table with the columns {', '.join(map(str, named))}")
        if array.dtype.kind not in "biuf":
            # Texts, complex numbers and None would be turned into floats without a word; Fractions may be.
            kinds = all(isinstance(v, Real) for v in array.flat) if array.dtype.kind == "O" else False
            if not kinds:
                raise ArgumentError(f"{what} must be an array of real numbers, got {array.dtype}")
        return np.asarray(array, dtype=np.float64)
    except OverflowError:
        raise ValueOutOfBoundsError(what, type(values), "within the range of floats") from None
    except ArgumentError:
        raise
    except (TypeError, ValueError) as error:
        raise ArgumentError(f"{what} must be an array of real numbers: {error}") from None


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
        value = getattr(values, attribute, None)
        if value is not None:
            return list(value() if callable(value) else value)
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
        values: Points of a caller.
        what: Their name in messages.

    Raises:
        ArgumentError: For columns that are missing, repeated or no inputs, all of them by name; for a list of records.
    """
    _refuse_records(values)
    labels = axis_names(inputs, values)
    names = column_names(values) if labels is None else labels
    if names is None:
        return None
    # As rule files are read: letters with accents have one form.
    normal = [unicodedata.normalize("NFC", name) if isinstance(name, str) else name for name in names]
    kind = "state" if what.startswith("state") else "input"
    others = [name for name in dict.fromkeys(normal) if name not in inputs]
    mistakes = [f"no {kind} {name!r}{_hint(name, inputs)}" for name in others[:SHOWN]]
    mistakes += [f"and {len(others) - SHOWN} more"] if len(others) > SHOWN else []
    mistakes += [f"column {name!r} occurs {normal.count(name)} times" for name in inputs if normal.count(name) > 1]
    missing = [repr(name) for name in inputs if name not in normal]
    mistakes += [f"a column is missing for: {', '.join(missing)}"] if missing else []
    if mistakes:
        if getattr(values, "ndim", None) == 1 and hasattr(values, "iloc"):
            mistakes.append(f"a Series is one point, and its labels are the {kind}s: several are a data frame")
        wanted = f"{what} with named columns must have exactly the {kind}s {', '.join(inputs)}"
        raise ArgumentError(f"{wanted}; {'; '.join(mistakes)}")
    if labels is not None:
        return [values[..., normal.index(name)] for name in inputs]
    try:
        return [values[names[normal.index(name)]] for name in inputs]
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


def labelled(results: Any, names: Sequence[Any], given: Any) -> Any:
    """Return results as pandas objects if the points are pandas objects, else unchanged.

    Args:
        results: Shape (rows,) for one output, (rows, outputs) for several; of another shape they have no row labels.
        names: Of the results, such as the outputs.
        given: A DataFrame, or Series as the values of a mapping; anything else has no row labels.

    Returns:
        A Series named after the output, for several outputs a DataFrame, with the index that was given.
    """
    pandas = sys.modules.get("pandas")  # whoever gives a frame has loaded it
    if pandas is None:
        return results
    frames = (pandas.DataFrame, pandas.Series)
    columns = given.values() if isinstance(given, Mapping) else (given,)
    index = next((v.index for v in columns if isinstance(v, frames)), None)
    if index is None or results.shape[:1] != (len(index),):
        return results
    if results.ndim == 1 and len(names) == 1:
        return pandas.Series(results, index=index, name=names[0])
    return pandas.DataFrame(results, index=index, columns=list(names)) if results.ndim == 2 else results


NO_STATE: Final = "the system has no state: no output is adaptive or says 'else hold'"


def state_argument(state: Any, names: Sequence[str], *, compiled: bool) -> Any:
    """Return a state as the function of a backend takes it; compiled code would read beyond a short one.

    Raises:
        ArgumentError: For a state of another shape.
    """
    count = len(names)
    if type(state) in (list, tuple) and not compiled:  # no numpy for a light start
        try:
            plain: Any = [c if type(c) is float else as_number(c, "each entry of the state") for c in state]
        except OverflowError:
            raise ValueOutOfBoundsError("state", type(state), "within the range of floats") from None
    else:
        array = row_array(names, state, "state") if hasattr(state, "keys") else float_array(state, "state")
        if array.ndim != 1:
            raise ArgumentError(f"the state must have the shape ({count},), got {array.shape}")
        plain = writable(array) if compiled else array.tolist()
    if len(plain) != count:
        raise ArgumentError(f"the state must have {count} entries, got {len(plain)}")
    return plain


def states_along(
    plan: Plan, batch: Callable[[FloatArray, FloatArray], FloatArray], points: FloatArray, state: FloatArray
) -> FloatArray:
    """Return the state before each point of a sequence.

    An output is NaN where it would hold a previous value of NaN, which shows where it holds; the value that it holds
    there is the last one before. Outputs may read each other, so they are found one by one, each after those it reads:
    as many batches as there are such outputs, and no loop over points.

    Args:
        plan: The system.
        batch: The function (points, states) -> results.
        points: Shape (n, inputs).
        state: State before the first point, shape (states,).

    Returns:
        Shape (n, states).
    """
    import numpy as np

    states = np.tile(state, (len(points), 1))
    adaptive = len(plan.states)
    for k, position in enumerate(plan.held):
        column = states[:, adaptive + k]
        column[:] = np.nan
        fresh = batch(points, states)[:, position]
        column[:] = previous(fresh, float(state[adaptive + k]))
    return states


def previous(values: FloatArray, first: float) -> FloatArray:
    """Return for each of some values, shape (n,), the last one before it that is not NaN, or `first`."""
    import numpy as np

    latest = np.where(np.isnan(values), 0, np.arange(1, len(values) + 1))
    before = np.concatenate(([0], np.maximum.accumulate(latest)[:-1])) if len(values) else latest
    result: FloatArray = np.concatenate(([first], values))[before]
    return result


def state_after(plan: Plan, state: FloatArray, results: FloatArray) -> FloatArray:
    """Return the state after results of shape (n, outputs), the state before them given."""
    import numpy as np

    after = np.array(state, dtype=np.float64)
    for k, position in enumerate(plan.held):
        fresh = results[~np.isnan(results[:, position]), position]
        if len(fresh):
            after[len(plan.states) + k] = fresh[-1]
    return after
