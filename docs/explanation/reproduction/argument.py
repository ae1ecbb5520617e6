"""The paper's argument for stability, Eqs. (10) to (43), as one table.

    python docs/explanation/reproduction/argument.py

prints for each condition whether it is proved for all states, and by which claim, or assumed. The other columns are
leader, follower1 and follower2 in the run `paper` under AIFQSMC, v / ω channel: a share of time, or a largest value.
A share is the part of the time in which the condition fails, counted where the row applies.

d̃_0 is taken as in `results.lyapunov`. For the last rows d̃ is all that moves σ* except the law, that is
(dσ*/dt)/b + G_AIS sat(σ*) + p σ* with b = λ1² or D²; `one_channel.fz` proves a bound for |d̃| <= 0.28.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

import fuzzyctl
from dwmr.control.fuzzy_gains import Rules
from dwmr.results import lyapunov
from dwmr.results.metrics import measure
from dwmr.scenario.file import find, read
from dwmr.simulation import simulate
from fuzzyctl import Proved
from fuzzyctl.support.files import shipped_files

#: Bound of d̃ [m/s, rad/s], and the bound of σ* that is proved for it [m, rad]; the disturbances of `paper` reach 0.25.
D_MAX, BOUND = 0.28, 0.032
#: From here on f <= -0.33 and sat(σ*) = ±1 [m, rad]; the range of b in `one_channel.fz`.
FAR, B = 0.03, (0.25, 1.1)
#: Tolerance of the claims of the rule files.
TINY = 1e-12
#: Claims about the shipped tables that the argument needs; not in the rule files, since edited tables may break them.
MORE = {
    "ais_reaction": "f <= -0.33 within 1e-12 when abs(sigma) >= 0.03",
    "boundary_layer": "beta <= abs_sigma within 1e-12 when abs_sigma >= 0.0275",
}


class Row(NamedTuple):
    """A row of the table: equations, a condition, whether it is proved, and cells of the robots."""

    equations: str
    condition: str
    status: str
    cells: tuple[str, ...]


class Channel(NamedTuple):
    """The signals of one channel of one robot in AIFQSMC; `d` is d̃ from each sample to the next."""

    sigma: Any
    beta: Any
    gain: Any
    g_ais: Any
    f: Any
    d_0: Any
    d: Any
    b: Any
    epsilon: float
    avoiding: Any

    def bounded(self) -> Any:
        """Whether |d̃| and b are within the ranges of `one_channel.fz`, from each sample to the next."""
        return (np.abs(self.d) <= D_MAX) & (self.b >= B[0]) & (self.b <= B[1])

    def kept(self) -> Any:
        """|σ*| at the end of periods that begin within the bound and in which d̃ is bounded."""
        size = np.abs(self.sigma)
        return size[1:][self.bounded() & (size[:-1] <= BOUND)]


def proofs() -> dict[str, bool]:
    """Return by rule file whether all of its claims are proved, and those of `MORE`."""
    blocks = {name: fuzzyctl.load(name, block=name) for name in ("immune_channel", "one_channel")}
    for name, claim in MORE.items():
        text = shipped_files()[name].read_text(encoding="utf-8")
        blocks[name] = fuzzyctl.loads(f"{text}\nrequire {claim}\n")
    return {name: all(isinstance(v, Proved) for v in fuzzyctl.prove(block)) for name, block in blocks.items()}


def run_of(*overrides: str) -> tuple[Any, Any]:
    """Return a run of `paper` under AIFQSMC, and its scenario."""
    file = read(find("paper"), overrides)
    return simulate.run(simulate.prepare(file, "aifqsmc", Rules(file.scenario.rules, (), file.places))), file.scenario


def channels(run: Any, scenario: Any) -> list[list[Channel]]:
    """Return the channels v and ω of each robot."""
    signals, rows = lyapunov.signals(run, scenario), []
    for i, name in enumerate(run.robots):
        robot = scenario.robots[name]
        gains = robot.controllers["aifqsmc"]
        slopes = (
            np.full(len(run.t), gains["lambda_1"] ** 2),
            (gains["lambda_2"] * (robot.d + run["x_e"][:, i]) + gains["lambda_3"]) ** 2,
        )
        pair = []
        for key, b in zip(("v", "omega"), slopes, strict=True):
            sigma = run[f"sigma_{key}"][:, i]
            push = signals[f"switching_{key}"][:, i] + gains[f"p_{key}"] * sigma
            d = np.diff(sigma) / np.diff(run.t) / b[:-1] + push[:-1]
            parts = (run[f"{part}_{key}"][:, i] for part in ("beta", "k_h", "g_ais", "f"))
            avoiding = run["obstacle"][:, i] >= 0
            epsilon = gains[f"epsilon_{key}"]
            pair.append(Channel(sigma, *parts, signals[f"d_0_{key}"][:, i], d, b[:-1], epsilon, avoiding))
        rows.append(pair)
    return rows


def share(fails: Any, applies: Any = True) -> str:
    """Return the share of the time in which a condition fails, counted where it applies."""
    applies = np.broadcast_to(applies, fails.shape)
    return f"{np.mean(fails[applies]):.0%}" if applies.any() else "-"


def table(run: Any, scenario: Any, proved: dict[str, bool]) -> Iterator[Row]:
    """Yield the rows of the table."""
    robots, shares = channels(run, scenario), measure(run, scenario, ("lyapunov", "condition_violated"))

    def by(*names: str) -> str:
        return "proved: " + ", ".join(names) if all(proved[n] for n in names) else "NOT PROVED: " + ", ".join(names)

    def each(cell: Any) -> tuple[str, ...]:
        return tuple(" / ".join(cell(c) for c in pair) for pair in robots)

    def one(cell: Any) -> tuple[str, ...]:
        return tuple(f"{cell(name):.0%}" for name in run.robots)

    def counted(key: str) -> tuple[str, ...]:
        return one(lambda name: shares["lyapunov"][name][key])

    yield Row("(10)", "V does not grow (V > 0 by its form)", "conclusion", counted("V_10_growing"))
    yield Row("(13)", "λ2/λ3 <= 1/(|d + x_e| + 1)", "assumed", one(lambda name: shares["condition_violated"][name]))
    yield Row("(11), (12), (14)", "dV/dt <= 0", "conclusion", counted("V_dot_10_positive"))
    yield Row("(15)-(17), (20)", "G_AIS > 0; least", by("immune_channel"), each(lambda c: f"{c.g_ais.min():.4f}"))
    yield Row("(18)", "f <= -0.33 if |σ*| >= 0.03", by("ais_reaction"),
              each(lambda c: share(c.f > -0.33 + TINY, np.abs(c.sigma) >= FAR)))  # fmt: skip
    yield Row("(19)", "0.005 <= β <= 0.05", by("boundary_layer"),
              each(lambda c: share((c.beta < 0.005 - TINY) | (c.beta > 0.05 + TINY))))  # fmt: skip
    yield Row("(21), (22)", "k̂_h >= k̄_h; largest", by("immune_channel"), each(lambda c: f"{c.gain.max():.3f}"))
    yield Row("(23)-(27), (37)", "dV/dt <= 0, k_h the largest k̂_h", "conclusion", counted("V_dot_23_positive"))
    yield Row("(28), (29), (33), (38), (39)", "|d̃_0| <= 0.28", "assumed",
              each(lambda c: share(np.abs(c.d_0) > D_MAX)))  # fmt: skip
    yield Row("(30), (32), (34), (36)", "G_AIS >= 0.28 if |σ*| >= 0.03", by("ais_reaction", "immune_channel"),
              each(lambda c: share(c.g_ais < D_MAX, np.abs(c.sigma) >= FAR)))  # fmt: skip
    yield Row("(34)", "G_AIS >= 0.28 if |σ*| < 0.03", "assumed",
              each(lambda c: share(c.g_ais < D_MAX, np.abs(c.sigma) < FAR)))  # fmt: skip
    yield Row("(30), (31)", "k̂_h <= k_h if |σ*| > ε, k_h the largest k̂_h", "assumed",
              each(lambda c: share(c.gain > c.gain.max(), np.abs(c.sigma) > c.epsilon)))  # fmt: skip
    yield Row("(35), (41)", "k̂_h >= k_h if |σ*| < ε", "assumed",
              each(lambda c: share(c.gain < c.gain.max(), np.abs(c.sigma) < c.epsilon)))  # fmt: skip
    yield Row("(40)", "G_AIS |σ*|/β >= 0.28 if |σ*| <= β", "assumed",
              each(lambda c: share(c.g_ais * np.abs(c.sigma) < D_MAX * c.beta, np.abs(c.sigma) <= c.beta)))  # fmt: skip
    yield Row("(42), (43)", "|σ*| = ε and |σ*| <= β never", by("boundary_layer"),
              each(lambda c: share((np.abs(c.sigma) <= c.beta) & (np.abs(c.sigma) >= c.epsilon))))  # fmt: skip
    yield Row("section 4.2", "|d̃| <= 0.28, tracking", "assumed",
              each(lambda c: share(~c.bounded(), ~c.avoiding[:-1])))  # fmt: skip
    yield Row("", "|d̃| <= 0.28, avoidance", "assumed", each(lambda c: share(~c.bounded(), c.avoiding[:-1])))
    yield Row("", f"then |σ*| <= {BOUND} for ever; largest", by("one_channel"),
              each(lambda c: f"{c.kept().max(initial=0.0):.4f}"))  # fmt: skip
    yield Row("", "largest |σ*| after 10 s, all the same", "",
              each(lambda c: f"{np.abs(c.sigma[run.t >= 10.0]).max(initial=0.0):.4f}"))  # fmt: skip


def main() -> None:
    """Print the table."""
    print("| equations | condition | | leader | follower1 | follower2 |\n|---|---|---|---|---|---|")
    for equations, condition, status, cells in table(*run_of(), proofs()):
        print("| " + " | ".join((equations, condition.replace("|", "\\|"), status, *cells)) + " |")


if __name__ == "__main__":
    main()
