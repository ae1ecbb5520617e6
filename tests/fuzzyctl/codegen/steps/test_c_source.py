"""Steps as C: their self-tests pass, find what is wrong, and the text keeps what it promises."""

import re
from functools import cache

import pytest

from fuzzyctl.codegen import c_source
from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.files import generate
from fuzzyctl.codegen.names import C_FUNCTION_RESERVED, C_RESERVED
from tests import sizes
from tests.fuzzyctl.codegen.conftest import SANITIZED, UNDEFINED
from tests.fuzzyctl.codegen.steps.targets import unit_of as prepared
from tests.fuzzyctl.codegen.steps.texts import TEXTS
from tests.fuzzyctl.codegen.test_names import identifiers

#: A unit is prepared once for all tests.
unit_of = cache(prepared)


class TestSelfTest:
    @pytest.mark.parametrize("precision", ["double", "float"])
    def test_agrees(self, compiled, text, precision):
        flags = SANITIZED if precision == "double" or sizes.LONG else UNDEFINED
        built = compiled(unit_of(text, precision=precision), flags)
        assert built.code == 0, built.output
        assert " 0 failures" in built.output

    @pytest.mark.parametrize("name", ["pid", "timed", "silent", "refusing", "partial"])
    def test_compilers_may_assume_that_there_is_no_nan(self, compiled, name):
        built = compiled(unit_of(TEXTS[name]), ["-O2", "-ffinite-math-only"])
        assert built.code == 0, built.output

    @pytest.mark.parametrize(
        ("name", "old", "new"),
        [
            ("pid", "state->integral_4_sum = 0.0", "state->integral_4_sum = 1e-9"),
            ("pid", "state->started = 1.0", "state->started = 0.0"),
            ("pid", "(!pid_is_nan(y))", "true"),
            ("pid", "state->derivative_1 = v1;", ""),
            ("timed", "(dt > 0.0)", "true"),
            ("waits", "< 29U", "< 28U"),
            ("refusing", "if (found == REFUSING_OK) {", "{"),
        ],
    )
    def test_finds_what_is_wrong(self, compiled, name, old, new):
        def change(file, text):
            assert file.endswith((".h", "selftest.c")) or old in text
            return text.replace(old, new) if not file.endswith((".h", "selftest.c")) else text

        assert compiled(unit_of(TEXTS[name]), change=change).code == 1

    def test_a_state_that_does_not_begin_anew_is_found(self, compiled):
        def change(file, text):
            return text.replace("    state->s = 1.0;\n", "    if (state->s < 0.5) {\n        state->s = 1.0;\n    }\n")

        text = "controller c\ninput x in [0, 1]\nstate s in [0, 2] = 1\nnext s = 0.5 * s + x\noutput y = s\nevery 1 s\n"
        assert compiled(unit_of(text)).code == 0
        assert compiled(unit_of(text), change=change).code == 1


class TestSource:
    def test_nothing_is_allocated_and_nothing_is_global(self, text):
        source = c_source.source(unit_of(text))
        assert not re.search(r"\b(malloc|calloc|realloc|free|alloca|setjmp|goto)\b", source)
        assert not re.search(r"^static (?!const)[^(]*;$", source, re.M)
        assert not re.search(r"^ *static (?!const)[^(]*;$", source, re.M)

    def test_single_precision_has_no_double_in_it(self, text):
        unit = unit_of(text, precision="float")
        code = re.sub("//.*", "", c_source.source(unit) + c_source.header(unit))
        assert not re.search(r"\bdouble\b", code)
        assert not re.search(r"(?<![\w.])\d+\.\d+(e[-+]\d+)?(?![\dFe.])", code)

    def test_the_same_controller_gives_the_same_text(self, text):
        assert generate(unit_of(text), "c").files == generate(prepared(text), "c").files

    def test_every_name_is_reserved_or_begins_with_that_of_the_controller(self, text):
        unit = unit_of(text)
        layout = CLayout(unit)
        members = {m for pair in layout.members for m in pair}
        given = {*layout.arguments, *layout.outputs, *members, layout.name}
        for name, content in generate(unit, "c").files.items():
            kept = C_FUNCTION_RESERVED if "_selftest" in name else C_RESERVED
            left = {
                n
                for n in identifiers(content) - given
                if not n.startswith((f"{layout.name}_", "__", layout.name.upper()))
            }
            assert {n for n in left if n not in kept and not re.fullmatch(r"[A-Za-z]\d+(_.*)?|turn", n)} == set()

    def test_the_header_names_inputs_outputs_states_and_the_period(self):
        header = c_source.header(prepared(TEXTS["pid"], settings={"GE": 0.7}))
        for line in (
            "// pid: Fuzzy PID controller",
            "// Source: a book: Eq. (1)",
            "// Param set: GE = 0.7",
            "//   y: level, [-2, 2] m",
            "//   u: valve, [-3, 3] V",
            "#define PID_PERIOD 0.05 // [s]",
            "    double started; // 1 from the first step on",
            "double pid_step(pid_state *state, double r, double y);",
            "void pid_init(pid_state *state);",
        ):
            assert line in header.splitlines()

    def test_dt_is_an_argument_where_there_is_no_period(self):
        header = c_source.header(unit_of(TEXTS["timed"]))
        assert "double timed_step(timed_state *state, double r, double y, double dt);" in header
        assert "PERIOD" not in header

    def test_values_are_noted_with_the_names_of_their_equations(self):
        assert re.search(r"// e\n +const double v\d+ = r - y;", c_source.source(unit_of(TEXTS["pid"])))

    def test_a_delay_is_not_shifted(self):
        text = TEXTS["waits"].replace("30", "10000")
        source = c_source.source(unit_of(text))
        assert len(source) < 5000
        assert "double delay_1[10000];" in c_source.header(unit_of(text))

    def test_a_title_cannot_leave_its_comment(self, compiled):
        text = TEXTS["pid"].replace('"Fuzzy PID controller"', '"ends */ here \\\\ and ??/ there /* */"')
        text = text.replace('"level"', '"l */ \\\\ ??/ /*"')
        assert compiled(unit_of(text)).code == 0


NAMED = """controller {controller}
input {x} in [-2, 2]
input {y} in [-2, 2]
state {s} = 0.5
next {s} = 0.5 * {s} + {x}
output {u} = {s} + delay({y}, 5)
output {v} = {x} * {y}
"""


class TestNames:
    @pytest.mark.parametrize(
        "names",
        [
            {"controller": "a", "x": "a_is_nan", "y": "a_state", "s": "A_H", "u": "A_PERIOD", "v": "a_step"},
            {"controller": "A", "x": "state", "y": "outputs", "s": "members", "u": "VECTORS", "v": "turn"},
            {"controller": "v", "x": "double", "y": "found", "s": "int", "u": "result", "v": "k"},
            {"controller": "inputs", "x": "u0", "y": "s0", "s": "delay_1", "u": "v1", "v": "delay_1_oldest"},
            {"controller": "stdin", "x": "NAN", "y": "size_t", "s": "started", "u": "EOF", "v": "main"},
            {"controller": "fp", "x": "σ", "y": "sigma", "s": "Σ", "u": "Sigma", "v": "sigma_2"},
        ],
    )
    def test_may_be_anything(self, compiled, names):
        for period in ("", "every 1 s\n"):
            built = compiled(unit_of(NAMED.format(**names) + period), SANITIZED if sizes.LONG else ())
            assert built.code == 0, built.output

    def test_of_instances_and_operators_are_joined_by_underscores(self):
        members = [m for m, _ in CLayout(unit_of(TEXTS["inner"])).members]
        assert members == ["a_s", "b_s"]
        assert [m for m, _ in CLayout(unit_of(TEXTS["pid"])).members] == [
            "derivative_1",
            "started",
            "derivative_1_filtered",
            "integral_4_sum",
        ]

    def test_that_would_be_the_same_are_numbered(self):
        text = "controller inner\ninput x\nstate s = 0\nnext s = x\noutput y = s\ncontroller c\ninput x\n"
        text += "block a = inner(x)\nstate a_s = 0\nnext a_s = a.y\noutput y = a_s\nevery 1 s\n"
        assert [m for m, _ in CLayout(unit_of(text)).members] == ["a_s", "a_s_2"]
