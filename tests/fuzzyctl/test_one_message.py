"""One mistake gives one message, in the words of the one who made it."""

import pytest

from fuzzyctl.analysis.check import check_source
from fuzzyctl.diagnostics.diagnostic import CODES, WARNINGS
from fuzzyctl.diagnostics.source import SourceText
from tests.fuzzyctl.messages import BASE, only, places, said, says


class TestTheBase:
    def test_it_is_sound(self):
        assert said() == []


class TestNumbers:
    @pytest.mark.parametrize(
        ("old", "new", "place", "point"),
        [("[-5, 5]", "[-５, 5]", "5 FZ105", "U+FF15"), ("constant(1)", "constant(1٢.5)", "6 FZ105", "U+0662")],
    )
    def test_digits_of_other_scripts_are_refused_by_their_code_point(self, old, new, place, point):
        says(place, point, (old, new))


class TestIllFormedTerms:
    @pytest.mark.parametrize("otherwise", ["", " else 0"])
    def test_hints_do_not_stumble_over_them(self, otherwise):
        terms = "  N = piecewise(1, 2, 3)\n  Z = triangle(-1, 0, 1)\n  P = triangle(0, 1, 1)"
        assert only(said(("  terms N Z P", terms), ("[-5, 5]", f"[-5, 5]{otherwise}")))[0] == "4 FZ302"


#: Everything that leans on a declaration: arity, names in params and in guarantees.
LEANING = """\
if e is P then u is linear(1, 2)
param F = 2
param G = F
require u <= F
require u(-e) <= G
"""


class TestBrokenHeads:
    @pytest.mark.parametrize(
        ("old", "new", "place"),
        [
            ("input e in [-1, 1]", "input e [-1, 1]", "3 FZ102"),
            ("input e in [-1, 1]", "input e in [-1 1]", "3 FZ102"),
            ("input e in [-1, 1]", "inptu e in [-1, 1]", "3 FZ101"),
            ("input e in [-1, 1]", "e in [-1, 1]", "3 FZ101"),
            ("output u in [-5, 5]", "output u [-5, 5]", "5 FZ102"),
            ("output u in [-5, 5]", "outptu u in [-5, 5]", "5 FZ101"),
            ("output u in [-5, 5]", "u in [-5, 5]", "5 FZ101"),
            ("table u = e\n", "table u e\n", "8 FZ102"),
            ("table u = e\n", "u = e\n", "8 FZ101"),
            ("table u = e\n", "force table = e\n", "8 FZ101"),
            ("table u = e\n", ")table u = e\n", "8 FZ103"),
            ("input e in [-1, 1]", "an input e in [-1, 1]", "3 FZ101"),
            ("input e in [-1, 1]", "input e -1 k", "3 FZ102"),
            ("table u = e\n", "", "8 FZ110"),
        ],
    )
    def test_what_leans_on_them_is_no_mistake_of_its_own(self, old, new, place):
        assert only(said((old, new), after=LEANING))[0] == place

    @pytest.mark.parametrize("new", ["param F 2", "F = 2", "prm F = 2", "param F = 2 +", "param F = (2"])
    def test_nor_what_leans_on_a_param(self, new):
        after = LEANING.replace("param F = 2", new).replace("if e is P then u is linear(1, 2)\n", "")
        assert only(said(after=after))[0].startswith("11 ")

    def test_terms_without_their_head_do_not_go_to_the_variable_above(self):
        second = "d in [0, 1]\n  N = triangle(-1, 0, 1)\n  Z = triangle(0, 1, 2)\noutput u"
        says("5 FZ101", "'input' or 'output'", ("output u", second))

    @pytest.mark.parametrize("head", ["table u e", "u = e", "tabel u = e"])
    def test_a_slice_of_a_broken_table_is_not_missed(self, head):
        assert only(said(("table u = e", f"with e is N\n{head}")))[0].startswith("9 ")

    @pytest.mark.parametrize(
        "line", ["b = constant(2|3)", "b = constant(2)|", "b | constant(2)", "| b = constant(2)", "|b = constant(2)"]
    )
    def test_a_stray_bar_makes_no_table_row_of_a_term(self, line):
        says("7 FZ102", "unexpected '|'", ("b = constant(2)", line))

    def test_after_500_lines_it_says_that_it_stops(self):
        found = said(after="param k = (1]\n" * 900)
        assert [code for _, code, _ in found] == ["FZ103"] * 500 + ["FZ112"]
        assert "too many errors (500)" in found[-1][2]


#: Blocks of equations below the base text, with the first words of their lines.
BLOCKS = """\
controller c
input x
input beta
let d = derivative(2 * beta)
output y = d + x
every 1 s
plant p
input v
state h = 0
der h = v - h
output y = h
loop run
block c = c(r, p.y)
block p = p(c.y)
let r = steps(0: 1)
measure m = iae(p.y, r)
run 5 s
"""


class TestBlocks:
    @pytest.mark.parametrize(
        ("old", "new", "place"),
        [
            ("controller c", "a controller c", "11 FZ101"),
            ("controller c", ")controller c", "11 FZ103"),
            ("plant p", "motor plant p", "17 FZ101"),
            ("loop run", "less_rate loop", "22 FZ101"),
            ("loop run", "- loop run", "22 FZ101"),
            ("(2 * beta)", "(2 * be", "14 FZ103"),
        ],
    )
    def test_a_slip_before_the_head_costs_no_more_than_itself(self, old, new, place):
        assert old in BLOCKS
        assert only(said(after=BLOCKS.replace(old, new, 1)))[0] == place

    def test_a_half_typed_name_is_none_of_its_own(self):
        assert only(said(after="let z = (2 * be\n"))[0] == "11 FZ103"


class TestFiles:
    def test_rows_below_a_table_from_a_file_are_refused_once(self, tmp_path):
        (tmp_path / "t.csv").write_text(",N,Z,P\n,a,a,b\n")
        says("8 FZ218", "rows here and in a file", ("table u = e", 'table u = e from "t.csv"'), folder=tmp_path)


class TestGuarantees:
    def test_one_that_names_no_output_is_warned_of(self):
        says("11 FZ214", "names no output", after="require e < 2\n")


class TestPartitions:
    def test_peaks_out_of_order_are_named_as_they_were_typed(self):
        says(
            "4 FZ301", "the peaks of 'e' are out of order: 0.5 of 'Z', then 0", ("terms N Z P", "terms N@-1 Z@0.5 P@0")
        )

    def test_an_infinite_range_is_named_once(self):
        assert only(said(("[-1, 1]", "[-inf, inf]")))[0] == "3 FZ302"

    @pytest.mark.parametrize(("ends", "part"), [("[5, -5]", "swap the ends"), ("[1, 1]", "above the lower one")])
    def test_an_empty_range_has_its_own_repair(self, ends, part):
        says(
            "5 FZ304",
            part,
            ("[-5, 5]", f"{ends} adaptive rate e"),
            ("  a = constant(1)\n  b = constant(2)", "  terms a=0 b=2"),
        )


class TestNumbersUnderACentroid:
    @pytest.mark.parametrize("method", ["centroid", "bisector"])
    def test_are_called_numbers_and_reported_once_for_all_terms(self, method):
        where, words = only(said(("weighted_average", method)))
        assert where == "6 FZ214"
        start = f"term 'a' of 'u' is a number and has no area, so it has no {method} | the same holds for 'b' |"
        assert words.startswith(start)

    def test_functions_are_called_functions(self):
        _, words = only(said(("weighted_average", "centroid"), ("constant(1)", "linear(1, 2)")))
        assert "term 'a' of 'u' is a function of the inputs and has no area" in words


class TestSpacedSums:
    def test_are_warned_of(self):
        says(
            "6 FZ113",
            "for two parameters write '-3, -1', for one '-3 - 1'",
            ("weighted_average", "center_average"),
            ("constant(1)", "triangle(-3 -1, 0, 1)"),
        )

    @pytest.mark.parametrize("text", ["triangle(-3 - 1, 0, 1)", "triangle(-3-1, 0, 1)"])
    def test_others_are_not(self, text):
        assert said(("weighted_average", "center_average"), ("constant(1)", text)) == []


class TestSettings:
    def test_an_unknown_aggregation_is_not_also_without_effect(self):
        assert only(said(("weighted_average", "weighted_average\naggregation min")))[0] == "3 FZ213"


class TestSentences:
    @pytest.mark.parametrize(
        ("old", "new", "sentence"),
        [
            ("constant(1)", "function(q)", "no param, input or output 'q' | params, inputs and outputs: e, u"),
            ("defuzz", "hedge h(x) = x * e\ndefuzz", "'e' is neither a param nor 'x' | known here: x"),
            ("  terms N Z P", "  N = function(q)", "'q' is neither a param nor 'e' itself | known here: e"),
            ("constant(1)", "constant(abs(1, 2))", "'abs' takes 1 argument, not 2"),
            ("a a b", "a a a/b", "the cell names 2 terms for 1 output | name one term"),
        ],
    )
    def test_they_are_whole(self, old, new, sentence):
        assert any(words.startswith(sentence) for _, _, words in said((old, new)))

    def test_an_empty_system_is_reported_with_everything_at_once(self):
        _, diagnostics = check_source(SourceText("t.fz", "system a\n"))
        assert [d.message for d in diagnostics] == ["the system has no input and no output and no rules"]

    def test_a_hedge_given_twice_points_at_the_first(self):
        says("3 FZ201", "first declared here", ("defuzz", "hedge h(x) = x\nhedge h(x) = x\ndefuzz"))


class TestParams:
    @pytest.mark.parametrize(
        ("old", "new", "part"),
        [
            ("a a b", "1/2 a b", "(1/2)"),
            ("a a b", "k a b", "(k)"),
            ("a a b", "a*k a b", "(k)"),
            ("a a b", "-k a b", "(-k)"),
            ("terms N Z P", "terms N@k-1 Z@1 P@2", "(k-1)"),
            ("  a = constant(1)\n  b = constant(2)", "  terms a=1 b=1+k", "(1+k)"),
            ("table u", "if e is N then u is a weight k\ntable u", "(k)"),
            ("table u", "if e is N then u is k\ntable u", "(k)"),
        ],
    )
    def test_where_only_a_number_may_stand_the_parentheses_are_shown(self, old, new, part):
        _, words = only(said(("defuzz", "param k = 0.5\ndefuzz"), (old, new)))
        assert part in words


class TestSystemLines:
    def test_one_repeated_is_reported(self):
        for text in ("system s\nsystem s\n", f"{BASE}system s\n", f"system s\n{BASE}"):
            _, diagnostics = check_source(SourceText("t.fz", text))
            assert [d.code for d in diagnostics] == ["FZ215"], text
            assert diagnostics[0].notes[0].span.line == 1

    def test_a_profile_given_twice(self):
        assert only(said(("defuzz", "semantics exact\nsemantics exact\ndefuzz")))[0] == "3 FZ215"

    def test_a_version_given_twice_or_late(self):
        assert only(said(("system s", "fz 1\nfz 1\nsystem s")))[0] == "2 FZ215"
        assert only(said(after="fz 1\n"))[0] == "11 FZ214"
        assert said(("system s", "fz 1\nsystem s")) == []

    def test_an_error_cannot_be_allowed(self):
        says("11 FZ213", "cannot be allowed", after="allow FZ203\n")

    def test_those_that_are_warnings_can(self):
        assert set(CODES) >= WARNINGS
        assert said(after=f"allow {' '.join(sorted(WARNINGS))}\n") == []


class TestUsedFiles:
    USER = (("input e in [-1, 1]\n  terms N Z P\n", 'use "zz.fz"\n'), ("constant(1)", "constant(k)"))

    @pytest.mark.parametrize(
        ("used", "place"),
        [
            ("input e [-1, 1]\n  terms N Z P\nparam k = 1\n", "1 FZ102"),
            ("input e in [-1, 1]\n  terms N Z P\nparam k = (1\n", "3 FZ103"),
        ],
    )
    def test_what_is_broken_there_is_not_missed_here(self, tmp_path, used, place):
        (tmp_path / "zz.fz").write_text(used)
        assert only(said(*self.USER, after="if e is N then u is linear(1, 2)\n", folder=tmp_path))[0] == place

    def test_a_missing_file_is_all_that_is_said_and_the_one_meant_is_named_from_here(self, tmp_path):
        (tmp_path / "sub").mkdir()
        (tmp_path / "sub" / "zz.fz").write_text("param k = 1\n")
        says(
            "3 FZ218",
            "did you mean 'sub/zz.fz'?",
            (self.USER[0][0], 'use "sub/zzz.fz"\n'),
            self.USER[1],
            folder=tmp_path,
        )

    @pytest.mark.parametrize(("name", "help_text"), [("minr.fz", ""), ("tabel.csv", "did you mean 'table.csv'?")])
    def test_no_file_is_said_to_mean_itself(self, tmp_path, name, help_text):
        for file in ("mine.fz", "table.csv"):
            (tmp_path / file).write_text("param k = 1\n")
        text = f'use "{name}"\n{BASE}' if name.endswith("fz") else BASE.replace("= e\n", f'= e from "{name}"\n', 1)
        text = text.replace("    N Z P\n  | a a b\n", "") if name.endswith("csv") else text
        _, diagnostics = check_source(SourceText("mine.fz", text), folder=tmp_path)
        assert [(d.code, d.help) for d in diagnostics] == [("FZ218", help_text)]


class TestOutputsWithoutTerms:
    BARE = ("  a = constant(1)\n  b = constant(2)\n", "")

    def test_numbers_and_functions_need_none(self):
        assert said(self.BARE, ("a a b", "0.5 linear(1, 2) function(e)")) == []

    def test_the_first_rule_that_names_one_is_shown(self):
        says("5 FZ212", "'a' is named here", self.BARE, ("a a b", "0.5 a b"), after="if e is N then u is a\n")


class TestNoMistakeHidesAnother:
    @pytest.mark.parametrize("average", ["center_average", "weighted_average", "weighted_sum"])
    @pytest.mark.parametrize("term", ["piecewise(1, 0, 2)", "gaussian2(1, 0, 0, 1)"])
    def test_an_unsound_term_of_an_output_is_named_and_not_averaged(self, average, term):
        assert only(said(("weighted_average", average), ("constant(1)", term)))[0] == "6 FZ302"

    def test_nor_is_it_inverted(self):
        ramps = ("constant(1)", "s_shape(2, 1)"), ("constant(2)", "ramp(0, 1)")
        assert places(said(("weighted_average", "tsukamoto"), *ramps)) == ["6 FZ302"]

    @pytest.mark.parametrize(
        "broken",
        ["param q = 1 / 0", "param q = q", "if e is", "if e is M then u is a", "fuzz", "param q = r", "table v = e"],
    )
    def test_bad_numbers_are_found_beside_whatever_else_is_broken(self, broken):
        bad = ("[-5, 5]", "[5, -5]"), ("constant(1)", "triangle(3, 2, 1)")
        assert places(said(*bad, after=f"if e is N then u is a weight 3\n{broken}\n")) == [
            "5 FZ304",
            "6 FZ301",
            "11 FZ302",
            places(said(after=f"param u_max = 1\n{broken}\n"))[0],
        ]

    def test_a_rule_without_meaning_keeps_its_weight(self):
        assert places(said(after="if e is M then u is a weight 3\n")) == ["11 FZ203", "11 FZ302"]

    def test_cells_are_read_below_a_misspelt_header(self):
        assert places(said(("N Z P\n  |", "N Z Q\n  |"), ("a a b", "a a c"))) == ["9 FZ203", "10 FZ203"]

    def test_what_uses_a_param_without_value_is_not_at_fault(self):
        after = "param q = 1 / 0\nparam r = q + 1\nrequire u <= r within q\nif e is N then u is a weight (q)\n"
        assert places(said(("[-5, 5]", "[-q, q]"), after=after)) == ["11 FZ307"]

    def test_an_expression_that_has_no_meaning_is_not_computed(self):
        assert only(said(("[-1, 1]", "[-1, abs(1, 2)]")))[0] == "3 FZ303"

    def test_a_broken_first_line_hides_nothing(self):
        assert places(said(("system s", "systm s"), ("[-5, 5]", "[5, -5]"))) == ["1 FZ101", "5 FZ304"]


class TestBounds:
    def test_a_chain_of_outputs_is_bounded(self):
        chain = "".join(f"output v{i} in [0, 1]\n  A = constant(1)\nif e is N then v{i} is A\n" for i in range(200))
        says("1 FZ112", "201 outputs, more than 200", after=chain)


class TestElse:
    @pytest.mark.parametrize("otherwise", ["6", "-6", "hold(6)", "(2 * 3)"])
    def test_a_value_outside_the_range_is_warned_of(self, otherwise):
        says(
            "5 FZ306",
            f"the 'else' value {'-6' if otherwise == '-6' else '6'} lies outside the range [-5, 5] of 'u'",
            ("[-5, 5]", f"[-5, 5] else {otherwise}"),
        )

    @pytest.mark.parametrize("otherwise", ["5", "hold(-5)", "hold", "nan"])
    def test_one_within_it_is_not(self, otherwise):
        assert said(("[-5, 5]", f"[-5, 5] else {otherwise}")) == []
