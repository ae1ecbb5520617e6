"""Self-tests in single precision hold what a correct target must compute, and nothing that rounding decides."""

import re
import subprocess

import numpy as np
import pytest

from fuzzyctl import loads
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.files import expected_of, generate
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.codegen.single_precision import LANES, Roundings, nearest
from fuzzyctl.codegen.vectors import Reference, in_parts
from fuzzyctl.kernels.program.program import Accumulate, Fold

HEAD = "system s\nand {conjunct}\ndefuzzifier {method}\n{more}input x in [0, 1]\n{x}\ninput y in [0, 1]\n{y}\n"

#: Rules that are equally strong up to rounding: 1 - (1 - x) and x.
TIE = (
    HEAD.format(
        conjunct="min",
        method="weighted_average",
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
        conjunct="bounded_difference",
        method="weighted_average",
        more="",
        x="  a = ramp(0, 1)\n  b = function(1 - x)",
        y="  a = function(0.3 + 0 * y)",
    )
    + "output u in [0, 1] else nan\n  p = constant(0.5)\nif x is a and x is b then u is p\n"
)
#: The rates jump with the tie, the output does not where both consequents are the same.
STATE = TIE.replace("output u in [0, 1] else 0", "output u in [0, 9] else 0 adaptive rate 5").replace(
    "constant(0)", "constant(1)"
)


#: No number of single precision is as large.
HUGE = TIE.replace("activation highest(count=1)\n", "").replace("constant(1)", "constant(1e300)")


def narrowed(_name, text):
    """Return C as a compiler takes it whose `double` has 32 bits, as that of an AVR."""
    text = re.sub(r"\bdouble\b", "float", text.replace("DBL_MANT_DIG", "FLT_MANT_DIG"))
    return re.sub(r"\b(exp|sqrt|pow|log|sin|cos)\(", r"\1f(", text)


def single(text):
    return prepare(loads(text), text, precision="float")


class TestVectors:
    @pytest.mark.parametrize("text", [TIE, RESIDUE], ids=["tie", "residue"])
    def test_are_left_out_where_rounding_decides(self, text):
        unit = single(text)
        tried = [(nearest(x).item(), 0.5) for x in np.linspace(0.05, 0.95, 40)]
        reference = Reference(unit)
        assert not all(reference.rounded_alike(tried))
        assert reference.rounded_alike([(0.0, 0.5)]) == [True]

    def test_are_left_out_where_rounding_decides_on_the_state(self):
        reference = Reference(single(STATE))
        assert reference.evaluate((0.3, 0.5)).outputs == (1.0,)
        tried = [(nearest(x).item(), 0.5) for x in np.linspace(0.05, 0.95, 20)]
        assert not all(reference.rounded_alike([point])[0] for point in tried)

    @pytest.mark.parametrize("text", [TIE, RESIDUE, STATE], ids=["tie", "residue", "state"])
    def test_of_double_precision_are_kept_for_it_where_single_differs(self, text):
        unit = prepare(loads(text), text)
        anywhere, here = in_parts(unit)
        assert anywhere
        assert here
        assert expected_of(unit).vectors == [*anywhere, *here]

    @pytest.mark.parametrize("text", [TIE, RESIDUE, STATE], ids=["tie", "residue", "state"])
    def test_of_double_precision_agree_where_double_has_32_bits(self, compiled, text):
        built = compiled(prepare(loads(text), text), ["-w"], change=narrowed)
        assert built.code == 0, built.output

    @pytest.mark.parametrize("name", ["ais_reaction", "tipper", "fcafsmc", "takagi", "threshold", "holding"])
    def test_of_systems_agree_there_too(self, compiled, unit_of, name):
        built = compiled(unit_of(name), ["-w"], change=narrowed)
        assert built.code == 0, built.output
        assert f"{len(in_parts(unit_of(name))[0])} vectors" in built.output

    @pytest.mark.parametrize("target", ["c", "st"])
    def test_numbers_beyond_single_precision_are_refused(self, target):
        with pytest.raises(CodegenError, match=r"1e\+300 is too large for single precision; use double"):
            generate(single(HUGE), target)

    def test_numbers_beyond_single_precision_need_64_bits(self, compiled):
        unit = prepare(loads(HUGE), HUGE)
        assert in_parts(unit)[0] == []
        assert compiled(unit).code == 0
        with pytest.raises(subprocess.CalledProcessError):
            compiled(unit, ["-w"], change=narrowed)

    def test_agree_on_a_target_where_ties_abound(self, compiled):
        built = compiled(single(TIE))
        assert built.code == 0, built.output

    def test_are_still_most_where_nothing_jumps(self, unit_of):
        from_points = len(expected_of(unit_of("ais_reaction", precision="float")).vectors)
        assert from_points >= 0.9 * len(expected_of(unit_of("ais_reaction")).vectors)


class TestRoundings:
    def test_the_first_lane_is_what_numpy_computes_in_single_precision(self, unit_of, kind):
        """A different printer of the same program: arrays of single precision, statement by statement."""
        unit = unit_of(kind, precision="float")
        program = unit.program
        points = nearest(np.random.default_rng(2).uniform(-1, 10, (20, len(unit.arguments))))
        state = [np.full((20, LANES), nearest(v).item()) for v in unit.plan.initial_state]
        results, refused = Roundings(program).run(points, state)
        reference = Reference(unit)
        for i, point in enumerate(points):
            expected = reference.evaluate(tuple(point))
            if expected.refused or refused[i, 0] or not reference.steady(tuple(point)):
                continue
            for k, (found, wanted) in enumerate(zip(results, expected.outputs, strict=True)):
                assert np.isnan(wanted) or abs(found[i, 0] - wanted) <= unit.tolerance(k)

    def test_lanes_differ_by_rounding_only_where_a_result_is_inexact(self):
        text = TIE.replace("activation highest(count=1)\n", "").replace("x is not down", "x is down")
        text += "if y is any then u is q\n"
        program = single(text).program
        (exact,), _ = Roundings(program).run(np.array([[0.25, 0.0]]))
        (inexact,), _ = Roundings(program).run(nearest(np.array([[0.3, 0.0]])))
        assert len(set(exact[0])) == 1
        assert 1 < len(set(inexact[0])) <= 4

    def test_loops_are_run_in_parts_with_the_same_numbers(self, unit_of, monkeypatch):
        program = unit_of("sampled", precision="float").program
        assert any(isinstance(s, Accumulate | Fold) for s in program.body)
        points = nearest(np.random.default_rng(3).uniform(-1, 10, (9, 2)))
        whole, _ = Roundings(program).run(points)
        monkeypatch.setattr("fuzzyctl.codegen.single_precision._AT_ONCE", 1)
        parts, _ = Roundings(program).run(points)
        assert np.array_equal(whole[0][:, 0], parts[0][:, 0], equal_nan=True)
