"""Rules that are known to be a complete table leave no point without a value: drawn ones, at all places that matter."""

import itertools
import math

import hypothesis.strategies as st
import numpy as np
from hypothesis import given, note

from fuzzyctl import compile as compile_system
from fuzzyctl import loads
from fuzzyctl.analysis.coverage.box_search import Search
from fuzzyctl.analysis.coverage.coverage import uncovered
from fuzzyctl.formulas import CONJUNCTIONS
from fuzzyctl.kernels.plan.build import plan
from tests.properties.running import quick

HEDGES = ("", "", "", "very ", "somewhat ", "not ", "extremely ", "any ", "seldom ")
WEIGHTS = ("", "", "", "", "", " weight 0", " weight 1e-180", " weight 0.3")
METHODS = ("", "", "", "activation threshold(>= 0.2)\n", "activation highest(count=1)\n", "activation first(count=2)\n")
SEMANTICS = ("exact", "exact", "exact(least=0.05)", "fuzzylite", "matlab")
#: From terms that meet at 0.5 to such that leave a gap or touch with a degree that no product can be made of.
FEET = (0.0, 0.3, 0.5, 0.7, 1.0)


@st.composite
def tables(draw):
    """A table over one to three inputs: complete, or with rules that are hedged, weighted, shorter or left out."""
    count = draw(st.integers(1, 3))
    lines = [f"system s\nsemantics {draw(st.sampled_from(SEMANTICS))}"]
    lines += [f"and {draw(st.sampled_from(sorted(CONJUNCTIONS)))}\n{draw(st.sampled_from(METHODS))}"]
    lines += ["defuzzifier weighted_average"]
    terms = [draw(st.integers(1, 3)) for _ in range(count)]
    for i, n in enumerate(terms):
        lines.append(f"input x{i} in [0, {max(n - 1, 1)}]")
        lines += [f"  t{k} = {draw(shapes(k, n))}" for k in range(n)]
    lines += ["output y in [0, 1] else nan", "  one = constant(1)"]
    odd = draw(st.booleans())
    for own in itertools.product(*map(range, terms)):
        if odd and draw(st.integers(0, 9)) == 0:
            continue
        short = draw(st.integers(0, count)) if odd else count
        parts = [f"x{i} is {draw(st.sampled_from(HEDGES)) if odd else ''}t{k}" for i, k in enumerate(own)]
        weight = draw(st.sampled_from(WEIGHTS)) if odd else ""
        lines.append(f"if {' and '.join(parts[:short] or parts)} then y is one{weight}")
    if not lines[-1].startswith("if"):
        lines.append("if x0 is t0 then y is one")
    return "\n".join(lines)


def shapes(k, count):
    left = "-inf" if k == 0 else None
    right = "inf" if k == count - 1 else None
    return st.one_of(
        st.tuples(st.sampled_from((1.0, 1.0, *FEET)), st.sampled_from((1.0, 1.0, *FEET))).map(
            lambda f: f"triangle({left or (k - f[0] if f[0] else k - 1e-200)}, {k}, {right or k + f[1]})"
        ),
        st.sampled_from((0.05, 0.5)).map(lambda s: f"gaussian({k}, {s})"),
    )


def places(flat):
    """All combinations of corners, their neighbours and places between."""
    axes = []
    for i, variable in enumerate(flat.inputs):
        corners = {x for d in flat.degrees if d.variable == i for x, _ in d.set.vertices if math.isfinite(x)}
        corners |= {variable.lower, variable.upper}
        near = {math.nextafter(x, e) for x in corners for e in (-math.inf, math.inf)}
        axis = sorted(corners | near | set(np.linspace(variable.lower, variable.upper, 9)))
        axes.append([x for x in axis if variable.lower <= x <= variable.upper])
    return np.array(list(itertools.product(*axes)))


def check(text):
    note(text)
    system = loads(text)
    flat = plan(system)
    search = Search(flat, flat.outputs[0], free_outputs=True)
    search._prepare()
    if not search._is_complete_table() or uncovered(system)["y"] is not None:
        return False
    assert not np.isnan(compile_system(system, "numpy", algorithm="rules").batch(places(flat))).any()
    return True


@quick(250)
@given(tables())
def test_leave_no_point_without_a_value(text):
    check(text)
