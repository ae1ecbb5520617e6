"""Films of `dwmr animate`: what is where in a picture, and the files."""

import shutil
import stat
import sys
import weakref

import numpy as np
import pytest
from matplotlib.patches import Circle, Polygon
from PIL import Image

from dwmr.figures import film
from tests.dwmr.process import dwmr, here
from tests.dwmr.scenarios import PAPER, in_frame

SHORT = ("--set", "run.horizon=2")


def program(folder, text):
    """Put a program that plays ffmpeg into a folder."""
    path = folder / "ffmpeg"
    path.write_text(f"#!{sys.executable}\n{text}", encoding="utf-8")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return folder


#: Ten seconds with an obstacle on the way.
MADE = ("run.horizon=10", "obstacles=[{x=3.0, y=2.0, radius=0.5}]")


def shown(axes, kind):
    """Return the patches of a kind in a panel."""
    return [one for one in axes.patches if isinstance(one, kind)]


def test_obstacles_that_move_are_where_they_are(film_of, figures_of, run_paper):
    overrides = ("run.horizon=5", "obstacles=[{x=6,y=2,radius=0.5,velocity=[0,-1]}]")
    run = run_paper("aifqsmc", *overrides)[1]
    places = [one.get_center() for one in shown(film_of(run, 1.0, *overrides), Circle) if one.get_radius() == 0.5]
    assert places == [pytest.approx((6.0, 1.0))]
    (axes,) = figures_of("run", "paper", sets=overrides)["path.png"].axes
    places = [one.get_center() for one in shown(axes, Circle) if one.get_radius() == 0.5]
    assert any(place == pytest.approx((6.0, -3.0)) for place in places)  # at the end


class TestMoments:
    @pytest.mark.parametrize(("speed", "fps", "count"), [(10, 20, 11), (15, 5, 3), (1000, 1, 2)])
    def test_are_as_far_apart_as_speed_and_rate_say_and_end_with_the_run(
        self, recorded, run_paper, tmp_path, speed, fps, count
    ):
        recorded(run_paper("smc", "run.horizon=5")[1])
        options = ("--controller", "smc", "--set", "run.horizon=5", "--speed", speed, "--fps", fps)
        done = here("animate", "paper", *options, "-o", tmp_path / "a.gif")
        assert f": {count} pictures, " in done.stdout


class TestBody:
    def outline(self, film_of, run_paper, scenario):
        file, run = run_paper("smc", "run.horizon=5")
        bodies = shown(film_of(run, 5.0, "run.horizon=5", scenario=scenario), Polygon)
        robot = file.scenario.robots["follower1"]
        return in_frame(bodies[1].get_xy()[:5], robot, *(run[name][-1, 1] for name in ("x", "y", "theta"))), robot

    def test_is_the_body_with_its_front_cut_to_a_nose(self, film_of, run_paper):
        places, _ = self.outline(film_of, run_paper, "paper")
        assert places.min(axis=0) == pytest.approx((-0.542, -0.34))
        assert places.max(axis=0) == pytest.approx((0.369, 0.34))
        assert places[3] == pytest.approx((0.369, 0.0), abs=1e-9)

    def test_without_a_body_points_where_the_robot_does_and_stays_in_its_circle(self, film_of, run_paper, tmp_path):
        before, head, after = PAPER.read_text(encoding="utf-8").partition("[robot.body]")
        assert head
        (tmp_path / "bare.toml").write_text(before + after[after.index("\n[") :], encoding="utf-8")
        places, robot = self.outline(film_of, run_paper, tmp_path / "bare.toml")
        assert np.hypot(*places.T).max() == pytest.approx(robot.radius)
        assert places[3] == pytest.approx((robot.radius, 0.0), abs=1e-9)


class TestFilm:
    def test_robots_references_and_radii_are_where_they_were(self, film_of, run_paper):
        trajectory = run_paper("aifqsmc", *MADE)[1]
        k = int(np.flatnonzero(trajectory["obstacle"][:, 0] >= 0)[10])
        axes = film_of(trajectory, trajectory.t[k], *MADE)
        ends = [(one.get_xdata()[-1], one.get_ydata()[-1]) for one in axes.lines if len(one.get_xdata())]
        starts = [(one.get_xdata()[0], one.get_ydata()[0]) for one in axes.lines if len(one.get_xdata())]
        assert (trajectory["x"][k, 1], trajectory["y"][k, 1]) in ends
        assert (-3.5, 3.0) in starts
        crosses = [(*one.get_xdata(), *one.get_ydata()) for one in axes.lines if one.get_marker() == "x"]
        assert crosses[1] == (trajectory["x_r"][k, 1], trajectory["y_r"][k, 1])
        (circle,) = [one for one in shown(axes, Circle) if not one.get_fill()]
        assert circle.get_radius() == pytest.approx(trajectory["avoidance_radius"][k, 0])
        assert circle.get_linewidth() == 2.0
        assert f"t = {trajectory.t[k]:6.1f} s" in [text.get_text() for text in axes.texts]

    def test_labels_of_axes_lie_within_a_narrow_picture(self, film_of, run_paper):
        axes = film_of(run_paper("smc", "run.horizon=10")[1], 1.0, "run.horizon=10")
        axes.figure.draw_without_rendering()
        across, up = (axis.label.get_window_extent() for axis in (axes.xaxis, axes.yaxis))
        assert axes.figure.get_figwidth() < 6.5
        assert min(up.x0, across.y0) > 0.0

    @pytest.mark.parametrize(("t", "words"), [(0.5, ""), (5.0, "disturbance: sinusoid")])
    def test_says_what_disturbs(self, film_of, run_paper, t, words):
        axes = film_of(run_paper("aifqsmc", *MADE)[1], t, *MADE)
        assert words in [text.get_text() for text in axes.texts]

    def test_pictures_move_and_what_stays_stays(self, recorded, run_paper, tmp_path):
        recorded(run_paper("smc", "run.horizon=10")[1])
        options = ("--controller", "smc", "--set", "run.horizon=10", "--speed", 1000, "--fps", 1)
        here("animate", "paper", *options, "-o", tmp_path / "a.gif")
        with Image.open(tmp_path / "a.gif") as gif:
            assert all(side % 2 == 0 for side in gif.size)
            first = np.asarray(gif.convert("RGB"))
            gif.seek(1)
            last = np.asarray(gif.convert("RGB"))
        share = np.mean((first != last).any(axis=2))
        assert 0.0005 < share < 0.2


class TestGif:
    def test_a_picture_like_the_one_before_takes_its_time(self, tmp_path):
        film.write_gif(tmp_path / "a.gif", [np.full((20, 30, 3), 9, dtype=np.uint8)] * 5, 10, [])
        with Image.open(tmp_path / "a.gif") as gif:
            assert gif.n_frames == 5
            gif.seek(4)
            assert gif.info["duration"] == 100
            assert gif.convert("RGB").getcolors() == [(600, (9, 9, 9))]

    def test_shows_every_picture_as_it_was(self, tmp_path):
        pictures = [np.full((20, 30, 3), 200, dtype=np.uint8) for _ in range(5)]
        for k, picture in enumerate(pictures):
            picture[2 * k : 2 * k + 3, 5 * k : 5 * k + 4] = (0, 114, 178)
        film.write_gif(tmp_path / "a.gif", pictures, 10, ["#0072b2"])
        with Image.open(tmp_path / "a.gif") as gif:
            for k, picture in enumerate(pictures):
                gif.seek(k)
                assert np.array_equal(np.asarray(gif.convert("RGB")), picture)

    def test_what_stays_takes_few_bytes(self, tmp_path):
        first = np.random.default_rng(0).integers(0, 2, (80, 80, 1), dtype=np.uint8) * np.full(3, 200, dtype=np.uint8)
        pictures = [first.copy() for _ in range(10)]
        for k, picture in enumerate(pictures):
            picture[0, 0] = picture[-1, -1] = 200 * (k % 2)
        for name, count in (("one", 1), ("ten", 10)):
            film.write_gif(tmp_path / name, pictures[:count], 10, ["#000000"])
        assert (tmp_path / "ten").stat().st_size < 2 * (tmp_path / "one").stat().st_size
        with Image.open(tmp_path / "ten") as gif:
            for k, picture in enumerate(pictures):
                gif.seek(k)
                assert (np.asarray(gif.convert("RGB")) == picture).all()

    def test_holds_no_more_than_two_pictures_at_a_time(self, tmp_path):
        made = []

        def pictures():
            for k in range(20):
                picture = np.full((20, 30, 3), 4 * k, dtype=np.uint8)
                made.append(weakref.ref(picture))
                yield picture
                assert sum(one() is not None for one in made) <= 2

        film.write_gif(tmp_path / "a.gif", pictures(), 10, [])

    def test_has_all_pictures_and_keeps_its_time(self, tmp_path):
        pictures = [np.full((20, 30, 3), 4 * k, dtype=np.uint8) for k in range(61)]
        film.write_gif(tmp_path / "a.gif", pictures, 30, [f"#{3 * f'{4 * k:02x}'}" for k in range(61)])
        with Image.open(tmp_path / "a.gif") as gif:
            assert (gif.size, gif.n_frames) == ((30, 20), 61)
            delays = []
            for k in range(61):
                gif.seek(k)
                delays.append(gif.info["duration"])
        assert sum(delays) == 2030  # 61 pictures at 30 a second, to the hundredth of a second
        assert set(delays) == {30, 40}

    def test_colours_that_come_later_are_kept(self, tmp_path):
        white, yellow = (np.full((8, 8, 3), c, dtype=np.uint8) for c in ((255, 255, 255), (240, 228, 66)))
        film.write_gif(tmp_path / "a.gif", [white, yellow], 10, ["#f0e442"])
        with Image.open(tmp_path / "a.gif") as gif:
            gif.seek(1)
            assert gif.convert("RGB").getpixel((3, 3)) == (240, 228, 66)


class TestMp4:
    def test_sends_every_picture_to_ffmpeg(self, tmp_path, monkeypatch):
        program(tmp_path, "import sys\nopen(sys.argv[-1], 'wb').write(sys.stdin.buffer.read())\n")
        monkeypatch.setenv("PATH", str(tmp_path))
        pictures = [np.full((4, 6, 3), k, dtype=np.uint8) for k in range(5)]
        film.write_mp4(tmp_path / "a.mp4", pictures, 20, (6, 4))
        assert (tmp_path / "a.mp4").read_bytes() == b"".join(p.tobytes() for p in pictures)

    def test_says_why_ffmpeg_fails(self, tmp_path, monkeypatch):
        program(tmp_path, "import sys\nprint('hm', 'Unknown encoder', sep='\\n', file=sys.stderr)\nsys.exit(3)\n")
        monkeypatch.setenv("PATH", str(tmp_path))
        pictures = (np.zeros((400, 600, 3), dtype=np.uint8) for _ in range(20))
        with pytest.raises(film.FilmError, match=r"^Unknown encoder$"):
            film.write_mp4(tmp_path / "a.mp4", pictures, 20, (600, 400))

    @pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="the program ffmpeg is not installed")
    def test_is_a_film(self, tmp_path):
        dwmr("animate", "paper", *SHORT, "-o", tmp_path / "run.mp4")
        content = (tmp_path / "run.mp4").read_bytes()
        assert content[4:8] == b"ftyp"


class TestAnimate:
    def test_writes_a_gif_and_nothing_else(self, tmp_path):
        done = here(
            "animate", "paper", *SHORT, "--controller", "smc", "--speed", 2, "--fps", 10, "-o", tmp_path / "a.gif"
        )
        assert done.stderr == ""
        assert done.stdout == f"wrote {tmp_path / 'a.gif'}: 11 pictures, 1.1 s\n"
        with Image.open(tmp_path / "a.gif") as gif:
            assert gif.n_frames == 11
            assert gif.info["duration"] == 100
        assert [p.name for p in tmp_path.iterdir()] == ["a.gif"]

    @pytest.mark.parametrize(
        ("arguments", "status", "words"),
        [
            (["paper", "-o", "{}/run.avi"], 2, "a film is a .gif or an .mp4"),
            (["paper", "-o", "{}/run.mp4"], 1, "write a GIF instead: -o "),
            (["paper", "--speed", "0"], 2, "0.0 is not in the range"),
            (["paper", "--speed", "nan"], 2, "nan is not a number"),
            (["paper", "--fps", "61"], 2, "61 is not in the range"),
            (["paper", "--fps", "60"], 2, "at most 50 pictures"),
            (["paper", "--controller", "all"], 2, "a film shows one control law"),
            (["paper", "--speed", "0.01"], 1, "400,000 pictures, more than 20,000"),
            (["paper", "--at", "3"], 2, "write one moment of it to a .png"),
            (["paper", *SHORT, "--at", "3", "-o", "{}/a.png"], 2, "the run ends at 2 s"),
            (["paper", "--view", "scene"], 2, "--view scene: a scene shows rigid bodies"),
            (["paper", "--follow", "leader"], 2, "--follow leader: a scene shows rigid bodies"),
            (["paper", "--follow", "leda"], 2, "has the robots leader, follower1, follower2"),
            (["paper", "--follow", "leader", "--view", "above"], 2, "leave out --view above"),
            (["paper", *SHORT, "-o", "{}/file/run.gif"], 1, "cannot be written"),
        ],
    )
    def test_refuses_mistakes_and_leaves_nothing(self, tmp_path, arguments, status, words):
        (tmp_path / "file").write_text("x", encoding="utf-8")
        done = here("animate", *(a.format(tmp_path) for a in arguments), PATH=str(tmp_path), status=status)
        assert words in done.stderr
        assert [p.name for p in tmp_path.iterdir()] == ["file"]

    def test_a_failing_ffmpeg_is_a_message(self, tmp_path):
        (tmp_path / "bin").mkdir()
        program(tmp_path / "bin", "import sys\nprint('no room', file=sys.stderr)\nsys.exit(1)\n")
        done = here(
            "animate", "paper", *SHORT, "-o", tmp_path / "out" / "run.mp4", PATH=str(tmp_path / "bin"), status=1
        )
        assert "run.mp4: no room" in done.stderr
        assert not (tmp_path / "out").exists()

    def test_one_moment_is_a_picture(self, tmp_path):
        done = here("animate", "paper", *SHORT, "--at", 1.5, "-o", tmp_path / "a.png")
        assert done.stdout == f"wrote {tmp_path / 'a.png'}: t = 1.5 s\n"
        with Image.open(tmp_path / "a.png") as picture:
            assert (picture.format, max(picture.size)) == ("PNG", 720)
