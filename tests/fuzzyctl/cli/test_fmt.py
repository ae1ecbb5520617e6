"""Differences that `fuzzyctl fmt` prints, and pipes; transcripts/fmt.txt holds the rest."""

import os
import re
import threading

import pytest

from tests.commands import runner

run = runner("fmt")


def patched(before, diff):
    """Apply a unified diff as `patch` does."""
    lines, found, at = before.split("\n"), [], 0
    for line in diff.split("\n")[2:]:
        if line.startswith("@@"):
            start = int(re.findall(r"\d+", line)[0]) - 1
            found += lines[at:start]
            at = start
        elif line[:1] in ("-", " "):
            assert lines[at] == line[1:]
            at += 1
        if line[:1] in ("+", " "):
            found.append(line[1:])
        assert not line.startswith("\\") or not before.endswith("\n")
    return "\n".join([*found, *(lines[at:] if before.endswith("\n") else [""])])


@pytest.mark.parametrize("change", [str, lambda t: t.rstrip("\n"), lambda t: t.replace("\n", "\r\n")])
def test_patch_makes_the_canonical_layout_of_a_difference(tmp_path, base, change):
    path = tmp_path / "a.fz"
    path.write_bytes(change(base.replace("  N |", "N|").replace("[0, 10]", "[ 0,10 ]")).encode())
    diff = run("--diff", path).stdout_bytes.decode()
    assert patched(path.read_bytes().decode(), diff) == base
    run(path)
    assert path.read_bytes() == base.encode()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the platform has no named pipes")
def test_a_pipe_is_read_once(tmp_path, base):
    os.mkfifo(tmp_path / "pipe.fz")
    writer = threading.Thread(target=(tmp_path / "pipe.fz").write_text, args=[base])
    writer.start()
    result = run("--check", tmp_path / "pipe.fz")
    writer.join()
    assert (result.exit_code, result.output) == (0, "")
