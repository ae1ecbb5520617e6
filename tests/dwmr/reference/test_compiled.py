import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dwmr import find, read
from dwmr.simulation.periods import PATHS
from fuzzyctl import DiagnosticError

eight = PATHS["eight"]
SHAPE = np.array([15.0, 15.0, 200.0, 2.0, 1.0])
OBSTACLES = ((0.0, 15.5), (8.0, -4.25), (-14.5, -11.25))


class TestEight:
    @given(st.floats(0.0, 200.0))
    def test_velocity_and_orientation_are_those_of_the_moving_point(self, t):
        h = 1e-4
        before, here, after = eight(t - h, SHAPE), eight(t, SHAPE), eight(t + h, SHAPE)
        x_dot, y_dot = (after.x - before.x) / (2 * h), (after.y - before.y) / (2 * h)
        assert math.hypot(x_dot, y_dot) == pytest.approx(here.v, rel=1e-5)
        assert math.cos(here.theta) * here.v == pytest.approx(x_dot, abs=1e-5)
        assert math.sin(here.theta) * here.v == pytest.approx(y_dot, abs=1e-5)

    def test_as_printed_lies_along_x(self):
        shape = np.array([15.0, 15.0, 200.0, 1.0, 2.0])
        for t in (3.0, 50.0, 171.0):
            printed, swapped = eight(t, shape), eight(t, SHAPE)
            assert (printed.x, printed.y, printed.v) == (swapped.y, swapped.x, swapped.v)

    def test_starts_at_the_origin_counter_clockwise(self):
        start, later = eight(0.0, SHAPE), eight(20.0, SHAPE)
        assert (start.x, start.y) == (0.0, 0.0)
        assert math.degrees(start.theta) == pytest.approx(26.57, abs=0.01)
        assert later.x > 0.0
        assert later.y > 0.0

    @pytest.mark.parametrize(
        ("obstacle", "when", "distance"), list(zip(OBSTACLES, (50.0, 109.0, 172.5), (0.50, 0.08, 0.35), strict=True))
    )
    def test_passes_the_obstacles_when_disturbances_act(self, obstacle, when, distance):
        times = np.arange(0.0, 200.0, 0.1)
        gaps = [math.hypot(eight(t, SHAPE).x - obstacle[0], eight(t, SHAPE).y - obstacle[1]) for t in times]
        assert min(gaps) == pytest.approx(distance, abs=0.01)
        assert times[int(np.argmin(gaps))] == pytest.approx(when, abs=0.5)


def reference(text):
    """Return the shape of a reference written as an inline table."""
    return read(find("paper"), [f"reference={text}"]).shape


CIRCLE = 'kind = "circle", centre_x = 1.0, centre_y = -2.0, radius = 5.0, period = 60.0'
CORNERS = "points = [[0.0, 0.0], [10.0, 0.0], [12.0, 8.0], [0.0, 9.0]]"
EVERY_KIND = {
    "circle": f'{{{CIRCLE}, direction = "counter-clockwise"}}',
    "clockwise": f'{{{CIRCLE}, direction = "clockwise", start_angle = 1.0}}',
    "line": '{kind = "line", start_x = 1.0, start_y = 2.0, angle = 4.0, speed = 0.5}',
    "waypoints": f'{{kind = "waypoints", {CORNERS}, speed = 0.4}}',
    "closed": f'{{kind = "waypoints", {CORNERS}, closed = true, duration = 80.0}}',
    "eight along x": '{kind = "eight", amplitude_x = 15.0, amplitude_y = 15.0, period = 200.0, along = "x"}',
}


class TestEveryKind:
    @pytest.mark.parametrize("name", EVERY_KIND)
    def test_orientation_and_velocity_are_those_of_the_moving_point(self, name):
        shape = reference(EVERY_KIND[name])
        for t in np.linspace(-20.0, 220.0, 301):
            h = 1e-4
            before, here, after = shape.at(t - h), shape.at(t), shape.at(t + h)
            assert math.cos(here.theta) * here.v == pytest.approx((after.x - before.x) / (2 * h), abs=1e-5)
            assert math.sin(here.theta) * here.v == pytest.approx((after.y - before.y) / (2 * h), abs=1e-5)

    @pytest.mark.parametrize("name", EVERY_KIND)
    def test_the_compiled_path_is_the_plain_one(self, name):
        shape = reference(EVERY_KIND[name])
        for t in np.linspace(-20.0, 220.0, 301):
            assert PATHS[shape.path](t, shape.constants) == pytest.approx(shape.at(t), abs=1e-12)


class TestStandstill:
    @pytest.mark.parametrize("along", ["x", "y"])
    @pytest.mark.parametrize("amplitudes", [(15.0, 15.0), (3.0, 15.0), (15.0, 3.0), (15.0, 0.1)])
    def test_of_an_eight_is_refused_exactly_where_its_speed_falls_below_the_bound(self, along, amplitudes):
        text = f'{{kind = "eight", amplitude_x = {amplitudes[0]}, amplitude_y = {amplitudes[1]}, along = "{along}", '
        once = reference(text + "period = 1.0}")
        slowest = min(once.at(t).v for t in np.linspace(0.0, 1.0, 4001))
        limit = slowest / 1e-3  # the speed is inverse to the period
        reference(f"{text}period = {limit * 0.999}}}")
        with pytest.raises(DiagnosticError, match=r"stands still: its speed is 0\.000999"):
            reference(f"{text}period = {limit * 1.0011}}}")

    def test_is_refused_with_its_time(self):
        with pytest.raises(DiagnosticError, match=r"speed is 0.000524 m/s at t = 0 s"):
            reference(f'{{{CIRCLE.replace("60.0", "60000.0")}, direction = "clockwise"}}')
        with pytest.raises(DiagnosticError, match=r"speed is 0.0001 m/s"):
            reference('{kind = "line", start_x = 1.0, start_y = 2.0, angle = 4.0, speed = 1e-4}')
        with pytest.raises(DiagnosticError, match=r"turns back on the spot near place 1"):
            reference('{kind = "waypoints", points = [[0.0, 0.0], [5.0, 0.0], [0.0, 0.0]], speed = 1.0}')
        with pytest.raises(DiagnosticError, match=r"points.2 is the same place as reference.points.1"):
            reference('{kind = "waypoints", points = [[0.0, 0.0], [5.0, 0.0], [5.0, 0.0]], speed = 1.0}')


class TestCircle:
    def test_begins_at_its_angle_and_turns_in_its_direction(self):
        there, later = reference(EVERY_KIND["circle"]).at(0.0), reference(EVERY_KIND["circle"]).at(15.0)
        assert (there.x, there.y) == pytest.approx((6.0, -2.0))
        assert (later.x, later.y) == pytest.approx((1.0, 3.0))
        clockwise = reference(EVERY_KIND["clockwise"])
        assert (clockwise.at(0.0).x, clockwise.at(0.0).y) == pytest.approx((1 + 5 * math.cos(1), -2 + 5 * math.sin(1)))
        assert clockwise.at(0.0).theta == pytest.approx(1.0 - math.pi / 2)


class TestWaypoints:
    @pytest.mark.parametrize("name", ["waypoints", "closed"])
    def test_are_all_visited_in_order(self, name):
        shape = reference(EVERY_KIND[name])
        way = np.array([(p.x, p.y) for p in map(shape.at, np.linspace(0.0, 80.0, 8001))])
        gaps = [np.linalg.norm(way - corner, axis=1) for corner in ((0, 0), (10, 0), (12, 8), (0, 9))]
        assert max(g.min() for g in gaps) < 0.01
        assert sorted(int(np.argmin(g)) for g in gaps) == [int(np.argmin(g)) for g in gaps]

    def test_are_passed_at_the_speed_or_in_the_time_that_is_given(self):
        shape = reference(EVERY_KIND["waypoints"])
        assert [shape.at(t).v for t in np.linspace(0.0, 70.0, 701)] == pytest.approx([0.4] * 701, abs=1e-4)
        assert reference(EVERY_KIND["closed"]).period == pytest.approx(80.0)

    def test_an_open_path_goes_on_straight_at_its_last_velocity(self):
        shape = reference(EVERY_KIND["waypoints"])
        last, later = shape.at(shape.end), shape.at(shape.end + 10.0)
        assert (last.x, last.y) == pytest.approx((0.0, 9.0), abs=1e-9)
        assert (later.theta, later.v) == pytest.approx((last.theta, last.v))
        assert (later.x, later.y) == pytest.approx(
            (last.x + 10 * last.v * math.cos(last.theta), last.y + 10 * last.v * math.sin(last.theta))
        )

    def test_a_closed_path_begins_again(self):
        shape = reference(EVERY_KIND["closed"])
        assert shape.at(7.0 + 3 * 80.0) == pytest.approx(shape.at(7.0))
        assert shape.at(80.0 - 1e-9) == pytest.approx(shape.at(0.0), abs=1e-6)


class TestEightTurnRate:
    @given(st.floats(0.0, 200.0))
    def test_is_the_rate_of_the_orientation(self, t):
        h = 1e-4
        change = eight(t + h, SHAPE).theta - eight(t - h, SHAPE).theta
        change = (change + math.pi) % (2 * math.pi) - math.pi
        assert eight(t, SHAPE).omega == pytest.approx(change / (2 * h), abs=1e-5)

    def test_keeps_the_printed_speeds_and_turn_rates(self):
        speeds = [eight(t, SHAPE).v for t in np.arange(0.0, 200.0, 0.1)]
        assert (min(speeds), max(speeds)) == pytest.approx((0.33, 1.05), abs=0.01)
        rates = [eight(t, SHAPE).omega for t in np.arange(0.0, 200.0, 0.1)]
        assert (min(rates), max(rates)) == pytest.approx((-0.18, 0.18), abs=0.005)
