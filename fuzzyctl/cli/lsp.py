"""`fuzzyctl lsp`: the language server for editors."""

from __future__ import annotations

import sys

import click

from fuzzyctl.cli.common import DONE, FAILED, answers_with_diagnostics
from fuzzyctl.cli.streams import say


@click.command()
@answers_with_diagnostics
def lsp() -> int:
    """Serve an editor over standard input and output.

    Editors start this command themselves and speak the Language Server Protocol with it: mistakes while one types,
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
