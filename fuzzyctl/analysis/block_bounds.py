"""Bounds of systems and controllers: the public face."""

from __future__ import annotations

from typing import Final

from fuzzyctl.analysis import bounds
from fuzzyctl.analysis.bounds import OutputBound
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.system import FuzzySystem

#: Seconds for the range of a state, and for each end of an output, of a controller.
TIMEOUT: Final = 5.0


def output_bounds(system: FuzzySystem | Controller) -> dict[str, OutputBound]:
    """Bound every output of a system over all inputs, or every output and state of a controller over all steps.

    Of a system, an average lies between the consequents of the rules that can fire, a weighted sum within the sum of
    what each rule can add, a centroid between the ends of their supports, an adaptive output within its range. Where it
    is not proved that some rule always fires, `else` counts too. NaN, for `else nan` and for inputs that are NaN, is
    not bounded. Of a controller, inputs are taken in their ranges, and states in those that no step leaves, see
    `prove`.

    Returns:
        A bound for each output by name, of a controller for each declared state, too.

    Raises:
        ArgumentError: For what is no system and no controller.
    """
    if not isinstance(system, Controller):
        return bounds.output_bounds(system)
    from fuzzyctl.analysis.induction.bounds import controller_bounds

    return controller_bounds(system, TIMEOUT)
