"""A node of ROS 2 that runs a controller of a rule file: its inputs from topics, its outputs to topics.

It is handed its node of rclpy, so that it needs no ROS to be imported or tested.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from importlib import import_module
from numbers import Real
from typing import Any, NamedTuple

import numpy as np

from fuzzyctl.analysis.prove import prove
from fuzzyctl.analysis.verdicts import Proved
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, FuzzyctlError
from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.kernels.compile import compile
from fuzzyctl.kernels.kernel import Kernel
from fuzzyctl.loading.load import chosen, opened
from fuzzyctl.model.controller import Controller
from fuzzyctl.ros.program import ParameterError, Period, parameters, spin

_TYPE = re.compile(r"([a-z][a-z0-9_]*)/msg/([A-Z][A-Za-z0-9]*)")
_FORMS = {
    "inputs": "NAME TOPIC TYPE FIELD, such as 'level tank/level std_msgs/msg/Float64 data'",
    "outputs": "NAME TOPIC TYPE FIELD REST, such as 'omega_c cmd_vel geometry_msgs/msg/Twist angular.z 0'",
}


class Connection(NamedTuple):
    """A signal of the controller and the field of messages that it is.

    Attributes:
        signal: Name of the input or output.
        topic: Where the messages are.
        type: Class of the messages.
        field: Path to a number in a message; the number of an entry, from 0 on, leads into a list.
        rest: The value of an output while the controller does not run.
    """

    signal: str
    topic: str
    type: Any
    field: str
    rest: float = math.nan


def connections(lines: Iterable[str], parameter: str, signals: Sequence[str], wrong: list[str]) -> list[Connection]:
    """Read the connections of all inputs, or of some outputs.

    Args:
        lines: One for each signal.
        parameter: Which lines these are, `inputs` or `outputs`.
        signals: Names that the controller has.
        wrong: Takes a message for each mistake.
    """
    result: list[Connection] = []
    for line in filter(str.strip, lines):
        one, mistake = _connection(line, parameter, signals)
        if one is None:
            wrong.append(f"{parameter}: '{line}': {mistake}")
        elif any(other.signal == one.signal for other in result):
            wrong.append(f"{parameter}: '{one.signal}' stands there twice")
        elif clash := next((o for o in result if o.topic == one.topic and o.type is not one.type), None):
            wrong.append(f"{parameter}: '{one.signal}' and '{clash.signal}' give the topic {one.topic} two types")
        else:
            result.append(one)
    missing = [name for name in signals if all(name != one.signal for one in result)]
    if not wrong and (missing if parameter == "inputs" else not result):
        wrong.append(f"{parameter}: a line is missing for {', '.join(missing)}; expected {_FORMS[parameter]}")
    return sorted(result, key=lambda one: signals.index(one.signal))


def _connection(line: str, parameter: str, signals: Sequence[str]) -> tuple[Connection | None, str]:
    """Return a connection, or None and the mistake."""
    words = line.split()
    if len(words) != len(_FORMS[parameter].split(",")[0].split()):
        return None, f"expected {_FORMS[parameter]}"
    signal, topic, kind, field = words[:4]
    if signal not in signals:
        near = closest(signal, signals)
        return None, f"the controller has no such {parameter[:-1]}" + (f"; did you mean '{near}'?" if near else "")
    rest = _finite(words[4]) if parameter == "outputs" else math.nan
    if rest is None:
        return None, f"expected a number as REST, got '{words[4]}'"
    matched = _TYPE.fullmatch(kind)
    try:
        message = getattr(import_module(f"{matched[1]}.msg"), matched[2]) if matched else None
    except (ImportError, AttributeError):
        message = None
    if message is None:
        return None, f"there is no message type '{kind}'; expected one such as std_msgs/msg/Float64"
    if parameter == "inputs" and any(part.isdigit() for part in field.split(".")):
        return Connection(signal, topic, message, field), ""  # entries of lists are there when a message has come
    value = value_of(message(), field)
    if value is None or (parameter == "outputs" and not isinstance(value, float)):
        return None, f"'{field}' is not a {'number' if parameter == 'inputs' else 'floating-point number'} of {kind}"
    return Connection(signal, topic, message, field, rest), ""


def _finite(word: str) -> float | None:
    try:
        number = float(word)
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def value_of(message: Any, field: str) -> Real | None:
    """Return the number in a field of a message, or None."""
    for part in field.split("."):
        try:
            message = message[int(part)] if part.isdigit() else getattr(message, part)
        except (AttributeError, IndexError, TypeError):
            return None
    return message if isinstance(message, Real) else None  # also those of NumPy, which arrays of fixed size have


def put(message: Any, field: str, value: float) -> None:
    """Write a number into a field of a message."""
    *path, last = field.split(".")
    for part in path:
        message = getattr(message, part)
    setattr(message, last, value)


#: Parameters of the node and their defaults.
PARAMETERS: Mapping[str, str | float | Sequence[str]] = {
    "file": "",
    "controller": "",
    "period": 0.0,
    "timeout": 0.5,
    "inputs": [""],
    "outputs": [""],
}


def run(node: Any) -> int:
    """Run the controller that parameters name until it fails, and publish its values at rest whatever ends it.

    Args:
        node: Node of rclpy.

    Returns:
        Exit code: 1 for a controller that failed.

    Raises:
        ParameterError: For parameters that cannot be used.
        DiagnosticError: For mistakes in the file, and guarantees that are not proved.
    """
    values = parameters(node, PARAMETERS)
    if not values["file"]:
        raise ParameterError("file is missing: the path of a rule file with a controller")
    controller = chosen(opened(values["file"]), values["controller"] or None, Controller)
    step, wrong = compile(controller, "python"), list[str]()
    inputs = connections(values["inputs"], "inputs", step.input_names, wrong)
    outputs = connections(values["outputs"], "outputs", step.output_names, wrong)
    period = values["period"] or step.period or 0.0
    if not 0.0 < period < math.inf:
        wrong.append(f"period = {period:g} s, expected a positive number; the controller has no 'every' line")
    elif step.period not in (None, period):
        wrong.append(f"period = {period:g} s, but the controller says every {step.period:g} s")
    if not 0.0 < values["timeout"] < math.inf:
        wrong.append(f"timeout = {values['timeout']:g} s, expected a positive number")
    if wrong:
        raise ParameterError("\n".join(wrong))
    _require_proofs(controller, values["file"])
    qos = import_module("rclpy.qos").qos_profile_sensor_data
    running = ControllerNode(node, step, period, inputs, outputs, values["timeout"], qos)
    try:
        spin(node, lambda: running.failed)
    finally:
        running.rest()
    return 1


def _require_proofs(controller: Controller, file: str) -> None:
    """Refuse a controller whose guarantees are not proved."""
    repair = f"fuzzyctl prove {file} says why"
    wrong = [
        Diagnostic("FZ402", f"the guarantee '{one.claim}' is not proved", one.span, file=file, help=repair)
        for one in prove(controller)
        if not isinstance(one, Proved)
    ]
    if wrong:
        raise DiagnosticError(wrong)


class ControllerNode:
    """Makes a step in each period, and publishes values at rest while an input is missing.

    Args:
        node: Node of rclpy.
        step: Of the controller.
        period: Time between two steps [s].
        inputs: Of all inputs, in order.
        outputs: Of the outputs that are published.
        timeout: Largest time since a message of each input came [s].
        qos: Quality of service of inputs.
    """

    def __init__(
        self,
        node: Any,
        step: Kernel,
        period: float,
        inputs: Sequence[Connection],
        outputs: Sequence[Connection],
        timeout: float,
        qos: Any,
    ) -> None:
        self._node, self._log, self._timeout = node, node.get_logger(), timeout
        self._inputs, self._outputs = inputs, outputs
        self._step, self._state = step, step.start()
        self._dt = period if step.period is None else None
        self._latest: dict[str, tuple[Any, int]] = {}
        self._problems: tuple[str, ...] = ()
        self._publishers = {
            topic: (kind, node.create_publisher(kind, topic, 1))
            for topic, kind in dict.fromkeys((one.topic, one.type) for one in outputs)
        }
        for topic, kind in dict.fromkeys((one.topic, one.type) for one in inputs):
            node.create_subscription(kind, topic, partial(self._keep, topic), qos)
        self._period = Period(node, period)
        node.create_timer(period, self.tick)
        #: Whether the controller cannot go on.
        self.failed = False

    def tick(self) -> None:
        """Make a step and publish its outputs, or those at rest."""
        if self.failed:
            return
        now = self._node.get_clock().now().nanoseconds
        self._period.begin(now)
        values = [self._value(one, now) for one in self._inputs]
        problems = tuple(dict.fromkeys(one for one in values if isinstance(one, str)))
        if problems != self._problems:
            if problems:
                self._log.warning("at rest: " + "; ".join(problems))
            else:
                self._log.info("all inputs are there: the controller runs")
            self._problems = problems
        if problems:
            self.rest()
            return
        try:
            numbers = [one for one in values if not isinstance(one, str)]
            commands, self._state = self._step(*numbers, self._state, dt=self._dt)
        except FuzzyctlError as error:
            self._fail(str(error))
            return
        outputs = dict(zip(self._step.output_names, np.atleast_1d(commands).tolist(), strict=True))
        if wrong := [one.signal for one in self._outputs if not math.isfinite(outputs[one.signal])]:
            self._fail(f"output {', '.join(wrong)} is not finite")
            return
        self._publish(outputs)

    def rest(self) -> None:
        """Publish the values at rest."""
        self._publish({one.signal: one.rest for one in self._outputs})

    def _publish(self, outputs: Mapping[str, float]) -> None:
        for topic, (kind, publisher) in self._publishers.items():
            message = kind()
            if hasattr(message, "header"):
                message.header.stamp = self._node.get_clock().now().to_msg()
            for one in self._outputs:
                if one.topic == topic:
                    put(message, one.field, outputs[one.signal])
            publisher.publish(message)

    def _keep(self, topic: str, message: Any) -> None:
        """Keep a message and its time; the tick computes."""
        self._latest[topic] = message, self._node.get_clock().now().nanoseconds

    def _fail(self, reason: str) -> None:
        self.failed = True
        self.rest()
        self._log.error(f"at rest: {reason}")

    def _value(self, one: Connection, now: int) -> float | str:
        """Return the value of an input, or the reason why it is missing."""
        if one.topic not in self._latest:
            return f"no message on {one.topic}"
        message, came = self._latest[one.topic]
        if not 0 <= now - came <= 1e9 * self._timeout:
            return f"no message on {one.topic} for more than {self._timeout:g} s"
        value = value_of(message, one.field)
        if value is None:
            return f"no number {one.field} in the message on {one.topic}"
        return float(value) if math.isfinite(value) else f"{one.field} on {one.topic} is not finite"
