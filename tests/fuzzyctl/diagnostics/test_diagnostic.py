import json
import re
import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl import DiagnosticError, UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note, render, render_all, wrapped
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.testing import check_text
from tests.effort import at_most

SOURCE = SourceText("a.fz", "one\nNS |  NM  NG  ZO\nthree\n")
PLACE = Span(SOURCE, 14, 16)


class TestRender:
    def test_the_caret_stands_under_the_place(self):
        lines = render(Diagnostic("FZ203", "no term 'NG'", PLACE)).split("\n")
        assert lines[0] == "a.fz:2:11: error[FZ203]: no term 'NG'"
        assert lines[2] == "2 | NS |  NM  NG  ZO"
        assert lines[3].index("^^") == lines[2].index("NG")

    def test_facts_notes_and_help_follow(self):
        diagnostic = Diagnostic("FZ203", "m", PLACE, facts=("a fact",), help="do it", notes=(Note(PLACE, "first"),))
        assert render(diagnostic).split("\n")[4:] == ["  = a fact", "  = first (line 2)", "  = help: do it"]

    def test_wide_characters_take_two_columns(self):
        source = SourceText("a.fz", "語 x")
        lines = render(Diagnostic("FZ102", "m", Span(source, 2, 3))).split("\n")
        assert lines[3].endswith("|    ^")

    def test_a_long_line_is_cut_to_the_place(self):
        source = SourceText("a.fz", "x" * 5000 + "!" + "y" * 5000)
        lines = render(Diagnostic("FZ102", "m", Span(source, 5000, 5001))).split("\n")
        assert len(lines[2]) < 200
        assert lines[2][lines[3].index("^")] == "!"

    def test_control_characters_do_not_reach_the_terminal(self):
        source = SourceText("a.fz", "\x1b[31mred\tx")
        text = render(Diagnostic("FZ105", "m", Span(source, 0, 1)))
        assert "\x1b" not in text

    def test_colour_only_on_request(self):
        assert "\x1b[" in render(Diagnostic("FZ203", "m", PLACE), color=True)


LONG = "the defuzzifier of output 'tip' takes no sets whose membership functions have no closed form"


class TestWidth:
    """On a terminal lines are wrapped at its width; in a pipe they are not."""

    def long(self, text=LONG, line=1):
        source = SourceText("some_folder/a_file.fz", "\n" * (line - 1) + f"if service is poor then {'x' * 200} is low")
        place = Span(source, line + 23, line + 223)
        return Diagnostic("FZ203", text, place, facts=(text, "short"), help=text, notes=(Note(place, text),))

    def test_in_a_pipe_each_message_fact_and_help_is_one_line(self):
        lines = render(self.long()).split("\n")
        assert len(lines) == 8
        assert lines[0].endswith(LONG)

    @pytest.mark.parametrize("color", [False, True])
    @given(
        width=st.integers(50, 200), line=st.sampled_from([1, 1000]), text=st.text("ab 語 '", min_size=1, max_size=300)
    )
    def test_no_line_is_wider_than_the_terminal_and_nothing_is_lost(self, color, width, line, text):
        words = " ".join(word[:20] for word in text.split(" "))
        diagnostic = self.long(words, line)
        plain = re.sub(r"\x1b\[[\d;]*m", "", render(diagnostic, color=color, width=width))
        lines = plain.split("\n")
        assert [part for part in lines if columns(part.rstrip(" ")) > width] == []
        shown = "".join(plain.split())
        assert shown.count("".join(words.split())) >= 4

    @pytest.mark.parametrize("width", [20, 40, 80, 300])
    def test_the_caret_stands_under_its_place_at_every_width(self, width):
        source = SourceText("a.fz", f"{'x ' * 300}語 fare {'y ' * 300}")
        at = source.text.index("fare")
        lines = render(Diagnostic("FZ203", "m", Span(source, at, at + 4)), width=width).split("\n")
        *_, excerpt, carets = lines
        assert columns(excerpt[: excerpt.index("fare")]) == carets.index("^^^^")
        assert columns(excerpt) <= max(width, 24)

    def test_a_word_longer_than_the_terminal_stays_whole(self):
        assert wrapped("see /a/path/that/is/long here", 12, first=4, indent=2) == [
            "see",
            "/a/path/that/is/long",
            "here",
        ]

    def test_a_text_that_fits_stays_on_its_line(self):
        assert wrapped("a  b c", 10, first=4, indent=2) == ["a  b c"]
        assert wrapped("a  b c", 9, first=4, indent=2) == ["a  b", "c"]


def columns(text):
    return sum(2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in text)


class TestRenderAll:
    def test_of_very_many_only_the_first_are_shown(self):
        text = render_all([Diagnostic("FZ203", f"no {i}", PLACE) for i in range(1000)])
        assert text.count("error[FZ203]") == 200
        assert text.endswith("... and 800 more")

    def test_of_very_many_the_errors_are_shown(self):
        warnings = [Diagnostic("FZ404", f"no {i}", PLACE, "warning") for i in range(1000)]
        text = render_all([*warnings[:500], Diagnostic("FZ401", "a gap", PLACE), *warnings[500:]])
        heads = [line.partition(": ")[2] for line in text.split("\n") if "[FZ" in line]
        assert heads[-2:] == ["warning[FZ404]: no 198", "error[FZ401]: a gap"]


class TestDiagnostic:
    def test_it_is_plain_data_for_json_with_lines_and_columns_from_one(self):
        found = next(d for d in check_text("system t\nparam k = = 1\n")[1] if d.fix)
        data = json.loads(json.dumps(found.as_dict()))
        place = {"line": 2, "column": 11, "end_line": 2, "end_column": 12}
        assert {key: data[key] for key in ("file", *place)} == {"file": "<text>"} | place
        assert data["fix"] == {"applicability": "sure", "edits": [place | {"column": 10, "text": ""}]}

    def test_an_unknown_code_is_refused(self):
        with pytest.raises(KeyError):
            Diagnostic("FZ999", "m")

    def test_it_is_one_line_in_a_list_and_prints_as_the_command_does(self):
        found = Diagnostic("FZ203", "no term 'NG'\x1b[31m", PLACE, help="use 'NB'")
        assert repr([found]).startswith("[Diagnostic(a.fz:2:11: error[FZ203]: no term 'NG'")
        assert repr(found).isprintable()
        assert str(found) == render(found)
        assert "= help: use 'NB'" in f"{found}"
        assert repr(Diagnostic("FZ203", "x", severity="hint")) == "Diagnostic(hint[FZ203]: x)"


class TestExceptions:
    def test_a_diagnostic_error_shows_all_diagnostics(self):
        error = DiagnosticError([Diagnostic("FZ203", "first", PLACE), Diagnostic("FZ202", "second", PLACE)])
        assert "first" in str(error)
        assert "second" in str(error)
        assert not str(error).startswith("\n")

    def test_its_text_begins_with_the_first_of_them(self):
        first = Diagnostic("FZ203", "first", PLACE)
        assert str(DiagnosticError([first])) == render(first)

    def test_an_unknown_name_names_the_known_ones(self):
        assert str(UnknownNameError("input", "sgma", ["sigma"])) == (
            "no input 'sgma'; there are: sigma; did you mean 'sigma'?"
        )

    def test_a_bound_names_value_and_unit(self):
        assert str(ValueOutOfBoundsError("mass", -1, "> 0", "kg")) == "mass must be > 0 kg, got -1"


class TestSuggestions:
    """Those for single words are in tests/golden/mistakes/words.txt."""

    def suggested(self, *names):
        terms = " ".join(f"term_{i}" for i in range(1000))
        head = f"system s\ninput x in [0, 1]\n  terms {terms}\noutput y in [0, 1] else 0\n  terms a b\n"
        found = check_text(head + "".join(f"if x is {name} then y is a\n" for name in names))[1]
        return [d.help for d in found if d.code == "FZ203"]

    def test_among_a_thousand_names_one_slip_is_found_and_two_are_not(self):
        helps = self.suggested("term_77x", "tem_777", "trem_777", "terM_777", "ter777")
        assert [text.removeprefix("did you mean 'term_77") for text in helps[:4]] == ["'?", "7'?", "7'?", "7'?"]
        assert helps[4] == ""

    def test_hundreds_of_slips_take_no_seconds(self):
        with at_most(3):
            self.suggested(*(f"term_{i}q" for i in range(400)))
