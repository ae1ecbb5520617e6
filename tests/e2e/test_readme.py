"""The README in a fresh terminal, its pictures, and the files that say who made what."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from PIL import Image

import fuzzyctl
from tests.e2e.commands import run_here
from tests.e2e.pages import DOCS, PAGES, ROOT, blocks, without_code
from tests.e2e.pictures import JOBS, Picture, excess, is_example, made, pictures
from tests.e2e.terminal import picture_of


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
def test_the_commands_work_in_a_terminal_that_has_only_the_environment_of_the_first_line(tmp_path: Path) -> None:
    readme = list(blocks(ROOT / "README.md"))
    commands = [
        c for b in readme if b.language == "console" for c in re.findall(r"^\$ (.+)$", b.text, flags=re.MULTILINE)
    ]
    assert {c.split()[0] for c in commands} >= {"fuzzyctl", "cc"}
    for block in readme:
        if block.file:
            (tmp_path / block.file).write_text(block.text, encoding="utf-8")
    assert "`. .venv/bin/activate`" in (ROOT / "README.md").read_text(encoding="utf-8")
    (tmp_path / ".venv").symlink_to(sys.prefix)
    environment = {k: v for k, v in os.environ.items() if k not in ("PATH", "VIRTUAL_ENV")} | {"PATH": "/usr/bin:/bin"}
    assert shutil.which("fuzzyctl", path=environment["PATH"]) is None
    done = subprocess.run(
        ["/bin/sh", "-uc", "\n".join([". .venv/bin/activate", *commands])],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "not found" not in done.stderr


def test_something_makes_every_picture_and_says_so() -> None:
    for page in PAGES:
        shown = re.findall(r"!\[[^\]]*\]\((?!http)(?!performance/)", without_code(page))
        assert len(list(pictures(page))) == len(shown), page
    found = [picture.path for page in PAGES for picture in pictures(page)]
    assert sorted(found) == sorted(path for path in (DOCS / "images").rglob("*") if path.is_file())
    assert sum(path.stat().st_size for path in found) < 700_000


@pytest.mark.parametrize(
    "picture",
    [p for page in PAGES for p in pictures(page) if p.kind not in ("picture", *JOBS) and not is_example(p)],
    ids=lambda p: str(p.path.name),
)
def test_a_picture_is_what_its_command_draws(picture: Picture, tmp_path: Path) -> None:
    assert excess(picture.path, made(picture, tmp_path)) == 0.0


def test_a_term_that_moves_is_seen(tmp_path: Path) -> None:
    text = (ROOT / "rules" / "tipper.fz").read_text(encoding="utf-8")
    (tmp_path / "moved.fz").write_text(text.replace("gaussian(10, 1.5)", "gaussian(9.5, 1.5)"), encoding="utf-8")
    command = f"fuzzyctl why {tmp_path}/moved.fz service=7 food=8 -o {tmp_path}/moved.png"
    assert run_here(command, {}) is not None
    assert excess(DOCS / "images" / "rules.png", tmp_path / "moved.png") > 0.001


def test_a_film_that_ends_elsewhere_is_seen(tmp_path: Path) -> None:
    stored = DOCS / "images" / "moving-obstacles.gif"
    with Image.open(stored) as film:
        film.seek(film.n_frames - 3)
        film.convert("RGB").save(tmp_path / "shorter.gif")
    assert excess(stored, stored) == 0.0
    assert excess(stored, tmp_path / "shorter.gif") > 0.01


def test_a_terminal_shows_its_text() -> None:
    text = picture_of("fuzzyctl check <a>", "a.fz:1:2: error[FZ203]: no <term>\n  |\n  |   ^^\n  = help: x & y\n")
    assert "<a>" not in text
    assert '<tspan class="error">error[FZ203]:</tspan> no &lt;term&gt;' in text
    assert '<tspan class="error">  |   ^^</tspan>' in text
    assert '<tspan class="help">  = help: x &amp; y</tspan>' in text


def test_versions_and_names_agree() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {fuzzyctl.__version__}\n" in citation
    assert project["version"] == fuzzyctl.__version__
    studio = tomllib.loads((ROOT / "apps" / "studio" / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["optional-dependencies"]["studio"] == [f"{studio['name']}=={fuzzyctl.__version__}"]
    assert studio["version"] == fuzzyctl.__version__
    assert f"\nlicense: {project['license']}\n" in citation
    assert f"- name: {project['authors'][0]['name']}\n" in citation
    for page in (ROOT / "README.md", DOCS / "explanation" / "the-paper.md"):
        title = re.search(r'"(Adaptive immune [^"]+)"', page.read_text(encoding="utf-8"))
        assert title is not None
        assert " ".join(title[1].rstrip(".").split()) in " ".join(citation.split())
