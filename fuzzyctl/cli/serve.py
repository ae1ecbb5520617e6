"""`fuzzyctl studio` and `fuzzyctl lsp`: rule files in the browser, and in editors."""

from __future__ import annotations

import sys
import webbrowser
from pathlib import Path
from threading import Thread
from typing import Final

import click

import fuzzyctl
from fuzzyctl.cli.common import DONE, FAILED, answers_with_diagnostics
from fuzzyctl.cli.loading import folder_of, source_of
from fuzzyctl.cli.streams import say
from fuzzyctl.support.files import place_of, studio_folder

#: The command that installs the studio, or the one of this version.
REPAIR: Final = "pip install 'fuzzyctl[studio]', or in a clone: pip install ./apps/studio"


@click.command()
@click.argument("file", required=False)
@click.option(
    "--folder",
    metavar="FOLDER",
    help="The built studio.  [default: the checkout's, else the installed one]",
)
@click.option("--port", type=click.IntRange(0, 65535), help="Port; 0 for a free one.  [default: 8617, else a free one]")
@click.option("--no-browser", is_flag=True, help="Print the address only.")
@answers_with_diagnostics
def studio(file: str | None, folder: str | None, port: int | None, no_browser: bool) -> int:
    """Edit rule files in the browser, with their mistakes, repairs and pictures.

    \b
    fuzzyctl studio tipper

    fuzzyctl itself runs in the browser; nothing leaves this machine, and no network is needed. The file is opened as a
    copy, with the files that it uses: 'Save' in the studio writes it. A server on the loopback address hands the
    studio to the browser, since browsers do not start workers from local files. Ctrl-C ends it.

    The studio is an extra: pip install "fuzzyctl[studio]", or in a clone, with Node 20: pip install ./apps/studio
    """
    from fuzzyctl.studio.server import PORT, address, server, used_files

    built = Path(folder) if folder is not None else studio_folder()
    if built is None:
        raise click.ClickException(f"the studio is not installed: {REPAIR}")
    if not (built / "index.html").is_file():
        raise click.UsageError(f"there is no studio in '{built}': {REPAIR}")
    version = built / "version.txt"
    other = version.read_text("utf-8", "replace").strip() if version.is_file() else "of an unknown version"
    if other != fuzzyctl.__version__:
        say(f"the studio in '{built}' has fuzzyctl {other}, this is {fuzzyctl.__version__}: {REPAIR}", err=True)
    text = source_of(file).text if file is not None else None
    used = used_files(text, folder_of(file)) if text is not None and file not in (None, "-") else {}
    try:
        serving = server(built, PORT if port is None else port)
    except OSError as error:
        if port is not None:
            raise click.UsageError(f"port {port} cannot be served: {error.strerror}; leave '--port' out") from None
        say(f"port {PORT} cannot be served: {error.strerror}; drafts of the studio there are not seen here", err=True)
        serving = server(built)
    place = address(
        serving.server_port, place_of(file).path.name if file not in (None, "-") else "stdin.fz", text, used
    )
    say(f"the studio: {place}")
    sys.stdout.flush()
    try:
        if not no_browser:
            Thread(target=_open, args=(place,), daemon=True).start()
        serving.serve_forever()
    except KeyboardInterrupt:
        say("", err=True)
    finally:
        serving.server_close()
    return DONE


def _open(place: str) -> None:
    """Open the browser beside the server: some return when they are closed only."""
    try:
        is_open = webbrowser.open(place)
    except OSError:  # an address longer than the system lets arguments be
        is_open = False
    if not is_open:
        say("no browser opens the address above: open it there yourself", err=True)


@click.command()
@answers_with_diagnostics
def lsp() -> int:
    """Serve an editor over standard input and output.

    Editors start this command themselves and speak the Language Server Protocol with it: mistakes while you type,
    with their repairs, completion, hover, definition, references, renaming, outline, formatting. It needs the extra
    'lsp': pip install "fuzzyctl[lsp]"
    """
    if sys.stdin.isatty():
        say("fuzzyctl lsp is started by an editor, which speaks with it; Ctrl-C ends it.", err=True)
    try:
        from fuzzyctl.editor.server import server
    except ImportError as error:
        say(f'error: the language server needs {error.name}: pip install "fuzzyctl[lsp]"', err=True)
        return FAILED
    server.start_io()
    # The server closes the streams at its end, and the command flushes them.
    sys.stdout = sys.stderr
    return DONE
