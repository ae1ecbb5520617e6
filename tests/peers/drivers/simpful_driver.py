"""Evaluates systems with simpful; runs in an environment of its own.

    python simpful_driver.py FOLDER

reads every NAME.json of the folder with its points NAME.points, one a line, and writes the outputs to NAME.out, or to
NAME.err why there are none.
"""

from __future__ import annotations

import contextlib
import io
import json
from functools import reduce

import simpful as sf
from answering import answer


def fuzzy_set(name: str, kind: str, p: list[float], universe: list[float]) -> sf.FuzzySet:
    """Return a term; simpful has no shoulders, and its sigmoid has the slope of ours."""
    functions = {
        "triangle": lambda: sf.Triangular_MF(*p),
        "trapezoid": lambda: sf.Trapezoidal_MF(*p),
        "gaussian": lambda: sf.Gaussian_MF(*p),
        "gaussian2": lambda: sf.DoubleGaussian_MF(*p),
        "sigmoid": lambda: sf.Sigmoid_MF(c=p[0], a=p[1]),
    }
    if kind == "piecewise":
        return sf.FuzzySet(points=[list(c) for c in zip(p[::2], p[1::2], strict=True)], term=name)
    return sf.FuzzySet(function=functions[kind](), term=name)


def condition(parts: list) -> str:
    """Return an antecedent with every pair in parentheses: simpful reads what has none from right to left."""
    word, *rest = parts
    if word == "is":
        return f"({rest[0]} IS {rest[1]})"
    if word == "not":
        return f"(NOT {condition(rest[0])})"
    return reduce(lambda a, b: f"({a} {word.upper()} {b})", map(condition, rest))


def build(described: dict) -> sf.FuzzySystem:
    """Return a system."""
    system = sf.FuzzySystem(
        show_banner=False, operators=["AND_PRODUCT"] if described["conjunction"] == "product" else None
    )
    averages = described["defuzzifier"] == "weighted_average"
    for variable in described["inputs"] + ([] if averages else described["outputs"]):
        sets = [fuzzy_set(*term, variable["range"]) for term in variable["terms"]]
        system.add_linguistic_variable(
            variable["name"], sf.LinguisticVariable(sets, universe_of_discourse=variable["range"])
        )
    for variable in described["outputs"] if averages else []:
        for name, kind, numbers in variable["terms"]:
            if kind == "constant":
                system.set_crisp_output_value(name, numbers[0])
            elif kind == "function":
                system.set_output_function(name, numbers[0].replace("^", "**"))
            else:
                names = [v["name"] for v in described["inputs"]]
                factors = [f"({a!r})*{n}" for a, n in zip(numbers, names, strict=False)]
                system.set_output_function(name, "+".join([*factors, f"({numbers[-1]!r})"]))
    rules = []
    for rule in described["rules"]:
        for output, term in rule["consequents"]:
            weight = f" WEIGHT {rule['weight']!r}" if rule["weight"] != 1.0 else ""
            rules.append(f"IF {condition(rule['antecedent'])} THEN ({output} IS {term}){weight}")
    system.add_rules(rules)
    return system


def evaluate(described: dict, points: list[list[float]]) -> list[list[float]]:
    """Return the outputs at some points."""
    system = build(described)
    names = [v["name"] for v in described["outputs"]]
    results = []
    for point in points:
        for variable, value in zip(described["inputs"], point, strict=True):
            system.set_variable(variable["name"], value)
        if described["defuzzifier"] == "weighted_average":
            found = system.Sugeno_inference(names)
        else:
            joins = {"max": max, "sum": sum}[described["aggregation"]]
            found = system.Mamdani_inference(names, subdivisions=described["resolution"], aggregation_function=joins)
        results.append([float(found[n]) for n in names])
    return results


def silently(text: str, points: list[list[float]]) -> list[list[float]]:
    """Evaluate without what simpful prints."""
    with contextlib.redirect_stdout(io.StringIO()):
        return evaluate(json.loads(text), points)


if __name__ == "__main__":
    answer(".json", silently)
