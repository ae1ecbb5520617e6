"""A file of fuzzylite whose input and whose output have one term each, to be filled in."""

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
