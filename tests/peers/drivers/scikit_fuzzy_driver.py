"""Evaluates systems with scikit-fuzzy; runs in an environment of its own.

    python scikit_fuzzy_driver.py FOLDER

reads every NAME.json of the folder with its points NAME.points, one a line, and writes the outputs to NAME.out, or to
NAME.err why there are none. Terms are polygons over the samples of a universe, which the user gives: here the corners
of the terms and, since scikit-fuzzy leaves them out, the places where two cut terms of an output cross at a point.
"""

from __future__ import annotations

import json
from functools import reduce
from itertools import combinations

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


def universe(variable: dict, more: list[float]) -> np.ndarray:
    """Return the corners of the terms within the range, its ends, and more points."""
    low, high = variable["range"]
    places = [low, high, *more]
    for _, kind, p in variable["terms"]:
        places += p[::2] if kind == "piecewise" else p
    return np.array(sorted({x for x in places if low <= x <= high}))


def build(described: dict, more: dict[str, list[float]]) -> tuple[ctrl.ControlSystemSimulation, dict]:
    """Return a simulation and its outputs by name."""
    variables = {}
    for kind in ("inputs", "outputs"):
        for v in described[kind]:
            x = universe(v, more.get(v["name"], []))
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


def crossings(variable: dict, cuts: dict[str, float]) -> list[float]:
    """Return where two cut terms cross."""
    low, high = variable["range"]
    shapes = {name: (kind, p) for name, kind, p in variable["terms"]}
    places = set(universe(variable, []))
    for name, cut in cuts.items():  # where a term meets its own cut
        x = np.array(sorted(places))
        y = degrees(*shapes[name], x) - cut
        places |= {_root(*ends) for ends in zip(x, x[1:], y, y[1:], strict=False) if ends[2] * ends[3] < 0.0}
    x = np.array(sorted(places))
    found = []
    for a, b in combinations(cuts, 2):
        y = np.minimum(degrees(*shapes[a], x), cuts[a]) - np.minimum(degrees(*shapes[b], x), cuts[b])
        found += [_root(*ends) for ends in zip(x, x[1:], y, y[1:], strict=False) if ends[2] * ends[3] < 0.0]
    return [p for p in found if low < p < high]


def _root(x0: float, x1: float, y0: float, y1: float) -> float:
    return float(x0 + (x1 - x0) * (y0 / (y0 - y1)))


def run(simulation: ctrl.ControlSystemSimulation, described: dict, point: list[float]) -> None:
    """Compute a point; inputs that no rule reads are not known to scikit-fuzzy."""
    known = {a.label for a in simulation.ctrl.antecedents}
    for variable, value in zip(described["inputs"], point, strict=True):
        if variable["name"] in known:
            simulation.input[variable["name"]] = value
    simulation.compute()


def evaluate(described: dict, points: list[list[float]]) -> list[list[float]]:
    """Return the outputs at some points."""
    results = []
    for point in points:
        simulation, outputs = build(described, {})
        simulation.cache = True
        run(simulation, described, point)
        more = {}
        for v in described["outputs"]:
            cuts = {n: t.membership_value[simulation] for n, t in outputs[v["name"]].terms.items()}
            more[v["name"]] = crossings(v, {n: float(c) for n, c in cuts.items() if c is not None and c > 0.0})
        simulation, outputs = build(described, more)
        simulation.cache = True
        run(simulation, described, point)
        results.append([float(simulation.output.get(n, np.nan)) for n in outputs])
    return results


if __name__ == "__main__":
    answer(".json", lambda text, points: evaluate(json.loads(text), points))
