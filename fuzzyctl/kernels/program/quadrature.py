"""Adaptive quadrature of sets, down to rounding: for curved terms, and for norms without a closed form.

Their derivatives, which have both signs, are integrated in the same way.

The range is cut where terms have corners. Each stretch is integrated by the rules of Gauss and Kronrod with 7 and 15
points; where both differ it is halved, so that only around places where the set bends or jumps, such as where a term is
clipped, many short stretches arise. Stretches run from left to right, and the same ones in every backend.

The functions here are what generated Python calls, and what is pasted into modules for numba: they use nothing but
arithmetic, tuples and one list of floats.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final

Given = tuple[float, ...]
#: From a place and what else it depends on to the degree.
SetFunction = Callable[[float, Given], float]
#: The same to the values of `program.Crossings`.
CrossingFunction = Callable[[float, Given], tuple[float, ...]]

#: Positive nodes of the Kronrod rule with 15 points on [-1, 1], their weights, and those of the Gauss rule with 7
#: points, which has every other node (Piessens et al., QUADPACK, 1983).
NODES: Final = (
    0.991455371120812639206854697526329,
    0.949107912342758524526189684047851,
    0.864864423359769072789712788640926,
    0.741531185599394439863864773280788,
    0.586087235467691130294144691693690,
    0.405845151377397166906606412076961,
    0.207784955007898467600689403773245,
)
KRONROD: Final = (
    0.022935322010529224963732008058970,
    0.063092092629978553290700663189204,
    0.104790010322250183839876322541518,
    0.140653259715525918745189590510238,
    0.169004726639267902826583426598550,
    0.190350578064785409913256402421014,
    0.204432940075298892414161999234649,
)
GAUSS: Final = (
    0.0,
    0.129484966168869693270611432679082,
    0.0,
    0.279705391489276667901467771423780,
    0.0,
    0.381830050505118944950369775488975,
    0.0,
)
KRONROD_MIDDLE: Final = 0.209482141084727828012999174891714
GAUSS_MIDDLE: Final = 0.417959183673469387755102040816327

#: No node lies in the outer parts of a stretch, where a bend would not be seen. So the function is also looked at
#: next to both ends, and compared with the polynomial through the nodes. Ends themselves may be places of jumps.
END: Final = 1.0 - 1e-9
#: The polynomial at ±END is a sum over the nodes: these times f(x) + f(-x), plus or minus those times f(x) - f(-x).
EVEN: Final = (
    0.730111099156431581359002796250460,
    -0.362562734668144675065942090676127,
    0.225242720462736739489294951568692,
    -0.167334729984671505305792199546401,
    0.139447522589830276999719362035157,
    -0.124174646081349231204725695689811,
    0.115735346085408016989752553813647,
)
ODD: Final = (
    0.723872571497436880833149766123231,
    -0.344111160538275433987063863428216,
    0.194804415743794883636616540845952,
    -0.124083920841571920755643031951303,
    0.081728413089220448712026062681021,
    -0.050395678086515574741263122289755,
    0.024048063703228126551393266845960,
)
EVEN_MIDDLE: Final = -0.112929155120482406522619355511233
#: The share of half a stretch that lies beyond its last node: a difference at the end is at most there.
BEYOND: Final = 1.0 - NODES[0]

#: A stretch is halved while its error is more than both of these parts: of the whole area, and of its own.
OF_ALL: Final = 1e-14
OF_OWN: Final = 1e-13
#: By how much places are rounded, as a part of the largest: more of a narrow stretch than halving could gain.
ROUNDED: Final = 1e-15
#: A stretch is halved so often at most.
DEEPEST: Final = 60
#: Largest number of stretches of an integral; between two locations, a quarter of those left until the last ones. Where
#: a set is so steep that rounded locations make noise of its degrees, halving would take all, and the others none.
MOST: Final = 5000
#: Where they are not enough, as rounding makes noise of degrees, all are taken anew for an error so much larger, and so
#: often: else those on the left would take what those on the right need.
LOOSENED: Final = 100.0
LOOSER: Final = 3
#: Parts of half the area that are taken for rounding: where the area ends up to this, a gap may follow.
SLACK: Final = 1e-13
#: A bound that no area comes to.
NOWHERE: Final = math.nan
#: A speed that is not known.
INFINITE: Final = math.inf
#: Between neighbouring places a continuous difference of degrees changes by less; one that jumps itself by more.
CONTINUOUS: Final = 1e-6
#: Most steps to find a place within a stretch, and where they end, as a part of its length.
STEPS: Final = 60
NEAR: Final = 1e-15


def marked(places: Sequence[float], marks: Given) -> Sequence[float]:
    """Return places that rise, and marks among them."""
    found = [0.0] * (len(places) + len(marks))
    for k in range(len(places)):
        found[k] = places[k]
    count = len(places)
    for mark in marks:
        k = count
        while k > 0 and found[k - 1] > mark:
            found[k] = found[k - 1]
            k -= 1
        found[k] = mark
        count += 1
    return found


def stretch(function: SetFunction, given: Given, center: float, half: float) -> tuple[float, float, float]:
    """Return the area over a stretch, the moment about its center, and by how much both may be off."""
    value = function(center, given)
    area = KRONROD_MIDDLE * value
    other = GAUSS_MIDDLE * value
    moment = 0.0
    other_moment = 0.0
    even = EVEN_MIDDLE * value
    odd = 0.0
    for k in range(7):
        away = half * NODES[k]
        below = function(center - away, given)
        above = function(center + away, given)
        both = below + above
        apart = (above - below) * NODES[k]
        area += KRONROD[k] * both
        other += GAUSS[k] * both
        moment += KRONROD[k] * apart
        other_moment += GAUSS[k] * apart
        even += EVEN[k] * both
        odd += ODD[k] * (above - below)
    away = half * END
    ends = abs(function(center + away, given) - even - odd) + abs(function(center - away, given) - even + odd)
    error = abs(area - other) + abs(moment - other_moment) + BEYOND * ends
    return half * area, half * half * moment, half * error


def rough_area(function: SetFunction, places: Sequence[float], given: Given) -> float:
    """Return about the area between the first and the last of some places, that below 0 counted as above."""
    total = 0.0
    for k in range(len(places) - 1):
        left, right = places[k], places[k + 1]
        total += abs(stretch(function, given, 0.5 * left + 0.5 * right, 0.5 * (right - left))[0])
    return total


def moments(function: SetFunction, places: Sequence[float], given: Given) -> tuple[float, float]:
    """Return the first moment, about 0, and the area between the first and the last of some places."""
    moment, area, _ = integrals(function, places, given)
    return moment, area


def integrals(function: SetFunction, places: Sequence[float], given: Given) -> tuple[float, float, float]:
    """Return moment and area, and the error of a stretch up to which it was not halved."""
    allowed = OF_ALL * rough_area(function, places, given)
    moment, area, is_complete, _, _, _ = summed(function, places, given, allowed, NOWHERE)
    for _ in range(LOOSER):
        if not is_complete:
            allowed *= LOOSENED
            moment, area, is_complete, _, _, _ = summed(function, places, given, allowed, NOWHERE)
    return moment, area, allowed


def summed(
    function: SetFunction, places: Sequence[float], given: Given, allowed: float, bound: float
) -> tuple[float, float, bool, float, float, float]:
    """Add up stretches from the left until the area comes to a bound.

    Args:
        function: The set.
        places: Where it is cut, at least two.
        given: Its arguments besides the place.
        allowed: Error up to which a stretch is not halved.
        bound: An area; NOWHERE for all stretches.

    Returns:
        Moment and area before the stretch in which the area comes to the bound, whether there were enough stretches for
        the allowed error, the ends of this stretch, and its own area; its area is 0 where the area nowhere does.
    """
    rounded = ROUNDED * max(abs(places[0]), abs(places[len(places) - 1]))
    area = 0.0
    moment = 0.0
    is_complete = True
    left_over = MOST
    ends = [0.0] * (DEEPEST + 1)
    for k in range(len(places) - 1):
        left = places[k]
        ends[0] = places[k + 1]
        top = 0
        reserve = left_over - left_over // min(len(places) - 1 - k, 4)
        while top >= 0:
            right = ends[top]
            center = 0.5 * left + 0.5 * right
            own, about, error = stretch(function, given, center, 0.5 * (right - left))
            left_over -= 1
            size = abs(own)
            is_off = error > allowed and error > OF_OWN * size and error * (right - left) > rounded * size
            is_off = is_off and top < DEEPEST and left < center < right
            if is_off and left_over > reserve:
                top += 1
                ends[top] = center
            else:
                is_complete = is_complete and not is_off
                if area + own >= bound:
                    return moment, area, is_complete, left, right, own
                area += own
                moment += own * center + about
                left = right
                top -= 1
    end = places[len(places) - 1]
    return moment, area, is_complete, end, end, 0.0


def speed(here: tuple[float, ...], there: tuple[float, ...]) -> float:
    """Return the derivative of the place at which a set jumps, from the crossings at a place before and one behind it.

    By the implicit function theorem the place x of g(x, p) = 0 has the derivative -(∂g/∂p)/(∂g/∂x).

    Returns:
        0 without a crossing between both places; infinite for a jump that does not move, and while both are too far
        apart to tell.
    """
    for k in range(0, len(here), 4):
        if here[k] != there[k]:
            # On one side the difference may be constant, as that of a degree that is held above 0.
            side = there if here[k + 2] == 0.0 else here
            if abs(here[k + 1] - there[k + 1]) >= CONTINUOUS or side[k + 2] == 0.0:
                return INFINITE
            return -side[k + 3] / side[k + 2]
    return 0.0


def jumps(
    function: SetFunction, crossing: CrossingFunction, places: Sequence[float], given: Given
) -> tuple[float, float]:
    """Return the parts of moving jumps of a set in the derivatives of moment and area.

    Stretches are halved while the set is not smooth, and besides while something jumps between their ends, which takes
    none of the stretches of the other: noise of degrees on the left leaves those that jumps on the right need.
    """
    allowed = OF_ALL * rough_area(function, places, given)
    rounded = ROUNDED * max(abs(places[0]), abs(places[len(places) - 1]))
    area = 0.0
    moment = 0.0
    left_over = MOST
    left_over_of_jumps = MOST
    ends = [0.0] * (DEEPEST + 1)
    for k in range(len(places) - 1):
        left = places[k]
        ends[0] = places[k + 1]
        top = 0
        reserve = left_over - left_over // min(len(places) - 1 - k, 4)
        while top >= 0:
            right = ends[top]
            center = 0.5 * left + 0.5 * right
            own, _, error = stretch(function, given, center, 0.5 * (right - left))
            moved = speed(crossing(left, given), crossing(right, given))
            if moved == 0.0:
                left_over -= 1
                size = abs(own)
                is_off = error > allowed and error > OF_OWN * size and error * (right - left) > rounded * size
                is_off = is_off and left_over > reserve
            else:
                left_over_of_jumps -= 1
                is_off = left_over_of_jumps > 0
            if is_off and top < DEEPEST and left < center < right:
                top += 1
                ends[top] = center
            else:
                if abs(moved) < INFINITE:
                    share = moved * (function(left, given) - function(right, given))
                    area += share
                    moment += share * center
                left = right
                top -= 1
    return moment, area


def within(function: SetFunction, given: Given, left: float, right: float, wanted: float, whole: float) -> float:
    """Return up to where a stretch has some area, by Newton's method, held between bounds that close in."""
    if wanted <= 0.0 or whole <= 0.0:
        return left
    if wanted >= whole:
        return right
    low, high = left, right
    place = left + (right - left) * (wanted / whole)
    for _ in range(STEPS):
        area, _, _ = stretch(function, given, 0.5 * left + 0.5 * place, 0.5 * (place - left))
        beyond = area - wanted
        if beyond > 0.0:
            high = place
        else:
            low = place
        degree = function(place, given)
        following = place - beyond / degree if degree > 0.0 else high
        if not low < following < high:
            following = 0.5 * low + 0.5 * high
        if abs(following - place) <= NEAR * (right - left):
            return following
        place = following
    return place


def half(function: SetFunction, places: Sequence[float], given: Given) -> tuple[float, float]:
    """Return where the area to the left is half of all, and the area; at a gap the middle of the gap."""
    _, whole, allowed = integrals(function, places, given)
    wanted = 0.5 * whole
    _, area, _, left, right, own = summed(function, places, given, allowed, (1.0 - SLACK) * wanted)
    _, _, _, after, _, _ = summed(function, places, given, allowed, (1.0 + SLACK) * wanted)
    if after > right:
        return 0.5 * right + 0.5 * after, whole
    return within(function, given, left, right, wanted - area, own), whole
