"""Planes of fuzzy systems hold their values over boxes, and over plane sets however narrow or bent."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyctl import compile, load, loads
from fuzzyctl.analysis.multilinear.surface import surface_of
from fuzzyctl.analysis.reach.forms import DomainError, ends
from fuzzyctl.analysis.reach.surfaces import SystemSurface, _slabs
from tests import sizes
from tests.fuzzyctl.analysis.reach.exact import arb, at, holds
from tests.properties.drawn_systems import plain_systems, systems
from tests.shipped import rules_folder

RULES = rules_folder()
NAMES = ["loops/pendulum", "loops/water_tank", "boundary_layer", "ais_reaction", "fcafsmc", "tipper"]
DIRECTIONS = st.tuples(st.integers(-1024, 1024), st.integers(-1024, 1024), st.integers(-1024, 1024))
PARALLEL = st.sampled_from(
    [(1000, 500, 250), (1001, 500, 250), (-1000, -500, -250), (1000, 0, 0), (0, 1000, 0), (0, 0, 0)]
)


@st.composite
def sets(draw, lowers, uppers):
    """Draw a zonotope beside the ranges of some inputs, on a grid of powers of two, so that its points are floats."""
    scales = [2.0 ** round(math.log2(u - a)) for a, u in zip(lowers, uppers, strict=True)]
    middles = [round(0.5 * (a + u) / s * 1024) for a, u, s in zip(lowers, uppers, scales, strict=True)]
    width = 2.0 ** -draw(st.sampled_from([10, 10, 12, 16, 30]))
    directions = draw(st.lists(DIRECTIONS | PARALLEL, min_size=0, max_size=5))
    rows = []
    for k, (s, m) in enumerate(zip(scales, middles, strict=True)):
        centre = (m + draw(st.integers(-700, 700))) / 1024 * s
        own = draw(st.sampled_from([0, 0, 64, 1000])) * width * s
        rows.append(np.array([[centre, own, *(d[k % 3] * width * s for d in directions)]]))
    return rows


def ranges(system):
    inputs = SystemSurface(system).plan.inputs
    return [v.lower for v in inputs], [v.upper for v in inputs]


def corners_and_others(rows, rng):
    """Return values of symbols and own errors."""
    width = rows[0].shape[-1] - 2
    for k in range(40):
        signs = rng.choice([-1, 1], width + len(rows)) if k < 24 else rng.integers(-16, 17, width + len(rows)) / 16
        yield [Fraction(float(e)) for e in signs[:width]], [Fraction(float(e)) for e in signs[width:]]


def check(system, rows, seed):
    """Check the planes of a system over a set against what its kernel returns."""
    try:
        planes = SystemSurface(system)(rows)
    except DomainError:
        return
    kernel, surface = compile(system, "python"), surface_of(SystemSurface(system).plan)
    for number, (symbols, own) in enumerate(corners_and_others(rows, np.random.default_rng(seed))):
        place = [at(r, symbols, e) for r, e in zip(rows, own, strict=True)]
        if any(Fraction(float(x)) != x for x in place):
            continue
        value = kernel(*map(float, place))
        outputs = value if isinstance(value, tuple) else (value,)
        for k, (plane, output) in enumerate(zip(planes, map(float, outputs), strict=True)):
            assert holds(plane, symbols, output), place
            if surface is not None and number % 8 == 0:
                clipped = [
                    x if v.extrapolate else min(max(x, Fraction(v.lower)), Fraction(v.upper))
                    for x, v in zip(place, surface.plan.inputs, strict=True)
                ]
                above, below = surface.sums(k, clipped)
                assert holds(plane, symbols, above / below), place


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=10)
@given(data=st.data(), seed=st.integers(0, 9))
def test_planes_of_shipped_systems_hold_their_values(name, data, seed):
    system = SHIPPED[name]
    check(system, data.draw(sets(*ranges(system))), seed)


SHIPPED = {
    n: load(RULES / f"{n}.fz", block={"loops/pendulum": "surface", "loops/water_tank": None}.get(n)) for n in NAMES
}


def random_table(rng):
    """Return a system that interpolates between knots, over a partition of unity or over terms that overlap more."""
    counts = rng.integers(2, 5, rng.integers(1, 4))
    is_partition = rng.integers(2)
    lines = ["system s", "and product", f"defuzzifier {'center_average' if is_partition else 'weighted_average'}"]
    names = "abc"[: len(counts)]
    for name, count in zip(names, counts, strict=True):
        peaks = np.sort(rng.choice(np.arange(-20, 21), count, replace=False)) / 16 * rng.choice([1, 1, 1000])
        reach = [peaks[0] * 2 - peaks[-1] - 1, *peaks, peaks[-1] * 2 - peaks[0] + 1]
        lines.append(f"input {name} in [{peaks[0]}, {peaks[-1]}]")
        for k in range(count):
            lower, upper = (reach[k], reach[k + 2]) if is_partition else (reach[0], reach[-1])
            lines.append(f"  T{k} = triangle({lower}, {peaks[k]}, {upper})")
    lines.append("output u in [-10, 10]")
    cells = list(np.ndindex(*counts))
    lines += [f"  C{k} = constant({rng.integers(-100, 101) / 10})" for k in range(len(cells))]
    for k, cell in enumerate(cells):
        condition = " and ".join(f"{n} is T{i}" for n, i in zip(names, cell, strict=True))
        lines.append(f"if {condition} then u is C{k}")
    return loads("\n".join(lines) + "\n")


@pytest.mark.parametrize("seed", range(sizes.examples(200, 24)))
def test_planes_of_tables_hold_their_values(seed):
    rng = np.random.default_rng(seed)
    system = random_table(rng)
    surface = SystemSurface(system)
    assert surface.grid is not None
    for _ in range(6):
        width = 2.0 ** -rng.choice([0, 1, 3, 6, 20])
        count = rng.integers(0, 5)
        rows = []
        for low, high in zip(*ranges(system), strict=True):
            size = 2.0 ** round(math.log2(high - low))
            centre = (rng.integers(-700, 700) / 1024) * size + round(0.5 * (low + high) / size * 1024) / 1024 * size
            own = rng.choice([0, 0, 16]) / 64 * width * size
            rows.append(np.array([[centre, own, *(rng.integers(-64, 65, count) / 128 * width * size)]]))
        if rng.integers(2) and len(rows) > 1:
            rows[1][0, 2:] = rows[0][0, 2:] * 2.0 ** rng.integers(-8, 3)  # a line
        check(system, rows, seed)


@settings(max_examples=8)
@given(data=st.data(), system=plain_systems() | systems())
def test_planes_of_all_systems_hold_their_values(data, system):
    check(system, data.draw(sets(*ranges(system))), 1)


def test_a_set_where_no_rule_may_fire_is_refused():
    text = "system s\ninput a in [0, 4]\n  L = triangle(0, 1, 2)\noutput u in [0, 1]\n  K = triangle(0, 0.5, 1)\n"
    text += "if a is L then u is K\n"
    for otherwise in ("", "error", "nan"):
        system = loads(text.replace("output u in [0, 1]", f"output u in [0, 1] {'else ' * bool(otherwise)}{otherwise}"))
        assert SystemSurface(system)([np.array([[1.0, 0.02]])])
        with pytest.raises(DomainError, match="value"):
            SystemSurface(system)([np.array([[2.0, 0.02]])])


def test_an_else_is_no_average_of_consequents_that_are_0_at_0():
    text = "system s\ndefuzzifier weighted_average\ninput x in [-4, 4]\n  Z = triangle(-1, 0, 1)\n"
    text += "output u in [-9, 9] else 5\n  L = linear(2, 0)\nif x is Z then u is L\n"
    for row in ([[2.0, 0.1, 0.5]], [[0.5, 0.0, 1.0]], [[0.25, 0.0, 0.25]]):
        check(loads(text), [np.array(row)], 0)
        is_inside = row[0][0] < 0.5
        assert (SystemSurface(loads(text)).rules([np.array(row)], 0) is not None) == is_inside


@settings(max_examples=60)
@given(
    data=st.data(), knots=st.lists(st.integers(-1500, 1500), max_size=4),
    tilt=st.sampled_from([0, 1e-15, 1e-9, 1e-4]), shift=st.sampled_from([0.0, 1.0, 1e6]),
)  # fmt: skip
def test_slabs_hold_a_plane_set(data, knots, tilt, shift):
    """Also one that is narrow, tilted, far from 0, or a line."""
    x, y = (r[0].copy() for r in data.draw(sets([-1.0, -1.0], [1.0, 1.0])))
    x[2:] = x[2:] * tilt if tilt else x[2:]
    x[1] = x[1] * tilt if tilt else x[1]
    x[0] += shift
    cuts, low, high = _slabs(x, y, np.array(sorted(k / 1024 for k in knots)))
    assert (np.diff(cuts) >= 0).all()
    places = list(corners_and_others([x[None], y[None]], np.random.default_rng(0)))
    for angle in np.linspace(0, 2 * np.pi, 16):  # corners of the polygon
        towards = np.cos(angle) * x[1:] / (np.abs(x[1:]).sum() or 1.0) + np.sin(angle) * y[1:] / (
            np.abs(y[1:]).sum() or 1.0
        )
        signs = [1 if t >= 0 else -1 for t in towards[1:]]
        places.append((signs, [np.sign(np.cos(angle)).astype(int).item(), np.sign(np.sin(angle)).astype(int).item()]))
    for symbols, own in places:
        px, py = at(x[None], symbols, own[0]), at(y[None], symbols, own[1])
        slab = [k for k in range(len(low)) if cuts[k] <= px <= cuts[k + 1]]
        assert slab
        assert any(low[k] <= py <= high[k] for k in slab)


CURVED = """
system s
input a in [-1, 1]
  terms N Z P
input b in [-1, 1]
  terms N Z P
output u in [-1, 1]
  terms N Z P
and product
defuzzifier center_average
table u = a x b
       N  Z  P
  N |  P  N  P
  Z |  N  P  N
  P |  P  Z  N
"""


def test_a_bent_surface_is_held_along_a_line_across_many_cells():
    system = loads(CURVED)
    kernel = compile(system, "python")
    for slope in (1.0, -1.0, 0.25, 3.0):
        rows = [np.array([[0.0, 0.0, 1.5]]), np.array([[0.125, 0.0, 1.5 * slope]])]
        (plane,) = SystemSurface(system)(rows)
        for e in np.linspace(-1, 1, 65):
            assert holds(plane, [e], float(kernel(1.5 * e, 0.125 + 1.5 * slope * e)))


def test_a_small_set_has_a_narrow_plane():
    """The plane follows the surface: within a cell what is left is of second order."""
    system = loads(CURVED)
    (plane,) = SystemSurface(system)([np.array([[0.5, 0.0, 0.01, 0.0]]), np.array([[0.5, 0.0, 0.0, 0.01]])])
    assert plane[0, 1] < 1e-3
    assert np.subtract(*ends(plane)[::-1])[0] > 1e-3


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_inputs_without_bound_are_refused(bad):
    with pytest.raises(DomainError):
        SystemSurface(loads(CURVED))([np.array([[0.0, bad]]), np.array([[0.0, 0.0]])])


INPUTS = """
input a in [-1, 1]
  {}
input b in [-1, 1]
  {}
"""
PARTITION = INPUTS.format(*["terms N Z P"] * 2)
CURVES = INPUTS.format(*["N = gaussian(-1, 0.5)\n  Z = gaussian(0, 0.4)\n  P = gaussian(1, 0.5)"] * 2)
TABLE = "table u = a x b\n       N  Z  P\n  N |  N  N  Z\n  Z |  N  Z  P\n  P |  Z  P  P\n"
SETS = "output u in [-1, 1]\n  N = triangle(-1, -0.5, 0)\n  Z = triangle(-0.4, 0, 0.4)\n  P = triangle(0, 0.5, 1)\n"
LINES = "output u in [-9, 9]\nif a is N then u is function(a - 2 * b)\nif a is Z then u is function(0.5 * b)\n"
LINES += "if a is P and b is Z then u is function(1 + a * b)\n"
#: Systems that are no tables, how often the planes of small sets may be wider than what simulation shows.
KINDS = {
    "min, max, centroid": ("and min\n", PARTITION + SETS + TABLE, 3.0),
    "min, sum, centroid": ("and min\nimplication min\naggregation sum\n",
                           PARTITION + SETS + TABLE, 3.0),
    "product, sampled": ("and product\nimplication product\naggregation max\ndefuzzifier centroid(resolution=51)\n",
                         CURVES + SETS + TABLE, 2.0),
    "average of centres": ("and min\ndefuzzifier center_average\n",
                           PARTITION + SETS + TABLE, 3.0),
    "curved terms": ("and product\ndefuzzifier weighted_average\n",
                     CURVES + "output u in [-1, 1]\n  terms N=-1 Z=0 P=1\n" + TABLE, 1.5),
    "linear consequents": ("and product\ndefuzzifier weighted_average\n", CURVES + LINES, 1.5),
    "weights of rules": (
        "and min\ndefuzzifier center_average\n",
        PARTITION + SETS + "if a is N then u is N weight 0.25\nif a is Z then u is Z weight 0.5\n"
        "if a is P then u is P\nif b is P then u is P weight 0.3\n", 3.0),
    "maxima": ("and min\ndefuzzifier mom\n", PARTITION + SETS + TABLE, math.inf),
    "inverses": ("and product\ndefuzzifier tsukamoto\n",
                 CURVES + "output u in [0, 1]\n  N = ramp(1, 0)\n  Z = ramp(0, 1)\n  P = ramp(0.2, 0.9)\n"
                 + TABLE, 1.5),
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_planes_of_systems_that_are_no_tables_hold_their_values(kind):
    """At 20,000 places each; they are not much wider than what these show."""
    methods, rest, wider = KINDS[kind]
    system = loads(f"system s\n{methods}{rest}")
    surface, kernel = SystemSurface(system), compile(system, "numpy")
    rng, widths = np.random.default_rng(1), []
    for size in (1.5, 0.5, 0.1, 0.1, 0.1, 0.1, 0.01, 0.01):
        centre = rng.uniform(-0.9, 0.9, 2)
        steps = rng.uniform(-1, 1, (2, 3)) * size / 3
        steps[1] = steps[0] * -0.7 if rng.integers(4) == 0 else steps[1]
        rows = [np.array([[c, own, *g]]) for c, g, own in zip(centre, steps, (0.0, 0.1 * size), strict=True)]
        symbols = rng.uniform(-1, 1, (5000 if size > 1 else 2000, 4))
        symbols[::2] = np.sign(symbols[::2])
        places = centre + symbols[:, :3] @ steps.T + np.outer(symbols[:, 3], [0.0, 0.1 * size])
        values = kernel.batch(places)
        (plane,) = surface(rows)
        rest = values - plane[0, 0] - symbols[:, :3] @ plane[0, 2:]
        assert (np.abs(rest) <= plane[0, 1] + 1e-13 * (1 + np.abs(values))).all()
        low, high = ends(plane)
        if size == 0.1 and np.ptp(values) > 0.02:
            widths.append(float(high[0] - low[0]) / np.ptp(values))
    assert np.exp(np.mean(np.log(widths or [1.0]))) <= wider


@pytest.mark.parametrize("seed", range(12))
def test_parts_hold_the_whole_set(seed):
    """Also where only a corner of a part is in the set, which is narrow for some seeds."""
    surface = SystemSurface(loads(f"system s\n{KINDS['average of centres'][0]}{KINDS['average of centres'][1]}"))
    rng = np.random.default_rng(seed)
    centre, steps = rng.uniform(-0.5, 0.5, 2), rng.uniform(-0.4, 0.4, (2, 3))
    steps[1] = steps[0] * rng.uniform(-2, 2) + 0.02 * steps[1] if seed % 2 else steps[1]
    low, high = surface._cut([np.array([[c, 0.01, *g]]) for c, g in zip(centre, steps, strict=True)])
    symbols = np.concatenate([rng.uniform(-1, 1, (3000, 5)), rng.choice([-1.0, 1.0], (1000, 5))])
    places = centre + symbols[:, :3] @ steps.T + 0.01 * symbols[:, 3:]
    inside = (places[:, None] + 1e-15 >= low.T) & (places[:, None] <= high.T + 1e-15)
    assert inside.all(-1).any(-1).all()
    assert low.shape[1] < 400


def test_a_curved_surface_is_held_to_many_digits():
    """Compared with the formula of the average in the arithmetic of arb."""
    text = (
        "system s\ndefuzzifier weighted_average\ninput a in [-2, 2]\n  N = gaussian(-1, 0.5)\n  P = gaussian(1, 0.75)\n"
    )
    system = loads(
        text + "output u in [-9, 9]\nif a is N then u is function(1 - 3 * a)\nif a is P then u is function(a)\n"
    )
    surface = SystemSurface(system)
    for size in (1.0, 2.0**-6, 2.0**-30, 2.0**-44):
        for centre in (-0.75, 0.0, 0.5):
            (plane,) = surface([np.array([[centre, 0.0, size]])])
            for e in np.linspace(-1, 1, 33):
                x = arb(Fraction(centre) + Fraction(float(e)) * Fraction(size))
                n = (-((x + 1) ** 2) / (2 * arb("0.25"))).exp()
                p = (-((x - 1) ** 2) / (2 * arb("0.5625"))).exp()
                assert holds(plane, [e], (n * (1 - 3 * x) + p * x) / (n + p)), (size, centre, e)


def test_slopes_of_a_curved_surface_hold_its_differences():
    methods, rest, _ = KINDS["linear consequents"]
    system = loads(f"system s\n{methods}{rest}")
    surface, kernel = SystemSurface(system), compile(system, "numpy")
    rng = np.random.default_rng(2)
    for size in (0.8, 0.1, 0.01):
        centre = rng.uniform(-0.2, 0.2, 2)
        low, high = ends(surface.gradients([np.array([[c, size]]) for c in centre], 0))
        for side in (0, 1):
            places = centre + rng.uniform(-size, size, (2, 2000, 2))
            places[1, :, 1 - side] = places[0, :, 1 - side]
            apart = np.diff(places[..., side], axis=0)[0]
            slopes = np.diff([kernel.batch(p) for p in places], axis=0)[0] / apart
            slopes = slopes[np.abs(apart) > 1e-3 * size]
            assert low[:, side].min() - 1e-9 <= slopes.min()
            assert slopes.max() <= high[:, side].max() + 1e-9


@pytest.mark.parametrize("kind", ["average of centres", "min, max, centroid"])
@np.errstate(all="ignore")
def test_values_that_are_0_change_no_bound(kind):
    """Over boxes in which terms begin at 0, and in which they are 0."""
    system = loads(f"system s\n{KINDS[kind][0]}{KINDS[kind][1]}")
    boxed = SystemSurface(system)._boxed
    for low, high in (((0.0, 0.0), (1.0, 1.0)), ((0.0, -1.0), (0.5, 0.0)), ((0.25, 0.25), (0.5, 0.75))):
        sides = list(boxed.inputs_of(np.array(low)[:, None], np.array(high)[:, None], sloped=True).values())
        (sparse,), (full,) = (boxed.evaluate(sides, [0], sparse=s)[0] for s in (True, False))
        assert np.allclose([sparse.lo, sparse.hi], [full.lo, full.hi], atol=1e-12)
