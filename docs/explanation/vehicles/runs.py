"""Runs of the formation on other vehicles: `python docs/explanation/vehicles/runs.py [--rows]`."""

import json
import sys
from pathlib import Path

from dwmr.control.fuzzy_gains import Rules
from dwmr.results.metrics import measure
from dwmr.scenario.file import find, read
from dwmr.simulation import simulate

RESULT = Path(__file__).with_name("runs.json")
NAMES = ("x_e", "y_e", "theta_e")
OBSTACLES = "obstacles=[{x=0.0,y=15.5,radius=0.5},{x=8.0,y=-4.25,radius=0.5},{x=-14.5,y=-11.25,radius=0.5}]"
#: The leader's turns and its followers' places as in the paper, in place of those of `ackermann`.
CLOSE = (
    "robots.leader.controllers.ackermann.kappa_max=1.35",
    "robots.follower1.formation={leader='leader',separation=1.25,bearing=2.356194490192345}",
    "robots.follower2.formation={leader='leader',separation=1.25,bearing=-2.356194490192345}",
)
#: Scenario, law and overrides of each run.
RUNS = {
    "two wheels, AIFQSMC": ("undisturbed", "aifqsmc", ("obstacles=[]",)),
    "car, AIFQSMC": ("ackermann", "aifqsmc", ("obstacles=[]", *CLOSE)),
    "car, its own law": ("ackermann", "ackermann", ("obstacles=[]", *CLOSE)),
    "mecanum wheels, AIFQSMC": ("omnidirectional", "aifqsmc", ()),
    "mecanum wheels, their own law": ("omnidirectional", "omnidirectional", ()),
    "two wheels, AIFQSMC, obstacles": ("undisturbed", "aifqsmc", ()),
    "car, AIFQSMC, obstacles": ("ackermann", "aifqsmc", CLOSE),
    "car, its own law, obstacles": ("ackermann", "ackermann", CLOSE),
    "car, AIFQSMC, obstacles, wide turns": ("ackermann", "aifqsmc", ()),
    "car, its own law, obstacles, wide turns": ("ackermann", "ackermann", ()),
    "car, its own law, turned round at the start": (
        *("ackermann", "ackermann"),
        ("obstacles=[]", *CLOSE, "robots.follower1.theta_0=3.0"),
    ),
    "mecanum wheels, their own law, obstacles": ("omnidirectional", "omnidirectional", (OBSTACLES,)),
}


def result(scenario, law, overrides):
    """Return the errors of all robots, how many pairs of robots, and robots and obstacles, touch, and the least gap."""
    file = read(find(scenario), overrides)
    trajectory = simulate.run(simulate.prepare(file, law, Rules(file.scenario.rules, file.folders, file.places)))
    measures = measure(trajectory, file.scenario, ("rmse", "robots_hit", "obstacles_hit", "robot_gap", "obstacle_gap"))
    errors = [[round(row[name], 5) for name in NAMES] for row in measures["rmse"].values()]
    gaps = [gap for key in ("robot_gap", "obstacle_gap") for gap in measures[key].values() if gap is not None]
    hits = len(measures["robots_hit"]), len(measures["obstacles_hit"])
    return {"errors": errors, "hits": hits, "gap": round(min(gaps), 4)}


def rows(results):
    """Return the rows of the table in docs/explanation/vehicles.md."""
    for name, one in results.items():
        errors = (" ".join(f"{value:.3f}" for value in robot) for robot in one["errors"])
        hits = " ".join(str(hit) for hit in one["hits"])
        yield f"| {name} | {' | '.join(errors)} | {hits} | {one['gap']:.2f} |"


if __name__ == "__main__":
    if "--rows" not in sys.argv:
        RESULT.write_text(json.dumps({name: result(*one) for name, one in RUNS.items()}, indent=1) + "\n", "utf-8")
    print("\n".join(rows(json.loads(RESULT.read_text("utf-8")))))
