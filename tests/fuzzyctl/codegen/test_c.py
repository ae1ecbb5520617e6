"""Generated C computes what the kernels compute, and does nothing that C leaves undefined."""

import random
import re
import subprocess

import pytest

from fuzzyctl import loads
from fuzzyctl.codegen import c_source
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.files import expected_of, generate
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.codegen.vectors import Reference, points
from tests import sizes
from tests.fuzzyctl.codegen.conftest import SOME, UNDEFINED, prepared

ONE_CORNER = """
system one
and min
defuzzifier weighted_average
input x in [-1, 1]
{}
input y in [0, 1]
  on = triangle(-inf, 1, 2)
output u in [0, 3]
  a = constant(1)
  b = constant(2)
  c = constant(3)
if x is N and y is on then u is a
if x is Z and y is on then u is b
if x is P and y is on then u is c
"""


class TestSelfTest:
    def test_double_agrees_with_the_kernel_to_1e_12(self, compiled, unit_of, sanitized, kind):
        unit = unit_of(kind)
        built = compiled(unit, sanitized if kind in SOME or sizes.LONG else UNDEFINED)
        assert built.code == 0, built.output
        assert f"{len(expected_of(unit).vectors)} vectors, 0 failures" in built.output
        for position in range(len(unit.plan.outputs)):
            assert unit.tolerance(position) <= 1e-12 * unit.scale(position)

    def test_float_agrees_to_the_stated_tolerance(self, compiled, unit_of, some_kind):
        built = compiled(unit_of(some_kind, precision="float"))
        assert built.code == 0, built.output

    def test_rules_that_act_are_looked_up(self, unit_of):
        assert unit_of("active").algorithm.name == "active"

    def test_inputs_with_one_term_everywhere_are_looked_up_nowhere(self, compiled):
        text = ONE_CORNER.format("  N = triangle(-inf, -1, 0)\n  Z = triangle(-1, 0, 1)\n  P = triangle(0, 1, inf)")
        unit = prepare(loads(text), text, algorithm="active")
        built = compiled(unit)
        assert built.code == 0, built.output

    @pytest.mark.parametrize("name", ["ais_reaction", "exact", "silent", "refusing", "chained", "holding", "adaptive"])
    def test_compilers_may_assume_that_there_is_no_nan(self, compiled, unit_of, name):
        built = compiled(unit_of(name), ["-O3", "-ffast-math"])
        assert built.code == 0, built.output

    def test_a_wrong_coefficient_is_found(self, compiled, unit_of):
        def change(name, text):
            return (
                text.replace("1.3599999999999999, 22.666", "1.36000001, 22.666") if name == "ais_reaction.c" else text
            )

        assert compiled(unit_of("ais_reaction")).code == 0
        built = compiled(unit_of("ais_reaction"), change=change)
        assert built.code == 1
        assert " 0 failures" not in built.output

    def test_a_lost_test_for_nan_is_found(self, compiled, unit_of):
        def change(name, text):
            return text.replace("> EXACT_INFINITE", "> EXACT_MAGNITUDE") if name == "exact.c" else text

        assert compiled(unit_of("exact"), change=change).code == 1

    def test_vectors_cover_what_a_target_may_get_wrong(self, unit_of, some_kind):
        unit = unit_of(some_kind)
        found = expected_of(unit).vectors
        tried = points(unit, random.Random(1))
        # Vectors at jumps are left out, never most of them.
        assert len(found) >= 0.6 * len(tried)
        assert any(x != x for v in found for x in v.inputs)
        assert any(x in (float("inf"), float("-inf")) for v in found for x in v.inputs)
        assert all(y != y for v in found if any(x != x for x in v.inputs) for y in v.outputs)
        if unit.refusals:
            assert any(v.refused for v in found)

    def test_no_vector_stands_at_a_jump(self, unit_of):
        reference = Reference(unit_of("threshold"))
        assert not reference.steady((3.1, -0.9))  # x is low: (4 - 3.1) / 3 = 0.3
        assert reference.steady((3.2, -0.9))


class TestSource:
    def test_an_input_that_is_looked_up_is_held_once(self, unit_of):
        source = c_source.source(unit_of("active"))
        held = re.findall(r"const double (\w+) = \((\w+) <", source)
        assert [x for _, x in held if x in ("e", "de")] == ["e", "de"]
        assert not {name for name, _ in held} & {x for _, x in held}

    def test_libm_is_asked_for_only_where_it_is_needed(self, unit_of):
        assert "math.h" not in c_source.source(unit_of("ais_reaction"))
        assert "math.h" not in c_source.source(unit_of("fcafsmc"))
        assert "exp(" in c_source.source(unit_of("tipper"))
        assert "#include <math.h>" in c_source.source(unit_of("tipper"))

    def test_links_without_libm_where_it_is_not_needed(self, compiled, unit_of, tmp_path):
        compiled(unit_of("ais_reaction"))
        symbols = subprocess.run(
            ["nm", "-u", str(_object(tmp_path, "ais_reaction"))], capture_output=True, text=True, check=True
        ).stdout.split()
        assert {s for s in symbols if s != "U"} <= {"memcpy", "_GLOBAL_OFFSET_TABLE_"}

    def test_code_of_w1_fits_into_2_kb(self, compiled, unit_of, tmp_path):
        compiled(unit_of("ais_reaction"))
        size = subprocess.run(
            ["size", str(_object(tmp_path, "ais_reaction"))], capture_output=True, text=True, check=True
        ).stdout.split("\n")[1]
        text, data, bss = map(int, size.split()[:3])
        assert text < 2048
        assert (data, bss) == (0, 0)

    def test_nothing_is_allocated_and_nothing_recurses(self, unit_of, kind):
        text = c_source.source(unit_of(kind))
        assert not re.search(r"\b(malloc|calloc|realloc|free|alloca|setjmp|goto)\b", text)

    def test_single_precision_has_no_double_in_it(self, unit_of, kind):
        text = re.sub("//.*", "", c_source.source(unit_of(kind, precision="float")))
        assert not re.search(r"\bdouble\b", text)
        assert not re.search(r"(?<![\w.])\d+\.\d+(e[-+]\d+)?(?![\dFe.])", text)

    def test_the_header_says_where_it_comes_from_and_what_is_proved(self, unit_of):
        header = c_source.header(unit_of("ais_reaction"))
        assert "SHA-256 e3b0c44298fc1c14" in header
        assert "proved: -1.0 <= f <= 0.18 for all inputs" in header
        assert "dsigma (dσ*/dt): [-1.0, 1.0] 1/s" in header
        assert "double ais_reaction(double sigma, double dsigma);" in header

    def test_a_title_cannot_leave_its_comment(self, unit_of, compiled):
        unit = unit_of("ais_reaction")
        system = unit.system.model_copy(update={"title": "ends */ here \\ and ??/ there /* */"})
        built = compiled(type(unit)(**{f: getattr(unit, f) for f in unit.__dataclass_fields__} | {"block": system}))
        assert built.code == 0

    def test_the_same_system_gives_the_same_text(self, unit_of, some_kind):
        assert generate(unit_of(some_kind), "c").files == generate(prepared(some_kind), "c").files

    def test_refusals_of_outputs_that_differ_by_case_only_are_told_apart(self, compiled, sanitized):
        text = (
            "system s\ndefuzzifier weighted_average\ninput x in [0, 9]\n"
            "  a = triangle(0, 1, 3)\n  b = triangle(2, 5, 6)\n"
            "output u in [0, 1] else error\n  p = constant(0)\noutput U in [0, 1] else error\n  q = constant(1)\n"
            "if x is a then u is p\nif x is b then U is q\n"
        )
        unit = prepare(loads(text), text)
        assert {v.refused for v in expected_of(unit).vectors} >= {"u", "U"}
        built = compiled(unit, sanitized)
        assert built.code == 0, built.output

    def test_roundings_and_comparisons_are_those_of_the_kernel(self, compiled, sanitized):
        values = ("floor(9 * x) - ceil(y)", "round(9 * x) + mod(y, -0.3)", "fmod(-9 * x, y) * lt(x, y) + ne(x, y)")
        rules = "".join(f"if x is low then u{k} is function({v})\n" for k, v in enumerate(values))
        text = (
            "system steps\ndefuzzifier weighted_average\ninput x in [0, 1]\n  low = trapezoid(-inf, 0, 1, inf)\n"
            "input y in [0, 1]\n" + "".join(f"output u{k} in [-20, 20] else 0\n" for k in range(3)) + rules
        )
        for precision in ("double", "float"):
            built = compiled(prepare(loads(text), text, precision=precision), sanitized)
            assert built.code == 0, built.output

    def test_knots_that_single_precision_cannot_tell_apart_are_refused(self, unit_of):
        text = (
            "system s\nand product\ndefuzzifier weighted_average\ninput x in [1000, 1001]\n"
            "  terms a@1000 b@1000.00001 c@1001\noutput u in [0, 1]\n  p = constant(0)\n  q = constant(1)\n"
            "if x is a then u is p\nif x is b then u is q\nif x is c then u is p\n"
        )
        assert c_source.source(prepare(loads(text), text))
        with pytest.raises(CodegenError, match="use double"):
            c_source.source(prepare(loads(text), text, precision="float"))


def _object(folder, name):
    target = folder / f"{name}.o"
    subprocess.run(["gcc", "-std=c99", "-Os", "-c", str(folder / f"{name}.c"), "-o", str(target)], check=True)
    return target
