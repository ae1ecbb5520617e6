"""Where the errors of AIFQSMC and FCAFSMC come from: the start, the obstacles, the limits of drives.

    python docs/explanation/reproduction/shares.py

runs `paper` and `paper-with-limits`, with and without obstacles, and prints the ratios to
Table 12 with two shares of the sum of squares: that of the first 10 s, and that of the obstacles.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from dwmr.control.fuzzy_gains import Rules
from dwmr.results.metrics import errors, printed_frame
from dwmr.results.paper_tables import TABLE_12
from dwmr.scenario.file import find, read
from dwmr.simulation import simulate

SCENARIOS = ("paper", "paper-with-limits")
#: The start, in which the robots find into the formation [s].
START = 10.0


def squares(law: str, scenario: str, *overrides: str) -> tuple[Any, dict[str, dict[str, Any]]]:
    """Return the times of a run, and the squared errors of each robot as Table 12 takes them."""
    file = read(find(scenario), overrides)
    run = simulate.run(simulate.prepare(file, law, Rules(file.scenario.rules, (), file.places)))
    series = {robot: errors(run, robot, printed_frame(file.scenario, robot)) for robot in TABLE_12[law]}
    return run.t, {
        robot: {name: np.square(series[robot][name]) for name in row} for robot, row in TABLE_12[law].items()
    }


def shares(law: str, scenario: str = "paper") -> dict[str, dict[str, dict[str, float]]]:
    """Return for each error of each robot its ratio to Table 12, and its shares from the start and the obstacles."""
    t, whole = squares(law, scenario)
    _, without = squares(law, scenario, "obstacles=[]")
    return {
        robot: {
            name: {
                "ratio": float(np.sqrt(whole[robot][name].mean())) / wanted,
                "start": float(whole[robot][name][t <= START].sum() / whole[robot][name].sum()),
                "obstacles": 1.0 - float(without[robot][name].sum() / whole[robot][name].sum()),
            }
            for name, wanted in printed.items()
        }
        for robot, printed in TABLE_12[law].items()
    }


def main() -> None:
    """Print the ratios and the shares."""
    for scenario in SCENARIOS:
        for law in ("aifqsmc", "fcafsmc"):
            for robot, row in shares(law, scenario).items():
                cells = "  ".join(
                    f"{name} {one['ratio']:.2f}, start {one['start']:.0%}, obstacles {one['obstacles']:.0%}"
                    for name, one in row.items()
                )
                print(f"{scenario}: {law} {robot}: {cells}")


if __name__ == "__main__":
    main()
