"""The shipped control laws, as text: stepped by hand, and against the paper's matrices."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fuzzyctl
from dwmr.control import laws
from dwmr.control.fuzzy_gains import Rules
from dwmr.control.law_text import OFFERED
from dwmr.core.interfaces import TrackingError
from dwmr.core.jit import first_class, first_class_functions
from dwmr.scenario.file import find, read
from dwmr.simulation.preflight import settings_of
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.support.shipped import rules_folder

FILE = read(find("paper-with-limits"))
RULES = Rules(FILE.scenario.rules, (), FILE.places)
SLOPES = (0.5, 0.3, 0.7)
DT = 0.005
small = st.floats(-1.5, 1.5)


def law(name, rules=RULES):
    return laws.find(name, Path("nowhere"), rules)


def error(x_e=0.1, y_e=-0.2, theta=0.3, drift=(0.6, 0.05, 0.1), d=0.4):
    return TrackingError(x_e, y_e, theta, *drift, d, theta, 0.0, 0.0, 0.0, 0.0, 0.0)


def surface(e, slopes=SLOPES):
    """Return B_σ of Eq. (8), without its guard, and σ of Eq. (7)."""
    l1, l2, l3 = slopes
    matrix = np.array([[-l1, l1 * e.y_e], [0.0, -(l2 * (e.d + e.x_e) + l3)]])
    return matrix, np.array([l1 * e.x_e, l2 * e.y_e + l3 * e.theta_e_star])


def sliding_variables(e, *slopes):
    matrix, sigma = surface(e, slopes)
    return tuple(matrix.T @ sigma)


def equivalent_control(e, *slopes):
    matrix, _ = surface(e, slopes)
    return tuple(-np.linalg.solve(matrix, [slopes[0] * e.drift_x, slopes[1] * e.drift_y + slopes[2] * e.drift_theta]))


class Bench:
    """A control law of one robot, stepped by hand."""

    def __init__(self, name, **gains):
        self.module = law(name)
        _, own = laws.table(FILE.scenario.robots["leader"].controllers, name)
        made = self.module.init((own or self.module.Settings()).model_copy(update=gains), RULES, "leader")
        self.gains, self.state, self.kernels = made
        self.signals = np.zeros(len(self.module.SIGNALS))
        step = self.module.assembled.step("numba")
        self.kept = {n: len(step.output_names) + k for k, n in enumerate(step.state_names)}

    def step(self, tracking):
        after = self.state.copy()
        kernels = tuple(first_class(k) for k in self.kernels)
        with first_class_functions():
            command = self.module.step(tracking, DT, self.gains, self.state, kernels, after, self.signals)
        before, self.state = self.state, after
        return command, before

    def consequents(self, channel):
        """Return the positions of the consequents of one channel."""
        return [at for name, at in self.kept.items() if name.startswith(f"push_{channel}.F")]

    def __getitem__(self, name):
        return self.signals[[s.name for s in self.module.SIGNALS].index(name)]


class TestSurface:
    STEP = fuzzyctl.compile(fuzzyctl.load(rules_folder() / "sliding_surface.fz", block=fuzzyctl.Controller), "python")

    def of(self, e):
        return self.STEP(*e[:7], [], dt=DT)[0]

    @given(small, small, small, st.sampled_from([0.1, 0.4]))
    def test_sliding_variables_are_the_transposed_input_matrix_times_sigma(self, x_e, y_e, theta, d):
        e = error(x_e, y_e, theta, d=d)
        assert self.of(e)[:2] == pytest.approx(sliding_variables(e, *SLOPES), abs=1e-12)

    @given(small, small, small, small, small, small)
    def test_equivalent_control_holds_the_surfaces_still(self, x_e, y_e, theta, drift_x, drift_y, drift_theta):
        l1, l2, l3 = SLOPES
        _, _, v, omega = self.of(error(x_e, y_e, theta, (drift_x, drift_y, drift_theta), d=0.1))
        # Eq. (6) with these velocities, and sigma of Eq. (7)
        assert l1 * (drift_x - v + y_e * omega) == pytest.approx(0.0, abs=1e-9)
        assert l2 * (drift_y - (0.1 + x_e) * omega) + l3 * (drift_theta - omega) == pytest.approx(0.0, abs=1e-9)

    @given(st.floats(-10.0, 10.0))
    def test_divisor_keeps_its_sign_and_a_least_size(self, x_e):
        omega = self.of(error(x_e, 0.0, 0.0, (0.0, 0.0, 1.0), d=0.1))[3]
        plain = 0.3 * (0.1 + x_e) + 0.7
        divisor = 0.7 / omega
        assert divisor == pytest.approx(plain if abs(plain) >= 0.05 else np.copysign(0.05, plain))

    def test_takes_what_the_formation_offers(self):
        assert tuple(OFFERED) == TrackingError._fields
        for text in ("smc", "aifqsmc", "fcafsmc"):
            assert {i.name: i.unit for i in law(text).text.controller.inputs}.items() <= OFFERED.items()


class TestNames:
    def test_are_those_of_the_shipped_texts_and_their_ablations(self):
        assert laws.names() == (
            "ackermann",
            "aifqsmc",
            "aifqsmc_without_adaptation",
            "aifqsmc_without_immunity",
            "aifqsmc_without_layer",
            "fcafsmc",
            "omnidirectional",
            "smc",
        )


class TestGroup:
    def test_all_are_the_laws_that_stand_on_their_own(self):
        assert laws.group("all") == ("aifqsmc", "fcafsmc", "smc")

    def test_ablations_come_with_the_law_they_are_taken_from(self):
        parts = ("adaptation", "immunity", "layer")
        assert laws.group("ablations") == ("aifqsmc", *(f"aifqsmc_without_{p}" for p in parts))

    def test_a_name_stands_for_itself(self):
        assert laws.group("smc") == ("smc",)


class TestTable:
    def test_an_ablation_has_the_gains_of_its_law(self):
        tables = FILE.scenario.robots["leader"].controllers
        assert laws.table(tables, "aifqsmc_without_layer") == ("aifqsmc", tables.aifqsmc)

    def test_unless_the_scenario_gives_it_its_own(self):
        usual = FILE.scenario.robots["leader"].controllers.aifqsmc.model_dump(exclude_none=True)
        own = {**usual, "lambda_1": 1.0}
        overrides = [f"robot.controllers.aifqsmc_without_layer.{key}={value}" for key, value in own.items()]
        file = read(find("paper-with-limits"), overrides)
        for name, slope in (("aifqsmc_without_layer", 1.0), ("aifqsmc_without_adaptation", 0.5)):
            assert settings_of(file, "leader", name, law(name)).lambda_1 == slope

    def test_a_law_without_gains_is_missing_under_its_own_name(self):
        assert laws.table(FILE.scenario.robots["leader"].controllers, "mine") == ("mine", None)


class TestSmc:
    def test_adds_constant_switching_and_reaching_to_the_equivalent_control(self):
        bench = Bench("smc", p_v=0.1, p_omega=0.2, g_v=0.3, g_omega=0.4)
        (v, omega, fault), _ = bench.step(error(y_e=0.4))
        sigma_v, sigma_omega = sliding_variables(error(y_e=0.4), *SLOPES)
        v_eq, omega_eq = equivalent_control(error(y_e=0.4), *SLOPES)
        assert v == pytest.approx(v_eq - 0.3 * np.sign(sigma_v) - 0.1 * sigma_v)
        assert omega == pytest.approx(omega_eq - 0.4 * np.sign(sigma_omega) - 0.2 * sigma_omega)
        assert fault == 0

    def test_rests_on_the_surface(self):
        (v, omega, _), _ = Bench("smc").step(error(0.0, 0.0, 0.0))
        assert (v, omega) == pytest.approx(equivalent_control(error(0.0, 0.0, 0.0), *SLOPES))


class TestAifqsmc:
    def test_starts_with_the_floor_gain_and_no_rate(self):
        bench = Bench("aifqsmc")
        bench.step(error())
        assert bench["k_h_v"] == bench["k_h_omega"] == 0.1
        assert bench["sigma_dot_v"] == bench["sigma_dot_omega"] == 0.0

    def test_takes_the_backward_difference_afterwards(self):
        bench = Bench("aifqsmc")
        bench.step(error(x_e=0.1))
        bench.step(error(x_e=0.11))
        assert bench["sigma_dot_v"] == pytest.approx(-0.25 * 0.01 / DT)

    def test_follows_its_law(self):
        bench = Bench("aifqsmc")
        (v, omega, _), _ = bench.step(error(x_e=0.01))
        v_eq, omega_eq = equivalent_control(error(x_e=0.01), *SLOPES)
        for command, equivalent, channel in ((v, v_eq, "v"), (omega, omega_eq, "omega")):
            sigma, beta = bench[f"sigma_{channel}"], bench[f"beta_{channel}"]
            gain = bench[f"k_h_{channel}"] - 0.55 * bench[f"f_{channel}"]
            assert bench[f"g_ais_{channel}"] == pytest.approx(gain)
            assert command == pytest.approx(equivalent - gain * np.clip(sigma / beta, -1, 1) - 0.1 * sigma)

    def test_channels_have_their_own_adaptation(self):
        bench = Bench("aifqsmc")
        for _ in range(3):
            bench.step(error(x_e=1.0, y_e=1.0))
        assert bench["k_h_v"] == pytest.approx(0.1 + DT * 0.1 + DT * 0.15 * 0.25)
        assert bench["k_h_omega"] == pytest.approx(0.1 + DT * 0.1 + DT * 0.40 * abs(bench["sigma_omega"]))

    @settings(max_examples=50, deadline=None)
    @given(st.lists(st.tuples(*[st.floats(-3.0, 3.0)] * 3), min_size=1, max_size=30))
    def test_gain_and_layer_stay_positive_whatever_the_errors_do(self, sequence):
        bench = Bench("aifqsmc")
        for values in sequence:
            (_, _, fault), _ = bench.step(error(*values))
            assert fault == 0
            for channel in ("v", "omega"):
                assert bench[f"g_ais_{channel}"] >= 0.001 - 1e-12
                assert 0.005 <= bench[f"beta_{channel}"] <= 0.05
                assert -1.0 <= bench[f"f_{channel}"] <= 0.18
                assert bench[f"k_h_{channel}"] >= 0.1

    def test_blames_no_guarantee_for_undefined_errors(self):
        (v, _, fault), _ = Bench("aifqsmc").step(error(x_e=float("nan")))
        assert np.isnan(v)
        assert fault == 0

    def test_channels_have_their_own_layer(self):
        tracking = error(x_e=0.4, y_e=0.0, theta=0.02)
        bench = Bench("aifqsmc")
        (v, omega, _), _ = bench.step(tracking)
        v_eq, omega_eq = equivalent_control(tracking, *SLOPES)
        sigma_v, sigma_omega = sliding_variables(tracking, *SLOPES)
        assert abs(sigma_omega) < bench["beta_omega"]
        assert bench["beta_omega"] > 2.0 * bench["beta_v"]
        assert omega == pytest.approx(
            omega_eq - bench["g_ais_omega"] * sigma_omega / bench["beta_omega"] - 0.1 * sigma_omega
        )
        assert v == pytest.approx(v_eq - bench["g_ais_v"] * np.sign(sigma_v) - 0.1 * sigma_v)

    def test_gain_never_falls_below_its_floor(self):
        # an adaptation so strong that one period would go far below
        bench = Bench("aifqsmc", gamma_v=500.0, gamma_omega=500.0)
        for _ in range(20):
            bench.step(error(0.12, 0.0, 0.05))
            assert min(bench.state[bench.kept["v.k_h"]], bench.state[bench.kept["omega.k_h"]]) >= 0.1

    def test_signals_have_the_unit_of_their_channel(self):
        units = {s.name: s.unit for s in law("aifqsmc").SIGNALS}
        assert (units["g_ais_v"], units["g_ais_omega"]) == ("m/s", "rad/s")
        assert (units["sigma_v"], units["sigma_omega"]) == ("m", "rad")


class TestAblations:
    """Each differs from AIFQSMC by its part, and by nothing else."""

    def test_without_adaptation_the_gain_stays_at_its_floor(self):
        whole, bench = Bench("aifqsmc"), Bench("aifqsmc_without_adaptation")
        first, _ = bench.step(error(x_e=1.0))
        assert first == whole.step(error(x_e=1.0))[0]
        for _ in range(5):
            bench.step(error(x_e=1.0))
            whole.step(error(x_e=1.0))
        assert bench["k_h_v"] == bench["k_h_omega"] == 0.1
        assert whole["k_h_v"] > 0.1
        assert bench["f_v"] == whole["f_v"]

    def test_without_a_layer_the_sign_switches(self):
        bench, tracking = Bench("aifqsmc_without_layer"), error(x_e=0.01, y_e=0.0, theta=0.02)
        (v, omega, fault), _ = bench.step(tracking)
        sigma_v, sigma_omega = sliding_variables(tracking, *SLOPES)
        v_eq, omega_eq = equivalent_control(tracking, *SLOPES)
        assert v == pytest.approx(v_eq - bench["g_ais_v"] * np.sign(sigma_v) - 0.1 * sigma_v)
        assert omega == pytest.approx(omega_eq - bench["g_ais_omega"] * np.sign(sigma_omega) - 0.1 * sigma_omega)
        assert fault == 0

    def test_without_a_layer_the_control_rests_on_the_surface(self):
        (v, omega, fault), _ = Bench("aifqsmc_without_layer").step(error(0.0, 0.0, 0.0))
        assert (v, omega) == pytest.approx(equivalent_control(error(0.0, 0.0, 0.0), *SLOPES))
        assert fault == 0

    def test_without_immunity_the_gain_is_the_adaptive_one(self):
        bench, whole = Bench("aifqsmc_without_immunity"), Bench("aifqsmc")
        bench.step(error())
        whole.step(error())
        assert bench["f_v"] == bench["f_omega"] == 0.0
        assert bench["g_ais_v"] == bench["k_h_v"]
        assert whole["g_ais_v"] != whole["k_h_v"]
        assert bench["beta_v"] == whole["beta_v"]

    def test_eta_is_the_share_of_suppression_in_the_gain(self):
        bench = Bench("aifqsmc")
        for _ in range(3):
            bench.step(error(x_e=1.0))
        assert bench["g_ais_v"] == pytest.approx(bench["k_h_v"] * (1.0 - bench["eta_v"] * bench["f_v"]))

    def test_chatter_without_their_part_as_the_paper_says(self, measured_with_limits):
        whole, bare = (measured_with_limits(law, "run.horizon=60") for law in ("aifqsmc", "aifqsmc_without_layer"))
        for robot in whole["chattering"]:
            assert bare["chattering"][robot]["v"] > 2.0 * whole["chattering"][robot]["v"]


class TestFcafsmc:
    def test_begins_without_fuzzy_gain(self):
        (v, omega, _), _ = Bench("fcafsmc").step(error())
        sigma_v, sigma_omega = sliding_variables(error(), *SLOPES)
        v_eq, omega_eq = equivalent_control(error(), *SLOPES)
        assert (v, omega) == pytest.approx((v_eq - 0.1 * sigma_v, omega_eq - 0.1 * sigma_omega))

    def test_consequents_grow_with_sigma_in_proportion_to_their_rules(self):
        bench = Bench("fcafsmc")
        bench.step(error())
        sigma_v, sigma_omega = sliding_variables(error(), *SLOPES)
        assert bench.state[bench.consequents("v")].sum() == pytest.approx(DT * sigma_v)
        assert bench.state[bench.consequents("omega")].sum() == pytest.approx(DT * sigma_omega)

    @settings(max_examples=20, deadline=None)
    @given(st.lists(st.tuples(*[st.floats(-20.0, 20.0)] * 3), min_size=1, max_size=30))
    def test_consequents_and_gain_stay_in_their_range(self, sequence):
        bench = Bench("fcafsmc")
        consequents = bench.consequents("v") + bench.consequents("omega")
        assert len(consequents) == 14
        bench.state[consequents] = 1.99
        for values in sequence:
            bench.step(error(*values))
            assert np.abs(bench.state[consequents]).max() <= 2.0
            assert max(abs(bench["f_v"]), abs(bench["f_omega"])) <= 2.0


class TestEditedText:
    """What the text of a law requires is proved before a run, with the gains of each robot."""

    def rules(self, folder, old, new):
        texts = {p.name: p.read_text(encoding="utf-8") for p in rules_folder().glob("*.fz")}
        assert sum(old in text for text in texts.values()) == 1
        for name, text in texts.items():
            (folder / name).write_text(text.replace(old, new, 1), encoding="utf-8")
        return Rules(FILE.scenario.rules, (folder,), FILE.places)

    def refusal(self, rules):
        with pytest.raises(DiagnosticError) as caught:
            law("aifqsmc", rules).prove(FILE.scenario.robots["leader"].controllers.aifqsmc, rules, "leader")
        return caught.value.diagnostics

    def test_an_adaptation_that_may_leave_its_floor_is_refused(self, tmp_path, monkeypatch):
        monkeypatch.setattr("fuzzyctl.analysis.prove.TIMEOUT", 0.5)  # it is all used up
        found = self.refusal(self.rules(tmp_path, "max(k_h_min, k_h + dt * adaptation * rate)", "k_h + dt * rate"))
        assert {d.code for d in found} == {"FZ402"}
        assert found[0].span.source.name == str(tmp_path / "aifqsmc.fz")
        assert found[0].facts[0] == "robot leader"

    def test_another_law_with_the_same_guarantee_is_accepted(self, tmp_path):
        rules = self.rules(tmp_path, "pull * sign(size - epsilon)", "pull - 0.01 * k_h")
        law("aifqsmc", rules).prove(FILE.scenario.robots["leader"].controllers.aifqsmc, rules, "leader")

    def test_a_gain_that_the_text_does_not_have_is_named_with_its_key(self, tmp_path):
        text = "param epsilon_v in [0, inf)     = 0.05"
        rules = self.rules(tmp_path, text, text.replace("epsilon_v", "epsilom_v"))
        (tmp_path / "aifqsmc.fz").write_text(
            (tmp_path / "aifqsmc.fz").read_text(encoding="utf-8").replace("epsilon=epsilon_v", "epsilon=epsilom_v"),
            encoding="utf-8",
        )
        (one,) = self.refusal(rules)
        assert one.code == "FZ902"
        assert one.message == "robot.controllers.aifqsmc.epsilon_v: aifqsmc.fz has no param 'epsilon_v'"
        assert one.help == "did you mean 'epsilom_v'?"


@pytest.mark.parametrize("name", laws.names())
class TestEveryLaw:
    def test_step_changes_nothing_but_its_results(self, name):
        bench = Bench(name)
        gains, state = bench.gains.copy(), bench.state.copy()
        _, before = bench.step(error())
        assert np.array_equal(before, state)
        assert np.array_equal(bench.gains, gains)

    def test_same_inputs_give_same_results(self, name):
        first, second = Bench(name), Bench(name)
        assert first.step(error())[0] == second.step(error())[0]
        assert np.array_equal(first.state, second.state)
