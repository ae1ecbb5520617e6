"""Fields of messages that are signals of a controller, as parameters of the node say."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from importlib import import_module
from numbers import Real
from typing import Any, NamedTuple

from fuzzyctl.diagnostics.suggestions import closest

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
        rest: What an output is while the controller does not run.
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
    found: list[Connection] = []
    for line in filter(str.strip, lines):
        one, mistake = _connection(line, parameter, signals)
        if one is None:
            wrong.append(f"{parameter}: '{line}': {mistake}")
        elif any(other.signal == one.signal for other in found):
            wrong.append(f"{parameter}: '{one.signal}' stands there twice")
        elif clash := next((o for o in found if o.topic == one.topic and o.type is not one.type), None):
            wrong.append(f"{parameter}: '{one.signal}' and '{clash.signal}' give the topic {one.topic} two types")
        else:
            found.append(one)
    missing = [name for name in signals if all(name != one.signal for one in found)]
    if not wrong and (missing if parameter == "inputs" else not found):
        wrong.append(f"{parameter}: a line is missing for {', '.join(missing)}; expected {_FORMS[parameter]}")
    return sorted(found, key=lambda one: signals.index(one.signal))


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
        made = getattr(import_module(f"{matched[1]}.msg"), matched[2]) if matched else None
    except (ImportError, AttributeError):
        made = None
    if made is None:
        return None, f"there is no message type '{kind}'; expected one such as std_msgs/msg/Float64"
    if parameter == "inputs" and any(part.isdigit() for part in field.split(".")):
        return Connection(signal, topic, made, field), ""  # entries of lists are there when a message has come
    value = value_of(made(), field)
    if value is None or (parameter == "outputs" and not isinstance(value, float)):
        return None, f"'{field}' is no {'number' if parameter == 'inputs' else 'floating-point number'} of {kind}"
    return Connection(signal, topic, made, field, rest), ""


def _finite(word: str) -> float | None:
    try:
        number = float(word)
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def value_of(message: Any, field: str) -> Real | None:
    """Return the number in a field of a message, None where there is none."""
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
