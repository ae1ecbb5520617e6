import pytest

import fuzzyctl
from tests.shipped import rules_folder

LOOP = """
controller law
input r
input y
param K in (0, 50] = 2
output u = K * (r - y)
every 50 ms

plant p = tf(num=[3, 1], den=[1, 2, 5])

loop small
block law = law(r, p.y)
block p = p(law.u)
let r = steps(0: 1)
measure error = iae(p.y, r)
run 5 s step 10 ms
"""


@pytest.fixture
def small(tmp_path):
    """Load a loop around a linear plant, written in one of its forms."""

    def load(form="tf(num=[3, 1], den=[1, 2, 5])", text=LOOP):
        path = tmp_path / "small.fz"
        path.write_text(text.replace("tf(num=[3, 1], den=[1, 2, 5])", form), encoding="utf-8")
        return fuzzyctl.load(path, block=fuzzyctl.Loop)

    return load


@pytest.fixture
def tank(tmp_path):
    """Load the shipped water tank with another `run` line and noise."""

    def load(duration="10 s step 10 ms", text="", sigma=0.002):
        written = (rules_folder() / "loops" / "water_tank.fz").read_text(encoding="utf-8")
        written = written.replace("60 s step 10 ms", duration).replace("sigma=0.002", f"sigma={sigma}")
        path = tmp_path / "tank.fz"
        path.write_text(written + text, encoding="utf-8")
        return fuzzyctl.load(path, block=fuzzyctl.Loop)

    return load
