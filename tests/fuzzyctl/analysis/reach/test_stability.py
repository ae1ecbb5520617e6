"""What is proved to converge does: derivatives hold difference quotients, and norms those of products."""

import math
import sys

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import Proved, loads
from fuzzyctl.analysis.reach import reach
from fuzzyctl.analysis.reach.forms import ends, interval
from fuzzyctl.analysis.reach.prover import LoopProver, stability
from fuzzyctl.analysis.reach.reach import ReachableSets
from fuzzyctl.analysis.reach.surfaces import SystemSurface
from fuzzyctl.simulation.expansion import loop_equations
from tests.fuzzyctl.analysis.reach.loops import FUZZY, TANK


def verdicts(text, timeout=20.0):
    loop = loads(text, block="l")
    looking = LoopProver(loop, timeout)
    return [looking.verdict(c) for c in loop.guarantees]


def is_stable(text, timeout=20.0):
    return [isinstance(v, Proved) for v in verdicts(text, timeout)] == [True]


def sets_of(text):
    return ReachableSets(loop_equations(loads(text, block="l")), 0, np.zeros((1, 0)))


def boxed(low, high):
    return [interval(np.array([a]), np.array([b])) for a, b in zip(low, high, strict=True)]


STEEP = """
system steep
and product
defuzzifier center_average
input e in [-1, 1]
  terms A@-1 B@-0.0000004 C@0 D@0.4 E@1
input d in [-1, 1]
  terms N P
output u in [-1, 1]
  terms low@-1 z@0 m@0.3 high@1
table u = e x d
       N     P
  A |  low   z
  B |  low   low
  C |  high  m
  D |  z     m
  E |  high  high
"""


def test_gradients_hold_difference_quotients_beside_narrow_cells():
    """The cell between B and C has a part of 2e-7 of the range."""
    surface, system = SystemSurface(loads(STEEP)), fuzzyctl.compile(loads(STEEP))
    random = np.random.default_rng(3)
    for scale in (3e-7, 1e-3, 1.5):
        for _ in range(8):
            low = random.uniform(-scale, scale, 2)
            high = low + random.uniform(0, scale, 2)
            low_slope, high_slope = ends(surface.slopes(boxed(low, high))[0])
            corners = surface.gradients(boxed(low, high), 0)[..., 0]
            for _ in range(10):
                a, b = random.uniform(low, high), random.uniform(low, high)
                b[1] = a[1]
                quotient = (system(*a) - system(*b)) / (a[0] - b[0])
                assert low_slope[0] <= quotient + 1e-7 * abs(quotient)
                assert quotient <= high_slope[0] + 1e-7 * abs(quotient)
            for turn in np.linspace(0, 2 * math.pi, 7):  # the hull of the corners is wide enough in each direction
                aim = np.array([math.cos(turn) * scale, math.sin(turn)])
                moved = random.uniform(low, high)
                step = 1e-3 * (high - low) * np.sign(aim)
                inside = np.clip(moved + step, low, high)
                rise = system(*inside) - system(*moved)
                assert rise <= (corners @ (inside - moved)).max() + 1e-12


def test_an_input_that_acts_differently_within_a_period_counts():
    """X' = A X + B(t) with a turning A: B may have the sign of what multiplies it at each time."""
    length, r = 2.2, 0.1
    a = np.zeros((2, 2, 2))
    a[0, 1, 0], a[1, 0, 0] = 1.0, -1.0
    b = np.zeros((2, 1, 2))
    b[..., 1] = r
    s = np.linspace(0.0, length, 10001)
    worst = r * np.trapezoid(np.abs(np.cos(s)) + np.abs(np.sin(s)), s)
    assert ends(reach._driven(a, b, length))[1][0, 0] >= worst
    exact = reach._series(a, np.stack([np.eye(2), np.zeros((2, 2))], -1), 1.0, 1)
    assert np.all(np.abs(exact[..., 0] - [[math.cos(1), math.sin(1)], [-math.sin(1), math.cos(1)]]) <= exact[..., 1])
    assert float(exact[..., 1].max()) < 1e-3


#: A plant that turns, whose input acts by its state, and a controller that bends.
TURNING = """
controller law
input x
state s = 0.1
next s = 0.5 * s + clamp(x, -0.2, 0.3)
output u = abs(x - 0.1) + s * x
every 1.5 s
plant p
input u
state x = 0.2
state v = 0
der x = v
der v = -x - 0.3 * v + u * (1 + sin(x))
output y = x
loop l
block law = law(p.y)
block p = p(law.u)
run 9 s
"""


def difference_holds(vertices, apart, difference, aims, slack):
    """Check that a difference is one of the vertices' hull times how far two points are apart."""
    for aim in aims:
        reach = vertices[..., 0] @ apart @ aim + (vertices[..., 1] @ np.abs(apart)) @ np.abs(aim)
        assert difference @ aim <= reach.max() + slack @ np.abs(aim)


@pytest.mark.parametrize("chords", [False, True])
@pytest.mark.parametrize(("text", "low", "high"), [
    (TURNING, [-0.2, -0.3, -0.2], [0.3, 0.3, 0.4]),
    (TANK, [0.3, -0.2], [0.5, 0.2]),
    (FUZZY, [-0.3, -0.3], [0.5, 0.4]),
])  # fmt: skip
def test_the_vertices_of_a_period_hold_difference_quotients(text, low, high, chords):
    sets = sets_of(text)
    random = np.random.default_rng(1)
    for _ in range(2):
        c = random.uniform(low, high)
        about = list(map(float, c)) if chords else None
        vertices = reach.period_slopes(sets, boxed(low, high), [], about)
        for _ in range(3):
            a, b = random.uniform(low, high), c if chords else random.uniform(low, high)
            images = [reach.image(sets, [np.array([[x, 0.0]]) for x in z], []) for z in (a, b)]
            first, second = (np.array([r[0, 0] for r in rows]) for rows in images)
            slack = 1e-9 + sum(np.array([np.abs(r[0, 1:]).sum() for r in rows]) for rows in images)
            aims = (*np.eye(len(low)), random.normal(size=len(low)))
            difference_holds(vertices, a - b, first - second, aims, slack)


def test_bends_that_reach_no_state_are_left_out():
    """A claim about a bend, and one that is multiplied by 0."""
    text = "controller c\ninput y\nlet a = abs(y)\noutput u = -y + 0 * max(y, a)\noutput w = a\nevery 100 ms\n"
    text += "plant p\ninput u\nstate x = 1\nder x = u\noutput y = x\nloop l\nblock c = c(p.y)\nblock p = p(c.u)\n"
    assert is_stable(text + "for p.x in [-1, 1]\nrun 5 s\nrequire stable\n")


#: Systems and a plant, each of whose derivatives is one kind of function.
KINDS = """
system surface
and product
defuzzifier center_average
input e in [-1, 1]
  terms N@-1 Z@0 S@0.3 P@0.9
input d in [-1, 1]
  terms N Z P
output u in [-1, 1]
  terms a@-1 b@-0.4 c@0 d@0.7 e@1
table u = e x d
       N  Z  P
  N |  a  b  e
  Z |  d  c  a
  S |  b  e  d
  P |  c  a  b
system model
defuzzifier weighted_average
input x in [-2, 2]
  near = function(1 - abs(x) / 2)
  far  = function(abs(x) / 2)
input u in [-90, 90]
output f in [-9, 9]
if x is near then f is function(2 * x - u)
if x is far then f is function(x - 3 * u / 7 + 0.1 * sin(u))
system law
defuzzifier weighted_average
input x in [-2, 2]
  near = function(1 - abs(x) / 2)
  far  = function(abs(x) / 2)
input y in [-2, 2]
output u in [-9, 9]
if x is near then u is function(x + y)
if x is far then u is function(5 * x - y / 3)
plant p
state x = 0.1
state y = 0
state z = 0
der x = {}
der y = {}
der z = {}
output o = x
loop l
block p = p()
run 1 s step 100 ms
"""


@pytest.mark.parametrize("about", ["drawn", "zero", "near"])
@pytest.mark.parametrize("formulas", [
    ("x * y", "x * x * z", "x / (2 + y)"),
    ("sin(x) * cos(y)", "sqrt(2 + x) * y", "exp(x) * log(3 + y) ^ 2"),
    ("clamp(3 * x, -0.5, 0.4)", "max(x + 0.5, y, z - 0.2)", "min(x, y + 0.1) + abs(y)"),
    ("surface(x, y)", "surface(x - 2 * y, z)", "x * surface(0.3 * z, x)"),
    ("model(x, law(x, y))", "model(x, y) * z + law(x, z)", "law(x, y) / (1 + x ^ 2)"),
    ("model(x, law(x, law(x, y)))", "where(x > 5, 1, y)", "sin(x - y)"),
])  # fmt: skip
def test_vertices_of_equations_hold_chords(formulas, about):
    sets = sets_of(KINDS.format(*formulas))
    random = np.random.default_rng(11)
    nodes = sets.flow.nodes

    def rates(z):
        values = stability.Series(nodes, [0.0, *map(float, z)]).extend()
        return np.array([float(v) if isinstance(v, float) else v[0, 0] for v in values])

    for _ in range(2):
        low, high = np.sort(random.uniform(-0.7, 0.9, (2, 3)), 0)
        if about == "drawn":
            c = random.uniform(low, high)
            around = list(map(float, c))
        elif about == "zero":
            low, high = np.minimum(low, -0.1), np.maximum(high, 0.1)
            c, around = np.zeros(3), [0.0] * 3
        else:  # the point lies anywhere within an interval
            c = random.uniform(low, high)
            width = 10.0 ** random.uniform(-9, -2)
            around = boxed(c - width * random.uniform(0, 1, 3), c + width * random.uniform(0, 1, 3))
            low, high = low - width, high + width
        for point in (around, None):
            try:
                vertices = reach.flow_slopes(sets, boxed(low, high), [], point)
            except stability.DomainError:
                assert "model" in formulas[0]  # derivatives of curved weights may have no bound
                continue
            for _ in range(6):
                z = random.uniform(low, high)
                if random.uniform() < 0.3:
                    z = np.where(random.uniform(size=3) < 0.5, low, z)
                aims = (*np.eye(3), *-np.eye(3), random.normal(size=3))
                difference_holds(vertices, z - c, rates(z) - rates(c), aims, np.full(3, 1e-9))


def test_products_of_weights_lie_in_the_hull_of_raised_coefficients():
    random = np.random.default_rng(2)
    for keys in (["a", "a"], ["a", "b", "a"], [None, "a", "a"], ["a", "a", "a"], ["a", "a", "b", "b"], [None, "b"]):
        sizes = {key: int(random.integers(2, 4)) for key in keys}
        grid = random.normal(size=(*(sizes[k] for k in keys), 2, 2, 2)) * [1.0, 0.0]
        raised = sys.modules[stability.Slopes.__module__]._raised(grid, keys, 256)
        for _ in range(50):
            weights = {key: random.dirichlet(np.full(n, 0.5)) for key, n in sizes.items()}
            total = grid[..., 0]
            for key in keys:
                total = np.tensordot(weights[key], total, (0, 0))
            aim = random.normal(size=(2, 2))
            assert (total * aim).sum() <= (raised[..., 0] * aim).sum((1, 2)).max() + 1e-12


def common_basis(centres, continuous):
    bases = stability.common_bases([centres], [np.eye(centres.shape[-1])], continuous)
    return None if bases is None else bases[0]


@pytest.mark.parametrize("continuous", [False, True])
def test_norms_in_common_coordinates_bound_switching_families(continuous):
    """Drawn families: where a common quadratic function is found, no member and no product of members grows."""
    random = np.random.default_rng(5)
    found = 0
    for _ in range(40):
        n, count = random.integers(1, 5), random.integers(1, 5)
        centres = random.normal(size=(count, n, n)) * random.uniform(0.1, 0.9)
        if continuous:
            centres = centres - random.uniform(0, 2) * np.eye(n)
        vertices = np.stack([centres, 0.02 * random.uniform(size=centres.shape)], -1)
        basis = common_basis(centres, continuous)
        if basis is None:
            # None exists, if no family of a single matrix is refused that converges.
            modes = np.linalg.eigvals(centres)
            growth = modes.real.max() if continuous else np.abs(modes).max() - 1.0
            assert count > 1 or growth > -1e-3
            continue
        bound = stability.growth_bound if continuous else stability.norm_bound
        rate = max(bound(v, basis) for v in vertices)
        inverse = np.linalg.inv(basis)
        for _ in range(20):
            weights = random.dirichlet(np.ones(count))
            member = np.einsum("v,vij->ij", weights, centres + vertices[..., 1] * random.choice([-1, 1], (n, n)))
            turned = inverse @ member @ basis
            if continuous:
                assert np.linalg.eigvalsh(turned + turned.T)[-1] / 2 <= rate
                assert np.linalg.eigvals(member).real.max() <= rate + 1e-12
            else:
                assert np.linalg.norm(turned, 2) <= rate
                assert np.abs(np.linalg.eigvals(member)).max() <= rate + 1e-12
        found += rate < (0.0 if continuous else 1.0)
    assert found > 10


def test_a_common_function_is_found_where_one_is_known():
    """Two modes that share a function only in a narrow range: s = 1 +- k of a double integrator with a sector."""
    a = np.array([[0.0, 1.0], [-1.0, -1.0]])
    b, c = np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])
    # Re 1 / (1 + k G) > 0: the circle criterion holds for gains in (-k, k) iff k |G(iw)| < 1, at most 2 / sqrt(3).
    for k, holds in ((0.5, True), (0.86, True), (0.87, False)):
        basis = common_basis(np.stack([a + k * b @ c, a - k * b @ c]), True)
        assert (basis is not None) == holds, k


def test_a_state_that_leaves_its_range_is_not_stable():
    text = "plant p\nstate x in [{}, 2] = 1\nder x = -x\noutput y = x\nloop l\nblock p = p()\nrun 10 s step 100 ms\n"
    assert not is_stable(text.format(0.5) + "require stable\n", 0.1)
    assert is_stable(text.format(-0.5) + "require stable\n")


@pytest.mark.parametrize(("start", "true"), [(0.9, True), (3, False)])
def test_a_model_whose_rules_end_is_stable_where_they_fire(start, true):
    """Beyond 1 the output is 5, which no average of the rules is."""
    text = f"""
system ts
defuzzifier weighted_average
input x in [-9, 9]
  Z = triangle(-1, 0, 1)
output u in [-9, 9] else 5
  L = linear(-2, 0)
if x is Z then u is L
plant p
state x = 0
let u = ts(x)
der x = u
output y = x
loop l
block p = p()
for p.x in [-{start}, {start}]
require stable
run 1 s step 100 ms
"""
    loop = loads(text, block="l")
    assert isinstance(LoopProver(loop, 2.0).verdict(loop.guarantees[0]), Proved) == true


def test_a_ball_that_contracts_but_moves_is_not_enough():
    """Distances shrink below x = 2, but nothing is at rest: x grows without limit."""
    text = "plant p\nstate x = 0\nder x = 1 - 0.5 * x + x * x / {}\noutput y = x\nloop l\nblock p = p()\n"
    text += "for p.x in [-0.1, 0.1]\nrun 10 s step 100 ms\nrequire stable\n"
    assert not is_stable(text.format(8), 0.3)
    assert is_stable(text.format(40))


def test_a_loop_of_controllers_alone_converges():
    text = "controller c\nstate s = 0.5\nnext s = {} * s\noutput u = s\nevery 1 s\nloop l\nblock c = c()\nrun 9 s\n"
    assert is_stable(text.format(0.5) + "require stable\n")
    assert not is_stable(text.format(1.001) + "require stable\n", 0.1)


def lure(gain, table):
    """A damped oscillator with a static table in the way back: |G| is at most 2 / sqrt(3)."""
    knots = " ".join(f"t{k}@{x!r}" for k, (x, _) in enumerate(table))
    heights = sorted({gain * y for _, y in table})
    peaks = " ".join(f"u{k}@{y!r}" for k, y in enumerate(heights))
    rows = "".join(f"if e is t{k} then u is u{heights.index(gain * y)}\n" for k, (_, y) in enumerate(table))
    return (
        "system tab\nand product\ndefuzzifier center_average\n"
        f"input e in [{table[0][0]}, {table[-1][0]}]\n  terms {knots}\n"
        f"output u in [-9, 9]\n  terms {peaks}\n{rows}"
        "plant p\nstate x = 0.1\nstate v = 0\nder x = v\nder v = -x - v - tab(x)\noutput y = x\n"
        "loop l\nblock p = p()\nfor p.x in [-2, 2]\nrun 10 s step 100 ms\nrequire stable\n"
    )


#: Chords of a zigzag lie in [-1, 1], its slopes do not.
ZIGZAG = [
    (-4.0, 4.0),
    (-2.0, -2.0),
    (-1.9, 1.9),
    (-0.1, -0.1),
    (0.0, 0.0),
    (0.1, 0.1),
    (1.9, -1.9),
    (2.0, 2.0),
    (4.0, -4.0),
]


def test_the_circle_criterion_takes_the_sector_of_a_table():
    """The point of rest attracts all if the sector is [-k, k] and k |G| < 1, which is k < 0.866."""
    (verdict,) = verdicts(lure(0.85, ZIGZAG))
    assert isinstance(verdict, Proved)
    assert "point of rest" in verdict.note
    assert not is_stable(lure(0.88, ZIGZAG), 0.1)
    assert not is_stable(lure(-1.2, [(-3.0, -3.0), (0.0, 0.0), (3.0, 3.0)]), 0.1)


def test_parts_of_a_family_have_functions_that_the_whole_has_not():
    """An oscillator whose stiffness may not change at will: damping 0.2 at least, but a constant one each."""
    plant = "param a = 1\nstate x = 0.1\nstate v = 0\nder x = v\nder v = -a * x - {} * v\noutput y = x\n"
    text = f"plant p\n{plant}loop l\nblock p = p()\nfor p.a in [0.2, 4]\nrun 10 s step 100 ms\nrequire stable\n"
    (verdict,) = verdicts(text.format(0.4))
    assert isinstance(verdict, Proved)
    assert "boxes" in verdict.note
    assert not is_stable(text.format(0.0), 0.3)
    assert not is_stable(text.format(0.4).replace("in [0.2", "in [-0.01"), 0.3)
