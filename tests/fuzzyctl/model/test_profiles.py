"""Profiles reproduce what was measured with the tools themselves, to the digits that were noted."""

import pytest

import fuzzyctl
from fuzzyctl import as_profile, dumps, loads
from tests.tipper import FUZZYLITE, POINTS, TIPS

TIPPER = """system tipper
input service in [0, 10]
  poor = gaussian(0, 1.5)
  good = gaussian(5, 1.5)
  excellent = gaussian(10, 1.5)
input food in [0, 10]
  rancid = trapezoid(-inf, 0, 1, 3)
  delicious = trapezoid(7, 9, 10, inf)
output tip in [0, 30]
  cheap = triangle(0, 5, 10)
  average = triangle(10, 15, 20)
  generous = triangle(20, 25, 30)
if service is poor or food is rancid then tip is cheap
if service is good then tip is average
if service is excellent or food is delicious then tip is generous
"""


@pytest.fixture(scope="module")
def tipper():
    return fuzzyctl.loads(TIPPER)


def under(text, name):
    return fuzzyctl.as_profile(fuzzyctl.loads(text), name)


class TestMeasuredNumbers:
    @pytest.mark.parametrize("name", TIPS)
    def test_the_tipper_of_matlab(self, tipper, name):
        kernel = fuzzyctl.compile(as_profile(tipper, name), "python")
        assert kernel.batch(POINTS) == pytest.approx(TIPS[name], abs=0.51e-10)

    def test_fuzzylite_leaves_out_what_fires_below_a_millionth(self):
        text = TIPPER.replace("\ninput", "\nsemantics fuzzylite{}\ndefuzzifier centroid(resolution=200)\ninput", 1)
        found = [
            fuzzyctl.compile(fuzzyctl.loads(text.replace("{}", knobs)), "python")(2, 1) for knobs in ("", "(least=0)")
        ]
        assert [round(x, 9) for x in found] == [FUZZYLITE[0], 7.014331192]
        kernel = fuzzyctl.compile(fuzzyctl.loads(text.replace("{}", "")), "python")
        assert [round(kernel(*p), 9) for p in POINTS[1:]] == list(FUZZYLITE[1:])

    def test_a_previous_value_is_kept_from_call_to_call(self):
        system = fuzzyctl.loads(
            "system s\nsemantics pyfuzzylite\ndefuzzifier weighted_average\ninput x in [0, 3]\n"
            "  none = rectangle(0, 0.5)\n  one = rectangle(0.6, 1.4)\n  two = rectangle(1.5, 3)\n"
            "output y in [0, 10] else hold(9)\n  one = constant(1)\n  two = constant(2)\n"
            "if x is one then y is one\nif x is two then y is two\nif x is none then y is one weight 0\n"
        )
        for backend in ("python", "numpy"):
            kernel = fuzzyctl.compile(system, backend)
            found, _ = kernel.run([[0.0], [1.0], [0.0], [2.0], [0.0], [0.0], [1.0], [0.0]])
            assert found.tolist() == [9, 1, 1, 2, 2, 2, 1, 1]

    def test_simpful_leaves_weights_out_of_what_it_divides_by(self):
        text = (
            "system s\nsemantics {}\ndefuzzifier weighted_average\ninput x in [0, 1]\n  a = triangle(-inf, 0, inf)\n"
            "output y in [0, 10]\n  ten = constant(10)\nif x is a then y is ten weight 0.5\n"
        )
        assert fuzzyctl.loads(text.format("simpful"))(x=0) == 5.0
        assert fuzzyctl.loads(text.format("matlab"))(x=0) == 10.0

    def test_a_weight_counts_before_or_after_implication(self):
        text = (
            "system s\nsemantics exact(weight={})\ninput x in [0, 1]\n  terms a b\noutput y in [0, 10] else nan\n"
            "  low = triangle(0, 2, 4)\n  high = triangle(6, 8, 10)\n"
            "if x is a then y is low\nif x is b then y is high weight 0.5\n"
        )
        before, after = (fuzzyctl.loads(text.format(when))(x=0.6) for when in ("before", "after"))

        def area(height):  # of a triangle of width 4 that is cut
            return 4 * height - 2 * height**2

        low, high, scaled = area(0.4), area(0.3), 0.5 * area(0.6)
        assert before == pytest.approx((2 * low + 8 * high) / (low + high), abs=1e-12)
        assert after == pytest.approx((2 * low + 8 * scaled) / (low + scaled), abs=1e-12)


def names(system):
    with pytest.raises(fuzzyctl.UnknownNameError, match="did you mean 'matlab'") as error:
        as_profile(system, "matlap")
    return error.value.known


class TestAsProfile:
    def test_the_system_stays_and_its_numerics_are_those_of_a_file(self, tipper):
        assert len(names(tipper)) > 8
        for name in names(tipper):
            other = as_profile(tipper, name)
            assert (other.inputs, other.blocks, other.params) == (tipper.inputs, tipper.blocks, tipper.params)
            method = loads(TIPPER.replace("\ninput", f"\nsemantics {name}\ninput", 1)).method
            assert (other.method.semantics, other.method.defuzzifier) == (method.semantics, method.defuzzifier)
            assert other.method.semantics.profile == name
            assert as_profile(other, name) == other == loads(dumps(other))

    def test_every_knob_is_printed_and_read_back(self):
        own = "fuzzylite(least=none, equal=0.25, total=strengths)"
        for form in (own, f"{own}\ndefuzzifier centroid(resolution=exact)"):
            system = loads(TIPPER.replace("\ninput", f"\nsemantics {form}\ninput", 1))
            assert loads(dumps(system)) == system

    def test_what_an_output_is_without_a_rule_changes_where_it_was_the_default(self, tipper):
        matlab = as_profile(tipper, "matlab")
        assert matlab.outputs[0].otherwise == "midpoint"
        assert as_profile(matlab, "jfuzzylogic").outputs[0].otherwise.start == "nan"
        said = loads(TIPPER.replace("[0, 30]", "[0, 30] else 4"))
        assert as_profile(said, "matlab").outputs == said.outputs

    def test_tools_whose_files_say_how_many_samples_there_are_keep_the_number(self):
        text = TIPPER.replace("\ninput", "\nsemantics fuzzylite\ndefuzzifier centroid(resolution=200)\ninput", 1)
        assert under(text, "pyfuzzylite").method.defuzzifier.resolution == 200
        assert under(text, "matlab").method.defuzzifier.resolution == 101
        assert under(text, "exact").method.defuzzifier.resolution is None
        usual = text.replace("(resolution=200)", "")
        assert under(usual, "pyfuzzylite").method.defuzzifier.resolution == 1000

    def test_an_output_with_a_defuzzifier_of_its_own_changes_too(self):
        text = TIPPER.replace("[0, 30]", "[0, 30] defuzzifier centroid(resolution=50)")
        other = under(text, "octave_0_4")
        assert other.outputs[0].defuzzifier == other.method.defuzzifier

    def test_a_tool_may_lack_what_a_system_needs(self):
        ramps = TIPPER.replace("triangle(0, 5, 10)", "ramp(0, 10)").replace("triangle(10, 15, 20)", "ramp(10, 20)")
        ramps = ramps.replace("triangle(20, 25, 30)", "ramp(20, 30)").replace(
            "\ninput", "\ndefuzzifier tsukamoto\ninput", 1
        )
        with pytest.raises(fuzzyctl.DiagnosticError, match="MATLAB Fuzzy Logic Toolbox has no 'tsukamoto'"):
            under(ramps, "matlab")
        assert under(ramps, "fuzzylite").method.semantics.places == "free"
        few = TIPPER.replace("\ninput", "\nactivation highest(count=1)\ninput", 1)
        with pytest.raises(fuzzyctl.DiagnosticError, match="has no activation 'highest'"):
            under(few, "octave")
