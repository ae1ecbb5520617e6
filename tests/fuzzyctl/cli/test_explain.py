"""Pages of diagnostic codes; transcripts/explain.txt holds what `fuzzyctl explain` prints."""

import json

import pytest

from tests.commands import runner

run = runner("explain")
CODES = json.loads(run("--format", "json").output)["codes"]


def test_marks_of_the_pages_are_left_out():
    for code in CODES:
        output = run(code if isinstance(code, str) else code["code"]).output
        for mark in ("```", "<!--", "\n#", "](", "\n\n\n"):
            assert mark not in output, (code, mark)


@pytest.mark.parametrize("form", ["text", "json"])
def test_an_installation_without_pages_still_has_titles(form, monkeypatch):
    monkeypatch.setattr("fuzzyctl.cli.reports.explanations_folder", lambda: None)
    result = run("FZ203", "--format", form)
    assert result.exit_code == 0
    assert "a variable has no such term" in result.output
