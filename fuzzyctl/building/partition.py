"""Partitions given as Python values: names, and peaks or none."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real

from fuzzyctl.building import values
from fuzzyctl.building.values import Value
from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Expr, Name
from fuzzyctl.model.variable import Membership
from fuzzyctl.support import arguments


class Partition:
    """Triangular terms that meet at each other's peaks.

    Args:
        names: The terms, in order.
        peaks: Their peaks; None spreads them evenly over the range of the variable.
    """

    def __init__(self, names: tuple[str, ...], peaks: tuple[Expr, ...] | None) -> None:
        self.names, self.peaks = names, peaks

    def terms(self, lower: object, upper: object) -> list[tuple[str, Membership]]:
        """Return terms in order; one that is named twice is kept, for the checks to find as in a file."""
        peaks = self.peaks if self.peaks is not None else _even(lower, upper, len(self.names))
        feet = [-Name("inf"), *peaks, Name("inf")]
        triangles = (Membership(kind="triangle", arguments=(feet[k], p, feet[k + 2])) for k, p in enumerate(peaks))
        return list(zip(self.names, triangles, strict=True))


def partition(names: str | Sequence[str], peaks: Sequence[Value] | None = None) -> Partition:
    """Return a triangular partition: terms that meet at each other's peaks, with shoulders at the ends.

    Args:
        names: The terms, in a text separated by blanks or as a sequence.
        peaks: Their peaks; None spreads them evenly over the range of the variable.

    Raises:
        ArgumentError: For fewer than two terms, or another number of peaks.
    """
    given = arguments.names("'names'", names)
    at = None if peaks is None else arguments.items("'peaks'", "a list of numbers", peaks)
    if len(given) < 2 or (at is not None and len(at) != len(given)):
        got = f"{counted(len(given), 'term')}{'' if at is None else ' and ' + counted(len(at), 'peak')}"
        raise ArgumentError(f"a partition needs two terms or more and a peak for each, got {got}")
    return Partition(given, None if at is None else tuple(values.expression("a peak", p) for p in at))


def _even(lower: object, upper: object, count: int) -> tuple[Expr, ...]:
    """Return peaks spread evenly from end to end."""
    ends = [float(e) for e in (lower, upper) if isinstance(e, Real)]
    if len(ends) < 2 or not all(map(math.isfinite, ends)):
        raise ArgumentError("an even partition needs a range of finite numbers; give the peaks")
    last = count - 1
    return tuple(values.expression("a peak", (ends[0] * (last - k) + ends[1] * k) / last) for k in range(count))
