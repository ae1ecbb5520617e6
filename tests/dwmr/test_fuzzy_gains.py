import pytest
from hypothesis import given
from hypothesis import strategies as st

from dwmr.fuzzy_gains import Rules
from dwmr.scenario_file import find, read
from fuzzyctl.errors import DiagnosticError
from fuzzyctl.shipped import rules_folder

PAPER = find("paper")


def rules(*overrides, folder=None):
    file = read(PAPER, overrides)
    return Rules(file.scenario.rules, (folder,) if folder else (), file.places)


def edited(folder, name, *replacements):
    text = (rules_folder() / name).read_text(encoding="utf-8")
    for old, new in replacements:
        assert old in text
        text = text.replace(old, new, 1)
    (folder / name).write_text(text, encoding="utf-8")
    return folder


def refusal(call):
    with pytest.raises(DiagnosticError) as caught:
        call()
    (one,) = caught.value.diagnostics
    return one


class TestReaction:
    def test_gives_kernel_floor_and_suppression_gain(self):
        f, k_h_min, k_s = rules().reaction("leader", "v", None, None)
        assert (k_h_min, k_s) == (0.1, 0.55)
        assert f(0.0, 0.0) == pytest.approx(0.18)
        assert f(-0.05, -0.9) == pytest.approx(-1.0)

    def test_is_refused_when_a_peak_breaks_the_guarantee(self, tmp_path):
        folder = edited(
            tmp_path, "ais_reaction.fz", ("0.09, 0.18, inf)", "0.09, 0.19, inf)"), ("[-1, f_max]", "[-1, 0.19]")
        )
        one = refusal(lambda: rules(folder=folder).prove_reaction("follower1", "omega", None, None))
        assert one.code == "FZ906"
        assert one.span.source.name == str(tmp_path / "ais_reaction.fz")
        assert "PM = triangle(0.09, 0.19, inf)" in one.span.source.line_text(one.span.line)
        assert "f reaches 0.19" in one.message
        assert "robot follower1, channel omega" in one.facts[0]
        assert "-0.0045" in one.facts[0]

    def test_is_refused_for_one_channel_with_a_stronger_suppression(self):
        checked = rules()
        checked.prove_reaction("leader", "v", None, 0.5)
        one = refusal(lambda: checked.prove_reaction("leader", "omega", None, 0.6))
        assert "0.1 - 0.6 * 0.18 = -0.008" in one.facts[0]

    def test_is_refused_when_nothing_is_asked_of_the_gain(self):
        one = refusal(lambda: rules("rules.ais_reaction.G_min=0").prove_reaction("leader", "v", None, None))
        assert "G_min must be > 1e-12" in one.facts[1]

    @given(st.floats(0.01, 1.0), st.floats(0.01, 2.0))
    def test_is_accepted_exactly_when_the_constraint_holds(self, k_h_min, k_s):
        holds = k_h_min - k_s * 0.18 >= 0.001
        if abs(k_h_min - k_s * 0.18 - 0.001) < 1e-9:
            return
        try:
            rules().prove_reaction("leader", "v", k_h_min, k_s)
            accepted = True
        except DiagnosticError:
            accepted = False
        assert accepted == holds


class TestBoundaryLayer:
    def test_stays_within_the_printed_bounds(self):
        beta = rules().boundary_layer()
        assert beta(0.0) == pytest.approx(0.05)
        assert beta(1.0) == pytest.approx(0.005)

    def test_is_refused_when_it_may_vanish(self, tmp_path):
        folder = edited(
            tmp_path,
            "boundary_layer.fz",
            ("VS = triangle(1e-6, 0.0050", "VS = triangle(-1e-6, 0"),
            ("[0.005, 0.05]", "[0, 0.05]"),
        )
        one = refusal(rules(folder=folder).prove_boundary_layer)
        assert one.code == "FZ907"
        assert "VS" in one.span.source.line_text(one.span.line)


class TestAdaptiveGain:
    def test_starts_at_zero_with_one_consequent_per_rule(self):
        gain, rates, start, lowest, highest = rules().adaptive_gain()
        assert start.tolist() == [0.0] * 7
        assert (lowest, highest) == (-2.0, 2.0)
        assert gain(0.1, start) == 0.0
        out = start.copy()
        rates(0.4, start, out)
        assert out.tolist() == pytest.approx([0, 0, 0, 0, 0, 0, 0.4])


class TestRoles:
    def test_refuse_a_file_with_other_inputs_or_outputs(self):
        one = refusal(lambda: rules('rules.boundary_layer.file="tipper.fz"').prove_boundary_layer())
        assert one.code == "FZ905"
        assert "its inputs are service, food; boundary_layer needs abs_sigma in this order" in one.facts

    def test_refuse_inputs_in_another_order(self, tmp_path):
        text = (rules_folder() / "ais_reaction.fz").read_text(encoding="utf-8")
        swapped = (
            text.replace("input sigma", "input TMP")
            .replace("input dsigma", "input sigma")
            .replace("input TMP", "input dsigma")
        )
        (tmp_path / "ais_reaction.fz").write_text(swapped, encoding="utf-8")
        one = refusal(lambda: rules(folder=tmp_path).prove_reaction("leader", "v", None, None))
        assert "in this order" in one.facts[0]

    def test_name_the_places_searched_for_a_missing_file(self):
        one = refusal(lambda: rules("rules.ais_reaction.file=nope.fz").prove_reaction("leader", "v", None, None))
        assert "does not exist" in one.message
        assert str(rules_folder()) in one.facts[0]

    def test_suggest_the_param_that_was_meant(self):
        one = refusal(lambda: rules("rules.fcafsmc.gama=2").system("fcafsmc", {}))
        assert one.help == "did you mean 'gamma'?"


class TestOverlay:
    def test_takes_a_file_of_the_same_name_and_leaves_the_others(self, tmp_path):
        edited(tmp_path, "boundary_layer.fz")
        overlaid = rules(folder=tmp_path)
        assert overlaid.path("boundary_layer") == tmp_path / "boundary_layer.fz"
        assert overlaid.path("ais_reaction") == rules_folder() / "ais_reaction.fz"
