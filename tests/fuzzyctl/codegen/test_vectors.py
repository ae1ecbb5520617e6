"""Self-tests in single precision hold what a correct target must compute, and nothing that rounding decides."""

import re
import subprocess

import pytest

from fuzzyctl.codegen.files import generate
from tests.fuzzyctl.codegen.conftest import c_selftests, expected_of, prepared, run_c, unit_of, written

HEAD = "system {name}\nand {conjunct}\ndefuzzifier weighted_average\n{more}"
HEAD += "input x in [0, 1]\n{x}\ninput y in [0, 1]\n{y}\n"

#: Rules that are equally strong up to rounding: 1 - (1 - x) and x.
TIE = (
    HEAD.format(
        name="tie",
        conjunct="min",
        more="activation highest(count=1)\n",
        x="  up = ramp(0, 1)\n  down = ramp(1, 0)",
        y="  any = rectangle(-1, 2)",
    )
    + "output u in [0, 1] else 0\n  p = constant(0)\n  q = constant(1)\n"
    "if x is not down then u is p\nif x is up then u is q\n"
)
#: A rule that fires by what rounding leaves of 0.3 + 0.3 + 0.4 - 1.
RESIDUE = (
    HEAD.format(
        name="residue",
        conjunct="bounded_difference",
        more="",
        x="  a = ramp(0, 1)\n  b = function(1 - x)",
        y="  a = function(0.3 + 0 * y)",
    )
    + "output u in [0, 1] else nan\n  p = constant(0.5)\nif x is a and x is b then u is p\n"
)
#: The rates jump with the tie, the output does not where both consequents are the same.
STATE = TIE.replace("output u in [0, 1] else 0", "output u in [0, 9] else 0 adaptive rate 5").replace(
    "constant(0)", "constant(1)"
).replace("system tie", "system state")  # fmt: skip
#: No number of single precision is as large.
HUGE = TIE.replace("activation highest(count=1)\n", "").replace("constant(1)", "constant(1e300)")
SYSTEMS = ("ais_reaction", "tipper", "fcafsmc", "takagi", "threshold", "holding")


def narrowed(files):
    """Return C as a compiler takes it whose `double` has 32 bits, as that of an AVR."""
    for name, text in files.items():
        text = re.sub(r"\bdouble\b", "float", text.replace("DBL_MANT_DIG", "FLT_MANT_DIG"))
        files[name] = re.sub(r"\b(exp|sqrt|pow|log|sin|cos)\(", r"\1f(", text)
    return files


class TestDoublePrecision:
    def test_has_vectors_of_its_own_where_single_differs(self):
        for text in (TIE, RESIDUE, STATE):
            expected = expected_of(unit_of(text))
            assert expected.anywhere
            assert expected.here

    def test_of_32_bits_agrees_with_the_others(self, gcc, tmp_path):
        units = [unit_of(text) for text in (TIE, RESIDUE, STATE, *SYSTEMS)]
        output = c_selftests([narrowed(dict(generate(u, "c").files)) for u in units], tmp_path, ["-w"])
        for unit in units:
            assert f": {len(expected_of(unit).anywhere)} vectors, 0 failures" in output

    def test_has_numbers_that_32_bits_have_not(self, tmp_path):
        unit = unit_of(HUGE)
        assert expected_of(unit).anywhere == []
        assert run_c(generate(unit, "c").files, tmp_path).code == 0
        with pytest.raises(subprocess.CalledProcessError):
            run_c(narrowed(dict(generate(unit, "c").files)), tmp_path, ["-w"])


class TestSinglePrecision:
    def test_leaves_out_what_rounding_decides(self, gcc, tmp_path):
        units = [unit_of(text, precision="float") for text in (TIE, RESIDUE, STATE)]
        for unit, text in zip(units, (TIE, RESIDUE, STATE), strict=True):
            assert len(expected_of(unit).vectors) < len(expected_of(unit_of(text)).vectors)
        c_selftests([generate(u, "c").files for u in units], tmp_path)

    def test_keeps_most_where_nothing_jumps(self):
        found = len(expected_of(unit_of("ais_reaction", precision="float")).vectors)
        assert found >= 0.9 * len(expected_of(unit_of("ais_reaction")).vectors)

    @pytest.mark.parametrize("target", ["c", "st"])
    def test_has_not_all_numbers(self, target):
        words = "1e+300 is too large for single precision; use double"
        assert words in written(HUGE, target, "--float", "float").errors

    def test_of_loops_in_parts_gives_the_same_numbers(self, monkeypatch):
        whole = expected_of(prepared("sampled", precision="float"))
        monkeypatch.setattr("fuzzyctl.codegen.single_precision._AT_ONCE", 1)
        assert repr(expected_of(prepared("sampled", precision="float"))) == repr(whole)
