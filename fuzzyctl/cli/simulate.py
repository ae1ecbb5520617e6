"""`fuzzyctl simulate`: run the loops of files, and judge them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fuzzyctl.cli.common import DONE, FAILED, FORMAT, QUIET, answers_with_diagnostics, show
from fuzzyctl.cli.loops import chosen_loops, settings_of
from fuzzyctl.cli.progress import progress
from fuzzyctl.cli.streams import say, write_json

if TYPE_CHECKING:
    from fuzzyctl.diagnostics.diagnostic import Diagnostic
    from fuzzyctl.model.loop import Loop
    from fuzzyctl.simulation.run import Run


@dataclass(frozen=True)
class Labelled:
    """A run and what it is called."""

    label: str
    run: Run


@click.command()
@click.argument("file")
@click.argument("loop", required=False)
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
@click.option(
    "--data", type=click.Choice(["csv", "npz", "parquet"]), default="csv", show_default=True, help="Format of the data."
)
@click.option(
    "--picture", type=click.Choice(["png", "svg", "pdf"]), default="png", show_default=True, help="Its format."
)
@FORMAT
@QUIET
@answers_with_diagnostics
def simulate(
    file: str,
    loop: str | None,
    settings: tuple[str, ...],
    against: tuple[str, ...],
    out: str | None,
    solver: str,
    substeps: int,
    data: str,
    picture: str,
    form: str,
) -> int:
    """Run loops: controllers and plants over time.

    \b
    fuzzyctl simulate rules/loops/water_tank.fz
    fuzzyctl simulate rules/loops/water_tank.fz --set law.GU=2 -o out
    fuzzyctl simulate rules/loops/water_tank.fz fill --against other.fz

    All loops of a file are run side by side, or the one that is named. A plant in Python is executed.

    Exit code: 0; 1 where a run is stopped or a requirement is not met.
    """
    from fuzzyctl.simulation.data import require_format

    require_format(data)
    loops = [pair for name in (file, *against) for pair in chosen_loops(name, loop if name == file else None)]
    changed = settings_of(settings, [own for _, own in loops])
    labels = _labels(loops)
    runs = [Labelled(label, _run(own, solver, substeps)) for label, own in zip(labels, changed, strict=True)]
    found = _diagnostics(runs)
    if form == "json":
        write_json({"runs": [_summary(r) for r in runs], "diagnostics": [d.as_dict() for d in found]})
    else:
        from fuzzyctl.cli.run_tables import text_of

        say(text_of([r.run for r in runs], labels))
        show(found)
    if out is not None:
        written = _write(runs, Path(out), data, picture)
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


def _run(loop: Loop, solver: str, substeps: int) -> Run:
    from fuzzyctl.simulation.simulate import simulate as simulated

    with progress() as shown:

        def advanced(done: int, samples: int) -> None:
            if shown is not None:
                shown(f"{loop.name}: {done:,} of {samples:,} samples")

        return simulated(loop, solver=solver, substeps=substeps, progress=advanced)


def _diagnostics(runs: Sequence[Labelled]) -> list[Diagnostic]:
    from fuzzyctl.simulation.simulate import inaccuracies

    stopped = [r.run.stopped for r in runs if r.run.stopped is not None]
    return [*stopped, *(d for r in runs for d in inaccuracies(r.run))]


def _summary(labelled: Labelled) -> dict[str, Any]:
    return {"label": labelled.label, **labelled.run.summary()}


def _write(runs: Sequence[Labelled], folder: Path, data: str, picture: str) -> list[Path]:
    """Write what is known of runs: one into the folder, several into folders of their own within it."""
    from fuzzyctl.cli.streams import json_text
    from fuzzyctl.plot.names import file_part
    from fuzzyctl.plot.style import saved
    from fuzzyctl.plot.time_series import draw_runs
    from fuzzyctl.simulation.data import save
    from fuzzyctl.support.writing import folder_for, write_together

    folders = [folder] if len(runs) == 1 else []
    for labelled in runs if len(runs) > 1 else ():
        folders.append(folder / file_part(labelled.label, [f.name for f in folders]))
    written = [save(r.run, folder_for(own), data) for r, own in zip(runs, folders, strict=True)]
    texts = {own / "summary.json": f"{json_text(_summary(r))}\n" for r, own in zip(runs, folders, strict=True)}
    write_together(texts)
    target = folder / f"loop.{picture}"
    with saved(target) as figure:
        draw_runs(figure, [r.run for r in runs], [r.label for r in runs])
    return [*written, *texts, target]
