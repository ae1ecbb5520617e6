"""Names of any kind become identifiers, and stay apart."""

import keyword

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import fuzzyctl
from fuzzyctl.formats.common.identifiers import identifier, with_identifiers


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("tip", "tip"),
        ("very good", "very_good"),
        ("1st", "_1st"),
        ("σ*", "σ"),
        ("%", "unnamed"),
        ("not", "not_"),
        ("out1mf-2", "out1mf_2"),
    ],
)
def test_a_name_stays_as_near_as_it_can(name, expected):
    assert identifier(name) == expected


@settings(deadline=None)
@given(st.lists(st.text(max_size=12), unique=True, max_size=8))
@example(["param", "if", "table"])
def test_names_of_terms_stay_apart_and_the_file_reads_back(names):
    text = "system s\ninput x in [0, 1]\n  A = ramp(0, 1)\noutput y in [0, 1] else 0\n  b = constant(1)\n"
    system = fuzzyctl.loads(text + "defuzzifier weighted_average\nif x is A then y is b\n")
    (x,), (y,) = system.inputs, system.outputs
    terms = tuple(x.terms[0].model_copy(update={"name": n}) for n in ["A", *(n for n in names if n != "A")])
    changed = system.model_copy(update={"inputs": (x.model_copy(update={"terms": terms, "name": "x y"}),)})
    rule = system.blocks[0]
    antecedent = rule.antecedent.model_copy(update={"variable": "x y"})
    changed = changed.model_copy(update={"blocks": (rule.model_copy(update={"antecedent": antecedent}),)})
    named, losses = with_identifiers(changed)
    found = [t.name for t in named.inputs[0].terms]
    assert len(set(found)) == len(found)
    assert all(n.isidentifier() or keyword.iskeyword(n) for n in found)
    assert fuzzyctl.loads(fuzzyctl.dumps(named)) == named
    assert named.inputs[0].label == "x y"
    assert all(loss.exact for loss in losses)
    assert y.name == "y"


def test_tables_name_what_is_called_otherwise(changed):
    system = fuzzyctl.loads(changed(("u in [-2, 2]", "u in [-2, 2] else 0"), ("N |  N  Z", "N |  N  .")))
    named, losses = with_identifiers(system, reserved=["N", "x"])
    assert {loss.what for loss in losses} == {"the name 'N'", "the name 'x'"}
    (table,) = named.tables_and_rules
    assert (table.rows, table.row_terms, table.column_terms) == ("x_", ("N_", "Z", "P"), ("N_", "P"))
    assert [cell.terms for cell in table.cells[0]] == [("N_",), ()]
    points = [[-0.9, 2.0], [0.3, 8.0]]
    kernels = [fuzzyctl.compile(s, "python") for s in (system, named)]
    assert kernels[0].batch(points).tolist() == kernels[1].batch(points).tolist()


@pytest.mark.parametrize(
    ("name", "title", "expected"),
    [("cart & pole", "", "cart & pole"), ("cart & pole", "A cart", "A cart"), ("cart", "", "")],
)
def test_a_system_that_is_called_otherwise_keeps_its_name_as_its_title(name, title, expected):
    system = fuzzyctl.loads(
        "system s\ninput x in [0, 1]\n  a = ramp(0, 1)\noutput y in [0, 1]\n  b = ramp(0, 1)\nif x is a then y is b\n"
    )
    found, _ = with_identifiers(system.model_copy(update={"name": name, "title": title}))
    assert (found.name, found.title) == (name.replace(" & ", "_"), expected)


FOREIGN = {
    "x.fis": "[System]\nName='NAME'\nType='mamdani'\nNumInputs=1\nNumOutputs=1\nNumRules=1\nAndMethod='min'\n"
    "OrMethod='max'\nImpMethod='min'\nAggMethod='max'\nDefuzzMethod='centroid'\n"
    "[Input1]\nName='NAME'\nRange=[0 1]\nNumMFs=1\nMF1='NAME':'trimf',[-1 0 2]\n"
    "[Output1]\nName='oNAME'\nRange=[0 1]\nNumMFs=1\nMF1='NAME':'trimf',[0 1 2]\n[Rules]\n1, 1 (1) : 1\n",
    "x.fll": "Engine: NAME\nInputVariable: NAME\n  range: 0 1\n  term: NAME Triangle -1 0 2\n"
    "OutputVariable: oNAME\n  range: 0 1\n  aggregation: Maximum\n  defuzzifier: Centroid 100\n  default: nan\n"
    "  term: NAME Triangle 0 1 2\nRuleBlock:\n  conjunction: Minimum\n  disjunction: Maximum\n"
    "  implication: Minimum\n  activation: General\n  rule: if NAME is NAME then oNAME is NAME\n",
    "x.fcl": "FUNCTION_BLOCK NAME\nVAR_INPUT NAME : REAL; END_VAR\nVAR_OUTPUT oNAME : REAL; END_VAR\n"
    "FUZZIFY NAME\nTERM NAME := (-1, 0) (0, 1) (2, 0);\nEND_FUZZIFY\nDEFUZZIFY oNAME\n"
    "TERM NAME := (0, 0) (1, 1) (2, 0);\nMETHOD : COG;\nDEFAULT := 0;\nEND_DEFUZZIFY\nRULEBLOCK No1\nAND : MIN;\n"
    "ACT : MIN;\nACCU : MAX;\nRULE 1 : IF NAME IS NAME THEN oNAME IS NAME;\nEND_RULEBLOCK\nEND_FUNCTION_BLOCK\n",
}


#: Files whose names become identifiers when they are read.
TRANSLATED = ["x.fll", "x.fis", "x.fcl"]


@pytest.mark.parametrize("length", [199, 200, 201, 1000])
@pytest.mark.parametrize("file", FOREIGN)
def test_a_long_name_of_another_format_is_written_only_where_it_is_read_back(file, length):
    system = fuzzyctl.loads(FOREIGN[file].replace("NAME", "n" * (length - 1)), file)
    if file in TRANSLATED and length > 200:
        assert fuzzyctl.loads(fuzzyctl.dumps(system)).outputs[0].name == system.outputs[0].name
        return
    assert len(system.outputs[0].name) == length
    if length <= 200:
        assert fuzzyctl.loads(fuzzyctl.dumps(system)).outputs[0].name == system.outputs[0].name
    else:
        with pytest.raises(fuzzyctl.ValueOutOfBoundsError, match="at most 200 characters"):
            fuzzyctl.dumps(system)
    named, losses = with_identifiers(system)
    assert fuzzyctl.loads(fuzzyctl.dumps(named)).outputs[0].name == named.outputs[0].name
    assert bool(losses) == (length > 192)


@pytest.mark.parametrize("name", ["two words", "a\x1b[2Jb", "a\u202eb", "1st"])
def test_a_name_that_no_rule_file_can_hold_is_not_written(name):
    system = fuzzyctl.loads(FOREIGN["x.fis"], "x.fis").model_copy(update={"name": name})
    with pytest.raises(fuzzyctl.ValueOutOfBoundsError, match="a name of a rule file"):
        fuzzyctl.dumps(system)
    fuzzyctl.loads(fuzzyctl.dumps(with_identifiers(system)[0]))
