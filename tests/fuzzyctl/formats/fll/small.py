"""A small file of fuzzylite that tests vary, and what is said of it."""

from fuzzyctl.diagnostics.diagnostic import render_all
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.fll import read

SMALL = """\
Engine: small
InputVariable: a
  range: 0.0 1.0
  term: low Ramp 1.0 0.0
  term: high Ramp 0.0 1.0
InputVariable: b
  range: 0.0 1.0
  term: low Ramp 1.0 0.0
  term: high Ramp 0.0 1.0
OutputVariable: y
  range: 0.0 1.0
  aggregation: Maximum
  defuzzifier: Centroid 100
  default: nan
  lock-previous: false
  term: low Ramp 1.0 0.0
  term: high Ramp 0.0 1.0
RuleBlock: all
  conjunction: Minimum
  disjunction: Maximum
  implication: Minimum
  activation: General
  rule: if a is low then y is low
  rule: if a is high then y is high
"""


def system(text):
    found, diagnostics = read(SourceText("t.fll", text))
    assert found is not None, render_all(diagnostics)
    return found


def said(text):
    """Return what is said of a text as (code, severity, line, column)."""
    _, diagnostics = read(SourceText("t.fll", text))
    return [(d.code, d.severity, d.span.line if d.span else 0, d.span.column if d.span else 0) for d in diagnostics]


def changed(old, new, text=SMALL):
    assert old in text
    return text.replace(old, new)


def rule(text):
    """Return the rule of a text."""
    return system(SMALL.replace("if a is low then y is low", text)).rules[0]
