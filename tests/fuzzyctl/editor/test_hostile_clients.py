"""What no editor should send, and what happens to editors: each request has an answer, and the log no traceback."""

import asyncio
import json
import logging
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException

from fuzzyctl.editor.server import server
from fuzzyctl.editor.session import MOST_SENT, FuzzyServer
from tests import sizes
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM
from tests.fuzzyctl.editor.requests import requests
from tests.fuzzyctl.editor.wire import (
    SECONDS,
    changed,
    opened,
    position,
    started,
)

DOCUMENT = lsp.TextDocumentIdentifier("untitled:a.fz")
FAR = 2**31 - 1
#: Places before, in, between and behind what a line and a text have.
PLACES = [lsp.Position(*p) for p in ((0, 0), (0, 1), (0, 3), (2, 10_000), (7, 5), (FAR, 0), (FAR, FAR))]
TEXTS = {
    "a system": SYSTEM,
    "a loop with CRLF": LOOP.replace("\n", "\r\n"),
    "CR alone": SYSTEM.replace("\n", "\r"),
    "empty": "",
    "binary": "".join(map(chr, range(256))),
    "emoji": '🙂 🙂\r\nsystem 🙂 "🙂"\r\ninput x in [0, 1]  # 🙂\n  terms 🙂 a\n',
    "half an emoji": 'system t "\ud83d"\nparam \ude00 = 1\n',
    "nested": "param a = " + "(" * 5000,
    "many systems": "system t\n" * 300,
    "a table of bars": "table a = b\n" + "|||||\n" * 50,
}


def talk_to(text, uri="untitled:a.fz", folders=(), encoding="utf-16"):
    """Open a text in the server of this process; it answers without a wire."""
    general = lsp.GeneralClientCapabilities(position_encodings=[encoding])
    able = lsp.ClientCapabilities(general=general)
    list(server.protocol.lsp_initialize(lsp.InitializeParams(able, workspace_folders=list(folders))))
    talk_to.version += 1
    server.workspace.put_text_document(lsp.TextDocumentItem(uri, "fz", talk_to.version, text))
    return lambda method, params: server.protocol.fm.features[method](params)


talk_to.version = 0


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-32"])
@pytest.mark.parametrize("text", TEXTS)
def test_all_requests_at_all_places_have_answers(text, encoding, caplog):
    answer = talk_to(TEXTS[text], encoding=encoding)
    for method, params in requests("untitled:a.fz", PLACES):
        answer(method, params)
    assert caplog.records == []


PIECES = ["\r\n", "\r", "🙂", "|", "(", '"', "#", "terms", "table", "input x in [0, 1]\n", "\0", " = ", "x x y", ""]


@st.composite
def broken(draw):
    """Return a text that was a rule file, and a place in it."""
    text = draw(st.sampled_from([SYSTEM, LOOP]))
    for _ in range(draw(st.integers(0, 3))):
        start = draw(st.integers(0, len(text)))
        end = draw(st.integers(start, min(len(text), start + 60)))
        text = text[:start] + draw(st.sampled_from(PIECES)) + text[end:]
    line = draw(st.integers(0, text.count("\n")))
    return text, lsp.Position(line, draw(st.integers(0, len(text.split("\n")[line]))))


@settings(max_examples=sizes.examples(200, 30), deadline=None)
@given(broken())
def test_all_requests_about_broken_texts_have_answers(drawn):
    text, place = drawn
    answer = talk_to(text)
    for method, params in requests("untitled:a.fz", [place]):
        answer(method, params)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-32"])
def test_places_behind_emoji_are_those_of_the_client(encoding):
    text = 'system t "🙂"\nparam a = 1  # 🙂\nlet b = a\nsource "🙂", "🙂" a\n'
    answer = talk_to(text, encoding=encoding)
    document = server.document("untitled:a.fz")
    units = {"utf-8": 4, "utf-16": 2, "utf-32": 1}[encoding]
    for offset in range(len(text) + 1):
        at = server.position(document.source, offset)
        assert server.offset(document, at) == offset
    assert server.position(document.source, text.index("🙂") + 1).character == len('system t "') + units
    symbols = answer("textDocument/documentSymbol", lsp.DocumentSymbolParams(DOCUMENT))
    assert symbols[0].selection_range.start == lsp.Position(0, 7)


def test_a_place_within_an_emoji_is_before_or_behind_it():
    talk_to('system t "🙂"\n')
    document = server.document("untitled:a.fz")
    assert server.offset(document, lsp.Position(0, 11)) in (10, 11)


def test_lines_that_end_with_crlf_have_the_answers_of_others():
    found = []
    for text in (SYSTEM, SYSTEM.replace("\n", "\r\n")):
        answer = talk_to(text)
        folds = answer("textDocument/foldingRange", lsp.FoldingRangeParams(DOCUMENT))
        tokens = answer("textDocument/semanticTokens/full", lsp.SemanticTokensParams(DOCUMENT))
        uses = lsp.ReferenceParams(lsp.ReferenceContext(True), DOCUMENT, lsp.Position(10, 9))
        found.append((folds, tokens, answer("textDocument/references", uses)))
    assert found[0] == found[1]


def test_a_folder_without_rule_files_has_no_names(tmp_path):
    (tmp_path / "a.txt").write_text("system t\n")
    for folder in (tmp_path, tmp_path / "absent", Path("untitled:")):
        uri = folder.as_uri() if folder.is_absolute() else "untitled:folder"
        answer = talk_to("", folders=[lsp.WorkspaceFolder(uri, "f")])
        assert answer("workspace/symbol", lsp.WorkspaceSymbolParams("t")) == []


def test_a_used_file_vanishes_between_a_request_and_the_next(tmp_path):
    (tmp_path / "shared.fz").write_text("input x in [0, 1]\n  terms a b\nsystem other\n")
    uri = (tmp_path / "a.fz").as_uri()
    text = 'use "shared.fz"\nsystem t\nif x is a then y is b\n'
    places = [lsp.Position(0, 7), lsp.Position(2, 3), lsp.Position(2, 8)]
    for vanished in (False, True, False):
        if vanished:
            (tmp_path / "shared.fz").unlink()
        answer = talk_to(text, uri)
        for method, params in requests(uri, places):
            answer(method, params)
        found = answer("textDocument/definition", lsp.DefinitionParams(lsp.TextDocumentIdentifier(uri), places[1]))
        assert (found is None) == (not (tmp_path / "shared.fz").exists())


#: Requests whose parameters are none.
WRONG = {
    "negative lines": {"textDocument": {"uri": "a"}, "position": {"line": -1, "character": 0}},
    "lines beyond those of the protocol": {"textDocument": {"uri": "a"}, "position": {"line": 2**40, "character": 0}},
    "a text for a number": {"textDocument": {"uri": "a"}, "position": {"line": "one", "character": 0}},
    "no document": {"position": {"line": 0, "character": 0}},
    "a list": [],
    "nothing": None,
}


class Wire:
    """A writer that keeps what the server sends."""

    def __init__(self):
        self.sent = b""

    def write(self, data):
        self.sent += data

    def close(self):
        pass


@pytest.mark.parametrize("params", WRONG)
def test_a_request_without_proper_parameters_has_an_error_as_its_answer(params, caplog):
    wire, protocol = Wire(), FuzzyServer().protocol
    protocol.set_writer(wire)
    data = {"jsonrpc": "2.0", "id": 7, "method": "textDocument/hover", "params": WRONG[params]}
    with pytest.raises(JsonRpcException, match="not parameters of 'textDocument/hover'"):
        protocol.structure_message(data)
    answer = json.loads(wire.sent.partition(b"\r\n\r\n")[2])
    assert (answer["id"], answer["error"]["code"]) == (7, -32602)
    assert "Traceback" not in caplog.text


def test_the_log_has_a_line_for_a_mistake_of_a_client_and_a_traceback_for_one_of_the_server(caplog):
    FuzzyServer()
    for error in (JsonRpcException("no such name"), RuntimeError("a mistake of the server")):
        try:
            raise error
        except (JsonRpcException, RuntimeError):
            logging.getLogger("pygls.server").exception("Unable to handle message")
    answer = talk_to(SYSTEM)
    try:  # the editor shows what is refused, and nothing is wrong
        answer("textDocument/rename", lsp.RenameParams(DOCUMENT, lsp.Position(0, 7), "2a"))
    except JsonRpcException:
        logging.getLogger("pygls.protocol.json_rpc").exception("Failed to handle request")
    ours, own = (logging.Formatter().format(record) for record in caplog.records)
    assert ours == "Unable to handle message: no such name"
    assert "Traceback" in own


def test_wrong_requests_have_errors_as_answers_and_right_ones_behind_them_are_answered(with_shared_server):
    async def talk(client, _):
        document = opened(client, SYSTEM)
        for method, params in {"textDocument/juggle": {}, "fuzzyctl/preview": {}}.items():
            sent = client.protocol.send_request_async(method, params)
            with pytest.raises(JsonRpcException):
                await asyncio.wait_for(sent, SECONDS)
        with pytest.raises(JsonRpcException, match="cannot be a name") as refused:
            await client.text_document_rename_async(lsp.RenameParams(document, lsp.Position(0, 7), "2a"))
        assert refused.value.code == lsp.LSPErrorCodes.RequestFailed
        assert await client.text_document_hover_async(lsp.HoverParams(document, lsp.Position(0, 7))) is not None

    with_shared_server(talk)


def test_a_large_text_is_refused_and_answered(with_shared_server):
    text = "param a = 1\n" * 900_000  # 10 MB

    async def talk(client, _):
        document = opened(client, text)
        (mistake,) = (await client.diagnostics()).diagnostics
        assert mistake.code == "FZ003"
        for method, params in requests(document.uri, [lsp.Position(0, 7), lsp.Position(99_999, 3)]):
            await asyncio.wait_for(client.protocol.send_request_async(method, params), SECONDS)
        changed(client, document, 2, SYSTEM)
        assert not [d for d in (await client.diagnostics(2)).diagnostics if d.severity == 1]

    with_shared_server(talk)


def test_of_very_many_diagnostics_the_first_errors_are_sent():
    text = "param a = 1\n" * (MOST_SENT + 50)
    answer = talk_to(text)
    found = answer("textDocument/diagnostic", lsp.DocumentDiagnosticParams(DOCUMENT)).items
    assert len(found) == MOST_SENT + 1
    assert found[-1].message == "50 more diagnostics are not shown"


def test_more_keys_than_anybody_types(with_shared_server):
    """As fast as the wire takes them, with a request behind each: the last text is checked, and all are answered."""
    keys = 400

    async def talk(client, _):
        document = opened(client, SYSTEM)
        answers = []
        for k in range(keys):
            end = lsp.Position(SYSTEM.count("\n"), k)
            change = lsp.TextDocumentContentChangePartial(range=lsp.Range(end, end), text="#")
            identifier = lsp.VersionedTextDocumentIdentifier(k + 2, document.uri)
            client.text_document_did_change(lsp.DidChangeTextDocumentParams(identifier, [change]))
            params = lsp.CompletionParams(document, position(SYSTEM, "good |", 8))
            answers.append(client.text_document_completion_async(params))
        found = await asyncio.wait_for(asyncio.gather(*answers), SECONDS)
        assert {tuple(i.label for i in f.items) for f in found} == {("small", "large")}
        while (await client.diagnostics()).version != keys + 1:
            pass
        await client.text_document_hover_async(lsp.HoverParams(document, lsp.Position(0, 7)))

    with_shared_server(talk)


def test_a_server_that_is_killed_is_started_again():
    async def run():
        for is_killed in (True, False):
            client, _ = await started()
            opened(client, SYSTEM.replace("small  large", "small  lagre", 1))
            (mistake,) = [d for d in (await client.diagnostics()).diagnostics if d.severity == 1]
            assert mistake.code == "FZ203"
            if is_killed:
                client._server.kill()
            else:  # an editor that ends without a word closes the wire
                client._server.stdin.close()
            assert await asyncio.wait_for(client._server.wait(), SECONDS) is not None
            assert b"Traceback" not in await client._server.stderr.read()

    asyncio.run(run())
