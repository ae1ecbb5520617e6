"""Bags are read back with the reader of rosbags: topics, stamps, frames, and the numbers of the run."""

import math
import sqlite3
import sys

import numpy as np
import pytest
import yaml

from dwmr.core.geometry import ahead, yaw
from tests.dwmr.process import here
from tests.dwmr.ros.stub import FILTER
from tests.dwmr.scenarios import changed, shared

pytest.importorskip("rosbags", reason="rosbags is not installed: pip install 'fuzzyctl[ros]'")


LIMIT = "robots.follower1.actuator.v_limit=0.5"
LEADERS_LIMIT = "robots.leader.actuator.v_limit=0.3"
SAFETY = f"safety={{{', '.join(FILTER)}}}"


def bag_of(folder, name, law, *overrides):
    """Run a scenario; return its trajectory, the scenario and the folder of the bag."""
    file, trajectory = shared(name, law, *overrides)
    options = [word for one in overrides for word in ("--set", one)]
    here("run", name, "--controller", law, *options, "--bag", folder / "first", "-o", folder / "out")
    return trajectory, file.scenario, folder / "first"


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """A short run, its scenario and its bag."""
    folder = tmp_path_factory.mktemp("bags")
    return bag_of(folder, "undisturbed", "aifqsmc", "run.horizon=0.5", "run.save_every=10", LIMIT)


def sent(folder, *topics):
    """Return the messages of some topics of a bag."""
    from rosbags.highlevel import AnyReader

    found = {one: [] for one in topics}
    with AnyReader([folder]) as reader:
        for connection, _, data in reader.messages([one for one in reader.connections if one.topic in found]):
            found[connection.topic].append(reader.deserialize(data, connection.msgtype))
    return tuple(found.values())


@pytest.fixture(scope="module")
def messages(kept):
    """All messages by topic, with their times [ns]."""
    from rosbags.highlevel import AnyReader

    found = {}
    with AnyReader([kept[2]]) as reader:
        for connection, time, data in reader.messages():
            found.setdefault(connection.topic, []).append((time, reader.deserialize(data, connection.msgtype)))
    return found


def test_each_robot_has_its_topics_and_all_share_the_transforms(messages, kept):
    robots = kept[1].robots
    assert set(messages) == {
        "/tf",
        *(f"/{name}/{topic}" for name in robots for topic in ("odom", "cmd_vel", "reference")),
    }
    assert {len(found) for found in messages.values()} == {11}


def test_times_and_stamps_are_those_of_the_run(messages):
    for time, message in messages["/leader/odom"]:
        assert message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec == time
    assert [time for time, _ in messages["/tf"]] == [50_000_000 * k for k in range(11)]


def test_odometry_is_that_of_the_wheel_axis_in_the_frames_of_ros(messages, kept):
    trajectory, scenario, _ = kept
    for i, (name, robot) in enumerate(scenario.robots.items()):
        for k, (_, message) in enumerate(messages[f"/{name}/odom"]):
            x, y, theta, v, omega = trajectory.values[10 * k, i, :5]
            place, turn, twist = message.pose.pose.position, message.pose.pose.orientation, message.twist.twist
            assert (message.header.frame_id, message.child_frame_id) == ("odom", f"{name}/base_link")
            assert (place.x, place.y, place.z) == (*ahead(x, y, theta, -robot.d), 0.0)
            assert yaw(turn.x, turn.y, turn.z, turn.w) == pytest.approx(theta, abs=1e-12)
            assert (twist.linear.x, twist.angular.z) == (v, omega)


def test_commands_are_limited(messages, kept):
    asked = kept[0]["v_c"][::10, 1]
    commands = [message.linear.x for _, message in messages["/follower1/cmd_vel"]]
    assert np.max(np.abs(asked)) > 0.5
    assert commands == list(np.clip(asked, -0.5, 0.5))


def test_robots_on_mecanum_wheels_have_velocities_to_their_left(tmp_path):
    trajectory, _, folder = bag_of(tmp_path, "omnidirectional", "omnidirectional", "run.horizon=0.2", LEADERS_LIMIT)
    odometry, commands = sent(folder, "/leader/odom", "/leader/cmd_vel")
    rows = np.linspace(0, len(trajectory.t) - 1, len(odometry)).astype(int)
    seen = [one.twist.twist.linear.y for one in odometry]
    assert seen == list(trajectory["v_y"][rows, 0])
    assert min(seen) < -0.1
    asked = trajectory["v_y_c"][rows, 0]
    assert [one.linear.y for one in commands] == list(np.clip(asked, -0.3, 0.3))
    assert np.abs(asked).max() > 0.3


def test_references_and_transforms_are_those_of_the_run(messages, kept):
    trajectory = kept[0]
    for k, (_, message) in enumerate(messages["/follower2/reference"]):
        assert (message.pose.position.x, message.pose.position.y) == (
            trajectory["x_r"][10 * k, 2],
            trajectory["y_r"][10 * k, 2],
        )
    _, tf = messages["/tf"][-1]
    _, odometry = messages["/leader/odom"][-1]
    assert [one.child_frame_id for one in tf.transforms] == [f"{name}/base_link" for name in kept[1].robots]
    assert tf.transforms[0].transform.translation.x == odometry.pose.pose.position.x
    assert tf.transforms[0].transform.rotation == odometry.pose.pose.orientation


def test_commands_are_those_after_the_safety_filter(tmp_path):
    overrides = ("run.horizon=0.1", "run.save_every=1", LIMIT, SAFETY)
    trajectory, _, folder = bag_of(tmp_path, "undisturbed", "aifqsmc", *overrides)
    commands = [one.linear.x for one in sent(folder, "/follower1/cmd_vel")[0]]
    assert np.any(trajectory["safe_v"] != trajectory["v_c"])
    assert commands == list(np.clip(trajectory["safe_v"][:, 1], -0.5, 0.5))


def test_the_metadata_is_what_old_and_new_ros_read(kept):
    about = yaml.safe_load((kept[2] / "metadata.yaml").read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
    assert (about["version"], about["storage_identifier"], about["relative_file_paths"]) == (
        8,
        "sqlite3",
        ["first.db3"],
    )
    assert about["custom_data"] == {"scenario": "undisturbed", "controller": "aifqsmc"}
    assert {type(one["topic_metadata"]["offered_qos_profiles"]) for one in about["topics_with_message_count"]} == {str}
    with sqlite3.connect(kept[2] / "first.db3") as database:
        assert database.execute("select count(*) from messages").fetchone() == (110,)


def test_equal_runs_give_equal_messages(kept, tmp_path):
    bag_of(tmp_path, "undisturbed", "aifqsmc", "run.horizon=0.5", "run.save_every=10", LIMIT)
    again = (tmp_path / "first" / "metadata.yaml").read_bytes()
    assert again == (kept[2] / "metadata.yaml").read_bytes()


@pytest.mark.parametrize("kind", ["folder", "file", "link"])
def test_what_exists_is_kept(tmp_path, kind):
    path = tmp_path / "there"
    {"folder": path.mkdir, "file": path.touch, "link": lambda: path.symlink_to("nowhere")}[kind]()
    done = here("run", "undisturbed", "--bag", path, "-o", tmp_path / "out", status=1)
    assert "it exists, and a bag is a new folder" in done.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["there"]


def test_a_run_records_a_bag(dwmr, tmp_path):
    run = ("run", "undisturbed", "--set", "run.horizon=0.1", "--bag", "bag")
    assert dwmr(*run)[:2][0] == 0
    assert (tmp_path / "bag" / "metadata.yaml").exists()
    status, _, err = dwmr(*run, "-o", "again")
    assert status == 1
    assert "bag cannot be written: it exists, and a bag is a new folder" in err
    assert not (tmp_path / "again").exists()
    status, _, err = dwmr(*run, "--controller", "all")
    assert status == 2
    assert "a bag holds the run of one control law, and --controller names 3" in err
    status, _, err = dwmr(*run[:-1], "one", "-o", "./one")
    assert status == 2
    assert "one is the folder of the results, and a bag is one of its own" in err
    assert not (tmp_path / "one").exists()


def test_a_folder_that_cannot_be_made_is_refused_before_the_run(dwmr, tmp_path):
    (tmp_path / "file").touch()
    status, _, err = dwmr("run", "undisturbed", "--bag", "file/bag")
    assert status == 1
    assert "file cannot be written: " in err
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_robots_need_names_that_topics_may_have(dwmr, tmp_path):
    text = 'extends = "undisturbed"\nname = "more"\n[robots.my-robot]\nx_0 = 9.0\ny_0 = 9.0\ntheta_0 = 0.0\nd = 0.1\n'
    (tmp_path / "more.toml").write_text(text, encoding="utf-8")
    status, _, err = dwmr("run", "more.toml", "--bag", "bag")
    assert status == 1
    assert "the name 'my-robot' of a robot cannot be that of topics of ROS 2" in err


def test_without_rosbags_the_extra_is_named(dwmr, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "rosbags", None)
    status, _, err = dwmr("run", "undisturbed", "--bag", "bag")
    assert status == 1
    assert "pip install 'fuzzyctl[ros]'" in err
    assert list(tmp_path.iterdir()) == []


class TestLimitsOfVehicles:
    """Commands that are sent keep to the limits of a robot."""

    LIMITS = ("robot.actuator.v_limit=1.5", "robot.actuator.omega_limit=1.0", "run.save_every=1")

    def run(self, name, law):
        return shared(name, law, "run.horizon=0.02", *self.LIMITS)

    def sent(self, recorded, folder, name, run, v, omega, **more):
        law = run.controller
        columns = {"v_c": v, "omega_c": omega, **more}
        recorded(changed(run, **{name: np.array(column)[:, None] for name, column in columns.items()}))
        options = [word for one in ("run.horizon=0.02", *self.LIMITS) for word in ("--set", one)]
        here("run", name, "--controller", law, *options, "--bag", folder / name, "-o", folder / f"of-{name}")
        (messages,) = sent(folder / name, "/leader/cmd_vel")
        return np.array([[one.linear.x, one.linear.y, one.angular.z] for one in messages])

    def test_of_two_wheels_and_mecanum_wheels_are_limited_one_by_one(self, recorded, tmp_path):
        wheels, mecanum = (self.run(*one)[1] for one in (("undisturbed", "smc"), ("omnidirectional",) * 2))
        v, omega = [2.0, -2.0, 0.0, 1.0, 1.0], [-4.0, 0.25, 0.0, 0.0, 0.5]
        wanted = np.array([[1.5, 0, -1.0], [-1.5, 0, 0.25], [0, 0, 0], [1, 0, 0], [1, 0, 0.5]])
        assert self.sent(recorded, tmp_path, "undisturbed", wheels, v, omega).tolist() == wanted.tolist()
        wanted[:, 1] = [-1.5, 0.5, 0.0, 0.0, 0.0]
        sideways = {"v_y_c": [-3.0, 0.5, 0.0, 0.0, 0.0]}
        found = self.sent(recorded, tmp_path, "omnidirectional", mecanum, v, omega, **sideways)
        assert found.tolist() == wanted.tolist()

    def test_of_a_car_keep_its_curvature(self, recorded, tmp_path):
        file, run = self.run("ackermann", "ackermann")
        car = file.scenario.robots["leader"].vehicle
        v, omega = [2.0, 1.2, -2.0, 0.5, 0.0], [0.4, 1.5, 0.4, -9.0, 1.0]
        found = self.sent(recorded, tmp_path, "ackermann", run, v, omega)
        bend = math.tan(car.steering_limit) / car.wheelbase
        wanted = [[1.5, 0, 0.3], [0.8, 0, 1.0], [-1.5, 0, 0.3], [0.5, 0, -0.5 * bend], [0, 0, 0]]
        assert found == pytest.approx(np.array(wanted), abs=1e-12)
