"""Trees of robots: deep chains, several robots on the reference, and what noise does to avoidance."""

import numpy as np
import pytest

from dwmr import read
from tests.dwmr.scenarios import run


@pytest.fixture
def write(tmp_path):
    """A function (robots) -> path of a scenario with these robots besides the paper's."""

    def write_file(name, robots):
        text = 'extends = "paper"\nobstacles = []\ndisturbances = []\n[run]\nhorizon = 30.0\n' + "\n".join(robots)
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
        return tmp_path / f"{name}.toml"

    return write_file


def robot(name, x, y, formation=None, **more):
    place = f'formation = {{ leader = "{formation}", separation = 1.25, bearing = 3.1 }}\n' if formation else ""
    rest = "".join(f"{k} = {v}\n" for k, v in more.items())
    return f"[robots.{name}]\nx_0 = {x}\ny_0 = {y}\ntheta_0 = 0.0\nd = 0.4\n{place}{rest}"


class TestChain:
    CHAIN = tuple(robot(f"r{k}", -4.0 - k, 3.0, "follower1" if k == 1 else f"r{k - 1}") for k in range(1, 7))

    def test_of_six_robots_does_not_depend_on_their_order(self, write):
        forward, backward = (run(write("a", robots), "fcafsmc") for robots in (self.CHAIN, self.CHAIN[::-1]))
        order = [backward.robots.index(name) for name in forward.robots]
        assert np.array_equal(forward.values, backward.values[:, order])

    def test_of_six_robots_sees_its_leaders_of_the_same_instant(self, write):
        trajectory = run(write("a", self.CHAIN), "fcafsmc")
        names = list(trajectory.robots)
        for follower, leader in [("r1", "follower1"), *((f"r{k}", f"r{k - 1}") for k in range(2, 7))]:
            j, i = names.index(follower), names.index(leader)
            theta = trajectory["theta"][:, i]
            x = trajectory["x"][:, i] - 0.4 * np.cos(theta) + 1.25 * np.cos(theta + 3.1)
            assert trajectory["x_r"][:, j] == pytest.approx(x, abs=1e-12)
        assert (
            np.hypot(trajectory["x_e"][-1], trajectory["y_e"][-1])[:-1].max() < 0.05
        )  # the last one is still on its way


class TestRoots:
    def test_follow_the_same_path_at_their_delays(self, write):
        path = write("two", [robot("second", -6.0, -3.0, delay=5.0), robot("ahead", 4.0, 2.0, delay=-2.5)])
        trajectory = run(path, "fcafsmc")
        assert read(path).warnings == ()
        leader, second, ahead = (trajectory.robots.index(name) for name in ("leader", "second", "ahead"))
        x_r = trajectory["x_r"]
        assert x_r[1000:, second] == pytest.approx(x_r[:-1000, leader], abs=1e-9)
        assert x_r[:-500, ahead] == pytest.approx(x_r[500:, leader], abs=1e-9)
        assert trajectory["theta_r_star"][0, ahead] == pytest.approx(trajectory["theta_r"][500, leader], abs=1e-9)

    def test_without_a_delay_are_warned_of(self, write):
        (one,) = read(write("two", [robot("second", -6.0, -3.0)])).warnings
        assert one.message == "robots.second and robots.leader are sent to the same place of the reference"
        assert one.span.source.line_text(one.span.line) == "[robots.second]"


def test_avoidance_goes_by_measured_places():
    noise = ((), ("robots.leader.noise.x=0.2",))
    exact, noisy = (run("paper-with-limits", "smc", "run.horizon=50", *one)["obstacle"][:, 0] for one in noise)
    assert np.count_nonzero(np.diff(exact)) == 1
    assert np.count_nonzero(np.diff(noisy)) > 10
