"""What commands print and the code they exit with, for good and for bad input."""

import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from tests.frozen.kept import check_kept

RULES = Path(__file__).parents[2] / "rules"

FILES = {
    "broken.fz": (
        "system broken\ninput x in [0, 1]\n  terms a b\noutput y in [0, 1]\n  terms c d\nif x is q then y is c\n"
    ),
    "gap.fz": (
        "system gap\ndefuzzifier weighted_average\ninput x in [0, 4]\n  low = triangle(-inf, 0, 1)\n"
        "  high = triangle(3, 4, inf)\noutput y in [0, 1]\n  terms c=0 d=1\ntable y = x\n     low  high\n  |  c    d\n"
    ),
    "false.fz": (
        "system refuted\ndefuzzifier weighted_average\ninput x in [0, 4]\n  terms low high\noutput y in [0, 1]\n"
        "  terms c=0 d=1\ntable y = x\n     low  high\n  |  c    d\nrequire y <= 0.5\nrequire increasing(y, x)\n"
    ),
    "points.csv": "service,food\n7,8\n2,1\n",
}

FUZZYCTL = """
check tipper.fz
check tipper.fz --format json
check broken.fz
check broken.fz --format json
check broken.fz --format sarif
check broken.fz --format github
check gap.fz
check false.fz
check missing.fz
check
show tipper.fz
show ais_reaction.fz --format json
eval tipper.fz service=7 food=8
eval tipper.fz service=7 food=8 --format json
eval tipper.fz service=7
eval tipper.fz service=7 food=8 drink=9
eval tipper.fz service=seven food=8
eval tipper.fz --points points.csv
eval broken.fz x=0
prove false.fz
prove ais_reaction.fz
prove gap.fz
prove --bounds false.fz
why tipper.fz service=7 food=8
fmt --diff tipper.fz
fmt --check broken.fz
explain FZ203
explain FZ999
compare --changes tipper.fz false.fz
compare tipper.fz tipper.fz
convert tipper.fz - --to fll
convert tipper.fz - --to fis
convert tipper.fz - --to fcl
convert tipper.fz - --to fml
convert broken.fz - --to fll
eval tipper.fz service=7 food=8 --set a=1
unknown
""".strip().splitlines()

DWMR = """
check paper
check nothing
run nothing
run paper --set run.horizon=-1
run paper --set run.horizn=1
run paper --controller none
""".strip().splitlines()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    for path in RULES.glob("*.fz"):
        shutil.copy(path, tmp_path)
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    return tmp_path


def transcript(main, program, lines):
    """Return commands, what they print and their exit codes."""
    parts = []
    for line in lines:
        result = CliRunner().invoke(main, line.split(), prog_name=program)
        parts.append(f"$ {program} {line}\n{result.output.rstrip()}\n[exit code {result.exit_code}]\n\n")
    return "".join(parts)


def test_fuzzyctl_answers_as_kept(folder):
    from fuzzyctl.cli.main import main

    check_kept("commands", "fuzzyctl", transcript(main, "fuzzyctl", FUZZYCTL))


def test_dwmr_answers_as_kept(folder):
    from dwmr.cli.main import main

    check_kept("commands", "dwmr", transcript(main, "dwmr", DWMR))
