from itertools import pairwise

from fuzzyctl.editor.navigation import folds, links, outline, selections
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM, marked


def test_blocks_hold_variables_and_these_their_terms():
    (system,) = outline(marked(SYSTEM, "tip")[0])
    assert [e.symbol.name for e in system.inside] == ["most", "hardly", "service", "food", "tip"]
    assert [e.symbol.name for e in system.inside[2].inside] == ["poor", "good"]
    blocks = outline(marked(LOOP, "law")[0])
    assert [(e.symbol.kind, e.symbol.name) for e in blocks] == [
        ("system", "surface"),
        ("controller", "law"),
        ("plant", "lag"),
        ("loop", "closed"),
    ]


def test_a_file_without_a_head_has_its_variables():
    document, _ = marked("input x in [0, 1]\n  terms a b\n", "x")
    assert [e.symbol.name for e in outline(document)] == ["x"]


def test_folds():
    assert list(folds(marked(SYSTEM, "tip")[0])) == [(1, 19), (6, 8), (9, 10), (11, 12), (14, 17)]
    assert list(folds(marked(LOOP, "law")[0]))[:4] == [(1, 9), (11, 19), (21, 26), (28, 33)]
    assert list(folds(marked("§")[0])) == []


def test_selections_grow():
    found = selections(*marked(SYSTEM, "oor = ramp"))
    assert [s.text.split("\n")[0] for s in found] == [
        "poor",
        "poor = ramp(10, 0)",
        "  poor = ramp(10, 0)",
        "input service in [0, 10]",
        'system tip "Tip for a meal"',
        'system tip "Tip for a meal"',
    ]
    assert all(a.start >= b.start and a.end <= b.end for a, b in pairwise(found))


def test_links():
    document, _ = marked('use "a.fz"\ntable u = x x y from "b.csv"§\n')
    assert [(span.text, name) for span, name in links(document)] == [('"a.fz"', "a.fz"), ('"b.csv"', "b.csv")]
