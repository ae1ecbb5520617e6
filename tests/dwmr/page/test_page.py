import base64
import json
import re
from html import escape
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from dwmr.control import laws
from dwmr.control.fuzzy_gains import Rules
from dwmr.output.summary import describe
from dwmr.page import plots, settings
from dwmr.page.document import page
from dwmr.results import derived
from dwmr.results.metrics import measure
from dwmr.scenario.file import find, read
from dwmr.simulation import simulate
from tests.dwmr.process import here, in_short

SHORT = ("--set", "run.horizon=2")
EVIL = "<script>alert(1)</script>"


def written(file, trajectories, overrides=()):
    """Return the page about some runs."""
    rules = Rules(file.scenario.rules, (), file.places)
    summary = describe(file, rules, overrides)
    summary["controllers"] = {t.controller: measure(t, file.scenario) for t in trajectories}
    return page(summary, trajectories, file.scenario)


@pytest.fixture(scope="module")
def short(run_paper):
    """A page about five seconds under two laws."""
    runs = [run_paper(law, "run.horizon=5") for law in ("aifqsmc", "smc")]
    return written(runs[0][0], [one[1] for one in runs], ["run.horizon=5"])


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


def lines(text, name):
    """Return the lines of one plot as plotly takes them."""
    found = re.search(rf'Plotly\.newPlot\(\s*"{name}",\s*(\[.*?\]),\s*\{{', text, flags=re.DOTALL)
    return json.loads(found[1])


def traces(text, name):
    """Return the lines of one plot by their names and axes."""
    found = lines(text, name)
    return {(one["name"], one.get("yaxis", "y")): (numbers(one["x"]), numbers(one["y"])) for one in found}


def numbers(data):
    return np.frombuffer(base64.b64decode(data["bdata"]), dtype=data["dtype"])


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

    def test_offers_no_button_that_sends_a_plot_away(self, short):
        count = len(re.findall(r"Plotly\.newPlot\(\s*\"plot-", short))
        assert short.count('"showSendToCloud": false') == count > 8

    def test_every_link_leads_to_a_section(self, short):
        elements = Elements(short).found
        places = {a["id"] for _, a in elements if "id" in a}
        links = [a["href"].removeprefix("#") for t, a in elements if t == "a" and "href" in a]
        assert {"results", "law-aifqsmc", "law-smc", "settings", "origin"} <= set(links) <= places

    def test_holds_tables_that_a_screen_reader_can_read(self, short):
        elements = Elements(short).found
        count = [tag for tag, _ in elements]
        assert count.count("caption") == count.count("table") > 8
        assert all(a.get("scope") in ("row", "col") for t, a in elements if t == "th")
        assert dict(elements)["html"] == {"lang": "en"}

    def test_is_the_same_twice(self, short, run_paper):
        runs = [run_paper(law, "run.horizon=5") for law in ("aifqsmc", "smc")]
        assert written(runs[0][0], [one[1] for one in runs], ["run.horizon=5"]) == short

    def test_is_small_enough_for_the_whole_paper(self, run_paper):
        runs = [run_paper(law) for law in laws.group("all")]
        text = written(runs[0][0], [one[1] for one in runs])
        assert len(text.encode()) < 6e6
        assert "beside Table 12 of the paper" in text
        assert '<td class="n">0.5399</td>' in text

    def test_of_another_run_says_why_the_paper_is_left_out(self, run_paper):
        file, trajectory = run_paper("smc", "run.horizon=200", "robots.leader.mass=121")
        text = written(file, [trajectory])
        assert "beside Table 12 of the paper" not in text
        assert "Table 12 is left out, it speaks of another run: robots.leader.mass is not" in text

    def test_of_a_short_run_is_not_compared_with_the_paper(self, short):
        assert "0.5399" not in short

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
        file = read(tmp_path / "evil.toml", ["run.horizon=1"])
        rules = Rules(file.scenario.rules, (), file.places)
        shown = written(file, [simulate.run(simulate.prepare(file, "aifqsmc", rules))], [EVIL])
        assert EVIL not in shown
        assert "&lt;script&gt;alert(1)" in shown
        # plotly takes some markup in names: it must get none
        assert all((escape(EVIL), "y") in traces(shown, f"plot-aifqsmc-{k}") for k in (0, 1))
        usual = Elements(written(read(find("paper"), ["run.horizon=1"]), [_run("aifqsmc")])).found
        assert [tag for tag, _ in Elements(shown).found].count("script") == [tag for tag, _ in usual].count("script")


def _run(law):
    file = read(find("paper"), ["run.horizon=1"])
    return simulate.run(simulate.prepare(file, law, Rules(file.scenario.rules, (), file.places)))


class TestPlots:
    def test_paths_have_x_to_the_right_and_y_upwards(self, short, run_paper):
        trajectory = run_paper("aifqsmc", "run.horizon=5")[1]
        x, y = traces(short, "plot-aifqsmc-0")["follower1", "y"]
        assert (x[0], y[0]) == (-3.5, 3.0)
        assert (x[-1], y[-1]) == pytest.approx((trajectory["x"][-1, 1], trajectory["y"][-1, 1]))

    def test_the_axes_of_paths_hold_the_circles_around_obstacles(self, short):
        drawn = [(numbers(one["x"]), numbers(one["y"])) for one in lines(short, "plot-aifqsmc-0")]
        circles = re.findall(r'"type":"circle","x0":([^,]*),"x1":([^,]*),"y0":([^,]*),"y1":([^}]*)\}', short)
        assert len(circles) >= 6
        for circle in circles:
            ends = [float(n) for n in circle]
            for axis, end in zip((0, 0, 1, 1), ends, strict=True):
                places = np.concatenate([one[axis] for one in drawn])
                assert places.min() - 1e-6 <= end <= places.max() + 1e-6

    @pytest.mark.parametrize("plot", range(6))
    def test_no_two_lines_of_a_plot_look_the_same(self, short, plot):
        looks = [
            (one["line"]["color"], one["line"]["dash"], one["line"]["width"], one.get("yaxis", "y"))
            for one in lines(short, f"plot-aifqsmc-{plot}")
            if one["line"]["width"]
        ]
        assert len(set(looks)) == len(looks) > 3

    @pytest.mark.parametrize(
        ("plot", "name", "axis", "signal"),
        [
            (1, "follower2", "y2", "y_e"),
            (2, "leader", "y", "v"),
            (2, "leader, asked for", "y2", "omega_c"),
            (4, "follower1", "y", "sigma_v"),
            (4, "follower1", "y2", "sigma_omega"),
            (4, "leader", "y5", "k_h_v"),
        ],
    )
    def test_signals_stand_on_their_axes(self, short, run_paper, plot, name, axis, signal):
        trajectory = run_paper("aifqsmc", "run.horizon=5")[1]
        robot = trajectory.robots.index(name.split(",")[0])
        t, values = traces(short, f"plot-aifqsmc-{plot}")[name, axis]
        index = np.searchsorted(trajectory.t, t - 1e-4)
        assert values == pytest.approx(trajectory[signal][index, robot], rel=1e-5, abs=1e-6)
        assert values.max() == pytest.approx(trajectory[signal][:, robot].max(), rel=1e-5)
        assert values.min() == pytest.approx(trajectory[signal][:, robot].min(), rel=1e-5)

    def test_chattering_shows_its_peaks(self, short, run_paper):
        file, trajectory = run_paper("smc", "run.horizon=5")
        level = derived.chattering(trajectory, "omega", file.scenario.run.dt)[:, 2]
        _, values = traces(short, "plot-smc-3")["follower2", "y2"]
        assert values.max() == pytest.approx(level.max(), rel=1e-5)
        assert values.min() >= plots.LEAST_LEVEL * (1.0 - 1e-6)

    def test_many_laws_share_the_points(self, run_paper):
        one = run_paper("aifqsmc", "run.horizon=5")[1]
        assert plots.buckets([one]) > plots.buckets([one] * 6) >= 40
        assert plots.buckets([one] * 6) * 2 * 6 * 3 * (13 + len(one.law_signals)) <= plots.MOST_POINTS


class TestSettings:
    def test_every_number_of_the_scenario_has_its_key_and_unit(self):
        rows = {row.key: row for row in settings.rows(read(find("paper"), []).scenario)}
        assert rows["robots.follower1.formation.separation"][1:3] == ("1.25", "m")
        assert rows["obstacles[1].x"].value == "8.0"
        assert rows["rules.ais_reaction.k_s"].value == "0.55"
        assert rows["robots.leader.avoids_obstacles"].value == "yes"
        assert rows["avoidance.rho"].unit == "1/m"


class TestReport:
    def test_writes_one_page_and_nothing_else(self, tmp_path):
        done = in_short("report", "paper", *SHORT, "--controller", "fcafsmc", "-o", tmp_path / "a.html")
        assert done.stderr == ""
        assert re.fullmatch(rf"wrote {tmp_path / 'a.html'}: \d\.\d MB\n", done.stdout)
        assert [p.name for p in tmp_path.iterdir()] == ["a.html"]
        assert "law-fcafsmc" in (tmp_path / "a.html").read_text(encoding="utf-8")

    @pytest.mark.parametrize(
        ("arguments", "status", "words"),
        [
            (["papper"], 2, "did you mean 'paper'?"),
            (["paper", "--controller", "pid"], 2, "'pid' is not one of"),
            (["paper", "--set", "robot.mass=-1"], 1, "must be > 0 kg"),
            (["paper", *SHORT, "-o", "{}/file/a.html"], 1, "cannot be written"),
        ],
    )
    def test_refuses_mistakes_and_leaves_nothing(self, tmp_path, arguments, status, words):
        (tmp_path / "file").write_text("x", encoding="utf-8")
        done = here("report", *(a.format(tmp_path) for a in arguments), status=status)
        assert words in done.stderr
        assert [p.name for p in tmp_path.iterdir()] == ["file"]

    def test_says_how_to_get_what_it_needs(self, tmp_path, monkeypatch, dwmr):
        monkeypatch.setattr(plots, "available", lambda: False)
        status, _, err = dwmr("report", "paper", *SHORT, "-o", tmp_path / "a.html")
        assert status == 1
        assert "pip install 'fuzzyctl[html]'" in err
        assert list(tmp_path.iterdir()) == []

    def test_of_a_run_that_diverges_shows_how_far_it_went(self, tmp_path):
        wild = ("--set", "disturbances.0.start=1", "--set", "disturbances.0.force=1e300", "--set", "run.horizon=5")
        done = here("report", "paper", *wild, "-o", tmp_path / "a.html", status=1)
        assert "warning: aifqsmc stopped at t = 1.005 s" in done.stderr
        assert "aifqsmc: stopped at t = 1.005 s" in (tmp_path / "a.html").read_text(encoding="utf-8")

    def test_of_huge_numbers_says_nothing_else(self, tmp_path):
        done = here("report", "paper", "--set", "robots.leader.d=1e-300", "-o", tmp_path / "a.html", status=1)
        assert done.stderr.splitlines() == [
            "warning: aifqsmc stopped at t = 0.005 s: v_c is beyond 1e+12 m/s, "
            "omega_c is beyond 1e+12 rad/s: the run diverged"
        ]


def test_the_how_to_says_what_its_page_needs():
    text = (Path(__file__).parents[3] / "docs" / "how-to" / "show-a-run.md").read_text(encoding="utf-8")
    before, _, _ = text.partition("$ dwmr report")
    assert '.venv/bin/pip install -e ".[html]"' in before
