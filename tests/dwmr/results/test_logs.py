"""Logs of real robots: forms, each mistake at its line, warnings, and the differences of a run from them."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dwmr import Log, differences, read, read_logs
from tests.dwmr.process import here
from tests.dwmr.scenarios import ROBOTS, diagnostics, shared

POSTURE, VELOCITIES, COMMANDS = ("x", "y", "theta"), ("v", "omega"), ("v_c", "omega_c")
#: A short run that is its own log.
SHORT = ("run.horizon=0.5", "run.save_every=1")
HEAD = "t,robot,x,y,theta\n"
#: Texts of CSV files, the place of the only mistake, and words of its message.
MISTAKES = [
    ("", "", "is empty"),
    (HEAD, "", "has 0 rows; a log needs at least 2"),
    ("t,robot,x,y\n0,leader,0,0\n", ":1:1", "names no column theta"),
    ("t,robot,x,x,y,theta\n", ":1:1", "names column x twice"),
    (HEAD + "0,leader,0,0,0\n1,leader,nan,0,0\n", ":3:10", "column x: nan is not a finite number"),
    (HEAD + "0,leader,0,0,0\n1,leader,0,,0\n", ":3:12", "column y is empty"),
    (HEAD + "0,leader,0,0,0\n0,leader,1,0,0\n", ":3:1", "column t: 0 of leader comes after 0; times must increase"),
    (HEAD + "1700000000.5,leader,0,0,0\n1700000000.4,leader,1,0,0\n", ":3:1", "1700000000.4 of leader comes after"),
    (
        HEAD + "".join(f"{t},{name},0,0,0\n" for t in (0, 1, 0.5, 0.6) for name in ("leader", "follower1")),
        ":6:1",
        "0.5 of leader comes after 1",
    ),
    (HEAD + "0,leader,0,0,0\n1,leadre,0,0,0\n2,leadre,0,0,0\n", ":3:3", "column robot: unknown name 'leadre'"),
    (HEAD + "0,leader,0,0\n", ":2:1", "the row has 4 cells for 5 columns"),
    (HEAD + "0,leader,0,0,0\n0,follower1,0,0,0\n1,leader,0,0,0\n", "", "follower1 has one row"),
]


def written(folder, text):
    path = folder / "log.csv"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def paper():
    return read("paper").scenario


class TestCsv:
    @pytest.mark.parametrize(("text", "place", "words"), MISTAKES)
    def test_each_mistake_is_at_its_line(self, tmp_path, paper, text, place, words):
        (one,) = diagnostics(read_logs, written(tmp_path, text), paper, POSTURE)
        assert one.code == "FZ911"
        assert one.place.endswith(f"log.csv{place}")
        assert words in one.message

    def test_all_mistakes_are_given_at_once(self, tmp_path, paper):
        text = HEAD + "0,leader,0,0,0\n1,leader,nan,inf,0\n1,leader,0,0,0\n0.5,leader,0,0,0\n2,nemo,0,0,0\n"
        mistakes = diagnostics(read_logs, written(tmp_path, text), paper, POSTURE)
        assert [one.span.line for one in mistakes] == [3, 3, 4, 5, 6]

    def test_velocities_and_commands_are_needed_to_identify(self, tmp_path, paper):
        path = written(tmp_path, HEAD + "0,leader,0,0,0\n1,leader,0,0,0\n")
        (one,) = diagnostics(read_logs, path, paper, (*VELOCITIES, *COMMANDS))
        assert one.message == "the first line names no column v, omega, v_c, omega_c"

    def test_a_clock_that_is_set_back_is_one_mistake(self, tmp_path, paper):
        stamps = [0.0, 0.1, 0.2, 0.05, 0.06, 0.07, 0.3]
        path = written(tmp_path, HEAD + "".join(f"{t},leader,0,0,0\n" for t in stamps))
        (one,) = diagnostics(read_logs, path, paper, POSTURE)
        assert one.message == "column t: 0.05 of leader comes after 0.2; times must increase by 1e-06 s"

    def test_a_column_that_is_there_is_not_offered_for_another(self, tmp_path, paper):
        path = written(tmp_path, "t,robot,v,omega,v_c\n")
        (one,) = diagnostics(read_logs, path, paper, (*VELOCITIES, *COMMANDS))
        assert one.facts[1] == "other names of omega_c: safe_omega, omega_cmd, cmd_omega, angular_cmd"
        assert "did you mean" not in one.help

    def test_other_words_for_columns_and_clocks_that_count_from_1970(self, tmp_path, paper):
        text = "stamp,name,x,y,yaw,linear,yaw_rate,cmd_v,cmd_omega,battery\n"
        text += "".join(f"{1.7e9 + 0.1 * k:.1f},leader,{k},2,3,4,5,6,7,full\n" for k in range(4))
        logs, warnings = read_logs(written(tmp_path, text), paper, (*POSTURE, *VELOCITIES, *COMMANDS))
        assert logs["leader"].t == pytest.approx([0.0, 0.1, 0.2, 0.3], abs=1e-6)
        assert list(logs["leader"].signals["x"]) == [0, 1, 2, 3]
        assert logs["leader"].commands.tolist() == [[6, 7]] * 4
        assert [one.message for one in warnings] == [f"in the log: there is no {one}" for one in ROBOTS[1:]]

    def test_gaps_and_logs_that_end_early_are_warned_of(self, tmp_path, paper):
        stamps = [0.0, 0.1, 0.2, 0.3, 2.0, 2.1]
        path = written(tmp_path, HEAD + "".join(f"{t},{n},0,0,0\n" for n in ROBOTS for t in stamps))
        logs, warnings = read_logs(path, paper, POSTURE)
        assert [one.message for one in warnings] == [
            f"in the log: {one} has 1 gap, the longest 1.7 s at t = 0.3 s" for one in ROBOTS
        ]
        assert [one.severity for one in warnings] == ["warning"] * 3
        assert "leader ends at 2.1 s" in read_logs(path, paper, horizon=3.0)[1][-1].message
        assert len(read_logs(path, paper, horizon=2.2)[1]) == 3
        assert [log.gaps.tolist() for log in logs.values()] == [[3]] * 3


class TestBeside:
    def test_a_run_does_not_differ_from_its_own_logs(self, tmp_path):
        run = ("run", "undisturbed", "--controller", "smc", *(word for one in SHORT for word in ("--set", one)))
        here(*run, "-o", tmp_path / "a", "--data", "csv", "--bag", tmp_path / "bag")
        done = here(*run, "-o", tmp_path / "b", "--beside", tmp_path / "a" / "trajectory.csv")
        assert done.stderr == ""
        assert "Root mean square differences from the log" in done.stdout
        summary = json.loads((tmp_path / "b" / "summary.json").read_text(encoding="utf-8"))
        file, trajectory = shared("undisturbed", "smc", *SHORT)
        tables = [summary["controllers"]["smc"]["log"]]
        for path in (tmp_path / "bag", next((tmp_path / "bag").glob("*.db3"))):
            tables.append(differences(trajectory, read_logs(path, file.scenario, COMMANDS)[0]))
        for row in (row for table in tables for row in table.values()):
            assert row.pop("samples") >= 100
            assert max(row.values()) < 1e-6

    @given(st.floats(-5, 5), st.floats(-5, 5), st.integers(-3, 3))
    def test_a_moved_log_differs_by_its_motion_and_by_no_full_turn(self, x, y, turns):
        _, run = shared("undisturbed", "smc", *SHORT)
        state = {k: run[k][:, 0] for k in (*POSTURE, *VELOCITIES)}
        moved = {"x": state["x"] + x, "y": state["y"] + y, "theta": state["theta"] + 2.0 * np.pi * turns}
        row = differences(run, {"leader": Log(run.t, {**state, **moved}, run.t[:0], np.zeros((0, 2)))})["leader"]
        assert (row["x"], row["y"]) == pytest.approx((abs(x), abs(y)), abs=1e-9)
        assert row["distance"] == pytest.approx(np.hypot(x, y), abs=1e-9)
        assert row["theta"] < 1e-9

    def test_a_log_among_the_results_is_not_replaced(self, tmp_path):
        log = written(tmp_path, HEAD + "0,leader,0,0,0\n0.1,leader,0,0,0\n").rename(tmp_path / "trajectory.csv")
        done = here("run", "paper", "--set", "run.horizon=0.1", "-o", tmp_path, "--beside", log, status=2)
        assert "is replaced by the results; name another folder with -o" in done.stderr.replace("\n", " ")
        assert log.exists()

    def test_a_log_that_begins_after_the_run_is_not_compared(self, tmp_path):
        rows = [f"{t},leader,0,0,0\n" for t in (0, 0.1)] + [f"{t},follower1,0,0,0\n" for t in (5, 5.1)]
        path = written(tmp_path, HEAD + "".join(rows))
        short = ("--set", "run.horizon=0.1", "--controller", "smc", "-o", tmp_path / "a")
        done = here("run", "paper", *short, "--beside", path)
        assert "in the log: follower1 begins at 5 s, the run ends at 0.1 s: it is not compared" in done.stderr
        assert "empty slice" not in done.stdout + done.stderr
        summary = json.loads((tmp_path / "a" / "summary.json").read_text(encoding="utf-8"))
        assert list(summary["controllers"]["smc"]["log"]) == ["leader"]

    def test_a_table_is_shown_whatever_was_changed(self, tmp_path):
        short = ("--set", "run.horizon=0.1", "-o", tmp_path / "a")
        done = here("run", "paper", *short, "--controller", "smc", "--beside", "table12")
        assert "Root mean square errors beside Table 12" in done.stdout
        assert "Table 12 speaks of another run: run.horizon is not the paper's" in done.stdout.replace("\n", " ")
        done = here("run", "paper", *short, "--controller", "smc", "--beside", "table13", status=2)
        assert "Table 13 has no row of this run" in done.stderr
        done = here("run", "paper", *short, "--beside", "table14", status=2)
        assert "table14 is no file, and the paper's tables are table12 and table13" in done.stderr.replace("\n", " ")

    def test_mistakes_end_the_command_before_it_computes(self, tmp_path):
        path = written(tmp_path, HEAD + "0,leader,0,0,0\n0,leader,x,0,0\n")
        done = here("run", "paper", "--beside", path, "-o", tmp_path / "out", status=1)
        assert "log.csv:3:10: error[FZ911]: column x: x is not a number" in done.stderr
        assert not (tmp_path / "out").exists()
        done = here("run", "paper", "--beside", tmp_path / "none.csv", status=1)
        assert "none.csv cannot be read" in done.stderr


class TestBag:
    def test_a_folder_that_is_no_bag_is_refused(self, tmp_path, paper):
        (one,) = diagnostics(read_logs, tmp_path, paper, POSTURE)
        assert "is not a readable bag" in one.message

    @pytest.mark.parametrize(
        ("rows", "words"),
        [
            ([(0.0, 0.0), (0.0, 1.0)], "message 2 has the stamp of message 1"),
            ([(0.0, 0.0), (0.1, np.nan)], "message 2 has a number that is not finite"),
            ([(0.0, 0.0)], "no robot of the scenario has two messages of odometry"),
        ],
    )
    def test_mistakes_of_messages(self, tmp_path, rows, words):
        path = bag_of(tmp_path / "bag", "/leader/odom", rows)
        (one,) = diagnostics(read_logs, path, read("paper").scenario, POSTURE)
        assert words in one.message

    def test_commands_are_needed_to_identify(self, tmp_path, paper):
        path = bag_of(tmp_path / "bag", "/leader/odom", [(0.0, 0.0), (0.1, 0.0)])
        (one,) = diagnostics(read_logs, path, paper, COMMANDS)
        assert "there are no commands of leader" in one.message


def bag_of(folder, topic, rows):
    """Write a bag with odometry: times [s] and x [m]."""
    pytest.importorskip("rosbags", reason="rosbags is not installed: pip install 'fuzzyctl[ros]'")
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    make = {name.rpartition("/")[2]: one for name, one in store.types.items()}
    still, covariance = make["Vector3"](0.0, 0.0, 0.0), np.zeros(36)
    header = make["Header"](make["Time"](0, 0), "odom")
    twist = make["TwistWithCovariance"](make["Twist"](still, still), covariance)
    with Writer(folder, version=8) as writer:
        connection = writer.add_connection(topic, "nav_msgs/msg/Odometry", typestore=store)
        for t, x in rows:
            pose = make["Pose"](make["Point"](x, 0.0, 0.0), make["Quaternion"](0.0, 0.0, 0.0, 1.0))
            message = make["Odometry"](header, "base", make["PoseWithCovariance"](pose, covariance), twist)
            writer.write(connection, round(1e9 * t), store.serialize_cdr(message, connection.msgtype))
    return folder
