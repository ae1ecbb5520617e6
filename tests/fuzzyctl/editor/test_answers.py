"""Laws of the server's answers, in this process; tests/golden/editor holds the answers themselves."""

import re
from base64 import b64decode
from pathlib import Path
from xml.etree import ElementTree

import pytest
from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException

import fuzzyctl
from fuzzyctl.editor.server import server
from tests.effort import at_most
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM
from tests.golden.answers import ABLE, Case
from tests.golden.test_editor import cases
from tests.shipped import SYSTEMS

SNIPPETS = lsp.ClientCapabilities(
    text_document=lsp.TextDocumentClientCapabilities(
        completion=lsp.CompletionClientCapabilities(
            completion_item=lsp.ClientCompletionItemOptions(snippet_support=True)
        )
    )
)
#: Beginnings of lines in each kind of block, a membership function, a row of a table.
BEGUN = {
    "": "①",
    "system": SYSTEM + "①",
    "controller": LOOP.split("plant")[0] + "①",
    "plant": LOOP.split("loop")[0] + "①",
    "loop": LOOP + "①",
    "function": "system t\ninput x in [0, 1]\n  low = ①",
    "row": SYSTEM.replace("  good | small  large  large\n", "  ①\n"),
}


def items(marked, able=ABLE):
    case = Case(marked, able=able)
    found = case.ask("textDocument/completion", lsp.CompletionParams(case.document, case.places[0])).items
    return {item.label: item for item in found}


class TestCompletion:
    @pytest.mark.parametrize("line", ["@ = clamp(@", "@ = @ + (@"])
    @pytest.mark.parametrize("letter", ["v", "Ω", "a\u0301"])
    def test_long_names_take_no_longer(self, line, letter):
        case = Case(LOOP + line.replace("@", letter * 25) + "①")
        with at_most(1.0):
            case.ask("textDocument/completion", lsp.CompletionParams(case.document, case.places[0]))

    @pytest.mark.parametrize("place", BEGUN)
    def test_words_are_explained_and_skeletons_begin_with_their_word(self, place):
        for label, item in items(BEGUN[place]).items():
            assert (item.text_edit.new_text, item.insert_text_format) == (label, None)
        for label, item in items(BEGUN[place], SNIPPETS).items():
            assert item.documentation or item.detail, label
            if item.insert_text_format is None:
                assert item.text_edit.new_text == label
            else:
                assert item.text_edit.new_text.startswith(label)
                assert "${1:" in item.text_edit.new_text
                assert item.text_edit.new_text.count("{") == item.text_edit.new_text.count("}")

    @pytest.mark.parametrize(
        ("place", "label", "skeleton"),
        [
            ("", "input", "input ${1:name} in [${2:0}, ${3:1}]\n  terms ${4:low high}"),
            ("controller", "input", "input ${1:name}"),
            ("row", "good", "good |  ${1:.}  ${2:.}  ${3:.}"),
            ("function", "triangle", "triangle(${1:left}, ${2:peak}, ${3:right})"),
        ],
    )
    def test_skeletons(self, place, label, skeleton):
        assert items(BEGUN[place], SNIPPETS)[label].text_edit.new_text == skeleton


@pytest.mark.parametrize(("title", "text"), [(title, text) for title, _, text in cases("actions")])
def test_an_action_leaves_a_text_of_the_language_with_the_same_kernel(title, text):
    case, found = Case(text), []
    for place in case.places:
        params = lsp.CodeActionParams(case.document, lsp.Range(place, place), lsp.CodeActionContext([]))
        found += case.ask("textDocument/codeAction", params)
    for action in found:
        after = case.after(action.edit.changes[case.uri])
        documents = [Case(case.text).now, Case(after).now]
        before, later = [[d.code for d in x.mistakes if d.severity == "error"] for x in documents]
        assert not {code for code in later if code.startswith("FZ1")} - set(before), after
        if action.title.startswith("write the terms") and not before:
            plans = [[fuzzyctl.compile(s, "python").plan for s in x.examined.systems] for x in documents]
            assert plans[0] == plans[1], after


class TestPictures:
    KINDS = (
        *("triangle(0, 2, 4)", "trapezoid(0, 1, 2, 4)", "rectangle(1, 3)", "ramp(0, 10)", "gaussian(5, 1)"),
        *("bell(5, 1, 2)", "sigmoid(5, 2)", "triangle(-inf, 2, 4)", "triangle(-20, -12, -11)"),
        *("triangle(0, most / 10, 4)", "singleton(3)"),
    )

    def picture(self, text):
        case = Case(text)
        markdown = case.ask("textDocument/hover", lsp.HoverParams(case.document, case.places[0])).contents.value
        return b64decode(markdown.split("base64,")[1].split(")")[0]).decode() if "base64," in markdown else ""

    @pytest.mark.parametrize("kind", KINDS)
    def test_of_a_term_are_well_formed_and_stay_inside(self, kind):
        root = ElementTree.fromstring(self.picture(SYSTEM.replace("poor = ramp(10, 0)", f"①poor = {kind}")))
        lines = [e for e in root if e.tag.endswith("polyline")]
        assert len(lines) == 2
        assert [e.text for e in root if e.tag.endswith("text")] == ["0", "service", "10"]
        for line in lines:
            points = [tuple(map(float, p.split(","))) for p in line.attrib["points"].split()]
            assert all(0 <= x <= 260 and 0 <= y <= 66 for x, y in points)

    def test_show_peaks_at_the_top_singletons_as_lines_and_labels_as_text(self):
        root = ElementTree.fromstring(self.picture(SYSTEM.replace("poor = ramp(10, 0)", "①poor = triangle(0, 5, 10)")))
        strong = [e for e in root if e.tag.endswith("polyline")][-1].attrib["points"].split()
        assert strong[65] == "130.0,4.0"
        assert "259.0,66 259.0,4.0" in self.picture(SYSTEM.replace("large  large", "large  ①large"))
        named = SYSTEM.replace('"Food"', '"a < b & c"').replace("terms bad", "terms ①bad")
        assert "a &lt; b &amp; c" in self.picture(named)
        assert self.picture(SYSTEM.replace("small=0 large=most", "small=0\n  ①large = linear(1, 1, 0)")) == ""


@pytest.mark.parametrize("path", sorted(SYSTEMS[0].parent.rglob("*.fz")), ids=lambda p: p.stem)
def test_every_name_of_the_shipped_files_is_found_at_its_text(path):
    Case("")
    text = path.read_text(encoding="utf-8")
    server.workspace.put_text_document(lsp.TextDocumentItem(path.as_uri(), "fz", 1, text))
    found = server.document(path.as_uri()).symbols
    assert all(span.text == symbol.name for span, symbol in found.uses)
    names, covered = {s.name for s in found.all}, {span.start for span, _ in found.uses}
    offset = 0
    for line in text.split("\n"):
        code = re.sub(r'"[^"]*"', lambda m: " " * len(m[0]), line.split("#")[0])
        for m in re.finditer(r"\w+", code):
            # `x` crosses the inputs of a table, measures have names of functions, and arguments by name and members
            # may be those of a block in another file.
            crosses = m[0] == "x" and line.startswith("table")
            by_name = re.match(r"=\w", code[m.end() :]) is not None or code[: m.start()].endswith(".")
            known = m[0] in names and not crosses and not by_name and code[m.end() :][:1] != "("
            assert not known or offset + m.start() in covered, line
        offset += len(line) + 1


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
block a = ①law(x, ②k=3)
output z = a.③v + ④rule(⑤e=x)
loop closed
block b = top(lag.y)
block lag = ⑥lag(u=b.z)
run 1 s
"""


class TestFilesThatAreUsed:
    @pytest.fixture
    def top(self, tmp_path):
        (tmp_path / "parts.fz").write_text(PARTS)
        return Case(TOP, folder=tmp_path)

    def references(self, case, uri, place):
        context = lsp.ReferenceContext(True)
        params = lsp.ReferenceParams(context=context, text_document=lsp.TextDocumentIdentifier(uri), position=place)
        return [(f.uri.rpartition("/")[2], f.range.start.line + 1) for f in case.ask("textDocument/references", params)]

    @pytest.mark.parametrize(
        ("mark", "line", "uses"),
        [
            (0, 9, [4, 9]),
            (1, 11, [4, 11, 12]),
            (2, 12, [5, 12]),
            (3, 3, [5, 3, 12]),
            (4, 1, [5, 1, 6]),
            (5, 13, [8, 13]),
        ],
    )
    def test_blocks_are_found(self, top, mark, line, uses):
        assert top.now.mistakes == []
        found = top.ask("textDocument/definition", lsp.DefinitionParams(top.document, top.places[mark]))
        assert (found.uri.rpartition("/")[2], found.range.start.line + 1) == ("parts.fz", line)
        assert [line for _, line in self.references(top, top.uri, top.places[mark])] == uses

    def test_a_block_is_renamed_in_the_file_that_declares_it(self, top, tmp_path):
        params = lsp.RenameParams(top.document, top.places[0], "lawful")
        changes = top.ask("textDocument/rename", params).changes
        assert set(changes) == {top.uri, (tmp_path / "parts.fz").as_uri()}
        (tmp_path / "parts.fz").write_text(Case(PARTS).after(changes[(tmp_path / "parts.fz").as_uri()]))
        after = Case(Case(TOP).after(changes[top.uri]), folder=tmp_path).now
        assert after.mistakes == []
        assert "lawful" in {head.name for _, head in after.symbols.blocks()}

    def test_files_that_use_a_name_are_among_its_uses(self, top, tmp_path):
        """Also if the text on the screen has moved on from the file that the others read."""
        uri = (tmp_path / "parts.fz").as_uri()
        top.put(uri, "# new\n" + PARTS)
        at = lsp.Position(9, len("controller "))
        assert self.references(top, uri, at) == [("parts.fz", 10), ("a.fz", 4)]
        document = lsp.TextDocumentIdentifier(uri)
        changes = top.ask("textDocument/rename", lsp.RenameParams(document, at, "lawful")).changes
        assert {u: [e.new_text for e in edits] for u, edits in changes.items()} == {
            uri: ["controller lawful"],
            top.uri: ["lawful"],
        }

    @pytest.mark.parametrize(
        ("mark", "name", "place"),
        [("①", "m", "line 4 of b.fz"), ("②", "Z", "line 10 of b.fz"), ("①", "free", "line 7 of b.fz")],
    )
    def test_a_name_with_another_meaning_in_a_file_that_uses_this_one_is_refused(self, tmp_path, mark, name, place):
        (tmp_path / "b.fz").write_text(
            'use "a.fz"\nsystem s\ninput q in [0, 1] terms of e\n  Z = ramp(0, k)\nparam m = 2\n'
            "output y in [0, 1] else 0\n  low = constant(k + m + free)\n  high = constant(1)\n"
            "if e is N then y is low\nif q is N and q is Z then y is high\n"
        )
        text = "param ①k = 1\ninput e in [-1, 1]\n  terms ②N P\n"
        (tmp_path / "a.fz").write_text(re.sub("[①②]", "", text))
        case = Case(text, folder=tmp_path, folders=[tmp_path])
        at = case.places["①②".index(mark)]
        with pytest.raises(JsonRpcException, match=f"'{name}' .* {place}"):
            case.ask("textDocument/rename", lsp.RenameParams(case.document, at, name))
        changes = case.ask("textDocument/rename", lsp.RenameParams(case.document, at, "other")).changes
        assert set(changes) == {case.uri, (tmp_path / "b.fz").as_uri()}

    def test_a_used_file_outside_of_the_folder_is_not_read(self, tmp_path):
        folder = tmp_path / "sub"
        folder.mkdir()
        (tmp_path / "parts.fz").write_text(PARTS)
        (folder / "link.fz").symlink_to(tmp_path / "parts.fz")
        for name in ("../parts.fz", str(tmp_path / "parts.fz"), "link.fz"):
            case = Case(TOP.replace("parts.fz", name), folder=folder)
            case.put((tmp_path / "parts.fz").as_uri(), PARTS)
            assert "FZ218" in {d.code for d in case.now.mistakes}
            assert case.ask("textDocument/definition", lsp.DefinitionParams(case.document, case.places[0])) is None

    USER = "input service in [0, 10]\n  terms poor good\n"

    @pytest.mark.parametrize(
        ("saved", "shown", "codes"),
        [
            (USER, None, set()),
            (None, USER, set()),
            (USER.replace("good", "bad"), USER, set()),
            (USER, USER.replace("good", "bad"), {"FZ203"}),
            (None, None, {"FZ218"}),
        ],
    )
    def test_texts_that_are_not_saved_are_used(self, tmp_path, saved, shown, codes):
        text = 'system t\ndefuzzifier center_average\nuse "shared.fz"\noutput tip in [0, 1] else 0\n'
        text += "  terms small=0 large=1\nif service is poor then tip is small\nif service is good then tip is large\n"
        if saved is not None:
            (tmp_path / "shared.fz").write_text(saved)
        case = Case(text, folder=tmp_path)
        if shown is not None:
            case.put((tmp_path / "shared.fz").as_uri(), shown)
            case.put(case.uri, text)
        assert {d.code for d in case.now.mistakes if d.severity == "error"} == codes
        assert str(tmp_path / "shared.fz") in case.now.used


class TestRename:
    """A rename reads the blocks that it concerns, and gives what reading all of them gives."""

    BLOCKS = "param T = 2\n" + LOOP + SYSTEM.replace("tip >= 0", "tip >= missing")

    def verdicts(self, name):
        case, found = Case(self.BLOCKS), []
        for symbol in case.now.symbols.all:
            at = server.position(case.now.source, symbol.span.start)
            try:
                found.append(case.ask("textDocument/rename", lsp.RenameParams(case.document, at, name)))
            except JsonRpcException as error:
                found.append(error.message)
        return found

    @pytest.mark.parametrize("name", ["fresh", "missing", "error", "food", "T"])
    def test_other_blocks_make_no_difference(self, name, monkeypatch):
        found = self.verdicts(name)
        monkeypatch.setattr("fuzzyctl.editor.navigation._concerned", lambda document, changes: document.text)
        assert self.verdicts(name) == found


class TestWorkspace:
    @pytest.fixture
    def folder(self, tmp_path):
        (tmp_path / "sub").mkdir()
        for hidden in (".git", "node_modules"):
            (tmp_path / hidden).mkdir()
            (tmp_path / hidden / "c.fz").write_text("system hidden\n")
        (tmp_path / "a.fz").write_text(SYSTEM)
        (tmp_path / "sub" / "b.fz").write_text(LOOP)
        (tmp_path / "bytes.fz").write_bytes(b"\xff\xfe\0")
        (tmp_path / "other.txt").write_text("system other\n")
        return tmp_path

    def names(self, case, query):
        return [s.name for s in case.ask("workspace/symbol", lsp.WorkspaceSymbolParams(query))]

    def test_names_of_all_files_are_found_by_letters_in_their_order(self, folder):
        case = Case("system unsaved\n", folder=folder / "sub", folders=[folder])
        for query, found in {
            "service": ["service"],
            "SERV": ["service"],
            "srvc": ["service"],
            "tip": ["tip", "tip"],
            "law": ["law", "law"],
            "unsaved": ["unsaved"],
            "hidden": [],
            "other": [],
            "zzz": [],
            "ecivres": [],
        }.items():
            assert self.names(case, query) == found, query

    def test_texts_that_are_open_count_and_files_may_change_and_vanish(self, folder):
        case = Case("system unsaved\n", folder=folder, folders=[folder])
        assert (self.names(case, "unsaved"), self.names(case, "service")) == (["unsaved"], [])
        path = folder / "sub" / "b.fz"
        path.write_text("system another_one\n")
        assert self.names(case, "other") == ["another_one"]
        path.unlink()
        assert self.names(case, "other") == []

    def test_not_more_files_are_read_than_allowed(self, folder, monkeypatch):
        monkeypatch.setattr("fuzzyctl.editor.session.MAX_FILES", 1)
        case = Case("", folders=[folder])
        assert (self.names(case, "service"), self.names(case, "closed")) == (["service"], [])
        assert Path(folder / "sub" / "b.fz").exists()
