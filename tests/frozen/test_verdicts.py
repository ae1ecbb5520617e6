"""Diagnostic codes, bounds and verdicts of the kept systems, of the shipped ones and of drawn ones.

Of the 200 drawn ones the test line compares 20; FUZZYCTL_FROZEN=200 python -m pytest tests/frozen compares all.
"""

import os
from random import Random

import pytest

from fuzzyctl import DiagnosticError, check, dumps, load, loads, output_bounds, prove
from tests import shipped
from tests.frozen.kept import check_kept
from tests.frozen.systems import SYSTEMS
from tests.peers.drawing import Abilities, Draw
from tests.sizes import examples

ABLE = Abilities(
    implications=("min", "product"),
    aggregations=("max", "sum"),
    defuzzifiers=("centroid", "bisector"),
    resolutions=(None, None, 9),
    negates=True,
    infinite=True,
    heights=True,
)
#: Seeds of drawn systems, less those whose proofs take more than a second or end at the time limit.
SLOW = {1, 6, 28, 41, 50, 54, 71, 75, 86, 87, 89, 90, 95, 118, 124, 138, 139, 145, 154, 162, 164, 166, 187, 196}
DRAWN = [seed for seed in range(224) if seed not in SLOW]
GROUP = 20
COMPARED = int(os.environ.get("FUZZYCTL_FROZEN", examples(200, 20)))


def drawn(seed):
    """A drawn system and what is claimed of it: a value everywhere, and the lower half of the range."""
    system = Draw(Random(seed), "exact", ABLE).system()
    claims = [
        f"require total({o.name})\nrequire {o.name} <= {(o.lower.value + o.upper.value) / 2!r}\n"
        for o in system.outputs
    ]
    return dumps(system) + "".join(claims)


def found(system):
    """Yield the lines of what is found of a system; numbers with the digits that all mathematical libraries share."""
    yield " ".join(["codes", *(d.code for d in check(system)[1])])
    for bound in output_bounds(system).values():
        yield f"{bound.name} in [{bound.lo:.12g}, {bound.hi:.12g}]{' attained' if bound.exact else ''}"
    for verdict in prove(system):
        yield f"{type(verdict).__name__}: {verdict.claim}"


def report(text):
    try:
        system = loads(text)
    except DiagnosticError as error:
        return [f"refused {' '.join(d.code for d in error.diagnostics)}"]
    return list(found(system))


def compare(name, reports):
    text = "".join(f"== {title}\n" + "".join(f"{line}\n" for line in lines) for title, lines in reports)
    check_kept("verdicts", name, text)


def test_of_shipped_systems_they_are_as_kept():
    compare("shipped", [(path.stem, list(found(load(path)))) for path in shipped.SYSTEMS])


def test_of_kept_systems_they_are_as_kept():
    compare("kept", [(name, report(text)) for name, text in SYSTEMS.items()])


@pytest.mark.parametrize("first", range(0, COMPARED, GROUP))
def test_of_drawn_systems_they_are_as_kept(first):
    compare(f"drawn-{first:03}", [(seed, report(drawn(seed))) for seed in DRAWN[first : first + GROUP]])
