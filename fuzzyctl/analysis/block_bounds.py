"""Bounds of systems and controllers: the public face."""

from __future__ import annotations

from typing import Any, Final

from fuzzyctl.analysis import bounds
from fuzzyctl.analysis.bounds import OutputBound
from fuzzyctl.model.block import Block
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.support import arguments

#: Seconds for all bounds of a controller.
TIMEOUT: Final = 5.0


def output_bounds(system: FuzzySystem | Controller, *, timeout: float = TIMEOUT) -> dict[str, OutputBound]:
    """Bound every output of a system over all inputs, or every output and state of a controller over all steps.

    Of a system, an average lies between the consequents of the rules that can fire, a weighted sum within the sum of
    what each rule can add, a centroid between the ends of their supports, an adaptive output within its range. Where it
    is not proved that some rule always fires, `else` counts too. NaN, for `else nan` and for inputs that are NaN, is
    not bounded. Of a controller, inputs are taken in their ranges, and states in those that no step leaves, see
    `prove`; the note of a bound says why an end is infinite, and for which inputs it is proved if not for all.

    Args:
        system: The system or the controller.
        timeout: Seconds that all bounds of a controller may take together; those of a system take no search.

    Returns:
        A bound for each output by name, of a controller for each declared state, too.

    Raises:
        ArgumentError: For an object that is neither a system nor a controller, and for a timeout that is not a number.
        ValueOutOfBoundsError: For a negative timeout.
    """
    timeout = arguments.seconds("'timeout'", timeout)
    block: Any = arguments.instance("the system", Block, "a FuzzySystem or a Controller", system)
    if not block.is_sampled:
        return bounds.output_bounds(block)
    from fuzzyctl.analysis.induction.bounds import controller_bounds

    return controller_bounds(block, timeout)
