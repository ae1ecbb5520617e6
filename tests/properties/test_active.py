"""Averages over the rules that act alone and over all rules are the same function."""

import itertools

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fuzzyctl import ArgumentError, NoRuleFiresError, loads, output_bounds
from fuzzyctl import compile as compile_system
from fuzzyctl.kernels.algorithms.select import algorithm_of
from fuzzyctl.kernels.plan.build import plan
from tests.properties.around import points_around
from tests.sizes import examples


@st.composite
def axes(draw, name, most=5):
    """An input whose terms meet by two at most, as text, its terms and its corners; between terms there may be gaps."""
    count = draw(st.integers(1, most))
    lines, corners, at = [], [], draw(st.integers(-20, 20)) / 4
    foot = at
    for k in range(count):
        top = max(at, foot) + draw(st.sampled_from([0.25, 1.0, 3.0]))
        end = top + draw(st.sampled_from([0.0, 0.5]))
        # The next term begins on this one's falling side, at its top or beyond its foot.
        falls = end + draw(st.sampled_from([0.5, 2.0]))
        left = "-inf" if k == 0 and draw(st.booleans()) else foot
        right = "inf" if k == count - 1 and draw(st.booleans()) else falls
        height = draw(st.sampled_from(["", "", ", height=0.75"]))
        lines.append(f"  T{k} = trapezoid({left}, {top}, {end}, {right}{height})")
        corners += [foot, top, end, falls]
        foot, at = draw(st.sampled_from([end, end, falls + 0.25])), falls
    ends = (
        corners[0] + draw(st.sampled_from([-1.0, 0.0, 0.125])),
        corners[-1] + draw(st.sampled_from([-0.125, 0.0, 1.0])),
    )
    head = f"input {name} in [{ends[0]}, {ends[1]}]{draw(st.sampled_from(['', ' extrapolate']))}"
    return [head, *lines], [f"T{k}" for k in range(count)], [*corners, *ends]


@st.composite
def systems(draw, otherwise=(" else -3", " else nan", " else midpoint", " else error")):
    """A table over one to three inputs with some rules missing, some twice and some weighted, and its corners."""
    norm = draw(st.sampled_from(["min", "product"]))
    lines, terms, knots = ["system s", f"and {norm}", "defuzzifier weighted_average"], [], []
    inputs = draw(st.integers(1, 3))
    for i in range(inputs):
        text, names, corners = draw(axes(f"x{i}", 5 if inputs < 3 else 2))
        lines += text
        terms.append(names)
        knots.append(corners)
    bounded = not any("extrapolate" in line for line in lines)
    for name in draw(st.sampled_from([["u"], ["u", "v"]])):
        lines.append(f"output {name} in [-10, 10]{draw(st.sampled_from(otherwise))}")
        factors = st.sampled_from([-1.5, 0.0, 0.5, 2.0])
        for k in range(4):
            own = [draw(factors) for _ in range(inputs + 1)]
            linear = bounded and draw(st.booleans())
            lines.append(
                f"  c{k} = linear({', '.join(map(str, own))})" if linear else f"  c{k} = constant({own[0] * 4})"
            )
        left = False
        for combination in itertools.product(*terms):
            parts = [f"{n} is {t}" for n, t in zip([f"x{i}" for i in range(inputs)], combination, strict=True)]
            for _ in range(draw(st.sampled_from([0, 1, 1, 1, 1, 2])) or int(not left)):
                weight, left = draw(st.sampled_from(["", "", " weight 0.5", " weight 0"])), True
                lines.append(f"if {' and '.join(parts)} then {name} is c{draw(st.integers(0, 3))}{weight}")
    return "\n".join(lines), knots


def points_of(knots, seed):
    """Points around corners; a weight of half makes nothing of 5e-324, and two such rules together something."""
    points = points_around(knots, seed)
    return np.where(np.abs(points) < 1e-300, 0.0, points)


def outcome(kernel, points):
    """Return the results, or the message that no rule fires somewhere."""
    try:
        return kernel.batch(points)
    except NoRuleFiresError as error:
        return str(error)


def agree(system, backend, points):
    """Compare with all rules: sums of at most 125 products of numbers below 100 in magnitude."""
    # Backends differ in which of several errors they tell first.
    interpreter = "python" if backend == "numba" else backend
    expected = outcome(compile_system(system, interpreter, algorithm="rules"), points)
    found = outcome(compile_system(system, backend, algorithm="active"), points)
    if isinstance(expected, str) or isinstance(found, str):
        assert found == expected
    else:
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12 * 100)
    return found


@settings(max_examples=examples(30), deadline=None, suppress_health_check=list(HealthCheck))
@given(case=systems(), seed=st.integers(0, 1000))
@pytest.mark.parametrize("backend", ["python", "numpy"])
def test_rules_that_act_are_all_rules(backend, case, seed):
    text, knots = case
    system = loads(text)
    points = points_of(knots, seed)
    found = agree(system, backend, points)
    if isinstance(found, str):
        return
    bounds = output_bounds(system)
    for column, output in zip(found.reshape(len(points), -1).T, system.outputs, strict=True):
        known = column[~np.isnan(column)]
        assert all(bounds[output.name].lo <= known)
        assert all(known <= bounds[output.name].hi)


@settings(max_examples=examples(5, 1), deadline=None, suppress_health_check=list(HealthCheck))
@given(case=systems(otherwise=(" else -3", " else nan")), seed=st.integers(0, 1000))
def test_compiled_too(case, seed):
    text, knots = case
    system, points = loads(text), points_of(knots, seed)
    found = agree(system, "numba", points)
    kernel = compile_system(system, "numba", algorithm="active")
    for point, value in zip(points[:20].tolist(), found[:20], strict=True):
        np.testing.assert_allclose(np.atleast_1d(kernel(*point)), np.atleast_1d(value), rtol=1e-12, atol=1e-10)


def table(terms, settings="and min\ndefuzzifier weighted_average", rules="", width=1, terms_of_u="  terms c0 c1 c2 c3"):
    names = " ".join(f"t{k}" for k in range(terms))
    lines = ["system s", settings]
    for name in "xy":
        lines += [f"input {name} in [0, {width}]", f"  terms {names}"]
    lines += ["output u in [0, 3]", terms_of_u, "table u = x x y", f"  {names}"]
    for i in range(terms):
        lines.append(f"  t{i} | " + " ".join(f"c{(3 * i + 5 * j) % 4}" for j in range(terms)))
    return loads("\n".join([*lines, rules]))


class TestChoice:
    def test_is_for_tables_of_many_rules(self):
        assert algorithm_of(plan(table(3))).name == "active"
        assert "4 of 9 rules at a time" in algorithm_of(plan(table(3))).reason
        assert algorithm_of(plan(table(2))).name == "rules"
        assert algorithm_of(plan(table(2)), "active").name == "active"

    def test_is_interpolation_where_there_is_nothing_to_choose(self):
        assert algorithm_of(plan(table(5, "and product\ndefuzzifier weighted_average"))).name == "interpolation"

    @pytest.mark.parametrize(
        ("system", "reason"),
        [
            (table(5, "and min\ndefuzzifier bisector"), "'u' is no average over rules"),
            (table(5, "and bounded_difference\ndefuzzifier weighted_average"), "rules are no conjunctions"),
            (table(5, "and min\nactivation first(count=1)\ndefuzzifier weighted_average"), "not every rule acts"),
            (table(5, "and min\ndefuzzifier weighted_sum"), "'u' is no average over rules"),
            (table(5, rules="if x is t0 then u is c1\n"), "rules are no conjunctions"),
            (table(5, rules="if x is t0 or y is t0 then u is c1\n"), "rules are no conjunctions"),
            (table(5, rules="if x is not t0 and y is t0 then u is c1\n"), "rules are no conjunctions"),
        ],
        ids=range(7),
    )
    def test_is_all_rules_for_others(self, system, reason):
        assert algorithm_of(plan(system)).name == "rules"
        with pytest.raises(ArgumentError, match=f"not looked up: {reason}"):
            compile_system(system, "python", algorithm="active")

    def test_is_all_rules_where_three_terms_meet(self):
        text = "\n".join(f"  t{k} = triangle({k - 2}, {k}, {k + 2})" for k in range(5))
        rules = "\n".join(f"if x is t{i} then u is c{i % 2}" for i in range(5))
        head = "system s\ndefuzzifier weighted_average\ninput x in [0, 4]\n"
        system = loads(f"{head}{text}\noutput u in [0, 1] else 0\n  c0 = constant(0)\n  c1 = constant(1)\n{rules}\n")
        with pytest.raises(ArgumentError, match=r"more than two terms of 'x' meet between 0\.0 and 1\.0"):
            compile_system(system, "python", algorithm="active")


CORNERS = """
system s
and {norm}
defuzzifier weighted_average
input x in [0, 1]
  T0 = {first}
  T1 = {second}
  T2 = {third}
input y in [0, 1]
  terms T0 T1 T2
output u in [0, 9] else 9
  a = constant(1)
  b = constant(2)
  c = constant(4)
table u = x x y
     T0 T1 T2
  T0 | a b c
  T1 | {cells}
  T2 | c a b
"""
#: What 3 · 0.1 is in floating point: larger than 0.3, from which it differs by rounding.
ABOVE = 0.30000000000000004


class TestCornersThatDifferByRounding:
    """They count as one knot, where a degree of 1e-16 must not decide which rules act."""

    def compare(self, algorithm, first, second, third, norm="min", cells="b c a"):
        system = loads(CORNERS.format(first=first, second=second, third=third, norm=norm, cells=cells))
        assert algorithm_of(plan(system)).name == algorithm
        points = np.array([*itertools.product([0.0, 0.1, 0.25, 0.3, ABOVE, 0.4, 0.6, 0.9, 1.0], [0.0, 0.2, 0.75, 1.0])])
        expected = compile_system(system, "python", algorithm="rules").batch(points)
        for backend in ("python", "numpy"):
            np.testing.assert_allclose(compile_system(system, backend).batch(points), expected, rtol=1e-12)
        return expected

    def test_partitions_are_looked_up(self):
        self.compare("active", f"triangle(-inf, 0, {ABOVE})", "triangle(0, 0.3, 1)", "triangle(0.3, 1, inf)")

    def test_gaps_behind_them_are_gaps(self):
        terms = f"triangle(-inf, 0, {ABOVE})", "trapezoid(0, 0.1, 0.2, 0.3)", "triangle(0.8, 0.9, 1)"
        assert 9.0 in self.compare("rules", *terms)

    def test_missing_rules_behind_them_are_missing(self):
        terms = f"triangle(-inf, 0, {ABOVE})", "triangle(0, 0.3, 1)", "triangle(0.3, 1, inf)"
        self.compare("rules", *terms, cells="b c .")

    @pytest.mark.parametrize(("norm", "algorithm"), [("min", "rules"), ("product", "active")])
    def test_beside_a_gap_of_another_input_minima_are_as_small_as_they_are(self, norm, algorithm):
        """One float beside the gap T0 is 1e-16 there, and so is the part of x that the corners are off by."""
        terms = f"triangle(-inf, 0, {ABOVE})", "triangle(0, 0.3, 1)", "triangle(0.3, 1, inf)"
        text = CORNERS.format(first=terms[0], second=terms[1], third=terms[2], norm=norm, cells="b c a")
        text = text.replace(
            "  terms T0 T1 T2\n",
            "  T0 = triangle(-inf, 0, 0.5)\n  T1 = triangle(0.5, 0.7, 0.9)\n  T2 = triangle(0.8, 1, inf)\n",
        )
        system, beside = loads(text), np.nextafter(0.5, 0.0)
        assert algorithm_of(plan(system)).name == algorithm
        points = np.array([*itertools.product([0.0, 0.1, 0.3, ABOVE, 0.4], [0.2, beside, 0.5, np.nextafter(0.5, 1.0)])])
        expected = [compile_system(system, "python", algorithm="rules")(*p) for p in points.tolist()]
        found = [compile_system(system, "python", algorithm=algorithm)(*p) for p in points.tolist()]
        np.testing.assert_allclose(found, expected, rtol=1e-12)


@pytest.mark.parametrize("settings", ["and min", "and product"])
@pytest.mark.parametrize("width", [1e-310, 1e-200, 1e150])
def test_ranges_may_be_as_small_or_large_as_numbers(settings, width):
    system = table(4, f"{settings}\ndefuzzifier weighted_average", width=width)
    points = np.array([*itertools.product([0.0, 0.3, 0.5, 0.75, 1.0], repeat=2)]) * width
    expected = compile_system(table(4, f"{settings}\ndefuzzifier weighted_average"), "python").batch(points / width)
    for backend in ("python", "numpy"):
        np.testing.assert_allclose(compile_system(system, backend).batch(points), expected, rtol=1e-12)


NUMBERS = """
system s
and min
defuzzifier weighted_average
input x in [0, {width}]
  low  = triangle(-inf, 0, {foot}, height={low})
  high = trapezoid(-inf, 0, {width}, inf, height={height})
output u in [-10, 10] else -10
  a = constant({first})
  b = constant({second})
if x is low then u is a
if x is high then u is b
if x is high then u is b
"""


@pytest.mark.parametrize(
    ("algorithm", "numbers"),
    [
        # At the end both terms are 1e-16, and what is made of them is no rounding error.
        ("active", {"width": 0.7, "foot": 0.7000000000000001, "height": 1e-16}),
        # Slopes that have only some digits, or none.
        ("rules", {"width": 3e300, "foot": 3e300, "height": 1e-20, "low": 1e-20}),
        # Consequents that are no numbers together are some where one rule acts a little.
        ("rules", {"width": 3, "foot": 3, "height": 1e-20, "second": 1.2e308}),
    ],
    ids=["small degrees", "flat sides", "large consequents"],
)
def test_numbers_may_be_as_small_or_large_as_there_are(algorithm, numbers):
    system = loads(NUMBERS.format(**{"first": 1, "second": -2, "low": 1} | numbers))
    points = np.array([[share * numbers["width"]] for share in (0.0, 0.3, 0.7, 1.0)])
    expected = compile_system(system, "python", algorithm="rules").batch(points)
    for backend in ("python", "numpy"):
        np.testing.assert_allclose(compile_system(system, backend).batch(points), expected, rtol=1e-12)
    if algorithm == "active":
        found = compile_system(system, "python", algorithm="active").batch(points)
        np.testing.assert_allclose(found, expected, rtol=1e-12)
    else:
        with pytest.raises(ArgumentError, match="not looked up"):
            compile_system(system, "python", algorithm="active")
