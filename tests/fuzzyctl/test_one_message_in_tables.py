"""One mistake in a table gives one message, in the words of the one who made it."""

import pytest

from tests.fuzzyctl.messages import only, said, says

CROSSED = (
    ("input e in [-1, 1]\n  terms N Z P", "input e in [-1, 1]\n  terms N Z P\ninput d in [0, 1]\n  terms N Z P"),
    ("table u = e\n    N Z P\n  | a a b\n", 'table u = e x d from "t.csv"\n'),
    ("[-5, 5]", "[-5, 5] else 0"),
)


class TestCsvFields:
    def read(self, tmp_path, csv):
        """What is said of the fields; that an empty cell at the end of a range makes the output jump is true there."""
        (tmp_path / "t.csv").write_text(csv)
        return [message for message in said(*CROSSED, folder=tmp_path) if message[1] != "FZ405"]

    @pytest.mark.parametrize(
        "csv",
        [
            ',N,Z,P\n"N",a,"a", b\nZ,a,a,"linear(1, 0.5, 3)"\nP,a,0.5,b*(1/2)\n',
            "e\\d;N;Z;P\nN;a;a;b\nZ;a;a;b\nP;a;0.5;.\n",
            '"e, d",N,Z,P\r\n\r\nN,a,a,b\r\nZ,a,a,b\r\n,,,\r\nP,a,a,b',
        ],
    )
    def test_quotes_semicolons_and_a_corner_are_read(self, tmp_path, csv):
        assert self.read(tmp_path, csv) == []

    @pytest.mark.parametrize(
        ("csv", "place", "part"),
        [
            (",N,Z,P\nN,,a,b,b\nZ,a,a,b\nP,a,a,b\n", "2 FZ207", "the field of cell 1 is empty | write '.'"),
            (",N,,P\nN,a,a,b\nZ,a,a,b\nP,a,a,b\n", "1 FZ207", "the field of column 2 is empty"),
            (",N,Z,P\nN,a,a,b,\nZ,a,a,b\nP,a,a,b\n", "2 FZ207", "a ',' too many | remove it"),
            (";N;Z;P;\nN;a;a;b;\nZ;a;a;b;\nP;a;a;b\n", "1 FZ207", "remove it here and in 2 other lines"),
            ("\tN\tZ\tP\nN\ta\ta\tb\nZ\ta\ta\tb\nP\ta\ta\tb\n", "1 FZ105", "parted by tabs"),
            (",N,Z,P\rN,a,a,b\rZ,a,a,b\rP,a,a,b\r", "1 FZ105", "line ends LF or CRLF"),
            (",N,Z,P\nN,a,a # why,b\nZ,a,a,b\nP,a,a,b\n", "2 FZ105", "no comments"),
            (",N,Z,P\nN # why,a,a,b\nZ,a,a,b\nP,a,a,b\n", "2 FZ105", "no comments"),
            (",N,Z,P\nN,a a,b,b\nZ,a,a,b\nP,a,a,b\n", "2 FZ102", "unexpected 'a'"),
            (",N,Z,P\nN,linear(1, 2, 3),b,b\nZ,a,a,b\nP,a,a,b\n", "2 FZ103", "in double quotes"),
            (',N,Z,P\nN,"a,b,b\nZ,a,a,b\nP,a,a,b\n', "2 FZ104", "quoted field"),
            ("N,Z,P\nN,a,a,b\nZ,a,a,b\nP,a,a,b\n", "1 FZ207", "begin it with an empty field"),
            (",N,Z,P\nN,a,a,b\n,a,a,b\nP,a,a,b\n", "3 FZ207", "in its first field"),
            (",N Z,P\nN,a,b\n", "1 FZ102", "parted by commas"),
            ("", "10 FZ212", "the form of the file is: the first line"),
        ],
    )
    def test_a_field_that_is_no_cell_is_named(self, tmp_path, csv, place, part):
        where, words = only(self.read(tmp_path, csv))
        assert where == place
        assert part in words


class TestTheFormOfATable:
    def test_a_cross_without_its_keyword_is_a_table(self):
        crossed = said(*CROSSED[:1], ("table u = e\n    N Z P\n", "u = e x d\n    N Z P\nN"))
        assert only(crossed)[0] == "10 FZ101"

    @pytest.mark.parametrize("rows", ["  N | a\n  Z | a\n  P | b", "  | N Z P\n  | a a b"])
    def test_a_table_without_header_is_shown_its_own_form(self, rows):
        says(
            "8 FZ212", "the form is: a line 'N Z P', below it a line '| CELL CELL CELL'", ("    N Z P\n  | a a b", rows)
        )


class TestTables:
    def test_swapped_rows_and_columns_are_seen_at_once(self):
        crossed = ("table u = e\n    N Z P\n  | a a b\n", "table u = e x d\n N Z P\nA | a a b\nB | b b a\n")
        other = ("output u", "input d in [0, 1]\n  terms A B\noutput u")
        says("10 FZ214", "write: table u = d x e", crossed, other)

    def test_cells_for_too_few_outputs_are_named_once(self):
        two = (("output u", "output v in [0, 1]\n  terms lo=0 hi=1\noutput u"), ("table u = e", "table u, v = e"))
        says("12 FZ207", "1 term for 2 outputs | and so do 2 other cells", *two)


TWO_WAY = (
    ("output u", "input d in [0, 1]\n  terms A B\noutput u"),
    ("table u = e\n    N Z P\n  | a a b\n", "table u = d x e\n    N Z P\n  A | a a b\n  B | b b a\n"),
)


class TestRowsAndHeadersAsPapersPrintThem:
    @pytest.mark.parametrize(
        ("without", "place", "help_text"),
        [
            ("A |", "12 FZ102", "write 'A | a a b'"),
            ("B |", "13 FZ102", "write 'B | b b a'"),
            ("AB", "12 FZ102", "and so does 1 other row | write 'A | a a b'"),
        ],
    )
    def test_a_row_without_its_bar_is_shown_with_it(self, without, place, help_text):
        bars = [(f"{label} |", f"{label}  ") for label in "AB" if label in without]
        says(place, help_text, *TWO_WAY, *bars)

    def test_so_is_that_of_a_one_way_table(self):
        says("10 FZ102", "write '| a a b'", ("| a a b", "  a a b"))

    def test_a_line_below_a_table_that_is_no_row_is_none(self):
        says("11 FZ101", "begins no statement", after="fi e is N\n")

    @pytest.mark.parametrize("corner", ["d\\e", "d/e", "d \\ e |"])
    def test_a_corner_is_to_be_left_out(self, corner):
        says("11 FZ102", "leave it out", *TWO_WAY, ("    N Z P\n  A", f" {corner} N Z P\n  A"))

    def test_so_is_one_that_is_a_name(self):
        where, words = only(said(*TWO_WAY, ("    N Z P\n  A", "  d N Z P\n  A")))
        assert where == "11 FZ102"
        assert words == "a table of a rule file has no corner | write: N Z P"

    def test_a_table_does_not_read_the_output_that_it_sets(self):
        where, words = only(said(*TWO_WAY, ("= d x e", "= d x u")))
        assert where == "10 FZ214"
        assert words.startswith("the table sets 'u' and reads it")

    def test_so_is_the_bar_of_a_header(self):
        says("10 FZ212", "leave the bar of the first line out", *TWO_WAY, ("    N Z P\n  A", "  | N Z P\n  A"))
