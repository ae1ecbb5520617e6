"""Blocks and their parts are values: typed, frozen, compared without their locations."""

import copy
import dataclasses
import math
import pickle

import pytest

import fuzzyctl
from fuzzyctl import FuzzySystem, build, loads

PARTS = {
    "input": lambda s: s.inputs[0],
    "output": lambda s: s.outputs[0],
    "method": lambda s: s.method,
    "defuzzifier": lambda s: s.method.defuzzifier,
    "semantics": lambda s: s.method.semantics,
    "hold": lambda _: build.Hold(1),
    "system": lambda s: s,
    "block": lambda _: build.rule_block("b", ["if x is A then y is B"]),
}


class TestFields:
    @pytest.mark.parametrize(
        ("part", "field", "value", "message"),
        [
            ("input", "lower", 0, r"Input.lower must be of type Expr, got 0"),
            ("input", "name", None, r"Input.name must be of type str, got None"),
            ("input", "terms", ("A",), r"Input.terms must be of type tuple\[Term, ...\], got \('A',\)"),
            ("input", "extrapolate", "yes", r"Input.extrapolate must be of type bool, got 'yes'"),
            ("output", "otherwise", math.nan, r"Output.otherwise must be .*, got nan"),
            ("output", "otherwise", "hold", r"Output.otherwise must be .*, got 'hold'"),
            ("hold", "start", "error", r"Hold.start must be of type Expr \| Literal\['nan'\] \| None, got 'error'"),
            ("defuzzifier", "rule", "nearby", r"Defuzzifier.rule must be of type Rule \| None, got 'nearby'"),
            ("defuzzifier", "tolerance", math.inf, r"Defuzzifier.tolerance must be of type float \| None, got inf"),
            ("semantics", "equal", 10**400, r"Semantics.equal must be of type float, got 1000"),
            ("defuzzifier", "resolution", 0.5, r"Defuzzifier.resolution must be of type int \| None, got 0.5"),
            ("semantics", "merge", "outputs", r"Semantics.merge must be .*, got 'outputs'"),
            ("method", "spans", (), r"Method.spans must be of type Mapping\[str, Span\], got \(\)"),
            ("method", "span", "3:1", r"Method.span must be of type Span \| None, got '3:1'"),
            ("block", "rules", (), r"RuleBlock.rules must be one rule or more, got \(\)"),
            ("system", "inputs", 3, r"FuzzySystem.inputs must be .*, got 3"),
        ],
    )
    def test_values_of_other_types_are_refused_with_name_type_and_value(self, base, part, field, value, message):
        with pytest.raises(fuzzyctl.ValueOutOfBoundsError, match=message):
            dataclasses.replace(PARTS[part](loads(base)), **{field: value})

    def test_words_numbers_and_lists_of_the_declared_types_are_accepted(self, base):
        system = loads(base)
        (output,) = system.outputs
        for value in ("nan", build.expression(1)):
            assert dataclasses.replace(output, otherwise=value).otherwise == value
        assert dataclasses.replace(system.method.defuzzifier, tolerance=0, resolution=100).tolerance == 0
        assert dataclasses.replace(output, terms=list(output.terms)) == output

    def test_unknown_and_missing_fields_are_refused_by_name(self, base):
        part = loads(base).rules[0].consequents[0]
        with pytest.raises(TypeError, match="bogus"):
            type(part)(output="u", term="A", bogus=1)
        with pytest.raises(TypeError, match="output"):
            type(part)(term="A")

    def test_no_field_can_be_set_or_deleted(self, base):
        system = loads(base)
        for node, name in ((system, "title"), (system.inputs[0], "lower"), (system.method, "span")):
            with pytest.raises(dataclasses.FrozenInstanceError):
                setattr(node, name, None)
            with pytest.raises(dataclasses.FrozenInstanceError):
                delattr(node, name)


class TestEquality:
    def test_locations_and_the_path_take_no_part(self, base):
        system = loads(base)
        for other in (loads("\n\n# a comment\n" + base), dataclasses.replace(system, path="elsewhere.fz")):
            assert other == system
            assert hash(other) == hash(system)

    def test_types_with_the_same_fields_differ(self):
        inside, outside = (f("x", 0, 1, {"A": ("singleton", 0)}) for f in (build.input_variable, build.output_variable))
        assert inside != outside

    def test_copies_and_pickles_are_equal(self, base):
        system = loads(base)
        for copied in (copy.copy(system), copy.deepcopy(system), pickle.loads(pickle.dumps(system))):
            assert copied == system
            assert hash(copied) == hash(system)
            assert [r.span.line for r in copied.rules] == [r.span.line for r in system.rules]


def test_the_text_of_a_system_is_one_line_and_so_is_that_of_its_parts(base):
    system = loads(base)
    assert repr(system).startswith(f"FuzzySystem({system.name}: ")
    assert repr(system.inputs) == "(Input(x in [-1, 1]: N, Z, P), Input(y in [0, 10] m: N, P))"


def test_completion_offers_fields_and_methods_of_the_project_only():
    inherited = {name for name in dir(FuzzySystem) if not name.startswith("_")}
    own = {*vars(FuzzySystem), *vars(fuzzyctl.Block), *FuzzySystem.__dataclass_fields__}
    assert inherited - own <= {"model_copy"}
