"""Plot of an output over one or two inputs."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fuzzyctl.diagnostics.diagnostic import ArgumentError, UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.kernels.backends.arguments import input_number
from fuzzyctl.kernels.compile import compile as compile_block
from fuzzyctl.kernels.compile import compile as compile_system
from fuzzyctl.kernels.kernel import Kernel
from fuzzyctl.model.block import Block
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.plot.choices import chosen_axes
from fuzzyctl.plot.figures import finish, one, place, styled
from fuzzyctl.plot.style import COLORS
from fuzzyctl.support import arguments

if TYPE_CHECKING:
    from fuzzyctl.annotations import Column
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.system import FuzzySystem

#: Fewest and most points along an axis.
RESOLUTIONS: Final = (2, 2001)
#: Points along an axis in a notebook.
OVERVIEW: Final = 61
#: Width and height of a surface beside its map [inch], and the longest line of its title.
SIZE: Final = (11.0, 4.8)
LINE: Final = 100


@dataclass(frozen=True)
class Sampled:
    """A kernel to draw, with the labels of its variables.

    Args:
        kernel: Of numpy.
        title: Of the picture.
        labels: The label of each variable, by name.
        axis_labels: The same with the unit.
        ends: Of the range of each input.
        state: By name, at which it is drawn; None for the initial one.
    """

    kernel: Kernel
    title: str
    labels: Mapping[str, str]
    axis_labels: Mapping[str, str]
    ends: Mapping[str, tuple[float, float]]
    state: Mapping[str, float] | None = None

    @classmethod
    def of(cls, drawn: Block | Kernel, state: Mapping[str, float] | None = None) -> Sampled:
        """Return the samples of a block or a kernel; the kernel of a system knows the names of its variables only."""
        if isinstance(drawn, Kernel):
            names = {n: n for n in (*drawn.input_names, *drawn.output_names)}
            ends = {i.name: (i.lower, i.upper) for i in drawn.plan.inputs}
            return cls(Kernel(drawn.form, "numpy"), "", names, names, ends, state)
        block: Any = drawn
        variables = (*block.inputs, *block.outputs)
        kernel: Kernel = compile_block(block, backend="numpy")
        if kernel.form.needs_time:
            raise ArgumentError(f"controller '{drawn.name}' has no 'every' line: its outputs depend on 'dt', too")
        axis_labels = {v.name: v.axis_label for v in variables}
        ends = {v.name: drawn.range_of(v) for v in drawn.inputs}
        return cls(kernel, drawn.title or drawn.name, {v.name: v.title for v in variables}, axis_labels, ends, state)

    def range(self, name: str) -> tuple[float, float]:
        """Return the ends of an input.

        Raises:
            ArgumentError: For an input without a finite range.
        """
        low, high = self.ends[name]
        if not (math.isfinite(low) and math.isfinite(high)):
            raise ArgumentError(f"input {name!r} has no finite range to draw over; give it one, or a value")
        return low, high

    def middle(self, name: str) -> float:
        """Return the middle of the range of an input; 0 without a finite range."""
        middle = sum(self.ends[name]) / 2
        return middle if math.isfinite(middle) else 0.0


def surface(
    system: FuzzySystem | Controller | Kernel,
    x: str | None = None,
    y: str | None = None,
    *,
    output: str | None = None,
    at: Mapping[str, float] | Column | None = None,
    state: Mapping[str, float] | None = None,
    resolution: int = 61,
    ax: Axes | None = None,
) -> Axes:
    """Draw an output over one input, or over two.

    Args:
        system: A well-formed system, a controller, which makes one step, or the kernel of a system.
        x: Input along the first axis; None for the first that `at` leaves free.
        y: Input along the second axis; None for the next one. With `x` alone and `at`, or a system of one input, the
            picture is a curve.
        output: None for the first.
        at: Values of other inputs; those not named are at mid-range.
        state: Numbers of the state by name; None for those of the start.
        resolution: Points along each axis.
        ax: Axes to draw in: over two inputs a surface where they have three dimensions, else a map. None for new ones.

    Returns:
        The axes. Where the output has no finite value there is a hole.

    Raises:
        UnknownNameError: For a name of no input or output.
        ArgumentError: For an input named twice, and arguments of another type.
        ValueOutOfBoundsError: For a value that is NaN or too large for a float, and a resolution outside 2 to 2001.
        NoRuleFiresError: Where no rule fires for an output that says `else error`.
    """
    if not isinstance(system, Kernel | Block):
        raise arguments.wrong("the system", "a FuzzySystem, a Controller or a Kernel", system)
    drawn = Sampled.of(system, state)
    output = _known("output", drawn.kernel.output_names, output or drawn.kernel.output_names[0])
    fixed = _fixed(drawn, at)
    axes = _checked_axes(drawn, x, y, fixed)
    arguments.integer("'resolution'", resolution, *RESOLUTIONS)
    grids, values = _sample(drawn, axes, fixed, output, resolution)
    with styled(ax):
        target = one(ax, (6.4, 4.0) if len(axes) == 1 else (6.4, 5.0), solid=len(axes) == 2)
        _draw(target, drawn, axes, grids, values, output)
        target.set_title(_title(drawn, axes, fixed, 60))
        finish(target)
    return target


def overview(kernel: Kernel) -> Figure:
    """Return a figure of the first output of a kernel over its first inputs, the others at mid-range."""
    with styled(None):
        figure: Figure = place(None)
        draw_surface(figure, kernel, list(kernel.input_names[:2]), {}, kernel.output_names[0], OVERVIEW)
        finish(figure)
    return figure


def _known(kind: str, names: Sequence[str], name: object) -> str:
    if not isinstance(name, str):
        raise ArgumentError(f"the name of an {kind} must be a text, got {type(name).__name__}")
    if name not in names:
        raise UnknownNameError(kind, name, names)
    return name


def _fixed(drawn: Sampled, at: Mapping[str, float] | Column | None) -> dict[str, float]:
    numbers = {}
    for name, value in arguments.mapping("'at'", "numbers by name of the input", {} if at is None else at).items():
        _known("input", drawn.kernel.input_names, name)
        numbers[name] = number = input_number(name, value)
        if math.isnan(number):
            raise ValueOutOfBoundsError(f"input {name!r}", number, "a number that is not NaN")
    return numbers


def _checked_axes(drawn: Sampled, x: str | None, y: str | None, fixed: Mapping[str, float]) -> list[str]:
    names = drawn.kernel.input_names
    for name in (x, y):
        if name is not None:
            _known("input", names, name)
        if name in fixed:
            raise ArgumentError(f"{name!r} is an axis and has a value, too")
    if x is not None and x == y:
        raise ArgumentError(f"{x!r} is named for both axes")
    axes = chosen_axes(names, x, y, fixed)
    if axes[0] in fixed:
        raise ArgumentError("all inputs have values: leave one or two of them out of 'at'")
    return axes


def _draw(ax: Any, drawn: Sampled, axes: Sequence[str], grids: Sequence[Any], values: Any, output: str) -> None:
    """Draw a curve, a surface or a map, whichever the axes are for."""
    labels = [drawn.axis_labels[name] for name in (*axes, output)]
    if len(axes) == 1:
        _draw_curve(ax, grids[0], values, labels)
    elif ax.name == "3d":
        _draw_surface(ax, grids, values, labels)
    else:
        _draw_map(ax, grids, values, labels)
    if not np.isfinite(values).any():
        write = ax.text2D if ax.name == "3d" else ax.text
        write(0.5, 0.5, f"{labels[-1]} has no finite value here", transform=ax.transAxes, ha="center")


def _draw_curve(ax: Any, x: Any, values: Any, labels: Sequence[str]) -> None:
    ax.plot(x, values, color=COLORS[0])
    ax.set(xlabel=labels[0], ylabel=labels[1], xlim=(x[0], x[-1]))


def _draw_surface(ax: Any, grids: Sequence[Any], values: Any, labels: Sequence[str]) -> None:
    x, y = np.meshgrid(*grids)
    stride = max(1, len(grids[0]) // 60)
    if np.isfinite(values).any():
        edge = (0, 0, 0, 0.25)
        ax.plot_surface(x, y, values, cmap="viridis", rstride=stride, cstride=stride, lw=0.2, edgecolor=edge)
    ax.set_xlabel(labels[0], labelpad=10)
    ax.set_ylabel(labels[1], labelpad=10)
    ax.zaxis.set_rotate_label(False)
    ax.set_zlabel(labels[2], labelpad=8, rotation=90)
    ax.tick_params(labelsize="small", pad=1)
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_major_locator(MaxNLocator(5))
    ax.view_init(elev=28, azim=-125)
    ax.set_box_aspect(None, zoom=0.8)


def _draw_map(ax: Any, grids: Sequence[Any], values: Any, labels: Sequence[str]) -> None:
    x, y = np.meshgrid(*grids)
    ax.grid(False)
    ax.set(xlabel=labels[0], ylabel=labels[1])
    if np.isfinite(values).any():
        filled = ax.contourf(x, y, values, levels=21, cmap="viridis")
        ax.contour(x, y, values, levels=10, colors="k", linewidths=0.4, alpha=0.5, linestyles="solid")
        ax.figure.colorbar(filled, ax=ax, label=labels[2])


def sample(
    system: FuzzySystem, axes: Sequence[str], fixed: Mapping[str, float], output: str, resolution: int
) -> tuple[list[Any], Any]:
    """Evaluate an output over a grid.

    Args:
        system: The system.
        axes: Names of one or two inputs; the first varies along the last axis of the result (columns of a picture).
        fixed: Values of other inputs; those not named stand at mid-range.
        output: Name of the output.
        resolution: Points along each axis.

    Returns:
        The grid of each axis, shape (resolution,), and the values, shape (resolution,) or (resolution, resolution)
        with the second input along the first axis.
    """
    return _sample(Sampled.of(system), axes, fixed, output, resolution)


def grid_points(
    drawn: Sampled, axes: Sequence[str], fixed: Mapping[str, float], resolution: int
) -> tuple[list[Any], Any]:
    """Return the grid of each axis, and its points with all inputs, shape (resolution, ..., inputs)."""
    grids = [np.linspace(*drawn.range(name), resolution) for name in axes]
    mesh = dict(zip(axes, np.meshgrid(*grids), strict=True))
    shape = next(iter(mesh.values())).shape
    columns = []
    for name in drawn.kernel.input_names:
        column = mesh.get(name)
        columns.append(column if column is not None else np.full(shape, fixed.get(name, drawn.middle(name))))
    return grids, np.stack(columns, axis=-1)


def _sample(
    drawn: Sampled, axes: Sequence[str], fixed: Mapping[str, float], output: str, resolution: int
) -> tuple[list[Any], Any]:
    kernel = drawn.kernel
    grids, points = grid_points(drawn, axes, fixed, resolution)
    numbers = kernel.batch(points, drawn.state)
    values = numbers[0] if kernel.form.moves else numbers
    if len(kernel.output_names) > 1:
        values = values[..., kernel.output_names.index(output)]
    # An infinite value has no place in a picture.
    return grids, np.where(np.isfinite(values), values, np.nan)


def draw_surface(
    figure: Any,
    system: Block | Kernel | Sampled,
    axes: Sequence[str],
    fixed: Mapping[str, float],
    output: str,
    resolution: int,
    size: tuple[float, float] = SIZE,
) -> None:
    """Draw an output: a curve over one input; over two inputs a surface and the same as a map.

    Args:
        figure: An empty matplotlib figure.
        system: The system or controller, a kernel, or a `Sampled`.
        axes: Names of one or two inputs.
        fixed: Values of other inputs.
        output: Name of the output.
        resolution: Points along each axis.
        size: Width and height of the surface beside its map [inch].
    """
    drawn = system if isinstance(system, Sampled) else Sampled.of(system)
    grids, values = _sample(drawn, axes, fixed, output, resolution)
    title = _title(drawn, axes, fixed, int(LINE * size[0] / SIZE[0]))
    if len(axes) == 1:
        figure.set_size_inches(6.4, 4)
        ax = figure.subplots()
        _draw(ax, drawn, axes, grids, values, output)
        ax.set_title(title)
        return
    figure.set_size_inches(*size)
    figure.suptitle(title)
    for ax in (figure.add_subplot(1, 2, 1, projection="3d"), figure.add_subplot(1, 2, 2)):
        _draw(ax, drawn, axes, grids, values, output)


def _title(drawn: Sampled, axes: Sequence[str], fixed: Mapping[str, float], line: int) -> str:
    constants = []
    for name in drawn.kernel.input_names:
        if name not in axes:
            constants.append(f"{drawn.labels[name]} = {fixed.get(name, drawn.middle(name)):.4g}")
    if drawn.state is not None:
        start = zip(drawn.kernel.state_names, drawn.kernel.start().tolist(), strict=True)
        constants += [f"{n} = {drawn.state[n]:.4g}" for n, x in start if drawn.state[n] != x]
    title = f"{drawn.title}  ({', '.join(constants)})".strip() if constants else drawn.title
    return title if len(title) <= line else textwrap.fill(title, line)


def grid(
    system: FuzzySystem, axes: Sequence[str], fixed: Mapping[str, float], resolution: int
) -> tuple[list[Any], Any]:
    """Return the grid of each axis, and its points with all inputs, shape (resolution, ..., inputs)."""
    return grid_points(Sampled.of(system), axes, fixed, resolution)


def lead(system: FuzzySystem, output: str, rule: int, points: Any) -> Any:
    """Compute how far a rule is more active than any other rule of an output.

    Args:
        system: The system.
        output: Name of the output.
        rule: Position of the rule in `FuzzySystem.rules`; it concludes on the output.
        points: Shape (..., inputs).

    Returns:
        Shape (...,), above 0 where it is the strongest one.
    """
    strengths = rule_strengths(system, points)
    others = [r for r, _ in system.conclusions[output] if r != rule]
    return strengths[..., rule] - (np.max(strengths[..., others], axis=-1) if others else 0.0)


def rule_strengths(system: FuzzySystem, points: Any) -> Any:
    """Compute how far each rule is active, shape (..., rules), at points of shape (..., inputs)."""
    return compile_system(system, backend="numpy").strengths(points)


def mark_rule(ax: Any, grids: Sequence[Any], leads: Any) -> None:
    """Draw the border of where a rule is the strongest one into the map of a surface, or its range under a curve.

    Args:
        ax: Axes of the map or of the curve.
        grids: The grid of each axis.
        leads: From `lead`, over the grid.
    """
    if not (leads > 0).any():
        return
    if len(grids) == 1:
        ax.fill_between(grids[0], 0, 1, where=leads > 0, transform=ax.get_xaxis_transform(), color=COLORS[1], alpha=0.2)
    else:
        # A border on the edge of the map, where the region ends, too.
        leads = np.pad(leads, 1, constant_values=-1e-9)
        x, y = (np.pad(g, 1, mode="edge") for g in grids)
        ax.contour(x, y, leads, levels=[0.0], colors=COLORS[1], linewidths=2.5)
