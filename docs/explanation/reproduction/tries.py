"""Runs the readings of tries.toml and writes tries.json; with --rows it prints the page's table from tries.json.

python tries.py [--rows]
"""

from __future__ import annotations

import json
import sys
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from dwmr.control.fuzzy_gains import Rules
from dwmr.results.metrics import errors, printed_frame, rmse
from dwmr.results.paper_tables import TABLE_12
from dwmr.scenario.file import find, read
from dwmr.simulation import simulate

HERE = Path(__file__).parent
NAMES = ("x_e", "y_e", "theta_e")


def run(law: str, overrides: Sequence[str]) -> dict[str, dict[str, float]]:
    """Return the errors of one run by robot; without robots when it ended early."""
    file = read(find("paper-with-limits"), overrides)
    rules = Rules(file.scenario.rules, file.folders, file.places)
    trajectory = simulate.run(simulate.prepare(file, law, rules))
    if trajectory.stop is not None:
        return {}
    by_robot = {}
    for robot in trajectory.robots:
        by_name = errors(trajectory, robot, printed_frame(file.scenario, robot))
        by_robot[robot] = {name: round(rmse(by_name[name]), 5) for name in (*NAMES, "theta_e_unwrapped")}
    return by_robot


def tries() -> list[dict[str, Any]]:
    """Return the readings of tries.toml."""
    readings: list[dict[str, Any]] = tomllib.loads((HERE / "tries.toml").read_text(encoding="utf-8"))["tries"]
    return readings


def rows(results: Sequence[dict[str, Any]]) -> Iterator[str]:
    """Yield the rows of the page's table."""
    for one in results:
        runs = one["errors"]
        cells = [one["name"], _span(runs)]
        for robot in TABLE_12["smc"]:
            cells.append(" ".join(_number(runs["smc"].get(robot, {}).get(name)) for name in NAMES))
        cells.append(_number(runs["smc"].get("leader", {}).get("theta_e_unwrapped")))
        yield f"| {' | '.join(cells)} |"


def _span(runs: dict[str, Any]) -> str:
    ratios = [
        runs[law][robot][name] / printed
        for law in ("aifqsmc", "fcafsmc")
        for robot, row in TABLE_12[law].items()
        if robot in runs[law]
        for name, printed in row.items()
    ]
    return f"{_number(min(ratios))} to {_number(max(ratios))}" if len(ratios) == 18 else "a run ended early"


def _number(value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.2f}" if value < 100 else f"{value:.0f}"


def main() -> None:
    """Run all readings, or print the rows."""
    results = HERE / "tries.json"
    if "--rows" in sys.argv[1:]:
        print("\n".join(rows(json.loads(results.read_text(encoding="utf-8")))))
        return
    done = [{**one, "errors": {law: run(law, one["set"]) for law in TABLE_12}} for one in tries()]
    part = results.with_suffix(".part")
    part.write_text(json.dumps(done, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    part.replace(results)


if __name__ == "__main__":
    main()
