"""How Table 12 comes out of other amplitudes, frequencies and widths of FCAFSMC's partition than those of `paper`.

    python docs/explanation/reproduction/amplitudes.py

prints the rows of the page's table: how many of the 18 errors of AIFQSMC and FCAFSMC are within 10 and 12 % of Table
12, their least and greatest ratio, in which errors FCAFSMC's leader is before AIFQSMC's as it is in the paper, and the
ratios of SMC's leader.
"""

from __future__ import annotations

from collections.abc import Iterator

from dwmr.control.fuzzy_gains import Known, Rules
from dwmr.results.metrics import errors, printed_frame, rmse
from dwmr.results.paper_tables import TABLE_12
from dwmr.scenario.file import find, read
from dwmr.simulation import simulate

#: Amplitude [m/s, rad/s], frequency [rad/s] and half width [m, rad]: those of `paper`, then others.
CHOSEN = (0.25, 0.85, 0.3)
NEAR = ((0.2375, 0.85, 0.3), (0.2625, 0.85, 0.3), (0.25, 0.8075, 0.3), (0.25, 0.8925, 0.3), (0.25, 0.85, 0.285),
        (0.25, 0.85, 0.315))  # fmt: skip
FAR = ((0.2, 0.85, 0.3), (0.3, 0.85, 0.3), (0.25, 0.7, 0.3), (0.25, 1.0, 0.3), (0.25, 1.2, 0.3), (0.25, 2.0, 0.3),
       (0.25, 0.85, 0.2), (0.25, 0.85, 0.4))  # fmt: skip
SETS = (CHOSEN, *NEAR, *FAR)
_KNOWN = Known()


def ratios(law: str, values: tuple[float, float, float]) -> dict[tuple[str, str], float]:
    """Return the ratios to Table 12 of one run, by robot and error."""
    amplitude, frequency, width = values
    keys = [f"disturbances.{k}.{key}={amplitude}" for k in range(4) for key in ("v", "omega")]
    keys += [f"disturbances.{k}.angular_frequency={frequency}" for k in (0, 2)]
    file = read(find("paper"), [*keys, f"rules.fcafsmc.half_width={width}"])
    rules = Rules(file.scenario.rules, file.folders, file.places, _KNOWN)
    run = simulate.run(simulate.prepare(file, law, rules))
    series = {robot: errors(run, robot, printed_frame(file.scenario, robot)) for robot in TABLE_12[law]}
    return {
        (r, name): rmse(series[r][name]) / wanted for r, row in TABLE_12[law].items() for name, wanted in row.items()
    }


def counts(values: tuple[float, float, float]) -> tuple[int, int, float, float, str]:
    """Return the numbers of errors of two laws within 10 and 12 %, their least and greatest ratio, and the order."""
    by_law = {law: ratios(law, values) for law in ("aifqsmc", "fcafsmc")}
    every = [ratio for row in by_law.values() for ratio in row.values()]
    within = [sum(abs(ratio - 1.0) <= bar for ratio in every) for bar in (0.10, 0.12)]
    mine = {law: {n: by_law[law]["leader", n] * TABLE_12[law]["leader"][n] for n in ("x_e", "y_e")} for law in by_law}
    order = [name for name in ("x_e", "y_e") if mine["fcafsmc"][name] < mine["aifqsmc"][name]]
    return within[0], within[1], min(every), max(every), ", ".join(order)


def rows() -> Iterator[str]:
    """Yield the rows of the page's table."""
    for values in SETS:
        near, nearly, least, greatest, order = counts(values)
        smc = ratios("smc", values)
        leader = " ".join(f"{smc['leader', name]:.2f}" for name in ("x_e", "y_e", "theta_e"))
        cells = [
            *(f"{one:g}" for one in values),
            str(near),
            str(nearly),
            f"{least:.2f} to {greatest:.2f}",
            order,
            leader,
        ]
        yield f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    print("\n".join(rows()))
