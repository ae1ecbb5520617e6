import pytest

from fuzzyctl.diagnostics.fixes import Fix, fixed
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.editor import navigation
from fuzzyctl.editor.document import Document
from fuzzyctl.editor.navigation import RenameError, definition, references, rename
from fuzzyctl.lang.formatter import format_source
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM, marked


def renamed(text, at, name, before=""):
    document, offset = marked(text, at, before)
    return fixed(document.source, [Fix(tuple(rename(document, offset, name)), "sure")])


@pytest.mark.parametrize(
    ("text", "at", "before", "line"),
    [
        (SYSTEM, "poor |", "", 7),
        (SYSTEM, "fine", "table", 10),
        (SYSTEM, "small  large", "", 12),
        (SYSTEM, "service x", "", 6),
        (SYSTEM, "tip >=", "", 11),
        (SYSTEM, "most]", "", 3),
        (LOOP, "surface(e", "", 1),
        (LOOP, "y)\nblock", "", 26),
        (LOOP, "u = law", "block lag", 22),
        (LOOP, "level + error", "", 15),
    ],
)
def test_definition(text, at, before, line):
    document, offset = marked(text, at, before)
    assert definition(document, offset).line == line


def test_no_name_has_none():
    document, offset = marked(SYSTEM, "else 0")
    assert definition(document, offset) is None
    assert references(document, offset) == []


def test_references_without_the_declaration():
    document, offset = marked(SYSTEM, "good |")
    assert [s.line for s in references(document, offset)] == [8, 17]
    assert [s.line for s in references(document, offset, declaration=False)] == [17]


def test_a_term_is_renamed_everywhere_and_columns_stay_aligned():
    text = format_source(SourceText("a.fz", SYSTEM))
    after = renamed(text, "small=0", "very_small")
    assert after == format_source(SourceText("a.fz", text.replace("small", "very_small")))
    assert "  poor |  very_small  very_small  large\n" in after


def test_a_file_of_another_layout_keeps_it():
    text = SYSTEM.replace("  poor | small  small  large", " poor |small small   large")
    assert " poor |tiny tiny   large\n" in renamed(text, "small=0", "tiny")


def test_names_of_other_blocks_stay():
    after = renamed(LOOP, "u\nparam T", "force")
    assert "input force\nparam T = 1" in after
    assert "der x = (force - x) / T" in after
    assert "block lag = lag(force = law.u)" in after
    assert "output u = gain" in after


@pytest.mark.parametrize("name", ["", "two words", "3", "and", "not", "a" * 201, "a-b"])
def test_what_is_no_name(name):
    with pytest.raises(RenameError, match="cannot be a name"):
        renamed(SYSTEM, "service", name, "input")


def test_a_name_that_is_taken_or_missing():
    with pytest.raises(RenameError, match="'food' is declared already in line 9"):
        renamed(SYSTEM, "service", "food", "input")
    with pytest.raises(RenameError, match="'good' is declared already in line 8"):
        renamed(SYSTEM, "poor", "good")
    with pytest.raises(RenameError, match="no name here"):
        renamed(SYSTEM, "else", "food")
    # Terms of another variable have names of their own.
    assert "  terms poor fine great" in renamed(SYSTEM, "bad", "poor")


#: A text, a name in it, its new name, and the line where that has another meaning.
MIXED_UP = [
    # The param of the block hides the one above all blocks.
    ("param k = 1\ncontroller c\ninput x\nparam m = 2\noutput y = k * x\n", "k", "m", 4),
    ("param m = 1\ncontroller c\ninput x\nparam k = 2\noutput y = k * x + m\n", "k", "m", 1),
    # A name that stands for nothing yet.
    ("param k = 1\ncontroller c\ninput x\noutput y = k * x + m\n", "k", "m", 4),
    # A term that another variable takes over beside its own.
    (
        "input a in [0, 1]\n  terms N P\ninput b in [0, 1] terms of a\n  Z = ramp(0, 1)\n"
        "output y in [0, 1] else 0\n  terms N P\nif b is N and b is Z then y is P\n",
        "N P",
        "Z",
        7,
    ),
]


@pytest.mark.parametrize(("text", "at", "name", "line"), MIXED_UP)
def test_a_name_with_another_meaning(text, at, name, line):
    with pytest.raises(RenameError, match=f"'{name}' .* line {line}$"):
        renamed(text, at, name)


@pytest.mark.parametrize(
    ("at", "name", "place"),
    [("k = 1", "m", "line 4 of b.fz"), ("N P", "Z", "line 10 of b.fz"), ("k = 1", "free", "line 7 of b.fz")],
)
def test_a_name_with_another_meaning_in_a_file_that_uses_this_one(tmp_path, at, name, place):
    (tmp_path / "a.fz").write_text("param k = 1\ninput e in [-1, 1]\n  terms N P\n")
    (tmp_path / "b.fz").write_text(
        'use "a.fz"\nsystem s\ninput q in [0, 1] terms of e\n  Z = ramp(0, k)\nparam m = 2\n'
        "output y in [0, 1] else 0\n  low = constant(k + m + free)\n  high = constant(1)\n"
        "if e is N then y is low\nif q is N and q is Z then y is high\n"
    )
    first, second = (Document(SourceText(str(p), p.read_text()), tmp_path) for p in sorted(tmp_path.glob("*.fz")))
    with pytest.raises(RenameError, match=f"'{name}' .* {place}"):
        rename(first, first.text.index(at), name, [first, second])
    changed = rename(first, first.text.index(at), "other", [first, second])
    assert {r.span.source.name for r in changed} == {str(tmp_path / "a.fz"), str(tmp_path / "b.fz")}


@pytest.mark.parametrize(("at", "name"), [("service", "min"), ("service", "bounded"), ("tip", "floor")])
def test_functions_are_no_names_of_variables(at, name):
    with pytest.raises(RenameError, match=f"'{name}' is a function of the language"):
        renamed(SYSTEM, at, name, "output" if at == "tip" else "input")
    # Nothing is mixed up with a term.
    assert f"\n  {name} |" in renamed(SYSTEM, "poor", name).replace("  |", " |")


def test_the_same_name_changes_nothing():
    assert renamed(SYSTEM, "service", "service", "input") == SYSTEM


def test_used_files(tmp_path):
    (tmp_path / "shared.fz").write_text("input service in [0, 10]\n  terms poor good\n")
    text = 'use "shared.fz"\noutput tip in [0, 1]\n  terms small=0 large=1\nif service is poor then tip is small\n'
    path = tmp_path / "a.fz"
    document = Document(SourceText(str(path), text), tmp_path)
    found = definition(document, text.index("poor"))
    assert (found.source.name, found.line) == (str(tmp_path / "shared.fz"), 2)
    changed = rename(document, text.index("poor"), "bad")
    assert {r.span.source.name for r in changed} == {str(path), str(tmp_path / "shared.fz")}


PARTS = """input e in [-1, 1]
  terms N P
system rule "The rule"
output u in [-1, 1]
  terms N P
table u = e
     N  P
  |  N  P
controller law
input r
param k = 2
output v = k * rule(r)
plant lag = tf(num=[1], den=[1, 1])
"""
TOP = """use "parts.fz"
controller top
input x
block a = law(x, k=3)
output z = a.v + rule(e=x)
loop closed
block b = top(lag.y)
block lag = lag(u=b.z)
run 1 s
"""


@pytest.fixture
def top(tmp_path):
    (tmp_path / "parts.fz").write_text(PARTS)
    return Document(SourceText(str(tmp_path / "a.fz"), TOP), tmp_path)


@pytest.mark.parametrize(
    ("at", "line", "uses"),
    [
        ("law(x", 9, [4, 9]),
        ("k=3", 11, [4, 11, 12]),
        ("v + rule", 12, [5, 12]),
        ("rule(e", 3, [5, 3, 12]),
        ("e=x", 1, [5, 1, 6]),
        ("lag(u", 13, [8, 13]),
    ],
)
def test_blocks_of_used_files_are_found(top, at, line, uses):
    offset = TOP.index(at)
    found = definition(top, offset)
    assert (found.source.name, found.line) == (str(top.folder / "parts.fz"), line)
    assert [s.line for s in references(top, offset)] == uses
    assert top.mistakes == []


def test_a_block_is_renamed_in_the_file_that_declares_it(top):
    changes = rename(top, TOP.index("law(x"), "lawful")
    assert {c.span.source.name for c in changes} == {str(top.folder / n) for n in ("a.fz", "parts.fz")}
    for name, text in (("parts.fz", PARTS), ("a.fz", TOP)):
        path = top.folder / name
        own = tuple(c for c in changes if c.span.source.name == str(path))
        path.write_text(fixed(SourceText(str(path), text), [Fix(own, "sure")]))
    after = Document(SourceText(str(top.folder / "a.fz"), (top.folder / "a.fz").read_text()), top.folder)
    assert after.mistakes == []
    assert "lawful" in {head.name for _, head in after.symbols.blocks()}


def test_a_used_file_outside_of_the_folder_is_not_read(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "parts.fz").write_text(PARTS)
    (tmp_path / "sub" / "link.fz").symlink_to(tmp_path / "parts.fz")
    for name in ("../parts.fz", str(tmp_path / "parts.fz"), "link.fz"):
        text = TOP.replace("parts.fz", name)
        document = Document(SourceText(str(tmp_path / "sub" / "a.fz"), text), tmp_path / "sub")
        assert definition(document, text.index("law(x")) is None


def test_files_that_use_a_name_are_among_its_uses(top):
    """Also where the text on the screen has moved on from the file that the others read."""
    parts = Document(SourceText(str(top.folder / "parts.fz"), "# new\n" + PARTS), top.folder)
    offset = parts.text.index("controller law") + len("controller ")
    assert [(s.source is top.source, s.line) for s in references(parts, offset, others=[parts, top])] == [
        (False, 10),
        (True, 4),
    ]
    term = parts.text.index("N P")
    assert [s.line for s in references(parts, term, others=[top])] == [3, 8]
    changes = rename(parts, offset, "lawful", [parts, top])
    assert [(c.span.source is top.source, c.text) for c in changes] == [(False, "controller lawful"), (True, "lawful")]
    alone = Document(SourceText(str(top.folder / "alone.fz"), "controller law\ninput x\noutput y = x\n"), top.folder)
    assert len(references(parts, offset, others=[alone])) == 1


#: Two systems and a loop, whose parts have names in common, with a name that none of them has declared.
BLOCKS = "param T = 2\n" + LOOP + SYSTEM.replace("tip >= 0", "tip >= missing")


def verdict(document, span, name):
    try:
        return rename(document, span.start, name)
    except RenameError as error:
        return str(error)


@pytest.mark.parametrize("name", ["fresh", "missing", "error", "food", "T"])
def test_blocks_without_a_change_or_the_new_name_make_no_difference(name, monkeypatch):
    document = Document(SourceText("a.fz", BLOCKS))
    spans = [symbol.span for symbol in document.symbols.all if symbol.kind != "term"]
    found = [verdict(document, span, name) for span in spans]
    monkeypatch.setattr(navigation, "_concerned", lambda document, changes: document.text)
    assert [verdict(document, span, name) for span in spans] == found


def test_a_rename_reads_the_blocks_that_it_concerns(monkeypatch):
    document, offset = marked(BLOCKS, "poor |")
    texts, concerned = [], navigation._concerned
    monkeypatch.setattr(navigation, "_concerned", lambda *given: texts.append(concerned(*given)) or texts[-1])
    rename(document, offset, "bad_one")
    (text,) = texts
    heads = "system surface controller law plant lag loop closed "
    assert text.split() == ("param T = 2 " + heads + SYSTEM.replace("tip >= 0", "tip >= missing")).split()
    assert [len(line) for line in text.split("\n")] == [len(line) for line in BLOCKS.split("\n")]
    rename(document, offset, "level")  # the law has it
    assert "next level" in texts[-1]
    assert "state x" not in texts[-1]
