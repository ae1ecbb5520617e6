"""Runs of formations as graphs: places in a virtual structure, and weighted means of those beside neighbours."""

import numpy as np
import pytest

from dwmr import measure, read, simulate
from dwmr.control.formation import follower_position
from tests.dwmr.scenarios import KNOWN, PAPER, run

SHORT = ("run.horizon=3", "obstacles=[]")
PLACE = 'leader="leader",separation=1.25,bearing=2.356194490192345'


def short(*overrides):
    """A short run and its scenario."""
    file = read(PAPER, (*SHORT, *overrides))
    return simulate(file, "fcafsmc", known=KNOWN), file


class TestConsensus:
    def test_of_one_neighbour_is_a_separation_and_bearing(self):
        usual, _ = short()
        one, _ = short(f'robots.follower1.formation={{kind="consensus",neighbours=[{{{PLACE}}}]}}')
        assert np.array_equal(one.values, usual.values)

    def test_of_one_neighbour_twice_is_the_same_but_for_rounding(self):
        usual, _ = short()
        twice = f"{{{PLACE},weight=0.25}},{{{PLACE},weight=0.75}}"
        one, _ = short(f'robots.follower1.formation={{kind="consensus",neighbours=[{twice}]}}')
        assert np.abs(one.values - usual.values)[:, :, :12].max() < 1e-9

    def test_is_the_weighted_mean_of_the_places_in_a_cycle_too(self):
        def neighbours(other, bearing):
            return (
                f'{{kind="consensus",neighbours=[{{leader="leader",separation=1.6,bearing={bearing},weight=0.7}},'
                f'{{leader="{other}",separation=2.3,bearing={0.6 * bearing},weight=0.3}}]}}'
            )

        trajectory, file = short(
            f"robots.follower1.formation={neighbours('follower2', 2.3)}",
            f"robots.follower2.formation={neighbours('follower1', -2.3)}",
        )
        names, robots = list(trajectory.robots), file.scenario.robots
        for name in ("follower1", "follower2"):
            place = np.zeros(2)
            for edge in robots[name].edges:
                i = names.index(edge.leader)
                x, y, theta = (trajectory[key][-1, i] for key in ("x", "y", "theta"))
                d = robots[edge.leader].d
                place += edge.weight * np.array(follower_position(x, y, theta, d, edge.separation, edge.bearing))
            there = [trajectory[key][-1, names.index(name)] for key in ("x_r", "y_r")]
            assert there == pytest.approx(place, abs=1e-12)
        far = measure(trajectory, file.scenario, ["amplification"])["amplification"]
        rms = {n: np.sqrt(np.mean(trajectory["x_e"][:, k] ** 2 + trajectory["y_e"][:, k] ** 2))
               for k, n in enumerate(names)}  # fmt: skip
        assert far["follower1"] == pytest.approx(rms["follower1"] / (0.7 * rms["leader"] + 0.3 * rms["follower2"]))
        assert set(far) == {"follower1", "follower2"}

    def test_of_orientations_on_both_sides_of_half_a_turn_is_half_a_turn(self):
        places = (f'{{leader="{name}",separation=2,bearing=2}}' for name in ("leader", "follower2"))
        starts = [f"robots.{name}.theta_0={value}" for name, value in (("leader", -3.1), ("follower2", 3.1))]
        trajectory = run(
            "omnidirectional", "", "run.horizon=0.1", "robots.follower1.theta_0=0", *starts,
            f'robots.follower1.formation={{kind="consensus",neighbours=[{",".join(places)}]}}',
        )  # fmt: skip
        assert abs(trajectory["omega_c"][0, 1]) > 0.7


class TestVirtualStructure:
    STRUCTURE = tuple(
        f'robots.{name}.formation={{kind="virtual-structure",separation=1.5,bearing={bearing}}}'
        for name, bearing in (("leader", 0.0), ("follower1", 2.0), ("follower2", -2.0))
    )

    def test_moves_along_the_reference_with_its_orientation(self):
        trajectory, file = short(*self.STRUCTURE, "robots.leader.avoids_obstacles=false")
        for k in (0, 200, 600):
            body = file.shape.at(float(trajectory.t[k]))
            for i, robot in enumerate(file.scenario.robots.values()):
                (edge,) = robot.edges
                place = follower_position(body.x, body.y, body.theta, 0.0, edge.separation, edge.bearing)
                assert (trajectory["x_r"][k, i], trajectory["y_r"][k, i]) == pytest.approx(place, abs=1e-12)
        assert trajectory["theta_r_star"][0] == pytest.approx(file.shape.at(0.0).theta)
        assert measure(trajectory, file.scenario, ["amplification"])["amplification"] == {}

    def test_keeps_its_place_in_a_turn(self):
        circle = '{kind="circle",centre_x=0,centre_y=0,radius=6.0,period=60,direction="counter-clockwise"}'
        starts = ("robots.follower1.x_0=6", "robots.follower1.y_0=0", "robots.follower1.theta_0=1.57")
        trajectory = run(
            "undisturbed", "fcafsmc", "obstacles=[]", "run.horizon=40", f"reference={circle}", *starts,
            'robots.follower1.formation={kind="virtual-structure",separation=1.5,bearing=2.0}',
        )  # fmt: skip
        assert np.hypot(trajectory["x_e"][-1, 1], trajectory["y_e"][-1, 1]) < 0.02
