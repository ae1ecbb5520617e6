"""What constructs of the language mean, on small systems with numbers worked out by hand."""

import math

import numpy as np
import pytest

from fuzzyctl import NoRuleFiresError, compile, loads
from fuzzyctl.kernels.compile import degrees

BACKENDS = ("python", "numpy")
INPUTS = "".join(
    f"input {name} in [0, 1]\n  up = ramp(0, 1)\n  down = ramp(1, 0)\n  middle = triangle(0, 0.5, 1)\n" for name in "xy"
)


def system(rules, output="", head="", method="weighted_average"):
    """Return a system of two inputs in [0, 1]; without another output u has the terms of `output`."""
    if "output" not in output:
        output = f"output u in [-10, 10] else nan\n{output}"
    return loads(f"system s\ndefuzzifier {method}\n{head}{INPUTS}{output}{rules}\n")


def rules(*lines):
    return "\n".join(f"if {line}" for line in lines)


FLAT = "  flat = trapezoid(0, 1, 3, 9)\n  edge = s_shape(0, 5)\n  hill = gaussian(4, 1, height=0.5)\n"
MORE = "  more = ramp(0, 8)\n  less = ramp(4, 0)\n  tall = ramp(0, 8, height=0.5)\n"
BOXES = "output u in [0, 4] else nan\n  low = rectangle(0, 2, height=0.5)\n  high = rectangle(2, 4)\n"
THREE = (
    "output u in [0, 4] else nan defuzzifier centroid implication product aggregation sum\n"
    "  low = rectangle(0, 2)\n  high = rectangle(2, 4)\noutput v in [-9, 9] else nan\n  c = constant(5)\n"
)
TABLE = "output u in [-10, 10] else nan\n  c = constant(4)\ntable u = x\n  up down middle\n| linear(1, 0, 0) c .\n"
#: A system, a point and the value there.
VALUES = {
    "linear consequents": (
        system(rules("x is up then u is linear(2, -1, 3)", "x is down then u is constant(7)")),
        *((0.25, 0.5), 0.25 * (0.5 - 0.5 + 3) + 0.75 * 7),
    ),
    "functions of inputs and params": (
        system(rules("x is up then u is function(k * x + max(y, 0.5, x))"), head="param k = 4\n"),
        *((0.25, 0.125), 1.5),
    ),
    "clamped inputs": (system(rules("x is up then u is linear(1, 1, 0)")), (1e9, 1e9), 2.0),
    "a rule that does not fire has no value": (
        system(rules("x is up then u is function(1 / x)", "x is down then u is constant(2)")),
        *((0.0, 0.0), 2.0),
    ),
    "one that fires without a value": (system(rules("x is up then u is function(sqrt(x - 2))")), (0.5, 0.0), math.nan),
    "a sum does not divide": (
        system(
            rules("x is up then u is linear(0, 1, 3)", "x is down then u is constant(7) weight 0.5"),
            method="weighted_sum",
        ),
        *((0.25, 0.5), 0.25 * 3.5 + 0.375 * 7),
    ),
    "sets count with the middle of their core": (
        system(rules("x is up then u is flat", "x is down then u is edge", "y is up then u is hill"), FLAT),
        *((0.25, 0.5), (0.25 * 2 + 0.75 * 5 + 0.5 * 4) / 1.5),
    ),
    "cells of tables": (system("", TABLE), (0.25, 0.0), 0.25 * 0.25 + 0.75 * 4),
    "tsukamoto": (
        system(rules("x is up then u is more", "x is down then u is less"), MORE, method="tsukamoto"),
        *((0.25, 0.0), 0.25 * 2 + 0.75 * 1),
    ),
    "tsukamoto relative to the height": (
        system(rules("x is up then u is tall"), MORE, method="tsukamoto"),
        *((0.25, 0.0), 4.0),
    ),
    "tsukamoto no more than the height": (
        system(rules("x is up then u is tall"), MORE, method="tsukamoto"),
        *((0.75, 0.0), 8.0),
    ),
    "tsukamoto within the range": (
        system(rules("x is up then u is s"), "  s = sigmoid(1, 2)\n", method="tsukamoto"),
        *((1e-300, 0.0), -10.0),
    ),
    "a method for each output": (
        system(rules("x is up then u is low, v is c", "x is down then u is high"), THREE),
        *((0.25, 0.0), (0.25 * 1 + 0.75 * 3, 5.0)),
    ),
    **{
        f"heights of sets, {method}": (
            system(rules("x is up then u is low", "x is up then u is high"), BOXES, method=method),
            *((1.0, 0.0), (0.5 * 1 + 3) / 1.5),
        )
        for method in ("centroid", "centroid(resolution=4)")
    },
    **{
        f"hedges from the term outwards, {hedges}": (
            system(
                rules(f"x is {hedges} up then u is constant(1)"),
                head="param two = 2\nhedge half(m) = m / two\nhedge wild(m) = log(m - 0.5)\nhedge twice(m) = 2 * m\n",
                method="weighted_sum",
            ),
            *((x, 0.0), value),
        )
        for hedges, x, value in (
            *(("very", 0.25, 0.0625), ("not very", 0.25, 0.9375), ("very not", 0.25, 0.5625), ("any", 0.25, 1.0)),
            *(("half", 0.25, 0.125), ("twice", 0.75, 1.0), ("wild", 0.25, math.nan), ("wild", 0.75, math.nan)),
        )
    },
}


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", VALUES)
def test_values_are_those_by_hand(name, backend):
    own, point, expected = VALUES[name]
    kernel = compile(own, backend)
    for found in (kernel(*point), kernel.batch([point])[0]):
        np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_averages_never_leave_what_they_average():
    share = compile(system(rules(*["x is up then u is function(0.3 * y)"] * 2)), "python")
    line = compile(system(rules(*["x is up then u is linear(0, 0.3, 0)"] * 2)), "python")
    for x in np.geomspace(5e-324, 1.0, 200).tolist():  # below 1e-300 products of activations lose digits
        assert share(x, 1.0) == 0.3
        assert line(x, 1.0) == pytest.approx(0.3, rel=1e-15 if x > 1e-290 else 0.5)
        assert 0.0 <= line(x, 1.0) <= 0.3


def test_long_conjunctions_of_any_norm_stay_short_programs():
    both = " and ".join(f"{v} is {t}" for v in "xy" for t in ("up", "middle", "down") * 2)
    for norm in ("hamacher_product", "einstein_product", "nilpotent_minimum"):
        kernel = compile(system(rules(f"{both} then u is constant(1)"), head=f"and {norm}\n"), "python")
        assert len(kernel.source) < 12_000
        assert kernel(0.5, 0.5) == pytest.approx(1.0) or math.isnan(kernel(0.5, 0.5))


class TestChains:
    """An output in an antecedent is its value of this evaluation, within its range."""

    def chain(self, otherwise="else nan", last=""):
        output = (
            f"output v in [-9, 9] {last}\n  n = constant(1)\n  p = constant(3)\n"
            f"output u in [0, 1] {otherwise}\n  small = ramp(1, 0)\n  large = ramp(0, 1)\n"
        )
        lines = ("u is small then v is n", "u is large then v is p", "x is middle then u is linear(1, 0, 0)")
        return system(rules(*lines), output)

    @pytest.mark.parametrize("backend", [*BACKENDS, "numba"])
    @pytest.mark.parametrize(
        ("otherwise", "last", "x", "expected"),
        [
            ("else nan", "", 0.25, (0.75 * 1 + 0.25 * 3, 0.25)),
            ("else 7", "", 0.0, (3.0, 7.0)),
            *(("else nan", last, 0.0, (math.nan, math.nan)) for last in ("", "else error", "else 2")),
        ],
    )
    def test_values_go_on_to_those_that_read_them(self, backend, otherwise, last, x, expected):
        kernel = compile(self.chain(otherwise, last), backend)
        for found in (kernel(x, 0.0), kernel.batch([[x, 0.0]])[0]):
            np.testing.assert_array_equal(found, expected)

    @pytest.mark.parametrize("backend", [*BACKENDS, "numba"])
    @pytest.mark.parametrize("otherwise", ["", "else error"])
    def test_a_broken_promise_is_reported_with_the_output_that_broke_it(self, backend, otherwise):
        kernel = compile(self.chain(otherwise), backend)
        for call in (lambda: kernel(0.0, 0.0), lambda: kernel.batch([[0.5, 0.0], [0.0, 0.0]])):
            with pytest.raises(NoRuleFiresError, match="'u'"):
                call()

    def test_an_adaptive_output_may_read_another(self):
        text = (
            "output u in [0, 1] else nan\n  small = ramp(1, 0)\n  large = ramp(0, 1)\n"
            "output v in [-9, 9] adaptive rate x\n  n = constant(-1)\n  p = constant(1)\n"
        )
        lines = ("x is up then u is linear(1, 0, 0)", "u is small then v is n", "u is large then v is p")
        kernel = compile(system(rules(*lines), text), "numpy")
        assert kernel(0.25, 0.0, kernel.start())[1] == pytest.approx(-0.5)
        xi = np.empty(2)
        kernel.jit_strengths(0.25, 0.0, xi)
        assert xi == pytest.approx([0.75, 0.25])


#: Rules with activations x, 0.5, y and 0.25 and the consequents 1, 10, 100 and 1000 of a weighted sum.
ACTING = [
    ("general", (0.3, 0.7), [0.3, 0.5, 0.7, 0.25]),
    ("first(count=1)", (0.3, 0.7), [0.3, 0, 0, 0]),
    ("first(count=2)", (0.0, 0.7), [0, 0.5, 0.7, 0]),
    ("first(count=2, threshold=0.5)", (0.3, 0.7), [0, 0.5, 0.7, 0]),
    ("last(count=2, threshold=0.3)", (0.3, 0.7), [0, 0.5, 0.7, 0]),
    ("highest(count=2)", (0.3, 0.7), [0, 0.5, 0.7, 0]),
    ("highest(count=1)", (0.5, 0.5), [0.5, 0, 0, 0]),
    ("lowest(count=2)", (0.5, 0.0), [0.5, 0, 0, 0.25]),
    ("proportional", (0.5, 0.75), [0.25, 0.25, 0.375, 0.125]),
    ("threshold(>= 0.5)", (0.3, 0.7), [0, 0.5, 0.7, 0]),
    ("threshold(> 0.5)", (0.3, 0.7), [0, 0, 0.7, 0]),
    ("threshold(!= 0.5)", (0.3, 0.7), [0.3, 0, 0.7, 0.25]),
]


@pytest.mark.parametrize(("activation", "point", "acting"), ACTING)
def test_activation_methods_let_those_rules_act(activation, point, acting):
    terms = "output u in [0, 999] else 0\n" + "".join(f"  c{k} = constant({10**k})\n" for k in range(4))
    lines = (
        "x is up then u is c0",
        "x is half then u is c1",
        "y is up then u is c2",
        "x is half then u is c3 weight 0.5",
    )
    text = INPUTS.replace("input y", "  half = function(0.5)\ninput y")
    head = f"system s\ndefuzzifier weighted_sum\nactivation {activation}\n"
    found = loads(f"{head}{text}{terms}{rules(*lines)}\n")(x=point[0], y=point[1])
    assert found == pytest.approx(sum(a * 10**k for k, a in enumerate(acting)), rel=1e-12)


def test_degrees_are_those_of_any_term_with_its_height():
    text = "input x in [0, 1]\n  f = function(sign(x))\n  s = s_shape(0, 1, height=0.5)\n"
    text += "output u in [0, 1] else nan\n  k = linear(1, 0)\nif x is f then u is k\n"
    own = loads(f"system s\ndefuzzifier weighted_average\n{text}")
    x, u = own.inputs[0], own.outputs[0]
    assert degrees(own, x, x.term("f"), [-1.0, 0.0, 0.5]).tolist() == [0.0, 0.0, 1.0]
    assert degrees(own, x, x.term("s"), [0.0, 0.5, 1.0]).tolist() == [0.0, 0.25, 0.5]
    assert degrees(own, u, u.terms[0], [0.0]) is None
