"""Kernels against the reference interpreter, over systems and knobs that are drawn."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fuzzyctl
from fuzzyctl.analysis.coverage.box_search import Hole
from fuzzyctl.analysis.coverage.coverage import uncovered
from tests.reference.interpreter import Reference
from tests.sizes import examples

TERMS = ("lo", "mid", "hi")
INPUTS = """input a in [0, 10]
  lo = triangle(-inf, 0, 4.5)
  mid = gaussian(5, 1.75)
  hi = trapezoid(5.5, 8, 9, inf)
input b in [-1, 1]
  lo = triangle(-inf, -1, 0.1)
  mid = sigmoid_difference(0.3, 7, 5, -0.2)
  hi = triangle(-0.3, 1, inf)
"""
SETS = "  lo = triangle(-3, 1, 4)\n  mid = triangle(2, 5, 7)\n  hi = triangle(6, 9, 13)\n"
FUNCTIONS = "  lo = constant(2)\n  mid = constant(2)\n  hi = linear(0.4, -3, 2)\n"

KNOBS = {
    "weight": st.sampled_from(["before", "after"]),
    "merge": st.sampled_from(["rules", "terms", "places"]),
    "total": st.sampled_from(["activations", "strengths", "all_rules"]),
    "least": st.sampled_from(["none", "0", "0.0137", "0.31"]),
    "equal": st.sampled_from(["0", "0.213"]),
    "chained": st.just("degree"),
    "consequent_hedges": st.sampled_from(["set", "activation", "carried", "undone"]),
    "extremely": st.sampled_from(["contrast", "cube"]),
    "sigmoid_difference": st.sampled_from(["magnitude", "clamped"]),
}


@st.composite
def literals(draw, outputs=()):
    variable = draw(st.sampled_from(["a", "b", *outputs]))
    hedges = draw(st.lists(st.sampled_from(["not", "very", "somewhat", "extremely"]), max_size=2))
    if variable in outputs and "not" in hedges:
        # What rules before have added up may be more than 1, and what is not that has no root.
        hedges = [h for h in hedges if h != "somewhat"]
    return f"{variable} is {' '.join([*hedges, draw(st.sampled_from(TERMS))])}"


@st.composite
def block_lines(draw, name, compares):
    """The first line of a rule block."""
    choices = {
        "and": ["product", "drastic_product"],
        "or": ["bounded_sum", "drastic_sum"],
        "implication": ["min", "product"],
        "activation": ["general", "threshold(>= 0.213)", *(["highest(count=1)"] if compares else [])],
    }
    said = [f"{word} {draw(st.sampled_from(own))}" for word, own in choices.items() if draw(st.booleans())]
    return " ".join(["rules", name, *said])


@st.composite
def systems(draw):
    knobs = draw(st.fixed_dictionaries({}, optional=KNOBS))
    norms = draw(
        st.sampled_from([("min", "max"), ("product", "probabilistic_sum"), ("drastic_product", "drastic_sum")])
    )
    aggregation = draw(st.sampled_from(["max", "sum", "probabilistic_sum", "bounded_sum"]))
    implication = draw(st.sampled_from(["min", "product"]))
    over_sets = draw(st.booleans())
    rule = draw(st.sampled_from(["plain", "trapezoid"]))
    sampled = f"centroid(resolution={draw(st.integers(5, 40))}, grid=endpoints, rule={rule})"
    defuzzifier = sampled if over_sets else draw(st.sampled_from(["weighted_average", "weighted_sum"]))
    hedges = st.lists(st.sampled_from(["very", "somewhat", "not"]), max_size=1)
    if defuzzifier == "weighted_average" and knobs.get("total", "activations") != "activations":
        hedges = st.just([])
        knobs.pop("merge", None)
    if not over_sets and knobs.get("consequent_hedges", "set") == "set":
        hedges = st.just([])
    outputs = ["y", "z"] if draw(st.booleans()) else ["y"]
    rules = []
    for _ in range(draw(st.integers(2, 5))):
        read = outputs if "chained" in knobs else ()
        parts = draw(st.lists(literals(read), min_size=1, max_size=3))
        word = draw(st.sampled_from([" and ", " or "]))
        ends = [f"{o} is {' '.join([*draw(hedges), draw(st.sampled_from(TERMS))])}" for o in outputs]
        kept = ends if draw(st.booleans()) else ends[:1]
        weight = draw(st.sampled_from(["", "", " weight 0.5", " weight 0.21", " weight 0"]))
        rules.append(f"if {word.join(parts)} then {', '.join(kept)}{weight}")
    fallback = draw(st.sampled_from(["else nan", "else midpoint", "else 3.5", "else nan clamp"]))
    options = ", ".join(f"{k}={v}" for k, v in knobs.items())
    text = f"system s\nsemantics exact{f'({options})' if options else ''}\nand {norms[0]}\nor {norms[1]}\n"
    text += f"implication {implication}\naggregation {aggregation}\ndefuzzifier {defuzzifier}\n{INPUTS}"
    text += "".join(f"output {o} in [0, 10] {fallback}\n{SETS if over_sets else FUNCTIONS}" for o in outputs)
    if len(outputs) > 1:
        rules.append("if a is mid then z is mid")
    # Rule blocks begin before some of the rules, the last one first, so that each has a rule.
    begins = draw(st.lists(st.integers(0, len(rules) - 1), max_size=2, unique=True))
    for k in sorted(begins, reverse=True):
        rules.insert(k, draw(block_lines(f"b{k}", compares="chained" not in knobs)))
    return text + "\n".join(rules) + "\n"


POINTS = [(x, y) for x in (-2.0, 0.0, 1.3, 4.4, 6.2, 8.5, 11.0) for y in (-0.97, -0.25, 0.0, 0.43, 1.0)]


def expected(system, points=POINTS):
    return np.array([Reference(system, point).values() for point in points])


def found(system, backend, points=POINTS):
    return fuzzyctl.compile(system, backend).run(points)[0].reshape(len(points), -1)


@settings(max_examples=examples(80), deadline=None)
@given(systems())
def test_kernels_compute_what_the_reference_says(text):
    system = fuzzyctl.loads(text)
    wanted = expected(system)
    for backend in ("python", "numpy"):
        np.testing.assert_allclose(found(system, backend), wanted, rtol=1e-9, atol=1e-9, err_msg=text)


@settings(max_examples=examples(40), deadline=None)
@given(systems())
def test_bounds_hold_whatever_the_semantics(text):
    system = fuzzyctl.loads(text)
    wanted = expected(system)
    for k, bound in enumerate(fuzzyctl.output_bounds(system).values()):
        values = wanted[:, k][~np.isnan(wanted[:, k])]
        slack = 1e-9 * max(1.0, *np.abs(values)) if len(values) else 0.0
        assert (values >= bound.lo - slack).all(), (text, bound)
        assert (values <= bound.hi + slack).all(), (text, bound)


@settings(max_examples=examples(40), deadline=None)
@given(systems())
def test_coverage_is_sound_whatever_the_semantics(text):
    system = fuzzyctl.loads(text.replace("else midpoint", "else nan").replace("else 3.5", "else nan"))
    wanted = expected(system)
    for k, verdict in enumerate(uncovered(system).values()):
        if verdict is None:
            assert not np.isnan(wanted[:, k]).any(), text
        elif isinstance(verdict, Hole):
            point = tuple(verdict.witness[name] for name in ("a", "b"))
            assert np.isnan(expected(system, [point])[0, k]), (text, point)


RULES = (
    "if a is lo and b is not hi then y is mid weight 0.5\nif b is mid or a is mid then y is mid\n"
    "if a is hi then y is hi\n"
)


@pytest.mark.parametrize("knobs", ["weight=after", "merge=places", "merge=rules, total=all_rules", "least=0.31"])
def test_compiled_code_agrees(knobs):
    text = f"system s\nsemantics fuzzylite({knobs})\naggregation max\ndefuzzifier weighted_average\n{INPUTS}"
    system = fuzzyctl.loads(f"{text}output y in [0, 10] else nan\n{FUNCTIONS}{RULES}")
    wanted = expected(system)
    np.testing.assert_allclose(found(system, "numba"), wanted, rtol=1e-9, atol=1e-9)


class TestMoreThanOnePoint:
    TEXT = (
        "system s\nsemantics exact\ndefuzzifier weighted_average\n"
        + INPUTS
        + "output y in [0, 10] else hold({})\n  one = function(a + 1)\n"
        + "output z in [0, 10] else hold(nan) clamp\n  two = function(y * b * 7)\n"
        + "if a is hi then y is one\nif b is hi then z is two\n"
    )

    @pytest.mark.parametrize("start", ["nan", "4"])
    @pytest.mark.parametrize("backend", ["python", "numpy"])
    def test_values_are_held_and_functions_read_outputs(self, start, backend):
        system = fuzzyctl.loads(self.TEXT.format(start))
        points = [(0, -1), (0, 1), (9, -1), (9, 0.5), (0, 0.5), (7, 1), (0, -1)]
        previous, rows = {}, []
        for x, y in points:
            rows.append(Reference(system, (x, y), previous).values())
            previous |= {k: v for k, v in zip("yz", rows[-1], strict=True) if not math.isnan(v)}
        np.testing.assert_allclose(found(system, backend, points), rows, rtol=1e-12)
        assert rows[-1] == [8.0, 10.0]


def test_a_rule_reads_how_far_the_rules_before_have_activated_a_term():
    text = (
        f"system s\nsemantics exact(chained=degree)\naggregation sum\ndefuzzifier weighted_sum\n{INPUTS}"
        f"output y in [0, 10] else nan\n{FUNCTIONS}output z in [0, 10] else nan\n{FUNCTIONS}"
        "if y is lo then z is lo\nif a is lo then y is lo\nif b is lo then y is lo\nif y is lo then z is mid\n"
    )
    # The first rule comes too early; the last one feels both rules for y.
    assert fuzzyctl.loads(text)(a=2.25, b=-0.45) == {"y": pytest.approx(2.0), "z": pytest.approx(2.0)}


OVERFULL = """
system s
semantics exact(chained=degree)
aggregation sum
defuzzifier weighted_average
input a in [0, 10]
  lo = triangle(-inf, 0, 4.5)
  mid = gaussian(5, 1.75)
output y in [0, 10] else nan
  lo = constant(2)
  mid = constant(4)
output z in [0, 10] else nan
  lo = constant(1)
  mid = constant(3)
if a is lo then y is mid
if a is lo then y is mid
if y is not mid then z is lo
if a is mid then z is mid
"""


@pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
def test_a_rule_below_0_does_not_act(backend):
    """At a = 0 the term y.mid has the degree 2, so that `y is not mid` is -1."""
    system = fuzzyctl.loads(OVERFULL)
    points = [(a,) for a in (0.0, 1.0, 3.0, 4.0, 9.0)]
    wanted = np.array([Reference(system, point).values() for point in points])
    np.testing.assert_allclose(found(system, backend, points), wanted, rtol=1e-12)
    assert wanted[0, 1] == 3.0
