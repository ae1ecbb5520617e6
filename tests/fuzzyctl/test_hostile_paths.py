"""Names of files that a file gives: none of them blocks, and each is a diagnostic at its place."""

import os
import subprocess
import sys

import pytest

from fuzzyctl import DiagnosticError, load, loads
from fuzzyctl.testing import check_text

SYSTEM = """
system s
input x in [0, 1]
  terms a b
output y in [0, 1]
  terms a b
defuzzifier center_average
"""
TABLE = SYSTEM + 'table y = x from "NAME"\n'
USE = 'use "NAME"\n' + SYSTEM + "if x is a then y is a\nif x is b then y is b\n"

needs_pipes = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the platform has no named pipes")


def check(folder, *arguments):
    """Run `fuzzyctl check` in a process of its own, which a pipe without a writer would block."""
    code = "from fuzzyctl.cli.main import main; main()"
    words = [sys.executable, "-c", code, "check", *arguments]
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=120, check=False)


def found(tmp_path, text, name):
    _, diagnostics = check_text(text.replace("NAME", name), str(tmp_path / "main.fz"), folder=tmp_path)
    return [d for d in diagnostics if d.code == "FZ218"]


@needs_pipes
@pytest.mark.parametrize("text", [USE, TABLE], ids=["use", "table"])
def test_a_pipe_is_refused_at_its_name(tmp_path, text):
    os.mkfifo(tmp_path / "pipe.fz")
    (tmp_path / "main.fz").write_text(text.replace("NAME", "pipe.fz"))
    done = check(tmp_path, "main.fz")
    assert done.returncode == 1
    assert '"pipe.fz" cannot be used: this is not a regular file' in done.stderr
    assert "main.fz:" in done.stderr


@needs_pipes
@pytest.mark.parametrize("text", [USE, TABLE], ids=["use", "table"])
def test_a_link_to_a_device_is_refused(tmp_path, text):
    (tmp_path / "link.fz").symlink_to("/dev/tty")
    (diagnostic,) = found(tmp_path, text, "link.fz")
    assert "lies outside the folder" in diagnostic.message


@needs_pipes
def test_a_user_may_name_a_pipe(tmp_path):
    """As shells do for `<(command)`."""
    os.mkfifo(tmp_path / "pipe.fz")
    text = SYSTEM + "if x is a then y is a\nif x is b then y is b\n"
    code = f"open({str(tmp_path / 'pipe.fz')!r}, 'w').write({text!r})"
    with subprocess.Popen([sys.executable, "-c", code]):
        assert load(tmp_path / "pipe.fz") == loads(text)


@pytest.mark.parametrize("text", [USE, TABLE], ids=["use", "table"])
@pytest.mark.parametrize(
    "name",
    ["a" * 300 + ".fz", "a/" * 3000 + "b.fz", "loop.fz", "a.**", "a.[!", "missing/deep.fz", "\x1b[2J.fz", "ü" * 200],
    ids=["component", "path", "loop", "stars", "bracket", "folder", "control", "bytes"],
)
def test_names_that_no_file_can_have_are_diagnostics(tmp_path, text, name):
    if name == "loop.fz":
        (tmp_path / "loop.fz").symlink_to("loop.fz")
    (diagnostic,) = found(tmp_path, text, name)
    assert diagnostic.span.line in (1, 8)


def test_a_missing_file_in_a_folder_that_cannot_be_listed_is_a_diagnostic(tmp_path, monkeypatch):
    def refuse(*_):
        raise PermissionError

    monkeypatch.setattr(os, "listdir", refuse)
    with pytest.raises(DiagnosticError, match="no such file"):
        load(tmp_path / "missing.fz")
    with pytest.raises(DiagnosticError, match="FZ001"):
        load(tmp_path / ("a" * 300) / "missing.fz")
