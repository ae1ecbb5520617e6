"""Documents and proofs of a server without a client."""

import asyncio

import pytest
from lsprotocol import types as lsp
from pygls.workspace import Workspace

from fuzzyctl.editor.session import FuzzyServer, diagnostics_of, lights
from tests.fuzzyctl.editor.marked import SYSTEM

URI = "untitled:a.fz"
EMOJI = 'system t "🙂🙂" # é\r\nparam a = 1  # 🙂\r\n\r\nend'


@pytest.fixture
def server(monkeypatch):
    made = FuzzyServer()
    made.protocol._workspace = Workspace(None)
    shown = []
    monkeypatch.setattr(made, "publish", lambda uri, document, *, proved: shown.append((document.text, proved)))
    return made, shown


def put(server, version, text, uri=URI):
    server.workspace.put_text_document(lsp.TextDocumentItem(uri, "fz", version, text))


def test_a_burst_of_changes_gives_one_check_and_one_proof(server, monkeypatch):
    server, shown = server
    proofs = []
    monkeypatch.setattr(lights, "prove", lambda document, *_: bool(proofs.append(document.text)))
    texts = [SYSTEM + f"# {k}\n" for k in range(60)]

    async def burst():
        checks = []
        for version, text in enumerate(texts):
            put(server, version, text)
            checks.append(asyncio.create_task(server.check(URI)))
            await asyncio.sleep(0)
        await asyncio.gather(*checks)
        await asyncio.gather(*server._proofs.values())

    asyncio.run(burst())
    assert proofs == [texts[-1]]
    assert shown == [(texts[-1], False), (texts[-1], True)]


def test_a_newer_text_stops_the_proof_that_runs(server, monkeypatch):
    server, shown = server
    begun, ended = [], []
    texts = [SYSTEM, SYSTEM + "# newer\n"]

    def prove(document, _, stopped):
        begun.append(document.text)
        while document.text == texts[0] and not stopped():
            pass
        if stopped():
            raise lights.StoppedError
        ended.append(document.text)
        return False

    monkeypatch.setattr(lights, "prove", prove)

    async def change():
        put(server, 1, texts[0])
        await server.check(URI)
        while not begun:
            await asyncio.sleep(0.001)
        put(server, 2, texts[1])
        await server.check(URI)
        await asyncio.gather(*server._proofs.values())

    asyncio.run(change())
    assert (begun, ended) == (texts, texts[1:])
    assert shown[-1] == (texts[1], True)


def test_a_document_is_computed_once_for_each_version(server):
    server, _ = server
    put(server, 1, SYSTEM)
    first = server.document(URI)
    assert server.document(URI) is first
    put(server, 2, SYSTEM)
    assert server.document(URI) is not first


def test_a_text_that_is_too_large_is_empty(server, monkeypatch):
    server, _ = server
    monkeypatch.setattr("fuzzyctl.editor.session.MAX_BYTES", 10)
    put(server, 1, SYSTEM)
    document = server.document(URI)
    assert (document.text, document.characters) == ("", len(SYSTEM))
    assert [d.code for d in diagnostics_of(document, proved=True)] == ["FZ003"]


@pytest.mark.parametrize("offset", [0, 5, 10, 11, 12, 17, 18, 21, 30, 37, 38, 40, 41, 43, 44])
def test_positions_are_those_of_the_client_both_ways(server, offset):
    server, _ = server
    put(server, 1, EMOJI)
    document = server.document(URI)
    before = EMOJI[:offset]
    place = server.position(document.source, offset)
    line = before[before.rfind("\n") + 1 :]
    assert (place.line, place.character) == (before.count("\n"), len(line.encode("utf-16-le")) // 2)
    back = server.offset(document, place)
    assert back == (offset - 1 if before.endswith("\r") else min(offset, len(EMOJI)))


@pytest.mark.parametrize(
    ("line", "character", "rest"),
    [(0, 999, " # é"), (1, 999, "# 🙂"), (2, 1, ""), (3, 9, "end"), (4, 0, "end"), (10**9, 10**9, "end")],
)
def test_positions_beyond_the_text_are_at_ends(server, line, character, rest):
    server, _ = server
    put(server, 1, EMOJI)
    document = server.document(URI)
    assert document.text[: server.offset(document, lsp.Position(line, character))].endswith(rest)
