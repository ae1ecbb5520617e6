"""docs/explanation/reproduction.md prints numbers: they must be those that the runs and the result files give."""

import re

import pytest

from dwmr import find, read
from tests import explanation
from tests.dwmr import test_equations
from tests.dwmr.paper import NAMES, TABLE_12, TABLE_13
from tests.dwmr.scenarios import measured as measured_run

PAGE = explanation.text("reproduction.md")
#: How far a run may be from what the page prints: SMC chatters, and its followers differ between processors.
BANDS = {"aifqsmc": 0.02, "fcafsmc": 0.02, "smc": 0.25}


def section(title):
    return re.search(rf"^## {title}\n(.*?)(?=^## |\Z)", PAGE, flags=re.M | re.S)[1]


def rows(title, columns):
    """Return the rows of a section's table that begin with a name and have a number of columns."""
    found = [line.strip("| ").split(" | ") for line in section(title).splitlines() if re.match(r"\| [a-z]", line)]
    return [cells for cells in found if len(cells) == columns and cells[-1][0].isdigit()]


def tries():
    return script("tries")


def script(name):
    explanation.script("reproduction/runs.py")  # which others import
    return explanation.script(f"reproduction/{name}.py")


def ratios_of(law, measures):
    """Return the errors of a run over those of Table 12 by robot and error; angles are not wrapped."""
    names = {**{name: name for name in NAMES}, "theta_e": "theta_e_unwrapped"}
    return {
        (robot, name): measures["rmse"][robot][names[name]] / wanted
        for robot, row in TABLE_12[law].items()
        for name, wanted in row.items()
    }


def results(name):
    return explanation.results(f"reproduction/{name}")


def test_table_12_is_what_the_runs_give(measured):
    table = rows("Table 12", 11)
    assert len(table) == 9
    for law, robot, *numbers in table:
        for name, printed, ours, ratio in zip(NAMES, numbers[::3], numbers[1::3], numbers[2::3], strict=True):
            assert float(printed) == TABLE_12[law][robot][name]
            assert measured(law)["rmse"][robot][name] == pytest.approx(float(ours), rel=BANDS[law])
            assert float(ours) / float(printed) == pytest.approx(float(ratio), abs=0.006)


def test_followers_that_know_the_wheels_velocity_of_their_leader(measured):
    table = rows("The leader's velocity", 8)
    assert len(table) == 4
    for law, robot, *numbers in table:
        found = measured(law, "formation.leader_velocity=wheels")
        assert found["rmse"]["leader"] == measured(law)["rmse"]["leader"]
        assert found["robots_hit"]
        for name, ours, ratio in zip(NAMES, numbers[::2], numbers[1::2], strict=True):
            assert found["rmse"][robot][name] == pytest.approx(float(ours), rel=BANDS[law])
            assert float(ours) / TABLE_12[law][robot][name] == pytest.approx(float(ratio), abs=0.006)


def test_switches_of_the_avoidance_are_what_the_table_says():
    switching = script("switching")
    table = [
        line for line in section("Switches of the avoidance").splitlines() if re.match(r"\| (aifqsmc|fcafsmc) ", line)
    ]
    assert len(table) == 2 * (len(switching.HYSTERESES) + 2 * (len(switching.PERIODS) - 1))
    for law in switching.LAWS:
        assert switching.row(law, 0.5, *switching.PERIODS[0]) in table


def test_the_order_of_the_leaders_is_what_the_runs_give(measured):
    printed = [TABLE_12[law]["leader"][name] for law in ("fcafsmc", "aifqsmc") for name in ("x_e", "y_e")]
    ours = [measured(law)["rmse"]["leader"][name] for law in ("fcafsmc", "aifqsmc") for name in ("x_e", "y_e")]
    assert ours[0] < ours[2]
    assert ours[1] < ours[3]
    found = re.search(
        r"The paper prints ([\d.]+) and ([\d.]+) m against AIFQSMC's ([\d.]+) and ([\d.]+) m; "
        r"here they are ([\d.]+) and ([\d.]+) m against ([\d.]+) and ([\d.]+) m",
        " ".join(PAGE.split()),
    )
    assert [float(one) for one in found.groups()] == pytest.approx([*printed, *ours], abs=0.001)


def test_what_the_ratios_measure_is_what_the_script_gives():
    shares = script("shares")
    shipped, limited = shares.shares("aifqsmc"), shares.shares("aifqsmc", "paper-with-limits")
    followers = [(robot, name) for robot in ("follower1", "follower2") for name in ("x_e", "y_e")]
    text = " ".join(section("The chosen reading").split())
    said = re.search(
        r"Under AIFQSMC (\d+) to (\d+) % .* (\d+) % or more .* ratios of (\S+) to (\S+) in x_e and y_e "
        r"are (\S+) to (\S+) with the limits",
        text,
    )
    starts = [100.0 * shipped[robot][name]["start"] for robot, name in followers]
    assert [min(starts), max(starts)] == pytest.approx([float(one) for one in said.groups()[:2]], abs=0.5)
    assert min(one["obstacles"] for one in shipped["leader"].values()) >= 0.01 * float(said[3])
    for k, found in ((4, shipped), (6, limited)):
        ratios = [found[robot][name]["ratio"] for robot, name in followers]
        assert [min(ratios), max(ratios)] == pytest.approx([float(said[k]), float(said[k + 1])], abs=0.006)


def test_table_13_is_what_the_undisturbed_run_gives():
    found = measured_run("undisturbed", "aifqsmc")["rmse"]
    table = rows("Table 13", 10)
    assert len(table) == 3
    for robot, *numbers in table:
        assert tuple(map(float, numbers[::3])) == tuple(TABLE_13["aifqsmc"][robot].values())
        assert [found[robot][name] for name in NAMES] == pytest.approx(list(map(float, numbers[1::3])), rel=0.02)


def test_the_other_ways_to_measure_are_what_the_runs_give(measured):
    table = rows("Other ways to measure", 9)
    assert len(table) == 9
    for law, robot, *numbers in table:
        body, inertial = (measured(law)[f"rmse_{frame}"][robot] for frame in ("body", "inertial"))
        angles = [body[name] for name in ("theta_e", "theta_e_star", "theta_e_unwrapped")]
        got = [body["x_e"], body["y_e"], inertial["x_e"], inertial["y_e"], *angles]
        assert got == pytest.approx(list(map(float, numbers)), rel=BANDS[law], abs=0.001), (law, robot)


def test_the_chosen_reading_and_those_beside_it_are_as_near_as_the_table_says():
    lines = section("The chosen reading").splitlines()
    table = [line.strip("| ").split(" | ") for line in lines if line.startswith("| `")]
    assert [cells[0].strip("`") for cells in table] == [
        "paper", "paper-constant-gain", "paper-ideal-loop", "paper-with-limits",
    ]  # fmt: skip
    for name, *_, near, nearly, span, order in table:
        found = {law: measured_run(name.strip("`"), law)["rmse"] for law in ("aifqsmc", "fcafsmc")}
        ratios = [
            found[law][robot][name] / wanted
            for law in found for robot, row in TABLE_12[law].items() for name, wanted in row.items()
        ]  # fmt: skip
        assert [sum(abs(one - 1.0) <= bar for one in ratios) for bar in (0.1, 0.12)] == [int(near), int(nearly)]
        assert f"{min(ratios):.2f} to {max(ratios):.2f}" == span
        before = [n for n in ("x_e", "y_e") if found["fcafsmc"]["leader"][n] < found["aifqsmc"]["leader"][n]]
        assert (", ".join(before) or "neither") == order


def test_the_draws_are_what_their_result_file_says():
    draws, summaries = script("draws"), results("draws.json")
    assert {kind: one["draws"] for kind, one in summaries.items()} == draws.DRAWS
    page = section("The chosen reading").splitlines()
    for row in (*draws.rows(summaries), *draws.shares(summaries)):
        assert row in page


@pytest.mark.parametrize(("kind", "number"), [("phases", 0), ("phases", 1), ("box", 13), ("free", 13)])
def test_a_draw_is_among_the_quantiles(kind, number, measured):
    draws, summary = script("draws"), results("draws.json")[kind]
    arguments = draws.draw(kind, draws.SEED, number)
    assert arguments == draws.draw(kind, draws.SEED, number) != draws.draw(kind, draws.SEED, number + 1)
    if kind != "phases":
        assert "rules.fcafsmc.half_width=0.3" in arguments  # that of `paper`, which is compiled
    ratios = [one for law in ("aifqsmc", "fcafsmc") for one in ratios_of(law, measured(law, *arguments)).values()]
    for bar, (least, *_, greatest) in zip((0.10, 0.12), summary["quantiles"]["18"], strict=True):
        assert least <= sum(abs(one - 1.0) <= bar for one in ratios) <= greatest


def test_counts_of_draws_are_summed_up_as_quantiles_and_shares():
    draws = script("draws")
    ratios = dict.fromkeys(script("runs").ENTRIES, 1.0)
    ratios["fcafsmc", "leader", "y_e"], ratios["smc", "leader", "theta_e"] = 1.11, 0.5
    one = draws.count(ratios)
    assert (one["27"], one["18"], one["all_18"], one["smc_worst"]) == ([25, 26], [17, 18], False, True)
    assert (one["ahead_x_e"], one["ahead_y_e"]) == (True, True)
    two = draws.count(ratios | {("smc", "follower1", "x_e"): 0.1, ("fcafsmc", "leader", "x_e"): 1.5})
    summary = draws.summary([one, one, one, two])
    assert summary["quantiles"]["27"] == [[23, 23, 25, 25, 25], [24, 24, 26, 26, 26]]
    assert summary["shares"] == {"all_18": 0.0, "smc_worst": 0.75, "ahead_x_e": 0.75, "ahead_y_e": 1.0}


def test_the_lost_turn_is_what_its_result_file_says():
    result, scenario, paper = results("lost-turn.json"), *(read(find(n)).scenario for n in ("paper-lost-turn", "paper"))
    assert script("calibrate").present("paper-lost-turn", [*result["parameters"]]) == (*result["parameters"].values(),)
    assert scenario.model_copy(update={"name": "paper", "disturbances": paper.disturbances}) == paper
    ratios = [one["ratio"] for one in result["entries"]]
    assert len(ratios) == 27
    assert min(ratios) >= 1.0 / 1.5
    assert max(ratios) <= 1.5
    assert result["angle"] > 2.6
    page = " ".join(section("The chosen reading").split())
    assert f"between {min(ratios):.2f} and {max(ratios):.2f} times" in page
    assert f"θ_e of {result['angle']:.2f} rad" in page
    for reach, share in result["keep"].items():
        assert f"{100 * share:.0f} % of {result['neighbours']} neighbours within {reach.replace('%', ' %')}" in page


@pytest.mark.parametrize("law", ["aifqsmc", "fcafsmc"])
def test_the_lost_turn_keeps_the_other_laws(law):
    ratios = ratios_of(law, measured_run("paper-lost-turn", law))
    for one in results("lost-turn.json")["entries"]:
        if one["law"] == law:
            assert ratios[one["robot"], one["error"]] == pytest.approx(one["ratio"], rel=0.02)


def test_the_fit_with_limits_is_what_the_runs_give(measured_with_limits):
    table = rows("The fit with limits", 5)
    assert len(table) == 9
    for law, robot, *printed in table:
        ratios = ratios_of(law, measured_with_limits(law))
        assert [ratios[robot, name] for name in NAMES] == pytest.approx(
            list(map(float, printed)), rel=BANDS[law], abs=0.006
        )


class TestCalibration:
    ENTRY = "aifqsmc", "leader", "x_e"

    @pytest.fixture
    def perfect(self):
        return dict.fromkeys(script("runs").ENTRIES, 1.0)

    @pytest.fixture
    def search(self, monkeypatch):
        """A search whose sets have ratios of 1 and ten times their first value."""
        calibrate = script("calibrate")

        def ratios(search, sets, laws):
            entries = [entry for entry in script("runs").ENTRIES if entry[0] in laws]
            return [dict.fromkeys(entries, 1.0 + 10.0 * abs(values[0])) for values in sets]

        monkeypatch.setattr(calibrate.Search, "_run", ratios)
        monkeypatch.setattr(calibrate, "SIZE", 20)
        return calibrate.Search("paper", ("sinusoid_v", "first_omega"), 1)

    def test_table_12_itself_costs_nothing_and_the_angle_of_smc_counts(self, perfect):
        calibrate = script("calibrate")
        assert calibrate.cost(perfect) == 0.0
        assert calibrate.cost(perfect | {self.ENTRY: 1.3}) == 0.0
        far = calibrate.cost(perfect | {self.ENTRY: 1.6})
        assert far > 0.0
        assert calibrate.cost(perfect | {("smc", "leader", "theta_e"): 1 / 1.6}) == pytest.approx(far)

    def test_the_property_needs_all_entries_and_the_angle(self, perfect):
        calibrate = script("calibrate")
        assert calibrate.keeps(perfect)
        assert not calibrate.keeps(perfect | {self.ENTRY: 1.51})
        assert not calibrate.keeps(perfect | {("smc", "leader", "theta_e"): 0.64})
        assert not calibrate.keeps({entry: one for entry, one in perfect.items() if entry[0] == "smc"})

    def test_neighbours_are_as_near_as_they_should_be(self):
        near = script("calibrate").neighbours((0.1, -2.0), 0.05, 50)
        assert len(set(near)) == 50
        assert all(0.095 <= a <= 0.105 and -2.1 <= b <= -1.9 for a, b in near)

    def test_the_search_finds_the_least_cost_and_depends_on_its_seed_alone(self, search):
        calibrate = script("calibrate")
        best = [calibrate.explore(calibrate.Search("paper", search.names, 1), 4, seed) for seed in (0, 0, 1)]
        assert best[0] == best[1] != best[2]
        assert abs(best[0][0]) < 0.05

    def test_sets_that_smc_excludes_are_not_run_under_other_laws(self, search):
        search.run([(0.1, 0.0), (0.11, 0.0), (0.2, 0.0)])
        assert [len(one) for one in search.ratios.values()] == [27, 27, 9]
        search.run([(0.2, 0.0)], whole=True)
        assert [len(one) for one in search.ratios.values()] == [27, 27, 27]


def test_the_rows_of_what_was_tried_are_those_of_its_result_file():
    found = results("tries.json")
    shown = [line for line in section("Readings for SMC").splitlines() if line.startswith("| ")][1:]
    assert shown == list(tries().rows(found))
    assert [(one["name"], one["set"]) for one in found] == [(one["name"], one["set"]) for one in tries().tries()]


@pytest.mark.parametrize(
    "name",
    [
        "as shipped", "PD gains as forces", "only the leader is disturbed", "nothing disturbs", "velocity limit 3 m/s",
        "Eq. (76) as printed", "second obstacle passed on its other side",
        "noise of 1 cm, 0.01 rad, 0.01 m/s, 0.01 rad/s on what robots see",
    ],
)  # fmt: skip
@pytest.mark.parametrize("law", ["aifqsmc", "fcafsmc"])
def test_what_was_tried_gives_what_the_result_file_says(name, law):
    (one,) = [one for one in results("tries.json") if one["name"] == name]
    got = tries().run(law, one["set"])
    for robot, errors in one["errors"][law].items():
        assert got[robot] == pytest.approx(errors, rel=0.02), robot


@pytest.mark.parametrize("name", ["as shipped", "start at π/2, Table 4"])
def test_what_was_tried_of_smcs_leader_gives_what_the_result_file_says(name):
    (one,) = [one for one in results("tries.json") if one["name"] == name]
    assert tries().run("smc", one["set"])["leader"] == pytest.approx(one["errors"]["smc"]["leader"], rel=BANDS["smc"])


class TestArgument:
    """The table of the argument for stability, in docs/explanation/the-paper.md."""

    PROVED = dict.fromkeys(("ais_reaction", "boundary_layer", "immune_channel", "one_channel"), True)

    def table(self):
        lines = (
            explanation.text("the-paper.md").split("### The argument for stability")[1].split("\n### ")[0].splitlines()
        )
        return [line.replace("\\|", "¦")[2:-2].split(" | ") for line in lines if line.startswith("| ")][1:]

    def test_it_is_what_the_script_prints(self):
        argument = script("argument")
        rows = list(argument.table(*argument.run_of(), self.PROVED))
        assert len(rows) == len(self.table())
        for row, (equations, condition, status, *cells) in zip(rows, self.table(), strict=True):
            assert (equations, condition, status) == (row.equations, row.condition.replace("|", "¦"), row.status)
            for cell, printed in zip(row.cells, cells, strict=True):
                values = [[float(x.rstrip("%")) for x in text.split(" / ") if x != "-"] for text in (cell, printed)]
                assert values[0] == pytest.approx(values[1], rel=0.02, abs=2.0 if "%" in cell else 2e-4)

    def test_every_equation_of_the_argument_is_in_it(self):
        named = set().union(*(test_equations.numbers(f"Eqs. {row[0]}") for row in self.table()))
        assert named == set(range(10, 44))

    def test_a_claim_that_is_not_proved_is_named(self):
        argument = script("argument")
        run = argument.run_of("run.horizon=1")
        rows = list(argument.table(*run, self.PROVED | {"one_channel": False}))
        assert [row.status for row in rows if "NOT" in row.status] == ["NOT PROVED: one_channel"]
