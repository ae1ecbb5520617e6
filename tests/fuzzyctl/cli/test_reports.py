"""The machine formats are checked by hand against what their specifications require: no schema is fetched."""

import json
from urllib.parse import unquote

import pytest

from fuzzyctl.cli.reports import as_github, as_sarif
from fuzzyctl.diagnostics.diagnostic import CODES, Diagnostic, Note
from fuzzyctl.diagnostics.source import SourceText, Span

TEXT = "first\n  𝜎 = bad, and more\nlast\n"


@pytest.fixture
def source(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return SourceText("a folder/a.fz", TEXT)


@pytest.fixture
def diagnostic(source):
    at = TEXT.index("bad")
    note = Note(Span(source, 0, 5), "first declared here")
    return Diagnostic(
        "FZ203", "no 'bad'", Span(source, at, at + 3), facts=("50 % of a, b",), help="did you mean: x?", notes=(note,)
    )


def _run(diagnostics):
    log = json.loads(as_sarif(diagnostics))
    assert log["version"] == "2.1.0"
    assert log["$schema"].endswith("sarif-schema-2.1.0.json")
    (run,) = log["runs"]
    return run


class TestSarif:
    def test_what_the_schema_requires_is_there(self, diagnostic):
        run = _run([diagnostic])
        driver = run["tool"]["driver"]
        assert driver["name"] == "fuzzyctl"
        assert run["columnKind"] == "utf16CodeUnits"
        (rule,) = driver["rules"]
        assert rule["id"] == "FZ203"
        for text in ("shortDescription", "fullDescription", "help"):
            assert rule[text]["text"].strip()
        (result,) = run["results"]
        assert result["message"]["text"].startswith("no 'bad'\n50 % of a, b\n")
        assert result["level"] == "error"
        assert driver["rules"][result["ruleIndex"]]["id"] == result["ruleId"]

    def test_columns_count_utf16_units_from_1(self, diagnostic):
        (result,) = _run([diagnostic])["results"]
        region = result["locations"][0]["physicalLocation"]["region"]
        # 𝜎 takes two units: `bad` begins behind two blanks, two units, a blank, the sign and a blank.
        assert region == {"startLine": 2, "startColumn": 8, "endLine": 2, "endColumn": 11}

    def test_files_below_this_folder_are_relative_uris(self, diagnostic, tmp_path):
        (result,) = _run([diagnostic])["results"]
        assert result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] == "a%20folder/a.fz"
        inside = Diagnostic("FZ001", "gone", file=str(tmp_path / "b.fz"))
        outside = Diagnostic("FZ001", "gone", file=str(tmp_path.parent / "b.fz"))
        uris = [
            r["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] for r in _run([inside, outside])["results"]
        ]
        assert uris[0] == "b.fz"
        assert unquote(uris[1]) == f"file://{tmp_path.parent}/b.fz"

    def test_notes_are_related_locations(self, diagnostic):
        (result,) = _run([diagnostic])["results"]
        (related,) = result["relatedLocations"]
        assert related["message"]["text"] == "first declared here"
        assert related["physicalLocation"]["region"]["startLine"] == 1

    def test_a_rule_is_described_once(self, diagnostic):
        other = Diagnostic("FZ101", "what", severity="warning")
        run = _run([diagnostic, other, diagnostic])
        assert [r["id"] for r in run["tool"]["driver"]["rules"]] == ["FZ101", "FZ203"]
        assert [r["ruleIndex"] for r in run["results"]] == [1, 0, 1]
        assert run["results"][1]["level"] == "warning"
        assert "locations" not in run["results"][1]

    def test_nothing_found_is_a_run_without_results(self):
        assert _run([])["results"] == []

    def test_every_code_has_a_rule(self):
        run = _run([Diagnostic(code, "x") for code in CODES])
        assert {r["id"]: r["shortDescription"]["text"] for r in run["tool"]["driver"]["rules"]} == CODES


class TestGithub:
    def test_properties_and_message_are_escaped(self, diagnostic):
        assert as_github([diagnostic]) == (
            "::error file=a folder/a.fz,line=2,endLine=2,col=8,endColumn=10,title=FZ203%3A a variable has no such term"
            "::no 'bad'%0A50 %25 of a, b%0Ahelp: did you mean: x?"
        )

    def test_colons_and_commas_of_a_file_name_are_escaped(self, source):
        d = Diagnostic("FZ001", "a: b, c", file="odd,name:1.fz")
        assert as_github([d]).startswith("::error file=odd%2Cname%3A1.fz,title=")
        assert as_github([d]).endswith("::a: b, c")

    def test_a_range_over_lines_has_no_end_column(self, source):
        d = Diagnostic("FZ102", "x", Span(source, 0, len(TEXT) - 1), severity="warning")
        assert as_github([d]).startswith("::warning file=a folder/a.fz,line=1,endLine=3,col=1,title=")

    def test_one_line_a_diagnostic(self, diagnostic):
        assert as_github([]) == ""
        assert len(as_github([diagnostic, diagnostic]).split("\n")) == 2
