"""Search for disturbances that bring all 27 entries of Table 12 near, the angle of SMC's leader included.

    python docs/explanation/reproduction/calibrate.py [SCENARIO] [--parameters NAMES] [--generations N] [--seed S]
        [--jobs N] [-o FILE]

Without arguments it searches on `paper` for the values of `paper-lost-turn`, in about five minutes of CPU. Each
generation draws some sets within the bounds, signs free, and changes the best ones so far. Of an entry with a ratio r
to Table 12 the miss is |ln r|, of angles that are not wrapped; the cost of a set is the sum of (miss − ln 1.35)² over
the misses beyond ln 1.35. Runs under SMC come first; only sets that it brings within a factor 2.2 are run under the
other laws. Of the best sets the one is chosen whose neighbours keep the property most often: all entries within a
factor 1.5, and θ_e of SMC's leader above 2.6 rad. With --generations 0 the scenario's own values are judged. The result
goes to FILE as JSON.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import runs

from dwmr.results.paper_tables import TABLE_12
from dwmr.scenario.file import UnknownScenarioError, find, read
from fuzzyctl.diagnostics.diagnostic import DiagnosticError


class Parameter(NamedTuple):
    """A value to search for: the keys that take it, its bounds and their unit."""

    keys: tuple[str, ...]
    low: float
    high: float
    unit: str


def _disturbances(numbers: Sequence[int], name: str, most: float, unit: str) -> Parameter:
    return Parameter(tuple(f"disturbances.{k}.{name}" for k in numbers), -most, most, unit)


#: No law could fail alone beyond AIFQSMC's largest gain of 0.65; the reference turns at up to 0.18 rad/s.
PARAMETERS = {
    "sinusoid_v": _disturbances((0, 2), "v", 0.35, "m/s"),
    "sinusoid_omega": _disturbances((0, 2), "omega", 0.35, "rad/s"),
    "frequency": Parameter(tuple(f"disturbances.{k}.angular_frequency" for k in (0, 2)), 0.4, 5.0, "rad/s"),
    "first_v": _disturbances((1,), "v", 0.4, "m/s"),
    "first_omega": _disturbances((1,), "omega", 0.45, "rad/s"),
    "second_v": _disturbances((3,), "v", 0.4, "m/s"),
    "second_omega": _disturbances((3,), "omega", 0.45, "rad/s"),
    "constant_v": _disturbances((1, 3), "v", 0.4, "m/s"),
    "constant_omega": _disturbances((1, 3), "omega", 0.45, "rad/s"),
}
USUAL = ("sinusoid_v", "sinusoid_omega", "frequency", "first_v", "first_omega", "second_v", "second_omega")
#: Sets of a generation, sets that are kept, and candidates that are judged by neighbours.
SIZE, KEPT, CANDIDATES = 240, 60, 5
#: Beyond the first factor a miss costs; the second one ends the runs of a set.
FREE, HOPELESS = 1.35, 2.2
#: The property: the factor of all entries, and θ_e of SMC's leader [rad].
FACTOR, ANGLE = 1.5, 2.6
#: Neighbours of a candidate and of the choice, and how far each value is away.
FEW, MANY, NEAR, FAR = 30, 100, 0.01, 0.05

Values = tuple[float, ...]
Ratios = Mapping[runs.Entry, float]


class Search:
    """Sets of values that have been run.

    Args:
        scenario: Shipped name or path.
        names: Parameters.
        jobs: Processes, None for all cores.
    """

    def __init__(self, scenario: str, names: Sequence[str], jobs: int | None) -> None:
        self.scenario, self.names, self.jobs = scenario, tuple(names), jobs
        self.ratios: dict[Values, Ratios] = {}

    def run(self, sets: Sequence[Values], whole: bool = False) -> None:
        """Run sets of values under SMC, and the promising ones, or all, under the other laws, too."""
        new = [one for one in dict.fromkeys(sets) if one not in self.ratios]
        if new:
            self.ratios |= dict(zip(new, self._run(new, ("smc",)), strict=True))
        partial = [one for one in dict.fromkeys(sets) if len(self.ratios[one]) < len(runs.ENTRIES)]
        good = [one for one in partial if whole or miss(self.ratios[one]) < math.log(HOPELESS)]
        if good:
            for one, ratios in zip(good, self._run(good, ("aifqsmc", "fcafsmc")), strict=True):
                self.ratios[one] = {**ratios, **self.ratios[one]}

    def _run(self, sets: Sequence[Values], laws: Sequence[str]) -> list[Ratios]:
        rows = runs.rows(self.scenario, [arguments(self.names, one) for one in sets], laws, self.jobs)
        return [runs.ratios(row) for row in rows]

    def best(self) -> list[Values]:
        """Return the sets of least cost, cheapest first."""
        return sorted(self.ratios, key=lambda one: (cost(self.ratios[one]), one))

    def share(self, values: Values, reach: float, count: int) -> float:
        """Return the share of neighbours that keep the property."""
        sets = neighbours(values, reach, count)
        self.run(sets)
        return sum(keeps(self.ratios[one]) for one in sets) / count


def arguments(names: Sequence[str], values: Values) -> list[str]:
    """Return the arguments of `--set` that give parameters some values."""
    return [f"{key}={value!r}" for name, value in zip(names, values, strict=True) for key in PARAMETERS[name].keys]


def miss(ratios: Ratios) -> float:
    """Return the largest miss of some ratios."""
    return max(abs(math.log(one)) for one in ratios.values())


def cost(ratios: Ratios) -> float:
    """Return the cost of a set; laws that were not run cost 1 together."""
    missing = 0.0 if len(ratios) == len(runs.ENTRIES) else 1.0
    return missing + sum(max(0.0, abs(math.log(one)) - math.log(FREE)) ** 2 for one in ratios.values())


def keeps(ratios: Ratios) -> bool:
    """Return whether ratios have the property."""
    entry = "smc", "leader", "theta_e"
    turned = ratios[entry] * TABLE_12["smc"]["leader"]["theta_e"] > ANGLE
    return len(ratios) == len(runs.ENTRIES) and miss(ratios) <= math.log(FACTOR) and turned


def neighbours(values: Values, reach: float, count: int) -> list[Values]:
    """Return sets whose values each differ by up to a share, seeded by the values' number and the reach."""
    random = np.random.default_rng([len(values), round(1e6 * reach)])
    factors = 1.0 + random.uniform(-reach, reach, (count, len(values)))
    return [tuple(round(float(one), 6) for one in row) for row in factors * np.array(values)]


def generation(search: Search, random: np.random.Generator, share: float) -> list[Values]:
    """Return the sets of a generation: a share drawn within the bounds, the others near the best ones."""
    low, high = np.array([PARAMETERS[name][1:3] for name in search.names]).T
    best, sets = [np.array(one) for one in search.best()[:KEPT]], list[Values]()
    for _ in range(SIZE):
        values = random.uniform(low, high)
        if best and random.random() >= share:
            first, second = (min(int(random.exponential(8.0)), len(best) - 1) for _ in range(2))
            reach = 10.0 ** random.uniform(-3.0, -0.7) * (high - low)
            moved = random.random(len(low)) < 0.5
            values = best[first] + moved * reach * random.standard_normal(len(low))
            if random.random() < 0.2:
                values = np.where(random.random(len(low)) < 0.5, values, best[second])
        sets.append(tuple(round(float(one), 4) for one in np.clip(values, low, high)))
    return sets


def present(scenario: str, names: Sequence[str]) -> Values:
    """Return the values that a scenario has."""
    disturbances = read(find(scenario), ()).scenario.disturbances
    keys = [PARAMETERS[name].keys[0].split(".") for name in names]
    return tuple(float(getattr(disturbances[int(number)], key)) for _, number, key in keys)


def explore(search: Search, generations: int, seed: int) -> Values:
    """Return the best set of some generations, judged by its neighbours."""
    random = np.random.default_rng(seed)
    for number in range(generations):
        search.run(generation(search, random, 1.0 if number == 0 else 0.15))
        (best, *_) = search.best()
        ratios = search.ratios[best]
        angle = ratios["smc", "leader", "theta_e"] * TABLE_12["smc"]["leader"]["theta_e"]
        print(f"generation {number}: factor {math.exp(miss(ratios)):.3f}, θ_e {angle:.2f} rad, {best}", file=sys.stderr)
    shares = {one: search.share(one, NEAR, FEW) for one in search.best()[:CANDIDATES]}
    return max(shares, key=lambda one: (shares[one], -cost(search.ratios[one])))


def result(search: Search, values: Values) -> dict[str, Any]:
    """Return a set of values with its ratios, those of its neighbours, and the shares that keep the property."""
    search.run([values], whole=True)
    near = neighbours(values, FAR, MANY)
    shares = {f"{reach:.0%}": search.share(values, reach, MANY) for reach in (NEAR, FAR)}
    search.run(near, whole=True)
    ratios, around = search.ratios[values], [search.ratios[one] for one in near]
    entries = [
        {
            "law": entry[0], "robot": entry[1], "error": entry[2], "ratio": round(ratios[entry], 4),
            "least": round(min(one[entry] for one in around), 4),
            "greatest": round(max(one[entry] for one in around), 4),
        }
        for entry in runs.ENTRIES
    ]  # fmt: skip
    return {
        "scenario": search.scenario,
        "parameters": dict(zip(search.names, values, strict=True)),
        "sets": len(search.ratios),
        "factor": round(math.exp(miss(ratios)), 4),
        "angle": round(ratios["smc", "leader", "theta_e"] * TABLE_12["smc"]["leader"]["theta_e"], 4),
        "neighbours": MANY,
        "keep": shares,
        "entries": entries,
    }


def main() -> None:
    """Search, and print the result."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", default="paper")
    parser.add_argument("--parameters", default=",".join(USUAL), help=f"of {', '.join(PARAMETERS)}")
    parser.add_argument("--generations", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int)
    parser.add_argument("-o", type=Path, metavar="FILE")
    options = parser.parse_args()
    names = options.parameters.split(",")
    if unknown := [one for one in names if one not in PARAMETERS]:
        parser.error(f"{unknown[0]!r} is not one of {', '.join(PARAMETERS)}")
    keys = [key for name in names for key in PARAMETERS[name].keys]
    if twice := [key for k, key in enumerate(keys) if key in keys[:k]]:
        parser.error(f"two parameters set {twice[0]}")
    try:
        values = present(options.scenario, names)
    except (UnknownScenarioError, DiagnosticError, IndexError) as error:
        reason = "it has no such disturbances" if isinstance(error, IndexError) else str(error)
        parser.error(f"SCENARIO {options.scenario}: {reason}")
    search = Search(options.scenario, names, options.jobs)
    if options.generations > 0:
        values = explore(search, options.generations, options.seed)
    text = json.dumps(result(search, values), indent=1) + "\n"
    print(text, end="")
    if options.o is not None:
        options.o.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
