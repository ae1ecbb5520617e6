"""AIFQSMC without its immune reaction, f = 0, with the switching gain k̂_h alone: an ablation of Eq. (17)."""

from __future__ import annotations

from dwmr.control.fuzzy_gains import Rules
from dwmr.control.laws import aifqsmc
from dwmr.control.laws.aifqsmc import FAULTS, SIGNALS, step
from dwmr.control.laws.settings import AifqsmcSettings as Settings
from dwmr.core.interfaces import Law
from dwmr.core.jit import compiled_as

__all__ = ["FAULTS", "SIGNALS", "Settings", "init", "step"]


@compiled_as(lambda types: types.float64(types.float64, types.float64))
def no_reaction(sigma: float, sigma_dot: float) -> float:
    """Return an immune reaction that neither suppresses nor stimulates [-]."""
    return 0.0


def init(settings: Settings, rules: Rules, robot: str) -> Law:
    """Prepare AIFQSMC for one robot and take its immune reaction away.

    Raises:
        DiagnosticError: As AIFQSMC does.
    """
    law = aifqsmc.init(settings, rules, robot)
    return law._replace(kernels=(no_reaction, no_reaction, law.kernels[2]))
