"""Options of all commands that run a scenario, and the steps from its name to trajectories."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from dwmr.cli.common import read_scenario
from dwmr.control import laws
from fuzzyctl.cli.common import show
from fuzzyctl.cli.progress import Begin, stages
from fuzzyctl.cli.streams import say
from fuzzyctl.experiments.result_files import versions

if TYPE_CHECKING:
    from dwmr.control.fuzzy_gains import Rules
    from dwmr.scenario.file import ScenarioFile
    from dwmr.simulation.periods import Simulation
    from dwmr.simulation.simulate import Trajectory

Command = TypeVar("Command", bound=Callable[..., object])


def controller_option(command: Command) -> Command:
    """Add --controller to a command."""
    return click.option(
        "--controller",
        metavar="LAWS",
        show_default="the scenario's own",
        help=f"Control laws to run, separated by commas: {', '.join(laws.names())}, or of your own in LAW.fz or LAW.py "
        f"beside the scenario; several at once: {', '.join(laws.GROUPS)}.",
    )(command)


def rules_option(command: Command) -> Command:
    """Add --rules to a command."""
    return click.option(
        "--rules",
        "rules_folder",
        type=click.Path(exists=True, file_okay=False, path_type=Path),
        metavar="DIR",
        help="Folder whose rule files replace those of the same name.",
    )(command)


def set_option(command: Command) -> Command:
    """Add --set to a command."""
    return click.option(
        "--set", "overrides", multiple=True, metavar="KEY=VALUE", help="Replace a value of the scenario; repeatable."
    )(command)


def output_option(name: str, default: str, kind: str, help: str) -> Callable[[Command], Command]:
    """Add -o/--output to a command, as argument `name`; `kind` is FILE or DIR."""
    return click.option(
        "-o", "--output", name, type=click.Path(path_type=Path), default=Path(default), metavar=kind, help=help
    )


def format_option(command: Command) -> Command:
    """Add --format to a command."""
    return click.option("--format", "style", type=click.Choice(["text", "json"]), default="text", help="How to print.")(
        command
    )


@dataclass(frozen=True)
class Task:
    """A run of a command: read, but not yet checked.

    Attributes:
        file: The scenario, overrides included.
        rules: Its rule files.
        overrides: As given on the command line.
    """

    file: ScenarioFile
    rules: Rules
    overrides: tuple[str, ...]


def read(scenario: str, rules_folder: Path | None, overrides: Sequence[str]) -> Task:
    """Read a scenario and find its rule files, without compiling.

    Raises:
        DiagnosticError: With every mistake in the scenario file.
    """
    from dwmr.control.fuzzy_gains import Rules

    file = read_scenario(scenario, overrides)
    rules = Rules(file.scenario.rules, (*([rules_folder] if rules_folder else []), *file.folders), file.places)
    if rules_folder:
        rules.files.require_use_of(rules_folder)
        rules.warnings += rules.files.near_misses(rules_folder)
    return Task(file, rules, tuple(overrides))


def describe(task: Task) -> dict[str, Any]:
    """Return where the numbers of a run come from, as plain data; of files those that the run has read."""
    file, rules = task.file, task.rules
    return {
        "scenario": {
            "name": file.scenario.name,
            "file": file.path.name,
            "sha256": file.sha256,
            "overrides": list(task.overrides),
        },
        "rules": {
            role: {
                "file": used.path.name,
                "sha256": used.sha256,
                "files": dict(used.files),
                "params": file.scenario.rules[role].params,
            }
            for role, used in sorted(rules.used.items())
        },
        "laws": {name: {"sha256": used.sha256, "files": dict(used.files)} for name, used in sorted(rules.laws.items())},
        "versions": versions(),
    }


def laws_of(task: Task, controller: str | None) -> tuple[str, ...]:
    """Return the names of the control laws that --controller asks for.

    Raises:
        click.BadParameter: For a word that is neither a law, a group, nor a law beside the scenario; for one that is
            there twice.
    """
    if controller is None:
        return (task.file.scenario.run.controller,)
    words = words_of(controller)
    for word in words:
        require_law(word, task.file.path.parent, "the scenario")
    return tuple(dict.fromkeys(name for word in words for name in laws.group(word)))


def words_of(controller: str) -> tuple[str, ...]:
    """Return the words of --controller, which commas separate.

    Raises:
        click.BadParameter: For a word that is there twice.
    """
    words = tuple(word.strip() for word in controller.split(","))
    require_once("--controller", words)
    return words


def require_law(word: str, folder: Path, scenario: str) -> None:
    """Refuse a word that is neither a law, a group of laws, nor a law in the folder of a scenario."""
    if word in laws.GROUPS or laws.exists(word, folder):
        return
    words = ", ".join(repr(name) for name in (*laws.names(), *laws.GROUPS))
    message = f"{word!r} is not one of {words}, and there is no {word}.fz or {word}.py beside {scenario}."
    raise click.BadParameter(message, param_hint="'--controller'")


def require_once(option: str, words: Sequence[str]) -> None:
    """Refuse a word that an option or argument has twice."""
    twice = next((word for k, word in enumerate(words) if word in words[:k]), None)
    if twice is not None:
        raise click.BadParameter(f"{twice!r} is given twice.", param_hint=f"'{option}'")


def check(task: Task, names: Sequence[str]) -> None:
    """Check a scenario and its rule files for some control laws, and print what there is to warn of.

    Raises:
        DiagnosticError: With every mistake.
    """
    from dwmr.simulation import preflight

    preflight.check(task.file, names, task.rules)
    show([*task.file.warnings, *task.rules.warnings])


def say_stops(trajectories: Iterable[Trajectory]) -> None:
    """Print a warning for every run that ended before its horizon."""
    for one in trajectories:
        if one.stop is not None:
            say(f"warning: {one.controller} stopped at t = {one.stop.t:.3f} s: {one.stop.reason}", err=True)


def simulate(task: Task, names: Sequence[str], begin: Begin | None = None) -> list[Trajectory]:
    """Run a checked scenario under some control laws.

    An interruption keeps the finished laws, and the computed part of the present one.

    Args:
        task: What to run.
        names: Control laws.
        begin: Begins a stage of the command, see `common.stages`; without it there is a display for the stages here.

    Raises:
        DiagnosticError: When the records would not fit into memory.
        KeyboardInterrupt: When it comes before anything is done.
    """
    if begin is None:
        with stages() as begin_stage:
            return _simulate(task, names, begin_stage)
    return _simulate(task, names, begin)


def simulate_whole(task: Task, names: Sequence[str], begin: Begin | None = None) -> list[Trajectory]:
    """Run a checked scenario under some control laws, all of them to the end; arguments as those of `simulate`.

    Raises:
        DiagnosticError: As `simulate` does.
        KeyboardInterrupt: When it comes before all is done.
    """
    trajectories = simulate(task, names, begin)
    if len(trajectories) < len(names) or any(t.stop and t.stop.reason == "interrupted" for t in trajectories):
        raise KeyboardInterrupt
    return trajectories


def _simulate(task: Task, names: Sequence[str], begin: Begin) -> list[Trajectory]:
    # the compiler comes only now, when the run can begin
    display = _Shown(begin)
    from dwmr.core import jit
    from dwmr.simulation import simulate

    if not jit.COMPILED:
        say("numba is not installed: the run is computed in plain Python, about a hundred times slower", err=True)
    trajectories: list[Trajectory] = []
    try:
        with jit.watched(partial(display.report, "compiling", 100)):
            simulations = [simulate.prepare(task.file, name, task.rules) for name in names]
            simulate.require_memory(simulations, task.file.places)
            run = task.file.scenario.run
            if (every := simulations[0].every) > 1 and run.record_every is None:
                step = f"{every} control periods ({every * run.dt:g} s); run.record_every sets it"
                say(f"note: results are computed from a sample every {step}", err=True)
            trajectories.append(_run(simulations[0], display))
        for one in simulations[1:]:
            if trajectories[-1].stop is not None and trajectories[-1].stop.reason == "interrupted":
                break
            display.report(f"compiling {one.name}", 0, 0)
            trajectories.append(_run(one, display))
    except KeyboardInterrupt:
        if not trajectories:
            raise
    return trajectories


def _run(one: Simulation, shown: _Shown) -> Trajectory:
    from dwmr.simulation import simulate

    trajectory = simulate.run(one, partial(shown.report, f"simulating {one.name}", one.scenario.run.steps + 1))
    if trajectory.stop is not None and trajectory.stop.mistake is not None:
        show([trajectory.stop.mistake])
    return trajectory


class _Shown:
    """Reports progress, and begins a stage where the one that shows is another.

    Args:
        begin: Begins a stage of the command.
    """

    def __init__(self, begin: Begin) -> None:
        self._begin, self._name, self._move = begin, "", begin("loading the compiler", 0)

    def report(self, name: str, total: int, done: float) -> None:
        """Report how many steps of a stage are done."""
        if name != self._name:
            self._name, self._move = name, self._begin(name, total)
        self._move(done)
