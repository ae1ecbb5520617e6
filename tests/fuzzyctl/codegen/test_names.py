import ast
import math
import re
import shutil
import subprocess

import pytest

from fuzzyctl import loads
from fuzzyctl.codegen import c_source
from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.files import generate
from fuzzyctl.codegen.fixed.fixed_format import to_format
from fuzzyctl.codegen.fixed.fixed_system import fixed_point
from fuzzyctl.codegen.names import (
    C_FUNCTION_RESERVED,
    C_RESERVED,
    JAVASCRIPT_FUNCTION_RESERVED,
    LIBRARY,
    PYTHON_FUNCTION_RESERVED,
    PYTHON_RESERVED,
    ST_RESERVED,
    Names,
    ascii_name,
)
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.codegen.python_source import module, module_name
from fuzzyctl.codegen.selftests import c_selftest
from fuzzyctl.codegen.vectors import Expected, Vector

IDENTIFIER = re.compile(r"[A-Za-z](_?[A-Za-z0-9])*")


class TestNames:
    @pytest.mark.parametrize(
        ("name", "expected"),
        [
            ("sigma", "sigma"),
            ("σ", "sigma"),
            ("Σ", "Sigma"),
            ("dσ_dt", "dsigma_dt"),
            ("ά", "alpha"),
            ("größe", "grou00DFe"),
            ("naïve", "naive"),
            ("скорость", "u0441u043Au043Eu0440u043Eu0441u0442u044C"),
            ("_hidden", "hidden"),
            ("a__b_", "a_b"),
            ("_1", "n1"),
            ("__", "name"),
        ],
    )
    def test_are_spelt_in_ascii(self, name, expected):
        assert ascii_name(name) == expected
        assert IDENTIFIER.fullmatch(ascii_name(name))

    @pytest.mark.parametrize("reserved", [C_RESERVED, ST_RESERVED, PYTHON_RESERVED, JAVASCRIPT_FUNCTION_RESERVED])
    def test_are_never_words_of_the_language(self, reserved):
        for word in reserved:
            assert Names(reserved).claim(word) not in reserved

    @pytest.mark.parametrize("own", ["x0", "v12", "T0", "t3", "C", "c1", "K0", "u1", "rate0", "result1", "Rv1"])
    def test_are_never_those_of_generated_values(self, own):
        assert Names(()).claim(own) == f"{own}_fz"

    def test_are_given_out_once(self):
        names = Names(C_RESERVED)
        assert [names.claim(n) for n in ("σ", "sigma", "sigma", "sigma_2")] == [
            "sigma",
            "sigma_2",
            "sigma_3",
            "sigma_2_2",
        ]

    def test_may_differ_by_case_where_the_language_knows_it(self):
        names, folded = Names(()), Names((), fold=True)
        assert [names.claim("A"), names.claim("a")] == ["A", "a"]
        assert [folded.claim("A"), folded.claim("a")] == ["A", "a_2"]
        assert Names(ST_RESERVED, fold=True).claim("Real") == "Real_fz"

    def test_that_are_suffixed_or_numbered_are_reserved_by_nobody(self):
        names = Names(["if", "if_fz", "x_2"])
        assert [names.claim(n) for n in ("if", "x", "x")] == ["if_fz_fz", "x", "x_3"]

    def test_stay_apart_from_what_generated_text_begins_its_own_with(self):
        names = Names(())
        assert names.claim("a_is_nan", apart_from=("a_",)) == "a_is_nan_fz"
        assert names.claim("about", apart_from=("a_",)) == "about"
        assert names.claim("a_is_nan", apart_from=("b_",)) == "a_is_nan"


PAIR = """system {system}
{method}
input {x} in [0, 1]
  terms low@0 high@1
input {y} in [0, 2]
  terms low@0 high@2
output {u} in [0, 10]{otherwise}
  terms A=0 B=10
output {v} in [0, 10]{otherwise}
  terms A=0 B=10
if {x} is low{both} then {u} is A, {v} is B
if {x} is high then {u} is B, {v} is A
"""


def pair(system="s", x="x", y="y", u="u", v="v", *, both=True):
    """Return a system of two inputs and outputs: one that may refuse, or one that fixed point can write."""
    names = {"system": system, "x": x, "y": y, "u": u, "v": v}
    method = "and product\ndefuzzifier weighted_average"
    text = PAIR.format(
        **names, method=method, otherwise=" else error" if both else "", both=f" and {y} is low" if both else ""
    )
    return prepare(loads(text), text)


def identifiers(text):
    """Return the identifiers of C text without comments, strings, what is included, and functions of its own."""
    text = re.sub(r"^static [^;={]*\n\{.*?^\}", " ", text, flags=re.M | re.S)
    text = re.sub(r'//[^\n]*|"[^"\n]*"|#include[^\n]*|#define|#(if|el|else|endif|error|undef)[^\n]*', " ", text)
    return set(re.findall(r"(?<![\w.])[A-Za-z_]\w*", text))


def _unreserved(layout, text, kept):
    """Return the names of a text that an input or the system may have, too."""
    given = {*layout.arguments, *layout.outputs, *(f"held_{o}" for o in layout.outputs), layout.name}
    heads = (f"{layout.name}_", f"{layout.name.upper()}_", "__")
    left = {n for n in identifiers(text) - given if not n.startswith(heads)}
    return {n for n in left if Names(kept).claim(n) == n}


class TestC:
    """Inputs and outputs may be called anything, the files' own names included."""

    @pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
    def test_every_name_of_the_headers_is_reserved(self):
        headers = "".join(f"#include <{h}.h>\n" for h in "float math stdbool stddef stdint stdio string".split())
        run = [["gcc", "-std=gnu17", "-E", *flag, "-xc", "-"] for flag in (["-dM"], [])]
        defined, declared = (subprocess.run(r, input=headers, capture_output=True, text=True, check=True) for r in run)
        macros = set(re.findall(r"#define ([A-Za-z]\w*)", defined.stdout))
        assert len(macros) > 100
        assert macros <= C_RESERVED
        text = re.sub(r"^#.*$", "", declared.stdout, flags=re.M)
        functions = set(re.findall(r"\b(?:extern|\*|int|double|float)\s+\**([A-Za-z]\w*) \(", text))
        assert len(functions) > 200
        assert functions <= C_FUNCTION_RESERVED

    def test_every_name_of_the_files_is_reserved_or_begins_with_that_of_the_system(self, unit_of, kind):
        unit = unit_of(kind)
        layout = CLayout(unit)
        vector = Vector((0.0,) * len(layout.arguments), (math.nan,) * len(layout.outputs))
        self_test = c_selftest(unit, Expected([1.0] * len(layout.outputs), [vector], [vector]))
        for text, kept in (
            (c_source.header(unit) + c_source.source(unit), C_RESERVED),
            (self_test, C_FUNCTION_RESERVED),
        ):
            assert not _unreserved(layout, text, kept)

    def test_so_is_that_of_fixed_point(self, unit_of):
        unit = unit_of("ais_reaction")
        for name, text in generate(unit, "c", fixed_point(unit, to_format("Q3.12"))).files.items():
            kept = C_FUNCTION_RESERVED if "_selftest" in name else C_RESERVED
            assert not _unreserved(CLayout(unit), text, kept)

    def test_those_of_the_file_itself_may_be_those_of_inputs_and_outputs(self, compiled, sanitized):
        unit = pair("a", x="a_is_nan", y="A_OK", u="A_NAN", v="A_NO_RULE_FOR_A_NAN_FZ")
        built = compiled(unit, sanitized)
        assert built.code == 0, built.output

    def test_so_may_types_and_values(self, compiled):
        unit = pair("A", x="A_NO_RULE_FOR_VECTORS_FZ", y="A_status", u="VECTORS", v="A_H")
        built = compiled(unit)
        assert built.code == 0, built.output

    @pytest.mark.parametrize(("x", "y"), [("s_place", "s_between"), ("s_outputs", "S_H"), ("NULL", "INT16_MAX")])
    def test_so_may_those_of_fixed_point(self, compiled, x, y):
        unit = pair(x=x, y=y, u="S_FRACTION", v="EOF", both=False)
        built = compiled(unit, fixed=fixed_point(unit, to_format("Q5.10")))
        assert built.code == 0, built.output

    @pytest.mark.parametrize("system", ["inputs", "v", "VECTORS", "stdin", "remove", "FILE", "string"])
    def test_a_system_may_be_called_what_the_self_test_calls_its_own(self, compiled, system):
        built = compiled(pair(system, x="NAN", y="refused", u="DBL_MAX", v="offsetof"))
        assert built.code == 0, built.output

    def test_macros_of_a_system_are_never_those_of_the_library(self):
        assert CLayout(pair("fp")).name == "fp_fz"
        assert "FP_NAN" in LIBRARY


class TestPython:
    def test_every_name_of_the_module_is_reserved(self, unit_of, kind):
        unit = unit_of(kind)
        tree = ast.parse(module(unit))
        given = {node.arg for node in ast.walk(tree) if isinstance(node, ast.arg)} | {module_name(unit)}
        for node in ast.walk(tree):
            if isinstance(node, ast.Name) and node.id not in given and not node.id.startswith("__"):
                assert Names(PYTHON_FUNCTION_RESERVED).claim(node.id) != node.id, node.id

    @pytest.mark.parametrize("system", ["values", "point", "name", "value", "arguments", "error", "zip", "len"])
    def test_a_system_may_be_called_what_its_module_calls_its_own(self, system, capsys):
        unit = pair(system, x="zip", y="float", u="len", v="print")
        names = {"__name__": "generated"}
        exec(compile(module(unit), "generated", "exec"), names)
        assert names["main"](["0.25", "0"]) == 0
        assert capsys.readouterr().out == "len = 2.5\nprint = 7.5\n"


class TestStructuredText:
    @pytest.mark.parametrize(
        "word", "class method end_method interface namespace final this super null using eno".split()
    )
    def test_words_of_the_third_edition_are_no_names(self, word):
        assert Names(ST_RESERVED, fold=True).claim(word.upper()) == f"{word.upper()}_fz"
