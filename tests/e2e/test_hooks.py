"""Hooks of pre-commit and the action for GitHub: their commands do what they say; the services are not run."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent
HOOKS = (ROOT / ".pre-commit-hooks.yaml").read_text()
ACTION = (ROOT / "action.yml").read_text()


def fuzzyctl(words, *files):
    assert words[0] == "fuzzyctl"
    command = [sys.executable, "-m", *words, *map(str, files)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "a.fz"
    path.write_text(
        "system t\ninput x in [0, 1]\n  terms N P\noutput y in [0,1] else 0\n  terms a b\nif x is M then y is a\n"
    )
    return path


def test_hooks(path):
    entries = [entry.split() for entry in re.findall(r"entry: (.+)", HOOKS)]
    check, fmt = (fuzzyctl(words, path) for words in entries)
    assert (check.returncode, "has no term 'M'" in check.stderr) == (1, True)
    assert (fmt.returncode, "in [0, 1] else 0" in path.read_text()) == (0, True)
    (pattern,) = set(re.findall(r"files: (.+)", HOOKS))
    assert re.search(pattern, "rules/a.fz")
    assert not re.search(pattern, "a.fzz")


def test_the_action_annotates(path):
    (command,) = re.findall(r"run: (fuzzyctl .+)", ACTION)
    words = re.sub(r"\$\{\{.*?\}\}", "", command).split()
    done = fuzzyctl(words, path)
    assert done.returncode == 1
    assert done.stdout.startswith(f"::error file={path.as_posix()},line=6")
