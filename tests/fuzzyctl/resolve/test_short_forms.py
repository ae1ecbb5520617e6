"""Short forms stand for text that can be written at length: the systems are equal, printed and formatted as well."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl import build, dumps, load, loads
from fuzzyctl.testing import run_command
from tests.layout import laid_out


def read(text):
    """A system that is the same after it has been printed, and after it has been formatted."""
    system = loads(text)
    assert loads(dumps(system)) == system == loads(laid_out(text))
    return system


class TestFormulas:
    TEXT = """system forms
defuzzifier weighted_average
param h = 0.25
input e in [-1, 1]
  terms N Z P
input de in [-1, 1]
  A = ramp(-1, 1)
output u in [-1, 1] else 0
  terms low=-0.5 high=0.5
if e is N then u is low
if e is P and de is A then u is high
"""

    def read(self, old, new):
        assert old in self.TEXT
        return read(self.TEXT.replace(old, new))

    @pytest.mark.parametrize(
        ("old", "short", "long"),
        [
            ("ramp(-1, 1)", "function(de > 0)", "function(gt(de, 0))"),
            ("ramp(-1, 1)", "function((de <= 0) * 0.5)", "function(le(de, 0) * 0.5)"),
            ("ramp(-1, 1)", "function(-0.5 <= de and de < 0.5)", "function(min(le(-0.5, de), lt(de, 0.5)))"),
            ("ramp(-1, 1)", "function(not (de == 0 or de != h))", "function(1 - max(eq(de, 0), ne(de, h)))"),
            ("ramp(-1, 1)", "function(abs((de >= 0) - 1))", "function(abs(ge(de, 0) - 1))"),
            ("u is high", "u is function((e > 0) * de)", "u is function(gt(e, 0) * de)"),
            ("u is high", "u is linear(0.5, e=2, de=-h)", "u is linear(2, -h, 0.5)"),
            ("u is high", "u is linear(de=1)", "u is linear(0, 1, 0)"),
            ("u is high", "u is linear(e=1, 0.5)", "u is linear(1, 0, 0.5)"),
            ("terms low=-0.5 high=0.5", "terms low=-2*h high=h/2*3", "terms low=(-2*h) high=(h/2*3)"),
            ("terms low=-0.5 high=0.5", "terms low=-(h + 1)*2 high=(h)", "terms low=(-(h + 1)*2) high=(h)"),
            ("terms N Z P", "terms N@-h Z@h*h P@2*h", "terms N@(-h) Z@(h*h) P@(2*h)"),
        ],
    )
    def test_are_their_long_forms(self, old, short, long):
        assert self.read(old, short) == self.read(old, long)

    def test_a_hedge_may_hold_a_condition(self):
        short, long = (
            self.read("param h = 0.25", f"hedge sharp(x) = {c}\nparam h = 0.25") for c in ("x > 0.5", "gt(x, 0.5)")
        )
        assert short.hedges == long.hedges

    def test_terms_may_be_called_like_units(self):
        terms = self.read("terms low=-0.5 high=0.5", "terms low=-1 s=2 high=3 ms=4 h=5").output("u").terms
        assert [t.name for t in terms] == ["low", "s", "high", "ms", "h"]

    def test_items_are_formatted_without_blanks(self):
        text = self.TEXT.replace("low=-0.5 high=0.5", "low = - 2 * h   high=( h + 1 )* h / 2")
        assert "  terms low=-2*h high=(h + 1)*h/2\n" in laid_out(text)

    @pytest.mark.parametrize(
        ("function", "short", "long"),
        [
            ("", "let z = e > 0\noutput w in [0, 1] = z * de", "let z = gt(e, 0)\noutput w in [0, 1] = z * de"),
            ("", "output w in [0, 1] = e > 0 and de > h", "output w in [0, 1] = min(gt(e, 0), gt(de, h))"),
            ("function on(x) = x > h\n", "output w in [0, 1] = on(e) * de", "output w in [0, 1] = gt(e, h) * de"),
        ],
    )
    def test_lets_outputs_and_functions_take_conditions(self, function, short, long):
        first, second = (self.TEXT.replace("input e", f"{lines}\ninput e") for lines in (short, long))
        assert loads(function + first) == loads(second)


RULES = """system forms
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
OTHER = "output v in [-1, 1] else 0\n  terms A=-1 B=1\n"


def rules(lines, head=RULES):
    return read(f"{head}{OTHER if 'v is' in lines else ''}{lines}").rules


class TestRules:
    @pytest.mark.parametrize(
        ("short", "long"),
        [
            ("if e is (N or P) then u is A", "if e is N or e is P then u is A"),
            ("if e is (not N and not P) then u is A", "if e is not N and e is not P then u is A"),
            ("if e is not (N or very P) then u is A", "if not (e is N or e is very P) then u is A"),
            ("if e is not not (N or P) then u is A", "if not not (e is N or e is P) then u is A"),
            ("if de is N and e is (N or P) then u is A", "if de is N and (e is N or e is P) then u is A"),
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
        ],
    )
    def test_are_their_long_forms(self, short, long):
        assert rules(short) == rules(long)

    @pytest.mark.parametrize("name", ["unless", "any", "otherwise"])
    def test_words_of_short_forms_are_names_of_terms_too(self, name):
        head = RULES.replace("terms N Z P", f"terms N {name} P", 1)
        assert rules(f"if e is {name} then u is A", head)[0].antecedent.term == name
        assert rules(f"if e is not {name} and de is N then u is A", head)[0].antecedent.operands[0].hedges == ("not",)

    @pytest.mark.parametrize(
        ("short", "long"),
        [
            (
                "if e is N and de is N then u is A\notherwise u is B weight 0.5\nif e is P then u is A",
                "if e is N and de is N then u is A\n"
                "if not ((e is N and de is N) or e is P) then u is B weight 0.5\nif e is P then u is A",
            ),
            (
                "if e is N then u is A\nif e is P then v is A\notherwise u is B, v is B",
                "if e is N then u is A\nif e is P then v is A\nif not e is N then u is B\nif not e is P then v is B",
            ),
            (
                "otherwise u is 0\nwith de is N\ntable u = e\n  N Z P\n  | A . B\n",
                "if not ((de is N and e is N) or (de is N and e is P)) then u is 0\n"
                "with de is N\ntable u = e\n  N Z P\n  | A . B\n",
            ),
            (
                "if e is N then u is A\nrules other\nif e is P then u is A\notherwise u is B",
                "if e is N then u is A\nrules other\nif e is P then u is A\nif not e is P then u is B",
            ),
        ],
        ids=["all others", "others of each output", "cells", "others of its block"],
    )
    def test_otherwise_denies_the_other_rules(self, short, long):
        assert rules(short) == rules(long)

    @given(st.floats(-1, 1), st.floats(-1, 1))
    def test_the_strength_of_otherwise_is_one_minus_the_largest_of_the_others(self, e, de):
        system = loads(
            RULES.replace("weighted_average", "weighted_sum") + "if e is N and de is P then u is 0\n"
            "if e is Z then u is 0\notherwise u is 1"
        )
        strongest = max(min(max(0, -e), max(0, de)), 1 - abs(e))
        assert system(e=e, de=de) == pytest.approx(1 - strongest, abs=1e-15)

    def test_otherwise_of_many_rules_is_a_tree_that_can_be_read_again(self):
        names = " ".join(f"t{k}" for k in range(120))
        table = f"table u = e\n  {names}\n  | {' '.join(['A'] * 120)}\notherwise u is B"
        assert len(rules(table, RULES.replace("terms N Z P", f"terms {names}", 1))) == 121


class TestVariables:
    START = "system s\nand product\ndefuzzifier center_average\n"
    SHARED = 'input e "error", de in [-1, 1] unit "V"\n  terms N@-0.5 Z P@0.5\n'
    SHARED += "output u, v in [-2, 2] else 0\n  terms A B\n"
    APART = 'input e "error" in [-1, 1] unit "V"\n  terms N@-0.5 Z P@0.5\n'
    APART += 'input de in [-1, 1] unit "V"\n  terms N@-0.5 Z P@0.5\n'
    APART += "output u in [-2, 2] else 0\n  terms A B\noutput v in [-2, 2] else 0\n  terms A B\n"

    def read(self, lines):
        rules = "if e is N and de is P then u is A, v is B\nif e is Z then u is B\nif de is N then v is A\n"
        return read(self.START + lines.replace("Z P@", "Z@0 P@") + rules)

    @pytest.mark.parametrize(
        ("own", "taken"),
        [
            ('input de in [-1, 1] unit "V"\n  terms N@-0.5 Z P@0.5\n', 'input de in [-1, 1] unit "V" terms of e\n'),
            ("output v in [-2, 2] else 0\n  terms A B\n", "output v in [-2, 2] terms of u else 0\n"),
        ],
    )
    def test_of_a_line_and_terms_of_another_are_written_out(self, own, taken):
        assert own in self.APART
        assert self.read(self.APART.replace(own, taken)) == self.read(self.APART) == self.read(self.SHARED)

    def test_the_other_variable_may_be_declared_below(self):
        above = 'input de in [-1, 1] unit "V" terms of e\n'
        system = self.read(above + self.SHARED.replace(", de", ""))
        assert system.input("de").terms == system.input("e").terms

    def test_names_alone_follow_the_range(self):
        lines = "input e in [-1, 1]\n  terms N Z P\ninput de in [0, 10] terms of e\n"
        lines += "output u, v in [-1, 1] else 0\n  terms A B\n"
        assert self.read(lines) == self.read(lines.replace(" terms of e", "\n  terms N Z P"))

    def test_terms_are_called_of_where_they_are_listed(self):
        lines = self.SHARED.replace("terms A B", "terms of A B")
        assert [t.name for t in self.read(lines).output("u").terms] == ["of", "A", "B"]


HEAD = """system forms
semantics exact(consequent_hedges=activation)
defuzzifier weighted_average
param g = 0.5
input e, de in [-1, 1]
  terms N Z P
output u in [-1, 1] else 0
  terms low@-1 mid@0 high@1
"""
NAMES = "table u = e x de\n  N Z P\n  N | low mid mid\n  Z | low mid high\n  P | mid mid high\n"
VALUES = "table u = e x de\n  N Z P\n  N | -1 0 (g)\n  Z | (-g) 0.5*.2 1\n  P | 0 0.25 1\n"
CASCADE = "output v in [-1, 1] else 0\n  terms low high\n"


class TestTables:
    @pytest.mark.parametrize(
        ("header", "labels"), [("-1 0 +1", "0 1 2"), ("0. 1 2", "7 8 9"), ("N Z P", "-1 0 1"), ("1 0 -1", "-1 0 1")]
    )
    def test_numbers_count_the_terms_and_may_fall(self, header, labels):
        table = NAMES.replace("N Z P\n", f"{header}\n", 1)
        for name, label in zip("NZP", labels.split(), strict=True):
            table = table.replace(f"  {name} |", f"  {label} |")
        columns = "P Z N" if header == "1 0 -1" else "N Z P"
        assert read(HEAD + table) == read(HEAD + NAMES.replace("N Z P", columns, 1))

    @pytest.mark.parametrize(
        ("csv", "lines", "table"),
        [
            (",-1,0,1\n-1,low,mid,mid\n0,low,mid,high\n1,mid,mid,high\n", 'table u = e x de from "u.csv"\n', NAMES),
            (
                ",N,Z,P\n,1,2,3\n",
                'table u = e scale 0.1 from "u.csv"\nif de is N then u is 0\n',
                "table u = e\n  N Z P\n | (0.1*1) (0.1*2) (0.1*3)\nif de is N then u is 0\n",
            ),
        ],
    )
    def test_of_a_csv_file_are_those_of_the_text(self, csv, lines, table, tmp_path):
        (tmp_path / "u.csv").write_text(csv)
        (tmp_path / "s.fz").write_text(HEAD + lines)
        assert load(tmp_path / "s.fz") == read(HEAD + table)

    def test_a_factor_multiplies_the_numbers_of_all_cells(self):
        long = "table u = e x de\n  N Z P\n  N | (2*g*-1) (2*g*0) (2*g*g)\n  Z | (2*g*-g) (2*g*0.5)*.2 (2*g*1)\n"
        long += "  P | (2*g*0) (2*g*0.25) (2*g*1)\n"
        short = read(HEAD + VALUES.replace("x de", "x de scale 2*g"))
        assert short == read(HEAD + long)
        assert short(e=-1, de=-1) == -1.0
        assert short.with_params(g=2)(e=-1, de=-1) == -4.0

    def test_hedged_cells_are_rules_with_hedged_consequents(self, tmp_path):
        table = "table u = e\n  N Z P\n  | [not low] mid [very not high]*0.5\n"
        rules = "if e is N then u is not low\nif e is Z then u is mid\nif e is P then u is very not high weight 0.5\n"
        system = read(HEAD + table)
        assert system.rules == read(HEAD + rules).rules
        assert "[not low]" in dumps(system)
        (tmp_path / "s.fz").write_text(HEAD + table)
        assert run_command("convert", "s.fz", "s.md", folder=tmp_path).exit_code == 0
        assert "very not high" in (tmp_path / "s.md").read_text()
        cells = {"N": "[not low]", "Z": "mid", "P": "[very not high]*0.5"}
        assert build.rule_table("u", "e", cells).cells == system.blocks[0].cells
        both = "table u, v = e\n  N Z P\n  | [not low]/high mid/low high/[very low]\n"
        hedges = [tuple(c.hedges for c in r.consequents) for r in read(HEAD + CASCADE + both).rules]
        assert hedges == [(("not",), ()), ((), ()), ((), ("very",))]

    def test_rows_may_be_those_of_an_output(self):
        lines = f"{HEAD}{CASCADE}table v = e\n  N Z P\n  | high low high\n"
        table = "table u = v x e\n        N    Z    P\n  low | mid low high\n  high | low mid mid\n"
        rules = "".join(
            f"if v is {row} and e is {column} then u is {cell}\n"
            for row, cells in (("low", "mid low high"), ("high", "low mid mid"))
            for column, cell in zip("NZP", cells.split(), strict=True)
        )
        assert read(lines + table).rules == read(lines + rules).rules
        assert read(lines + table)(e=0.3, de=0) == read(lines + rules)(e=0.3, de=0)

    def test_conditions_in_cells_are_formatted_with_blanks_between_words(self):
        read(HEAD + VALUES.replace("0.25", "function(e > 0 and not de > 0)"))
