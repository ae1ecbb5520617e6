"""Search for values: differential evolution, then a choice among the best by the cost of their neighbours."""

from __future__ import annotations

import math
import signal
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import differential_evolution
from scipy.stats import qmc

from dwmr.calibration.parameters import PARAMETERS, overrides
from dwmr.control.fuzzy_gains import Known, Rules
from dwmr.results.metrics import distances, errors, printed_frame, rmse
from dwmr.results.paper_tables import TABLE_12
from dwmr.scenario.file import ScenarioFile, read
from dwmr.simulation import simulate
from dwmr.simulation.simulate import Trajectory
from fuzzyctl.support.cores import interrupts_blocked

LAWS = ("aifqsmc", "fcafsmc", "smc")
ERRORS = ("x_e", "y_e", "theta_e")
#: Law, robot and error of one number of Table 12.
Entry = tuple[str, str, str]
ENTRIES: tuple[Entry, ...] = tuple((law, robot, name) for law in LAWS for robot in TABLE_12[law] for name in ERRORS)
#: Bars: how far a ratio may be from 1, and the weight of a miss. SMC's leader fails in the paper, and its followers
#: chatter then: their errors change by a third with the integration step, so they weigh a tenth. The printed angle of
#: SMC's leader, 4.02 rad, is more than half a turn: no wrapped angle can reach it, and it does not count.
CLOSE_LEADER, CLOSE_FOLLOWER, SMC_LEADER = 0.20, 0.25, 0.30
_BARRED, _SMC_FOLLOWERS = 3.0, 0.1
#: A follower of SMC that is off by more than this costs no more: its chaos must not lead the search.
_MOST_OFF = 4.0
#: Cost of runs that end early or bring the leader of AIFQSMC or FCAFSMC closer to an obstacle than this [m].
UNSAFE, CLEARANCE = 1000.0, 1.06


class Outcome(NamedTuple):
    """What became of one set of values.

    Attributes:
        cost: See `cost`.
        ratios: Error over the number of Table 12, in the order of `ENTRIES`.
    """

    cost: float
    ratios: tuple[float, ...]


def bar(entry: Entry) -> float:
    """Return how far the ratio of an entry may be from 1, as a logarithm."""
    law, robot, _ = entry
    if law == "smc":
        return math.log1p(SMC_LEADER)
    return math.log1p(CLOSE_LEADER if robot == "leader" else CLOSE_FOLLOWER)


def cost(ratios: Mapping[Entry, float]) -> float:
    """Return the cost of a set of ratios: 0 for Table 12 itself.

    Of each entry the miss is m = |ln ratio| / ln(1 + bar), where the bar is 20 % for the leader under AIFQSMC and
    FCAFSMC, 25 % for their followers and 30 % under SMC. AIFQSMC and FCAFSMC add m² + 3 max(0, m − 1), the x_e and y_e
    of SMC's leader the half of it, SMC's followers 0.1 min(m, 4)², and the angle of SMC's leader nothing.
    """
    total = 0.0
    for entry, ratio in ratios.items():
        law, robot, name = entry
        miss = abs(math.log(ratio)) / bar(entry) if ratio > 0.0 else math.inf
        barred = miss * miss + _BARRED * max(0.0, miss - 1.0)
        if law != "smc":
            total += barred
        elif robot != "leader":
            total += _SMC_FOLLOWERS * min(miss, _MOST_OFF) ** 2
        elif name != "theta_e":
            total += 0.5 * barred
    return total


class Scorer:
    """Runs a scenario with other values under the three laws; runs share proofs and compiled code.

    Args:
        path: The scenario's file.
    """

    def __init__(self, path: Path) -> None:
        self.path, self._known = path, Known()

    def __call__(self, arguments: Sequence[str]) -> Outcome:
        """Return the cost of the scenario with some values replaced.

        Raises:
            DiagnosticError: When the scenario does not admit the values.
        """
        file = read(self.path, arguments)
        rules = Rules(file.scenario.rules, file.folders, file.places, self._known)
        ratios: dict[Entry, float] = {}
        unsafe = False
        for law in LAWS:
            trajectory = simulate.run(simulate.prepare(file, law, rules))
            ratios |= _ratios(trajectory, file)
            unsafe = unsafe or _unsafe(trajectory, file)
        return Outcome(UNSAFE if unsafe else cost(ratios), tuple(ratios.values()))


def _ratios(trajectory: Trajectory, file: ScenarioFile) -> dict[Entry, float]:
    law = trajectory.controller
    ratios: dict[Entry, float] = {}
    for robot, printed in TABLE_12[law].items():
        by_name = errors(trajectory, robot, printed_frame(file.scenario, robot))
        ratios |= {(law, robot, name): rmse(by_name[name]) / printed[name] for name in ERRORS}
    return ratios


def _unsafe(trajectory: Trajectory, file: ScenarioFile) -> bool:
    """Return whether a run ended early, or its leader came too close to an obstacle though its law should work."""
    if trajectory.stop is not None:
        return True
    if trajectory.controller == "smc" or not file.scenario.obstacles:
        return False
    return float(distances(trajectory, file.scenario, "leader").min()) < CLEARANCE


Values = tuple[float, ...]
#: Scores many sets of values, in their order.
Batch = Callable[[Sequence[Values]], Iterator[Outcome]]

#: Vectors of a generation of the differential evolution, per parameter.
PER_PARAMETER = 6
#: How many of the best sets are judged by their neighbours, and how far these are away.
CANDIDATES, NEAR = 6, 0.05
#: Most decimals of a candidate value: candidates are judged as they will be written.
DECIMALS = 3
#: Evaluations of the choice take at most this share of all.
CHOICE = 0.4


@dataclass(frozen=True)
class Found:
    """Result of a search.

    Attributes:
        values: The values chosen, by parameter.
        outcome: Their cost.
        start_values, start: The values of the scenario as it was.
        neighbours: Outcomes with one value changed by 5 % each; none when the search did not come so far.
        evaluations: How many sets of values were run.
        interrupted: Whether Ctrl-C ended it.
    """

    values: dict[str, float]
    outcome: Outcome
    start_values: dict[str, float]
    start: Outcome
    neighbours: tuple[Outcome, ...]
    evaluations: int
    interrupted: bool

    def data(self) -> dict[str, Any]:
        """Return values, costs and ratios as plain data."""
        entries = []
        for k, (law, robot, name) in enumerate(ENTRIES):
            around = [outcome.ratios[k] for outcome in (self.outcome, *self.neighbours)]
            entries.append(
                {
                    "law": law,
                    "robot": robot,
                    "error": name,
                    "table_12": TABLE_12[law][robot][name],
                    "before": self.start.ratios[k],
                    "ratio": self.outcome.ratios[k],
                    "least": min(around),
                    "greatest": max(around),
                }
            )
        costs = [outcome.cost for outcome in self.neighbours]
        return {
            "parameters": {
                name: {"before": self.start_values[name], "value": value, "unit": PARAMETERS[name].unit}
                for name, value in self.values.items()
            },
            "cost": {
                "before": self.start.cost,
                "value": self.outcome.cost,
                "of_neighbours": [min(costs), max(costs)] if costs else None,
            },
            "entries": entries,
            "evaluations": self.evaluations,
            "interrupted": self.interrupted,
        }


@dataclass
class Search:
    """A search under way: every set of values that was run, in an order that does not depend on how many ran at once.

    Args:
        names: Parameters to fit.
        batch: Scores sets of values.
        report: Called with the number of evaluations done.
    """

    names: tuple[str, ...]
    batch: Batch
    report: Callable[[int], None]
    seen: dict[Values, Outcome] = field(default_factory=dict)
    done: int = 0

    def score(self, sets: Iterable[Values]) -> list[float]:
        """Return the costs of some sets of values; one that was run before is not run again."""
        wanted = list(sets)
        new = [one for one in dict.fromkeys(wanted) if one not in self.seen]
        for one, outcome in zip(new, self.batch(new), strict=True):
            self.seen[one] = outcome
            self.done += 1
            self.report(self.done)
        return [self.seen[one].cost for one in wanted]

    def best(self) -> list[Values]:
        """Return the sets of least cost, cheapest first."""
        return sorted(self.seen, key=lambda one: (self.seen[one].cost, one))

    def neighbours(self, values: Values) -> list[Values]:
        """Return the sets that differ in one value by `NEAR` of it, within the bounds."""
        sets = []
        for k, name in enumerate(self.names):
            for factor in (1.0 - NEAR, 1.0 + NEAR):
                moved = min(max(values[k] * factor, PARAMETERS[name].low), PARAMETERS[name].high)
                sets.append((*values[:k], round(moved, DECIMALS + 1) + 0.0, *values[k + 1 :]))
        return [one for one in dict.fromkeys(sets) if one != values]


def search(
    file: ScenarioFile,
    start: Mapping[str, float],
    evaluations: int,
    seed: int,
    jobs: int,
    report: Callable[[int], None],
) -> Found:
    """Search for the values that bring a scenario's runs nearest to Table 12.

    Args:
        file: The scenario, checked.
        start: Parameters to fit, with the values they have now; these are run first.
        evaluations: About how many sets of values to run.
        seed: Of the differential evolution.
        jobs: Processes to run them in; the result does not depend on it.
        report: Called with the number of sets done.

    Raises:
        KeyboardInterrupt: When it comes before the first set is done.
    """
    with _batches(file, tuple(start), jobs) as batch:
        return explore(batch, start, evaluations, seed, report)


def explore(
    batch: Batch, start: Mapping[str, float], evaluations: int, seed: int, report: Callable[[int], None]
) -> Found:
    """Search with a function that scores sets of values; other arguments and errors as `search`."""
    names = tuple(start)
    one = Search(names, batch, report)
    (first,) = _rounded(names, [tuple(start.values())])
    interrupted, near = False, list[Values]()
    try:
        one.score([first])
        _evolve(one, first, evaluations, seed)
        chosen, near = _choose(one, evaluations)
    except KeyboardInterrupt:
        if first not in one.seen:
            raise
        interrupted, chosen = True, one.best()[0]
    around = tuple(one.seen[n] for n in near)
    values = dict(zip(names, chosen, strict=True))
    return Found(values, one.seen[chosen], dict(start), one.seen[first], around, one.done, interrupted)


def _evolve(one: Search, first: Values, evaluations: int, seed: int) -> None:
    bounds = [(PARAMETERS[name].low, PARAMETERS[name].high) for name in one.names]
    low, high = np.array(bounds).T
    size = max(5, min(PER_PARAMETER * len(bounds), evaluations // 2))
    population = qmc.scale(qmc.LatinHypercube(len(bounds), seed=seed).random(size), low, high)
    population[0] = np.clip(first, low, high)
    generations = (evaluations - 2 * len(bounds) * _candidates(one, evaluations)) // size - 1
    if generations < 1:
        one.score(_rounded(one.names, population))
        return
    differential_evolution(
        _never_called,
        bounds,
        init=population,
        maxiter=generations,
        seed=seed,
        tol=0.0,
        polish=False,
        updating="deferred",
        workers=lambda _, vectors: one.score(_rounded(one.names, vectors)),
    )


def _never_called(vector: Any) -> float:
    raise NotImplementedError("sets of values are scored by the generation")


def _candidates(one: Search, evaluations: int) -> int:
    """Return how many sets to judge by their neighbours."""
    return max(1, min(CANDIDATES, int(CHOICE * evaluations) // (2 * len(one.names))))


def _choose(one: Search, evaluations: int) -> tuple[Values, list[Values]]:
    """Return the best set, judged by the mean cost of itself and its neighbours, and the neighbours.

    After obstacles a run depends finely on everything, so the least cost of all would be luck.
    """
    candidates = one.best()[: _candidates(one, evaluations)]
    around = {values: one.neighbours(values) for values in candidates}
    one.score([n for near in around.values() for n in near])
    means = {values: _mean([one.seen[n].cost for n in (values, *near)]) for values, near in around.items()}
    chosen = min(candidates, key=lambda v: means[v])
    return chosen, around[chosen]


def _mean(costs: Sequence[float]) -> float:
    return sum(costs) / len(costs)


def _rounded(names: Sequence[str], vectors: Iterable[Sequence[float]]) -> list[Values]:
    steps = [PARAMETERS[name].step for name in names]
    return [
        tuple(round(step * round(float(v) / step), DECIMALS) + 0.0 for v, step in zip(vector, steps, strict=True))
        for vector in vectors
    ]


@contextmanager
def _batches(file: ScenarioFile, names: Sequence[str], jobs: int) -> Iterator[Batch]:
    """Offer a function that scores sets of values, in this process or in several."""

    def arguments(values: Values) -> tuple[str, ...]:
        return overrides(file.scenario, dict(zip(names, values, strict=True)), file.places)

    if jobs == 1:
        scorer = Scorer(file.path)
        yield lambda sets: (scorer(arguments(one)) for one in sets)
        return
    with ProcessPoolExecutor(jobs, get_context("spawn"), _begin, (file.path,)) as pool:

        def score(sets: Sequence[Values]) -> Iterator[Outcome]:
            with interrupts_blocked():
                return pool.map(_score, [arguments(one) for one in sets])

        try:
            yield score
        except KeyboardInterrupt:
            pool.shutdown(cancel_futures=True)
            raise


_scorer: list[Scorer] = []


def _begin(path: Path) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the first process
    _scorer.append(Scorer(path))


def _score(arguments: Sequence[str]) -> Outcome:
    return _scorer[0](arguments)
