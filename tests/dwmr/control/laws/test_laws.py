import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dwmr.control import laws
from dwmr.control.fuzzy_gains import Rules
from dwmr.control.sliding import equivalent_control, sliding_variables
from dwmr.core.interfaces import TrackingError
from dwmr.core.jit import first_class, first_class_functions
from dwmr.scenario.file import find, read
from dwmr.simulation.preflight import settings_of

FILE = read(find("paper"))
RULES = Rules(FILE.scenario.rules, (), FILE.places)
SLOPES = (0.5, 0.3, 0.7)
DT = 0.005


def error(x_e=0.1, y_e=-0.2, theta=0.3):
    return TrackingError(x_e, y_e, theta, 0.6, 0.05, 0.1, 0.4)


class Bench:
    """A control law of one robot, stepped by hand."""

    def __init__(self, name):
        self.module = laws.find(name)
        _, own = laws.table(FILE.scenario.robots["leader"].controllers, name)
        law = self.module.init(own, RULES, "leader")
        self.gains, self.state, self.kernels = law
        self.signals = np.zeros(len(self.module.SIGNALS))

    def step(self, tracking):
        after = self.state.copy()
        kernels = tuple(first_class(k) for k in self.kernels)
        with first_class_functions():
            command = self.module.step(tracking, DT, self.gains, self.state, kernels, after, self.signals)
        before, self.state = self.state, after
        return command, before

    def __getitem__(self, name):
        return self.signals[[s.name for s in self.module.SIGNALS].index(name)]


class TestNames:
    def test_are_the_files_of_the_folder(self):
        assert laws.names() == (
            "aifqsmc",
            "aifqsmc_without_adaptation",
            "aifqsmc_without_immunity",
            "aifqsmc_without_layer",
            "fcafsmc",
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
        file = read(find("paper"), overrides)
        assert settings_of(file, "leader", "aifqsmc_without_layer").lambda_1 == 1.0
        assert settings_of(file, "leader", "aifqsmc_without_adaptation").lambda_1 == 0.5

    def test_a_law_without_gains_is_missing_under_its_own_name(self):
        assert laws.table(FILE.scenario.robots["leader"].controllers, "mine") == ("mine", None)


class TestSmc:
    def test_adds_constant_switching_and_reaching_to_the_equivalent_control(self):
        bench = Bench("smc")
        bench.gains[3:] = 0.1, 0.2, 0.3, 0.4
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

    @pytest.mark.parametrize(("index", "channel"), [(4, "linear"), (9, "angular")])
    def test_reports_a_gain_that_is_not_positive(self, index, channel):
        bench = Bench("aifqsmc")
        bench.gains[index] = 10.0  # a suppression gain that no proof would have let through
        (_, _, fault), _ = bench.step(error(0.0, 0.0, 0.0))
        assert bench.module.FAULTS[fault] == f"G_AIS of the {channel} channel is not positive"

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
        bench = Bench("aifqsmc")
        bench.gains[6] = bench.gains[11] = 500.0  # an adaptation so strong that one period would go far below
        for _ in range(20):
            bench.step(error(0.12, 0.0, 0.05))
            assert min(bench.state[2], bench.state[3]) >= 0.1

    def test_signals_have_the_unit_of_their_channel(self):
        units = {s.name: s.unit for s in laws.find("aifqsmc").SIGNALS}
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

    def test_chatter_without_their_part_as_the_paper_says(self, measured):
        whole, bare = (measured(law, "run.horizon=60") for law in ("aifqsmc", "aifqsmc_without_layer"))
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
        assert bench.state[:7].sum() == pytest.approx(DT * sigma_v)
        assert bench.state[7:].sum() == pytest.approx(DT * sigma_omega)

    @settings(max_examples=20, deadline=None)
    @given(st.lists(st.tuples(*[st.floats(-20.0, 20.0)] * 3), min_size=1, max_size=30))
    def test_consequents_and_gain_stay_in_their_range(self, sequence):
        bench = Bench("fcafsmc")
        bench.state[:] = 1.99
        for values in sequence:
            bench.step(error(*values))
            assert np.abs(bench.state).max() <= 2.0
            assert max(abs(bench["f_v"]), abs(bench["f_omega"])) <= 2.0


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
