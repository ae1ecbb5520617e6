"""Generated Structured Text, read by a parser of its grammar and run: the numbers are those of the kernels."""

import math
import re
from itertools import product

import pytest

from fuzzyctl import compile, loads
from fuzzyctl.codegen.files import sources
from tests.fuzzyctl.codegen.conftest import expected_of, prepared, unit_of, written
from tests.fuzzyctl.codegen.structured_text import Block, differences


def function_block(unit):
    (text,) = sources(unit, "st").values()
    return text


GUARDED = """system s
and product
defuzzifier weighted_average
input x in [-4, 4]
  low  = triangle(-inf, -3, 1)
  high = triangle(-1, 3, inf)
input y in [-2, 2]
  on = function({degree})
  off = triangle(-inf, -1, 1)
output u in [-9, 9] else nan
  p = constant(1)
  q = function({value})
if x is low and y is off then u is p
if x is high or y is on then u is q
"""


class TestGuards:
    """Functions are called only where they have a value: the machine of this test stops elsewhere."""

    @pytest.mark.parametrize(
        "value",
        [
            *("log(x)", "x^0.5", "x^(-2)", "x^(-0.5)", "(x - 1)^y", "0 * log(y)", "sqrt(y) / y", "1 / sqrt(x)"),
            *("max(sqrt(x), y)", "max(y, sqrt(x))", "min(log(x), 2) + sqrt(y)", "abs(sqrt(x))", "exp(-1 / (x * x))"),
            *(
                "ne(sqrt(x), y) + eq(y, y)",
                "ge(x, y) * le(1 / x, y) - gt(x, 0.5)",
                "sign(sqrt(x))",
                "sqrt(sqrt(x) - 1)",
            ),
        ],
    )
    def test_give_the_numbers_and_validity_of_the_kernel(self, value):
        text = GUARDED.format(value=value, degree="y / 2")
        unit = prepared(text)
        assert differences(unit) <= 1.0
        assert sum(v.outputs[0] == v.outputs[0] for v in expected_of(unit).vectors) > 20

    @pytest.mark.parametrize("degree", ["log(y)", "1 / y", "max(sqrt(y), 0.2)", "1 - y^0.5"])
    def test_of_degrees_do_too(self, degree):
        text = GUARDED.format(value="x", degree=degree)
        assert differences(prepared(text)) <= 1.0

    def test_of_rates_do_too(self):
        text = GUARDED.format(value="x", degree="y / 2").replace("else nan", "else nan adaptive rate sqrt(x) / y")
        text = text.replace("function(x)", "constant(2)")
        assert differences(prepared(text)) <= 1.0

    def test_a_lost_guard_is_found(self):
        text = GUARDED.format(value="sqrt(x)", degree="y / 2")
        written = function_block(prepared(text))
        test = re.search(r"\(v\d+ < 0\.0\)(?= THEN\n +v\d+ := 0\.0;\n +v\d+_no := TRUE)", written)
        with pytest.raises(ValueError, match="math domain error"):
            Block(written.replace(test[0], "FALSE"))(x=-1.0, y=1.0)


INFINITE = """system s
and product
defuzzifier weighted_average
input x in [0, 10] extrapolate
  low  = triangle(-inf, 1, 4)
  high = triangle(1, 4, inf)
input y in [-1, 1] extrapolate
  down = gaussian(0, 1)
  up   = triangle(-0.6, 0.4, inf)
output u in [-50, 50] {adaptive}else -1
  a = {first}
  b = {second}
if x is low or y is up then u is a
if x is high and y is down then u is b
"""


class TestInfinity:
    """The machine of these tests stops where a selection is handed NaN."""

    @pytest.mark.parametrize(
        ("first", "second"),
        [
            ("function(x - y)", "function(2 * x - x * y)"),
            ("linear(1, -1, 0)", "constant(3)"),
            ("function(min(x - y, 4))", "function(max(3, x * y))"),
            ("function(sqrt(abs(x)) - y)", "function(x / (y - 7))"),
        ],
    )
    def test_less_infinity_and_times_zero_has_no_value(self, first, second):
        text = INFINITE.format(first=first, second=second, adaptive="")
        block, kernel = Block(function_block(prepared(text))), compile(loads(text), "python")
        places = [math.inf, -math.inf, 1e308, -1e308, 0.0, 2.5]
        undefined = 0
        for x, y in product(places, places):
            value, valid = block(x=x, y=y)
            wanted = kernel(x, y)
            assert valid == (wanted == wanted), (x, y)
            assert value == (pytest.approx(wanted, rel=1e-12) if valid else 0.0), (x, y)
            undefined += not valid
        assert 0 < undefined < len(places) ** 2

    def test_in_a_rate_keeps_the_consequent(self):
        text = INFINITE.format(first="constant(1)", second="constant(3)", adaptive="adaptive rate x - y ")
        block = Block(function_block(prepared(text)))
        assert block(x=2.5, y=0.5, time_step=0.125)[1]
        before = block.variables["consequent_0"]
        assert before > 1.0
        block(x=math.inf, y=math.inf, time_step=0.125)
        assert block.variables["consequent_0"] == before

    def test_costs_nothing_where_inputs_are_clamped(self):
        text = INFINITE.format(first="linear(1, -1, 0)", second="constant(3)", adaptive="")
        assert "<>" in function_block(prepared(text))
        assert "<>" not in function_block(prepared(text.replace(" extrapolate", "")))


class TestNumbers:
    def test_are_those_of_the_kernel(self, kind):
        assert differences(unit_of(kind)) <= 1.0

    def test_of_rules_too_where_the_system_interpolates(self):
        assert differences(unit_of("ais_reaction", algorithm="rules")) <= 1.0

    def test_of_a_table(self):
        assert differences(unit_of("ais_reaction", table=21)) <= 1.0

    def test_a_wrong_number_is_found(self):
        unit = unit_of("boundary_layer")
        text = function_block(unit)
        assert "0.0275" in text
        block = Block(text.replace("0.0275", "0.0274"))
        assert block(abs_sigma=0.03)[0] != pytest.approx(Block(text)(abs_sigma=0.03)[0], rel=1e-6)

    def test_single_precision_is_declared_and_within_its_tolerance(self):
        unit = unit_of("ais_reaction", precision="float")
        assert "LREAL" not in function_block(unit)
        assert differences(unit) <= 1.0


class TestText:
    def test_an_input_that_is_looked_up_is_held_once(self):
        assert function_block(unit_of("active")).count("LIMIT(") == 3  # both inputs, and the output

    def test_names_that_differ_by_case_only_are_told_apart(self):
        text = (
            "system If\ndefuzzifier weighted_average\ninput X in [0, 1]\n  terms a b\ninput x in [0, 1]\n  terms a b\n"
            "output Y in [0, 1]\n  p = constant(0)\n  q = constant(1)\nif X is a then Y is p\nif x is b then Y is q\n"
            "if X is b or x is a then Y is q\n"
        )
        block = Block(function_block(prepared(text)))
        assert block.name == "If_fz".lower()
        assert len({*block.inputs}) == 2

    def test_functions_without_a_standard_one_are_refused(self):
        text = (
            "system s\ndefuzzifier weighted_average\ninput x in [0, 1]\n  terms a b\noutput y in [-9, 9]\n"
            "  p = function({})\n  q = constant(1)\nif x is a then y is p\nif x is b then y is q\n"
        )
        for function, value in (("atan2", "atan2(x, 2)"), ("floor", "round(x) + x"), ("fmod", "mod(x, 2)")):
            assert function in written(text.format(value), "st").errors

    def test_what_is_held_at_first_must_be_a_number(self):
        text = (
            "system s\ninput x in [0, 9]\n  low = triangle(-inf, 0, 4)\noutput y in [0, 1] else hold({})\n"
            "  p = triangle(0, 0.5, 1)\nif x is low then y is p\n"
        )
        assert "'y' holds NaN at first" in " ".join(written(text.format("nan"), "st").errors.split())
        assert "held_y : LREAL := 0.25;" in "".join(written(text.format("0.25"), "st").files.values())
