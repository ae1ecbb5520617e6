"""Comparison of a translation with the reader that it took the place of."""

import random
from importlib import import_module

import fuzzyctl
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.common.identifiers import as_read
from fuzzyctl.kernels.compile import compile as compiled
from fuzzyctl.model.rule import literals

POINTS = 50


def places(diagnostics):
    """Return the places of errors."""
    errors = [d for d in diagnostics if d.severity == "error"]
    if "FZ201" in {d.code for d in errors}:  # of two variables of one name the oracles knew the last one only
        errors = [d for d in errors if d.code != "FZ203"]
    return [str(d.span) if d.span is not None else "" for d in errors]


def differences(format, text):
    """Return in what a text is read otherwise than by the oracle: acceptance, places of mistakes, text, numbers."""
    source = SourceText(f"drawn.{format}", text)
    old, before = import_module(f"tests.oracles.{format}").read(source)
    new, after = import_module(f"fuzzyctl.formats.{format}").read(source)
    if (old is None) != (new is None):
        return ["acceptance: " + "; ".join(map(repr, (d for d in (*before, *after) if d.severity == "error")))]
    if old is None or new is None:
        first = places(before)[0]  # what follows may be a mistake for the first one only
        return [] if first in places(after) else [f"place {first}: {[*map(repr, before)]} / {[*map(repr, after)]}"]
    known = {v.name for v in old.variables}
    if any(i.variable not in known for r in old.rules for i in literals(r.antecedent)):
        return []  # a condition on a disabled output was read, and had no value
    old, _ = as_read(old)  # the oracles left names as they are in the file
    if fuzzyctl.dumps(old) != fuzzyctl.dumps(new):
        return ["text"]
    if old == new:  # the same parts, and so the same numbers
        return []
    return [f"number at {point}: {a!r} / {b!r}" for point, a, b in numbers(old, new) if a != b]


def numbers(old, new):
    """Yield outputs of two systems at points drawn within the ranges, as texts; errors by their class."""
    rng = random.Random(1)
    kernels = [compiled(s, backend="python") for s in (old, new)]
    ends = [(old.number(i.lower), old.number(i.upper)) for i in old.inputs]
    for _ in range(POINTS):
        point = [rng.uniform(low - (high - low) / 9, high + (high - low) / 9) for low, high in ends]
        yield point, *(value(k, point) for k in kernels)


def value(kernel, point):
    """Return what a kernel says of a point."""
    try:
        return repr(kernel(*point))
    except fuzzyctl.FuzzyctlError as error:
        return type(error).__name__
