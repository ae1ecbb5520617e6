"""Sums over the rules of a table, with the degrees of its rows taken out."""

import itertools
import re

import numpy as np
import pytest

from fuzzyctl import loads
from fuzzyctl.expr import Binary, walk
from fuzzyctl.kernels.compile import compile as compile_system
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.program.passes.factor import factored
from fuzzyctl.kernels.program.program import Assign, Program

TERMS = "NSZBP"


def table(terms: int, inputs: int = 2, *, weights: bool = False, shared: bool = False) -> str:
    """Return a first-order system over all combinations of Gaussian terms."""
    names = TERMS[:terms]
    rows = list(itertools.product(names, repeat=inputs))
    lines = ["system s", "and product", "defuzzifier weighted_average"]
    for i in range(inputs):
        lines += [f"input x{i} in [-2, 2]", *(f"  {n} = gaussian({k - terms / 2}, 0.7)" for k, n in enumerate(names))]
    lines.append("output u in [-50, 50]")
    count = 3 if shared else len(rows)
    factors = [", ".join(str((k * 7 + i * 3) % 131 / 10 - 5.5) for i in range(inputs + 1)) for k in range(count)]
    lines += [f"  c{k} = linear({f})" for k, f in enumerate(factors)]
    for k, row in enumerate(rows):
        weight = f" weight {0.25 + (k % 3) / 4}" if weights else ""
        conditions = " and ".join(f"x{i} is {n}" for i, n in enumerate(row))
        lines.append(f"if {conditions} then u is c{k % count}{weight}")
    return "\n".join(lines) + "\n"


def program(text: str) -> Program:
    return inference.evaluation(plan(loads(text)))


def steps(of: Program) -> int:
    """Count the operations of arithmetic of a program."""
    return sum(isinstance(n, Binary) for s in of.body if isinstance(s, Assign) for n in walk(s.value))


@pytest.mark.parametrize(
    "text",
    [table(3), table(5), table(2, 3), table(3, 3), table(3, weights=True), table(5, 3, weights=True)],
    ids=["3x3", "5x5", "2x2x2", "3x3x3", "weights", "5x5x5 weights"],
)
def test_gives_the_same_numbers_with_fewer_products(text):
    plain = program(text)
    fewer = factored(plain)
    assert steps(fewer) < steps(plain)
    system = loads(text)
    points = np.random.default_rng(4).uniform(-3, 3, (300, len(system.inputs)))
    python = compile_system(system, "python")
    found = [python(*p) for p in points.tolist()]
    # Sums of at most 125 products of numbers below 25 in magnitude, divided by the sum of their weights.
    assert found == pytest.approx(compile_system(system, "numpy").batch(points), rel=0, abs=25 * 500 * 2**-53)


def test_the_sum_of_all_strengths_is_a_product():
    source = compile_system(loads(table(3)), "python").source
    assert "(((v4 + v6) + v8) * ((v10 + v12) + v14))" in source


def test_a_row_is_multiplied_once():
    """Nine products of degrees, and seven of their sums with degrees, become three of rows and one of sums."""
    plain = program(table(3))
    assert steps(factored(plain)) == steps(plain) - (9 + 9 + 8 + 8) + (9 + 6) + (3 + 2) + (2 + 2 + 1)


def test_strengths_that_are_needed_elsewhere_stay():
    text = table(3).replace("output u in [-50, 50]", "output w in [0, 1]\n  one = constant(1)\noutput u in [-50, 50]")
    text = text.replace("then u is c0", "then u is c0, w is one").replace("then u is c4", "then u is c4, w is one")
    system = loads(text)
    points = np.random.default_rng(5).uniform(-3, 3, (100, 2))
    python = compile_system(system, "python")
    found = np.array([python(*p) for p in points.tolist()])
    np.testing.assert_allclose(found, compile_system(system, "numpy").batch(points), rtol=0, atol=1e-12)


def test_consequents_near_the_largest_number_are_not_taken_apart():
    huge = [f"  c{k} = constant({sign}1e308)" for k, sign in enumerate(["", "-", "", "-"])]
    text = re.sub(r"  c0 .*\n(?:  c. .*\n)*", "\n".join(huge) + "\n", table(2))
    plain = program(text)
    assert factored(plain) is plain
    kernel = compile_system(loads(text.replace("0.7)", "0.01)")), "python")
    assert kernel(-1.0, -1.0) == 1e308


def test_infinite_inputs_and_nan_are_as_they_were():
    kernel = compile_system(loads(table(3)), "python")
    assert kernel(float("inf"), -float("inf")) == pytest.approx(kernel(2.0, -2.0), rel=1e-15)
    assert np.isnan(kernel(float("nan"), 0.0))
