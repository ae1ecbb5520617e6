"""The README in a fresh terminal, its pictures, and the files that say who made what."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import fuzzyctl
from tests.e2e.pages import DOCS, ROOT, blocks
from tests.e2e.pictures import blocks_of, made, pictures


def test_the_commands_work_in_a_terminal_that_has_only_the_environment_of_the_first_line(tmp_path: Path) -> None:
    (block,) = [b for b in blocks(ROOT / "README.md") if b.language == "console"]
    commands = re.findall(r"^\$ (.+)$", block.text, flags=re.MULTILINE)
    assert any(c.startswith("fuzzyctl") for c in commands)
    shutil.copytree(ROOT / "rules", tmp_path / "rules")
    (tmp_path / ".venv").symlink_to(sys.prefix)
    environment = {k: v for k, v in os.environ.items() if k not in ("PATH", "VIRTUAL_ENV")} | {"PATH": "/usr/bin:/bin"}
    assert shutil.which("fuzzyctl", path=environment["PATH"]) is None
    done = subprocess.run(
        ["/bin/sh", "-euc", "\n".join(commands)],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_there_are_two_pictures() -> None:
    shown = re.findall(r"!\[", (ROOT / "README.md").read_text(encoding="utf-8"))
    assert len(list(pictures())) == len(shown) == 2


@pytest.mark.parametrize(("command", "path"), list(pictures()), ids=lambda v: str(v))
def test_a_picture_is_what_its_command_draws(command: str, path: Path, tmp_path: Path) -> None:
    """Up to the letters and edges of another version of matplotlib."""
    stored, drawn = (blocks_of(p) for p in (ROOT / path, made(command, path.name, tmp_path)))
    assert stored.shape == drawn.shape
    assert np.abs(stored - drawn).mean() < 0.005


def test_versions_and_names_agree() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {fuzzyctl.__version__}\n" in citation
    assert project["version"] == fuzzyctl.__version__
    assert f"\nlicense: {project['license']}\n" in citation
    assert f"- name: {project['authors'][0]['name']}\n" in citation
    for page in (ROOT / "README.md", DOCS / "explanation" / "the-paper.md"):
        title = re.search(r'"(Adaptive immune [^"]+)"', page.read_text(encoding="utf-8"))
        assert title is not None
        assert " ".join(title[1].rstrip(".").split()) in " ".join(citation.split())
