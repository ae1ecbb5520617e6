"""How drawn systems are run: how many of them, evaluated at a point, and without outputs that raise."""

import numpy as np
from hypothesis import HealthCheck, Phase, settings

from fuzzyctl import NoRuleFiresError
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
        state = (kernel.start(),) if kernel.n_states else ()
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
