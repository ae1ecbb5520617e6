import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fuzzyctl
from dwmr import read
from dwmr.control.fuzzy_gains import Rules
from dwmr.sweep.robots import Robots
from fuzzyctl import DiagnosticError
from tests.dwmr.process import here
from tests.dwmr.scenarios import PAPER, diagnostics, mistakes
from tests.dwmr.scenarios import edited_rules as edited
from tests.shipped import rules_folder
from tests.sizes import examples


def rules(*overrides, folder=None):
    file = read(PAPER, overrides)
    return Rules(file.scenario.rules, (folder,) if folder else (), file.places)


def prove(*overrides, folder=None, scenario=PAPER, law="aifqsmc"):
    """Prove a law of a scenario with the gains of all robots."""
    Robots(folder).check(read(scenario, overrides), (law,))


def refusal(*overrides, **more):
    (one,) = diagnostics(lambda: prove(*overrides, **more))
    return one


class TestConstraint:
    """G_AIS > 0 is a claim of the law and of its rule file, proved with the gains of each channel."""

    def test_a_peak_that_breaks_it_is_refused(self, tmp_path):
        folder = edited(
            tmp_path, "ais_reaction.fz", ("0.09, 0.18, inf)", "0.09, 0.19, inf)"), ("[-1, f_max]", "[-1, 0.19]")
        )
        one = refusal(folder=folder)
        assert (one.code, one.span.source.name) == ("FZ402", str(tmp_path / "ais_reaction.fz"))
        assert "k_h_min - k_s * f >= G_min" in one.message
        assert one.facts == ("robot leader", "at sigma = 0, dsigma = 0: k_h_min - k_s * f = -0.0045, G_min = 0.001")

    def test_is_refused_for_one_channel_with_a_stronger_suppression(self):
        prove("robots.leader.controllers.aifqsmc.k_s_v=0.5")
        one = refusal("robots.leader.controllers.aifqsmc.k_s_omega=0.6")
        assert "k_h_min - k_s * f = -0.008" in one.facts[1]

    def test_needs_no_claim_in_the_rule_file(self, tmp_path):
        peak = ("0.09, 0.18, inf)", "0.09, 0.19, inf)"), ("[-1, f_max]", "[-1, 0.19]")
        folder = edited(tmp_path, "ais_reaction.fz", *peak, ("require k_h_min - k_s * f >= G_min", "require f <= 1"))
        found = diagnostics(lambda: prove(folder=folder))
        assert {d.message for d in found} == {f"the guarantee 'g_ais_{c} > 0' does not hold" for c in ("v", "omega")}

    def test_needs_no_claim_in_any_file(self, tmp_path):
        peak = ("0.09, 0.18, inf)", "0.09, 0.25, inf)"), ("[-1, f_max]", "[-1, 0.25]")
        edited(tmp_path, "ais_reaction.fz", *peak, ("require k_h_min - k_s * f >= G_min", "require f <= 1"))
        edited(tmp_path, "boundary_layer.fz")
        edited(tmp_path, "sliding_surface.fz")
        edited(tmp_path, "immune_channel.fz", ("require g_ais > 0\n", ""))
        folder = edited(tmp_path, "aifqsmc.fz", ("require g_ais_v > 0\n", ""), ("require g_ais_omega > 0\n", ""))
        found = diagnostics(lambda: prove(folder=folder))
        assert [d.message.partition("'")[2].partition(" ")[0] for d in found] == ["g_ais_v", "g_ais_omega"]
        assert found[0].span.source.line_text(found[0].span.line).startswith("output g_ais_v")

    ANY = read(PAPER)

    @settings(max_examples=examples(30))
    @given(st.floats(0.01, 1.0), st.floats(0.01, 2.0))
    def test_is_accepted_exactly_when_it_holds(self, k_h_min, k_s):
        holds = k_h_min - k_s * 0.18 >= 0.001
        if abs(k_h_min - k_s * 0.18 - 0.001) < 1e-9:
            return
        gains = f"robots.leader.controllers.aifqsmc={{k_h_min_v = {k_h_min!r}, k_s_v = {k_s!r}}}"
        try:
            prove(gains)
            accepted = True
        except DiagnosticError:
            accepted = False
        assert accepted == holds


class TestBoundaryLayer:
    def test_is_refused_when_it_may_vanish(self, tmp_path):
        folder = edited(
            tmp_path,
            "boundary_layer.fz",
            ("VS = triangle(1e-6, 0.0050", "VS = triangle(-1e-6, 0"),
            ("[0.005, 0.05]", "[0, 0.05]"),
        )
        one = refusal(folder=folder)
        assert one.code == "FZ402"
        assert "beta >= 0.005" in one.message

    def test_is_refused_without_a_claim_in_the_rule_file_too(self, tmp_path, monkeypatch):
        monkeypatch.setattr("fuzzyctl.analysis.prove.TIMEOUT", 1.0)  # which it uses up
        edits = ("VS = triangle(1e-6, 0.0050", "VS = triangle(-1e-6, 0"), ("[0.005, 0.05]", "[0, 0.05]")
        folder = edited(tmp_path, "boundary_layer.fz", *edits, ("require beta >= 0.005", "require beta >= 0"))
        assert diagnostics(lambda: prove(folder=folder))

    def test_is_refused_when_it_is_negative_without_any_claim(self, tmp_path):
        peaks = [("triangle(1e-6, 0.0050", "triangle(-1, -0.01"), ("[0.005, 0.05]", "[-0.01, 0.05]")]
        peaks += [("|  VB  B  M  S  VS", "|  VS  VS  VS  VS  VS")]
        none = [("require beta >= 0.005 within 1e-12\n", ""), ("require decreasing(beta, abs_sigma)\n", "")]
        edited(tmp_path, "boundary_layer.fz", *peaks, *none)
        for name in ("ais_reaction.fz", "immune_channel.fz", "sliding_surface.fz"):
            edited(tmp_path, name)
        folder = edited(tmp_path, "aifqsmc.fz", ("require g_ais_v > 0\n", ""), ("require g_ais_omega > 0\n", ""))
        found = diagnostics(lambda: prove(folder=folder))
        assert [d.message for d in found] == [f"the guarantee 'beta_{c} > 0' does not hold" for c in ("v", "omega")]


class TestGuarantees:
    """What a rule file requires is proved before a run, with the params of each robot and channel."""

    def test_a_swapped_cell_is_refused_with_the_point_that_shows_it(self, tmp_path):
        folder = edited(tmp_path, "ais_reaction.fz", ("NS |  NM  NS  ZO  PS  ZO", "NS |  NM  NS  ZO  ZO  PS"))
        one = refusal(folder=folder)
        assert one.code == "FZ402"
        assert "f(-sigma, -dsigma) == f" in one.message
        assert one.span.source.line_text(one.span.line).startswith("require f(-sigma")
        assert one.facts[0] == "robot leader"
        assert one.facts[1].startswith("at sigma = ")

    def test_values_of_one_channel_count(self, tmp_path):
        folder = edited(
            tmp_path, "ais_reaction.fz", ("require f <= 0 within 1e-12 when", "require k_s <= 0.5 or f <= 0 when")
        )
        weaker = "rules.ais_reaction.k_s=0.5"
        prove(folder=folder)
        edited(tmp_path, "ais_reaction.fz", ("f <= 0 within 1e-12 when abs(sigma) >= 0.03", "k_s * f <= 0.095"))
        prove(weaker, folder=folder)
        assert "k_s * f = 0.099" in refusal("robot.controllers.aifqsmc.k_s_v=0.5", folder=folder).facts[1]

    def test_so_are_those_of_the_adaptive_gain(self, tmp_path):
        folder = edited(tmp_path, "fcafsmc.fz", ("require F <= 2", "require F <= 1.5"))
        one = refusal(folder=folder, law="fcafsmc")
        assert one.code == "FZ402"

    def test_what_is_left_open_is_refused_too(self, tmp_path):
        folder = edited(tmp_path, "boundary_layer.fz", ("beta <= 0.05 within 1e-12", "sqrt(beta * beta) <= 0.05"))
        one = refusal(folder=folder)
        assert "is not proved" in one.message

    def test_equal_ones_are_proved_once(self, tmp_path, monkeypatch):
        proved, prove = [], fuzzyctl.prove
        monkeypatch.setattr(fuzzyctl, "prove", lambda system: proved.append(system.name) or prove(system))
        Robots().check(read(PAPER, ("robot.controllers.aifqsmc.k_s_v=0.5",)), ("aifqsmc",))
        assert sorted(proved) == ["ais_reaction", "ais_reaction", "boundary_layer"]


class TestRoles:
    def test_refuse_a_file_with_other_inputs_or_outputs(self):
        one = refusal('rules.boundary_layer.file="tipper.fz"')
        assert one.code == "FZ905"
        assert "its inputs are service, food; boundary_layer needs abs_sigma in this order" in one.facts

    def test_refuse_inputs_in_another_order(self, tmp_path):
        swap = (("input sigma", "input TMP"), ("input dsigma", "input sigma"), ("input TMP", "input dsigma"))
        folder = edited(tmp_path, "ais_reaction.fz", *swap)
        one = refusal(folder=folder)
        assert "in this order" in one.facts[0]

    def test_name_the_places_searched_for_a_missing_file(self):
        one = refusal("rules.ais_reaction.file=nope.fz")
        assert "does not exist" in one.message
        assert str(rules_folder()) in one.facts[0]

    def test_suggest_the_param_that_was_meant(self):
        one = refusal("rules.fcafsmc.gama=2", law="fcafsmc")
        assert one.help == "did you mean 'rules.fcafsmc.gamma'?"


def test_a_folder_replaces_files_of_the_same_name_and_leaves_the_others(tmp_path):
    edited(tmp_path, "boundary_layer.fz")
    overlaid = rules(folder=tmp_path)
    assert overlaid.files.path("boundary_layer") == tmp_path / "boundary_layer.fz"
    assert overlaid.files.path("ais_reaction") == rules_folder() / "ais_reaction.fz"


@pytest.mark.parametrize("section", ["{}", '{file=""}', '{file="x",k_s="2"}', '{file="x",k_s=nan}'])
def test_a_section_needs_a_file_and_finite_params(section):
    assert mistakes(PAPER, f"rules.ais_reaction={section}")


class TestGains:
    """Gains out of the ranges that the law declares are refused where they are given."""

    @pytest.mark.parametrize("name", ["k_s", "k_h_min"])
    def test_of_the_scenario(self, name):
        one = refusal(f"rules.ais_reaction.{name}=-0.1")
        assert (one.code, one.message) == ("FZ904", f"rules.ais_reaction.{name} must be in (0, inf), got -0.1")
        assert one.file == f"--set rules.ais_reaction.{name}=-0.1"

    def test_of_the_rule_file(self, tmp_path):
        text = PAPER.read_text(encoding="utf-8")
        line = next(one for one in text.splitlines() if one.startswith("k_s = "))
        (tmp_path / "mine.toml").write_text(text.replace(line + "\n", ""), encoding="utf-8")
        edited(tmp_path, "ais_reaction.fz", ("k_s     = 0.55", "k_s     = -0.55"), ("[-1, f_max]", "[-1, 0.18]"))
        one = refusal(scenario=tmp_path / "mine.toml", folder=tmp_path)
        assert one.message == "param k_s must be in (0, inf), got -0.55"
        assert one.span.source.line_text(one.span.line).startswith("param k_s")

    @pytest.mark.parametrize("channel", ["v", "omega"])
    def test_of_a_channel(self, channel):
        one = refusal(f"robots.leader.controllers.aifqsmc.k_s_{channel}=-0.5")
        assert one.message.startswith(f"robots.leader.controllers.aifqsmc.k_s_{channel} must be in (0, inf)")


class TestCoverage:
    HOLE = (("PS = triangle(0, 0.015, 0.030)", "PS = triangle(0.015, 0.016, 0.030)"),)

    def test_a_hole_is_refused_at_its_line(self, tmp_path):
        folder = edited(tmp_path, "ais_reaction.fz", *self.HOLE)
        one = refusal(folder=folder)
        assert one.code == "FZ401"
        assert "output f" in one.span.source.line_text(one.span.line)

    @pytest.mark.parametrize("word", ["nan", "error"])
    def test_a_hole_filled_with_no_number_is_refused(self, tmp_path, word):
        folder = edited(tmp_path, "ais_reaction.fz", *self.HOLE, ("[-1, f_max]", f"[-1, f_max] else {word}"))
        one = refusal(folder=folder)
        assert one.code == "FZ401"
        assert f"'else {word}' is not a number" in one.message

    @pytest.mark.parametrize("word", ["", " else nan"])
    def test_coverage_that_is_not_decided_is_refused(self, tmp_path, monkeypatch, word):
        monkeypatch.setattr("fuzzyctl.analysis.coverage.coverage.COVERAGE", 10)
        folder = edited(tmp_path, "boundary_layer.fz", ("[0.005, 0.05]", f"[0.005, 0.05]{word}"))
        one = refusal(folder=folder)
        assert (one.code, one.severity) == ("FZ407", "error")
        assert "output beta" in one.span.source.line_text(one.span.line)
        assert one.facts == ("it takes more work than a check does", "a control law needs a number everywhere")

    def test_an_else_with_a_number_replaces_the_decision(self, tmp_path, monkeypatch):
        monkeypatch.setattr("fuzzyctl.analysis.coverage.coverage.COVERAGE", 10)
        edited(tmp_path, "boundary_layer.fz", ("[0.005, 0.05]", "[0.005, 0.05] else 0.005"))
        folder = edited(tmp_path, "ais_reaction.fz", ("[-1, f_max]", "[-1, f_max] else 0"))
        prove(folder=folder)

    def test_a_hole_filled_with_a_number_is_none(self, tmp_path):
        # The hole lies on one side only, which the guarantee of symmetry would not allow.
        edits = (
            *self.HOLE,
            ("[-1, f_max]", "[-1, f_max] else 0"),
            ("require f(-sigma, -dsigma) == f", "require f <= 9"),
        )
        folder = edited(tmp_path, "ais_reaction.fz", *edits)
        prove(folder=folder)

    def test_a_hole_that_a_param_opens_is_refused(self, tmp_path):
        folder = edited(
            tmp_path,
            "boundary_layer.fz",
            ("and         product", "and         product\nparam edge = 0.0162"),
            ("VS = triangle(-inf, 0.0050, 0.0162)", "VS = triangle(-inf, 0.0050, edge)"),
            ("S  = triangle(0.0050, 0.0162, 0.0275)", "S  = triangle(0.0100, 0.0162, 0.0275)"),
        )
        prove(folder=folder)
        one = refusal("rules.boundary_layer.edge=0.009", folder=folder)
        assert one.code == "FZ401"

    def test_warnings_are_kept_once(self, tmp_path):
        folder = edited(tmp_path, "ais_reaction.fz", ("PM  PS  ZO\n", "PS  PS  ZO\n"))
        assert here("check", "paper", "--rules", folder).stderr.count("warning[FZ208]") == 1


class TestDerivedParams:
    def test_cannot_be_parted_from_what_they_are_computed_from(self):
        one = refusal("rules.ais_reaction.f_max=0.1")
        assert "computes f_max from k_h_min, G_min, k_s" in one.message


class TestFolder:
    def test_without_any_of_the_files_is_refused(self, tmp_path):
        edited(tmp_path, "ais_reaction.fz")
        (tmp_path / "ais_reaction.fz").rename(tmp_path / "ais_reactoin.fz")
        (one,) = diagnostics(lambda: rules().files.require_use_of(tmp_path))
        gains = "ais_reaction.fz, boundary_layer.fz, fcafsmc.fz"
        assert one.facts[0].startswith(f"looked for {gains}, ackermann.fz, aifqsmc.fz")
        assert one.help == "did you mean 'ais_reaction.fz'?"

    def test_with_one_of_them_is_taken_and_near_misses_are_warned_of(self, tmp_path):
        edited(tmp_path, "ais_reaction.fz")
        edited(tmp_path, "boundary_layer.fz")
        (tmp_path / "boundary_layer.fz").rename(tmp_path / "boundery_layer.fz")
        rules().files.require_use_of(tmp_path)
        (one,) = rules().files.near_misses(tmp_path)
        assert one.help == "did you mean 'boundary_layer.fz'?"
