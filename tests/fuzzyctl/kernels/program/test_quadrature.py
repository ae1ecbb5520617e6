"""Adaptive integrals against areas and moments that are known."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyctl.kernels.backends import numpy_integrals
from fuzzyctl.kernels.program.quadrature import (
    DEEPEST,
    OF_ALL,
    OF_OWN,
    STEPS,
    half,
    jumps,
    marked,
    moments,
    rough_area,
    stretch,
    summed,
    within,
)

#: Number of halved stretches that each of two bends may leave, each with the error that is allowed to it.
CLOSE = 2 * DEEPEST * OF_ALL + OF_OWN
UNIT = 2.0**-53


def clipped(x, given):
    """A triangle from c - 1 to c + 1, clipped: its area is 2 h - h²."""
    center, height = given
    return min(max(0.0, 1.0 - abs(x - center)), height)


def two_blocks(x, _):
    return 1.0 if x <= 1.0 or x >= 3.0 else 0.0


@pytest.mark.parametrize("power", range(23))
def test_a_stretch_is_exact_for_polynomials_up_to_the_degree_of_the_rule(power):
    area, about, error = stretch(lambda x, _: x**power, (), 0.5, 0.5)
    # All terms are positive: a node is off by one rounding, which its power multiplies, and fifteen terms are added.
    allowed = 2 * (power + 20) * UNIT
    assert area == pytest.approx(1 / (power + 1), rel=allowed)
    if power < 22:
        # The moment about 0 has one power more; about the center it is a difference of two numbers below 1.
        assert about + 0.5 * area == pytest.approx(1 / (power + 2), abs=2 * allowed)
    if power <= 12:  # what the rule with seven points integrates exactly too
        # Differences of sums whose terms are below 1 in total, and of the polynomial next to the ends, which is exact.
        assert error <= 2 * (power + 20) * UNIT


def test_a_power_beyond_is_seen_in_the_error():
    assert stretch(lambda x, _: x**40, (), 0.5, 0.5)[2] > 1e-9


@given(st.floats(-3, 3), st.floats(0.05, 1))
@settings(max_examples=30, deadline=None)
def test_bends_between_places_are_found(center, height):
    moment, area = moments(clipped, (center - 1, center, center + 1), (center, height))
    whole = 2 * height - height**2
    # Places near a bend are off by rounding of x, which changes the area by as much.
    assert area == pytest.approx(whole, abs=CLOSE * whole + 8 * UNIT * 4)
    assert moment == pytest.approx(center * whole, abs=4 * (CLOSE * whole + 8 * UNIT * 4))


def test_a_gaussian_has_the_area_and_the_moment_that_are_known():
    moment, area = moments(lambda x, _: math.exp(-0.5 * x * x), (-1.0, 2.0), ())
    assert moment == pytest.approx(math.exp(-0.5) - math.exp(-2.0), abs=2 * CLOSE * area)
    known = math.sqrt(math.pi / 2) * (math.erf(2 / math.sqrt(2)) + math.erf(1 / math.sqrt(2)))
    assert area == pytest.approx(known, rel=CLOSE)


def test_a_jump_between_places_is_found():
    _, area = moments(lambda x, _: 1.0 if x <= 1 / 3 else 0.0, (0.0, 1.0), ())
    assert area == pytest.approx(1 / 3, rel=CLOSE)


@pytest.mark.parametrize("level", [0.0078, 0.5])
@pytest.mark.parametrize("power", [5.44, 20.0, 40.0])
class TestNoise:
    """Rounding makes noise of small degrees on the left; to the right of it, in the same stretch, the set bends."""

    PLACES = (0.0, 1.0)

    @staticmethod
    def notched(x, given):
        power, level = given
        return min(math.sqrt(1.0 - 1.0 / (1.0 + x**power)), level)

    @staticmethod
    def notched_arrays(x, given):
        power, level = given
        return np.minimum(np.sqrt(1.0 - 1.0 / (1.0 + x**power)), level)

    @staticmethod
    def known(power, level):
        """Return the area of the set without rounding, between the places where it bends."""
        bend = (level**2 / (1.0 - level**2)) ** (1 / power)
        _, area = moments(lambda x, _: math.sqrt(x**power / (1.0 + x**power)), (0.0, 0.5 * bend, bend), ())
        return area + (1.0 - bend) * level

    def test_leaves_halves_to_what_bends_elsewhere(self, power, level):
        _, area = moments(self.notched, self.PLACES, (power, level))
        assert area == pytest.approx(self.known(power, level), abs=3e-10)
        place, whole = half(self.notched, self.PLACES, (power, level))
        assert whole == area
        _, left = moments(self.notched, (0.0, place), (power, level))
        assert left == pytest.approx(0.5 * area, abs=3e-10)

    def test_leaves_halves_in_arrays_too(self, power, level):
        given = (np.array([power, 2.0]), np.array([level, 0.1]))
        for function in (numpy_integrals.moments, numpy_integrals.half):
            _, areas = function(self.notched_arrays, np.array(self.PLACES), given)
            assert areas[0] == pytest.approx(self.known(power, level), abs=3e-10)

    @staticmethod
    def stepped(x, given):
        """The same up to the level, and 1 beyond: the place of the jump moves with the level."""
        power, level = given
        degree = np.sqrt(1.0 - 1.0 / (1.0 + x**power))
        return np.where(degree < level, degree, 1.0)

    @staticmethod
    def crossing(x, given):
        power, level = given
        degree = np.sqrt(1.0 - 1.0 / (1.0 + x**power))
        slope = power * x ** (power - 1.0) / (1.0 + x**power) ** 2 / (2.0 * np.maximum(degree, 1e-30))
        return np.where(degree < level, 1.0, 0.0), degree - level, slope, np.full(np.shape(x), -1.0)

    @pytest.mark.filterwarnings("ignore:divide by zero:RuntimeWarning")
    def test_leaves_halves_to_jumps_elsewhere(self, power, level):
        bend = (level**2 / (1.0 - level**2)) ** (1 / power)
        by_level = bend * 2 / (power * level * (1.0 - level**2))
        moment, area = jumps(self.stepped, self.crossing, self.PLACES, (power, level))
        assert [moment, area] == pytest.approx([bend * by_level * (level - 1.0), by_level * (level - 1.0)], rel=1e-9)
        given = (np.array([power, 2.0]), np.array([level, 0.1]))
        moments_, areas = numpy_integrals.jumps(self.stepped, self.crossing, np.array(self.PLACES), given)
        assert [moments_[0], areas[0]] == pytest.approx([moment, area], rel=1e-12)


class TestReach:
    PLACES = (0.0, 1.0, 2.0)
    GIVEN = (1.0, 0.7)

    @pytest.mark.parametrize("bound", [0.01, 0.3, 0.455, 0.6, 0.9])
    def test_the_bound_is_passed_within_the_stretch(self, bound):
        allowed = OF_ALL * rough_area(clipped, self.PLACES, self.GIVEN)
        _, area, _, left, right, own = summed(clipped, self.PLACES, self.GIVEN, allowed, bound)
        assert area < bound <= area + own
        assert moments(clipped, (0.0, *(p for p in (1.0,) if p < left), left), self.GIVEN)[1] == pytest.approx(
            area, abs=CLOSE
        )
        assert 0.0 <= left < right <= 2.0

    def test_what_is_never_reached_gives_the_whole(self):
        allowed = OF_ALL * rough_area(clipped, self.PLACES, self.GIVEN)
        _, area, _, left, right, own = summed(clipped, self.PLACES, self.GIVEN, allowed, 1.0)
        assert area == pytest.approx(2 * 0.7 - 0.49, abs=CLOSE)
        assert (left, right, own) == (2.0, 2.0, 0.0)


class TestHalf:
    @pytest.mark.parametrize("height", [0.1, 0.5, 1.0])
    def test_of_a_symmetric_set_is_its_middle(self, height):
        place, area = half(clipped, (2.0, 3.0, 4.0), (3.0, height))
        assert place == pytest.approx(3.0, abs=CLOSE / height)
        assert area == pytest.approx(2 * height - height**2, abs=CLOSE)

    def test_at_a_gap_is_the_middle_of_the_gap(self):
        place, area = half(two_blocks, (0.0, 1.0, 3.0, 4.0), ())
        assert place == 2.0
        assert area == pytest.approx(2.0, abs=CLOSE)

    def test_within_a_stretch_ends_are_kept(self):
        assert within(two_blocks, (), 0.0, 1.0, 0.0, 1.0) == 0.0
        assert within(two_blocks, (), 0.0, 1.0, 1.0, 1.0) == 1.0


class TestArrays:
    """Many points at once have the places that each has by itself."""

    @staticmethod
    def clipped(x, given):
        center, height = given
        return np.minimum(np.maximum(0.0, 1.0 - np.abs(x - center)), height)

    @staticmethod
    def hills(x, given):
        """Two hills, the second of any height, with a gap between them."""
        (height,) = given
        first, second = (np.maximum(0.0, 1.0 - (x - c) ** 2) ** 2 for c in (1.0, 5.0))
        return first + height * second

    def both(self, function, places, given, scalar=None):
        """Return the places of many points at once, and of each by itself, where a function of numbers is faster."""
        with np.errstate(all="ignore"):  # as kernels do
            together = numpy_integrals.half(function, np.array(places), tuple(map(np.array, given)))
        alone = [half(scalar or function, places, tuple(map(float, one))) for one in zip(*given, strict=True)]
        return np.array(together).T, np.array(alone)

    def test_of_clipped_triangles(self):
        heights = np.linspace(0.01, 1.0, 300)  # more than are taken at once
        given = (np.linspace(0.5, 3.5, 300), heights)
        together, alone = self.both(self.clipped, (0.0, 1.0, 2.0, 4.0), given, clipped)
        assert together == pytest.approx(alone, rel=CLOSE, abs=CLOSE)

    def test_points_are_taken_together(self):
        calls = []

        def counted(x, given):
            calls.append(len(x))
            return self.clipped(x, given)

        centers, height = np.linspace(0.5, 3.5, numpy_integrals.PART), np.array(0.5)
        numpy_integrals.half(counted, np.array((0.0, 1.0, 2.0, 4.0)), (centers, height))
        assert len(calls) <= 1 + DEEPEST + 2 * STEPS  # of the levels of halving, and of Newton's steps

    def test_before_at_and_behind_a_gap(self):
        together, alone = self.both(self.hills, (0.0, 2.0, 4.0, 6.0), ([0.0, 0.5, 1.0, 1.0 + 1e-6, 2.0],))
        assert together == pytest.approx(alone, rel=CLOSE)
        assert together[2, 0] == 3.0
        assert together[1, 0] < 2.0 < 4.0 < together[4, 0]

    def test_of_small_areas_beside_large_ones(self):
        together, alone = self.both(self.clipped, (0.0, 1.0, 2.0), ([1.0, 1.2, 1.0], [1.0, 1e-12, 1e-200]))
        assert together == pytest.approx(alone, rel=1e-12)

    def test_nothing_and_no_number(self):
        together, alone = self.both(self.clipped, (0.0, 1.0, 2.0), ([1.0, math.nan, 1.0], [0.0, 1.0, math.nan]))
        np.testing.assert_array_equal(together, alone)


@given(st.lists(st.floats(-9, 9), min_size=1), st.lists(st.floats(-9, 9)))
def test_marks_are_sorted_in(places, marks):
    assert marked(sorted(places), tuple(marks)) == sorted([*places, *marks])
