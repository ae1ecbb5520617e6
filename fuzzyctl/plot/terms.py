"""Draws the terms of linguistic variables."""

from __future__ import annotations

from typing import Any

import numpy as np

from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.kernels.compile import degrees
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable
from fuzzyctl.plot.style import COLORS


def draw_terms(figure: Any, system: FuzzySystem) -> None:
    """Draw one panel for each variable: degrees of its terms over its universe.

    Args:
        figure: An empty matplotlib figure.
        system: The system to draw.
    """
    variables = [*system.inputs, *system.outputs]
    figure.set_size_inches(7.5, 2.2 * len(variables) + 0.4)
    axes = figure.subplots(len(variables), 1, squeeze=False)[:, 0]
    for ax, variable in zip(axes, variables, strict=True):
        draw_variable(ax, system, variable)
    figure.suptitle(system.title or system.name)


def draw_variable(ax: Any, system: FuzzySystem, variable: LinguisticVariable) -> Any:
    """Draw the terms of one variable into axes and return the axes."""
    low, high = system.number(variable.lower), system.number(variable.upper)
    x = _grid(system, variable, low, high)
    for i, term in enumerate(variable.terms):
        color = COLORS[i % len(COLORS)]
        y = degrees(system, variable, term, x)
        if y is None:
            continue  # a function of the inputs has no picture over the output's range
        if term.membership.kind in ("singleton", "constant"):
            at = system.number(term.membership.arguments[0])
            ax.vlines(at, 0, 1, color=color, lw=2)
        else:
            at = _top(x, y)
            ax.plot(x, y, color=color)
            ax.fill_between(x, y, color=color, alpha=0.08, lw=0)
        # At the ends of the axis a centred name would stand on the tick labels or outside.
        side = "left" if at <= low else "right" if at >= high else "center"
        height = 1.0 if term.membership.kind in ("singleton", "constant") else float(np.max(y))
        offset = (0, 3)
        ax.annotate(term.name, (at, height), offset, textcoords="offset points", ha=side, color=color)
    ax.set(xlim=(low, high), ylim=(0, 1.18), xlabel=variable.axis_label, ylabel="degree", yticks=[0, 0.5, 1])
    return ax


def _top(x: Any, y: Any) -> float:
    """Return the middle of where a term is highest."""
    highest = x[y >= np.max(y) - 1e-12]
    return float((highest[0] + highest[-1]) / 2)


def _grid(system: FuzzySystem, variable: LinguisticVariable, low: float, high: float) -> Any:
    """Return points that include every corner, so that peaks are drawn at their full height."""
    corners = [low, high]
    for term in variable.terms:
        if term.membership.kind not in MEMBERSHIP:
            continue
        numbers = tuple(system.number(a) for a in term.membership.arguments)
        corners.extend(x for x, _ in MEMBERSHIP[term.membership.kind].vertices(numbers) if low <= x <= high)
    beside = [np.nextafter(c, d) for c in corners for d in (-np.inf, np.inf)]
    points = np.unique(np.concatenate([np.linspace(low, high, 401), corners, beside]))
    return points[(points >= low) & (points <= high)]
