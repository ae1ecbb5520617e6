"""Kernels whose numbers are arguments: names, values, backends, refusals, degrees, strengths and gradients."""

import pickle

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import ArgumentError, Kernel, UnknownNameError, ValueOutOfBoundsError, loads
from fuzzyctl import compile as compile_system
from tests import sizes

BACKENDS = ("python", "numpy", "numba")
NAMES = ["g", "e.Z.peak", "u.P.peak", "u.weights"]
#: Outputs for the first three of them: 1, then other numbers.
POINTS = np.array([[0.25, -0.4], [-0.7, 0.1], [1.5, 0.9]])

TEXT = """
system s
and         product
defuzzifier center_average
param g = 1
param h = 2 * g
input e in [-1, 1]
  terms N Z P
input d in [-1, 1]
  terms N@-1 Z@(0.1 * h) P@1
output u in [-1, 1]
  terms N=-1 Z=0 P=1
table u = e x d
       N  Z  P
  N |  N  N  Z
  Z |  N  Z  P
  P |  Z  P  P
"""


@pytest.fixture(scope="module")
def system():
    return loads(TEXT)


def retyped(peak="", z="0.2", p="1", weight=""):
    """The system with other numbers, typed."""
    text = TEXT.replace("terms N Z P\n", f"terms N@-1 Z@{peak} P@1\n") if peak else TEXT
    text = text.replace("(0.1 * h)", z).replace("P=1", f"P={p}")
    return loads(text.replace("|  N  N  Z", f"|  N*{weight}  N  Z") if weight else text)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_kernel_of_free_numbers_computes_what_typed_numbers_do(system, backend):
    kernel = compile_system(system, backend, free=NAMES)
    assert kernel.free_names == ("g", "e.Z.peak", "u.P.peak", *(f"u.weights[{k}]" for k in range(9)))
    typed = compile_system(retyped(peak="0.3", z="0.1", p="0.8", weight="0.5"), "python")
    values = kernel.start({"g": 0.5, "e.Z.peak": 0.3, "u.P.peak": 0.8, "u.weights[0]": 0.5})
    assert kernel.batch(POINTS, values) == pytest.approx(typed.batch(POINTS), abs=1e-12)
    assert [kernel(*p, values) for p in POINTS] == pytest.approx(typed.batch(POINTS), abs=1e-12)
    assert kernel.jit(0.25, -0.4, values) == pytest.approx(typed(0.25, -0.4), abs=1e-12)
    assert kernel(e=0.25, d=-0.4, state=values) == kernel(0.25, -0.4, values)


@pytest.mark.parametrize("backend", BACKENDS)
def test_values_broadcast_with_the_points(system, backend):
    kernel = compile_system(system, backend, free=["g", "u.P.peak"])
    values = np.array([[1.0, 1.0], [2.0, 0.5]])
    found = kernel.batch(POINTS[:, np.newaxis], values)
    assert found.shape == (3, 2)
    for k, own in enumerate(values):
        assert np.array_equal(found[:, k], kernel.batch(POINTS, own))
    assert np.array_equal(kernel.batch(POINTS[0], values), found[0])
    with pytest.raises(ArgumentError, match=r"a state of shape \(2, 2\) does not fit points of shape \(3,\)"):
        kernel.batch(POINTS, values)


def test_a_mapping_leaves_other_numbers_as_they_are(system):
    kernel = compile_system(system, "python", free=["u.weights", "g"])
    assert kernel.start({"u.weights": 0.5}).tolist() == [*[0.5] * 9, 1.0]
    assert kernel.start({"u.weights": np.arange(9) / 9, "g": 2}).tolist() == [*(np.arange(9) / 9), 2.0]
    assert kernel(0.1, 0.2, {"g": 2}) == kernel(0.1, 0.2, kernel.start({"g": 2}))
    with pytest.raises(UnknownNameError, match="no free number 'k'; there are"):
        kernel.start({"k": 1})
    with pytest.raises(ArgumentError, match=r"free number 'u.weights' has 9 values, got the shape \(3,\)"):
        kernel.start({"u.weights": [1, 1, 1]})


def test_the_peak_of_a_terms_line_moves_the_feet_beside_it():
    line = loads(TEXT.replace("terms N Z P\n", "terms N@-1 Z@0 P@1\n"))
    kernel = compile_system(line, "python", free=["e.Z.peak"])
    degrees = kernel.degrees([[-0.25, 0]], [0.5])["e"]
    assert [degrees[t][0] for t in "NZP"] == [0.5, 0.5, 0.0]
    apart = loads(TEXT.replace("terms N Z P\n", "N = ramp(0, -1)\n  Z = triangle(-1, 0, 1)\n  P = ramp(0, 1)\n"))
    kernel = compile_system(apart, "python", free=["e.Z.peak"])
    degrees = kernel.degrees([[-0.25, 0]], [0.5])["e"]
    assert [degrees[t][0] for t in "NZP"] == [0.25, 0.5, 0.0]


def test_equal_numbers_that_are_typed_apart_stay_apart():
    vertical = loads(TEXT.replace("terms N Z P\n", "N = ramp(0, -1)\n  Z = triangle(0, 0, 1)\n  P = ramp(0, 1)\n"))
    kernel = compile_system(vertical, "python", free=["e.Z.left"])
    assert kernel.degrees([[-0.25, 0], [0.25, 0]], [-0.5])["e"]["Z"].tolist() == [0.5, 0.75]


@pytest.mark.parametrize(
    ("names", "error", "message"),
    [
        (["q"], UnknownNameError, "no free number 'q'; there are: g, h, e, d, u"),
        (["gg"], UnknownNameError, "did you mean 'g'"),
        (["e.M.peak"], UnknownNameError, "there are: e.N, e.Z, e.P"),
        (
            ["e.Z.peek"],
            UnknownNameError,
            "there are: e.Z.left, e.Z.peak, e.Z.right, e.Z.height; did you mean 'e.Z.peak'",
        ),
        (["u.weights[9]"], UnknownNameError, r"there are: u.weights\[0\] to \[8\]"),
        (["e.weights"], UnknownNameError, "no free number 'e.weights'"),
        (["e.N.left"], ArgumentError, "'e.N.left' cannot be free: it is infinite"),
        (["g", "g"], ArgumentError, "'g' cannot be free: it is given twice"),
        (["e.Z.peak", "e.N.right"], ArgumentError, "'e.N.right' cannot be free: it is given twice, as 'e.Z.peak'"),
        ("g", ArgumentError, "free must be a list of names, got str"),
        ([3], ArgumentError, "free must be a list of names, got int in it"),
    ],
)
def test_what_cannot_be_free_is_refused(system, names, error, message):
    with pytest.raises(error, match=message):
        compile_system(system, "python", free=names)


def test_numbers_that_a_program_is_worked_out_from_cannot_be_free():
    bisector = TEXT.replace("center_average", "bisector").replace("N=-1 Z=0 P=1", "N@-1 Z@0 P@1")
    with pytest.raises(ArgumentError, match=r"'u\.Z\.peak' cannot be free: exact bisectors"):
        compile_system(loads(bisector), "python", free=["g", "u.Z.peak"])
    assert compile_system(loads(bisector), "python", free=["g"])(0.1, 0.2, [1]) == loads(bisector)(e=0.1, d=0.2)
    curve = TEXT.replace("terms N Z P\n", "N = ramp(0, -1)\n  Z = piecewise(0, 0, 0, 1, 1, 0)\n  P = ramp(0, 1)\n", 1)
    with pytest.raises(ArgumentError, match=r"'e\.Z\.x2' cannot be free: the set jumps there"):
        compile_system(loads(curve), "python", free=["e.Z.x2"])
    with pytest.raises(ArgumentError, match="'interpolation' tabulates numbers beforehand"):
        compile_system(loads(TEXT), "python", free=["g"], algorithm="interpolation")


def test_a_system_with_a_state_has_no_free_numbers(adaptive):
    with pytest.raises(ArgumentError, match="has no free numbers"):
        compile_system(adaptive, "python", free=["half_width"])


@pytest.mark.parametrize("backend", ["python", "numpy"])
@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"e.Z.peak": -1.5}, "the peaks of 'e' are out of order: -1 of 'N', then -1.5"),
        ({"u.weights[3]": 2}, "the weight 2 lies outside"),
        ({"g": np.nan}, "free number 'g' must be a finite number, got nan"),
        ({"g": 9}, "free number 'g' must be one that the system can have"),
    ],
)
def test_values_that_the_system_cannot_have_are_refused(system, backend, changed, message):
    kernel = compile_system(system, backend, free=NAMES)
    with pytest.raises(ValueOutOfBoundsError, match=message):
        kernel.start(changed)
    good = kernel.start()
    bad = good.copy()
    for name, value in changed.items():
        bad[kernel.free_names.index(name)] = value
    for given in (bad, np.stack([good, bad])):
        with pytest.raises(ValueOutOfBoundsError, match=message):
            kernel.batch(POINTS[0], given)


def test_corners_of_an_exact_centroid_stay_in_their_order():
    text = TEXT.replace("center_average", "centroid").replace(
        "terms N=-1 Z=0 P=1", "N = triangle(-2, -1, 0)\n  Z = triangle(-0.9, 0.05, 0.9)\n  P = triangle(0.1, 1, 2)"
    )
    kernel = compile_system(loads(text), "python", free=["u.Z.peak"])
    typed = loads(text.replace("0.05", "0.02"))
    assert kernel.batch(POINTS, [0.02]) == pytest.approx(compile_system(typed).batch(POINTS), abs=1e-12)
    with pytest.raises(ValueOutOfBoundsError, match=r"such that u\.Z\.peak <= 0\.1, as it was"):
        kernel.batch(POINTS, [0.2])


def test_a_kernel_of_free_numbers_can_be_sent_to_another_process(system):
    kernel = compile_system(system, "python", free=NAMES)
    other = pickle.loads(pickle.dumps(kernel))
    assert isinstance(other, Kernel)
    assert other.free_names == kernel.free_names
    assert other(0.1, 0.2, {"g": 2}) == kernel(0.1, 0.2, {"g": 2})
    assert repr(kernel) == "Kernel(e, d -> u; 12 free; python)"


# --- degrees, strengths, gradients -----------------------------------------------------------------------------------


@pytest.mark.parametrize("backend", sizes.BACKENDS)
def test_numbers_of_lets_may_be_free(backend):
    text = """
system s
defuzzifier weighted_average
param slope = 2
input e in [-1, 1]
input d in [-1, 1]
let z in [-3, 3] = slope * e + d
  terms N@-3 Z@0 P@3
output u in [-1, 1]
  terms N=-1 Z=0 P=1
output v in [-9, 9] = slope * u + z
table u = z
    N Z P
  | N Z P
"""
    kernel = compile_system(loads(text), backend, free=["slope", "z.Z.peak"])
    typed = compile_system(loads(text.replace("slope = 2", "slope = 1.5").replace("Z@0", "Z@0.5")), "python")
    values = [1.5, 0.5]
    assert kernel.batch(POINTS, values) == pytest.approx(typed.batch(POINTS), abs=1e-12)
    assert kernel.degrees([[0.5, 0.0]], values)["z"]["Z"] == pytest.approx([0.9])
    # z = 0.75, u = (z - 0.5) / 2.5
    slopes = kernel.gradient([[0.5, 0.0]], values)[0]
    assert slopes == pytest.approx(np.array([[0.6, 0.4], [2.4, 1.6]]), abs=1e-12)
    by_slope = kernel.gradient([[0.5, 0.0]], values, by="state")[0, :, 0]
    assert by_slope == pytest.approx([0.2, 0.1 + 1.5 * 0.2 + 0.5], abs=1e-12)


def test_a_bisector_in_a_gap_jumps_and_has_no_gradient():
    text = """
system s
implication einstein_product
defuzzifier bisector
input x in [0, 1]
  terms L H
output u in [0, 4]
  A = triangle(0, 0.5, 1)
  B = triangle(3, 3.5, 4)
if x is L then u is A
if x is H then u is B
"""
    kernel = compile_system(loads(text), "numpy")
    assert kernel(0.5) == 2.0
    assert np.isnan(kernel.gradient([[0.5], [0.4]])[:, 0]).tolist() == [True, False]


WORST = """system s
and product
defuzzifier center_average
param k in [0.1, 2] = 0.5
input x in [-1, 1]
  N = ramp(0, -1)
  Z = triangle(-1, 0, 1)
  P = ramp(0, 1)
input y in [0, 2]
  lo = triangle(-inf, 0, 1)
  mi = trapezoid(0, 0.5, 1.5, 2)
  hi = triangle(1, 2, inf)
output u in [-3, 3] else nan
  a = constant(-1)
  b = constant(k)
  c = constant(2)
if x is N and y is lo then u is a
if x is Z and y is mi then u is b weight 0.5
if x is P and y is hi then u is c
if not x is N and y is lo then u is b
"""
#: Corners of terms, points between and beyond them, infinities and NaN.
CORNERS = np.array(
    [[x, y] for x in (-1.5, -1, -0.5, -0.25, 0, 0.5, 1, np.nan, np.inf) for y in (-1, 0, 0.5, 0.75, 1, 1.75, 2, np.nan)]
)


def by_hand(points):
    """Degrees and firing strengths of WORST, in numpy alone."""
    x, y = np.clip(points[:, 0], -1, 1), np.clip(points[:, 1], 0, 2)
    degrees = {
        "x": {"N": np.clip(-x, 0, 1), "Z": 1 - np.abs(x), "P": np.clip(x, 0, 1)},
        "y": {
            "lo": np.clip(1 - y, 0, 1),
            "mi": np.clip(np.minimum(y / 0.5, (2 - y) / 0.5), 0, 1),
            "hi": np.clip(y - 1, 0, 1),
        },
    }
    (n, z, p), (lo, mi, hi) = degrees["x"].values(), degrees["y"].values()
    return degrees, np.stack([n * lo, 0.5 * z * mi, p * hi, (1 - n) * lo], axis=-1)


@pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
def test_degrees_strengths_and_gradients_are_those_by_hand_at_the_worst_places(backend):
    system = fuzzyctl.loads(WORST)
    kernel, free = fuzzyctl.compile(system, backend), fuzzyctl.compile(system, backend, free=["k"])
    values = free.start()
    degrees, strengths = by_hand(CORNERS)
    for found in (kernel.degrees(CORNERS), free.degrees(CORNERS, values)):
        for variable, terms in degrees.items():
            for term, expected in terms.items():
                np.testing.assert_allclose(found[variable][term], expected, atol=1e-15)
    for found in (kernel.strengths(CORNERS), free.strengths(CORNERS, values)):
        np.testing.assert_allclose(found, strengths, atol=1e-15)
    with np.errstate(invalid="ignore"):
        outputs = strengths @ [-1, 0.5, 2, 0.5] / strengths.sum(axis=-1)
        by_k = strengths @ [0, 1, 0, 1] / strengths.sum(axis=-1)
    np.testing.assert_allclose(kernel.batch(CORNERS), outputs, atol=1e-14)
    np.testing.assert_allclose(free.gradient(CORNERS, values, by="state")[:, 0], by_k, atol=1e-14)
    slopes = kernel.gradient(CORNERS)
    assert (np.isnan(slopes).all(axis=-1) == np.isnan(outputs)).all(), "no value, no derivative"
    for k in range(2):
        ahead, behind = (kernel.batch(CORNERS + 1e-7 * sign * np.eye(2)[k]) for sign in (1, -1))
        sides = np.sort([(ahead - outputs) * 1e7, (outputs - behind) * 1e7], axis=0)
        fine = np.isfinite(CORNERS).all(axis=-1) & np.isfinite(sides).all(axis=0)
        assert (slopes[fine, k] >= sides[0, fine] - 1e-5).all()
        assert (slopes[fine, k] <= sides[1, fine] + 1e-5).all()


@pytest.mark.parametrize("what", ["degrees", "strengths", "gradient"])
def test_a_system_without_a_state_takes_none(what):
    kernel = fuzzyctl.compile(fuzzyctl.loads(WORST), "python")
    with pytest.raises(ArgumentError, match="the system has no state"):
        getattr(kernel, what)(CORNERS, [1.0])
