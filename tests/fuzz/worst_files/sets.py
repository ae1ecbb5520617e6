"""Worst cases of shapes of fuzzy sets, samples and norms."""

import random

from worst_files.case import HEAD, OUTPUTS, RULES, SUGENO, TERMS, case, files_case, inputs_of, names
from worst_files.claims import SMALL

FLL = """Engine: worst
InputVariable: x
  enabled: true
  range: 0.000 1.000
  lock-range: false
  term: low Discrete {}
OutputVariable: y
  enabled: true
  range: 0.000 1.000
  lock-range: false
  aggregation: Maximum
  defuzzifier: Centroid 100
  default: 0.0
  lock-previous: false
  term: small Triangle 0.000 0.500 1.000
RuleBlock: rules
  enabled: true
  conjunction: Minimum
  disjunction: Maximum
  implication: Minimum
  activation: General
  rule: if x is low then y is small
"""


@files_case
def a_discrete_term(size):
    points = " ".join(f"{k / 20000:.6g} {k % 2}" for k in range(int(20_000 * size)))
    return {"discrete.fll": FLL.format(points)}


@case
def a_long_piecewise(size):
    yield "input x in [0, 1]\n  low = piecewise(0, 0"
    body = "".join(f", {k / 60000:.6g}, {k % 2}" for k in range(1, int(60_000 * size)))
    yield body + ")\n  high = triangle(0, 1, 2)\n" + HEAD.split("\n", 2)[2] + "if x is low then y is small\n"


@case
def a_long_piecewise_output(size):
    yield "input x in [0, 1]\n  terms low high\noutput y in [0, 1]\n  small = piecewise(0, 0"
    body = "".join(f", {k / 60000:.6g}, {k % 2}" for k in range(1, int(60_000 * size)))
    yield body + ")\n  large = triangle(0, 1, 2)\nif x is low then y is small\nif x is high then y is large\n"


@case
def many_long_piecewise(size):
    points = "".join(f", {k / 600:.6g}, {k % 2}" for k in range(1, int(600 * size)))
    terms = "".join(f"  s{k} = piecewise(0, 0{points})\n" for k in range(int(150 * size)))
    rules = "".join(f"if x is low then y is s{k}\n" for k in range(int(150 * size)))
    yield "input x in [0, 1]\n  terms low high\noutput y in [0, 1]\n" + terms + rules


@case
def many_gaussians(size):
    terms = "".join(f"  s{k} = gaussian({k / 1000}, 0.01)\n" for k in range(int(TERMS * size)))
    rules = "".join(f"if x is low then y is s{k}\n" for k in range(int(TERMS * size)))
    yield "input x in [0, 1]\n  terms low high\noutput y in [0, 1]\n" + terms + rules


@case
def gaussians_as_inputs(size):
    terms = "".join(f"  s{k} = gaussian({k / 1000}, 0.0001)\n" for k in range(int(TERMS * size)))
    yield f"input x in [0, 1]\n{terms}input z in [0, 1]\n{terms}output y in [0, 1]\n  terms small large\n"
    for k in range(int(TERMS * size)):
        yield f"if x is s{k} and z is s{k} then y is small\n"


@case
def gaussians_of_six_inputs(size):
    terms = "".join(f"  s{k} = gaussian({k / 5}, 0.0001)\n" for k in range(6))
    yield "".join(f"input x{k} in [0, 1]\n{terms}" for k in range(6)) + "output y in [0, 1]\n  terms small large\n"
    rng = random.Random(1)
    for _ in range(int(5000 * size)):
        yield "if " + " and ".join(f"x{i} is s{rng.randrange(6)}" for i in range(6)) + " then y is small\n"


@case
def a_million_samples(size):
    yield f"defuzzifier centroid(resolution={int(1_000_000 * size)})\n" + SMALL


@case
def a_million_samples_of_many_terms(size):
    terms = "".join(f"  s{k} = gaussian({k / 1000}, 0.01)\n" for k in range(int(TERMS * size)))
    rules = "".join(f"if x is low then y is s{k}\n" for k in range(int(TERMS * size)))
    yield f"defuzzifier centroid(resolution={int(1_000_000 * size)})\n"
    yield "input x in [0, 1]\n  terms low high\noutput y in [0, 1]\n" + terms + rules


@case
def a_million_samples_of_many_outputs(size):
    outputs = int(OUTPUTS * size)
    yield f"defuzzifier centroid(resolution={int(1_000_000 * size)})\ninput x in [0, 1]\n  terms low high\n"
    yield "".join(f"output y{k} in [0, 1] else 0\n  terms small large\n" for k in range(outputs))
    for t in ("low", "high"):
        yield f"if x is {t} then " + ", ".join(f"y{k} is large" for k in range(outputs)) + "\n"


@case
def a_thousand_samples_of_many_outputs(size):
    outputs = int(OUTPUTS * size)
    known = " ".join(names(100))
    yield f"defuzzifier centroid(resolution=1000)\ninput x in [0, 1]\n  terms {known}\n"
    yield "".join(f"output y{k} in [0, 1]\n  terms {known}\n" for k in range(outputs))
    for t in range(100):
        for k in range(outputs):
            yield f"if x is t{t} then y{k} is t{t}\n"


@case
def inputs_that_jump(size):
    terms = "".join(f"  s{k} = rectangle({k / 100}, {(k + 1) / 100})\n" for k in range(100))
    yield "".join(f"input x{k} in [0, 1]\n{terms}" for k in range(3)) + HEAD.split("\n", 2)[2]
    rng = random.Random(1)
    for _ in range(int(RULES * size)):
        yield "if " + " and ".join(f"x{i} is s{rng.randrange(100)}" for i in range(3)) + " then y is small\n"


@case
def outputs_that_jump(size):
    outputs = int(OUTPUTS * size)
    terms = "".join(f"  s{k} = rectangle({k / 100}, {(k + 1) / 100})\n" for k in range(100))
    yield "".join(f"input x{k} in [0, 1]\n{terms}" for k in range(3))
    yield "".join(f"output y{k} in [0, 1] else 0\n  terms small large\n" for k in range(outputs))
    rng = random.Random(1)
    for k in range(int(RULES * size)):
        antecedent = " and ".join(f"x{i} is s{rng.randrange(100)}" for i in range(3))
        yield f"if {antecedent} then y{k % outputs} is small\n"


@case
def norms_that_are_not_strict(size):
    yield "and bounded_difference\n" + inputs_of(6, "a b c d e") + SUGENO.replace(" else 0", "")
    rng = random.Random(1)
    for _ in range(int(RULES * size)):
        yield "if " + " and ".join(f"x{i} is {rng.choice('abcde')}" for i in range(6)) + " then y is small\n"


@case
def outputs_of_norms_that_are_not_strict(size):
    outputs = int(OUTPUTS * size)
    yield "and bounded_difference\ndefuzzifier weighted_average\n" + inputs_of(4, "a b c")
    yield "".join(f"output y{k} in [0, 1]\n  terms small=0 large=1\n" for k in range(outputs))
    rng = random.Random(1)
    for k in range(int(RULES * size)):
        yield (
            "if " + " and ".join(f"x{i} is {rng.choice('abc')}" for i in range(4)) + f" then y{k % outputs} is small\n"
        )
