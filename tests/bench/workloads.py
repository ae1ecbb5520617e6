"""The four workloads that kernels are measured with, each a rule file and the ranges its points are drawn from."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

RULES = Path(__file__).parent.parent.parent / "rules"

SEVEN = "NB NM NS ZO PS PM PB".split()


@dataclass(frozen=True)
class Workload:
    """A system and where it is evaluated: over 1.5 times the ranges, so that shoulders are used.

    Args:
        name: Short name.
        what: What it is.
        text: The rule file.
        low, high: Ranges of the two inputs.
    """

    name: str
    what: str
    text: str
    low: tuple[float, float]
    high: tuple[float, float]

    def points(self, count: int, seed: int = 1) -> NDArray[np.float64]:
        """Return uniform random points, shape (count, 2)."""
        return np.random.default_rng(seed).uniform(self.low, self.high, (count, 2))


def _seven_by_seven() -> str:
    rows = [
        f"  {name} | {' '.join(SEVEN[min(max(i + j - 3, 0), 6)] for j in range(7))}" for i, name in enumerate(SEVEN)
    ]
    terms = f"  terms {' '.join(SEVEN)}"
    return "\n".join(
        [
            "system w2",
            "defuzzifier centroid",
            "input e in [-1, 1]",
            terms,
            "input de in [-1, 1]",
            terms,
            "output u in [-1, 1]",
            terms,
            "table u = e x de",
            f"  {' '.join(SEVEN)}",
            *rows,
            "",
        ]
    )


#: Consequents of W4: factors of both inputs, and a constant.
LINES = (
    (1.0, 2.0, 0.5),
    (-1.0, 0.2, 0.1),
    (0.3, -2.0, 0.0),
    (0.7, 0.5, -0.5),
    (0.1, 0.1, 0.0),
    (-0.4, 1.2, 0.2),
    (2.0, -0.5, 0.3),
    (-1.5, 0.7, -0.1),
    (0.9, 0.9, 0.9),
)


def _gaussian_sugeno() -> str:
    terms = "\n".join(f"  {n} = gaussian({m}, 0.5)" for n, m in zip("NZP", (-1, 0, 1), strict=True))
    lines = "\n".join(f"  c{k} = linear({a}, {b}, {c})" for k, (a, b, c) in enumerate(LINES))
    head = "system w4\nand product\ndefuzzifier weighted_average"
    inputs = f"input a in [-2, 2]\n{terms}\ninput b in [-2, 2]\n{terms}"
    table = "table u = a x b\n     N  Z  P\n  N | c0 c1 c2\n  Z | c3 c4 c5\n  P | c6 c7 c8\n"
    return f"{head}\n{inputs}\noutput u in [-5, 5]\n{lines}\n{table}"


_TIPPER = (RULES / "tipper.fz").read_text(encoding="utf-8")

WORKLOADS = (
    Workload(
        "W1",
        "25 rules, product, centre average",
        (RULES / "ais_reaction.fz").read_text(encoding="utf-8"),
        (-0.045, -0.75),
        (0.045, 0.75),
    ),
    Workload("W2", "49 rules, min/max, exact centroid", _seven_by_seven(), (-1.5, -1.5), (1.5, 1.5)),
    Workload(
        "W3", "tipper, exact centroid", (RULES / "tipper.fz").read_text(encoding="utf-8"), (0.0, 0.0), (10.0, 10.0)
    ),
    Workload("W4", "9 rules, Gaussian, first-order Sugeno", _gaussian_sugeno(), (-2.0, -2.0), (2.0, 2.0)),
)
