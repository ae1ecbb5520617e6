"""A server of one folder on the loopback address: browsers start no workers and no WebAssembly from files."""

from __future__ import annotations

import base64
import os
import zlib
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, Final
from urllib.parse import quote

#: Only this machine reaches it.
ADDRESS: Final = "127.0.0.1"
#: What files are, by the end of their names.
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


class _Handler(SimpleHTTPRequestHandler):
    """Serves files without a word; browsers ask whether what they have is the newest, but for Pyodide.

    Its folder is named after its version, so they keep it, and the machine code that they make of it.
    """

    def guess_type(self, path: str | os.PathLike[str]) -> str:
        """Return the type of a file by its name, the same on every machine."""
        return _TYPES.get(os.path.splitext(path)[1], "application/octet-stream")

    def end_headers(self) -> None:
        """Send what each answer has."""
        kept = getattr(self, "path", "").startswith("/pyodide-")  # a request without sense has none
        self.send_header("Cache-Control", "max-age=31536000, immutable" if kept else "no-cache")
        self.send_header("X-Content-Type-Options", "nosniff")
        super().end_headers()

    def log_message(self, *_: Any) -> None:
        """Write nothing."""


def server(folder: Path, port: int = 0) -> ThreadingHTTPServer:
    """Return a server of a folder, which `serve_forever` starts.

    Args:
        folder: What is served.
        port: 0 for one that is free.

    Raises:
        OSError: For a port that is taken.
    """
    return ThreadingHTTPServer((ADDRESS, port), partial(_Handler, directory=str(folder)))


def address(port: int, name: str = "", text: str | None = None) -> str:
    """Return the address of the studio, with a text in it where one is given: deflated, in base 64 of URLs."""
    page = f"http://{ADDRESS}:{port}/"
    if text is None:
        return page
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    packed = packer.compress(text.encode("utf-8")) + packer.flush()
    return f"{page}#name={quote(name, safe='')}&text={base64.urlsafe_b64encode(packed).decode('ascii').rstrip('=')}"
