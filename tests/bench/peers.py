"""Time of the same workloads in other Python tools, each in an environment of its own that lasts as long as the run.

Runs by itself in such an environment, too: `python peers.py TOOL ENGINE POINTS` prints nanoseconds for each evaluation,
and with `--values` the outputs instead.
"""

from __future__ import annotations

import re
import struct
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import Any, Final

#: What to install, and the workloads that the tool can express: scikit-fuzzy has no consequents but sets.
PEERS: Final[dict[str, tuple[tuple[str, ...], tuple[str, ...]]]] = {
    "pyfuzzylite": (("pyfuzzylite==8.0.6", "numpy<2"), ("W1", "W2", "W3", "W4")),
    "scikit-fuzzy": (("scikit-fuzzy==0.5.0", "networkx", "scipy", "packaging"), ("W2", "W3")),
    "simpful": (("simpful==2.12.0",), ("W1", "W2", "W3", "W4")),
}
ROUNDS, POINTS, SAMPLES = 3, 200, 101

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
    said = _run(peer, python, engine, points)
    return float(said.split()[-1]) if said is not None else None


def values(peer: str, python: Path, engine: Path, points: Path) -> list[float] | None:
    """Return the outputs at some points; None, with the reason printed, where the tool fails."""
    said = _run(peer, python, engine, points, "--values")
    return [float(v) for v in said.splitlines()[-1].split()] if said is not None else None


def _run(peer: str, python: Path, engine: Path, points: Path, *more: str) -> str | None:
    command = [str(python), __file__, peer, str(engine), str(points), *more]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        print(f"{peer} fails: {done.stderr.strip().splitlines()[-1]}", file=sys.stderr)
        return None
    return done.stdout


@dataclass
class Variable:
    """An input or the output of a workload.

    Args:
        name: Name.
        low, high: Range.
        terms: Kind and numbers of each term, by name.
    """

    name: str
    low: float = 0.0
    high: float = 0.0
    terms: dict[str, tuple[str, list[float]]] = field(default_factory=dict)


@dataclass
class Engine:
    """A workload as its FLL says it: two inputs, one output, rules of one or two conditions.

    Args:
        variables: The inputs, then the output.
        rules: Variables and terms of each rule, the consequent last, and what joins the conditions.
        product: Whether they are joined by the product.
    """

    variables: list[Variable]
    rules: list[tuple[list[tuple[str, str]], str]]
    product: bool

    @property
    def output(self) -> Variable:
        """The last variable."""
        return self.variables[-1]


def parsed(text: str) -> Engine:
    """Read FLL as far as the workloads use it."""
    engine = Engine([], [], "conjunction: AlgebraicProduct" in text)
    for line in text.splitlines():
        word, _, rest = line.strip().partition(": ")
        if word in ("InputVariable", "OutputVariable"):
            engine.variables.append(Variable(rest))
        elif word == "range":
            variable = engine.variables[-1]
            variable.low, variable.high = map(float, rest.split())
        elif word == "term":
            name, kind, *numbers = rest.split()
            engine.variables[-1].terms[name] = kind, [float(n) for n in numbers]
        elif word == "rule":
            engine.rules.append((re.findall(r"(\w+) is (\w+)", rest), "or" if " or " in rest else "and"))
    return engine


def trapezoid(kind: str, numbers: list[float]) -> list[float]:
    """Return four corners; a ramp is a shoulder that goes on beyond all points."""
    if kind == "Triangle":
        a, b, c = numbers
        return [a, b, b, c]
    if kind == "Ramp":
        foot, top = numbers
        return [foot, top, 1e3, 1e3 + 1] if foot < top else [-1e3 - 1, -1e3, top, foot]
    return numbers


def _pyfuzzylite(engine: Path) -> Evaluate:
    import fuzzylite

    system = fuzzylite.FllImporter().from_string(engine.read_text(encoding="utf-8"))
    (first, second), output = system.input_variables, system.output_variables[0]

    def evaluate(x: float, y: float) -> Any:
        first.value, second.value = x, y
        system.process()
        return output.value

    return evaluate


def _scikit_fuzzy(path: Path) -> Evaluate:
    import numpy as np
    import skfuzzy
    from skfuzzy import control

    engine, made = parsed(path.read_text(encoding="utf-8")), {}
    for variable in engine.variables:
        kind = control.Consequent if variable is engine.output else control.Antecedent
        made[variable.name] = kind(np.linspace(variable.low, variable.high, SAMPLES), variable.name)
        for name, (shape, numbers) in variable.terms.items():
            x = made[variable.name].universe
            is_curved = shape == "Gaussian"
            degrees = skfuzzy.gaussmf(x, *numbers) if is_curved else skfuzzy.trapmf(x, trapezoid(shape, numbers))
            made[variable.name][name] = degrees
    rules = []
    for (*conditions, (output, term)), word in engine.rules:
        first, *rest = (made[v][t] for v, t in conditions)
        for other in rest:
            first = first | other if word == "or" else first & other
        rules.append(control.Rule(first, made[output][term]))
    simulation = control.ControlSystemSimulation(control.ControlSystem(rules), cache=False)
    names = [v.name for v in engine.variables]

    def evaluate(x: float, y: float) -> Any:
        simulation.input[names[0]], simulation.input[names[1]] = x, y
        simulation.compute()
        return simulation.output[names[2]]

    return evaluate


def _simpful(path: Path) -> Evaluate:
    import simpful

    engine = parsed(path.read_text(encoding="utf-8"))
    operators = ["AND_PRODUCT"] if engine.product else None
    system = simpful.FuzzySystem(show_banner=False, operators=operators)
    names = [v.name for v in engine.variables]
    sugeno = False
    for variable in engine.variables:
        sets = []
        for name, (shape, numbers) in variable.terms.items():
            if shape == "Constant":
                system.set_crisp_output_value(name, numbers[0])
            elif shape == "Linear":
                a, b, c = numbers
                system.set_output_function(name, f"({a!r})*{names[0]}+({b!r})*{names[1]}+({c!r})")
            elif shape == "Gaussian":
                sets.append(simpful.GaussianFuzzySet(mu=numbers[0], sigma=numbers[1], term=name))
            else:
                sets.append(simpful.TrapezoidFuzzySet(*trapezoid(shape, numbers), term=name))
        sugeno = not sets
        if sets:
            ends = [variable.low, variable.high]
            system.add_linguistic_variable(variable.name, simpful.LinguisticVariable(sets, universe_of_discourse=ends))
    system.add_rules(
        [
            f"IF {f' {word.upper()} '.join(f'({v} IS {t})' for v, t in conditions)} THEN ({output} IS {term})"
            for (*conditions, (output, term)), word in engine.rules
        ]
    )

    def evaluate(x: float, y: float) -> Any:
        system.set_variable(names[0], x)
        system.set_variable(names[1], y)
        if sugeno:
            return system.Sugeno_inference([names[2]])[names[2]]
        return system.Mamdani_inference([names[2]], subdivisions=SAMPLES)[names[2]]

    return evaluate


_TOOLS: Final = {"pyfuzzylite": _pyfuzzylite, "scikit-fuzzy": _scikit_fuzzy, "simpful": _simpful}


def main(peer: str, engine: str, points: str, *more: str) -> None:
    """Print the best time of some rounds, or the outputs."""
    evaluate = _TOOLS[peer](Path(engine))
    numbers = list(struct.iter_unpack("dd", Path(points).read_bytes()))[:POINTS]
    if more:
        print(*(float(evaluate(x, y)) for x, y in numbers))
        return
    best = float("inf")
    for _ in range(ROUNDS):
        began = perf_counter()
        for x, y in numbers:
            evaluate(x, y)
        best = min(best, (perf_counter() - began) / len(numbers) * 1e9)
    print(best)


if __name__ == "__main__":
    main(*sys.argv[1:])
