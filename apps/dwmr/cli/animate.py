"""`dwmr animate SCENARIO`: a run as MP4 or GIF."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

from dwmr.cli import run_options
from dwmr.cli.common import mistakes_as_diagnostics
from fuzzyctl.cli.bars import progress
from fuzzyctl.cli.interruptions import terminated_as_interrupted
from fuzzyctl.cli.streams import say

if TYPE_CHECKING:
    from dwmr.scenario.model import Scenario
    from dwmr.simulation.simulate import Trajectory

#: More pictures than these are refused: an hour of film at 20 pictures a second has 72,000.
MOST_PICTURES = 20_000

Item = TypeVar("Item")


def _number(context: click.Context, parameter: click.Parameter, value: float) -> float:
    """Refuse what is no number; comparisons with a range let NaN pass."""
    if math.isnan(value):
        raise click.BadParameter(f"{value} is not a number")
    return value


@click.command(context_settings={"show_default": True})
@click.argument("scenario")
@run_options.output_option("path", "run.gif", "FILE", "Film to write: .gif, or .mp4 where ffmpeg is installed.")
@run_options.controller_option
@click.option(
    "--speed",
    type=click.FloatRange(0.0, 1000.0, min_open=True),
    callback=_number,
    default=10.0,
    metavar="FACTOR",
    help="Seconds of the run in one second of film.",
)
@click.option(
    "--fps", type=click.IntRange(1, 60), default=20, metavar="N", help="Pictures in a second of film, 1 to 60."
)
@run_options.rules_option
@run_options.set_option
def animate(
    scenario: str,
    path: Path,
    controller: str | None,
    speed: float,
    fps: int,
    rules_folder: Path | None,
    overrides: tuple[str, ...],
) -> None:
    """Show a run of SCENARIO, a shipped name or a TOML file, as moving pictures.

    Bodies with headings and trails, crosses where they should be, obstacles with the radius within which they are
    avoided.
    """
    _check_film(path, fps)
    with mistakes_as_diagnostics("text"), terminated_as_interrupted():
        task = run_options.read(scenario, rules_folder, overrides)
        names = run_options.laws_of(task, controller)
        if len(names) > 1:
            raise click.UsageError(f"--controller {controller}: a film shows one control law")
        count = task.file.scenario.run.horizon / speed * fps
        if count > MOST_PICTURES:
            raise click.ClickException(
                f"the film would have {count:,.0f} pictures, more than {MOST_PICTURES:,}: raise --speed or lower --fps"
            )
        finished = _film(task, names[0], path, speed, fps)
    if not finished:
        sys.exit(1)


def _check_film(path: Path, fps: int) -> None:
    """Refuse a kind of film that cannot be written, before anything is run."""
    if path.suffix.lower() not in (".gif", ".mp4"):
        raise click.UsageError(f"-o {path}: a film is a .gif or an .mp4")
    from dwmr.figures import film

    if path.suffix.lower() == ".gif" and fps > film.FASTEST_GIF:
        raise click.UsageError(f"--fps {fps}: a GIF shows at most {film.FASTEST_GIF:g} pictures in a second")
    if path.suffix.lower() == ".mp4" and not film.has_ffmpeg():
        raise click.ClickException(
            "an MP4 needs the program ffmpeg, which is not installed; "
            f"install it, or write a GIF instead: -o {path.with_suffix('.gif')}"
        )


def _film(task: run_options.Task, law: str, path: Path, speed: float, fps: int) -> bool:
    """Run, draw and write; return whether the run came to its end."""
    from fuzzyctl.experiments.results.folder import one_file

    run_options.check(task, (law,))
    with one_file(path) as files:
        (trajectory,) = run_options.simulate(task, (law,))
        if trajectory.stop is not None and trajectory.stop.reason == "interrupted":
            raise KeyboardInterrupt
        count = _draw(files.write, path, trajectory, task.file.scenario, speed, fps)
        files.publish()
    run_options.say_stops([trajectory])
    say(f"wrote {path}: {count} pictures, {count / fps:.1f} s")
    return trajectory.stop is None


def _draw(
    write: Callable[[str, Callable[[Path], None]], None],
    path: Path,
    trajectory: Trajectory,
    scenario: Scenario,
    speed: float,
    fps: int,
) -> int:
    """Draw all pictures into the file; return their number."""
    from dwmr.figures import CANNOT_DRAW, animation, film, large_numbers

    try:
        with large_numbers(), progress("") as start:
            samples = animation.moments(trajectory, speed, fps)
            made = animation.Film(trajectory, scenario)
            pictures = _counted(made.pictures(samples), start("pictures", len(samples)))
            if path.suffix.lower() == ".gif":
                write(path.name, lambda part: film.write_gif(part, pictures, fps, animation.PALETTE))
            else:
                write(path.name, lambda part: film.write_mp4(part, pictures, fps, made.size))
    except film.FilmError as error:
        raise click.ClickException(f"ffmpeg cannot write {path}: {error}") from error
    except CANNOT_DRAW as error:
        raise click.ClickException(f"the run cannot be drawn: {str(error) or type(error).__name__}") from error
    return len(samples)


def _counted(items: Iterable[Item], move: Callable[[int], None]) -> Iterator[Item]:
    for k, item in enumerate(items):
        yield item
        move(k + 1)
