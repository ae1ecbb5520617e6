"""Lyapunov functions and the drift of gains: hand-made trajectories, and whole runs against numerical derivatives."""

import numpy as np
import pytest

from dwmr import find, measure, read
from dwmr.results import lyapunov
from tests.dwmr.scenarios import by_hand

SCENARIO = read(find("paper-with-limits")).scenario
#: The paper's λ1, λ2, λ3 and P.
SLOPES, P = (0.5, 0.3, 0.7), 0.1


def smc(**columns):
    return by_hand(**{"sigma_v": 0.0, "sigma_omega": 0.0, **columns})


def aifqsmc(**columns):
    names = ("sigma_v", "sigma_omega", "k_h_v", "k_h_omega", "beta_v", "beta_omega", "g_ais_v", "g_ais_omega")
    return by_hand("aifqsmc", **{**dict.fromkeys(names, 0.01), **columns})


class TestSignals:
    def test_v_of_eq_10_is_half_the_square_of_the_sliding_variables(self):
        found = lyapunov.signals(smc(x_e=0.2, y_e=0.3, theta_r_star=0.4, theta=0.1), SCENARIO)
        assert found["surface_v"] == pytest.approx(0.5 * 0.2)
        assert found["surface_omega"] == pytest.approx(0.3 * 0.3 + 0.7 * 0.3)
        assert found["V_10"] == pytest.approx(0.5 * (0.1**2 + 0.3**2))

    def test_the_orientation_in_it_is_wrapped(self):
        found = lyapunov.signals(smc(theta_r_star=3.1, theta=-3.1), SCENARIO)
        assert found["surface_omega"] == pytest.approx(0.7 * (6.2 - 2 * np.pi))

    def test_its_derivative_is_what_control_and_deviation_make_of_it(self):
        run = smc(sigma_v=-0.2, sigma_omega=0.3, v=0.5, v_c=0.4, d_v=0.05, omega=0.1, omega_c=0.3, d_omega=0.02)
        expected = -0.2 * (0.15 + 0.1 - P * -0.2) + 0.3 * (-0.18 - 0.1 - P * 0.3)
        assert lyapunov.signals(run, SCENARIO)["V_dot_10"] == pytest.approx(expected)

    def test_inside_the_layer_the_switching_portion_is_in_proportion(self):
        run = aifqsmc(sigma_v=0.01, beta_v=0.04, g_ais_v=0.6, sigma_omega=-0.1, g_ais_omega=0.5)
        found = lyapunov.signals(run, SCENARIO)
        assert found["switching_v"] == pytest.approx(0.6 * 0.25)
        assert found["switching_omega"] == pytest.approx(-0.5)

    def test_the_gains_part_of_eq_23_is_measured_from_the_largest_gain(self):
        k_h_v = np.array([0.1, 0.25, 0.2])[:, None]
        run = aifqsmc(k_h_v=k_h_v, k_h_omega=np.array([0.1, 0.1, 0.5])[:, None])
        assert lyapunov.surrogate(run, "v") == pytest.approx(0.25)
        found = lyapunov.signals(run, SCENARIO)
        extra = found["V_23"] - found["V_10"]
        assert extra[:, 0] == pytest.approx([0.15**2 / 0.3 + 0.4**2 / 0.8, 0.4**2 / 0.8, 0.05**2 / 0.3])
        rate = found["V_dot_23"] - found["V_dot_10"]
        assert rate[0, 0] == pytest.approx(-0.15 / 0.15 * 0.15 / 0.005)
        assert rate[1, 0] == pytest.approx(-0.4 / 0.4 * 0.4 / 0.005)

    def test_a_law_without_an_adaptive_gain_has_no_eq_23(self):
        found = lyapunov.signals(smc(x_e=1.0), SCENARIO)
        assert "V_23" not in found
        assert "V_dot_23" not in found

    def test_a_law_without_sliding_variables_has_none_at_all(self):
        assert lyapunov.signals(by_hand("mine"), SCENARIO) == {}

    @pytest.mark.parametrize("law", ["smc", "aifqsmc", "fcafsmc", "aifqsmc_without_layer"])
    def test_every_array_has_a_name_and_a_unit(self, run_with_limits, law):
        file, run = run_with_limits(law, "run.horizon=1")
        found = lyapunov.signals(run, file.scenario)
        assert set(found) <= {s.name for s in lyapunov.SIGNALS}
        assert {"V_10", "V_dot_10", "d_0_v", "switching_omega"} <= set(found)
        assert all(values.shape == (201, 3) and np.isfinite(values).all() for values in found.values())

    @pytest.mark.parametrize("law", ["aifqsmc", "fcafsmc"])
    def test_the_printed_derivatives_are_those_of_the_recorded_run(self, run_with_limits, law):
        """Except in avoidance, where the printed error dynamics leave out that the reference drives on."""
        file, run = run_with_limits(law)
        found = lyapunov.signals(run, file.scenario)
        calm = (run["obstacle"] < 0) & (run.t > 5.0)[:, None]
        calm[1:-1] &= calm[:-2] & calm[2:]
        for name in ("10", "23") if law == "aifqsmc" else ("10",):
            measured = np.gradient(found[f"V_{name}"], run.t, axis=0)
            off = np.abs(measured - found[f"V_dot_{name}"])[calm]
            assert np.median(off) < 1e-6
            assert np.quantile(off, 0.95) < 2e-3
            assert np.abs(found[f"V_dot_{name}"][calm]).max() > 0.05

    def test_in_avoidance_the_leaders_v_grows_where_the_printed_derivative_says_it_falls(self, run_with_limits):
        file, run = run_with_limits("aifqsmc")
        found, avoiding = lyapunov.signals(run, file.scenario), run["obstacle"][:-1, 0] >= 0
        assert (np.diff(found["V_10"][:, 0])[avoiding] > 0.0).mean() > 0.7
        assert (found["V_dot_23"][:-1, 0][avoiding] > 0.0).mean() < 0.1


class TestModes:
    @pytest.mark.parametrize("law", ["aifqsmc", "fcafsmc"])
    def test_v_does_not_jump_where_avoidance_begins_or_ends(self, run_with_limits, law):
        """Position and θ*_r are those of one reference, so that one V serves both modes: Eq. (73) adds nothing."""
        file, run = run_with_limits(law)
        found = lyapunov.signals(run, file.scenario)["V_10"][:, 0]
        switches = np.flatnonzero(np.diff(run["obstacle"][:, 0] >= 0))
        assert switches.size >= 6
        assert np.abs(np.diff(found))[switches].max() < 2.0 * np.abs(np.diff(found)).max()
        assert np.abs(np.diff(found))[switches].max() < 0.01 * found.max()


class TestMeasure:
    def test_counts_the_samples_at_which_v_grows(self):
        sigma = np.array([1.0, 1.0, -1.0])[:, None]
        avoids = np.array([[-1], [0], [-1]]) * [1, 0, 0] + [0, -1, -1]
        run = smc(sigma_v=sigma, v=0.5, x_e=np.array([0.0, 0.1, 0.2])[:, None], obstacle=avoids)
        leader = lyapunov.measure(run, SCENARIO)["lyapunov"]["leader"]
        assert leader["V_dot_10_positive"] == pytest.approx(2 / 3)
        assert (leader["in_tracking"], leader["in_avoidance"]) == (0.5, 1.0)
        assert leader["V_10_growing"] == 1.0

    def test_is_empty_where_a_law_has_nothing_of_the_kind(self):
        assert lyapunov.measure(by_hand("mine"), SCENARIO) == {"lyapunov": {}, "drift": {}}
        assert lyapunov.measure(smc(), SCENARIO)["drift"] == {}

    def test_stands_in_the_measures_of_a_run(self, run_with_limits):
        file, run = run_with_limits("aifqsmc", "run.horizon=1")
        result = measure(run, file.scenario)
        assert set(result["lyapunov"]["follower2"]) == {
            "V_dot_10_positive", "V_dot_23_positive", "V_10_growing", "in_tracking", "in_avoidance"
        }  # fmt: skip
        assert set(result["drift"]["leader"]) == {"k_h_v", "k_h_omega", "eta_v", "eta_omega"}

    def test_a_run_of_one_sample_has_measures_too(self):
        one = lyapunov.measure(aifqsmc(samples=1), SCENARIO)
        assert one["drift"]["leader"]["k_h_v"] == {"start": 0.01, "largest": 0.01, "final": 0.01, "growth": 0.0}
        assert one["lyapunov"]["leader"]["V_10_growing"] is None

    @pytest.mark.parametrize("law", ["aifqsmc", "aifqsmc_without_immunity"])
    def test_the_adaptive_gains_of_the_paper_do_not_run_away(self, measured_with_limits, law):
        for gains in measured_with_limits(law)["drift"].values():
            for name in ("k_h_v", "k_h_omega"):
                assert 0.1 <= gains[name]["final"] <= gains[name]["largest"] < 1.0


class TestDrift:
    def test_measures_the_slope_of_the_last_part_only(self):
        t = np.linspace(0.0, 8.0, 801)
        late = t >= 8.0 * (1.0 - lyapunov.LAST_PART)
        values = np.where(late, 5.0 - 0.5 * (t - 6.0), 100.0 * t)
        result = lyapunov.drift(t, values)
        assert result["growth"] == pytest.approx(-0.5)
        assert result["final"] == pytest.approx(4.0)
        assert result["largest"] == pytest.approx(599.0, abs=1.0)
