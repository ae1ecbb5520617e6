"""Types of arguments and results, for checkers and editors only: nothing here exists at run time.

No checker reads from a file how many outputs a system has. So the result of a call has one type, which
serves as the value of one output and as the values of several: see docs/explanation/types.md.
"""

from collections.abc import ItemsView, Iterator, KeysView, Mapping, Sequence, ValuesView
from typing import Any, Protocol, SupportsIndex, overload

import numpy as np
import numpy.typing as npt
import pandas as pd
from matplotlib.axes import Axes as Axes

from fuzzyctl.plot.figures import Panels as Panels

FloatArray = npt.NDArray[np.float64]
#: One real number.
Scalar = float | np.floating[Any] | np.integer[Any]

class Array(Protocol):
    """An array of numpy, or what converts itself into one."""

    def __array__(self) -> npt.NDArray[Any]: ...

#: Numbers along one axis.
Vector = Array | Sequence[Scalar]
#: One number, or numbers of any shape; lists have at most two axes.
Numbers = Scalar | Vector | Sequence[Sequence[Scalar] | Array]
#: Points of shape (..., inputs), or columns by the names of the inputs.
Points = Numbers | Mapping[str, Numbers]

class Column(Protocol):
    """A Series of pandas."""

    @property
    def iloc(self) -> Any: ...
    @property
    def index(self) -> Any: ...

class Frame(Column, Protocol):
    """A DataFrame of pandas."""

    @property
    def columns(self) -> Any: ...

#: Points with row labels.
Frames = Frame | Mapping[str, Column]
#: What they give: a Series for one output, a DataFrame for several.
Labelled = pd.Series[float] | pd.DataFrame

class Outputs(float):
    """Outputs at one point: a float for one output, a tuple of floats for several."""

    def __iter__(self) -> Iterator[float]: ...
    def __len__(self) -> int: ...
    @overload
    def __getitem__(self, position: SupportsIndex) -> float: ...
    @overload
    def __getitem__(self, position: slice) -> tuple[float, ...]: ...

class NamedOutputs(float, Mapping[str, float]):
    """Outputs at one point: a float for one output, a dict of floats by name for several."""

    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    def __getitem__(self, output: str) -> float: ...

class NamedArrays(np.ndarray[Any, np.dtype[np.float64]]):
    """Outputs at many points: an array for one output, a dict of arrays by name for several."""

    @overload  # type: ignore[override]
    def __getitem__(self, output: str) -> FloatArray: ...
    @overload
    def __getitem__(self, points: npt.NDArray[Any] | slice | tuple[Any, ...] | list[int]) -> FloatArray: ...
    @overload
    def __getitem__(self, point: SupportsIndex) -> Any: ...
    def keys(self) -> KeysView[str]: ...
    def values(self) -> ValuesView[FloatArray]: ...
    def items(self) -> ItemsView[str, FloatArray]: ...

class NamedColumns(pd.Series[float]):
    """Outputs at many points: a Series for one output, a dict of Series by name for several."""

    def __getitem__(self, output: Any) -> Any: ...
    def items(self) -> ItemsView[str, pd.Series[float]]: ...
