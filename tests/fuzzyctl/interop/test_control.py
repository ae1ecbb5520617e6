"""Blocks in python-control: the numbers of the kernel and of simulate."""

import control
import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import ArgumentError, ValueOutOfBoundsError
from fuzzyctl.interop.control import nlsys, start
from tests import sizes

RUN = f"{100 if sizes.LONG else 6} s step 10 ms"


class TestLoop:
    def test_a_slow_controller_and_a_held_plant_give_the_run_of_simulate(self, tank):
        loop = tank(RUN)
        run = fuzzyctl.Experiment(loop, "python").run()
        (law,), (plant,) = loop.controllers, loop.plants
        closed = control.interconnect(
            [nlsys(law, dt=0.01, name="law"), nlsys(plant, dt=0.01, name="tank")],
            connections=[["tank.v", "law.valve"], ["law.level", "tank.y"]],
            inplist=[["law.reference"], ["law.level"], ["tank.v"]], inputs=["r", "noise", "leak"],
            outlist=["tank.y", "law.valve"],
        )  # fmt: skip
        given = [run["reference"], run["law.level"] - run["tank.y"], -run["leak"]]
        begin = np.concatenate([start(law, dt=0.01), start(plant)])
        found = control.input_output_response(closed, run.t, given, begin)
        np.testing.assert_allclose(found.outputs[0], run["tank.y"], atol=1e-12)
        np.testing.assert_allclose(found.outputs[1], run["law.valve"], atol=1e-12)
        assert np.ptp(run["law.valve"]) > 1.0

    def test_a_controller_at_its_own_period_has_the_state_of_its_step(self, tank):
        (law,) = tank().controllers
        system, step = nlsys(law), fuzzyctl.compile(law, "python")
        assert (system.dt, system.nstates) == (0.05, len(step.state_names))
        t = np.arange(200) * 0.05
        given = np.array([np.ones(200), 0.5 + 0.4 * np.sin(t)])
        expected, _ = step.run(given.T)
        found = control.input_output_response(system, t, given, start(law))
        np.testing.assert_allclose(np.ravel(found.outputs), expected, atol=1e-12)


class TestBlocks:
    def test_a_system_is_static_and_joins_any_timebase(self):
        system = fuzzyctl.load("tipper")
        found = nlsys(system, name="tip")
        assert (found.nstates, found.dt, found.name) == (0, None, "tip")
        assert found.input_labels == ["service", "food"]
        assert float(found.output(0.0, [], [3.0, 8.0])[0]) == fuzzyctl.compile(system, "python")(3.0, 8.0)
        assert "input service" in found.__doc__
        assert " in [0, 10]" in found.__doc__

    def test_a_plant_is_continuous_without_a_sample_time(self, tank):
        (plant,) = tank().plants
        found = nlsys(plant)
        assert (found.dt, found.state_labels) == (0, ["h"])
        answer = control.input_output_response(found, np.linspace(0, 5, 51), np.full(51, 5.0), start(plant),
                                               solve_ivp_kwargs={"rtol": 1e-10, "atol": 1e-12})  # fmt: skip
        held = control.input_output_response(
            nlsys(plant, dt=0.1), np.linspace(0, 5, 51), np.full(51, 5.0), start(plant)
        )
        np.testing.assert_allclose(held.outputs, answer.outputs, atol=1e-7)
        assert "input v in [0, 10] [V]" in found.__doc__

    def test_a_controller_without_period_takes_dt(self):
        text = "controller law\ninput e\noutput u = integral(e)\n"
        law = fuzzyctl.loads(text, block=fuzzyctl.Controller)
        found = control.input_output_response(nlsys(law, dt=0.5), np.arange(4) * 0.5, np.ones(4))
        assert found.outputs.tolist() == [0.0, 0.5, 1.0, 1.5]
        with pytest.raises(ArgumentError, match="give its sample time as 'dt'"):
            nlsys(law)

    @pytest.mark.parametrize(
        ("options", "error", "words"),
        [
            ({"dt": 0.02}, ArgumentError, "not a multiple of dt = 0.02 s"),
            ({"dt": -1.0}, ValueOutOfBoundsError, "dt must be > 0 s"),
            ({"dt": float("inf")}, ValueOutOfBoundsError, "dt must be finite"),
            ({"dt": "0.1"}, ValueOutOfBoundsError, "dt must be real"),
            ({"dt": True}, ValueOutOfBoundsError, "dt must be a number"),
            ({"substeps": 0}, ValueOutOfBoundsError, "substeps must be a positive integer"),
        ],
    )
    def test_bad_sample_times_are_refused(self, tank, options, error, words):
        with pytest.raises(error, match=words):
            nlsys(tank().controllers[0], **options)

    def test_other_objects_and_dead_time_are_refused(self, small):
        with pytest.raises(ArgumentError, match="expected a FuzzySystem, Controller or Plant, got Loop"):
            nlsys(small())
        assert start(fuzzyctl.load("tipper")).shape == (0,)
        with pytest.raises(ArgumentError, match="has dead time"):
            nlsys(small("tf(num=[1], den=[1, 1], delay=0.1 s)").plants[0])
