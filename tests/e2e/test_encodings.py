"""Every command under encodings that are not UTF-8: text for people degrades, data is UTF-8, and nothing fails."""

import codecs
import io
import json
import os
import subprocess
import sys

import pytest

from dwmr.cli.main import main as dwmr
from fuzzyctl.cli.main import main as fuzzyctl
from tests.commands import commands_of

#: What cp1252 has, what it lacks, and what a terminal would act on: an escape sequence, C1 CSI, and an override.
TITLE = "Größe σ → 中 \x1b[31m\x1b]0;owned\x07 \x9b2J \u202eabc"
SYSTEM = f"""\
system s "{TITLE}"
source "{TITLE}"
input σ "{TITLE}" in [0, 10] unit "{TITLE}"
  terms niedrig höhe
output y "{TITLE}" in [0, 1] unit "{TITLE}"
  terms c d
defuzzifier center_average
table y = σ
     niedrig  höhe
  |  c        d
require bounded(y, 0, 1)
"""
POINTS = "σ,note\n3,ü→中\n"
SCENARIO = 'extends = "paper"\nname = "Größe σ →"\n[run]\nhorizon = 0.05\n'
SPEC = 'scenario = "mine.toml"\n[grid]\n"run.horizon" = [0.05, 0.06]\n'
#: The name of the rule file.
FILE = "σ→.fz"

#: Characters that a terminal acts on, apart from line ends.
ACTIVE = {*map(chr, (*range(10), *range(11, 32), *range(127, 160))), "\u202e"}

ENCODINGS = ["cp1252", "ascii", "latin-1"]

#: Arguments of each command; `-` reads `POINTS` or `SYSTEM`.
COMMANDS = {
    "check": [["check", FILE], ["check", "bad.fz"], ["check", "none→.fz"], ["check", "--format", "json", "bad.fz"]],
    "explain": [["explain"], ["explain", "FZ203"], ["explain", "--format", "json", "FZ203"]],
    "show": [["show", FILE], ["show", "--plan", FILE], ["show", "--format", "json", FILE]],
    "eval": [["eval", FILE, "σ=3"], ["eval", FILE], ["eval", FILE, "--points", "-"]],
    "prove": [["prove", FILE], ["prove", "--bounds", FILE], ["prove", "--format", "json", FILE]],
    "page": [["page", FILE, "-o", "→.html"], ["page", FILE, "--block", "→"]],
    "plot-surface": [["plot-surface", FILE, "-o", "σ.png"]],
    "plot": [["plot", "--terms", FILE, "-o", "τ.png"]],
    "fmt": [["fmt", "-"], ["fmt", "--check", "wide.fz"], ["fmt", "--diff", "wide.fz"]],
    "codegen": [["codegen", FILE, "--target", "python"]],
    "compare": [
        ["compare", FILE, "other.fz", "--points", "100"],
        ["compare", "--changes", FILE, "other.fz"],
        ["compare", "--changes", "--format", "json", FILE, "other.fz"],
    ],
    "convert": [["convert", FILE, "-", "--to", "fz"], ["convert", FILE, "→.fis", "--points", "100"]],
    "doctor": [["doctor"], ["doctor", "--format", "json"]],
    "new": [["new", "σ"], ["new", "→"]],
    "simulate": [["simulate", "loop.fz"], ["simulate", "loop.fz", "-o", "→", "--format", "json"], ["simulate", FILE]],
    "verify": [["verify", "→.json"]],
    "why": [["why", FILE, "σ=3"], ["why", "--format", "json", FILE, "σ=3"]],
}
ROBOTS = {
    "show": [["show"], ["show", "mine.toml"], ["show", "--format", "json", "mine.toml"]],
    "new": [["new", "neu→"]],
    "check": [["check", "mine.toml"], ["check", "broken.toml"], ["check", "--format", "json", "broken.toml"]],
    "run": [["run", "mine.toml", "-o", "out→"], ["run", "mine.toml", "--format", "json"], ["run", "→"]],
    "figures": [["figures", "mine.toml", "--only", "8", "-o", "→"]],
    "animate": [["animate", "mine.toml", "-o", "→.gif", "--fps", "→"]],
    "report": [["report", "mine.toml", "-o", "→.html"]],
    "paper": [["paper", "-o", "→", "--set", "run.horizon=→"]],
    "compare": [["compare", "mine.toml", "--controller", "smc", "--jobs", "1"]],
    "bench": [["bench", "→"], ["bench", "mine.toml", "--set", "run.horizon=→"]],
    "identify": [["identify", "→.csv"], ["identify", FILE, "--scenario", "mine.toml", "--format", "json"]],
    "sweep": [["sweep", "spec.toml", "--jobs", "1", "-o", "→"], ["sweep", "→.toml"]],
}
LOOP = """plant tank
state höhe "Höhe →" unit "m" = 1
der höhe = -höhe
output level "Höhe 中" unit "m" = höhe

loop leert "Leert sich →"
block tank = tank()
measure höchst "höchste Höhe 中" unit "m" = maximum(tank.level)
run 1 s step 0.1 s
require höchst <= 0.5
"""

#: Commands that print data.
DATA = [["fmt", "-"], ["eval", FILE, "--points", "-"], ["convert", FILE, "-", "--to", "fz"]]


def test_every_command_is_here():
    # A sweep prints what that of the robots does, and the others end with the editor, the browser or Ctrl-C.
    assert set(COMMANDS) | {"lsp", "studio", "sweep"} == set(commands_of(fuzzyctl))
    assert set(ROBOTS) == set(commands_of(dwmr))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    files = {
        FILE: SYSTEM,
        "bad.fz": SYSTEM.replace("table y = σ", "table y = τ\x1b[31m"),
        "wide.fz": SYSTEM.replace("höhe\n", "höhe  \n", 1),
        "loop.fz": LOOP,
        "other.fz": SYSTEM.replace("höhe", "hoch→".replace("→", "中")),
        "mine.toml": SCENARIO,
        "broken.toml": SCENARIO.replace("horizon", '"hörizon→\\u001b"'),
        "spec.toml": SPEC,
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8", newline="\n")
    return tmp_path


def run(program, arguments, encoding, monkeypatch):
    """Run a command in this process; return its exit code and the bytes of both streams."""
    data = (POINTS if "--points" in arguments else SYSTEM).encode()
    streams = [io.TextIOWrapper(io.BytesIO(), encoding=encoding) for _ in "oe"]
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data), encoding=encoding))
    monkeypatch.setattr(sys, "stdout", streams[0])
    monkeypatch.setattr(sys, "stderr", streams[1])
    with pytest.raises(SystemExit) as ended:
        program(arguments)
    out, err = (stream.flush() or stream.buffer.getvalue() for stream in streams)
    return ended.value.code or 0, out, err


# Pictures are of fonts that lack some characters; what is printed is tested here.
pytestmark = pytest.mark.filterwarnings("ignore:Glyph .* missing from font:UserWarning")

CASES = [
    pytest.param(program, arguments, id=f"{name} {' '.join(arguments)}")
    for name, program, table in (("fuzzyctl", fuzzyctl, COMMANDS), ("dwmr", dwmr, ROBOTS))
    for several in table.values()
    for arguments in several
]


#: Commands of dwmr that take seconds: they run under one encoding, and under UTF-8 only before a release.
LONG = {"run", "figures", "animate", "report", "compare", "sweep"}


def takes_seconds(case):
    program, arguments = case.values
    return program is dwmr and arguments[0] in LONG


UNDER = [
    pytest.param(*case.values, encoding, id=f"{case.id} {encoding}")
    for case in CASES
    for encoding in (ENCODINGS[:1] if takes_seconds(case) else ENCODINGS)
]


@pytest.mark.parametrize(("program", "arguments", "encoding"), UNDER)
def test_a_command_prints_what_the_encoding_has(program, arguments, encoding, folder, monkeypatch):
    code, out, err = run(program, arguments, encoding, monkeypatch)
    assert code in (0, 1, 2, 3)
    assert b"Traceback" not in err
    if arguments in DATA or "json" in arguments or "--diff" in arguments:
        text = out.decode("utf-8")
        if "json" in arguments:
            json.loads(text)
            assert not ACTIVE & set(text)
    else:
        assert not ACTIVE & set(out.decode(encoding))
    if code != 2:  # click itself writes UTF-8 to ASCII streams
        assert not ACTIVE & set(err.decode(encoding))


@pytest.mark.parametrize(
    ("program", "arguments"),
    [pytest.param(*case.values, id=case.id, marks=[pytest.mark.long] if takes_seconds(case) else []) for case in CASES],
)
def test_nothing_of_a_file_controls_a_terminal(program, arguments, folder, monkeypatch):
    _, out, err = run(program, arguments, "utf-8", monkeypatch)
    assert not ACTIVE & set(err.decode())
    if arguments not in DATA and "--diff" not in arguments:
        assert not ACTIVE & set(out.decode())


@pytest.mark.parametrize("arguments", DATA, ids=" ".join)
def test_data_is_the_same_bytes_under_every_encoding(arguments, folder, monkeypatch):
    outputs = {run(fuzzyctl, arguments, encoding, monkeypatch)[1] for encoding in (*ENCODINGS, "utf-8")}
    (data,) = outputs
    assert ("ü→中" if "--points" in arguments else TITLE) in data.decode()


def test_text_for_people_stays_readable(folder, monkeypatch):
    _, out, _ = run(fuzzyctl, ["eval", FILE, "σ=3"], "cp1252", monkeypatch)
    assert "y = 0.3" in out.decode("cp1252")
    _, out, _ = run(fuzzyctl, ["show", FILE], "cp1252", monkeypatch)
    text = out.decode("cp1252")
    assert "Größe sigma -> u4E2D" in text
    assert "sigma | niedrig  höhe" in text
    assert "------+--------------" in text


@pytest.mark.parametrize("encoding", [*ENCODINGS, "utf-8"])
def test_the_caret_stands_below_its_place(encoding, folder, monkeypatch):
    text = SYSTEM.replace("require bounded(y, 0, 1)", "if σ is ΣΩ then y is c")
    (folder / "caret.fz").write_text(text, encoding="utf-8")
    _, _, err = run(fuzzyctl, ["check", "caret.fz"], encoding, monkeypatch)
    _, _, line, caret, *_ = err.decode(encoding).split("\n")
    name = "ΣΩ" if encoding == "utf-8" else "SigmaOmega"
    assert caret.index("^") == line.index(name)
    assert caret.count("^") == len(name)


@pytest.mark.parametrize(
    "variables",
    [{"PYTHONIOENCODING": "cp1252"}, {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}],
    ids=["PYTHONIOENCODING", "LC_ALL"],
)
def test_a_process_gives_an_editor_its_buffer_back(variables):
    words = [sys.executable, "-c", "from fuzzyctl.cli.main import main; main()", "fmt", "-"]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONIOENCODING"} | variables
    done = subprocess.run(words, input=SYSTEM.encode(), capture_output=True, env=environment, timeout=120, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.decode() == SYSTEM


def test_the_handler_of_errors_is_for_encoding_only():
    with pytest.raises(UnicodeDecodeError):
        b"\xff".decode("utf-8", "fuzzyctl.spelt")
    assert codecs.lookup_error("fuzzyctl.spelt")
