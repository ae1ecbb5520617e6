"""Integration around the rules that act and the evaluation of all rules are the same function."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fuzzyctl import loads, output_bounds
from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.kernels.algorithms.select import algorithm_of
from fuzzyctl.kernels.compile import compile as compile_system
from fuzzyctl.kernels.plan.build import plan
from tests.properties.around import points_around
from tests.sizes import examples


def partition(peaks, *, shoulders):
    """Triangles with neighbours' peaks as feet, as text; the outer ones end in shoulders, or one step further."""
    ends = (-math.inf, math.inf) if shoulders else (2 * peaks[0] - peaks[1], 2 * peaks[-1] - peaks[-2])
    feet = [ends[0], *peaks, ends[1]]
    return [f"  T{k} = triangle({feet[k]}, {p}, {feet[k + 2]})" for k, p in enumerate(peaks)]


@st.composite
def axes(draw, name):
    """An input with an even or an uneven partition, as text, and its peaks."""
    count, lower = draw(st.integers(2, 7)), draw(st.integers(-20, 20)) / 4
    steps = draw(st.one_of(st.just([1.5] * (count - 1)), st.lists(st.integers(1, 8), min_size=count - 1, max_size=7)))
    peaks = list(itertools.accumulate(steps[: count - 1], initial=lower))
    shoulders = draw(st.booleans())
    room = draw(st.sampled_from([0.0, 1.0])) if shoulders else 0.0
    extrapolate = draw(st.sampled_from(["", " extrapolate"])) if shoulders else ""
    head = f"input {name} in [{peaks[0] - room}, {peaks[-1] + room}]{extrapolate}"
    return [head, *draw(st.permutations(partition(peaks, shoulders=shoulders)))], peaks


@st.composite
def outputs(draw, name):
    """An output with an even partition, as text, and the number of its terms."""
    count, lower = draw(st.integers(3, 9)), draw(st.integers(-20, 20)) / 4
    step = draw(st.sampled_from([0.125, 1 / 3, 2.0]))
    peaks = [lower + k * step for k in range(count)]
    below, above = (draw(st.sampled_from([0.0, step, 2.5 * step])) for _ in range(2))
    head = f"output {name} in [{peaks[0] - below}, {peaks[-1] + above}]"
    shoulders = not below and not above and draw(st.booleans())
    return [head, *draw(st.permutations(partition(peaks, shoulders=shoulders)))], count


@st.composite
def systems(draw):
    """A system of one or two tables whose consequents run along diagonals, and the peaks of its inputs."""
    lines = ["system s", "defuzzifier centroid"]
    knots = []
    for name in ("e", "de"):
        text, peaks = draw(axes(name))
        lines += text
        knots.append(peaks)
    tables = []
    for name in draw(st.sampled_from([["u"], ["u", "v"]])):
        text, count = draw(outputs(name))
        lines += text
        signs = draw(st.tuples(*[st.sampled_from([1, -1])] * 2))
        numbers = [[signs[0] * i + signs[1] * j for j in range(len(knots[1]))] for i in range(len(knots[0]))]
        # Somewhere in the middle, so that at least three terms are named, and often some beyond either end.
        offset = -sum(map(sum, numbers)) // (len(knots[0]) * len(knots[1])) + draw(st.integers(0, count - 1))
        held = [[min(max(n + offset, 0), count - 1) for n in row] for row in numbers]
        swapped = draw(st.booleans())
        tables.append(f"table {name} = de x e" if swapped else f"table {name} = e x de")
        rows = [list(column) for column in zip(*held, strict=True)] if swapped else held
        tables.append(" " + " ".join(f"T{j}" for j in range(len(rows[0]))))
        tables += [f"  T{i} | " + " ".join(f"T{n}" for n in row) for i, row in enumerate(rows)]
    return "\n".join([*lines, *tables]), knots


def agree(system, backend, points):
    """Compare with all rules: the heights of both are off by some ulp, and so is what is made of them, in steps."""
    expected = compile_system(system, "numpy", algorithm="rules").batch(points)
    found = compile_system(system, backend).batch(points)
    widths = np.array([system.number(o.upper) - system.number(o.lower) for o in system.outputs])
    ends = np.array([max(abs(system.number(o.upper)), abs(system.number(o.lower))) for o in system.outputs])
    off = np.abs(found - expected).reshape(len(points), -1)
    assert (off <= 1e-14 * widths + 4 * 2.0**-53 * ends).all()
    return found.reshape(len(points), -1)


@settings(max_examples=examples(40), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(case=systems(), seed=st.integers(0, 1000))
@pytest.mark.parametrize("backend", ["python", "numpy"])
def test_window_is_the_evaluation_of_all_rules(backend, case, seed):
    text, knots = case
    system = loads(text)
    named = [{c for row in t.cells for cell in row for c in cell.terms} for t in system.tables_and_rules]
    assert (algorithm_of(plan(system)).name == "diagonals") == all(len(n) >= 3 for n in named)
    found = agree(system, backend, points_around(knots, seed))
    for position, output in enumerate(system.outputs):
        bound = output_bounds(system)[output.name]
        assert bound.lo <= found[:, position].min()
        assert found[:, position].max() <= bound.hi


@settings(max_examples=examples(6, 2), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(case=systems(), seed=st.integers(0, 1000))
def test_compiled_window_too(case, seed):
    text, knots = case
    system, points = loads(text), points_around(knots, seed)
    found = agree(system, "numba", points)
    kernel = compile_system(system, "numba")
    for point, value in zip(points[:20].tolist(), found[:20], strict=True):
        np.testing.assert_allclose(np.atleast_1d(kernel(*point)), value, rtol=1e-13, atol=1e-14)


PD = """
system pd
{settings}
input e in [-1, 1]
  terms N Z P
input de in [-1, 1]
  terms N Z P
output u in [-1, 1]
{terms}
table u = e x de
     N  Z  P
  N | {cells}
  Z | NS Z  PS
  P | Z  PS PB
"""
EVEN = "  terms NB NS Z PS PB"


def pd(settings="defuzzifier centroid", terms=EVEN, cells="NB NS Z"):
    return loads(PD.format(settings=settings, terms=terms, cells=cells))


def test_a_table_of_diagonals_is_seen():
    assert algorithm_of(plan(pd())).name == "diagonals"
    assert "3 x 3 terms" in algorithm_of(plan(pd())).reason


@pytest.mark.parametrize(
    "changes",
    [
        {"settings": "defuzzifier bisector"},
        {"settings": "defuzzifier centroid(resolution=100)"},
        {"settings": "and product\ndefuzzifier centroid"},
        {"settings": "implication product\ndefuzzifier centroid"},
        {"settings": "aggregation sum\ndefuzzifier centroid"},
        {"cells": "NB NB Z"},
        {"cells": "NB NS ."},
        {"cells": "NB NS Z*0.5"},
        {"terms": "  terms NB@-1 NS@-0.4 Z@0 PS@0.4 PB@1"},
    ],
    ids=str,
)
def test_others_are_left_to_the_rules(changes):
    system = pd(**changes)
    assert algorithm_of(plan(system)).name != "diagonals"
    with pytest.raises(ArgumentError, match="no table of diagonals"):
        compile_system(system, "python", algorithm="diagonals")


def test_a_rule_besides_the_table_counts():
    system = loads(PD.format(settings="defuzzifier centroid", terms=EVEN, cells="NB NS Z") + "if e is N then u is PB\n")
    assert algorithm_of(plan(system)).name == "rules"


def test_a_symmetric_table_gives_opposite_numbers():
    kernel = compile_system(pd(), "python")
    for e, de in [(0.0, 0.0), (0.25, 0.5), (0.3, -0.7), (1.0, 0.1)]:
        assert kernel(-e, -de) == pytest.approx(-kernel(e, de), abs=2.0**-52)
    assert kernel(0.0, 0.0) == 0.0


@pytest.mark.parametrize("backend", ["python", "numpy"])
@pytest.mark.parametrize("ends", [(0.0, 1e-310), (0.0, 1e-200), (0.0, 1e150), (1e6, 1000001.0)], ids=str)
def test_inputs_may_have_any_range(backend, ends):
    """Slopes are numbers; far from 0, peaks that look even are not, since they are rounded."""
    low, high = ends
    text = PD.format(settings="defuzzifier centroid", terms=EVEN, cells="NB NS Z")
    text = text.replace("input e in [-1, 1]\n  terms N Z P", f"input e in [{low}, {high}]\n  terms N Z P PP")
    system = loads(text + "  PP | PS PB PB\n")
    e = low + (high - low) * np.linspace(0.0, 1.0, 50)
    points = np.stack([e, np.linspace(-1.0, 0.9, 50)], axis=1)
    expected = compile_system(system, "python", algorithm="rules").batch(points)
    np.testing.assert_allclose(compile_system(system, backend).batch(points), expected, rtol=0, atol=1e-13)
