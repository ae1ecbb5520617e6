import json

import pytest

from tests.commands import runner
from tests.fuzzyctl.loading.test_fixing import FOREIGN, RIGHT

run = runner("check")


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "t.fz"
    path.write_text(FOREIGN, newline="")
    return path


def test_sure_fixes_are_made_in_the_file_and_the_rest_is_reported(path):
    result = run("--fix", path)
    assert result.exit_code == 1
    assert path.read_text() == RIGHT.replace("is hi\n", "is hii\n")
    assert f"{path}: 6 mistakes fixed" in result.stderr
    assert "output 'y' has no term 'hii'" in result.stderr
    again = run("--fix", path)
    assert (again.exit_code, "fixed" in again.stderr) == (1, False)


def test_likely_ones_on_request(path):
    result = run("--fix", "likely", path)
    assert (result.exit_code, path.read_text()) == (0, RIGHT)
    assert result.stdout == f"{path}: t: 2 rules, no errors\n"
    assert run("--fix=likely", path).exit_code == 0


def test_a_diff_changes_nothing(path):
    result = run("--fix", "--diff", path)
    assert (result.exit_code, path.read_text()) == (1, FOREIGN)
    assert "-defuzzifer center_average\n+defuzzifier center_average\n" in result.stdout
    path.write_text(RIGHT)
    assert run("--fix", "--diff", path).output == ""
    assert run("--diff", path).exit_code == 2


def test_standard_input_goes_to_standard_output():
    result = run("--fix", "likely", "-", stdin=FOREIGN)
    assert (result.exit_code, result.stdout) == (0, RIGHT)


def test_byte_order_mark_and_line_ends_stay(path):
    path.write_bytes(b"\xef\xbb\xbf" + FOREIGN.replace("\n", "\r\n").encode())
    run("--fix", "likely", path)
    assert path.read_bytes() == b"\xef\xbb\xbf" + RIGHT.replace("\n", "\r\n").encode()


def test_what_can_be_fixed_is_said(path):
    assert "7 errors, 0 warnings; '--fix' repairs 6" in run(path).stderr
    path.write_text(RIGHT.replace("is hi\n", "is hii\n"))
    assert "1 error, 0 warnings; '--fix likely' may repair 1" in run(path).stderr


def test_a_file_without_fixes_and_one_that_is_missing_are_left_alone(tmp_path):
    path = tmp_path / "a.fz"
    path.write_text("nothing of this kind\n")
    assert run("--fix", path).exit_code == 1
    assert path.read_text() == "nothing of this kind\n"
    assert "no such file" in run("--fix", tmp_path / "b.fz").stderr.lower()


def test_data_and_code_scanning_carry_the_edits(path):
    first = json.loads(run("--format", "json", path).stdout)["diagnostics"][0]
    edit = {"line": 1, "column": 9, "end_line": 1, "end_column": 10, "text": ""}
    assert first["fix"] == {"applicability": "sure", "edits": [edit]}
    result = json.loads(run("--format", "sarif", path).stdout)["runs"][0]["results"][0]
    (change,) = result["fixes"][0]["artifactChanges"]
    region = {"startLine": 1, "startColumn": 9, "endLine": 1, "endColumn": 10}
    assert change["replacements"] == [{"deletedRegion": region, "insertedContent": {"text": ""}}]


def test_a_value_alone_becomes_the_param_that_is_printed(tmp_path):
    path = tmp_path / "b.fz"
    rules = "input x in [0, 1]\n  terms a c\noutput y in [0, 1]\n  terms l h\ntable y = x\n    a c\n  | l h\n"
    path.write_text(f"system s\nb = 0.8\n{rules}require y <= b + 1\n")
    assert "'--fix' repairs 1" in run(path).output
    result = run("--fix", path)
    assert result.exit_code == 0, result.output
    assert path.read_text().splitlines()[1] == "param b = 0.8"
