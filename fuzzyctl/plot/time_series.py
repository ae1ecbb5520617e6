"""Picture of runs: references and outputs, controls and disturbances over time, in panels below each other."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.axes import Axes

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.plot import limits
from fuzzyctl.plot.figures import Panels, place, sized, styled
from fuzzyctl.plot.figures import panels as panels_of
from fuzzyctl.plot.memberships import shortened
from fuzzyctl.plot.style import COLORS
from fuzzyctl.simulation.panels import Panel, panels
from fuzzyctl.simulation.run import Run
from fuzzyctl.support import arguments

if TYPE_CHECKING:
    from fuzzyctl.simulation.members import Tube

#: Most panels of a picture, and points of a line: at most twice as many.
MOST: Final = 8
POINTS: Final = 20_000
#: Colour of references and disturbances.
GIVEN: Final = "#444444"
#: Colour of the band that holds all members.
TUBE: Final = "#2ca02c"
#: Width of the picture, height of a panel, and the rest [inches].
WIDTH: Final = 8.0
PANEL: Final = 1.6
REST: Final = 1.1
#: Letters of a line of a remark below a panel.
LETTERS: Final = 120
#: Letters of a line of the label of a panel, which is as high as the panel.
LABEL: Final = 20


def runs(
    *runs: Run,
    labels: Sequence[str] | None = None,
    ax: Axes | None = None,
    tube: Tube | None = None,
    members: Sequence[Run] = (),
) -> Panels:
    """Draw runs over each other, one panel for each signal that the first run shows.

    Args:
        runs: One or more.
        labels: Their labels in the legend, one for each; None for the names of their loops.
        ax: Axes whose place the panels take; None for a new figure.
        tube: Bounds of outputs of plants over time, from `fuzzyctl.prove(loop).tube`, drawn as a band; None without.
        members: Further runs of the same family, drawn as thin lines.

    Returns:
        The axes from top to bottom, a tuple that a notebook shows as the picture.

    Raises:
        ArgumentError: For no run, another number of labels, arguments of another type, and axes that have no place in
            a grid.
    """
    if not runs:
        raise ArgumentError("at least one run must be given")
    for run in runs:
        arguments.instance("a run", Run, "a Run", run)
    called = [r.loop.name for r in runs] if labels is None else list(arguments.names("'labels'", labels))
    if len(called) != len(runs):
        raise ArgumentError(f"'labels' must have one label for each of {len(runs)} runs, got {len(called)}")
    with styled(ax):
        figure = place(ax)
        draw_runs(figure, runs, called, tube, members)
        return panels_of(figure)


def draw_runs(
    figure: Any,
    runs: Sequence[Run],
    labels: Sequence[str],
    tube: Tube | None = None,
    members: Sequence[Run] = (),
) -> None:
    """Draw runs over each other; a run that was stopped ends in a cross.

    Args:
        figure: An empty matplotlib figure, or a part of one.
        runs: The runs, in the panels that any of them has.
        labels: Their labels in the legend, one for each.
        tube: Bounds of signals over time, drawn as a band, or None.
        members: Further runs, drawn as thin lines.
    """
    by_run = [{p.signal: p for p in panels(run.loop, run.positions)} for run in runs]
    first = {name: p for group in reversed(by_run) for name, p in group.items()}  # of a signal of several runs
    names = dict.fromkeys(name for group in by_run for name in group)
    rows = sorted((first[name] for name in names), key=lambda p: (p.given, p.held))[:MOST]
    sized(figure, WIDTH, REST + PANEL * max(len(rows), 1))
    axes = np.atleast_1d(figure.subplots(max(len(rows), 1), 1, sharex=True))
    for ax, panel in zip(axes, rows, strict=False):
        having = {k: group[panel.signal] for k, group in enumerate(by_run) if panel.signal in group}
        behind = _draw_family(ax, panel, tube, members)
        if panel.given:
            _draw_given(ax, runs, {k: runs[k][panel.signal] for k in having}, {"lw": 1.4})
        else:
            for k in having:
                _draw_signal(ax, runs[k], panel, COLORS[k % len(COLORS)], labels[k])
        references = {k: runs[k].signal(p.reference) for k, p in having.items() if p.reference is not None}
        _draw_given(ax, runs, references, {"lw": 1.0, "ls": "--", "zorder": 1.5, "label": "reference"})
        ax.set_ylabel(textwrap.fill(panel.label, LABEL))
        ax.margins(x=0, y=0.08)
        names_of_lines = {k: labels[k] if len(having) > 1 else panel.label for k in having}
        lines = [limits.Line(names_of_lines[k], runs[k].t, np.asarray(runs[k][panel.signal])) for k in having] + behind
        _cut_peaks(ax, [*lines, *(limits.Line("reference", runs[k].t, v) for k, v in references.items())])
    figure.align_ylabels(axes)
    axes[-1].set_xlabel("\n".join(filter(None, ("time [s]", axes[-1].get_xlabel()))))
    titles = {run.loop.title or run.loop.name for run in runs}
    if len(titles) == 1:
        axes[0].set_title(*titles)
    _legend(figure, axes)


def _draw_signal(ax: Any, run: Run, panel: Panel, color: str, label: str) -> None:
    style = {"drawstyle": "steps-post"} if panel.held else {}
    stopped = run.stopped is not None
    ax.plot(*_drawn(run, run[panel.signal]), color=color, lw=1.4, label=label + ", stopped" * stopped, **style)
    if stopped and len(run):
        ax.plot(run.t[-1:], run[panel.signal][-1:], color=color, marker="x", clip_on=False)


def _draw_family(ax: Any, panel: Panel, tube: Tube | None, members: Sequence[Run]) -> list[limits.Line]:
    """Draw the bounds of a signal and its runs by other members; return the lines."""
    lines, signal = [], panel.signal
    style: dict[str, Any] = {"color": GIVEN, "lw": 0.5, "alpha": 0.5, "zorder": 1.2}
    style |= {"drawstyle": "steps-post"} if panel.held else {}
    for k, run in enumerate(r for r in members if signal in r.positions):
        ax.plot(*_drawn(run, run[signal]), label="" if k else "members", **style)
        lines.append(limits.Line("a member", run.t, np.asarray(run[signal])))
    if tube is not None and signal in tube.bounds:
        # The bounds of a stretch are sides of a rectangle, not points of a line.
        times = np.column_stack([tube.begin, tube.end]).ravel()
        low, high = (np.repeat(side, 2) for side in tube.bounds[signal])
        ax.fill_between(times, low, high, color=TUBE, alpha=0.25, lw=0, zorder=1.0, label="all members, proved")
        lines += [limits.Line("all members", times, side) for side in (low, high)]
    return lines


def _draw_given(ax: Any, runs: Sequence[Run], values: Mapping[int, Any], style: Mapping[str, Any]) -> None:
    """Draw the inputs of runs, by their positions: one line in grey where all have the same, else in their colours."""
    longest = max(values, key=lambda k: len(values[k]), default=0)
    alike = all(np.array_equal(v, values[longest][: len(v)]) for v in values.values())
    for k in [longest] if alike and values else values:
        ax.plot(*_drawn(runs[k], values[k]), color=GIVEN if alike else COLORS[k % len(COLORS)], **style)


def _cut_peaks(ax: Any, lines: Sequence[limits.Line]) -> None:
    """Limit the axis of a panel as a page does; a remark below it names the peaks that are cut off."""
    bounds = limits.of(lines)
    if bounds.note:
        ax.set_ylim(bounds.shown)
        ax.set_xlabel(textwrap.fill(bounds.note, LETTERS), fontsize="x-small")


def _legend(figure: Any, axes: Any) -> None:
    """Put one legend above the panels, where no line runs through it, if there is anything to tell apart."""
    handles = {label: line for ax in axes for line, label in zip(*ax.get_legend_handles_labels(), strict=True)}
    if len(handles) > 1:
        figure.legend(
            handles.values(), [shortened(n) for n in handles], loc="outside upper center", ncols=min(len(handles), 4),
            frameon=False,
        )  # fmt: skip


def _drawn(run: Run, values: Any) -> tuple[Any, Any]:
    """Return the points of a line; of a long run the least and greatest value of each stretch, and both ends."""
    stretch = 2 * (len(run) // POINTS)
    if stretch < 4:
        return run.t, values
    whole = len(values) // stretch * stretch
    stretches = np.asarray(values[:whole]).reshape(-1, stretch)
    begins = np.arange(0, whole, stretch)
    least, greatest = begins + stretches.argmin(axis=1), begins + stretches.argmax(axis=1)
    at = np.unique(np.concatenate([[0], least, greatest, np.arange(whole, len(values))]))
    return run.t[at], values[at]
