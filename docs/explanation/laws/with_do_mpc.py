"""The control law mpc beside do-mpc: the same problem, once solved by dwmr's law and once by do-mpc's controller.

    python docs/explanation/laws/with_do_mpc.py

runs scene.toml, which lies beside this file, under both and prints how far each robot is from its place. It takes half
a minute and needs do-mpc: pip install do-mpc. This file is itself the second law: a law in Python with a plan.
"""

from pathlib import Path

import casadi as ca
import do_mpc
import numpy as np

import dwmr
from dwmr.control.laws import mpc
from dwmr.control.laws.mpc import FAULTS, SIGNALS, Settings, step  # noqa: F401 - parts of a law
from dwmr.core.interfaces import Law

HERE = Path(__file__).parent


def model():
    """Return Eq. (6) as do-mpc's model, in continuous time, with the velocity of the place as parameters."""
    system = do_mpc.model.Model("continuous", "SX")
    x_e, y_e, turn = (system.set_variable("_x", name) for name in ("x_e", "y_e", "turn"))
    v, omega = (system.set_variable("_u", name) for name in ("v", "omega"))
    drift_x, drift_y, d = (system.set_variable("_p", name) for name in ("drift_x", "drift_y", "d"))
    along = drift_x * ca.cos(turn) + drift_y * ca.sin(turn)
    across = drift_y * ca.cos(turn) - drift_x * ca.sin(turn)
    system.set_expression("along", along)
    system.set_expression("across", across)
    system.set_rhs("x_e", along - v + omega * y_e)
    system.set_rhs("y_e", across - omega * (d + x_e))
    system.set_rhs("turn", omega)
    system.setup()
    return system


def controller(settings, period, robot):
    """Return do-mpc's controller with the weights, horizon and limits of the law; it predicts by collocation."""
    system = model()
    solver = do_mpc.controller.MPC(system)
    solver.settings.n_horizon, solver.settings.t_step, solver.settings.n_robust = settings.steps, period, 0
    solver.settings.store_full_solution = False
    solver.settings.supress_ipopt_output()
    x, u, place = system.x, system.u, system.p
    along, across = system.aux["along"], system.aux["across"]
    # errors count at the beginning of each stage and at the end of the last one, in the law at the end of each stage
    error = x["x_e"] ** 2 + settings.q_y * x["y_e"] ** 2
    lost = ca.sqrt(place["drift_x"] ** 2 + place["drift_y"] ** 2) - along
    stage = error + settings.q_theta * lost + settings.r_v * (u["v"] - along) ** 2
    stage += settings.r_omega * (u["omega"] - across / place["d"]) ** 2
    solver.set_objective(mterm=error, lterm=stage)
    solver.set_rterm(v=0.0, omega=0.0)
    for name, most in (("v", robot.v_limit), ("omega", robot.omega_limit)):
        solver.bounds["lower", "_u", name], solver.bounds["upper", "_u", name] = -most, most
    values = solver.get_p_template(1)
    solver.set_p_fun(lambda _: values)
    solver.setup()
    return solver, values, ca.Function("cost", [solver.opt_x, solver.opt_p], [solver.nlp_obj])


def init(settings, rules, robot):
    """Return the law for one robot: do-mpc makes its plans, and starts each from the one before."""
    controllers = []

    def plan(state, robot):
        x_e, y_e, drift_x, drift_y, d, dt = state[4:]
        first = not controllers
        if first:
            controllers.append(controller(settings, settings.every * dt, robot))
        ((solver, values, cost),) = controllers
        values["_p", 0] = np.array([drift_x, drift_y, d])
        start = np.array([[x_e], [y_e], [0.0]])
        if first:
            solver.x0, solver.u0 = start, np.array([[drift_x], [0.0]])
            solver.set_initial_guess()
        state[:2] = solver.make_step(start)[:, 0]
        end = solver.solver_stats
        state[2], state[3] = (
            float(cost(solver.opt_x_num, solver.opt_p_num)) - x_e**2 - settings.q_y * y_e**2,
            end["iter_count"],
        )
        return 0 if end["success"] else len(FAULTS)

    return Law(np.zeros(0), np.zeros(10), (), (), plan, settings.every)


def differences(*overrides):
    """Return the root mean square distances of all robots from their places [m], and the cost of all plans, by law."""
    file = dwmr.read(HERE / "scene.toml", overrides)
    by_law = {}
    for law in ("mpc", Path(__file__).stem):
        run = dwmr.simulate(file, law)
        assert run.stop is None, run.stop
        distances = np.sqrt(np.mean(run["x_e"] ** 2 + run["y_e"] ** 2, axis=0)).tolist()
        cost = float(run["cost"][1 :: mpc.Settings().every].sum())
        by_law[law] = dict(zip(run.robots, distances, strict=True)) | {"cost": cost}
    return by_law


def table(by_law):
    """Yield the lines of the table of the page."""
    rows = {"`mpc`": by_law["mpc"], "do-mpc": by_law["with_do_mpc"]}
    heads = list(by_law["mpc"])
    yield f"| | {', m | '.join(heads[:-1])}, m | {heads[-1]}, m² |\n"
    yield "|---" * (len(heads) + 1) + "|\n"
    for name, row in rows.items():
        yield f"| {name} | " + " | ".join(f"{row[k]:.4f}" if k != "cost" else f"{row[k]:.1f}" for k in heads) + " |\n"


if __name__ == "__main__":
    print("".join(table(differences())), end="")
