"""Dead times of a run: what is kept of each delayed signal, and how it is looked up between samples."""

from __future__ import annotations

import math
from typing import Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.simulation.equations import DeadTime
from fuzzyctl.simulation.source import LAGS, WEIGHTS

#: Most numbers that a dead time keeps.
MOST_KEPT: Final = 10_000_000


def enough(delays: tuple[DeadTime, ...], step: float, substeps: int) -> int:
    """Return how many steps of integration there are between two samples: none is longer than a dead time.

    Args:
        delays: The dead times.
        step: Time between two samples [s].
        substeps: The fewest steps.
    """
    shortest = min((d.time for d in delays), default=math.inf)
    return max(substeps, math.ceil(step / shortest * (1.0 - 1e-9)))


def dead_times(delays: tuple[DeadTime, ...], step: float) -> tuple[int, list[int], list[float]]:
    """Return how many numbers are kept, positions and lags, and weights of the interpolation.

    Of each step of integration a signal is kept at its begin, middle and end; between them it is a parabola.

    Args:
        delays: The dead times.
        step: Of the integration [s].

    Raises:
        ArgumentError: For one that keeps more than `MOST_KEPT` numbers.
    """
    integers = [0] * (LAGS * len(delays))
    weights = [0.0] * (WEIGHTS * len(delays))
    offset = 0
    for k, delay in enumerate(delays):
        ratio = delay.time / step
        whole = round(ratio) if abs(ratio - round(ratio)) < 1e-9 * max(ratio, 1.0) else math.ceil(ratio)
        rest = max(whole - ratio, 0.0) if abs(whole - ratio) > 1e-9 * max(ratio, 1.0) else 0.0
        length = whole + 2
        if offset + 3 * length > MOST_KEPT:
            raise ArgumentError(f"a dead time of {delay.time:g} s is too long for steps of {step:g} s")
        integers[LAGS * k : LAGS * k + 2] = offset, length
        weights[WEIGHTS * k] = delay.start
        for part in range(3):
            share = 0.5 * part + rest
            lag = whole - (1 if share > 1.0 else 0)
            share -= whole - lag
            integers[LAGS * k + 2 + part] = lag
            at = WEIGHTS * k + 1 + 3 * part
            weights[at : at + 3] = (2 * share - 1) * (share - 1), 4 * share * (1 - share), share * (2 * share - 1)
        offset += 3 * length
    return max(offset, 1), integers, weights
