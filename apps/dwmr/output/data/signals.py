"""Recorded signals as plain arrays with their metadata, common to all file formats."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from dwmr.scenario.model import Scenario
    from dwmr.simulation.simulate import Trajectory

FloatArray = NDArray[np.float64]

#: Name of the times among the signals.
TIME = "t"


@dataclass(frozen=True)
class Data:
    """Signals of runs.

    Args:
        runs: By control law, then by signal: `t` of shape (samples,) [s], all others of shape (samples, robots).
        metadata: Plain data: robots, units and meanings of the signals, scenario, rule files, versions.
    """

    runs: Mapping[str, Mapping[str, FloatArray]]
    metadata: Mapping[str, Any]

    @property
    def robots(self) -> tuple[str, ...]:
        """Names in the order of the arrays' second axis."""
        return tuple(self.metadata["robots"])

    def signals(self) -> tuple[str, ...]:
        """Return the names of all signals of all runs but `t`, in order."""
        return tuple(dict.fromkeys(name for run in self.runs.values() for name in run if name != TIME))


def of(trajectories: Sequence[Trajectory], scenario: Scenario, every: int, metadata: Mapping[str, Any]) -> Data:
    """Return the signals of some runs with their units, the Lyapunov functions of `lyapunov.signals` among them.

    Those are of the whole run, whatever is kept of it. A law without them has none, and where a signal of a law's own
    has the name of one, that signal is kept.

    Args:
        trajectories: One per control law, of the same robots.
        scenario: What was run.
        every: Samples between two that are kept; the last sample always is.
        metadata: What else to say about the runs.
    """
    from dwmr.results import lyapunov
    from dwmr.simulation.loop import SIGNALS

    units: dict[str, Any] = {TIME: {"unit": "s", "doc": "time"}}
    runs: dict[str, dict[str, FloatArray]] = {}
    for one in trajectories:
        kept = kept_samples(len(one.t), every)
        runs[one.controller] = {TIME: one.t[kept]}
        for signal in (*SIGNALS, *one.law_signals):
            runs[one.controller][signal.name] = one[signal.name][kept]
            units[signal.name] = {"unit": signal.unit, "doc": signal.doc}
        found = lyapunov.signals(one, scenario)
        for signal in lyapunov.SIGNALS:
            if signal.name in found and signal.name not in one.names:
                runs[one.controller][signal.name] = found[signal.name][kept]
                units.setdefault(signal.name, {"unit": signal.unit, "doc": signal.doc})
    return Data(runs, {**metadata, "robots": list(trajectories[0].robots), "signals": units})


def kept_samples(samples: int, every: int) -> NDArray[np.int64]:
    """Return the numbers of the samples that are kept: every `every`-th from the first on, and the last."""
    return np.union1d(np.arange(0, samples, every), [samples - 1])


def rows(data: Data) -> dict[str, Any]:
    """Return the signals as columns of one table, a row for each law, time and robot; None for what a law has not.

    Returns:
        "controller" and "robot" as lists, "t" and the signals as arrays or None, by control law and column.
    """
    count = len(data.robots)
    return {
        law: {
            "controller": [law] * (len(run[TIME]) * count),
            TIME: np.repeat(run[TIME], count),
            "robot": list(data.robots) * len(run[TIME]),
            **{name: run[name].reshape(-1) if name in run else None for name in data.signals()},
        }
        for law, run in data.runs.items()
    }


def from_rows(law: Sequence[str], columns: Mapping[str, FloatArray], metadata: Mapping[str, Any]) -> Data:
    """Return the signals of a table as `rows` makes it; which signals a law has is in the metadata.

    Args:
        law: Control law of each row.
        columns: `t` and the signals, each of as many numbers as there are rows.
        metadata: With `robots`, and `laws`, the names of signals by control law.
    """
    laws, count = np.array(law), len(metadata["robots"])
    runs = {}
    for name, signals in metadata["laws"].items():
        mine = laws == name
        runs[name] = {TIME: columns[TIME][mine][::count]}
        runs[name] |= {s: columns[s][mine].reshape(-1, count) for s in signals if s != TIME}
    return Data(runs, {k: v for k, v in metadata.items() if k != "laws"})


def described(data: Data) -> dict[str, Any]:
    """Return the metadata with the names of the signals of each law, which a table cannot tell from empty cells."""
    return {**data.metadata, "laws": {law: list(run) for law, run in data.runs.items()}}
