"""Time of the same workloads in other Python tools, each in an environment of its own that lasts as long as the run.

Runs by itself in such an environment, too: `python peers.py TOOL ENGINE POINTS` prints nanoseconds for each evaluation.
"""

from __future__ import annotations

import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any, Final

#: What to install, and the workloads that the tool can express: W1 and W4 need Takagi-Sugeno, W2 has 49 rules by hand.
PEERS: Final[dict[str, tuple[tuple[str, ...], tuple[str, ...]]]] = {
    "pyfuzzylite": (("pyfuzzylite==8.0.6", "numpy<2"), ("W1", "W2", "W3", "W4")),
    "scikit-fuzzy": (("scikit-fuzzy==0.5.0", "networkx", "scipy", "packaging"), ("W3",)),
    "simpful": (("simpful==2.12.0",), ("W3",)),
}
ROUNDS, POINTS = 3, 200

Evaluate = Callable[[float, float], Any]


def environment(peer: str, folder: Path) -> Path | None:
    """Install a tool and return the Python that has it; None, with the reason printed, where that fails."""
    python = folder / peer / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(folder / peer)], check=True)
        install = [str(python), "-m", "pip", "install", "-q", *PEERS[peer][0]]
        done = subprocess.run(install, capture_output=True, text=True, check=False)
        if done.returncode:
            print(f"{peer} cannot be installed: {done.stderr.strip().splitlines()[-1]}", file=sys.stderr)
            return None
    return python


def measure(peer: str, python: Path, engine: Path, points: Path) -> float | None:
    """Return nanoseconds of an evaluation; None, with the reason printed, where the tool fails."""
    command = [str(python), __file__, peer, str(engine), str(points)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        print(f"{peer} fails: {done.stderr.strip().splitlines()[-1]}", file=sys.stderr)
        return None
    return float(done.stdout.split()[-1])


def _pyfuzzylite(engine: Path) -> Evaluate:
    import fuzzylite

    system = fuzzylite.FllImporter().from_string(engine.read_text(encoding="utf-8"))
    (first, second), output = system.input_variables, system.output_variables[0]

    def evaluate(x: float, y: float) -> Any:
        first.value, second.value = x, y
        system.process()
        return output.value

    return evaluate


def _scikit_fuzzy(_engine: Path) -> Evaluate:
    import numpy as np
    import skfuzzy
    from skfuzzy import control

    service = control.Antecedent(np.linspace(0, 10, 101), "service")
    food = control.Antecedent(np.linspace(0, 10, 101), "food")
    tip = control.Consequent(np.linspace(0, 30, 101), "tip")
    for name, mean in (("poor", 0), ("good", 5), ("excellent", 10)):
        service[name] = skfuzzy.gaussmf(service.universe, mean, 1.5)
    food["rancid"] = skfuzzy.trapmf(food.universe, [-2, 0, 1, 3])
    food["delicious"] = skfuzzy.trapmf(food.universe, [7, 9, 10, 12])
    for name, left in (("cheap", 0), ("average", 10), ("generous", 20)):
        tip[name] = skfuzzy.trimf(tip.universe, [left, left + 5, left + 10])
    rules = [
        control.Rule(service["poor"] | food["rancid"], tip["cheap"]),
        control.Rule(service["good"], tip["average"]),
        control.Rule(service["excellent"] | food["delicious"], tip["generous"]),
    ]
    simulation = control.ControlSystemSimulation(control.ControlSystem(rules), cache=False)

    def evaluate(x: float, y: float) -> Any:
        simulation.input["service"], simulation.input["food"] = x, y
        simulation.compute()
        return simulation.output["tip"]

    return evaluate


def _simpful(_engine: Path) -> Evaluate:
    import simpful

    system = simpful.FuzzySystem(show_banner=False)
    service = [
        simpful.GaussianFuzzySet(mu=m, sigma=1.5, term=t) for t, m in (("poor", 0), ("good", 5), ("excellent", 10))
    ]
    food = [
        simpful.TrapezoidFuzzySet(-2, 0, 1, 3, term="rancid"),
        simpful.TrapezoidFuzzySet(7, 9, 10, 12, term="delicious"),
    ]
    tip = [
        simpful.TriangleFuzzySet(a, a + 5, a + 10, term=t) for t, a in (("cheap", 0), ("average", 10), ("generous", 20))
    ]
    system.add_linguistic_variable("service", simpful.LinguisticVariable(service, universe_of_discourse=[0, 10]))
    system.add_linguistic_variable("food", simpful.LinguisticVariable(food, universe_of_discourse=[0, 10]))
    system.add_linguistic_variable("tip", simpful.LinguisticVariable(tip, universe_of_discourse=[0, 30]))
    system.add_rules(
        [
            "IF (service IS poor) OR (food IS rancid) THEN (tip IS cheap)",
            "IF (service IS good) THEN (tip IS average)",
            "IF (service IS excellent) OR (food IS delicious) THEN (tip IS generous)",
        ]
    )

    def evaluate(x: float, y: float) -> Any:
        system.set_variable("service", x)
        system.set_variable("food", y)
        return system.Mamdani_inference(["tip"], subdivisions=101)["tip"]

    return evaluate


_TOOLS: Final = {"pyfuzzylite": _pyfuzzylite, "scikit-fuzzy": _scikit_fuzzy, "simpful": _simpful}


def main(peer: str, engine: str, points: str) -> None:
    """Print the best time of some rounds."""
    evaluate = _TOOLS[peer](Path(engine))
    numbers = list(struct.iter_unpack("dd", Path(points).read_bytes()))[:POINTS]
    best = float("inf")
    for _ in range(ROUNDS):
        began = perf_counter()
        for x, y in numbers:
            evaluate(x, y)
        best = min(best, (perf_counter() - began) / len(numbers) * 1e9)
    print(best)


if __name__ == "__main__":
    main(*sys.argv[1:])
