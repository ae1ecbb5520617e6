"""Widths of enclosures beside those of immrax, on plants that both can express, and processor times.

    python tests/bench/enclosures.py
    python tests/bench/enclosures.py shipped     shipped loops with families: verdicts, processor times

The first needs immrax (PyPI, not among the dependencies) for its column: the narrowest of the natural, Jacobian and
mixed Jacobian embeddings in the given coordinates. Its transformed coordinates and normotopes are not tried.
"""

import sys
import time
from pathlib import Path

import numpy as np

from fuzzyctl import loads
from fuzzyctl.analysis.reach.prover import LoopProver

#: By name: the second derivative as text, and the box of x and v; x' = v.
PLANTS = {
    "oscillator": ("-x - 0.5 * v", (0.9, 1.1), (-0.1, 0.1)),
    "van der Pol, damped": ("(1 - x * x) * v - x - 2 * v", (0.4, 0.6), (-0.1, 0.1)),
    "pendulum": ("sin(x) - 2 * x - v", (0.9, 1.1), (-0.1, 0.1)),
}
#: By text: the second derivative as a function of x, v and the sine of numpy or jax.
RATES = {
    "-x - 0.5 * v": lambda x, v, sin: -x - 0.5 * v,
    "(1 - x * x) * v - x - 2 * v": lambda x, v, sin: (1 - x * x) * v - x - 2 * v,
    "sin(x) - 2 * x - v": lambda x, v, sin: sin(x) - 2 * x - v,
}
DURATION = 5.0

#: Files of shipped loops, the loop in it, and the lines that make it a family with claims.
SHIPPED = {
    "pendulum": (
        "balanced",
        """
for cart.x in [-0.5, 0.5]
for cart.v in [-0.3, 0.3]
for cart.th in [-0.05, 0.05]
for cart.w in [-0.1, 0.1]
require always abs(cart.th) <= 0.2 until 9.9 s
require always abs(cart.x) <= 1.1 until 9.9 s
require always abs(cart.x) <= 0.05 from 9 s until 9.9 s
""",
    ),
    "water_tank": (
        "fill",
        """
for tank.h in [0.45, 0.55]
for tank.A in [19.5, 20.5]
require always tank.h in [0.44, 1.1]
require always abs(tank.h - 1) <= 0.02 from 15 s until 20 s
require always abs(tank.h - 1) <= 0.1 from 20 s until 35 s
require always abs(tank.h - 0.6) <= 0.02 from 50 s
""",
    ),
}


def shipped(name):
    """Return the verdicts on a shipped loop with a family, and the processor time [s]."""
    block, lines = SHIPPED[name]
    path = Path(__file__).parents[2] / "rules" / "loops" / f"{name}.fz"
    loop = loads(path.read_text(encoding="utf-8") + lines, block=block)
    prover, begin = LoopProver(loop, 100.0), time.process_time()
    verdicts = [prover.verdict(c) for c in loop.guarantees]
    return verdicts, time.process_time() - begin


def ours(rate, *box):
    """Return the width of the tube of x at the end, and the time [s]."""
    (a, b), (c, d) = box
    text = f"""plant p
input nothing
state x = {a}
state v = {c}
der x = v
der v = {rate}
output y = x
loop l
block p = p(0)
for p.x in [{a}, {b}]
for p.v in [{c}, {d}]
run {DURATION} s step 50 ms
require always abs(p.x) <= 100
"""
    loop = loads(text, block="l")
    prover, begin = LoopProver(loop, 20.0), time.process_time()
    prover._refuted = {}
    prover.verdict(loop.guarantees[0])
    low, high = prover.tube.bounds["p.y"]
    return float(high[-1] - low[-1]), time.process_time() - begin


def theirs(rate, *box):
    """Return the least width of x at the end over immrax's embeddings, and the time of that one [s]."""
    import immrax
    import jax.numpy as jnp

    class Plant(immrax.System):
        def __init__(self):
            self.evolution, self.xlen = "continuous", 2

        def f(self, t, z):
            x, v = z
            return jnp.array([v, RATES[rate](x, v, jnp.sin)])

    start = immrax.interval(*(jnp.array([float(side[k]) for side in box]) for k in (0, 1)))
    results = []
    for embed in (immrax.natemb, immrax.jacemb, immrax.mjacemb):
        begin = time.process_time()
        run = embed(Plant()).compute_trajectory(0.0, DURATION, immrax.i2ut(start), dt=0.01)
        states = np.asarray(run.ys)
        end = states[np.isfinite(states).all(1)][-1]  # the rest is padding
        results.append((float(end[2] - end[0]), time.process_time() - begin))
    return min(results)


def runs(rate, *box):
    """Return the width of x at the end over 400 runs: no enclosure is narrower."""
    rng = np.random.default_rng(0)
    corners = np.array([(x, v) for x in box[0] for v in box[1]])
    x, v = np.concatenate([corners, rng.uniform(*zip(*box, strict=True), (400, 2))]).T
    step = 0.001
    for _ in range(round(DURATION / step)):
        middle = x + 0.5 * step * v, v + 0.5 * step * RATES[rate](x, v, np.sin)
        x, v = x + step * middle[1], v + step * RATES[rate](*middle, np.sin)
    return float(np.ptp(x))


def main():
    """Print a line for each plant."""
    for name, plant in PLANTS.items():
        (own, spent), width = ours(*plant), runs(*plant)
        line = f"{name}: runs {width:.4g}, fuzzyctl {own:.4g} in {spent:.2f} s"
        try:
            other, took = theirs(*plant)
            line += f", immrax {other:.4g} in {took:.2f} s"
        except ImportError:
            line += ", immrax is not installed"
        print(line)


if __name__ == "__main__":
    if sys.argv[1:] == ["shipped"]:
        for name in SHIPPED:
            verdicts, spent = shipped(name)
            print(name, [type(v).__name__ for v in verdicts], f"in {spent:.1f} s")
    else:
        main()
