"""Cost of a calibration: distance of a scenario's runs from Table 12, with the ratios behind it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from dwmr.control.fuzzy_gains import Known, Rules
from dwmr.results.metrics import TABLE_12, distances, errors, printed_frame, rmse
from dwmr.scenario.file import ScenarioFile, read
from dwmr.simulation import simulate
from dwmr.simulation.simulate import Trajectory

LAWS = ("aifqsmc", "fcafsmc", "smc")
ERRORS = ("x_e", "y_e", "theta_e")
#: Law, robot and error of one number of Table 12.
Entry = tuple[str, str, str]
ENTRIES: tuple[Entry, ...] = tuple((law, robot, name) for law in LAWS for robot in TABLE_12[law] for name in ERRORS)
#: Bars: how far a ratio may be from 1, and what a miss weighs. SMC's leader fails in the paper, and its followers then
#: chatter along: their errors change by a third with the integration step, so they weigh a tenth. The printed angle of
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
    """Runs a scenario with other values under the three laws; what is proved and compiled is shared between runs.

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
    found: dict[Entry, float] = {}
    for robot, printed in TABLE_12[law].items():
        by_name = errors(trajectory, robot, printed_frame(file.scenario, robot))
        found |= {(law, robot, name): rmse(by_name[name]) / printed[name] for name in ERRORS}
    return found


def _unsafe(trajectory: Trajectory, file: ScenarioFile) -> bool:
    """Return whether a run ended early, or its leader came too close to an obstacle though its law should work."""
    if trajectory.stop is not None:
        return True
    if trajectory.controller == "smc" or not file.scenario.obstacles:
        return False
    return float(distances(trajectory, file.scenario, "leader").min()) < CLEARANCE
