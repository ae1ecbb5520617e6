"""`python -m gallery [NAME ...]`: run loops of the gallery, and make their tables and pictures again."""

from __future__ import annotations

import argparse

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from gallery.pages import entries, remade


def main() -> None:
    """Make the pages that are named, or all of them."""
    pages = entries()
    parser = argparse.ArgumentParser(
        prog="python -m gallery", description="Run loops of the gallery, and make their tables and pictures again."
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"pages, by default all: {', '.join(pages)}")
    names = parser.parse_args().names
    if unknown := [name for name in names if name not in pages]:
        parser.error(f"no such page: {', '.join(unknown)}; there are {', '.join(pages)}")
    for name in names or pages:
        try:
            print(remade(pages[name]))
        except DiagnosticError as error:
            parser.exit(1, f"{error}\n")


if __name__ == "__main__":
    main()
