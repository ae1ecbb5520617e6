"""Parts of systems and blocks are one line each, whatever the file."""

import dataclasses

import fuzzyctl
from tests.shipped import SYSTEMS

#: One system with what the shipped files do not have.
ODD = """system odd
semantics matlab(weight=after)
defuzzifier weighted_average
hedge fairly(x) = x ^ 0.7
param low = -1
input x "Way out" in [low, 1] unit "m"
  N = triangle(-inf, low, 0, height=0.5)
let s in [0, 1] = x ^ 2
  big = ramp(0, 1)
output u in [0, 1] else hold(0.5)
  terms a=0 b=1
rules first and product
if x is not fairly N or s is big then u is a weight 0.5
require u <= 1 within 1e-9 when x > 0
"""


def parts(found):
    """Yield all parts inside of a block."""
    for field in dataclasses.fields(found):
        value = getattr(found, field.name)
        for part in value if isinstance(value, tuple) else (value,):
            if dataclasses.is_dataclass(part) and type(part).__module__.startswith("fuzzyctl.model."):
                yield part
                yield from parts(part)


def blocks():
    for path in SYSTEMS:
        yield fuzzyctl.load(path)
    for name in ("water_tank", "pendulum"):
        yield fuzzyctl.load(name, block=fuzzyctl.Loop)


def test_the_words_are_those_of_rule_files():
    system = fuzzyctl.loads(ODD)
    assert [repr(p) for p in (*system.params, *system.hedges, *system.inputs, *system.lets, *system.outputs)] == [
        "Param(low = -1)",
        "Hedge(fairly(x) = x^0.7)",
        "Input(x in [low, 1] m: N)",
        "Let(s in [0, 1] = x^2: big)",
        "Output(u in [0, 1]: a, b)",
    ]
    assert repr(system.inputs[0].terms[0]) == "Term(N = triangle(-inf, low, 0, height=0.5))"
    assert repr(system.rules) == "(Rule(if x is not fairly N or s is big then u is a weight 0.5),)"
    assert repr(system.blocks[0]) == "RuleBlock(first and product; 1 rule)"
    assert repr(system.guarantees[0]) == "Guarantee(u <= 1 within 1e-9 when x > 0)"
    assert repr(system.method) == "Method(semantics matlab(weight=after), defuzzifier weighted_average)"


def test_a_table_says_how_many_rules_it_is():
    table = fuzzyctl.load("ais_reaction").blocks[0]
    assert repr(table) == "RuleTable(f = sigma x dsigma; 25 rules)"


def test_every_part_of_every_shipped_file_is_one_line():
    kinds = set()
    for found in blocks():
        for part in parts(found):
            text = repr(part)
            kinds.add(type(part).__name__)
            assert text.startswith(f"{type(part).__name__}("), text
            assert text.isprintable()
    assert {"Input", "Output", "Term", "Rule", "RuleTable", "Param", "Guarantee", "Method", "State", "Measure"} <= kinds


def test_control_characters_are_visible():
    variable = fuzzyctl.loads(ODD).inputs[0]
    assert repr(dataclasses.replace(variable, name="x\x1b[31m\u202e\n")).isprintable()


def test_bounds_and_algorithms_name_no_locations_and_tables():
    system = fuzzyctl.load("tipper")
    assert repr(fuzzyctl.output_bounds(system)["tip"]) == (
        "OutputBound(name='tip', lo=0.0, hi=30.0, exact=False, lo_at=None, hi_at=None)"
    )
    assert repr(fuzzyctl.compile(system, "python").algorithm).startswith("Algorithm(rules: ")
