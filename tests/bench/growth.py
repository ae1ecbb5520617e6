"""Measure how the cost of an evaluation grows with inputs, terms and samples, and draw it.

    python tests/bench/growth.py -o FOLDER

Writes growth.json and growth.svg into the folder. One point in compiled code, the best of some rounds.
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

import fuzzyctl

sys.path.insert(0, str(Path(__file__).parents[2]))

POINTS, ROUNDS = 100_000, 5


def complete(inputs: int, terms: int, conjunction: str, defuzzifier: str) -> str:
    """Return a complete rule base over even partitions; each rule says one of five terms."""
    names = [f"t{k}" for k in range(terms)]
    lines = ["system s", f"and {conjunction}", f"defuzzifier {defuzzifier}"]
    for i in range(inputs):
        lines += [f"input x{i} in [0, 1]", f"  terms {' '.join(names)}"]
    lines += ["output u in [0, 1]", "  terms a b c d e"]
    for combination in itertools.product(range(terms), repeat=inputs):
        antecedent = " and ".join(f"x{i} is t{k}" for i, k in enumerate(combination))
        lines.append(f"if {antecedent} then u is {'abcde'[sum(combination) * 7 % 5]}")
    return "\n".join(lines) + "\n"


def cost(text: str, inputs: int) -> float:
    """Return nanoseconds of one evaluation inside a compiled loop."""
    import numba

    function = fuzzyctl.compile(fuzzyctl.loads(text), "numba").jit
    arguments = ", ".join(f"points[k, {i}]" for i in range(inputs))
    lines = ["def loop(points):", "    s = 0.0", "    for k in range(points.shape[0]):", f"        s += f({arguments})"]
    body = "\n".join([*lines, "    return s"])
    names: dict[str, Any] = {"f": function}
    exec(compile(body, "<loop>", "exec"), names)  # a loop over as many inputs as there are
    loop = numba.njit(names["loop"])
    points = np.random.default_rng(1).uniform(-0.1, 1.1, (POINTS, inputs))
    loop(points[:2])
    best = float("inf")
    for _ in range(ROUNDS):
        began = perf_counter()
        loop(points)
        best = min(best, perf_counter() - began)
    return best / POINTS * 1e9


#: What is varied: title, label of the axis, and for each curve its name with systems by the value varied.
STUDIES: dict[str, dict[str, Any]] = {
    "inputs": {
        "label": "inputs of 3 terms each (3ⁿ rules)",
        "curves": {
            "product, average": [(n, complete(n, 3, "product", "weighted_average"), n) for n in (1, 2, 3, 4, 5, 6)],
            "min, average": [(n, complete(n, 3, "min", "weighted_average"), n) for n in (1, 2, 3, 4, 5, 6)],
        },
    },
    "terms": {
        "label": "terms of each of 2 inputs (k² rules)",
        "curves": {
            "product, average": [(k, complete(2, k, "product", "weighted_average"), 2) for k in (3, 5, 7, 9, 11)],
            "min, average": [(k, complete(2, k, "min", "weighted_average"), 2) for k in (3, 5, 7, 9, 11)],
            "min, max, exact centroid": [(k, complete(2, k, "min", "centroid"), 2) for k in (3, 5, 7, 9)],
        },
    },
    "samples": {
        "label": "samples of the centroid (25 rules)",
        "curves": {
            "sampled": [(n, complete(2, 5, "min", f"centroid(resolution={n})"), 2) for n in (10, 30, 100, 300, 1000)],
            "exact": [(0, complete(2, 5, "min", "centroid"), 2)],
        },
    },
}


def measure() -> dict[str, dict[str, list[tuple[int, float]]]]:
    """Return the cost by study and curve: (what was varied, ns)."""
    return {study: {name: _costs(curve) for name, curve in data["curves"].items()} for study, data in STUDIES.items()}


def _costs(curve: list[tuple[int, str, int]]) -> list[tuple[int, float]]:
    return [(varied, round(cost(text, inputs), 1)) for varied, text, inputs in curve]


#: Okabe and Ito's colours.
COLORS = ("#0072B2", "#D55E00", "#009E73")
STYLE = {
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "figure.constrained_layout.use": True,
    "grid.alpha": 0.3,
    "svg.hashsalt": "fuzzyctl",
}


def draw(found: dict[str, dict[str, list[tuple[int, float]]]], target: Path) -> None:
    """Draw one panel for each study."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure((10.5, 4.0))
        panels = figure.subplots(1, len(found))
        for ax, (study, curves) in zip(panels, found.items(), strict=True):
            for color, marker, (name, points) in zip(COLORS, "osd", curves.items(), strict=False):
                if len(points) == 1:  # what is varied does not matter to it
                    ax.axhline(points[0][1], color=color, ls="--", label=name)
                else:
                    ax.plot(*zip(*points, strict=True), color=color, marker=marker, ms=4, label=name)
            ax.set(xlabel=STUDIES[study]["label"], yscale="log", ylim=(1, 3000))
            if study == "samples":
                ax.set_xscale("log")
                ax.xaxis.set_major_formatter("{x:g}")
            else:
                ax.locator_params(axis="x", integer=True)
            ax.yaxis.set_major_formatter("{x:g}")
            ax.legend(fontsize="small", frameon=False, loc="upper left")
        panels[0].set_ylabel("ns per evaluation")
        figure.savefig(target, metadata={"Date": None})


def main() -> None:
    """Measure, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", dest="out", type=Path, default=Path("."), help="folder to write to")
    folder = parser.parse_args().out
    found = measure()
    (folder / "growth.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    draw(found, folder / "growth.svg")
    for study, curves in found.items():
        for name, points in curves.items():
            print(f"{study}: {name}: {', '.join(f'{n}: {ns:g} ns' for n, ns in points)}")


if __name__ == "__main__":
    main()
