"""Overrides of scenario values on the command line: `key=value` with dotted keys."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterable
from typing import Any


class OverrideError(Exception):
    """Raised when a `--set` argument is not of the form key=value."""


#: Longest key; no table of a scenario is nested nearly as deep.
DEEPEST = 20
#: One part of a dotted key, quoted as TOML has it or bare, and what ends it.
_BARE = re.compile(r"[^\s.=\"']+")
_PART = re.compile(r"""\s*(?:"([^"\\]*)"|'([^']*)'|([^.="']*?))\s*([.=]|$)""")


def shorten(argument: str) -> str:
    """Return an argument as one line of at most 80 characters."""
    line = "".join(c if c.isprintable() else repr(c)[1:-1] for c in argument[:80])
    return line if len(argument) <= 80 else f"{line[:77]}..."


def split_key(key: str) -> list[str]:
    """Return the parts of a dotted key; a part in quotes may hold dots. What is no dotted key is one part."""
    parts, value = _split(f"{key}=")
    return parts if value == "" else [key]


def join_key(parts: Iterable[str]) -> str:
    """Return parts as a dotted key, from which `split_key` gets them back: what a bare part cannot hold is quoted."""
    return ".".join(part if _BARE.fullmatch(part) else f"'{part}'" if '"' in part else f'"{part}"' for part in parts)


def override(data: dict[str, Any], argument: str) -> tuple[str, str]:
    """Set one value; return the full key and the argument that set it.

    Args:
        data: Tables of a scenario as TOML gives them; changed.
        argument: `key=value` with a dotted key.

    Raises:
        OverrideError: When it has another form, or the key leads to no place in the tables.
    """
    parts, value = _split(argument)
    if not argument.isprintable():
        raise OverrideError(f"--set {shorten(argument)}: holds a line break or another control character")
    if len(parts) > DEEPEST:
        raise OverrideError(f"--set {shorten(argument)}: the key has {len(parts)} parts; expected at most {DEEPEST}")
    if value is None or not all(parts):
        raise OverrideError(f"--set {shorten(argument)}: expected key=value with a dotted key, such as table.key=20")
    node: Any = data
    for k, part in enumerate(parts[:-1]):
        node = _child(node, part, ".".join(parts[: k + 1]), argument)
    if isinstance(node, list):
        node[_index(node, parts[-1], argument)] = _value(value, argument)
    elif isinstance(node, dict):
        node[parts[-1]] = _value(value, argument)
    else:
        raise OverrideError(f"--set {shorten(argument)}: {'.'.join(parts[:-1])} is a value, not a table")
    return ".".join(parts), shorten(argument)


def _split(argument: str) -> tuple[list[str], str | None]:
    """Return the parts of the dotted key and the text of the value, None without one or with a stray quote."""
    parts, end = [], 0
    while found := _PART.match(argument, end):
        parts.append(found[1] or found[2] or found[3] or "")
        end = found.end()
        if found[4] != ".":
            return parts, argument[end:] if found[4] else None
    return parts, None


def _child(node: Any, part: str, key: str, argument: str) -> Any:
    if isinstance(node, list):
        return node[_index(node, part, argument)]
    if isinstance(node, dict):
        return node.setdefault(part, {})
    raise OverrideError(f"--set {shorten(argument)}: {key.rpartition('.')[0]} is a value, not a table")


def _index(items: list[Any], part: str, argument: str) -> int:
    if not part.isdecimal() or int(part) >= len(items):
        raise OverrideError(
            f"--set {shorten(argument)}: {part!r} is no index here; there are {len(items)}, counted from 0"
        )
    return int(part)


def _value(text: str, argument: str) -> Any:
    """Read a value as TOML does; a bare word is text."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text.strip()
    except ValueError as error:
        raise OverrideError(f"--set {shorten(argument)}: the number has too many digits") from error
    except RecursionError as error:
        raise OverrideError(f"--set {shorten(argument)}: the value is nested too deeply") from error


def literal(value: Any) -> str:
    """Return a value as TOML has it, bit for bit."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(literal(v) for v in value)}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{json.dumps(k)} = {literal(v)}' for k, v in value.items())}}}"
    return repr(value)
