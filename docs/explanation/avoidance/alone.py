"""Runs the leader of the paper's path alone, with and without the safety filter, and compares its errors.

python alone.py [--horizon S]
"""

from __future__ import annotations

import argparse
import dataclasses

import numpy as np

from dwmr.control.fuzzy_gains import Rules
from dwmr.results.metrics import errors, rmse
from dwmr.scenario.file import find, read
from dwmr.simulation import simulate

LAWS = ("aifqsmc", "fcafsmc", "smc")
#: Settings of the filter.
SAFETY = (
    "safety={alpha=1.0,lookahead=0.3,margin=0.0,velocity_error=0.1,acceleration=3.0,angular_acceleration=6.0}"
)  # fmt: skip


def run(law: str, horizon: float, *overrides: str) -> simulate.Trajectory:
    """Run the leader without its followers and without obstacles, with the disturbances of `paper-with-limits`."""
    file = read(find("paper-with-limits"), ("obstacles=[]", f"run.horizon={horizon}", *overrides))
    leader = file.scenario.model_copy(update={"robots": {"leader": file.scenario.robots["leader"]}})
    file = dataclasses.replace(file, scenario=leader)
    return simulate.run(simulate.prepare(file, law, Rules(leader.rules, file.folders, file.places)))


def main() -> None:
    """Print the errors of each law without the filter, and by how much they differ with it."""
    options = argparse.ArgumentParser()
    options.add_argument("--horizon", type=float, default=200.0)
    horizon = options.parse_args().horizon
    for law in LAWS:
        free, guarded = run(law, horizon), run(law, horizon, SAFETY)
        before, after = (errors(one, "leader", "body") for one in (free, guarded))
        values = ", ".join(f"{name} {rmse(before[name]):.4f}" for name in ("x_e", "y_e", "theta_e"))
        differs = max(float(np.abs(before[name] - after[name]).max()) for name in before)
        print(f"{law}: {values}; with the filter they differ by {differs:g} at most")


if __name__ == "__main__":
    main()
