"""Rule bases as large as the language takes: no expression of theirs may be nested as deeply as they are long."""

import math

import numpy as np
import pytest

from fuzzyctl import And, DiagnosticError, Is, Not, loads
from fuzzyctl import compile as compile_system
from fuzzyctl.analysis.coverage.coverage import uncovered
from fuzzyctl.expr import Name
from tests.sizes import examples

BACKENDS = ("python", "numpy")


def terms(count):
    return " ".join(f"T{i}" for i in range(count))


def one_way(count, head="defuzzifier weighted_average", consequents="", output="in [-2, 2]"):
    own = " ".join(f"T{i}={math.sin(i)!r}" for i in range(count))
    return loads(
        f"system s\n{head}\ninput x in [0, 1]\n  terms {terms(count)}\n"
        f"output u {output}\n  {consequents or 'terms ' + own}\n"
        f"table u = x\n  {terms(count)}\n  | {terms(count)}\n"
    )


def two_way(count, head, consequents, output="in [-2, 2]"):
    rows = "\n".join(f"  T{i} | {' '.join(f'T{i * j % count}' for j in range(count))}" for i in range(count))
    return loads(
        f"system s\n{head}\ninput x in [0, 1]\n  terms {terms(count)}\ninput y in [0, 1]\n  terms {terms(count)}\n"
        f"output u {output}\n  terms {consequents(count)}\ntable u = x x y\n  {terms(count)}\n{rows}\n"
    )


def peaks(count):
    return " ".join(f"T{i}={i / count!r}" for i in range(count))


def check(system, backends=BACKENDS, *, state=None, points=None):
    """Return the values, the same bit for bit on all backends."""
    points = np.linspace(0, 1, 7)[:, None] * np.ones(len(system.inputs)) if points is None else points
    results = [compile_system(system, b).batch(points, state) for b in backends]
    for result in results[1:]:
        np.testing.assert_array_equal(result, results[0])
    assert np.isfinite(results[0]).all()
    return results[0]


class TestLargeRuleBases:
    @pytest.mark.parametrize("count", [300, pytest.param(900, marks=pytest.mark.long)])
    def test_one_way_averages_of_distinct_consequents(self, count):
        found = check(one_way(count), points=np.array([[0.0], [1.0]]))
        np.testing.assert_allclose(found, [math.sin(0), math.sin(count - 1)], atol=1e-15)

    @pytest.mark.parametrize(
        "method",
        [
            "proportional",
            "highest(count=2)",
            *(
                pytest.param(m, marks=pytest.mark.long)
                for m in ("threshold(>= 0.1)", "first(count=2)", "lowest(count=2)")
            ),
        ],
    )
    def test_activation_methods(self, method):
        count = examples(300, 210)  # Python reads 200 levels of parentheses
        check(one_way(count, f"defuzzifier weighted_average\nactivation {method}"), points=np.array([[0.3001]]))

    @pytest.mark.parametrize(
        "head",
        [
            "defuzzifier weighted_average",
            pytest.param("defuzzifier center_average", marks=pytest.mark.long),
            "and product\ndefuzzifier weighted_sum",
            pytest.param("defuzzifier centroid(resolution=50)\naggregation sum", marks=pytest.mark.long),
            "defuzzifier centroid(resolution=50)",
        ],
    )
    def test_tables_of_30_by_30(self, head):
        shapes = (lambda n: terms(n)) if "centroid" in head or "center" in head else peaks
        check(two_way(30, head, shapes))

    def test_adaptive_tables_of_30_by_30(self):
        system = two_way(30, "defuzzifier weighted_average", peaks, "in [-2, 2] adaptive rate x")
        state = np.random.default_rng(1).uniform(-1, 1, 900)
        check(system, state=state)
        kernel = compile_system(system, "python")
        xi, rates = np.empty(900), np.empty(900)
        kernel.jit_strengths(0.3, 0.7, xi)
        kernel.jit_rates(0.3, 0.7, state, rates)
        assert xi.sum() == pytest.approx(1)
        np.testing.assert_allclose(rates, 0.3 * xi)

    @pytest.mark.parametrize(
        "head",
        [
            pytest.param("and product\nimplication product\naggregation sum", marks=pytest.mark.long),
            "aggregation sum",
        ],
    )
    def test_exact_centroids_of_150_terms(self, head):
        check(one_way(150, f"{head}\ndefuzzifier centroid", f"terms {terms(150)}"), points=np.array([[0.7003]]))


def _sum(value, names):
    return names[value.name] if isinstance(value, Name) else _sum(value.left, names) + _sum(value.right, names)


SMALL = """
system s
and {norm}
defuzzifier weighted_average
input x in [0, 1]
  a = triangle(-inf, 0, inf)
output u in [0, 1]
  b = singleton(1)
if x is a then u is b
"""


class TestLongAntecedents:
    @pytest.mark.parametrize("norm", ["min", "hamacher_product"])
    def test_built_ones_are_evaluated(self, norm):
        system = loads(SMALL.format(norm=norm))
        long = And(operands=tuple(Is(variable="x", term="a") for _ in range(900)))
        rule = system.rules[0].model_copy(update={"antecedent": long})
        system = system.model_copy(update={"blocks": (rule,)})
        check(system)
        assert uncovered(system) == {"u": None}

    def test_nested_ones_are_refused_by_name(self):
        system = loads(SMALL.format(norm="min"))
        nested = Is(variable="x", term="T0")
        for _ in range(150):
            nested = Not(operand=nested)
        rule = system.rules[0].model_copy(update={"antecedent": nested})
        with pytest.raises(DiagnosticError, match="FZ106"):
            compile_system(system.model_copy(update={"blocks": (rule,)}), "python")


def test_long_sums_are_not_nested_deeper_than_python_reads():
    rules = "".join(f"if x{i} is a then u is linear({'0, ' * 150}{i})\n" for i in range(150))
    inputs = "".join(f"input x{i} in [0, 1]\n  terms a b\n" for i in range(150))
    system = loads(f"system s\ndefuzzifier weighted_average\n{inputs}output u in [0, 200] else 0\n{rules}")
    assert compile_system(system, "python")(*[0.0] * 150) == pytest.approx(74.5)
