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
#: Scenario, law and overrides of each run.
RUNS = {
    "two wheels, AIFQSMC": ("undisturbed", "aifqsmc", ("obstacles=[]",)),
    "car, AIFQSMC": ("ackermann", "aifqsmc", ()),
    "car, its own law": ("ackermann", "ackermann", ()),
    "mecanum wheels, AIFQSMC": ("omnidirectional", "aifqsmc", ()),
    "mecanum wheels, their own law": ("omnidirectional", "omnidirectional", ()),
    "two wheels, AIFQSMC, obstacles": ("undisturbed", "aifqsmc", ()),
    "car, AIFQSMC, obstacles": ("ackermann", "aifqsmc", (OBSTACLES,)),
    "car, its own law, obstacles": ("ackermann", "ackermann", (OBSTACLES,)),
    "mecanum wheels, their own law, obstacles": ("omnidirectional", "omnidirectional", (OBSTACLES,)),
}


def result(scenario, law, overrides):
    """Return the root mean square errors of all robots and how many pairs of robots touch."""
    file = read(find(scenario), overrides)
    trajectory = simulate.run(simulate.prepare(file, law, Rules(file.scenario.rules, file.folders, file.places)))
    found = measure(trajectory, file.scenario, ("rmse", "robots_hit"))
    errors = [[round(row[name], 5) for name in NAMES] for row in found["rmse"].values()]
    return {"errors": errors, "hit": len(found["robots_hit"])}


def rows(results):
    """Return the rows of the table in docs/explanation/vehicles.md."""
    for name, one in results.items():
        errors = (" ".join(f"{value:.3f}" for value in robot) for robot in one["errors"])
        yield f"| {name} | {' | '.join(errors)} | {one['hit']} |"


if __name__ == "__main__":
    if "--rows" not in sys.argv:
        RESULT.write_text(json.dumps({name: result(*one) for name, one in RUNS.items()}, indent=1) + "\n", "utf-8")
    print("\n".join(rows(json.loads(RESULT.read_text("utf-8")))))
