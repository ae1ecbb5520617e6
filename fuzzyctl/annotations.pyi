"""Types of arguments and results, for checkers and editors only: nothing here exists at run time.

No checker reads from a file how many outputs a system has. So the result of a call has one type, which
serves as the value of one output and as the values of several: see docs/explanation/types.md.
"""

from collections.abc import ItemsView, Iterator, KeysView, Mapping, Sequence, ValuesView
from typing import Any, Literal, Protocol, SupportsIndex, overload

import numpy as np
import numpy.typing as npt
import pandas as pd
from matplotlib.axes import Axes as Axes

from fuzzyctl.kernels.kernel import Kernel
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
#: What derivatives are taken by.
By = Literal["inputs", "state", "all"]
#: Points of shape (..., inputs), or columns by the names of the inputs.
Points = Numbers | Mapping[str, Numbers]

#: The state of a block: numbers; of a system with free numbers also values by name.
State = Numbers | Mapping[str, Numbers]

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

class SystemKernel(Kernel):
    """The kernel of a system: a call gives the outputs."""

    def __call__(self, *arguments: Scalar | State, **named: Scalar | State | None) -> Outputs: ...
    @overload
    def batch(
        self,
        points: Frames,
        state: State | Frames | None = None,
        *,
        dt: Numbers | None = None,
        out: None = None,
        parallel: bool = True,
    ) -> Labelled: ...
    @overload
    def batch(
        self,
        points: Points | Frames,
        state: State | Frames | None = None,
        *,
        dt: Numbers | None = None,
        out: FloatArray | None = None,
        parallel: bool = True,
    ) -> FloatArray: ...
    @overload
    def run(
        self, points: Frames, state: State | None = None, *, dt: Numbers | None = None
    ) -> tuple[Labelled, FloatArray]: ...
    @overload
    def run(
        self, points: Points, state: State | None = None, *, dt: Numbers | None = None
    ) -> tuple[FloatArray, FloatArray]: ...
    @overload
    def degrees(self, points: Frames, state: State | None = None) -> dict[str, dict[str, pd.Series[float]]]: ...
    @overload
    def degrees(self, points: Points, state: State | None = None) -> dict[str, dict[str, FloatArray]]: ...
    @overload
    def strengths(self, points: Frames, state: State | None = None) -> pd.DataFrame: ...
    @overload
    def strengths(self, points: Points, state: State | None = None) -> FloatArray: ...
    @overload
    def gradient(
        self, points: Frames, state: State | None = None, *, dt: Numbers | None = None, by: By = "inputs"
    ) -> pd.DataFrame | FloatArray: ...
    @overload
    def gradient(
        self, points: Points, state: State | None = None, *, dt: Numbers | None = None, by: By = "inputs"
    ) -> FloatArray: ...

class ControllerKernel(Kernel):
    """The kernel of a controller: a call makes a step, and gives the outputs and the next state."""

    def __call__(self, *arguments: Scalar | State, **named: Scalar | State | None) -> tuple[Outputs, FloatArray]: ...
    @overload
    def batch(
        self, points: Frame, state: Frame, *, dt: Numbers | None = None, out: None = None, parallel: bool = True
    ) -> tuple[Labelled, pd.DataFrame]: ...
    @overload
    def batch(
        self,
        points: Frame,
        state: Numbers | None = None,
        *,
        dt: Numbers | None = None,
        out: None = None,
        parallel: bool = True,
    ) -> tuple[Labelled, FloatArray]: ...
    @overload
    def batch(
        self,
        points: Points | Frames,
        state: State | Frames | None = None,
        *,
        dt: Numbers | None = None,
        out: FloatArray | None = None,
        parallel: bool = True,
    ) -> tuple[FloatArray, FloatArray]: ...
    @overload
    def run(
        self, points: Frames, state: State | None = None, *, dt: Numbers | None = None
    ) -> tuple[Labelled, FloatArray]: ...
    @overload
    def run(
        self, points: Points, state: State | None = None, *, dt: Numbers | None = None
    ) -> tuple[FloatArray, FloatArray]: ...
    def gradient(
        self, points: Points | Frames, state: State | None = None, *, dt: Numbers | None = None, by: By = "inputs"
    ) -> tuple[FloatArray, FloatArray]: ...
