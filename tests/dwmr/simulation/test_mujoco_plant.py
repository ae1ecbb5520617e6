"""Rigid bodies in MuJoCo: what Newton says of them, their agreement with the equations, and scenarios they refuse."""

import math

import numpy as np
import pytest

from dwmr import find, read
from dwmr.simulation import mujoco_plant
from dwmr.simulation.mujoco_plant import mjcf
from tests.dwmr.scenarios import diagnostics, shared
from tests.physics import needs_mujoco

EXPERIMENT = find("experiment")
NO_FRICTION = (
    "robot.friction.coulomb_force=0",
    "robot.friction.viscous_force=0",
    "robot.rigid_body.caster_friction=0",
    "robot.rigid_body.wheel_spin_friction=0",
)
PUSH = 'disturbances=[{kind="constant",start=0,stop=9,v=0,omega=0,force=%s,torque=%s}]'


class Driven:
    """Robots under held torques, for some control periods."""

    def __init__(self, *overrides):
        self.scenario = read(EXPERIMENT, overrides).scenario
        self.plant = mujoco_plant.MujocoPlant(self.scenario)
        self.state, self.slip = np.zeros((3, 7)), np.zeros((3, 2))

    def drive(self, right, left, periods, begin=0):
        torques = np.tile([float(right), float(left)], (3, 1))
        for k in range(begin, begin + periods):
            self.plant.move(k * self.scenario.run.dt, torques, self.state, self.slip)
        return self.state


@needs_mujoco
class TestMechanics:
    def test_mass_centre_and_inertia_are_those_of_the_scenario(self):
        import mujoco

        scenario = read(EXPERIMENT).scenario
        model = mujoco.MjModel.from_xml_string(mjcf(scenario))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        inertia = np.zeros((model.nv, model.nv))
        try:
            mujoco.mj_fullM(model, data, inertia)
        except TypeError:  # before MuJoCo 4
            mujoco.mj_fullM(model, inertia, data.qM)
        for i, robot in enumerate(scenario.robots.values()):
            body, first = model.body(f"robot{i}"), int(model.joint(f"free{i}").dofadr[0])
            assert model.body_subtreemass[body.id] == pytest.approx(robot.mass)
            offset = data.subtree_com[body.id] - data.xpos[body.id]
            wanted = [robot.com_offset, 0.0, robot.rigid_body.com_height - robot.wheel_radius]
            assert offset == pytest.approx(wanted, abs=1e-9)
            assert inertia[first + 5, first + 5] == pytest.approx(robot.inertia)

    def test_stand_still_without_torque(self):
        robots = Driven()
        before = np.array([(r.x_0, r.y_0, r.theta_0) for r in robots.scenario.robots.values()])
        assert robots.drive(0.0, 0.0, 100)[:, :3] == pytest.approx(before, abs=1e-3)

    def test_accelerate_as_newton_says(self):
        robots = Driven(*NO_FRICTION, "robot.actuator.lag=0.001")
        state = robots.drive(4.0, 4.0, 200)
        r, own = 0.13, robots.scenario.robots["leader"].rigid_body
        force, mass = 2.0 * 4.0 / r, 120.0 + 2.0 * 0.5 * own.wheel_mass
        assert state[:, 3] == pytest.approx(force / mass, rel=0.02)
        assert np.abs(robots.slip).max() < 0.01
        assert state[:, 0] - [-1.0, -3.5, -3.0] == pytest.approx(0.5 * force / mass, rel=0.02)

    def test_turn_to_the_left_when_the_right_wheel_pulls(self):
        state = Driven(*NO_FRICTION, "robot.actuator.lag=0.001").drive(1.0, -1.0, 400)
        assert (state[:, 2] > 0.5).all()
        assert state[:, 4] == pytest.approx(2.0 * 2.0 * 0.268 / 0.13 / 13.8, rel=0.1)

    def test_count_whole_turns(self):
        state = Driven("robot.friction.coulomb_force=0").drive(4.0, -4.0, 1000)
        assert (state[:, 2] > 2.0 * math.pi).all()

    def test_friction_takes_its_force_from_the_motion(self):
        force, mass = 2.0 * 4.0 / 0.13, 123.0
        for own, speed in (
            ("viscous_force=60", force / 60.0 * (1.0 - math.exp(-60.0 / mass))),
            ("coulomb_force=30", (force - 30.0) / mass),
        ):
            others = [key for key in NO_FRICTION if own.split("=")[0] not in key]
            state = Driven(*others, "robot.actuator.lag=0.001", f"robot.friction.{own}").drive(4.0, 4.0, 200)
            assert state[:, 3] == pytest.approx(speed, rel=0.03)

    def test_torques_follow_with_the_lag_of_the_drives_and_within_their_limit(self):
        lag, limit = 0.02, 34.0
        assert Driven().drive(10.0, -10.0, 4)[0, 5:] == pytest.approx(
            [10.0 * (1 - math.exp(-0.02 / lag)), -6.32], rel=0.01
        )
        assert Driven().drive(100.0, 100.0, 100)[0, 5:] == pytest.approx([limit, limit], rel=1e-6)

    def test_wheels_slip_on_ice(self):
        robots = Driven("robot.rigid_body.wheel_friction=0.02")
        robots.drive(20.0, 20.0, 100)
        assert (robots.slip[:, 0] < -1.0).all()

    def test_a_load_makes_them_slower(self):
        loaded = [*NO_FRICTION, "load.start=0", "load.stop=9", "load.mass_factor=1.5"]
        slow, fast = Driven(*loaded).drive(4.0, 4.0, 100), Driven(*NO_FRICTION).drive(4.0, 4.0, 100)
        assert slow[:, 3] == pytest.approx(fast[:, 3] * 123 / 183, rel=0.02)

    def test_forces_and_torques_push_them(self):
        assert Driven(*NO_FRICTION, PUSH % (60.0, 0.0)).drive(0, 0, 200)[:, 3] == pytest.approx(60 / 123, rel=0.03)
        assert (Driven(*NO_FRICTION, PUSH % (0.0, 10.0)).drive(0, 0, 200)[:, 4] > 0.5).all()
        spared = PUSH % (60.0, 0.0)
        state = Driven(*NO_FRICTION, spared.replace("force", 'robots=["leader"],force')).drive(0, 0, 100)
        assert state[0, 3] > 0.2
        assert np.abs(state[1:, 3]).max() < 0.01

    def test_bodies_do_not_pass_through_each_other(self):
        ahead = ("robots.leader.x_0=0", "robots.leader.y_0=3.0", "robots.follower1.x_0=-2.0")
        robots = Driven(*ahead)
        torques = np.array([[0.0, 0.0], [10.0, 10.0], [0.0, 0.0]])
        for k in range(600):
            robots.plant.move(0.005 * k, torques, robots.state, robots.slip)
        assert robots.state[0, 0] > 0.5  # pushed
        axles = robots.state[:2, 0] - [0.1, 0.4]
        assert axles[0] - axles[1] > 0.9


def run(*overrides):
    return shared("experiment", "aifqsmc", *overrides)[1]


@needs_mujoco
class TestRun:
    def test_is_near_that_of_the_equations(self):
        bodies, equations = (run("run.horizon=4", f"run.plant={plant}") for plant in ("mujoco", "equations"))
        for name, near in (("x", 0.15), ("y", 0.15), ("theta", 0.3)):
            assert np.abs(bodies[name] - equations[name]).max() < near, name
        assert not np.array_equal(bodies["x"], equations["x"])

    def test_keeps_where_the_bodies_were(self):
        trajectory, d = run("run.horizon=1", PUSH % (50.0, 0.0)), np.array([0.1, 0.4, 0.4])
        positions = trajectory.positions.reshape(-1, 3, 9)
        axle_x, axle_y = (trajectory[n] - d * f(trajectory["theta"]) for n, f in (("x", np.cos), ("y", np.sin)))
        assert positions[..., 0] == pytest.approx(axle_x, abs=1e-6)
        assert positions[..., 1] == pytest.approx(axle_y, abs=1e-6)
        assert (positions[-1, :, 7:] > 0.1).all()  # wheels have turned forwards
        assert run("run.horizon=0.1", "run.plant=equations").positions is None

    def test_that_diverges_is_stopped_and_writes_no_file_of_its_own(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        trajectory = run("run.horizon=2", PUSH % (1e9, 0.0))
        assert trajectory.stop is not None
        assert "diverged" in trajectory.stop.reason
        assert list(tmp_path.iterdir()) == []


class TestRefuses:
    def test_says_what_brings_mujoco(self, monkeypatch):
        def missing(name):
            raise ImportError(f"No module named {name!r}")

        monkeypatch.setattr(mujoco_plant, "import_module", missing)
        (found,) = diagnostics(mujoco_plant.require, read(EXPERIMENT))
        assert (found.code, "fuzzyctl[physics]" in found.help) == ("FZ904", True)
        assert found.facts == ("No module named 'mujoco'",)
        mujoco_plant.require(read(find("paper")))

    @needs_mujoco
    def test_gives_the_words_of_mujoco_for_a_model_it_refuses(self):
        (found,) = diagnostics(mujoco_plant.require, read(EXPERIMENT, ["robot.inertia=0.001"]))
        assert "does not load" in found.message
        assert "inertia" in found.facts[0]

    @pytest.mark.parametrize("error", [RuntimeError("invalid value"), AttributeError("'NoneType'")])
    def test_a_renderer_that_mujoco_cannot_have_is_a_diagnostic(self, monkeypatch, error):
        def broken(name):
            raise error

        monkeypatch.setattr(mujoco_plant, "import_module", broken)
        monkeypatch.setenv("MUJOCO_GL", "osmesa")
        (found,) = diagnostics(mujoco_plant.require, read(EXPERIMENT))
        assert "cannot be imported with MUJOCO_GL = 'osmesa'" in found.message
        assert found.facts == (str(error),)
