"""`dwmr show SCENARIO`: summary of a scenario on one page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dwmr.cli import run_options
from dwmr.cli.common import mistakes_as_diagnostics
from fuzzyctl.cli.streams import say, write_json

if TYPE_CHECKING:
    from dwmr.cli.run_options import Task


@click.command(context_settings={"show_default": True})
@click.argument("scenario", required=False)
@run_options.rules_option
@run_options.set_option
@run_options.format_option
def show(scenario: str | None, rules_folder: Path | None, overrides: tuple[str, ...], style: str) -> None:
    """Print what SCENARIO says on one page; without SCENARIO, the shipped scenarios and control laws.

    Shown are the formation, the path with its length and speeds, how far the obstacles are from it, the disturbances in
    the order of time, the gains of the control laws, and what is proved of the rule files. Nothing is simulated.
    """

    if scenario is None:
        if overrides or rules_folder:
            raise click.UsageError("--set and --rules need a SCENARIO")
        _list(style)
        return
    with mistakes_as_diagnostics(style):
        task = run_options.read(scenario, rules_folder, overrides)
        facts = _facts(task)
    if style == "json":
        from fuzzyctl.experiments.result_files import finite

        write_json(finite(facts))
        return
    for line in _page(facts):
        say(line)


def _facts(task: Task) -> dict[str, Any]:
    from dwmr.scenario.overview import facts

    return facts(task.file, task.rules)


def _list(style: str) -> None:
    """Print the shipped scenarios and control laws with the first sentence of each file."""

    from dwmr.control import laws
    from dwmr.scenario.file import SHIPPED, shipped_names
    from fuzzyctl.support.shipped import first_sentence, rules_folder

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
        sentence = f"with {part} = 0" if part else first_sentence(rules_folder() / file)
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
        if one["leader"] is None:
            words.insert(0, "on the reference" + (f", {one['delay']:g} s behind" if one["delay"] else ""))
        else:
            words.insert(0, f"{one['separation']:g} m at {one['bearing']:.4g} rad from {one['leader']}")
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
