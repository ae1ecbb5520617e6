"""What commands write to a terminal, to a pipe and to a full disk."""

import os
import re
import struct
import sys
import threading
import warnings

import click
import pytest
from click.testing import CliRunner

from dwmr.cli.main import main as dwmr
from fuzzyctl.cli.main import main

pty = pytest.importorskip("pty", reason="there are no pseudo-terminals on this system")
fcntl = pytest.importorskip("fcntl", reason="there are no pseudo-terminals on this system")
termios = pytest.importorskip("termios", reason="there are no pseudo-terminals on this system")
Program = type(main)


def read(master, found):
    """Collect what a terminal shows; at its end Linux reports an error."""
    try:
        while part := os.read(master, 65536):
            found.append(part)
    except OSError:
        pass


@pytest.fixture
def shown(monkeypatch, tmp_path):
    """Return a function that runs a command with a stream on a terminal of some columns; it returns what is shown."""

    def run(words, stream="stdout", text="", columns=80, program=main):
        (tmp_path / "stdin").write_text(text, encoding="utf-8")
        found, (master, slave) = [], pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        reader = threading.Thread(target=read, args=[master, found])
        reader.start()
        with (
            monkeypatch.context() as patch,
            open(tmp_path / "stdin", encoding="utf-8") as stdin,
            open(os.devnull, "w", encoding="utf-8") as other,
            open(slave, "w", encoding="utf-8") as terminal,
        ):
            patch.setattr(sys, "stdin", stdin)
            for name in ("stdout", "stderr"):
                patch.setattr(sys, name, terminal if name == stream else other)
            with pytest.raises(SystemExit):
                program([str(word) for word in words], prog_name="fuzzyctl")
        reader.join()
        os.close(master)
        return b"".join(found).decode().replace("\r\n", "\n")

    monkeypatch.setenv("NO_COLOR", "1")
    return run


@pytest.fixture
def mistaken(tmp_path, base):
    path = tmp_path / "a.fz"
    path.write_text(base.replace("P", "a_rather_long_name_of_a_term", 1))
    return path


def test_a_terminal_gets_lines_of_its_width_with_carets_under_their_place(shown, mistaken):
    lines = shown(["check", mistaken], "stderr", columns=60).split("\n")
    carets = [k for k, line in enumerate(lines) if line.strip(" |^") == "" and "^" in line]
    assert carets
    for k in carets:
        assert lines[k - 1][lines[k].index("^")] not in " |"
    assert [line for line in lines if len(line) > 60 and " " in line.strip(" =") and str(mistaken) not in line] == []


def test_a_pipe_gets_one_line_for_each_message(shown, mistaken):
    in_pipe = CliRunner().invoke(main, ["check", str(mistaken)]).stderr
    on_terminal = shown(["check", mistaken], "stderr", columns=60)
    assert " ".join(in_pipe.split()) == " ".join(on_terminal.split())
    assert len(in_pipe.split("\n")) < len(on_terminal.split("\n"))


@pytest.mark.parametrize("arguments", [["fmt", "-"], ["fmt", "--diff", "-"], ["convert", "-", "-", "--to", "fz"]])
def test_data_does_not_control_a_terminal(shown, base, arguments):
    title = "\x1b]0;title\x07 \x9b31m"
    found = shown(arguments, text=base.replace('"Base"', f'"{title}"').replace("[-1, 1]", "[-1,1]"))
    assert "␛]0;title␇ \ufffd31m" in found
    assert not {"\x1b", "\x07", "\x9b"} & set(found)


REPORTS = [
    (["why", "tipper", "service=7", "food=8"], "\x1b[1mtip\x1b[0m = "),
    (["prove", "tipper"], "\x1b[1;32mproved\x1b[0m: bounded"),
    (["prove", "--bounds", "tipper", "--timeout", "0.1"], "\x1b[1mtip\x1b[0m: from "),
    (["simulate", "water_tank"], ": \x1b[1;32mmet\x1b[0m"),
    (["doctor"], "\x1b[1mbackend\x1b[0m: "),
    (["fmt", "--diff", "-"], "\x1b[31m-system  s\x1b[0m\n\x1b[32m+system s\x1b[0m"),
]


@pytest.mark.parametrize(("arguments", "part"), REPORTS, ids=[words[0] for words, _ in REPORTS])
def test_a_terminal_gets_reports_in_colour_and_of_its_width(shown, monkeypatch, arguments, part):
    monkeypatch.delenv("NO_COLOR")
    monkeypatch.setenv("TERM", "xterm")
    found = shown(arguments, text="system  s\n")
    assert part in found
    plain = re.sub(r"\x1b\[[0-9;]*m", "", found)
    assert "\x1b" not in plain
    assert [line for line in plain.split("\n") if len(line) > 80 and " " in line.strip()] == []


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="the platform has no full device")
@pytest.mark.parametrize(
    ("program", "words"), [(main, "eval tipper service=1 food=2"), (main, "--help"), (dwmr, "--help"), (dwmr, "show")]
)
def test_a_full_disk_is_reported_in_one_line(program, words, monkeypatch, capsys):
    with open("/dev/full", "w") as full, monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", full)
        with pytest.raises(SystemExit) as stop:
            program(words.split(), prog_name="program")
    assert stop.value.code == 1
    assert capsys.readouterr().err == "error: the output cannot be written: No space left on device\n"


def test_an_interruption_is_a_single_line():
    @click.command()
    def endless():
        raise KeyboardInterrupt

    done = CliRunner().invoke(Program("program", [endless]), ["endless"])
    assert (done.exit_code, done.stdout, done.stderr) == (130, "", "interrupted\n")


@pytest.mark.filterwarnings("default")
def test_a_warning_is_a_single_line_without_the_place_in_the_program():
    @click.command()
    def slow():
        warnings.warn("it takes longer", RuntimeWarning, stacklevel=1)

    assert CliRunner().invoke(Program("program", [slow]), ["slow"]).stderr == "warning: it takes longer\n"


class TestProgress:
    """A line or a bar says how far long work is, on terminals only."""

    CLAIM = (
        "system s\ndefuzzifier weighted_average\ninput x in [0, 1]\n  a = gaussian(0, 0.4)\n  b = gaussian(1, 0.4)\n"
        "output y in [0, 1]\n  p = constant(0)\n  q = constant(1)\nif x is a then y is p\nif x is b then y is q\n"
        "require y <= x + 0.2\n"
    )

    @pytest.mark.parametrize(("patience", "stream"), [(0.0, "stderr"), (0.0, "stdout"), (1000.0, "stderr")])
    def test_proofs_tell_of_their_boxes_once_they_take_long(self, shown, monkeypatch, patience, stream):
        monkeypatch.setattr("fuzzyctl.cli.progress.PATIENCE", patience)
        monkeypatch.setenv("TERM", "xterm")
        found = shown(["prove", "-"], stream, self.CLAIM)
        is_shown = re.search(r"y <= x \+ 0\.2: \d+ boxes settled, \d+ open", found) is not None
        assert is_shown == (patience == 0.0 and stream == "stderr")

    def test_runs_have_a_bar_with_a_remark_until_it_moves(self, shown, monkeypatch, tmp_path):
        monkeypatch.setenv("TERM", "xterm")
        (tmp_path / "a.fz").write_text(
            "plant p\ninput u\nparam T = 1\nstate x = 0\nder x = (u - x) / T\noutput y = x\n"
            "loop a\nblock p = p(1)\nmeasure end = final(p.y)\nrun 1 s step 0.1 s\n",
            encoding="utf-8",
        )
        (tmp_path / "spec.toml").write_text('scenario = "a.fz"\n[grid]\n"p.T" = [1.0, 2.0]\n', encoding="utf-8")
        words = ["sweep", tmp_path / "spec.toml", "-o", tmp_path / "out", "--jobs", 1]
        assert "compiling" not in shown(words, "stdout")
        (tmp_path / "out" / "results.csv").unlink()
        found = shown(words, "stderr", columns=120)
        assert "2 runs (compiling at the first run)" in found
        assert re.search(r"2 runs .*100 %.* left", found)

    def test_stages_take_each_others_place(self, shown, monkeypatch, tmp_path):
        monkeypatch.setenv("TERM", "xterm")
        words = ["run", "paper", "--controller", "smc", "--set", "run.horizon=0.5", "-o", tmp_path / "out"]
        found = shown(words, "stderr", program=dwmr)
        assert found.index("reading") < found.index("measuring") < found.index("writing")
        assert "reading" not in found[found.index("measuring") :]
