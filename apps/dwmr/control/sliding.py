"""Sliding variables, equivalent control and saturation of the control laws: pure functions."""

from __future__ import annotations

from dwmr.core.geometry import sign
from dwmr.core.interfaces import TrackingError
from dwmr.core.jit import compiled

#: Eq. (13) divides by D = λ2 (d + x_e) + λ3, which is zero at x_e = −2.43 m for the leader. D keeps its sign and at
#: least this magnitude.
SMALLEST_D = 0.05


@compiled
def denominator(x_e: float, d: float, lambda_2: float, lambda_3: float) -> float:
    """Return D = λ2 (d + x_e) + λ3 of Eq. (13), kept away from zero [-]."""
    value = lambda_2 * (d + x_e) + lambda_3
    if abs(value) >= SMALLEST_D:
        return value
    return SMALLEST_D if value >= 0.0 else -SMALLEST_D


@compiled
def sliding_variables(error: TrackingError, lambda_1: float, lambda_2: float, lambda_3: float) -> tuple[float, float]:
    """Return σ* = B_0σᵀ σ, the sliding variables that stay regular where B_0σ does not.

    Args:
        error: Tracking error of one robot.
        lambda_1, lambda_2, lambda_3: Slopes of the surfaces.

    Returns:
        σ*_v [m] and σ*_ω [rad], taking λ2 in rad/m and the other slopes as pure numbers.

    Source:
        Goto, Bertol, Martins, Eqs. (7), (9) for the leader; Eqs. (52), (53) for a follower.
    """
    sigma_v = lambda_1 * error.x_e
    sigma_omega = lambda_2 * error.y_e + lambda_3 * error.theta_e_star
    d_plus = lambda_2 * (error.d + error.x_e) + lambda_3
    return -lambda_1 * sigma_v, lambda_1 * error.y_e * sigma_v - d_plus * sigma_omega


@compiled
def equivalent_control(error: TrackingError, lambda_1: float, lambda_2: float, lambda_3: float) -> tuple[float, float]:
    """Return −B_0σ⁻¹ A_0σ, the velocities that keep an undisturbed robot on the surface.

    Args:
        error: Tracking error of one robot.
        lambda_1, lambda_2, lambda_3: Slopes of the surfaces.

    Returns:
        Linear [m/s] and angular velocity [rad/s].

    Source:
        Goto, Bertol, Martins, Eqs. (8), (11)-(13).
    """
    a_v = lambda_1 * error.drift_x
    a_omega = lambda_2 * error.drift_y + lambda_3 * error.drift_theta
    omega = a_omega / denominator(error.x_e, error.d, lambda_2, lambda_3)
    return a_v / lambda_1 + error.y_e * omega, omega


@compiled
def saturation(sigma: float, beta: float) -> float:
    """Replace the sign function inside a boundary layer.

    Args:
        sigma: Sliding variable [m or rad].
        beta: Half-width of the layer, > 0, in the same unit.

    Returns:
        sigma / beta inside the layer, the sign outside.

    Source:
        Goto, Bertol, Martins, Eq. (19).
    """
    return sign(sigma) if abs(sigma) > beta else sigma / beta


@compiled
def gain_rate(k_h: float, k_h_min: float, gamma: float, sigma: float, beta: float, epsilon: float) -> float:
    """Return the rate of the adaptive gain k̂_h.

    Args:
        k_h: The gain now [m/s, rad/s].
        k_h_min: Its floor k̄_h [m/s, rad/s]; at the floor the number is also the rate, as printed.
        gamma: Adaptation gain Γ_h [1/s²].
        sigma: Sliding variable σ* [m, rad].
        beta: Half-width of the boundary layer [m, rad].
        epsilon: Margin between growth and decline [m, rad].

    Returns:
        dk̂_h/dt [m/s², rad/s²].

    Units are those of the linear, then of the angular channel.

    Source:
        Goto, Bertol, Martins, Eqs. (21), (22).
    """
    if k_h <= k_h_min:
        return k_h_min
    size = abs(sigma)
    direction = sign(size - epsilon)
    return gamma * size * direction if size > beta else gamma * size * size / beta * direction
