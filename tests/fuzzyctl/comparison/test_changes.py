"""What was changed: terms, rules, cells and settings, whatever the layout."""

import pytest

import fuzzyctl
from fuzzyctl.comparison.changes import changes


@pytest.fixture
def between(base, changed):
    """The changes from the base text to the base text with replacements."""

    def find(*pairs, after=""):
        found = changes(fuzzyctl.loads(base), fuzzyctl.loads(changed(*pairs, after=after)))
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

    def test_the_same_rule_outside_of_the_table_is_the_same_rule(self, between):
        assert between(("  Z |  N  P", "  Z |  N  ."), after="if y is P and x is Z then u is P\n") == []

    def test_a_renamed_term_is_no_other_term_and_its_rules_are_the_same(self, changed, base):
        renamed = changed(
            ("  Z = triangle(-1, 0, 1)", "  ZERO = triangle(-1, 0, 1)"), ("  Z |  N  P", "  ZERO |  N  P")
        )
        found = changes(fuzzyctl.loads(base), fuzzyctl.loads(renamed))
        assert [(c.kind, c.what, c.before, c.after) for c in found] == [("renamed", "term", "Z", "ZERO")]

    def test_a_renamed_variable_is_no_other_variable(self, changed, base):
        renamed = changed(("input y in", "input height in"), ("table u = x x y", "table u = x x height"))
        found = changes(fuzzyctl.loads(base), fuzzyctl.loads(renamed))
        assert [(c.kind, c.what, c.before, c.after) for c in found] == [("renamed", "input", "y", "height")]

    def test_a_moved_corner_is_a_changed_term_with_both_lines(self, base, changed):
        other = changed(("  Z = triangle(-1, 0, 1)", "\n  Z = triangle(-1, 0.25, 1)"))
        (change,) = changes(fuzzyctl.loads(base), fuzzyctl.loads(other))
        assert (change.name, change.before, change.after) == ("Z of x", "triangle(-1, 0, 1)", "triangle(-1, 0.25, 1)")
        assert (change.before_line, change.after_line) == (5, 6)

    def test_an_expression_of_the_same_value_is_rewritten(self, between):
        assert between(("  Z = triangle(-1, 0, 1)", "  Z = triangle(-1, 0, 2 / 2)")) == [
            ("rewritten", "term", "Z of x", "triangle(-1, 0, 1)", "triangle(-1, 0, 2 / 2)")
        ]

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
        assert changes(fuzzyctl.loads(base), fuzzyctl.loads(changed(rows))) == ()
        first = "activation first(count=1)\n"
        found = changes(fuzzyctl.loads(base + first), fuzzyctl.loads(changed(rows, after=first)))
        assert [c.what for c in found] == ["order of rules"]

    def test_what_is_no_system_is_refused(self, base):
        with pytest.raises(fuzzyctl.ArgumentError, match="FuzzySystem"):
            changes(fuzzyctl.loads(base), base)

    def test_names_that_a_format_respells_are_the_same_things(self, base, changed):
        """As a conversion does: another term is moved at the same time, so that shapes alone would not pair them."""
        respelt = changed(
            ("  Z = triangle(-1, 0, 1)", "  z_ = triangle(-1, 0.5, 1)"),
            ("  Z |  N  P", "  z_ |  N  P"),
            ("input y in", "input Y_ in"),
            ("table u = x x y", "table u = x x Y_"),
        )
        found = changes(fuzzyctl.loads(base), fuzzyctl.loads(respelt))
        assert [(c.kind, c.what) for c in found] == [("renamed", "term"), ("changed", "term"), ("renamed", "input")]
