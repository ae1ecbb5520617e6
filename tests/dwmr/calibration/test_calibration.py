"""`dwmr calibrate`: what may be fitted, what a miss costs, how the search goes, and what it leaves."""

import json
import math
import signal

import pytest

from dwmr import find, read
from dwmr.calibration import search
from dwmr.calibration.parameters import PARAMETERS, USUAL, keys, overrides, present, scenario_text
from dwmr.calibration.search import ENTRIES, UNSAFE, Outcome, Scorer, bar, cost, explore
from fuzzyctl.experiments import sweep_workers
from tests.dwmr.process import interrupted_by_a_worker_that_starts

PERFECT = dict.fromkeys(ENTRIES, 1.0)
SHORT = 'extends = "paper"\nname = "short"\n\n[run]\nhorizon = 1.0\n'
NAMES = ("constant_v", "sinusoid_v")
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
    def test_the_usual_ones_exist_and_the_paper_lies_within_all_bounds(self):
        file = read(find("paper-with-limits"))
        values = dict(zip(PARAMETERS, present(file.scenario, tuple(PARAMETERS), file.places), strict=True))
        assert set(USUAL) <= set(values)
        assert [n for n, v in values.items() if not PARAMETERS[n].low <= v <= PARAMETERS[n].high] == []

    @pytest.mark.parametrize("name", PARAMETERS)
    def test_a_value_that_is_set_is_the_value_that_is_there(self, name):
        file, value = read(find("paper")), 0.75 * PARAMETERS[name].high
        changed = read(find("paper"), overrides(file.scenario, {name: value}, file.places))
        assert present(changed.scenario, (name,), changed.places) == (value,)

    def test_an_amplitude_is_set_in_every_window_of_its_kind_and_in_no_other(self):
        file = read(find("paper"))
        assert keys(file.scenario, "constant_v", file.places) == ["disturbances.1.v", "disturbances.3.v"]


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


class TestWriting:
    def test_what_is_written_says_what_was_found_and_leaves_the_rest(self, tmp_path):
        file, path = read(find("paper")), tmp_path / "found.toml"
        values = {"constant_v": -0.125, "half_width": 0.45, "v_limit": 2.25, "load": 1.5}
        path.write_text(scenario_text(file, values, path, "two\nlines"))
        found = read(path)
        assert present(found.scenario, tuple(values), found.places) == tuple(values.values())
        back = read(
            path,
            overrides(
                file.scenario,
                dict(zip(values, present(file.scenario, tuple(values), file.places), strict=True)),
                file.places,
            ),
        )
        assert back.scenario.model_copy(update={"name": "paper"}) == file.scenario


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
        values = present(read(tmp_path / "by1/found.toml").scenario, NAMES, None)
        assert values == tuple(found["parameters"][n]["value"] for n in NAMES)

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
