"""Follows README and all pages of docs/ with the wheel alone: `python tests/e2e/follow_pages.py`.

It builds the wheel, installs it into an empty environment, and follows the pages one after the other in one folder that
is empty at first, then once more. Each difference between what a page says and what comes out ends it with exit code 1,
and so does a file that two pages write with different contents. A page whose first line says `pip install PACKAGE`
is followed once that is installed; `--pages WORD` follows those with the word in their paths.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
import traceback
import venv
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pages", default="", metavar="WORD", help="follow pages with this word in their paths")
    parser.add_argument("--inside", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.inside is not None:
        return inside(given.inside, given.pages)
    with tempfile.TemporaryDirectory() as made:
        return outside(Path(made), given.pages)


def outside(folder: Path, word: str) -> int:
    """Make the environment and follow the pages in it."""
    subprocess.run([sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", folder, ROOT], check=True)
    venv.create(folder / "env", with_pip=True)
    python = folder / "env" / "bin" / "python"
    (wheel,) = folder.glob("*.whl")
    subprocess.run([python, "-m", "pip", "install", "-q", wheel], check=True)
    # Of the checkout only pages and what follows them.
    for part in ("docs", "tests"):
        shutil.copytree(ROOT / part, folder / "tree" / part)
    shutil.copy(ROOT / "README.md", folder / "tree")
    (folder / "empty").mkdir()
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "FUZZYCTL"))}
    environment |= {
        "FUZZYCTL_CACHE_DIR": str(folder / "cache"),
        "MPLBACKEND": "Agg",
        "VIRTUAL_ENV": str(folder / "env"),
    }
    script = folder / "tree" / "tests" / "e2e" / "follow_pages.py"
    command = [python, script, "--inside", wheel, "--pages", word]
    return subprocess.run(command, cwd=folder / "empty", env=environment, check=False).returncode


def inside(wheel: Path, word: str) -> int:
    """Follow the pages twice in the current folder; return 1 for differences."""
    sys.path.insert(0, str(ROOT))
    from tests.e2e.pages import PAGES, needs

    pages = [page for page in PAGES if word in str(page.relative_to(ROOT))]
    pages.sort(key=lambda page: bool(needs(page)))
    folder, found = Path.cwd(), list[str]()
    owners: dict[Path, Path] = {}
    for time in range(2):
        for page in pages:
            if time == 0 and (packages := needs(page)):
                packages = tuple(re.sub(r"^fuzzyctl(?=\[)", str(wheel), name) for name in packages)
                subprocess.run([sys.executable, "-m", "pip", "install", "-q", *packages], check=True)
            before = contents(folder)
            differences = list(followed(page, folder, time))
            after = contents(folder)
            for path in (p for p in after if before.get(p) != after[p]):
                other = owners.setdefault(path, page)
                if other != page and time == 0:
                    first = other.relative_to(ROOT)
                    differences.append(f"{page.relative_to(ROOT)}: it writes {path} of {first} with other content")
            print("\n".join([*differences, f"{page.relative_to(ROOT)}: {len(differences)} differences"]), flush=True)
            found += differences
    print(f"{len(pages)} pages, followed twice: {len(found)} differences")
    return 1 if found else 0


def followed(page: Path, folder: Path, time: int) -> Iterator[str]:
    """Run the blocks of a page; yield what differs."""
    from tests.e2e.pages import Session, blocks

    session = Session(page, folder, " (followed before)" if time else "", in_process=True)
    for block in blocks(page):
        if block.once and time:
            continue
        try:
            session.run(block)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a block may raise anything; it is reported
            yield f"{session.where(block)}: {error if isinstance(error, AssertionError) else traceback.format_exc()}"
            session.status = 0
    os.chdir(folder)
    if session.status:
        yield f"{page.relative_to(ROOT)}: the last command left with {session.status}, which the page does not show"


def contents(folder: Path) -> dict[Path, str]:
    """Return checksums of all files of a folder, by path from there."""
    paths = [path for path in folder.rglob("*") if path.is_file() and not re.search("__pycache__", str(path))]
    return {path.relative_to(folder): hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}


if __name__ == "__main__":
    sys.exit(main())
