"""Fixed point stays within its proved bound, over all inputs where they can be counted."""

import math
import re
from fractions import Fraction

import numpy as np
import pytest

from fuzzyctl import loads
from fuzzyctl.codegen import table_error
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.files import generate
from fuzzyctl.codegen.fixed.fixed_format import Format, to_format
from fuzzyctl.codegen.fixed.fixed_system import fixed_point
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.codegen.table import at_most
from fuzzyctl.kernels.compile import compile as compile_system

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


def errors_of(unit, fixed, points):
    """Return the largest error of each output at integer points, against the kernel in double precision."""
    scale = 2.0**-fixed.format.fraction
    points = np.asarray(points, dtype=np.int64)
    kernel = compile_system(unit.system, "numpy")
    exact = kernel.batch(points * scale).reshape(len(points), -1)
    found = np.array([fixed.evaluate(p) for p in points.tolist()]) * scale
    return np.abs(found - exact).max(axis=0)


class TestBound:
    @pytest.mark.parametrize("text", ["Q2.13", "Q2.9", "Q2.4"])
    @pytest.mark.parametrize("steep", [3.3, -3.8])
    def test_holds_for_every_input_of_a_curve(self, text, steep):
        own = CURVE.format(first=-2.9, steep=steep)
        unit = prepare(loads(own), own)
        fixed = fixed_point(unit, to_format(text))
        every = [[x] for x in range(-fixed.format.most - 1, fixed.format.most + 1)]
        (error,) = errors_of(unit, fixed, every)
        assert error <= fixed.errors[0]
        # A bound far above what happens would hold as well.
        assert fixed.errors[0] <= 4.0 * error

    @pytest.mark.parametrize(("text", "units"), [("Q3.12", 1.0), ("Q0.15", 2.6), ("Q1.30", 2.0), ("Q4.11", 1.0)])
    def test_holds_for_the_immune_reaction_and_is_some_units(self, unit_of, text, units):
        unit = unit_of("ais_reaction")
        fixed = fixed_point(unit, to_format(text))
        rng = np.random.default_rng(3)
        most = fixed.format.most
        reach = [(max(a.least - 3, -most - 1), min(a.most + 3, most)) for a in fixed.axes]
        points = np.stack([rng.integers(low, high, 20_000) for low, high in reach], axis=1)
        (error,) = errors_of(unit, fixed, points)
        assert error <= fixed.errors[0] <= units * 2.0**-fixed.format.fraction

    def test_is_exact_arithmetic_not_a_sample(self, unit_of):
        """The same by hand, for a line from 0 to 1 on knots that the format has: only entries and results round."""
        text = (
            "system s\nand product\ndefuzzifier weighted_average\ninput x in [0, 1]\n  terms a b\n"
            "output u in [0, 1]\n  p = constant(0)\n  q = constant(1)\nif x is a then u is p\nif x is b then u is q\n"
        )
        fixed = fixed_point(prepare(loads(text), text), Format(3, 12))
        for x in range(-10, 5000):
            exact = Fraction(min(max(x, 0), 4096), 4096)
            assert abs(Fraction(fixed.evaluate([x])[0], 4096) - exact) <= Fraction(fixed.errors[0])

    def test_adds_up_every_rounding(self):
        """Of a line on knots that the format has: entry, share, interpolation, result, and the table's own floats."""
        text = (
            "system s\nand product\ndefuzzifier weighted_average\ninput x in [0, 1]\n  terms a b\n"
            "output u in [0, 1]\n  p = constant(0)\n  q = constant(1)\nif x is a then u is p\nif x is b then u is q\n"
        )
        fixed = fixed_point(prepare(loads(text), text), Format(3, 12))
        entry = Fraction(1, 2 ** (12 + fixed.outputs[0].guard)) / 2
        share = Fraction(1, 2 ** (fixed.share_bits + 1)) * (1 + 2 * entry)
        result = Fraction(1, 2**13)
        assert 0 <= fixed.errors[0] - float(entry + share + entry + result) <= 1e-12

    def test_adds_that_of_a_table(self, unit_of):
        unit = unit_of("boundary_layer", table=6)
        plain = fixed_point(unit_of("boundary_layer"), to_format("Q0.15"))
        fixed = fixed_point(unit, to_format("Q0.15"))
        assert fixed.errors[0] >= unit.table.errors[0] > plain.errors[0]
        (error,) = errors_of(unit, fixed, [[x] for x in range(-100, 2200)])
        assert error <= fixed.errors[0]


class TestCode:
    @pytest.mark.parametrize("text", ["Q3.12", "Q1.14", "Q1.30", "Q4.20", "Q10.5"])
    def test_computes_the_expected_integers(self, compiled, unit_of, sanitized, text):
        unit = unit_of("ais_reaction")
        built = compiled(unit, sanitized, fixed_point(unit, to_format(text)))
        assert built.code == 0, built.output
        assert "worst error 0 units" in built.output

    def test_a_wrong_entry_is_found(self, compiled, unit_of):
        unit = unit_of("boundary_layer")
        fixed = fixed_point(unit, to_format("Q0.15"))
        entry = f"{max(fixed.outputs[0].values)}U"

        def change(name, text):
            assert name != "boundary_layer.c" or entry in text
            return text.replace(entry, "7U") if name == "boundary_layer.c" else text

        assert compiled(unit, fixed=fixed, change=change).code == 1

    @pytest.mark.parametrize("name", ["ais_reaction", "boundary_layer"])
    def test_has_no_floating_point_in_it(self, unit_of, name):
        unit = unit_of(name)
        files = generate(unit, "c", fixed_point(unit, to_format("Q1.14"))).files
        for text in files.values():
            code = "\n".join(line.split("//")[0] for line in text.splitlines())
            assert "float" not in code
            assert "double" not in code
            assert "math.h" not in code

    def test_the_header_prints_the_bound(self, unit_of):
        unit = unit_of("ais_reaction")
        fixed = fixed_point(unit, to_format("Q3.12"))
        header = generate(unit, "c", fixed).files["ais_reaction.h"]
        assert f"|f - exact f| <= {at_most(fixed.errors[0], 6)}, that is" in header
        assert "int16_t ais_reaction(int16_t sigma, int16_t dsigma);" in header

    def test_several_outputs_and_inputs_that_nothing_reads(self, compiled, sanitized):
        text = (
            "system s\nand product\ndefuzzifier weighted_average\ninput x in [0, 1]\n  terms a b\n"
            "input y in [0, 1]\n  terms a b\noutput u in [-1, 1]\n  p = constant(-1)\n  q = constant(0.5)\n"
            "output v in [0, 2]\n  p = constant(0)\n  q = constant(2)\n"
            "if x is a then u is p, v is q\nif x is b then u is q, v is p\n"
        )
        unit = prepare(loads(text), text)
        fixed = fixed_point(unit, to_format("Q3.12"))
        assert len(fixed.axes) == 1
        built = compiled(unit, sanitized, fixed)
        assert built.code == 0, built.output


class TestEnds:
    @pytest.mark.parametrize("text", ["Q0.15", "Q0.6", "Q3.5"])
    def test_in_the_header_are_those_of_the_integers(self, unit_of, text):
        """Of all inputs of the type; in few bits they lie outside those of the system."""
        unit = unit_of("boundary_layer")
        fixed = fixed_point(unit, to_format(text))
        header = generate(unit, "c", fixed).files["boundary_layer.h"]
        ends = re.search(r"proved: (\S+) <= beta <= (\S+) for all inputs", header).groups()
        most = fixed.format.most
        found = {fixed.evaluate([x])[0] / 2**fixed.format.fraction for x in range(-most - 1, most + 1)}
        assert tuple(map(float, ends)) == (min(found), max(found))
        assert (min(found) < 0.005) == (text != "Q0.15")

    def test_of_the_type_are_used_in_full(self, compiled, unit_of, sanitized):
        """The function reaches -1, which Q0.15 has, and its input 1, which Q0.15 has not, to no effect."""
        unit = unit_of("ais_reaction")
        fixed = fixed_point(unit, to_format("Q0.15"))
        assert fixed.evaluate([-32768, -32768]) == (-32768,)
        header = generate(unit, "c", fixed).files["ais_reaction.h"]
        assert "Hold dsigma within [-1.0, 0.999969482421875] before it is converted" in header
        built = compiled(unit, sanitized, fixed)
        assert built.code == 0, built.output
        assert "Hold" not in generate(unit, "c", fixed_point(unit, to_format("Q1.14"))).files["ais_reaction.h"]

    @pytest.mark.parametrize("end", [1.0 - 2.0**-15, 1.0 - 2.0**-15 + 2.0**-19, -1.0 - 2.0**-19])
    def test_are_not_left_by_rounding(self, end):
        text = CURVE.replace("-3.9", repr(end)).format(first=-0.9, steep=0.5)
        text = re.sub(r"@-?[.0-9]+", "", text.replace("[-3, 3]", "[-0.9, 0.9]"))
        fixed = fixed_point(prepare(loads(text), text), to_format("Q0.15"))
        found = [fixed.evaluate([x])[0] for x in range(-32768, 32768, 7)]
        assert -32768 <= min(found) <= max(found) <= 32767
        assert (max(found) == 32767) if end > 0 else (min(found) == -32768)

    @pytest.mark.parametrize("end", [1.0, 1.0 - 2.0**-16, -1.0 - 2.0**-16])
    def test_that_lie_beyond_are_refused(self, end):
        text = CURVE.replace("-3.9", repr(end)).format(first=-0.9, steep=0.5)
        text = re.sub(r"@-?[.0-9]+", "", text.replace("[-3, 3]", "[-0.9, 0.9]"))
        with pytest.raises(
            CodegenError, match=r"^Q0\.15 reaches from -1 to 0\.999969482, and 'u' from .*; Q1\.14 does"
        ):
            fixed_point(prepare(loads(text), text), to_format("Q0.15"))


def proposed(reason):
    """Return the options that a refusal names."""
    form = re.search(r"(Q\d+\.\d+) does", reason)[1]
    table = re.search(r"--table (\d+)", reason)
    return to_format(form), {"table": int(table[1])} if table else {}


class TestRefusal:
    @pytest.fixture(autouse=True)
    def _soon(self, monkeypatch):
        """Let bounds of tables be found soon; they are wider then, and hold as well."""
        monkeypatch.setattr(table_error, "MOST_OPERATIONS", 400_000)
        monkeypatch.setattr("fuzzyctl.codegen.fixed.fixed_system._POINTS", (9,))

    @pytest.mark.parametrize(
        ("name", "reason"),
        [
            ("tipper", r"not all defuzzifiers are averages over rules; --table 9 --fixed Q5\.10 does, off by \d"),
            ("fcafsmc", r"it has a state; nor does a table take its place: a system with a state has no table$"),
            ("takagi", r"nor does a table take its place: an output has no value at x = 5, y = -1$"),
            ("hedged", r"nor does a table take its place: no useful bound is found"),
        ],
    )
    def test_names_its_reason_and_help_that_works(self, unit_of, name, reason):
        with pytest.raises(CodegenError, match=reason) as error:
            fixed_point(unit_of(name), to_format("Q3.12"))
        if "does, off by" in reason:
            form, options = proposed(str(error.value))
            assert fixed_point(unit_of(name, **options), form)

    @pytest.mark.parametrize("algorithm", ["rules", "active"])
    def test_of_an_algorithm_that_was_asked_for(self, unit_of, algorithm):
        reason = f"needs interpolation, which algorithm '{algorithm}' excludes; take --algorithm interpolation"
        with pytest.raises(CodegenError, match=reason):
            fixed_point(unit_of("ais_reaction", algorithm=algorithm), to_format("Q3.12"))

    @pytest.mark.parametrize(
        ("name", "options", "text", "reason"),
        [
            (
                "boundary_layer",
                {},
                "Q7.0",
                r"'beta' in Q7\.0: at most 0\.501, of a span of 0\.045; Q0\.15 does, off by",
            ),
            ("boundary_layer", {}, "Q0.4", r"Q0\.15 does, off by 1\.65e-05 at most"),
            (
                "tipper",
                {"table": 9},
                "Q3.12",
                r"Q3\.12 reaches from -8 to .*'food' from 0 to 10, 'tip'.*; Q5\.10 does",
            ),
        ],
    )
    def test_of_a_format_names_one_that_does(self, unit_of, name, options, text, reason):
        unit = unit_of(name, **options)
        with pytest.raises(CodegenError, match=reason) as error:
            fixed_point(unit, to_format(text))
        form, _ = proposed(str(error.value))
        assert form.bits == to_format(text).bits
        assert fixed_point(unit, form)

    def test_says_where_no_format_does(self):
        text = re.sub(r"(@-?[.0-9]+)", r"\1e10", CURVE.format(first=-2.9, steep=1)).replace("[-3, 3]", "[-3e10, 3e10]")
        with pytest.raises(
            CodegenError, match=r"'x' from -2\.9e\+10 to 2\.9e\+10; nor does any other format of up to 32 bits"
        ):
            fixed_point(prepare(loads(text), text), to_format("Q3.12"))

    def test_of_sums_that_are_not_one(self):
        text = CURVE.format(first=-2.9, steep=1).replace("then u is r", "then u is r weight 0.5")
        with pytest.raises(CodegenError, match=r"sum to 1, and those .*; --table 9 --fixed Q3\.12 does") as error:
            fixed_point(prepare(loads(text), text), to_format("Q3.12"))
        form, options = proposed(str(error.value))
        assert fixed_point(prepare(loads(text), text, **options), form)

    @pytest.mark.parametrize("text", ["3.12", "Q3", "Q-1.3", "Q16.16", "Q0.0", "Q3.12f", "", "Q99.99"])
    def test_of_what_is_no_format(self, text):
        with pytest.raises(ValueError):
            to_format(text)

    def test_a_format_has_as_many_bits_as_its_type(self):
        assert (to_format("Q3.12").bits, to_format("Q0.15").bits, to_format("q8.8").bits) == (16, 16, 32)
        assert math.log2(to_format("Q15.16").most + 1) == 31
