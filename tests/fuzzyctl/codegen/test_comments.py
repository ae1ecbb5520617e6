"""Comments and line breaks of generated text: what people read, and compilers do not see."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl import load, loads
from fuzzyctl.analysis.prove import quickly
from fuzzyctl.codegen.comments import table_notes, value_notes
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.files import generate
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.codegen.wrapping import WIDTH, broken, folded
from fuzzyctl.formats.fz import rule_text
from tests.fuzzyctl.codegen.conftest import RULES
from tests.fuzzyctl.codegen.structured_text import Block

#: What would end a comment, begin one, join it to the next line, or break it.
HOSTILE = "ends */ here *) (* and (*) ??/ there /* */ \\ \n \u202e\u2066 * // \\ ???/"
PIECES = st.lists(st.sampled_from(["(", ")", " + ", " - ", " ? ", " : ", ", ", "alpha", "0.125", "T[k]"]), max_size=80)


def texts(unit, target):
    return [t for name, t in generate(unit, target).files.items() if "_selftest" not in name]


def code(line):
    return not line.lstrip().startswith(("#", "//", "(*"))


class TestBroken:
    @given(PIECES)
    def test_lines_say_the_same_and_nest_no_deeper_than_needed(self, pieces):
        line = "    " + "".join(pieces)
        found = list(broken([line], "  ", 40))
        assert "".join("".join(found).split()) == "".join(line.split())
        for part in found[:-1]:
            assert len(part) <= 40

    def test_are_broken_where_they_nest_least(self):
        line = "  v := (alpha + (beta * gamma)) + (delta + epsilon);"
        assert list(broken([line], "  ", 45)) == ["  v := (alpha + (beta * gamma))", "    + (delta + epsilon);"]
        inner = "  v := ((alpha + beta) ? gamma : delta);"
        assert list(broken([inner], "  ", 30)) == ["  v := ((alpha + beta) ? gamma", "      : delta);"]

    @pytest.mark.parametrize("line", ["#define A " + "1 + " * 40, "    // " + "one, " * 40, "(* " + "a + " * 40 + "*)"])
    def test_directives_and_comments_stay_whole(self, line):
        assert list(broken([line], "  ")) == [line]

    def test_no_code_of_any_kind_is_longer(self, some_kind, unit_of):
        for target in ("c", "st"):
            try:
                found = texts(unit_of(some_kind), target)
            except CodegenError:
                continue  # what Structured Text has no function for
            assert max(len(line) for text in found for line in text.splitlines() if code(line)) <= WIDTH


class TestFolded:
    def test_long_lines_are_indented_further_and_lose_no_word(self):
        line = "  " + "word " * 50
        found = list(folded([line]))
        assert " ".join(found).split() == line.split()
        assert all(len(f) <= WIDTH - 6 for f in found)
        assert [f[:5] for f in found[1:]] == ["    w"] * (len(found) - 1)

    def test_what_has_no_space_stays(self):
        assert list(folded(["  " + "x" * 300])) == ["  " + "x" * 300]


class TestNotes:
    def test_every_table_says_what_it_holds(self, some_kind, unit_of):
        text = generate(unit_of(some_kind), "c").files
        lines = "\n".join(t for n, t in text.items() if n.endswith(".c") and "_selftest" not in n).splitlines()
        tables = [k for k, line in enumerate(lines) if re.match(r"    static const double T\d+\[", line)]
        assert all(lines[k - 1].startswith("    // ") for k in tables)

    def test_a_table_that_stands_for_several_says_so(self):
        unit = prepare(load(RULES / "ais_reaction.fz"), "", algorithm="active")
        notes = table_notes(unit, unit.program)
        same = [f"degree at the foot of the first term in each cell of {name}" for name in ("sigma", "dsigma")]
        assert same in notes.values()
        (text,) = generate(unit, "st").files.values()
        assert f"  (* {same[0]} *)\n  (* {same[1]} *)\n  T3 : ARRAY" in text

    def test_every_rule_and_degree_stands_where_it_is_computed(self):
        text = generate(prepare(load(RULES / "tipper.fz"), ""), "c").files["tipper.c"]
        for rule in load(RULES / "tipper.fz").rules:
            assert text.count(f"        // {rule_text(rule)}\n") == 1
        assert "        // degree of food is rancid\n        const double v9 = (v2 <= 1.0)" in text
        assert text.count("// degree of ") == 5

    def test_values_are_those_of_the_text(self, kind, unit_of):
        unit = unit_of(kind)
        notes = value_notes(unit)
        assert bool(notes) == (unit.algorithm.name == "rules")
        body = {s.name: s for s in unit.algorithm.printed.body if hasattr(s, "name")}
        assert notes.keys() <= body.keys()

    def test_prototypes_say_what_goes_in_and_comes_out(self):
        text = generate(prepare(load(RULES / "ais_reaction.fz"), ""), "c").files["ais_reaction.h"]
        assert (
            "// Evaluate ais_reaction: f of sigma, dsigma.\n//   sigma: σ*, [-0.06, 0.06]\n"
            "//   dsigma: dσ*/dt, [-1.0, 1.0] 1/s\n"
            "// Returns f: [-1.0, 0.18]; NaN where an input is NaN or there is no value.\n"
            "double ais_reaction(double sigma, double dsigma);\n"
        ) in text

    def test_parameters_of_all_kinds_are_reported(self, unit_of):
        assert "//   status: REFUSING_OK, or which output" in generate(unit_of("refusing"), "c").files["refusing.h"]
        assert "//   state: begun by holding_init; what outputs" in generate(unit_of("holding"), "c").files["holding.h"]
        many = generate(unit_of("chained"), "c").files["chained.h"]
        assert "//   outputs: where the results go, NaN where" in many
        assert "//     u: [-5.0, 20.0]\n//     v: [0.0, 1.0]\n" in many


class TestHostileTexts:
    @pytest.fixture
    def unit(self):
        system = loads((RULES / "tipper.fz").read_text(encoding="utf-8"))
        inputs = tuple(i.model_copy(update={"label": HOSTILE, "unit": HOSTILE}) for i in system.inputs)
        outputs = tuple(o.model_copy(update={"label": HOSTILE, "unit": HOSTILE}) for o in system.outputs)
        system = system.model_copy(update={"inputs": inputs, "outputs": outputs, "title": HOSTILE})
        return prepare(system, "", verdicts=quickly(system)[0])

    def test_hold_no_trigraph_and_turn_no_line(self, unit):
        text = "".join(generate(unit, "c").files.values())
        assert "??" not in text
        assert not set("\u202a\u202b\u202d\u202e\u2066\u2067\u2068\u200f") & set(text)

    def test_end_no_comment_of_c(self, unit, compiled):
        found = compiled(unit, flags=["-Wcomment", "-trigraphs"])
        assert found.code == 0, found.output

    def test_end_no_comment_of_structured_text(self, unit):
        (text,) = generate(unit, "st").files.values()
        block = Block(text)
        assert (block.inputs, block.outputs) == (["service", "food"], ["tip", "tip_valid"])
