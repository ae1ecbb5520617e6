"""`dwmr new`, `dwmr check` and `dwmr show`, as a user types them."""

import json
import os
import resource

import pytest

from dwmr import find, read
from tests.dwmr.scenarios import edited_rules
from tests.shipped import rules_folder

#: The names of all shipped scenarios.
SHIPPED = sorted(path.stem for path in find("paper").parent.glob("*.toml"))


class TestNew:
    @pytest.mark.parametrize("base", ["csv-path", "omnidirectional", "paper-as-printed"])
    def test_writes_a_scenario_that_is_clean_and_says_the_same(self, dwmr, tmp_path, base):
        assert dwmr("new", "mine", "--from", base)[0] == 0
        mine, source = read(tmp_path / "mine.toml"), read(find(base))
        assert mine.scenario.name == "mine"
        assert dwmr("check", "mine.toml")[0] == 0
        skipped = {"name", "reference"}
        assert mine.scenario.model_dump(exclude=skipped) == source.scenario.model_dump(exclude=skipped)
        assert mine.shape.at(17.3) == source.shape.at(17.3)

    def test_copies_the_csv_file_under_the_new_name(self, dwmr, tmp_path):
        _, said, _ = dwmr("new", "mine", "--from", "csv-path", "-o", "hall.toml")
        assert said == "wrote hall.toml\nwrote hall.csv\n"
        assert read(tmp_path / "hall.toml").scenario.reference.file == "hall.csv"
        assert (tmp_path / "hall.csv").read_bytes() == find("csv-path").with_name("csv-path.csv").read_bytes()

    def test_writes_a_short_one_on_request(self, dwmr, tmp_path):
        dwmr("new", "mine", "--from", "five-robots", "--extends")
        assert (tmp_path / "mine.toml").read_text(encoding="utf-8").count("\n") < 15
        assert list(read(tmp_path / "mine.toml").scenario.robots) == list(read(find("five-robots")).scenario.robots)

    def test_replaces_nothing_unless_forced(self, dwmr, tmp_path):
        (tmp_path / "mine.csv").write_text("mine")
        status, _, said = dwmr("new", "mine", "--from", "csv-path")
        assert (status, "mine.csv exists" in said, "--force" in said) == (1, True, True)
        assert [p.name for p in tmp_path.iterdir()] == ["mine.csv"]
        assert dwmr("new", "mine", "--from", "csv-path", "--force")[0] == 0
        assert sorted(p.name for p in tmp_path.iterdir()) == ["mine.csv", "mine.toml"]

    @pytest.mark.parametrize("base", ["paper", pytest.param("ackermann", marks=pytest.mark.long)])
    def test_copies_the_rule_files_that_other_commands_take(self, dwmr, tmp_path, base):
        status, said, _ = dwmr("new", "--rules", "mine", "--from", base)
        assert (status, said.count("wrote mine/")) == (0, len(list((tmp_path / "mine").iterdir())))
        for path in (tmp_path / "mine").iterdir():
            assert path.read_bytes() == (rules_folder() / path.name).read_bytes()
        assert dwmr("check", base, "--rules", "mine")[0] == 0
        status, _, said = dwmr("new", "other", "--rules", "mine")
        assert (status, "smc.fz exists" in said, (tmp_path / "other.toml").exists()) == (1, True, False)
        assert "name another folder with --rules DIR, or replace it with --force" in said
        assert dwmr("new", "other", "--rules", "mine", "--force")[0] == 0
        assert (tmp_path / "other.toml").is_file()

    def test_a_full_disk_leaves_no_folder_of_rules(self, dwmr, tmp_path):
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
        try:
            status, _, said = dwmr("new", "--rules", "mine/own")
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert (status, "File too large" in said) == (1, True)
        assert list(tmp_path.iterdir()) == []

    def test_files_are_readable_by_all_whom_the_mask_allows(self, dwmr, tmp_path):
        before = os.umask(0o027)
        try:
            dwmr("new", "mine")
        finally:
            os.umask(before)
        assert (tmp_path / "mine.toml").stat().st_mode & 0o777 == 0o640

    def test_writes_all_files_or_none(self, dwmr, tmp_path):
        (tmp_path / "mine.csv").mkdir()
        status, _, said = dwmr("new", "mine", "--from", "csv-path", "--force")
        assert (status, said.splitlines()[0]) == (1, "mine.csv: error[FZ005]: this is a folder")
        assert [p.name for p in tmp_path.iterdir()] == ["mine.csv"]

    @pytest.mark.parametrize(
        ("arguments", "words"),
        [
            (["a/b"], "letters, digits"),
            (['a"'], "letters, digits"),
            (["x" * 101], "up to 100"),
            (["paper"], "name of a shipped scenario"),
            (["mine", "--from", "papr"], "did you mean 'paper'?"),
            ([], "NAME is missing"),
            (["--rules", "mine", "--extends"], "NAME is missing"),
        ],
    )
    def test_wrong_usage_is_answered(self, dwmr, tmp_path, arguments, words):
        status, _, said = dwmr("new", *arguments)
        assert status == 2
        assert words in said
        assert list(tmp_path.iterdir()) == []


class TestCheck:
    def test_finds_the_mistakes_of_all_files_at_once(self, dwmr, tmp_path):
        for name, line in (("a", "[robot]\nmass = -1.0\n"), ("b", "[run]\ndt = 2.0\n")):
            (tmp_path / f"{name}.toml").write_text(f'extends = "paper"\n{line}', encoding="utf-8")
        status, said, complaints = dwmr("check", "a.toml", "paper", "b.toml")
        assert status == 1
        assert said == "paper: 3 robots on a reference of kind eight; smc, aifqsmc, fcafsmc: no errors\n"
        assert "a.toml:3:1: error[FZ904]: robot.mass must be > 0 kg, got -1.0" in complaints
        assert "b.toml:3:1: error[FZ904]: run.dt must be <= 1 s, got 2.0" in complaints

    def test_reads_the_rule_files_of_every_law(self, dwmr, tmp_path):
        rules = tmp_path / "my-rules"
        rules.mkdir()
        text = (rules_folder() / "boundary_layer.fz").read_text(encoding="utf-8")
        (rules / "fcafsmc.fz").write_text(text, encoding="utf-8")
        assert dwmr("run", "paper", "--rules", "my-rules", "--set", "run.horizon=0.1")[0] == 0
        status, _, said = dwmr("check", "paper", "--rules", "my-rules")
        assert status == 1
        assert "fcafsmc.fz does not fit the role fcafsmc" in said

    @pytest.mark.parametrize(
        ("value", "code"),
        [
            ("rules.ais_reaction.file=tipper.fz", "FZ905"),
            ("rules.ais_reaction.k_s=0.6", "FZ402"),
            ("robots.leader.controllers.aifqsmc.k_s_v=0.9", "FZ402"),
            ("robots.follower1.formation.leader=follower1", "FZ904"),
            ("run.horizn=3", "FZ902"),
        ],
    )
    def test_answers_machines_too(self, dwmr, value, code):
        status, said, complaints = dwmr("check", "paper", "--set", value, "--format", "json")
        assert (status, complaints) == (1, "")
        assert json.loads(said)["diagnostics"][0]["code"] == code

    @pytest.mark.parametrize(
        ("key", "meant"),
        [
            ("horizon", "run.horizon"),
            ("run.horizn", "run.horizon"),
            ("robots.follower1.mas", "robots.follower1.mass"),
            ("rules.ais_reactoin.k_s", "rules.ais_reaction"),
            ("rules.ais_reaction.k_t", "rules.ais_reaction.k_s"),
            ("half_width", "rules.fcafsmc.half_width"),
        ],
    )
    def test_proposes_a_key_as_it_is_written_in_an_argument(self, dwmr, key, meant):
        status, _, said = dwmr("check", "paper", "--set", f"{key}=20")
        assert status == 1
        assert f"help: did you mean '{meant}'?" in said

    def test_proposes_a_key_of_a_file_without_its_table(self, dwmr, tmp_path):
        path = tmp_path / "mine.toml"
        path.write_text('extends = "paper"\n[run]\nhorizn = 20\n', encoding="utf-8")
        assert "help: did you mean 'horizon'?" in dwmr("check", str(path))[2]

    def test_finds_a_boundary_layer_that_is_not_positive(self, dwmr, tmp_path):
        peak = ("triangle(1e-6, 0.0050,", "triangle(-1, 0,")
        edited_rules(tmp_path, "boundary_layer.fz", peak, ("[0.005, 0.05]", "[0, 0.05]"))
        status, _, said = dwmr("check", "paper", "--rules", tmp_path)
        assert status == 1
        assert "error[FZ402]: the guarantee 'beta >= 0.005 within 1e-12' does not hold" in said

    def test_a_file_of_the_folder_with_the_name_of_a_shipped_scenario_is_named(self, dwmr, tmp_path):
        (tmp_path / "undisturbed.toml").write_text('extends = "undisturbed"\n', encoding="utf-8")
        note = "note: the shipped 'undisturbed' is read, not 'undisturbed.toml' of this folder\n"
        assert dwmr("check", "undisturbed")[2] == note
        assert "note" not in dwmr("check", "undisturbed.toml")[2]


class TestShow:
    def test_lists_the_shipped_scenarios_with_a_sentence_each(self, dwmr):
        _, said, _ = dwmr("show")
        lines = said.split("\n\n")[0].splitlines()[1:]
        assert [line.split()[0] for line in lines] == SHIPPED
        assert all(line.endswith((".", "sin(2 w t).")) and len(line) < 140 for line in lines)
        assert json.loads(dwmr("show", "--format", "json")[1])["scenarios"].keys() == set(SHIPPED)

    def test_says_what_moves_and_what_is_filtered(self, dwmr):
        settings = "alpha=1,lookahead=0.3,margin=0,velocity_error=0.4,acceleration=2,angular_acceleration=4"
        given = ("--set", "obstacles.0.velocity=[0.3,0.4]", "--set", f"safety={{{settings}}}")
        said = dwmr("show", "paper-with-limits", *given)[1]
        assert said.count("moves from there at up to 0.5 m/s") == 1
        assert "safety filter: all robots, 0 m beyond discs about points 0.3 m ahead of their axles" in said

    def test_lists_the_shipped_laws_with_their_files(self, dwmr):
        _, said, _ = dwmr("show")
        lines = said.split("Control laws\n")[1].splitlines()
        files = {line.split()[0]: line.split()[1] for line in lines}
        assert {"ackermann", "aifqsmc", "aifqsmc_without_layer", "fcafsmc", "omnidirectional", "smc"} < files.keys()
        assert files["mpc"] == "mpc.py"
        assert all((rules_folder() / file).is_file() for name, file in files.items() if name != "mpc")
        assert files["fcafsmc"] == "fcafsmc_law.fz"
        assert all(line.endswith((".", f"with {line.split()[0].partition('_without_')[2]} = 0")) for line in lines)
        assert json.loads(dwmr("show", "--format", "json")[1])["laws"] == files

    def test_draws_the_tree_of_the_formation(self, dwmr):
        _, said, _ = dwmr("show", "five-robots")
        tree = [line[:14] for line in said.split("Robots\n")[1].splitlines()[:5]]
        assert [len(line) - len(line.lstrip()) for line in tree] == [2, 4, 6, 4, 6]
        assert "5 m straight" not in said

    def test_says_how_far_the_obstacles_are_and_when(self, dwmr):
        found = json.loads(dwmr("show", "paper", "--format", "json")[1])
        nearest = [(round(o["from_path"], 2), round(o["at"], 1)) for o in found["obstacles"]]
        assert nearest == [(0.5, 50.0), (0.08, 109.0), (0.35, 172.5)]
        assert found["reference"]["speed"] == pytest.approx([0.328, 1.054], abs=1e-3)
        assert found["rules"]["ais_reaction"]["bounds"] == [-1.0, 0.18]
        assert found["rules"]["ais_reaction"]["g_ais_min"] == pytest.approx(0.001)

    def test_finds_the_nearest_place_of_the_path_between_its_samples(self, dwmr):
        circle = 'reference={kind="circle",centre_x=0,centre_y=0,radius=5,period=60,direction="clockwise"}'
        found = json.loads(dwmr("show", "paper", "--set", circle, "--format", "json")[1])
        assert found["obstacles"][1]["from_path"] == pytest.approx((8.0**2 + 4.25**2) ** 0.5 - 5.0, abs=1e-9)
        assert found["reference"]["length"] == pytest.approx(10.0 * 3.14159265, rel=1e-6)
        assert found["reference"]["turn_rate"] == pytest.approx([-0.10472] * 2, abs=1e-5)

    def test_orders_disturbances_by_time_and_shows_own_gains_of_a_robot(self, dwmr):
        _, said, _ = dwmr(
            "show", "paper", "--set", "robots.leader.controllers.smc.g_v=0.7", "--set", "robot.noise.x=0.01"
        )
        starts = [float(line.split()[0]) for line in said.split("Disturbances\n")[1].splitlines()[:5]]
        assert starts == [3.0, 40.0, 50.0, 100.0, 150.0]
        assert "leader: g_v 0.7" in said
        assert "measures with noise x 0.01" in said

    def test_says_what_moves_the_robots_and_what_they_know_themselves_by(self, dwmr):
        coarse = ("--set", "robot.sensors.pose=odometry", "--set", "robots.leader.sensors.encoder_steps=2000")
        _, said, _ = dwmr("show", "experiment", *coarse)
        assert "under aifqsmc; robots are rigid bodies in MuJoCo\n" in said
        assert said.count("knows its posture by odometry") == 3
        assert said.count("encoders of 2000 steps") == 1
        assert "MuJoCo" not in dwmr("show", "paper")[1]

    def test_takes_options_for_a_scenario_only(self, dwmr):
        assert dwmr("show", "--set", "run.horizon=3")[0] == 2
        changed = ("--set", "formation.leader_velocity=wheels", "--set", "disturbances=[]")
        assert "followers know the velocity of their leader's wheels" in dwmr("show", "paper", *changed)[1]

    def test_says_where_an_open_path_goes_on_straight(self, dwmr):
        way = 'reference={kind="waypoints",points=[[0,0],[9,1],[12,8]],duration=60}'
        assert "straight on from 60 s" in dwmr("show", "paper", "--set", way)[1]
        assert "straight on" not in dwmr("show", "paper", "--set", way, "--set", "run.horizon=30")[1]
