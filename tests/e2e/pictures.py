"""The pictures of README and docs: above each stands what makes it.

- `<!-- COMMAND -->`: the command writes a file of the picture's name, in a folder with the shipped rules and
  the files of the page.
- `<!-- terminal: COMMAND -->`: the picture is what the command prints.
- `<!-- picture: FILE -->`: the examples of the page leave this file.
- `<!-- studio: FILE -->`: the job that drives the studio leaves this file, `apps/studio/test/job.sh`.
- `<!-- browser: FILE -->`: the job that opens pages does, `tests/browser/job.sh`.

`python tests/e2e/pictures.py` makes all of them again, `python tests/e2e/pictures.py PAGE ...` those of some pages.
`python tests/e2e/pictures.py --studio FOLDER` compares those of the studio with what its job left in a folder;
`PICTURES=FOLDER apps/studio/test/job.sh PYTHON` and then `--store-studio FOLDER` makes them again. `--browser` and
`--store-browser` do the same for those of the pages.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from tests.e2e.commands import run_here  # noqa: E402 - as a script it finds no tests otherwise
from tests.e2e.pages import PAGES, blocks, follow  # noqa: E402
from tests.e2e.terminal import picture_of  # noqa: E402

FORM = re.compile(
    r"^<!-- (?:(terminal|picture|studio|browser): )?(.+) -->\n!\[[^\]]{20,}\]\((.+)\)$", flags=re.MULTILINE
)

#: Kinds of pictures that a job in a browser leaves.
JOBS = ("studio", "browser")
#: Colours of a PNG, the more where the fewer would be seen, as in shades: its size is a third of that with all of them.
COLOURS = (64, 128)
#: What is seen: this difference, of 255, in this share of the pixels.
SEEN = (8, 0.0025)
#: The environment of the commands.
SHOWN = {"MPLBACKEND": "Agg", "NO_COLOR": "1", "COLUMNS": "100"}


class Picture(NamedTuple):
    """A picture of a page: what makes it, the kind of that, and its file."""

    page: Path
    kind: str
    source: str
    path: Path


def pictures(page: Path) -> Iterator[Picture]:
    """Yield the pictures of a page that something makes."""
    for kind, source, path in FORM.findall(page.read_text(encoding="utf-8")):
        yield Picture(page, kind or "command", source, (page.parent / path).resolve())


def is_example(picture: Picture) -> bool:
    """Whether the command of a picture is an example of its page, which is run there."""
    text = picture.page.read_text(encoding="utf-8")
    return picture.kind == "command" and f"$ {picture.source}\n" in text


def made(picture: Picture, folder: Path) -> Path:
    """Run the command of a picture in a folder and return the file that it writes there."""
    shutil.copytree(ROOT / "rules", folder / "rules")
    for block in blocks(picture.page):
        if block.file:
            (folder / block.file).write_text(block.text, encoding="utf-8")
    with contextlib.chdir(folder):
        status, printed = run_here(picture.source, SHOWN) or (1, "a command of the project is expected")
    if picture.kind == "terminal":
        found = folder / picture.path.name
        found.write_text(picture_of(picture.source, printed), encoding="utf-8")
        return found
    assert status == 0, printed
    (found,) = folder.rglob(picture.path.name)
    return found


def excess(stored: Path, drawn: Path) -> float:
    """Return by how much two pictures differ more than they may: 0 where they are the same.

    Of PNGs it is the share of squares with another colour, so that a line that moves counts; letters and edges of
    another version of matplotlib may differ in a twentieth of all squares. Of an SVG, a text here, each letter counts.
    """
    if stored.suffix == ".svg":
        return float(stored.read_text(encoding="utf-8") != drawn.read_text(encoding="utf-8"))
    a, b = blocks_of(stored), blocks_of(drawn)
    if a.shape != b.shape:
        return 1.0
    program = drawn_by(stored)
    allowed = 0.0005 if program and program == drawn_by(drawn) else 0.05
    return max(0.0, float((np.abs(a - b).max(axis=2) > 0.05).mean()) - allowed)


def drawn_by(path: Path) -> str:
    """Return the program and version that drew a PNG or a film."""
    with Image.open(path) as picture:
        return str(picture.info.get("Software") or picture.info.get("comment", ""))


def blocks_of(path: Path, size: int = 15) -> np.ndarray:
    """Return the mean colours of squares of a picture, 0 to 1; of the last one of a film, which shows all trails."""
    with Image.open(path) as picture:
        picture.seek(getattr(picture, "n_frames", 1) - 1)
        pixels = np.asarray(picture.convert("RGB")) / 255.0
    high, wide = (n // size for n in pixels.shape[:2])
    return pixels[: high * size, : wide * size].reshape(high, size, wide, size, 3).mean(axis=(1, 3))


def store(drawn: Path, path: Path) -> None:
    """Copy a picture to its place, a PNG with few colours."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".png":
        with Image.open(drawn) as picture:
            by = PngInfo()
            by.add_text("Software", drawn_by(drawn))
            with_few_colours(picture.convert("RGB")).save(path, optimize=True, pnginfo=by)
    else:
        shutil.copyfile(drawn, path)
    print(f"wrote {path.relative_to(ROOT)}")


def with_few_colours(picture: Image.Image) -> Image.Image:
    """Return a picture with as few colours as show no difference, at the most with the larger number of them."""
    few, many = (picture.quantize(n, Image.Quantize.MAXCOVERAGE, 1, dither=Image.Dither.NONE) for n in COLOURS)
    difference = np.abs(np.asarray(few.convert("RGB"), dtype=np.int16) - np.asarray(picture)).max(axis=2)
    return few if (difference > SEEN[0]).mean() <= SEEN[1] else many


def of_a_job(kind: str, folder: Path, *, stored: bool) -> int:
    """Store the pictures that a browser's job left in a folder, or return 1 where one differs from its stored one."""
    found = [p for page in PAGES for p in pictures(page) if p.kind == kind]
    if stored:
        for picture in found:
            store(folder / picture.source, picture.path)
        return 0
    stale = [p for p in found if not p.path.exists() or excess(p.path, folder / p.source) > 0.0]
    for picture in stale:
        print(f"{picture.path.relative_to(ROOT)} is not what the {kind} shows now; see {Path(__file__).name}")
    return 1 if stale else 0


def main(names: list[str]) -> int:
    """Make the pictures of some pages again, of all without a name; compare or store those of a browser's job."""
    if names and names[0] in {f"--{store}{kind}" for store in ("", "store-") for kind in JOBS}:
        return of_a_job(names[0].rpartition("-")[2], Path(names[1]), stored=names[0].startswith("--store-"))
    pages = [Path(name).resolve() for name in names] or PAGES
    os.environ |= SHOWN
    for page in pages:
        found = list(pictures(page))
        for picture in found:
            if picture.kind not in ("picture", *JOBS):
                with tempfile.TemporaryDirectory() as folder:
                    store(made(picture, Path(folder)), picture.path)
        if left := [p for p in found if p.kind == "picture"]:
            with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
                shutil.copytree(ROOT / "rules", "rules")
                follow(page, Path(folder))
                for picture in left:
                    store(Path(picture.source), picture.path)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
