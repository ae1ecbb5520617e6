"""`dwmr calibrate`: what may be fitted, what a miss costs, how the search goes, and what it leaves."""

import json
import math
import signal

import pytest

from dwmr import find, read
from dwmr.calibration import search
from dwmr.calibration.search import ENTRIES, UNSAFE, Found, Outcome, Scorer, bar, cost, explore
from fuzzyctl.experiments import sweep_workers
from tests.dwmr.process import interrupted_by_a_worker_that_starts

PERFECT = dict.fromkeys(ENTRIES, 1.0)
SHORT = 'extends = "paper"\nname = "short"\n\n[run]\nhorizon = 1.0\n'
NAMES = ("constant_v", "sinusoid_v")
#: All that can be fitted, with a key of the paper's scenario that has the value.
KEYS = {
    "sinusoid_v": "disturbances.0.v", "sinusoid_omega": "disturbances.0.omega",
    "constant_v": "disturbances.1.v", "constant_omega": "disturbances.1.omega",
    "half_width": "rules.fcafsmc.half_width", "frequency": "disturbances.0.angular_frequency",
    "force": "disturbances.0.force", "torque": "disturbances.0.torque",
    "v_limit": "robots.leader.actuator.v_limit", "omega_limit": "robots.leader.actuator.omega_limit",
    "load": "load.mass_factor", "friction": "robots.leader.friction.coulomb_force",
}  # fmt: skip
ALL = ",".join(KEYS)


def value_of(scenario, key):
    """Return the value that a scenario has for a key."""
    node = scenario
    for part in key.split("."):
        if isinstance(node, tuple):
            node = node[int(part)]
        else:
            node = node[part] if isinstance(node, dict) else getattr(node, part)
        node = {**node.params} if hasattr(node, "params") else node
    return node


@pytest.fixture
def fitted(dwmr, monkeypatch):
    """A function that lets `dwmr calibrate` find some values at once, and returns those that it began with."""

    def calibrate(scenario, values, *options):
        begun, outcome = [], Outcome(0.0, (1.0,) * len(ENTRIES))

        def found_at_once(file, start, *others):
            begun.append(start)
            return Found(values or dict(start), outcome, start, outcome, (), 1, False)

        monkeypatch.setattr(search, "search", found_at_once)
        names = ",".join(values) if values else ALL
        status, out, err = dwmr("calibrate", scenario, "--parameters", names, "--force", *options)
        assert status == 0, err
        return begun[0], out

    return calibrate


START = {"constant_v": 0.2, "sinusoid_v": 0.2}


class TestCost:
    def test_table_12_itself_costs_nothing(self):
        assert cost(PERFECT) == 0.0

    @pytest.mark.parametrize("ratio", [1.2, 1.0 / 1.2])
    def test_a_miss_at_its_bar_costs_one_whichever_way(self, ratio):
        assert cost(PERFECT | {("aifqsmc", "leader", "x_e"): ratio}) == pytest.approx(1.0)

    def test_a_miss_beyond_its_bar_costs_more_than_its_square(self):
        entry = ("fcafsmc", "follower2", "theta_e")
        assert cost(PERFECT | {entry: math.exp(2.0 * bar(entry))}) == pytest.approx(4.0 + 3.0)

    def test_followers_of_the_failing_law_count_a_tenth_and_no_more_than_so_much(self):
        entry = ("smc", "follower1", "y_e")
        assert cost(PERFECT | {entry: 1.3}) == pytest.approx(0.1)
        assert cost(PERFECT | {entry: 1000.0}) == pytest.approx(1.6)

    def test_the_angle_of_the_failing_leader_does_not_count(self):
        assert cost(PERFECT | {("smc", "leader", "theta_e"): 0.08}) == 0.0
        assert cost(PERFECT | {("smc", "leader", "x_e"): 1.3}) == pytest.approx(0.5)

    def test_a_run_that_brings_the_leader_to_an_obstacle_is_unsafe(self, tmp_path):
        path = tmp_path / "near.toml"
        path.write_text(SHORT + "\n[[obstacles]]\nx = 0.0\ny = 1.2\nradius = 0.5\n")
        assert Scorer(path)([]).cost == UNSAFE


class TestParameters:
    def test_the_paper_lies_within_all_bounds(self, fitted):
        start, out = fitted("paper-with-limits", {})
        assert list(start) == list(KEYS)
        rows = {row[0]: row for row in map(str.split, out.splitlines()) if row and row[0] in KEYS}
        scenario = read(find("paper-with-limits")).scenario
        for name, value in start.items():
            *_, low, high, before, _ = rows[name]
            assert float(low) <= value <= float(high)
            assert float(before) == pytest.approx(value, abs=0.0005)
            assert value == value_of(scenario, KEYS[name])

    def test_the_usual_ones_are_not_printed_in_the_paper(self, dwmr, monkeypatch):
        names = []
        monkeypatch.setattr(search, "search", lambda file, start, *others: names.append(tuple(start)))
        with pytest.raises(AttributeError):  # there is no result to show
            dwmr("calibrate", "paper")
        assert names == [("sinusoid_v", "sinusoid_omega", "constant_v", "constant_omega", "frequency", "half_width")]

    def test_values_that_are_set_are_those_that_are_there_and_the_rest_is_left(self, fitted, tmp_path):
        usual, _ = fitted("paper", {})
        values = {name: round(0.75 * abs(value) + 0.125, 6) for name, value in usual.items()}
        fitted("paper", values, "-o", "found.toml")
        found = read(tmp_path / "found.toml").scenario
        for name, key in KEYS.items():
            assert value_of(found, key) == values[name], name
        assert [one.v for one in found.disturbances if one.kind == "constant"] == [values["constant_v"]] * 2
        assert [one.v for one in found.disturbances if one.kind == "sinusoid"] == [values["sinusoid_v"]] * 2
        assert fitted("found.toml", {})[0] == values
        fitted("found.toml", usual, "-o", "back.toml")
        back = read(tmp_path / "back.toml").scenario
        assert back.model_copy(update={"name": "paper"}) == read(find("paper")).scenario


def bowl(values):
    """A broad basin around (-0.1, 0.3) and a spike of less cost, too narrow for neighbours to share."""
    a, b = values
    return Outcome(10.0 * ((a + 0.1) ** 2 + (b - 0.3) ** 2) + 0.01, ())


def spiked(values):
    return Outcome(0.0, ()) if values == (0.2, 0.2) else bowl(values)


def explored(score, evaluations=300, seed=0):
    return explore(lambda sets: map(score, sets), START, evaluations, seed, lambda done: None)


class TestSearch:
    def test_finds_the_least_cost(self):
        found = explored(bowl)
        assert found.outcome.cost < 0.02 < found.start.cost
        assert found.values == pytest.approx({"constant_v": -0.1, "sinusoid_v": 0.3}, abs=0.03)

    def test_prefers_a_basin_to_a_spike(self):
        found = explored(spiked)
        assert found.start.cost == 0.0
        assert found.values != START
        assert found.outcome.cost < 0.02

    def test_depends_on_its_seed_and_on_nothing_else(self):
        assert explored(bowl) == explored(bowl)
        assert explored(bowl, seed=1) != explored(bowl, seed=2)

    def test_runs_about_as_many_sets_as_asked(self):
        assert 150 <= explored(bowl).evaluations <= 300  # equal sets are run once
        assert explored(bowl, evaluations=1).evaluations <= 12

    def test_an_interruption_keeps_the_best_so_far(self):
        done = []

        def until(values):
            if len(done) == 40:
                raise KeyboardInterrupt
            done.append(bowl(values).cost)
            return bowl(values)

        found = explored(until)
        assert found.interrupted
        assert (found.evaluations, found.outcome.cost) == (40, min(done))

    def test_an_interruption_before_anything_is_done_keeps_nothing(self):
        def never(values):
            raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            explored(never)


class TestCommand:
    @pytest.fixture(autouse=True)
    def short(self, tmp_path):
        (tmp_path / "short.toml").write_text(SHORT)

    def test_the_result_does_not_depend_on_the_number_of_processes(self, dwmr, tmp_path, monkeypatch):
        monkeypatch.setattr(search, "get_context", sweep_workers.get_context)
        said = []
        for jobs in (1, 2):
            command = ("calibrate", "short.toml", "--parameters", "constant_v,sinusoid_v", "--evaluations", 4)
            status, out, _ = dwmr(*command, "--jobs", jobs, "-o", f"by{jobs}/found.toml", "--format", "json")
            assert status == 1  # the folder is missing
            (tmp_path / f"by{jobs}").mkdir()
            status, out, _ = dwmr(*command, "--jobs", jobs, "-o", f"by{jobs}/found.toml", "--format", "json")
            assert status == 0
            said.append(out)
        assert said[0] == said[1]
        assert (tmp_path / "by1/found.toml").read_bytes() == (tmp_path / "by2/found.toml").read_bytes()
        found = json.loads(said[0])
        assert len(found["entries"]) == 27
        assert found["cost"]["value"] <= found["cost"]["before"]
        scenario = read(tmp_path / "by1/found.toml").scenario
        assert [value_of(scenario, KEYS[n]) for n in NAMES] == [found["parameters"][n]["value"] for n in NAMES]

    @pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="needs signal masks")
    @pytest.mark.long
    def test_an_interrupt_while_workers_start_is_a_single_line(self, tmp_path):
        path = tmp_path / "short.toml"
        done = interrupted_by_a_worker_that_starts(tmp_path, "calibrate", path, "--evaluations", "8", "--jobs", "2")
        assert done.stdout == ""
        assert done.stderr.splitlines()[1:] == ["interrupted"]

    def test_shows_the_ratios_and_no_progress_in_a_pipe(self, dwmr):
        status, out, err = dwmr(
            "calibrate", "short.toml", "--parameters", "half_width", "--evaluations", 3, "--jobs", 1
        )
        assert (status, err) == (0, "warning: run.horizon is not the paper's: Table 12 speaks of another run\n")
        assert "wrote calibrated.toml" in out
        assert out.count("follower2") == 9

    def test_warns_of_what_the_paper_prints_and_not_of_what_may_be_fitted(self, dwmr, tmp_path, monkeypatch):
        def interrupted(*_):
            raise KeyboardInterrupt

        monkeypatch.setattr(search, "search", interrupted)
        text = find("paper").read_text(encoding="utf-8").replace("mass = 120.0", "mass = 121.0")
        windows = text.replace("stop = 20.0", "stop = 21.0", 1).replace("d = 0.1 ", "d = 0.2 ", 1)
        for name, changed, keys in (("fitted", text, ""), ("other", windows, "disturbances, robots.leader.d are")):
            (tmp_path / f"{name}.toml").write_text(changed, encoding="utf-8")
            status, _, err = dwmr("calibrate", f"{name}.toml")
            warning = f"warning: {keys} not the paper's: Table 12 speaks of another run\n" if keys else ""
            assert (status, err) == (130, f"{warning}interrupted\n")

    @pytest.mark.parametrize(
        ("arguments", "status", "says"),
        [
            (("--parameters", "constant_w"), 2, "constant_omega"),
            (("--parameters", "force,force"), 2, "twice"),
            (("--evaluations", "0"), 2, "0 is not in the range"),
            (("-o", "short.toml"), 1, "short.toml exists"),
            (("-o", "short.toml", "--force"), 2, "the scenario itself"),
            (("-o", "missing/found.toml"), 1, "no folder missing"),
        ],
    )
    def test_mistakes_are_answered_before_the_search(self, dwmr, tmp_path, arguments, status, says):
        got, _, err = dwmr("calibrate", "short.toml", *arguments)
        assert (got, says in err) == (status, True), err
        assert [p.name for p in tmp_path.iterdir()] == ["short.toml"]

    def test_a_scenario_without_a_disturbance_to_fit_is_refused(self, dwmr):
        status, _, err = dwmr("calibrate", "undisturbed", "--parameters", "sinusoid_v")
        assert (status, "there is none of kind 'sinusoid'" in err) == (1, True)

    def test_a_scenario_without_the_robots_of_the_table_is_refused(self, dwmr, tmp_path):
        (tmp_path / "other.toml").write_text((find("paper")).read_text().replace("follower2", "third"))
        status, _, err = dwmr("calibrate", "other.toml")
        assert (status, "Table 12 has a robot 'follower2'" in err) == (1, True)
