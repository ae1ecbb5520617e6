"""`.fis` files as MATLAB, Octave and fuzzylite write them. Mistakes are in tests/golden/foreign_mistakes.txt."""

import math

import pytest

import fuzzyctl
from tests.fuzzyctl.formats.files import SAMPLES, errors, examined, head, lines, read, replaced, rules, said, write

TIPPER, PENDULUM = SAMPLES["tipper.fis"], SAMPLES["pendulum.fis"]
OCTAVE, FUZZYLITE = SAMPLES["portfolio_octave.fis"], SAMPLES["heater_fuzzylite.fis"]


def changed(old, new):
    return replaced(TIPPER, (old, new))


class TestMatlab:
    def test_the_method_is_that_of_the_file_with_the_samples_of_matlab(self):
        assert head("fis", TIPPER) == {"semantics": "matlab"}
        defuzzifier = read("fis", TIPPER).method.defuzzifier
        assert (defuzzifier.kind, defuzzifier.resolution, defuzzifier.grid) == ("centroid", 101, "endpoints")
        assert lines("fis", TIPPER)[4:8] == [
            "input service in [0, 10] extrapolate",
            "poor      = gaussian(0, 1.5)",
            "good      = gaussian(5, 1.5)",
            "excellent = gaussian(10, 1.5)",
        ]
        assert rules("fis", TIPPER) == [
            "if service is poor or food is rancid then tip is cheap",
            "if service is good then tip is average",
            "if service is excellent or food is delicious then tip is generous",
        ]

    def test_names_become_identifiers_with_the_names_of_the_file_as_labels(self):
        text = replaced(
            TIPPER, ("'service'", "'Age_(years) it''s'"), ("'tipper'", "'simple-dimmer'"), ("'poor'", "'very poor'")
        )
        found = lines("fis", text)
        assert found[0] == 'system simple_dimmer "simple-dimmer"'
        assert found[4] == 'input Age_years_it_s "Age_(years) it\'s" in [0, 10] extrapolate'
        assert found[5] == "very_poor = gaussian(0, 1.5)"
        assert ("FZ604", 1, 1) in said("fis", text, "hint")
        assert "Name='Age_(years) it''s'" in write("fis", read("fis", text))[0]

    @pytest.mark.parametrize(
        ("rule", "expected"),
        [
            (
                "-1 -2, -1 (0.25) : 1",
                "if service is not poor and food is not delicious then tip is not cheap weight 0.25",
            ),
            ("0 0, 1 (1) : 1", "if service is any poor then tip is cheap"),
            ("0 0, 1 (1) : 2", "if service is not any poor then tip is cheap"),
        ],
    )
    def test_a_minus_is_not_and_a_rule_without_conditions_holds_everywhere_by_and(self, rule, expected):
        assert rules("fis", changed("1 1, 1 (1) : 2", rule))[0] == expected

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
            ("3 2, 3 (1) : 2\n", "3 2, 3 (1) : 2"),
        ],
    )
    def test_the_same_file_is_written_in_many_ways(self, old, new):
        assert read("fis", changed(old, new)) == read("fis", TIPPER)
        assert [code for code, *_ in said("fis", changed(old, new))] == [code for code, *_ in said("fis", TIPPER)]

    def test_defaults_are_those_of_matlab(self):
        bare = "\n".join(line for line in TIPPER.splitlines() if "Method=" not in line and "Type=" not in line)
        assert read("fis", bare) == read("fis", TIPPER)

    @pytest.mark.parametrize(
        ("old", "new", "setting"),
        [
            *(("'centroid'", f"'{kind}'", ("defuzzifier", kind)) for kind in ("bisector", "mom", "som", "lom")),
            ("AggMethod='max'", "AggMethod='sum'", ("aggregation", "sum")),
            ("AggMethod='max'", "AggMethod='probor'", ("aggregation", "probabilistic_sum")),
        ],
    )
    def test_methods_have_the_options_of_matlab(self, old, new, setting):
        assert head("fis", changed(old, new)) == dict([("semantics", "matlab"), setting])


class TestFunctions:
    @pytest.mark.parametrize(
        ("text", "term"),
        [
            ("'trimf',[0 1 2]", "triangle(0, 1, 2)"),
            ("'trapmf',[0 1 2 3]", "trapezoid(0, 1, 2, 3)"),
            ("'gaussmf',[-2 5]", "gaussian(5, 2)"),
            ("'gauss2mf',[1 2 3 4]", "gaussian2(2, 1, 4, 3)"),
            ("'gauss2mf',[-1 2 -3 4]", "gaussian2(2, 1, 4, 3)"),
            ("'gbellmf',[1 2 3]", "bell(3, 1, 2)"),
            ("'sigmf',[1 2]", "sigmoid(2, 1)"),
            ("'dsigmf',[1 2 3 4]", "sigmoid_difference(2, 1, 3, 4)"),
            ("'psigmf',[1 2 -3 4]", "sigmoid_product(2, 1, -3, 4)"),
            ("'zmf',[1 2]", "z_shape(1, 2)"),
            ("'smf',[1 2]", "s_shape(1, 2)"),
            ("'smf',[3 1]", "rectangle(2, inf)"),
            ("'zmf',[2 2]", "rectangle(-inf, 2)"),
            ("'pimf',[1 2 3 4]", "pi_shape(1, 2, 3, 4)"),
            ("'linsmf',[1 2]", "ramp(1, 2)"),
            ("'linzmf',[1 2]", "ramp(2, 1)"),
            ("'trapmf',[-Inf -Inf 1 2]", "trapezoid(-inf, 1, 1, 2)"),
            ("'trapmf',[1 2 Inf Inf]", "trapezoid(1, 2, 2, inf)"),
            # With its tops reversed it is the lower of its two sides.
            ("'trapmf',[0 2 1 3]", "piecewise(0, 0, 1.5, 0.75, 3, 0)"),
            ("'trapmf',[0 0 -1 3]", "piecewise(0, 0, 0, 0.75, 3, 0)"),
        ],
    )
    def test_parameters_go_where_they_belong(self, text, term):
        assert f"poor      = {term}" in lines("fis", changed("'gaussmf',[1.5 0]", text))

    @pytest.mark.parametrize(
        ("text", "values"),
        [
            ("1 2", (1, 2)),
            ("1,2;", (1, 2)),
            (" 1 ,\t2 ", (1, 2)),
            ("1 -2", (1, -2)),
            ("1 - 2 5", (-1, 5)),
            ("1 -2 + 3", (1, 1)),
            ("-pi/4 pi/4", (-math.pi / 4, math.pi / 4)),
            ("2*pi 2 * 3", (2 * math.pi, 6)),
            ("(1 -2)*3 1", (-3, 1)),
            ("2^3 2^-1", (8, 0.5)),
            ("1e3 1E-3", (1000, 0.001)),
            (".5 5.", (0.5, 5)),
            ("1d2 1", (100, 1)),
            ("--1 +2", (1, 2)),
            ("2^3^2 1", (64, 1)),
            *((f"{text} 1", None) for text in ("[", "nan", "1/0", "inf-inf", "(1", "1 +", "sin(1)", "(-8)^(1/3)")),
            *((f"{text} 1", None) for text in ("9^9^9^9", "(" * 30 + "1" + ")" * 30)),
        ],
    )
    def test_numbers_are_separated_as_in_matlab(self, text, values):
        system, _ = examined("fis", changed("'gaussmf',[1.5 0]", f"'sigmf',[{text}]"))
        found = system and tuple(system.number(a) for a in system.inputs[0].terms[0].membership.arguments)[::-1]
        assert found == values


class TestSugeno:
    def test_consequents_are_functions_of_all_inputs_and_repeated_names_are_told_apart(self):
        assert head("fis", PENDULUM)["defuzzifier"] == "weighted_average"
        output = lines("fis", PENDULUM).index("output force in [-4.5, 4.5]")  # as far as its terms about its middle
        assert lines("fis", PENDULUM)[output + 1 : output + 5] == [
            "out1mf   = linear(-3, -0.5, 0, 0.25)",
            "out1mf_2 = linear(-2.5, -0.25, 1, 0)",
            "out1mf_3 = constant(4.5)",
            "out1mf_4 = linear(1, 0, 0, -1)",
        ]
        assert [line.split(" then force is ")[1] for line in rules("fis", PENDULUM)] == [
            *("out1mf", "out1mf_2 weight 0.5", "out1mf_3", "out1mf_4", "out1mf_2 weight 0.25"),
        ]
        assert f"input angle in [{-math.pi / 4}, {math.pi / 4}] extrapolate" in lines("fis", PENDULUM)

    def test_padding_is_reported_once_and_changes_nothing(self):
        assert [c for c in said("fis", PENDULUM) if c[0] == "FZ603" and c[1] < 30] == [("FZ603", 18, 37)]
        assert read("fis", PENDULUM.replace(" 0]", "]", 3)).inputs == read("fis", PENDULUM).inputs

    def test_a_weighted_sum_does_not_divide(self):
        assert head("fis", PENDULUM.replace("wtaver", "wtsum"))["defuzzifier"] == "weighted_sum"

    @pytest.mark.parametrize(
        ("old", "new", "code"),
        [
            ("'wtaver'", "'centroid'", "FZ214"),
            ("[-2.5 -0.25 1 0]", "[-2.5 -0.25]", "FZ303"),
            ("2 0 0, 2 (0.5)", "2 0 0, -2 (0.5)", "FZ602"),
        ],
    )
    def test_what_has_no_meaning_is_refused(self, old, new, code):
        assert code in {d.code for d in errors("fis", PENDULUM.replace(old, new))}


class TestDialects:
    def test_octave_is_known_by_its_comment_its_norms_and_its_hedges(self):
        assert head("fis", OCTAVE) == {
            "semantics": "octave",
            "and": "einstein_product",
            "or": "einstein_sum",
            "implication": "einstein_product",
            "aggregation": "einstein_sum",
        }
        for old, new in (("1 1, 1 (1) : 2", "1.2 1, 1 (1) : 2"), ("'min'\nOr", "'hamacher_product'\nOr")):
            assert head("fis", changed(old, new))["semantics"] == "octave"

    def test_hedges_are_powers_of_ten_times_the_fraction(self):
        assert [line.split(" then ")[0] for line in rules("fis", OCTAVE)[2:]] == [
            "if Age is not extremely Old and Water_Quality is not extremely Low",
            "if Age is very Young and Water_Quality is somewhat High",
            "if Age is power_1_5 Young and Water_Quality is not very very High",
        ]
        assert "hedge power_1_5(x) = x^1.5" in lines("fis", OCTAVE)

    @pytest.mark.parametrize(
        ("old", "new"),
        [
            ("Version=2.0", "Version=7.0"),
            ("[Input1]\n", "[Input1]\nEnabled=1\n"),
            ("'trimf',[0 5 10]", "'rampmf',[0 5]"),
        ],
    )
    def test_fuzzylite_is_known_by_its_keys_its_version_and_its_functions(self, old, new):
        assert head("fis", changed(old, new))["semantics"] == "fuzzylite"

    @pytest.mark.parametrize(
        ("old", "new", "line"),
        [
            ("\n", "\n", "output power in [0, 100] else 12.5"),
            ("\n", "\n", "if error is not extremely cold then power is off weight 0.5"),
            ("\n", "\n", "open = piecewise(0, 0, 0.5, 0.25, 1, 1)"),
            ("Range=[0.000 1.000]", "Range=[0.000 1.000]\nLockRange=1", "input window in [0, 1]"),
            ("LockValid=0", "LockValid=1", "output power in [0, 100] else hold(12.5)"),
            ("Default=12.500", "Default=nan", "output power in [0, 100]"),
        ],
    )
    def test_fuzzylite_has_defaults_locks_any_and_functions_of_its_own(self, old, new, line):
        assert line in lines("fis", replaced(FUZZYLITE, (old, new)))

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
        before, _, _ = FUZZYLITE.partition("[Rules]")
        found = read("fis", f"{before.replace('NumRules=4', 'NumRules=1')}[Rules]\n{rule}\n")
        strengths = fuzzyctl.compile(found, "python").strengths([[1.0, 0.08]])
        assert strengths.tolist() == [[pytest.approx(activation, rel=1e-12)]]

    @pytest.mark.parametrize("value", ["0", "0.000", "false"])
    def test_what_fuzzylite_has_switched_off_is_refused(self, value):
        found = errors("fis", changed("[Input1]\n", f"[Input1]\nEnabled={value}\n"))
        assert [(d.code, d.span.text) for d in found] == [("FZ602", value)]

    def test_old_fuzzylite_called_the_algebraic_sum_sum(self):
        text = FUZZYLITE.replace("AggMethod='max'", "AggMethod='sum'")
        assert head("fis", text)["aggregation"] == "sum"
        old = replaced(text, ("fuzzylite 6.0", "fuzzylite 5.1"), ("Version=6.0", "Version=5.1"))
        assert head("fis", old)["aggregation"] == "probabilistic_sum"

    def test_a_hybrid_system_averages_the_outputs_whose_terms_are_numbers(self):
        cost = "[Output2]\nName='cost'\nRange=[0 1]\nNumMFs=1\nMF1='a':{}\n\n[Rules]"
        more = replaced(
            FUZZYLITE,
            *(("Type='mamdani'", "Type='hybrid'"), ("NumOutputs=1", "NumOutputs=2"), (".000 (", ".000 1.000 (")),
        )
        found = lines("fis", more.replace("[Rules]", cost.format("'constant',[0.5]")))
        assert "output cost in [0, 1] defuzzifier weighted_average" in found
        # A formula of an output may name the outputs before it.
        formula = cost.format("'function',[fabs ( power-error )]")
        area = more.replace("'mom'", "'centroid'")
        assert "a = function(abs(power - error))" in lines("fis", area.replace("[Rules]", formula))
        wrong = area.replace("[Rules]", formula.replace("power", "cost"))
        assert [d.code for d in errors("fis", wrong)] == ["FZ202"]

    def test_tsukamoto_systems_are_known_by_their_terms(self):
        text = replaced(
            FUZZYLITE,
            *(("Type='mamdani'", "Type='sugeno'"), ("'mom'", "'wtaver'")),
            *(("'rectmf',[0.000 10.000]", "'rampmf',[9 0]"), ("'spikemf',[50.000 60.000]", "'sigmf',[1 50]")),
            ("'trapmf',[60.000 90.000 100.000 100.000]", "'smf',[60 100]"),
        )
        assert head("fis", text)["defuzzifier"] == "tsukamoto"

    @pytest.mark.parametrize(
        ("given", "expected"), [("[-inf inf]", "[-5, 10]"), ("[-2 inf]", "[-2, 10]"), ("[-inf 20]", "[-5, 20]")]
    )
    def test_an_input_of_fuzzylite_without_end_is_as_wide_as_its_terms(self, given, expected):
        text = "% generated with fuzzylite\n[System]\nName='t'\nType='sugeno'\n[Input1]\nName='a'\n"
        text += f"Range={given}\nMF1='lo':'trimf',[-5 0 10]\n[Output1]\nName='y'\nRange=[0 30]\n"
        text += "MF1='u':'constant',[2]\n[Rules]\n1, 1 (1) : 1\n"
        assert f"input a in {expected} extrapolate" in lines("fis", text)
        found = [d for d in examined("fis", text)[1] if "infinite" in d.message]
        assert [(d.code, d.span.line) for d in found] == [("FZ603", 7)]


def test_all_mistakes_are_reported_at_once():
    text = TIPPER.replace("'gaussmf'", "'gausmf'", 1).replace("'trimf',[0 5 10]", "'trimf',[0 5]")
    text = text.replace("2 0, 2 (1) : 1", "2 0, 9 (1) : 1")
    assert [d.code for d in errors("fis", text)] == ["FZ602", "FZ303", "FZ607"]
