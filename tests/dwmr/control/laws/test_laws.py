"""The shipped control laws as text, stepped by hand and compared with the paper's matrices.

The whole law of AIFQSMC is compared with a second computation in tests/dwmr/test_independent.py.
"""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fuzzyctl
from dwmr import find, read
from tests import sizes
from tests.dwmr.process import here
from tests.dwmr.scenarios import diagnostics, edited, measured, run, shared
from tests.shipped import rules_folder

#: Laws of the literature that the scenario has no gains for.
BASELINES = ("backstepping", "kanayama", "super_twisting")
SLOPES = (0.5, 0.3, 0.7)
DT = 0.005
#: The reference point ahead of the wheel axis [m].
D = 0.4
small = st.floats(-1.5, 1.5)


@cache
def compiled(name, **params):
    """Return the step of a law as plain Python; equal calls share one."""
    controller = fuzzyctl.load(rules_folder() / f"{name}.fz", block=fuzzyctl.Controller)
    return fuzzyctl.compile(controller.with_params(**params) if params else controller, "python")


class Bench:
    """A control law of one robot, stepped by hand."""

    def __init__(self, name, **params):
        self.law = compiled(name, **params)
        self.state = np.array(self.law.start())
        self.outputs = {}

    def step(self, x_e=0.1, y_e=-0.2, theta=0.3, drift=(0.6, 0.05, 0.1), d=D):
        values, self.state = self.law(x_e, y_e, theta, *drift, d, self.state, dt=DT)
        self.outputs = dict(zip(self.law.output_names, values, strict=True))
        return self

    def consequents(self, channel):
        """Return the positions of the adaptive consequents of one channel."""
        return [k for k, name in enumerate(self.law.state_names) if name.startswith(f"push_{channel}.F")]

    def __getitem__(self, name):
        return self.outputs[name]


def expected(x_e=0.1, y_e=-0.2, theta=0.3, drift=(0.6, 0.05, 0.1), d=D):
    """Return σ* of Eq. (9) and the equivalent control of Eq. (13), without its guard, for both channels."""
    l1, l2, l3 = SLOPES
    matrix = np.array([[-l1, l1 * y_e], [0.0, -(l2 * (d + x_e) + l3)]])
    sigma = matrix.T @ [l1 * x_e, l2 * y_e + l3 * theta]
    return sigma, -np.linalg.solve(matrix, [l1 * drift[0], l2 * drift[1] + l3 * drift[2]])


def commands(bench):
    return np.array([bench["v_c"], bench["omega_c"]])


def channels(bench, name):
    return np.array([bench[f"{name}_v"], bench[f"{name}_omega"]])


class TestSurface:
    @given(small, small, small, st.sampled_from([0.1, 0.4]))
    def test_sliding_variables_are_the_transposed_input_matrix_times_sigma(self, x_e, y_e, theta, d):
        bench = Bench("sliding_surface").step(x_e, y_e, theta, d=d)
        assert channels(bench, "sigma") == pytest.approx(expected(x_e, y_e, theta, d=d)[0], abs=1e-12)

    @given(small, small, small, small, small, small)
    def test_equivalent_control_holds_the_surfaces_still(self, x_e, y_e, theta, drift_x, drift_y, drift_theta):
        l1, l2, l3 = SLOPES
        bench = Bench("sliding_surface").step(x_e, y_e, theta, (drift_x, drift_y, drift_theta), d=0.1)
        v, omega = bench["v"], bench["omega"]
        # Eq. (6) with these velocities, and sigma of Eq. (7)
        assert l1 * (drift_x - v + y_e * omega) == pytest.approx(0.0, abs=1e-9)
        assert l2 * (drift_y - (0.1 + x_e) * omega) + l3 * (drift_theta - omega) == pytest.approx(0.0, abs=1e-9)

    @given(st.floats(-10.0, 10.0))
    def test_divisor_keeps_its_sign_and_a_least_size(self, x_e):
        omega = Bench("sliding_surface").step(x_e, 0.0, 0.0, (0.0, 0.0, 1.0), d=0.1)["omega"]
        plain = 0.3 * (0.1 + x_e) + 0.7
        assert 0.7 / omega == pytest.approx(plain if abs(plain) >= 0.05 else np.copysign(0.05, plain))


class TestNames:
    def test_are_those_of_the_shipped_texts_and_their_ablations(self):
        parts = tuple(f"aifqsmc_without_{part}" for part in ("adaptation", "immunity", "layer"))
        names = ("ackermann", "aifqsmc", *parts, "backstepping", "fcafsmc", "kanayama", "mpc", "omnidirectional")
        names = (*names, "smc", "super_twisting")
        said = " ".join(here("run", "paper", "--controller", "pid", status=2).stderr.split())
        assert f"'pid' is not one of {', '.join(map(repr, (*names, 'all', 'ablations')))}, and there is no" in said

    def test_an_ablation_has_the_gains_of_its_law_unless_the_scenario_gives_it_its_own(self):
        tables = read(find("paper-with-limits")).scenario.robots["leader"].controllers
        usual = tables["aifqsmc"] | {"lambda_1": 1.0}
        overrides = [f"robot.controllers.aifqsmc_without_layer.{key}={value}" for key, value in usual.items()]
        for name, slope in (("aifqsmc_without_layer", 1.0), ("aifqsmc_without_adaptation", 0.5)):
            found = run("paper-with-limits", name, "run.horizon=0.01", *overrides)
            assert found["sigma_v"][0] == pytest.approx(-(slope**2) * found["x_e"][0])


class TestBaselines:
    @given(small, small, small, st.floats(0.0, 2.0), small)
    def test_kanayama_and_backstepping_are_their_equations(self, x_e, y_e, theta, v_r, omega_r):
        errors = {"x_e": x_e, "y_e": y_e, "theta_e": theta, "v_r": v_r, "omega_r": omega_r}
        wanted = [v_r * np.cos(theta) + 1.5 * x_e, omega_r + v_r * (2.5 * y_e + 3.0 * np.sin(theta))]
        for name, gains in (("kanayama", ("k_x", "k_y", "k_theta")), ("backstepping", ("k_1", "k_2", "k_3"))):
            law = compiled(name, **dict(zip(gains, (1.5, 2.5, 3.0), strict=True)))
            values, _ = law(*(errors[n] for n in law.input_names), np.array(law.start()), dt=DT)
            outputs = dict(zip(law.output_names, values, strict=True))
            assert [outputs["v_c"], outputs["omega_c"]] == pytest.approx(wanted)

    def test_backstepping_leads_its_command_by_the_time_constant_of_the_inner_loop(self):
        law, state = compiled("backstepping", k_4=20.0), None
        for x_e in (0.1, 0.2):
            values, state = law(x_e, 0.0, 0.0, 0.5, 0.0, np.array(law.start()) if state is None else state, dt=DT)
        outputs = dict(zip(law.output_names, values, strict=True))
        assert outputs["v_c"] - outputs["v_f"] == pytest.approx(0.1 / DT / 20.0)

    def test_super_twisting_takes_a_root_and_an_integral_from_the_equivalent_control(self):
        sigma, equivalent = expected(y_e=0.4)
        bench = Bench("super_twisting", k_1_v=0.3, k_1_omega=0.4, k_2_v=2.0, k_2_omega=3.0, w_max=0.02).step(y_e=0.4)
        assert commands(bench) == pytest.approx(equivalent - [0.3, 0.4] * np.sqrt(abs(sigma)) * np.sign(sigma))
        bench.step(y_e=0.4)
        assert channels(bench, "integral") == pytest.approx([0.01, 0.015] * np.sign(sigma))
        for _ in range(5):
            bench.step(y_e=0.4)
        assert channels(bench, "integral") == pytest.approx(0.02 * np.sign(sigma))

    @pytest.mark.parametrize("law", BASELINES)
    def test_runs_in_the_scenario_of_the_paper(self, law):
        end = run("paper", law, "run.horizon=30")
        assert end.stop is None
        assert np.hypot(end["x_e"], end["y_e"])[-1, 1:].max() < 0.6


class TestSmc:
    def test_adds_constant_switching_and_reaching_to_the_equivalent_control(self):
        sigma, equivalent = expected(y_e=0.4)
        bench = Bench("smc", p_v=0.1, p_omega=0.2, g_v=0.3, g_omega=0.4).step(y_e=0.4)
        assert commands(bench) == pytest.approx(equivalent - [0.3, 0.4] * np.sign(sigma) - [0.1, 0.2] * sigma)

    def test_rests_on_the_surface(self):
        assert commands(Bench("smc").step(0.0, 0.0, 0.0)) == pytest.approx(expected(0.0, 0.0, 0.0)[1])


class TestAifqsmc:
    def test_starts_with_the_floor_gain_and_no_rate(self):
        bench = Bench("aifqsmc").step()
        assert channels(bench, "k_h").tolist() == [0.1, 0.1]
        assert channels(bench, "sigma_dot").tolist() == [0.0, 0.0]

    @settings(max_examples=sizes.examples(50, 10))
    @given(st.lists(st.tuples(*[st.floats(-3.0, 3.0)] * 3), min_size=1, max_size=30))
    def test_gain_and_layer_stay_positive_whatever_the_errors_do(self, sequence):
        # an adaptation so strong that one period would go far below the floor
        for bench in (Bench("aifqsmc"), Bench("aifqsmc", gamma_v=500.0, gamma_omega=500.0)):
            for values in sequence:
                bench.step(*values)
                assert channels(bench, "g_ais").min() >= 0.001 - 1e-12
                assert 0.005 <= channels(bench, "beta").min() <= channels(bench, "beta").max() <= 0.05
                assert -1.0 <= channels(bench, "f").min() <= channels(bench, "f").max() <= 0.18
                assert channels(bench, "k_h").min() >= 0.1

    def test_channels_have_their_own_layer_and_adaptation(self):
        errors = (0.4, 0.0, 0.02)
        sigma, equivalent = expected(*errors)
        bench = Bench("aifqsmc").step(*errors)
        beta = channels(bench, "beta")
        assert abs(sigma[1]) < beta[1]
        assert beta[1] > 2.0 * beta[0]
        inside = np.clip(sigma / beta, -1.0, 1.0)
        assert commands(bench) == pytest.approx(equivalent - channels(bench, "g_ais") * inside - 0.1 * sigma)
        for _ in range(3):
            bench.step(1.0, 1.0)
        assert bench["k_h_v"] < bench["k_h_omega"]

    def test_signals_have_the_unit_of_their_channel(self):
        units = {s.name: s.unit for s in shared("paper-with-limits", "aifqsmc", "run.horizon=1")[1].law_signals}
        assert (units["g_ais_v"], units["g_ais_omega"]) == ("m/s", "rad/s")
        assert (units["sigma_v"], units["sigma_omega"]) == ("m", "rad")


class TestOneChannel:
    """The closed loop with proved bounds has the law of AIFQSMC."""

    @pytest.mark.parametrize("gamma", [0.15, 0.4])  # of the channels of `paper`
    def test_it_pushes_and_adapts_as_the_law_does(self, gamma):
        loop = compiled("one_channel")
        law = compiled("immune_channel", gamma=gamma)
        state, own = np.array(loop.start()), np.array(law.start())
        rng, b, before, largest = np.random.default_rng(0), 0.5, 0.0, 0.0
        for period in range(2000):
            sigma = dict(zip(loop.state_names, state, strict=True))["sigma"]
            change = (sigma - before) / DT if period else 0.0
            d = 0.28 * np.sign(np.sin(period * DT)) if period % 600 < 400 else rng.uniform(-0.28, 0.28)
            values, own = law(sigma, own, dt=DT)
            wanted = dict(zip(law.output_names, values, strict=True))
            values, state = loop(d, change, b, gamma, state)
            outputs = dict(zip(loop.output_names, values, strict=True))
            assert outputs["push"] == pytest.approx(wanted["push"], abs=1e-12)
            assert outputs["gain"] == pytest.approx(wanted["gain"], abs=1e-12)
            before, largest = sigma, max(largest, abs(sigma))
        assert 0.02 < largest <= 0.032


class TestAblations:
    """Each differs from AIFQSMC by its part, and by nothing else."""

    def test_without_adaptation_the_gain_stays_at_its_floor(self):
        whole, bench = Bench("aifqsmc").step(1.0), Bench("aifqsmc", adaptation=0).step(1.0)
        assert commands(bench).tolist() == commands(whole).tolist()
        for _ in range(5):
            bench.step(1.0)
            whole.step(1.0)
        assert channels(bench, "k_h").tolist() == [0.1, 0.1]
        assert whole["k_h_v"] > 0.1
        assert bench["f_v"] == whole["f_v"]
        assert whole["g_ais_v"] == pytest.approx(whole["k_h_v"] * (1.0 - whole["eta_v"] * whole["f_v"]))

    def test_without_a_layer_the_sign_switches_and_is_zero_on_the_surface(self):
        bench, errors = Bench("aifqsmc", layer=0), (0.01, 0.0, 0.02)
        sigma, equivalent = expected(*errors)
        wanted = equivalent - channels(bench.step(*errors), "g_ais") * np.sign(sigma) - 0.1 * sigma
        assert commands(bench) == pytest.approx(wanted)
        assert commands(Bench("aifqsmc", layer=0).step(0.0, 0.0, 0.0)) == pytest.approx(expected(0.0, 0.0, 0.0)[1])

    def test_without_immunity_the_gain_is_the_adaptive_one(self):
        bench, whole = Bench("aifqsmc", immunity=0).step(), Bench("aifqsmc").step()
        assert channels(bench, "f").tolist() == [0.0, 0.0]
        assert bench["g_ais_v"] == bench["k_h_v"] == whole["k_h_v"] != whole["g_ais_v"]
        assert bench["beta_v"] == whole["beta_v"]

    def test_run_with_their_part_at_zero(self):
        parts = {"adaptation": "k_h_v", "immunity": "f_v"}
        for part, signal in parts.items():
            found = shared("paper-with-limits", f"aifqsmc_without_{part}", "run.horizon=1")[1][signal]
            assert len(np.unique(found)) == 1

    def test_chatter_without_the_layer_as_the_paper_says(self):
        laws = ("aifqsmc", "aifqsmc_without_layer")
        whole, bare = (measured("paper-with-limits", law, "run.horizon=60")["chattering"] for law in laws)
        assert all(bare[robot]["v"] > 2.0 * one["v"] for robot, one in whole.items())


class TestFcafsmc:
    def test_begins_without_fuzzy_gain_and_consequents_grow_with_sigma_in_proportion_to_their_rules(self):
        sigma, equivalent = expected()
        bench = Bench("fcafsmc_law").step()
        assert commands(bench) == pytest.approx(equivalent - 0.1 * sigma)
        assert [bench.state[bench.consequents(c)].sum() for c in ("v", "omega")] == pytest.approx(DT * sigma)

    @settings(max_examples=sizes.examples(20, 10))
    @given(st.lists(st.tuples(*[st.floats(-20.0, 20.0)] * 3), min_size=1, max_size=30))
    def test_consequents_and_gain_stay_in_their_range(self, sequence):
        bench = Bench("fcafsmc_law")
        assert len(bench.consequents("v") + bench.consequents("omega")) == bench.state.size == 14
        bench.state[:] = 1.99
        for values in sequence:
            bench.step(*values)
            assert max(np.abs(bench.state).max(), np.abs(channels(bench, "f")).max()) <= 2.0


class TestEditedText:
    """Requirements of the text of a law are proved before a run, with the gains of each robot."""

    def rules(self, folder, *replacements, file="immune_channel.fz"):
        for path in rules_folder().glob("*.fz"):
            (folder / path.name).write_bytes(path.read_bytes())
        edited(rules_folder() / file, folder / file, *replacements)
        return folder

    def refusal(self, *arguments, **options):
        folder = self.rules(*arguments, **options)
        return diagnostics(lambda: run("paper-with-limits", "aifqsmc", folders=(folder,)))

    def test_an_adaptation_that_may_leave_its_floor_is_refused(self, tmp_path, monkeypatch):
        monkeypatch.setattr("fuzzyctl.analysis.prove.TIMEOUT", 0.5)  # it is all used up
        floor = ("max(k_h_min, k_h + dt * adaptation * rate)", "k_h + dt * rate")
        found = self.refusal(tmp_path, floor)
        assert {d.code for d in found} == {"FZ402"}
        assert found[0].span.source.name == str(tmp_path / "aifqsmc.fz")
        assert found[0].facts[0] == "robot leader"

    def test_another_law_with_the_same_guarantee_is_accepted(self, tmp_path):
        folder = self.rules(tmp_path, ("pull * sign(size - epsilon)", "pull - 0.01 * k_h"))
        here("check", "paper-with-limits", "--rules", folder)

    def test_a_gain_that_the_text_does_not_have_is_named_with_its_key(self, tmp_path):
        misspelt = (("param epsilon_v in", "param epsilom_v in"), ("epsilon=epsilon_v", "epsilon=epsilom_v"))
        (one,) = self.refusal(tmp_path, *misspelt, file="aifqsmc.fz")
        assert one.code == "FZ902"
        assert one.message == "robot.controllers.aifqsmc.epsilon_v: aifqsmc.fz has no param 'epsilon_v'"
        assert one.help == "did you mean 'epsilom_v'?"


@pytest.mark.parametrize("name", ["ackermann", "aifqsmc", *BASELINES, "fcafsmc_law", "omnidirectional", "smc"])
def test_a_step_depends_on_its_arguments_alone(name):
    law = compiled(name)
    arguments, state = np.linspace(0.1, 0.5, len(law.input_names)), np.array(law.start())
    first, second = (law(*arguments, state, dt=DT) for _ in range(2))
    assert state.tolist() == list(law.start())
    assert first[0] == second[0]
    assert np.array_equal(first[1], second[1])
