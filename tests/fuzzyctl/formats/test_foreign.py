"""Files of other tools go through the same functions and commands as rule files."""

import codecs
import re
from pathlib import Path

import pytest

import fuzzyctl
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.foreign import examine_foreign
from fuzzyctl.formats.registry import FORMATS, SUFFIXES, format_of
from fuzzyctl.loading.load import decode, examine_all, load, load_all, loads
from fuzzyctl.support.shipped import FOREIGN, MAX_BYTES
from tests.fuzzyctl.formats.one_term import FLL

TIPPER = (Path(__file__).parent / "samples" / "tipper.fis").read_text(encoding="utf-8")


@pytest.fixture
def tipper(tmp_path):
    path = tmp_path / "tipper.fis"
    path.write_text(TIPPER, encoding="utf-8")
    return path


def codes(diagnostics):
    return {d.code for d in diagnostics}


class TestSuffixes:
    def test_reading_and_the_registry_know_the_same_ones(self):
        assert {".fz", *FOREIGN} == set(SUFFIXES)

    @pytest.mark.parametrize(
        ("name", "format"),
        [
            ("a.fll", "fll"),
            ("A.FIS", "fis"),
            ("x/y.fcl", "fcl"),
            ("a.fml", "fml"),
            ("a.xml", "fml"),
            ("a.b.fis", "fis"),
        ],
    )
    def test_a_suffix_says_the_format(self, name, format):
        assert format_of(name) is FORMATS[format]

    @pytest.mark.parametrize("name", ["a.fz", "a", "fis", "<text>", "-", "a.fis.txt"])
    def test_everything_else_is_a_rule_file(self, name):
        assert format_of(name) is None


class TestLoading:
    def test_load_takes_a_file_of_another_tool(self, tipper):
        assert load(tipper).name == "tipper"
        assert [s.name for s in load_all(tipper)] == ["tipper"]
        assert load(tipper, block="tipper") == load(tipper)

    def test_loads_goes_by_the_suffix_of_the_name(self, tipper):
        assert loads(TIPPER, "t.fis") == load(tipper)
        with pytest.raises(DiagnosticError):
            loads(TIPPER)

    def test_check_takes_one(self, tipper):
        system, diagnostics = fuzzyctl.check(tipper)
        assert system == load(tipper)
        assert "FZ309" in codes(diagnostics)

    def test_a_system_of_another_name_is_refused(self, tipper):
        with pytest.raises(DiagnosticError, match="no block 'tip'"):
            load(tipper, block="tip")

    def test_matlab_documents_these_values_of_its_tipper(self, tipper):
        system = load(tipper)
        points = [(2, 1), (4, 5), (7, 8), (1, 2)]
        printed = ["7.0168791431", "14.4584724643", "20.3413663053", "5.5585859298"]
        assert [f"{system(service=s, food=f):.10f}" for s, f in points] == printed

    def test_an_output_without_rules_is_a_warning_only(self):
        more = TIPPER.replace("NumOutputs=1", "NumOutputs=2").replace(
            "[Rules]", "[Output2]\nName='other'\nRange=[0 4]\nNumMFs=1\nMF1='a':'trimf',[0 1 2]\n\n[Rules]"
        )
        more = more.replace(", 1 (", ", 1 0 (").replace(", 2 (", ", 2 0 (").replace(", 3 (", ", 3 0 (")
        systems, diagnostics = examine_all(SourceText("t.fis", more))
        assert [(d.code, d.severity) for d in diagnostics if d.code == "FZ210"] == [("FZ210", "warning")]
        assert systems[0](service=2, food=1)["other"] == 2.0


def test_utf_32_is_no_utf_16_though_its_mark_begins_so():
    with pytest.raises(DiagnosticError) as caught:
        decode(codecs.BOM_UTF32_LE + TIPPER.encode("utf-32-le"), "t.fis")
    assert [d.code for d in caught.value.diagnostics] == ["FZ002"]


class TestEncodings:
    NAME = "Qualität"
    TEXT = TIPPER.replace("'service'", f"'{NAME}'")

    @pytest.mark.parametrize(
        ("data", "read_as"),
        [
            (TEXT.encode(), ""),
            (codecs.BOM_UTF8 + TEXT.encode(), ""),
            (TEXT.encode("cp1252"), "Windows-1252"),
            (TEXT.encode("utf-16"), "UTF-16"),
            (codecs.BOM_UTF16_BE + TEXT.encode("utf-16-be"), "UTF-16"),
            (TEXT.replace("\n", "\r\n").encode(), ""),
            (TEXT.replace("\n", "\r").encode(), ""),
            (TEXT.replace("\n", "\r\r\n").encode(), ""),
        ],
    )
    def test_files_of_other_tools_come_in_many(self, data, read_as):
        source = decode(data, "t.fis")
        assert source.encoding == read_as
        (system,), diagnostics = examine_all(source)
        assert system.inputs[0].name == self.NAME
        assert ("FZ605" in codes(diagnostics)) == bool(read_as)

    @pytest.mark.parametrize("data", [b"\xff\xfe\x00", b"[System]\x00", b"\x00\xff"])
    def test_what_is_no_text_is_refused(self, data):
        with pytest.raises(DiagnosticError) as caught:
            decode(data, "t.fis")
        assert codes(caught.value.diagnostics) == {"FZ002"}

    def test_rule_files_stay_utf_8(self):
        with pytest.raises(DiagnosticError):
            decode(self.TEXT.encode("cp1252"), "t.fz")


class TestFiles:
    def test_fifty_megabytes_are_not_read(self, tmp_path):
        path = tmp_path / "big.fis"
        path.write_bytes(b"[System]\n" + b"% x\n" * (50 << 18))
        with pytest.raises(DiagnosticError) as caught:
            load(path)
        assert codes(caught.value.diagnostics) == {"FZ003"}
        assert path.stat().st_size > MAX_BYTES

    def test_a_misspelt_name_is_found(self, tipper):
        with pytest.raises(DiagnosticError) as caught:
            load(tipper.with_name("tiper.fis"))
        assert "tipper.fis" in caught.value.diagnostics[0].help


LINEAR = {
    "fll": """\
Engine: t
InputVariable: a
  range: 0 10
  term: lo Linear 0.3 1 2
  term: hi Triangle 0 10 15
InputVariable: b
  range: 0 10
  term: hi Triangle 0 10 15
OutputVariable: y
  range: 0 30
  aggregation: none
  defuzzifier: WeightedAverage
  term: u Linear 1 2 3
RuleBlock:
  implication: none
  rule: if a is {term} then y is u
""",
    "fis": """\
[System]
Name='t'
Type='sugeno'
[Input1]
Name='a'
Range=[0 10]
MF1='lo':'linear',[0.3 1]
MF2='hi':'trimf',[0 10 15]
[Output1]
Name='y'
Range=[0 30]
MF1='u':'linear',[1 2]
[Rules]
{number}, 1 (1) : 1
""",
}


@pytest.mark.parametrize("used", ["lo", "hi"])
@pytest.mark.parametrize(("format", "line"), [("fll", 4), ("fis", 7)])
def test_a_linear_term_of_an_input_is_reported_at_its_place(format, line, used):
    text = LINEAR[format].format(term=used, number=1 + (used == "hi"))
    systems, diagnostics = examine_foreign(FORMATS[format], SourceText(f"t.{format}", text))
    assert systems == ()
    (error,) = [d for d in diagnostics if d.severity == "error"]
    assert (error.code, error.span.line) == ("FZ214", line)
    assert "linear" in error.message
    assert "a consequent" in error.message


def test_points_from_right_to_left_are_reported_with_what_to_do():
    text = LINEAR["fll"].replace("lo Linear 0.3 1 2", "lo Discrete 6 0 3 1").format(term="lo")
    _, diagnostics = examine_foreign(FORMATS["fll"], SourceText("t.fll", text))
    (error,) = [d for d in diagnostics if d.severity == "error"]
    assert (error.code, error.span.line, error.help) == ("FZ301", 4, "give the points from left to right")
    assert error.message.endswith("x = 6 is greater than the next x = 3")


@pytest.mark.parametrize(
    ("format", "text", "written"),
    [
        ("fll", FLL.format("Ramp 0 5", "Constant 2"), "defuzzifier: WeightedAverage"),
        ("fis", re.sub("'trimf',.*", "'constant',[2]", TIPPER), "Type='sugeno' and DefuzzMethod='wtaver'"),
    ],
)
def test_numbers_under_a_centroid_are_repaired_in_words_of_the_format(format, text, written):
    _, diagnostics = examine_foreign(FORMATS[format], SourceText(f"t.{format}", text))
    (error,) = [d for d in diagnostics if d.severity == "error"]
    assert "is a number and has no area" in error.message
    assert error.help == f"write: {written}"


JUMP = """
FUNCTION_BLOCK s
VAR_INPUT v : REAL; END_VAR
VAR_OUTPUT o : REAL; END_VAR
FUZZIFY v TERM a := 1; RANGE := (0 .. 4); END_FUZZIFY
DEFUZZIFY o TERM x := (0, 0) (0.5, 1) (1, 0); METHOD : COG; DEFAULT := 0; RANGE := (0 .. 1); END_DEFUZZIFY
RULEBLOCK r AND : MIN; ACT : MIN; ACCU : MAX; RULE 1 : IF v IS a THEN o IS x; END_RULEBLOCK
END_FUNCTION_BLOCK
"""


def test_helps_name_an_option_instead_of_a_line_of_rule_files(tmp_path):
    path = tmp_path / "s.fcl"
    path.write_text(JUMP, encoding="utf-8")
    _, diagnostics = fuzzyctl.check(path)
    (jump,) = (d for d in diagnostics if d.code == "FZ405")
    assert jump.help == "let terms overlap there; where the jump is meant, check with '--allow FZ405'"


def test_a_count_of_too_many_digits_is_refused_with_its_limit():
    text = re.sub(r"NumInputs=\d+", "NumInputs=1000000000", TIPPER)
    with pytest.raises(DiagnosticError) as caught:
        loads(text, "tipper.fis")
    message = "'NumInputs' is a whole number of at most 9 digits, got '1000000000'"
    assert [d.message for d in caught.value.diagnostics] == [message]
