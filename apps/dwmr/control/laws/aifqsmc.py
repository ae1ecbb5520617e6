"""AIFQSMC: adaptive immune fuzzy quasi-sliding mode control, Eqs. (19)-(22)."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from dwmr.control.fuzzy_gains import Rules
from dwmr.control.laws.settings import AifqsmcSettings as Settings
from dwmr.control.sliding import equivalent_control, gain_rate, saturation, sliding_variables
from dwmr.core.arrays import FloatArray
from dwmr.core.interfaces import Law, Signal, TrackingError, control_law
from dwmr.core.jit import compiled

#: Name, units in the two channels and meaning of what is recorded. σ*_ω mixes λ2 y_e and λ3 θ*_e; with λ2 in rad/m it
#: is an angle.
_PER_CHANNEL = (
    ("sigma", "m", "rad", "sliding variable σ*"),
    ("sigma_dot", "m/s", "rad/s", "backward difference of σ*"),
    ("k_h", "m/s", "rad/s", "adaptive gain k̂_h"),
    ("f", "-", "-", "immune reaction f(σ*, dσ*/dt)"),
    ("beta", "m", "rad", "half-width of the boundary layer"),
    ("g_ais", "m/s", "rad/s", "switching gain G_AIS = k̂_h − k_s f"),
    ("eta", "-", "-", "proportion η̂ = k_s/k̂_h of the suppression"),
)
#: How many of them there are, and where Γ_h of both channels stands among the gains.
_COUNT = len(_PER_CHANNEL)
GAMMA = (6, 11)
SIGNALS = tuple(
    Signal(f"{name}_{channel}", units[k], f"{doc}, {channel} channel")
    for k, channel in enumerate(("v", "omega"))
    for name, *units, doc in _PER_CHANNEL
)
FAULTS = {
    1: "G_AIS of the linear channel is not positive",
    2: "β of the linear channel is not positive",
    3: "G_AIS of the angular channel is not positive",
    4: "β of the angular channel is not positive",
}

Reaction = Callable[[float, float], float]
Layer = Callable[[float], float]


def init(settings: Settings, rules: Rules, robot: str) -> Law:
    """Prepare the law for one robot: prove G_AIS > 0 and β > 0 for both channels and compile the gain kernels.

    Raises:
        DiagnosticError: When a rule file has mistakes, does not fit its role, or breaks a guarantee.
    """
    s = settings
    f_v, k_h_min_v, k_s_v = rules.reaction(robot, "v", s.k_h_min_v, s.k_s_v)
    f_omega, k_h_min_omega, k_s_omega = rules.reaction(robot, "omega", s.k_h_min_omega, s.k_s_omega)
    beta = rules.boundary_layer()
    surface = [s.lambda_1, s.lambda_2, s.lambda_3]
    linear = [s.p_v, k_s_v, k_h_min_v, s.gamma_v, s.epsilon_v]
    angular = [s.p_omega, k_s_omega, k_h_min_omega, s.gamma_omega, s.epsilon_omega]
    # state: σ*_v, σ*_ω of the last sample, k̂_h of both channels, and whether there was a last sample
    state = np.array([0.0, 0.0, k_h_min_v, k_h_min_omega, 0.0])
    return Law(np.array(surface + linear + angular), state, (f_v, f_omega, beta))


@compiled
def channel(
    sigma: float,
    sigma_dot: float,
    k_h: float,
    f: float,
    beta: float,
    gains: FloatArray,
    dt: float,
    signals: FloatArray,
) -> tuple[float, float, int]:
    """Return G_AIS sat(σ*) + p σ*, the next k̂_h and a fault for one channel.

    Args:
        sigma, sigma_dot: Sliding variable and its rate [m, m/s; rad, rad/s in the angular channel].
        k_h: Adaptive gain now [m/s; rad/s].
        f, beta: Values of the two fuzzy systems [-; m or rad].
        gains: p, k_s, k̄_h, Γ_h, ε; Γ_h = 0 is a gain k̂_h that does not adapt.
        dt: Control period [s].
        signals: Receives σ*, dσ*/dt, k̂_h, f, β, G_AIS, η̂.

    Source:
        Goto, Bertol, Martins, Eqs. (15)-(17), (19)-(22); k̂_h is also kept at or above k̄_h.
    """
    p, k_s, k_h_min, gamma, epsilon = gains[0], gains[1], gains[2], gains[3], gains[4]
    g_ais = k_h - k_s * f
    signals[0], signals[1], signals[2], signals[3] = sigma, sigma_dot, k_h, f
    signals[4], signals[5], signals[6] = beta, g_ais, k_s / k_h
    if math.isnan(g_ais) or math.isnan(beta) or math.isnan(sigma):
        return math.nan, k_h, 0  # the run has diverged: no guarantee has been broken, and the loop says so
    if g_ais <= 0.0:
        return 0.0, k_h, 1
    if beta <= 0.0:
        return 0.0, k_h, 2
    if gamma == 0.0:
        return g_ais * saturation(sigma, beta) + p * sigma, k_h, 0
    k_h_next = max(k_h_min, k_h + dt * gain_rate(k_h, k_h_min, gamma, sigma, beta, epsilon))
    return g_ais * saturation(sigma, beta) + p * sigma, k_h_next, 0


@control_law("float64(float64, float64)", "float64(float64, float64)", "float64(float64)")
def step(
    error: TrackingError,
    dt: float,
    gains: FloatArray,
    state: FloatArray,
    kernels: tuple[Reaction, Reaction, Layer],
    next_state: FloatArray,
    signals: FloatArray,
) -> tuple[float, float, int]:
    """Return the velocity command v_c = −B⁻¹A − G_AIS sat(σ*) − P σ*.

    Source:
        Goto, Bertol, Martins, Eq. (20); dσ*/dt is a backward difference, 0 at the first sample.
    """
    sigma_v, sigma_omega = sliding_variables(error, gains[0], gains[1], gains[2])
    v, omega = equivalent_control(error, gains[0], gains[1], gains[2])
    rate_v = (sigma_v - state[0]) / dt if state[4] > 0.0 else 0.0
    rate_omega = (sigma_omega - state[1]) / dt if state[4] > 0.0 else 0.0
    f_v, f_omega = kernels[0](sigma_v, rate_v), kernels[1](sigma_omega, rate_omega)
    beta_v, beta_omega = kernels[2](abs(sigma_v)), kernels[2](abs(sigma_omega))
    push_v, next_state[2], fault_v = channel(sigma_v, rate_v, state[2], f_v, beta_v, gains[3:8], dt, signals[:_COUNT])
    push_omega, next_state[3], fault_omega = channel(
        sigma_omega, rate_omega, state[3], f_omega, beta_omega, gains[8:13], dt, signals[_COUNT:]
    )
    next_state[0], next_state[1], next_state[4] = sigma_v, sigma_omega, 1.0
    fault = fault_v if fault_v > 0 else (fault_omega + 2 if fault_omega > 0 else 0)
    return v - push_v, omega - push_omega, fault
