"""Table 12 over draws of the numbers that the paper does not print.

    python docs/explanation/reproduction/draws.py [--draws N] [--seed 0] [--jobs N] [box] [phases] [free]

runs `paper` under the three laws with each draw and prints how many entries are within 10 and 12 % of Table 12, of all
27 and of the 18 of AIFQSMC and FCAFSMC: least, 5 %, median, 95 %, greatest; and the shares of draws in which the order
of the laws is the paper's. Each kind takes about four minutes of CPU and goes to draws.json beside this file, unless
options say otherwise.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import runs

from dwmr.results.paper_tables import BARS, TABLE_12

RESULTS = Path(__file__).with_name("draws.json")
#: The box: amplitude [m/s, rad/s], frequency [rad/s], half width of FCAFSMC's partition [m, rad]. Each partition is
#: compiled, so there are few widths.
AMPLITUDES, FREQUENCIES, WIDTHS = (0.2, 0.3), (0.7, 1.2), tuple(round(0.2 + 0.025 * k, 3) for k in range(9))
#: Kinds of draws: the box; the phases of both sinusoids with the other numbers of `paper`; and all free choices: the
#: box, an amplitude and a sign each of v and ω, and both phases.
KINDS = ("box", "phases", "free")
DRAWS, SEED = {"box": 500, "phases": 500, "free": 250}, 0
QUANTILES = (0.0, 0.05, 0.5, 0.95, 1.0)
#: Sets of entries, and shares of draws.
ENTRIES, SHARES = ("27", "18"), ("all_18", "smc_worst", "ahead_x_e", "ahead_y_e")


def draw(kind: str, seed: int, number: int) -> list[str]:
    """Return the arguments of one draw, which depends on the seed and its number only."""
    random = np.random.default_rng([seed, number])
    amplitudes = [round(float(one), 4) for one in random.uniform(*AMPLITUDES, 2)]
    frequency, width = round(float(random.uniform(*FREQUENCIES)), 4), float(random.choice(WIDTHS))
    phases = [round(float(one), 4) for one in random.uniform(0.0, 2.0 * np.pi, 2)]
    signs = random.choice((-1.0, 1.0), 2)
    arguments = [f"disturbances.{2 * k}.phase={one!r}" for k, one in enumerate(phases) if kind != "box"]
    if kind == "phases":
        return arguments
    v = omega = amplitudes[0]
    if kind == "free":
        v, omega = (float(sign) * one for sign, one in zip(signs, amplitudes, strict=True))
    arguments += [*runs.keys("both", v=v, omega=omega), *runs.keys("sinusoid", angular_frequency=frequency)]
    return [*arguments, f"rules.fcafsmc.half_width={width!r}"]


def count(ratios: Mapping[runs.Entry, float]) -> dict[str, Any]:
    """Return the numbers of entries within the bars, and whether the orders of the laws are the paper's."""
    close = [ratio for (law, _, _), ratio in ratios.items() if law != "smc"]
    errors = {entry: ratio * TABLE_12[entry[0]][entry[1]][entry[2]] for entry, ratio in ratios.items()}
    within = {
        name: [sum(abs(one - 1.0) <= bar for one in values) for bar in BARS]
        for name, values in zip(ENTRIES, (ratios.values(), close), strict=True)
    }
    return {
        **within,
        "all_18": within["18"][0] == 18,
        "smc_worst": all(value < errors["smc", robot, n] for (law, robot, n), value in errors.items() if law != "smc"),
        **{f"ahead_{n}": errors["fcafsmc", "leader", n] < errors["aifqsmc", "leader", n] for n in ("x_e", "y_e")},
    }


def summary(counts: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the quantiles of the numbers of entries for each bar, and the shares of draws."""
    return {
        "draws": len(counts),
        "quantiles": {
            name: [
                [int(n) for n in np.quantile([one[name][k] for one in counts], QUANTILES, method="inverted_cdf")]
                for k in range(len(BARS))
            ]
            for name in ENTRIES
        },
        "shares": {name: float(np.mean([one[name] for one in counts])) for name in SHARES},
    }


def rows(summaries: Mapping[str, Any]) -> list[str]:
    """Return the rows of the page's table of quantiles."""
    return [
        f"| {kind} | {name} | {' | '.join(', '.join(map(str, numbers)) for numbers in one['quantiles'][name])} |"
        for kind, one in summaries.items()
        for name in ENTRIES
    ]


def shares(summaries: Mapping[str, Any]) -> list[str]:
    """Return the rows of the page's table of shares."""
    cells = {kind: [f"{100 * one['shares'][name]:.1f}" for name in SHARES] for kind, one in summaries.items()}
    return [f"| {kind} | {' | '.join(row)} |" for kind, row in cells.items()]


def main() -> None:
    """Run the draws and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinds", nargs="*", metavar="KIND", help="box, phases or free; all without one")
    parser.add_argument("--draws", type=int, help=f"default {', '.join(f'{n} of {kind}' for kind, n in DRAWS.items())}")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--jobs", type=int)
    options = parser.parse_args()
    if unknown := [one for one in options.kinds if one not in KINDS]:
        parser.error(f"KIND {unknown[0]!r} is not one of {', '.join(KINDS)}")
    if options.seed < 0 or (options.draws is not None and options.draws < 1):
        parser.error("--draws is at least 1 and --seed at least 0")
    summaries = {}
    for kind in options.kinds or KINDS:
        sets = [draw(kind, options.seed, k) for k in range(options.draws or DRAWS[kind])]
        summaries[kind] = summary([count(runs.ratios(row)) for row in runs.rows("paper", sets, jobs=options.jobs)])
        if (options.draws, options.seed) == (None, SEED):
            stored = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
            merged = {one: (stored | summaries)[one] for one in KINDS if one in stored | summaries}
            RESULTS.write_text(json.dumps(merged, indent=1) + "\n", encoding="utf-8")
    print(
        "| draws | entries | within 10 % | within 12 % |", "|---|---|---|---|", *rows(summaries), sep="\n", end="\n\n"
    )
    print("| draws | all 18 within 10 % | SMC worst | FCAFSMC's leader is before in x_e | in y_e |")
    print("|---|---|---|---|---|", *shares(summaries), sep="\n")


if __name__ == "__main__":
    main()
