"""Diagnostics on a terminal and in a pipe."""

import os
import struct
import subprocess
import sys

import pytest

pty = pytest.importorskip("pty", reason="there are no pseudo-terminals on this system")
fcntl = pytest.importorskip("fcntl", reason="there are no pseudo-terminals on this system")
termios = pytest.importorskip("termios", reason="there are no pseudo-terminals on this system")


def errors_of(arguments, columns, **environment):
    """Run a command whose standard error is a terminal of some columns, or a pipe; return what it prints there."""
    environment = os.environ | {"NO_COLOR": "1", "PYTHONUTF8": "1"} | environment
    command = [sys.executable, "-c", "from fuzzyctl.cli.main import main; main()", *map(str, arguments)]
    if columns is None:
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=False).stderr
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    with subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=slave) as running:
        os.close(slave)
        found = b""
        while part := read(master):
            found += part
    os.close(master)
    assert running.returncode == 1
    return found.decode().replace("\r\n", "\n")


def read(master):
    """Return what a terminal shows next; at its end Linux reports an error."""
    try:
        return os.read(master, 65536)
    except OSError:
        return b""


@pytest.fixture
def mistaken(tmp_path, base):
    path = tmp_path / "a.fz"
    path.write_text(base.replace("P", "a_rather_long_name_of_a_term", 1))
    return path


def test_a_terminal_gets_lines_of_its_width_with_carets_under_their_place(mistaken):
    shown = errors_of(["check", mistaken], 60).split("\n")
    carets = [k for k, line in enumerate(shown) if line.strip(" |^") == "" and "^" in line]
    assert carets
    for k in carets:
        assert shown[k - 1][shown[k].index("^")] not in " |"
    assert [line for line in shown if len(line) > 60 and " " in line.strip(" =") and str(mistaken) not in line] == []


def test_a_pipe_gets_one_line_for_each_message(mistaken):
    in_pipe = errors_of(["check", mistaken], None)
    assert " ".join(in_pipe.split()) == " ".join(errors_of(["check", mistaken], 60).split())
    assert len(in_pipe.split("\n")) < len(errors_of(["check", mistaken], 60).split("\n"))
