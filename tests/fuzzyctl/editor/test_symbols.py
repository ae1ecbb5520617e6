import re

import pytest

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.editor.document import Document
from fuzzyctl.support.shipped import rules_folder
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM

FILES = sorted(rules_folder().rglob("*.fz"))


def symbols(text, kind=None):
    return [s for s in Document(SourceText("a.fz", text)).symbols.all if kind in (None, s.kind)]


def uses(text, name, kind):
    found = Document(SourceText("a.fz", text)).symbols
    (symbol,) = [s for s in found.all if (s.name, s.kind) == (name, kind)]
    return [(u.line, u.column) for u in found.uses_of(symbol)]


def test_declarations():
    found = [(s.kind, s.name, s.owner.name if s.owner else "") for s in symbols(SYSTEM)]
    assert found[:6] == [
        ("system", "tip", ""),
        ("param", "most", "tip"),
        ("hedge", "hardly", "tip"),
        ("input", "service", "tip"),
        ("term", "poor", "service"),
        ("term", "good", "service"),
    ]
    assert [s.label for s in symbols(SYSTEM) if s.label] == ["Tip for a meal", "Food"]


def test_terms_belong_to_their_variable():
    text = SYSTEM.replace("bad fine great", "poor fine great").replace("         bad ", "         poor")
    document = Document(SourceText("a.fz", text))
    terms = [s for s in document.symbols.all if s.kind == "term" and s.name == "poor"]
    assert [[u.line for u in document.symbols.uses_of(t)] for t in terms] == [[7, 16], [10, 15]]


@pytest.mark.parametrize(
    ("name", "kind", "places"),
    [
        ("law", "controller", [(11, 12), (29, 13)]),
        ("law", "block", [(29, 7), (30, 21)]),
        ("lag", "plant", [(21, 7), (30, 13)]),
        ("lag", "block", [(29, 20), (30, 7), (32, 19)]),
        ("surface", "system", [(1, 8), (18, 19)]),
        ("total", "state", [(15, 7), (17, 6), (17, 14), (18, 40)]),
        ("r", "let", [(29, 17), (31, 5), (32, 26)]),
        ("iae", "measure", [(32, 9)]),
    ],
)
def test_blocks_of_equations(name, kind, places):
    assert uses(LOOP, name, kind) == places


def test_arguments_by_name_and_members_belong_to_the_block_called():
    document = Document(SourceText("a.fz", LOOP))
    plant = {s.name: s for s in document.symbols.all if s.owner is not None and s.owner.name == "lag"}
    assert [(u.line, u.column) for u in document.symbols.uses_of(plant["u"])] == [(22, 7), (25, 10), (30, 17)]
    assert [(u.line, u.column) for u in document.symbols.uses_of(plant["y"])] == [(26, 8), (29, 24), (32, 23)]


def test_parameters_of_functions_are_no_names_of_the_block():
    text = SYSTEM.replace("hedge hardly(d) = d ^ 3", "param d = 1\nhedge hardly(d) = d ^ 3")
    assert uses(text, "d", "param") == [(4, 7)]


def test_terms_of_another_variable():
    text = SYSTEM.replace("input food", "input mood in [0, 1]\n  terms of service\ninput food")
    text = text.replace("terms of service", "").replace("mood in [0, 1]", "mood in [0, 10] terms of service")
    text += "if mood is poor then tip is small\n"
    assert (9, 32) in uses(text, "service", "input")
    assert (22, 12) in uses(text, "poor", "term")


def test_a_broken_line_hides_no_other_name():
    text = SYSTEM.replace("param most = 20", "param most = 20\nparam broken = = (\n")
    assert [s.name for s in symbols(text, "input")] == ["service", "food"]


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_every_name_of_the_shipped_files_is_found_at_its_text(path):
    source = SourceText(str(path), path.read_text(encoding="utf-8"))
    found = Document(source, path.parent).symbols
    assert all(span.text == symbol.name for span, symbol in found.uses)
    names, covered = {s.name for s in found.all}, {span.start for span, _ in found.uses}
    offset = 0
    for line in source.text.split("\n"):
        code = re.sub(r'"[^"]*"', lambda m: " " * len(m[0]), line.split("#")[0])
        for m in re.finditer(r"\w+", code):
            # `x` crosses the inputs of a table, measures have names of functions, and arguments by name and members
            # may be those of a block in another file.
            crosses = m[0] == "x" and line.startswith("table")
            by_name = re.match(r"=\w", code[m.end() :]) is not None
            by_name = by_name or code[: m.start()].endswith(".")
            known = m[0] in names and not crosses and not by_name and code[m.end() :][:1] != "("
            assert not known or offset + m.start() in covered, line
        offset += len(line) + 1
