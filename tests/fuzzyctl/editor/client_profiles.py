"""The language server with the client profiles of pytest-lsp: each answer fits what that editor says it can do.

    python -m venv other && other/bin/pip install -e ".[lsp]" pytest-lsp
    other/bin/python tests/fuzzyctl/editor/client_profiles.py

In an environment of its own, since pytest-lsp changes how pytest runs. For each profile a server is started, a file is
opened, every request is sent, and what the server sends by itself is looked at. Exit code 1 after a
warning of pytest-lsp, an answer that is an error, a request of the server that the editor does not offer, or a line
in the server's log.
"""

from __future__ import annotations

import asyncio
import sys
import tempfile
import warnings
from pathlib import Path

import pytest_lsp
from lsprotocol import types as lsp
from pytest_lsp.client import make_test_lsp_client

sys.path.insert(0, str(Path(__file__).parents[3]))

from tests.fuzzyctl.editor.requests import requests

CLIENTS = Path(pytest_lsp.__file__).parent / "clients"
SECONDS = 120
TEXT = """system tip "Tip 🙂"
use "shared.fz"
output tip in [0, 20] else 0
  terms small=0 large=20
table tip = service
     poor   good
  |  small  large
if service is poor then tip is smal
require tip <= 19
param half = tip
param half = 1
param unused = 1
"""
SHARED = "input service in [0, 10]\n  terms poor good\n"
#: Where names, cells and calls stand, and beyond the text.
PLACES = [lsp.Position(*p) for p in ((0, 8), (2, 8), (4, 13), (6, 7), (7, 14), (7, 32), (8, 10), (9, 13), (99, 99))]

#: What a server may only ask of editors that offer it: the section of their capabilities, and its flag.
ASKED = {
    lsp.WORKSPACE_DIAGNOSTIC_REFRESH: ("diagnostics", "refresh_support"),
    lsp.WORKSPACE_CODE_LENS_REFRESH: ("code_lens", "refresh_support"),
    lsp.WORKSPACE_INLAY_HINT_REFRESH: ("inlay_hint", "refresh_support"),
    lsp.CLIENT_REGISTER_CAPABILITY: ("did_change_watched_files", "dynamic_registration"),
}


def misfits(capabilities: lsp.ClientCapabilities, asked: list[str], shown: list[lsp.Diagnostic]):
    """Yield what an editor with these capabilities should not have been sent."""
    for method in asked:
        section, flag = ASKED.get(method, ("", ""))
        if not getattr(getattr(capabilities.workspace, section, None), flag, None):
            yield f"the server asked for {method}"
    own = capabilities.text_document.publish_diagnostics
    if not own.related_information and any(d.related_information for d in shown):
        yield "diagnostics have related information"
    if not own.tag_support and any(d.tags for d in shown):
        yield "diagnostics have tags"


async def talk(profile: str, folder: Path) -> tuple[int, list[lsp.Diagnostic], list[str]]:
    """Return how many requests were answered, the last diagnostics, and what went wrong."""
    capabilities = pytest_lsp.client_capabilities(profile)
    (folder / "shared.fz").write_text(SHARED)
    log, uri = folder / "log", (folder / "a.fz").as_uri()
    client, wrong, asked, seen = make_test_lsp_client(), [], [], asyncio.Event()
    handle, note = client.protocol._handle_request, client.protocol._handle_notification

    def requested(msg_id, method, params):
        asked.append(method)
        handle(msg_id, method, params)

    def notified(method, params):
        note(method, params)
        if uri in client.diagnostics or client.diagnostic_refresh_count:
            seen.set()

    client.protocol._handle_request, client.protocol._handle_notification = requested, notified
    for method in (lsp.WORKSPACE_CODE_LENS_REFRESH, lsp.WORKSPACE_INLAY_HINT_REFRESH):
        client.feature(method)(lambda _: None)  # which pytest-lsp leaves unanswered
    await client.start_io("sh", "-c", f"exec '{sys.executable}' -m fuzzyctl lsp 2>'{log}'")
    root = [lsp.WorkspaceFolder(folder.as_uri(), folder.name)]
    started = lsp.InitializeParams(capabilities, root_uri=folder.as_uri(), workspace_folders=root)
    await client.initialize_session(started)
    client.text_document_did_open(lsp.DidOpenTextDocumentParams(lsp.TextDocumentItem(uri, "fz", 1, TEXT)))
    count = 0
    rename = lsp.RenameParams(lsp.TextDocumentIdentifier(uri), PLACES[1], "percent")
    for method, params in (*requests(uri, PLACES), (lsp.TEXT_DOCUMENT_RENAME, rename)):
        try:
            await asyncio.wait_for(client.protocol.send_request_async(method, params), SECONDS)
            count += 1
        except Exception as error:  # noqa: BLE001 - each is printed
            wrong.append(f"{method}: {error!r}")
    if not (capabilities.text_document.diagnostic and capabilities.workspace.diagnostics):
        await asyncio.wait_for(seen.wait(), SECONDS)
    await client.shutdown_session()
    await client.stop()
    shown = list(client.diagnostics.get(uri, ()))
    lines = log.read_text().splitlines()
    return count, shown, [*wrong, *misfits(capabilities, asked, shown), *(f"log: {line}" for line in lines)]


def main() -> int:
    """Talk under each profile; return 1 where something went wrong."""
    failed = False
    for path in sorted(CLIENTS.glob("*.json")):
        profile = path.stem.replace("_v", "@v")
        with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            count, shown, wrong = asyncio.run(talk(profile, Path(folder)))
        wrong += [str(w.message) for w in warned if "Specification" in w.category.__name__]
        print(f"{profile:<30} {count} answers, {len(shown)} diagnostics, {len(wrong)} warnings")
        print("".join(f"  {line}\n" for line in wrong), end="")
        failed |= bool(wrong)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
