"""Verdicts on stability against everything that could contradict them, and against published conditions.

    python tests/bench/stability.py drawn [LOOPS] [MEMBERS] [SEED]    drawn loops against eigenvalues, functions, runs
    python tests/bench/stability.py sector                            MathWorks' example of absolute stability
    python tests/bench/stability.py rules                             parallel distributed compensation, largest b

The runs are computed here, with numpy alone: exact steps of the linear plant, the table by linear interpolation.
"""

import math
import sys
from collections import Counter
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from fuzzyctl import Proved, loads
from fuzzyctl.analysis.reach.prover import LoopProver

KINDS = ("linear", "saturated", "fuzzy")


class Drawn(NamedTuple):
    """A loop x' = A x + b (u + d), u = -f(c x), f odd and linear between knots; sampled every `step`, or continuous."""

    kind: str
    sampled: bool
    step: float
    a: object
    b: object
    c: object
    knots: object
    values: object
    start: float
    disturbance: float

    def u(self, x):
        y = x @ self.c
        return -self.values[-1] * y if self.kind == "linear" else -np.interp(y, self.knots, self.values)

    def text(self, claim, disturbed=False):
        """Return the loop as text with a claim."""
        n, law = len(self.b), {"linear": f"{self.values[-1]!r} * y", "fuzzy": "f(y)"}
        law["saturated"] = f"{self.values[-1]!r} * clamp(y / {self.knots[-1]!r}, -1, 1)"
        terms = " ".join(f"t{i}@{k!r}" for i, k in enumerate(self.knots))
        cells = " ".join(f"v{i}@{v!r}" for i, v in sorted(enumerate(self.values), key=lambda p: p[1]))
        rows = " ".join(f"v{i}" for i in range(len(self.values)))
        ends = f"[{self.knots[0]!r}, {self.knots[-1]!r}]", f"[{min(self.values)!r}, {max(self.values)!r}]"
        system = (
            f"system f\nand product\ndefuzzifier center_average\ninput y in {ends[0]}\n  terms {terms}\noutput u in "
        )
        system += f"{ends[1]}\n  terms {cells}\ntable u = y\n     {rows.replace('v', 't')}\n  |  {rows}\n"
        rates = [
            " + ".join(f"({self.a[i][j]!r}) * x{j}" for j in range(n)) + f" + ({self.b[i]!r}) * (u + d)"
            for i in range(n)
        ]
        y = " + ".join(f"({self.c[j]!r}) * x{j}" for j in range(n))
        inputs = "input u\n" if self.sampled else f"let y = {y}\nlet u = -({law[self.kind]})\n"
        return (
            (system if self.kind == "fuzzy" else "")
            + (
                f"controller law\ninput y\noutput u = -({law[self.kind]})\nevery {self.step!r}\n"
                if self.sampled
                else ""
            )
            + f"plant p\n{inputs}input d\n"
            + "".join(f"state x{i} = 0\n" for i in range(n))
            + "".join(f"der x{i} = {rates[i]}\n" for i in range(n))
            + f"output s = {y}\nloop l\n"
            + ("block law = law(p.s)\nblock p = p(u=law.u, d=w)\n" if self.sampled else "block p = p(d=w)\n")
            + "".join(f"for p.x{i} in [{-self.start!r}, {self.start!r}]\n" for i in range(n))
            + (f"disturbance w in [{-self.disturbance!r}, {self.disturbance!r}] = 0\n" if disturbed else "let w = 0\n")
            + f"run {20 * self.step!r} step {self.step!r}\nrequire {claim}\n"
        )

    def run(self, x, d, periods):
        """Yield the states of members, shape (members, states), four times a period; d has one value for each time."""
        n, parts = len(self.b), 4
        whole = np.zeros((n + 1, n + 1))
        whole[:n, :n], whole[:n, n] = self.a, self.b
        short = self.step / parts / (1 if self.sampled else 2)
        moved = expm(whole * short)
        for k in range(periods * parts):
            if self.sampled:
                if k % parts == 0:
                    held = self.u(x)
                x = x @ moved[:n, :n].T + np.outer(held + d[k % len(d)], moved[:n, n])
            else:
                for _ in range(2):  # RK4
                    slope, total = 0.0, 0.0
                    for weight, share in ((1, 0.0), (2, 0.5), (2, 0.5), (1, 1.0)):
                        z = x + share * short * slope
                        slope = z @ np.transpose(self.a) + np.outer(self.u(z) + d[k % len(d)], self.b)
                        total = total + weight * slope
                    x = x + short / 6 * total
            yield x

    def linear_limit(self, gain):
        """Return the largest real part, or for a sampled loop the radius minus 1, of the loop with a gain."""
        if not self.sampled:
            return float(np.linalg.eigvals(self.a - gain * np.outer(self.b, self.c)).real.max())
        n = len(self.b)
        whole = np.zeros((n + 1, n + 1))
        whole[:n, :n], whole[:n, n] = self.a, self.b
        moved = expm(whole * self.step)
        return float(np.abs(np.linalg.eigvals(moved[:n, :n] - gain * np.outer(moved[:n, n], self.c))).max()) - 1.0

    def gain(self):
        """Return the slope of f at 0."""
        if self.kind == "linear":
            return self.values[-1]
        return float(np.interp(1e-6 * self.knots[-1], self.knots, self.values) / (1e-6 * self.knots[-1]))

    def cycle(self):
        """Return the amplitude of y of a limit cycle by the describing function; None for none (continuous loops)."""
        angles = np.linspace(0, 2 * math.pi, 400, endpoint=False)
        sizes = np.geomspace(0.05, 50, 80) * self.knots[-1]
        n_of = [2 * np.mean(np.sin(angles) * np.interp(a * np.sin(angles), self.knots, self.values)) / a for a in sizes]
        limits = np.array([self.linear_limit(g) for g in n_of])
        change = np.flatnonzero(np.diff(np.sign(limits)))
        return float(sizes[change[0]]) if len(change) else None


def drawn(rng):
    """Draw a loop."""
    kind, n = KINDS[rng.integers(3)], int(rng.integers(1, 4))
    poles = -rng.uniform(0.05, 3, n) * (1 if rng.random() < 0.7 else rng.choice([-0.3, 1], n))
    a = np.diag(poles) + np.triu(rng.uniform(-2, 2, (n, n)), 1)
    turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
    a, b, c = turn @ a @ turn.T, rng.normal(size=n), rng.normal(size=n)
    half = np.sort(rng.uniform(0.2, 1, 2 if kind == "fuzzy" else 1))
    rise = np.cumsum(rng.uniform(0.1, 1.5, len(half))) * rng.choice([1, 1, 1, -0.3])
    knots, values = np.concatenate([-half[::-1], [0.0], half]), np.concatenate([-rise[::-1], [0.0], rise])
    a, b, c, knots, values = (
        [float(x) for x in v] if np.ndim(v) == 1 else v.tolist() for v in (a, b, c, knots, values)
    )
    start, step = float(rng.uniform(0.05, 0.5)), float(rng.choice([0.02, 0.1, 0.3]))
    return Drawn(kind, bool(rng.random() < 0.5), step, a, b, c, knots, values, start, float(rng.uniform(0.01, 0.2)))


def starts(loop, rng, members):
    """Return starts of members: the corners, then drawn ones."""
    n = len(loop.b)
    corners = np.array(np.meshgrid(*[[-1.0, 1.0]] * n)).reshape(n, -1).T
    return loop.start * np.concatenate([corners, rng.uniform(-1, 1, (max(members - len(corners), 0), n))])


def disturbances(loop, rng, members, kind):
    """Return values of d, shape (times, members): 0, constant ends, switches at random, or random."""
    times, w = 80, loop.disturbance
    match kind:
        case "ends":
            return np.tile(w * rng.choice([-1.0, 1.0], members), (times, 1))
        case "switches":
            return w * np.where(np.cumsum(rng.random((times, members)) < 0.1, 0) % 2 == 0, 1.0, -1.0)
    return rng.uniform(-w, w, (times, members))


def largest(loop, rng, members):
    """Return the largest |y| over members in 20 periods: from corners, drawn, and improved near the worst."""
    most = 0.0
    for kind in ("ends", "switches", "random"):
        x, d = starts(loop, rng, members // 6), disturbances(loop, rng, max(members // 6, 2 ** len(loop.b)), kind)
        for _ in range(2):
            peak = np.abs(x @ loop.c)
            for z in loop.run(x, d[:, : len(x)], 20):
                peak = np.maximum(peak, np.abs(z @ loop.c))
            most, best = (
                max(most, float(np.nan_to_num(peak, nan=np.inf).max())),
                np.argsort(-peak)[: max(len(x) // 20, 1)],
            )
            again = np.resize(best, len(x))
            x = np.clip(x[again] + rng.normal(0, 0.1 * loop.start, x.shape), -loop.start, loop.start)
            d = np.where(rng.random(d[:, : len(x)].shape) < 0.95, d[:, again], -d[:, again])
    return most


def converging(loop, rng, ball, members):
    """Return whether runs behave as a proof of convergence claims."""
    basis = ball.balls[0].basis
    inverse = np.linalg.inv(basis)
    factor = np.linalg.cond(basis) * 4.0
    periods = int(min(math.log(factor * 2) / -math.log(ball.rate), 600)) if ball.rate < 1.0 else 600
    x = starts(loop, rng, members)
    *_, last = loop.run(x, np.zeros((1, 1)), max(periods, 1))
    spread = [np.linalg.norm(z @ inverse.T, axis=1).max() for z in (x, last)]
    late = ball.rate**periods
    return bool(np.isfinite(last).all() and spread[1] <= spread[0] * max(4.0 * late, 1e-9) * 8.0)


def settles(loop, rng, limit):
    """Return whether 16 members converge to 0 in a long run."""
    x, periods = starts(loop, rng, 16), min(600, int(12 / -limit / (1 if loop.sampled else loop.step)) + 1)
    with np.errstate(over="ignore", invalid="ignore"):
        *_, last = loop.run(x, np.zeros((1, 1)), periods)
    return bool(np.abs(last).max() < 1e-2 * loop.start) if np.isfinite(last).all() else False


def popov(loop):
    """Return whether the circle criterion and Popov's hold by frequencies for the sector of f (continuous loops)."""
    slopes = [v / k for k, v in zip(loop.knots, loop.values, strict=True) if k]
    reach = sum(abs(c) for c in loop.c) * loop.start * 10
    low, high = min(*slopes, loop.values[-1] / max(reach, loop.knots[-1])), max(*slopes)
    a = np.array(loop.a) - low * np.outer(loop.b, loop.c)
    if np.linalg.eigvals(a).real.max() >= 0 or high - low < 1e-9:
        return None
    grid = np.concatenate([[0.0], np.geomspace(1e-3, 1e3, 600)])
    g = np.array([np.array(loop.c) @ np.linalg.solve(1j * w * np.eye(len(a)) - a, loop.b) for w in grid])
    eta = np.concatenate([[0.0], np.geomspace(1e-3, 1e3, 60), -np.geomspace(1e-3, 1e3, 60)])
    margins = (g.real[None] - eta[:, None] * (grid * g.imag)[None]).min(1) + 1 / (high - low)
    return bool(margins[0] > 0), bool(margins.max() > 0)


def verdict(text, timeout=0.5):
    """Return the verdict on the one claim of a loop, without runs that refute it: compiling them takes longest."""
    loop = loads(text, block="l")
    prover = LoopProver(loop, timeout)
    prover._refuted = {}
    return prover.verdict(loop.guarantees[0])


def judged(loop, rng, members):
    """Return the outcomes of a loop: a Counter, with the key "contradiction" for each of them."""
    counts, where = Counter(), f"{loop.kind}, {'sampled' if loop.sampled else 'continuous'}"
    limit = loop.linear_limit(loop.gain())
    answer = verdict(loop.text("stable"))
    true = (limit < 0) if loop.kind == "linear" else limit < 0 and settles(loop, rng, limit)
    if isinstance(answer, Proved):
        counts[where, "stable: proved"] += 1
        cycle = None if loop.kind == "linear" or loop.sampled else loop.cycle()
        objections = limit >= 0, not converging(loop, rng, answer.data, 64)
        (ball,) = answer.data.balls
        reach = float(np.sqrt(((np.array(loop.c) @ ball.basis) ** 2).sum()) * ball.radius)
        objections += (cycle is not None and cycle < 0.9 * reach,)
        counts["contradiction"] += any(objections)
    elif true:
        counts[where, "stable: open, but runs converge"] += 1
        if not loop.sampled and loop.kind != "linear" and (found := popov(loop)) is not None:
            counts[
                "Lur'e, continuous, open", "circle, global" if found[0] else "Popov only" if found[1] else "neither"
            ] += 1
    else:
        counts[where, "stable: open, runs do not converge or slowly"] += 1
    most = largest(loop, rng, min(members, 240))
    bound = most * float(rng.uniform(0.8, 1.6))
    if not math.isfinite(bound) or bound > 1e6:
        return counts
    answer = verdict(loop.text(f"always abs(p.s) <= {bound!r}", disturbed=True))
    name = "proved" if isinstance(answer, Proved) else "open"
    counts[where, f"always: {name}, {'true' if bound >= most else 'false'} for 240 members"] += 1
    if name == "proved":
        counts["contradiction"] += largest(loop, rng, members) > bound * (1 + 1e-6)
        counts["members of proved claims"] += 3 * 2 * (members // 6)
    return counts


def main_drawn(loops=1000, members=6000, seed=0):
    """Print how many drawn loops are decided, and how many verdicts are contradicted."""
    rng, counts = np.random.default_rng(seed), Counter(contradiction=0)
    for _ in range(loops):
        counts.update(judged(drawn(rng), rng, members))
    for key, count in sorted(counts.items(), key=str):
        print(f"{count:8,}  {key if isinstance(key, str) else ': '.join(key)}")


#: MathWorks' example "Absolute Stability for Quantized System" (Control System Toolbox); "Analyze Absolute Stability of
#: Fuzzy Controller" (Fuzzy Logic Toolbox, R2026b) has the same plant. Sampled every 10 ms, u = -N(y).
PLANT = ([[0.9995, 0.0100, 0.0001], [-0.0020, 0.9995, 0.0106], [0.0, 0.0, 0.9978]], [0.0, 0.002, 0.04],
         [2.3948, 0.3303, 2.2726])  # fmt: skip


def sector_of(density):
    """Return the sector of a logarithmic quantizer: [0.4, 1.6] for 0.25, accepted there; for 0.1 it is refused."""
    return 2 * density / (1 + density), 2 / (1 + density)


def sector_text(density):
    """Return the example with a table whose chords fill the sector, for outputs up to 1000."""
    (low, high), (a, b, c) = sector_of(density), PLANT
    y = " + ".join(f"{x!r} * x{j}" for j, x in enumerate(c))
    return (
        "system n\nand product\ndefuzzifier center_average\ninput y in [-1000, 1000]\n"
        + f"  terms a@-1000 b@{-high / low!r} c@-1 d@0 e@1 f@{high / low!r} g@1000\n"
        + f"output u in [{-1000 * low!r}, {1000 * low!r}]\n"
        + f"  terms a@{-1000 * low!r} c@{-high!r} d@0 e@{high!r} g@{1000 * low!r}\n"
        + "table u = y\n     a b c d e f g\n  |  a c c d e e g\ncontroller closed\ninput unused\n"
        + "".join(f"state x{i} = 0\n" for i in range(3))
        + f"let u = -n({y})\n"
        + "".join(
            f"next x{i} = " + " + ".join(f"({a[i][j]!r}) * x{j}" for j in range(3)) + f" + ({b[i]!r}) * u\n"
            for i in range(3)
        )
        + "output y = x0\nevery 10 ms\nloop l\nblock closed = closed(0)\n"
        + "".join(f"for closed.x{i} in [-5, 5]\n" for i in range(3))
        + "run 1 s\nrequire stable\n"
    )


def circle(density):
    """Return whether the circle criterion holds on a grid of frequencies."""
    (low, high), (a, b, c) = sector_of(density), map(np.array, PLANT)
    poles, modes = np.linalg.eig(a - low * np.outer(b, c))
    if np.abs(poles).max() >= 1:
        return False
    gains = (c @ modes) * np.linalg.solve(modes, b)
    response = (gains / (np.exp(1j * np.geomspace(1e-6, math.pi, 40000))[:, None] - poles)).sum(1)
    return bool(response.real.min() + 1 / (high - low) > 0)


def least(accepted, low, high, tolerance):
    """Return the least number that is accepted, by bisection."""
    while high - low > tolerance:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if accepted(middle) else (middle, high)
    return high


def sector(timeout=3.0):
    """Print the coarsest quantizer that is proved, and that of the circle criterion by frequencies."""
    for density in (0.25, 0.1):
        answer = verdict(sector_text(density), timeout)
        print(f"density {density}, sector {sector_of(density)}: {type(answer).__name__}")
    proved = least(lambda d: isinstance(verdict(sector_text(d), timeout), Proved), 0.2, 0.25, 1e-4)
    print(f"proved from density {proved:.4f} on; by frequencies from {least(circle, 0.2, 0.25, 1e-5):.4f} on")


def rules_text(a, b, first, second):
    """Return the loop x' = sum h_i h_j (A_i - B_i F_j) x with A1 = [2 -10; 2 0], A2 = [a -10; 1 1], B2 = [b; 2]."""
    matrices = {"one": ([[2, -10], [2, 0]], [1, 1]), "two": ([[a, -10], [1, 1]], [b, 2])}

    def system(name, inputs, rows):
        terms = "input z in [-1, 1]\n  one = function(0.5 - 0.5 * z)\n  two = function(0.5 + 0.5 * z)\n"
        ranges = "".join(f"input {i} in [-1e6, 1e6]\n" for i in inputs)
        rules = "".join(f"if z is {k} then r is function({row})\n" for k, row in rows.items())
        return f"system {name}\ndefuzzifier weighted_average\n{terms}{ranges}output r in [-1e9, 1e9]\n{rules}"

    gains = {"one": first, "two": second}
    text = system("law", "xy", {k: f"({float(f[0])!r}) * x + ({float(f[1])!r}) * y" for k, f in gains.items()})
    for i in range(2):
        rows = {k: f"({m[i][0]!r}) * x + ({m[i][1]!r}) * y + ({n[i]!r}) * u" for k, (m, n) in matrices.items()}
        text += system(f"rate{i}", "xyu", rows)
    return text + (
        "plant p\nstate x = 0\nstate y = 0\nlet u = -law(x, x, y)\nder x = rate0(x, x, y, u)\n"
        "der y = rate1(x, x, y, u)\noutput s = x\nloop l\nblock p = p()\nfor p.x in [-0.01, 0.01]\n"
        "for p.y in [-0.01, 0.01]\nrun 1 s step 1 ms\nrequire stable\n"
    )


def placed(a, b, pole=-2.0):
    """Return the gains that place both poles of each rule, and the matrices A_i - B_i F_j."""
    models = [
        (np.array([[2.0, -10], [2, 0]]), np.array([1.0, 1])),
        (np.array([[a, -10], [1.0, 1]]), np.array([b, 2.0])),
    ]
    gains = []
    for m, n in models:
        wanted = m @ m - 2 * pole * m + pole**2 * np.eye(2)  # Ackermann
        gains.append(np.array([0.0, 1.0]) @ np.linalg.solve(np.column_stack([n, m @ n]), wanted))
    return gains, [[m - np.outer(n, f) for f in gains] for m, n in models]


def proved_rules(a, b):
    """Return whether `require stable` is proved."""
    return isinstance(verdict(rules_text(a, b, *placed(a, b)[0]), 1.0), Proved)


def exact_rules(a, b):
    """Return whether one quadratic function exists: Liu, Zhang 2003, exact for two rules (cvxpy)."""
    import cvxpy as cp

    closed = placed(a, b)[1]
    p, margin, eye = cp.Variable((2, 2), symmetric=True), cp.Variable(), np.eye(2)
    first, second = (cp.Variable((2, 2), symmetric=True) for _ in range(2))
    cross = cp.Variable((2, 2))

    def rate(g):
        return g.T @ p + p @ g

    both = rate(closed[0][1] + closed[1][0]) + cross + cross.T
    claims = [rate(closed[0][0]) + first << -margin * eye, rate(closed[1][1]) + second << -margin * eye]
    claims += [both << -margin * eye, cp.bmat([[first, cross], [cross.T, second]]) >> 0]
    cp.Problem(cp.Maximize(margin), [*claims, p >> 0, cp.trace(p) == 1, margin <= 1]).solve(solver=cp.CLARABEL)
    return margin.value is not None and margin.value > 1e-6


def rules():
    """Print the largest b for each a: of the verdict, and with cvxpy of the exact condition."""
    try:
        import cvxpy  # noqa: F401

        columns = {"proved": proved_rules, "exact": exact_rules}
    except ImportError:
        columns = {"proved": proved_rules}
    for a, start in ((2.0, 8.0), (4.0, 8.0), (6.0, 10.0), (8.0, 14.0), (10.0, 18.0)):
        edges = {}
        for name, holds in columns.items():
            low = start
            while holds(a, low + 1.0):
                low += 1.0
            edges[name] = least(lambda b, a=a, holds=holds: not holds(a, b), low, low + 1.0, 0.01) - 0.01
        print(f"a = {a:g}: " + ", ".join(f"{name} b <= {b:.2f}" for name, b in edges.items()))


def main(name="drawn", *numbers):
    """Run one of the comparisons."""
    {"drawn": main_drawn, "sector": sector, "rules": rules}[name](*map(int, numbers))


if __name__ == "__main__":
    main(*sys.argv[1:])
