"""Confidence intervals of measures over repeated runs."""

from __future__ import annotations

import math
from collections.abc import Sequence

#: Share of such intervals that hold the true value.
CONFIDENCE = 0.95


def mean_interval(values: Sequence[float]) -> tuple[float, float] | None:
    """Return the confidence interval of a mean by Student's t; a single value has none.

    The values are taken for independent; the interval holds for the mean of many of them whatever their distribution,
    for that of a few when they are about normal.

    Args:
        values: One per run.

    Source:
        Student, The probable error of a mean, Biometrika 6, 1908: mean ± t(n − 1) s/√n.
    """
    n = len(values)
    if n < 2:
        return None
    from scipy import special  # a second to load, and a mistake on the command line is answered without it

    mean = math.fsum(values) / n
    deviation = math.sqrt(math.fsum((v - mean) ** 2 for v in values) / (n - 1))
    half = float(special.stdtrit(n - 1, 0.5 + 0.5 * CONFIDENCE)) * deviation / math.sqrt(n)
    return mean - half, mean + half


def share_interval(hits: int, n: int) -> tuple[float, float] | None:
    """Return the confidence interval of a probability that was seen as `hits` of `n` runs; a single run has none.

    Unlike mean ± z s/√n it has a width when nothing was hit, or everything.

    Source:
        Wilson, Probable inference, the law of succession, and statistical inference, JASA 22, 1927.
    """
    if n < 2:
        return None
    from scipy import special

    z = float(special.ndtri(0.5 + 0.5 * CONFIDENCE))
    share, spread = hits / n, z * z / n
    middle = (share + 0.5 * spread) / (1.0 + spread)
    half = z / (1.0 + spread) * math.sqrt(share * (1.0 - share) / n + 0.25 * spread / n)
    return max(0.0, middle - half), min(1.0, middle + half)
