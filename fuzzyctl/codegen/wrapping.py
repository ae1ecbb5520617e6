"""Wrapping of generated lines: code at operators, comments at spaces."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

#: About how long lines of generated text are at most.
WIDTH: Final = 120
#: Where a line break in an expression is allowed: before these.
_BREAKS: Final = frozenset({"?", ":", "+", "-", "*", "/", "&&", "||", "AND", "OR"})


def broken(lines: Iterable[str], further: str, width: int = WIDTH) -> Iterator[str]:
    """Yield lines of code, long ones broken at operators where they nest least; directives and comments stay whole.

    Args:
        lines: Lines of C or Structured Text, none with a string in it.
        further: What continued lines are indented by.
        width: Where to break.
    """
    for text in lines:
        for line in text.split("\n"):
            if len(line) <= width or line.lstrip().startswith(("#", "//", "(*")):
                yield line
            else:
                yield from _parts(line, further, width)


def _parts(line: str, further: str, width: int) -> Iterator[str]:
    indent = pad = line[: len(line) - len(line.lstrip())]
    level = 0
    while len(line) > width:
        split = _place(line, len(indent) + 1, width)
        if split is None:
            break
        place, deeper = split
        yield line[:place].rstrip()
        level += deeper
        indent = pad + further * (1 + level)
        line = indent + line[place:].lstrip()
    yield line


def _place(line: str, first: int, width: int) -> tuple[int, int] | None:
    """Return where to break a line, the last place of those that nest least, and how deep that is."""
    depth, best = 0, None
    for k, character in enumerate(line[: width + 1]):
        depth += (character in "([{") - (character in ")]}")
        if character != " " or k <= first:
            continue
        word = line[k + 1 :].split(" ", 1)[0]
        if (word in _BREAKS or line[k - 1] == ",") and (best is None or depth <= best[1]):
            best = k, depth
    return best


def folded(lines: Sequence[str], width: int = WIDTH - 6) -> Iterator[str]:
    """Yield lines of a comment, long ones broken at spaces and indented."""
    for text in lines:
        line = text
        pad = line[: len(line) - len(line.lstrip())] + "  "
        while len(line) > width and (place := line.rfind(" ", len(pad) + 1, width + 1)) > 0:
            yield line[:place].rstrip()
            line = pad + line[place:].lstrip()
        yield line
