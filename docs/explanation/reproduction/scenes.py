"""Runs the leader of the paper's scenario among obstacles and counts the scenes in which it comes too close.

python scenes.py [--law LAW] [--obstacles N] [--apart M] [--aside M] [--scenes N] [--seed N]
    draws random scenes
python scenes.py --grid [--law LAW]
    places one obstacle at a time, everywhere along the path and to its sides
python scenes.py --all
    runs all cases that the page names and writes scenes.json
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from dwmr.control.fuzzy_gains import Rules
from dwmr.results.metrics import distances
from dwmr.scenario.file import find, read
from dwmr.scenario.model import Obstacle
from dwmr.simulation import simulate

#: Radius of every obstacle [m].
RADIUS = 0.5
#: r_a + R_R, the distance at which the robot touches the obstacle [m].
CLOSEST = RADIUS + 0.56
#: Obstacles nearer to the start than this are in the robot's way before it has reached the path [m].
FROM_START = 6.0
START = (-1.0, 1.0)
#: Draws after which a scene is begun anew.
MOST_DRAWS = 300
#: When the path turns most narrowly [s], with a radius of 1.8 m.
TURNS = (26.0, 74.0, 126.0, 174.0)
RESULTS = Path(__file__).with_name("scenes.json")

Place = tuple[float, float]
LeastDistances = Callable[[Sequence[Place]], list[float]]


class Case(NamedTuple):
    """Random scenes: how many obstacles, how far from each other and from the path [m], drawn from which seed."""

    law: str = "aifqsmc"
    obstacles: int = 4
    apart: float = 14.0
    aside: float = 0.75
    scenes: int = 600
    seed: int = 0

    def drawn(self) -> Iterator[list[Place]]:
        """Yield the places of the obstacles of every scene."""
        random = np.random.default_rng(self.seed)
        for _ in range(self.scenes):
            yield scene(random, self.obstacles, self.apart, self.aside)


#: The cases of the page: 14 m with three seeds under each law, then obstacles nearer to each other, then farther aside.
CASES = (
    *(Case("aifqsmc", seed=seed) for seed in range(3)),
    *(Case("fcafsmc", aside=0.4, seed=seed) for seed in range(3)),
    *(Case("aifqsmc", obstacles=5, apart=apart) for apart in (4.0, 6.0, 8.0, 10.0)),
    Case("aifqsmc", aside=1.0),
    Case("fcafsmc", aside=0.75),
)


def beside_path(t: float, aside: float) -> Place:
    """Return the place beside the paper's eight [m]: `t` is the time on the path [s], `aside` to its left [m]."""
    w = 2.0 * math.pi / 200.0
    x, y = 15.0 * math.sin(2.0 * w * t), 15.0 * math.sin(w * t)
    ahead = math.atan2(math.cos(w * t), 2.0 * math.cos(2.0 * w * t))
    return x - aside * math.sin(ahead), y + aside * math.cos(ahead)


def when_beside(place: Place) -> float:
    """Return when the path is nearest to a place [s], to 0.1 s."""
    return min((0.1 * k for k in range(2000)), key=lambda t: math.dist(place, beside_path(t, 0.0)))


def are_apart(places: Sequence[Place], apart: float) -> bool:
    """Return whether obstacles are `apart` from each other [m] and away from the start."""
    pairs = ((a, b) for k, a in enumerate(places) for b in places[:k])
    return all(math.dist(a, START) > FROM_START for a in places) and all(math.dist(a, b) >= apart for a, b in pairs)


def scene(random: np.random.Generator, count: int, apart: float, aside: float) -> list[Place]:
    """Draw the places of some obstacles: anywhere along the path, up to `aside` from it, at least `apart` [m]."""
    places: list[Place] = []
    tried = 0
    while len(places) < count:
        one = beside_path(float(random.uniform(0.0, 200.0)), float(random.uniform(-aside, aside)))
        tried += 1
        if are_apart([*places, one], apart):
            places.append(one)
        elif tried > MOST_DRAWS:  # those that are there leave no room for another one
            places, tried = [], 0
    return places


def leader_alone(law: str) -> LeastDistances:
    """Return a function that runs the leader around obstacles, disturbed as in the paper: its least distances [m]."""
    file = read(find("paper-with-limits"))
    robots = {"leader": file.scenario.robots["leader"]}
    file = dataclasses.replace(file, scenario=file.scenario.model_copy(update={"robots": robots}))
    prepared = simulate.prepare(file, law, Rules(file.scenario.rules, file.folders, file.places))

    def least_distances(places: Sequence[Place]) -> list[float]:
        obstacles = tuple(Obstacle(x=x, y=y, radius=RADIUS) for x, y in places)
        scenario = file.scenario.model_copy(update={"obstacles": obstacles})
        trajectory = simulate.run(dataclasses.replace(prepared, scenario=scenario))
        return [float(one) for one in distances(trajectory, scenario, "leader").min(axis=0)]

    return least_distances


def count(case: Case) -> dict[str, Any]:
    """Run random scenes: the nearest of them, and those too close."""
    least_distances = leader_alone(case.law)
    close, nearest = [], {"scene": -1, "centre_distance": math.inf}
    for number, places in enumerate(case.drawn()):
        least = least_distances(places)
        here = {"scene": number, "centre_distance": round(min(least), 4)}
        if here["centre_distance"] < nearest["centre_distance"]:
            nearest = here
        if min(least) < CLOSEST:
            at = least.index(min(least))
            alone = round(least_distances([places[at]])[0], 4)
            close.append({**here, "after": since_the_one_before(places, at), "alone": alone})
    return {**case._asdict(), "nearest": nearest, "close": close}


def since_the_one_before(places: Sequence[Place], at: int) -> float | None:
    """Return the time on the path from the obstacle before to obstacle `at` [s], none for the first."""
    when = [when_beside(place) for place in places]
    before = [one for one in when if one < when[at]]
    return round(when[at] - max(before), 1) if before else None


def grid(law: str) -> dict[str, Any]:
    """Run the leader around one obstacle at a time, every 2 s along the path and every 0.2 m up to 2 m to its sides."""
    least_distances = leader_alone(law)
    spots = [(2.0 * k, 0.2 * j) for k in range(100) for j in range(-10, 11)]
    spots = [one for one in spots if are_apart([beside_path(*one)], 0.0)]
    least = [least_distances([beside_path(*one)])[0] for one in spots]
    close = [
        {"t": t, "aside": round(aside, 1), "centre_distance": round(one, 4)}
        for (t, aside), one in zip(spots, least, strict=True)
        if one < CLOSEST
    ]
    return {"law": law, "scenes": len(spots), "close": close}


def described(case: dict[str, Any]) -> str:
    """Describe random scenes: for each too close, when its obstacle came and if it was alone."""
    rows = []
    for one in case["close"]:
        when = "as the first" if one["after"] is None else f"{one['after']:g} s after the one before"
        rows.append(f"\n  scene {one['scene']}: {one['centre_distance']:.3f} m, {when}; alone {one['alone']:.3f} m")
    return (
        f"{case['law']}, {case['obstacles']} obstacles {case['apart']:g} m apart within {case['aside']:g} m, seed "
        f"{case['seed']}: {len(rows)} of {case['scenes']} scenes closer than {CLOSEST:g} m; the nearest "
        f"{case['nearest']['centre_distance']:.3f} m{''.join(rows)}"
    )


def grid_described(case: dict[str, Any]) -> str:
    """Describe the grid: the places passed too close, and their distance from a turn."""
    rows = [
        f"  {one['t']:g} s, {one['aside']:g} m to the left: {one['centre_distance']:.3f} m" for one in case["close"]
    ]
    title = f"{case['law']}: {len(rows)} of {case['scenes']} single obstacles closer than {CLOSEST:g} m"
    if not rows:
        return title
    aside = [abs(one["aside"]) for one in case["close"]]
    from_turn = max(min(abs(one["t"] - turn) for turn in TURNS) for one in case["close"])
    return "\n".join([
        title, *rows,
        f"  {min(aside):g} to {max(aside):g} m beside the path, at most {from_turn:g} s from a turn at "
        f"{', '.join(f'{turn:g}' for turn in TURNS)} s",
    ])  # fmt: skip


def run_all() -> None:
    """Run all scenes of the page and write their results, completely or not at all."""
    results: dict[str, Any] = {"grid": [], "random": []}
    with ProcessPoolExecutor() as pool:
        grids, cases = pool.map(grid, ("aifqsmc", "fcafsmc")), pool.map(count, CASES)
        for one in grids:
            results["grid"].append(one)
            print(grid_described(one), flush=True)
        for one in cases:
            results["random"].append(one)
            print(described(one), flush=True)
    part = RESULTS.with_suffix(".part")
    part.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    part.replace(RESULTS)


def main() -> None:
    """Run the scenes of the options."""
    options = argparse.ArgumentParser()
    for name, default in Case._field_defaults.items():
        options.add_argument(f"--{name}", type=type(default), default=default)
    options.add_argument("--grid", action="store_true")
    options.add_argument("--all", action="store_true")
    chosen = vars(options.parse_args())
    if chosen.pop("all"):
        run_all()
    elif chosen.pop("grid"):
        print(grid_described(grid(chosen["law"])))
    else:
        print(described(count(Case(**{key: one for key, one in chosen.items() if key != "grid"}))))


if __name__ == "__main__":
    main()
