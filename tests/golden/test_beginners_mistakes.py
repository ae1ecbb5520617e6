"""Mistakes of beginners and of those who come from other tools: each is reported at once, with the repaired line.

Each block of `beginners_mistakes.txt` changes lines of `beginners_mistakes.fz`: `-` is a line of it, `+` what stands in
its place, `|` what is printed. After an intended change of wording: FUZZYCTL_UPDATE_GOLDEN=1 python -m pytest
tests/golden, then read the difference.
"""

import os
import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from fuzzyctl.testing import check_text

FOLDER = Path(__file__).parent
TABLE = FOLDER / "beginners_mistakes.txt"
BASE = (FOLDER / "beginners_mistakes.fz").read_text(encoding="utf-8")


@dataclass(frozen=True)
class Case:
    """A mistake: the lines of the base text, what stands in their place, and what is printed."""

    title: str
    right: tuple[str, ...]
    wrong: tuple[str, ...]
    printed: str

    @cached_property
    def lines(self):
        """The numbers of the lines, from 0."""
        lines = [line.strip() for line in BASE.split("\n")]
        return [lines.index(line.strip()) for line in self.right]

    @cached_property
    def text(self):
        """The base text with the mistake."""
        return replaced(dict(zip(self.lines, self.wrong, strict=True)))

    @cached_property
    def diagnostics(self):
        """What is reported of it."""
        return check_text(self.text, "tip.fz")[1]

    @property
    def block(self):
        """The block as it is now."""
        printed = "\n".join(f"| {line}".rstrip() for line in "\n\n".join(map(str, self.diagnostics)).split("\n"))
        return "\n".join(
            [f"=== {self.title}", *(f"- {r}" for r in self.right), *(f"+ {w}" for w in self.wrong), printed]
        )


def replaced(lines):
    """Return the base text with other lines, by their numbers from 0; indented as they were."""
    texts = BASE.split("\n")
    for k, line in lines.items():
        indent = texts[k][: len(texts[k]) - len(texts[k].lstrip())]
        texts[k] = "\n".join(indent + part.lstrip() for part in line.split("\n"))
    return "\n".join(texts)


def _cases():
    found = []
    for block in TABLE.read_text(encoding="utf-8").split("=== ")[1:]:
        title, *lines = block.rstrip("\n").split("\n")
        right = tuple(line[2:] for line in lines if line.startswith("- "))
        wrong = tuple(line[2:] for line in lines if line.startswith("+ "))
        found.append(Case(title, right, wrong, "\n".join(line[2:] for line in lines if line.startswith("|"))))
    return found


CASES = _cases()


def errors(case):
    """The errors of a case."""
    return [d for d in case.diagnostics if d.severity == "error"]


def test_the_base_has_no_mistake():
    assert check_text(BASE)[1] == []


def test_there_are_a_hundred_of_them_and_no_two_alike():
    assert len({c.wrong for c in CASES}) == len(CASES) >= 100


def test_they_are_as_in_the_table():
    now = "\n\n".join(c.block for c in CASES) + "\n"
    if os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
        TABLE.write_text(now, encoding="utf-8", newline="\n")
    assert now == TABLE.read_text(encoding="utf-8")


def test_each_line_is_reported_once():
    reported = {c.title: [d.span.line - 1 for d in errors(c)] for c in CASES}
    assert reported == {c.title: c.lines for c in CASES}


def repaired(case):
    """The base text with the lines that the help of each error gives."""
    lines = {}
    for d in errors(case):
        found = re.fullmatch(r"(?:write: (?P<line>.*)|write \d lines:\n(?P<lines>(?:.*\n?)+)|remove the line)", d.help)
        assert found, (case.title, d.help)
        lines[d.span.line - 1] = found["line"] or found["lines"] or ""
    return replaced(lines)


def test_the_repaired_line_leaves_no_error():
    # Many a repaired text is the base itself.
    titles = {repaired(c): c.title for c in CASES}
    left = {title: check_text(text, "tip.fz")[1] for text, title in titles.items()}
    assert {title: d.message for title, found in left.items() for d in found if d.severity == "error"} == {}


def test_all_mistakes_of_a_file_are_reported_at_once():
    """One mistake a line, as far as no two are of one line, in one file."""
    taken, wrong = set(), {}
    for case in CASES:
        if not taken & set(case.lines) and "\n" not in "".join(case.wrong):
            wrong |= dict(zip(case.lines, case.wrong, strict=True))
            taken |= set(case.lines)
    _, diagnostics = check_text(replaced(wrong), "tip.fz")
    assert sorted({d.span.line - 1 for d in diagnostics if d.severity == "error"}) == sorted(wrong)
