"""Benchmark of control laws: equal tuning of each, then paired differences on runs that no law was tuned on."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.console import Console
from rich.markup import escape

from dwmr.control import laws
from dwmr.control.fuzzy_gains import Rules
from dwmr.core.arrays import FloatArray
from dwmr.output.report import table_by_law
from dwmr.scenario.file import ScenarioFile
from dwmr.simulation.preflight import settings_of
from dwmr.sweep.robots import Robots
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.experiments.estimates import CONFIDENCE, bootstrap_interval
from fuzzyctl.experiments.sweep_plan import Plan, Run

#: Gains are searched from their values in the scenario over and times this factor, evenly in their logarithm.
REACH = 4.0
#: The last share of the evaluations searches around the best gains, by this factor.
LOCAL_SHARE, LOCAL_REACH = 0.5, 1.3
#: Measures of a run and their units.
MEASURES = {"error": "m", "chattering": "m/s²", "energy": "kJ", "formation": "s", "amplification": "-"}
_GROUPS = ("rmse", "chattering", "energy", "arrival", "amplification")


@dataclass(frozen=True)
class Tuned:
    """Gains of one law for one scenario.

    Args:
        gains: By name.
        cost: Mean error over the training runs [m].
        start: That of the scenario's own gains [m]; either is infinite if a run stopped.
        evaluations: Number of candidates.
    """

    gains: Mapping[str, float]
    cost: float
    start: float
    evaluations: int


@dataclass(frozen=True)
class Entry:
    """One measure of one law in one scenario over the held-out runs.

    Args:
        scenario, controller, measure, unit: Subject of the measure.
        n: Held-out runs that came to their end.
        mean: Over them; None without any.
        difference: Mean of the paired differences from the first law over the runs that both finish.
        low, high: Bootstrap interval of that; None for the first law, and for less than two runs.
    """

    scenario: str
    controller: str
    measure: str
    unit: str
    n: int
    mean: float | None
    difference: float | None
    low: float | None
    high: float | None


def of_run(row: Mapping[str, Any]) -> dict[str, float] | None:
    """Return the measures of a run from its columns, see `MEASURES`; None of one that stopped."""
    if row["stopped"]:
        return None
    grouped: dict[str, dict[str, Any]] = {}
    for column, value in row.items():
        group, _, name = column.partition(".")
        grouped.setdefault(group, {})[name] = value
    arrivals = [value for name, value in grouped["arrival"].items() if name.endswith(".t")]
    ratios = [value for value in grouped.get("amplification", {}).values() if value is not None]
    changes = [value for name, value in grouped["chattering"].items() if name.endswith(".v")]
    return {
        "error": error_of(row),
        "chattering": sum(changes) / len(changes),
        "energy": sum(grouped["energy"].values()) / 1000.0,
        "formation": max(row["t_end"] if t is None else t for t in arrivals),
        "amplification": max(ratios, default=math.nan),
    }


def error_of(row: Mapping[str, Any]) -> float:
    """Return the root mean square of the distances of all robots from their places [m]; infinite if the run stopped."""
    if row["stopped"]:
        return math.inf
    parts = [value**2 for name, value in row.items() if name.startswith("rmse.") and name.endswith((".x_e", ".y_e"))]
    return math.sqrt(2.0 * sum(parts) / len(parts))


def gains_of(file: ScenarioFile, law: str, rules: Rules) -> dict[str, float]:
    """Return the positive gains of a law for the first robot: those of the scenario, else those of its text."""
    robot = next(iter(file.scenario.robots))
    module = laws.find(law, file.path.parent, rules)
    settings = settings_of(file, robot, law, module)
    values = settings.model_dump(exclude_none=True)
    if not values and hasattr(module, "values"):
        values = module.values(settings, robot)
    return {name: float(one) for name, one in values.items() if one > 0.0 and not isinstance(one, int)}


def candidates(start: Mapping[str, float], budget: int, seed: int, law: str) -> Generator[FloatArray, float, None]:
    """Yield factors of the gains; the caller sends the cost of each.

    The first one is 1; random ones follow, the last of them near the best so far.
    """
    random = np.random.default_rng([seed, *law.encode()])
    best: FloatArray = np.ones(len(start))
    least, one = math.inf, best
    for k in range(budget):
        local = k >= budget * (1.0 - LOCAL_SHARE)
        if k > 0:
            exponents = random.uniform(-1.0, 1.0, len(start))
            one = best * LOCAL_REACH**exponents if local else REACH**exponents
        cost = yield one
        if cost < least:
            least, best = cost, one


class Bench:
    """Tunes and runs one law after the other in one scenario.

    Args:
        robots: Runs scenarios.
        plan: Repetitions under all laws, those to tune on first.
        training: Number of repetitions to tune on.
        budget: Candidates for the gains of each law.
        seed: Of the candidates and the bootstrap.
    """

    def __init__(self, robots: Robots, plan: Plan[ScenarioFile], training: int, budget: int, seed: int) -> None:
        self._robots, self._plan, self._training = robots, plan, training
        self._budget, self._seed = budget, seed

    def tune(self, law: str, report: Callable[[int], None]) -> Tuned:
        """Return the candidate with the least mean error over the training runs; `report` gets the number done."""
        file = self._plan.scenario
        start = gains_of(file, law, self._robots.rules(file))
        search = candidates(start, self._budget, self._seed, law)
        factors, costs = next(search), list[float]()
        best, gains = math.inf, dict(start)
        while True:
            tried = {name: float(value * factor) for (name, value), factor in zip(start.items(), factors, strict=True)}
            try:
                costs.append(self._cost(law, tried))
            except DiagnosticError:  # gains beyond their bounds, or for which a proof fails
                if not costs:
                    raise
                costs.append(math.inf)
            if costs[-1] < best:
                best, gains = costs[-1], tried
            report(len(costs))
            try:
                factors = search.send(costs[-1])
            except StopIteration:
                return Tuned(gains, best, costs[0], len(costs))

    def measure(self, law: str, gains: Mapping[str, float]) -> list[dict[str, float] | None]:
        """Return the measures of the held-out runs of a law, None for each that stopped."""
        return [of_run(self._row(run, gains, _GROUPS)) for run in self._runs(law) if run.repetition >= self._training]

    def _runs(self, law: str) -> list[Run]:
        return [run for run in self._plan.runs if run.controller == law]

    def _cost(self, law: str, gains: Mapping[str, float]) -> float:
        rows = [run for run in self._runs(law) if run.repetition < self._training]
        return sum(error_of(self._row(run, gains, ("rmse",))) for run in rows) / len(rows)

    def _row(self, run: Run, gains: Mapping[str, float], groups: Sequence[str]) -> Mapping[str, Any]:
        values = [f"robot.controllers.{laws.base(run.controller)}.{name}={value!r}" for name, value in gains.items()]
        file = self._robots.read(run.path, (*run.overrides, *values))
        return self._robots.prepare(file, run.controller, groups).compute().row


def entries(scenario: str, measured: Mapping[str, Sequence[Mapping[str, float] | None]], seed: int) -> Iterator[Entry]:
    """Yield every measure of every law, by law from `Bench.measure`, with its difference from the first law."""
    first = next(iter(measured.values()), ())
    for k, (law, runs) in enumerate(measured.items()):
        ended = [run for run in runs if run is not None]
        for name, unit in MEASURES.items():
            values = [run[name] for run in ended if not math.isnan(run[name])]
            pairs = [b[name] - a[name] for a, b in zip(first, runs, strict=True) if a is not None and b is not None]
            pairs = [one for one in pairs if not math.isnan(one)]
            mean = math.fsum(values) / len(values) if values else None
            difference = math.fsum(pairs) / len(pairs) if pairs and k > 0 else None
            low, high = bootstrap_interval(pairs, seed) if k > 0 and len(pairs) > 1 else (None, None)
            yield Entry(scenario, law, name, unit, len(values), mean, difference, low, high)


def print_bench(out: Console, found: Sequence[Entry], budget: int, training: int, held_out: int) -> None:
    """Print a table and a conclusion for each scenario, and a legend of the columns."""
    heads = [f"{name}\n{unit}" for name, unit in MEASURES.items()]
    for scenario in dict.fromkeys(one.scenario for one in found):
        rows: dict[str, dict[str, list[str]]] = {}
        entries = [one for one in found if one.scenario == scenario]
        for one in entries:
            cells = {"mean": _number(one.mean, "", 4)}
            if one.difference is not None:
                cells["difference"] = _number(one.difference, "+")
                cells |= (
                    {"  from": _number(one.low, "+"), "  to": _number(one.high, "+")} if one.low is not None else {}
                )
            for label, cell in cells.items():
                rows.setdefault(one.controller, {}).setdefault(label, []).append(cell)
        out.print(
            f"{escape(scenario)}: after {counted(budget, 'evaluation')} of each law", style="bold", highlight=False
        )
        out.print(table_by_law(heads, rows, ""))
        for line in conclusions(entries):
            out.print(escape(line), highlight=False)
        out.print()
    out.print(
        f"Means over {counted(held_out, 'held-out run')}; the gains have the least mean error of "
        f"{counted(training, 'other run')}. "
        f"difference: from the first law in the same runs, with its {100 * CONFIDENCE:.0f} % bootstrap interval, which "
        "speaks of these gains; other candidates would give others. "
        "error: root mean square distance of all robots from their places. energy: of all wheels, with braking. "
        "formation: when the last robot is at its place for good, or the end of the run. "
        "amplification: largest ratio of a follower's error to its leader's.",
        style="dim", highlight=False,
    )  # fmt: skip


def conclusions(entries: Sequence[Entry]) -> Iterator[str]:
    """Yield which laws of one scenario have less error than the first one, which more, and which cannot be told apart.

    Args:
        entries: Those of the scenario, those of the first law first.
    """
    first, *others = [one for one in entries if one.measure == "error"]
    groups: dict[str, list[Entry]] = {"less error": [], "more error": [], "no clear difference": []}
    for one in others:
        if one.low is not None and one.high is not None:
            groups["less error" if one.high < 0 else "more error" if one.low > 0 else "no clear difference"].append(one)
    for words, group in groups.items():
        group.sort(key=lambda one: one.difference or 0.0)
        if group:
            of = "from" if words.endswith("difference") else "than"
            yield f"{words} {of} {first.controller}: {', '.join(one.controller for one in group)}"


def _number(value: float | None, sign: str = "", digits: int = 3) -> str:
    """Return a number with some digits; powers of ten only for those that are very small or large."""
    if value is None:
        return ""
    return f"{value:{sign}.0f}" if 10.0 ** (digits - 1) <= abs(value) < 1e7 else f"{value:{sign}.{digits}g}"
