"""The checker of certificates: its sets hold all that they should, and it takes nothing else.

Each check is a function of the module, so that mutants of the module can be shown to fail one of them.
"""

import copy
import json
import math
import random
import re
import subprocess
import sys
import tempfile
import types
from fractions import Fraction
from pathlib import Path

import pytest

from tests.commands import runner
from tests.fuzzyctl.analysis.reach.loops import FUZZY, TANK

ROOT = Path(__file__).parents[3]
SOURCES = [ROOT / "fuzzyctl" / "analysis" / name for name in ("verify_numbers.py", "verify.py")]
prove = runner("prove")


def changed(old="", new=""):
    """Return the checker, or one with a changed text."""
    texts = [source.read_text(encoding="utf-8") for source in SOURCES]
    assert not old or sum(text.count(old) for text in texts) == 1, old
    modules = []
    for source, text in zip(SOURCES, texts, strict=True):
        modules.append(types.ModuleType(source.stem))
        modules[-1].__file__ = str(source)
        sys.modules["verify_numbers"] = modules[0]
        exec(compile(text.replace(old, new) if old else text, str(source), "exec"), modules[-1].__dict__)
    sys.path = [p for p in sys.path if p != str(SOURCES[0].parent)]
    del sys.modules["verify_numbers"]
    return modules[-1]


verify = changed()

#: A linear plant with a disturbance, and a controller with a memory.
SERVO = """
controller law
input r
input y
state s = 0
next s = clamp(s + 0.05 * (r - y), -1, 1)
output u = 1.5 * (r - y) + s
every 100 ms
plant motor
input u
param k in [0, 10] = 1
state x = 0
der x = k * u - x
output y = x
loop servo
block law = law(0.5, motor.y)
block motor = motor(law.u + w)
for motor.x in [-0.2, 0.2]
for motor.k in [0.9, 1.1]
disturbance w in [-0.05, 0.05] = 0
run 1 s
require always motor.y <= 0.6
require always motor.y >= 0.05 and law.u <= 1.2 from 0.6 s
"""
#: Its output returns, for all time.
RETURNS = SERVO.replace("disturbance w in [-0.05, 0.05] = 0\n", "").replace("law.u + w", "law.u")
RETURNS = RETURNS[: RETURNS.index("require")] + "require always abs(motor.y) <= 1.2 forever\n"
#: Functions in the plant and in a claim.
WAVES = """
plant p
param a in [0, 2] = 1
state x = 0.5
state z = 1
der x = -sin(x) * exp(-z) / (1 + x ^ 2)
der z = a * cos(x) - sqrt(1 + z)
output y = x
loop l
block p = p()
for p.x in [0.45, 0.55]
for p.z in [0.9, 1.1]
for p.a in [0.9, 1]
run 1 s step 250 ms
require always sqrt(p.x ^ 2 + p.z ^ 2) <= 1.3
require always max(p.x, p.z - 1) > 0 or p.y < -1
"""
#: A dead zone, a step and noise.
CHOICES = """
controller law
input r
input y
output u = where(abs(r - y) < 0.02, 0, where(r > y or r > 2, 1, -1) * min(4 * abs(r - y), 1))
every 100 ms
plant motor
input u
state x = 0
der x = u - 0.2 * x
output y = x
loop l
block law = law(steps(0: 0.1, 0.7 s: 0.4, 0.95 s: 0.2), motor.y + noise(sigma=0.005))
block motor = motor(law.u)
for motor.x in [-0.02, 0.02]
run 1.2 s
require always motor.y <= 0.35 and motor.y >= -0.1
"""
TEXTS = {
    "servo": SERVO,
    "choices": CHOICES,
    "waves": WAVES,
    "fuzzy": FUZZY[: FUZZY.rindex("run")] + "run 0.4 s\nrequire always abs(pendulum.th) <= 0.8 and law.u <= 4\n",
    "tank": TANK[: TANK.rindex("run")] + "run 0.4 s\nrequire always tank.h <= 0.5\n",
}


def certified(path, *options):
    """Return the certificate of all claims of a file."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "c.json"
        done = prove(str(path), "--certificate", str(target), *options)
        assert done.exit_code == 0, done.output
        return json.loads(target.read_text(encoding="utf-8"))


def certificate(text):
    """Return the certificate of all claims of a loop."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "l.fz"
        path.write_text(text, encoding="utf-8")
        return certified(path)


@pytest.fixture(scope="module")
def certificates():
    known = {}

    def of(name):
        if name not in known:
            known[name] = certificate(TEXTS[name])
        return copy.deepcopy(known[name])

    return of


def refused(data, module=verify):
    """Return why a certificate is refused, None if it is not."""
    module.WORK[0] = 0
    try:
        module.check(data)
    except (
        AssertionError,
        LookupError,
        TypeError,
        ValueError,
        AttributeError,
        ArithmeticError,
        RecursionError,
    ) as error:
        return f"{type(error).__name__} {error}"
    return None


class Simulated:
    """Runs of the problem of a certificate, in floating point, by an interpreter of their own."""

    def __init__(self, part, seed=0):
        self.part, self.random = part, random.Random(seed)

    def value(self, i, known):
        if i not in known:
            op, *rest = self.part["nodes"][i]
            known[i] = self.applied(op, rest, known)
        return known[i]

    def applied(self, op, rest, known):
        match op:
            case "const":
                return float(rest[0])
            case "error":
                return self.random.uniform(-1.0, 1.0) * rest[0]
            case "+":
                return self.value(rest[0], known) + self.value(rest[1], known)
            case "*":
                return self.value(rest[0], known) * self.value(rest[1], known)
            case "inverse":
                return 1.0 / self.value(rest[0], known)
            case "sqrt":
                return math.sqrt(max(self.value(rest[0], known), 0.0))
            case "sin" | "cos" | "exp":
                return getattr(math, op)(self.value(rest[0], known))
            case "abs":
                return abs(self.value(rest[0], known))
            case "choice":
                x = self.value(rest[0], known)
                return self.value(rest[2 if x > 0 or (x == 0 and rest[1] != 1) else 3], known)
            case "table":
                table = self.part["tables"][rest[0]]
                return table_at(table["knots"], table["values"], [self.value(p, known) for p in rest[1:]])
        return known[op, *rest]

    def breaks(self, runs=12, fine=6):
        """Return a claim that a run breaks, None if none does; `least` holds the least value of each clause."""
        part, self.least = self.part, {}
        last = max((end if end is not None else 30 for *_, end in part["claims"]), default=0)
        for run in range(runs):
            pick = (lambda a, b: self.random.choice((a, b))) if run % 2 else self.random.uniform
            params = [pick(*r) for r in part["params"]]
            begin = [pick(*r) for r in part["start"]]
            n = len(part["rates"])
            x, memory = begin[:n], begin[n:]
            for k in range(math.ceil(last) + 1):
                inputs = {("param", i): v for i, v in enumerate(params)}
                inputs |= {("memory", i): v for i, v in enumerate(memory)}
                inputs |= {("given", i): v for i, v in enumerate(part["given"][k] if part.get("given") else [])}
                noise = {("disturbance", i): pick(*r) for i, r in enumerate(part["disturbances"])}
                at = inputs | noise | {("state", i): v for i, v in enumerate(x)} | {("time",): k * part["period"]}
                held = {("held", i): self.value(v, at) for i, v in enumerate(part["held"])}
                following = [self.value(v, at) for v in part["next"]]
                for j in range(fine + 1):
                    now = {("state", i): v for i, v in enumerate(x)} | {("time",): (k + j / fine) * part["period"]}
                    for text, clauses, first, end in part["claims"]:
                        if (
                            clauses != verify.CONVERGES
                            and first <= k + j / fine <= (math.inf if end is None else end)
                            and j < fine
                        ):
                            values = inputs | noise | held | now
                            largest = [max(self.value(i, values) for i, _ in c) for c in clauses]
                            for place, value in enumerate(largest):
                                before = self.least.get((text, place), math.inf)
                                self.least[text, place] = min(before, value)
                            if min(largest) < -1e-9:
                                return text
                    if j < fine:
                        x = self.moved(x, inputs | noise | held | now, part["period"] / fine)
                memory = following
        return None

    def spreads(self, runs=3, fine=4):
        """Return how two runs break what a proof by a ball says of them, None if none does.

        From the sample of the ball on both lie in it, and the distance shrinks by its rate.
        """
        part = self.part
        proof = next(p for p in part["proofs"] if 0 in p["claims"])
        _, inverse, centre, (radius, _, rate) = proof["ball"]["form"]
        first, n = len(proof["steps"]), len(part["rates"])
        last = first + min(400, math.ceil(math.log(0.01) / math.log(min(rate, 0.999)))) if rate else first + 9

        def length(z):
            return math.dist([sum(map(float.__mul__, map(float, row), z)) for row in inverse], [0.0] * len(z))

        for run in range(runs):
            pick = (lambda a, b: self.random.choice((a, b))) if run % 2 else self.random.uniform
            params = {("param", i): pick(*r) for i, r in enumerate(part["params"])}
            states = [[pick(*r) for r in part["start"]] for _ in range(2)]
            for k in range(last + 1):
                apart = length([a - b for a, b in zip(*states, strict=True)])
                if k >= first:
                    away = max(length([a - b for a, b in zip(z, centre, strict=True)]) for z in states)
                    if away > radius * (1 + 1e-6) + 1e-9 or apart > 2 * radius * rate ** (k - first) * 1.0001 + 1e-9:
                        return k, away, apart
                states = [self.period(z[:n], z[n:], params, fine) for z in states]
        return None

    def period(self, x, memory, params, fine):
        inputs = params | {("memory", i): v for i, v in enumerate(memory)}
        at = inputs | {("state", i): v for i, v in enumerate(x)}
        held = {("held", i): self.value(v, at) for i, v in enumerate(self.part["held"])}
        following = [self.value(v, at) for v in self.part["next"]]
        for _ in range(fine if x else 0):
            x = self.moved(x, inputs | held, self.part["period"] / fine)
        return [*x, *following]

    def moved(self, x, inputs, step):
        def rates(y):
            at = inputs | {("state", i): v for i, v in enumerate(y)}
            return [self.value(r, at) for r in self.part["rates"]]

        def plus(k, h):
            return [a + h * b for a, b in zip(x, k, strict=True)]

        k1 = rates(x)
        k2 = rates(plus(k1, step / 2))
        k3 = rates(plus(k2, step / 2))
        k4 = rates(plus(k3, step))
        return [a + step / 6 * (p + 2 * q + 2 * r + s) for a, p, q, r, s in zip(x, k1, k2, k3, k4, strict=True)]


def table_at(knots, values, point):
    if not knots:
        return float(values)
    k, x = knots[0], min(max(point[0], knots[0][0]), knots[0][-1])
    i = max(j for j in range(len(k) - 1) if k[j] <= x)
    share = (x - k[i]) / (k[i + 1] - k[i])
    return sum(w * table_at(knots[1:], values[j], point[1:]) for w, j in ((1.0 - share, i), (share, i + 1)) if w)


# What the sets of the checker must hold.


def drawn_form(rng, symbols, one, centre=2.0, width=0.5):
    scale = [rng.randrange(one) for _ in range(symbols + 2)]
    form = [int((rng.random() - 0.5) * centre * one), int(rng.random() * 0.01 * one)]
    return form + [int((rng.random() - 0.5) * width * one) + s % 1000 for s in scale[2:]]


def points_of(form, rng, count):
    """Yield values of the symbols, and of a form there."""
    for _ in range(count):
        e = [rng.choice((-1, 1, Fraction(rng.randrange(-8, 9), 8))) for _ in form[2:]]
        own = rng.choice((-1, 1, 0))
        yield e, form[0] + own * form[1] + sum(Fraction(g) * x for g, x in zip(form[2:], e, strict=True))


def at(form, e):
    return form[0] + sum(Fraction(g) * x for g, x in zip(form[2:], e, strict=True))


def products_hold_all(v):
    rng = random.Random(1)
    for k in range(60):
        a, b = drawn_form(rng, 3, v.ONE), drawn_form(rng, 3, v.ONE)
        if k % 3 == 0:  # small numbers, where each unit counts
            a, b = ([x % 1000 + 1 for x in f] for f in (a, b))
        if k % 3 == 1:  # only squares, and nothing of their own
            a, b = [0, 0, *a[2:3], 0, 0], [0, 0, *b[2:3], 0, 0]
        c = v.times(a, b)
        for e, x in points_of(a, rng, 12):
            for own in (-1, 0, 1):
                y = at(b, e) + own * b[1]
                assert abs(x * y / v.ONE - at(c, e)) <= c[1]


def functions_hold_all(v):
    rng = random.Random(2)
    exact = {"exp": math.exp, "sin": math.sin, "cos": math.cos, "abs": abs,
             "sqrt": lambda x: math.sqrt(max(x, 0.0)), "inverse": lambda x: 1.0 / x}  # fmt: skip
    for name, f in exact.items():
        for k in range(30):
            form = drawn_form(rng, 2, v.ONE, 3.0, 0.9)
            if name in ("sqrt", "inverse"):
                form[0] = sum(map(abs, form[1:])) + (0 if name == "sqrt" and k % 2 else v.ONE // 50)
            if name == "sqrt" and k % 3 == 1:  # the root of a negative number is 0
                form[0] = sum(map(abs, form[1:])) // 3
            if name == "inverse" and k % 2:
                form[0] = -form[0]
            result = v.applied(name, form)
            for e, x in points_of(form, rng, 16):
                assert abs(f(float(x / v.ONE)) - float(at(result, e) / v.ONE)) <= result[1] / v.ONE + 1e-13
    for x in (3, v.ONE // 3, 7 * v.ONE + 1, v.ONE):  # each unit counts
        c, r = v.applied("inverse", [x, 0])
        assert (c - r) * x <= v.ONE**2 <= (c + r) * x
        c, r = v.applied("sqrt", [x, 0])
        assert max(c - r, 0) ** 2 <= x * v.ONE <= (c + r) ** 2
    for name, value in (
        ("sin", "0.8414709848078965066525023216302989996"),
        ("exp", "2.7182818284590452353602874713526624977572"),
    ):
        c, r = v.applied(name, [v.ONE, 0])
        assert abs(c - Fraction(value) * v.ONE) <= r <= 20


def tables_hold_all(v):
    rng = random.Random(3)
    for k in range(30):
        knots = [sorted(rng.sample(range(-9, 10), 4)) for _ in range(2)]
        values = [[rng.randrange(-9, 10) for _ in knots[1]] for _ in knots[0]]
        inputs = [drawn_form(rng, 3, v.ONE, 8.0, 4.0) for _ in knots]
        shear = rng.uniform(-3, 3)
        if k % 2:  # inputs that move together
            inputs[1] = [int(shear * x) + y // 99 for x, y in zip(inputs[0], inputs[1], strict=True)]
            inputs[1][1] = abs(inputs[1][1])
        hint = [[rng.uniform(-1, 1) for _ in knots], [shear] * (k % 3)]
        result = v.tabulated(v.number([knots, values]), inputs, v.number(hint))
        for e, x in points_of(inputs[0], rng, 40):
            y = at(inputs[1], e) + rng.choice((-1, 1)) * inputs[1][1]
            exact = table_at(knots, values, [float(x / v.ONE), float(y / v.ONE)])
            assert abs(exact - float(at(result, e) / v.ONE)) <= result[1] / v.ONE + 1e-12


def only_what_fits_is_covered(v):
    one = v.ONE
    basis, inverse = [[one, 0], [0, one]], [[one, 0], [0, one]]
    v.cover([[one // 2, 0], [one // 3, one]], basis, inverse, [10, 10], "")
    for columns in ([[one // 2, 0], [one // 2 + 10, one]], [[0, 0], [0, one + 1]]):
        with pytest.raises(AssertionError):
            v.cover(columns, basis, inverse, [10, 10], "")
    with pytest.raises(AssertionError):  # the rest counts
        v.cover([[one, 100]], [[one, 0], [0, 0]], [[one, 0], [0, 0]], [10, 10], "")
    with pytest.raises(AssertionError):  # and so do further columns of the basis
        v.cover([[0, 0], [5 * one, 0]], [[one, 0, one], [0, one, 0]], [[0, 0], [0, one], [one, 0]], [10, 10], "")


def simple(v, rates, *, start, steps, period=0.5, claims=(), held=(), following=(), noise=(), params=(), nodes=()):
    """Return a part about some nodes, which follow the states."""
    count = len(rates)
    given = [["state", i] for i in range(count)] + [*nodes]
    return {"kind": "loop", "loop": "l", "nodes": given, "tables": [], "rates": [*rates], "held": [*held],
            "next": [*following], "period": period, "params": [*params], "start": start, "disturbances": [*noise],
            "names": [f"n{k}" for k in range(len(params) + len(start))], "claims": [list(c) for c in claims],
            "proofs": [{"claims": [*range(len(claims))], "steps": steps}]}  # fmt: skip


def growth(v, limit=1.649, tube=(1, 2.05), order=4, begin=1, end=1, steps=None):
    """x' = x from [1, 1]: e^0.5 = 1.6487212707 after one period."""
    tube = {"tube": [list(tube)], "order": order}
    own = [{"tables": {}, "parts": [tube]}, {"tables": {}, "parts": []}]
    nodes = [["const", limit], ["const", -1.0], ["*", 2, 0], ["+", 1, 3]]
    return simple(v, [0], start=[[1, 1]], steps=own if steps is None else steps, nodes=nodes,
                  claims=[["x <= limit", [[[4, 0]]], begin, end]])  # fmt: skip


def shows(v, part):
    return refused({"format": "fuzzyctl certificate 2", "parts": [part]}, v) is None


def steps_hold_their_solutions(v):
    assert shows(v, growth(v))
    assert not shows(v, growth(v, limit=1.6487))  # the end
    assert shows(v, growth(v, limit=1.64872128, order=8))
    assert not shows(v, growth(v, limit=1.64872126, order=8))
    for order in (0, 1, 2, 3):  # the remainder
        assert not shows(v, growth(v, limit=1.64872, order=order))
    assert not shows(v, growth(v, tube=(1, 1.9)))  # the tube
    assert not shows(v, growth(v, tube=(1.0001, 2.05)))
    assert not shows(v, growth(v, order=-1))
    assert shows(v, growth(v, limit=1.75, begin=0))  # between samples
    assert not shows(v, growth(v, limit=1.6, begin=0))
    assert not shows(v, growth(v, limit=1.3, begin=0.5, end=0.75))  # a part of a period
    assert not shows(v, growth(v, end=2))  # the claim goes on
    assert not shows(v, growth(v, end=None))
    assert not shows(v, growth(v, steps=[]))
    assert not shows(v, growth(v, begin=0, end=0, limit=0.5, steps=[{"tables": {}, "parts": []}]))  # an instant
    later = [{"tables": {}, "parts": []}, {"tables": {}, "parts": []}]
    assert not shows(v, growth(v, steps=later))  # no time passes
    # x' = sin x: its slope is the cosine of the same.
    for partner, proved in ((2, True), (1, False), (3, False)):
        nodes = [["sin", 0, partner], ["cos", 0, 1], ["cos", 1, 1], ["const", 1.0]]
        steps = [{"tables": {}, "parts": [{"tube": [[0, 1.2]], "order": 3}]}, {"tables": {}, "parts": []}]
        part = simple(v, [1], start=[[0.5, 0.5]], steps=steps, nodes=nodes, claims=[["1 >= 0", [[[4, 0]]], 0, 1]])
        assert shows(v, part) == proved
    # x' = t from 0: 0.125 after a period, in two parts.
    for order, limit, proved in ((2, 0.12501, True), (2, 0.12499, False), (0, 0.12, False)):
        parts = [{"tube": [[-0.1, 0.3]], "order": order}] * 2
        steps = [{"tables": {}, "parts": parts}, {"tables": {}, "parts": []}]
        nodes = [["time"], ["const", limit], ["const", -1.0], ["*", 3, 0], ["+", 2, 4]]
        part = simple(v, [1], start=[[0, 0]], steps=steps, nodes=nodes, claims=[["x", [[[5, 0]]], 0, 1]])
        assert shows(v, part) == proved
    # x' = 1 from 0: 0.5 after a period.
    for order, limit, proved in ((1, 0.501, True), (-2, 0.1, False)):
        steps = [{"tables": {}, "parts": [{"tube": [[-0.1, 0.6]], "order": order}]}, {"tables": {}, "parts": []}]
        nodes = [["const", 1.0], ["const", limit], ["const", -1.0], ["*", 3, 0], ["+", 2, 4]]
        part = simple(v, [1], start=[[0, 0]], steps=steps, nodes=nodes, claims=[["x", [[[5, 0]]], 1, 1]])
        assert shows(v, part) == proved
    # x' = w with |w| <= 0.1: 0.05 after a period, also between its ends.
    for apart, limit, proved in ((0.0501, 0.051, True), (0.0501, 0.0499, False), (0.049, 0.06, False), (-1, 1, False)):
        steps = [{"tables": {}, "parts": [{"tube": [[-0.06, 0.06]], "order": 2, "apart": [apart]}]},
                 {"tables": {}, "parts": []}]  # fmt: skip
        nodes = [["disturbance", 0], ["const", limit], ["const", -1.0], ["*", 3, 0], ["+", 2, 4]]
        part = simple(v, [1], start=[[0, 0]], steps=steps, nodes=nodes, noise=[[-0.1, 0.1]],
                      claims=[["x", [[[5, 0]]], 0, 1]])  # fmt: skip
        assert shows(v, part) == proved
    # x' = 2 x + w: what the disturbance does spreads.
    for apart, proved in ((0.06, False), (0.11, True)):
        steps = [{"tables": {}, "parts": [{"tube": [[-0.2, 0.2]], "order": 2, "apart": [apart]}]},
                 {"tables": {}, "parts": []}]  # fmt: skip
        nodes = [["disturbance", 0], ["+", 0, 0], ["+", 1, 2]]
        part = simple(v, [3], start=[[0, 0]], steps=steps, nodes=nodes, noise=[[-0.1, 0.1]], period=0.25,
                      claims=[["0 >= 0", [[[0, 0], [2, 0], [4, 0]]], 0, 1]])  # fmt: skip
        part["nodes"].append(["const", 0])
        part["claims"][0][1] = [[[4, 0]]]
        part["proofs"][0]["steps"][0]["parts"][0]["apart"] = [apart / 2]
        assert shows(v, part) == proved


def choices_hold_both(v):
    """A choice by x, 2 or 5, is the one on its side, and lies between both where the side of x is unknown."""
    for low, high, mark, least, most in (
        (0, 1, 0, 2, 2), (0, 1, 1, 2, 5), (0.01, 1, 1, 2, 2), (-1, 0, 0, 2, 5), (-1, 0, 1, 5, 5), (-1, -0.1, 0, 5, 5),
        (-1, 1, 0, 2, 5), (-1, 0.01, 1, 2, 5),
    ):  # fmt: skip
        for least_shown, most_shown, proved in (
            (least - 1e-9, most + 1e-9, True),
            (least + 1e-3, 9.0, False),
            (-9.0, most - 1e-3, False),
        ):
            nodes = [["const", 2.0], ["const", 5.0], ["choice", 0, mark, 1, 2], ["const", -1.0], ["*", 4, 3],
                     ["const", -least_shown], ["const", most_shown], ["+", 3, 6], ["+", 5, 7]]  # fmt: skip
            part = simple(v, [0], start=[[low, high]], steps=[{"tables": {}, "parts": []}], nodes=nodes,
                          claims=[["c", [[[8, 0]], [[9, 0]]], 0, 0]])  # fmt: skip
            assert shows(v, part) == proved
    # x' = 1, and 3 from t = 0.25 on: x is 1 at t = 0.5.
    for order in (0, 1, 2):
        for limit, proved in ((0.9, False), (1.6, order == 0)):
            nodes = [["time"], ["const", -0.25], ["+", 1, 2], ["const", 3.0], ["const", 1.0], ["choice", 3, 0, 4, 5],
                     ["const", limit], ["const", -1.0], ["*", 8, 0], ["+", 7, 9]]  # fmt: skip
            steps = [{"tables": {}, "parts": [{"tube": [[-0.1, 1.7]], "order": order}]}, {"tables": {}, "parts": []}]
            part = simple(v, [6], start=[[0, 0]], steps=steps, nodes=nodes, claims=[["c", [[[10, 0]]], 1, 1]])
            assert shows(v, part) == proved


def known_numbers_follow(v):
    """x' = 1 for a period and then 3: x is 2 at t = 1."""
    for limit, proved in ((1.99, False), (2.01, True)):
        nodes = [["given", 0], ["const", limit], ["const", -1.0], ["*", 3, 0], ["+", 2, 4]]
        steps = [{"tables": {}, "parts": [{"tube": [[-0.1, 2.1]], "order": 1}]} for _ in range(2)]
        part = simple(v, [1], start=[[0, 0]], steps=[*steps, {"tables": {}, "parts": []}], nodes=nodes,
                      claims=[["c", [[[5, 0]]], 2, 2]])  # fmt: skip
        assert shows(v, part | {"given": [[1.0], [3.0], [0.0]]}) == proved
        assert not shows(v, part | {"given": [[1.0], [3.0]]})


def memories_follow(v):
    """m = 0, 1, 2 at samples 0, 1, 2, held as u; x stays."""
    nodes = [["memory", 0], ["const", 1.0], ["+", 1, 2], ["held", 0], ["const", 0.0], ["const", -1.0], ["*", 4, 6],
             ["const", 1.5], ["+", 8, 7]]  # fmt: skip
    steps = [{"tables": {}, "parts": [{"tube": [[-1, 1]], "order": 1}]} for _ in range(2)]
    steps.append({"tables": {}, "parts": []})
    for end, proved in ((1, True), (1.5, True), (2, False)):
        part = simple(v, [5], start=[[0, 0], [0, 0]], steps=steps, nodes=nodes, held=[1], following=[3],
                      claims=[["u <= 1.5", [[[9, 0]]], 0, end]])  # fmt: skip
        assert shows(v, part) == proved


def sets_return_only_into_themselves(v):
    """x' = -x returns into [-1, 1]; x' = x does not, nor does what is not yet within."""
    one = {"set": [[[1.02]], [[1 / 1.02]], [1e-9]], "keep": [], "anchor": True}
    time, given = [["time"]], [["given", 0]]
    for sign, begin, timed, proved in (
        (-1, 0, [], True), (1, 0, [], False), (-1, 2, [], False), (-1, 0, time, False), (-1, 0, given, False)
    ):  # fmt: skip
        tubes = [[[-2.2, 2.2]], [[-4.4, 4.4]]]
        steps = [{"tables": {}, "parts": [{"tube": tube, "order": 3}]} for tube in tubes]
        steps[0] |= one if sign < 0 else {"set": [[[2.0]], [[0.5]], [1e-9]], "keep": [], "anchor": True}
        nodes = [["const", float(sign)], ["*", 1, 0], ["const", 3.0], *timed]
        part = {"given": [[0.0]] * 2} | simple(
            v, [2], start=[[-1, 1]], steps=steps, nodes=nodes, claims=[["3 > 0", [[[3, 1]]], begin, None]]
        )
        assert shows(v, part) == proved
    drop = [["memory", 0], ["const", 2.0], ["*", 0, 1], ["const", 0.5], ["*", 0, 3], ["+", 4, 3]]
    drop += [["const", 0.95], ["const", -1.0], ["*", 0, 7], ["+", 6, 8]]
    wide = {"set": [[[4.0]], [[0.25]], [1e-9]], "keep": [], "anchor": True}
    for following, start, claim, more in (
        (2, 1, [[[1, 1]]], [wide | {"set": [[[4.0]], [[0.125]], [9.0]]}]),  # the last set lies in itself
        (2, 1, [[[1, 1]]], [wide, {"set": [[[0.0]], [[0.0]], [1000.0]], "keep": []}]),  # m' = 2 m in an error
        (5, 0, [[[9, 0]]], [{"anchor": True, "keep": []}, {}]),  # m' = (m + 1) / 2, and an anchor without a set
    ):
        steps = [{"tables": {}, "parts": [{"tube": [], "order": 0}]} | hint for hint in more]
        part = simple(v, [], start=[[-start, start]], following=[following], nodes=drop, steps=steps,
                      claims=[["c", claim, 0, None]])  # fmt: skip
        assert not shows(v, part)


def claims_are_strict(v):
    for value, mark, proved in (
        (0.0, 0, True),
        (0.0, 1, False),
        (1e-20, 1, True),
        (-1e-20, 0, False),
        (-5.0, -9, False),
    ):
        steps = [{"tables": {}, "parts": []}]
        part = simple(
            v, [0], start=[[1, 1]], steps=steps, nodes=[["const", value]], claims=[["c", [[[1, mark]]], 0, 0]]
        )
        assert shows(v, part) == proved
    part["claims"] = [["both", [[[1, 0]], [[0, 0]]], 0, 0]]
    assert not shows(v, part)
    part["claims"] = [["either", [[[1, 0], [0, 0]]], 0, 0]]
    assert shows(v, part)
    part["proofs"][0]["claims"] = []  # nothing shows it
    assert not shows(v, part)
    for text, clauses in (("c", []), ("c\nverified: d", part["claims"][0][1])):
        assert not shows(v, part | {"claims": [[text, clauses, 0, 0]], "proofs": [{"claims": [0], "steps": steps}]})
    assert not shows(v, part | {"claims": []})
    assert refused({"format": "fuzzyctl certificate 2", "parts": []}, v)


def halves_cover_the_whole(v):
    steps = [{"tables": {}, "parts": []}]
    nodes = [["*", 0, 0], ["*", 1, 1], ["const", -1.0], ["*", 3, 0], ["+", 2, 4], ["const", 0.55], ["+", 5, 6]]
    for halves, proved in (([1, 1], True), ([1, 0], False)):
        part = simple(
            v, [0], start=[[0, 1]], steps=steps, nodes=nodes, claims=[["x^4 - x + 0.55 >= 0", [[[7, 0]]], 0, 0]]
        )
        assert not shows(v, part)  # of the whole at once
        half = [{"cut": [0, 0.25 + 0.5 * k], "halves": [{"steps": steps}] * 2} if deep else {"steps": steps}
                for k, deep in enumerate(halves)]  # fmt: skip
        part["proofs"] = [{"claims": [0], "cut": [0, 0.5], "halves": half}]
        assert shows(v, part) == proved
    part["proofs"] = [{"claims": [0], "cut": [0, 1.5], "halves": half}]
    assert not shows(v, part)


def symbols_stay_apart(v):
    """The memory is any number in [-1, 1] each period, as the param is, but not the same one."""
    nodes = [["memory", 0], ["param", 0], ["const", -1.0], ["*", 1, 2], ["+", 0, 3], ["error", 1.0], ["const", 1.0],
             ["+", 4, 6]]  # fmt: skip
    steps = [{"tables": {}, "parts": [{"tube": [], "order": 0}]}, {"tables": {}, "parts": []}]
    part = simple(v, [], start=[[0, 0]], params=[[-1, 1]], following=[5], nodes=nodes, steps=steps,
                  claims=[["memory >= param - 1", [[[7, 0]]], 1, 1]])  # fmt: skip
    assert not shows(v, part)


def small_numbers_count(v):
    """x' = 1e-29 * 1e19 * 1e19, and states, tables and periods below a unit."""
    nodes = [["const", 1e-29], ["const", 1e19], ["*", 1, 2], ["*", 3, 2], ["const", -1.0], ["*", 5, 0]]
    steps = [{"tables": {}, "parts": [{"tube": [[-1, 9]], "order": 1}]}, {"tables": {}, "parts": []}]
    zero = [["x <= 0", [[[6, 0]]], 0, 1]]
    part = simple(v, [4], start=[[0, 0]], nodes=nodes, steps=steps, claims=zero)
    assert not shows(v, part)
    part = simple(v, [1], start=[[0, 1e-30]], nodes=[["const", 0.0], *nodes[1:]], steps=steps, claims=zero)
    assert not shows(v, part)
    for change in ({"period": 1e-28}, {"tables": [{"knots": [[0, 1e-30, 1]], "values": [0, 1, 0]}]}):
        assert not shows(v, growth(v) | change)


def a_loop_has_times_and_errors(v):
    """Errors cancel in no sum, and a claim about no time is none."""
    still = [{"tables": {}, "parts": []}]
    for size, limit, proved in ((-5.0, 2.5, False), (5.0, 9.9, False), (5.0, 10.1, True), (1e-30, 5.1, True)):
        nodes = [["error", size], ["error", 5.0], ["+", 1, 2], ["const", limit], ["+", 3, 4]]
        part = simple(v, [0], start=[[0, 0]], steps=still, nodes=nodes, claims=[["sum", [[[5, 0]]], 0, 0]])
        assert shows(v, part) == proved
    assert not shows(v, growth(v) | {"period": 0})
    assert not shows(v, growth(v) | {"period": -0.5})
    assert not shows(v, growth(v, begin=1, end=0.5))
    assert not shows(v, growth(v, begin=-3, end=-2, steps=[]))


CHECKS = [products_hold_all, choices_hold_both, known_numbers_follow, functions_hold_all, tables_hold_all,
          only_what_fits_is_covered, steps_hold_their_solutions, memories_follow, sets_return_only_into_themselves,
          claims_are_strict, halves_cover_the_whole, symbols_stay_apart, small_numbers_count,
          a_loop_has_times_and_errors]  # fmt: skip


@pytest.mark.parametrize("check", CHECKS)
def test_the_checker_is_sound(check):
    check(verify)


#: What is broken, a text of the checker and what takes its place, and the check that finds it.
MUTANTS = {
    "a polynomial has no remainder": (
        "[between(*ends(whole(i, order + 1))) for i in n]", "[[0, 0] for i in n]", steps_hold_their_solutions),
    "a product does not round": ("(r >> BITS) + len(g) + 3", "(r >> BITS)", products_hold_all),
    "a product is linear": (" + ra * rb - sum(map(abs, both)) // 2", "", products_hold_all),
    "squares lie in the middle": ("- sum(map(abs, both)) // 2", "- sum(map(abs, both))", products_hold_all),
    "functions do not round": ("[f, 9 + (r >> (BITS - 1))]", "[f, 0]", functions_hold_all),
    "a bend is missed": ("min(max(low, 0), high), high)", "high)", functions_hold_all),
    "a sine bends half": ("(r * r >> BITS) // 2 + 1]", "(r * r >> BITS) // 4 + 1]", functions_hold_all),
    "a series ends early": ("for n in range(160)", "for n in range(9)", functions_hold_all),
    "knots are missed": ("*(y for y in k if least < y < most)", "", tables_hold_all),
    "a slab has one end": ("min(s * a, s * b)", "s * a", tables_hold_all),
    "a table has no distance from its plane": (
        "between(min(rest) - 3 * len(knots), max(rest) + 3 * len(knots))", "[max(rest), 0]", tables_hold_all),
    "a set is wider than its cover": ("<= ONE for part", "<= 2 * ONE for part", only_what_fits_is_covered),
    "what is left over does not count": (
        "need(all(sum(abs(g[i] - b[i])", "need(True or all(sum(abs(g[i] - b[i])", only_what_fits_is_covered),
    "a tube is not checked": ("least <= low and high <= most", "True", steps_hold_their_solutions),
    "a tube has one time": (
        "between(begin, begin + step)", "between(begin, begin)", steps_hold_their_solutions),
    "an order is negative": ('range(65).index(hint["order"])', 'hint["order"]', steps_hold_their_solutions),
    "any slope will do": ("need(self.nodes[rest[1]] ==", "need(True or self.nodes[rest[1]] ==",
                          steps_hold_their_solutions),
    "disturbances are not checked": ("need(0 <= moved * step >> BITS < a", "need(True", steps_hold_their_solutions),
    "a disturbance does not move": ("[[add(rows[i], [0, apart[i]]) for i in n] for rows in results]", "results",
                                    steps_hold_their_solutions),
    "no time passes": ('need(hint["parts"] or done', "need(True", steps_hold_their_solutions),
    "a claim ends early": ("else end <= (k - 1) * ONE", "else True", steps_hold_their_solutions),
    "a claim begins late": ("(b > c[2] or", "(a > c[2] or", steps_hold_their_solutions),
    "a claim is not looked at": ("need(holds, f", "need(True, f", claims_are_strict),
    "a claim has no proof": ("need(any(i in proof", "need(True or any(i in proof", claims_are_strict),
    "a claim is not strict": (">= (mark == 1)", ">= 0", claims_are_strict),
    "any clause will do": ("all(any(ends(v(i))", "any(any(ends(v(i))", claims_are_strict),
    "a choice has its first value": ("[high < mark:1 + (low < mark)]", "[:1]", choices_hold_both),
    "a choice is the mean": ("(max(map(abs, ends(minus(a, b)))) >> 1) + 1]", "0]", choices_hold_both),
    "a choice is not strict": ("rest[1] == 1", "0", choices_hold_both),
    "a choice does not jump": ('need(not k or low >= mark', 'need(True or low >= mark', choices_hold_both),
    "known numbers stay": ("self.given[k - 1]", "self.given[0]", known_numbers_follow),
    "known numbers do not matter for all time": ('not {"time", "given"} &', 'not {"time"} &',
                                                 sets_return_only_into_themselves),
    "memory stays": ("[*x, *(v(i) for i in self.next)]", "[*x, *rows[n:]]", memories_follow),
    "a claim for ever begins late": (" and begin <= anchor[0])", ")", sets_return_only_into_themselves),
    "the time does not matter": ("still and ", "", sets_return_only_into_themselves),
    "sets need not return": ("        cover([[a[0] for", "        0 and cover([[a[0] for",
                             sets_return_only_into_themselves),
    "one half is enough": ("for i in (0, 1)]", "for i in (0,)]", halves_cover_the_whole),
    "an error is no part of the last set": ("columns_of(apart, self.params)", "[*zip(*(a[2:] for a in apart))]",
                                            sets_return_only_into_themselves),
    "an error is the symbol of a param": ("[0] * (p + 2 - len(a))", "[]", symbols_stay_apart),
    "small constants are cut": ("enclosed(*rest, *rest)", "[hinted(*rest), 0]", small_numbers_count),
    "ends are cut inward": ("-hinted(-high))", "hinted(high))", small_numbers_count),
    "an error may be negative": ("sum(enclosed(0, *rest))", "hinted(*rest) + 1", a_loop_has_times_and_errors),
    "no time passes in a period": ("self.period > 0 and", "", a_loop_has_times_and_errors),
    "a claim ends before it begins": ("max(a, 0) <= b", "True", a_loop_has_times_and_errors),
    "roots of negative numbers are left out": (
        "for x in (low, min(max(low, 0)", "for x in (max(low, 0), min(max(low, 0)", functions_hold_all),
    "tables are cut": ("2**BITS % x", "0 % x", small_numbers_count),
}  # fmt: skip


@pytest.mark.parametrize("name", MUTANTS)
def test_a_rule_that_is_broken_is_found(name):
    old, new, check = MUTANTS[name]
    with pytest.raises((AssertionError, pytest.fail.Exception)):
        check(changed(old, new))


# Certificates of loops.


@pytest.mark.parametrize("name", TEXTS)
def test_a_certificate_is_verified_and_its_claims_hold_in_runs(certificates, name):
    data = certificates(name)
    assert refused(data) is None
    assert all(Simulated(part).breaks() is None for part in data["parts"])


def test_a_loop_without_plants_states_has_a_certificate():
    """Of a disturbance that a controller keeps."""
    text = "controller law\ninput d\nstate s = 0\nnext s = d\noutput y = s\nevery 1 s\nloop l\nblock law = law(d=w)\n"
    text += "disturbance w in [-1, 1] = 0\nrequire always abs(law.y) <= 1.1\nrun 2 s\n"
    assert refused(certificate(text)) is None


def leaves(data, path=()):
    """Yield the places of numbers and of operations."""
    items = data.items() if isinstance(data, dict) else enumerate(data)
    for key, value in items:
        if isinstance(value, dict | list):
            yield from leaves(value, (*path, key))
        elif not (path and path[0] == "names") and key not in ("kind", "loop", "text"):
            yield (*path, key)


def tampered(part, rng):
    """Change one thing, of any kind."""
    kind = rng.choice(["nodes", "proofs", "proofs", "claims", "start", "tables", "any"])
    places = [p for p in leaves(part) if p[0] == kind or kind == "any"] or [*leaves(part)]
    *way, last = rng.choice(places)
    inner = part
    for key in way:
        inner = inner[key]
    value = inner[last]
    if isinstance(value, str):
        inner[last] = rng.choice(["+", "*", "sin", "state", "const", "inverse", "abs", "error"])
    elif isinstance(value, bool) or value is None:
        inner[last] = rng.choice([0, 1, 5.0, None])
    elif isinstance(value, int):
        inner[last] = value + rng.choice([-2, -1, 1, 2])
    else:
        scale = rng.choice([1e-9, 1e-3, 0.1, 1.0, 10.0])
        inner[last] = rng.choice([-value, 0.0, value * (1 + scale), value - scale, value + scale, value * 1e6])
    return (*way, last)


def attack(data, seeds, fine=4):
    """Return how many tampered certificates are accepted; the claims of each of them hold in runs."""
    accepted = 0
    for seed in seeds:
        rng, other = random.Random(seed), copy.deepcopy(data)
        part = rng.choice(other["parts"])
        place = tampered(part, rng)
        if refused(other) is None:
            accepted += 1
            try:
                broken = Simulated(part, seed).breaks(6, fine)
                if verify.CONVERGES in [c[1] for c in part["claims"]]:
                    broken = broken or Simulated(part, seed).spreads(2, fine)
            except (LookupError, TypeError, ValueError):
                broken = "no run"
            assert broken is None, (seed, place, broken)
    return accepted


@pytest.mark.parametrize("name", ["servo", "fuzzy", "waves", "tank"])
def test_a_tampered_certificate_is_refused_or_claims_what_holds(certificates, name):
    data = certificates(name)
    attack(data, range(12))


@pytest.mark.parametrize("name", TEXTS)
def test_a_claim_that_a_run_breaks_is_refused(certificates, name):
    """Each clause asks for a little more than the least value of some runs."""
    data = certificates(name)
    seen = Simulated(data["parts"][0])
    assert seen.breaks() is None
    for (text, place), least in seen.least.items():
        other = copy.deepcopy(data)
        part = other["parts"][0]
        count = len(part["nodes"])
        part["nodes"].append(["const", -least - 1e-9])
        clause = next(clauses for claim, clauses, _, _ in part["claims"] if claim == text)[place]
        for k, pair in enumerate(clause):
            part["nodes"].append(["+", pair[0], count])
            pair[0] = count + 1 + k
        assert refused(other) is not None, (text, place, least)


def test_a_certificate_is_compared_with_its_file(tmp_path):
    file, target = tmp_path / "l.fz", tmp_path / "c.json"
    file.write_text(TEXTS["waves"], encoding="utf-8")
    assert prove(file, "--certificate", target).exit_code == 0
    verifies = runner("verify")
    assert verifies(target).exit_code == 0
    assert verifies(target, "--source", file).exit_code == 0
    data = json.loads(target.read_text(encoding="utf-8"))
    data["parts"][0]["nodes"].append(["const", 7.0])  # another loop, with the hashes of the first
    other = tmp_path / "other.json"
    other.write_text(json.dumps(data), encoding="utf-8")
    assert verifies(other).exit_code == 0
    assert "about another loop" in verifies(other, "--source", file).stderr
    text = file.read_text(encoding="utf-8")
    assert verifies(target, "--source", "-", stdin=text).exit_code == 0
    assert "about another loop" in verifies(other, "--source", "-", stdin=text).stderr
    before = file.read_bytes()
    assert prove(file, "--certificate", file).exit_code == 2
    assert file.read_bytes() == before
    assert prove(file, "--certificate", tmp_path / "c.csv", "--tube", tmp_path / "c.csv").exit_code == 2
    file.write_text(TEXTS["waves"] + "# another\n", encoding="utf-8")
    done = verifies(target, "--source", file)
    assert done.exit_code == 1
    assert "is not the file that was proved" in done.stderr
    assert verifies(tmp_path / "none.json").exit_code == 1


def test_settings_and_lines_that_are_there_twice_are_those_of_the_file(tmp_path):
    file, target = tmp_path / "l.fz", tmp_path / "c.json"
    twice = SERVO[: SERVO.index("disturbance")] + "run 1 s\n" + 2 * "require always motor.y <= 0.7\n"
    file.write_text(twice.replace("law.u + w", "law.u") + 2 * "require always motor.y <= 2 forever\n", encoding="utf-8")
    assert prove(file, "--certificate", target, "--set", "motor.x=0.05", "--set", "s=0").exit_code == 2
    assert prove(file, "--certificate", target, "--set", "motor.x=0.05", "--set", "law.s=0.01").exit_code == 0
    done = runner("verify")(target, "--source", file)
    assert done.exit_code == 0, done.stderr
    assert "is proved with --set motor.x=0.05 --set law.s=0.01" in done.output


def test_a_certificate_that_lacks_its_source_is_refused_with_a_message(tmp_path):
    file, target, broken = tmp_path / "l.fz", tmp_path / "c.json", tmp_path / "broken.json"
    file.write_text(TEXTS["waves"], encoding="utf-8")
    prove(file, "--certificate", target)
    (part,) = json.loads(target.read_text(encoding="utf-8"))["parts"]
    lacking = [{k: v for k, v in part.items() if k != key} for key in part if key != "kind"]
    wrong = [part | {key: value} for key in ("lines", "settings", "sha256", "loop") for value in (3, [3], "a", ["a"])]
    for other in (*lacking, *wrong):
        broken.write_text(json.dumps({"format": "fuzzyctl certificate 2", "parts": [other]}), encoding="utf-8")
        done = runner("verify")(broken, "--source", file)
        assert (done.exit_code, type(done.exception)) in ((1, SystemExit), (2, SystemExit)), done.stderr
        assert done.stderr.strip()


def test_a_claim_without_a_certificate_is_named_and_no_file_is_written(tmp_path):
    file, target = tmp_path / "l.fz", tmp_path / "c.json"
    file.write_text(TEXTS["waves"].replace("-sin(x)", "-sin(x) * x ^ 0.5"), encoding="utf-8")
    done = prove(file, "--certificate", target)
    assert done.exit_code == 3
    assert "no certificate of" in done.output
    assert "'power' has no operation in a certificate" in done.output
    assert not target.exists()
    assert prove(file, file, "--certificate", target).exit_code == 2
    data = json.loads(prove(file, "--certificate", target, "--format", "json").output)
    assert len(data["certificate"]["without"]) == 2


HOSTILE = {
    "no JSON": b"\xff\x00",
    "nothing": b"",
    "nested": b"[" * 100_000,
    "a list": b"[]",
    "no parts": b'{"format": "fuzzyctl certificate 2"}',
    "another format": b'{"format": "x", "parts": []}',
    "NaN": b'{"format": NaN, "parts": []}',
    "long numbers": b'{"format": ' + b"9" * 5000 + b"}",
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_file_that_is_no_certificate_gets_one_message(name, tmp_path):
    path = tmp_path / "c.json"
    path.write_bytes(HOSTILE[name])
    with pytest.raises(SystemExit) as error:
        verify.main(str(path))
    assert str(path) in error.value.code
    assert "\n" not in error.value.code


#: Nodes, ranges or steps that would take for ever, or have no numbers.
ENDLESS = {
    "powers": {"nodes": [["state", 0], *(["*", k, k] for k in range(2000))], "claims": [["c", [[[2000, 0]]], 0, 0]]},
    "sums": {"nodes": [["state", 0], *(["+", k, k] for k in range(600))], "claims": [["c", [[[600, 0]]], 0, 0]]},
    "a circle": {"nodes": [["state", 0], ["+", 2, 0], ["+", 1, 0]], "claims": [["c", [[[1, 0]]], 0, 0]]},
    "a huge number": {"period": 1e300},
    "no number": {"start": [[float("nan"), 1.0]]},
    "infinite": {"start": [[0.0, float("inf")]]},
    "a whole number without end": {"start": [[0, 10**400]]},
    "text": {"start": ["01"]},
    "empty": {"start": [[2.0, 1.0]]},
    "an unknown operation": {"nodes": [["state", 0], ["eval", "1"]], "claims": [["c", [[[1, 0]]], 0, 0]]},
    "a high order": {"order": 10**9},
    "a table of one": {"tables": [{"knots": [[0.0]], "values": [1.0]}]},
    "knots that fall": {"tables": [{"knots": [[1.0, 0.0]], "values": [1.0, 2.0]}]},
    "claims of other proofs": {"proofs": [{"claims": [5], "steps": []}]},
    "names": {"names": []},
}


@pytest.fixture
def little_work():
    verify.WORK[1] = 10**6
    yield
    verify.WORK[1] = 10**9


@pytest.mark.usefixtures("little_work")
@pytest.mark.parametrize("name", ENDLESS)
def test_what_would_take_for_ever_is_refused(name):
    part = growth(verify) | {k: v for k, v in ENDLESS[name].items() if k != "order"}
    if "claims" in ENDLESS[name]:
        part["proofs"] = [{"claims": [0], "steps": [{"tables": {}, "parts": []}]}]
    if "order" in ENDLESS[name]:
        part["proofs"][0]["steps"][0]["parts"][0]["order"] = ENDLESS[name]["order"]
    assert refused({"format": "fuzzyctl certificate 2", "parts": [part]}) is not None


@pytest.mark.usefixtures("little_work")
def test_the_work_that_a_file_causes_is_bounded():
    steps = [{"tables": {}, "parts": [{"tube": [[1, 2.05]], "order": 4}]} for _ in range(2000)]
    part = growth(verify, steps=steps)
    part["nodes"].append(["const", 0.0])
    part["rates"] = [5]
    assert "too much work" in str(refused({"format": "fuzzyctl certificate 2", "parts": [part]}))


#: A part by the number of its steps, and the least work for each step and what is many.
MANY = {
    "clauses": lambda n: {"claims": [["c", [[[1, 0]]] * n, 0, n - 1]], "proofs": [{"claims": [0], "steps": still(n)}]},
    "claims": lambda n: {
        "claims": [["c", [[[1, 0]]], 0, n - 1]] * n, "proofs": [{"claims": [*range(n)], "steps": still(n)}]},
    "symbols": lambda n: {  # each step adds one
        "nodes": [["state", 0], ["const", 1.0], ["memory", 0], ["error", 1e-9], ["+", 2, 3],
                  *(["+", 4 + i, 3] for i in range(n))],
        "next": [4], "held": [n + 4], "start": [[0, 0], [0, 0]], "names": ["a", "b"],
        "claims": [["c", [[[1, 0]]], 0, 1]], "proofs": [{"claims": [0], "steps": still(n)}]},
    "lines of a table": lambda n: {
        "nodes": [["state", 0], ["const", 1.0], ["table", 0, 0, 0]], "held": [2],
        "tables": [{"knots": [[*range(n)], [0.0, 1.0]], "values": [[0.0] * 2] * n}], "start": [[0, n]],
        "claims": [["c", [[[1, 0]]], 0, 0]],
        "proofs": [{"claims": [0], "steps": [{"parts": [], "tables": {"2": [[0, 0], [0] * n]}}]}]},
    "knots": lambda n: {
        "nodes": [["state", 0], ["const", 1.0], ["table", 0, 0, 0]], "held": [2],
        "tables": [{"knots": [[0.0, 1.0], [*range(n)]], "values": [[0.0] * n] * 2}],
        "claims": [["c", [[[1, 0]]], 0, 1]],
        "proofs": [{"claims": [0], "steps": [one | {"tables": {"2": [[0, 0], []]}} for one in still(n)]}]},
}  # fmt: skip


def still(count):
    """Return steps of a state at rest."""
    return [{"tables": {}, "parts": [{"tube": [[-1, 1]], "order": 0}]} for _ in range(count)]


@pytest.mark.parametrize("name", MANY)
def test_what_is_many_counts_at_each_step(name):
    """Work grows with the square of their number, as the time does."""
    work = []
    for count in (20, 80):
        part = simple(verify, [1], start=[[0, 0]], steps=[], nodes=[["const", 0.0]]) | MANY[name](count)
        part["nodes"][1:2] = [["const", 0.0]]
        refused({"format": "fuzzyctl certificate 2", "parts": [part]})
        work.append(verify.WORK[0])
    assert work[1] > 10 * work[0]


@pytest.mark.usefixtures("little_work")
def test_a_table_without_end_is_refused():
    knots = [[0.0, 1.0, 2.0]] * 8
    values = 0.0
    for k in knots:
        values = [values] * len(k)
    part = growth(verify) | {"tables": [{"knots": knots, "values": 0.0}]}
    part["tables"][0]["values"] = values
    part["nodes"].append(["table", 0, *[0] * 8])
    part["claims"][0][1] = [[[5, 0]]]
    part["start"] = [[0.0, 8.0]]
    part["claims"][0][2:] = [0, 0]
    part["proofs"][0]["steps"] = [{"tables": {}, "parts": []}]
    part["held"] = [5]
    part["proofs"][0]["steps"][0]["tables"] = {"5": [[0.0] * 8, []]}
    assert "too much work" in str(refused({"format": "fuzzyctl certificate 2", "parts": [part]}))


def test_the_checker_is_short_and_needs_python_alone(certificates, tmp_path):
    for source in SOURCES:
        text = source.read_text(encoding="utf-8")
        assert text.count("\n") <= 200
        assert max(map(len, text.split("\n"))) <= 120
        modules = re.findall(r"^(?:import|from) ([\w, ]+?)(?: import .*)?$", text, re.MULTILINE)
        named = {m.strip() for line in modules for m in line.split(",")}
        assert named <= sys.stdlib_module_names
        (tmp_path / source.name).write_text(text, encoding="utf-8")
    path, alone = tmp_path / "c.json", tmp_path / "verify.py"
    path.write_text(json.dumps(certificates("servo")), encoding="utf-8")
    command = [sys.executable, "-I", "-S", str(alone), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "verified: always motor.y <= 0.6" in done.stdout
    data = certificates("servo")
    data["parts"][0]["claims"][0][1][0][0][0] = data["parts"][0]["nodes"].index(["const", -1.0])
    path.write_text(json.dumps(data), encoding="utf-8")
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stdout.count("verified") == 0
    assert "not verified: 'always motor.y <= 0.6' is not shown from sample 0 on" in done.stderr


ARCH = ["attitude", "cruise", "docking", "pendulum", "tora", "unicycle"]


def of_gallery(name):
    return certified(ROOT / "apps" / "gallery" / f"arch_{name}" / f"arch_{name}.fz")


def test_a_certificate_of_the_gallery_is_verified():
    assert refused(of_gallery("pendulum")) is None


@pytest.mark.long
@pytest.mark.parametrize("name", ARCH)
def test_all_certificates_of_the_gallery_are_verified_and_none_that_is_tampered_with(name):
    data = of_gallery(name)
    assert refused(data) is None
    accepted = attack(data, range(170))
    print(f"arch_{name}: {accepted} of 170 accepted, whose claims hold")


@pytest.mark.long
def test_a_certificate_for_all_time_is_verified():
    data = certificate(RETURNS)
    assert refused(data) is None
    anchored = next(s for s in data["parts"][0]["proofs"][0]["steps"] if "anchor" in s)
    anchored["set"][0] = [[0.9 * x for x in row] for row in anchored["set"][0]]
    assert refused(data) is not None


def test_a_list_is_no_number():
    """It would be repeated as often as a product says."""
    table = {"nodes": [["state", 0], ["const", 1.0], ["table", 0, 0]], "held": [2], "start": [[0, 2.0**-60]],
             "tables": [{"knots": [[0.0, 1.0]], "values": [0.0, 0.0]}], "claims": [["c", [[[1, 0]]], 0, 0]],
             "proofs": [{"claims": [0], "steps": [{"parts": [], "tables": {"2": [[[0]], []]}}]}]}  # fmt: skip
    part = simple(verify, [1], start=[[0, 0]], steps=[]) | table
    assert "TypeError" in str(refused({"format": "fuzzyctl certificate 2", "parts": [part]}))
    steps = [{"tables": {}, "parts": [{"tube": [[-1, 1]], "order": 2, "apart": [[0]]}]}, {"tables": {}, "parts": []}]
    part = simple(verify, [1], start=[[0, 0]], steps=steps, nodes=[["disturbance", 0]], noise=[[-0.1, 0.1]],
                  claims=[["x", [[[0, 0]]], 0, 1]])  # fmt: skip
    assert "TypeError" in str(refused({"format": "fuzzyctl certificate 2", "parts": [part]}))


@pytest.mark.parametrize("node", [["choice", 0, 0, 0], ["choice", 0, 0, 0, 0, 0], ["choice", 0, 2, 0, 0]])
def test_a_choice_has_a_mark_and_two_values(node):
    """A choice that lacks its last value was that of the other one."""
    parts = ("tables", "held", "next", "params", "disturbances")
    data = {"nodes": [["state", 0], node], "rates": [0], "period": 1, **{name: [] for name in parts}}
    loop = verify.Loop(data | {"claims": [["c", [[[0, 0]]], 0, 1]]})
    with pytest.raises((AssertionError, ValueError)):
        loop.series({("state", 0): verify.between(-verify.ONE, verify.ONE)})(1)
