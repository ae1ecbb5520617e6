import pytest

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang.mistakes import FORMS
from fuzzyctl.lang.parser import parse
from fuzzyctl.lang.syntax import STATEMENT_KEYWORDS


def diagnose(text):
    _, (diagnostic,) = parse(SourceText("t", text))
    return diagnostic


class TestDescribe:
    def test_every_statement_has_its_form(self):
        assert set(FORMS) == set(STATEMENT_KEYWORDS)

    def test_the_end_of_a_line_is_no_token(self):
        assert diagnose("param k =").message == "the line ends too early"

    def test_it_says_what_was_expected(self):
        assert diagnose("hedge k(x) x").facts == ("expected '='",)

    @pytest.mark.parametrize(
        ("text", "part"),
        [
            ("param k = 1 ∗ 2", "U+2217, ASTERISK OPERATOR"),
            ("param k = 1\x07", "U+0007 (a control character)"),
            ("param k = 3 'm'", "double quotes"),
            ("param k = 12abc", "runs into letters"),
        ],
    )
    def test_what_cannot_be_read_is_named(self, text, part):
        assert part in diagnose(text).message

    def test_a_term_line_without_its_equals_sign_is_shown_with_it(self):
        assert diagnose("input x in [0, 1]\n  A triangle(0, 1, 2)").help == "write: A = triangle(0, 1, 2)"

    @pytest.mark.parametrize(
        ("line", "what", "repair"),
        [
            ("if " + " and ".join(f"x{k} is a" for k in range(102)) + " then y is b", "antecedent", "set an output"),
            ("param k = " + "-" * 102 + "1", "expression", "with 'let', or with 'param'"),
        ],
    )
    def test_what_nests_too_deeply_is_split_in_its_own_way(self, line, what, repair):
        mistake = diagnose(line)
        assert (mistake.code, mistake.message) == ("FZ106", f"the {what} nests deeper than 100 levels")
        assert repair in mistake.help
