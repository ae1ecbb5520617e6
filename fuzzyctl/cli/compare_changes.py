"""`fuzzyctl compare --changes`: what was changed between two rule files, in terms, rules and cells."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from fuzzyctl.cli.common import DONE, FAILED
from fuzzyctl.cli.loading import Choice, Opened, open_blocks
from fuzzyctl.cli.streams import say, write_json
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from fuzzyctl.comparison.changes import Change
    from fuzzyctl.model.system import FuzzySystem

#: How a change begins its line.
MARKS = {"added": "+", "removed": "-", "changed": "~", "renamed": "~", "rewritten": "="}


def print_changes(first: str, second: str, name: str | None, form: str) -> int:
    """Print what was changed from one file to another, and return the exit code: 1 if something was.

    Args:
        first: A file.
        second: Another one.
        name: The block of both; None for all, paired by name.
        form: "text" or "json".
    """
    before, after = _opened(first, second, name)
    pairs = _pairs(before, after)
    from fuzzyctl.comparison.changes import changes
    from fuzzyctl.comparison.policy import policy_changes

    said = policy_changes(before.file.policy, after.file.policy)
    found = [(a.name, changes(a, b)) for a, b in pairs]
    others: list[tuple[str, tuple[Change, ...]]] = []
    has_others = any(b.kind != "system" for b in (*before.blocks, *after.blocks))
    if has_others:
        from fuzzyctl.comparison.block_changes import block_changes
        from fuzzyctl.model.controller import EquationBlock

        others = block_changes(before.of(EquationBlock), after.of(EquationBlock))
    if form == "json":
        systems = [_data(name, own) for name, own in found]
        data: dict[str, Any] = {
            "first": first,
            "second": second,
            "changes": [dataclasses.asdict(c) for c in said],
            "systems": systems,
        }
        if has_others:
            data["blocks"] = [{"block": name, "changes": [dataclasses.asdict(c) for c in own]} for name, own in others]
        write_json(data)
    else:
        for change in said:
            say(_line(change))
        for name, own in found:
            if len(found) > 1 and own:
                say(f"system {name}")
            for change in own:
                say(_line(change))
        for name, own in others:
            say(name)
            for change in own:
                say(_line(change))
        if not said and not others and not any(own for _, own in found):
            say("nothing was changed")
    return FAILED if said or others or any(own for _, own in found) else DONE


def _opened(first: str, second: str, name: str | None) -> tuple[Opened, Opened]:
    """Open both files.

    Raises:
        DiagnosticError: With the errors of both.
    """
    opened: list[Opened] = []
    mistakes: list[Diagnostic] = []
    for file in (first, second):
        try:
            opened.append(open_blocks(file, Choice(name=name), hints=False))
        except DiagnosticError as error:
            mistakes.extend(error.diagnostics)
    if mistakes:
        raise DiagnosticError(mistakes)
    return opened[0], opened[1]


def _pairs(first: Opened, second: Opened) -> list[tuple[FuzzySystem, FuzzySystem]]:
    """Pair the systems of two files: by name, or the only ones.

    Raises:
        DiagnosticError: Where systems have no partner.
    """
    from fuzzyctl.model.system import FuzzySystem

    ones, others = first.of(FuzzySystem), second.of(FuzzySystem)
    if len(ones) == len(others) == 1:
        return [(ones[0], others[0])]
    lonely = [
        Diagnostic("FZ502", message, file=one.file.source.name, help="name one: --block")
        for one, mine, theirs in ((first, ones, others), (second, others, ones))
        for s in mine
        if s.name not in {o.name for o in theirs}
        for message in (f"system '{s.name}' is in one of the files only",)
    ]
    if lonely:
        raise DiagnosticError(lonely)
    by_name = {s.name: s for s in others}
    return [(s, by_name[s.name]) for s in ones]


def _data(name: str, changes: Sequence[Change]) -> dict[str, Any]:
    return {"system": name, "changes": [dataclasses.asdict(c) for c in changes]}


def _line(change: Change) -> str:
    """Return a change on one line, with the lines of both files where it stands."""
    lines = [f"{sign}{line}" for sign, line in (("-", change.before_line), ("+", change.after_line)) if line]
    name = f" {change.name}" if change.name else ""
    texts = " → ".join(t for t in (change.before, change.after) if t is not None)
    place = f"   (lines {' '.join(lines)})" if lines else ""
    return f"{MARKS[change.kind]} {change.what}{name}: {texts}{place}"
