"""What is said of a sound system that has been changed a bit."""

from fuzzyctl.analysis.check import check_source
from fuzzyctl.diagnostics.diagnostic import WARNINGS
from fuzzyctl.diagnostics.source import SourceText

BASE = """\
system s
defuzzifier weighted_average
input e in [-1, 1]
  terms N Z P
output u in [-5, 5]
  a = constant(1)
  b = constant(2)
table u = e
    N Z P
  | a a b
"""


def said(*pairs, after="", folder=None):
    """Return what is said of the base text with replacements that must all apply: place, code, words."""
    text = BASE
    for old, new in pairs:
        assert old in text, old
        text = text.replace(old, new, 1)
    return said_of(text + after, folder=folder)


def said_of(text, folder=None):
    """Return what is said of a text: place, code, words."""
    _, diagnostics = check_source(SourceText("t.fz", text), folder=folder)
    return [
        (d.span.line if d.span else 0, d.code, " | ".join([d.message, *d.facts, d.help, *(n.message for n in d.notes)]))
        for d in diagnostics
    ]


def only(found):
    """Return the only message as `line code`, and its words."""
    assert len(found) == 1, found
    line, code, words = found[0]
    return f"{line} {code}", words


def says(place, part, *pairs, after="", folder=None):
    """Assert that a changed base text gives one message, at a place and with some words."""
    where, words = only(said(*pairs, after=after, folder=folder))
    assert where == place
    assert part in words


def places(found):
    """Return the errors found as `line code`."""
    return [f"{line} {code}" for line, code, _ in found if code not in WARNINGS]
