"""Arrays in plain Python give what numpy gives, bit for bit, but for sums and functions of the C library."""

import math
import subprocess
import sys

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis.extra import numpy as arrays_of

from fuzzyctl.studio.arrays import module
from tests import sizes

plain = module()
EXAMPLES = sizes.examples(300)
NUMBERS = st.sampled_from([0.0, -0.0, 1.0, -1.0, 2.0, 0.5, 3.7, -1e308, 1e308, 5e-324, math.inf, -math.inf, math.nan])
ONE = ["isnan", "isfinite", "isinf", "isposinf", "isneginf", "sign", "sqrt", "abs", "exp", "expm1"]
TWO = ["add", "subtract", "multiply", "divide", "minimum", "maximum", "fmin", "fmax", "nextafter"]
OPERATORS = [f"__{n}__" for n in "add radd sub rsub mul rmul truediv rtruediv pow lt le gt ge eq ne".split()]
NEAR = {"exp", "expm1", "__pow__"}


def drawn(shape):
    return arrays_of.arrays(np.float64, shape, elements=NUMBERS)


def same(found, wanted, *, near=False):
    """Whether a result has the shape and the bits of numpy's; NaN is NaN, of whatever sign."""
    wanted = np.asarray(wanted)
    if isinstance(found, plain.ndarray):
        assert found.shape == wanted.shape
        assert np.asarray(found.tolist()).size == wanted.size
        found = np.array(found.items, wanted.dtype).reshape(found.shape)
    found = np.asarray(found)
    assert found.shape == wanted.shape
    if near:
        np.testing.assert_allclose(found, wanted, rtol=1e-13)
    else:
        assert np.array_equal(found, wanted, equal_nan=wanted.dtype.kind == "f")
        signs = ~np.isnan(wanted) if wanted.dtype.kind == "f" else wanted == wanted
        if wanted.dtype.kind == "f":
            assert np.array_equal(np.signbit(found[signs]), np.signbit(wanted[signs]))


def of(a):
    return plain.array(a.tolist())


@pytest.mark.parametrize("name", [*ONE, *TWO, *OPERATORS])
@settings(max_examples=EXAMPLES // 5)
@given(shapes=arrays_of.mutually_broadcastable_shapes(num_shapes=2, max_dims=3, max_side=3, min_side=1), data=st.data())
def test_functions_of_elements_are_numpy_s(name, shapes, data):
    given_ = [data.draw(drawn(s)) for s in (shapes.input_shapes if name not in ONE else shapes.input_shapes[:1])]
    with np.errstate(all="ignore"):
        wanted = getattr(given_[0], name)(*given_[1:]) if name in OPERATORS else getattr(np, name)(*given_)
    own = [of(a) for a in given_]
    found = getattr(own[0], name)(*own[1:]) if name in OPERATORS else getattr(plain, name)(*own)
    if name in ("minimum", "maximum", "fmin", "fmax"):  # of 0 and -0 numpy returns either
        wanted, found = wanted + 0.0, found + 0.0
    same(found, wanted, near=name in NEAR)


REDUCTIONS = ["min", "max", "all", "any", "argmax"]


@pytest.mark.parametrize("name", REDUCTIONS)
@settings(max_examples=EXAMPLES // 5)
@given(a=arrays_of.arrays(np.float64, arrays_of.array_shapes(max_dims=3, max_side=3), elements=NUMBERS), data=st.data())
def test_reductions_are_numpy_s(name, a, data):
    axis = data.draw(st.sampled_from([None, *range(-a.ndim, a.ndim)]))
    with np.errstate(all="ignore"):
        same(getattr(of(a), name)(axis=axis) + 0.0, getattr(a, name)(axis=axis) + 0.0)


@settings(max_examples=EXAMPLES // 5)
@given(shape=arrays_of.array_shapes(min_dims=0, max_dims=3, max_side=4), data=st.data())
def test_indexing_is_numpy_s(shape, data):
    a = np.arange(math.prod(shape), dtype=float).reshape(shape)
    own = of(a)
    key = data.draw(arrays_of.basic_indices(shape, allow_newaxis=True, min_dims=0))
    same(own[key], a[key])
    own[key], a[key] = -1.0, -1.0
    same(own, a)


def test_lists_masks_and_pairs_as_keys():
    a = np.arange(12.0).reshape(3, 4)
    own = of(a)
    for key in (np.array([2, 0, 0]), np.array([True, False, True]), np.zeros(3, bool)):
        same(own[of(key)], a[key])
        same(own[:, 1][of(key)], a[:, 1][key])
    same(own[:, plain.array([True, False, False, True])], a[:, [0, 3]])
    pairs = np.array([0, 2, 1]), np.array([3, 0, 0])
    same(own[tuple(map(of, pairs))], a[pairs])
    own[tuple(map(of, pairs))], a[pairs] = plain.array([7.0, 8.0, 9.0]), [7.0, 8.0, 9.0]
    same(own, a)


@pytest.mark.parametrize("key", [3, -4, [0, 3], [True, True, True, True]])
def test_a_place_beyond_the_end_is_an_error_as_of_numpy(key):
    for a in (np.zeros(3), plain.zeros(3)):
        with pytest.raises(IndexError):
            a[key]


@pytest.mark.parametrize("key", [[[0, 1], [1, 0]], ([True, False, True], [0, 1]), ([0, 1], [0, 1], slice(None))])
def test_keys_that_are_not_here_are_missing(key):
    own = tuple(map(of, map(np.array, key[:2]))) + key[2:] if isinstance(key, tuple) else of(np.array(key))
    with pytest.raises(ModuleNotFoundError):
        plain.zeros((3, 3, 2))[own]


def test_functions_of_whole_arrays_are_numpy_s():
    a, b = np.array([[3.0, -1.0, 2.0], [0.5, 7.0, -2.0]]), np.array([1.0, 1.0, math.nan, 0.0])
    own, other = of(a), of(b)
    same(own.T, a.T)
    same(plain.hstack([own, own]), np.hstack([a, a]))
    same(plain.hstack([other, other]), np.hstack([b, b]))
    same(plain.concatenate([own, own]), np.concatenate([a, a]))
    same(plain.argsort(other), np.argsort(b, kind="stable"))
    same(plain.flatnonzero(own > 0.0), np.flatnonzero(a > 0.0))
    same(~(own > 0.0) | (own == 7.0), ~(a > 0.0) | (a == 7.0))
    same(-abs(own), -abs(a))
    same(plain.where(own > 0.0, own, -1.0), np.where(a > 0.0, a, -1.0))
    same(plain.clip(own, -1.0, 1.0), np.clip(a, -1.0, 1.0))
    same(plain.prod(own, axis=0), np.prod(a, axis=0))
    same(own.sum(axis=-2), a.sum(axis=-2))
    same((own > 0.0).sum(), (a > 0.0).sum())
    same(plain.squeeze(own[:, None], 1), a)
    same(own.reshape(-1).reshape((3, 2)), a.reshape(-1).reshape((3, 2)))
    same(plain.broadcast_to(own[:, :0], (4, 2, 0)), np.empty((4, 2, 0)))
    same(plain.minimum.reduce(own), np.minimum.reduce(a))
    same(plain.logical_or.reduce([own > 3.0, own < 0.0]), np.logical_or.reduce([a > 3.0, a < 0.0]))
    same(own[:, :0].min(axis=1, initial=5.0), a[:, :0].min(axis=1, initial=5.0))
    rows, values = np.array([0.0, 1.0, 3.0]), np.array([2.0, -1.0, 0.1])
    at = np.append(np.linspace(-1.0, 4.0, 23), math.nan)
    same(plain.interp(of(at), of(rows), of(values)), np.interp(at, rows, values))
    same(plain.searchsorted(of(rows), [1.0, 2.0]), np.searchsorted(rows, [1.0, 2.0]))
    same(plain.append(plain.diff(of(rows)), 0.0), np.append(np.diff(rows), 0.0))
    at = at[:-1]
    same(plain.quantile(of(at), (0.005, 0.4, 1.0)), np.quantile(at, (0.005, 0.4, 1.0)))
    assert plain.median(other[:2]) == plain.median(own) - 0.25 == 1.0
    assert plain.nanargmax(of(np.array([1.0, math.nan, 3.0]))) == 2
    assert plain.dot(of(rows), of(values)) == np.dot(rows, values)
    assert plain.mean(of(values)) == pytest.approx(np.mean(values), rel=1e-15)


def test_shapes_that_do_not_fit_are_an_error():
    with pytest.raises(ValueError, match="do not fit"):
        plain.array([1.0, 2.0]) + plain.array([1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match="does not fit"):
        plain.broadcast_to([1.0, 2.0], (3,))


def test_what_is_not_here_is_missing_as_numpy_is():
    program = """import sys
sys.modules["numpy"] = None
from fuzzyctl.studio.arrays import install
install()
import numpy as np, numpy.typing
for missing in (lambda: np.linalg, lambda: np.zeros(2).cumsum):
    try:
        missing()
    except ModuleNotFoundError as error:
        print(error.name)
print(hasattr(np, "__array__"), [float(x) for x in np.zeros(2)])
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "numpy\nnumpy\nFalse [0.0, 0.0]\n"
