"""Separation-bearing formation: reference posture and tracking error of a follower."""

from __future__ import annotations

import math

from dwmr.core.geometry import to_body, wrap
from dwmr.core.interfaces import PostureError, TrackingError
from dwmr.core.jit import compiled


@compiled
def trajectory_error(
    x: float, y: float, theta: float, x_r: float, y_r: float, theta_r: float, theta_star: float, v_r: float, d: float
) -> PostureError:
    """Return the tracking error of a robot that follows a reference trajectory.

    Args:
        x, y, theta: Posture of the robot's reference point [m, m, rad].
        x_r, y_r, theta_r: Reference posture [m, m, rad].
        theta_star: Auxiliary reference orientation θ*_r [rad].
        v_r: Reference linear velocity [m/s].
        d: Distance of the reference point ahead of the wheel axis [m].

    Source:
        Goto, Bertol, Martins, Eqs. (4), (6); Eq. (3), first two rows, for the reference's motion seen from the robot.
    """
    x_e, y_e = to_body(x_r - x, y_r - y, theta)
    theta_e = theta_r - theta
    omega_star = trajectory_auxiliary_rate(theta_r, theta_star, v_r, d)
    return PostureError(
        x_e, y_e, wrap(theta_star - theta), v_r * math.cos(theta_e), v_r * math.sin(theta_e), omega_star, d
    )


@compiled
def trajectory_auxiliary_rate(theta_r: float, theta_star: float, v_r: float, d: float) -> float:
    """Return ω*_ar, the turning rate with which a point d ahead of the axle follows the reference direction [rad/s].

    Source:
        Goto, Bertol, Martins, Eq. (5), second row; Eq. (72) during avoidance.
    """
    return -v_r / d * math.sin(theta_star - theta_r)


@compiled
def separation_and_bearing(
    x_i: float, y_i: float, theta_i: float, d_i: float, x_j: float, y_j: float
) -> tuple[float, float]:
    """Return how far and in which direction a follower's front is from its leader's axle.

    Args:
        x_i, y_i, theta_i: Posture of the leader's reference point [m, m, rad].
        d_i: Distance of that point ahead of the leader's wheel axis [m].
        x_j, y_j: Position of the follower's reference point [m].

    Returns:
        L_ij [m] and Ψ_ij in (−π, π] [rad].

    Source:
        Goto, Bertol, Martins, Eqs. (44), (45), with atan2 for arctan.
    """
    l_x = x_i - d_i * math.cos(theta_i) - x_j
    l_y = y_i - d_i * math.sin(theta_i) - y_j
    return math.hypot(l_x, l_y), wrap(math.atan2(l_y, l_x) - theta_i + math.pi)


@compiled
def follower_position(
    x_i: float, y_i: float, theta_i: float, d_i: float, separation: float, bearing: float
) -> tuple[float, float]:
    """Return the place of a follower at a separation and bearing from its leader [m].

    Source:
        Goto, Bertol, Martins, Eq. (47), first two rows.
    """
    angle = bearing + theta_i
    x = x_i - d_i * math.cos(theta_i) + separation * math.cos(angle)
    y = y_i - d_i * math.sin(theta_i) + separation * math.sin(angle)
    return x, y


@compiled
def follower_error(
    x_i: float,
    y_i: float,
    theta_i: float,
    v_i: float,
    omega_i: float,
    d_i: float,
    x_j: float,
    y_j: float,
    theta_j: float,
    theta_star: float,
    d_j: float,
    separation: float,
    bearing: float,
) -> PostureError:
    """Return the tracking error of a follower.

    Args:
        x_i, y_i, theta_i: Posture of the leader [m, m, rad].
        v_i, omega_i: Velocities of the leader [m/s, rad/s].
        d_i, d_j: Reference points ahead of the wheel axes [m].
        x_j, y_j, theta_j: Posture of the follower [m, m, rad].
        theta_star: The follower's auxiliary reference orientation θ*_jr [rad].
        separation, bearing: Desired L_ijd [m] and Ψ_ijd [rad].

    Source:
        Goto, Bertol, Martins, Eqs. (49), (51); the second row of A_0 carries +ω_ai L_d cos(·), which differentiating
        Eq. (47) gives and ω*_ajr confirms, where the print has a minus.
    """
    theta_ij = theta_i - theta_j
    measured, measured_bearing = separation_and_bearing(x_i, y_i, theta_i, d_i, x_j, y_j)
    desired_angle, measured_angle = bearing + theta_ij, measured_bearing + theta_ij
    x_e = separation * math.cos(desired_angle) - measured * math.cos(measured_angle)
    y_e = separation * math.sin(desired_angle) - measured * math.sin(measured_angle)
    drift_x = v_i * math.cos(theta_ij) - omega_i * separation * math.sin(desired_angle)
    drift_y = v_i * math.sin(theta_ij) + omega_i * separation * math.cos(desired_angle)
    omega_star = follower_auxiliary_rate(theta_i, v_i, omega_i, theta_star, d_j, separation, bearing)
    return PostureError(x_e, y_e, wrap(theta_star - theta_j), drift_x, drift_y, omega_star, d_j)


@compiled
def follower_auxiliary_rate(
    theta_i: float, v_i: float, omega_i: float, theta_star: float, d_j: float, separation: float, bearing: float
) -> float:
    """Return ω*_ajr, the turning rate with which a follower moves without slipping while the formation turns [rad/s].

    Source:
        Goto, Bertol, Martins, the unnumbered equation before Eq. (51).
    """
    turn = theta_i - theta_star
    return (v_i * math.sin(turn) + separation * omega_i * math.cos(bearing + turn)) / d_j


@compiled
def behind_sideways(error: PostureError, u: float, theta_i: float, theta_j: float, theta_star: float) -> PostureError:
    """Return the tracking error of a follower whose leader moves sideways, which no leader of the paper can.

    Args:
        error: What `follower_error` gives.
        u: Velocity of the leader to its left [m/s].
        theta_i, theta_j: Orientations of leader and follower [rad].
        theta_star: The follower's auxiliary reference orientation θ*_jr [rad].
    """
    theta_ij = theta_i - theta_j
    return PostureError(
        error.x_e,
        error.y_e,
        error.theta_e_star,
        error.drift_x - u * math.sin(theta_ij),
        error.drift_y + u * math.cos(theta_ij),
        error.drift_theta + u * math.cos(theta_i - theta_star) / error.d,
        error.d,
    )


@compiled
def with_leaders_orientation(error: PostureError, theta_i: float, omega_i: float, theta_j: float) -> PostureError:
    """Return the tracking error of a follower that keeps the orientation of its leader, as one free to do so.

    The auxiliary orientation θ*_jr is that of a follower whose wheels do not slip sideways.

    Args:
        error: What `follower_error` gives.
        theta_i, omega_i: Orientation and angular velocity of the leader [rad, rad/s].
        theta_j: Orientation of the follower [rad].
    """
    e = error
    return PostureError(e.x_e, e.y_e, wrap(theta_i - theta_j), e.drift_x, e.drift_y, omega_i, e.d)


@compiled
def mixed(a: PostureError, share_a: float, b: PostureError, share_b: float, theta_e: float) -> PostureError:
    """Return the weighted sum of two errors of one robot and of their drifts.

    The orientation of `b` counts within half a turn of `theta_e`, that of the first error [rad].
    """
    return PostureError(
        share_a * a.x_e + share_b * b.x_e,
        share_a * a.y_e + share_b * b.y_e,
        share_a * a.theta_e_star + share_b * (theta_e + wrap(b.theta_e_star - theta_e)),
        share_a * a.drift_x + share_b * b.drift_x,
        share_a * a.drift_y + share_b * b.drift_y,
        share_a * a.drift_theta + share_b * b.drift_theta,
        a.d,
    )


@compiled
def tracking_error(
    e: PostureError, on_reference: bool, theta_e: float, v_r: float, omega_r: float, v: float, omega: float, t: float
) -> TrackingError:
    """Return the inputs of a control law: the error, and the velocities that cause it.

    Args:
        e: The error and its drift.
        on_reference: Whether the robot follows a reference, not another robot.
        theta_e: θ_r − θ of a robot on the reference [rad].
        v_r, omega_r: Velocities of the reference [m/s, rad/s].
        v, omega: Velocities that the robot measures [m/s, rad/s].
        t: Time [s].

    Returns:
        Of a follower with its place in the formation as the reference, in the direction θ*_jr that it should have.
    """
    theta_e_star = wrap(e.theta_e_star)  # a mean of some may be beyond half a turn
    if on_reference:
        theta_e = wrap(theta_e)
    else:
        theta_e, omega_r = theta_e_star, e.drift_theta
        v_r = e.drift_x * math.cos(theta_e) + e.drift_y * math.sin(theta_e)
    return TrackingError(
        e.x_e, e.y_e, theta_e_star, e.drift_x, e.drift_y, e.drift_theta, e.d, theta_e, v_r, omega_r, v, omega, t
    )
