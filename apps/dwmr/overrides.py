"""Values of a scenario given on the command line as `key=value` with dotted keys."""

from __future__ import annotations

import tomllib
from typing import Any


class OverrideError(Exception):
    """Raised when a `--set` argument is not of the form key=value."""


def override(data: dict[str, Any], argument: str) -> tuple[str, str]:
    """Set one value; return the full key and the argument that set it."""
    key, equals, value = argument.partition("=")
    parts = [p.strip() for p in key.split(".")]
    if not equals or not all(parts):
        raise OverrideError(f"--set {argument}: expected key=value with a dotted key, such as run.horizon=20")
    node: Any = data
    for k, part in enumerate(parts[:-1]):
        node = _child(node, part, ".".join(parts[: k + 1]), argument)
    if isinstance(node, list):
        node[_index(node, parts[-1], argument)] = _value(value)
    elif isinstance(node, dict):
        node[parts[-1]] = _value(value)
    else:
        raise OverrideError(f"--set {argument}: {'.'.join(parts[:-1])} is a value, not a table")
    return ".".join(parts), argument


def _child(node: Any, part: str, key: str, argument: str) -> Any:
    if isinstance(node, list):
        return node[_index(node, part, argument)]
    if isinstance(node, dict):
        return node.setdefault(part, {})
    raise OverrideError(f"--set {argument}: {key.rpartition('.')[0]} is a value, not a table")


def _index(items: list[Any], part: str, argument: str) -> int:
    if not part.isdecimal() or int(part) >= len(items):
        raise OverrideError(f"--set {argument}: {part!r} is no index here; there are {len(items)}, counted from 0")
    return int(part)


def _value(text: str) -> Any:
    """Read a value as TOML does; a bare word is text."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text.strip()
