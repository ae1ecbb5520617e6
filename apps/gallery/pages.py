"""Pages of the gallery: the table of numbers and the picture of each, made from runs of its loops.

The folder NAME holds NAME.fz, the page README.md and the picture NAME.png. A published number is a line of the loop:

    require overshoot == 32 within 0.5

The table of the page is between the lines TABLE and END; between VERDICTS and END_OF_VERDICTS are the verdicts of
`fuzzyctl prove` on the claims about all members of a family. The line `<!-- drawn: LOOP LOOP -->` above the picture
names the loops that it shows; without it, it shows all. The lines

    <!-- panel: control [N] in [-2, 8] = first.u second.u -->
    <!-- lines: fixed gain, self-tuning -->

choose the panels, each with its label, its range if it is clipped and its signals, and names of the lines in place of
those of their loops. The line `<!-- path: x [m] = BLOCK.X, y [m] = BLOCK.Y -->` draws one signal over another one
instead of both over time.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from PIL import Image

from fuzzyctl import prove
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Compare, Name, evaluate
from fuzzyctl.loading.load import look_through
from fuzzyctl.model.block import Guarantee
from fuzzyctl.model.loop import Loop, Measure
from fuzzyctl.plot.style import COLORS, saved
from fuzzyctl.plot.time_series import GIVEN, REST, WIDTH, draw_runs
from fuzzyctl.plot.time_series import PANEL as PANEL_HEIGHT
from fuzzyctl.simulation.run import Run
from fuzzyctl.simulation.simulate import simulate
from fuzzyctl.support.files import read_source

HERE: Final = Path(__file__).parent
TABLE: Final = "<!-- table: python -m gallery -->"
END: Final = "<!-- end of table -->"
VERDICTS: Final = "<!-- verdicts: python -m gallery -->"
END_OF_VERDICTS: Final = "<!-- end of verdicts -->"
PROOFS: Final = re.compile(f"{re.escape(VERDICTS)}\n(.*?){re.escape(END_OF_VERDICTS)}", flags=re.DOTALL)
BLOCK: Final = re.compile(f"{re.escape(TABLE)}\n(.*?){re.escape(END)}", flags=re.DOTALL)
DRAWN: Final = re.compile(r"^<!-- drawn: (.+) -->$", flags=re.MULTILINE)
PANEL: Final = re.compile(r"^<!-- panel: ([^=]+?)(?: in \[(\S+), (\S+)\])? = (.+) -->$", flags=re.MULTILINE)
LINES: Final = re.compile(r"^<!-- lines: (.+) -->$", flags=re.MULTILINE)
PATH: Final = re.compile(r"^<!-- path: (.+) = (\S+), (.+) = (\S+) -->$", flags=re.MULTILINE)
#: Processor time for the claims of a loop [s].
SECONDS: Final = 30.0
#: Pixels per inch and colours of the pictures, which are small files.
DPI: Final = 120
COLOURS: Final = 64


def entries() -> dict[str, Path]:
    """Return the folders of the gallery by name."""
    return {path.parent.name: path.parent for path in sorted(HERE.glob("*/*.fz")) if path.stem == path.parent.name}


def loops_of(folder: Path) -> tuple[Loop, ...]:
    """Return the loops of a folder.

    Raises:
        DiagnosticError: With all errors and warnings of the file.
    """
    examined = look_through(read_source(folder / f"{folder.name}.fz"), folder=folder)
    if diagnostics := examined.reported(examined.diagnostics):
        raise DiagnosticError(diagnostics)
    return examined.loops


def table_of(runs: Sequence[Run]) -> str:
    """Return the Markdown table of runs: a row for each measure, a column for each loop, printed values in brackets."""
    measures = {m.name: m for run in runs for m in run.loop.measures}
    rows = [[_label(m), *(_cell(run, m.name) for run in runs)] for m in measures.values()]
    head = ["", *(_title(run) for run in runs)]
    return "".join(f"| {' | '.join(row)} |\n" for row in [head, ["---"] * len(head), *rows])


def verdicts_of(loops: Sequence[Loop]) -> str:
    """Return the Markdown table of the verdicts on claims about families: a row for each claim."""
    rows = [["loop", "family", "claim", "verdict"], ["---"] * 4]
    for loop in loops:
        number = loop.number
        ranges = [f"`{n}` in [{number(b.lower):g}, {number(b.upper):g}]" for n, b in loop.family.items()]
        for verdict in prove(loop, timeout=SECONDS) if loop.guarantees else ():
            word = type(verdict).__name__.lower()
            why = re.sub(r"\s+", " ", getattr(verdict, "reason", ""))
            title = loop.title or loop.name
            rows.append([title, ", ".join(ranges), f"`{verdict.claim}`", f"{word}: {why}" if why else word])
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def _title(run: Run) -> str:
    return run.loop.title or run.loop.name


def _label(measure: Measure) -> str:
    label = measure.label or measure.name.replace("_", " ")
    return f"{label} [{measure.unit}]" if measure.unit else label


def _cell(run: Run, measure: str) -> str:
    """Return the value of a measure, and the requirements on it in brackets: `32.3 (32 ± 1)`."""
    if measure not in run.measures:
        return ""
    claims = [g for g in run.loop.requirements if _measure_of(g) == measure]
    value, printed = run.measures[measure], ", ".join(_printed(run.loop, g) for g in claims)
    tolerance = min((_tolerance(run.loop, g) for g in claims), default=0.0)
    text = f"{value:.{max(0, 1 - math.floor(math.log10(tolerance)))}f}" if tolerance else f"{value:.4g}"
    return f"{text} ({printed})" if printed else text


def _measure_of(g: Guarantee) -> str:
    """Return the measure that a requirement compares with a number; none for other claims."""
    match g.claim:
        case Compare(left=Name(name=name)):
            return name
    return ""


def _tolerance(loop: Loop, g: Guarantee) -> float:
    return 0.0 if g.within is None else evaluate(g.within, loop.param_values.values)


def _printed(loop: Loop, g: Guarantee) -> str:
    assert isinstance(g.claim, Compare)
    labels = {m.name: m.label or m.name for m in loop.measures}
    sign = {"==": "", "<=": "≤ ", ">=": "≥ "}.get(g.claim.op, f"{g.claim.op} ")
    tolerance = f" ± {_tolerance(loop, g):.3g}" if g.within is not None else ""
    match g.claim.right:
        case Name(name=name) if name in labels:
            return f"{sign}{labels[name]}{tolerance}"
        case right:
            return f"{sign}{evaluate(right, loop.param_values.values):.10g}{tolerance}"


def remade(folder: Path) -> str:
    """Make the table and the picture of a page again, and say which requirements are not met."""
    page = folder / "README.md"
    text = page.read_text(encoding="utf-8")
    loops = loops_of(folder)
    runs = [simulate(loop) for loop in loops]
    text = BLOCK.sub(lambda _: f"{TABLE}\n{table_of(runs)}{END}", text)
    if PROOFS.search(text):
        text = PROOFS.sub(lambda _: f"{VERDICTS}\n{verdicts_of(loops)}{END_OF_VERDICTS}", text)
    page.write_text(text, encoding="utf-8")
    draw(folder / f"{folder.name}.png", runs, text)
    missed = [
        f"{run.loop.name}: {r.text}, {', '.join(r.facts)}" for run in runs for r in run.requirements if not r.holds
    ]
    return "\n  ".join([f"{folder.name}: {counted(len(runs), 'loop')}", *(f"not met: {m}" for m in missed)])


def draw(target: Path, runs: Sequence[Run], page: str) -> None:
    """Draw the runs that a page shows."""
    names = match[1].split() if (match := DRAWN.search(page)) else [run.loop.name for run in runs]
    selected = [run for name in names for run in runs if run.loop.name == name]
    several = len(selected) > 1  # one has its title above the panels
    with saved(target, DPI) as figure:
        if path := PATH.search(page):
            draw_path(figure, selected, path.groups())
        elif chosen := PANEL.findall(page):
            draw_panels(figure, selected, chosen, match[1].split(", ") if (match := LINES.search(page)) else ())
        else:
            draw_runs(figure, selected, [_title(run) if several else run.loop.name for run in selected])
            if several:
                figure.axes[0].set_title("")
    with Image.open(target) as picture:
        few = picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    few.save(target, optimize=True)


def draw_panels(figure: Any, runs: Sequence[Run], chosen: Sequence[Sequence[str]], lines: Sequence[str]) -> None:
    """Draw signals of runs over time, references and disturbances in grey.

    Args:
        figure: An empty figure.
        runs: The runs.
        chosen: Label, least and largest value or "", and signals of each panel.
        lines: Names of the signals of blocks, in the order of each panel; by default the titles of their loops.
    """
    figure.set_size_inches(WIDTH, REST + PANEL_HEIGHT * len(chosen))
    axes = figure.subplots(len(chosen), 1, sharex=True, squeeze=False)[:, 0]
    for ax, (label, low, high, signals) in zip(axes, chosen, strict=True):
        drawn = [(run, name) for run in runs for name in signals.split() if "." in name]
        titles = lines or [_title(run) for run, _ in drawn]
        for (run, name), title, color in zip(drawn, titles, COLORS, strict=False):
            ax.plot(run.t, run[name], color=color, lw=1.4, drawstyle="steps-post", label=title)
        for name in signals.split():
            if "." not in name:
                style = {"ls": "--", "label": "reference"} if drawn else {"ls": "-"}
                ax.plot(runs[0].t, runs[0][name], color=GIVEN, lw=1.0, **style)
        ax.margins(x=0, y=0.08)
        ax.set_ylabel(label)
        if low:
            ax.set_ylim(float(low), float(high))
    figure.align_ylabels(axes)
    axes[-1].set_xlabel("time [s]")
    handles, labels = axes[0].get_legend_handles_labels()
    if len(handles) > 1:
        figure.legend(handles, labels, loc="outside upper center", ncols=4, frameon=False)


def draw_path(figure: Any, runs: Sequence[Run], axes_of: Sequence[str]) -> None:
    """Draw a signal of runs over another one in the same scale, with a dot at each start.

    Args:
        figure: An empty figure.
        runs: The runs.
        axes_of: Label and signal of the horizontal axis, then those of the vertical one.
    """
    x_label, x, y_label, y = axes_of
    figure.set_size_inches(5, 6)
    axes = figure.subplots()
    for run, color in zip(runs, COLORS, strict=False):
        axes.plot(run[x], run[y], ".-", color=color, markersize=4, linewidth=1, label=_title(run))
        axes.plot(run[x][0], run[y][0], "o", color=color, markersize=7)
    axes.set(xlabel=x_label, ylabel=y_label)
    axes.set_aspect("equal", adjustable="datalim")
    axes.legend()
