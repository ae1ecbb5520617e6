"""Plot of an output over one or two inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.ticker import MaxNLocator

from fuzzyctl.kernels.compile import compile as compile_system
from fuzzyctl.kernels.kernel import Kernel
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.plot.style import COLORS


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
    grids, points = grid(system, axes, fixed, resolution)
    kernel = compile_system(system, backend="numpy")
    values = kernel.batch(points, _initial(kernel, points))
    if len(system.outputs) > 1:
        values = values[..., [o.name for o in system.outputs].index(output)]
    return grids, values


def grid(
    system: FuzzySystem, axes: Sequence[str], fixed: Mapping[str, float], resolution: int
) -> tuple[list[Any], Any]:
    """Return the grid of each axis, and its points with all inputs, shape (resolution, ..., inputs); see `sample`."""
    grids = [_range(system, name, resolution) for name in axes]
    mesh = dict(zip(axes, np.meshgrid(*grids), strict=True))
    shape = next(iter(mesh.values())).shape
    columns = []
    for variable in system.inputs:
        middle = (system.number(variable.lower) + system.number(variable.upper)) / 2
        column = mesh.get(variable.name)
        columns.append(column if column is not None else np.full(shape, fixed.get(variable.name, middle)))
    return grids, np.stack(columns, axis=-1)


def _initial(kernel: Kernel, points: Any) -> Any:
    """Return the initial state at each point: a grid is no sequence, and nothing is held from one point to the next."""
    return np.broadcast_to(kernel.initial_state(), (*points.shape[:-1], kernel.n_states)) if kernel.n_states else None


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
    kernel = compile_system(system, backend="numpy")
    return kernel.strengths(points, _initial(kernel, points))


def draw_surface(
    figure: Any,
    system: FuzzySystem,
    axes: Sequence[str],
    fixed: Mapping[str, float],
    output: str,
    resolution: int,
) -> None:
    """Draw an output: a curve over one input; over two inputs a surface and the same as a map.

    Args:
        figure: An empty matplotlib figure.
        system: The system.
        axes: Names of one or two inputs.
        fixed: Values of other inputs.
        output: Name of the output.
        resolution: Points along each axis.
    """
    grids, values = sample(system, axes, fixed, output, resolution)
    label = system.output(output).axis_label
    names = [system.input(name).axis_label for name in axes]
    if len(axes) == 1:
        figure.set_size_inches(6.4, 4)
        ax = figure.subplots()
        ax.plot(grids[0], values, color=COLORS[0])
        ax.set(xlabel=names[0], ylabel=label, xlim=(grids[0][0], grids[0][-1]))
        ax.set_title(_title(system, axes, fixed))
        return
    figure.set_size_inches(11, 4.8)
    figure.suptitle(_title(system, axes, fixed))
    left = figure.add_subplot(1, 2, 1, projection="3d")
    x, y = np.meshgrid(*grids)
    stride = max(1, resolution // 60)
    left.plot_surface(x, y, values, cmap="viridis", rstride=stride, cstride=stride, lw=0.2, edgecolor=(0, 0, 0, 0.25))
    left.set_xlabel(names[0], labelpad=10)
    left.set_ylabel(names[1], labelpad=10)
    left.zaxis.set_rotate_label(False)
    left.set_zlabel(label, labelpad=8, rotation=90)
    left.tick_params(labelsize="small", pad=1)
    for axis in (left.xaxis, left.yaxis, left.zaxis):
        axis.set_major_locator(MaxNLocator(5))
    left.view_init(elev=28, azim=-125)
    left.set_box_aspect(None, zoom=0.8)
    right = figure.add_subplot(1, 2, 2)
    filled = right.contourf(x, y, values, levels=21, cmap="viridis")
    right.contour(x, y, values, levels=10, colors="k", linewidths=0.4, alpha=0.5, linestyles="solid")
    right.grid(False)
    right.set(xlabel=names[0], ylabel=names[1])
    figure.colorbar(filled, ax=right, label=label)


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
        # A border of its own on the edge of the map, where the region ends, too.
        leads = np.pad(leads, 1, constant_values=-1e-9)
        x, y = (np.pad(g, 1, mode="edge") for g in grids)
        ax.contour(x, y, leads, levels=[0.0], colors=COLORS[1], linewidths=2.5)


def _range(system: FuzzySystem, name: str, resolution: int) -> Any:
    variable = system.input(name)
    return np.linspace(system.number(variable.lower), system.number(variable.upper), resolution)


def _title(system: FuzzySystem, axes: Sequence[str], fixed: Mapping[str, float]) -> str:
    held = []
    for variable in system.inputs:
        if variable.name not in axes:
            middle = (system.number(variable.lower) + system.number(variable.upper)) / 2
            held.append(f"{variable.title} = {fixed.get(variable.name, middle):.4g}")
    title = system.title or system.name
    return f"{title}  ({', '.join(held)})" if held else title
