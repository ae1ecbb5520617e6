"""What generated Python does otherwise than compiled code: calls without detours."""

import math

import numpy as np
import pytest

from fuzzyctl import loads
from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.kernels.compile import Kernel
from fuzzyctl.kernels.compile import compile as compile_system

MIN = """
system s
and {conjunction}
defuzzifier weighted_average
input x in [0, 10]
  terms a b c d
input y in [-1, 1]
  low = trapezoid(-inf, -1, -0.5, 0.5)
  mid = triangle(-0.5, 0.5, 0.75)
  high = trapezoid(0.5, 0.75, 0.9, inf)
output u in [0, 1] else 0.125
  terms p q r
if x is a and y is low then u is p
if x is b and not y is mid then u is q
if x is c or y is high then u is r
if x is d and y is mid then u is p
if x is a and y is mid then u is q
if x is d and y is low then u is r
"""


@pytest.fixture(scope="module")
def kernel():
    return compile_system(loads(MIN.format(conjunction="min")), "python")


def points():
    corners = [0, 10 / 3, 20 / 3, 10, -1, -0.5, 0.5, 0.75, 0.9]
    near = [f(c, s) for c in corners for f, s in ((math.nextafter, math.inf), (math.nextafter, -math.inf))]
    values = np.array([*corners, *near, *np.linspace(-2, 12, 60), math.inf, -math.inf, 0.0, -0.0])
    rng = np.random.default_rng(3)
    return np.stack([rng.choice(values, 4000), rng.choice(values, 4000)], axis=1)


class TestNumbers:
    def test_are_those_of_compiled_code(self, kernel):
        plain = compile_system(loads(MIN.format(conjunction="min")), "numba").jit
        for x, y in points().tolist():
            assert kernel(x, y) == pytest.approx(plain(x, y), rel=1e-14), (x, y)

    def test_of_nan_are_nan(self, kernel):
        assert math.isnan(kernel(math.nan, 0.0))
        assert math.isnan(kernel(1.0, math.nan))

    def test_of_cells_are_those_of_the_rules(self):
        table = "table u = x x y\n     low  mid  high\n  a | p q r\n  b | q r p\n  c | r p q\n  d | p r q\n"
        system = loads(MIN.format(conjunction="product").partition("if ")[0] + table)
        kernel = compile_system(system, "python")
        assert kernel.algorithm.name == "interpolation"
        rules = compile_system(system, "python", algorithm="rules")
        for x, y in points().tolist():
            assert kernel(x, y) == pytest.approx(rules(x, y), abs=1e-13)


class TestCalls:
    @pytest.mark.parametrize("backend", ["python", "numba"])
    @pytest.mark.parametrize("count", [1, 2, 3, 4])
    def test_of_every_number_of_inputs(self, backend, count):
        inputs = "\n".join(f"input x{i} in [0, 1]\n  terms a b" for i in range(count))
        rules = "\n".join(f"if x{i} is a then u is lo\nif x{i} is b then u is hi" for i in range(count))
        text = f"system s\ndefuzzifier weighted_average\n{inputs}\noutput u in [0, 1]\n  terms lo=0 hi=1\n{rules}\n"
        kernel = compile_system(loads(text), backend)
        assert isinstance(kernel, Kernel)
        assert repr(kernel).startswith("Kernel(x0")
        assert kernel(*[0.25] * count) == pytest.approx(0.25)
        for wrong in (count - 1, count + 1):
            with pytest.raises(ArgumentError, match=f"takes {count} arguments .*, got {wrong}"):
                kernel(*[0.5] * wrong)
        with pytest.raises(ArgumentError, match="real number"):
            kernel(*["a"] * count)
        assert math.isnan(kernel(*[math.nan] * count))

    def test_take_every_kind_of_real_number(self, kernel):
        from fractions import Fraction

        expected = kernel(2.5, 0.5)
        for x, y in ((Fraction(5, 2), 0.5), (np.float32(2.5), np.float64(0.5)), (np.array(2.5), np.array(0.5))):
            assert kernel(x, y) == expected
            assert type(kernel(x, y)) is float


SQUARE = """
system s
and {conjunction}
implication min
aggregation max
defuzzifier centroid
input x in [-1, 1]
  terms a b c d
input y in [-1, 1]
  terms a b c d
output u in [-1, 1]
  terms p q r
table u = x x y
      a b c d
  a | p p q r
  b | p q r r
  c | q q r p
  d | r q q p
"""


class TestSets:
    @pytest.mark.parametrize("conjunction", ["min", "product"])
    def test_joined_by_the_maximum_have_the_centroid_of_compiled_code(self, conjunction):
        system = loads(SQUARE.format(conjunction=conjunction))
        python, plain = (compile_system(system, b, algorithm="rules") for b in ("python", "numba"))
        for x, y in points().tolist():
            assert python(x, y) == pytest.approx(plain(x, y), rel=1e-12, abs=1e-13), (x, y)


def test_long_sums_are_not_nested_deeper_than_python_reads():
    rules = "".join(f"if x{i} is a then u is linear({'0, ' * 150}{i})\n" for i in range(150))
    inputs = "".join(f"input x{i} in [0, 1]\n  terms a b\n" for i in range(150))
    system = loads(f"system s\ndefuzzifier weighted_average\n{inputs}output u in [0, 200] else 0\n{rules}")
    assert compile_system(system, "python")(*[0.0] * 150) == pytest.approx(74.5)
