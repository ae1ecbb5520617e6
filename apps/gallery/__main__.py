"""`python -m gallery [NAME ...]`: run loops of the gallery, and make their tables and pictures again."""

from __future__ import annotations

import sys

from gallery.pages import entries, remade

if __name__ == "__main__":
    known = entries()
    if unknown := [name for name in sys.argv[1:] if name not in known]:
        sys.exit(f"no such loop: {', '.join(unknown)}; there are {', '.join(known)}")
    for name in sys.argv[1:] or known:
        print(remade(known[name]))
