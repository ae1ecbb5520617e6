"""Changes in the lines `allow` and `deny` of two rule files, which affect diagnostics and no number."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from fuzzyctl.comparison.changes import Change, Kind
from fuzzyctl.lang import syntax as sx


@dataclass(frozen=True)
class _Said:
    """What a file says of a code: with which word, why, and in which line."""

    word: str
    reason: str
    line: int

    def text(self, code: str) -> str:
        """Return it as a file says it of this code alone."""
        return f'{self.word} {code} "{self.reason}"' if self.reason else f"{self.word} {code}"


def policy_changes(first: Sequence[sx.Allow], second: Sequence[sx.Allow]) -> tuple[Change, ...]:
    """Return what differs in the codes that two rule files allow and deny, and in the reasons; one change a code.

    Where codes share a line, and in which order the lines stand, does not count. A code that is both allowed and denied
    is denied. Files of other tools have no such lines.
    """
    return tuple(_changes(_policy(first), _policy(second)))


def _changes(before: dict[str, _Said], after: dict[str, _Said]) -> Iterator[Change]:
    for code in dict.fromkeys([*before, *after]):
        one, other = before.get(code), after.get(code)
        if one is not None and other is not None and (one.word, one.reason) == (other.word, other.reason):
            continue
        texts = one.text(code) if one else None, other.text(code) if other else None
        lines = one.line if one else None, other.line if other else None
        kind: Kind = "added" if one is None else "removed" if other is None else "changed"
        yield Change(kind, "diagnostic", code, *texts, *lines)


def _policy(lines: Sequence[sx.Allow]) -> dict[str, _Said]:
    found: dict[str, _Said] = {}
    for line in lines:
        for code in line.codes:
            said = _Said(line.keyword.text, line.reason, line.span.line)
            if code.text not in found or said.word == "deny":
                found[code.text] = said
    return found
