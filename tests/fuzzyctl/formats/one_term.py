"""A file of fuzzylite whose input and whose output have one term each, to be filled in."""

import fuzzyctl

FLL = """Engine: e
InputVariable: a
  range: 0 5
  term: t {}
OutputVariable: y
  range: 0 5
  aggregation: Maximum
  defuzzifier: Centroid 100
  term: t {}
RuleBlock: r
  implication: Minimum
  rule: if a is t then y is t
"""


def degrees(system, places):
    """Return the degrees of the first term of the first input."""
    name = system.inputs[0].name
    kernel = fuzzyctl.compile(system, backend="python")
    return list(kernel.degrees([[float(x)] for x in places])[name][system.inputs[0].terms[0].name])


def with_membership(system, **changes):
    """Return a system with another membership of the first term of its first input, which no file need hold."""
    (x, *others) = system.inputs
    term = x.terms[0].model_copy(update={"membership": x.terms[0].membership.model_copy(update=changes)})
    x = x.model_copy(update={"terms": (term, *x.terms[1:])})
    return system.model_copy(update={"inputs": (x, *others)})
