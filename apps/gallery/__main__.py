"""`python -m gallery [NAME ...]`: run loops of the gallery, and make their tables and pictures again."""

from __future__ import annotations

import argparse

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from gallery.pages import entries, remade


def main() -> None:
    """Make the pages that are named, or all of them."""
    known = entries()
    parser = argparse.ArgumentParser(
        prog="python -m gallery", description="Run loops of the gallery, and make their tables and pictures again."
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"pages, all where none is named: {', '.join(known)}")
    names = parser.parse_args().names
    if unknown := [name for name in names if name not in known]:
        parser.error(f"no such page: {', '.join(unknown)}; there are {', '.join(known)}")
    for name in names or known:
        try:
            print(remade(known[name]))
        except DiagnosticError as error:
            parser.exit(1, f"{error}\n")


if __name__ == "__main__":
    main()
