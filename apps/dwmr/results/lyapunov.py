"""Lyapunov functions and drift of the adaptive gains along a recorded run: arrays in, arrays out.

Everything follows from the recorded signals. d̃_0 of the paper, the effect of all uncertainties and disturbances
on the kinematics, is here what it is there (section 3.2): the difference between the velocities with which a robot
really moves and those its control law commands. With it Eqs. (14) and (26) are identities, and not only bounds: the
derivative of V along the recorded run, except during avoidance. There the reference's position goes on along the path
while the error dynamics of Eq. (6) take the slower reference of Eq. (71) for it, so V may grow where its derivative as
printed is negative; `measure` counts both.

The function over both modes and its derivative, Eqs. (73), (74), are not computed: along a run they are those of the
mode in force, and as position and θ*_r do not jump from one mode to the other, V of Eq. (10) serves both.

V_PD of Eq. (54), the part of the inner loop in the formation's sum, is printed in reference [3] only, which is not
open. It is left out, and so are that sum and its derivative, Eq. (55).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from dwmr.control import laws
from dwmr.core.arrays import FloatArray
from dwmr.core.geometry import wrap_array
from dwmr.core.interfaces import Signal
from dwmr.scenario.model import Scenario
from dwmr.simulation.simulate import Trajectory

_V, _RATE = "m² + rad²", "(m² + rad²)/s"

#: What `signals` offers, where the control law has it. σ_v is in m and σ_ω in rad, so V adds squares of both.
SIGNALS = (
    Signal("surface_v", "m", "sliding variable σ_v before its transformation, Eq. (7)"),
    Signal("surface_omega", "rad", "sliding variable σ_ω before its transformation, Eq. (7)"),
    Signal("switching_v", "m/s", "sliding mode portion of the control law, v channel"),
    Signal("switching_omega", "rad/s", "sliding mode portion of the control law, omega channel"),
    Signal("d_0_v", "m/s", "d̃_0: velocity of the robot minus the commanded one"),
    Signal("d_0_omega", "rad/s", "d̃_0: angular velocity of the robot minus the commanded one"),
    Signal("V_10", _V, "Lyapunov function of Eq. (10)"),
    Signal("V_dot_10", _RATE, "its derivative, Eq. (14)"),
    Signal("V_23", _V, "Lyapunov function of Eq. (23)"),
    Signal("V_dot_23", _RATE, "its derivative, Eq. (26)"),
)

#: Share of a run at its end over which the growth of a gain is measured.
LAST_PART = 0.25

_CHANNELS = ("v", "omega")
_DRIFTING = ("k_h_v", "k_h_omega", "eta_v", "eta_omega")


def signals(trajectory: Trajectory, scenario: Scenario) -> Mapping[str, FloatArray]:
    """Return the Lyapunov functions of a run with their derivatives and parts, each of shape (samples, robots).

    Returns:
        Arrays by the names of `SIGNALS`. Without an adaptive gain there are no V_23 and V_dot_23. A user's law
        takes part when its gains and signals have the names that those of the shipped laws have; else there is nothing.

    Source:
        Goto, Bertol, Martins, Eqs. (7), (10), (14), (23)-(26).
    """
    gains = _gains(trajectory, scenario)
    if gains is None:
        return {}
    # numbers of a run that diverged may overflow, and so do quotients by a layer of no width
    with np.errstate(over="ignore", invalid="ignore"):
        result = _parts(trajectory, gains)
        if "switching_v" in result:
            result |= _functions(trajectory, gains, result)
    return result if "V_10" in result else {}


def _gains(trajectory: Trajectory, scenario: Scenario) -> Mapping[str, FloatArray] | None:
    """Return the numbers in the law's tables by key, each of shape (robots,), or None without sliding variables."""
    tables = [laws.table(scenario.robots[r].controllers, trajectory.controller)[1] for r in trajectory.robots]
    rows = [one or {} for one in tables]
    keys = [key for key in rows[0] if all(isinstance(row.get(key), int | float) for row in rows)]
    gains = {key: np.array([row[key] for row in rows], dtype=np.float64) for key in keys}
    complete = {"lambda_1", "lambda_2", "lambda_3", "p_v", "p_omega"} <= gains.keys()
    return gains if complete and {"sigma_v", "sigma_omega"} <= set(trajectory.names) else None


def _parts(trajectory: Trajectory, gains: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Return σ, the switching portions and d̃_0; a portion that is not known is left out.

    Source:
        Goto, Bertol, Martins, Eqs. (6), (7).
    """
    theta_e_star = wrap_array(trajectory["theta_r_star"] - trajectory["theta"])
    result = {
        "surface_v": gains["lambda_1"] * trajectory["x_e"],
        "surface_omega": gains["lambda_2"] * trajectory["y_e"] + gains["lambda_3"] * theta_e_star,
    }
    for channel, velocity in (("v", "v"), ("omega", "omega")):
        actual = trajectory[velocity] + trajectory[f"d_{channel}"]
        result[f"d_0_{channel}"] = actual - trajectory[f"{velocity}_c"]
        portion = _switching(trajectory, gains, channel)
        if portion is not None:
            result[f"switching_{channel}"] = portion
    return result


def _switching(trajectory: Trajectory, gains: Mapping[str, FloatArray], channel: str) -> FloatArray | None:
    """Return the sliding mode portion of one channel, shape (samples, robots), or None for an unknown law.

    Source:
        Goto, Bertol, Martins, Eq. (20) for AIFQSMC, Eq. (77) for FCAFSMC, Eq. (11) for SMC.
    """
    sigma, names = trajectory[f"sigma_{channel}"], trajectory.names
    if f"g_ais_{channel}" in names and f"beta_{channel}" in names:
        saturated = np.clip(sigma / trajectory[f"beta_{channel}"], -1.0, 1.0)
        return np.asarray(trajectory[f"g_ais_{channel}"] * saturated)
    if f"f_{channel}" in names:
        return trajectory[f"f_{channel}"]
    return gains[f"g_{channel}"] * np.sign(sigma) if f"g_{channel}" in gains else None


def _functions(
    trajectory: Trajectory, gains: Mapping[str, FloatArray], parts: Mapping[str, FloatArray]
) -> dict[str, FloatArray]:
    """Return V and its derivative of Eqs. (10) and (23).

    Source:
        Goto, Bertol, Martins, Eq. (14), first line, with the law's own switching portion; Eqs. (26), (37).
    """
    rate = np.zeros_like(parts["surface_v"])
    for channel in _CHANNELS:
        sigma = trajectory[f"sigma_{channel}"]
        rate += sigma * (parts[f"d_0_{channel}"] - parts[f"switching_{channel}"] - gains[f"p_{channel}"] * sigma)
    result = {"V_10": 0.5 * (parts["surface_v"] ** 2 + parts["surface_omega"] ** 2), "V_dot_10": rate}
    if "k_h_v" in trajectory.names and {"gamma_v", "gamma_omega"} <= gains.keys():
        value, value_rate = _adaptive_part(trajectory, gains)
        result |= {"V_23": result["V_10"] + value, "V_dot_23": rate + value_rate}
    return result


def _adaptive_part(trajectory: Trajectory, gains: Mapping[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Return ½ Σ k̃²/Γ and Σ k̃/Γ dk̂/dt; dk̂/dt is the change by the law from each sample to the next.

    Source:
        Goto, Bertol, Martins, Eqs. (23)-(25), with `surrogate` for k_h.
    """
    value, rate = np.zeros_like(trajectory["x_e"]), np.zeros_like(trajectory["x_e"])
    for channel in _CHANNELS:
        estimate, gamma = trajectory[f"k_h_{channel}"], gains[f"gamma_{channel}"]
        missing = estimate - surrogate(trajectory, channel)
        value += 0.5 * missing**2 / gamma
        rate += missing / gamma * _forward_rate(estimate, trajectory.t)
    return value, rate


def surrogate(trajectory: Trajectory, channel: str) -> FloatArray:
    """Return a substitute for the unknown k_h of Eq. (24): the largest k̂_h of the run, shape (robots,) [m/s or rad/s].

    Args:
        trajectory: A run under a law with an adaptive gain.
        channel: "v" or "omega".

    Source:
        Goto, Bertol, Martins, after Eq. (31): the ideal gain is at least as large as its estimates.
    """
    largest: FloatArray = trajectory[f"k_h_{channel}"].max(axis=0)
    return largest


def _forward_rate(values: FloatArray, t: FloatArray) -> FloatArray:
    """Return forward differences over time along the first axis; the last one is repeated, a single sample rests."""
    if len(t) < 2:
        return np.zeros_like(values)
    rate = np.diff(values, axis=0) / np.diff(t)[:, None]
    return np.concatenate([rate, rate[-1:]])


def last(found: Mapping[str, FloatArray], kind: str) -> FloatArray:
    """Return "V" or "V_dot" of Eq. (23) for a law with an adaptive gain, else of Eq. (10).

    Args:
        found: From `signals`, not empty.
        kind: Which of both.
    """
    return found.get(f"{kind}_23", found[f"{kind}_10"])


def measure(trajectory: Trajectory, scenario: Scenario) -> dict[str, Any]:
    """Return for every robot the shares of time in which V̇ > 0, and the drift of its adaptive gains, as plain data.

    Returns:
        "lyapunov": by robot the shares [-] `V_dot_10_positive`, and `V_dot_23_positive` with an adaptive gain; the
        last of them split into those `in_tracking` and `in_avoidance`, None for a mode that never is on; and
        `V_10_growing`, the share of periods after which V of Eq. (10) is larger than before.
        "drift": by robot and gain `start`, `largest`, `final` and `growth`, see `drift`. Either is empty for a law
        without them.
    """
    functions = signals(trajectory, scenario)
    watched = [name for name in _DRIFTING if name in trajectory.names]
    return {
        "lyapunov": {r: _shares(trajectory, functions, i) for i, r in enumerate(trajectory.robots)}
        if functions
        else {},
        "drift": {
            r: {name: drift(trajectory.t, trajectory[name][:, i]) for name in watched}
            for i, r in enumerate(trajectory.robots)
        }
        if watched
        else {},
    }


def _shares(trajectory: Trajectory, found: Mapping[str, FloatArray], i: int) -> dict[str, float | None]:
    shares: dict[str, float | None] = {
        f"{name}_positive": float(np.mean(found[name][:, i] > 0.0))
        for name in ("V_dot_10", "V_dot_23")
        if name in found
    }
    growth = np.diff(found["V_10"][:, i])
    shares["V_10_growing"] = float(np.mean(growth > 0.0)) if growth.size else None
    avoiding = trajectory["obstacle"][:, i] >= 0
    for name, mode in (("in_tracking", ~avoiding), ("in_avoidance", avoiding)):
        shares[name] = float(np.mean(last(found, "V_dot")[mode, i] > 0.0)) if mode.any() else None
    return shares


def drift(t: FloatArray, values: FloatArray) -> dict[str, float]:
    """Return whether a gain still drifts at the end of a run.

    Args:
        t: Times, shape (samples,) [s].
        values: An adaptive gain of one robot, shape (samples,).

    Returns:
        `start`, of an adaptive gain its floor, `largest` and `final` value, and `growth`, the slope of a straight line
        through the last `LAST_PART` of the run, per second; a gain that rests or falls there has no growth above 0.

    Source:
        Goto, Bertol, Martins, section 4.2: parameter drift, which Eqs. (21), (22) are to prevent.
    """
    late = t >= t[-1] - LAST_PART * (t[-1] - t[0])
    time = t[late] - t[late].mean()
    # no dot products: a linear algebra library splits them among its threads, and the last bits depend on their number
    spread = float(np.sum(time * time))
    growth = float(np.sum(time * values[late])) / spread if spread > 0.0 else 0.0
    return {"start": float(values[0]), "largest": float(values.max()), "final": float(values[-1]), "growth": growth}
