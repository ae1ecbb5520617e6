"""AIFQSMC with the sign function in place of its fuzzy boundary layer: an ablation of Eq. (19)."""

from __future__ import annotations

from dwmr.control.fuzzy_gains import Rules
from dwmr.control.laws import aifqsmc
from dwmr.control.laws.aifqsmc import FAULTS, SIGNALS, step
from dwmr.control.laws.settings import AifqsmcSettings as Settings
from dwmr.core.interfaces import Law
from dwmr.core.jit import compiled_as

__all__ = ["FAULTS", "SIGNALS", "Settings", "init", "step"]

#: Half-width of a layer so thin that no sliding variable but 0 lies inside it: sat is then the sign, with sign(0) = 0.
THINNEST = 1e-300


@compiled_as(lambda types: types.float64(types.float64))
def no_layer(size: float) -> float:
    """Return a half-width that leaves the sign function [m or rad]."""
    return THINNEST


def init(settings: Settings, rules: Rules, robot: str) -> Law:
    """Prepare AIFQSMC for one robot and take its boundary layer away.

    Raises:
        DiagnosticError: As AIFQSMC does.
    """
    law = aifqsmc.init(settings, rules, robot)
    f_v, f_omega, _ = law.kernels
    return law._replace(kernels=(f_v, f_omega, no_layer))
