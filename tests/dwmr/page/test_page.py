"""The page of `dwmr report`: what it holds, and what its script draws."""

import base64
import hashlib
import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from dwmr import find
from tests.dwmr.process import here, in_short
from tests.dwmr.scenarios import in_frame

SHORT = ("--set", "run.horizon=2")
EVIL = "<script>alert(1)</script>"


def written(folder, laws, *overrides, scenario="paper"):
    """Return the page that `dwmr report` writes."""
    options = [word for one in overrides for word in ("--set", one)]
    here("report", scenario, "--controller", laws, *options, "-o", folder / "page.html")
    return (folder / "page.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """A page about five seconds under two laws."""
    return written(tmp_path_factory.mktemp("short"), "aifqsmc,smc", "run.horizon=5")


@pytest.fixture
def alone(recorded, run_paper, tmp_path):
    """A page about five seconds under one law."""
    recorded(run_paper("smc", "run.horizon=5")[1])
    return written(tmp_path, "smc", "run.horizon=5")


class Elements(HTMLParser):
    """Collects the elements of a page: name, attributes, text."""

    def __init__(self, text):
        super().__init__()
        self.found, self.styles, self._inside = [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))
        self._inside = tag

    def handle_endtag(self, tag):
        self._inside = ""

    def handle_data(self, data):
        if self._inside == "style":
            self.styles.append(data)


def data(text):
    """Return the plots as the script takes them."""
    return json.loads(re.search(r'id="facts">(.*?)</script>', text, flags=re.DOTALL)[1])["plots"]


def panels(text, title):
    """Return the panels of one plot and the names of its series."""
    (plot,) = [one for one in data(text) if one["title"] == title]
    return plot["panels"], [one["name"] for one in plot["series"]]


def line(text, title, label, law, robot, *, wide=False):
    """Return the points of one line, of a page about several laws."""
    found, names = panels(text, title)
    (panel,) = [one for one in found if (one["label"], one["title"]) == (label, robot)]
    lines = [one for one in panel["lines"] if "body" not in one]
    (points,) = [one for one in lines if names[one["series"]] == law and one["wide"] == wide]
    return numbers(points["x"]), numbers(points["y"])


def untimed(text):
    """Return a page without the computing times of its runs."""
    head, table, rest = text.partition("<caption>Effort")
    body, end, rest = rest.partition("</table>")
    return head + table + re.sub(r"<td[^>]*>[0-9.]+</td></tr>", "", body) + end + rest


def numbers(text):
    return np.frombuffer(base64.b64decode(text), dtype="<f4")


class TestPage:
    def test_loads_nothing_from_anywhere(self, short):
        elements = Elements(short)
        for tag, attributes in elements.found:
            assert tag not in ("link", "img", "iframe", "object", "embed", "base", "form")
            assert "src" not in attributes
            assert attributes.get("href", "#").startswith("#")
        assert not re.search(r"url\(|@import", " ".join(elements.styles))
        policy = next(a["content"] for t, a in elements.found if a.get("http-equiv") == "Content-Security-Policy")
        assert policy.startswith("default-src 'none';")
        assert "http" not in policy

    def test_runs_its_own_script_only(self, short):
        scripts = re.findall(r"<script>(.*?)</script>", short, flags=re.DOTALL)
        assert len(scripts) == 1
        digest = base64.b64encode(hashlib.sha256(scripts[0].encode()).digest()).decode()
        assert f"script-src 'sha256-{digest}';" in short
        assert "unsafe" not in short.split("</head>")[0]

    def test_every_link_leads_to_a_section(self, short):
        elements = Elements(short).found
        places = {a["id"] for _, a in elements if "id" in a}
        links = [a["href"].removeprefix("#") for t, a in elements if t == "a" and "href" in a]
        assert {"results", "plots-of-runs", "settings", "origin"} == set(links) <= places

    def test_holds_tables_that_a_screen_reader_can_read(self, short):
        elements = Elements(short).found
        count = [tag for tag, _ in elements]
        assert count.count("caption") == count.count("table") > 8
        assert all(a.get("scope") in ("row", "col") for t, a in elements if t == "th")
        assert dict(elements)["html"] == {"lang": "en"}

    def test_is_the_same_twice(self, short, recorded, run_paper, tmp_path):
        recorded(*(run_paper(law, "run.horizon=5")[1] for law in ("aifqsmc", "smc")))
        again = written(tmp_path, "aifqsmc,smc", "run.horizon=5")
        assert untimed(again) == untimed(short)

    def test_is_small_enough_for_the_whole_paper(self, recorded, run_paper, tmp_path):
        recorded(*(run_paper(law)[1] for law in ("aifqsmc", "fcafsmc", "smc")))
        text = written(tmp_path, "all")
        assert len(text.encode()) < 1.2e6
        assert "beside Table 12 of the paper" in text
        assert '<td class="n">0.5399</td>' in text
        assert [plot["bars"] for plot in data(text)[:2]] == [[], [[40.0, 160.0]]]  # the load
        one = written(tmp_path, "smc")
        points = []
        for page in (text, one):
            shown = [panel for plot in data(page) if not plot["map"] for panel in plot["panels"]]
            points.append([len(numbers(line["x"])) for panel in shown for line in panel["lines"]])
        assert max(points[0]) < max(points[1])  # many laws share the points
        assert sum(points[0]) < 75_000

    def test_names_files_settings_and_versions(self, short):
        assert re.search(r'<th scope="row">scenario</th><td>paper.toml</td><td>[0-9a-f]{64}</td>', short)
        assert "<code>run.horizon=5</code>" in short
        row = '<th scope="row">robots.leader.mass</th><td>120.0</td><td>kg</td><td>mass</td>'
        assert row in short
        assert f'<th scope="row">numpy</th><td>{np.__version__}</td>' in short

    def test_text_from_outside_is_harmless(self, tmp_path):
        text = find("paper").read_text(encoding="utf-8").replace("[robots.leader]", f'[robots."{EVIL}"]')
        text = text.replace('leader = "leader"', f'leader = "{EVIL}"').replace('name = "paper"', f'name = "{EVIL}"')
        (tmp_path / "evil.toml").write_text(text, encoding="utf-8")
        shown = written(tmp_path, "smc", "run.horizon=1", f'name="{EVIL}"', scenario=tmp_path / "evil.toml")
        assert EVIL not in shown
        assert "&lt;script&gt;alert(1)" in shown
        assert EVIL in panels(shown, "Paths")[1]
        usual = Elements(written(tmp_path, "smc", "run.horizon=1")).found
        assert [tag for tag, _ in Elements(shown).found].count("script") == [tag for tag, _ in usual].count("script")


class TestPlots:
    def test_laws_lie_over_each_other_in_a_panel_for_each_robot(self, short):
        found, names = panels(short, "Tracking errors")
        assert names == ["aifqsmc", "smc"]
        assert [one["title"] for one in found] == ["leader", "follower1", "follower2"] * 3
        assert all([one["series"] for one in panel["lines"]] == [0, 1] for panel in found)

    def test_of_one_law_the_lines_are_robots(self, alone):
        found, names = panels(alone, "Tracking errors")
        assert names == ["leader", "follower1", "follower2"]
        assert [len(panel["lines"]) for panel in found] == [3, 3, 3]

    def test_signals_that_only_one_law_has_have_its_line_only(self, short):
        found, names = panels(short, "Sliding variables and gains")
        gains = [panel for panel in found if panel["label"] == "k_h_v [m/s]"]
        assert [[names[one["series"]] for one in panel["lines"]] for panel in gains] == [["aifqsmc"]] * 3

    def test_panels_of_signals_of_laws_say_what_these_are(self, short):
        found, _ = panels(short, "Sliding variables and gains")
        about = {panel["label"]: panel["about"] for panel in found}
        assert about["k_h_v [m/s]"] == "adaptive gain k̂_h, v channel"
        assert all(about.values())

    def test_paths_have_x_to_the_right_and_y_upwards(self, short, run_paper):
        trajectory = run_paper("aifqsmc", "run.horizon=5")[1]
        x, y = line(short, "Paths", "y [m]", "aifqsmc", "follower1")
        assert (x[0], y[0]) == (-3.5, 3.0)
        assert (x[-1], y[-1]) == pytest.approx((trajectory["x"][-1, 1], trajectory["y"][-1, 1]))

    def test_paths_have_the_bodies_of_robots_along_them(self, short, run_paper):
        file, trajectory = run_paper("aifqsmc", "run.horizon=5")
        (first, *_), names = panels(short, "Paths")
        (outline,) = [one for one in first["lines"] if one.get("body") and names[one["series"]] == "aifqsmc"]
        x, y = (np.frombuffer(base64.b64decode(outline[axis]), "<f4") for axis in "xy")
        assert np.isnan(x).sum() > 5
        robot, last = file.scenario.robots["leader"], np.stack([x, y], axis=1)[-7:-1]
        places = in_frame(last, robot, *(trajectory[name][-1, 0] for name in ("x", "y", "theta")))
        assert places[0] == pytest.approx(places[-1])
        assert places[3] == pytest.approx((robot.body.front, 0.0), abs=1e-5)
        assert places.min(axis=0) == pytest.approx((-robot.body.rear, -0.5 * robot.body.width), abs=1e-5)

    def test_the_axes_of_paths_hold_the_circles_around_obstacles(self, short):
        for panel in panels(short, "Paths")[0]:
            assert len(panel["circles"]) == 6
            for x, y, radius, _ in panel["circles"]:
                for (low, high), centre in ((panel["x"], x), (panel["y"], y)):
                    assert low < centre - radius < centre + radius < high

    def test_no_two_lines_look_the_same(self, short, alone):
        for text in (short, alone):
            found = data(text)
            for plot in found:
                looks = [(one["colour"], one["dash"]) for one in plot["series"]]
                assert len(set(looks)) == len(looks) >= 2

    @pytest.mark.parametrize(
        ("plot", "label", "robot", "wide", "signal"),
        [
            ("Velocities", "v [m/s]", "leader", False, "v"),
            ("Velocities", "ω [rad/s]", "leader", True, "omega_c"),
            ("Sliding variables and gains", "sigma_v [m]", "follower1", False, "sigma_v"),
            ("Sliding variables and gains", "k_h_v [m/s]", "leader", False, "k_h_v"),
        ],
    )
    def test_signals_stand_on_their_axes(self, short, run_paper, plot, label, robot, wide, signal):
        trajectory = run_paper("aifqsmc", "run.horizon=5")[1]
        column = trajectory.robots.index(robot)
        t, values = line(short, plot, label, "aifqsmc", robot, wide=wide)
        index = np.searchsorted(trajectory.t, t - 1e-4)
        assert values == pytest.approx(trajectory[signal][index, column], rel=1e-5, abs=1e-6)
        assert values.max() == pytest.approx(trajectory[signal][:, column].max(), rel=1e-5)
        assert values.min() == pytest.approx(trajectory[signal][:, column].min(), rel=1e-5)

    def test_chattering_shows_its_peaks(self, short, run_paper):
        file, trajectory = run_paper("smc", "run.horizon=5")
        level = np.abs(np.diff(trajectory["omega_c"][:, 2])) / file.scenario.run.dt
        _, values = line(short, "Chattering", "|dω_c/dt| [rad/s²]", "smc", "follower2")
        assert values.max() == pytest.approx(level.max(), rel=1e-5)
        assert values.min() >= 1e-3 * (1.0 - 1e-6)

    @pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
    def test_the_script_draws_every_line_within_its_panel(self, short, tmp_path):
        (tmp_path / "page.html").write_text(short, encoding="utf-8")
        done = subprocess.run(
            ["node", str(Path(__file__).with_name("draw.js")), str(tmp_path / "page.html")],
            capture_output=True, text=True, timeout=60, check=True,
        )  # fmt: skip
        drawn = json.loads(done.stdout)
        found = data(short)
        assert drawn == [sum(len(panel["lines"]) for panel in plot["panels"]) for plot in found]


class TestSettings:
    @pytest.mark.parametrize(
        ("key", "value", "unit"),
        [
            ("robots.follower1.formation.separation", "1.25", "m"),
            ("obstacles[1].x", "8.0", "m"),
            ("rules.ais_reaction.k_s", "0.55", ""),
            ("robots.leader.avoids_obstacles", "yes", ""),
            ("avoidance.rho", "", "1/m"),
        ],
    )
    def test_every_number_of_the_scenario_has_its_key_and_unit(self, short, key, value, unit):
        row = re.search(rf'<th scope="row">{re.escape(key)}</th><td>(.*?)</td><td>(.*?)</td>', short)
        assert row[1] == value or not value
        assert row[2] == unit or not unit


class TestReport:
    def test_writes_one_page_and_nothing_else(self, tmp_path):
        done = in_short("report", "paper", *SHORT, "--controller", "fcafsmc", "-o", tmp_path / "a.html")
        assert done.stderr == ""
        assert re.fullmatch(rf"wrote {tmp_path / 'a.html'}: \d\.\d MB\n", done.stdout)
        assert [p.name for p in tmp_path.iterdir()] == ["a.html"]
        assert '"name":"leader"' in (tmp_path / "a.html").read_text(encoding="utf-8")

    def test_that_cannot_be_written_leaves_nothing(self, tmp_path):
        (tmp_path / "file").write_text("x", encoding="utf-8")
        done = here("report", "paper", *SHORT, "-o", tmp_path / "file" / "a.html", status=1)
        assert "cannot be written" in done.stderr
        assert [p.name for p in tmp_path.iterdir()] == ["file"]
