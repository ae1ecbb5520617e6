"""Diagnostics on a terminal and in a pipe."""

import os
import re
import struct
import subprocess
import sys
import warnings

import click
import pytest
from click.testing import CliRunner

import fuzzyctl
from fuzzyctl.cli.simulate import text_of
from fuzzyctl.cli.streams import Program

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


def output_of(arguments, text="", columns=80, **environment):
    """Run a command whose standard output is a terminal, without colours by default; return what it prints there."""
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    command = [sys.executable, "-c", "from fuzzyctl.cli.main import main; main()", *map(str, arguments)]
    environment = {"NO_COLOR": "1"} | os.environ | {"PYTHONUTF8": "1"} | environment
    environment = {name: value for name, value in environment.items() if value}
    with subprocess.Popen(command, env=environment, stdin=subprocess.PIPE, stdout=slave) as running:
        os.close(slave)
        running.stdin.write(text.encode())
        running.stdin.close()
        found = b""
        while part := read(master):
            found += part
    os.close(master)
    return found.decode().replace("\r\n", "\n")


@pytest.mark.parametrize("arguments", [["fmt", "-"], ["fmt", "--diff", "-"], ["convert", "-", "-", "--to", "fz"]])
def test_data_does_not_control_a_terminal(base, arguments):
    title = "\x1b]0;title\x07 \x9b31m"
    text = base.replace('"Base"', f'"{title}"').replace("[-1, 1]", "[-1,1]")
    shown = output_of(arguments, text)
    assert "␛]0;title␇ \ufffd31m" in shown
    assert not {"\x1b", "\x07", "\x9b"} & set(shown)


REPORTS = [
    (["why", "tipper", "service=7", "food=8"], "\x1b[1mtip\x1b[0m = "),
    (["prove", "tipper"], "\x1b[1;32mproved\x1b[0m: bounded"),
    (["prove", "--bounds", "tipper", "--timeout", "0.1"], "\x1b[1mtip\x1b[0m: from "),
    (["simulate", "water_tank"], ": \x1b[1;32mmet\x1b[0m"),
    (["doctor"], "\x1b[1mbackend\x1b[0m: "),
]


@pytest.mark.parametrize(("arguments", "part"), REPORTS, ids=[words[0] for words, _ in REPORTS])
def test_a_terminal_gets_reports_in_colour_and_of_its_width(arguments, part):
    shown = output_of(arguments, NO_COLOR="", TERM="xterm")
    assert part in shown
    plain = re.sub(r"\x1b\[[0-9;]*m", "", shown)
    assert "\x1b" not in plain
    assert [line for line in plain.split("\n") if len(line) > 80 and " " in line.strip()] == []


def test_an_interruption_is_a_single_line():
    @click.command()
    def endless():
        raise KeyboardInterrupt

    program = Program("program", [endless])
    done = CliRunner().invoke(program, ["endless"])
    assert (done.exit_code, done.stdout, done.stderr) == (130, "", "interrupted\n")


@pytest.mark.filterwarnings("default")
def test_a_warning_is_a_single_line_without_the_place_in_the_program():
    @click.group(cls=Program)
    def program():
        pass

    @program.command()
    def slow():
        warnings.warn("it takes longer", RuntimeWarning, stacklevel=1)

    result = CliRunner().invoke(program, ["slow"])
    assert result.stderr == "warning: it takes longer\n"


def test_a_table_of_runs_that_is_wider_than_the_terminal_is_printed_in_parts():
    labels = ["first", "second", "third", "fourth"]
    runs = dict.fromkeys(labels, fuzzyctl.simulate(fuzzyctl.load("water_tank", block=fuzzyctl.Loop)))
    whole, parts = text_of(runs).split("\n"), text_of(runs, 60).split("\n")
    assert [line.split() for line in whole if line.startswith("measure")] == [["measure", *labels]]
    heads = [line.split() for line in parts if line.startswith("measure")]
    assert heads == [["measure", "first", "second"], ["measure", "third", "fourth"]]
    assert max(len(line) for line in parts if line.startswith(("measure", "lowest"))) <= 60
