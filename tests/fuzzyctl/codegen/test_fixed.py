"""Fixed-point C stays within its proved bound, over all inputs if they can be counted."""

import re
from fractions import Fraction

import numpy as np
import pytest

import fuzzyctl
from tests.fuzzyctl.codegen.conftest import SANITIZED, run_c, text_of, written
from tests.fuzzyctl.codegen.steps.targets import by_integers, by_kernel
from tests.fuzzyctl.codegen.steps.texts import ADAPTIVE, SURFACE

pytestmark = pytest.mark.usefixtures("gcc")

CURVE = """
system curve
and product
defuzzifier weighted_average
input x in [-3, 3]
  terms a@{first} b@-0.7 c@0.1 d@1.3 e@2.9
output u in [-4, 4]
  p = constant(-3.9)
  q = constant({steep})
  r = constant(0.015)
if x is a then u is p
if x is b then u is q
if x is c then u is r
if x is d then u is p
if x is e then u is q
"""
#: A line from 0 to 1 on knots that the format has: only entries and results are rounded.
LINE = """
system line
and product
defuzzifier weighted_average
input x in [0, 1]
  terms a b
output u in [0, 1]
  p = constant(0)
  q = constant(1)
if x is a then u is p
if x is b then u is q
"""
TWO = """
system two
and product
defuzzifier weighted_average
input x in [0, 1]
  terms a b
input y in [0, 1]
  terms a b
output u in [-1, 1]
  p = constant(-1)
  q = constant(0.5)
output v in [0, 2]
  p = constant(0)
  q = constant(2)
if x is a then u is p, v is q
if x is b then u is q, v is p
"""


def fixed(text, form, *options):
    """Return what is written in fixed point."""
    found = written(text, "c", "--fixed", form, *options)
    assert found.code == 0, found.errors
    return found


def scale_of(form):
    return 2.0 ** -int(form.split(".")[1])


def largest_errors(text, form, points, folder, *options):
    """Return the largest error of each output at integer points, beside the kernel in double precision."""
    points = np.array(points)
    (found,) = by_integers([fixed(text, form, *options).files], [points], folder)
    kernel = fuzzyctl.compile(fuzzyctl.loads(text_of(text)), "numpy")
    return np.abs(found * scale_of(form) - kernel.batch(points * scale_of(form)).reshape(len(points), -1)).max(axis=0)


class TestBound:
    @pytest.mark.parametrize("form", ["Q2.13", "Q2.9", "Q2.4"])
    @pytest.mark.parametrize("steep", [3.3, -3.8])
    def test_holds_for_every_input_of_a_curve(self, tmp_path, form, steep):
        text = CURVE.format(first=-2.9, steep=steep)
        every = np.arange(-(2**15), 2**15)[:, None]
        (error,) = largest_errors(text, form, every, tmp_path)
        (bound,) = fixed(text, form).data["errors"].values()
        assert error <= bound
        # A bound far above what happens would hold as well.
        assert bound <= 4.0 * error

    @pytest.mark.parametrize(("form", "units"), [("Q3.12", 1.0), ("Q0.15", 2.6), ("Q1.30", 2.0)])
    def test_holds_for_the_immune_reaction_and_is_some_units(self, tmp_path, form, units):
        most = np.array([0.07, 1.1]) / scale_of(form)
        points = np.random.default_rng(3).uniform(-most, most, (20_000, 2)).clip(-(2**31), 2**31 - 1)
        points = points if form == "Q1.30" else points.clip(-(2**15), 2**15 - 1)
        (error,) = largest_errors("ais_reaction", form, points.astype(np.int64), tmp_path)
        assert error <= fixed("ais_reaction", form).data["errors"]["f"] <= units * scale_of(form)

    def test_adds_up_the_roundings_of_entry_share_interpolation_and_result(self, tmp_path):
        points = np.arange(-10, 5000)[:, None]
        (found,) = by_integers([fixed(LINE, "Q3.12").files], [points], tmp_path)
        bound = Fraction(fixed(LINE, "Q3.12").data["errors"]["u"])
        for x, u in zip(points.ravel().tolist(), found.ravel().tolist(), strict=True):
            assert abs(Fraction(u, 4096) - Fraction(min(max(x, 0), 4096), 4096)) <= bound
        assert Fraction(1, 2**13) < bound < Fraction(1, 2**12)

    def test_adds_that_of_a_table(self, tmp_path):
        bound = fixed("boundary_layer", "Q0.15", "--table", "6").data["errors"]["beta"]
        table = written("boundary_layer", "c", "--table", "6").data["errors"]["beta"]
        assert bound >= table > fixed("boundary_layer", "Q0.15").data["errors"]["beta"]
        points = np.arange(-100, 2200)[:, None]
        assert largest_errors("boundary_layer", "Q0.15", points, tmp_path, "--table", "6")[0] <= bound


class TestCode:
    @pytest.mark.parametrize(
        ("text", "form"),
        [("ais_reaction", f) for f in ("Q3.12", "Q1.14", "Q0.15", "Q1.30", "Q10.5")] + [(TWO, "Q3.12")],
    )
    def test_computes_the_expected_integers_without_floating_point(self, tmp_path, text, form):
        files = fixed(text, form).files
        assert not re.search(r"\b(float|double)\b|math\.h", re.sub("//.*", "", "".join(files.values())))
        built = run_c(files, tmp_path, SANITIZED)
        assert built.code == 0, built.output
        assert "worst error 0 units" in built.output

    def test_a_wrong_entry_is_found(self, tmp_path):
        files = dict(fixed("boundary_layer", "Q0.15").files)
        entry = max(re.findall(r"\b\d+(?=U\b)", files["boundary_layer.c"].split("T0[")[-1]), key=int)
        files["boundary_layer.c"] = files["boundary_layer.c"].replace(f"{entry}U", "7U")
        assert run_c(files, tmp_path).code == 1

    def test_the_header_prints_a_bound_that_holds(self):
        for form in ("Q3.12", "Q1.14"):
            found = fixed("ais_reaction", form)
            bound, steps = re.search(
                r"\|f - exact f\| <= (\S+), that is (\S+) / 2", found.files["ais_reaction.h"]
            ).groups()
            exact = found.data["errors"]["f"]
            assert exact <= float(bound) <= 1.001 * exact
            assert exact / scale_of(form) <= float(steps) <= 1.001 * exact / scale_of(form)


class TestEnds:
    @pytest.mark.parametrize("form", ["Q0.15", "Q0.6"])
    def test_in_the_header_are_those_of_the_integers(self, tmp_path, form):
        """Of all inputs of the type; in few bits they lie outside those of the system."""
        files = fixed("boundary_layer", form).files
        ends = re.search(r"proved: (\S+) <= beta <= (\S+) for all inputs", files["boundary_layer.h"]).groups()
        most = 2 ** (15 if form == "Q0.15" else 7)
        (integers,) = by_integers([files], [np.arange(-most, most)[:, None]], tmp_path)
        found = integers * scale_of(form)
        assert tuple(map(float, ends)) == (found.min(), found.max())
        assert (found.min() < 0.005) == (form != "Q0.15")

    def test_of_the_type_are_used_in_full(self, tmp_path):
        """The function reaches -1, which Q0.15 has, and its input 1, which Q0.15 has not, to no effect."""
        files = fixed("ais_reaction", "Q0.15").files
        assert by_integers([files], [np.array([[-32768, -32768]])], tmp_path)[0].tolist() == [[-32768]]
        assert "Hold dsigma within [-1.0, 0.999969482421875] before it is converted" in files["ais_reaction.h"]
        assert "Hold" not in fixed("ais_reaction", "Q1.14").files["ais_reaction.h"]

    @pytest.mark.parametrize(
        ("end", "refused"),
        [
            (1.0 - 2.0**-15, False),
            (1.0 - 2.0**-15 + 2.0**-19, False),
            (-1.0 - 2.0**-19, False),
            (1.0 - 2.0**-16, True),
            (-1.0 - 2.0**-16, True),
        ],
    )
    def test_are_not_left_by_rounding_and_refused_beyond(self, tmp_path, end, refused):
        text = CURVE.replace("-3.9", repr(end)).format(first=-0.9, steep=0.5)
        text = re.sub(r"@-?[.0-9]+", "", text.replace("[-3, 3]", "[-0.9, 0.9]"))
        if refused:
            words = r"Q0\.15 reaches from -1 to 0\.999969482, and 'u' from .*; Q1\.14 does"
            assert re.search(words, written(text, "c", "--fixed", "Q0.15").errors)
            return
        (found,) = by_integers([fixed(text, "Q0.15").files], [np.arange(-32768, 32768)[:, None]], tmp_path)
        assert (found.max() == 32767) if end > 0 else (found.min() == -32768)


HEAD = "controller c\ninput x in [-2, 2]\ninput y in [-2, 2]\n"
FAR = re.sub(r"(@-?[.0-9]+)", r"\1e10", CURVE.format(first=-2.9, steep=1)).replace("[-3, 3]", "[-3e10, 3e10]")
UNEVEN = CURVE.format(first=-2.9, steep=1).replace("then u is r", "then u is r weight 0.5")


class TestRefusal:
    @pytest.fixture(autouse=True)
    def _soon(self, monkeypatch):
        """Let bounds of tables be found soon; they are wider then, and hold as well."""
        monkeypatch.setattr("fuzzyctl.codegen.table_error.MOST_OPERATIONS", 400_000)
        monkeypatch.setattr("fuzzyctl.codegen.fixed.fixed_system._POINTS", (9,))

    @pytest.mark.parametrize(
        ("name", "form", "reason"),
        [
            ("tipper", "Q3.12", r"not all defuzzifiers are averages over .*; --table 9 --fixed Q5\.10 does, off by \d"),
            ("fcafsmc", "Q3.12", r"it has a state; nor does a table take its place: a system with a state has no t"),
            ("takagi", "Q3.12", r"nor does a table take its place: an output has no value at x = 5, y = -1"),
            ("hedged", "Q3.12", r"nor does a table take its place: no useful bound is found"),
            ("boundary_layer", "Q7.0", r"'beta' in Q7\.0: at most 0\.501, of a span of 0\.045; Q0\.15 does, off by"),
            ("boundary_layer", "Q0.4", r"Q0\.15 does, off by 1\.65e-05 at most"),
            ("tipper --table 9", "Q3.12", r"Q3\.12 reaches from -8 to .*'food' from 0 to 10, 'tip'.*; Q5\.10 does"),
            (FAR, "Q3.12", r"'x' from -2\.9e\+10 to 2\.9e\+10; nor does any other format of up to 32 bits"),
            (UNEVEN, "Q3.12", r"sum to 1, and those .*; --table 9 --fixed Q3\.12 does"),
            ("ais_reaction --algorithm rules", "Q3.12", "algorithm 'rules' excludes; take --algorithm interpolation"),
        ],
    )  # fmt: skip
    def test_names_its_reason_and_help_that_works(self, name, form, reason):
        text, *options = name.split() if "\n" not in name else [name]
        found = written(text, "c", "--fixed", form, *options)
        assert found.code != 0
        told = " ".join(found.errors.split())
        assert re.search(reason, told), told
        other = re.search(r"(?:--table (\d+) --fixed )?(Q\d+\.\d+) does", told)
        if other:
            assert fixed(text, other[2], *options, *(["--table", other[1]] if other[1] else []))

    def test_formats_that_no_type_has_are_wrong_usage(self):
        for form in ("3.12", "Q3", "Q-1.3", "Q16.16", "Q0.0", "Q3.12f", "", "Q99.99"):
            assert written(LINE, "c", "--fixed", form).code == 2
        widths = [re.search(r"int(\d+)_t line", fixed(LINE, f).files["line.h"])[1] for f in ("Q3.12", "q8.8", "Q15.16")]
        assert widths == ["16", "32", "32"]


def step_of(lines, form="Q5.10", period="every 50 ms\n", head=HEAD):
    """Return what is written of a controller."""
    return written(head + lines + "\n" + period, "c", "--fixed", form, "--unproved")


class TestSteps:
    @pytest.mark.parametrize(
        "lines",
        [
            "output u = x - y",
            "output u = previous(x) + delay(y, 200)",
            "output u = 2 * difference(x) + max(abs(y), 0.25)",
            "output u = hysteresis(x - y, -0.3, 0.1)",
            "output u = rate_limit(x, 2.5)",
            "output u = where(x < 0.1 or y > x, x, 0.5)",
            "state k = 0\nnext k = where(k >= 9, 0, k + 1)\noutput u = where(k == 3, x, y)",
            "state s in [-2, 2] = 0.25\nnext s = clamp(s + x, -2, 2)\noutput u = s",
        ],
    )
    def test_what_the_format_holds_whole_is_equal_at_every_step(self, lines):
        assert step_of(lines).data["errors"] == {"u": 0.0}

    def test_of_a_product_is_half_a_unit_and_of_a_lag_grows_with_its_time(self):
        (error,) = step_of("output u = x * y").data["errors"].values()
        assert Fraction(1, 2048) <= Fraction(error) <= Fraction(1, 2047)
        lags = [step_of(f"output u = lowpass(x, {t})", "Q5.26").data["errors"]["u"] for t in (0.05, 0.5, 5)]
        assert lags == sorted(lags)
        assert lags[2] > lags[0]

    def test_inputs_without_a_range_have_that_of_the_format(self):
        assert step_of("output u = 0.5 * x", head="controller c\ninput x\n").code == 0

    def test_a_system_that_nothing_reads_is_left_out(self):
        curved = SURFACE.replace("  terms N Z P\noutput", "  N = gaussian(0, 1)\n  Z = gaussian(1, 1)\n"
                                 "  P = ramp(1, 2)\noutput")  # fmt: skip
        assert step_of("let z = surface(x, y)\noutput u = x", head=curved + HEAD).data["errors"] == {"u": 0.0}

    @pytest.mark.parametrize(
        ("lines", "words"),
        [
            (
                "state s in [-2, 2] = 0\nnext s = clamp(s + 0.01 * x, -2, 2)\noutput u = s",
                r"no bound of the error of state 's' holds over all steps.*\"line\": 4,.*it keeps its error, as an i"
                r"ntegrator does, and each step may add that of a rounding.*--float float",
            ),
            ("output u = clamp(integral(x), -1, 1)", "no range of the state of 'integral' is proved.*least and"),
            ("output u = rate_limit(x, 2)", "no bound of the error of the state of 'rate_limit'.*keeps its error"),
            ("output u = sin(x)", "fixed point has no 'sin'"),
            ("output u = x / (y + 3)", "fixed point divides by numbers only"),
            ("output u = x^0.5", "fixed point has no powers but"),
            ("output u = where(lowpass(x, 1) > 0.3, 1, -1)", "no useful bound is found for the error of 'u'.*'u' j"),
            ("output u = hysteresis(lowpass(x, 1), 0, 1)", "the error of the state of 'hysteresis'.*'u' jumps where"),
            ("output u = 30 * x", "Q5.10 reaches from -32 to 31.9990234, and 'u' from -60 to 60"),
            ("output u = 1e9 * x - 1e9 * y - 1e9 * x^2", "beyond integers of 32 bits"),
            (
                "state a in [-9, 9] = 0\nstate b in [-9, 9] = 0\nnext a = clamp(0.8 * b + x, -9, 9)\n"
                "next b = clamp(1.3 * a, -9, 9)\noutput u = a",
                "no bound of the error of state.*states make each other's errors larger step by step",
            ),
        ],
    )  # fmt: skip
    def test_refusals_say_why(self, lines, words):
        found = step_of(lines)
        assert found.code == 1
        assert "FZ410" in found.errors
        assert re.search(words, " ".join(found.errors.split())), found.errors

    @pytest.mark.parametrize(
        ("options", "words"),
        [
            ({"lines": "output u = x", "period": ""}, "needs a sample time"),
            ({"lines": "output u = 2 * x", "head": "controller c\ninput x\n"}, "give 'x' a range"),
            (
                {"lines": "output u = gain(x, y)", "head": ADAPTIVE + HEAD},
                "fixed point needs systems that interpolate, and 'gain' does not: it has a state",
            ),
            (
                {"lines": "output u = surface(x, y)", "head": SURFACE.replace("and product", "and min") + HEAD},
                "fixed point needs systems that interpolate, and 'surface' does not: ",
            ),
        ],
    )
    def test_refusals_name_what_is_needed(self, options, words):
        found = step_of(**options)
        assert found.code == 1
        assert words in " ".join(found.errors.split())

    def test_proposals_are_accepted(self):
        told = " ".join(step_of("output u = clamp(x + integral(x), -1, 1)").errors.split())
        state, update = re.findall(r"'((?:state|next) [^']*)'", told)
        assert step_of(f"{state}\n{update}\noutput u = clamp(x + sum, -1, 1)").code == 0
        lines = "output u = 30 * x"
        assert step_of(lines, re.search(r"--fixed (Q\S+\d)", step_of(lines).errors)[1]).data["errors"]["u"] < 1e-3

    def test_a_step_without_a_state_that_no_round_settles_is_refused(self, monkeypatch):
        monkeypatch.setattr("fuzzyctl.codegen.fixed.fixed_step._ROUNDS", 0)
        words = "no integers of 32 bits hold a step in Q5.10 with its roundings"
        assert words in step_of("output u = x / 3").errors


SAMPLE = (
    SURFACE
    + HEAD.replace("controller c", "controller sample")
    + """let d = derivative(x - y, filter=0.3 s)
let w = lowpass(surface(0.7 * (x - y), 0.05 * d), 0.2 s)
output u in [-3, 3] = clamp(w + 0.5 * x, -3, 3)
output v in [-2, 2] = where(x > 0.3, delay(y, 7), previous(x))
every 50 ms
"""
)


class TestSample:
    def test_keeps_the_bound_beside_the_kernel(self, tmp_path):
        step = fixed(SAMPLE, "Q3.12", "--unproved")
        rows = np.random.default_rng(1).integers(-9000, 9000, (4000, 2))
        (found,) = by_integers([step.files], [rows], tmp_path, SANITIZED)
        off = np.abs(found / 4096.0 - by_kernel(SAMPLE, np.clip(rows, -8192, 8192) / 4096.0)).max(axis=0)
        bounds = np.array([*step.data["errors"].values()])
        assert np.all(off <= bounds)
        # A bound far above what happens would hold as well.
        assert off[0] > 0.5 * bounds[0]

    @pytest.mark.parametrize(
        ("old", "new"),
        [
            ("", ""),
            ("state->started = v", "state->started = 0 * v"),
            ("< 6U)", "< 5U)"),
            ("(shift - 1U)", "(shift - 2U)"),
        ],
    )
    def test_the_self_test_finds_what_is_wrong(self, tmp_path, old, new):
        files = dict(fixed(SAMPLE, "Q3.12", "--unproved").files)
        assert old in files["sample.c"]
        assert not re.search(r"\b(float|double)\b|\d\.\d|math\.h", re.sub("//.*", "", files["sample.c"]))
        files["sample.c"] = files["sample.c"].replace(old, new) if old else files["sample.c"]
        assert run_c(files, tmp_path).code == (1 if old else 0)
