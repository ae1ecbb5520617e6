"""The language server over the wire: a client of pygls starts it as an editor does."""

import asyncio
import itertools
import sys
from collections import defaultdict

import pytest
from lsprotocol import types as lsp
from pygls.lsp.client import LanguageClient

from tests.fuzzyctl.editor.marked import LOOP
from tests.fuzzyctl.editor.marked import SYSTEM as BASE

SECONDS = 60
SYSTEM = BASE + 'allow FZ219 "kept for later"\n'


class Client(LanguageClient):
    """A client that keeps the diagnostics published for each document, and can wait for the next ones."""

    def __init__(self):
        super().__init__("test", "1")
        self.published = defaultdict(asyncio.Queue)
        self.capabilities = None

        @self.feature(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def _published(params: lsp.PublishDiagnosticsParams) -> None:
            self.published[params.uri].put_nowait(params)

    async def diagnostics(self, document, version=None):
        """Return the next diagnostics of a document, of one version of its text where it is given."""
        while True:
            found = await asyncio.wait_for(self.published[document.uri].get(), SECONDS)
            if version is None or found.version == version:
                return found

    async def start(self):
        await self.start_io(sys.executable, "-m", "fuzzyctl", "lsp")
        done = await self.initialize_async(lsp.InitializeParams(capabilities=lsp.ClientCapabilities()))
        self.capabilities = done.capabilities
        self.initialized(lsp.InitializedParams())

    async def end(self):
        await self.shutdown_async(None)
        self.exit(None)
        await self.stop()


@pytest.fixture(scope="module")
def with_server():
    """Run conversations with one server, each about documents of its own."""
    with asyncio.Runner() as runner:
        client = Client()
        runner.run(client.start())
        yield lambda talk: runner.run(asyncio.wait_for(talk(client), SECONDS))
        runner.run(client.end())


NUMBERS = itertools.count()


def opened(client, text, uri=None):
    uri = uri or f"untitled:{next(NUMBERS)}.fz"
    client.text_document_did_open(lsp.DidOpenTextDocumentParams(lsp.TextDocumentItem(uri, "fz", 1, text)))
    return lsp.TextDocumentIdentifier(uri)


def changed(client, document, version, text):
    identifier = lsp.VersionedTextDocumentIdentifier(version, document.uri)
    whole = lsp.TextDocumentContentChangeWholeDocument(text)
    client.text_document_did_change(lsp.DidChangeTextDocumentParams(identifier, [whole]))


def position(text, at, more=0):
    before = text[: text.index(at) + more]
    return lsp.Position(before.count("\n"), len(before) - before.rfind("\n") - 1)


def applied(text, edits):
    lines = text.split("\n")
    for e in sorted(edits, key=lambda e: (e.range.start.line, e.range.start.character), reverse=True):
        start, end = e.range.start, e.range.end
        head, tail = lines[start.line][: start.character], lines[end.line][end.character :]
        lines[start.line : end.line + 1] = (head + e.new_text + tail).split("\n")
    return "\n".join(lines)


def test_a_conversation(with_server):
    async def talk(client):
        assert client.capabilities.rename_provider
        document = opened(client, SYSTEM)
        assert not (await client.diagnostics(document)).diagnostics
        wrong = SYSTEM.replace("large  large", "large  lagre")
        changed(client, document, 2, wrong)
        (mistake,) = (await client.diagnostics(document, 2)).diagnostics
        assert (mistake.code, mistake.severity) == ("FZ203", lsp.DiagnosticSeverity.Error)
        assert (mistake.range.start.line, mistake.range.start.character) == (16, 23)
        actions = await client.text_document_code_action_async(
            lsp.CodeActionParams(document, mistake.range, lsp.CodeActionContext([mistake]))
        )
        (edits,) = actions[0].edit.changes.values()
        assert applied(wrong, edits) == SYSTEM
        changed(client, document, 3, SYSTEM)
        at = position(SYSTEM, "poor |")
        here = {"text_document": document, "position": at}
        found = await client.text_document_definition_async(lsp.DefinitionParams(**here))
        assert found.range.start == position(SYSTEM, "poor = ")
        renamed = await client.text_document_rename_async(lsp.RenameParams(**here, new_name="awful"))
        (edits,) = renamed.changes.values()
        assert applied(SYSTEM, edits) == SYSTEM.replace("poor", "awful")
        shown = await client.text_document_hover_async(lsp.HoverParams(**here))
        assert "ramp(10, 0)" in shown.contents.value
        proposed = await client.text_document_completion_async(
            lsp.CompletionParams(document, position(SYSTEM, "poor |", 8))
        )
        assert [i.label for i in proposed.items] == ["small", "large"]
        symbols = await client.text_document_document_symbol_async(lsp.DocumentSymbolParams(document))
        assert [s.name for s in symbols] == ["tip"]
        edits = await client.text_document_formatting_async(
            lsp.DocumentFormattingParams(document, lsp.FormattingOptions(2, True))
        )
        assert "hedge hardly(d) = d^3" in applied(SYSTEM, edits)
        client.text_document_did_close(lsp.DidCloseTextDocumentParams(document))
        assert not (await client.diagnostics(document)).diagnostics

    with_server(talk)


def test_a_refuted_guarantee_lights_up_and_a_burst_gives_one_proof(with_server):
    async def talk(client):
        document = opened(client, SYSTEM)
        for version in range(2, 62):
            changed(client, document, version, SYSTEM.replace("tip >= 0", f"tip >= {version}"))
        seen = []
        while not seen or "FZ4" not in str([d.code for d in seen[-1].diagnostics]):
            seen.append(await client.diagnostics(document))
        proofs = [p for p in seen if p.diagnostics]
        assert [p.version for p in proofs] == [61]
        assert "tip >= 61" in proofs[0].diagnostics[0].message

    with_server(talk)


ODD = {
    "empty": "",
    "bytes": "\0\1",
    "emoji": "🙂 🙂\r\nsystem 🙂\r\n",
    "nested": "(" * 5000,
    "many": "system t\n" * 3000,
}


@pytest.mark.parametrize("text", ODD.values(), ids=ODD)
def test_odd_texts_get_answers(with_server, text):
    async def talk(client):
        document = opened(client, text)
        assert (await client.diagnostics(document)).version == 1
        for place in (lsp.Position(0, 0), lsp.Position(0, 10_000), lsp.Position(99_999, 3)):
            await client.text_document_hover_async(lsp.HoverParams(document, place))
            await client.text_document_completion_async(lsp.CompletionParams(document, place))
            await client.text_document_references_async(
                lsp.ReferenceParams(context=lsp.ReferenceContext(True), text_document=document, position=place)
            )
        await client.text_document_document_symbol_async(lsp.DocumentSymbolParams(document))
        await client.text_document_folding_range_async(lsp.FoldingRangeParams(document))

    with_server(talk)


def test_units_of_the_client(with_server):
    text = 'system t "🙂🙂" \nparam a = 1\n# 🙂\n' + "input x in [0, a]\n  terms p q  # 🙂 p\nlet y = x * a\n"

    async def talk(client):
        document = opened(client, text)
        await client.diagnostics(document)
        found = await client.text_document_references_async(
            lsp.ReferenceParams(
                context=lsp.ReferenceContext(True), text_document=document, position=position(text, "a = 1")
            )
        )
        assert [(p.range.start.line, p.range.start.character) for p in found] == [(1, 6), (3, 15), (5, 12)]

    with_server(talk)


def test_files_that_are_used(with_server, tmp_path):
    (tmp_path / "shared.fz").write_text("input service in [0, 10]\n  terms poor good\n")
    text = 'system t\ndefuzzifier center_average\nuse "shared.fz"\noutput tip in [0, 1] else 0\n'
    text += "  terms small=0 large=1\nif service is poor then tip is small\n"
    path = tmp_path / "a.fz"
    path.write_text(text)

    async def talk(client):
        document = opened(client, text, path.as_uri())
        assert [d for d in (await client.diagnostics(document)).diagnostics if d.severity == 1] == []
        at = {"text_document": document, "position": position(text, "poor")}
        found = await client.text_document_definition_async(lsp.DefinitionParams(**at))
        assert (found.uri, found.range.start.line) == ((tmp_path / "shared.fz").as_uri(), 1)
        (tmp_path / "shared.fz").unlink()
        changed(client, document, 2, text + "\n")
        assert (await client.diagnostics(document, 2)).diagnostics[0].code == "FZ218"

    with_server(talk)


def test_loops_have_names_too(with_server):
    async def talk(client):
        document = opened(client, LOOP)
        await client.diagnostics(document)
        at = {"text_document": document, "position": position(LOOP, "surface(e")}
        assert (await client.text_document_definition_async(lsp.DefinitionParams(**at))).range.start.line == 0

    with_server(talk)
