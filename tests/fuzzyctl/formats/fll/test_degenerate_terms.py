"""Terms whose parameters are a mistake elsewhere, and have a degree in fuzzylite."""

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import fuzzyctl
from tests.fuzzyctl.formats.files import examined as read
from tests.fuzzyctl.formats.one_term import FLL, degrees

PLACES = [0.0, 0.5, 1.0, 1.5, 1.75, 2.0, 2.25, 2.5, 3.0, 3.5, 4.0, 5.0]

#: Degrees at these places, of pyfuzzylite 8.0.6 and, but for the last one, which it does not have, of fuzzylite 6.0.
MEASURED = {
    "Triangle 2 1 3": "0 0 0 0 0 0.5 0.375 0.25 0 0 0 0",
    "Triangle 0 3 2": "0 0.166667 0.333333 0.5 0.583333 0.666667 0 0 0 0 0 0",
    "Triangle 3 2 1": "0 0 0 0 0 0 0 0 0 0 0 0",
    "Trapezoid 0 3 1 2": "0 0.166667 0.333333 0.5 0.583333 0.666667 0 0 0 0 0 0",
    "Trapezoid 3 1 2 4": "0 0 0 0 0 0 0 0 0.5 0.25 0 0",
    "Trapezoid 4 3 2 1": "0 0 0 0 0 0 0 0 0 0 0 0",
    "Trapezoid 0 1 3 2": "0 0.5 1 1 1 1 0 0 0 0 0 0",
    "PiShape 0 3 1 4": "0 0.0555556 0.222222 0.472222 0.571181 0.604938 0.571181 0.472222 0.222222 0.0555556 0 0",
    "PiShape 0 1 3 2": "0 0.5 1 1 1 1 1 1 1 0 0 0",
    "PiShape 4 3 2 1": "0 0 0 0 0 0 0 0 0 0 0 0",
    "Sigmoid 2 0": "0.5 0.5 0.5 0.5 0.5 0.5 0.5 0.5 0.5 0.5 0.5 0.5",
    "SigmoidDifference 1 0 2 3": "0.497527 0.493307 0.482014 0.452574 0.424142 0.380797 "
    "0.317574 0.231059 0 0.231059 0.380797 0.482014",
    "SigmoidDifference 1 2 0 3": "0.380797 0.231059 0 0.231059 0.317574 0.380797 "
    "0.424142 0.452574 0.482014 0.493307 0.497527 0.499665",
    "SigmoidProduct 1 0 -2 3": "0.498764 0.496654 0.491007 0.476287 0.462071 0.440399 "
    "0.408787 0.365529 0.25 0.134471 0.0596015 0.0089931",
    "SigmoidProduct 1 2 0 3": "0.0596015 0.134471 0.25 0.365529 0.408787 0.440399 "
    "0.462071 0.476287 0.491007 0.496654 0.498764 0.499832",
    "Bell 2 -1 2": "0.0588235 0.164948 0.5 0.941176 0.996109 1 0.996109 0.941176 0.5 0.164948 0.0588235 0.0121951",
    "Bell 2 1 0": "0.5 0.5 0.5 0.5 0.5 0.5 0.5 0.5 0.5 0.5 0.5 0.5",
    "Bell 2 1 -2": "0.941176 0.835052 0.5 0.0588235 0.00389105 0 0.00389105 0.0588235 0.5 0.835052 0.941176 0.987805",
    "Bell 2 -1 -2": "0.941176 0.835052 0.5 0.0588235 0.00389105 0 0.00389105 0.0588235 0.5 0.835052 0.941176 0.987805",
    "Spike 2 -1": "2.06115e-09 3.05902e-07 4.53999e-05 0.00673795 0.082085 1 "
    "0.082085 0.00673795 4.53999e-05 3.05902e-07 2.06115e-09 9.35762e-14",
    "Cosine 2 -3": "0 0 0 0 0 0 0 0 0 0 0 0",
    "SShape 3 1": "0 0 0 0 0 0 0 0 0 1 1 1",
    "SShape 2 2": "0 0 0 0 0 0 1 1 1 1 1 1",
    "ZShape 3 1": "1 1 1 1 1 1 1 1 1 0 0 0",
    "ZShape 2 2": "1 1 1 1 1 1 0 0 0 0 0 0",
    "Gaussian 2 -1": "0.135335 0.324652 0.606531 0.882497 0.969233 1 "
    "0.969233 0.882497 0.606531 0.324652 0.135335 0.011109",
    "Triangle 0 2 4 0": "0 0 0 0 0 0 0 0 0 0 0 0",
    "Discrete 0 0 2 0": "0 0 0 0 0 0 0 0 0 0 0 0",
    "Binary 2 2": "0 0 0 0 0 0 0 0 0 0 0 0",
    "SemiEllipse 3 1": "0 0 0 0.866025 0.968246 1 0.968246 0.866025 0 0 0 0",
    "PiShape 1 1 2 3": "0 0 0 1 1 1 0.875 0.5 0 0 0 0",
    "PiShape 1 1 1 3": "0 0 0 0.875 0.71875 0.5 0.28125 0.125 0 0 0 0",
    "PiShape 1 1 2 2": "0 0 0 1 1 1 0 0 0 0 0 0",
    "PiShape 1 1 1 1": "0 0 0 0 0 0 0 0 0 0 0 0",
    "PiShape 1 1 3 inf": "0 0 0 1 1 1 1 1 1 1 1 1",
    "PiShape 1 1 2 3 0.5": "0 0 0 0.5 0.5 0.5 0.4375 0.25 0 0 0 0",
    "PiShape 2 2 1 4": "0 0 0 0 0 0 0.652778 0.5 0.222222 0.0555556 0 0",
    "PiShape 0 3 2 2": "0 0.0555556 0.222222 0.5 0.652778 0.777778 0 0 0 0 0 0",
    "PiShape 0 3 2 1": "0 0.0555556 0.222222 0.5 0.652778 0.777778 0 0 0 0 0 0",
    "Discrete 2 0.25": "0.25 0.25 0.25 0.25 0.25 0.25 0.25 0.25 0.25 0.25 0.25 0.25",
    "Rectangle -inf inf": "1 1 1 1 1 1 1 1 1 1 1 1",
    "Binary -inf 0": "1 1 1 1 1 1 1 1 1 1 1 1",
}

#: What an output may be, too.
OF_OUTPUTS = [
    *("Triangle 2 1 3", "Triangle 0 3 2", "Trapezoid 0 3 1 2", "Trapezoid 3 1 2 4", "Trapezoid 0 1 3 2"),
    *("PiShape 0 1 3 2", "Sigmoid 2 0", "SigmoidProduct 1 0 -2 3", "SigmoidProduct 1 2 0 3", "Bell 2 1 0"),
    *("SShape 3 1", "SShape 2 2", "ZShape 3 1", "ZShape 2 2", "SemiEllipse 3 1", "PiShape 1 1 2 3", "PiShape 1 1 1 3"),
    *("PiShape 1 1 2 2", "PiShape 1 1 3 inf", "PiShape 1 1 2 3 0.5", "Discrete 2 0.25", "Rectangle -inf inf"),
    "Binary -inf 0",
]

FCL = """FUNCTION_BLOCK f
VAR_INPUT a: REAL; END_VAR
VAR_OUTPUT y: REAL; END_VAR
FUZZIFY a
  RANGE := (0 .. 5);
  TERM t := {};
END_FUZZIFY
DEFUZZIFY y
  RANGE := (0 .. 5);
  TERM t := Triangle 0 1 2;
  METHOD : COG;
  DEFAULT := nan;
END_DEFUZZIFY
RULEBLOCK r
  AND : MIN; ACT : MIN; ACCU : MAX;
  RULE 1 : if a is t then y is t
END_RULEBLOCK
END_FUNCTION_BLOCK
"""

FIS = """[System]
Name='f'
Type='mamdani'
Version=6.0
NumInputs=1
NumOutputs=1
NumRules=1
[Input1]
Enabled=1
Name='a'
Range=[0 5]
NumMFs=1
MF1='t':'{}',[{}]
[Output1]
Enabled=1
Name='y'
Range=[0 5]
NumMFs=1
MF1='t':'trimf',[0 1 2]
[Rules]
1, 1 (1) : 1
"""


def errors(diagnostics):
    return [d.code for d in diagnostics if d.severity == "error"]


def measured(word):
    return pytest.approx([float(y) for y in MEASURED[word].split()], rel=6e-6)  # six digits were printed


@pytest.mark.parametrize("word", MEASURED)
def test_an_input_has_the_degrees_that_fuzzylite_computes(word):
    system, diagnostics = read("t.fll", FLL.format(word, "Triangle 0 1 2"))
    assert not errors(diagnostics)
    assert degrees(system, PLACES) == measured(word)
    usual = word in ("Bell 2 -1 2", "Spike 2 -1", "Gaussian 2 -1")  # there the sign alone says nothing
    reported = [d for d in diagnostics if d.code == "FZ609"]
    assert len(reported) == (not usual)
    assert all("it is read as fuzzylite computes it" in d.message and d.span.line == 4 for d in reported)


@pytest.mark.parametrize("word", MEASURED)
def test_an_output_has_them_where_they_are_a_set(word):
    system, diagnostics = read("t.fll", FLL.format("Ramp 0 1", word))
    if word in OF_OUTPUTS:
        as_input, _ = read("t.fll", FLL.format(word, "Triangle 0 1 2"))
        assert system.outputs[0].terms[0].membership == as_input.inputs[0].terms[0].membership
    elif word not in ("Bell 2 -1 2", "Spike 2 -1", "Gaussian 2 -1"):
        assert errors(diagnostics) in (["FZ301"], ["FZ302"])


@pytest.mark.parametrize(
    "word",
    [
        *("Ramp 2 2", "Rectangle 3 1", "Concave 2 2"),  # fuzzylite 6 and pyfuzzylite 8 differ
        *("Bell 2 0 2", "Spike 2 0", "Cosine 2 0", "Gaussian 2 0", "GaussianProduct 2 0 3 1"),  # NaN at the centre
        *("Discrete 3 0 2 1 1 0", "SemiEllipse 2 2", "Triangle -inf inf 2", "PiShape 0 3 1 inf", "Triangle inf inf 0"),
        *("Trapezoid 0 2 1 inf", "Bell 1 inf -2", "SigmoidDifference 0 inf 0 1", "Trapezoid -inf 0 -inf 0"),
    ],
)
def test_what_has_no_such_term_is_refused(word):
    _, diagnostics = read("t.fll", FLL.format(word, "Triangle 0 1 2"))
    assert errors(diagnostics) in (["FZ301"], ["FZ302"])


@pytest.mark.parametrize(
    ("word", "what"),
    [
        ("Triangle 0 2 4 2.5", "the height 2.5 of 'Triangle' lies outside [0, 1]"),
        ("Triangle 0 2 4 -1", "the height -1 of 'Triangle' lies outside [0, 1]"),
        ("Discrete 0 0 1 1 3", "the height 3 of 'Discrete' lies outside [0, 1]"),
        ("Constant 1.5", "the degree 1.5 lies outside [0, 1]"),
    ],
)
def test_degrees_beyond_1_are_refused_with_the_reason(word, what):
    _, diagnostics = read("t.fll", FLL.format(word, "Triangle 0 1 2"))
    (error,) = (d for d in diagnostics if d.severity == "error")
    assert (error.code, error.message, error.span.line) == ("FZ302", what, 4)
    assert "between 0 and 1" in error.help


def test_weights_beyond_1_are_refused_with_the_reason():
    _, diagnostics = read("t.fll", FLL.format("Ramp 0 1", "Triangle 0 1 2").replace("y is t", "y is t with 1.5"))
    (error,) = (d for d in diagnostics if d.severity == "error")
    assert (error.code, error.span.text) == ("FZ302", "1.5")
    assert "between 0 and 1" in error.help


def test_a_low_height_is_kept():
    system, _ = read("t.fll", FLL.format("Sigmoid 2 0 0.5", "SigmoidProduct 1 0 -2 3 0.5"))
    assert degrees(system, PLACES) == pytest.approx([0.25] * len(PLACES))
    assert system.outputs[0].terms[0].membership.height == fuzzyctl.build.expression(0.25)
    system, _ = read("t.fll", FLL.format("Bell 2 1 -2 0.5", "Triangle 0 1 2"))
    assert degrees(system, PLACES) == pytest.approx([0.5 * float(y) for y in MEASURED["Bell 2 1 -2"].split()], rel=6e-6)


@pytest.mark.parametrize(
    ("formula", "reported"), [("a / 2", True), ("a - 1", True), ("a / 5", False), ("1 / (a - a)", False)]
)
def test_formulas_that_leave_0_to_1_are_reported(formula, reported):
    _, diagnostics = read("t.fll", FLL.format(f"Function {formula}", "Triangle 0 1 2"))
    beyond = [d for d in diagnostics if d.code == "FZ609"]
    assert len(beyond) == reported
    if formula == "a / 2":
        assert "the degree of 't' is 2.5 at a = 5, and held within [0, 1] here" in beyond[0].message
    if formula == "a - 1":
        assert "is 4 at a = 5" in beyond[0].message


@pytest.mark.parametrize(("formula", "reported"), [("a / 2", True), ("a / 5", False)])
def test_so_they_are_in_its_fcl_and_fis(formula, reported):
    of_constants = FCL.format(f"Function {formula.replace('a', 'k * a')}").replace(
        "VAR_OUTPUT", "VAR k: REAL := 1; END_VAR\nVAR_OUTPUT"
    )
    texts = {"t.fis": FIS.format("function", formula), "t.fcl": of_constants}
    for name, text in texts.items():
        beyond = [d for d in read(name, text)[1] if d.code == "FZ609"]
        assert len(beyond) == reported
        assert all("the degree of 't' is 2.5 at a = 5, and held within [0, 1] here" in d.message for d in beyond)


@pytest.mark.parametrize(
    "word",
    [
        *("Bell 2 -1 2", "Spike 2 -1", "Gaussian 2 -1", "PiShape 0 3 1 4", "Sigmoid 2 0", "Triangle 2 1 3"),
        *("SShape 3 1", "Binary 2 2", "PiShape 1 1 2 3", "Discrete 2 0.25", "Binary -inf 0"),
    ],
)
def test_so_are_the_terms_of_its_fcl(word):
    system, diagnostics = read("t.fcl", FCL.format(word))
    assert not errors(diagnostics)
    assert degrees(system, PLACES) == measured(word)


@pytest.mark.parametrize("word", ["Trapezoid -inf -inf 1 2", "Trapezoid 1 2 inf inf", "Trapezoid -inf 0.5 1 2"])
def test_shoulders_with_two_infinite_corners_are_those_of_fll(word):
    own, diagnostics = read("t.fcl", FCL.format(word))
    assert not errors(diagnostics)
    there, _ = read("t.fll", FLL.format(word, "Triangle 0 1 2"))
    assert own.inputs[0].terms[0].membership == there.inputs[0].terms[0].membership


@pytest.mark.parametrize(("numbers", "given"), [("3", (3, 0)), ("3 4", (3, 4))])
def test_the_constant_of_a_linear_consequent_may_be_left_out(numbers, given):
    text = FCL.format("Triangle 0 1 2").replace(
        "t := Triangle 0 1 2;\n  METHOD : COG", f"t := Linear {numbers};\n  METHOD : COGS"
    )
    system, diagnostics = read("t.fcl", text)
    assert not errors(diagnostics)
    assert system.outputs[0].terms[0].membership.arguments == tuple(map(fuzzyctl.build.expression, given))


@pytest.mark.parametrize("word", ["Triangle 0 2 4 2.5", "Constant 1.5"])
def test_degrees_beyond_1_are_refused_there_too(word):
    _, diagnostics = read("t.fcl", FCL.format(word))
    assert errors(diagnostics) == ["FZ302"]


@pytest.mark.parametrize(
    ("function", "numbers", "word"),
    [
        ("trimf", "2 1 3", "Triangle 2 1 3"),
        ("pimf", "0 3 1 4", "PiShape 0 3 1 4"),
        ("pimf", "1 1 2 3", "PiShape 1 1 2 3"),
        ("sigmf", "0 2", "Sigmoid 2 0"),
        ("gbellmf", "-1 2 2", "Bell 2 -1 2"),
        ("cosinemf", "2 -3", "Cosine 2 -3"),
        ("smf", "3 1", "SShape 3 1"),
        ("zmf", "2 2", "ZShape 2 2"),
        ("trapmf", "0 3 1 2", "Trapezoid 0 3 1 2"),
        ("binarymf", "2 2", "Binary 2 2"),
    ],
)
def test_and_those_of_its_fis(function, numbers, word):
    system, diagnostics = read("t.fis", FIS.format(function, numbers))
    assert not errors(diagnostics)
    assert degrees(system, PLACES) == measured(word)


def test_a_constant_beyond_1_is_refused_there():
    assert errors(read("t.fis", FIS.format("constant", "1.5"))[1]) == ["FZ302"]


def test_a_step_to_itself_is_no_set_of_an_output():
    changed = FIS.format("trimf", "0 1 2").replace("'trimf',[0 1 2]\n[Rules]", "'binarymf',[2 2]\n[Rules]")
    for name, text in {"t.fis": changed, "t.fll": FLL.format("Ramp 0 1", "Binary 2 2")}.items():
        assert errors(read(name, text)[1]) == ["FZ302"]


def test_a_foot_without_width_is_pointed_at_once():
    system, diagnostics = read("t.fll", FLL.format("PiShape 1 1 2 3", "Triangle 0 1 2"))
    (reported,) = (d for d in diagnostics if d.code == "FZ609")
    assert "'PiShape': its left side has no width" in reported.message
    assert list(degrees(system, [1.0, math.nextafter(1.0, 2.0)])) == [0, 1]


def test_a_sigmoid_without_slope_is_a_half_at_infinity_too():
    system, _ = read("t.fll", FLL.format("Sigmoid 2 0", "Triangle 0 1 2"))
    assert list(degrees(system, [-math.inf, math.inf])) == [0.5, 0.5]


def test_matlab_has_no_such_terms():
    of_matlab = FIS.format("trimf", "2 1 3").replace("Version=6.0", "Version=2.0").replace("Enabled=1\n", "")
    assert errors(read("t.fis", of_matlab)[1]) == ["FZ301"]


def trapezoid(x, left, left_top, right_top, right):
    """The conditions of fuzzylite's manual, from the first to the last."""
    if x < left or x > right:
        return 0.0
    if left_top <= x <= right_top or (left == -math.inf and x < left_top) or (right == math.inf and x > right_top):
        return 1.0
    return (x - left) / (left_top - left) if x < left_top else (right - x) / (right - right_top)


CORNERS = st.integers(0, 6).map(float)


@given(st.tuples(CORNERS | st.just(-math.inf), CORNERS, CORNERS, CORNERS | st.just(math.inf)))
def test_trapezoids_in_any_order_are_cut_off_at_the_feet(corners):
    word = f"Trapezoid {' '.join(map(str, corners))}"
    system, diagnostics = read("t.fll", FLL.format(word, "Triangle 0 1 2"))
    assume(any(d.code == "FZ609" for d in diagnostics))
    places = [k / 4 for k in range(-4, 29)]
    computed = degrees(system, places)
    assert list(computed) == pytest.approx([trapezoid(x, *corners) for x in places], abs=1e-15)
