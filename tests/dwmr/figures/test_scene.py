"""Pictures of MuJoCo's renderer: robots, references and obstacles are where they were."""

import math

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image

from dwmr.control.fuzzy_gains import Rules
from dwmr.figures import scene
from dwmr.figures.animation import NOTE
from dwmr.figures.scene import ACTIVE, ROOM, Scene
from dwmr.figures.style import COLOURS
from dwmr.scenario.file import find, read
from dwmr.simulation import simulate
from tests.dwmr.process import here
from tests.physics import require_renderer

#: One obstacle in the way of the leader, one that moves to the left, and a force.
RUN = (
    "run.horizon=3",
    "obstacles=[{x=3.0,y=2.0,radius=0.5},{x=9.0,y=-3.0,radius=0.5,velocity=[-2.0,0.0]}]",
    'disturbances=[{kind="constant",start=2.0,stop=9.0,v=0,omega=0,force=5,torque=0}]',
)


@pytest.fixture(scope="module", autouse=True)
def rendered():
    require_renderer()


@pytest.fixture(scope="module")
def run():
    file = read(find("experiment"), RUN)
    return file.scenario, simulate.run(simulate.prepare(file, "aifqsmc", Rules(file.scenario.rules, (), file.places)))


def pictures(run, samples, follow=None):
    scenario, trajectory = run
    with Scene(scenario, follow) as made:
        return [picture.copy() for picture in made.pictures(trajectory, samples)]


def hue(picture, i):
    """Where a picture has the hue of a robot, its names at the lower border aside, shape (height, width)."""
    colour, pixels = np.array(to_rgb(COLOURS[i])), picture[:-30] / 255.0
    length = np.linalg.norm(pixels, axis=2) * np.linalg.norm(colour)
    return (pixels @ colour > 0.985 * length) & (np.ptp(pixels, axis=2) > 0.25)


def middle(mask):
    """Column and row of the middle of what a mask holds."""
    return tuple(float(one.mean()) for one in np.nonzero(mask)[::-1])


class TestWhole:
    def test_robots_are_seen_side_by_side_as_they_stand(self, run):
        first, last = pictures(run, [0, 600])
        starts, ends = ([middle(hue(picture, i)) for i in range(3)] for picture in (first, last))
        assert max(starts[1][0], starts[2][0]) < starts[0][0]  # x = -3.5, -3.0, -1.0 to the right
        assert starts[1][1] < starts[0][1] < starts[2][1]  # y = 3.0, 1.0, -1.0 upwards
        assert ends[0][0] > starts[0][0] + 5.0

    @pytest.mark.parametrize(("wide", "high"), [(10.0, 6.0), (3.0, 20.0), (30.0, 2.0)])
    def test_everything_fills_the_picture(self, run, monkeypatch, wide, high):
        monkeypatch.setattr(scene, "extent", lambda *_: ((1.0, 2.0), (1.0 + wide, 2.0 + high)))
        with Scene(run[0]) as made:
            camera = made._whole(run[1])
        down, up = math.radians(-camera.elevation), ROOM * math.tan(math.radians(20.0))
        seen = []
        for x, y in ((1.0, 2.0), (1.0 + wide, 2.0), (1.0, 2.0 + high), (1.0 + wide, 2.0 + high)):
            ahead = y - camera.lookat[1]
            depth = camera.distance + ahead * math.cos(down)
            seen.append(((x - camera.lookat[0]) / (1.5 * up * depth), ahead * math.sin(down) / (up * depth)))
        assert np.abs(seen).max() == pytest.approx(1.0, abs=0.01)
        assert np.sum(seen, axis=0) == pytest.approx(0.0, abs=0.01)

    def test_obstacles_move(self, run):
        first, last = pictures(run, [0, 600])
        at = [np.nonzero(picture[40:-30].max(axis=2) < 90)[1].max() for picture in (first, last)]
        assert at[1] < at[0] - 40

    def test_says_what_disturbs(self, run):
        before, during = pictures(run, [100, 500])
        note = [int(part, 16) for part in (NOTE[1:3], NOTE[3:5], NOTE[5:])]
        found = [(picture == note).all(axis=2).sum() for picture in (before, during)]
        assert found[0] == 0
        assert found[1] > 200

    def test_the_palette_has_the_disc_of_an_obstacle_that_is_avoided(self, run):
        (last,) = pictures(run, [600])
        assert run[1]["obstacle"][600, 0] == 0
        for colour in ACTIVE:
            assert (np.abs(last - 255.0 * np.array(to_rgb(colour))).max(axis=2) < 6).sum() > 300

    def test_scenes_one_after_the_other_show_the_same(self, run):
        (first,), (again,) = (pictures(run, [200]) for _ in range(2))
        assert np.array_equal(first, again)


class TestFollow:
    @pytest.mark.parametrize("name", ["leader", "follower2"])
    def test_the_robot_is_in_the_middle_seen_from_behind(self, run, name):
        i = list(run[0].robots).index(name)
        for picture in pictures(run, [0, 400], name):
            x, y = middle(hue(picture, i)[160:320, 260:460])
            assert (x, y) == pytest.approx((100, 80), abs=45)
            rows, columns = (picture[160:330, 300:420].min(axis=2) > 245).nonzero()  # the white nose, far and across
            assert rows.mean() < 80
            assert columns.mean() == pytest.approx(60, abs=8)
            assert np.ptp(columns) > 3 * np.ptp(rows)

    def test_bodies_stand_as_the_run_says(self, run):
        scenario, trajectory = run
        with Scene(scenario) as made:
            list(made.pictures(trajectory, [300]))
            forward = made._data.body("robot1").xmat.reshape(3, 3)[:, 0]
            heading = math.atan2(forward[1], forward[0])
        assert heading == pytest.approx(trajectory["theta"][300, 1], abs=1e-6)


def test_animate_takes_it_for_bodies(tmp_path):
    done = here("animate", "experiment", "--set", "run.horizon=1", "-o", tmp_path / "a.gif")
    assert (done.stderr, done.stdout) == ("", f"wrote {tmp_path / 'a.gif'}: 3 pictures, 0.1 s\n")
    with Image.open(tmp_path / "a.gif") as gif:
        assert (gif.size, gif.n_frames) == ((720, 480), 3)
