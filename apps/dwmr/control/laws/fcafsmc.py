"""FCAFSMC: the switching term replaced by a fuzzy gain whose consequents adapt, Eqs. (77), (78)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from dwmr.control.fuzzy_gains import Rules
from dwmr.control.laws.settings import FcafsmcSettings as Settings
from dwmr.control.sliding import equivalent_control, sliding_variables
from dwmr.core.arrays import FloatArray
from dwmr.core.interfaces import Law, Signal, TrackingError, control_law

SIGNALS = (
    Signal("sigma_v", "m", "sliding variable σ*, v channel"),
    Signal("sigma_omega", "rad", "sliding variable σ*, omega channel"),
    Signal("f_v", "m/s", "fuzzy gain F(σ*), v channel"),
    Signal("f_omega", "rad/s", "fuzzy gain F(σ*), omega channel"),
)
FAULTS: dict[int, str] = {}


def init(settings: Settings, rules: Rules, robot: str) -> Law:
    """Prepare the law for one robot: one adaptive fuzzy system per channel, started at the consequents of its file.

    Raises:
        DiagnosticError: When the rule file has mistakes or does not fit its role.
    """
    s = settings
    gain, rates, start, lowest, highest = rules.adaptive_gain()
    gains = np.array([s.lambda_1, s.lambda_2, s.lambda_3, s.p_v, s.p_omega, lowest, highest])
    # state: the consequents C of both channels, one after the other
    return Law(gains, np.concatenate([start, start]), (gain, rates))


@control_law("float64(float64, float64[::1])", "void(float64, float64[::1], float64[::1])")
def step(
    error: TrackingError,
    dt: float,
    gains: FloatArray,
    state: FloatArray,
    kernels: tuple[Callable[[float, FloatArray], float], Callable[[float, FloatArray, FloatArray], Any]],
    next_state: FloatArray,
    signals: FloatArray,
) -> tuple[float, float, int]:
    """Return the velocity command v_c = −B⁻¹A − F(σ*) − P σ* and let the consequents adapt.

    Source:
        Goto, Bertol, Martins, Eqs. (77), (78).
    """
    sigma_v, sigma_omega = sliding_variables(error, gains[0], gains[1], gains[2])
    v, omega = equivalent_control(error, gains[0], gains[1], gains[2])
    n = state.shape[0] // 2
    f_v, f_omega = kernels[0](sigma_v, state[:n]), kernels[0](sigma_omega, state[n:])
    kernels[1](sigma_v, state[:n], next_state[:n])
    kernels[1](sigma_omega, state[n:], next_state[n:])
    for k in range(2 * n):  # next_state holds the rates until here
        next_state[k] = min(max(state[k] + dt * next_state[k], gains[5]), gains[6])
    signals[0], signals[1], signals[2], signals[3] = sigma_v, sigma_omega, f_v, f_omega
    return v - f_v - gains[3] * sigma_v, omega - f_omega - gains[4] * sigma_omega, 0
