"""Fixed point stays within its proved bound, over all inputs where they can be counted."""

import math
from fractions import Fraction

import numpy as np
import pytest

from fuzzyctl import loads
from fuzzyctl.codegen.digits import at_most
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.files import generate
from fuzzyctl.codegen.fixed import Format, fixed_point, to_format
from fuzzyctl.codegen.unit import prepare
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

    @pytest.mark.parametrize(("text", "units"), [("Q3.12", 1.0), ("Q0.15", 1.5), ("Q1.30", 2.0), ("Q4.11", 1.0)])
    def test_holds_for_the_immune_reaction_and_is_about_one_unit(self, unit_of, text, units):
        if text == "Q0.15":
            with pytest.raises(CodegenError, match=r"reaches to 0\.999969, and 'f' to 1"):
                fixed_point(unit_of("ais_reaction"), to_format(text))
            return
        unit = unit_of("ais_reaction")
        fixed = fixed_point(unit, to_format(text))
        rng = np.random.default_rng(3)
        reach = [(a.least - 3, a.most + 3) for a in fixed.axes]
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


class TestRefusal:
    @pytest.mark.parametrize(
        ("name", "reason"),
        [
            ("tipper", "needs a system that interpolates: .*; --table makes one that does"),
            ("fcafsmc", "it has a state"),
            ("takagi", "needs a system that interpolates"),
        ],
    )
    def test_names_its_reason(self, unit_of, name, reason):
        with pytest.raises(CodegenError, match=reason):
            fixed_point(unit_of(name), to_format("Q3.12"))

    def test_of_sums_that_are_not_one(self):
        text = CURVE.format(first=-2.9, steep=1).replace("then u is r", "then u is r weight 0.5")
        with pytest.raises(CodegenError, match="sum to 1"):
            fixed_point(prepare(loads(text), text), to_format("Q3.12"))

    @pytest.mark.parametrize("text", ["3.12", "Q3", "Q-1.3", "Q16.16", "Q0.0", "Q3.12f", "", "Q99.99"])
    def test_of_what_is_no_format(self, text):
        with pytest.raises(ValueError):
            to_format(text)

    def test_a_format_has_as_many_bits_as_its_type(self):
        assert (to_format("Q3.12").bits, to_format("Q0.15").bits, to_format("q8.8").bits) == (16, 16, 32)
        assert math.log2(to_format("Q15.16").most + 1) == 31
