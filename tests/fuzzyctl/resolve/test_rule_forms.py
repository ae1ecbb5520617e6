"""Short forms of rules stand for rules that can be written at length."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.fz import dumps
from fuzzyctl.lang.formatter import format_source
from fuzzyctl.loading.load import loads
from tests.fuzzyctl.messages import only, said_of

HEAD = """system forms
defuzzifier weighted_average
param k = 0.25
input e in [-1, 1]
  terms N Z P
input de in [-1, 1]
  terms N Z P
output u in [-1, 1] else 0
  terms A=-1 B=1
"""
#: What lines that name `v` need besides.
OTHER = """output v in [-1, 1] else 0
  terms A=-1 B=1
"""


def rules(lines, head=HEAD):
    """The rules of the base system with some lines behind it, which are the same after they have been printed."""
    text = f"{head}{OTHER if 'v is' in lines else ''}{lines}"
    system = loads(text)
    assert loads(dumps(system)) == system
    assert loads(format_source(SourceText("", text))) == system
    return system.rules


def said(lines):
    """What is reported of the base system with some lines behind it, but for terms without use."""
    return [d for d in said_of(f"{HEAD}{OTHER if 'v is' in lines else ''}{lines}") if d[1] not in ("FZ208", "FZ211")]


@pytest.mark.parametrize(
    ("short", "long"),
    [
        ("if e is (N or P) then u is A", "if e is N or e is P then u is A"),
        ("if e is (not N and not P) then u is A", "if e is not N and e is not P then u is A"),
        ("if e is not (N or very P) then u is A", "if not (e is N or e is very P) then u is A"),
        ("if e is not not (N or P) then u is A", "if not not (e is N or e is P) then u is A"),
        ("if de is N and e is (N or P) then u is A", "if de is N and (e is N or e is P) then u is A"),
        ("if e is any then u is A", "if e is any N then u is A"),
        ("if e is not any then u is A", "if e is not any N then u is A"),
        ("if e is (N or any) then u is A", "if e is N or e is any N then u is A"),
        ("if e is N unless de is P then u is A", "if e is N and not de is P then u is A"),
        ("if e is N then u is A unless de is P", "if e is N and not de is P then u is A"),
        ("if e is N or e is P unless de is P then u is A", "if (e is N or e is P) and not de is P then u is A"),
        ("if e is N and de is N unless e is P then u is A", "if e is N and de is N and not e is P then u is A"),
        (
            "if e is N then u is A unless not (de is P or e is P)",
            "if e is N and not not (de is P or e is P) then u is A",
        ),
        (
            "if e is N unless de is P then u is A unless de is Z",
            "if e is N and not de is P and not de is Z then u is A",
        ),
        ("if e is N then u is A unless de is P weight 0.5", "if e is N and not de is P then u is A weight 0.5"),
        ("if e is N then u is 0.5", "if e is N then u is constant(0.5)"),
        ("if e is N then u is -0.5, v is (2 * k)", "if e is N then u is constant(-0.5), v is constant(2 * k)"),
        ("if e is N then (u is A,\n  v is B) weight 0.5", "if e is N then u is A, v is B weight 0.5"),
        ("if e is N then (u is A)", "if e is N then u is A"),
    ],
)
def test_a_short_form_is_the_long_one(short, long):
    assert rules(short) == rules(long)


@pytest.mark.parametrize("name", ["unless", "any", "otherwise"])
def test_the_new_words_are_names_wherever_they_were(name):
    head = HEAD.replace("terms N Z P", f"terms N {name} P", 1)
    assert rules(f"if e is {name} then u is A", head)[0].antecedent.term == name
    assert rules(f"if e is not {name} and de is N then u is A", head)[0].antecedent.operands[0].hedges == ("not",)


def test_a_hedge_may_be_called_unless():
    head = HEAD.replace("param k", "hedge unless(x) = x ^ 3\nparam k")
    assert rules("if e is unless N then u is A", head)[0].antecedent.hedges == ("unless",)


class TestOtherwise:
    def test_it_denies_the_disjunction_of_the_others(self):
        short = "if e is N and de is N then u is A\notherwise u is B weight 0.5\nif e is P then u is A"
        long = (
            "if e is N and de is N then u is A\n"
            "if not ((e is N and de is N) or e is P) then u is B weight 0.5\nif e is P then u is A"
        )
        assert rules(short) == rules(long)

    def test_each_output_has_its_own_others(self):
        short = "if e is N then u is A\nif e is P then v is A\notherwise u is B, v is B"
        long = "if e is N then u is A\nif e is P then v is A\nif not e is N then u is B\nif not e is P then v is B"
        assert rules(short) == rules(long)

    def test_cells_and_conditions_count(self):
        short = "otherwise u is 0\nwith de is N\ntable u = e\n  N Z P\n  | A . B\n"
        table = "with de is N\ntable u = e\n  N Z P\n  | A . B\n"
        long = f"if not ((de is N and e is N) or (de is N and e is P)) then u is 0\n{table}"
        assert rules(short) == rules(long)

    def test_it_belongs_to_its_rule_block(self):
        short = "if e is N then u is A\nrules other\nif e is P then u is A\notherwise u is B"
        long = "if e is N then u is A\nrules other\nif e is P then u is A\nif not e is P then u is B"
        assert rules(short) == rules(long)

    @given(st.floats(-1, 1), st.floats(-1, 1))
    def test_its_strength_is_one_minus_the_largest_of_the_others(self, e, de):
        system = loads(
            HEAD.replace("weighted_average", "weighted_sum") + "if e is N and de is P then u is 0\n"
            "if e is Z then u is 0\notherwise u is 1"
        )
        degree = {"N": max(0, -e), "Z": 1 - abs(e)}
        strongest = max(min(degree["N"], max(0, de)), degree["Z"])
        assert system(e=e, de=de) == pytest.approx(1 - strongest, abs=1e-15)

    def test_many_rules_make_a_tree_that_can_be_read_again(self):
        head = HEAD.replace("terms N Z P", f"terms {' '.join(f't{k}' for k in range(120))}", 1)
        row = f"table u = e\n  {' '.join(f't{k}' for k in range(120))}\n  | {' '.join(['A'] * 120)}\notherwise u is B"
        assert len(rules(row, head)) == 121

    @pytest.mark.parametrize(
        ("lines", "code", "words"),
        [
            ("if e is N then v is A\notherwise u is A", "FZ212", "no other rule sets 'u'"),
            ("if e is N then u is A\notherwise u is A, u is B", "FZ215", "given twice"),
            ("if e is N then u is A\notherwise u is A\notherwise u is B", "FZ215", "'otherwise' of 'u' is given twice"),
            ("if e is N then u is A\notherwise u is C", "FZ203", "no term 'C'"),
            ("if e is N then u is A\notherwise e is N", "FZ214", "a consequent sets an output"),
            ("if e is N then u is A\notherwise u", "FZ102", "otherwise OUTPUT is TERM"),
        ],
    )
    def test_mistakes(self, lines, code, words):
        where, text = only(said(lines))
        assert code in where
        assert words in text


@pytest.mark.parametrize(
    ("line", "code", "words"),
    [
        ("if e is very (N or P) then u is A", "FZ102", "(very N or ...)"),
        ("if e is (N or P and Z) then u is A", "FZ102", "unexpected 'and'"),
        ("if e is (N) then u is A", "FZ102", "a term has no parentheses"),
        ("if e is N then u is (A)", "FZ202", "without parentheses: A"),
        ("if e is (N or Q) then u is A", "FZ203", "no term 'Q'"),
        ("if f is (N or P) then u is A", "FZ202", "no input or output 'f'"),
        ("if e is N then u is (j)", "FZ202", "no param 'j'"),
        ("if e is N then u is (e)", "FZ202", "no param 'e'"),
        ("if e is N, unless de is P, then u is A", "FZ102", "if e is N unless de is P then u is A"),
        ("IF e IS N UNLESS de IS P THEN u IS A", "FZ101", "if e is N unless de is P then u is A"),
    ],
)
def test_mistakes_are_reported_once(line, code, words):
    where, text = only(said(f"{line}\nif de is N then u is A\n"))
    assert code in where
    assert words in text


def test_an_else_without_a_rule_above_is_written_otherwise():
    where, text = only(said("else u is A\nif de is N then u is A\n"))
    assert where.endswith("FZ101")
    assert "write: otherwise u is A" in text


def test_an_otherwise_line_beside_an_incomplete_table_is_no_second_mistake():
    where, text = only(said("table u = e\n    N  Z\n |  A  A\notherwise u is A\n"))
    assert where.endswith("FZ205"), text
