"""The operations of certificates for systems that are no tables give the values of the kernel."""

import json
import random
from collections import defaultdict

import pytest

import fuzzyctl
from tests.commands import runner
from tests.fuzzyctl.analysis.test_verify import verify

prove = runner("prove")

HEAD = (
    "system s\n{settings}\ninput x in [-1, 1]\n{terms}input y in [-1, 1] extrapolate\n{terms}"
    "output u in [-2, 2] {rest}\n"
)
LINES = "  N = triangle(-2, -1, 0.2)\n  Z = trapezoid(-0.8, -0.1, 0.1, 0.7)\n  P = ramp(-0.1, 1)\n"
CURVES = "  N = gaussian(-1, 0.5)\n  Z = gaussian(0, 0.3)\n  P = sigmoid(4, 0.4)\n"
SETS = "else 0.3\n  low = triangle(-2, -1, 0)\n  mid = triangle(-1, 0.2, 1)\n  high = triangle(0, 1.5, 2)"
NUMBERS = "\n  low = constant(-1)\n  mid = function(0.3 * x - y + 0.2)\n  high = constant(1.7)"
RULES = (
    "if x is N and y is N then u is low\nif x is Z or y is Z then u is mid weight 0.5\n"
    "if x is P and not y is N then u is high\nif x is N and y is P then u is mid\nif x is P and y is N then u is high\n"
)
SYSTEMS = {
    "sums of sets": ("and product\nimplication product\naggregation sum\ndefuzzifier centroid", LINES, SETS),
    "sums of clipped sets": ("and min\nimplication min\naggregation sum\ndefuzzifier centroid", LINES, SETS),
    "largest clipped sets": ("and min\nimplication min\naggregation max\ndefuzzifier centroid", LINES, SETS),
    "curves": ("and product\nimplication product\naggregation max\ndefuzzifier centroid", CURVES, SETS),
    "functions of inputs": ("and product\ndefuzzifier weighted_average", CURVES, NUMBERS),
    "least degrees": ("and min\ndefuzzifier weighted_average", LINES, "else 0.3" + NUMBERS),
    "peaks": ("and min\nor probabilistic_sum\ndefuzzifier center_average", LINES, SETS),
}
LOOP = """
controller law
input x
input y
output u = s(x, y)
every 100 ms
plant p
input u
state x = 0.5
state y = 0.5
der x = 0
der y = 0 * u
output a = x
output b = y
loop l
block law = law(p.a, p.b)
block p = p(law.u)
for p.x in [0.5, 0.501]
for p.y in [0.5, 0.501]
run 100 ms
require always p.a <= 1
"""


@pytest.mark.parametrize("name", SYSTEMS)
def test_operations_give_the_values_of_the_kernel(name, tmp_path):
    settings, terms, rest = SYSTEMS[name]
    text = HEAD.format(settings=settings, terms=terms, rest=rest) + RULES
    path = tmp_path / "l.fz"
    path.write_text(text + LOOP, encoding="utf-8")
    done = prove(path, "--certificate", tmp_path / "l.json")
    assert done.exit_code == 0, done.output
    loop = verify.Loop(json.loads((tmp_path / "l.json").read_text(encoding="utf-8"))["parts"][0])
    kernel, rng = fuzzyctl.compile(fuzzyctl.loads(text), "python"), random.Random(1)
    for _ in range(40):
        x, y = rng.choice([rng.uniform(-0.95, 0.95), 0.1, -0.1]), rng.uniform(-0.95, 0.95)
        inputs = {("state", 0): verify.enclosed(x, x), ("state", 1): verify.enclosed(y, y), ("time",): [0, 0]}
        value = loop.series(inputs, None, defaultdict(lambda: [[0.0], []]))(loop.values[0])
        low, high = (e / verify.ONE for e in verify.ends(value))
        assert low <= kernel(x, y) <= high, (x, y)
        assert high - low <= 1e-9, (x, y)
