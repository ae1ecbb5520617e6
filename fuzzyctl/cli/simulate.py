"""`fuzzyctl simulate`: run the loops of files, and judge them."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from fuzzyctl.cli import common
from fuzzyctl.cli.common import BLOCK, DONE, FAILED, FORMAT, QUIET, SVG_TEXT, answers_with_diagnostics, report, show
from fuzzyctl.cli.loops import chosen_loops, settings_of
from fuzzyctl.cli.progress import progress
from fuzzyctl.cli.streams import say, write_json
from fuzzyctl.experiments.result_files import results

if TYPE_CHECKING:
    from fuzzyctl.diagnostics.diagnostic import Diagnostic
    from fuzzyctl.experiments.result_files import Results
    from fuzzyctl.model.loop import Loop
    from fuzzyctl.simulation.run import Run
    from fuzzyctl.simulation.simulate import Solver

#: Formats of data, as `simulation.run.FORMATS`, which imports numpy; and of pictures.
DATA: Final = ("csv", "npz", "parquet")
PICTURES: Final = ("png", "svg", "pdf")


@dataclass(frozen=True)
class Labelled:
    """A run and what it is called."""

    label: str
    run: Run


@click.command()
@click.argument("file")
@BLOCK
@click.option(
    "--set", "settings", multiple=True, metavar="NAME=VALUE", help="Set a param: PARAM, or BLOCK.PARAM of a block."
)
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

    All loops of a file are run side by side, or the one that is named. A plant in Python is executed, and so
    is the native code of an FMU.

    Exit code: 0; 1 where a run is stopped or a requirement is not met.
    """
    from fuzzyctl.simulation.run import require_format
    from fuzzyctl.simulation.sample_times import measures_without_samples

    require_format(data)
    loops = [pair for one in (file, *against) for pair in chosen_loops(one, name if one == file else None)]
    changed = settings_of(settings, [own for _, own in loops])
    labels = _labels(loops)
    folders = _folders(labels)
    with ExitStack() as stack:
        # The folder is made, and known to be writable, before anything runs.
        files = None if out is None else stack.enter_context(results(Path(out), _names(folders.values())))
        runs = [Labelled(label, _run(own, solver, substeps)) for label, own in zip(labels, changed, strict=True)]
        found = _diagnostics(runs)
        for (_, own), new in zip(loops, changed, strict=True):  # those of the file were shown when it was read
            known = {d.span for d in measures_without_samples(own)}
            found += [d for d in measures_without_samples(new) if d.span not in known]
        if form == "json":
            write_json({"runs": [_summary(r) for r in runs], "diagnostics": [d.as_dict() for d in found]})
        else:
            from fuzzyctl.cli.run_tables import text_of

            report(text_of([r.run for r in runs], labels, common.terminal_width(sys.stdout)))
            show(found)
        if files is not None:
            written = _write(files, runs, folders, data, picture, svg_text)
            if form == "text":
                say("\n".join(f"wrote {path}" for path in written))
    return DONE if all(r.run.passed for r in runs) else FAILED


def _labels(loops: Sequence[tuple[str, Loop]]) -> list[str]:
    """Return what the loops are called: their names, with the files where names are the same."""
    names = [own.name for _, own in loops]
    labels = [
        name if names.count(name) == 1 else f"{Path(file).stem}.{name}"
        for (file, _), name in zip(loops, names, strict=True)
    ]
    return [label if labels.count(label) == 1 else f"{label} {k + 1}" for k, label in enumerate(labels)]


def _run(loop: Loop, solver: Solver, substeps: int) -> Run:
    from fuzzyctl.simulation.simulate import simulate as simulated

    with progress() as shown:

        def advanced(done: int, samples: int) -> None:
            if shown is not None:
                shown(f"{loop.name}: {done:,} of {samples:,} samples")

        return simulated(loop, solver=solver, substeps=substeps, progress=advanced)


def _diagnostics(runs: Sequence[Labelled]) -> list[Diagnostic]:
    from fuzzyctl.simulation.simulate import warnings

    stopped = [r.run.stopped for r in runs if r.run.stopped is not None]
    return [*stopped, *(d for r in runs for d in warnings(r.run))]


def _summary(labelled: Labelled) -> dict[str, Any]:
    return {"label": labelled.label, **labelled.run.summary()}


def _folders(labels: Sequence[str]) -> dict[str, str]:
    """Return what stands before the names of the files of each run: nothing for one, folders for several."""
    from fuzzyctl.plot.names import file_part

    if len(labels) == 1:
        return {labels[0]: ""}
    taken: list[str] = []
    for label in labels:
        taken.append(file_part(label, taken))
    return {label: f"{part}/" for label, part in zip(labels, taken, strict=True)}


def _names(folders: Iterable[str]) -> list[str]:
    """Return the names of all files that runs may leave."""
    own = ("summary.json", *(f"data.{form}" for form in DATA))
    return [f"{folder}{name}" for folder in folders for name in own] + [f"loop.{form}" for form in PICTURES]


def _write(
    files: Results,
    runs: Sequence[Labelled],
    folders: Mapping[str, str],
    data: str,
    picture: str,
    svg_text: bool,
) -> list[Path]:
    """Write what is known of runs, and one picture of all of them, and return the files."""
    from fuzzyctl.experiments.result_files import write_summary
    from fuzzyctl.plot.style import saved
    from fuzzyctl.plot.time_series import draw_runs
    from fuzzyctl.simulation.run import save

    written = []
    for labelled in runs:
        own = f"{folders[labelled.label]}data.{data}"
        files.write(own, partial(save, labelled.run, form=data))
        write_summary(files, _summary(labelled), folders[labelled.label])
        written += [own, f"{folders[labelled.label]}summary.json"]

    def draw(path: Path) -> None:
        with saved(path, svg_text=svg_text) as figure:
            draw_runs(figure, [r.run for r in runs], [r.label for r in runs])

    files.write(f"loop.{picture}", draw)
    files.publish()
    return [files.folder / name for name in (*written, f"loop.{picture}")]
