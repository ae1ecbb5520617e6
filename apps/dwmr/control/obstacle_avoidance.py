"""Reactive avoidance of round obstacles with a radius that grows with the closing speed."""

from __future__ import annotations

import math
from typing import NamedTuple

from dwmr.core.arrays import FloatArray
from dwmr.core.geometry import wrap
from dwmr.core.interfaces import PostureError
from dwmr.core.jit import compiled


class Avoidance(NamedTuple):
    """Parameters of the avoidance.

    Attributes:
        margin: δ_Rd of Eq. (57) [m].
        largest_radius: Bound R̄_b of the avoidance radius [m].
        kappa: Gain of the expansion κ [m s/m].
        gamma: Divisor of the expansion γ [-].
        rho: Decline of the expansion with distance ϱ [1/m].
        slowdown: Share ρ_v of the reference velocity kept during avoidance [-].
        hysteresis: Distance beyond R_d at which an avoidance ends; 0 in the paper [m].
    """

    margin: float
    largest_radius: float
    kappa: float
    gamma: float
    rho: float
    slowdown: float
    hysteresis: float


@compiled
def constant_radius(radius: float, robot_radius: float, margin: float) -> float:
    """Return R̄_d, the avoidance radius around an obstacle for a robot at rest [m].

    Source:
        Goto, Bertol, Martins, Eq. (57).
    """
    return radius + robot_radius + margin


@compiled
def avoidance_radius(
    distance: float, closing_speed: float, radius: float, robot_radius: float, avoidance: Avoidance
) -> float:
    """Return the variable radius R_d around an obstacle.

    Args:
        distance: d_ia from the robot's reference point to the obstacle's centre [m].
        closing_speed: v_ia, the robot's velocity along the line to the obstacle [m/s].
        radius: r_a of the obstacle [m].
        robot_radius: R_R of the robot [m].
        avoidance: Parameters.

    Returns:
        R_d [m].

    Source:
        Goto, Bertol, Martins, Eqs. (58), (59), (63); ϱ restored in the exponent of Eq. (59).
    """
    expansion = avoidance.kappa * abs(closing_speed) / (avoidance.gamma * math.exp(avoidance.rho * distance))
    return min(avoidance.largest_radius, constant_radius(radius, robot_radius, avoidance.margin) + expansion)


@compiled
def evasive_side(theta: float, angle_to_obstacle: float) -> float:
    """Return α/(π/2): 1 to pass with the obstacle on the right, −1 on the left.

    Source:
        Goto, Bertol, Martins, Eq. (68), comparing wrapped angles.
    """
    return 1.0 if wrap(theta - angle_to_obstacle) >= 0.0 else -1.0


@compiled
def evasive_direction(l_x: float, l_y: float, distance: float, radius: float, side: float) -> float:
    """Return the direction that leads around an obstacle.

    Args:
        l_x, l_y: Vector from the robot to the obstacle's centre [m].
        distance: Its length d_ia [m].
        radius: Avoidance radius R_d [m].
        side: α/(π/2), latched when the avoidance began.

    Returns:
        θ_r,OA [rad].

    Source:
        Goto, Bertol, Martins, Eqs. (65)-(67), (69), (70).
    """
    back = 1.0 - radius / distance
    return math.atan2(back * l_y + side * l_x, back * l_x - side * l_y)


@compiled
def avoid(
    x: float,
    y: float,
    theta: float,
    v: float,
    robot_radius: float,
    obstacles: FloatArray,
    sides: FloatArray,
    avoidance: Avoidance,
) -> tuple[int, float, float]:
    """Find the nearest active obstacle and the direction around it, and latch the sides.

    Args:
        x, y, theta: Posture of the robot [m, m, rad].
        v: Its linear velocity [m/s].
        robot_radius: R_R of the robot [m].
        obstacles: Centre and radius of each, shape (n, 3) [m].
        sides: Latched sides, shape (n,): 1 or −1 while an obstacle is active, else 0; written.
        avoidance: Parameters.

    Returns:
        Index of the nearest active obstacle or −1, θ_r,OA [rad], R_d [m].

    Source:
        Goto, Bertol, Martins, Eqs. (56), (60)-(62), (64); without hysteresis the mode is on exactly while r_a < d_ia <=
        R_d.
    """
    nearest, nearest_distance, direction, radius_there = -1, math.inf, 0.0, 0.0
    for a in range(obstacles.shape[0]):
        l_x, l_y, radius = obstacles[a, 0] - x, obstacles[a, 1] - y, obstacles[a, 2]
        distance = math.hypot(l_x, l_y)
        angle = math.atan2(l_y, l_x)
        reach = avoidance_radius(distance, v * math.cos(theta - angle), radius, robot_radius, avoidance)
        if not radius < distance <= reach + (avoidance.hysteresis if sides[a] != 0.0 else 0.0):
            sides[a] = 0.0
            continue
        if sides[a] == 0.0:
            sides[a] = evasive_side(theta, angle)
        if distance < nearest_distance:
            nearest, nearest_distance, radius_there = a, distance, reach
            direction = evasive_direction(l_x, l_y, distance, reach, sides[a])
    return nearest, direction, radius_there


@compiled
def towards(error: PostureError) -> PostureError:
    """Return the error of a robot that moves in any direction, turned into the direction around an obstacle.

    A robot on two wheels moves where it heads, so that a changed orientation is enough for it. One that moves in any
    direction would follow its error through the obstacle.

    Args:
        error: In avoidance; its drift has the direction of the modified reference.
    """
    ahead = error.x_e * error.drift_x + error.y_e * error.drift_y > 0.0
    share = math.hypot(error.x_e, error.y_e) / math.hypot(error.drift_x, error.drift_y) if ahead else 0.0
    return PostureError(
        share * error.drift_x,
        share * error.drift_y,
        error.theta_e_star,
        error.drift_x,
        error.drift_y,
        error.drift_theta,
        error.d,
    )
