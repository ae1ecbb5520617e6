"""The graph of a formation: which robot follows which, and on what way each knows the reference."""

from __future__ import annotations

from collections.abc import Iterable

from dwmr.scenario.model import Edge, Scenario
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.experiments.scenario_keys import Places

#: Most robots of a circle that a message names.
_LONGEST = 12


def nearest(scenario: Scenario) -> dict[str, Edge | None]:
    """Return the edge of each robot on its shortest way to a reference, None for a robot on one.

    A robot comes after the leader of its edge; robots without a way are left out.
    """
    followers: dict[str, list[tuple[str, Edge]]] = {}
    for name, robot in scenario.robots.items():
        for edge in robot.edges:
            if edge.leader is not None:
                followers.setdefault(edge.leader, []).append((name, edge))
    edges = {name: next(iter(robot.edges), None) for name, robot in scenario.robots.items() if not robot.leaders}
    waiting = list(edges)
    for leader in waiting:  # grows
        for name, edge in followers.get(leader, []):
            if name not in edges:
                edges[name] = edge
                waiting.append(name)
    return edges


def way(scenario: Scenario, name: str) -> list[tuple[str, Edge | None]]:
    """Return the robots on the shortest way from a reference to a robot, each with its edge."""
    edges, robots = nearest(scenario), [name]
    while (edge := edges[robots[-1]]) is not None and edge.leader is not None:
        robots.append(edge.leader)
    return [(one, edges[one]) for one in reversed(robots)]


def in_order(scenario: Scenario) -> dict[str, int]:
    """Return the robots as a tree is read, each leader right before its followers, with their depth in the tree."""
    followers: dict[str | None, list[str]] = {}
    edges = nearest(scenario)
    for name in scenario.robots:
        edge = edges[name]
        followers.setdefault(edge.leader if edge else None, []).append(name)
    depths: dict[str, int] = {}
    waiting = [(name, 0) for name in reversed(followers.get(None, []))]
    while waiting:
        name, depth = waiting.pop()
        depths[name] = depth
        waiting += [(below, depth + 1) for below in reversed(followers.get(name, []))]
    return depths


def followed(scenario: Scenario, name: str) -> str:
    """Return the names of the leaders of a robot in the formation."""
    return ", ".join(scenario.robots[name].leaders) or "the body of the virtual structure"


def formation_mistakes(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Refuse leaders that do not exist, robots without a way to the reference, and keys of robots on a reference."""
    names = tuple(scenario.robots)
    edges = nearest(scenario)
    circles: dict[frozenset[str], list[Diagnostic]] = {}
    for name, robot in scenario.robots.items():
        for k, edge in enumerate(robot.edges):
            key = f"robots.{name}.formation.{edge.key}"
            if edge.leader is not None and edge.leader not in names:
                yield unknown(places, key, edge.leader, "robot", names)
            elif edge.leader == name:
                yield places.diagnostic("FZ904", key, f"{key} = {name!r}: a robot cannot follow itself")
            elif k == 0 and name not in edges and (circle := _circle(scenario, name)):
                chain = circle if len(circle) <= _LONGEST else (*circle[: _LONGEST - 2], "...", name)
                message = f"{key} leads back to {name}: {' -> '.join(chain)}; some robot must follow the reference"
                circles.setdefault(frozenset(circle), []).append(places.diagnostic("FZ904", key, message))
        if robot.formation is not None and name not in robot.leaders:
            yield from _on_reference_only(scenario, name, places)
    for each in circles.values():  # one of each, if possible in the scenario itself and not in one that it extends
        yield next((one for one in each if not one.span or one.span.source.name == places.source.name), each[0])


def _on_reference_only(scenario: Scenario, name: str, places: Places) -> Iterable[Diagnostic]:
    """Refuse keys of a robot in the formation that are for robots on a reference."""
    robot, only = scenario.robots[name], f"{name} follows {followed(scenario, name)}: only a robot on the reference"
    for key, value, has in (
        ("avoids_obstacles", "= true", "avoids" if robot.avoids_obstacles else ""),
        ("delay", f"= {robot.delay:g} s", "has a delay" if robot.delay else ""),
        ("reference", f"of kind {getattr(robot.reference, 'kind', '')!r}", "has its own" if robot.reference else ""),
    ):
        if has:
            key = f"robots.{name}.{key}"
            yield places.diagnostic("FZ904", key, f"{key} {value}, but {only} {has}")


def _circle(scenario: Scenario, name: str) -> tuple[str, ...]:
    """Return the way from a robot over the first leader of each back to itself, or nothing."""
    robots = {name: None}  # in order
    last = name
    while (leaders := scenario.robots[last].leaders) and leaders[0] in scenario.robots:
        last = leaders[0]
        if last in robots:
            return (*robots, name) if last == name else ()
        robots[last] = None
    return ()


def unknown(
    places: Places, key: str, name: str, kind: str, known: tuple[str, ...], facts: tuple[str, ...] = ()
) -> Diagnostic:
    """Describe a value that names no robot or control law."""
    message = f"{key} names an unknown {kind} {name!r}"
    facts = (f"there are {', '.join(known)}", *facts)
    return places.diagnostic("FZ904", key, message, facts=facts, help=did_you_mean(name, known))
