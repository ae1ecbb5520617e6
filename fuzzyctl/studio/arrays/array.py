"""Arrays: elements in C order and a shape; how they are indexed, and repeated along axes."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain, product
from typing import Any

Shape = tuple[int, ...]


def lacking() -> ModuleNotFoundError:
    """Return the error that numpy raises where it is not installed."""
    return ModuleNotFoundError("No module named 'numpy'", name="numpy")


class ndarray:  # noqa: N801 - numpy's name
    """An array: its elements in C order, and its shape."""

    __slots__ = ("items", "shape")

    def __init__(self, items: list[Any], shape: Shape) -> None:
        self.items, self.shape = items, shape

    def __getattr__(self, name: str) -> Any:
        """Report what arrays of numpy have and these lack."""
        raise AttributeError(name) if name.startswith("__") else lacking()

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return len(self.shape)

    @property
    def size(self) -> int:
        """Number of elements."""
        return len(self.items)

    @property
    def T(self) -> ndarray:  # noqa: N802 - numpy's name
        """The transpose of up to two axes."""
        if len(self.shape) < 2:
            return self
        rows, columns = self.shape
        return ndarray([x for k in range(columns) for x in self.items[k::columns]], (columns, rows))

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Iterator[Any]:
        return (self[k] for k in range(self.shape[0]))

    def __bool__(self) -> bool:
        return bool(self.item())

    def __float__(self) -> float:
        return float(self.item())

    def __int__(self) -> int:
        return int(self.item())

    def __index__(self) -> int:
        return operator.index(self.item())

    def __repr__(self) -> str:
        return f"array({self.tolist()})"

    def item(self) -> Any:
        """Return the only element."""
        (element,) = self.items
        return element

    def tolist(self) -> Any:
        """Return nested lists, or a number for no axis."""
        items = self.items
        for axis in range(len(self.shape) - 1, 0, -1):
            count = self.shape[axis]
            items = [items[k * count : (k + 1) * count] for k in range(math.prod(self.shape[:axis]))]
        return items if self.shape else items[0]

    def copy(self) -> ndarray:
        """Return the same elements in an array of their own."""
        return ndarray(self.items[:], self.shape)

    def reshape(self, *shape: Any) -> ndarray:
        """Return the elements in another shape; one length may be -1."""
        wanted = tuple(shape[0]) if len(shape) == 1 and not isinstance(shape[0], int) else shape
        size = math.prod(n for n in wanted if n != -1)
        return ndarray(self.items, tuple(len(self.items) // max(size, 1) if n == -1 else n for n in wanted))

    def __getitem__(self, key: Any) -> Any:
        places, shape = _places(self.shape, key)
        if shape is None:
            return self.items[places[0]]
        return ndarray([self.items[k] for k in places], shape)

    def __setitem__(self, key: Any, value: Any) -> None:
        places, shape = _places(self.shape, key)
        for k, item in zip(places, broadcast_to(value, shape or ()).items, strict=True):
            self.items[k] = item

    def reduced(self, function: Callable[[list[Any]], Any], axis: int | None) -> Any:
        """Return what a function of elements gives, of all of them or along an axis."""
        if axis is None:
            return function(self.items)
        axis %= len(self.shape)
        count, inner = self.shape[axis], math.prod(self.shape[axis + 1 :])
        starts = (k * count * inner + j for k in range(math.prod(self.shape[:axis])) for j in range(inner))
        results = [function(self.items[k : k + count * inner : inner][:count]) for k in starts]
        return ndarray(results, self.shape[:axis] + self.shape[axis + 1 :])

    def sum(self, axis: int | None = None) -> Any:
        """Return the sum."""
        return self.reduced(sum, axis)

    def mean(self) -> float:
        """Return the mean of all elements."""
        return float(sum(self.items)) / len(self.items)

    def all(self, axis: int | None = None) -> Any:
        """Return whether all elements are true."""
        return self.reduced(all, axis)

    def any(self, axis: int | None = None) -> Any:
        """Return whether some element is true."""
        return self.reduced(any, axis)

    def min(self, axis: int | None = None, *, initial: float | None = None) -> Any:
        """Return the least element; NaN where there is one."""
        return self.reduced(folded(smaller, initial), axis)

    def max(self, axis: int | None = None, *, initial: float | None = None) -> Any:
        """Return the largest element; NaN where there is one."""
        return self.reduced(folded(larger, initial), axis)

    def argmax(self, axis: int | None = None) -> Any:
        """Return the place of the first largest element; of the first NaN where there is one."""
        return self.reduced(lambda row: max(range(len(row)), key=lambda k: (row[k] != row[k], row[k])), axis)


def smaller(x: Any, y: Any) -> Any:
    """Return the smaller of two numbers; NaN where one is."""
    return x if x <= y or x != x else y


def larger(x: Any, y: Any) -> Any:
    """Return the larger of two numbers; NaN where one is."""
    return x if x >= y or x != x else y


def folded(function: Callable[[Any, Any], Any], initial: float | None = None) -> Callable[[list[Any]], Any]:
    """Return a function of two numbers as one of a list."""

    def fold(row: list[Any]) -> Any:
        elements = chain(row, () if initial is None else (initial,))
        result = next(elements)
        for x in elements:
            result = function(result, x)
        return result

    return fold


def _places(shape: Shape, key: Any) -> tuple[list[int], Shape | None]:
    """Return where the elements stand that a key takes, and their shape; None for a single one."""
    keys = list(key) if isinstance(key, tuple) else [key]
    if any(k is Ellipsis for k in keys):
        at = next(i for i, k in enumerate(keys) if k is Ellipsis)
        keys[at : at + 1] = [slice(None)] * (len(shape) - sum(k is not None for k in keys) + 1)
    keys += [slice(None)] * (len(shape) - sum(k is not None for k in keys))
    strides = [math.prod(shape[k + 1 :]) for k in range(len(shape))]
    lists = [asarray(k) for k in keys if isinstance(k, ndarray | list) and len(asarray(k).shape)]
    pairs = len(lists) > 1
    if any(len(along.shape) > 1 or (pairs and (_is_mask(along.items) or len(lists) < len(keys))) for along in lists):
        raise lacking()
    if pairs:  # one element for each of them
        rows = [_within(along.items, count) for along, count in zip(lists, shape, strict=True)]
        return [sum(map(operator.mul, row, strides)) for row in zip(*rows, strict=True)], (len(rows[0]),)
    indices: list[Sequence[int]] = []
    counts: list[int] = []
    axis = 0
    for k in keys:
        if k is None:
            counts.append(1)
            continue
        count, stride = shape[axis], strides[axis]
        axis += 1
        if isinstance(k, slice):
            along: Iterable[int] = range(*k.indices(count))
        elif isinstance(k, ndarray | list) and len(asarray(k).shape):
            items = asarray(k).items
            along = (n for n, is_in in enumerate(items) if is_in) if _is_mask(items) else items
        else:
            indices.append([range(count)[operator.index(k)] * stride])
            continue
        indices.append([n * stride for n in _within(along, count)])
        counts.append(len(indices[-1]))
    places = [sum(row) for row in product(*indices)] if len(indices) != 1 else list(indices[0])
    return places, tuple(counts) if counts or not shape else None


def _within(places: Iterable[int], count: int) -> list[int]:
    """Return places along an axis; negative ones count from its end, and one beyond it is an `IndexError`."""
    axis = range(count)
    return [axis[n] for n in places]


def _is_mask(items: list[Any]) -> bool:
    return bool(items) and isinstance(items[0], bool)


def array(value: Any, dtype: Any = None) -> ndarray:
    """Return nested sequences, arrays or a number as an array of its own."""
    result = _array(value)
    return ndarray(result.items[:] if dtype is None else [dtype(x) for x in result.items], result.shape)


def _array(value: Any) -> ndarray:
    if isinstance(value, ndarray):
        return value
    if not isinstance(value, list | tuple):
        return ndarray([value], ())
    if not any(isinstance(part, list | tuple | ndarray) for part in value):
        return ndarray(list(value), (len(value),))
    parts = [_array(part) for part in value]
    assert len({p.shape for p in parts}) == 1, "rows differ in length"
    return ndarray([x for p in parts for x in p.items], (len(parts), *parts[0].shape))


def asarray(value: Any, dtype: Any = None) -> ndarray:
    """Return an array as it is, and anything else as an array."""
    return _array(value) if dtype is None else array(value, dtype)


def broadcast_shapes(*shapes: Shape) -> Shape:
    """Return the shape that arrays of some shapes have together."""
    count = max(map(len, shapes), default=0)
    lengths = [{n for s in shapes for n in s[-k : len(s) - k + 1] if n != 1} for k in range(count, 0, -1)]
    if any(len(sizes) > 1 for sizes in lengths):
        raise ValueError(f"shapes do not fit: {shapes}")
    return tuple(sizes.pop() if sizes else 1 for sizes in lengths)


def broadcast_to(a: Any, shape: int | Shape) -> ndarray:
    """Return an array in a larger shape, its elements repeated."""
    source, wanted = asarray(a), (shape,) if isinstance(shape, int) else tuple(shape)
    if source.shape == wanted:
        return source
    if len(source.items) == 1 or 0 in wanted:
        return ndarray(source.items * math.prod(wanted), wanted)
    padded = (1,) * (len(wanted) - len(source.shape)) + source.shape
    items, inner = source.items, 1
    for have, want in zip(reversed(padded), reversed(wanted), strict=True):
        if have != want:
            if have != 1:
                raise ValueError(f"{source.shape} does not fit {wanted}")
            items = [x for k in range(0, len(items), inner) for x in items[k : k + inner] * want]
        inner *= want
    return ndarray(items, wanted)


def broadcast_arrays(*arrays: Any) -> tuple[ndarray, ...]:
    """Return arrays in the shape that they have together."""
    items = [asarray(a) for a in arrays]
    shape = broadcast_shapes(*(a.shape for a in items))
    return tuple(broadcast_to(a, shape) for a in items)
