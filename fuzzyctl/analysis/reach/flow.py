"""Reachable sets of differential equations over a step: Taylor polynomials over forms, with a proved remainder.

Source:
    Makino, Berz: Taylor models and other validated functional inclusion methods, 2003; Nedialkov, Jackson, Corliss:
    Validated solutions of initial value problems for ordinary differential equations, 1999 (a-priori enclosures).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from fuzzyctl.analysis.reach import forms
from fuzzyctl.analysis.reach.forms import DomainError, Form, Value, as_form, ends, hulled, interval, plus, scaled
from fuzzyctl.analysis.reach.series import Nodes, NotSmoothError, Series
from fuzzyctl.analysis.reach.slopes import Slopes

#: Highest order of the Taylor polynomials, and the part of a state's radius that the remainder of a lower one may have.
ORDER: Final = 4
_SMALL: Final = 1e-4
#: How often a tube is widened before the step is halved.
_TRIES: Final = 12
#: Relative error of times.
_ROUNDING: Final = 8 * 2.0**-53


class NoTubeError(Exception):
    """Raised if no a-priori enclosure is proved: the step is too long, or a solution may grow without limit."""


class Flow:
    """Solutions of x' = f(t, x, u) over steps in which u is constant.

    Args:
        nodes: Derivatives of the states from time, states and constants, in this order.
        states: How many states there are.
        influence: The derivatives of f by the states and the disturbances; None without disturbances.
        spread: Half the widths of the ranges of the disturbances, which are the last constants of `nodes`.
    """

    def __init__(
        self, nodes: Nodes, states: int, influence: Slopes | None = None, spread: Sequence[float] = ()
    ) -> None:
        self.nodes, self.states, self.influence, self.spread = nodes, states, influence, np.array(spread)
        #: Ends of the derivatives over the last tube, which propose the next one.
        self._rates: Form | None = None

    @np.errstate(all="ignore")
    def tube(
        self, time: float, step: float, x: Sequence[Form], constants: Sequence[Value]
    ) -> tuple[list[Form], Series]:
        """Return intervals that hold all solutions over a step, by Picard's inclusion, and f over slightly wider ones.

        Raises:
            NoTubeError: If none is proved.
        """
        fixed = [c if isinstance(c, float) else hulled(c) for c in constants]
        tube = start = [hulled(a) for a in x]
        clock = _clock(time, step)
        lows, highs = _ends(start)
        if self._rates is not None and self._rates.shape[-1] == lows.shape[-1]:  # the tube is that of the step before
            tube = _intervals(*_grown(*np.broadcast_arrays(*_moved(lows, highs, step * self._rates))))
        for attempt in range(_TRIES):
            series = Series(self.nodes, [clock, *tube, *fixed])
            rates = np.stack(_ends([as_form(r) for r in series.extend()]))
            low, high = np.broadcast_arrays(*_moved(lows, highs, step * rates))
            if not (np.all(np.isfinite(low)) and np.all(np.isfinite(high))):
                break
            next_tube = _intervals(low, high)
            if all(_holds(a, b) for a, b in zip(tube, next_tube, strict=True)):
                self._rates = rates
                return next_tube, series
            low, high = _grown(low, high)
            if attempt:
                old_low, old_high = _ends(tube)
                low, high = np.minimum(low, old_low), np.maximum(high, old_high)
            tube = _intervals(low, high)
        self._rates = None
        raise NoTubeError

    @np.errstate(all="ignore")
    def advance(
        self, time: float, step: float, x: Sequence[Form], constants: Sequence[Value]
    ) -> tuple[list[Form], list[Form]]:
        """Return the states at the end of a step, and over it.

        Args:
            time: At the begin of the step [s].
            step: Its length [s].
            x: Forms of the states.
            constants: Values that stay as they are over the step.

        Returns:
            Forms at the end, with independent errors, and forms over the step, in which the last symbol is the time.

        Raises:
            NoTubeError: If no enclosure of the solutions is proved.
        """
        if not x:
            return [], []
        tube, whole = self.tube(time, step, x, self._disturbed(constants))
        apart = self._deviation(time, step, tube, constants)
        polynomial: list[list[Value]]
        begin = np.array([[time, _ROUNDING * abs(time)]])
        small = [forms.radius(a) * _SMALL for a in x]
        for again in (True,) if self.spread.size else (False, True):
            try:
                if again:  # f over the tube itself, which a limit may touch that the wider one crosses
                    whole = Series(self.nodes, [_clock(time, step), *tube, *(_flat(c) for c in constants)])
                    whole.extend()
                *lower, rest = self._coefficients(whole, tube, ORDER + 1, small, step)
                series = Series(self.nodes, [begin, *x, *constants], whole)
                series.extend()
                polynomial = self._coefficients(series, x, len(lower) - 1)
                break
            except (NotSmoothError, DomainError):
                continue
        else:  # order 0 may be known where derivatives are not, as of a root at 0
            rest = self._over_tube(time, step, x, tube, constants)
            polynomial = [list(x)]
        end = [_evaluated([p[k] for p in polynomial], as_form(rest[k]), step) for k in range(self.states)]
        over = [_over([p[k] for p in polynomial], as_form(rest[k]), step) for k in range(self.states)]
        if apart is not None:
            for row, width in zip((*end, *over), (*apart, *apart), strict=True):
                row[..., 1] += width
        if not all(np.all(np.isfinite(row)) for row in (*end, *over)):
            raise NoTubeError
        return end, over

    def _disturbed(self, constants: Sequence[Value]) -> list[Value]:
        """Return the constants with the ranges of the disturbances, given at their centres."""
        count = len(constants) - len(self.spread)
        ranges = [
            interval(np.array([c - s]), np.array([c + s]))
            for c, s in zip(constants[count:], self.spread, strict=True)
            if isinstance(c, float)
        ]
        return [*constants[:count], *ranges]

    def _deviation(self, time: float, step: float, tube: Sequence[Form], constants: Sequence[Value]) -> Form | None:
        """Return how far disturbances move each state within a step at most, shape (states, boxes); None without any.

        The difference y of a disturbed solution and the one with the disturbances at their centres, both in the tube,
        obeys |y|' <= M |y| + b componentwise, M with the largest derivatives of f by the states, b with those by the
        disturbances (Gronwall). So |y| <= (integral of exp(M s) ds) b.
        """
        if self.influence is None:
            return None
        arguments = [_clock(time, step), *tube, *(_flat(c) for c in self._disturbed(constants))]
        n, boxes = self.states, max(t.shape[0] for t in tube)
        slopes = [self.influence.over([_box(a, box) for a in arguments]) for box in range(boxes)]
        low, high = (np.stack(e, -1) for e in zip(*map(ends, slopes), strict=True))
        largest = np.maximum(np.abs(low), np.abs(high))
        growth = largest[:, :n].copy()
        for k in range(n):
            growth[k, k] = np.maximum(high[k, k], 0.0)
        if float(growth.sum(1).max(initial=0.0)) * step > 1.0:
            raise NoTubeError
        term = np.einsum("ijb,j->ib", largest[:, n:], self.spread) * step
        first = total = term
        for k in range(2, 20):
            term = np.einsum("ijb,jb->ib", growth, term) * (step / k)
            total = total + term
        return np.asarray(total * (1.0 + 1e-12) + 1e-17 * first.max() + 1e-300)

    def _over_tube(
        self, time: float, step: float, x: Sequence[Form], tube: Sequence[Form], constants: Sequence[Value]
    ) -> list[Value]:
        """Return the derivatives over a step, correlated with the states at its begin."""
        moved = []
        rates = Series(self.nodes, [_clock(time, step), *tube, *map(_flat, constants)]).extend()
        for a, rate in zip(x, rates, strict=True):
            low, high = ends(as_form(rate))
            moved.append(plus(a, interval(np.minimum(step * low, 0.0), np.maximum(step * high, 0.0))))
        return Series(self.nodes, [_clock(time, step), *moved, *constants]).extend()

    def _coefficients(
        self, series: Series, x: Sequence[Value], order: int, small: Sequence[Form] = (), step: float = 1.0
    ) -> list[list[Value]]:
        """Return the Taylor coefficients of the states from order 0 on, up to an order.

        Args:
            series: Of the derivatives, extended to order 0.
            x: The states.
            order: The order.
            small: Radii that end the series early: those of terms of order 2 or more that all are smaller over a step.
            step: The step.
        """
        results: list[list[Value]] = [list(x)]
        idle = [0.0] * (len(series.nodes.inputs) - 1 - len(x))
        rates = [series.coefficients[at][0] for at in series.nodes.values]
        for k in range(order):
            if k:
                rates = series.extend([1.0 if k == 1 else 0.0, *results[-1], *idle])
            results.append([forms.divided(r, k + 1) for r in rates])
            if k and small:
                sizes = [forms.radius(as_form(r)) * step ** (k + 1) for r in results[-1]]
                if all(bool(np.all(a <= b)) for a, b in zip(sizes, small, strict=True)):
                    break
        return results


def _box(a: Value, box: int) -> Value:
    """Return the value of one box."""
    return a if isinstance(a, float) else a[min(box, a.shape[0] - 1)][None]


def _flat(a: Value) -> Value:
    return a if isinstance(a, float) else hulled(a)


def _clock(time: float, step: float) -> Form:
    """Return the times of a step; of a signal that jumps at an end see `Series`."""
    return interval(np.array([time]), np.array([time + step]))


def _ends(rows: Sequence[Form]) -> tuple[Form, Form]:
    """Return the ends of some values, shape (values, boxes)."""
    pairs = [ends(r) for r in rows]
    boxes = max((len(low) for low, _ in pairs), default=1)
    low, high = (np.array([np.broadcast_to(e, boxes) for e in side]) for side in zip(*pairs, strict=True))
    return low, high


def _moved(low: Form, high: Form, change: Form) -> tuple[Form, Form]:
    """Return the ends of values that change by up to some steps, the least and the largest ones."""
    return low + np.minimum(change[0], 0.0), high + np.maximum(change[1], 0.0)


def _grown(low: Form, high: Form) -> tuple[Form, Form]:
    """Return ends that are a little farther apart."""
    more = 0.05 * (high - low) + 1e-12 * (1.0 + np.abs(low) + np.abs(high))
    return low - more, high + more


def _intervals(low: Form, high: Form) -> list[Form]:
    return [interval(a, b) for a, b in zip(low, high, strict=True)]


def _holds(a: Form, b: Form) -> bool:
    """Return whether intervals hold others."""
    (low, high), (inner_low, inner_high) = ends(a), ends(b)
    return bool(np.all(low <= inner_low) and np.all(inner_high <= high))


def _evaluated(coefficients: Sequence[Value], rest: Form, step: float) -> Form:
    """Return a polynomial with its remainder at the end of a step."""
    total: Value = scaled(hulled(rest), step ** len(coefficients)) if len(coefficients) > 1 else scaled(rest, step)
    for k in range(len(coefficients) - 1, -1, -1):
        total = plus(total, scaled(coefficients[k], step**k))
    return as_form(total)


def _over(coefficients: Sequence[Value], rest: Form, step: float) -> Form:
    """Return a polynomial with its remainder over a step.

    The last symbol is the time, -1 at the begin of the step, 1 at its end.
    """
    start = as_form(coefficients[0])
    total = forms.widened(start, start.shape[-1] + 1)
    if len(coefficients) > 1:  # the linear part at the middle, and its slope along the time
        slope = as_form(scaled(coefficients[1], 0.5 * step))
        total = as_form(plus(total, slope)).copy()
        total[..., -1] += slope[..., 0]
        total[..., 1] += forms.radius(slope)
    parts = [*enumerate(coefficients[2:], 2), (len(coefficients), rest)]
    for power, part in parts:
        if not (isinstance(part, float) and part == 0.0):
            low, high = (e * step**power for e in ends(as_form(part)))
            total = as_form(plus(total, interval(np.minimum(low, 0.0), np.maximum(high, 0.0))))
    return total
