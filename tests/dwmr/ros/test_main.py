"""Start and end of the node, with a stub of rclpy and robots without inertia."""

import re
import runpy
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import yaml

import dwmr.ros
from dwmr import find, read
from dwmr.core.geometry import ahead
from dwmr.ros.main import PARAMETERS
from tests.dwmr.ros.stub import Float64, Node, Odometry, Twist, TwistStamped, Unicycles, install

FOLDER = Path(dwmr.ros.__file__).parent


def starts(scenario):
    return {n: (*ahead(r.x_0, r.y_0, r.theta_0, -r.d), r.theta_0) for n, r in scenario.robots.items()}


@pytest.fixture
def short(tmp_path):
    path = tmp_path / "short.toml"
    path.write_text(
        'extends = "undisturbed"\nname = "short"\n[run]\nhorizon = 8.0\ndt = 0.05\nsubsteps = 20\n', encoding="utf-8"
    )
    return path


def ended(monkeypatch, node, between=lambda node: None, unknown=()):
    """Run the node: exit code and calls of rclpy."""
    calls = install(monkeypatch, node, between, unknown)
    with pytest.raises(SystemExit) as stop:
        runpy.run_module("dwmr.ros", run_name="__main__")
    return stop.value.code, calls


def test_robots_under_the_node_come_to_their_places(monkeypatch, short):
    scenario, node = read(short).scenario, Node(scenario=str(short))
    robots = Unicycles(starts(scenario))
    status, calls = ended(monkeypatch, node, robots.report)
    assert (status, node.logged[-1]) == (0, ("info", "robots stopped: the end of the run"))
    assert calls == [("init", "no handlers"), ("create_node", "formation"), ("shutdown", True)]
    sent = node.published["leader/cmd_vel"]
    assert len(sent) == scenario.run.steps + 1 + 2  # zeros at the end of the run, and of the program
    assert sent[-1] == (0.0, 0.0)
    reference = read(short).shape.at(scenario.run.horizon)
    x, y = ahead(*robots.postures["leader"], scenario.robots["leader"].d)
    assert abs(x - reference.x) < 0.1
    assert abs(y - reference.y) < 0.1


def test_ctrl_c_stops_the_robots_before_the_communication_ends(monkeypatch, short):
    node = Node(scenario=str(short))
    robots = Unicycles(starts(read(short).scenario))

    def between(node):
        if node.now > 0.2:
            raise KeyboardInterrupt
        robots.report(node)

    status, calls = ended(monkeypatch, node, between)
    assert (status, calls[-1]) == (0, ("shutdown", True))
    assert node.published["leader/cmd_vel"][-2][0] != 0.0
    assert all(sent[-1] == (0.0, 0.0) for sent in node.published.values())


def test_all_mistakes_in_parameters_are_reported(monkeypatch, short, capsys):
    node = Node(scenario=str(short), timeout=-1.0, v_limit=0.0, rules="nowhere", controller="pid")
    assert ended(monkeypatch, node)[0] == 2
    said = capsys.readouterr().err
    for part in (
        "timeout = -1 s",
        "v_limit = 0 m/s",
        "rules = 'nowhere' is not a folder",
        "controller = 'pid' is not one of ackermann, aifqsmc",
    ):
        assert part in said
    assert node.published == {}


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"scenario": "papr"}, "papr"),
        ({"timeout": 1}, "timeout has the wrong type, expected a number with a point"),
        ({"scenario": 3}, "scenario has the wrong type, expected a text"),
        ({"stamped": "yes"}, "stamped has the wrong type, expected true or false"),
        ({"v_limt": 0.2}, "there is no parameter v_limt; did you mean 'v_limit'?"),
    ],
)
def test_a_mistake_in_a_parameter_is_reported(monkeypatch, capsys, given, message):
    assert ended(monkeypatch, Node(**given))[0] == 2
    said = capsys.readouterr().err
    assert message in said
    assert "Traceback" not in said


def test_an_argument_that_is_not_of_ros_is_reported(monkeypatch, capsys):
    status, calls = ended(monkeypatch, Node(), unknown=("--scenario", "paper"))
    assert (status, calls) == (2, [])
    assert "unknown argument --scenario; expected --ros-args" in capsys.readouterr().err


def test_arguments_that_ros_cannot_read_are_reported(monkeypatch, capsys):
    install(monkeypatch, Node())

    def init(**_):
        raise RuntimeError("failed to initialize rcl: Couldn't parse params file")

    monkeypatch.setattr("rclpy.init", init)
    with pytest.raises(SystemExit, match="2"):
        runpy.run_module("dwmr.ros", run_name="__main__")
    assert "error: failed to initialize rcl: Couldn't parse params file" in capsys.readouterr().err


def test_parameters_do_not_change_while_it_runs_and_others_have_no_effect(monkeypatch, short):
    node = Node(scenario=str(short), robot_radius=1.0, **{"qos_overrides./tf.depth": 1})
    assert ended(monkeypatch, node, Unicycles(starts(read(short).scenario)).report)[0] == 0
    assert {name: node.declared[name] for name in PARAMETERS} == dict.fromkeys(PARAMETERS, True)
    warned = [said for severity, said in node.logged if severity == "warning"]
    assert len(warned) == 1
    assert warned[0].startswith("parameter robot_radius has no effect; known are scenario")


def test_stamped_commands_have_the_time_and_the_frame_of_their_robot(monkeypatch, short):
    node = Node(scenario=str(short), stamped=True)
    assert ended(monkeypatch, node, Unicycles(starts(read(short).scenario)).report)[0] == 0
    headers = node.headers["follower1/cmd_vel"]
    assert headers[:2] == [((0, 0), "base_link"), ((0, 50_000_000), "base_link")]
    assert len(headers) == len(node.published["follower1/cmd_vel"])


def test_a_name_that_no_topic_has_is_reported(monkeypatch, tmp_path, capsys):
    text = find("paper").read_text(encoding="utf-8").replace('name = "paper"', 'name = "named"')
    path = tmp_path / "named.toml"
    path.write_text(re.sub(r"\bleader\b(?= *[\]\"])", "my-robot", text), encoding="utf-8")
    assert "my-robot" in read(path).scenario.robots
    assert ended(monkeypatch, Node(scenario=str(path)))[0] == 2
    assert "the name 'my-robot' of a robot cannot be that of topics of ROS 2" in capsys.readouterr().err


def test_a_law_with_a_mistake_is_a_diagnostic(monkeypatch, short, capsys):
    (short.parent / "mine.fz").write_text(
        "controller mine\ninput x_e\noutput v_c = x_f\noutput omega_c = 0\n", encoding="utf-8"
    )
    node = Node(scenario=str(short), controller="mine")
    status, calls = ended(monkeypatch, node)
    said = capsys.readouterr().err
    assert (status, calls[-1]) == (1, ("shutdown", True))
    assert "mine.fz:3:" in said
    assert "x_f" in said
    assert node.published == {}


def test_a_law_of_ones_own_drives(monkeypatch, short):
    law = "controller mine\ninput x_e\noutput v_c = 0.25\noutput omega_c = 0.5 * x_e - 0.5 * x_e\n"
    (short.parent / "mine.fz").write_text(law, encoding="utf-8")
    node = Node(scenario=str(short), controller="mine")
    assert ended(monkeypatch, node, Unicycles(starts(read(short).scenario)).report)[0] == 0
    assert set(node.published["follower1/cmd_vel"][:-2]) == {(0.25, 0.0)}


def test_without_ros_the_program_says_what_it_needs(capsys):
    with pytest.raises(SystemExit, match="rclpy is not installed; it is a part of ROS 2"):
        runpy.run_module("dwmr.ros", run_name="__main__")


def test_the_shipped_parameters_are_the_defaults():
    shipped = yaml.safe_load((FOLDER / "formation.yaml").read_text(encoding="utf-8"))
    assert shipped == {"/**": {"ros__parameters": dict(PARAMETERS)}}


def test_the_launch_file_starts_the_node_with_its_parameters():
    root = ElementTree.parse(FOLDER / "formation.launch.xml").getroot()
    arguments = {one.get("name"): one.get("default") for one in root.iter("arg")}
    (program,) = root.iter("executable")
    assert root.tag == "launch"
    assert arguments["params"] == "$(dirname)/formation.yaml"
    assert program.get("cmd") == "$(var python) -m dwmr.ros --ros-args --params-file $(var params)"
    assert (FOLDER / "__main__.py").exists()


def test_messages_of_the_stub_have_the_fields_of_ros():
    typesys = pytest.importorskip("rosbags.typesys")
    types = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE).types

    def compare(one, name):
        fields = types[name].__dataclass_fields__
        for key, value in vars(one).items():
            assert key in fields, f"{name}.{key}"
            if not isinstance(value, (int, float, str)):
                compare(value, str(fields[key].type).replace("__", "/"))

    compare(Odometry(), "nav_msgs/msg/Odometry")
    compare(Twist(), "geometry_msgs/msg/Twist")
    compare(TwistStamped(), "geometry_msgs/msg/TwistStamped")
    compare(Float64(), "std_msgs/msg/Float64")
