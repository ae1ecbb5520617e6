"""`fuzzyctl simulate`: run the loops of files, and judge them."""

from __future__ import annotations

import math
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from fuzzyctl.cli.common import BLOCK, DONE, FAILED, FORMAT, QUIET, SVG_TEXT, answers_with_diagnostics, report, show
from fuzzyctl.cli.loading import chosen_loops, settings_of
from fuzzyctl.cli.progress import status_line
from fuzzyctl.cli.streams import say, table_lines, terminal_width, write_json
from fuzzyctl.diagnostics.suggestions import listed
from fuzzyctl.experiments.result_files import results

if TYPE_CHECKING:
    from fuzzyctl.diagnostics.diagnostic import Diagnostic
    from fuzzyctl.experiments.result_files import Results
    from fuzzyctl.model.loop import Loop
    from fuzzyctl.simulation.members import Broken
    from fuzzyctl.simulation.run import Run
    from fuzzyctl.simulation.simulate import Solver

#: Formats of data, as `simulation.run.FORMATS`, which imports numpy; and of pictures.
DATA: Final = ("csv", "npz", "parquet")
PICTURES: Final = ("png", "svg", "pdf")
#: Most corners of a loop that the picture shows.
_DRAWN: Final = 32


@click.command()
@click.argument("file")
@BLOCK
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="NAME=VALUE",
    help="Set a param, PARAM or BLOCK.PARAM, a start, BLOCK.STATE, or a disturbance.",
)
@click.option("--corners", is_flag=True, help="Run the corners of the family, too: ends of 'for' and 'disturbance'.")
@click.option("--against", multiple=True, metavar="FILE", help="Run the loops of another file, too; may be repeated.")
@click.option("-o", "--output", "out", metavar="DIR", help="Folder for summary.json, the data and the picture.")
@click.option(
    "--solver",
    type=click.Choice(["RK4", "RK45", "DOP853", "Radau", "BDF", "LSODA"]),
    default="RK4",
    show_default=True,
    help="RK4 has steps of fixed length and is compiled; the others are scipy's.",
)
@click.option(
    "--substeps", type=click.IntRange(1, 10_000), default=1, show_default=True, help="Steps of RK4 between two samples."
)
@click.option("--data", type=click.Choice(DATA), default="csv", show_default=True, help="Format of the data.")
@click.option("--picture", type=click.Choice(PICTURES), default="png", show_default=True, help="Its format.")
@SVG_TEXT
@FORMAT
@QUIET
@answers_with_diagnostics
def simulate(
    file: str,
    name: str | None,
    settings: tuple[str, ...],
    corners: bool,
    against: tuple[str, ...],
    out: str | None,
    solver: Solver,
    substeps: int,
    data: str,
    picture: str,
    svg_text: bool,
    form: str,
) -> int:
    """Run loops: controllers and plants over time.

    \b
    fuzzyctl simulate water_tank
    fuzzyctl simulate water_tank --set law.GU=2 -o out
    fuzzyctl simulate water_tank --against mathworks_tank
    fuzzyctl simulate upright --corners

    All loops of a file are run, or the one that --block names. A plant in Python is executed, and so
    is the native code of an FMU.

    Exit code: 0; 1 if a run is stopped, a requirement is not met, or a claim about every instant is broken.
    """
    from fuzzyctl.simulation.run import require_format
    from fuzzyctl.simulation.sample_times import measures_without_samples

    if corners and solver != "RK4":
        raise click.UsageError("--corners takes the solver RK4")
    require_format(data)
    loops = [pair for one in (file, *against) for pair in chosen_loops(one, name if one == file else None)]
    changed = settings_of(settings, [loop for _, loop in loops])
    labels = _labels(loops)
    folders = _folders(labels)
    with ExitStack() as stack:
        # The folder is made, and known to be writable, before anything runs.
        files = None if out is None else stack.enter_context(results(Path(out), _names(folders.values())))
        runs = {label: _run(loop, solver, substeps) for label, loop in zip(labels, changed, strict=True)}
        cornered = [_corners(loop, settings, substeps) for loop in changed] if corners else []
        families = {label: one for label, one in zip(labels, cornered, strict=False) if one is not None}
        if corners and not families:
            raise click.UsageError("--corners: no loop has a family; add a 'for' or a 'disturbance' line")
        mistakes = _diagnostics(runs.values())
        for (_, loop), new in zip(loops, changed, strict=True):  # those of the file were shown when it was read
            spans = {d.span for d in measures_without_samples(loop)}
            mistakes += [d for d in measures_without_samples(new) if d.span not in spans]
        if form == "json":
            write_json(
                {
                    "runs": [
                        _summary(label, run) | ({"corners": families[label].data()} if label in families else {})
                        for label, run in runs.items()
                    ],
                    "diagnostics": [d.as_dict() for d in mistakes],
                }
            )
        else:
            texts = [line for label, one in families.items() for line in one.text(label if len(runs) > 1 else "")]
            report("\n".join([text_of(runs, terminal_width(sys.stdout)), *texts]))
            show(mistakes)
        if files is not None:
            cornering = [run for one in families.values() for run in one.runs]
            written = _write(files, runs, cornering, folders, data, picture, svg_text)
            if form == "text":
                say("\n".join(f"wrote {path}" for path in written))
    passed = all(run.passed for run in runs.values()) and not any(one.broken for one in families.values())
    return DONE if passed else FAILED


@dataclass(frozen=True)
class _Corners:
    """The corners of the family of a loop, or members drawn in their place, and the claims that they break.

    Args:
        names: The numbers in which they differ.
        count: How many were run.
        drawn: Whether they are a Latin hypercube, since there are too many corners.
        broken: The claims.
        settings: The options `--set` that all of them have.
        runs: The runs of the first of them.
    """

    names: tuple[str, ...]
    count: int
    drawn: bool
    broken: tuple[Broken, ...]
    settings: tuple[str, ...]
    runs: tuple[Run, ...]

    def replay(self, one: Broken) -> str:
        """Return the options that run the first member that breaks a claim."""
        from fuzzyctl.simulation.members import replayed

        return replayed(one.member, self.settings)

    def text(self, label: str) -> Iterator[str]:
        """Yield the lines of a report."""
        from fuzzyctl.simulation.members import STOPPED

        what = "members, a Latin hypercube, since there are too many corners," if self.drawn else "corners"
        head = f"{label}: " if label else ""
        yield ""
        yield f"{head}{self.count} {what} of {listed(self.names)}{'' if self.broken else ': no claim is broken'}"
        for one in self.broken:
            facts = f"  ({', '.join(one.facts)})" if one.facts else ""
            count = f"{'' if one.claim == STOPPED else 'broken by '}{one.count} of {self.count}"
            yield f"{head}{one.claim}: {count}, first by {self.replay(one)}{facts}"

    def data(self) -> dict[str, Any]:
        """Return the same as plain data."""
        claims = [
            {"claim": b.claim, "broken_by": b.count, "member": dict(b.member), "replay": self.replay(b)}
            for b in self.broken
        ]
        return {"members": self.count, "drawn": self.drawn, "broken": claims}


def _corners(loop: Loop, settings: Sequence[str], substeps: int) -> _Corners | None:
    """Run the corners of a loop; None for one without a family."""
    from fuzzyctl.simulation import members
    from fuzzyctl.simulation.loop_params import short_names

    if not loop.family:
        return None
    chosen, names = members.corners(loop), short_names(loop)
    first: list[Run] = []
    with status_line() as status:

        def counted() -> Iterator[Run]:
            for k, run in enumerate(members.runs(loop, chosen, substeps=substeps)):
                first.extend([run] if len(first) < _DRAWN else [])
                yield run
                if status is not None:
                    status(f"{loop.name}: {k + 1:,} of {len(chosen):,} corners")

        broken = tuple(members.broken(chosen, counted()))
    others = [t for t in settings if names.get(t.partition("=")[0].strip(), "") not in loop.family]
    return _Corners(
        tuple(loop.family), len(chosen), len(chosen) < 2 ** len(loop.family), broken, tuple(others), tuple(first)
    )


def _labels(loops: Sequence[tuple[str, Loop]]) -> list[str]:
    """Return labels of the loops: their names, with the files if names are the same."""
    names = [loop.name for _, loop in loops]
    labels = [
        name if names.count(name) == 1 else f"{Path(file).stem}.{name}"
        for (file, _), name in zip(loops, names, strict=True)
    ]
    return [label if labels.count(label) == 1 else f"{label} {k + 1}" for k, label in enumerate(labels)]


def _run(loop: Loop, solver: Solver, substeps: int) -> Run:
    from fuzzyctl.simulation.simulate import simulate as simulated

    with status_line() as status:

        def advanced(done: int, samples: int) -> None:
            if status is not None:
                status(f"{loop.name}: {done:,} of {samples:,} samples")

        return simulated(loop, solver=solver, substeps=substeps, progress=advanced)


def _diagnostics(runs: Collection[Run]) -> list[Diagnostic]:
    from fuzzyctl.simulation.simulate import warnings

    stopped = [run.stopped for run in runs if run.stopped is not None]
    return [*stopped, *(d for run in runs for d in warnings(run))]


def _summary(label: str, run: Run) -> dict[str, Any]:
    return {"label": label, **run.summary()}


def _folders(labels: Sequence[str]) -> dict[str, str]:
    """Return the prefixes of the files of each run: empty for one, folders for several."""
    from fuzzyctl.plot.choices import file_part

    if len(labels) == 1:
        return {labels[0]: ""}
    names: list[str] = []
    for label in labels:
        names.append(file_part(label, names))
    return {label: f"{part}/" for label, part in zip(labels, names, strict=True)}


def _names(folders: Iterable[str]) -> list[str]:
    """Return the names of all files that runs may leave."""
    files = ("summary.json", *(f"data.{form}" for form in DATA))
    return [f"{folder}{name}" for folder in folders for name in files] + [f"loop.{form}" for form in PICTURES]


def _write(
    files: Results,
    runs: Mapping[str, Run],
    members: Sequence[Run],
    folders: Mapping[str, str],
    data: str,
    picture: str,
    svg_text: bool,
) -> list[Path]:
    """Write data and summaries of runs, and one picture of all, and return the files."""
    from fuzzyctl.experiments.result_files import write_summary
    from fuzzyctl.plot.style import saved
    from fuzzyctl.plot.time_series import draw_runs
    from fuzzyctl.simulation.run import save

    written = []
    for label, run in runs.items():
        data_file = f"{folders[label]}data.{data}"
        files.write(data_file, partial(save, run, form=data))
        write_summary(files, _summary(label, run), folders[label])
        written += [data_file, f"{folders[label]}summary.json"]

    def draw(path: Path) -> None:
        with saved(path, svg_text=svg_text) as figure:
            draw_runs(figure, list(runs.values()), list(runs), members=members)

    files.write(f"loop.{picture}", draw)
    files.publish()
    return [files.folder / name for name in (*written, f"loop.{picture}")]


def text_of(runs: Mapping[str, Run], width: int | None = None) -> str:
    """Return runs as text.

    Args:
        runs: The runs by label.
        width: Columns of the terminal, None for a pipe; a wider table is printed in several parts.
    """
    lines = [line for label, run in runs.items() for line in _head(run, label)]
    table = [*_measures(runs, width), *_single_measures(runs)]
    claims = [line for label, run in runs.items() for line in _requirements(run, label, len(runs))]
    return "\n".join([*lines, *([""] if table else []), *table, *([""] if claims else []), *claims])


def _head(run: Run, label: str) -> Iterator[str]:
    yield f"{label}: {run.loop.title}" if run.loop.title else label
    end = f"{run.t[-1]:.6g} s" if len(run) else "0 s"
    how = (
        f"{run.solver} with {run.substeps} {'step' if run.substeps == 1 else 'steps'} a sample"
        if run.substeps
        else run.solver
    )
    yield f"  {end} in {len(run):,} {'sample' if len(run) == 1 else 'samples'}, {how}"
    if run.error:
        name, error = max(run.error.items(), key=lambda item: item[1])
        finer = "half the step changes" if run.substeps else "a tenth of the tolerances changes"
        yield f"  {finer} {name} by {error:.2g}{', the other states by no more' if len(run.error) > 1 else ''}"
    if run.stopped is not None and run.loop.measures:
        yield "  stopped: the measures are of the samples up to there"


def _measures(runs: Mapping[str, Run], width: int | None) -> list[str]:
    """Return a table: a row for each measure of any run, a column for each run."""
    measures = {m.name: m for run in runs.values() for m in run.loop.measures}
    if not measures:
        return []
    columns = [[_title(m.name, m.label) for m in measures.values()]]
    columns += [[_value(run, m.name, m.unit) for m in measures.values()] for run in runs.values()]
    if len(runs) > 1:
        columns = [[head, *column] for head, column in zip(("measure", *runs), columns, strict=True)]
    first, *others = columns
    parts: list[list[list[str]]] = []
    used = 0
    for column in others:
        used += max(map(len, column)) + 2
        if not parts or (width is not None and used > width):
            parts.append([first])
            used = max(map(len, first)) + max(map(len, column)) + 2
        parts[-1].append(column)
    tables = [table_lines(zip(*part, strict=True)) for part in parts]
    return [line for table in tables for line in ("", *table)][1:]


def _single_measures(runs: Mapping[str, Run]) -> Iterator[str]:
    """Name the measures that only one of several runs has."""
    for label, run in runs.items():
        others = {m.name for other in runs.values() if other is not run for m in other.loop.measures}
        names = [m.name for m in run.loop.measures if m.name not in others]
        if names and len(runs) > 1:
            yield f"only {label} measures: {', '.join(names)}"


def _title(name: str, label: str) -> str:
    return f"{name}  {label}" if label else name


def _value(run: Run, name: str, unit: str) -> str:
    if name not in run.measures:
        return ""
    value = run.measures[name]
    return "none" if math.isnan(value) else f"{value:.5g} {unit}".rstrip()


def _requirements(run: Run, label: str, count: int) -> Iterator[str]:
    for r in run.requirements:
        facts = f"  ({', '.join(r.facts)})" if r.facts else ""
        yield f"{f'{label}: ' if count > 1 else ''}require {r.text}: {r.verdict}{facts}"
