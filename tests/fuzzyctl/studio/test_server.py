"""The server of the studio: the loopback address, types that browsers ask for, links that carry a text."""

import base64
import json
import os
import socket
import struct
import threading
import urllib.error
import urllib.request
import zlib
from urllib.parse import parse_qs, urlsplit

import pytest

from fuzzyctl.studio.server import address, server, used_files


@pytest.fixture
def served(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "secret").write_text("no")
    for name in ("index.html", "worker.js", "a.wasm"):
        (tmp_path / "in" / name).write_text(name)
    (tmp_path / "in" / "pyodide-1").mkdir()
    (tmp_path / "in" / "pyodide-1" / "b.wasm").write_text("b")
    serving = server(tmp_path / "in")
    thread = threading.Thread(target=serving.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    yield f"http://127.0.0.1:{serving.server_port}"
    serving.shutdown()
    thread.join()
    serving.server_close()


def test_files_have_their_types_and_only_the_runtime_is_kept(served):
    found = {}
    for name in ("", "worker.js", "a.wasm", "pyodide-1/b.wasm"):
        with urllib.request.urlopen(f"{served}/{name}") as answer:
            found[name] = answer.headers["Content-Type"].split(";")[0], "immutable" in answer.headers["Cache-Control"]
    assert found == {
        "": ("text/html", False),
        "worker.js": ("text/javascript", False),
        "a.wasm": ("application/wasm", False),
        "pyodide-1/b.wasm": ("application/wasm", True),
    }


def test_a_closed_connection_is_no_error(served, tmp_path, capsys):
    (tmp_path / "in" / "large.wasm").write_bytes(bytes(10_000_000))
    host = urlsplit(served)
    with socket.create_connection((host.hostname, host.port)) as connection:
        connection.sendall(f"GET /large.wasm HTTP/1.1\r\nHost: {host.netloc}\r\n\r\n".encode())
        connection.recv(1)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    for thread in threading.enumerate():
        if "process_request" in thread.name:
            thread.join(10)
    assert capsys.readouterr().err == ""


def refusal(request):
    with pytest.raises(urllib.error.HTTPError) as caught:
        urllib.request.urlopen(request)
    caught.value.close()
    return caught.value.code


def test_nothing_outside_of_the_folder_is_served(served, tmp_path):
    (tmp_path / "in" / "out").symlink_to(tmp_path / "secret")
    (tmp_path / "in" / "up").symlink_to(tmp_path)
    (tmp_path / "in" / "circle").symlink_to("circle")
    (tmp_path / "in" / "long").mkdir()
    os.mkfifo(tmp_path / "in" / "pipe")
    for name in ("../secret", "%2e%2e/secret", "out", "up/secret", "circle", "long/", "pipe", "a" * 5000):
        assert refusal(f"{served}/{name}") == 404, name


@pytest.mark.parametrize("name", ["%00", "a%00b", "worker.js%00", "%00/../../secret", "in/%00.html"])
def test_a_path_with_nul_is_refused_without_a_traceback(served, name, capfd):
    for method in ("GET", "HEAD"):
        assert refusal(urllib.request.Request(f"{served}/{name}", method=method)) == 400
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "", "localhost:80:80", "user@localhost"])
def test_requests_for_other_hosts_are_refused(served, host):
    """A name of somebody else may lead to this address: pages from there must not read what is served."""
    assert refusal(urllib.request.Request(f"{served}/worker.js", headers={"Host": host})) == 421


def test_no_page_may_frame_it(served):
    for host in ("localhost", "LOCALHOST:8000", "127.0.0.1"):
        with urllib.request.urlopen(urllib.request.Request(f"{served}/", headers={"Host": host})) as answer:
            assert "frame-ancestors 'none'" in answer.headers["Content-Security-Policy"]


def test_only_this_machine_reaches_it(tmp_path):
    serving = server(tmp_path)
    assert serving.server_address[0] == "127.0.0.1"
    serving.server_close()


def test_a_link_carries_a_text():
    text = "# é 𝑥 & #\n" * 50
    found = urlsplit(address(80, "a b&c.fz", text))
    values = parse_qs(found.fragment)
    packed = values["text"][0]
    bytes_ = base64.urlsafe_b64decode(packed + "=" * (-len(packed) % 4))
    assert values["name"] == ["a b&c.fz"]
    assert zlib.decompress(bytes_, -15).decode() == text
    assert "files" not in values
    assert address(80) == "http://127.0.0.1:80/"


def test_a_link_carries_the_files_that_the_text_uses(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "a.fz").write_text('use "sub/b.fz"\nsource "c.csv is not it"\nuse "gone.fz"\nuse "../d.fz"\n')
    (tmp_path / "sub" / "b.fz").write_text('table x by y from "c.csv"\nuse "sub/b.fz"\n')
    (tmp_path / "c.csv").write_text("1,2\n")
    (tmp_path.parent / "d.fz").write_text("secret\n")
    found = used_files((tmp_path / "a.fz").read_text(), tmp_path)
    assert sorted(found) == ["c.csv", "sub/b.fz"]
    packed = parse_qs(urlsplit(address(80, "a.fz", "x", found)).fragment)["files"][0]
    text = zlib.decompress(base64.urlsafe_b64decode(packed + "=" * (-len(packed) % 4)), -15)
    assert json.loads(text) == found
