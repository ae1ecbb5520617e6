"""Turns of phrase that messages, help, docs and comments do without."""

import ast
import io
import json
import re
import tokenize
from pathlib import Path

from tests import habits
from tests.own_files import own_files

ROOT = Path(__file__).parent.parent

#: Each turn with what says it better. A turn may be broken over two lines.
TURNS = {
    r"\b(is|are|was|were) due\b": "expected",
    r"\bnobody\b": "no one, or the passive",
    r"\bso many\b": "the number",
    r"\btold\b(?! apart\b)": "reported",
    r"\bmend(s|ed|ing)?\b": "fix",
    r"\bof which\b": "a sentence of its own",
}
PATTERN = re.compile("|".join(TURNS).replace(" ", r"\s+"), flags=re.IGNORECASE)
#: CHANGELOG.md is history: it keeps its words.
PAGES = sorted(
    [
        *(ROOT / "docs").rglob("*.md"),
        *own_files(ROOT / "apps", "*.md"),
        *(ROOT / name for name in ("README.md", "CONTRIBUTING.md")),
    ]
)
TESTS = [path for path in (ROOT / "tests").rglob("*.py") if path.name not in (Path(__file__).name, "habits.py")]
SOURCES = sorted([*(ROOT / "fuzzyctl").rglob("*.py"), *own_files(ROOT / "apps", "*.py"), *TESTS])


def found(text, line=1):
    """Return each turn in a text with its line."""
    return [f"{line + text.count(chr(10), 0, match.start())}: {match[0]}" for match in PATTERN.finditer(text)]


def texts(path):
    """Yield the texts of a module with their lines: strings (diagnostics, help), docstrings and comments."""
    source = path.read_text(encoding="utf-8")
    if PATTERN.search(source) is None:  # not in code either: parsing takes seconds
        return
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, node.value
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string


def test_pages_are_plain():
    assert [(p, turn) for p in PAGES for turn in found(p.read_text(encoding="utf-8"))] == []


def test_the_texts_of_modules_are_plain():
    assert [(p, turn) for p in SOURCES for line, text in texts(p) for turn in found(text, line)] == []


def test_turns_are_found():
    assert found("A name is due here;\nnobody was told so\nmany things, two of which you mend, or mend those.") == [
        "1: is due",
        "2: nobody",
        "2: told",
        "2: so\nmany",
        "3: of which",
        "3: mend",
        "3: mend",
    ]


def test_what_is_told_apart_is_plain():
    assert found("Two terms are told apart by their names.") == []


def test_counts_of_habits_only_fall():
    assert habits.risen(habits.counts(), json.loads(habits.STORED.read_text(encoding="utf-8"))) == []


def test_a_habit_is_found(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("An axis that nothing names is none.\n```\nIt is none.\n```\n", encoding="utf-8")
    assert [habit for habit, _, _ in habits.places(page)] == ["nothing-subject", "is-none"]
    code = tmp_path / "code.py"
    code.write_text('def f():\n    """Return what is said."""\n    found = 1\n', encoding="utf-8")
    assert [(habit, line) for habit, line, _ in habits.places(code)] == [
        ("what-clause", 2),
        ("said-told-due", 2),
        ("participle", 1),
    ]


def test_a_count_that_rises_is_found():
    assert habits.risen({"docs": {"own": 3}}, {"docs": {"own": 2}}) == [("docs", "own", 2, 3)]
    assert habits.risen({"docs": {"own": 2}}, {"docs": {"own": 2, "stands": 1}}) == []
