"""Terms of many corners stand in tables: the same numbers, and programs whose size a compiler bears."""

import math

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import loads
from fuzzyctl.expr import Name, walk
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.kernels.algorithms.select import COMPILED, algorithm_of
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.program.program import Locate, Quadrature
from fuzzyctl.kernels.program.scalar import compile_source, evaluation_source, scalar_function
from fuzzyctl.kernels.program.traversal import parts

#: Places and degrees of a curve, with a flat part.
CURVE = [(0.1 * k + 1.0, round(math.exp(-((0.1 * k - 4.0) ** 2)), 6) if k % 7 else 0.25) for k in range(101)]
#: The same with jumps, one at the first place: upwards, downwards, and to a single higher place.
JUMPS = [(1.0, 0.0), (1.0, 0.5), *CURVE[1:50], (5.95, 0.1), (5.95, 0.9), (5.95, 0.2), *CURVE[50:], (11.0, 0.0)]


def points(corners):
    return f"piecewise({', '.join(f'{x!r}, {y!r}' for x, y in corners)})"


def system(terms, outputs=("constant(1)",), method="defuzzifier weighted_sum"):
    """Return a system with these terms of its input; each sets a term of its output."""
    lines = ["system s", method, "input a in [0, 12]"]
    lines += [f"  t{k} = {term}" for k, term in enumerate(terms)]
    lines += ["output c in [0, 12] else nan", *(f"  u{k} = {term}" for k, term in enumerate(outputs))]
    lines += [f"if a is t{k} then c is u{k % len(outputs)}" for k in range(len(terms))]
    return loads("\n".join(lines) + "\n")


def shifted(count, by=0.001):
    return [points([(round(x + by * k, 6), y) for x, y in CURVE]) for k in range(count)]


def nodes(program):
    return sum(1 for s in program.body if not isinstance(s, Quadrature) for e in parts(s).values for _ in walk(e))


PLACES = [0.0, 1.0, 5.95, 11.0, 12.0, *(x for x, _ in CURVE), *(float(x) for x in np.linspace(0, 12, 500))]


@pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
@pytest.mark.parametrize("corners", [CURVE, JUMPS, CURVE[::-1]], ids=["curve", "jumps", "reversed"])
def test_degrees_are_those_of_the_formula_to_the_last_bit(backend, corners):
    corners = corners if corners[0][0] < corners[-1][0] else [(12.0 - x, y) for x, y in corners]
    kernel = fuzzyctl.compile(system([points(corners)]), backend=backend)
    formula = scalar_function(MEMBERSHIP["piecewise"].degree(Name("x"), tuple(v for c in corners for v in c)))
    due = np.array([formula(x) or math.nan for x in PLACES])  # nothing fires where the degree is 0
    np.testing.assert_array_equal([kernel(x) for x in PLACES], due)
    np.testing.assert_array_equal(kernel.batch(np.array(PLACES)[:, None]).ravel(), due)
    assert math.isnan(kernel(math.nan))


def test_heights_and_hedges_count():
    few = "triangle(1, 6, 11)"
    many = points([(1.0 + 0.125 * k, min(k, 80 - k) / 40) for k in range(81)])
    by_table, by_choice = (fuzzyctl.compile(system([f"{t[:-1]}, height=0.75)"]), backend="python") for t in (many, few))
    assert [by_table(x) for x in PLACES[:100]] == pytest.approx([by_choice(x) for x in PLACES[:100]], nan_ok=True)


def test_fifty_terms_make_a_program_that_is_read_at_once():
    flat = plan(system(shifted(50)))
    program = algorithm_of(flat, "rules").point
    assert sum(isinstance(s, Locate) for s in program.body) == 50
    assert nodes(program) < 5000  # 50,000 choices took a compiler minutes
    same = algorithm_of(plan(system(shifted(50, by=0.0))), "rules").point
    assert sum(isinstance(s, Locate) for s in same.body) == 1


def test_analyses_and_other_languages_have_neither_tables_nor_integrals():
    algorithm = algorithm_of(plan(system(shifted(2), shifted(2), "and min")))
    for program in (inference.evaluation(algorithm.plan), algorithm.printed):
        assert not any(isinstance(s, Locate | Quadrature) for s in program.body)


@pytest.mark.parametrize(("aggregation", "terms"), [("max", 3), pytest.param("sum", 4, marks=pytest.mark.long)])
def test_an_exact_centroid_of_many_corners_is_an_integral_with_the_same_value(aggregation, terms):
    flat = plan(system(shifted(terms), shifted(terms), f"aggregation {aggregation}"))
    integrated = inference.evaluation(flat, most_pairs=COMPILED)
    written = inference.evaluation(flat, most_pairs=1_000_000)
    assert [sum(isinstance(s, Quadrature) for s in p.body) for p in (integrated, written)] == [1, 0]
    one, other = (compile_source(evaluation_source(p), p, ["a"]) for p in (integrated, written))
    for x in (0.5, 2.0, 5.0, 6.3):
        assert np.ravel(one(x)) == pytest.approx(np.ravel(other(x)), rel=1e-12)


def test_small_centroids_stay_written_out():
    own = system(["triangle(0, 4, 8)"] * 8, [f"triangle({k}, {k + 1}, {k + 2})" for k in range(8)], "and min")
    program = algorithm_of(plan(own), "rules").point
    assert not any(isinstance(s, Locate | Quadrature) for s in program.body)


def test_the_size_of_a_program_does_not_grow_with_the_corners():
    text = points([(0.0001 * k, (k % 100) / 100) for k in range(5_000)])
    program = algorithm_of(plan(system([text])), "rules").point
    assert nodes(program) < 100


@pytest.mark.parametrize("defuzzifier", ["bisector", "centroid"])
def test_tables_are_read_inside_of_integrals_of_arrays_too(defuzzifier):
    # Beside a curve a set has no closed form.
    method = f"and min\nimplication product\naggregation sum\ndefuzzifier {defuzzifier}"
    own = system(["ramp(0, 12)", "ramp(12, 0)"], [*shifted(1), "gaussian(6, 2)"], method)
    one, other = (fuzzyctl.compile(own, backend=backend) for backend in ("numpy", "python"))
    found = one.batch(np.array([[3.0], [9.0]])).ravel()
    assert list(found) == pytest.approx([other(3.0), other(9.0)], rel=1e-9)
