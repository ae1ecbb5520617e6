"""Where over two inputs a rule is the most active one, and how that region is marked in a picture of the surface."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fuzzyctl.kernels.compile import compile as compile_system
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.plot.style import COLORS
from fuzzyctl.plot.surfaces import Sampled, grid_points


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
        # A border of its own on the edge of the map, where the region ends, too.
        leads = np.pad(leads, 1, constant_values=-1e-9)
        x, y = (np.pad(g, 1, mode="edge") for g in grids)
        ax.contour(x, y, leads, levels=[0.0], colors=COLORS[1], linewidths=2.5)
