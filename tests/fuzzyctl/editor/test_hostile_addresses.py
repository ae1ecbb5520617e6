"""Addresses of documents that no editor has opened: files of the folders are read, and nothing else is."""

import asyncio
import os
import sys
from pathlib import Path

import pytest
from lsprotocol import types as lsp

from tests import sizes
from tests.commands import runner
from tests.fuzzyctl.editor.marked import SYSTEM
from tests.fuzzyctl.editor.requests import requests
from tests.fuzzyctl.editor.wire import SECONDS, ended, opened, started

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pipes and devices are files of POSIX")

PLACES = [lsp.Position(0, 0), lsp.Position(3, 2)]
#: Most memory of the server [kB], and most processor time that it takes for an answer [s].
MOST_MEMORY = 500_000
MOST_TIME = 2.0
DEVICES = ["zero", "random", "urandom", "full", "tty", "stdin", "fd/0", "null"]
ELSEWHERE = ["/proc/kmsg", "/proc/self/mem", "/proc/self/environ", "/proc/kcore", "/etc/passwd", "/", "/proc/self/root"]


#: Names of files that a text cannot use, and lines that name one each.
NAMES = ["/dev/zero", "../secret.fz", "pipe.fz", "zero.fz", "up/secret.fz", "sparse.fz", "x" * 5000, "a\0.fz"]
LINES = 'use "{0}"\ntable a = b x c from "{0}"\nplant p = fmu("{0}")\nplant q = python("{0}")\n'


@pytest.fixture
def folder(tmp_path):
    """A folder with a pipe, links, a large file and a text that is none; a secret lies beside it."""
    inside = tmp_path / "in side"
    (inside / "sub").mkdir(parents=True)
    (tmp_path / "secret.fz").write_text("system secret\n")
    (inside / "a.fz").write_text(SYSTEM)
    (inside / "large.fz").write_text("# a line\n" * 200_000)
    (inside / "binary.fz").write_bytes(bytes(range(256)))
    with (inside / "sparse.fz").open("wb") as file:
        file.truncate(1 << 40)
    os.mkfifo(inside / "pipe.fz")
    os.mkfifo(inside / "sub" / "pipe.csv")
    links = {"zero.fz": "/dev/zero", "out.fz": tmp_path / "secret.fz", "circle.fz": "circle.fz", "up": tmp_path}
    for name, target in {**links, "to_pipe.fz": "pipe.fz", "gone.fz": "nowhere"}.items():
        (inside / name).symlink_to(target)
    return inside


def addresses(folder):
    """Return 50 addresses that a server should not read, in the test line a third of them."""
    at = folder.as_uri()
    below = ["pipe.fz", "sub/pipe.csv", "zero.fz", "out.fz", "circle.fz", "up/secret.fz", "to_pipe.fz", "gone.fz"]
    below += ["large.fz", "sparse.fz", "binary.fz", "", "sub", "../secret.fz", "sub/../../secret.fz"]
    below += ["%2e%2e/secret.fz", "a.fz%00", "%00", "a%00.fz", "a.fz/", "a.fz/b.fz", "x" * 300, "x/" * 5000]
    below += ["x" * 100_000, "%ff%fe.fz", "*"]
    found = [f"{at}/{name}" for name in below]
    found += [f"file:///dev/{name}" for name in DEVICES] + [f"file://{path}" for path in ELSEWHERE]
    found += [
        "file://host/share/a.fz",
        "file://localhost/dev/zero",
        "file://///host/share",
        f"file://host{folder}/a.fz",
    ]
    found += ["untitled:a.fz", "http://localhost/a.fz", "file:", "", "/dev/zero"]
    assert len(found) == len(set(found)) == 50
    return found if sizes.LONG else found[::3]


RUN = runner()


def naming(name):
    """Return lines that name a file in each way."""
    return LINES.format(name) + f'loop l\nlet w = csv("{name}", "y")\nrun 1 s step 0.1 s\n'


def memory(process):
    """Return the most memory that a process has had [kB]; 0 on a system that does not say it."""
    status = Path(f"/proc/{process.pid}/status")
    lines = status.read_text().splitlines() if status.exists() else []
    return next((int(line.split()[1]) for line in lines if line.startswith("VmHWM:")), 0)


def effort(process):
    """Return the processor time that a process has taken [s]; 0 on a system that does not say it."""
    status = Path(f"/proc/{process.pid}/stat")
    fields = status.read_text().rpartition(")")[2].split() if status.exists() else []
    return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")


async def answer(client, what, waited):
    """Return an answer of the server; fail if it takes too much processor time, which no other process makes more."""
    began = effort(client._server)
    found = await asyncio.wait_for(waited, SECONDS)
    took = effort(client._server) - began
    assert took < MOST_TIME, f"{what} took {took:.2f} s of a processor"
    return found


async def published(client, uri):
    """Return the diagnostics of a document; what was published of the text before is left out."""
    while not (found := await client.diagnostics()).diagnostics or found.uri != uri:
        pass
    return found.diagnostics


async def asked(client, uri):
    """Send all requests about a document; return the names that its outline has."""
    for method, params in requests(uri, PLACES):
        await answer(client, f"{method} of {uri[:80]}", client.protocol.send_request_async(method, params))
    outline = lsp.DocumentSymbolParams(lsp.TextDocumentIdentifier(uri))
    return [symbol.name for symbol in await client.text_document_document_symbol_async(outline)]


def with_folder(talk, folder):
    async def run():
        client, _ = await started(folders=[lsp.WorkspaceFolder(folder.as_uri(), "f")])
        try:
            await talk(client)
            assert memory(client._server) < MOST_MEMORY
        finally:
            await ended(client)

    asyncio.run(run())


def test_no_other_file_is_read_and_each_request_is_answered(folder):
    async def talk(client):
        assert await asked(client, (folder / "a.fz").as_uri())
        for uri in addresses(folder):
            assert not await asked(client, uri), uri

    with_folder(talk, folder)


def test_what_is_open_is_answered_under_any_address(folder):
    """An editor may open what it likes; lines of the text that name such files are mistakes."""
    text = "".join(map(naming, NAMES))

    async def talk(client):
        for uri in [(folder / "a.fz").as_uri(), *addresses(folder)]:
            document = opened(client, text, uri)
            found = await answer(client, f"diagnostics of {uri[:80]}", published(client, uri))
            assert any(d.severity == 1 for d in found)
            await asked(client, uri)
            client.text_document_did_close(lsp.DidCloseTextDocumentParams(document))

    with_folder(talk, folder)


def test_a_folder_is_looked_through_without_links_and_pipes(folder):
    async def talk(client):
        found = await client.workspace_symbol_async(lsp.WorkspaceSymbolParams("secret"))
        assert not found

    with_folder(talk, folder)


@pytest.mark.parametrize("name", NAMES[:-1])
def test_commands_do_not_read_them_either(folder, name):
    """A file of text has no NUL."""
    (folder / "b.fz").write_text(naming(name))
    for command in ("check", "simulate", "show", "prove"):
        done = RUN(command, folder / "b.fz")
        assert done.exit_code == 1
        assert isinstance(done.exception, SystemExit)
        assert "secret" not in done.output.replace("secret.fz", "")
