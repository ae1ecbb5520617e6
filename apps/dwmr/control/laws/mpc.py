"""MPC: nonlinear model predictive control, whose optimal commands come from IPOPT through CasADi.

The solver predicts the posture error of Eq. (6). It assumes that the place of the robot, on its reference or in the
formation, goes straight on at its present velocity. The first commands of each plan are held until the next one.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from dwmr.config.quantities import quantity
from dwmr.control.laws.settings import LawSettings
from dwmr.core.arrays import FloatArray
from dwmr.core.interfaces import Law, Signal, TrackingError, control_law
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from dwmr.control.fuzzy_gains import Rules

SIGNALS = (
    Signal("cost", "m²", "cost of the plan"),
    Signal("iterations", "-", "iterations of the solver"),
)
FAULTS = {
    1: "the solver of the predictive control reached its limit of iterations",
    2: "the solver of the predictive control found no feasible commands",
    3: "the solver of the predictive control met a number that is not finite",
    4: "the solver of the predictive control failed",
}
_STATUS = {"SOLVER_RET_LIMITED": 1, "SOLVER_RET_INFEASIBLE": 2, "SOLVER_RET_NAN": 3}

#: Numbers in the state: commands, cost and iterations of the plan; then the start of the next one.
_PLAN, _START = 4, ("x_e", "y_e", "drift_x", "drift_y", "d", "dt")


class Settings(LawSettings):
    """Weights and horizon; the velocity limits are those of the robot's drives."""

    q_y: float = quantity("weight of the lateral error over that of the longitudinal one", "-", gt=0, default=1.0)
    q_theta: float = quantity(
        "weight of the velocity lost by another direction than the place's", "m s", gt=0, default=0.1
    )
    r_v: float = quantity("weight of the linear velocity's difference from the place's", "s²", gt=0, default=0.1)
    r_omega: float = quantity("weight of the angular velocity's difference", "m² s²/rad²", gt=0, default=0.03)
    steps: int = Field(10, description="predicted steps", ge=1, le=200)
    every: int = Field(20, description="control periods in one step, and from one plan to the next", ge=1, le=10_000)

    def prove(self, rules: Rules, robot: str) -> None:
        """Require CasADi.

        Raises:
            DiagnosticError: When it cannot be imported.
        """
        try:
            import_module("casadi")
        except ImportError as error:
            message = "the control law mpc needs the package casadi, which cannot be imported"
            help_text = "pip install 'fuzzyctl[mpc]', or take another control law"
            raise DiagnosticError([Diagnostic("FZ905", message, facts=(str(error),), help=help_text)]) from None


@cache
def solver(steps: int) -> Any:
    """Return the solver of a horizon.

    Its variables are, step by step, both commands and the three errors that they lead to: along, across, and the turn
    since the plan was made. Its parameters are those of `_START`, the last one times `every`, and the four weights.

    Source:
        Goto, Bertol, Martins, Eq. (6), for errors; a Runge-Kutta step of order 4 takes them to the next step.
    """
    ca = import_module("casadi")
    error, command, start = ca.SX.sym("error", 3), ca.SX.sym("command", 2), ca.SX.sym("start", 10)
    x_e, y_e, drift_x, drift_y, d, period, q_y, q_theta, r_v, r_omega = ca.vertsplit(start)
    along = drift_x * ca.cos(error[2]) + drift_y * ca.sin(error[2])
    across = drift_y * ca.cos(error[2]) - drift_x * ca.sin(error[2])
    v, omega = command[0], command[1]
    rate = ca.vertcat(along - v + omega * error[1], across - omega * (d + error[0]), omega)
    rates = ca.Function("rates", [error, command, start], [rate])
    a = rates(error, command, start)
    b = rates(error + 0.5 * period * a, command, start)
    c = rates(error + 0.5 * period * b, command, start)
    e = rates(error + period * c, command, start)
    then = error + period / 6.0 * (a + 2.0 * b + 2.0 * c + e)
    lost = ca.sqrt(drift_x**2 + drift_y**2) - along
    cost = then[0] ** 2 + q_y * then[1] ** 2 + q_theta * lost
    cost += r_v * (v - along) ** 2 + r_omega * (omega - across / d) ** 2
    step = ca.Function("step", [error, command, start], [then, cost])
    unknown, defects, total, before = [], [], 0.0, ca.vertcat(x_e, y_e, 0.0)
    for k in range(steps):
        now, after = ca.SX.sym(f"command_{k}", 2), ca.SX.sym(f"error_{k}", 3)
        predicted, part = step(before, now, start)
        unknown += [now, after]
        defects.append(after - predicted)
        total, before = total + part, after
    problem = {"x": ca.vertcat(*unknown), "p": start, "f": total, "g": ca.vertcat(*defects)}
    options = {
        "print_time": False,
        "calc_lam_p": False,
        "ipopt.print_level": 0,
        "ipopt.sb": "yes",
        "ipopt.max_iter": 300,
    }
    return ca.nlpsol("plan", "ipopt", problem, options)


def init(settings: Settings, rules: Rules, robot: str) -> Law:
    """Prepare the law for one robot."""
    weights = (settings.q_y, settings.q_theta, settings.r_v, settings.r_omega)
    solve = solver(settings.steps)

    def plan(state: FloatArray, robot: Any) -> int:
        """Write a plan into the state; return a key of FAULTS, or 0."""
        x_e, y_e, drift_x, drift_y, d, dt = state[_PLAN:]
        limits = np.array([robot.v_limit, robot.omega_limit])
        most = np.tile([*limits, np.inf, np.inf, np.inf], settings.steps)
        guess = np.clip(np.tile([drift_x, 0.0, x_e, y_e, 0.0], settings.steps), -most, most)
        start = (x_e, y_e, drift_x, drift_y, d, settings.every * dt, *weights)
        try:
            solution = solve(x0=guess, p=start, lbx=-most, ubx=most, lbg=0.0, ubg=0.0)
        except RuntimeError:
            return len(FAULTS)
        end = solve.stats()
        state[:2] = np.clip(solution["x"].full()[:2, 0], -limits, limits)  # the solver exceeds them by 1e-8
        state[2:_PLAN] = float(solution["f"]), end["iter_count"]
        return 0 if end["success"] else _STATUS.get(end["unified_return_status"], len(FAULTS))

    return Law(np.zeros(0), np.zeros(_PLAN + len(_START)), (), (), plan, settings.every)


@control_law()
def step(
    error: TrackingError, dt: float, gains: FloatArray, state: FloatArray, kernels: tuple[()], next_state: FloatArray,
    signals: FloatArray,
) -> tuple[float, float, int]:  # fmt: skip
    """Return the commands of the plan, and keep the start of the next one."""
    for k in range(4):
        next_state[k] = state[k]
    next_state[4], next_state[5] = error.x_e, error.y_e
    next_state[6], next_state[7] = error.drift_x, error.drift_y
    next_state[8], next_state[9] = error.d, dt
    signals[0], signals[1] = state[2], state[3]
    return state[0], state[1], 0
