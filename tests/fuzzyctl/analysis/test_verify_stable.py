"""The checker of certificates of convergence: balls, the slopes over them, and what they say of runs."""

import copy
import json
import math
import random
from fractions import Fraction

import pytest

from tests.commands import runner
from tests.fuzzyctl.analysis.reach.loops import FUZZY
from tests.fuzzyctl.analysis.test_verify import (
    ROOT,
    Simulated,
    attack,
    certificate,
    changed,
    prove,
    refused,
    shows,
    simple,
    table_at,
    verify,
)

#: A plant that a law pushes with kinks and a memory, to a point of rest at 0.
TURNS = """
controller law
input x
state s = 0.01
next s = 0.5 * s + 0.2 * clamp(x, -0.01, 0.3)
output u = -0.2 * abs(x) - 0.5 * x - s * exp(x)
every 100 ms
plant p
input u
param k in [0, 2] = 1
state x = 0.2
state v in [-2, 2] = 0
der x = v
der v = -x - 1.5 * v + k * u * (1 + 0.2 * sin(x)) - 0.1 * v * sqrt(2 + x)
output y = x
loop l
block law = law(p.y)
block p = p(law.u)
for p.x in [-0.02, 0.01]
for p.k in [0.9, 1]
for p.v in [-0.02, 0.02]
for law.s in [0, 0.01]
require stable
run 9 s
"""
#: A plant alone, whose point of rest depends on a param.
ALONE = """
plant p
param a in [0, 2] = 1
state x = 0.5
state z = 1
der x = -sin(x) / (1 + x ^ 2) + 0.1 * cos(z)
der z = a * cos(x) - sqrt(1 + z) - exp(z) + 2
output y = x
loop l
block p = p()
for p.x in [0.08, 0.09]
for p.z in [0.55, 0.56]
for p.a in [0.999, 1]
run 1 s step 100 ms
require stable
"""
#: A controller alone.
KEEPS = """
controller law
input d
param a in [0, 1] = 0.5
state s = 0
state r = 1
next s = a * s + 0.1 * r + 0.2
next r = 0.3 * abs(r) - 0.4 * s
output y = s
every 1 s
loop l
block law = law(d=1)
for law.a in [0.3, 0.6]
for law.s in [-1, 1]
require stable
run 20 s
"""
TEXTS = {
    "turns": TURNS,
    "alone": ALONE,
    "keeps": KEEPS,
    "fuzzy": FUZZY[: FUZZY.rindex("for pendulum.th")] + "for pendulum.th in [-0.05, 0.05]\nrun 5 s\nrequire stable\n",
}


@pytest.fixture(scope="module")
def certificates():
    known = {}

    def of(name):
        if name not in known:
            known[name] = certificate(TEXTS[name])
        return copy.deepcopy(known[name])

    return of


# Slopes, and matrices of intervals.


def whole(v, x):
    return round(Fraction(x) * v.ONE)


def inside(v, low, high):
    return [whole(v, (low + high) / 2), whole(v, (high - low) / 2) + 1]


def chords_hold_all(v):
    rng = random.Random(4)
    for k in range(40):
        knots = [sorted(rng.sample(range(-4, 5), rng.choice((2, 3, 5)))) for _ in range(2)]
        values = [[rng.randrange(-9, 10) for _ in knots[1]] for _ in knots[0]]
        boxes = [[sorted(rng.uniform(-6, 6) for _ in range(2)) for _ in range(2)] for _ in range(2)]
        if k % 2:  # from a small box, at a knot
            boxes[1] = [[a[1] - 1e-3, a[1] + 1e-3] for a in knots]
        xs, ys = ([inside(v, *side) for side in box] for box in boxes)
        slopes = [v.ends(s) for s in v.chords(v.number([knots, values]), xs, ys)]
        for _ in range(60):
            x, y = ([rng.choice((*side, rng.uniform(*side))) for side in box] for box in boxes)
            if k % 3 == 0:
                x[0] = y[0] + rng.uniform(-1e-3, 1e-3)  # beside each other
            for axis, path in ((0, [[x[0], x[1]], [y[0], x[1]]]), (1, [[y[0], x[1]], [y[0], y[1]]])):
                rise = table_at(knots, values, path[0]) - table_at(knots, values, path[1])
                apart = x[axis] - y[axis]
                if abs(apart) > 1e-6 and boxes[0][axis][0] <= x[axis] <= boxes[0][axis][1]:
                    low, high = slopes[axis]
                    assert low / v.ONE - 1e-7 <= rise / apart <= high / v.ONE + 1e-7


def units_of_chords_count(v):
    """The slope of a table of numbers of some units is not a whole number of units."""
    rng = random.Random(7)
    for _ in range(200):
        knots, values = [sorted(rng.sample(range(50), 4))], [rng.randrange(50) for _ in range(4)]
        xs, ys = ([[rng.randrange(50), rng.randrange(3)]] for _ in range(2))
        ((low, high),) = map(v.ends, v.chords((knots, values), xs, ys))
        for x in (xs[0][0] - xs[0][1], xs[0][0] + xs[0][1]):
            for y in (ys[0][0] - ys[0][1], ys[0][0] + ys[0][1]):
                f = [exactly(knots[0], values, z) for z in (x, y)]
                assert x == y or low <= (f[0] - f[1]) / (x - y) * v.ONE <= high


def exactly(knots, values, x):
    x = Fraction(min(max(x, knots[0]), knots[-1]))
    i = max(j for j in range(len(knots) - 1) if knots[j] <= x)
    return values[i] + (values[i + 1] - values[i]) * (x - knots[i]) / (knots[i + 1] - knots[i])


#: Operations by what they read: of each two numbers, and the node of the derivative.
OPERATIONS = {
    "+": lambda a, b: a + b,
    "*": lambda a, b: a * b,
    "abs": lambda a, b: abs(a),
    "inverse": lambda a, b: 1 / a,
    "sqrt": lambda a, b: math.sqrt(a),
    "exp": lambda a, b: math.exp(a),
    "sin": lambda a, b: math.sin(a),
    "cos": lambda a, b: math.cos(a),
}


def loop_of(v, nodes):
    claims = [["c", [[[0, 0]]], 0, 0]]
    return v.Loop(simple(v, [0, 1], start=[[0, 0]] * 2, steps=[], nodes=nodes, claims=claims))


def slopes_hold_differences(v):
    rng = random.Random(5)
    for name, f in OPERATIONS.items():
        nodes = [[name, 0, 1]] if name in "+*" else [[name, 0, 2]]
        nodes = {"sin": [["sin", 0, 3], ["cos", 0, 2]], "cos": [["cos", 0, 3], ["sin", 0, 2]]}.get(name, nodes)
        loop = loop_of(v, nodes)
        for _ in range(30):
            least = 0.1 if name in ("inverse", "sqrt") else -3.0
            boxes = [[sorted(rng.uniform(least, 3) for _ in range(2)) for _ in range(2)]]
            boxes.append([[rng.uniform(*side)] * 2 for side in boxes[0]])
            if rng.random() < 0.5:
                boxes[1] = [sorted(rng.uniform(*side) for _ in range(2)) for side in boxes[0]]
            x, y = (loop.series(v.keyed(state=[inside(v, *side) for side in box])) for box in boxes)
            slopes = [(j, [e / v.ONE for e in v.ends(s)]) for j, s in loop.slopes(x, y, 2)]
            assert len(slopes) == (2 if name in "+*" else 1)
            for _ in range(20):
                a, b = ([rng.choice((*side, rng.uniform(*side))) for side in box] for box in boxes)
                rise = f(*a) - f(*b)
                moves = [sorted((low * (a[j] - b[j]), high * (a[j] - b[j]))) for j, (low, high) in slopes]
                assert sum(m[0] for m in moves) - 1e-9 <= rise <= sum(m[1] for m in moves) + 1e-9
    # The root of a negative number has no slope, and a derivative has to be the node's.
    box = v.keyed(state=[inside(v, -0.5, 2), inside(v, 1, 1)])
    for nodes in ([["sqrt", 0]], [["sin", 0, 2], ["cos", 0, 2]], [["held", 0]], [["table", 0, 0]]):
        loop = loop_of(v, nodes)
        x, y = loop.series(box), loop.series(v.keyed(state=[inside(v, 1, 1)] * 2))
        with pytest.raises((AssertionError, LookupError)):
            loop.slopes(x, y, 2)


def steps_hold_what_moves(v):
    """d' = A d, for an A that turns or not, and with rows that change in time."""
    one = v.ONE
    for length in (0.01, 1.0, 5.0):
        turn = v.evolved([[[0, 0], [one, 0]], [[-one, 0], [0, 0]]], whole(v, length))
        for row, true in zip(turn, [[math.cos(length), math.sin(length)], [-math.sin(length), math.cos(length)]],
                             strict=True):  # fmt: skip
            for a, x in zip(row, true, strict=True):
                low, high = v.ends(a)
                assert low / one - 1e-14 <= x <= high / one + 1e-14
                assert high - low < one // 10**10
    low, high = v.ends(v.evolved([[[one, 0]]], one)[0][0])
    assert low <= Fraction("2.7182818284590452353602874713526624977572") * one <= high
    with pytest.raises(AssertionError):  # the second term is small, the third is not
        v.evolved([[[0, 0], [2**40 * one, 0]], [[one >> 90, 0], [0, 0]]], one)
    r, length = 0.1, 2.2
    driven = v.evolved([[[0, 0], [one, 0], [0, whole(v, r)]], [[-one, 0], [0, 0], [0, whole(v, r)]],
                        [[0, 0]] * 3], whole(v, length))  # fmt: skip
    times = [length * k / 4000 for k in range(4001)]
    worst = sum(r * (abs(math.cos(t)) + abs(math.sin(t))) for t in times[1:-1]) * length / 4000
    assert v.ends(driven[0][2])[1] / one >= worst


def norms_are_those_of_matrices(v):
    rng = random.Random(6)
    for _ in range(60):
        a, b, c, d = (rng.uniform(-1, 1) for _ in range(4))
        f, g = a * a + b * b + c * c + d * d, a * d - b * c
        norm = math.sqrt((f + math.sqrt(max(f * f - 4 * g * g, 0))) / 2)
        matrix = [[[whole(v, a), 0], [whole(v, b), 0]], [[whole(v, c), 0], [whole(v, d), 0]]]
        assert v.shrinks(matrix, whole(v, norm + 1e-9))
        assert not v.shrinks(matrix, whole(v, norm - 1e-9))
        for i in range(2):
            for k in range(2):
                wide = copy.deepcopy(matrix)
                wide[i][k][1] = whole(v, 0.1)
                assert not v.shrinks(wide, whole(v, norm + 0.09))
                assert v.shrinks(wide, whole(v, norm + 0.11))
    third = [[[whole(v, 1 / 3), 0]] * 3] * 3  # its norm is 1, its entries are small
    assert not v.shrinks(third, whole(v, 1 - 1e-9))
    assert v.shrinks(third, whole(v, 1 + 1e-9))
    assert not v.shrinks([[[0, 0]]], 0)
    assert not v.shrinks([[[0, 0]]], -v.ONE)
    for w, b, proved in ((1.0, 0.9, True), (2.0, 0.45, True), (1.0, 2.1, False), (1.0, -1.0, False), (0, 0, False)):
        try:
            stretch = v.least_stretch([[whole(v, w)]], [[whole(v, b)]])
        except AssertionError:
            assert not proved
        else:
            assert proved
            assert 0 < stretch <= abs(w * b) * v.ONE
    for w, b in (
        ([[v.ONE, 0]], [[v.ONE], [0]]),
        ([[v.ONE]], [[v.ONE, 0]]),
        ([[v.ONE, 0], [0]], [[v.ONE, 0], [0, v.ONE]]),
    ):
        with pytest.raises((AssertionError, IndexError)):
            v.least_stretch(w, b)


# Balls.


def settling(v, nodes, *, rates=(), following=(), held=(), start, form, tube=(), vary=(), parts=1, **more):
    """Return a part whose claim is convergence; the form is basis, centre, radius, near and rate."""
    basis, centre, *sizes = form
    inverse = basis if len(centre) > 1 else [[1 / basis[0][0]]]
    period = {"tables": {}, "parts": [{"tube": [*tube], "order": 4, "apart": []}] * parts}
    ball = {"form": [basis, inverse, centre, sizes], "periods": [period, period], "vary": [*vary]}
    part = simple(v, rates, start=start, steps=[], nodes=nodes, held=held, following=following,
                  claims=[["stable", v.CONVERGES, 0, None]])  # fmt: skip
    part["proofs"][0]["ball"] = ball
    return part | more


def memory(v, gain=0.5, start=(1.5, 2.5), form=([[1.0]], [2.0], 1.0, 1.0, 0.6), **more):
    """m' = 2 + gain (m - 2)."""
    nodes = [["memory", 0], ["const", gain], ["*", 0, 1], ["const", 2 - 2 * gain], ["+", 2, 3]]
    return settling(v, nodes, following=[4], start=[list(start)], form=form, **more)


def balls_hold_their_runs(v):
    unit = [[1.0]]
    assert shows(v, memory(v))
    for form, proved in (
        ((unit, [2.2], 1.0, 1.0, 0.6), True),  # 2 is a fixed point, not the centre
        ((unit, [3.5], 2.5, 1.8, 0.6), False),
        ((unit, [2.0], 0.4, 0.4, 0.6), False),  # the start
        ((unit, [2.0], 1.0, 1e-9, 0.6), True),  # a near ball
        ((unit, [2.2], 1.0, 1e-9, 0.6), False),
        ((unit, [2.0], 1.0, 2.0, 0.6), False),
        ((unit, [2.0], 1.0, -1.0, 0.6), False),
        ((unit, [2.0], 1.0, 1.0, 0.4), False),  # the rate
        ((unit, [2.0], 1.0, 1.0, 1.0), False),
        ((unit, [2.0], 1.0, 1.0, -0.6), False),
        (([[1e3]], [2.0], 1e-3, 1e-3, 0.6), True),  # another form
        (([[1e3]], [2.0], 4e-4, 4e-4, 0.6), False),
        (([[1e-3]], [2.0], 1e3, 1e3, 0.6), True),
        ((unit, [2.0, 1.0], 1.0, 1.0, 0.6), False),
        ((unit, [], 1.0, 1.0, 0.6), False),
    ):
        assert shows(v, memory(v, form=form)) == proved, form
    for gain, rate in ((-0.5, 0.6), (1.0, 0.999), (1.0, 1.0), (1.5, 0.9), (-1.5, 0.9), (1.0001, 1.5), (2.0, 2.5)):
        assert shows(v, memory(v, gain, form=(unit, [2.0], 1.0, 1.0, rate))) == (abs(gain) < 1), gain
    # The inverse has to be one: with 0.4 for it, or 0, lengths would be others.
    for inverse in ([[0.4]], [[0.0]], [[-1.0]], [[1.0, 0.0]], []):
        part = memory(v, start=(-1, 5))
        part["proofs"][0]["ball"]["form"][1] = inverse
        assert not shows(v, part)
    for node in (["+", 2, 3, 0], ["*", 2, 3, 0]):  # neither a sum of three, nor of the first two
        part = memory(v)
        part["nodes"][-1] = node
        assert not shows(v, part)
    for sizes in ([1.0, 1e-20, [0]], [1.0, [1.0], 0.6], [[1.0], 1.0, 0.6], [1.0, 1.0]):
        part = memory(v)
        part["proofs"][0]["ball"]["form"][3] = sizes
        assert not shows(v, part)
    part = memory(v)
    part["proofs"][0]["ball"]["periods"][1] = {"tables": {}, "parts": []}
    assert not shows(v, part)


def only_still_loops_converge(v):
    for node in (["error", 1e-3], ["time"], ["given", 0]):
        part = memory(v, given=[[0.0]] * 9)
        part["nodes"] += [node, ["+", 4, 5]]
        part["next"] = [6]
        assert not shows(v, part)
    part = memory(v, disturbances=[[-0.1, 0.1]])
    part["nodes"] += [["disturbance", 0], ["+", 4, 5]]
    part["next"] = [6]
    assert not shows(v, part)
    part = memory(v)  # a claim that begins to fail
    part["nodes"] += [["time"], ["const", -9.0], ["*", 5, 6], ["const", 20.0], ["+", 7, 8]]
    part["claims"].append(["9 t <= 20", [[[9, 0]]], 0, None])
    part["proofs"][0]["claims"].append(1)
    assert not shows(v, part)
    for change in ({"claims": [["stable", v.CONVERGES, 0, 0]]}, {"claims": [["stable", "converge", 0, None]]}):
        assert not shows(v, memory(v) | change)
    for end in (0, None):  # without a ball
        part = memory(v, -0.99)  # it converges, but nothing shows it
        anchor = {"set": [[[4.0]], [[0.25]], [1e-9]], "keep": [], "anchor": True}
        step = {"tables": {}, "parts": [{"tube": [], "order": 0}]}
        part |= {"claims": [["stable", v.CONVERGES, 0, end]], "start": [[1, 3]]}
        part["proofs"] = [{"claims": [0], "steps": [step | anchor, step]}]
        assert not shows(v, part)
    # Params: each has its fixed point, and the ball holds all of them.
    for low, high, proved in ((0.9, 1.1, True), (0.5, 1.5, False)):
        part = memory(v, form=([[1.0]], [2.0], 1.0, 0.4, 0.6), params=[[low, high]], names=["a", "m"])
        part["nodes"] += [["param", 0], ["+", 2, 5]]
        part["next"] = [6]
        assert shows(v, part) == proved


def errors_stay_in_the_ball(v):
    """m' = 2 + 0.5 (m - 2), with an error e or a disturbance, is within 2 e of 2 for ever."""
    for size, limit, proved in ((0.1, 3.1, True), (0.1, 2.9, False), (0.45, 3.1, False)):
        for node, noise in ((["error", size], []), (["disturbance", 0], [[-size, size]])):
            part = memory(v, start=(1.9, 2.1), form=([[1.0]], [2.0], 1.0, 1.0, 0.6), disturbances=noise)
            part["nodes"] += [node, ["+", 4, 5], ["const", -1.0], ["*", 0, 7], ["const", limit], ["+", 8, 9]]
            part |= {"next": [6], "claims": [["m <= limit", [[[10, 0]]], 0, None]]}
            assert shows(v, part) == proved, (size, limit, node)


def bends_have_two_slopes(v):
    """m' = a m + b |m|: its slopes are a + b and a - b."""
    for a, b, start, proved in (
        (0.2, 0.5, (-0.5, 0.5), True),
        (0.3, -0.9, (-0.5, 0.5), False),
        (-0.3, 0.9, (-0.5, 0.5), False),
        (0.3, 0.9, (-0.5, 0.5), False),
        (-0.3, -0.9, (-0.5, 0.5), False),
    ):
        for vary in ((), (1,), (1, 1)):
            for near in (1.0, 1e-9):
                nodes = [["memory", 0], ["abs", 0], ["const", a], ["*", 0, 2], ["const", b], ["*", 1, 4], ["+", 3, 5]]
                part = settling(v, nodes, following=[6], start=[list(start)], vary=vary,
                                form=([[1.0]], [0.0], 1.0, near, 0.99))  # fmt: skip
                assert shows(v, part) == proved, (a, b, vary, near)
    # Two bends cancel only if their corners are combined: |m| - 0.9 |m|, of one node, twice.
    nodes = [["memory", 0], ["abs", 0], ["const", -0.9], ["*", 1, 2], ["+", 1, 3]]
    part = settling(v, nodes, following=[4], start=[[-0.5, 0.5]], form=([[1.0]], [0.0], 1.0, 1.0, 0.2))
    assert not shows(v, part)
    part["proofs"][0]["ball"]["vary"] = [1]
    assert shows(v, part)


def plants_move_between_samples(v):
    """x' = a x + b x^2 + u, u = c x + d m held for 0.1 s, m' = 0.1 m + e x."""
    nodes = [["held", 0], ["const", -1.0], ["const", 0.0], ["const", 0.0], ["const", 0.0], ["const", 0.0],
             ["*", 0, 2], ["*", 0, 0], ["*", 8, 3], ["+", 7, 9], ["+", 10, 1], ["memory", 0], ["*", 0, 4],
             ["*", 12, 5], ["+", 13, 14], ["const", 0.1], ["*", 12, 16], ["*", 0, 6], ["+", 17, 18]]  # fmt: skip
    for a, b, c, d, e, size, proved in (
        (-1, 0, 0, 0, 0, 0.1, True),
        (0.1, 0, 0, 0, 0, 0.1, False),
        (-1, 0, -30, 0, 0, 0.1, False),  # e^-0.1 - 30 (1 - e^-0.1)
        (-1, 0, -3, 0, 0, 0.1, True),
        (1, 0, -2, 0, 0, 0.1, True),
        (1, 0, -0.9, 0, 0, 0.1, False),
        (-1, 0, 0, 5, 0, 0.1, False),  # in this form
        (-1, 0, 0, 0, 5, 0.1, False),
        (-1, 0, 0, 0.1, 0.1, 0.1, True),
        (-1, 1, 0, 0, 0, 0.2, True),
        (-1, 4, 0, 0, 0, 0.3, False),  # 0.25 is a point of rest, too
        (-1, -4, 0, 0, 0, 0.3, False),
    ):
        for parts in (1, 2):
            own = copy.deepcopy(nodes)
            for place, value in zip((1, 2, 3, 4, 5), (a, b, c, d, e), strict=True):
                own[place] = ["const", float(value)]
            start, tube = 0.9 * size, (1.5 if b else 5.0) * size
            part = settling(v, own, rates=[11], held=[15], following=[19], start=[[-start, start], [-1e-3, 1e-3]],
                            form=([[1.0, 0.0], [0.0, 1.0]], [0.0, 0.0], size, size, 0.97), tube=[[-tube, tube]],
                            parts=parts, period=0.1)  # fmt: skip
            assert shows(v, part) == proved, (a, b, c, d, e, parts)
    # x' = a (x - 1): time passes for the centre, which is 1 and not 0, as for the ball.
    for centre, parts, proved in ((1.0, 1, True), (1.0, 0, False), (0.0, 1, False), (0.0, 0, False)):
        nodes = [["const", -1.0], ["+", 0, 1], ["*", 2, 1]]
        for near in (0.1, 0.05):
            part = settling(v, nodes, rates=[3], start=[[centre, centre]], form=([[1.0]], [centre], 0.1, near, 0.95),
                            tube=[[centre - 0.4, centre + 0.4]], period=0.1)  # fmt: skip
            periods = part["proofs"][0]["ball"]["periods"]
            periods[0] = periods[0] | {"parts": periods[0]["parts"] * parts}
            assert shows(v, part) == proved, (centre, parts, near)


CHECKS = [chords_hold_all, units_of_chords_count, slopes_hold_differences, steps_hold_what_moves,
          norms_are_those_of_matrices, balls_hold_their_runs, only_still_loops_converge, errors_stay_in_the_ball,
          bends_have_two_slopes, plants_move_between_samples]  # fmt: skip


@pytest.mark.parametrize("check", CHECKS)
def test_the_checker_is_sound(check):
    check(verify)


#: What is broken, a text of the checker and what takes its place, and the check that finds it.
MUTANTS = {
    "a chord ends at no knot": ("*(z for z in k if low < z < high), high)", "high)", chords_hold_all),
    "cells beside the start do not count": ("for a, b in pairwise(k) if a <= most and least <= b", "for a, b in ()",
                                            chords_hold_all),
    "the slope beyond a table is that at its end": ("[(0, 0)] if least <= k[0] or most >= k[-1] else []", "[]",
                                                    chords_hold_all),
    "other inputs are those of the start": ("*inner[0][i + 1:]", "*inner[1][i + 1:]", chords_hold_all),
    "other inputs are those of the end": ("*inner[1][:i]", "*inner[0][:i]", chords_hold_all),
    "all slopes are those of the start": (
        "if any(min(x, y) < z < max(x, y) for z in k)", "if False", chords_hold_all),
    "a chord does not round": ("(2 * len(knots) << BITS) // abs(a - b) + 2", "0", units_of_chords_count),
    "a product moves with both ends": ("(p[1], hull(b(p[0])))", "(p[1], hull(a(p[0])))", slopes_hold_differences),
    "a cosine rises": ('if op == "cos" else hull(x(p[1]))', 'if op == "tan" else hull(x(p[1]))',
                       slopes_hold_differences),
    "1/x rises": ("times(times(hull(x(i)), hull(y(i))), MINUS)", "times(hull(x(i)), hull(y(i)))",
                  slopes_hold_differences),
    "1/x bends as at one end": ("hull(x(i)), hull(y(i))), MINUS", "hull(y(i)), hull(y(i))), MINUS",
                                   slopes_hold_differences),
    "a root bends as at one end": ("add(hull(x(i)), hull(y(i)))", "add(hull(y(i)), hull(y(i)))",
                                   slopes_hold_differences),
    "roots of negative numbers have slopes": ("min(ends(x(p[0]))[0], ends(y(p[0]))[0]) >= 0", "True",
                                              slopes_hold_differences),
    "any derivative will do": ("need(self.nodes[p[1]] ==", "need(True or self.nodes[p[1]] ==", slopes_hold_differences),
    "a sum moves with its first part": ("for j in p[:2]]", "for j in p[:1]]", slopes_hold_differences),
    "what is not known has no slope": (
        'need(op in ("const", "param", "error", "disturbance")', "need(True", slopes_hold_differences),
    "a series has no rest": ("[[add(x, [0, rest])", "[[add(x, [0, 0])", steps_hold_what_moves),
    "a series ends at a small term": ("largest(a) * step >> BITS > k * ONE // 2 or ", "", steps_hold_what_moves),
    "radii do not count": ("q = limit - math.isqrt(sum(a[1] ** 2", "q = limit - 0 * math.isqrt(sum(a[1] ** 2",
                           norms_are_those_of_matrices),
    "only the diagonal counts": ("(gram[i][j] * gram[k][k] - gram[i][k] * gram[k][j]) // before", "gram[i][j]",
                                 norms_are_those_of_matrices),
    "a minor is left out": ("for k in n:  # Sylvester", "for k in n[:2]:  # Sylvester", norms_are_those_of_matrices),
    "a limit is negative": ("if q <= 0 or gram", "if gram", norms_are_those_of_matrices),
    "any inverse will do": ("return ONE - length(rest)", "return ONE", norms_are_those_of_matrices),
    "a matrix may be wide": (
        "need(all(len(row) == len(basis) == len(inverse)", "need(True or all(len(row) == len(basis)",
                             norms_are_those_of_matrices),
    "the start is anywhere": ("and away(rows) <= radius", "and True", balls_hold_their_runs),
    "the near ball is larger": ("0 <= near <= radius", "0 <= near", balls_hold_their_runs),
    "the centre moves": ("for run in runs) and drift", "for run in runs) and 0", balls_hold_their_runs),
    "the centre is where it is": ("[[add(a, [-c])]", "[[add(a, [0 * c])]", balls_hold_their_runs),
    "no time passes in a ball": ("need(all(run[2] for run in runs)", "need(runs[2][2]", plants_move_between_samples),
    "slopes are not judged": ("need(shrinks(multiplied", "need(True or shrinks(multiplied", balls_hold_their_runs),
    "errors converge": ('({"error", "disturbance"} if', '({"disturbance"} if', only_still_loops_converge),
    "disturbances converge": ('({"error", "disturbance"} if', '({"error"} if', only_still_loops_converge),
    "the time stays": ('changing = {"time"} |', 'changing = set() |', only_still_loops_converge),
    "convergence needs no ball": ("clauses != CONVERGES and anchor", "anchor", only_still_loops_converge),
    "convergence ends": ("need(all(b == math.inf", "need(True or all(b == math.inf", only_still_loops_converge),
    "claims are not looked at in a ball": ("due if len(runs) == 2 else []", "[]", errors_stay_in_the_ball),
    "claims are looked at in the near ball": ("due if len(runs) == 2", "due if len(runs) == 0",
                                              errors_stay_in_the_ball),
    "a bend has one slope": ("chords(([[-m, 0, m]], [m, 0, m])", "chords(([[-m, 0, m]], [-m, 0, m])",
                             bends_have_two_slopes),
    "a corner has one end": ("[[[a[0] - a[1], 0], [a[0] + a[1], 0]]", "[[[a[0] + a[1], 0]]", bends_have_two_slopes),
    "a slope has no width": ("if a[1] >> (BITS // 2) else [a] for", "if False else [[a[0], 0]] for",
                             bends_have_two_slopes),
    "a law does not act": ("*inner[:read],", "*exact([[0] * size] * read),", plants_move_between_samples),
    "the memory stays": ("+ inner[read:]", "+ unit(size)[n:]", plants_move_between_samples),
    "plants stay": ("evolved([*rates,", "evolved([*exact([[0] * len(names)] * n),", plants_move_between_samples),
    "only the last part moves": ("(size + read)), local)\n            whole = multiplied(evolved",
                                 "(size + read)), local)\n            whole = multiplied(unit(size + read) and evolved",
                                 plants_move_between_samples),
    "a ball is a point": ("* r // stretch + 2", "* 0 // stretch + 2", plants_move_between_samples),
}  # fmt: skip


@pytest.mark.parametrize("name", MUTANTS)
def test_a_rule_that_is_broken_is_found(name):
    old, new, check = MUTANTS[name]
    with pytest.raises((AssertionError, pytest.fail.Exception)):
        check(changed(old, new))


# Certificates of loops.


@pytest.mark.parametrize("name", TEXTS)
def test_a_certificate_of_convergence_is_verified_and_runs_converge(certificates, name, capsys):
    data = certificates(name)
    assert refused(data) is None
    assert "verified: stable: all runs converge; from 0 to inf periods" in capsys.readouterr().out
    for part in data["parts"]:
        assert Simulated(part).breaks() is None
        assert Simulated(part).spreads() is None


@pytest.mark.parametrize("name", TEXTS)
def test_a_tampered_certificate_is_refused_or_its_runs_converge(certificates, name):
    attack(certificates(name), range(10))


@pytest.mark.parametrize("name", TEXTS)
def test_a_ball_that_says_more_than_runs_keep_is_refused(certificates, name):
    """A faster rate, a smaller ball, a point of rest elsewhere."""
    data = certificates(name)
    inner = data["parts"][0]["proofs"][0]["ball"]["form"]
    _, _, centre, (radius, near, rate) = inner
    for sizes in ((radius, near, rate - 0.05), (0.9 * radius, min(near, 0.9 * radius), rate), (radius, near, 1.0)):
        other = copy.deepcopy(data)
        other["parts"][0]["proofs"][0]["ball"]["form"][3] = [*sizes]
        assert refused(other) is not None, sizes
    for k in range(len(centre)):
        other = copy.deepcopy(data)
        other["parts"][0]["proofs"][0]["ball"]["form"][2][k] += 4 * radius
        assert refused(other) is not None


@pytest.mark.long
@pytest.mark.parametrize("name", TEXTS)
def test_a_thousand_tampered_certificates_are_refused_or_their_runs_converge(certificates, name):
    accepted = attack(certificates(name), range(10, 260))
    print(f"{name}: {accepted} of 250 accepted, whose runs converge")


@pytest.mark.parametrize("corners", [10, 40])
def test_corners_without_end_are_refused(corners):
    """m' = |m| / n, added up from n bends, whose corners are 2^n."""
    nodes = [["memory", 0], ["const", 0.5 / corners], ["const", 0.0], *(["abs", 0] for _ in range(corners))]
    total = 2
    for k in range(corners):
        nodes.append(["+", total, 3 + k])
        total = len(nodes) - 1
    nodes.append(["*", total, 1])
    part = settling(verify, nodes, following=[len(nodes) - 1], start=[[-0.5, 0.5]], vary=range(3, 3 + corners),
                    form=([[1.0]], [0.0], 1.0, 1.0, 0.6))  # fmt: skip
    verify.WORK[1] = 10**7
    reason = refused({"format": "fuzzyctl certificate 2", "parts": [part]})
    verify.WORK[1] = 10**9
    assert reason is None if corners == 10 else "too much work" in reason


@pytest.mark.parametrize("vary", [[1] * 40, [2] * 10**6])
def test_a_node_that_is_varied_many_times_is_refused(vary):
    nodes = [["memory", 0], ["abs", 0], ["const", 0.5], ["*", 1, 2]]
    part = settling(verify, nodes, following=[3], start=[[-0.5, 0.5]], vary=vary, form=([[1.0]], [0.0], 1.0, 1.0, 0.9))
    verify.WORK[1] = 10**7
    reason = refused({"format": "fuzzyctl certificate 2", "parts": [part]})
    verify.WORK[:] = [0, 10**9]
    assert "too much work" in reason


def test_a_certificate_of_convergence_is_compared_with_its_file(tmp_path):
    file, target = tmp_path / "l.fz", tmp_path / "c.json"
    file.write_text(KEEPS.replace("require stable", "require stable\nrequire always abs(law.y) <= 9 forever"))
    assert prove(file, "--certificate", target).exit_code == 0
    assert len(json.loads(target.read_text())["parts"]) == 2
    verifies = runner("verify")
    assert verifies(target, "--source", file).exit_code == 0
    data = json.loads(target.read_text())
    for part in data["parts"]:
        part["params"] = [[0.4, 0.5]]
    target.write_text(json.dumps(data))
    assert verifies(target).exit_code == 0
    assert "about another loop" in verifies(target, "--source", file).stderr


def test_a_model_whose_rules_act_between_samples_has_no_certificate(tmp_path):
    """The limits of its inputs have no derivatives: the reason is printed, and no file is written."""
    file, target = ROOT / "apps" / "gallery" / "wang_tanaka_1996" / "stable.fz", tmp_path / "c.json"
    done = prove(file, "--block", "model", "--certificate", target)
    assert done.exit_code == 3
    assert "no certificate of 'stable': the derivative of a choice is not known" in done.output
    assert not target.exists()


UNSTABLE = {
    "it grows": ("next s = a * s + 0.1 * r + 0.2", "next s = (1 + a) * s + 0.1 * r + 0.2"),
    "it turns": ("next r = 0.3 * abs(r) - 0.4 * s", "next r = -4 * s"),
}


@pytest.mark.parametrize("name", UNSTABLE)
def test_a_ball_of_another_loop_is_refused(certificates, name):
    """The certificate of a loop that converges, with the equations of one that does not."""
    data, (old, new) = certificates("keeps"), UNSTABLE[name]
    finite = KEEPS.replace(old, new).replace("require stable", "require always abs(law.y) <= 9 until 1 s")
    other = certificate(finite)["parts"][0]
    part = data["parts"][0]
    own = [node for node in other["nodes"] if node[0] != "error"]
    assert part["nodes"] != own
    exact = [["const", 0.0] if node[0] == "error" else node for node in other["nodes"]]
    part |= {key: other[key] for key in ("held", "next", "rates", "tables", "params", "start", "names")}
    part["nodes"] = exact
    part["proofs"][0]["ball"]["vary"] = []
    assert refused(data) is not None
    part["proofs"][0]["ball"]["form"][3][2] = 1 - 2**-40
    assert refused(data) is not None


@pytest.mark.parametrize("line", ["require stable", "require always law.y <= 0.5 forever"])
def test_a_claim_for_all_time_has_a_part_of_its_own(tmp_path, line):
    """A part about claims that end does not speak of another claim that it names."""
    file, target = tmp_path / "l.fz", tmp_path / "c.json"
    turns = KEEPS.replace("next s = a * s + 0.1 * r + 0.2", "next s = -s").replace("[-1, 1]", "[0.2, 0.3]")
    claims = f"require always abs(law.y) <= 9\nrequire always law.y <= 1\n{line}"
    file.write_text(turns.replace("require stable", claims))
    prove(file, "--certificate", target)
    data = json.loads(target.read_text())
    verifies = runner("verify")
    assert verifies(target, "--source", file).exit_code == 0
    part = data["parts"][0]
    data["parts"] = [part]
    part["lines"].append(line)
    if "forever" in line:  # for as long as the others
        part["claims"].append([line.removeprefix("require "), part["claims"][1][1], 0, part["claims"][1][3]])
        part["proofs"][0]["claims"].append(2)
    target.write_text(json.dumps(data))
    assert verifies(target).exit_code == 0
    done = verifies(target, "--source", file)
    assert done.exit_code == 1
    assert "is about another loop" in done.output
