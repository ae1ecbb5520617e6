"""SMC: sliding mode control with constant gains, Eq. (11)."""

from __future__ import annotations

import numpy as np

from dwmr.control.fuzzy_gains import Rules
from dwmr.control.laws.settings import SmcSettings as Settings
from dwmr.control.sliding import equivalent_control, sliding_variables
from dwmr.core.arrays import FloatArray
from dwmr.core.geometry import sign
from dwmr.core.interfaces import Law, Signal, TrackingError, control_law

SIGNALS = (
    Signal("sigma_v", "m", "sliding variable σ*, v channel"),
    Signal("sigma_omega", "rad", "sliding variable σ*, omega channel"),
)
FAULTS: dict[int, str] = {}


def init(settings: Settings, rules: Rules, robot: str) -> Law:
    """Prepare the law for one robot; it needs no gain kernel and keeps no state."""
    s = settings
    gains = np.array([s.lambda_1, s.lambda_2, s.lambda_3, s.p_v, s.p_omega, s.g_v, s.g_omega])
    return Law(gains, np.zeros(0), ())


@control_law()
def step(
    error: TrackingError,
    dt: float,
    gains: FloatArray,
    state: FloatArray,
    kernels: tuple[()],
    next_state: FloatArray,
    signals: FloatArray,
) -> tuple[float, float, int]:
    """Return the velocity command v_c = −B⁻¹A − G sign(σ*) − P σ*.

    Source:
        Goto, Bertol, Martins, Eq. (11), with sign(0) = 0.
    """
    lambda_1, lambda_2, lambda_3, p_v, p_omega, g_v, g_omega = (
        gains[0], gains[1], gains[2], gains[3], gains[4], gains[5], gains[6]
    )  # fmt: skip
    sigma_v, sigma_omega = sliding_variables(error, lambda_1, lambda_2, lambda_3)
    v, omega = equivalent_control(error, lambda_1, lambda_2, lambda_3)
    v -= g_v * sign(sigma_v) + p_v * sigma_v
    omega -= g_omega * sign(sigma_omega) + p_omega * sigma_omega
    signals[0], signals[1] = sigma_v, sigma_omega
    return v, omega, 0
