"""A server of one folder on the loopback address: browsers start no workers and no WebAssembly from files."""

from __future__ import annotations

import base64
import json
import os
import re
import sys
import zlib
from collections.abc import Mapping
from functools import partial
from http import HTTPStatus
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, Final
from urllib.parse import quote, unquote

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.support.files import is_below, is_special, read_source

#: Only this machine reaches it.
ADDRESS: Final = "127.0.0.1"
#: The port unless another one is named: browsers keep drafts for each address and port.
PORT: Final = 8617
#: Types of files, by the end of their names.
_TYPES: Final = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".mjs": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".wasm": "application/wasm",
    ".zip": "application/zip",
    ".txt": "text/plain; charset=utf-8",
}


#: Names of this machine in requests: a page of another name that leads here is refused.
_HOSTS: Final = re.compile(r"(127\.0\.0\.1|localhost)(:\d+)?", re.IGNORECASE)


class _Handler(SimpleHTTPRequestHandler):
    """Serves files without a word; browsers ask whether their copy is the newest, but for Pyodide.

    Its folder is named after its version, so they keep it, and the machine code that they make of it.
    """

    def send_head(self) -> Any:
        """Send the headers of a file of the folder, and return the file; refuse other hosts and other files."""
        path = self.translate_path(self.path)
        if "\0" in unquote(self.path):
            self.send_error(HTTPStatus.BAD_REQUEST, "A path has no NUL")
        elif not _HOSTS.fullmatch(self.headers.get("Host", "")):
            self.send_error(HTTPStatus.MISDIRECTED_REQUEST, "This is another host")
        elif not is_below(path, self.directory) or is_special(path):
            self.send_error(HTTPStatus.NOT_FOUND)
        else:
            return super().send_head()
        return None

    def list_directory(self, path: str | os.PathLike[str]) -> None:
        """Show no folders."""
        self.send_error(HTTPStatus.NOT_FOUND)

    def guess_type(self, path: str | os.PathLike[str]) -> str:
        """Return the type of a file by its name, the same on every machine."""
        return _TYPES.get(os.path.splitext(path)[1], "application/octet-stream")

    def end_headers(self) -> None:
        """Send the common headers."""
        is_kept = getattr(self, "path", "").startswith("/pyodide-")  # a request without sense has none
        self.send_header("Cache-Control", "max-age=31536000, immutable" if is_kept else "no-cache")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Content-Security-Policy", "frame-ancestors 'none'")
        super().end_headers()

    def log_message(self, *_: Any) -> None:
        """Write nothing."""


class _Server(ThreadingHTTPServer):
    """A server that shares its port with no other one, which Windows would let it."""

    allow_reuse_address = os.name == "posix"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Report an error, but for a connection that the browser has closed."""
        if not isinstance(sys.exc_info()[1], ConnectionError):
            super().handle_error(request, client_address)


def server(folder: Path, port: int = 0) -> ThreadingHTTPServer:
    """Return a server of a folder, which `serve_forever` starts.

    Args:
        folder: The folder to serve.
        port: 0 for one that is free.

    Raises:
        OSError: For a port that is taken.
    """
    return _Server((ADDRESS, port), partial(_Handler, directory=str(folder)))


def address(port: int, name: str = "", text: str | None = None, files: Mapping[str, str] | None = None) -> str:
    """Return the address of the studio, with a text in it where one is given.

    Args:
        port: Of the server.
        name: Of the text.
        text: The text.
        files: The texts that it uses, by name, see `used_files`.
    """
    page = f"http://{ADDRESS}:{port}/"
    if text is None:
        return page
    more = f"&files={_packed(json.dumps(dict(files)))}" if files else ""
    return f"{page}#name={quote(name, safe='')}&text={_packed(text)}{more}"


def _packed(text: str) -> str:
    """Return a text deflated, in base 64 of URLs."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    packed = packer.compress(text.encode("utf-8")) + packer.flush()
    return base64.urlsafe_b64encode(packed).decode("ascii").rstrip("=")


def used_files(text: str, folder: Path) -> dict[str, str]:
    """Return the files below a folder that a text names in quotes, and those that they name, by name.

    One that cannot be read is left out; the studio reports it where it is used.
    """
    files: dict[str, str] = {}
    waiting = [text]
    while waiting:
        for name in re.findall(r'"([^"\n\0]+)"', waiting.pop()):
            path = folder / name
            if name in files or not is_below(path, folder):
                continue
            try:
                files[name] = read_source(path, only_regular=True).text
            except DiagnosticError:
                continue
            waiting.append(files[name])
    return files
