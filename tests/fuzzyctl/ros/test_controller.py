"""The node against a stub of rclpy: what it publishes, when it rests, and what it refuses."""

import math
import runpy
from pathlib import Path

import numpy as np
import pytest
import yaml

import fuzzyctl
from tests.dwmr.ros.stub import Float64, JointState, Node, install
from tests.e2e.pages import blocks

PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "drive-robots-with-ros.md"
VALVE = """
controller valve
input reference in [0, 2]
input level in [0, 2]
output opening in [0, 1] = clamp(sum, 0, 1)
output rate = 0.5 * (reference - level)
let sum = integral(rate)
every 0.1 s
"""
INPUTS = ["reference goal std_msgs/msg/Float64 data", "level joints sensor_msgs/msg/JointState position.1"]
OUTPUTS = ["rate cmd_vel geometry_msgs/msg/Twist angular.z 0", "opening cmd_vel geometry_msgs/msg/Twist linear.x 0.25"]
REST = (0.25, 0.0)


@pytest.fixture
def given(tmp_path):
    """Parameters of a node whose file has a text."""

    def write(text=VALVE, **more):
        (tmp_path / "law.fz").write_text(text, encoding="utf-8")
        return {"file": str(tmp_path / "law.fz"), "inputs": INPUTS, "outputs": OUTPUTS, **more}

    return write


def ended(monkeypatch, node, between=lambda node: None, periods=20):
    """Run the node for some periods: its exit code."""

    def until(node):
        if node.now > (periods - 0.5) * 0.1:
            raise KeyboardInterrupt
        between(node)

    install(monkeypatch, node, until)
    with pytest.raises(SystemExit) as stop:
        runpy.run_module("fuzzyctl.ros", run_name="__main__")
    return stop.value.code


def report(node, level=0.5):
    node.callbacks["goal"](Float64(1.0))
    node.callbacks["joints"](JointState([9.0, level]))


def test_outputs_are_those_of_the_controller_and_rest_comes_last(monkeypatch, given):
    node = Node(**given())
    levels = [0.1 * k for k in range(20)]
    assert ended(monkeypatch, node, lambda node: report(node, levels[round(10 * node.now)])) == 0
    wanted, _ = fuzzyctl.compile(fuzzyctl.load(node.given["file"], block=fuzzyctl.Controller)).run(
        [[1.0, x] for x in levels]
    )
    assert [period for period, _ in node.timers] == [0.1]
    assert node.subscribed == {"goal": Float64, "joints": JointState}
    assert node.published["cmd_vel"][:-1] == [pytest.approx(tuple(row)) for row in wanted.tolist()]
    assert node.published["cmd_vel"][-1] == REST


def test_old_inputs_bring_it_to_rest_its_state_waits_and_the_log_says_so_once(monkeypatch, given):
    node = Node(**given(timeout=0.25))

    def between(node):
        if round(10 * node.now) not in range(5, 12):
            report(node)

    ended(monkeypatch, node, between)
    sent = node.published["cmd_vel"]
    assert [k for k, one in enumerate(sent) if one == REST] == [7, 8, 9, 10, 11, 20]
    assert sent[12][0] - sent[6][0] == pytest.approx(0.025)
    reasons = "no message on goal for more than 0.25 s; no message on joints for more than 0.25 s"
    assert node.logged == [("warning", f"at rest: {reasons}"), ("info", "all inputs are there: the controller runs")]


def test_numbers_of_arrays_of_fixed_size_are_read(monkeypatch, given):
    node = Node(**given())

    def between(node):
        node.callbacks["goal"](Float64(1.0))
        node.callbacks["joints"](JointState(np.array([9.0, 0.5], dtype=np.float32)))

    ended(monkeypatch, node, between, 3)
    assert node.logged == []
    assert node.published["cmd_vel"][0][1] == 0.25


def test_messages_with_a_header_have_the_time(monkeypatch, given):
    node = Node(**given(outputs=["rate cmd_vel geometry_msgs/msg/TwistStamped twist.angular.z 0"]))
    ended(monkeypatch, node, report, 3)
    assert node.headers["cmd_vel"][1] == ((0, 100_000_000), "")
    assert node.published["cmd_vel"][1][1] == 0.25


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (JointState([1.0]), "no number position.1 in the message on joints"),
        (JointState([1.0, math.nan]), "position.1 on joints is not finite"),
        (None, "no message on joints"),
    ],
)
def test_an_input_that_cannot_be_used_brings_it_to_rest(monkeypatch, given, message, reason):
    node = Node(**given())

    def between(node):
        node.callbacks["goal"](Float64(1.0))
        if message:
            node.callbacks["joints"](message)

    ended(monkeypatch, node, between, 3)
    assert set(node.published["cmd_vel"]) == {REST}
    assert node.logged == [("warning", f"at rest: {reason}")]


def test_a_controller_without_period_takes_that_of_the_parameter(monkeypatch, given):
    node = Node(**given(VALVE.replace("every 0.1 s\n", ""), period=0.05))
    ended(monkeypatch, node, report)
    assert [period for period, _ in node.timers] == [0.05]
    assert node.published["cmd_vel"][10][0] == pytest.approx(10 * 0.05 * 0.25)


def test_an_output_that_is_not_finite_ends_it(monkeypatch, given):
    node = Node(**given(VALVE.replace("0.5 * (reference - level)", "1 / (level - 0.5)").replace("in [0, 1]", "")))
    assert ended(monkeypatch, node, report) == 1
    assert set(node.published["cmd_vel"]) == {REST}
    assert node.logged[-1] == ("error", "at rest: output rate is not finite")


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"file": ""}, "file is missing"),
        ({"inputs": INPUTS[:1]}, "inputs: a line is missing for level; expected NAME TOPIC TYPE FIELD"),
        ({"outputs": [""]}, "outputs: a line is missing for opening, rate"),
        ({"outputs": ["rate cmd_vel geometry_msgs/msg/Twist angular.z"]}, "expected NAME TOPIC TYPE FIELD REST"),
        ({"outputs": ["rate a std_msgs/msg/Float64 data off"]}, "expected a number as REST, got 'off'"),
        ({"outputs": ["rate a std_msgs/msg/Float64 data nan"]}, "expected a number as REST, got 'nan'"),
        ({"outputs": ["rat a std_msgs/msg/Float64 data 0"]}, "has no such output; did you mean 'rate'?"),
        ({"outputs": ["rate a std_msgs/msg/Float65 data 0"]}, "there is no message type 'std_msgs/msg/Float65'"),
        ({"outputs": ["rate a os.path data 0"]}, "there is no message type 'os.path'"),
        ({"outputs": ["rate a geometry_msgs/msg/Twist angular 0"]}, "'angular' is not a floating-point number of"),
        ({"outputs": ["rate a sensor_msgs/msg/JointState position.0 0"]}, "'position.0' is not a floating-point"),
        ({"inputs": [*INPUTS, INPUTS[0]]}, "inputs: 'reference' stands there twice"),
        (
            {"outputs": ["rate a std_msgs/msg/Float64 data 0", "opening a geometry_msgs/msg/Twist linear.x 0"]},
            "outputs: 'opening' and 'rate' give the topic a two types",
        ),
        ({"period": 0.2}, "period = 0.2 s, but the controller says every 0.1 s"),
        ({"timeot": 1.0}, "there is no parameter timeot; did you mean 'timeout'?"),
        ({"timeout": 0.0}, "timeout = 0 s, expected a positive number"),
        ({"inputs": "level"}, "inputs has the wrong type, expected a list of texts"),
    ],
)
def test_a_mistake_in_a_parameter_is_reported_and_nothing_published(monkeypatch, given, capsys, more, message):
    node = Node(**given(**more))
    assert ended(monkeypatch, node) == 2
    assert message in capsys.readouterr().err
    assert node.published == {}


def test_a_controller_without_period_needs_one(monkeypatch, given, capsys):
    assert ended(monkeypatch, Node(**given(VALVE.replace("every 0.1 s\n", "")))) == 2
    assert "period = 0 s, expected a positive number; the controller has no 'every' line" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (VALVE.replace("reference - level", "reference - lavel"), "lavel"),
        (VALVE + "require rate <= 0.1\n", "law.fz:9:1: error[FZ402]: the guarantee 'rate <= 0.1' is not proved"),
    ],
)
def test_a_mistake_in_the_file_and_a_claim_without_proof_are_diagnostics(monkeypatch, given, capsys, text, words):
    node = Node(**given(text))
    assert ended(monkeypatch, node) == 1
    assert words in capsys.readouterr().err
    assert node.published == {}


def test_the_example_of_the_page_runs(monkeypatch, tmp_path):
    files = {one.file: one.text for one in blocks(PAGE) if one.file}
    (tmp_path / "heading.fz").write_text(files["heading.fz"], encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    node = Node(**yaml.safe_load(files["heading.yaml"])["controller"]["ros__parameters"])

    def between(node):
        node.callbacks["heading"](Float64(3.0))
        node.callbacks["compass"](Float64(-3.0))

    assert ended(monkeypatch, node, between) == 0
    assert node.published["cmd_vel"][0] == pytest.approx((0.0, 0.8 * (6.0 - 2 * math.pi)))
