import copy
import dataclasses
import math
import pickle

import pytest

import fuzzyctl
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.expr import Number
from fuzzyctl.loading.load import loads
from fuzzyctl.model.block import Block
from fuzzyctl.model.method import Defuzzifier, Method, Semantics
from fuzzyctl.model.rule import Is, RuleBlock
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, Membership, Output, Term

ZERO_TO_ONE = {"name": "x", "lower": Number(0.0), "upper": Number(1.0), "terms": ()}
SPAN = Span(SourceText("t", "text"), 0, 4)


class TestFields:
    @pytest.mark.parametrize(
        ("kind", "fields", "message"),
        [
            (Input, ZERO_TO_ONE | {"lower": 0}, r"Input.lower must be of type Expr, got 0"),
            (Input, ZERO_TO_ONE | {"name": None}, r"Input.name must be of type str, got None"),
            (Input, ZERO_TO_ONE | {"terms": ("A",)}, r"Input.terms must be of type tuple\[Term, ...\], got \('A',\)"),
            (Input, ZERO_TO_ONE | {"extrapolate": "yes"}, r"Input.extrapolate must be of type bool, got 'yes'"),
            (Output, ZERO_TO_ONE | {"otherwise": math.nan}, r"Output.otherwise must be .*, got nan"),
            (Output, ZERO_TO_ONE | {"otherwise": "hold"}, r"Output.otherwise must be .*, got 'hold'"),
            (Hold, {"start": "error"}, r"Hold.start must be of type Expr \| Literal\['nan'\] \| None, got 'error'"),
            (Defuzzifier, {"rule": "nearby"}, r"Defuzzifier.rule must be of type Rule \| None, got 'nearby'"),
            (Defuzzifier, {"tolerance": math.inf}, r"Defuzzifier.tolerance must be of type float \| None, got inf"),
            (Semantics, {"equal": 10**400}, r"Semantics.equal must be of type float, got 1000"),
            (Defuzzifier, {"resolution": 0.5}, r"Defuzzifier.resolution must be of type int \| None, got 0.5"),
            (Semantics, {"merge": "outputs"}, r"Semantics.merge must be .*, got 'outputs'"),
            (Method, {"spans": ()}, r"Method.spans must be of type Mapping\[str, Span\], got \(\)"),
            (Method, {"span": "3:1"}, r"Method.span must be of type Span \| None, got '3:1'"),
            (RuleBlock, {"name": "b", "rules": ()}, r"RuleBlock.rules must be one rule or more, got \(\)"),
        ],
    )
    def test_values_of_other_types_are_refused_with_name_type_and_value(self, kind, fields, message):
        with pytest.raises(fuzzyctl.ValueOutOfBoundsError, match=message):
            kind(**fields)

    def test_words_numbers_and_expressions_of_the_declared_types_are_accepted(self):
        assert Output(**ZERO_TO_ONE, otherwise="nan").otherwise == "nan"
        assert Output(**ZERO_TO_ONE, otherwise=Hold(start="nan")).otherwise.start == "nan"
        assert Output(**ZERO_TO_ONE, otherwise=Number(1.0)).otherwise == Number(1.0)
        assert Defuzzifier(tolerance=0, resolution=100).tolerance == 0

    def test_lists_are_taken_as_tuples(self):
        term = Term(name="A", membership=Membership(kind="singleton", arguments=[Number(0.0)]))
        made = Input(**ZERO_TO_ONE | {"terms": [term]})
        assert made.terms == (term,)
        assert term.membership.arguments == (Number(0.0),)
        with pytest.raises(fuzzyctl.ValueOutOfBoundsError, match=r"Input.terms must be"):
            Input(**ZERO_TO_ONE | {"terms": ["A"]})

    def test_unknown_and_missing_fields_are_refused_by_name(self):
        with pytest.raises(TypeError, match="bogus"):
            Is(variable="x", term="A", bogus=1)
        with pytest.raises(TypeError, match="term"):
            Is(variable="x")

    def test_nothing_can_be_set_or_deleted(self, base):
        system = loads(base)
        for node, name in ((system, "title"), (system.inputs[0], "lower"), (system.method, "span")):
            with pytest.raises(dataclasses.FrozenInstanceError):
                setattr(node, name, None)
            with pytest.raises(dataclasses.FrozenInstanceError):
                delattr(node, name)

    def test_a_changed_copy_is_checked_too(self, base):
        with pytest.raises(fuzzyctl.ValueOutOfBoundsError, match=r"FuzzySystem.inputs must be .*, got 3"):
            dataclasses.replace(loads(base), inputs=3)


class TestEquality:
    def test_locations_take_no_part(self):
        placed = Is(variable="x", term="A", span=SPAN)
        assert placed == Is(variable="x", term="A")
        assert len({placed, Is(variable="x", term="A")}) == 1
        assert Method(spans={"and": SPAN}) == Method()
        assert hash(Method(spans={"and": SPAN})) == hash(Method())

    def test_the_path_of_the_file_takes_no_part(self, base):
        system = loads(base)
        moved = dataclasses.replace(system, path="elsewhere.fz")
        assert moved == system
        assert hash(moved) == hash(system)

    def test_types_with_the_same_fields_differ(self):
        term = Term(name="A", membership=Membership(kind="singleton", arguments=(Number(0.0),)))
        fields = ZERO_TO_ONE | {"terms": (term,)}
        assert Input(**fields) != Output(**fields)

    def test_the_text_of_a_system_is_one_line_and_so_is_that_of_its_parts(self, base):
        system = loads(base)
        assert repr(system).startswith(f"FuzzySystem({system.name}: ")
        assert repr(system.inputs) == "(Input(x in [-1, 1]: N, Z, P), Input(y in [0, 10] m: N, P))"


def test_completion_offers_fields_and_methods_of_the_project_only():
    inherited = {name for name in dir(FuzzySystem) if not name.startswith("_")}
    own = {*vars(FuzzySystem), *vars(Block), *FuzzySystem.__dataclass_fields__}
    assert inherited - own <= {"model_copy"}


def test_copies_and_pickles_are_equal(base):
    system = loads(base)
    for copied in (copy.copy(system), copy.deepcopy(system), pickle.loads(pickle.dumps(system))):
        assert copied == system
        assert hash(copied) == hash(system)
        assert [r.span.line for r in copied.rules] == [r.span.line for r in system.rules]
