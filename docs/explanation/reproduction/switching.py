"""How often the avoidance of `paper` switches, with and without hysteresis and with shorter control periods.

    python docs/explanation/reproduction/switching.py

prints the rows of the page's table: law, hysteresis [m], control period [ms], switches of the leader's avoidance, how
many of them follow the one before within 10 periods, the leader's chattering in the whole run and outside of avoidances
[m/s²], and by how many percent its x_e, y_e and θ_e and those of the followers, at most, differ from `paper` as it is.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

from dwmr.control.fuzzy_gains import Known, Rules
from dwmr.results.metrics import measure
from dwmr.scenario.file import find, read
from dwmr.simulation import simulate

LAWS = ("aifqsmc", "fcafsmc")
HYSTERESES = (0.0, 0.1, 0.2, 0.3, 0.5)
#: Control period [s] and integration steps in it; the steps stay as long.
PERIODS = ((0.005, 4), (0.0025, 2), (0.001, 1))
NAMES = ("x_e", "y_e", "theta_e")
_KNOWN = Known()


@cache
def measures(law: str, hysteresis: float = 0.0, dt: float = 0.005, substeps: int = 4) -> dict[str, Any]:
    """Return the measures of one run."""
    settings = (f"avoidance.hysteresis={hysteresis}", f"run.dt={dt}", f"run.substeps={substeps}")
    file = read(find("paper"), settings)
    rules = Rules(file.scenario.rules, file.folders, file.places, _KNOWN)
    run = simulate.run(simulate.prepare(file, law, rules))
    return measure(run, file.scenario, ("rmse", "chattering", "chattering_outside", "avoidance_switches"))


def row(law: str, hysteresis: float, dt: float, substeps: int) -> str:
    """Return one row of the page's table."""
    now, usual = measures(law, hysteresis, dt, substeps), measures(law)
    moved = {r: [100.0 * (now["rmse"][r][n] / usual["rmse"][r][n] - 1.0) for n in NAMES] for r in now["rmse"]}
    leader = moved.pop("leader")
    switches = now["avoidance_switches"]["leader"]
    levels = [f"{now[name]['leader']['v']:.2f}" for name in ("chattering", "chattering_outside")]
    cells = [
        *(law, f"{hysteresis:g}", f"{1e3 * dt:g}", str(switches["all"]), str(switches["fast"]), *levels),
        " ".join(f"{one:+.1f}" for one in leader),
        f"{max(abs(one) for row in moved.values() for one in row):.1f}",
    ]
    return f"| {' | '.join(cells)} |"


def rows() -> Iterator[str]:
    """Yield the rows of the page's table."""
    for law in LAWS:
        for hysteresis in HYSTERESES:
            for dt, substeps in PERIODS if hysteresis in (HYSTERESES[0], HYSTERESES[-1]) else PERIODS[:1]:
                yield row(law, hysteresis, dt, substeps)


if __name__ == "__main__":
    print("\n".join(rows()))
