"""A node of ROS 2 that runs a controller of a rule file: its inputs from topics, its outputs to topics.

It is handed its node of rclpy, so that it needs no ROS to be imported or tested.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np

from fuzzyctl.analysis.prove import prove
from fuzzyctl.analysis.verdicts import Proved
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, FuzzyctlError
from fuzzyctl.kernels.compile import compile
from fuzzyctl.kernels.kernel import Kernel
from fuzzyctl.loading.load import chosen, opened
from fuzzyctl.model.controller import Controller
from fuzzyctl.ros.connections import Connection, connections, put, value_of
from fuzzyctl.ros.program import ParameterError, Period, parameters, spin

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
            found, self._state = self._step(*numbers, self._state, dt=self._dt)
        except FuzzyctlError as error:
            self._fail(str(error))
            return
        outputs = dict(zip(self._step.output_names, np.atleast_1d(found).tolist(), strict=True))
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
        """Keep a message and when it came; nothing is computed here."""
        self._latest[topic] = message, self._node.get_clock().now().nanoseconds

    def _fail(self, reason: str) -> None:
        self.failed = True
        self.rest()
        self._log.error(f"at rest: {reason}")

    def _value(self, one: Connection, now: int) -> float | str:
        """Return the value of an input, or why there is none."""
        if one.topic not in self._latest:
            return f"no message on {one.topic}"
        message, came = self._latest[one.topic]
        if not 0 <= now - came <= 1e9 * self._timeout:
            return f"no message on {one.topic} for more than {self._timeout:g} s"
        value = value_of(message, one.field)
        if value is None:
            return f"no number {one.field} in the message on {one.topic}"
        return float(value) if math.isfinite(value) else f"{one.field} on {one.topic} is not finite"
