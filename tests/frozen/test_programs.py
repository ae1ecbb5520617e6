"""Printed programs as they are kept in files: moves and simplifications leave them equal to the last character."""

import pytest

from fuzzyctl import ArgumentError, loads
from fuzzyctl.kernels.algorithms.select import ALGORITHMS, algorithm_of
from fuzzyctl.kernels.backends import numpy_backend
from fuzzyctl.kernels.backends.numba import source as numba_backend
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.program import scalar
from tests.frozen.kept import check_kept
from tests.frozen.systems import SYSTEMS


def programs(text):
    """Yield a title and the text of everything that is printed of a system."""
    planned = plan(loads(text))
    for name in ALGORITHMS[1:]:
        try:
            chosen = algorithm_of(planned, name)
        except ArgumentError as error:
            yield f"{name}: refused", str(error)
            continue
        yield f"{name}: point in Python", scalar.evaluation_source(chosen.interpreted)
        yield f"{name}: point in numba", numba_backend.evaluation_source(chosen.point)
        yield f"{name}: batch in numba", numba_backend.batch_source(chosen.many)
        yield f"{name}: batch in numpy", numpy_backend.block_source(chosen.arrays)
    yield "algorithm", algorithm_of(planned).name
    yield "trace", scalar.storing_source(inference.trace(planned))
    if planned.states:
        yield "rates", numba_backend.storing_source(inference.rates(planned))
        yield "strengths", numba_backend.storing_source(inference.strengths(planned))


def kept(text):
    return "".join(f"===== {title}\n{body.rstrip()}\n\n" for title, body in programs(text))


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_printed_program_is_as_it_is_kept(name):
    check_kept("programs", name, kept(SYSTEMS[name]))
