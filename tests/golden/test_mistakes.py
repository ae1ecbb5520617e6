"""Mistakes in rule files: in mistakes/SUBJECT.txt texts, changes of them, and all that `check` reports of each.

`==== TITLE` begins a text, in which a line `…` is the place of added lines; without it they follow at the end. Behind
the title `| errors` leaves out warnings and hints, and `| file PATH` takes the text of a file. Each block below it is a
case: `-` is a part of the text and `+` its replacement, `>` an added line, `@ NAME` a file beside it, `|` a diagnostic
as LINE:COLUMN CODE [text at this location] message, then its facts, notes, help and fix. `⏎` is a line end, `␍` a
carriage return, `⇥` a tab, `␣` a space at an end. A case without changes shows the text itself.

After an intended change: FUZZYCTL_UPDATE_GOLDEN=1 python -m pytest tests/golden, then read the difference.
"""

import os
import re
from pathlib import Path

import pytest

from fuzzyctl.testing import check_text

FOLDER = Path(__file__).parent / "mistakes"
SIGNS = {"\n": "⏎", "\r": "␍", "\t": "⇥"}
HEAD = re.compile(r"^==== (?P<title>.*?)(?P<errors> \| errors)?(?: \| file (?P<file>.*))?$")


def plain(shown):
    """Return the text that signs of white space stand for."""
    for text, sign in SIGNS.items():
        shown = shown.replace(sign, text)
    return shown.replace("␣", " ")


def line(text):
    """Return a text as one line."""
    for sign in SIGNS:
        text = text.replace(sign, SIGNS[sign])
    return re.sub(r"^ | $", "␣", text)


def answers(diagnostics, name):
    """Yield the lines of some diagnostics."""
    for d in diagnostics:
        place = ""
        if d.span is not None:
            file = "" if d.span.source.name == name else f"{Path(d.span.source.name).name}:"
            place = f"{file}{d.span.line}:{d.span.column} "
        severity = "" if d.severity == "error" else f" {d.severity}"
        yield f"{place}{d.code}{severity} [{line(d.span.text[:40]) if d.span else ''}] {d.message}"
        yield from (f"  = {fact}" for fact in d.facts)
        yield from (f"  = {n.message} ({Path(n.span.source.name).name}:{n.span.line}:{n.span.column})" for n in d.notes)
        if d.help:
            yield f"  = help: {line(d.help)}"
        if d.fix is not None:
            edits = ", ".join(f"[{line(r.span.text)}] → [{line(r.text)}]" for r in d.fix.replacements)
            yield f"  = {d.fix.applicability}: {edits}"


def changed(text, changes):
    """Return a text with the changes of a case, and the files beside it."""
    files, added, old = {}, "", None
    for change in changes:
        kind, rest = change[0], plain(change[2:])
        if kind == "-":
            old = rest
        elif kind == "+":
            assert old in text, old
            text = text.replace(old, rest, 1)
        elif kind == ">":
            added += f"{rest}\n"
        else:
            name, _, files_text = rest.partition(" ")
            files[name] = files_text
    return text.replace("…\n", added, 1) if "…\n" in text else text + added, files


def written(path, folder):
    """Return the file of a subject with the diagnostics as they are now."""
    parts = []
    for section in re.split(r"^(?===== )", path.read_text(encoding="utf-8"), flags=re.M)[1:]:
        head, *cases = section.rstrip("\n").split("\n\n")
        title, *text = head.split("\n")
        options = HEAD.match(title)
        text = "".join(f"{row}\n" for row in text)
        if options["file"]:
            text = (path.parent / options["file"]).read_text(encoding="utf-8")
        parts.append(head)
        for number, case in enumerate(cases):
            changes = [row for row in case.split("\n") if not row.startswith("|")]
            checked, files = changed(text, changes)
            place = folder / f"{len(parts)}-{number}"
            place.mkdir()
            for name, beside in files.items():
                (place / name).write_text(beside, encoding="utf-8", newline="")
            name = Path(options["file"]).name if options["file"] else "t.fz"
            found = check_text(checked, name, folder=place if files else None)[1]
            found = [d for d in found if d.severity == "error" or not options["errors"]]
            rows = [*answers(found, name)] or ["nothing"]
            parts.append("\n".join([*changes, *(f"| {row}" for row in rows)]))
    return "\n\n".join(parts).replace(str(folder), "FOLDER") + "\n"


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.txt")), ids=lambda p: p.stem)
def test_each_is_reported_as_in_the_table(path, tmp_path):
    now = written(path, tmp_path)
    if os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
        path.write_text(now, encoding="utf-8", newline="\n")
    assert now == path.read_text(encoding="utf-8")
