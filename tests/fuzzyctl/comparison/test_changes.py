"""What was changed: terms, rules, cells and settings, whatever the layout."""

import pytest

import fuzzyctl
from fuzzyctl.testing import run_command
from tests.fuzzyctl.comparison.command import changes


def converted(text, folder, suffix):
    """Return the path of a system in another format."""
    (folder / "a.fz").write_text(text, encoding="utf-8")
    path = folder / f"a.{suffix}"
    assert run_command("convert", folder / "a.fz", path, "--lossy").exit_code == 0
    return path


@pytest.fixture
def between(base, changed):
    """The changes from the base text to the base text with replacements."""

    def find(*pairs, after=""):
        found = changes(base, changed(*pairs, after=after))
        return [(c.kind, c.what, c.name, c.before, c.after) for c in found]

    return find


class TestChanges:
    def test_layout_comments_and_spelling_of_numbers_are_none(self, between):
        assert between(("  N |  N  Z", "N|N Z # a comment"), ("-1, 1]\n", "-1.0, 1e0]\n")) == []

    def test_a_changed_cell_is_named_by_its_antecedent(self, between):
        assert between(("  Z |  N  P", "  Z |  Z  P")) == [("changed", "cell", "x is Z and y is N then u", "N", "Z")]

    def test_a_weight_belongs_to_the_cell(self, between):
        assert between(("  Z |  N  P", "  Z |  N  P*0.5")) == [
            ("changed", "cell", "x is Z and y is P then u", "P", "P weight 0.5")
        ]

    def test_a_dropped_cell_and_an_added_rule_are_shown_as_rules(self, between):
        found = between(
            ("  Z |  N  P", "  Z |  N  ."), ("u in [-2, 2]", "u in [-2, 2] else 0"), after="if y is N then u is Z\n"
        )
        assert ("removed", "cell", "x is Z and y is P", "if x is Z and y is P then u is P", None) in found
        assert ("added", "rule", "y is N", None, "if y is N then u is Z") in found
        assert ("added", "else", "u", None, "0") in found
        assert len(found) == 3

    def test_a_variable_that_one_of_them_lacks_is_shown_with_its_terms(self, base, changed):
        table = base[base.index("table u") :]
        without = changed(
            ('input y in [0, 10] unit "m"\n  terms N@0 P@10\n', ""), (table, "table u = x\n   N Z P\n | N Z P\n")
        )
        first, second = base, without
        (gone,) = [c for c in changes(first, second) if c.what == "input"]
        assert (gone.kind, gone.name, gone.before, gone.after) == ("removed", "y", "in [0, 10] with terms N, P", None)
        (new,) = [c for c in changes(second, first) if c.what == "input"]
        assert (new.kind, new.name, new.before, new.after) == ("added", "y", None, "in [0, 10] with terms N, P")

    def test_a_consequent_without_a_name_is_shown_as_it_is_written(self, base):
        text = (
            base.replace("input x", "defuzzifier weighted_average\ninput x", 1)
            + "if x is N then u is linear(1, 2, {})\n"
        )
        found = changes(*(text.format(end) for end in (3, 4)))
        assert [(c.what, c.name, c.before, c.after) for c in found] == [
            ("rule", "x is N then u", "linear(1, 2, 3)", "linear(1, 2, 4)")
        ]

    def test_the_same_rule_outside_of_the_table_is_the_same_rule(self, between):
        assert between(("  Z |  N  P", "  Z |  N  ."), after="if y is P and x is Z then u is P\n") == []

    def test_a_renamed_term_is_no_other_term_and_its_rules_are_the_same(self, changed, base):
        renamed = changed(
            ("  Z = triangle(-1, 0, 1)", "  ZERO = triangle(-1, 0, 1)"), ("  Z |  N  P", "  ZERO |  N  P")
        )
        found = changes(base, renamed)
        assert [(c.kind, c.what, c.before, c.after) for c in found] == [("renamed", "term", "Z", "ZERO")]

    def test_a_renamed_variable_is_no_other_variable(self, changed, base):
        renamed = changed(("input y in", "input height in"), ("table u = x x y", "table u = x x height"))
        found = changes(base, renamed)
        assert [(c.kind, c.what, c.before, c.after) for c in found] == [("renamed", "input", "y", "height")]

    def test_a_moved_corner_is_a_changed_term_with_both_lines(self, base, changed):
        other = changed(("  Z = triangle(-1, 0, 1)", "\n  Z = triangle(-1, 0.25, 1)"))
        (change,) = changes(base, other)
        assert (change.name, change.before, change.after) == ("Z of x", "triangle(-1, 0, 1)", "triangle(-1, 0.25, 1)")
        assert (change.before_line, change.after_line) == (5, 6)

    def test_an_expression_of_the_same_value_is_rewritten(self, between):
        assert between(("  Z = triangle(-1, 0, 1)", "  Z = triangle(-1, 0, 2 / 2)")) == [
            ("rewritten", "term", "Z of x", "triangle(-1, 0, 1)", "triangle(-1, 0, 2 / 2)")
        ]

    @pytest.mark.parametrize("suffix", ["fll", "fis", "fcl", "fml"])
    def test_another_format_spells_numbers_in_another_way(self, tmp_path, suffix):
        """A minus is a sign in some formats and an operator in others, and so it is before inf."""
        text = "system s\ninput x in [-0.50, 1]\n  N = triangle(-inf, -0.50, 1e0)\n  P = trapezoid(-0.250, 0, 1, inf)\n"
        text += "output u in [-1.0, 1]\n  A = triangle(-1.0, -0.50, 0)\nif x is N then u is A\nif x is P then u is A\n"
        path = converted(text, tmp_path, suffix)
        found = changes(text, path)
        assert [c for c in found if c.kind == "rewritten"] == []
        assert [c for c in found if c.what == "range"] == []
        # Other formats write other shapes.
        assert suffix != "fll" or [c for c in found if c.what == "term"] == []

    def test_settings_hedges_and_knobs_have_the_lines_of_their_statements(self, base):
        first = "and product\nhedge twice(x) = x / 2\n"
        second = "semantics exact(least=0.1)\nhedge twice(x) = x ^ 2\nactivation threshold(>=0.1)\ndefuzzifier som\n"
        lines = len(base.splitlines())
        found = changes(base + first, base + second)
        places = {c.name: [line and line - lines for line in (c.before_line, c.after_line)] for c in found}
        assert places == {
            "and": [1, None],
            "least": [None, 1],
            "twice": [2, 2],
            "activation": [None, 3],
            "defuzzifier": [None, 4],
        }

    @pytest.mark.parametrize(
        ("statement", "name", "before", "after"),
        [
            ("and product", "and", "min", "product"),
            ("aggregation sum", "aggregation", "max", "sum"),
            ("activation highest(count=1)", "activation", "general", "highest(count=1)"),
            ("defuzzifier center_average", "defuzzifier", "centroid", "center_average"),
        ],
    )
    def test_settings_are_compared_in_effect(self, between, statement, name, before, after):
        assert ("changed", "setting", name, before, after) in between(after=statement + "\n")
        assert len(between(after=statement + "\n")) == 1

    def test_guarantees_and_params_are_compared(self, between):
        found = between(after="param k = 2\nrequire u <= k\n")
        assert found == [("added", "param", "k", None, "2"), ("added", "guarantee", "", None, "u <= k")]

    def test_the_order_of_rules_counts_where_it_has_a_meaning(self, base, changed):
        rows = ("  N |  N  Z\n  Z |  N  P", "  Z |  N  P\n  N |  N  Z")
        assert changes(base, changed(rows)) == []
        first = "activation first(count=1)\n"
        found = changes(base + first, changed(rows, after=first))
        assert [c.what for c in found] == ["order of rules"]

    def test_names_that_a_format_respells_are_the_same_things(self, base, changed):
        """As a conversion does: another term is moved at the same time, so that shapes alone would not pair them."""
        respelt = changed(
            ("  Z = triangle(-1, 0, 1)", "  z_ = triangle(-1, 0.5, 1)"),
            ("  Z |  N  P", "  z_ |  N  P"),
            ("input y in", "input Y_ in"),
            ("table u = x x y", "table u = x x Y_"),
        )
        found = changes(base, respelt)
        assert [(c.kind, c.what) for c in found] == [("renamed", "term"), ("changed", "term"), ("renamed", "input")]


TWO_TABLES = """\
system two
input a in [0, 1]
  terms n p
input b in [0, 1]
  terms n p
output y in [0, 1] else 0
  terms s l
output w in [0, 1] else 0
  terms s l
"""
TABLE = "table {} = a x b\n       n  p\n  n |  {}  l\n  p |  l  s\n"
JOINED = "table y, w = a x b\n       n    p\n  n | s/s  l/l\n  p | l/l  s/s\n"


class TestRulesOfOneAntecedent:
    """Two tables over the same inputs have rules of the same antecedents; each is paired by what it says."""

    @staticmethod
    def between(first, second, settings=""):
        found = changes(*(TWO_TABLES + settings + text for text in (first, second)))
        return [(c.kind, c.what, c.name, c.before, c.after) for c in found]

    def test_a_cell_that_is_gone_is_one_change(self):
        first, second = (TABLE.format("y", "s") + TABLE.format("w", cell) for cell in ("s", "."))
        rule = "if a is n and b is n then w is s"
        assert self.between(first, second) == [("removed", "cell", "a is n and b is n", rule, None)]
        first, second = (TABLE.format("y", cell) + TABLE.format("w", "s") for cell in ("s", "."))
        assert self.between(first, second) == [("removed", "cell", "a is n and b is n", rule.replace("w", "y"), None)]

    def test_tables_in_another_order_or_joined_say_the_same(self):
        y, w = TABLE.format("y", "s"), TABLE.format("w", "s")
        assert self.between(y + w, w + y) == []
        assert self.between(y + w, JOINED) == []
        assert self.between(JOINED, w + y) == []

    def test_a_cell_that_changed_on_the_way_is_one_change(self):
        y, w = TABLE.format("y", "s"), TABLE.format("w", "l")
        cell = "a is n and b is n then w"
        assert self.between(w + y, JOINED) == [("changed", "cell", cell, "l", "s")]
        assert self.between(JOINED, y + w) == [("changed", "cell", cell, "s", "l")]

    def test_what_a_joined_table_no_longer_says_is_said_of_its_output(self):
        y, w = TABLE.format("y", "s"), TABLE.format("w", ".")
        assert self.between(JOINED, y + w) == [("removed", "cell", "a is n and b is n then w", "s", None)]
        assert self.between(y + w, JOINED) == [("added", "cell", "a is n and b is n then w", None, "s")]

    def test_the_line_is_that_of_the_file_that_has_it(self):
        a = TWO_TABLES + JOINED
        b = TWO_TABLES + TABLE.format("y", "s") + TABLE.format("w", ".")
        (change,) = changes(a, b)
        assert (change.before_line, change.after_line) == (12, None)

    def test_the_same_rule_twice_is_not_the_rule_once(self):
        rule, other = "if a is n then y is s\n", "if a is p then w is s\n"
        assert self.between(rule + rule + other, rule + other) == [("removed", "rule", "a is n", rule.strip(), None)]

    def test_where_rules_are_compared_with_each_other_two_rules_are_not_one(self):
        y, w = TABLE.format("y", "s"), TABLE.format("w", "s")
        first = "activation first(count=1)\n"
        assert [c[1] for c in self.between(y + w, w + y, first)] == ["order of rules"]
        found = self.between(y + w, JOINED, first)
        assert ("removed", "cell", "a is n and b is n", "if a is n and b is n then w is s", None) in found
        assert ("added", "cell", "a is n and b is n then w", None, "s") in found
        assert len(found) == 8
        assert self.between(y + w, w + y, "activation proportional\n") == []

    def test_the_order_of_adaptive_consequents_counts(self):
        head, _ = TWO_TABLES.split("output y")
        text = f"defuzzifier center_average\n{head}output y in [0, 1] adaptive rate 0.1 else 0\n  terms s@0 l@1\n"
        rules = [f"if a is {t} then y is s\n" for t in ("n", "p")]
        a, b = (text + "".join(order) for order in (rules, reversed(rules)))
        assert [c.what for c in changes(a, b)] == ["order of rules"]


CHAINED = """\
system chained
semantics fuzzylite
input x in [0, 10]
  lo = ramp(10, 0)
  hi = ramp(0, 10)
output y in [0, 10] else nan
  s = triangle(0, 2, 4)
  l = triangle(5, 7, 9)
output z in [0, 10] else nan
  s = triangle(0, 2, 4)
  l = triangle(5, 7, 9)
"""


class TestOrder:
    """Under fuzzylite's numerics the place of a rule, and of a consequent in it, may count."""

    LOW, HIGH = "if x is lo then y is very s, z is s\n", "if x is hi then y is l\n"
    READS, OTHER = "if y is l then z is l\n", "if x is very hi then z is s\n"

    def between(self, first, second):
        a, b = (CHAINED + "".join(rules) for rules in (first, second))
        values = [(s(x=4.0), s(x=7.0)) for s in map(fuzzyctl.loads, (a, b))]
        found = [(c.what, c.before, c.after) for c in changes(a, b)]
        same = all(p == pytest.approx(q, rel=1e-12) for p, q in zip(*values, strict=True))
        assert same == (not found), "what is called a change changes numbers, and nothing else does"
        return found

    def test_rules_before_one_that_reads_what_they_set_count(self):
        found = self.between([self.LOW, self.HIGH, self.READS], [self.LOW, self.READS, self.HIGH])
        assert [what for what, _, _ in found] == ["order of rules"]

    def test_rules_on_the_same_side_of_it_do_not(self):
        assert self.between([self.LOW, self.HIGH, self.READS], [self.HIGH, self.LOW, self.READS]) == []
        assert self.between([self.HIGH, self.READS, self.OTHER], [self.OTHER, self.HIGH, self.READS]) == []

    def test_a_hedge_that_later_consequents_feel_is_said_of_them(self):
        beside = "if x is hi then z is l, y is l\n"
        turned = "if x is lo then z is s, y is very s\n"
        assert self.between([self.LOW, beside], [turned, beside]) == [("rule", "s after very", "s")]
        halves = "if x is lo then y is very s\nif x is lo then z is s\n"
        assert self.between([self.LOW, beside], [halves, beside]) == [("rule", "s after very", "s")]

    def test_blocks_in_another_order_are_the_same_blocks(self):
        one = "rules one activation first(count=1)\nif x is lo then y is s\nif x is hi then y is l\n"
        two = "rules two\nif x is hi then z is l\n"
        assert self.between([one, two], [two, one]) == []
        head, *rules = one.splitlines(keepends=True)
        turned = "".join([head, *reversed(rules)])
        assert [what for what, _, _ in self.between([one, two], [turned, two])] == ["order of rules"]


class TestRenamedBlocks:
    ONE = "rules one activation first(count=1)\nif x is lo then y is s\nif x is hi then y is l\n"
    TWO = "rules two\nif x is hi then z is l\n"

    def between(self, *second):
        a, b = (CHAINED + "".join(rules) for rules in ((self.ONE, self.TWO), second))
        return [(c.kind, c.what, c.name) for c in changes(a, b)]

    def test_their_rules_are_the_same(self):
        other = self.ONE.replace("one", "other")
        assert self.between(other, self.TWO) == [("renamed", "rule block", "one")]
        assert self.between(self.TWO.replace("two", "other"), self.ONE) == [("renamed", "rule block", "two")]

    def test_what_else_they_say_is_a_change_besides(self):
        other = self.ONE.replace("one activation first(count=1)", "other")
        assert self.between(other, self.TWO)[:2] == [("renamed", "rule block", "one"), ("changed", "rule block", "one")]

    def test_a_block_of_other_rules_is_another(self):
        other = "rules other activation first(count=1)\nif x is hi then y is s\nif x is lo then y is l\n"
        found = self.between(other, self.TWO)
        assert [kind for kind, what, _ in found if what == "rule block"] == ["removed", "added"]


def test_blocks_of_other_tools_files_have_lines(tmp_path):
    text = CHAINED + TestRenamedBlocks.ONE + TestRenamedBlocks.TWO
    for target, word in (("fll", "RuleBlock"), ("fcl", "RULEBLOCK"), ("fml", "<mamdaniRuleBase")):
        path = converted(text, tmp_path, target)
        system = fuzzyctl.load(path)
        lines = [
            n
            for n, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
            if line.strip().startswith(word)
        ]
        assert [b.span.line for b in system.rule_blocks] == lines[-len(system.rule_blocks) :]


def test_rules_of_fml_that_join_by_other_norms_begin_where_they_stand(tmp_path):
    text = """<fuzzySystem name="s" xmlns="http://www.ieee1855.org">
  <knowledgeBase>
    <fuzzyVariable name="x" domainleft="0" domainright="10" type="input">
      <fuzzyTerm name="lo"><leftLinearShape param1="0" param2="10"/></fuzzyTerm>
      <fuzzyTerm name="hi"><rightLinearShape param1="0" param2="10"/></fuzzyTerm>
    </fuzzyVariable>
    <fuzzyVariable name="y" domainleft="0" domainright="10" type="output">
      <fuzzyTerm name="s"><triangularShape param1="0" param2="2" param3="4"/></fuzzyTerm>
    </fuzzyVariable>
  </knowledgeBase>
  <mamdaniRuleBase name="one" andMethod="MIN">
    <rule name="a" connector="and"><antecedent>
      <clause><variable>x</variable><term>lo</term></clause><clause><variable>x</variable><term>hi</term></clause>
    </antecedent><consequent><then><clause><variable>y</variable><term>s</term></clause></then></consequent></rule>
    <rule name="b" connector="and" andMethod="PROD"><antecedent>
      <clause><variable>x</variable><term>lo</term></clause><clause><variable>x</variable><term>hi</term></clause>
    </antecedent><consequent><then><clause><variable>y</variable><term>s</term></clause></then></consequent></rule>
  </mamdaniRuleBase>
</fuzzySystem>
"""
    (tmp_path / "a.fml").write_text(text, encoding="utf-8")
    system = fuzzyctl.load(tmp_path / "a.fml")
    assert [(b.conjunction, b.span.line) for b in system.rule_blocks] == [(None, 11), ("product", 15)]
