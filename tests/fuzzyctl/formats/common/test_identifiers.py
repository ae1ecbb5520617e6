"""Names of any kind become identifiers, and stay apart."""

import re

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import fuzzyctl
from fuzzyctl.convert.convert import written
from tests.fuzzyctl.formats.files import read, write

LINE = "system s\ndefuzzifier weighted_average\ninput x in [0, 1]\n  A = ramp(0, 1)\noutput y in [0, 1] else 0\n"
LINE += "  b = constant(1)\nif x is A then y is b\n"


def named(names):
    """Return a system whose input is called `x y` and has a term A, and others of some names."""
    system = fuzzyctl.loads(LINE)
    (x,), rule = system.inputs, system.blocks[0]
    terms = tuple(x.terms[0].model_copy(update={"name": n}) for n in ["A", *(n for n in names if n != "A")])
    antecedent = rule.antecedent.model_copy(update={"variable": "x y"})
    changes = {
        "inputs": (x.model_copy(update={"terms": terms, "name": "x y"}),),
        "blocks": (rule.model_copy(update={"antecedent": antecedent}),),
    }
    return system.model_copy(update=changes)


def as_file(system):
    """Return a system as its rule file holds it."""
    text, losses = written(system, "fz")
    assert all(loss.exact for loss in losses)
    return fuzzyctl.loads(text)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        *(("tip", "tip"), ("very good", "very_good"), ("1st", "_1st"), ("σ*", "σ"), ("%", "unnamed"), ("not", "not_")),
        ("out1mf-2", "out1mf_2"),
    ],
)
def test_a_name_stays_as_near_as_it_can(name, expected):
    assert as_file(named([name])).inputs[0].terms[1].name == expected


@settings(deadline=None)
@given(st.lists(st.text(max_size=12), unique=True, max_size=6))
@example(["param", "if", "table"])
def test_names_of_terms_stay_apart_and_the_file_reads_back(names):
    system = named(names)
    back = as_file(system)
    found = [t.name for t in back.inputs[0].terms]
    assert len(set(found)) == len(found) == len(system.inputs[0].terms)
    assert back.inputs[0].label == "x y"


def test_tables_name_what_is_called_otherwise(changed):
    text = changed(("u in [-2, 2]", "u in [-2, 2] else 0"), ("N |  N  Z", "N |  N  ."))
    text = re.sub(r"\bx\b", "IS", re.sub(r"\bN\b", "THEN", text)).replace("= IS IS y", "= IS x y")
    system = fuzzyctl.loads(text)
    assert system.tables_and_rules[0].rows == "IS"
    back = read("fcl", write("fcl", system)[0])
    assert [v.name for v in back.inputs] == ["IS_", "y"]
    assert back.inputs[0].terms[0].name == "THEN_"
    points = [[-0.9, 2.0], [0.3, 8.0]]
    values = pytest.approx(fuzzyctl.compile(system, "python").batch(points), rel=1e-9)
    assert fuzzyctl.compile(back, "python").batch(points) == values


@pytest.mark.parametrize(
    ("name", "title", "expected"),
    [("cart & pole", "", "cart & pole"), ("cart & pole", "A cart", "A cart"), ("cart", "", "")],
)
def test_a_system_that_is_called_otherwise_keeps_its_name_as_its_title(name, title, expected):
    found = as_file(fuzzyctl.loads(LINE).model_copy(update={"name": name, "title": title}))
    assert (found.name, found.title) == (name.replace(" & ", "_"), expected)


FIS = "[System]\nName='NAME'\nType='mamdani'\n[Input1]\nName='NAME'\nRange=[0 1]\nMF1='NAME':'trimf',[-1 0 2]\n"
FIS += "[Output1]\nName='oNAME'\nRange=[0 1]\nMF1='NAME':'trimf',[0 1 2]\n[Rules]\n1, 1 (1) : 1\n"


@pytest.mark.parametrize("length", [199, 200, 201, 1000])
def test_a_long_name_is_written_only_where_it_is_read_back(length):
    system = read("fis", FIS.replace("NAME", "n" * (length - 1)))
    assert fuzzyctl.loads(fuzzyctl.dumps(system)).outputs[0].name == system.outputs[0].name
    long = system.model_copy(update={"name": "n" * length})
    if length > 200:
        with pytest.raises(fuzzyctl.ValueOutOfBoundsError, match="at most 200 characters"):
            fuzzyctl.dumps(long)
    assert len(as_file(long).name) <= 200


@pytest.mark.parametrize("name", ["two words", "a\x1b[2Jb", "a\u202eb", "1st"])
def test_a_name_that_no_rule_file_can_hold_is_not_written(name):
    system = fuzzyctl.loads(LINE).model_copy(update={"name": name})
    with pytest.raises(fuzzyctl.ValueOutOfBoundsError, match="a name of a rule file"):
        fuzzyctl.dumps(system)
    as_file(system)
