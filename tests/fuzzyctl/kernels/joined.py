"""Systems whose inputs are the activations of their rules, so that tests say what is joined and defuzzified."""

import pytest

from fuzzyctl import compile as compile_system
from fuzzyctl import loads

LOWER, UPPER = -3.0, 5.0
WIDTH = UPPER - LOWER

TEXT = """
system s
implication {implication}
aggregation {aggregation}
defuzzifier {defuzzifier}
input x in [0, 1]
  on = ramp(0, 1)
input y in [0, 1]
  on = ramp(0, 1)
input z in [0, 1]
  on = ramp(0, 1)
output u in [{lower}, {upper}] else 77
{terms}
{rules}
"""


def build(terms, implication, aggregation, defuzzifier, lower=LOWER, upper=UPPER):
    """Return a system whose inputs are the activations of its rules, one for each term."""
    lines = "\n".join(f"  t{k} = {t}" for k, t in enumerate(terms))
    rules = "\n".join(f"if {'xyz'[k]} is on then u is t{k}" for k in range(len(terms)))
    return loads(
        TEXT.format(
            implication=implication,
            aggregation=aggregation,
            defuzzifier=defuzzifier,
            terms=lines,
            rules=rules,
            lower=lower,
            upper=upper,
        )
    )


def evaluated(system, activations, backends=("python", "numpy"), off=1e-12):
    """Return what all backends give, one point at a time and in batch; `off` is how far they may be apart."""
    point = [*activations, *[0.0] * (3 - len(activations))]
    found = []
    for backend in backends:
        kernel = compile_system(system, backend)
        found += [kernel(*point), *kernel.batch([point, point])]
    assert found == pytest.approx([found[0]] * len(found), rel=off, abs=off)
    return found[0]


def parsed(term):
    """Return kind and parameters of a term."""
    system = build([term], "min", "max", "centroid")
    membership = system.outputs[0].terms[0].membership
    return membership.kind, tuple(map(system.number, membership.arguments))
