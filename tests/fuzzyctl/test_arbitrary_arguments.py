"""Whatever callers hand to the public functions, only fuzzyctl's own errors come out."""

import math
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import fuzzyctl
from fuzzyctl import FuzzyctlError, ValueOutOfBoundsError, build
from tests.sizes import examples

X = build.input_variable("x", 0, 1, build.partition("L H"))
Y = build.input_variable("y", 0, 1, build.partition("L H"))
U = build.output_variable("u", 0, 1, {"A": 0, "B": 1}, otherwise=0)
TABLE = build.rule_table("u", "x", {"L": "A", "H": "B"})
SYSTEM = build.system("s", [X, U], [TABLE], defuzzifier="weighted_average")

#: What a caller may get nearly right.
TEXTS = (
    "", " ", "L", "L H", "x", "u", "min ", "hold", "hold(0.2)", "hold(", "highest(count=1)", "threshold(>= 0.1)",
    "triangle(0, 1, 2, height=0.5)", "triangle(0)", "triangle(0, 1, left=2)", "if x is L then u is A", "if", "x is L",
    "u <= 1", "1 +", "(1", "k", "1 # c", "a\nb", 'a"b', "x ^ 2", "A/B", "A*0.5", "\0", "\ud800", "é", "inf",
)  # fmt: skip

PLAIN = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 3),
    st.sampled_from([10**400, -(10**400), Fraction(10**400), Fraction(1, 3), Decimal(1), 1j, math.inf, math.nan]),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from(TEXTS),
    st.binary(max_size=3),
    st.sampled_from([X, U, TABLE, SYSTEM, SYSTEM.method.activation, SYSTEM.method.defuzzifier, build.Hold()]),
    st.sampled_from([object(), int, len, Path("nothing.fz"), np.float32(0.5), np.array(0.5), np.array([0.0, 1.0])]),
)
HASHABLE = st.one_of(st.none(), st.integers(-3, 3), st.text(max_size=4), st.sampled_from(TEXTS), st.binary(max_size=2))
ANYTHING = st.recursive(
    PLAIN,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.lists(inner, max_size=3).map(tuple),
        st.dictionaries(HASHABLE, inner, max_size=3),
        st.sets(HASHABLE, max_size=2),
    ),
    max_leaves=5,
)

SYSTEM_ARGUMENTS = {
    "name": "s", "variables": [X, U], "rules": [TABLE], "defuzzifier": "weighted_average", "params": {}, "hedges": {},
    "title": "", "citation": "", "activation": "general", "guarantees": [], "conjunction": "min", "disjunction": "max",
    "implication": "min", "aggregation": "max",
}  # fmt: skip
VARIABLE_ARGUMENTS = {"name": "x", "lower": 0, "upper": 1, "terms": {"A": 0}, "label": "", "unit": ""}


def one_parameter(kind, a, height):
    return build.membership(kind, a, height=height)


def traced(block, x):
    return fuzzyctl.why(block, x=x)


#: Public functions with arguments that are right.
FUNCTIONS = {
    "system": (build.system, SYSTEM_ARGUMENTS),
    "input_variable": (build.input_variable, {**VARIABLE_ARGUMENTS, "extrapolate": False}),
    "output_variable": (
        build.output_variable,
        {**VARIABLE_ARGUMENTS, "otherwise": 0, "adaptive": 1}
        | {"implication": "min", "aggregation": "max", "defuzzifier": "centroid"},
    ),
    "partition": (build.partition, {"names": "L H", "peaks": [0, 1]}),
    "even partition": (build.input_variable, {**VARIABLE_ARGUMENTS, "terms": build.partition("L M H")}),
    "membership": (one_parameter, {"kind": "t", "a": 0, "height": 1}),
    "one-way rule_table": (build.rule_table, {"outputs": "u", "rows": "x", "cells": {"L": "A"}, "condition": "y is L"}),
    "rule_table": (
        build.rule_table,
        {"outputs": "u", "rows": "x", "cells": {"L": "A B"}, "columns": "y", "headers": "L H", "condition": None},
    ),
    "rule_block": (
        build.rule_block,
        {"name": "b", "rules": [TABLE, "if x is L then u is A"], "conjunction": "min", "disjunction": "max"}
        | {"implication": "min", "activation": "general"},
    ),
    "rule": (build.rule, {"text": "if x is L then u is A"}),
    "expression": (build.expression, {"value": 1}),
    "Hold": (build.Hold, {"start": 0}),
    "load": (fuzzyctl.load, {"path": "nothing.fz", "block": None, "max_bytes": 100}),
    "load_all": (fuzzyctl.load_all, {"path": "nothing.fz", "max_bytes": 100}),
    "loads": (fuzzyctl.loads, {"text": fuzzyctl.dumps(SYSTEM), "name": "<text>", "block": None}),
    "check": (fuzzyctl.check, {"path": SYSTEM, "block": None, "max_bytes": 100, "guarantees": True}),
    "prove": (fuzzyctl.prove, {"path": SYSTEM, "block": None, "timeout": 1, "progress": None}),
    "output_bounds": (fuzzyctl.output_bounds, {"system": SYSTEM, "timeout": 1}),
    "why": (traced, {"block": SYSTEM, "x": 0.5}),
    "dumps": (fuzzyctl.dumps, {"system": SYSTEM}),
    "compile": (fuzzyctl.compile, {"block": SYSTEM, "backend": "python", "algorithm": "auto"}),
}  # fmt: skip

RELAXED = settings(deadline=None, max_examples=examples(60), suppress_health_check=[HealthCheck.too_slow])


def attempt(function, arguments):
    """Call a function; what is no error of fuzzyctl, or one that cannot be shown, fails the test."""
    try:
        return function(**arguments)
    except FuzzyctlError as error:
        str(error).encode()  # half a surrogate pair could not be printed
        return None


class TestArbitraryArguments:
    @pytest.mark.parametrize("name", FUNCTIONS)
    def test_right_arguments_are_taken(self, name):
        function, arguments = FUNCTIONS[name]
        if not name.startswith("load"):
            assert function(**arguments) is not None

    @pytest.mark.parametrize("name", FUNCTIONS)
    @RELAXED
    @given(data=st.data())
    def test_one_wrong_argument_costs_no_other_error(self, name, data):
        function, arguments = FUNCTIONS[name]
        wrong = data.draw(st.sampled_from(list(arguments)))
        attempt(function, {**arguments, wrong: data.draw(ANYTHING)})

    @RELAXED
    @given(spec=ANYTHING)
    @example(spec=())
    @example(spec=(1, 2, 3))
    @example(spec=("triangle", 0, True))
    def test_terms_cells_and_params_may_be_anything(self, spec):
        attempt(build.input_variable, {**VARIABLE_ARGUMENTS, "terms": {"A": spec}})
        attempt(build.rule_table, {"outputs": "u", "rows": "x", "cells": {"L": spec}})
        attempt(build.rule_table, {"outputs": "u", "rows": "x", "cells": {"L": [spec]}, "columns": "y", "headers": "L"})
        for where in ("params", "hedges"):
            attempt(build.system, {**SYSTEM_ARGUMENTS, where: {"p": spec}})
        attempt(build.system, {**SYSTEM_ARGUMENTS, "params": {"p": (1, spec)}})
        for where in ("variables", "rules", "guarantees"):
            attempt(build.system, {**SYSTEM_ARGUMENTS, where: [*SYSTEM_ARGUMENTS[where], spec]})

    @RELAXED
    @given(spec=ANYTHING)
    def test_an_odd_variable_is_found_when_the_system_is_built(self, spec):
        for wrong in ("lower", "terms", "otherwise", "adaptive", "defuzzifier", "label"):
            odd = attempt(build.output_variable, {**VARIABLE_ARGUMENTS, "name": "v", wrong: spec})
            if odd is not None:
                built = attempt(build.system, {**SYSTEM_ARGUMENTS, "variables": [X, U, odd], "rules": [TABLE]})
                if built is not None:
                    assert fuzzyctl.loads(fuzzyctl.dumps(built)) == built
                    for function in (fuzzyctl.check, fuzzyctl.output_bounds, fuzzyctl.compile):
                        attempt(lambda f=function, s=built: f(s), {})

    @settings(RELAXED, suppress_health_check=[HealthCheck.function_scoped_fixture])
    @given(path=ANYTHING)
    @example(path="\ud800")
    def test_a_system_is_written_to_a_path_only(self, path, tmp_path):
        if isinstance(path, str):
            path = str(tmp_path / path) if not path.startswith("/") else path[1:] and "/nothing" + path
        elif isinstance(path, Path):
            path = tmp_path / path
        attempt(fuzzyctl.dump, {"system": SYSTEM, "path": path})


class TestDuplicates:
    """Lists can hold a name twice, and nothing is dropped without a word."""

    @pytest.mark.parametrize("peaks", [None, [0, 0.3, 0.3, 1]])
    def test_a_term_of_a_partition(self, peaks):
        twice = build.input_variable("x", 0, 1, build.partition("N Z Z P", peaks))
        assert [t.name for t in twice.terms] == ["N", "Z", "Z", "P"]
        with pytest.raises(fuzzyctl.DiagnosticError, match=r"FZ201.*term 'Z' is declared twice"):
            build.system("s", [twice, U], ["if x is Z then u is A"], defuzzifier="weighted_average")

    def test_an_output_of_a_table(self):
        table = build.rule_table(["u", "u"], "x", {"L": "A/B", "H": "B/A"})
        with pytest.raises(fuzzyctl.DiagnosticError, match="the table sets 'u' twice"):
            build.system("s", [X, U], [table], defuzzifier="weighted_average")

    def test_headers_without_columns_are_refused(self):
        with pytest.raises(fuzzyctl.ArgumentError, match="'headers' are the terms of 'columns'"):
            build.rule_table("u", "x", {"L": "A", "H": "B"}, headers="L H")


class TestNamedArguments:
    @pytest.mark.parametrize(
        ("changed", "message"),
        [
            ({"rules": TABLE}, "'rules' must be a list of rules, tables, rule blocks and texts .*, got RuleTable"),
            ({"rules": "if x is L then u is A"}, "'rules' must be a list .*, got str"),
            ({"rules": None}, "'rules' must be a list .*, got None"),
            ({"variables": [1, 2]}, "'variables' must be a list of inputs, lets and outputs, got one with int in it"),
            ({"variables": X}, "'variables' must be a list of inputs, lets and outputs, got Input"),
            ({"guarantees": "u <= 1"}, "'guarantees' must be a list"),
            ({"params": []}, "'params' must be values by name, got list"),
            ({"params": {"p": (1, "m", "z")}}, "param 'p' must be a value, or a value and its unit, got 3"),
            ({"params": {"p": (1, 2)}}, "the unit of param 'p' must be a text, got int"),
            ({"params": {"p": True}}, "param 'p' must be a number or the text of an expression, got bool"),
            ({"hedges": {3: "x"}}, "'hedges' must be expressions over x by name, got one with int for a name"),
            ({"title": b"x"}, "'title' must be a text, got bytes"),
            ({"name": b"a"}, "'name' must be a text, got bytes"),
            ({"defuzzifier": 3}, "'defuzzifier' must be the text of a defuzzifier"),
            ({"activation": ""}, "expected an activation, got an empty text; the form is: general"),
        ],
    )
    def test_of_a_system(self, changed, message):
        with pytest.raises(fuzzyctl.ArgumentError, match=message):
            build.system(**SYSTEM_ARGUMENTS | changed)

    def test_of_others(self):
        for message, call in (
            ("'peaks' must be a list of numbers, got str", lambda: build.partition("L H", "01")),
            ("term 'A' must begin with its kind", lambda: build.input_variable("x", 0, 1, {"A": (1, 2, 3)})),
            ("'extrapolate' must be True or False", lambda: build.input_variable("x", 0, 1, {}, extrapolate="no")),
            ("row 'L' must be cells", lambda: build.rule_table("u", "x", {"L": 3}, "y", headers="L")),
            ("'otherwise' must be a number", lambda: build.output_variable("u", 0, 1, {}, otherwise="")),
            ("term 'A' must be a number", lambda: build.input_variable("x", 0, 1, {"A": " "})),
            ("'name' must be a text", lambda: fuzzyctl.loads("system s", None)),
            ("'block' must be the name of a block", lambda: fuzzyctl.check(SYSTEM, block=3)),
            ("'max_bytes' must be a whole number", lambda: fuzzyctl.load("a.fz", max_bytes="a")),
            ("the system must be a FuzzySystem", lambda: fuzzyctl.dump(3, "a.fz")),
            ("expected the path of a rule file, got int$", lambda: fuzzyctl.dump(SYSTEM, 3)),
        ):
            with pytest.raises(fuzzyctl.ArgumentError, match=message):
                call()

    @pytest.mark.parametrize("digits", [400, 5000])  # of 5000 digits Python makes no text
    def test_numbers_beyond_floats_are_refused(self, digits):
        with pytest.raises(fuzzyctl.ValueOutOfBoundsError, match="param 'p' must be within the range of floats"):
            build.system(**SYSTEM_ARGUMENTS | {"params": {"p": 10**digits}})
        with pytest.raises(fuzzyctl.ValueOutOfBoundsError, match="'max_bytes' must be from 1 to"):
            fuzzyctl.load("a.fz", max_bytes=10**digits)
        with pytest.raises(fuzzyctl.ArgumentError, match="expected the path of a rule file, got int"):
            fuzzyctl.load(10**digits)

    @pytest.mark.parametrize("character", ["\0", "\ud800"])
    def test_what_no_file_can_hold_is_refused_at_the_start(self, character):
        with pytest.raises(fuzzyctl.DiagnosticError, match=rf"FZ002.*U\+{ord(character):04X} in line 2"):
            fuzzyctl.loads(f'\nsystem s "a{character}"')
        with pytest.raises(fuzzyctl.ValueOutOfBoundsError, match="title must be a text"):
            build.system(**SYSTEM_ARGUMENTS | {"title": f"a{character}"})

    def test_a_time_above_all_floats_is_infinite(self):
        assert fuzzyctl.output_bounds(SYSTEM, timeout=10**400)["u"].hi == 1.0
        with pytest.raises(ValueOutOfBoundsError, match="'timeout' must be >= 0 s"):
            fuzzyctl.output_bounds(SYSTEM, timeout=-(10**400))
