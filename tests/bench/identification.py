"""Coverage of the intervals of `dwmr identify` over logs with known parameters.

    python -m tests.bench.identification [LOGS]

prints for each parameter the share of intervals that contain the truth and half of their median width over it, with
white noise and with noise that correlates.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from dwmr import Log, Replica, find, identify, read

ROBOT = "leader"
#: Gains as forces, which tell mass and friction apart; periods of 10 ms take half the time.
FORCES = (
    "run.dt=0.01",
    "run.substeps=2",
    "robot.inner_loop.torque_reading=force",
    "robot.inner_loop.k_p_v=400.0",
    "robot.inner_loop.k_p_omega=60.0",
    "robot.inner_loop.k_d_v=20.0",
    "robot.inner_loop.k_d_omega=2.0",
)
#: Drives of the robot that made the logs.
DRIVES = ("lag=0.05", "acceleration=0.8", "angular_acceleration=1.7")
DEAD_TIME = 0.03
#: Standard deviations of the measured velocities [m/s, rad/s].
NOISE = (0.005, 0.01)
#: Time between two rows, duration, and time between two commands [s].
STEP, DURATION, HOLD = 0.02, 20.0, 1.0


def scenario(*overrides: str):
    """Return the scenario of the robot; overrides replace those of `FORCES`."""
    values = dict(one.split("=", 1) for one in (*FORCES, *overrides))
    return read(find("paper-with-limits"), [f"{key}={value}" for key, value in values.items()]).scenario


def truth(*overrides: str):
    """Return the same with the drives that made the logs."""
    return scenario(*(f"robot.actuator.{one}" for one in DRIVES), *overrides)


def log_of(true, seed: int, noise: Any = NOISE, correlation: float = 0.0) -> Log:
    """Return a log of steps of the commands; noise follows x[k+1] = ρ x[k] + white noise with ρ `correlation`."""
    random, steps = np.random.default_rng(seed), round(DURATION / HOLD)
    commands = np.repeat(random.uniform((-1.0, -1.2), (1.0, 1.2), (steps, 2)), round(HOLD / STEP), axis=0)
    commands[: round(1.0 / STEP)] = 0.0
    t = STEP * np.arange(len(commands))
    robot = Replica(_at_rest(t, commands), true, ROBOT)
    moving = robot.simulate({**robot.start, "dead_time": DEAD_TIME})
    velocities = np.concatenate([np.zeros((len(t) - len(moving), 2)), moving])
    errors = random.standard_normal(velocities.shape) * noise
    for k in range(1, len(t) if correlation else 0):
        errors[k] = correlation * errors[k - 1] + np.sqrt(1.0 - correlation**2) * errors[k]
    v, omega = (velocities + errors).T
    return Log(t, {"v": v, "omega": omega}, t, commands)


def _at_rest(t, commands) -> Log:
    return Log(t, {"v": np.zeros(len(t)), "omega": np.zeros(len(t))}, t, commands)


def identified(log: Log, start):
    """Return the estimates from a log."""
    return identify(log, start, ROBOT)


def true_values(true) -> dict[str, float]:
    """Return the parameters of a robot by key."""
    t = STEP * np.arange(200)
    return {**Replica(_at_rest(t, np.zeros((200, 2))), true, ROBOT).start, "dead_time": DEAD_TIME}


def coverage(results: Sequence[Any], true: dict[str, float]) -> dict[str, tuple[float, float, int]]:
    """Return by key the share of intervals with the truth, half their median width over it, and their number."""
    table = {}
    for key, value in true.items():
        rows = [one for r in results for one in r.estimates if one.key == key and one.low is not None]
        hits = [one.low <= value <= one.high for one in rows]
        widths = [0.5 * (one.high - one.low) / value for one in rows]
        table[key] = (float(np.mean(hits)), float(np.median(widths)), len(rows)) if rows else (np.nan, np.nan, 0)
    return table


def main() -> None:
    """Print both tables."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    for correlation in (0.0, 0.6):
        logs = (log_of(truth(), seed, correlation=correlation) for seed in range(count))
        results = [identified(log, scenario()) for log in logs]
        print(f"{count} logs, correlation of the noise {correlation:g}")
        for key, (share, width, number) in coverage(results, true_values(truth())).items():
            print(f"| `{key}` | {100.0 * share:.0f} % of {number} | {100.0 * width:.2g} % |", flush=True)


if __name__ == "__main__":
    main()
