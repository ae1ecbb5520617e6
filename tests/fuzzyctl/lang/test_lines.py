from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang.lines import split


def kinds(text):
    return [(line.kind, line.word) for line in split(SourceText("t", text))]


class TestSplit:
    def test_each_line_has_its_kind(self):
        text = "input x in [0, 1]\n  A = triangle(0, 1, 2)\n  terms A B\n\ntable u = x\n  A B\n | A B\n# c\nnonsense\n"
        assert [k for k, _ in kinds(text)] == [
            "statement",
            "term_line",
            "statement",
            "blank",
            "statement",
            "header",
            "row",
            "blank",
            "unknown",
            "blank",
        ]

    def test_a_keyword_is_a_name_before_an_equals_sign_or_a_bar(self):
        assert kinds("output = triangle(0, 1, 2)")[0] == ("term_line", "output")
        assert kinds("table | A B")[0] == ("row", "table")

    def test_a_keyword_with_more_letters_is_no_keyword(self):
        assert kinds("tablef = x")[0][0] == "term_line"

    def test_a_line_goes_on_inside_parentheses(self):
        source = SourceText("t", "A = triangle(0,  # foot\n  1,\n  2)  # end\ninput x in [0, 1]")
        lines = [*split(source)]
        assert len(lines) == 2
        assert source.text[lines[0].start : lines[0].end].endswith("2)")
        assert lines[0].comment == "# end"

    def test_an_unclosed_parenthesis_ends_at_the_next_statement(self):
        lines = [*split(SourceText("t", "input x in [0, 1\noutput u in [0, 1]"))]
        assert [line.word for line in lines] == ["input", "output"]
        assert lines[0].mistake.code == "FZ103"
        assert lines[1].mistake is None

    def test_an_unclosed_parenthesis_ends_at_the_next_term_or_row(self):
        assert len([*split(SourceText("t", "A = triangle(0, 1, 2\nB = triangle(1, 2, 3)"))]) == 2
        assert len([*split(SourceText("t", "input x in [0, 1\n NB | A B"))]) == 2

    def test_a_rule_may_be_broken_before_a_connective(self):
        lines = [*split(SourceText("t", "if (x is a\n    or x is b\n    and y is c) then z is d\nor max"))]
        assert [(line.word, line.mistake) for line in lines] == [("if", None), ("or", None)]

    def test_brackets_must_match(self):
        mistakes = [next(split(SourceText("t", text))).mistake.message for text in ("x = (1]", "x = 1)")]
        assert mistakes == ["'(' is closed by ']'", "')' closes nothing"]

    def test_ranges_of_params_may_be_open_at_an_end(self):
        texts = ("param k in (0, 1] = 1", "param\tk in [0, 1) = 0", "params in (0, 1] = 1", "input x in (0, 1]")
        assert [next(split(SourceText("t", text))).mistake is None for text in texts] == [True, True, False, False]

    def test_a_hash_or_a_parenthesis_inside_a_string_is_text(self):
        lines = [*split(SourceText("t", 'source "a (b # c"  # d'))]
        assert (lines[0].comment, lines[0].mistake) == ("# d", None)
