import pytest

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.expr import Number
from fuzzyctl.loading.load import loads
from fuzzyctl.model.rule import And, Is, Not, Or
from tests.fuzzyctl.messages import only, said


def errors(text):
    with pytest.raises(DiagnosticError) as error:
        loads(text)
    return [(d.code, d.span.line) for d in error.value.diagnostics]


class TestTables:
    def test_cells_become_rules_row_by_row(self, base):
        rules = loads(base).rules
        first = rules[1]
        assert first.antecedent == And(operands=(Is(variable="x", term="N"), Is(variable="y", term="P")))
        assert [r.consequents[0].term for r in rules] == ["N", "Z", "N", "P", "Z", "P"]

    def test_rows_and_columns_may_stand_in_any_order(self, base, changed):
        other = changed(
            ("       N  P\n", "       P  N\n"),
            ("N |  N  Z", "N |  Z  N"),
            ("Z |  N  P", "Z |  P  N"),
            ("P |  Z  P", "P |  P  Z"),
        )
        point = {"x": 0.3, "y": 2.0}
        assert loads(other)(**point) == pytest.approx(loads(base)(**point), rel=1e-14)

    def test_a_dot_is_no_rule_and_a_weight_belongs_to_the_cell(self, changed):
        rules = loads(changed(("N |  N  Z", "N |  .  Z*0.5"))).rules
        assert len(rules) == 5
        assert rules[0].weight == Number(0.5)

    def test_a_table_may_set_two_outputs(self, changed):
        text = changed(("table u", "output v in [0, 1]\n  A = triangle(0, 0.5, 1)\n\ntable u, v"))
        for row in ("N  Z", "N  P", "Z  P"):
            a, b = row.split()
            text = text.replace(f"|  {row}", f"|  {a}/A  {b}/A", 1)
        assert [c.output for c in loads(text).rules[0].consequents] == ["u", "v"]

    @pytest.mark.parametrize(
        ("old", "new", "code", "line"),
        [
            ("Z |  N  P", "Z |  N  P  Z", "FZ207", 19),
            ("Z |  N  P", "  |  N  P", "FZ207", 19),
            ("Z |  N  P", "Z |  N  P/Z", "FZ207", 19),
            ("Z |  N  P", "Q |  N  P", "FZ203", 19),
            ("Z |  N  P", "Z |  N  P*k", "FZ102", 19),
            ("Z |  N  P", "Z |  N  P*(k)", "FZ202", 19),
            ("Z |  N  P", "Z |  N  P*1.5", "FZ302", 19),
            ("table u = x x y", "table u = x x x", "FZ214", 16),
            ("table u = x x y", "table u = x x u", "FZ214", 16),
            ("table u = x x y", "table u = x", "FZ214", 18),
            ("table u = x x y", "table w = x x y", "FZ202", 16),
            ("       N  P\n", "", "FZ212", 16),
            ("       N  P\n", "       N  N\n", "FZ206", 17),
        ],
    )
    def test_mistakes_are_found_at_their_line(self, changed, old, new, code, line):
        assert (code, line) in errors(changed((old, new)))


class TestRules:
    def test_not_binds_tighter_than_and(self, changed):
        rule = loads(changed(after="if not x is N and y is P then u is Z\n")).rules[-1]
        assert rule.antecedent == And(operands=(Not(operand=Is(variable="x", term="N")), Is(variable="y", term="P")))

    def test_parentheses_group(self, changed):
        rule = loads(
            changed(after="if x is N and (y is P or y is N) then u is Z weight 1 / 2\n".replace("1 / 2", "(1 / 2)"))
        ).rules[-1]
        assert isinstance(rule.antecedent.operands[1], Or)

    @pytest.mark.parametrize(
        ("rule", "code"),
        [
            ("if x is Q then u is N", "FZ203"),
            ("if z is N then u is N", "FZ202"),
            ("if u is N then u is N", "FZ217"),
            ("if x is vry N then u is N", "FZ202"),
            ("if x is N then y is N", "FZ214"),
            ("if x is N then u is N, u is P", "FZ215"),
            ("if x is N then u is N weight 2", "FZ302"),
            ("if x is N then u is Q", "FZ203"),
        ],
    )
    def test_mistakes_are_found(self, changed, rule, code):
        assert errors(changed(after=rule + "\n")) == [(code, 21)]

    def test_an_output_that_is_set_twice_is_shown_in_both_places(self, changed):
        with pytest.raises(DiagnosticError) as caught:
            loads(changed(after="if x is N then u is N, u is P\n"))
        (error,) = caught.value.diagnostics
        assert (error.span.column, error.notes[0].span.column) == (24, 16)
        assert error.help == "remove one of them, or write two rules"


class TestRequire:
    @pytest.mark.parametrize(
        "claim",
        [
            "u <= 2",
            "u(-x, 10 - y) == -u within 1e-12",
            "total(u)",
            "total(u) >= 0.1 within 0.01 when x > 0",
            "not total(u) >= 1 / 2",
            "increasing(u, x)",
            "lipschitz(u, x) <= 2 * 3",
            "bounded(u, -2, 2) within 0.1 when x > 0",
            "not (u < -2) and increasing(u, x)",
            "u <= 0 when x < 0",
        ],
    )
    def test_a_claim_is_stored(self, changed, claim):
        assert len(loads(changed(after=f"require {claim}\n")).guarantees) == 1

    @pytest.mark.parametrize(
        ("claim", "code"),
        [
            ("u", "FZ307"),
            ("w > 1", "FZ202"),
            ("u(x) == 1", "FZ303"),
            ("foo(u) > 1", "FZ202"),
            ("u > 1 within q", "FZ202"),
            ("abs(u, 2) > 0", "FZ303"),
            ("bounded(u)", "FZ303"),
            ("total()", "FZ303"),
            ("increasing(1, 2)", "FZ303"),
            ("increasing(x, u)", "FZ202"),
            ("lipschitz(u, x)", "FZ307"),
            ("bounded(u, 0, 1) > 3", "FZ307"),
            ("u >= 0 when 3", "FZ307"),
            ("(x < 1) + 1 > 0", "FZ307"),
            ("not 3", "FZ307"),
            ("u and x", "FZ307"),
            ("u >= 0 within -1", "FZ302"),
            ("bounded(u, 1, -1)", "FZ302"),
            ("bounded(u, 0, inf)", "FZ302"),
            ("u >= 1 / 0", "FZ307"),
            ("u >= x * (1 / (2 - 2))", "FZ307"),
            ("u > inf", "FZ302"),
            ("u > 0 when x < log(-1)", "FZ307"),
            ("lipschitz(u, x) >= 3", "FZ303"),
            ("lipschitz(u, x) == 3", "FZ303"),
            ("3 >= lipschitz(u, x)", "FZ303"),
            ("2 * lipschitz(u, x) <= 3", "FZ303"),
            ("lipschitz(u, x) <= x", "FZ202"),
            ("lipschitz(u, x) <= -1", "FZ302"),
            ("total(u) within 0.1", "FZ214"),
            ("total(u) >= 0", "FZ302"),
            ("total(u) >= 1.5", "FZ302"),
            ("total(u) >= x", "FZ202"),
            ("total(u) <= 0.5", "FZ307"),
            ("total(x) >= 0.5", "FZ202"),
            ("2 * total(u) >= 0.5", "FZ307"),
            ("u >= 0 when total(u)", "FZ214"),
        ],
    )
    def test_a_malformed_claim_is_refused(self, changed, claim, code):
        assert set(errors(changed(after=f"require {claim}\n"))) == {(code, 21)}


class TestWordsOfOtherTools:
    def test_xor_is_no_connective(self):
        place, words = only(said(after="if e is N xor e is P then u is a\n"))
        assert place == "11 FZ102"
        assert words.startswith("there is no connective 'xor' | 'A xor B' is written: (A or B) and not (A and B)")

    @pytest.mark.parametrize(
        ("end", "advice"),
        [
            ("a with weight 0.5", "remove 'with'"),
            ("a weigth 0.5", "did you mean 'weight'?"),
            ("a hardly", "a rule ends with its last term"),
        ],
    )
    def test_a_word_behind_the_last_term(self, end, advice):
        found = said(after=f"if e is N then u is {end}\n")
        assert any(advice in words for _, _, words in found), found
        assert advice == "did you mean 'weight'?" or not any("did you mean 'weight'" in words for _, _, words in found)


def test_a_rule_that_reads_an_input_without_terms_is_refused_where_functions_need_none():
    text = (
        "system s\ndefuzzifier weighted_average\ninput a in [0, 1]\n  lo = ramp(1, 0)\ninput x in [0, 1]\n"
        "output y in [0, 9] else 0\n  c = linear(1, 2, 3)\nif a is lo then y is c\nif x is foo then y is c\n"
    )
    with pytest.raises(DiagnosticError) as caught:
        loads(text)
    (error,) = caught.value.diagnostics
    assert (error.code, error.message, error.span.text) == ("FZ203", "input 'x' has no term 'foo'", "foo")
