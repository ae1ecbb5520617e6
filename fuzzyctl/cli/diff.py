"""`fuzzyctl diff`: what was changed between two rule files, in terms, rules and cells."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fuzzyctl.cli.common import DONE, FAILED, FORMAT, SYSTEM, answers_with_diagnostics, source_of
from fuzzyctl.cli.streams import say, write_json
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from fuzzyctl.comparison.changes import Change
    from fuzzyctl.diagnostics.source import SourceText
    from fuzzyctl.model.system import FuzzySystem

#: How a change begins its line.
MARKS = {"added": "+", "removed": "-", "changed": "~", "renamed": "~", "rewritten": "="}


@click.command()
@click.argument("first")
@click.argument("second")
@FORMAT
@SYSTEM
@answers_with_diagnostics
def diff(first: str, second: str, form: str, name: str | None) -> int:
    """Show what was changed from one rule file to another.

    \b
    fuzzyctl diff old.fz new.fz
    git show HEAD:tip.fz | fuzzyctl diff - tip.fz
    fuzzyctl diff tipper.fis tipper.fll

    Settings, params, terms, rules, cells of tables, guarantees, and the diagnostics that a file allows or denies are
    compared, not lines of text: layout, comments and the order of the parts of a rule do not count, and a term that was
    renamed is no other term. Systems of the same name are compared where files hold several. '=' marks what is written
    in another way and has the same value.

    Exit code: 0 where nothing was changed, 1 where something was.
    """
    sources = source_of(first), source_of(second)
    pairs = _pairs(*sources, name)
    from fuzzyctl.comparison.changes import changes
    from fuzzyctl.comparison.policy import policy_changes

    said = policy_changes(*sources)
    found = [(a.name, changes(a, b)) for a, b in pairs]
    if form == "json":
        systems = [_data(name, own) for name, own in found]
        data = {"first": first, "second": second, "changes": [dataclasses.asdict(c) for c in said], "systems": systems}
        write_json(data)
    else:
        for change in said:
            say(_line(change))
        for name, own in found:
            if len(found) > 1 and own:
                say(f"system {name}")
            for change in own:
                say(_line(change))
        if not said and not any(own for _, own in found):
            say("nothing was changed")
    return FAILED if said or any(own for _, own in found) else DONE


def _pairs(first: SourceText, second: SourceText, name: str | None) -> list[tuple[FuzzySystem, FuzzySystem]]:
    """Load both files and pair their systems: by name, or the only ones.

    Raises:
        DiagnosticError: With the errors of both files, or where systems have no partner.
    """
    (own, mistakes), (other, more) = (_systems(source, name) for source in (first, second))
    if mistakes or more:
        raise DiagnosticError([*mistakes, *more])
    if len(own) == len(other) == 1:
        return [(own[0], other[0])]
    by_name = {s.name: s for s in other}
    lonely = [
        Diagnostic("FZ502", f"system '{s.name}' is in one of the files only", file=file, help="name one: --system")
        for file, systems, names in ((first.name, own, set(by_name)), (second.name, other, {s.name for s in own}))
        for s in systems
        if s.name not in names
    ]
    if lonely:
        raise DiagnosticError(lonely)
    return [(s, by_name[s.name]) for s in own]


def _systems(source: SourceText, name: str | None) -> tuple[tuple[FuzzySystem, ...], list[Diagnostic]]:
    """Return the systems of a file, or the one named, and the errors of the file."""
    from fuzzyctl.loading.load import choose, examine_all

    systems, found = examine_all(source, folder=Path(source.name).parent, hints=False)
    if name is not None:
        chosen, found = choose(source, systems, found, name)
        systems = (chosen,) if chosen is not None else ()
    return systems, [d for d in found if d.severity == "error"]


def _data(name: str, changes: Sequence[Change]) -> dict[str, Any]:
    return {"system": name, "changes": [dataclasses.asdict(c) for c in changes]}


def _line(change: Change) -> str:
    """Return a change on one line, with the lines of both files where it stands."""
    lines = [f"{sign}{line}" for sign, line in (("-", change.before_line), ("+", change.after_line)) if line]
    name = f" {change.name}" if change.name else ""
    texts = " → ".join(t for t in (change.before, change.after) if t is not None)
    place = f"   (lines {' '.join(lines)})" if lines else ""
    return f"{MARKS[change.kind]} {change.what}{name}: {texts}{place}"
