"""Pages of the gallery: the table of numbers and the picture of each, made from runs of its loops.

The folder NAME holds NAME.fz, the page README.md and the picture NAME.png. What was printed is a line of the loop:

    require overshoot == 32 within 0.5

The table of the page stands between the lines TABLE and END. The line `<!-- drawn: LOOP LOOP -->` above the picture
names the loops that it shows; without it, it shows all. The line `<!-- path: BLOCK.X BLOCK.Y -->` draws one signal over
another one instead of both over time.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Compare, Name, evaluate
from fuzzyctl.loading.load import look_through
from fuzzyctl.model.guarantee import Guarantee
from fuzzyctl.model.loop import Loop, Measure
from fuzzyctl.plot.style import COLORS, saved
from fuzzyctl.plot.time_series import draw_runs
from fuzzyctl.simulation.run import Run
from fuzzyctl.simulation.simulate import simulate
from fuzzyctl.support.reading import read_source

HERE: Final = Path(__file__).parent
TABLE: Final = "<!-- table: python -m gallery -->"
END: Final = "<!-- end of table -->"
BLOCK: Final = re.compile(f"{re.escape(TABLE)}\n(.*?){re.escape(END)}", flags=re.DOTALL)
PATH: Final = re.compile(r"^<!-- path: (\S+) (\S+) -->$", flags=re.MULTILINE)
#: Pixels per inch of the pictures, which are small files.
DPI: Final = 80
DRAWN: Final = re.compile(r"^<!-- drawn: (.+) -->$", flags=re.MULTILINE)


def entries() -> dict[str, Path]:
    """Return the folders of the gallery by name."""
    return {path.parent.name: path.parent for path in sorted(HERE.glob("*/*.fz")) if path.stem == path.parent.name}


def loops_of(folder: Path) -> tuple[Loop, ...]:
    """Return the loops of a folder.

    Raises:
        DiagnosticError: With all errors and warnings of the file.
    """
    examined = look_through(read_source(folder / f"{folder.name}.fz"), folder=folder)
    if found := examined.reported(examined.diagnostics):
        raise DiagnosticError(found)
    return examined.loops


def table_of(runs: Sequence[Run]) -> str:
    """Return the Markdown table of runs: a row for each measure, a column for each loop, printed values in brackets."""
    measures = {m.name: m for run in runs for m in run.loop.measures}
    rows = [[_label(m), *(_cell(run, m.name) for run in runs)] for m in measures.values()]
    head = ["", *(run.loop.title or run.loop.name for run in runs)]
    return "".join(f"| {' | '.join(row)} |\n" for row in [head, ["---"] * len(head), *rows])


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
    shown = f"{value:.{max(0, 1 - math.floor(math.log10(tolerance)))}f}" if tolerance else f"{value:.4g}"
    return f"{shown} ({printed})" if printed else shown


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
    runs = [simulate(loop) for loop in loops_of(folder)]
    page.write_text(BLOCK.sub(lambda _: f"{TABLE}\n{table_of(runs)}{END}", text), encoding="utf-8")
    draw(folder / f"{folder.name}.png", runs, text)
    missed = [
        f"{run.loop.name}: {r.text}, {', '.join(r.facts)}" for run in runs for r in run.requirements if not r.holds
    ]
    return "\n  ".join([f"{folder.name}: {counted(len(runs), 'loop')}", *(f"not met: {m}" for m in missed)])


def draw(target: Path, runs: Sequence[Run], page: str) -> None:
    """Draw the runs that a page shows."""
    names = match[1].split() if (match := DRAWN.search(page)) else [run.loop.name for run in runs]
    shown = [run for name in names for run in runs if run.loop.name == name]
    path = PATH.search(page)
    with saved(target, DPI) as figure:
        if path is not None:
            draw_paths(figure, shown, *path.groups())
        else:
            several = len(shown) > 1  # one has its title above the panels
            draw_runs(figure, shown, [(run.loop.title if several else "") or run.loop.name for run in shown])
            if several:
                figure.axes[0].set_title("")


def draw_paths(figure: Any, runs: Sequence[Run], x: str, y: str) -> None:
    """Draw a signal of runs over another one, with a dot at each start."""
    figure.set_size_inches(6, 4)
    axes = figure.subplots()
    for run, color in zip(runs, COLORS, strict=False):
        axes.plot(run[x], run[y], ".-", color=color, markersize=3, linewidth=1, label=run.loop.title or run.loop.name)
        axes.plot(run[x][0], run[y][0], "o", color=color, markersize=5)
    axes.set(xlabel=x, ylabel=y, aspect="equal")
    axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1, 0.5))
