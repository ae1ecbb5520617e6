"""Numbers that other tools print, and laws that defuzzifiers obey."""

import math

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from fuzzyctl import Defuzzifier, as_profile, compile, loads, output_bounds
from fuzzyctl.expr import Name
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.kernels.program.scalar import scalar_function
from tests import sizes
from tests.fuzzyctl.kernels.joined import build, evaluated, parsed
from tests.properties.running import quick
from tests.tipper import FUZZYLITE, POINTS, TIPS


class TestTipper:
    """The tipper of MATLAB's manual at (service, food), as the tools print it."""

    @pytest.mark.parametrize(
        ("profile", "resolution", "grid", "rule", "expected"),
        [
            ("matlab", 101, "endpoints", None, TIPS["matlab"]),
            ("fuzzylogic_jl", 101, "endpoints", "trapezoid", TIPS["fuzzylogic_jl"]),
            ("pyfuzzylite", 1000, "midpoint", None, TIPS["pyfuzzylite"]),
            ("fuzzylite", 200, "midpoint", None, FUZZYLITE),
            ("jfuzzylogic", 1000, "left", None, TIPS["jfuzzylogic"]),
            ("simpful", 1000, "endpoints", None, TIPS["simpful"]),
            ("exact", None, "midpoint", None, TIPS["exact"]),
        ],
    )
    def test_each_tool_prints_its_own_digits(self, tipper, profile, resolution, grid, rule, expected):
        system = as_profile(tipper, profile)
        defuzzifier = Defuzzifier(resolution=resolution, grid=grid, rule=rule)
        # Norms of the tipper, whatever a tool takes where nothing is said.
        system = system.model_copy(update={"method": system.method.model_copy(update={"defuzzifier": defuzzifier})})
        found = [system(service=service, food=food) for service, food in POINTS]
        assert found == pytest.approx(expected, abs=6e-10 if profile in ("fuzzylite", "fuzzylogic_jl") else 6e-11)


MIRRORED = {
    "triangle(-2, 0, 1)": "triangle(-1, 0, 2)",
    "trapezoid(0.5, 1, 2, 3)": "trapezoid(-3, -2, -1, -0.5)",
    "gaussian(1, 0.5)": "gaussian(-1, 0.5)",
    "s_shape(0, 2)": "z_shape(-2, 0)",
}
OPPOSITE = {"som": "lom", "lom": "som"}


class TestLaws:
    @given(
        st.lists(st.sampled_from(list(MIRRORED)), min_size=1, max_size=3, unique=True),
        st.lists(st.sampled_from([0.25, 0.5, 0.8, 1.0]), min_size=3, max_size=3),
        st.sampled_from(["centroid", "bisector", "som", "lom", "mom"]),
        st.sampled_from(["min", "product"]),
    )
    @quick(60)
    def test_a_mirrored_set_has_the_mirrored_place(self, terms, activations, kind, implication):
        own = activations[: len(terms)]
        found = evaluated(build(terms, implication, "max", kind, -4, 4), own, ("python",))
        mirrored = build([MIRRORED[t] for t in terms], implication, "max", OPPOSITE.get(kind, kind), -4, 4)
        assert evaluated(mirrored, own, ("python",)) == pytest.approx(-found, abs=2e-12)

    @given(
        st.sampled_from(["centroid", "bisector", "som", "lom", "mom"]),
        st.sampled_from([("min", "max"), ("product", "sum"), ("product", "max")]),
        st.sampled_from([0.3, 0.5, 1.0]),
        st.sampled_from([0.25, 1.0]),
    )
    @quick(30)
    def test_a_set_shifted_and_stretched_has_its_place_moved_alike(self, kind, norms, x, y):
        near = build(["triangle(-2, 0, 1)", "trapezoid(0, 1, 2, 4)"], *norms, kind, -4, 4)
        far = build(["triangle(92, 100, 104)", "trapezoid(100, 104, 108, 116)"], *norms, kind, 84, 116)
        assert evaluated(far, [x, y]) == pytest.approx(100 + 4 * evaluated(near, [x, y]), abs=1e-12 * 32)


class TestTsukamoto:
    TERMS = ("ramp(0, 4)", "z_shape(-2, 2)", "concave(0, 2)")

    ONE_SIDED = ("gaussian2(1, 0.5, inf, 1)", "gaussian2(-inf, 1, 1, 2)", "piecewise(-1, 1, 0, 0.8, 0, 0.3, 2, 0)")

    @pytest.mark.parametrize("places", ["clamped", "free"])
    @pytest.mark.parametrize("terms", [TERMS, ONE_SIDED])
    def test_the_family_sums_places_or_degrees(self, terms, places):
        weights = [0.3, 0.8, 0.1]
        for kind in ("tsukamoto", "tsukamoto_sum", "inverse_tsukamoto", "inverse_tsukamoto_sum"):
            system = build(terms, "min", "max", kind)
            semantics = system.method.semantics.model_copy(update={"places": places})
            system = system.model_copy(update={"method": system.method.model_copy(update={"semantics": semantics})})
            compiled = sizes.LONG or (kind == "tsukamoto" and places == "clamped")
            found = evaluated(system, weights, ("python", "numpy", *(["numba"] if compiled else [])))
            values = []
            for (name, parameters), w in zip(map(parsed, terms), weights, strict=True):
                formula = MEMBERSHIP[name]
                expr = (
                    formula.degree(Name("w"), parameters)
                    if "inverse" in kind
                    else formula.inverse(Name("w"), parameters)
                )
                value = scalar_function(expr)(w)
                values.append(min(max(value, -3.0), 5.0) if places == "clamped" else value)
            expected = math.fsum(w * z for w, z in zip(weights, values, strict=True))
            if not kind.endswith("_sum"):
                expected /= math.fsum(weights)
            assert found == pytest.approx(expected, rel=1e-14)

    @pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
    def test_logarithmic_consequents_of_zhao_tomizuka_isaka(self, backend):
        system = loads(FORMULAS.format(small="function(-log(y) / c)"))
        e = np.linspace(-1, 1, 201)
        n, p = (1 - e) / 2, (1 + e) / 2
        expected = n * np.exp(-4 * n) + p * (1 - np.exp(-4 * p))
        np.testing.assert_allclose(compile(system, backend).batch(e[:, None]), expected, rtol=1e-12, atol=1e-15)
        bound = output_bounds(system)["y"]
        assert (bound.lo, bound.hi) == (0.0, 1.0)

    @pytest.mark.parametrize(
        ("small", "degree"),
        [
            ("exp(-2 * y)", lambda y: math.exp(-2 * y)),
            ("sqrt(y / 3) * 2 - 0.25", lambda y: math.sqrt(y / 3) * 2 - 0.25),
            ("1 - (0.5 + y) / 2", lambda y: 1 - (0.5 + y) / 2),
            ("-(log(2 - y) - 1)", lambda y: -(math.log(2 - y) - 1)),
        ],
    )
    def test_the_place_of_a_formula_has_the_degree(self, small, degree):
        text = FORMULAS.format(small=f"function({small})").replace("tsukamoto", "tsukamoto_sum")
        kernel = compile(loads(text.replace("[0, 1]", "[-9, 9]").replace("if e is P then y is big\n", "")), "python")
        for w in (0.35, 0.5, 0.6):
            assert degree(kernel(1 - 2 * w) / w) == pytest.approx(w, rel=1e-12)


FORMULAS = """
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
