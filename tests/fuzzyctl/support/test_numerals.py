"""Numbers of every format: digits of other scripts, underscores, hexadecimals and what overflows are never values."""

import math
from pathlib import Path

import pytest

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import examine_all
from fuzzyctl.support.shipped import to_number

SAMPLES = Path(__file__).parents[1] / "formats"

#: For each format a file that is read without errors, and a number of it to replace.
PLACES = {
    "fz range": ("x.fz", "system s\ninput x in [0, 7.5]\n  terms a b\noutput y in [0, 1]\n  terms c d\n", "7.5"),
    "fz term": (
        "x.fz",
        "system s\ninput x in [0, 8]\n  a = triangle(0, 7.5, 8)\noutput y in [0, 1]\n  terms c\n",
        "7.5",
    ),
    "fis parameter": ("x.fis", (SAMPLES / "samples/tipper.fis").read_text(), "[7 9 10 10]"),
    "fis range": ("x.fis", (SAMPLES / "samples/tipper.fis").read_text(), "Range=[0 30]"),
    "fis count": ("x.fis", (SAMPLES / "samples/tipper.fis").read_text(), "NumMFs=2"),
    "fis rule": ("x.fis", (SAMPLES / "samples/tipper.fis").read_text(), "2 0, 2"),
    "fis weight": ("x.fis", (SAMPLES / "samples/tipper.fis").read_text(), "2 0, 2 (1)"),
    "fll range": ("x.fll", (SAMPLES / "samples/tipper.fll").read_text(), "range: 0.000 10.000"),
    "fcl point": ("x.fcl", (SAMPLES / "fcl/standard.fcl").read_text(), "(comfort, 0) (27"),
    "fml attribute": ("x.fml", (SAMPLES / "fml/mamdani.fml").read_text(), 'domainright="30.0'),
}
BAD = {
    "Arabic digits": "٧",
    "fullwidth digits": "７",
    "superscript": "²",
    "underscore": "7_0",
    "hexadecimal": "0x7",
    "overflow": "1e400",
}


def replaced(text, old, bad):
    """The text with the last number of a part replaced."""
    assert old in text, old
    at = max(i for i, c in enumerate(old) if c.isdigit())
    first = at
    while first and (old[first - 1].isdigit() or old[first - 1] == "."):
        first -= 1
    return text.replace(old, old[:first] + bad + old[at + 1 :], 1)


def errors(name, text):
    _, diagnostics = examine_all(SourceText(name, text))
    return [d for d in diagnostics if d.severity == "error"]


@pytest.mark.parametrize("bad", BAD.values(), ids=BAD)
@pytest.mark.parametrize("place", PLACES)
def test_no_format_takes_them(place, bad):
    name, text, old = PLACES[place]
    assert errors(name, replaced(text, old, bad)), replaced(text, old, bad)[:2000]


@pytest.mark.parametrize("formula", ["1e400", "1e308*10", "-1d400"])
def test_an_overflow_in_a_fis_is_out_of_range_and_an_infinity_is_none(formula):
    name, text, old = PLACES["fis parameter"]
    (error,) = errors(name, text.replace(old, f"[7 9 10 {formula}]"))
    assert (error.code, error.help) == ("FZ108", "write Inf")
    assert not errors(name, text.replace(old, "[7 9 10 Inf]"))
    assert not errors(name, text.replace(old, "[7 9 10 2*Inf]"))


def test_an_overflow_in_a_formula_of_fuzzylite_is_out_of_range():
    text = (SAMPLES / "samples/tipper.fll").read_text()
    line = next(line for line in text.split("\n") if "term: average" in line)
    found = errors("x.fll", text.replace(line, "  term: average Function 1e400 * x", 1))
    assert "FZ108" in [d.code for d in found]


@pytest.mark.parametrize("text", ["²", "٣", "1_0", "0x1", "1e400", "", "1,5", "infinit", "+-1", "1e", "\u20031"])
def test_what_is_no_number(text):
    with pytest.raises((ValueError, OverflowError)):
        to_number(text)


@pytest.mark.parametrize(
    ("text", "value"), [("1", 1.0), (" -.5e1 ", -5.0), ("+2.", 2.0), ("INF", math.inf), ("-Infinity", -math.inf)]
)
def test_what_is_a_number(text, value):
    assert to_number(text) == value
    assert math.isnan(to_number("NaN"))


@pytest.mark.parametrize("text", ["centroid(resolution=²)", "centroid(resolution=٣)", "lom(tolerance=²)"])
def test_an_option_in_digits_of_other_scripts_is_a_diagnostic(text):
    found = errors("x.fz", f"system s\ndefuzzifier {text}\n")
    assert any(d.code in ("FZ105", "FZ302", "FZ101", "FZ601") for d in found)


@pytest.mark.parametrize("bad", BAD.values(), ids=BAD)
def test_the_command_line_and_tables_of_points_refuse_them(bad, tmp_path):
    from click.testing import CliRunner

    from fuzzyctl.cli.main import main

    (tmp_path / "s.fz").write_text(
        "system s\nparam k = 1\ninput x in [0, k]\n  terms a b\noutput y in [0, 1]\n  terms c d\n"
        "defuzzifier center_average\ntable y = x\n     a b\n  |  c d\n"
    )
    (tmp_path / "points.csv").write_text(f"x\n0.5\n{bad}\n", encoding="utf-8")
    file = str(tmp_path / "s.fz")
    assert CliRunner().invoke(main, ["eval", file, "x=0.5"]).exit_code == 0
    for arguments in ([f"x={bad}"], ["x=0.5", "--set", f"k={bad}"], ["--points", str(tmp_path / "points.csv")]):
        done = CliRunner().invoke(main, ["eval", file, *arguments])
        assert done.exit_code == (1 if "--points" in arguments else 2), arguments
        assert "error[FZ50" in done.stderr


def test_what_rounds_to_zero_is_zero_in_files_of_other_tools():
    name, text, old = PLACES["fis parameter"]
    (system,), found = examine_all(SourceText(name, text.replace(old, "[1e-400 0 10 10]")))
    assert [d.code for d in found if d.severity == "error"] == []
    assert system == examine_all(SourceText(name, text.replace(old, "[0 0 10 10]")))[0][0]
    assert errors(*(part.replace("7.5", "1e-400") for part in PLACES["fz range"][:2]))[0].code == "FZ108"
