"""How drawn systems are run: how many of them, evaluated at a point, and without outputs that raise."""

import math

import numpy as np
from hypothesis import HealthCheck, Phase, settings

from fuzzyctl.analysis.bounds import output_bounds
from fuzzyctl.diagnostics.diagnostic import NoRuleFiresError
from fuzzyctl.kernels.compile import compile as compile_system
from tests.sizes import examples


def quick(everything, some=None):
    """Draw a number of examples (tests/sizes.py), unshrunk: to shrink a large system takes longer than to read it.

    The same are drawn in every run, and others with pytest's option `--hypothesis-seed`; see tests/conftest.py.
    """
    return settings(
        max_examples=examples(everything, some),
        deadline=None,
        database=None,
        report_multiple_bugs=False,
        suppress_health_check=list(HealthCheck),
        phases=[Phase.generate],
    )


def evaluated(kernel, point, *, batch=False):
    """The numbers of all outputs, or "error" where no rule fires."""
    try:
        state = (kernel.initial_state(),) if kernel.n_states else ()
        result = kernel.batch(np.array(point)) if batch else kernel(*point, *state)
    except NoRuleFiresError:
        return "error"
    return [float(v) for v in np.atleast_1d(result)]


def total(system):
    """The system with NaN where it would raise, so that whole batches can be evaluated."""
    outputs = tuple(
        o.model_copy(update={"otherwise": "nan"}) if o.otherwise in (None, "error") else o for o in system.outputs
    )
    return system.model_copy(update={"outputs": outputs})


def check_samples(system, points):
    """Every number that a kernel returns lies within the proved bounds of its output."""
    bounds, kernel = output_bounds(system), compile_system(system, "python")
    for point in points:
        found = evaluated(kernel, point)
        if not isinstance(found, str):
            for output, value in zip(system.outputs, found, strict=True):
                bound = bounds[output.name]
                assert math.isnan(value) or bound.lo <= value <= bound.hi
