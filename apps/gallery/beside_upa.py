"""`python apps/gallery/beside_upa.py`: the loops upa_motor and upa_pendulum compared with UPAFuzzySystems 0.2.4.

UPAFuzzySystems comes from PyPI into a separate environment in a temporary folder; it needs python-control before
0.10 and numpy before 2. There this file runs itself with an argument, the file that the outputs go to. Times are those
of the processor, the best of some runs: other work on the machine does not count.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
import time
import venv
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

PACKAGES: Final = ("UPAFuzzySystems==0.2.4", "control==0.9.4", "numpy<2")
#: Loops by the name of the folder: those of the exact centroid and of the centroid on the grid, and the output.
LOOPS: Final = {
    "upa_motor": ("exact_motor", "grid_motor", "motor.y"),
    "upa_pendulum": ("exact_pendulum", "grid_pendulum", "pendulum.y"),
}
RUNS: Final = {"upa": 2, "fuzzyctl": 20}


def timed(run: Callable[[], Any], count: int) -> tuple[float, Any]:
    """Return the least time of some runs on the processor [s], and the result of the last one."""
    best = math.inf
    for _ in range(count):
        begin = time.process_time()
        result = run()
        best = min(best, time.process_time() - begin)
    return best, result


def theirs() -> dict[str, tuple[float, list[float]]]:
    """Return the time and the outputs of each loop in UPAFuzzySystems."""
    import control
    import numpy as np

    results = {}
    for name, build in {"upa_motor": _motor, "upa_pendulum": _pendulum}.items():
        system, times, reference = build()
        respond = partial(control.input_output_response, system, times, reference, 0)
        seconds, response = timed(respond, RUNS["upa"])
        results[name] = (seconds, [float(y) for y in np.ravel(response.outputs)])
    return results


def _universe(name: str, points: Any, terms: Mapping[str, Sequence[float]]) -> Any:
    from UPAFuzzySystems import fuzzy_universe

    universe = fuzzy_universe(name, points, "continuous")
    for term, corners in terms.items():
        universe.add_fuzzyset(term, "trimf" if len(corners) == 3 else "trapmf", list(corners))
    return universe


def _mamdani(inputs: list[Any], output: Any, rules: list[tuple[list[str], str]]) -> Any:
    from UPAFuzzySystems import inference_system

    system = inference_system("rules")
    for universe in inputs:
        system.add_premise(universe)
    system.add_consequence(output)
    for terms, then in rules:
        premises = [[universe.name, term] for universe, term in zip(inputs, terms, strict=True)]
        system.add_rule(premises, ["and"] * (len(inputs) - 1), [[output.name, then]])
    system.configure("Mamdani")
    system.build()
    return system


def _motor() -> tuple[Any, Any, list[float]]:
    import control
    import numpy as np
    from UPAFuzzySystems import fuzzy_controller

    error = _universe(
        "E", np.arange(-100, 101, 1), {"N": (-100, -100, -50, 0), "Z": (-1, 0, 1), "P": (0, 50, 100, 100)}
    )
    voltage = _universe("U", np.arange(-20, 21, 1), {"N": (-20, -20, -5, 0), "Z": (-5, 0, 5), "P": (0, 5, 20, 20)})
    rules = _mamdani([error], voltage, [([t], t) for t in "NZP"])
    times = np.linspace(0, 1, 500)
    s = control.TransferFunction.s
    plant = 0.0274 / (s * ((3.2284e-6 * s + 3.5077e-6) * (2.75e-6 * s + 4) + 0.0274**2))
    loop = fuzzy_controller(rules, typec="Fuzzy1", tf=plant, DT=times[1])
    loop.build()
    return loop.get_system(), times, [math.pi / 4 * _ramp(t, 0.25, 0.255) for t in times]


def _pendulum() -> tuple[Any, Any, list[float]]:
    import control
    import numpy as np
    from UPAFuzzySystems import fuzzy_controller

    error = _universe("E", np.linspace(-1, 1, 41), {"N": (-1, -1, -0.2, 0), "Z": (-0.2, 0, 0.2), "P": (0, 0.2, 1, 1)})
    rate = _universe("D", np.linspace(-2, 2, 41), {"N": (-2, -2, -1, 0), "Z": (-1, 0, 1), "P": (0, 1, 2, 2)})
    forces = {"NB": (-80, -60, -30), "N": (-60, -30, 0), "Z": (-30, 0, 30), "P": (0, 30, 60), "PB": (30, 60, 80)}
    force = _universe("U", np.linspace(-80, 80, 161), forces)
    names = list(forces)
    rules = [([a, b], names[j + k]) for j, a in enumerate("NZP") for k, b in enumerate("NZP")]
    times = np.linspace(0, 20, 2001)
    s = control.TransferFunction.s
    cart, mass, length, inertia, friction, gravity = 2.4, 0.23, 0.4, 0.099, 0.055, 9.81
    turning, weight = mass * length**2 + inertia, mass * gravity * length
    q = (cart + mass) * turning - (mass * length) ** 2
    below = s**3 + friction * turning / q * s**2 - (cart + mass) * weight / q * s - friction * weight / q
    plant = mass * length / q * s / below
    loop = fuzzy_controller(_mamdani([error, rate], force, rules), typec="Fuzzy2", tf=plant, DT=times[1])
    loop.build()
    return loop.get_system(), times, [0.1 * (_ramp(t, 0.5, 1) - _ramp(t, 5, 5.5)) for t in times]


def _ramp(t: float, begin: float, end: float) -> float:
    return min(max((t - begin) / (end - begin), 0.0), 1.0)


def compared(theirs: dict[str, tuple[float, list[float]]]) -> str:
    """Run the same loops here, and return a Markdown table of both.

    Args:
        theirs: For each loop the time [s] and the outputs at its samples.
    """
    import fuzzyctl

    lines = ["| loop | UPAFuzzySystems [s] | here [s] | times as fast | end there | end here | largest difference |"]
    lines.append("|---" * 7 + "|")
    for name, (slow, outputs) in theirs.items():
        *loops, signal = LOOPS[name]
        for loop in loops:
            experiment = fuzzyctl.Experiment(
                fuzzyctl.load(Path(__file__).parent / name / f"{name}.fz", block=loop), "numba"
            )
            experiment.run()  # compiles
            fast, run = timed(experiment.run, RUNS["fuzzyctl"])
            apart = max(abs(a - b) for a, b in zip(run[signal], outputs, strict=True))
            values = (
                f"{slow:.2f}",
                f"{fast:.2g}",
                f"{slow / fast:,.0f}",
                f"{outputs[-1]:.9f}",
                f"{run[signal][-1]:.9f}",
            )
            lines.append(f"| {loop} | {' | '.join(values)} | {apart:.1e} |")
    return "\n".join(lines)


def main() -> None:
    """Run UPAFuzzySystems in a separate environment, and print a comparison with the loops of the gallery."""
    if len(sys.argv) > 1:
        Path(sys.argv[1]).write_text(json.dumps(theirs()), encoding="utf-8")
        return
    with tempfile.TemporaryDirectory() as folder:
        venv.create(folder, with_pip=True)
        python = next(p for p in (Path(folder) / "bin/python", Path(folder) / "Scripts/python.exe") if p.exists())
        subprocess.run([python, "-m", "pip", "install", "-q", *PACKAGES], check=True)
        results = Path(folder) / "results.json"
        subprocess.run([python, "-W", "ignore", __file__, results], check=True)
        print(compared(json.loads(results.read_text(encoding="utf-8"))))


if __name__ == "__main__":
    main()
