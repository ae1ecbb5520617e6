"""The machine formats are checked by hand against what their specifications require: no schema is fetched."""

import json
from urllib.parse import unquote

import pytest

from tests.commands import runner

run = runner("check")
#: Mistakes with a note, a repair and a help, one of them behind a letter of two UTF-16 units.
TEXT = (
    "system s\nparam a = 1\nparam a = 2\ninput 𝜎 in [0, a]\n  terms lo hi\noutput y in [0, 1] else 0\n  terms p q\n"
    "if 𝜎 is lo then y is p\nif 𝜎 is hi then y is qq\n"
)


@pytest.fixture
def log(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in (("a folder/a.fz", TEXT), ("odd,name:1.fz", "system t;\n"), ("../b.fz", "system b;\n")):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")

    def checked(form, *names):
        return run("--format", form, *(names or ["a folder/a.fz"])).stdout

    return checked


def result_of(log, code, *names):
    (sarif,) = json.loads(log("sarif", *names))["runs"]
    return next(r for r in sarif["results"] if r["ruleId"] == code)


def place(result):
    return result["locations"][0]["physicalLocation"]


def test_sarif_has_the_members_that_its_schema_requires(log):
    data = json.loads(log("sarif"))
    assert data["version"] == "2.1.0"
    assert data["$schema"].endswith("sarif-schema-2.1.0.json")
    (sarif,) = data["runs"]
    driver = sarif["tool"]["driver"]
    assert (driver["name"], sarif["columnKind"]) == ("fuzzyctl", "utf16CodeUnits")
    codes = [rule["id"] for rule in driver["rules"]]
    assert codes == sorted(set(codes)) == sorted({r["ruleId"] for r in sarif["results"]})
    for rule in driver["rules"]:
        for text in ("shortDescription", "fullDescription", "help"):
            assert rule[text]["text"].strip()
    for result in sarif["results"]:
        assert result["level"] in ("error", "warning")
        assert driver["rules"][result["ruleIndex"]]["id"] == result["ruleId"]
    assert json.loads(log("sarif", "odd,name:1.fz"))["runs"][0]["results"]


def test_columns_of_sarif_count_utf16_units_from_1(log):
    region = place(result_of(log, "FZ203"))["region"]
    assert region == {"startLine": 9, "startColumn": 23, "endLine": 9, "endColumn": 25}


def test_notes_are_related_locations(log):
    (related,) = result_of(log, "FZ201")["relatedLocations"]
    assert related["physicalLocation"]["region"]["startLine"] == 2


def test_files_below_this_folder_are_relative_uris(log, tmp_path):
    assert place(result_of(log, "FZ203"))["artifactLocation"]["uri"] == "a%20folder/a.fz"
    outside = place(result_of(log, "FZ105", "../b.fz"))["artifactLocation"]["uri"]
    assert unquote(outside) in (f"file://{tmp_path.parent}/b.fz", "../b.fz")


def test_github_escapes_properties_and_messages(log):
    lines = log("github").splitlines()
    assert all(line.startswith(("::error ", "::warning ")) for line in lines)
    (line,) = [line for line in lines if "FZ203" in line]
    assert line.startswith("::error file=a folder/a.fz,line=9,endLine=9,col=23,endColumn=24,title=FZ203%3A a variable")
    assert line.partition("::error ")[2].partition("::")[2].count("%0A") > 0
    assert "::error file=odd%2Cname%3A1.fz,line=1" in log("github", "odd,name:1.fz")
