"""Verdicts on systems whose consequents have poles and jumps at 0, set against kernels at 0, -0.0 and around them.

More of them: FUZZYCTL_PROOFS=1000 python -m pytest tests/properties/test_proofs_at_poles.py
"""

import math
import os
import random

import pytest

from fuzzyctl import Proved, Refuted, compile, loads, prove
from tests.sizes import examples

#: Generated systems.
COUNT = int(os.environ.get("FUZZYCTL_PROOFS", examples(24)))
#: Consequents that are infinite, jump or are steep at 0.
FUNCTIONS = (
    "min(5, max(-3, {a} ^ -1))",
    "min(max({a} ^ -3, -3), 5)",
    "1 / {a}",
    "atan2({a}, -1)",
    "sign({a}) + {a}",
    "sqrt(abs({a})) ^ -1",
    "min(max(1 / ({a} * {b}), -2), 2)",
    "max(1 / ({b} - {a}), -1)",
    "lt({a}, 0) * 3 - le({b}, {a})",
    "4 * eq({a}, 0) - ne({b}, 1)",
    "gt({a}, ge({b}, 0.5) - 0.5)",
    "floor(3 * {a}) - ceil({b})",
    "round(2 * {a}) / 2 + mod({b}, -0.3)",
    "fmod({a}, {b}) + mod({a}, 0.25)",
)
#: Claims, and whether they hold, decided by this file alone.
CLAIMS = {
    "y >= {v}": lambda x, y, v: y >= v,
    "y <= {v}": lambda x, y, v: y <= v,
    "y(-x, z) <= {v}": lambda x, y, v: y <= v,
    "abs(y) <= {v}": lambda x, y, v: abs(y) <= v,
    "y >= {v} when x >= 0": lambda x, y, v: x < 0 or y >= v,
    "atan2(x, -1) + y <= {v}": lambda x, y, v: math.atan2(x, -1) + y <= v,
}


class Case:
    def __init__(self, seed):
        self.rng = rng = random.Random(seed)
        self.lower, self.free = rng.choice([-1.0, 0.0, -0.3]), rng.random() < 0.5
        first, second = (rng.choice(FUNCTIONS).format(a=a, b=b) for a, b in ("xz", "zx"))
        self.words, self.holds = rng.choice(list(CLAIMS.items()))
        self.bound = rng.choice([-4, -3, -1, 0, 1, 2, 3, 5, 7])
        self.text = (
            "system s\ndefuzzifier weighted_average\nand product\n"
            f"input x in [{self.lower}, 1]{' extrapolate' if self.free else ''}\n  terms A B\n"
            "input z in [0, 2]\n  terms A B\noutput y in [-9, 9] else 0\n"
            f"  K = function({first})\n  M = function({second})\n  C = constant(1)\n"
            "if x is A and z is A then y is K\nif x is B then y is M\nif z is B then y is C\n"
            f"require {self.words.format(v=self.bound)}\n"
        )
        self.kernel = compile(loads(self.text), "python")

    def is_broken(self, x, z):
        y = self.kernel(-x if "-x" in self.words else x, z)
        return not math.isnan(y) and not self.holds(x, y, self.bound)

    def points(self):
        own = [0.0, -0.0, 5e-324, 1e-13, self.lower, 1.0, *(self.rng.uniform(self.lower, 1.0) for _ in range(20))]
        if self.free:
            own += [-5e-324, -1e-13, 1e9, -1e9, 1e300, -1e300, math.inf, -math.inf]
        others = [0.0, -0.0, 5e-324, 2.0, *(self.rng.uniform(0.0, 2.0) for _ in range(8))]
        return [(x, z) for x in own for z in others]


@pytest.mark.parametrize("seed", range(COUNT))
def test_proofs_hold_and_witnesses_break_what_they_should(seed):
    case = Case(seed)
    (verdict,) = prove(loads(case.text), timeout=0.2)
    if isinstance(verdict, Refuted):
        assert case.is_broken(verdict.witness.point["x"], verdict.witness.point["z"]), (case.text, verdict)
    elif isinstance(verdict, Proved):
        broken = [point for point in case.points() if case.is_broken(*point)]
        assert not broken, (case.text, broken)
