"""Draws the rules that act at a point: degrees, consequents cut at the activations, and what comes out."""

from __future__ import annotations

from typing import Any

import numpy as np

from fuzzyctl.kernels.compile import degrees
from fuzzyctl.kernels.tracing import FiredRule, Trace
from fuzzyctl.model.rule import literals
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, LinguisticVariable, Output
from fuzzyctl.plot.style import COLORS

INPUT, OUTPUT, LINE = COLORS[0], COLORS[1], "#444444"


def draw_rules(figure: Any, system: FuzzySystem, found: Trace, most: int) -> None:
    """Draw one row for each rule that acts, one column for each variable, and the outputs below.

    Args:
        figure: An empty matplotlib figure.
        system: The system.
        found: What was traced.
        most: Most rules to draw, those of the highest activation.
    """
    rules = found.rules[:most]
    variables = [*system.inputs, *system.outputs]
    rows = len(rules) + 1
    figure.set_size_inches(2.3 * len(variables) + 0.6, 0.85 * rows + 0.9)
    axes = figure.subplots(rows, len(variables), squeeze=False)
    for row, rule in zip(axes, rules, strict=False):
        for ax, variable in zip(row, variables, strict=True):
            _cell(ax, system, found, rule, variable)
        row[0].set_ylabel(f"rule {rule.number}\n{rule.activation:.3g}", rotation=0, ha="right", va="center")
    axes[-1][0].set_ylabel("together", rotation=0, ha="right", va="center")
    for ax, variable in zip(axes[-1], variables, strict=True):
        _last_row(ax, system, found, rules, variable)
    for ax, variable in zip(axes[0], variables, strict=True):
        ax.set_title(variable.axis_label)
    point = ", ".join(f"{n} = {x:.6g}" for n, x in found.inputs.items())
    figure.suptitle(f"{system.title or system.name}\nat {point}")


def _frame(ax: Any, system: FuzzySystem, variable: LinguisticVariable, *, ticks: bool) -> Any:
    low, high = system.number(variable.lower), system.number(variable.upper)
    ax.set(xlim=(low, high), ylim=(0, 1.05), yticks=[])
    ax.locator_params(axis="x", nbins=4)
    if not ticks:
        ax.tick_params(labelbottom=False)
    return np.linspace(low, high, 401)


def _cell(ax: Any, system: FuzzySystem, found: Trace, rule: FiredRule, variable: LinguisticVariable) -> None:
    x = _frame(ax, system, variable, ticks=False)
    source = system.rules[rule.number - 1]
    named = [i.term for i in literals(source.antecedent) if i.variable == variable.name]
    for name in dict.fromkeys(named):
        term = variable.term(name)
        curve = None if term is None else degrees(system, variable, term, x)
        if curve is None:
            continue
        degree = found.degrees[variable.name][name]
        ax.plot(x, curve, color=INPUT, lw=1)
        ax.fill_between(x, np.minimum(curve, degree), color=INPUT, alpha=0.25, lw=0)
        _name(ax, name, INPUT)
    if named and isinstance(variable, Input):
        ax.axvline(found.inputs[variable.name], color=LINE, lw=0.8)
    for c in rule.contributions:
        if c.output == variable.name and isinstance(variable, Output):
            _consequent(ax, system, variable, x, rule.activation, c.term, c.value)
    if not named and all(c.output != variable.name for c in rule.contributions):
        ax.set_facecolor("#f4f4f4")


def _consequent(
    ax: Any, system: FuzzySystem, output: Output, x: Any, activation: float, name: str, value: float | None
) -> None:
    _name(ax, name, OUTPUT)
    if value is not None:
        ax.vlines(value, 0, activation, color=OUTPUT, lw=3)
        return
    term = output.term(name)
    curve = None if term is None else degrees(system, output, term, x)
    if curve is not None:
        ax.plot(x, curve, color=OUTPUT, lw=1)
        ax.fill_between(x, _implied(system, output, curve, activation), color=OUTPUT, alpha=0.35, lw=0)


def _name(ax: Any, name: str, color: str) -> None:
    box = {"boxstyle": "square,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.7}
    ax.annotate(name, (0.03, 0.8), xycoords="axes fraction", fontsize="small", color=color, bbox=box)


def _implied(system: FuzzySystem, output: Output, curve: Any, activation: float) -> Any:
    """Return a consequent set as its implication leaves it; other norms than the product are drawn as the minimum."""
    implication = output.implication or system.method.implication
    return curve * activation if implication == "product" else np.minimum(curve, activation)


def _last_row(
    ax: Any, system: FuzzySystem, found: Trace, rules: tuple[FiredRule, ...], variable: LinguisticVariable
) -> None:
    """Draw an input's value, or all consequents of an output together with what comes out."""
    x = _frame(ax, system, variable, ticks=True)
    if isinstance(variable, Input):
        ax.axvline(found.inputs[variable.name], color=LINE, lw=0.8)
        return
    assert isinstance(variable, Output)
    together = np.zeros_like(x)
    for rule in rules:
        for c in rule.contributions:
            if c.output != variable.name:
                continue
            term = variable.term(c.term)
            curve = None if term is None or c.value is not None else degrees(system, variable, term, x)
            if c.value is not None:
                ax.vlines(c.value, 0, rule.activation, color=OUTPUT, lw=3)
            elif curve is not None:
                together = np.maximum(together, _implied(system, variable, curve, rule.activation))
    ax.fill_between(x, together, color=OUTPUT, alpha=0.35, lw=0)
    value = found.outputs[variable.name]
    if np.isfinite(value):
        ax.axvline(value, color=LINE, lw=1.6)
        ax.annotate(f"{value:.4g}", (0.97, 0.72), xycoords="axes fraction", ha="right", fontsize="small", color=LINE)
