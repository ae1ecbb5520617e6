"""`dwmr animate SCENARIO`: a run as MP4 or GIF, or one moment of it as PNG."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import click

from dwmr.cli import run_options
from dwmr.cli.common import mistakes_as_diagnostics
from fuzzyctl.cli.progress import progress
from fuzzyctl.cli.streams import say, terminated_as_interrupted
from fuzzyctl.experiments.result_files import one_file

if TYPE_CHECKING:
    from dwmr.core.arrays import FloatArray
    from dwmr.figures.scene import Scene
    from dwmr.scenario.model import Scenario
    from dwmr.simulation.simulate import Trajectory

#: More pictures than these are refused: an hour of film at 20 pictures a second has 72,000.
MOST_PICTURES = 20_000
SUFFIXES = (".gif", ".mp4", ".png")
#: How to install a renderer.
REPAIR = (
    "leave MUJOCO_GL unset, or set it to egl, and install what brings OpenGL without a window; on Debian: "
    "apt install libegl1 libgl1-mesa-dri"
)

Item = TypeVar("Item")


def _number(context: click.Context, parameter: click.Parameter, value: float | None) -> float | None:
    """Refuse NaN, which comparisons with a range let pass."""
    if value is not None and math.isnan(value):
        raise click.BadParameter(f"{value} is not a number")
    return value


@click.command(context_settings={"show_default": True})
@click.argument("scenario")
@run_options.output_option(
    "path", "run.gif", "FILE", "Film to write: .gif, or .mp4 if ffmpeg is installed; .png: one moment."
)
@run_options.controller_option
@click.option(
    "--speed",
    type=click.FloatRange(0.0, 1000.0, min_open=True),
    callback=_number,
    default=10.0,
    metavar="FACTOR",
    help="Seconds of the run in one second of film.",
)
@click.option("--fps", type=click.IntRange(1, 60), default=20, metavar="N", help="Frames per second of film, 1 to 60.")
@click.option(
    "--at",
    type=click.FloatRange(0.0),
    callback=_number,
    metavar="SECONDS",
    show_default="the last",
    help="Moment of the run that a .png shows.",
)
@click.option(
    "--view",
    type=click.Choice(["above", "scene"]),
    show_default="scene if robots are rigid bodies",
    help="A drawing from above, or a scene rendered by MuJoCo.",
)
@click.option("--follow", metavar="ROBOT", help="Robot that the camera of a scene follows.")
@run_options.rules_option
@run_options.set_option
def animate(
    scenario: str,
    path: Path,
    controller: str | None,
    speed: float,
    fps: int,
    at: float | None,
    view: str | None,
    follow: str | None,
    rules_folder: Path | None,
    overrides: tuple[str, ...],
) -> None:
    """Write a run of SCENARIO, a shipped name or a TOML file, as a film.

    It shows bodies with headings and trails, a cross at each reference position, and obstacles with the radius of
    avoidance.
    """
    _check_film(path, fps, at)
    with mistakes_as_diagnostics("text"), terminated_as_interrupted():
        task = run_options.read(scenario, rules_folder, overrides)
        names = run_options.laws_of(task, controller)
        if len(names) > 1:
            raise click.UsageError(f"--controller {controller}: a film shows one control law")
        horizon = task.file.scenario.run.horizon
        if at is not None and at > horizon:
            raise click.UsageError(f"--at {at:g}: the run ends at {horizon:g} s")
        count = horizon / speed * fps
        if count > MOST_PICTURES and path.suffix.lower() != ".png":
            raise click.ClickException(
                f"the film would have {count:,.0f} pictures, more than {MOST_PICTURES:,}: raise --speed or lower --fps"
            )
        _check_view(task.file.scenario, view, follow)
        finished = _film(task, names[0], path, _Shown(speed, fps, at, view, follow))
    if not finished:
        sys.exit(1)


class _Shown(NamedTuple):
    """Contents of a film: options of the command."""

    speed: float
    fps: int
    at: float | None
    view: str | None
    follow: str | None


def _check_view(scenario: Scenario, view: str | None, follow: str | None) -> None:
    """Refuse a scene without bodies, and a camera behind an unknown robot."""
    if follow is not None and view == "above":
        raise click.UsageError("--follow: a drawing from above shows all robots; leave out --view above")
    if follow is not None and follow not in scenario.robots:
        raise click.UsageError(f"--follow {follow}: the scenario has the robots {', '.join(scenario.robots)}")
    if (view == "scene" or follow is not None) and scenario.run.plant != "mujoco":
        option = "--view scene" if view else f"--follow {follow}"
        raise click.UsageError(
            f"{option}: a scene shows rigid bodies, and run.plant is {scenario.run.plant!r}; "
            "the scenario 'experiment' has bodies"
        )


def _scene(scenario: Scenario, shown: _Shown) -> AbstractContextManager[Scene | None]:
    """Return the renderer of the film, None inside if it is drawn from above."""
    if shown.view == "above" or scenario.run.plant != "mujoco":
        return nullcontext()
    from dwmr.figures.scene import NoRendererError, Scene

    try:
        return Scene(scenario, shown.follow)
    except NoRendererError as error:
        what = f"MuJoCo cannot render here: {error}"
        if shown.view or shown.follow:
            raise click.ClickException(
                f"{what}\n = help: {REPAIR}; or draw the run from above: --view above"
            ) from error
        say(f"warning: {what}; the run is drawn from above\n = help: {REPAIR}", err=True)
        return nullcontext()


def _check_film(path: Path, fps: int, at: float | None) -> None:
    """Refuse a kind of film that cannot be written, before anything is run."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise click.UsageError(f"-o {path}: a film is a .gif or an .mp4, one moment of it a .png")
    if at is not None and suffix != ".png":
        raise click.UsageError(f"--at {at:g}: a film shows the whole run; write one moment of it to a .png")
    from dwmr.figures import film

    if suffix == ".gif" and fps > film.FASTEST_GIF:
        raise click.UsageError(f"--fps {fps}: a GIF shows at most {film.FASTEST_GIF:g} pictures in a second")
    if suffix == ".mp4" and not film.has_ffmpeg():
        raise click.ClickException(
            "an MP4 needs the program ffmpeg, which is not installed; "
            f"install it, or write a GIF instead: -o {path.with_suffix('.gif')}"
        )


def _film(task: run_options.Task, law: str, path: Path, shown: _Shown) -> bool:
    """Run, draw and write; return whether the run came to its end."""
    run_options.check(task, (law,))
    with one_file(path) as files, _scene(task.file.scenario, shown) as scene:
        (trajectory,) = run_options.simulate_whole(task, (law,))
        samples = _samples(trajectory, path, shown)
        _draw(files.write, path, trajectory, task.file.scenario, scene, samples, shown.fps)
        files.publish()
    run_options.say_stops([trajectory])
    if path.suffix.lower() == ".png":
        say(f"wrote {path}: t = {trajectory.t[samples[0]]:g} s")
    else:
        say(f"wrote {path}: {len(samples)} pictures, {len(samples) / shown.fps:.1f} s")
    return trajectory.stop is None


def _samples(trajectory: Trajectory, path: Path, shown: _Shown) -> list[int]:
    """Return the samples that are shown: one of a picture, those of all moments of a film."""
    from dwmr.figures import animation

    if path.suffix.lower() != ".png":
        return animation.moments(trajectory, shown.speed, shown.fps)
    last = len(trajectory.t) - 1
    return [last if shown.at is None else min(int(trajectory.t.searchsorted(shown.at - 1e-9)), last)]


def _draw(
    write: Callable[[str, Callable[[Path], None]], None],
    path: Path,
    trajectory: Trajectory,
    scenario: Scenario,
    scene: Scene | None,
    samples: list[int],
    fps: int,
) -> None:
    """Draw all pictures into the file."""
    from dwmr.figures import CANNOT_DRAW, animation, film, large_numbers

    try:
        with large_numbers(), progress("") as start:
            if scene is None:
                drawn = animation.Film(trajectory, scenario)
                size, frames = drawn.size, drawn.pictures(samples)
                palette: Sequence[str] = animation.PALETTE
            else:
                size, palette, frames = scene.size, scene.palette, scene.pictures(trajectory, samples)
            pictures = _counted(frames, start("pictures", len(samples)))
            write(path.name, lambda part: _write(part, path.suffix.lower(), pictures, fps, size, palette))
    except film.FilmError as error:
        raise click.ClickException(f"ffmpeg cannot write {path}: {error}") from error
    except CANNOT_DRAW as error:
        raise click.ClickException(f"the run cannot be drawn: {str(error) or type(error).__name__}") from error


def _write(
    part: Path, suffix: str, pictures: Iterator[FloatArray], fps: int, size: tuple[int, int], palette: Sequence[str]
) -> None:
    from dwmr.figures import film

    if suffix == ".gif":
        film.write_gif(part, pictures, fps, palette)
    elif suffix == ".mp4":
        film.write_mp4(part, pictures, fps, size)
    else:
        film.write_png(part, next(pictures))


def _counted(items: Iterable[Item], move: Callable[[int], None]) -> Iterator[Item]:
    for k, item in enumerate(items):
        yield item
        move(k + 1)
