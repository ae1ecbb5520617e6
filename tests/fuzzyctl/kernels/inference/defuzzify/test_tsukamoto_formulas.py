"""Tsukamoto's method with consequents that are formulas of the output."""

import math

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import DiagnosticError
from fuzzyctl.expr import Name, evaluate
from fuzzyctl.formulas.inverse import solved

BACKENDS = ("python", "numpy", "numba")

TEXT = """
param c = 4
system z
defuzzifier tsukamoto
input e in [-1, 1]
  terms N P
output y in [0, 1]
  small = {small}
  big   = function(-1/c * log(1 - y))
if e is N then y is small
if e is P then y is big
"""
ZHAO = TEXT.format(small="function(-log(y) / c)")


@pytest.mark.parametrize("backend", BACKENDS)
def test_logarithmic_consequents_of_zhao_tomizuka_isaka(backend):
    system = fuzzyctl.loads(ZHAO)
    e = np.linspace(-1, 1, 201)
    n, p = (1 - e) / 2, (1 + e) / 2
    expected = n * np.exp(-4 * n) + p * (1 - np.exp(-4 * p))
    found = fuzzyctl.compile(system, backend).batch(e[:, None])
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-15)
    bound = fuzzyctl.output_bounds(system)["y"]
    assert (bound.lo, bound.hi) == (0.0, 1.0)


@pytest.mark.parametrize(
    "text", ["function(y * y)", "function(y + y)", "function(1 / y)", "function(sin(y))", "function(0 * y + 0.5)"]
)
def test_others_are_refused(text):
    with pytest.raises(DiagnosticError) as caught:
        fuzzyctl.loads(TEXT.format(small=text))
    (found,) = caught.value.diagnostics
    assert (found.code, found.message) == (
        "FZ214",
        "term 'small' of 'y' is a formula whose inverse 'tsukamoto' does not know",
    )
    assert "exp, log and sqrt" in found.help


@pytest.mark.parametrize(
    ("text", "degree"),
    [
        ("function(exp(-2 * y))", lambda y: math.exp(-2 * y)),
        ("function(sqrt(y / 3) * 2 - 0.25)", lambda y: math.sqrt(y / 3) * 2 - 0.25),
        ("function(1 - (0.5 + y) / 2)", lambda y: 1 - (0.5 + y) / 2),
        ("function(-(log(2 - y) - 1))", lambda y: -(math.log(2 - y) - 1)),
    ],
)
def test_the_place_has_the_degree(text, degree):
    system = fuzzyctl.loads(TEXT.format(small=text))
    (term, _) = system.outputs[0].terms
    for w in (0.35, 0.5, 0.6):
        place = solved(term.membership.arguments[0], "y", Name("w"))
        y = evaluate(_plain(place), {"w": w})
        assert degree(y) == pytest.approx(w, rel=1e-12)


def _plain(place):
    """Return an inverse in words that the evaluator of params knows."""
    from fuzzyctl.expr import Call, replace

    def change(node):
        match node:
            case Call(function="divide", arguments=(a, b)):
                return a / b
            case Call(function="larger", arguments=arguments):
                return Call("max", arguments)
        return node

    return replace(place, change)
