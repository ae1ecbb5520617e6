"""Files of other tools go through the same functions and commands as rule files."""

import codecs
import re

import pytest

import fuzzyctl
from tests.fuzzyctl.formats.files import SAMPLES, errors, examined, replaced
from tests.fuzzyctl.formats.one_term import FLL

TIPPER = SAMPLES["tipper.fis"]


@pytest.fixture
def tipper(tmp_path):
    path = tmp_path / "tipper.fis"
    path.write_text(TIPPER, encoding="utf-8")
    return path


def refused(function, *arguments):
    """Return the codes of the errors that a call raises, and their helps."""
    with pytest.raises(fuzzyctl.DiagnosticError) as caught:
        function(*arguments)
    return [d.code for d in caught.value.diagnostics], [d.help for d in caught.value.diagnostics]


@pytest.mark.parametrize(
    ("name", "sample"),
    [
        *(("a.fll", "tipper.fll"), ("A.FIS", "tipper.fis"), ("y.fcl", "standard.fcl"), ("a.fml", "mamdani.fml")),
        *(("a.xml", "mamdani.fml"), ("a.b.fis", "tipper.fis")),
    ],
)
def test_a_suffix_says_the_format_and_that_other_encodings_are_read(name, sample, tmp_path):
    path = tmp_path / name
    path.write_bytes(SAMPLES[sample].encode("utf-16"))
    assert fuzzyctl.load(path).inputs


@pytest.mark.parametrize("name", ["a.fz", "a", "fis", "<text>", "-", "a.fis.txt"])
def test_every_other_name_is_that_of_a_rule_file(name, base):
    assert fuzzyctl.loads(base, name).name == "base"
    refused(fuzzyctl.loads, TIPPER, name)


class TestLoading:
    def test_load_and_check_take_a_file_of_another_tool(self, tipper):
        system = fuzzyctl.load(tipper)
        assert [s.name for s in fuzzyctl.load_all(tipper)] == [system.name] == ["tipper"]
        assert fuzzyctl.load(tipper, block="tipper") == fuzzyctl.loads(TIPPER, "t.fis") == system
        checked, diagnostics = fuzzyctl.check(tipper)
        assert checked == system
        assert "FZ309" in {d.code for d in diagnostics}
        with pytest.raises(fuzzyctl.DiagnosticError, match="no block 'tip'"):
            fuzzyctl.load(tipper, block="tip")

    def test_matlab_documents_these_values_of_its_tipper(self, tipper):
        system = fuzzyctl.load(tipper)
        points = [(2, 1), (4, 5), (7, 8), (1, 2)]
        printed = ["7.0168791431", "14.4584724643", "20.3413663053", "5.5585859298"]
        assert [f"{system(service=s, food=f):.10f}" for s, f in points] == printed

    def test_an_output_without_rules_is_a_warning_only(self):
        more = "[Output2]\nName='other'\nRange=[0 4]\nNumMFs=1\nMF1='a':'trimf',[0 1 2]\n\n[Rules]"
        text = replaced(TIPPER, ("NumOutputs=1", "NumOutputs=2"), ("[Rules]", more))
        system, diagnostics = examined("fis", re.sub(r", (\d) \(", r", \1 0 (", text))
        assert [d.severity for d in diagnostics if d.code == "FZ210"] == ["warning"]
        assert system(service=2, food=1)["other"] == 2.0

    def test_a_misspelt_name_is_found(self, tipper):
        assert "tipper.fis" in refused(fuzzyctl.load, tipper.with_name("tiper.fis"))[1][0]

    def test_fifty_megabytes_are_not_read(self, tmp_path):
        path = tmp_path / "big.fis"
        path.write_bytes(b"[System]\n" + b"% x\n" * (50 << 18))
        assert refused(fuzzyctl.load, path)[0] == ["FZ003"]

    def test_a_count_of_too_many_digits_is_refused_with_its_limit(self):
        (error,) = errors("fis", re.sub(r"NumInputs=\d+", "NumInputs=1000000000", TIPPER))
        assert error.message == "'NumInputs' is a whole number of at most 9 digits, got '1000000000'"


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
    def test_files_of_other_tools_come_in_many(self, data, read_as, tipper):
        tipper.write_bytes(data)
        system, diagnostics = fuzzyctl.check(tipper)
        assert system.inputs[0].name == self.NAME
        messages = [d.message for d in diagnostics if d.code == "FZ605"]
        assert messages == ([f"the file is not UTF-8; it is read as {read_as}"] if read_as else [])

    @pytest.mark.parametrize(
        ("name", "data"),
        [
            *(("t.fis", b"\xff\xfe\x00"), ("t.fis", b"[System]\x00"), ("t.fis", b"\x00\xff")),
            ("t.fis", codecs.BOM_UTF32_LE + TIPPER.encode("utf-32-le")),  # whose mark begins as that of UTF-16
            ("t.fz", TEXT.encode("cp1252")),
        ],
    )
    def test_other_bytes_are_no_text(self, name, data, tmp_path):
        (tmp_path / name).write_bytes(data)
        assert refused(fuzzyctl.load, tmp_path / name)[0] == ["FZ002"]


@pytest.mark.parametrize(
    ("name", "text", "code"),
    [
        *((f"t.{format}", text, "FZ004") for format in ("fll", "fis", "fcl", "fml") for text in ("", " \n")),
        ("t.fll", "# nothing\n", "FZ004"),
        ("t.fll", "<html>not found</html>", "FZ601"),
        ("t.fll", "Engine: a\n", "FZ212"),
        ("t.fll", SAMPLES["small.fll"].split("RuleBlock")[0], "FZ212"),
        ("t.fll", SAMPLES["small.fll"].split("OutputVariable")[0], "FZ212"),
        ("t.fis", "% nothing\n", "FZ004"),
        ("t.fis", "<html><body>Not found</body></html>", "FZ601"),
        ("t.fis", "[System]\nNinputs=2\n[Interface]\n", "FZ602"),
        ("t.fis", "[Input1]\nName='a'\nRange=[0 1]\n", "FZ212"),
        ("t.fis", TIPPER.replace("[Output1]", "[Input1]"), "FZ215"),
        ("t.fis", TIPPER + TIPPER, "FZ215"),
        ("t.fis", TIPPER.replace("mamdani", "mamdanitype2"), "FZ602"),
        ("t.fis", TIPPER.replace("'centroid'", "'centroid'\nTypeRedMethod='Karnik-Mendel'"), "FZ602"),
        ("t.fcl", "(* nothing", "FZ601"),
        ("t.fcl", "FUNCTION_BLOCK x", "FZ601"),
        ("t.fcl", "FUNCTION_BLOCK x END_FUNCTION_BLOCK", "FZ212"),
        ("t.fcl", "VAR_INPUT x : REAL; END_VAR", "FZ601"),
        ("t.fml", "<frbsPMML/>", "FZ004"),
    ],
)
def test_other_texts_are_no_files_of_a_format(name, text, code):
    assert code in [d.code for d in errors(name, text)]


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
    (error,) = errors(format, LINEAR[format].format(term=used, number=1 + (used == "hi")))
    assert (error.code, error.span.line) == ("FZ214", line)
    assert "linear" in error.message
    assert "a consequent" in error.message


def test_points_from_right_to_left_are_reported_with_what_to_do():
    text = LINEAR["fll"].replace("lo Linear 0.3 1 2", "lo Discrete 6 0 3 1").format(term="lo")
    (error,) = errors("fll", text)
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
    (error,) = errors(format, text)
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
    (jump,) = (d for d in fuzzyctl.check(path)[1] if d.code == "FZ405")
    assert jump.help == "let terms overlap there; where the jump is meant, check with '--allow FZ405'"
