"""`rules NAME` lines: which rules belong to a block, what it says, and mistakes in it."""

import pytest

from fuzzyctl import DiagnosticError, dumps, loads
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang.formatter import format_source
from fuzzyctl.loading.load import examine
from fuzzyctl.model.method import Activation
from fuzzyctl.model.rule import RuleTable

HEAD = """
system s
input e in [-1, 1]
  terms N P
input d in [-1, 1]
  terms N P
output u in [-1, 1] else 0
  terms N P
output v in [-1, 1] else 0
  terms N P
"""
LOOSE = "table v = d\n  N P\n  | P N\n"
FAST = "rules fast and product or bounded_sum implication product activation highest(count=1)\n"
RULE = "if e is N and d is N then u is N\n"
MIRRORED = "if e is P and d is P then u is P\n"


def found(text):
    return [(d.code, d.severity, d.message) for d in examine(SourceText("t", HEAD + text))[1]]


def test_a_block_holds_what_stands_below_it_up_to_the_next_one():
    system = loads(HEAD + LOOSE + FAST + RULE + MIRRORED + "rules slow\ntable u = d\n  N P\n  | P N\n")
    assert isinstance(system.blocks[0], RuleTable)
    fast, slow = system.rule_blocks
    assert (fast.name, fast.conjunction, fast.disjunction) == ("fast", "product", "bounded_sum")
    assert (fast.implication, fast.activation) == ("product", Activation(kind="highest", count=1))
    assert (slow.name, slow.conjunction, slow.activation) == ("slow", None, None)
    assert [len(b.rules) for b in system.rule_blocks] == [2, 1]
    assert [m.block for m in system.rule_methods] == [-1, -1, 0, 0, 1, 1]
    assert [m.conjunction for m in system.rule_methods] == ["min"] * 2 + ["product"] * 2 + ["min"] * 2


def test_other_statements_may_stand_between_the_rules_of_a_block():
    system = loads(HEAD + LOOSE + FAST + RULE + "param k = 1\nrequire u <= k\nor max\n" + MIRRORED)
    assert len(system.rule_blocks[0].rules) == 2
    assert system.method.disjunction == "max"


def test_a_block_prints_as_it_is_written():
    text = dumps(loads(HEAD + LOOSE + FAST + RULE + MIRRORED))
    assert f"\n\n{FAST}\n{RULE}{MIRRORED}" in text
    assert format_source(SourceText("t", text)) == text


def test_spaces_of_a_block_line_are_laid_out():
    typed = "rules  fast   and product activation  highest( count = 1 )\n" + RULE
    assert format_source(SourceText("t", typed)) == "rules fast and product activation highest(count=1)\n" + RULE


def test_rules_names_things_where_a_name_is_due():
    system = loads(
        "system rules\ninput rules in [0, 1]\n  rules = triangle(0, 0, 1)\n  x = triangle(0, 1, 1)\n"
        "output y in [0, 1]\n  terms rules=0 x=1\ndefuzzifier weighted_average\n"
        "table y = rules\n  rules x\n  | rules x\n"
    )
    assert system.inputs[0].terms[0].name == "rules"
    assert not system.rule_blocks


@pytest.mark.parametrize(
    ("text", "code", "message"),
    [
        ("rules a and produkt\n" + RULE, "FZ213", "'and' knows no 'produkt'"),
        ("rules a implication sum\n" + RULE, "FZ213", "'implication' knows no 'sum'"),
        ("rules a and min and product\n" + RULE, "FZ215", "'and' is given twice"),
        ("rules a activation first(count=1) activation general\n" + RULE, "FZ215", "'activation' is given twice"),
        ("rules a activation first\n" + RULE, "FZ303", "activation 'first' needs a count"),
        ("rules a activation threshold(>= (k))\n" + RULE, "FZ202", "'k'"),
        ("rules a and min(resolution=3)\n" + RULE, "FZ213", "'min' takes no options"),
        ("rules a\n" + RULE + "rules a\n" + MIRRORED, "FZ201", "there is a rule block 'a' already"),
        ("rules weight\n" + RULE, "FZ201", "'weight' is a word of the language and cannot name a rule block"),
        (RULE + "rules a\n", "FZ212", "rule block 'a' has no rules"),
        ("rules\n" + RULE, "FZ102", "the line ends too early"),
        ("rules a aggregation sum\n" + RULE, "FZ102", "expected the end of the line"),
        ("rules a activation highest(count=1)\nif e is N then u is N\nif u is N then v is N\n", "FZ214", "compares"),
    ],
)
def test_a_mistake_is_one_error(text, code, message):
    errors = [(c, m) for c, severity, m in found(LOOSE + MIRRORED + text) if severity == "error"]
    assert [c for c, _ in errors] == [code]
    assert message in errors[0][1] or code == "FZ102"


def test_a_broken_block_line_costs_no_more_than_itself():
    errors = [c for c, severity, _ in found("rules a and\n" + RULE + MIRRORED + LOOSE) if severity == "error"]
    assert errors == ["FZ102"]
    with pytest.raises(DiagnosticError, match="rules NAME and product"):
        loads(HEAD + "rules a and\n" + RULE)


def test_a_block_that_starts_before_several_systems_ends_at_the_first():
    shared = "input e in [-1, 1]\n  terms N P\noutput u in [-1, 1]\n  terms N P\nrules a and product\n"
    text = shared + "if e is N then u is N\nsystem s\nif e is P then u is P\nsystem t\nif e is P then u is P\n"
    system = loads(text, block="s")
    assert [b.name for b in system.rule_blocks] == ["a"]
    assert len(system.rule_blocks[0].rules) == 1
    assert [m.block for m in system.rule_methods] == [-1, 0]


def test_implications_that_nothing_heeds_are_warned_of():
    def idle(text):
        return [m for c, _, m in found(text) if c == "FZ214"]

    every = "rules a implication product\n" + RULE + MIRRORED
    other = "rules b implication min\nif d is N then v is N\nif d is P then v is P\n"
    assert idle(LOOSE + every) == []
    assert idle("implication min\n" + every + other) == ["'implication' has no effect: every output has its own"]
    averaged = HEAD.replace(
        "else 0\n  terms N P\noutput v", "else 0 defuzzifier weighted_average\n  terms N P\noutput v"
    )
    _, diagnostics = examine(SourceText("t", averaged + LOOSE + every))
    assert [d.message for d in diagnostics] == ["'implication' has no effect: 'weighted_average' sums over rules"]
    own = HEAD.replace("output u in [-1, 1] else 0", "output u in [-1, 1] else 0 implication min")
    _, diagnostics = examine(SourceText("t", own + LOOSE + every))
    assert [d.message for d in diagnostics] == [
        "'implication' has no effect: every rule block that sets the output has its own"
    ]
