"""Commands about scenarios, without a run: `dwmr show`, `dwmr check` and `dwmr new`."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dwmr.cli import run_options
from dwmr.cli.common import mistakes_as_diagnostics, refuse_present
from dwmr.control.rule_files import LAWS
from dwmr.scenario.file import SHIPPED, UnknownScenarioError, read, shipped_names
from fuzzyctl.cli.common import show as show_mistakes
from fuzzyctl.cli.streams import say, write_json
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.experiments.result_files import finite
from fuzzyctl.loading.assembly import files_read
from fuzzyctl.support.files import first_sentence, rules_folder
from fuzzyctl.support.writing import folder_for, write_together

if TYPE_CHECKING:
    from dwmr.cli.run_options import Task
    from fuzzyctl.diagnostics.diagnostic import Diagnostic


@click.command(context_settings={"show_default": True})
@click.argument("scenario", required=False)
@run_options.rules_option
@run_options.set_option
@run_options.format_option
def show(scenario: str | None, rules_folder: Path | None, overrides: tuple[str, ...], style: str) -> None:
    """Print a summary of SCENARIO on one page; without SCENARIO, list the shipped scenarios and control laws.

    The summary has the formation, the path with its length and speeds, the distances of obstacles from it, the
    disturbances in the order of time, the gains of the control laws, and the proved bounds of the rule files. Nothing
    is simulated.
    """
    from dwmr.scenario import overview

    if scenario is None:
        if overrides or rules_folder:
            raise click.UsageError("--set and --rules need a SCENARIO")
        _list(style)
        return
    with mistakes_as_diagnostics(style):
        task = run_options.read(scenario, rules_folder, overrides)
        facts = overview.facts(task.file, task.rules)
    if style == "json":
        write_json(finite(facts))
        return
    for line in _page(facts):
        say(line)


def _list(style: str) -> None:
    """Print the shipped scenarios and control laws with the first sentence of each file."""
    from dwmr.control import laws

    first = {name: first_sentence(SHIPPED / f"{name}.toml") for name in shipped_names()}
    files = {name: laws.shipped_file(name) for name in laws.names()}
    if style == "json":
        write_json({"scenarios": first, "laws": files})
        return
    width = max(map(len, (*first, *files)))
    say("Scenarios")
    for name, text in first.items():
        say(f"  {name:{width}}  {text}")
    say("")
    say("Control laws")
    for name, file in files.items():
        part = laws.zeroed(name)
        sentence = f"with {part} = 0" if part else laws.first_sentence_of(name)
        say(f"  {name:{width}}  {file:{max(map(len, files.values()))}}  {sentence}")


def _page(found: Mapping[str, Any]) -> Iterator[str]:
    run, files = found["run"], found["files"]
    yield f"{found['name']}: {', which extends '.join(files)}"
    yield (
        f"{run['horizon']:g} s in periods of {1000 * run['dt']:g} ms with {run['substeps']} substeps, under "
        f"{run['controller']}" + ("; robots are rigid bodies in MuJoCo" if run["plant"] == "mujoco" else "")
    )
    for title, lines in (
        ("Reference", _reference(found["reference"])),
        ("Robots", _robots(found["robots"], found["formation"])),
        ("Obstacles", _obstacles(found["obstacles"], found["avoidance"], found.get("safety"))),
        ("Disturbances", _disturbances(found["disturbances"], found["load"])),
        ("Controllers", _controllers(found["controllers"])),
        ("Rule files", _rules(found["rules"])),
    ):
        yield ""
        yield title
        yield from (f"  {line}" for line in lines)


def _reference(one: Mapping[str, Any]) -> Iterator[str]:
    slow, fast = one["speed"]
    yield (
        f"{one['kind']}: {one['length']:.4g} m in {one['time']:g} s, x from {one['x'][0]:.4g} to {one['x'][1]:.4g} m, "
        f"y from {one['y'][0]:.4g} to {one['y'][1]:.4g} m"
    )
    yield (
        f"speed {slow:.3g} to {fast:.3g} m/s, turn rate {one['turn_rate'][0]:.3g} to {one['turn_rate'][1]:.3g} rad/s"
        if fast - slow > 1e-3 * fast
        else f"speed {fast:.3g} m/s, turn rate {one['turn_rate'][0]:.3g} to {one['turn_rate'][1]:.3g} rad/s"
    )
    if one["straight_from"] is not None:
        yield f"straight on from {one['straight_from']:.6g} s"


def _robots(robots: Sequence[Mapping[str, Any]], formation: Mapping[str, str]) -> Iterator[str]:
    width = max(2 * r["depth"] + len(r["name"]) for r in robots)
    for one in robots:
        name = "  " * one["depth"] + one["name"]
        x, y, theta = one["start"]
        words = [f"start ({x:g}, {y:g}) m, {theta:g} rad", f"d = {one['d']:g} m"]
        words.insert(0, _place(one))
        if one["avoids_obstacles"]:
            words.append("avoids obstacles")
        if one["noise"]:
            words.append("measures with noise " + ", ".join(f"{k} {v:g}" for k, v in one["noise"].items() if v))
        if one["sensors"]["pose"] == "odometry":
            words.append("knows its posture by odometry")
        if one["sensors"]["encoder_steps"]:
            words.append(f"encoders of {one['sensors']['encoder_steps']} steps")
        yield f"{name:{width}}  {'; '.join(words)}"
    if formation["leader_velocity"] == "wheels":
        yield "followers know the velocity of their leader's wheels, not its slip"


def _place(one: Mapping[str, Any]) -> str:
    """Describe the place of a robot."""
    if one["formation"] is None:
        path = f"on its own {one['reference']['kind']}" if "reference" in one else "on the reference"
        return path + (f", {one['delay']:g} s behind" if one["delay"] else "")
    edges = one.get("neighbours", [{**one, "weight": 1.0}])
    return " and ".join(
        (f"{edge['weight']:.3g} x " if len(edges) > 1 else "")
        + f"{edge['separation']:g} m at {edge['bearing']:.4g} rad from {edge['leader'] or 'the reference as a body'}"
        for edge in edges
    )


def _obstacles(
    obstacles: Sequence[Mapping[str, float]], avoidance: Mapping[str, float], safety: Mapping[str, float] | None
) -> Iterator[str]:
    if not obstacles:
        yield "none"
    for k, one in enumerate(obstacles):
        yield (
            f"obstacles.{k}: radius {one['radius']:g} m at ({one['x']:g}, {one['y']:g}) m; centre "
            f"{one['from_path']:.2f} m from the path at {one['at']:.1f} s"
            + (f"; moves from there at up to {one['speed']:.3g} m/s" if "speed" in one else "")
        )
    if obstacles:
        yield (
            f"avoided from {avoidance['margin']:g} m and the robot's radius beyond them, farther at speed, up to "
            f"{avoidance['largest_radius']:g} m from the centre"
        )
    if safety:
        yield (
            f"safety filter: all robots, {safety['margin']:g} m beyond discs about points {safety['lookahead']:g} m "
            f"ahead of their axles; alpha {safety['alpha']:g} 1/s"
        )


def _disturbances(disturbances: Sequence[Mapping[str, Any]], load: Mapping[str, float]) -> Iterator[str]:
    events = [(one["start"], one["stop"], _disturbance(one)) for one in disturbances]
    if load["mass_factor"] != 1.0 or load["inertia_factor"] != 1.0:
        what = f"load, mass x {load['mass_factor']:g}, inertia x {load['inertia_factor']:g}"
        events.append((load["start"], load["stop"], what))
    if not events:
        yield "none"
    for start, stop, what in sorted(events):
        yield f"{start:6g} to {f'{stop:g} s:':8} {what}"


def _disturbance(one: Mapping[str, Any]) -> str:
    kind = f"sinusoid of {one['angular_frequency']:g} rad/s" if one["kind"] == "sinusoid" else one["kind"]
    kind += f", {one['phase']:g} rad at t = 0" if one["phase"] else ""
    parts = (("v", "m/s"), ("omega", "rad/s"), ("force", "N"), ("torque", "N m"))
    amounts = ", ".join(f"{name} {one[name]:g} {unit}" for name, unit in parts if one[name])
    whom = f", on {', '.join(one['robots'])}" if one["robots"] else ""
    return f"{kind}, {amounts or 'nothing'}{whom}"


def _controllers(laws: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> Iterator[str]:
    from dwmr.scenario.overview import common

    for law, tables in laws.items():
        shared = common(tables, list(tables))
        yield f"{law}: {_gains(shared)}"
        for robot, gains in tables.items():
            differences = {k: v for k, v in gains.items() if k not in shared}
            if differences:
                yield f"  {robot}: {_gains(differences)}"


def _gains(gains: Mapping[str, Any]) -> str:
    return ", ".join(f"{k} {v:g}" if isinstance(v, int | float) else f"{k} {v}" for k, v in gains.items()) or "no gains"


def _rules(rules: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    for role, one in rules.items():
        low, high = one["bounds"]
        yield f"{role}: {one['file']}, {one['rules']} rules; proved: {low:g} <= {one['output']} <= {high:g}"
        params = _gains(one["params"]) if one["params"] else ""
        gain = f"; proved: G_AIS >= {one['g_ais_min']:.6g} m/s or rad/s" if "g_ais_min" in one else ""
        if params:
            yield f"  {params}{gain}"


@click.command(context_settings={"show_default": True})
@click.argument("scenarios", nargs=-1, required=True, metavar="SCENARIO...")
@run_options.rules_option
@run_options.set_option
@click.option("--format", "style", type=click.Choice(["text", "json"]), default="text", help="How to print.")
def check(scenarios: tuple[str, ...], rules_folder: Path | None, overrides: tuple[str, ...], style: str) -> None:
    """Check SCENARIOs, shipped names or TOML files, and their rule files, without a simulation.

    The rule files of all control laws that a scenario has gains for are read, and their guarantees are proved.
    """
    reported: list[Diagnostic] = []
    for scenario in scenarios:
        diagnostics, summary = _check(scenario, rules_folder, overrides)
        reported += [d for d in diagnostics if d not in reported]
        if style == "text" and summary:
            say(summary)
    if style == "json" or reported:
        show_mistakes(reported, style)
    if any(d.severity == "error" for d in reported):
        sys.exit(1)


def _check(scenario: str, rules_folder: Path | None, overrides: Sequence[str]) -> tuple[list[Diagnostic], str]:
    """Return the diagnostics of one scenario, and what to say of it if it has no errors."""
    try:
        task = run_options.read(scenario, rules_folder, overrides)
    except DiagnosticError as error:
        return list(error.diagnostics), ""
    warnings, laws = [*task.file.warnings], _laws(task)
    try:
        from dwmr.simulation import preflight

        preflight.check(task.file, laws, task.rules)
    except DiagnosticError as error:
        return [*warnings, *task.rules.warnings, *error.diagnostics], ""
    robots, kind = len(task.file.scenario.robots), task.file.scenario.reference.kind
    summary = (
        f"{scenario}: {robots} robot{'s' if robots != 1 else ''} on a reference of kind {kind}; "
        f"{', '.join(laws)}: no errors"
    )
    return [*warnings, *task.rules.warnings], summary


def _laws(task: Task) -> tuple[str, ...]:
    """Return the laws to check: those that some robot has gains for, and the scenario's own choice."""
    from dwmr.scenario.overview import laws_of

    scenario = task.file.scenario
    return tuple(dict.fromkeys([*laws_of(scenario.robots.values()), scenario.run.controller]))


#: Valid names, which become names of files.
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,99}")


@click.command(context_settings={"show_default": True})
@click.argument("name", required=False)
@click.option("--from", "base", default="paper", metavar="SCENARIO", help="Shipped scenario to start from.")
@click.option(
    "--extends",
    is_flag=True,
    help="Write only the name and what it extends, instead of a whole copy.",
)
@click.option(
    "-o",
    "--output",
    "path",
    type=click.Path(path_type=Path),
    show_default="NAME.toml",
    metavar="FILE",
    help="File to write.",
)
@click.option(
    "--rules",
    "folder",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Copy the rule files that the shipped scenario uses to this folder, for --rules of other commands.",
)
@click.option("--force", is_flag=True, help="Replace files that exist.")
def new(name: str | None, base: str, extends: bool, path: Path | None, folder: Path | None, force: bool) -> None:
    """Write a scenario NAME to start from: a copy of a shipped one with all its comments.

    A CSV file that the shipped scenario reads is written beside it. NAME may be left out with --rules.
    """
    if name is None and (folder is None or path is not None or extends):
        raise click.UsageError("NAME is missing; only --rules DIR works without it")
    if name is not None and not NAME.fullmatch(name):
        raise click.BadParameter(
            "a name has up to 100 letters, digits, - and _, and begins with a letter or a digit", param_hint="'NAME'"
        )
    if name in shipped_names():
        raise click.BadParameter(f"{name} is the name of a shipped scenario; take another one", param_hint="'NAME'")
    try:
        files = _files(name, base, path or Path(f"{name}.toml"), extends) if name is not None else {}
        files |= _rule_files(base, folder) if folder is not None else {}
    except UnknownScenarioError as error:
        raise click.BadParameter(str(error), param_hint="'--from'") from error
    with mistakes_as_diagnostics("text"):
        refuse_present(files, force, folder)
        with folder_for(folder) if folder is not None else nullcontext():
            write_together(files)
    for one in files:
        say(f"wrote {one}")


def _files(name: str, base: str, path: Path, extends: bool) -> dict[Path, str]:
    """Return the texts to write by path: the scenario first, then the CSV file that it reads.

    Args:
        name: The scenario's name.
        base: Name of the shipped scenario to start from.
        path: Where the scenario goes.
        extends: Whether it extends the shipped one instead of copying it.

    Raises:
        UnknownScenarioError: When there is no such shipped scenario.
    """
    _require_shipped(base)
    if extends:
        return {path: _EXTENDING.format(base=base, name=name)}
    text = (SHIPPED / f"{base}.toml").read_text(encoding="utf-8")
    renamed = re.sub(r'^name = ".*"$', f'name = "{name}"', text, count=1, flags=re.MULTILINE)
    beside = getattr(read(SHIPPED / f"{base}.toml").scenario.reference, "file", None)
    if beside is not None:
        renamed = renamed.replace(beside, f"{path.stem}.csv")
    head = f"# Made by `dwmr new` from {base}; `dwmr check {path.name}` finds mistakes.\n#\n"
    files = {path: head + renamed}
    if beside is not None:
        files[path.with_suffix(".csv")] = (SHIPPED / beside).read_text(encoding="utf-8")
    return files


def _rule_files(base: str, folder: Path) -> dict[Path, str]:
    """Return copies of the rule files that a shipped scenario and the control laws use, by their path in a folder.

    Raises:
        UnknownScenarioError: When there is no such shipped scenario.
    """
    _require_shipped(base)
    named = read(SHIPPED / f"{base}.toml").scenario.rules.values()
    paths = {rules_folder() / name for name in (*(rule.file for rule in named), *LAWS.values())}
    paths |= {used for path in paths for used in files_read(path)}
    return {folder / path.name: path.read_text(encoding="utf-8") for path in sorted(paths)}


def _require_shipped(base: str) -> None:
    if base not in shipped_names():
        hint = did_you_mean(base, shipped_names())
        message = f"no shipped scenario {base[:200]!r}; there are {', '.join(shipped_names())}"
        raise UnknownScenarioError(message + (f"; {hint}" if hint else ""))


_EXTENDING = """\
# {name}: {base} with other values.
#
# What stands here replaces the value of {base}, key by key; lists such as obstacles are replaced whole. `dwmr show
# {base}` prints what it says.

extends = "{base}"
name = "{name}"

[run]
# horizon = 60.0                    # s
"""
