"""The pictures of the README: above each stands the command that makes it.

`python tests/e2e/pictures.py` makes them again.
"""

from __future__ import annotations

import contextlib
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from matplotlib import image

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from tests.e2e.commands import run_here  # noqa: E402 - as a script it finds no tests otherwise

FORM = re.compile(r"^<!-- (.+) -->\n!\[.+\]\((docs/images/.+)\)$", flags=re.MULTILINE)


def pictures() -> Iterator[tuple[str, Path]]:
    """Yield each command with the file of its picture, relative to the project."""
    for command, path in FORM.findall((ROOT / "README.md").read_text(encoding="utf-8")):
        yield command, Path(path)


def made(command: str, name: str, folder: Path) -> Path:
    """Run a command in a folder and return the file of some name that it writes there."""
    shutil.copytree(ROOT / "rules", folder / "rules")
    with contextlib.chdir(folder):
        status, printed = run_here(command, {"MPLBACKEND": "Agg"}) or (1, "a command of the project is expected")
    assert status == 0, printed
    (found,) = folder.rglob(name)
    return found


def blocks_of(path: Path, size: int = 15) -> np.ndarray:
    """Return the mean colours of squares of a picture."""
    pixels = image.imread(path)[:, :, :3]
    high, wide = (n // size for n in pixels.shape[:2])
    return pixels[: high * size, : wide * size].reshape(high, size, wide, size, 3).mean(axis=(1, 3))


def main() -> None:
    """Make all of them again."""
    for command, path in pictures():
        with tempfile.TemporaryDirectory() as folder:
            (ROOT / path).parent.mkdir(exist_ok=True)
            shutil.copyfile(made(command, path.name, Path(folder)), ROOT / path)
        print(f"wrote {path}: {command}")


if __name__ == "__main__":
    sys.exit(main())
