"""Keys of a scenario: their locations in its files, and values of the command line that replace them."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import closest


class OverrideError(Exception):
    """Raised when a `--set` argument is not of the form key=value."""


#: Longest key; no table of a scenario is nested nearly as deep.
DEEPEST = 20
#: One part of a dotted key, quoted as TOML has it or bare, and its end.
_BARE = re.compile(r"[^\s.=\"']+")
_PART = re.compile(r"""\s*(?:"([^"\\]*)"|'([^']*)'|([^.="']*?))\s*([.=]|$)""")


def shorten(argument: str) -> str:
    """Return an argument as one line of at most 80 characters."""
    line = "".join(c if c.isprintable() else repr(c)[1:-1] for c in argument[:80])
    return line if len(argument) <= 80 else f"{line[:77]}..."


def split_key(key: str) -> list[str]:
    """Return the parts of a dotted key; a part in quotes may hold dots. Any other text is one part."""
    parts, value = _split(f"{key}=")
    return parts if value == "" else [key]


def join_key(parts: Iterable[str]) -> str:
    """Return parts as a dotted key, from which `split_key` gets them back; parts are quoted if necessary."""
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
    while match := _PART.match(argument, end):
        parts.append(match[1] or match[2] or match[3] or "")
        end = match.end()
        if match[4] != ".":
            return parts, argument[end:] if match[4] else None
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
            f"--set {shorten(argument)}: {part!r} is not an index here; there are {len(items)}, counted from 0"
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


KeyPath = tuple[str, ...]

_KEY = r'(?:[A-Za-z0-9_-]+|"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\')'
_DOTTED = rf"{_KEY}(?:\s*\.\s*{_KEY})*"
_HEADER = re.compile(rf"^\s*(\[\[?)\s*({_DOTTED})\s*\]\]?")
_PAIR = re.compile(rf"^\s*({_DOTTED})\s*=")


def key_places(text: str) -> Mapping[KeyPath, tuple[int, int]]:
    """Return the character range of every key that begins a line, by its full path.

    Keys inside inline tables and arrays have no separate line; look up their parent. The text must be valid TOML,
    so a line inside a multi-line string that looks like a key can only mislead a diagnostic's line, never its content.

    Args:
        text: A TOML document.
    """
    places: dict[KeyPath, tuple[int, int]] = {}
    counts: dict[KeyPath, int] = {}
    table: KeyPath = ()
    offset = 0
    for line in text.splitlines(keepends=True):
        if header := _HEADER.match(line):
            table = _resolve(_parts(header[2]), counts)
            if header[1] == "[[":
                index = counts.get(table, -1) + 1
                counts[table] = index
                table = (*table, str(index))
            places.setdefault(table, (offset + header.start(2), offset + header.end(2)))
        elif pair := _PAIR.match(line):
            places.setdefault((*table, *_parts(pair[1])), (offset + pair.start(1), offset + pair.end(1)))
        offset += len(line)
    return places


def _parts(dotted: str) -> KeyPath:
    return tuple(_unquoted(p) for p in re.findall(_KEY, dotted))


def _unquoted(key: str) -> str:
    """Return a part of a key without its quotes and escapes."""
    return str(tomllib.loads(f"key = {key}")["key"]) if key[0] in "\"'" else key


def _resolve(path: KeyPath, counts: Mapping[KeyPath, int]) -> KeyPath:
    """Put the current index after every part that is an array of tables, except the last."""
    resolved: KeyPath = ()
    for k, part in enumerate(path):
        resolved = (*resolved, part)
        if k + 1 < len(path) and resolved in counts:
            resolved = (*resolved, str(counts[resolved]))
    return resolved


#: Key by which a scenario names the one it changes.
EXTENDS = "extends"


@dataclass(frozen=True)
class Places:
    """Locations of the keys of a scenario: a line of one of its files, or an argument of the command line.

    Args:
        source: The scenario's own file.
        overrides: Arguments of the command line, by key.
        base: Places of the scenario that it extends.
        hidden: Keys whose values replace those of the base whole.
        common: By the name of a table of tables, the table whose values each of those takes over unless it sets one.
    """

    source: SourceText
    overrides: Mapping[str, str] = field(default_factory=dict)
    base: Places | None = None
    hidden: frozenset[tuple[str, ...]] = frozenset()
    common: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def _keys(self) -> Mapping[tuple[str, ...], tuple[int, int]]:
        return key_places(self.source.text)

    def _exact(self, path: tuple[str, ...]) -> Span | None:
        if offsets := self._keys.get(path):
            return Span(self.source, *offsets)
        if self.base is None or any(path[:k] in self.hidden for k in range(1, len(path) + 1)):
            return None
        return self.base._exact(path)

    def _argument(self, path: tuple[str, ...]) -> str:
        """Return the argument of the command line that gave a key, or a whole table with it."""
        heads = (".".join(path[:k]) for k in range(len(path), 0, -1))
        return next((self.overrides[head] for head in heads if head in self.overrides), "")

    def _argument_below(self, path: tuple[str, ...]) -> str:
        """Return the first argument of the command line that gave something in a table."""
        table = f"{'.'.join(path)}."
        return next((argument for key, argument in self.overrides.items() if key.startswith(table)), "")

    def given(self, *path: str) -> bool:
        """Return whether an argument of the command line gave a key, or a whole table with it."""
        return bool(self._argument(path))

    def resolve(self, path: tuple[str, ...]) -> tuple[str, Span | None, str]:
        """Return the key as its author wrote it, its place in the file, and its argument of the command line.

        A key that is taken over from a common table is found there. A table that is in no file, but in which an
        argument gave something, has the place of that argument; any other key that of its nearest parent.
        """
        table = self.common.get(path[0]) if len(path) > 2 else None
        common = (table, *path[2:]) if table else None
        for candidate in (path, common):
            if candidate and (argument := self._argument(candidate)):
                return ".".join(candidate), None, argument
            if candidate and (span := self._exact(candidate)):
                return ".".join(candidate), span, ""
        for candidate in (path, common):
            if candidate and (argument := self._argument_below(candidate)):
                return ".".join(path), None, argument
        for length in range(len(path) - 1, 0, -1):
            for candidate in (path[:length], common[: length - 1] if common and length >= 2 else None):
                if candidate and (span := self._exact(candidate)):
                    return ".".join(path), span, ""
        return ".".join(path), None, ""

    def texts(self) -> list[dict[str, str]]:
        """Return name and text of the scenario's file and of those it extends, as they were read."""
        top = {"file": Path(self.source.name).name, "text": self.source.text}
        return [top, *(self.base.texts() if self.base else ())]

    def did_you_mean(self, key: str, known: Collection[str]) -> str:
        """Return a help that names the known key most like the last part of a key, or an empty string.

        An argument of the command line gets the whole key, as it is written there.
        """
        table, _, name = key.rpartition(".")
        near = closest(name, known)
        in_argument = any(f"{written}.".startswith(f"{key}.") for written in self.overrides)
        whole = f"{table}.{near}" if table and in_argument else near
        return f"did you mean '{whole}'?" if near else ""

    def diagnostic(self, code: str, key: str, message: str, *, facts: Sequence[str] = (), help: str = "") -> Diagnostic:
        """Return a diagnostic about a key; its message stays as given."""
        _, span, argument = self.resolve(tuple(split_key(key)))
        file = f"--set {argument}" if argument else self.source.name
        return Diagnostic(code, message, span=span, facts=tuple(facts), help=help, file=file)
