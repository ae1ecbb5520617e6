import pytest

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.parser import parse


def statements(text):
    tree, diagnostics = parse(SourceText("t", text))
    assert diagnostics == []
    return tree.statements


def one(text):
    (statement,) = statements(text)
    return statement


def mistakes(text):
    _, diagnostics = parse(SourceText("t", text))
    return [(d.code, d.span.line) for d in diagnostics]


class TestStatements:
    def test_a_system_has_a_name_and_a_title(self):
        system = one('system ais "Immune reaction"')
        assert (system.name.text, system.title) == ("ais", "Immune reaction")

    def test_a_setting_may_have_options(self):
        setting = one("defuzzifier centroid(resolution=100, grid=midpoint)")
        assert [(o.name.text, o.value.text) for o in setting.options] == [("resolution", "100"), ("grid", "midpoint")]

    def test_a_variable_takes_label_range_and_clauses_in_any_order(self):
        output = one('output u "U" in [-1, k] else (a) unit "V" adaptive rate g * x')
        assert output.label == "U"
        assert output.upper == ex.Name("k")
        assert [type(c).__name__ for c in output.clauses] == ["FallbackClause", "UnitClause", "AdaptiveClause"]

    @pytest.mark.parametrize("word", sorted(set(sx.STATEMENT_KEYWORDS) - sx.RESERVED))
    @pytest.mark.parametrize("form", ["{} = ramp(0, 1)", "{}=ramp(0,1)", "{}  =  ramp(0, 1)"])
    def test_a_term_may_be_called_like_a_keyword(self, word, form):
        (term,) = one(f"input x in [0, 1]\n  {form.format(word)}").terms
        assert (term.name.text, term.kind.text) == (word, "ramp")

    @pytest.mark.parametrize("word", ["else", "unit", "implication", "weight"])
    @pytest.mark.parametrize("value", ["0.5", "-1", "(k)", "a*0.5"])
    def test_a_cell_behind_a_number_may_be_called_like_a_keyword(self, word, value):
        (row,) = one(f"table y = x\n  a b c\n| {value} {word} b*0.5").rows
        assert [c.terms[0].text for c in row.cells[1:]] == [word, "b"]

    def test_a_term_takes_positional_and_named_parameters(self):
        variable = one("input x in [0, 1]\n A = triangle(-inf, peak=0.5, right=1)")
        (term,) = variable.terms
        assert [a.keyword and a.keyword.text for a in term.arguments] == [None, "peak", "right"]
        assert term.arguments[0].value == ex.Negate(ex.Name("inf"))

    def test_a_partition_takes_peaks_values_or_bare_names(self):
        items = [one(f"input x in [0, 1]\n terms {t}").terms[0].items[1] for t in ("A@0 B@-1.5", "A=0 B=(2*k)", "A B")]
        assert items[0].peak == ex.Number(-1.5)
        assert items[1].value == ex.Binary("*", ex.Number(2.0), ex.Name("k"))
        assert (items[2].peak, items[2].value) == (None, None)

    def test_a_table_has_header_and_rows(self):
        table = one("table f = x x y\n   A B\n N | P .\n Z | P*0.5 Q")
        assert (table.first.text, table.second.text) == ("x", "y")
        assert [w.text for w in table.header.terms] == ["A", "B"]
        assert table.rows[0].cells[1].terms == ()
        assert table.rows[1].cells[0].weight == ex.Number(0.5)

    def test_a_rule_keeps_its_parentheses_apart(self):
        rule = one("if a is NB and not (b is PS or b is ZO) then f is NS, g is PB weight 0.5")
        assert isinstance(rule.antecedent, sx.Chain)
        assert isinstance(rule.antecedent.operands[1].operand, sx.Group)
        assert [c.output.text for c in rule.consequents] == ["f", "g"]
        assert rule.weight == ex.Number(0.5)

    def test_a_guarantee_has_claim_tolerance_and_region(self):
        require = one("require f(-x, -y) == f within 1e-12 when abs(x) >= 0.03 and not y < 0")
        assert isinstance(require.claim, ex.Compare)
        assert require.within == ex.Number(1e-12)
        assert isinstance(require.when, ex.Logic)

    @pytest.mark.parametrize("word", ["error", "table", "x", "in", "input", "unit", "is", "rate", "if"])
    def test_keywords_are_names_where_a_name_is_due(self, word):
        variable, table = statements(
            f"input {word} in [0, 1]\n {word} = triangle(0, 1, 2)\ntable {word} = {word} x {word}"
        )
        assert variable.name.text == variable.terms[0].name.text == word
        assert table.outputs[0].text == table.second.text == word

    def test_names_are_normalised(self):
        assert one("system e\u0301").name.text == "\u00e9"

    def test_places_are_those_of_the_whole_file(self):
        tree, _ = parse(SourceText("t", "system a\n\nparam k = 1 +\\\n".replace("\\\n", " 2\n")))
        span = tree.statements[1].expression.span
        assert (span.line, span.column, span.text) == (3, 11, "1 + 2")


class TestMistakes:
    def test_one_mistake_each_line_each_reported(self):
        text = "sytem a\nparam = 3\nparam k = 1 2\nif a is then b\ninput x [0, 1]\n"
        assert [line for _, line in mistakes(text)] == [1, 2, 3, 4, 5]

    @pytest.mark.parametrize("head", ["input x [0, 1]", "input x about 1"])
    def test_a_slip_in_a_head_hides_no_mistake_of_its_block(self, head):
        text = f"{head}\n A = triangle(0 1 x)\n terms\n B = triangle(0, 1, 2)\noutput u in [0, 1]\n terms A B"
        assert mistakes(text) == [("FZ102", 1), ("FZ102", 2), ("FZ102", 3)]

    def test_of_500_lines_with_91_broken_exactly_those_are_reported(self):
        lines = [f"param p{i} = {i}" for i in range(500)]
        broken = list(range(3, 500, 5))[:91]
        for i in broken:
            lines[i] = ("param p = ", f"parm p{i} = {i}", f"param p{i} == {i}", f"param {i} = (", "param q = 3 'm'")[
                i % 5
            ]
        assert [line - 1 for _, line in mistakes("\n".join(lines))] == broken

    @pytest.mark.parametrize(
        ("text", "code"),
        [
            ("param k = " + "(" * 101 + "1" + ")" * 101, "FZ106"),
            ("param k = " + "-" * 101 + "1", "FZ106"),
            ("param k = " + "1+" * 101 + "1", "FZ106"),
            ("param k = " + "2^" * 50_000 + "1", "FZ106"),
            ("if a is " + "very " * 101 + "b then c is d", "FZ106"),
            ("if " + "a is b and " * 101 + "a is b then c is d", "FZ106"),
            ("if " + "not " * 101 + "a is b then c is d", "FZ106"),
            ("param " + "k" * 201 + " = 1", "FZ107"),
            ("param k = 1e999", "FZ108"),
            ("param k = 1e-999", "FZ108"),
            ("param k = 5m", "FZ102"),
            ("param k = 'x'", "FZ105"),
            ("param k = ½", "FZ105"),
            ("if a is b or c is d and e is f then g is h", "FZ109"),
        ],
    )
    def test_what_is_out_of_bounds_is_diagnosed(self, text, code):
        assert [c for c, _ in mistakes(text)] == [code]

    def test_mixed_connectives_with_parentheses_are_fine(self):
        assert mistakes("if (a is b or c is d) and e is f then g is h") == []

    def test_a_misspelt_word_inside_a_statement_is_named(self):
        _, (diagnostic,) = parse(SourceText("t", "if a is b then c is d wieght 0.5"))
        assert "weight" in diagnostic.help


class TestLimits:
    @pytest.mark.parametrize(
        ("head", "line"),
        [("system s\n", "let a = x + 1\n"), ("controller c\n", "let a = x + 1\n"), ("plant p\n", "der a = 1\n")],
    )
    def test_lines_of_equations_are_counted(self, head, line, monkeypatch):
        monkeypatch.setattr("fuzzyctl.lang.parser.MAX_EQUATIONS", 20)
        assert not mistakes(head + 19 * line)
        _, (mistake,) = parse(SourceText("t", head + 40 * line))
        assert (mistake.code, mistake.message) == ("FZ112", "more than 20 lines of controllers, plants, loops and lets")
        assert mistake.span.line == (22 if head.startswith("system") else 21)

    def test_words_are_counted(self, monkeypatch):
        monkeypatch.setattr("fuzzyctl.lang.parser.MAX_WORDS", 24)
        rule = "if x is (a or b) then y is c\n"  # of ten words and a parenthesis
        assert not mistakes("system s\n" + 2 * rule)
        _, (mistake,) = parse(SourceText("t", "system s\n" + 20 * rule))
        assert (mistake.code, mistake.span.line) == ("FZ112", 4)
        assert mistake.message == "more than 24 words, numbers and parentheses"


class TestFilesOfOtherTools:
    @pytest.mark.parametrize(
        ("text", "what", "suffix", "column"),
        [
            ("% a comment\n[System]\nName='t'\nVersion=2.0\n", "a file of MATLAB or Octave", ".fis", 1),
            ("# a comment\nEngine: e\nInputVariable: x\n", "a fuzzylite file", ".fll", 1),
            ("(* a\ncomment *)  function_block f\nVAR_INPUT\n", "an FCL file", ".fcl", 13),
            ("\n  <?xml version='1.0'?>\n<FuzzyController>\n", "an FML file", ".fml", 3),
            ("\n<fuzzySystem name='x'>\n", "an FML file", ".fml", 1),
        ],
    )
    def test_are_one_mistake_with_the_suffix_that_they_need(self, text, what, suffix, column):
        tree, (mistake,) = parse(SourceText("t", text))
        assert not tree.statements
        assert mistake.message == f"this is {what}, not a rule file"
        assert f"ends with '{suffix}'" in mistake.help
        assert (mistake.span.line, mistake.span.column) == (2, column)
