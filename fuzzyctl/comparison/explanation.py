"""Settings that explain a difference: those of the second system are put into the first, one by one."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from fuzzyctl.comparison.differences import Difference, Place, Progress, at_point, at_points, pairing
from fuzzyctl.comparison.parts import Part, parts
from fuzzyctl.comparison.points import common_points
from fuzzyctl.diagnostics.diagnostic import FuzzyctlError
from fuzzyctl.expr import ExprError
from fuzzyctl.model.system import FuzzySystem

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

#: What is left of a difference counts as nothing below this part of it: rounding of two ways to compute.
NOTHING: Final = 1e-9

#: Up to this part of the range of an output, or of its values, a difference is rounding, which has no cause.
ROUNDING: Final = 1e-14

#: Points that a mean difference is explained at.
SAMPLE: Final = 256

#: Part of a mean difference that may be left once the causes of the largest one are gone; more has causes of its own.
ELSEWHERE: Final = 0.1

#: How far a system is from what it is to become; infinite where that cannot be said.
Distance = Callable[[FuzzySystem], float]


@dataclass(frozen=True)
class Cause:
    """A setting that both systems have in different ways.

    Args:
        name: The setting, or what else it is, such as `terms of food`.
        before: How the first system has it.
        after: How the second one does.
        explains: Part of the difference that is gone once the first system has it as the second does, after the causes
            before it in the list; may be negative where two causes work against each other.
    """

    name: str
    before: str
    after: str
    explains: float


@dataclass(frozen=True)
class Explanation:
    """What explains a difference, the largest cause first.

    Args:
        largest: Causes of the largest difference; none where there is none.
        mean: Those of the mean difference, where it is no more than partly explained by the causes of the largest.
        gap: Settings that each resolve a point where only one of both systems has a value.
        rounding: Whether the largest difference is no more than rounding, which has no cause.
    """

    largest: tuple[Cause, ...] = ()
    mean: tuple[Cause, ...] = ()
    gap: tuple[Cause, ...] = ()
    rounding: bool = False


def explanation(
    a: FuzzySystem, b: FuzzySystem, difference: Difference, *, progress: Progress | None = None
) -> Explanation:
    """Explain a difference: settings of the second system are put into the first, each time the one that helps most.

    Args:
        a: The first system.
        b: The second one.
        difference: What `differences` found for one output.
        progress: Called now and then.
    """
    _, outputs = pairing(a, b)
    output = [o.name for o in a.outputs].index(difference.output)
    gap = () if difference.gap is None else _resolving(a, b, difference.gap, output)
    if difference.largest <= ROUNDING * _scale(a, difference, output):
        return Explanation(gap=gap, rounding=difference.largest > 0.0)
    place = Place(difference.point, difference.first, difference.second)
    if not math.isfinite(difference.largest):
        # A gap that is the only difference is explained once.
        return Explanation(gap=gap) if difference.gap else Explanation(_resolving(a, b, place, output)[:1])
    point, target = [difference.point[v.name] for v in a.inputs], difference.second

    def reported(distance: Distance) -> Distance:
        """Tell of each try."""

        def far(system: FuzzySystem) -> float:
            if progress is not None:
                progress(f"looking for what explains {difference.output}")
            return distance(system)

        return far

    largest, changed = _greedy(a, b, reported(lambda system: abs(at_point(system, point, output) - target)))
    mean = reported(_mean_distance(a, b, output, outputs[output]))
    start = mean(a)
    if not 0.0 < start < math.inf or mean(changed) <= ELSEWHERE * start:
        return Explanation(largest, gap=gap)
    return Explanation(largest, _greedy(a, b, mean)[0], gap)


def _scale(system: FuzzySystem, difference: Difference, output: int) -> float:
    """Return how large an output is: the width of its range, or of its values, the larger one."""
    declared = system.outputs[output]
    values = (system.number(declared.lower), system.number(declared.upper), difference.first, difference.second)
    return max((abs(v) for v in values if math.isfinite(v)), default=0.0)


def causes(a: FuzzySystem, b: FuzzySystem, difference: Difference) -> tuple[Cause, ...]:
    """Return the causes of the largest difference; where only one system has a value, of that."""
    found = explanation(a, b, difference)
    return found.largest or found.gap


def _greedy(a: FuzzySystem, b: FuzzySystem, distance: Distance) -> tuple[tuple[Cause, ...], FuzzySystem]:
    """Put parts of the second system into the first, the best first, until the distance is gone or no part helps.

    Returns:
        The parts with what each explains, and the first system with them.
    """
    found: list[Cause] = []
    left, current, start = list(parts(a, b, *pairing(a, b))), a, distance(a)
    far = start
    while left and far > NOTHING * start:
        tried = [(part, *_with(current, part, distance)) for part in left]
        # A part that changes nothing, or gives no value, is no cause.
        working = [
            (part.last, d, k) for k, (part, s, d) in enumerate(tried) if s is not None and d != far and math.isfinite(d)
        ]
        if not working:
            break  # what is left takes several parts at once
        *_, best = min(working)
        part, system, new = tried[best]
        assert system is not None
        found.append(Cause(part.name, part.before, part.after, (far - new) / start))
        left.remove(part)
        current, far = system, new
    return tuple(found), current


def _with(system: FuzzySystem, part: Part, distance: Distance) -> tuple[FuzzySystem | None, float]:
    """Return the system with one part of the other and its distance; None where the part does not go without others."""
    try:
        changed = part.put(system)
        return changed, distance(changed)
    except (FuzzyctlError, ExprError):
        return None, math.inf


def _mean_distance(a: FuzzySystem, b: FuzzySystem, output: int, other: int) -> Distance:
    """Return the mean distance of a system from the second one, over points where both have a value at first."""
    import numpy as np

    inputs, _ = pairing(a, b)
    points = common_points(a, b, inputs, SAMPLE, 0)
    first = at_points(a, points, output)
    target = at_points(b, points[:, np.argsort(inputs)], other)
    both = np.isfinite(first) & np.isfinite(target)
    points, target = points[both], target[both]

    def mean(system: FuzzySystem) -> float:
        return float(np.abs(at_points(system, points, output) - target).mean()) if len(points) else math.inf

    return mean


def _resolving(a: FuzzySystem, b: FuzzySystem, place: Place, output: int) -> tuple[Cause, ...]:
    """Return the parts that each make both systems finite at a point, or neither."""
    point = [place.point[v.name] for v in a.inputs]

    def differs(system: FuzzySystem) -> float:
        value = at_point(system, point, output)
        same = math.isfinite(value) == math.isfinite(place.second) and math.isnan(value) == math.isnan(place.second)
        return 0.0 if same else 1.0

    tried = [(part, _with(a, part, differs)[1]) for part in parts(a, b, *pairing(a, b))]
    working = [part for part, left in tried if left == 0.0]
    single = [part for part in working if not part.last] or working
    return tuple(Cause(p.name, p.before, p.after, 1.0) for p in single)
