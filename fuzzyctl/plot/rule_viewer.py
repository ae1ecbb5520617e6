"""Plot of the rules that act at a point: degrees, clipped consequents, and the output."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.axes import Axes

from fuzzyctl.explain.block_trace import why
from fuzzyctl.explain.implied_sets import ImpliedSets, antecedent_set
from fuzzyctl.explain.trace import Contribution, FiredRule, Trace
from fuzzyctl.kernels.inference.defuzzify.sampling import sampled_degrees
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.model.rule import literals
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, LinguisticVariable
from fuzzyctl.plot.figures import Panels, panels, place, sized, styled
from fuzzyctl.plot.style import COLORS
from fuzzyctl.support import arguments

if TYPE_CHECKING:
    from fuzzyctl.annotations import Column

#: Most rules of a picture.
MOST: Final = 100
INPUT, OUTPUT, LINE = COLORS[0], COLORS[1], "#444444"


def rules(
    system: FuzzySystem,
    values: Mapping[str, float] | Column | None = None,
    /,
    *,
    most: int = 12,
    ax: Axes | None = None,
    **named: float,
) -> Panels:
    """Draw the rules that act at a point: one row for each, and the outputs below.

    Args:
        system: A well-formed system.
        values: A number for every input by name.
        most: Most rules to draw, those of the highest activation.
        ax: Axes whose place the panels take; None for a new figure.
        named: The same as `values`, for names that Python can write.

    Returns:
        The axes row by row, a tuple that a notebook shows as the picture.

    Raises:
        UnknownNameError: For a name that is not an input.
        ArgumentError: When an input is missing or no number, and for axes that have no place in a grid.
        ValueOutOfBoundsError: For fewer rules than one, or more than a picture has room for.
        NoRuleFiresError: Where no rule fires for an output that says `else error`.
    """
    return viewer(why(system, values, **named), most, ax)


def viewer(trace: Trace, most: int = 12, ax: Axes | None = None) -> Panels:
    """Draw a trace, see `rules`."""
    arguments.integer("'most'", most, 1, MOST)
    with styled(ax):
        figure = place(ax)
        draw_rules(figure, trace.system, trace, most)
        return panels(figure)


def draw_rules(figure: Any, system: FuzzySystem, trace: Trace, most: int) -> None:
    """Draw one row for each rule that acts, one column for each variable, and the outputs below.

    Args:
        figure: An empty matplotlib figure, or a part of one.
        system: The system.
        trace: The trace.
        most: Most rules to draw, those of the highest activation; all count in their common result.
    """
    rules = trace.rules[:most]
    columns = _columns(system, trace)
    rows = len(rules) + 1
    sized(figure, 2.3 * len(columns) + 0.6, 0.85 * rows + 0.9)
    axes = figure.subplots(rows, len(columns), squeeze=False)
    for row, rule in zip(axes, rules, strict=False):
        for ax, column in zip(row, columns, strict=True):
            _cell(ax, system, trace, rule, column)
        row[0].set_ylabel(f"rule {rule.number}\n{rule.activation:.3g}", rotation=0, ha="right", va="center")
    axes[-1][0].set_ylabel("together", rotation=0, ha="right", va="center")
    for ax, column in zip(axes[-1], columns, strict=True):
        _last_row(ax, trace, column)
    for ax, column in zip(axes[0], columns, strict=True):
        ax.set_title(column.variable.axis_label)
    point = ", ".join(f"{n} = {x:.6g}" for n, x in trace.inputs.items())
    figure.suptitle(f"{system.title or system.name}\nat {point}")


@dataclass(frozen=True)
class _Column:
    """A variable, the points of its range, the ends of its axis, and for an output the sets that rules leave there."""

    variable: LinguisticVariable
    x: tuple[float, ...]
    ends: tuple[float, float]
    sets: ImpliedSets | None


def _columns(system: FuzzySystem, trace: Trace) -> list[_Column]:
    plans = {o.name: o for o in plan(system).outputs}
    columns = []
    for variable in (*system.inputs, *system.outputs):
        low, high = system.number(variable.lower), system.number(variable.upper)
        if isinstance(variable, Input):
            ends = _with_room(low, high, [trace.inputs[variable.name]])
            columns.append(_Column(variable, _even(*(ends if variable.extrapolate else (low, high))), ends, None))
            continue
        x = _even(low, high)
        sets = ImpliedSets(plans[variable.name], x)
        columns.append(_Column(variable, x, _ends(variable, low, high, trace, sets), sets))
    return columns


def _even(low: float, high: float) -> tuple[float, ...]:
    return tuple(np.linspace(low, high, 401).tolist())


def _ends(
    variable: LinguisticVariable, low: float, high: float, trace: Trace, sets: ImpliedSets
) -> tuple[float, float]:
    """Return the ends of an output's axis: its range, and numbers beyond it, as sums and functions have them."""
    values = [value for value, _ in sets.crisp_values(_own(trace, variable))] if sets.has_crisp_values else []
    numbers = [c.value for rule in trace.rules for c in rule.contributions if c.output == variable.name]
    return _with_room(low, high, [*numbers, *values, trace.outputs[variable.name]])


def _with_room(low: float, high: float, numbers: Sequence[float | None]) -> tuple[float, float]:
    """Return the ends of an axis that holds a range and numbers beyond it."""
    beyond = [v for v in numbers if v is not None and np.isfinite(v) and not low <= v <= high]
    room = 0.05 * (max(high, *beyond) - min(low, *beyond)) if beyond else 0.0
    return min(low, *(v - room for v in beyond), low), max(high, *(v + room for v in beyond), high)


def _own(trace: Trace, output: LinguisticVariable) -> list[tuple[int, float, int]]:
    """Return the rules that leave something in an output: position, its effective activation, and which consequent."""
    return [
        (rule.number - 1, c.effective_activation, nth)
        for rule in trace.rules
        for nth, c in enumerate(c for c in rule.contributions if c.output == output.name)
        if c.value is None
    ]


def _frame(ax: Any, column: _Column, *, ticks: bool) -> None:
    ax.set(xlim=column.ends, ylim=(0, 1.05), yticks=[])
    ax.locator_params(axis="x", nbins=4)
    if not ticks:
        ax.tick_params(labelbottom=False)


def _cell(ax: Any, system: FuzzySystem, trace: Trace, rule: FiredRule, column: _Column) -> None:
    _frame(ax, column, ticks=False)
    variable = column.variable
    named = [i for i in literals(system.rules[rule.number - 1].antecedent) if i.variable == variable.name]
    value = _read_value(system, trace, variable)
    parts = [c for c in rule.contributions if c.output == variable.name]
    for part in dict.fromkeys(named):
        asked = antecedent_set(system, variable, part)
        if asked is None:
            continue
        curve = sampled_degrees(asked, column.x)
        ax.plot(column.x, curve, color=INPUT, lw=1)
        if value is not None:
            (degree,) = sampled_degrees(asked, [value])
            ax.fill_between(column.x, np.minimum(curve, degree), color=INPUT, alpha=0.25, lw=0)
    if named and isinstance(variable, Input):
        ax.axvline(trace.inputs[variable.name], color=LINE, lw=0.8)
    for nth, c in enumerate(parts):
        _consequent(ax, column, rule.number - 1, nth, c)
    names = [(" ".join((*p.hedges, p.term)), INPUT) for p in dict.fromkeys(named)]
    _names(ax, [*names, *((c.term, OUTPUT) for c in parts)])
    if not named and not parts:
        ax.set_facecolor("#f4f4f4")


def _read_value(system: FuzzySystem, trace: Trace, variable: LinguisticVariable) -> float | None:
    """Return the value whose degrees antecedents take; None where they take how far an output's terms are activated."""
    if isinstance(variable, Input):
        value, is_clamped = trace.inputs[variable.name], not variable.extrapolate
    elif system.method.semantics.chained == "degree":
        return None
    else:
        value, is_clamped = trace.outputs[variable.name], True
    low, high = system.number(variable.lower), system.number(variable.upper)
    return min(max(value, low), high) if is_clamped else value


def _consequent(ax: Any, column: _Column, rule: int, nth: int, contribution: Contribution) -> None:
    if contribution.value is not None:
        ax.vlines(contribution.value, 0, contribution.effective_activation, color=OUTPUT, lw=3)
        return
    assert column.sets is not None, "rules contribute to outputs only"
    if column.sets.has_crisp_values:
        _spikes(ax, column.sets.crisp_values([(rule, contribution.effective_activation, nth)]))
        if (shape := column.sets.consequent(rule, nth)) is not None and column.sets.output.inverts:
            ax.plot(column.x, shape, color=OUTPUT, lw=1)
        return
    curve, cut = column.sets.consequent(rule, nth), column.sets.implied(rule, contribution.effective_activation, nth)
    if curve is not None and cut is not None:
        ax.plot(column.x, curve, color=OUTPUT, lw=1)
        ax.fill_between(column.x, cut, color=OUTPUT, alpha=0.35, lw=0)


def _spikes(ax: Any, values: Sequence[tuple[float, float]]) -> None:
    """Draw crisp values as high as the activations applied to them."""
    for value, activation in values:
        ax.vlines(value, 0, activation, color=OUTPUT, lw=3)


def _names(ax: Any, names: Sequence[tuple[str, str]]) -> None:
    """Write names with their colours below each other, closer where there are many; at the end with more room."""
    if not names:
        return
    box = {"boxstyle": "square,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.7}
    size = "small" if len(names) < 3 else "xx-small"
    step = min(0.28, 0.8 / len(names))
    left, right = _crowded(ax, max(len(name) for name, _ in names), 0.75 - step * (len(names) - 1))
    place, side = (0.97, "right") if left > right else (0.03, "left")
    for k, (name, color) in enumerate(names):
        at = (place, 0.8 - k * step)
        ax.annotate(name, at, xycoords="axes fraction", ha=side, fontsize=size, color=color, bbox=box)


def _crowded(ax: Any, letters: int, height: float) -> tuple[int, int]:
    """Return the number of points of curves and lines behind names at the left end of the axes, and at the right end.

    Args:
        ax: The axes, with all that is drawn.
        letters: Of the longest name.
        height: Of the lower edge of the names, as a part of the axes.
    """
    lines = [line.get_xydata() for line in ax.lines]
    lines += [path.vertices for drawn in ax.collections for path in drawn.get_paths()]
    (low, high), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    places = [x for line in lines if len(line) for x, y in line if y >= bottom + height * (top - bottom)]
    room = (0.05 + 0.035 * letters) * (high - low)
    return sum(x <= low + room for x in places), sum(x >= high - room for x in places)


def _last_row(ax: Any, trace: Trace, column: _Column) -> None:
    """Draw an input's value, or all consequents of an output together with the result."""
    _frame(ax, column, ticks=True)
    name = column.variable.name
    if column.sets is None:
        ax.axvline(trace.inputs[name], color=LINE, lw=0.8)
        return
    contributions = [c for rule in trace.rules for c in rule.contributions if c.output == name]
    _spikes(ax, [(c.value, c.effective_activation) for c in contributions if c.value is not None])
    cuts = _own(trace, column.variable)
    if column.sets.has_crisp_values:
        _spikes(ax, column.sets.crisp_values(cuts))
    elif together := column.sets.together(cuts):
        _union(ax, column.x, together)
    value = trace.outputs[name]
    if np.isnan(value):
        ax.annotate("no value", (0.5, 0.45), xycoords="axes fraction", ha="center", fontsize="small", color=LINE)
    if np.isfinite(value):
        ax.axvline(value, color=LINE, lw=1.6)
        low, high = column.ends
        # Where its line does not run through it.
        place, side = (0.03, "left") if value > 0.5 * low + 0.5 * high else (0.97, "right")
        ax.annotate(f"{value:.4g}", (place, 0.72), xycoords="axes fraction", ha=side, fontsize="small", color=LINE)


def _union(ax: Any, x: Sequence[float], together: Sequence[float]) -> None:
    """Draw the union; a sum may be higher than 1."""
    ax.fill_between(x, together, color=OUTPUT, alpha=0.35, lw=0)
    ax.set_ylim(0, 1.05 * max(1.0, *together))
