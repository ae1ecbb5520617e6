"""Evaluates systems with scikit-fuzzy; runs in an environment of its own.

    python scikit_fuzzy_driver.py FOLDER

reads every NAME.json of the folder with its points NAME.points, one a line, and writes the outputs to NAME.out, or to
NAME.err why there are none. Terms are polygons over the samples of a universe, which the user gives: here the corners
of the terms, or for outputs the number of samples that the system says, in equal steps as numpy's linspace has them.
"""

from __future__ import annotations

import json
from functools import reduce

import numpy as np
import skfuzzy as fuzz
from answering import answer
from skfuzzy import control as ctrl


def degrees(kind: str, p: list[float], x: np.ndarray) -> np.ndarray:
    """Return the degrees of a term at the samples of a universe."""
    if kind == "triangle":
        return fuzz.trimf(x, p)
    if kind == "trapezoid":
        return fuzz.trapmf(x, p)
    if kind == "ramp":
        return np.interp(x, p, [0.0, 1.0]) if p[0] < p[1] else np.interp(x, p[::-1], [1.0, 0.0])
    return np.interp(x, p[::2], p[1::2])


def universe(variable: dict, samples: int | None) -> np.ndarray:
    """Return equal steps, or the corners of the terms within the range and its ends."""
    low, high = variable["range"]
    if samples is not None:
        return np.linspace(low, high, samples)
    places = [low, high]
    for _, kind, p in variable["terms"]:
        places += p[::2] if kind == "piecewise" else p
    return np.array(sorted({x for x in places if low <= x <= high}))


def build(described: dict) -> tuple[ctrl.ControlSystemSimulation, dict]:
    """Return a simulation and its outputs by name."""
    variables = {}
    for kind in ("inputs", "outputs"):
        for v in described[kind]:
            x = universe(v, described["resolution"] if kind == "outputs" else None)
            made = ctrl.Antecedent(x, v["name"]) if kind == "inputs" else ctrl.Consequent(x, v["name"])
            for name, shape, p in v["terms"]:
                made[name] = degrees(shape, p, x)
            if kind == "outputs":
                made.defuzzify_method = described["defuzzifier"]
            variables[v["name"]] = made
    joins = {"min": np.fmin, "product": np.multiply}[described["conjunction"]]
    rules = []
    for rule in described["rules"]:
        consequents = [variables[o][t] % rule["weight"] for o, t in rule["consequents"]]
        rules.append(ctrl.Rule(condition(rule["antecedent"], variables), consequents, and_func=joins))
    simulation = ctrl.ControlSystemSimulation(ctrl.ControlSystem(rules), cache=False)
    return simulation, {v["name"]: variables[v["name"]] for v in described["outputs"]}


def condition(parts: list, variables: dict) -> object:
    """Return an antecedent."""
    word, *rest = parts
    if word == "is":
        return variables[rest[0]][rest[1]]
    if word == "not":
        return ~condition(rest[0], variables)
    found = [condition(r, variables) for r in rest]
    return reduce((lambda a, b: a & b) if word == "and" else (lambda a, b: a | b), found)


def run(simulation: ctrl.ControlSystemSimulation, described: dict, point: list[float]) -> None:
    """Compute a point; inputs that no rule reads are not known to scikit-fuzzy."""
    known = {a.label for a in simulation.ctrl.antecedents}
    for variable, value in zip(described["inputs"], point, strict=True):
        if variable["name"] in known:
            simulation.input[variable["name"]] = value
    simulation.compute()


def evaluate(described: dict, points: list[list[float]]) -> list[list[float]]:
    """Return the outputs at some points."""
    simulation, outputs = build(described)
    results = []
    for point in points:
        run(simulation, described, point)
        results.append([float(simulation.output.get(n, np.nan)) for n in outputs])
    return results


if __name__ == "__main__":
    answer(".json", lambda text, points: evaluate(json.loads(text), points))
