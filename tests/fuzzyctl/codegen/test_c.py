"""Generated C of systems and controllers computes the numbers of kernels, without undefined behaviour."""

import re
import subprocess

import pytest

from fuzzyctl import FuzzyctlError
from fuzzyctl.codegen.files import generate, sources
from tests import sizes
from tests.fuzzyctl.codegen.conftest import (
    ALL,
    SANITIZED,
    SOME,
    UNDEFINED,
    c_selftests,
    expected_of,
    prepared,
    run_c,
    unit_of,
    written,
)
from tests.fuzzyctl.codegen.steps.targets import unit_of as step_of
from tests.fuzzyctl.codegen.steps.texts import TEXTS
from tests.fuzzyctl.codegen.structured_text import Block

KINDS = ALL if sizes.LONG else SOME
ONE_CORNER = """
system one
and min
defuzzifier weighted_average
input x in [-1, 1]
  N = triangle(-inf, -1, 0)
  Z = triangle(-1, 0, 1)
  P = triangle(0, 1, inf)
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
#: Outputs that refuse differ by case only.
CASES = """
system cases
defuzzifier weighted_average
input x in [0, 9]
  a = triangle(0, 1, 3)
  b = triangle(2, 5, 6)
output u in [0, 1] else error
  p = constant(0)
output U in [0, 1] else error
  q = constant(1)
if x is a then u is p
if x is b then U is q
"""
ROUNDED = """
system steps
defuzzifier weighted_average
input x in [0, 1]
  low = trapezoid(-inf, 0, 1, inf)
input y in [0, 1]
output u0 in [-20, 20] else 0
output u1 in [-20, 20] else 0
output u2 in [-20, 20] else 0
if x is low then u0 is function(floor(9 * x) - ceil(y))
if x is low then u1 is function(round(9 * x) + mod(y, -0.3))
if x is low then u2 is function(fmod(-9 * x, y) * lt(x, y) + ne(x, y))
"""
CLOSE = """
system s
and product
defuzzifier weighted_average
input x in [1000, 1001]
  terms a@1000 b@1000.00001 c@1001
output u in [0, 1]
  p = constant(0)
  q = constant(1)
if x is a then u is p
if x is b then u is q
if x is c then u is p
"""
FRESH = "controller fresh\ninput x in [0, 1]\nstate s in [0, 2] = 1\nnext s = 0.5 * s + x\noutput y = s\nevery 1 s\n"


def steps(**options):
    """Return the controllers of all kinds."""
    return [step_of(text, **options) for text in TEXTS.values()]


def source_of(unit):
    return next(text for name, text in sources(unit, "c").items() if name.endswith(".c"))


class TestSelfTest:
    def test_double_agrees_with_the_kernel_to_1e_12(self, gcc, tmp_path):
        watched = [*map(unit_of, KINDS), prepared(ONE_CORNER, algorithm="active"), prepared(CASES), prepared(ROUNDED)]
        (tmp_path / "watched").mkdir()
        output = c_selftests([generate(u, "c").files for u in watched], tmp_path / "watched", SANITIZED)
        assert f"{len(expected_of(watched[0]).vectors)} vectors, 0 failures" in output
        others = [*(unit_of(k) for k in ALL if k not in KINDS), *steps()]
        c_selftests([generate(u, "c").files for u in others], tmp_path, UNDEFINED)
        for unit in (u for u in (*watched, *others) if not u.is_step):
            assert all(unit.tolerance(k) <= 1e-12 * unit.scale(k) for k in range(len(unit.outputs)))

    def test_float_agrees_to_the_stated_tolerance(self, gcc, tmp_path):
        systems = [*(unit_of(k, precision="float") for k in KINDS), prepared(ROUNDED, precision="float")]
        for k, units in enumerate((systems, steps(precision="float"))):
            (tmp_path / f"{k}").mkdir()
            flags = SANITIZED if sizes.LONG else UNDEFINED
            c_selftests([generate(u, "c").files for u in units], tmp_path / f"{k}", flags)

    def test_rules_that_act_are_looked_up(self):
        assert unit_of("active").algorithm.name == "active"

    def test_compilers_may_assume_that_there_is_no_nan(self, gcc, tmp_path):
        for flags, units in (
            ("-O3 -ffast-math", map(unit_of, "ais_reaction exact silent refusing chained holding adaptive".split())),
            ("-O2 -ffinite-math-only", (step_of(TEXTS[n]) for n in "pid timed silent refusing partial".split())),
        ):
            (tmp_path / flags[:3]).mkdir()
            c_selftests([generate(u, "c").files for u in units], tmp_path / flags[:3], flags.split())

    @pytest.mark.parametrize(
        ("name", "old", "new"),
        [
            ("ais_reaction", "1.3599999999999999, 22.666", "1.36000001, 22.666"),
            ("exact", "> EXACT_INFINITE", "> EXACT_MAGNITUDE"),
            ("pid", "state->integral_4_sum = 0.0", "state->integral_4_sum = 1e-9"),
            ("pid", "state->started = 1.0", "state->started = 0.0"),
            ("pid", "(!pid_is_nan(y))", "true"),
            ("pid", "state->derivative_1 = v1;", ""),
            ("timed", "(dt > 0.0)", "true"),
            ("waits", "< 29U", "< 28U"),
            ("refusing", "if (found == REFUSING_OK) {", "{"),
            ("fresh", "    state->s = 1.0;\n", "    if (state->s < 0.5) {\n        state->s = 1.0;\n    }\n"),
        ],
    )
    def test_finds_what_is_wrong(self, compiled, name, old, new):
        text = {**TEXTS, "fresh": FRESH}.get(name)
        unit = step_of(text) if text else unit_of(name)

        def change(file, text):
            assert file != f"{name}.c" or old in text
            return text.replace(old, new) if file == f"{name}.c" else text

        built = compiled(unit, change=change)
        assert built.code == 1
        assert " 0 failures" not in built.output

    def test_vectors_cover_what_a_target_may_get_wrong(self, some_kind):
        unit = unit_of(some_kind)
        found = expected_of(unit).vectors
        # About 230 points are tried; vectors at jumps are left out, never most of them.
        assert len(found) >= 140
        assert any(x != x for v in found for x in v.inputs)
        assert any(x in (float("inf"), float("-inf")) for v in found for x in v.inputs)
        assert all(y != y for v in found if any(x != x for x in v.inputs) for y in v.outputs)
        refused = {v.refused for v in found}
        assert bool(refused - {""}) == bool(unit.refusals)

    def test_outputs_that_differ_by_case_refuse_apart(self):
        assert {v.refused for v in expected_of(unit_of(CASES)).vectors} >= {"u", "U"}


class TestSource:
    def test_allocates_nothing_keeps_nothing_and_mixes_no_precisions(self):
        for precision in ("double", "float"):
            for unit in [*(unit_of(k, precision=precision) for k in ALL), *steps(precision=precision)]:
                text = re.sub("//.*", "", "".join(sources(unit, "c").values()))
                assert not re.search(r"\b(malloc|calloc|realloc|free|alloca|setjmp|goto)\b", text)
                assert not re.search(r"^ *static (?!const)[^(]*;$", text, re.M)
                if precision == "float":
                    assert not re.search(r"\bdouble\b|(?<![\w.])\d+\.\d+(e[-+]\d+)?(?![\dFe.])", text)

    def test_an_input_that_is_looked_up_is_held_once(self):
        held = re.findall(r"const double (\w+) = \((\w+) <", source_of(unit_of("active")))
        assert [x for _, x in held if x in ("e", "de")] == ["e", "de"]
        assert not {name for name, _ in held} & {x for _, x in held}

    def test_libm_and_memory_are_used_only_where_they_are_needed(self, gcc, tmp_path):
        assert "#include <math.h>" in source_of(unit_of("tipper"))
        assert "math.h" not in source_of(unit_of("fcafsmc"))
        for name, text in sources(unit_of("ais_reaction"), "c").items():
            (tmp_path / name).write_text(text, encoding="utf-8")
        compile_ = ["gcc", "-std=c99", "-Os", "-c", "ais_reaction.c"]
        subprocess.run(compile_, check=True, cwd=tmp_path)
        symbols, size = (
            subprocess.run([*c, "ais_reaction.o"], capture_output=True, text=True, check=True, cwd=tmp_path).stdout
            for c in (["nm", "-u"], ["size"])
        )
        assert {s for s in symbols.split() if s != "U"} <= {"memcpy", "_GLOBAL_OFFSET_TABLE_"}
        code, data, bss = map(int, size.split("\n")[1].split()[:3])
        assert code < 2048
        assert (data, bss) == (0, 0)

    def test_the_same_block_gives_the_same_text(self):
        for name in KINDS:
            assert sources(unit_of(name), "c") == sources(prepared(name), "c")
        for text in TEXTS.values():
            assert generate(step_of(text), "c").files == generate(step_of(text), "c").files

    def test_knots_that_single_precision_cannot_tell_apart_are_refused(self):
        assert written(CLOSE).code == 0
        assert "use double" in written(CLOSE, "c", "--float", "float").errors

    def test_a_delay_is_not_shifted(self):
        files = sources(step_of(TEXTS["waits"].replace("30", "10000")), "c")
        assert len(files["waits.c"]) < 5000
        assert "double delay_1[10000];" in files["waits.h"]

    def test_values_are_noted_with_the_names_of_their_equations(self):
        assert re.search(r"// e\n +const double v\d+ = r - y;", source_of(step_of(TEXTS["pid"])))


class TestComments:
    def test_every_table_says_what_it_holds_and_no_code_is_too_long(self):
        for name in KINDS:
            for target in ("c", "st"):
                try:
                    texts = [t for n, t in sources(unit_of(name), target).items() if n[-1] != "h"]
                except FuzzyctlError:
                    continue  # Structured Text has not all functions
                for lines in map(str.splitlines, texts):
                    code = [line for line in lines if not line.lstrip().startswith(("#", "//", "(*"))]
                    assert max(map(len, code)) <= 120
                    tables = [k for k, t in enumerate(lines) if re.match(r"    static const double T\d+\[", t)]
                    assert all(lines[k - 1].startswith("    // ") for k in tables)

    def test_a_table_of_several_variables_names_all(self):
        (text,) = written("ais_reaction", "st", "--algorithm", "active").files.values()
        first, second = (f"(* degree at the foot of the first term in each cell of {n} *)" for n in ("sigma", "dsigma"))
        assert f"  {first}\n  {second}\n  T3 : ARRAY" in text

    def test_params_of_a_function_are_described(self):
        for name, words in {
            "refusing": "//   status: REFUSING_OK, or which output",
            "holding": "//   state: begun by holding_init; what outputs",
            "chained": "//     u: [-5.0, 20.0]\n//     v: [0.0, 1.0]\n",
        }.items():
            assert words in written(name).files[f"{name}.h"]


#: Text that would end a comment, begin one, join it to the next line, or break it.
HOSTILE = "ends */ here *) (* and (*) ??/ there /* */ \\\\ \u202e\u2066 * // \\\\ ???/"


class TestHostileTexts:
    @pytest.fixture
    def own(self):
        text = f'system tipper "{HOSTILE}"\nsource "{HOSTILE}"\ndefuzzifier weighted_average\n'
        text += f'input x "{HOSTILE}" in [0, 1] unit "{HOSTILE}"\n  terms a b\n'
        text += f'output u "{HOSTILE}" in [0, 1] unit "{HOSTILE}"\n  p = constant(0)\n  q = constant(1)\n'
        return text + "if x is a then u is p\nif x is b then u is q\nrequire u <= 1\n"

    def test_end_no_comment_of_c(self, own, tmp_path):
        files = written(own).files
        assert run_c(files, tmp_path, ["-Wcomment", "-trigraphs"]).code == 0
        text = "".join(files.values())
        assert "??" not in text
        assert not set("\u202a\u202b\u202d\u202e\u2066\u2067\u2068\u200f") & set(text)

    def test_end_no_comment_of_a_controller(self, compiled):
        text = TEXTS["pid"].replace("Fuzzy PID controller", HOSTILE).replace('"level"', f'"{HOSTILE}"')
        assert compiled(step_of(text)).code == 0

    def test_end_no_comment_of_structured_text(self, own):
        (text,) = written(own, "st").files.values()
        block = Block(text)
        assert (block.inputs, block.outputs) == (["x"], ["u", "u_valid"])
