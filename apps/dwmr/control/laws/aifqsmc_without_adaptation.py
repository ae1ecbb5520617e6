"""AIFQSMC with a gain k_h that stays at its floor k̄_h: an ablation of Eqs. (21), (22)."""

from __future__ import annotations

from dwmr.control.fuzzy_gains import Rules
from dwmr.control.laws import aifqsmc
from dwmr.control.laws.aifqsmc import FAULTS, SIGNALS, step
from dwmr.control.laws.settings import AifqsmcSettings as Settings
from dwmr.core.interfaces import Law

__all__ = ["FAULTS", "SIGNALS", "Settings", "init", "step"]


def init(settings: Settings, rules: Rules, robot: str) -> Law:
    """Prepare AIFQSMC for one robot and switch its adaptation off, Γ_h = 0.

    Raises:
        DiagnosticError: As AIFQSMC does.
    """
    law = aifqsmc.init(settings, rules, robot)
    gains = law.gains.copy()
    gains[list(aifqsmc.GAMMA)] = 0.0
    return law._replace(gains=gains)
