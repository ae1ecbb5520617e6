from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl.diagnostics.source import SourceText, Span


class TestSourceText:
    def test_lines_and_columns_count_from_one(self):
        source = SourceText("a.fz", "ab\ncd\n")
        assert [(source.line_of(i), source.column_of(i)) for i in range(6)] == [
            (1, 1),
            (1, 2),
            (1, 3),
            (2, 1),
            (2, 2),
            (2, 3),
        ]

    def test_a_line_has_neither_its_line_feed_nor_its_carriage_return(self):
        source = SourceText("a.fz", "ab\r\ncd")
        assert [source.line_text(1), source.line_text(2)] == ["ab", "cd"]

    def test_utf16_columns_count_surrogates(self):
        source = SourceText("a.fz", "x𝜎y")
        assert [source.utf16_column_of(i) for i in range(4)] == [0, 1, 3, 4]

    @given(st.text(alphabet="ab\n\r σ", max_size=40))
    def test_lines_joined_are_the_text(self, text):
        source = SourceText("a.fz", text)
        lines = [source.line_text(i) for i in range(1, source.line_count + 1)]
        assert "\n".join(lines) == "\n".join(part.rstrip("\r") for part in text.split("\n"))


class TestSpan:
    def test_it_says_where_it_is(self):
        span = Span(SourceText("a.fz", "ab\ncde\n"), 4, 6)
        assert (str(span), span.text, span.end_line) == ("a.fz:2:2", "de", 2)

    def test_two_spans_join_to_the_smallest_that_covers_both(self):
        source = SourceText("a.fz", "abcdef")
        assert Span(source, 3, 4).to(Span(source, 1, 2)) == Span(source, 1, 4)
