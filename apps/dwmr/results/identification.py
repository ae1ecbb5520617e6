"""Identification of a robot's body and drives from a log of its commands and velocities."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from dwmr.core.arrays import FloatArray
from dwmr.core.jit import compiled
from dwmr.plant.disturbances import DISTURBANCE, Load
from dwmr.plant.robot import State, advance, pd_torques, slewed
from dwmr.results.logs import VELOCITIES, Log
from dwmr.results.metrics import rmse
from dwmr.scenario.model import Scenario
from dwmr.simulation.periods import records
from fuzzyctl.experiments.estimates import CONFIDENCE

#: Time after the start of a log, and after a gap, in which the simulated robot settles and is not compared [s].
SETTLING = 1.0
#: A parameter is determined if its standard error is below this, of a factor in its logarithm, else over its scale.
LARGEST_ERROR = 0.5
#: Change of a parameter, so counted, for derivatives.
_STEP = 1e-5
#: A limit of acceleration is kept if it lowers half the weighted sum of squares by more.
_GAIN = 5.0
#: Other start of the lag, longer than those of drives [s].
_LONG_LAG = 0.1
#: Weighted errors beyond this are those of a simulation that diverges.
_LARGEST = 1e12
#: Parameters whose estimates correlate by more are named together.
_ALIKE = 0.9
#: Greatest logarithm of a factor that is not infinite.
_MOST = 700.0
#: Evaluations of one search.
_EVALUATIONS = 60


class Parameter(NamedTuple):
    """A number to identify.

    Attributes:
        key: Below the table of a robot in a scenario; "dead_time" is of the log's commands, and no key.
        unit: Its unit.
        scale: Field of the body and its multiple that count as 1; empty for a factor, which is positive.
        least: Lower bound, of a factor that of its logarithm.
    """

    key: str
    unit: str
    scale: tuple[str, float] = ("", 0.0)
    least: float = -math.inf

    @property
    def field(self) -> str:
        """Field of `ROBOT`."""
        return self.key.rpartition(".")[2]


#: All parameters; of those that the log does not tell apart the first one is held.
PARAMETERS = (
    Parameter("mass", "kg"),
    Parameter("inertia", "kg m²"),
    Parameter("actuator.acceleration", "m/s²"),
    Parameter("actuator.angular_acceleration", "rad/s²"),
    Parameter("dead_time", "s", ("", 0.1)),
    Parameter("friction.viscous_force", "N s/m", ("mass", 0.1), 0.0),
    Parameter("friction.viscous_torque", "N m s/rad", ("inertia", 0.1), 0.0),
    Parameter("friction.coulomb_force", "N", ("mass", 0.1), 0.0),
    Parameter("friction.coulomb_torque", "N m", ("inertia", 0.1), 0.0),
    Parameter("actuator.lag", "s", least=math.log(0.001)),
)
_KEYS = [p.key for p in PARAMETERS]
_LEAST = np.array([p.least for p in PARAMETERS])
_SLEWS = ("actuator.acceleration", "actuator.angular_acceleration")


@dataclass(frozen=True)
class Estimate:
    """Estimate of a parameter.

    Args:
        key, unit: As in `Parameter`.
        value: Its value; of one that is not determined the one that is held, None for no limit.
        low, high: Ends of the confidence interval, None for one that is not determined.
        before: In the scenario.
        why: Why it is not determined, or "".
    """

    key: str
    unit: str
    value: float | None
    low: float | None
    high: float | None
    before: float | None
    why: str = ""


@dataclass(frozen=True)
class Identified:
    """Estimates of one robot.

    Args:
        estimates: In the order of `PARAMETERS`.
        samples: Compared samples.
        residuals: Root mean squares of the remaining errors of v and omega [m/s, rad/s].
        before: The same with the scenario's own parameters.
        correlation: Of a residual with the one of the sample before, the larger of both signals.
        excess: Largest ratio of a residual to the noise from sample to sample, at least a thousandth of a signal.
    """

    estimates: tuple[Estimate, ...]
    samples: int
    residuals: tuple[float, float]
    before: tuple[float, float]
    correlation: float
    excess: float


class UnexplainedError(Exception):
    """Raised for a log that no values of the parameters explain."""


@compiled
def replay(
    commands: FloatArray, v: float, omega: float, robots: Any, acting: Any, load: Load, dt: float, substeps: int,
    record: FloatArray,
) -> None:  # fmt: skip
    """Simulate the inner loop, drives and body of a robot under logged commands.

    Args:
        commands: Velocity commands of each control period, shape (n, 2) [m/s, rad/s].
        v, omega: Velocities at the start [m/s, rad/s].
        robots: One record of dtype `ROBOT`.
        acting, load, dt, substeps: As for `robot.advance`.
        record: Written, velocities at the start of each period, shape (n, 2) [m/s, rad/s].
    """
    robot, state = robots[0], State(0.0, 0.0, 0.0, v, omega, 0.0, 0.0)
    filter_v = filter_omega = 0.0
    for k in range(commands.shape[0]):
        record[k, 0], record[k, 1] = state.v, state.omega
        v = slewed(commands[k, 0], robot.v_limit, v, robot.acceleration, dt)
        omega = slewed(commands[k, 1], robot.omega_limit, omega, robot.angular_acceleration, dt)
        right, left, filter_v, filter_omega = pd_torques(
            v - state.v, omega - state.omega, filter_v, filter_omega, robot, dt
        )
        state = advance(k * dt, state, right, left, robot, acting, load, dt, substeps)


def _parts(log: Log) -> list[tuple[int, int]]:
    """Return begin and end of each part of a log that has no gap and lasts long enough to be compared."""
    edges = [0, *(log.gaps + 1).tolist(), len(log.t)]
    return [(a, b) for a, b in pairwise(edges) if log.t[b - 1] - log.t[a] > SETTLING and b - a > len(PARAMETERS)]


def obstacle_to(log: Log) -> str:
    """Return why nothing can be identified from a log, or ""."""
    if not _parts(log):
        return f"no part without gaps is longer than {SETTLING:g} s"
    if log.command_t[0] > log.t[0] + SETTLING:
        return f"its first command comes at {log.command_t[0]:.6g} s"
    if not np.ptp(log.commands, axis=0).any():
        return "its commands never change"
    if not any(np.ptp(log.signals[name][a:b]) for name in VELOCITIES for a, b in _parts(log)):
        return "its velocities never change"
    return ""


class Replica:
    """A robot of a scenario that follows a log.

    Args:
        log: With velocities and commands.
        scenario: Scenario; its disturbances and its load are left out.
        robot: Name of the robot.

    Attributes:
        measured: Compared velocities, shape (samples, 2) [m/s, rad/s].
        start: Values of the scenario by key.
        scales: Unit of each parameter by key, 0 for a factor.
        spacing: Usual time between commands [s].
    """

    def __init__(self, log: Log, scenario: Scenario, robot: str) -> None:
        self._log, self._dt, self._substeps = log, scenario.run.dt, scenario.run.substeps
        i = list(scenario.robots).index(robot)
        self._record = records(scenario)[i : i + 1]
        self._acts_on_mass = scenario.robots[robot].inner_loop.torque_reading == "acceleration"
        self._velocities = np.stack([log.signals["v"], log.signals["omega"]], axis=1)
        self._parts = [(a, a + int(np.searchsorted(log.t[a:b], log.t[a] + SETTLING)), b) for a, b in _parts(log)]
        self.measured = np.concatenate([self._velocities[first:b] for _, first, b in self._parts])
        self.start = {p.key: float(self._record[p.field][0]) for p in PARAMETERS if p.key != "dead_time"}
        self.start["dead_time"] = 0.0
        self.scales = {p.key: p.scale[1] * self.start.get(p.scale[0], 1.0) for p in PARAMETERS}
        self.spacing = float(np.median(np.diff(log.command_t)))

    def values(self, z: FloatArray) -> dict[str, float]:
        """Return parameters by key from their logarithms, or from multiples of their scales."""
        return {
            key: one * self.scales[key] if self.scales[key] else math.inf if one > _MOST else math.exp(one)
            for key, one in zip(_KEYS, z.tolist(), strict=True)
        }

    def simulate(self, values: Mapping[str, float]) -> FloatArray:
        """Return the velocities at the compared samples, shape (samples, 2) [m/s, rad/s]."""
        record = self._record
        for p in PARAMETERS:
            if p.key != "dead_time":
                record[p.field][0] = values[p.key]
        if self._acts_on_mass:  # the inner loop knows the body
            record["pd_mass"][0], record["pd_inertia"][0] = values["mass"], values["inertia"]
        acting, load, results = np.zeros(0, dtype=DISTURBANCE).view(np.recarray), Load(0.0, 0.0, 1.0, 1.0), []
        for first, compared, end in self._parts:
            stamps, delay = self._log.t[compared:end] - values["dead_time"], abs(values["dead_time"])
            count = math.ceil((self._log.t[end - 1] - self._log.t[first] + delay) / self._dt) + 1
            grid = self._log.t[first] + self._dt * np.arange(count)
            latest = np.searchsorted(self._log.command_t, grid + 1e-6, side="right") - 1
            velocities = np.empty((count, 2))
            v, omega = self._velocities[first]
            commands = self._log.commands[np.maximum(latest, 0)]
            replay(commands, v, omega, record, acting, load, self._dt, self._substeps, velocities)
            results.append(np.stack([np.interp(stamps, grid, one) for one in velocities.T], axis=1))
        return np.concatenate(results)

    def peaks(self) -> FloatArray:
        """Return the largest accelerations over a tenth of a second, first guesses of limits [m/s², rad/s²]."""
        every = max(1, round(0.1 / self._log.step))
        steps = np.diff(self._log.t[::every])[:, None]
        rates = np.abs(np.diff(self._velocities[::every], axis=0)) / np.maximum(steps, 1e-9)
        peaks: FloatArray = np.maximum(rates.max(axis=0, initial=0.0), 1e-3)
        return peaks


def identify(
    log: Log, scenario: Scenario, robot: str, report: Callable[[int], object] = lambda done: None
) -> Identified:
    """Fit the plant's parameters to a log, least squares of simulated from logged velocities.

    Args:
        log: With velocities and commands.
        scenario: Scenario, with the starting values.
        robot: Name of the robot.
        report: Called with the number of simulations done.

    Raises:
        UnexplainedError: If the search ends beyond all numbers.

    Source:
        Output-error identification with intervals from the Jacobian: Ljung, System Identification, 2nd ed., 1999,
        section 9.6; an autocorrelation ρ widens their squares by (1 + ρ)/(1 − ρ).
    """
    return _Search(Replica(log, scenario, robot), report).identified()


class _Search:
    """Search of the least squares.

    Args:
        replica: The robot and its log.
        report: Called with the number of simulations done.
    """

    def __init__(self, replica: Replica, report: Callable[[int], object]) -> None:
        self._replica, self._report, self._done = replica, report, 0
        second = np.diff(replica.measured, n=2, axis=0)
        noise, size = np.median(np.abs(second), axis=0) / (0.6745 * math.sqrt(6.0)), np.ptp(replica.measured, axis=0)
        self._weights = 1.0 / np.maximum(noise, 1e-6 * size + 1e-12)
        self._noise = np.maximum(noise, 1e-3 * size + 1e-6)
        pairs = [(replica.start[key], replica.scales[key]) for key in _KEYS]
        self._start = np.array([one / scale if scale else math.log(one) for one, scale in pairs])

    def identified(self) -> Identified:
        """Return the estimates: with limits of acceleration only if they explain more, without undetermined ones."""
        before, (z, free) = self._errors(self._start), self._best()
        why = {key: "the log does not show a limit" for key in _SLEWS if not free[_KEYS.index(key)]}
        while True:
            self._weights = 1.0 / np.maximum(np.sqrt(np.mean(self._errors(z) ** 2, axis=0)), 1e-12)
            z = self._fit(z, free)
            residuals = self._errors(z)
            correlation = self._correlation(residuals)
            jacobian = self._jacobian(z, free) / math.sqrt((1.0 + correlation) / (1.0 - correlation))
            if not (np.isfinite(jacobian).all() and np.isfinite(residuals).all()):
                raise UnexplainedError("no mass, friction and drives lead from its commands to its velocities")
            _, singular, directions = np.linalg.svd(jacobian, full_matrices=False)
            roots = directions / np.maximum(singular, 1e-9)[:, None]  # their products are the covariances
            errors, numbers = np.linalg.norm(roots, axis=0), np.flatnonzero(free)
            if not (errors > LARGEST_ERROR).any():
                break
            first = int(np.flatnonzero(errors > LARGEST_ERROR)[0])
            shares = np.abs(roots.T @ roots[:, first]) / (errors * errors[first])
            others = [PARAMETERS[k].field for k in numbers[shares > _ALIKE] if k != numbers[first]]
            fixed = int(numbers[first])
            free[fixed], z[fixed] = False, math.inf if _KEYS[fixed] in _SLEWS else self._start[fixed]
            apart = f"the log does not tell it from {', '.join(others)}"
            why[_KEYS[fixed]] = apart if others else "the log hardly depends on it"
        half = np.full(len(z), math.nan)
        half[free] = NormalDist().inv_cdf(0.5 + 0.5 * CONFIDENCE) * errors
        columns = [
            self._replica.values(one).values() for one in (z, np.maximum(z - half, _LEAST), z + half, self._start)
        ]
        finite = [[one if math.isfinite(one) else None for one in column] for column in columns]
        estimates = tuple(
            Estimate(p.key, p.unit, value, low, high, start, why.get(p.key, ""))
            for p, value, low, high, start in zip(PARAMETERS, *finite, strict=True)
        )
        left, right, old_left, old_right = (rmse(one) for one in (*residuals.T, *before.T))
        excess = max(left / self._noise[0], right / self._noise[1])
        return Identified(estimates, len(residuals), (left, right), (old_left, old_right), correlation, float(excess))

    def _best(self) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Return the best of some searches and its free parameters; from a short lag some end at a local minimum."""
        searches: list[tuple[float, FloatArray, NDArray[np.bool_]]] = []
        for lag in (self._start[_KEYS.index("actuator.lag")], math.log(_LONG_LAG)):
            for slews in ([math.inf, math.inf], np.log(self._replica.peaks())):
                z = self._start.copy()
                z[_KEYS.index("actuator.lag")], z[[_KEYS.index(key) for key in _SLEWS]] = lag, slews
                free = np.isfinite(z)
                z = self._fit(z, free)
                searches.append((0.5 * float(np.sum(self._weighted(z) ** 2)) + _GAIN * free.sum(), z, free))
        _, z, free = min(searches, key=lambda one: one[0])
        return z, free

    def _errors(self, z: FloatArray) -> FloatArray:
        self._done += 1
        self._report(self._done)
        errors: FloatArray = self._replica.measured - self._replica.simulate(self._replica.values(z))
        return errors

    def _weighted(self, z: FloatArray) -> FloatArray:
        errors: FloatArray = (self._errors(z) * self._weights).ravel()
        return np.clip(np.nan_to_num(errors, nan=_LARGEST), -_LARGEST, _LARGEST)

    def _fit(self, z: FloatArray, free: NDArray[np.bool_]) -> FloatArray:
        from scipy.optimize import least_squares

        def whole(part: FloatArray) -> FloatArray:
            result = z.copy()
            result[free] = part
            return result

        low = _LEAST[free]
        # a command that was sent between two rows seems to be late
        low[[key == "dead_time" for key, is_free in zip(_KEYS, free, strict=True) if is_free]] = -self._replica.spacing
        result = least_squares(
            lambda part: self._weighted(whole(part)), np.maximum(z[free], low + 1e-6),
            lambda part: self._jacobian(whole(part), free), (low, math.inf),
            max_nfev=_EVALUATIONS, xtol=1e-6, ftol=1e-7,
        )  # fmt: skip
        return whole(result.x)

    def _jacobian(self, z: FloatArray, free: NDArray[np.bool_]) -> FloatArray:
        """Return the derivatives of weighted errors by the free parameters, shape (2 samples, parameters)."""
        base, steps = self._weighted(z), _STEP * np.eye(len(z))[free]
        columns: FloatArray = np.array([(self._weighted(z + one) - base) / _STEP for one in steps])
        return columns.reshape(len(steps), len(base)).T

    def _correlation(self, residuals: FloatArray) -> float:
        """Return the larger correlation of one sample with the next, at least 0."""
        centred = residuals - residuals.mean(axis=0)
        products = np.sum(centred[1:] * centred[:-1], axis=0) / np.maximum(np.sum(centred**2, axis=0), 1e-300)
        return float(np.clip(products.max(), 0.0, 0.99))
