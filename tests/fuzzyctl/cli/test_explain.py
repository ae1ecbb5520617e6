import json

import pytest

from fuzzyctl.cli import reports
from fuzzyctl.cli.reports import Page
from fuzzyctl.diagnostics.diagnostic import CODES
from tests.commands import runner

run = runner("explain")


class TestExplain:
    def test_a_code_has_its_meaning_mistake_message_and_repair(self):
        output = run("FZ203").output
        assert output.startswith("FZ203: a variable has no such term\n\nA rule or a cell names a term")
        assert "\n    fz203.fz:11:12: error[FZ203]: output 'speed' has no term 'hihg'\n" in output
        assert output.index("The mistake") < output.index("error[FZ203]") < output.index("The repair")

    def test_marks_of_the_page_are_left_out(self):
        for code in CODES:
            output = run(code).output
            for mark in ("```", "<!--", "\n#", "](", "\n\n\n"):
                assert mark not in output, (code, mark)

    def test_small_letters_do(self):
        assert run("fz203").output == run("FZ203").output

    @pytest.mark.parametrize(("number", "code"), [("203", "FZ203"), ("4", "FZ004"), ("004", "FZ004")])
    def test_a_number_does(self, number, code):
        assert run(number).output.startswith(f"{code}: ")

    def test_without_a_code_all_are_listed(self):
        result = run()
        assert result.exit_code == 0
        assert result.output.splitlines() == [f"{code}  {title}" for code, title in CODES.items()]

    def test_an_unknown_code_is_wrong_usage(self):
        result = run("FZ2203")
        assert result.exit_code == 2
        assert "no diagnostic code 'FZ2203'; did you mean 'FZ2" in result.output
        assert run("nonsense").exit_code == 2

    @pytest.mark.parametrize(("written", "meant"), [("E203", "FZ203"), ("fz-203", "FZ203"), ("FZ2", "FZ002")])
    def test_a_code_of_other_letters_or_fewer_digits_is_suggested(self, written, meant):
        result = run(written)
        assert result.exit_code == 2
        assert f"no diagnostic code '{written}'; did you mean '{meant}'?" in result.output

    def test_json_has_the_page_as_written(self):
        data = json.loads(run("FZ203", "--format", "json").output)
        assert data["title"] == CODES["FZ203"]
        assert data["page"].startswith("# FZ203: ")
        assert len(json.loads(run("--format", "json").output)["codes"]) == len(CODES)

    @pytest.mark.parametrize("form", ["text", "json"])
    def test_an_installation_without_pages_still_has_titles(self, form, monkeypatch):
        monkeypatch.setattr(reports, "explanations_folder", lambda: None)
        result = run("FZ203", "--format", form)
        assert result.exit_code == 0
        assert CODES["FZ203"] in result.output


class TestPage:
    def test_headings_are_bold_in_colour_only(self):
        page = Page("FZ000", "# FZ000: title\n\nWhat it\nmeans.\n\n## The mistake\n\n```fz\n# no heading\n```\n")
        assert page.laid_out(color=True).startswith("\x1b[1mFZ000: title\x1b[0m\n\nWhat it\n")
        assert "\n    # no heading\n" in page.laid_out(color=True)
        assert "\x1b" not in page.laid_out()

    def test_the_meaning_is_the_first_paragraph_on_one_line(self):
        assert Page("FZ000", "# FZ000: title\n\nWhat it\nmeans.\n\n## More\n").meaning == "What it means."

    def test_a_link_is_its_words(self):
        page = Page("FZ000", "# FZ000: title\n\nSee [the\npage](../a.md#b).\n")
        assert page.laid_out().endswith("See the\npage.\n")
