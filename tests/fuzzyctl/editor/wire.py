"""A client of pygls that starts the language server as an editor does, and conversations with it."""

import asyncio
import itertools
import sys

import pytest
from lsprotocol import types as lsp
from pygls.lsp.client import LanguageClient

SECONDS = 60
_NUMBERS = itertools.count()


class Client(LanguageClient):
    """A client that keeps the diagnostics published for the documents it has opened, and can wait for the next ones."""

    def __init__(self):
        super().__init__("test", "1")
        self.published = asyncio.Queue()
        self.uris = set()

        @self.feature(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def _published(params: lsp.PublishDiagnosticsParams) -> None:
            self.published.put_nowait(params)

    async def diagnostics(self, version=None):
        """Return the next diagnostics, of one version of a text where it is given."""
        while True:
            found = await asyncio.wait_for(self.published.get(), SECONDS)
            if found.uri in self.uris and version in (None, found.version):
                return found


async def started(capabilities=None, folders=()):
    """Return a client whose server runs, and what the server can do."""
    client = Client()
    await client.start_io(sys.executable, "-m", "fuzzyctl", "lsp")
    able = lsp.ClientCapabilities() if capabilities is None else capabilities
    done = await client.initialize_async(lsp.InitializeParams(capabilities=able, workspace_folders=list(folders)))
    client.initialized(lsp.InitializedParams())
    return client, done.capabilities


async def ended(client):
    """End a server; its log has no traceback."""
    await client.shutdown_async(None)
    client.exit(None)
    log = await asyncio.wait_for(client._server.stderr.read(), SECONDS)
    await client.stop()
    assert b"Traceback" not in log, log.decode()


def with_server(talk, capabilities):
    """Run a conversation with a server of its own, for a client with some capabilities."""

    async def run():
        client, able = await started(capabilities)
        try:
            return await asyncio.wait_for(talk(client, able), SECONDS)
        finally:
            await ended(client)

    return asyncio.run(run())


@pytest.fixture(scope="module")
def with_shared_server():
    """What runs a conversation with the server of the tests of a file, for a client without capabilities."""
    with asyncio.Runner() as runner:
        client, able = runner.run(started())

        async def run(talk):
            client.uris = set()
            await asyncio.wait_for(talk(client, able), SECONDS)
            for uri in client.uris:
                client.text_document_did_close(lsp.DidCloseTextDocumentParams(lsp.TextDocumentIdentifier(uri)))

        yield lambda talk: runner.run(run(talk))
        runner.run(ended(client))


def opened(client, text, uri=None):
    """Open a text, by default one that is no file."""
    uri = f"untitled:{next(_NUMBERS)}.fz" if uri is None else uri
    client.uris.add(uri)
    client.text_document_did_open(lsp.DidOpenTextDocumentParams(lsp.TextDocumentItem(uri, "fz", 1, text)))
    return lsp.TextDocumentIdentifier(uri)


def changed(client, document, version, text):
    """Send another version of a text."""
    identifier = lsp.VersionedTextDocumentIdentifier(version, document.uri)
    whole = lsp.TextDocumentContentChangeWholeDocument(text)
    client.text_document_did_change(lsp.DidChangeTextDocumentParams(identifier, [whole]))


def position(text, at, more=0):
    """Return where a part of a text begins, or some characters behind."""
    before = text[: text.index(at) + more]
    return lsp.Position(before.count("\n"), len(before) - before.rfind("\n") - 1)
