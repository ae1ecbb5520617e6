"""`.fis` files as MATLAB, Octave and fuzzylite write them, and as people break them."""

import math
from pathlib import Path

import pytest

from fuzzyctl.diagnostics.diagnostic import render_all
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.explain.trace import trace
from fuzzyctl.expr import Number
from fuzzyctl.formats.common.report import Findings
from fuzzyctl.formats.fis import read, write
from fuzzyctl.formats.fis.sections import vector
from fuzzyctl.formats.fis.shapes import written
from fuzzyctl.formats.fz import dumps
from fuzzyctl.loading.load import load, loads
from fuzzyctl.model.method import Defuzzifier
from fuzzyctl.model.profiles import profile
from fuzzyctl.model.rule import And, Is, Or
from fuzzyctl.model.variable import Hold

SAMPLES = Path(__file__).parent.parent / "samples"
TIPPER = (SAMPLES / "tipper.fis").read_text(encoding="utf-8")


def system(text):
    found, diagnostics = read(SourceText("t.fis", text))
    assert found is not None, render_all(diagnostics)
    return found


def said(text):
    """Return what is said of a text as (code, severity, line, column)."""
    _, diagnostics = read(SourceText("t.fis", text))
    return [(d.code, d.severity, d.span.line if d.span else 0, d.span.column if d.span else 0) for d in diagnostics]


def message(text):
    """Return the only diagnostic of a text, rendered."""
    _, diagnostics = read(SourceText("t.fis", text))
    assert len(diagnostics) == 1, render_all(diagnostics)
    return render_all(diagnostics)


def changed(old, new):
    assert old in TIPPER
    return TIPPER.replace(old, new)


class TestMatlab:
    def test_the_method_is_that_of_the_file_with_the_samples_of_matlab(self):
        method = system(TIPPER).method
        assert (method.conjunction, method.disjunction) == ("min", "max")
        assert (method.implication, method.aggregation) == ("min", "max")
        assert method.defuzzifier == Defuzzifier(resolution=101, grid="endpoints", rule="plain")
        assert method.semantics == profile("matlab").semantics

    def test_names_become_identifiers_with_the_names_of_the_file_as_labels(self):
        text = TIPPER.replace("'service'", "'Age_(years) it''s'").replace("'tipper'", "'simple-dimmer'")
        found = system(text.replace("'poor'", "'very poor'"))
        assert [(v.name, v.label) for v in found.inputs] == [("Age_years_it_s", "Age_(years) it's"), ("food", "")]
        assert (found.name, found.title) == ("simple_dimmer", "simple-dimmer")
        assert said(text) == [("FZ604", "hint", 1, 1)]
        assert loads(dumps(found)).inputs[0].terms[0].name == "very_poor"
        assert "Name='Age_(years) it''s'" in write(found)[0]

    def test_inputs_extrapolate_and_outputs_have_the_middle_where_no_rule_fires(self):
        found = system(TIPPER)
        assert all(v.extrapolate for v in found.inputs)
        assert found.outputs[0].otherwise == "midpoint"

    def test_rules_name_terms_by_number(self):
        first, second, third = system(TIPPER).rules
        assert first.antecedent == Or(
            operands=(Is(variable="service", term="poor"), Is(variable="food", term="rancid"))
        )
        assert second.antecedent == Is(variable="service", term="good")
        assert third.consequents[0].term == "generous"

    def test_a_minus_is_not_and_parentheses_hold_the_weight(self):
        rule = system(changed("1 1, 1 (1) : 2", "-1 -2, -1 (0.25) : 1")).rules[0]
        assert isinstance(rule.antecedent, And)
        assert [o.hedges for o in rule.antecedent.operands] == [("not",), ("not",)]
        assert rule.consequents[0].hedges == ("not",)
        assert rule.weight == Number(0.25)

    @pytest.mark.parametrize(("connective", "hedges"), [(1, ("any",)), (2, ("not", "any"))])
    def test_a_rule_without_conditions_holds_everywhere_by_and_and_nowhere_by_or(self, connective, hedges):
        rule = system(changed("2 0, 2 (1) : 1", f"0 0, 2 (1) : {connective}")).rules[1]
        assert isinstance(rule.antecedent, Is)
        assert rule.antecedent.hedges == hedges

    @pytest.mark.parametrize(
        ("old", "new"),
        [
            ("[System]\n", "% $Revision: 1.2 $\n# another comment\n\n[System]\n"),
            ("Name='tipper'", "Name = 'tipper'   % a comment"),
            ("Name='tipper'", 'Name="tipper"'),
            ("Name='tipper'", "Name=\u2018tipper\u2019"),
            ("Name='tipper'", "Name=tipper"),
            ("Name='tipper'", "name='tipper';"),
            ("Version=2.0\n", ""),
            ("Version=2.0", "Version='1.0'"),
            ("[Input1]", "[input1]"),
            ("NumMFs=3", "NumMFs= 3 "),
            ("Range=[0 10]", "Range = [ 0, 10 ]"),
            ("Range=[0 30]", "Range=[0;30]"),
            ("'poor':'gaussmf',[1.5 0]", "'poor' : 'gaussmf' , [ 1.5,0 ]"),
            ("'poor':'gaussmf',[1.5 0]", "'poor':'gaussmf',[1.5 0 ]  # wide"),
            ("'poor':'gaussmf',[1.5 0]", "'poor':'GaussMF',[3/2 0*pi]"),
            ("[7 9 10 10]", "[7 9 10 10];"),
            ("1 1, 1 (1) : 2", "1.000 1.000 , 1.000 (1.000) : 2 "),
            ("1 1, 1 (1) : 2", "  1   1,1(1):2;"),
            ("[Rules]\n", "[Rules]\n\n% by service\n"),
            ("[Rules]\n", "[ Rules ]\n"),
            ("MF1='cheap'", "MF 1='cheap'"),
            ("\n", "\r\n"),
        ],
    )
    def test_the_same_file_is_written_in_many_ways(self, old, new):
        assert system(changed(old, new)) == system(TIPPER)
        assert said(changed(old, new)) == []

    def test_defaults_are_those_of_matlab(self):
        bare = TIPPER
        for line in (
            "AndMethod='min'",
            "OrMethod='max'",
            "ImpMethod='min'",
            "AggMethod='max'",
            "DefuzzMethod='centroid'",
        ):
            bare = bare.replace(line + "\n", "")
        assert system(bare.replace("Type='mamdani'\n", "")) == system(TIPPER)

    @pytest.mark.parametrize("kind", ["bisector", "mom", "som", "lom"])
    def test_defuzzifiers_have_the_options_of_matlab(self, kind):
        found = system(changed("'centroid'", f"'{kind}'"))
        assert found.method.defuzzifier == profile("matlab").defuzzifier(kind)
        assert found.method.defuzzifier.resolution == 101

    def test_sum_adds_without_bound(self):
        assert system(changed("AggMethod='max'", "AggMethod='sum'")).method.aggregation == "sum"
        assert system(changed("AggMethod='max'", "AggMethod='probor'")).method.aggregation == "probabilistic_sum"

    def test_files_with_old_windows_line_ends_and_a_last_line_without_one(self):
        assert system(TIPPER.rstrip("\n")) == system(TIPPER)


class TestFunctions:
    @pytest.mark.parametrize(
        ("text", "kind", "parameters"),
        [
            ("'trimf',[0 1 2]", "triangle", (0, 1, 2)),
            ("'trapmf',[0 1 2 3]", "trapezoid", (0, 1, 2, 3)),
            ("'gaussmf',[2 5]", "gaussian", (5, 2)),
            ("'gaussmf',[-2 5]", "gaussian", (5, 2)),
            ("'gauss2mf',[1 2 3 4]", "gaussian2", (2, 1, 4, 3)),
            ("'gbellmf',[1 2 3]", "bell", (3, 1, 2)),
            ("'sigmf',[1 2]", "sigmoid", (2, 1)),
            ("'dsigmf',[1 2 3 4]", "sigmoid_difference", (2, 1, 3, 4)),
            ("'psigmf',[1 2 -3 4]", "sigmoid_product", (2, 1, -3, 4)),
            ("'zmf',[1 2]", "z_shape", (1, 2)),
            ("'smf',[1 2]", "s_shape", (1, 2)),
            ("'smf',[3 1]", "rectangle", (2, math.inf)),
            ("'zmf',[2 2]", "rectangle", (-math.inf, 2)),
            ("'pimf',[1 2 3 4]", "pi_shape", (1, 2, 3, 4)),
            ("'linsmf',[1 2]", "ramp", (1, 2)),
            ("'linzmf',[1 2]", "ramp", (2, 1)),
            ("'trapmf',[-Inf -Inf 1 2]", "trapezoid", (-math.inf, 1, 1, 2)),
            ("'trapmf',[1 2 Inf Inf]", "trapezoid", (1, 2, 2, math.inf)),
            ("'trapmf',[0 2 1 3]", "piecewise", (0, 0, 1.5, 0.75, 3, 0)),
            ("'trapmf',[0 0 -1 3]", "piecewise", (0, 0, 0, 0.75, 3, 0)),
        ],
    )
    def test_parameters_go_where_they_belong(self, text, kind, parameters):
        membership = system(changed("'gaussmf',[1.5 0]", text)).inputs[0].terms[0].membership
        assert membership.kind == kind
        assert tuple(a.value for a in membership.arguments) == parameters

    def test_a_trapezoid_with_its_tops_reversed_is_the_lower_of_its_two_sides(self, tmp_path):
        path = tmp_path / "t.fis"
        path.write_text(changed("'trapmf',[0 0 1 3]", "'trapmf',[0 8 2 10]"), encoding="utf-8")
        found = load(path)
        rule = "0 1, 1 (1) : 1"
        path.write_text(path.read_text().split("[Rules]")[0] + f"[Rules]\n{rule}\n", encoding="utf-8")
        found = load(path).model_copy()
        membership = found.inputs[1].terms[0].membership
        xs, ys = (tuple(a.value for a in membership.arguments)[k::2] for k in (0, 1))
        for x in (1.0, 3.0, 4.9, 5.0, 6.0, 9.0):
            lower = min(x / 8, (10 - x) / 8)
            between = next(i for i in range(2) if xs[i] <= x <= xs[i + 1])
            run = (x - xs[between]) / (xs[between + 1] - xs[between])
            assert ys[between] + run * (ys[between + 1] - ys[between]) == pytest.approx(lower, abs=1e-15)

    @pytest.mark.parametrize(
        ("kind", "count"),
        [
            *(("trapezoid", 4), ("triangle", 3), ("bell", 3), ("gaussian", 2), ("gaussian2", 4), ("sigmoid", 2)),
            *(("sigmoid_difference", 4), ("sigmoid_product", 4), ("s_shape", 2), ("z_shape", 2), ("pi_shape", 4)),
            *(("ramp", 2), ("constant", 1)),
        ],
    )
    def test_what_is_written_is_read_back(self, kind, count):
        parameters = (1.0, 2.5, 3.0, 4.0)[:count]
        function, values = written(kind, parameters, fuzzylite=False)
        line = f"'{function}',[{' '.join(map(repr, values))}]"
        membership = system(changed("'gaussmf',[1.5 0]", line)).inputs[0].terms[0].membership
        assert (membership.kind, tuple(a.value for a in membership.arguments)) == (kind, parameters)


class TestSugeno:
    PENDULUM = (SAMPLES / "pendulum.fis").read_text(encoding="utf-8")

    def test_consequents_are_numbers_and_functions_of_all_inputs(self):
        found = system(self.PENDULUM)
        kinds = [t.membership.kind for t in found.outputs[0].terms]
        assert kinds == ["linear", "linear", "constant", "linear"]
        assert found.method.defuzzifier.kind == "weighted_average"

    def test_repeated_names_are_told_apart_and_meant_by_number(self):
        found = system(self.PENDULUM)
        assert [t.name for t in found.outputs[0].terms] == ["out1mf", "out1mf_2", "out1mf_3", "out1mf_4"]
        assert [r.consequents[0].term for r in found.rules] == [
            "out1mf",
            "out1mf_2",
            "out1mf_3",
            "out1mf_4",
            "out1mf_2",
        ]
        assert [c for c in said(self.PENDULUM) if c[0] == "FZ604"] == [("FZ604", "warning", 39, 6)]

    def test_padding_is_reported_once_and_changes_nothing(self):
        padding = [c for c in said(self.PENDULUM) if c[0] == "FZ603" and c[2] < 30]
        assert padding == [("FZ603", "warning", 18, 37)]
        assert system(self.PENDULUM.replace(" 0]", "]", 3)).inputs == system(self.PENDULUM).inputs

    def test_an_output_without_a_range_reaches_as_far_as_its_terms_about_its_middle(self):
        output = system(self.PENDULUM).outputs[0]
        assert (output.lower.value, output.upper.value) == (-4.5, 4.5)
        assert output.otherwise == "midpoint"

    def test_ranges_are_expressions(self):
        assert system(self.PENDULUM).inputs[0].lower == Number(-math.pi / 4)

    def test_a_weighted_sum_does_not_divide(self):
        found = system(self.PENDULUM.replace("wtaver", "wtsum"))
        assert found.method.defuzzifier.kind == "weighted_sum"

    @pytest.mark.parametrize(
        ("old", "new", "code"),
        [
            ("'wtaver'", "'centroid'", "FZ214"),
            ("[-2.5 -0.25 1 0]", "[-2.5 -0.25]", "FZ303"),
            ("2 0 0, 2 (0.5)", "2 0 0, -2 (0.5)", "FZ602"),
        ],
    )
    def test_what_has_no_meaning_is_refused(self, old, new, code):
        assert code in [c for c, severity, *_ in said(self.PENDULUM.replace(old, new)) if severity == "error"]


class TestDialects:
    OCTAVE = (SAMPLES / "portfolio_octave.fis").read_text(encoding="utf-8")
    FUZZYLITE = (SAMPLES / "heater_fuzzylite.fis").read_text(encoding="utf-8")

    def test_octave_is_known_by_its_comment_its_norms_and_its_hedges(self):
        found = system(self.OCTAVE)
        assert found.method.semantics == profile("octave").semantics
        assert (found.method.conjunction, found.method.aggregation) == ("einstein_product", "einstein_sum")
        assert found.outputs[0].otherwise == "nan"
        hedged = system(changed("1 1, 1 (1) : 2", "1.2 1, 1 (1) : 2"))
        assert hedged.method.semantics.profile == "octave"
        assert system(changed("'min'\nOr", "'hamacher_product'\nOr")).method.semantics.profile == "octave"

    def test_hedges_are_powers_of_ten_times_the_fraction(self):
        found = system(self.OCTAVE)
        assert [i.hedges for i in found.rules[2].antecedent.operands] == [("not", "extremely"), ("not", "extremely")]
        assert [i.hedges for i in found.rules[3].antecedent.operands] == [("very",), ("somewhat",)]
        assert [i.hedges for i in found.rules[4].antecedent.operands] == [("power_1_5",), ("not", "very", "very")]
        assert [h.name for h in found.hedges] == ["power_1_5"]

    def test_fuzzylite_is_known_by_its_comment_its_keys_its_version_and_its_functions(self):
        assert system(self.FUZZYLITE).method.semantics == profile("fuzzylite_6").semantics
        for text in (
            changed("Version=2.0", "Version=7.0"),
            changed("[Input1]\n", "[Input1]\nEnabled=1\n"),
            changed("'trimf',[0 5 10]", "'rampmf',[0 5]"),
        ):
            assert system(text).method.semantics.profile == "fuzzylite"

    def test_fuzzylite_has_defaults_locks_any_and_functions_of_its_own(self):
        found = system(self.FUZZYLITE)
        assert found.outputs[0].otherwise == Number(12.5)
        assert [v.extrapolate for v in found.inputs] == [True, True]
        kinds = [t.membership.kind for v in (*found.inputs, *found.outputs) for t in v.terms]
        assert kinds == ["ramp", "cosine", "ramp", "concave", "piecewise", "rectangle", "spike", "trapezoid"]
        assert found.rules[2].antecedent == Is(variable="error", term="cold", hedges=("not", "extremely"))
        held = system(self.FUZZYLITE.replace("Range=[0.000 1.000]", "Range=[0.000 1.000]\nLockRange=1"))
        assert [v.extrapolate for v in held.inputs] == [True, False]
        locked = system(self.FUZZYLITE.replace("LockValid=0", "LockValid=1"))
        assert locked.outputs[0].otherwise == Hold(start=Number(12.5))
        unset = system(self.FUZZYLITE.replace("Default=12.500", "Default=nan"))
        assert unset.outputs[0].otherwise == "nan"

    @pytest.mark.parametrize(
        ("rule", "activation"),
        [
            ("0.99 2, 3 (1) : 1", 0.04),
            ("0.99 2, 3 (1) : 2", 1.0),
            ("-0.99 2, 3 (1) : 1", 0.0),
            ("-0.99 2, 3 (1) : 2", 0.04),
            ("0.99 0, 3 (1) : 2", 1.0),
            ("-.99 0, 3 (1) : 1", 0.0),
        ],
    )
    def test_any_of_fuzzylite_holds_everywhere_and_negated_nowhere(self, rule, activation):
        # As fuzzylite 6 computes them: 'any' joined by or is 1, whatever stands beside it.
        head, _, _ = self.FUZZYLITE.partition("[Rules]")
        found = system(f"{head.replace('NumRules=4', 'NumRules=1')}[Rules]\n{rule}\n")
        traced = trace(found, {"error": 1.0, "window": 0.08})
        assert sum(r.activation for r in traced.rules) == pytest.approx(activation, rel=1e-12)

    @pytest.mark.parametrize("value", ["0", "0.000", "false"])
    def test_what_fuzzylite_has_switched_off_is_refused(self, value):
        text = changed("[Input1]\n", f"[Input1]\nEnabled={value}\n")
        _, diagnostics = read(SourceText("t.fis", text))
        assert [(d.code, d.span.text) for d in diagnostics if d.severity == "error"] == [("FZ602", value)]

    def test_old_fuzzylite_called_the_algebraic_sum_sum(self):
        text = self.FUZZYLITE.replace("AggMethod='max'", "AggMethod='sum'")
        assert system(text).method.aggregation == "sum"
        old = text.replace("fuzzylite 6.0", "fuzzylite 5.1").replace("Version=6.0", "Version=5.1")
        assert system(old).method.aggregation == "probabilistic_sum"

    def test_a_hybrid_system_averages_the_outputs_whose_terms_are_numbers(self):
        more = self.FUZZYLITE.replace("Type='mamdani'", "Type='hybrid'").replace("NumOutputs=1", "NumOutputs=2")
        more = more.replace(
            "[Rules]", "[Output2]\nName='cost'\nRange=[0 1]\nNumMFs=1\nMF1='a':'constant',[0.5]\n\n[Rules]"
        )
        more = more.replace(".000 (", ".000 1.000 (")
        outputs = system(more).outputs
        assert [o.defuzzifier.kind for o in outputs] == ["mom", "weighted_average"]

    def test_tsukamoto_systems_are_known_by_their_terms(self):
        text = self.FUZZYLITE.replace("Type='mamdani'", "Type='sugeno'").replace("'mom'", "'wtaver'")
        for old, new in (
            ("'rectmf',[0.000 10.000]", "'rampmf',[9 0]"),
            ("'spikemf',[50.000 60.000]", "'sigmf',[1 50]"),
        ):
            text = text.replace(old, new)
        text = text.replace("'trapmf',[60.000 90.000 100.000 100.000]", "'smf',[60 100]")
        assert system(text).method.defuzzifier.kind == "tsukamoto"


class TestMistakes:
    """Each is one message, in the place where it is."""

    @pytest.mark.parametrize(
        ("old", "new", "expected"),
        [
            ("Name='tipper'", "Name 'tipper'", ("FZ601", "error", 2, 1)),
            ("Type='mamdani'", "Type='fuzzy'", ("FZ602", "error", 3, 6)),
            ("AndMethod='min'", "AndMethod='myand'", ("FZ602", "error", 8, 11)),
            ("DefuzzMethod='centroid'", "DefuzzMethod='mine'", ("FZ602", "error", 12, 14)),
            ("DefuzzMethod='centroid'", "DefuzzMethod='wtaver'", ("FZ214", "error", 12, 14)),
            ("NumInputs=2", "NumInputs=two", ("FZ601", "error", 5, 11)),
            ("NumInputs=2", "NumInputs=3", ("FZ606", "warning", 5, 11)),
            ("NumRules=3", "NumRules=4", ("FZ606", "warning", 7, 10)),
            ("NumMFs=2", "NumMFs=3", ("FZ606", "warning", 25, 8)),
            ("OrMethod='max'", "OrMethod='max'\nOrMethod='max'", ("FZ215", "error", 10, 1)),
            ("OrMethod='max'", "OrMethod='max'\nColour='red'", ("FZ603", "warning", 10, 1)),
            ("[Input1]", "[Inpt1]", None),
            ("Range=[0 30]\n", "", ("FZ212", "error", 29, 1)),
            ("Range=[0 30]", "Range=[0 10 30]", ("FZ601", "error", 31, 7)),
            ("Range=[0 30]", "Range=[0 30", ("FZ103", "error", 31, 7)),
            ("Range=[0 30]", "Range=[0 pie]", ("FZ601", "error", 31, 10)),
            ("Range=[0 30]", "Range=[0 1/0]", None),
            ("'trimf',[0 5 10]", "'trimf',[0 5]", ("FZ303", "error", 33, 5)),
            ("'trimf',[0 5 10]", "'trimf',[0 5 10 99]", ("FZ603", "warning", 33, 29)),
            ("'trimf',[0 5 10]", "'trimf',[0 5 NaN]", ("FZ601", "error", 33, 26)),
            ("'trimf',[0 5 10]", "'trimf',[0 5 10", ("FZ103", "error", 33, 21)),
            ("'trimf',[0 5 10]", "'mymf',[0 5 10]", ("FZ602", "error", 33, 14)),
            ("'trimf',[0 5 10]", "'trimf',[0 5 10],0.9,[0.2 0.2]", ("FZ602", "error", 33, 21)),
            ("'cheap':'trimf',[0 5 10]", "'cheap'", ("FZ601", "error", 33, 5)),
            ("MF1='cheap'", "MF1U='cheap'", None),
            ("MF2='average'", "MF2='cheap'", ("FZ604", "warning", 34, 6)),
            ("MF2='average'", "MF4='average'", ("FZ606", "warning", 34, 1)),
            ("Name='food'", "Name='service'", ("FZ604", "warning", 23, 7)),
            ("Name='food'", "Name=''", ("FZ604", "warning", 22, 1)),
            ("1 1, 1 (1) : 2", "1 1 1, 1 (1) : 2", ("FZ601", "error", 38, 1)),
            ("1 1, 1 (1) : 2", "1 1, 1 1 (1) : 2", ("FZ601", "error", 38, 1)),
            ("1 1, 1 (1) : 2", "1 1 1 (1) : 2", ("FZ601", "error", 38, 1)),
            ("1 1, 1 (1) : 2", "1 x, 1 (1) : 2", ("FZ601", "error", 38, 3)),
            ("1 1, 1 (1) : 2", "1 7, 1 (1) : 2", ("FZ607", "error", 38, 3)),
            ("1 1, 1 (1) : 2", "1 1, 4 (1) : 2", ("FZ607", "error", 38, 6)),
            ("1 1, 1 (1) : 2", "1 1, 1 (2) : 2", ("FZ302", "error", 38, 9)),
            ("1 1, 1 (1) : 2", "1 1, 1 (a) : 2", ("FZ601", "error", 38, 9)),
            ("1 1, 1 (1) : 2", "1 1, 1 (1) : 3", ("FZ601", "error", 38, 12)),
            ("1 1, 1 (1) : 2", "1 1, 0 (1) : 2", ("FZ603", "warning", 38, 1)),
            ("1 1, 1 (1) : 2\n2 0, 2 (1) : 1\n3 2, 3 (1) : 2\n", "", None),
        ],
    )
    def test_one_mistake_has_one_message(self, old, new, expected):
        text = changed(old, new)
        found = said(text)
        errors = [f for f in found if f[1] == "error"]
        if expected is not None:
            assert found == [expected]
        else:
            assert errors
        assert (read(SourceText("t.fis", text))[0] is None) == bool(errors)

    def test_all_mistakes_are_reported_at_once(self):
        text = TIPPER.replace("'gaussmf'", "'gausmf'", 1).replace("'trimf',[0 5 10]", "'trimf',[0 5]")
        text = text.replace("2 0, 2 (1) : 1", "2 0, 9 (1) : 1")
        assert [c for c, *_ in said(text)] == ["FZ602", "FZ303", "FZ607"]

    def test_a_misspelt_function_is_recognised(self):
        assert "did you mean 'gaussmf'?" in message(changed("'poor':'gaussmf'", "'poor':'gausmf'"))

    def test_a_custom_function_is_refused_with_its_name(self):
        text = message(changed("'cheap':'trimf'", "'cheap':'custom1'"))
        assert "there is no membership function 'custom1'" in text

    @pytest.mark.parametrize(
        ("text", "code"),
        [
            ("", "FZ004"),
            ("% nothing\n", "FZ004"),
            ("<html><body>Not found</body></html>", "FZ601"),
            ("[System]\nNinputs=2\n[Interface]\n", "FZ602"),
            ("[Input1]\nName='a'\nRange=[0 1]\n", "FZ212"),
            (TIPPER.replace("[Output1]", "[Input1]"), "FZ215"),
            (TIPPER + TIPPER, "FZ215"),
            (TIPPER.replace("mamdani", "mamdanitype2"), "FZ602"),
            (
                TIPPER.replace("DefuzzMethod='centroid'", "DefuzzMethod='centroid'\nTypeRedMethod='Karnik-Mendel'"),
                "FZ602",
            ),
        ],
    )
    def test_what_is_no_such_file_is_reported(self, text, code):
        assert code in [c for c, severity, *_ in said(text) if severity == "error"]


class TestVectors:
    @pytest.mark.parametrize(
        ("text", "values"),
        [
            ("", ()),
            ("1 2", (1, 2)),
            ("1,2;3", (1, 2, 3)),
            (" 1 ,\t2 ", (1, 2)),
            ("1 -2", (1, -2)),
            ("1 - 2", (-1,)),
            ("1 -2 + 3", (1, 1)),
            ("[", None),
            ("-pi/4 pi/4", (-math.pi / 4, math.pi / 4)),
            ("2*pi 2 * 3", (2 * math.pi, 6)),
            ("(1 -2)*3", (-3,)),
            ("2^3 2^-1", (8, 0.5)),
            ("-Inf inf", (-math.inf, math.inf)),
            ("1e3 1E-3 .5 5. 1d2", (1000, 0.001, 0.5, 5, 100)),
            ("--1 +2", (1, 2)),
            ("nan", None),
            ("1/0", None),
            ("inf-inf", None),
            ("(1", None),
            ("1 +", None),
            ("sin(1)", None),
            ("2^3^2", (64,)),
            ("(-8)^(1/3)", None),
            ("9^9^9^9", None),
            ("(" * 30 + "1" + ")" * 30, None),
        ],
    )
    def test_numbers_are_separated_as_in_matlab(self, text, values):
        source = SourceText("t", text)
        numbers = vector(Span(source, 0, len(text)), Findings(source))
        assert (None if numbers is None else tuple(n.value for n in numbers)) == values


def test_a_formula_of_an_output_may_name_the_outputs_before_it():
    text = (SAMPLES / "heater_fuzzylite.fis").read_text(encoding="utf-8").replace("NumOutputs=1", "NumOutputs=2")
    text = (
        text.replace("'mom'", "'centroid'").replace("Type='mamdani'", "Type='hybrid'").replace(".000 (", ".000 1.000 (")
    )
    second = "[Output2]\nName='cost'\nRange=[0 1]\nNumMFs=1\nMF1='a':'function',[fabs ( power-error )]\n\n[Rules]"
    found = system(text.replace("[Rules]", second))
    assert found.outputs[1].terms[0].membership.kind == "function"
    assert [c for c, *_ in said(text.replace("[Rules]", second.replace("power", "cost")))] == ["FZ202"]


@pytest.mark.parametrize(
    ("given", "lower", "upper"), [("[-inf inf]", -5.0, 10.0), ("[-2 inf]", -2.0, 10.0), ("[-inf 20]", -5.0, 20.0)]
)
def test_an_input_of_fuzzylite_without_end_is_as_wide_as_its_terms(given, lower, upper):
    text = f"""% generated with fuzzylite
[System]
Name='t'
Type='sugeno'
[Input1]
Name='a'
Range={given}
MF1='lo':'trimf',[-5 0 10]
[Output1]
Name='y'
Range=[0 30]
MF1='u':'constant',[2]
[Rules]
1, 1 (1) : 1
"""
    system, diagnostics = read(SourceText("t.fis", text))
    assert system is not None, render_all(diagnostics)
    (a,) = system.inputs
    assert (a.lower.value, a.upper.value, a.extrapolate) == (lower, upper, True)
    assert [(d.code, d.span.line) for d in diagnostics if "infinite" in d.message] == [("FZ603", 7)]
