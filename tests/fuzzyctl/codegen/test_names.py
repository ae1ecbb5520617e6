"""Systems, inputs and outputs may have any names; generated text spells them in ASCII and keeps them apart."""

import ast
import builtins
import keyword
import re
import subprocess

import pytest

from fuzzyctl.codegen.files import generate, sources
from tests.fuzzyctl.codegen.conftest import ALL, SANITIZED, c_selftests, prepared, run_c, unit_of, written
from tests.fuzzyctl.codegen.steps.targets import unit_of as step_of
from tests.fuzzyctl.codegen.steps.texts import TEXTS

C99 = (
    "auto break case char const continue default do double else enum extern float for goto if inline int long register "
    "restrict return short signed sizeof static struct switch typedef union unsigned void volatile while"
).split()
ST = (
    "class method end_method interface namespace final this super null using eno if then else real lreal bool array of "
    "and mod true false var function exit return"
).split()
#: Words that no input of a rule file can have as its name.
TAKEN = set("if then else and or not in is input output of true false".split()) | set(
    "abs min max sqrt exp log sin cos tan atan2 sign floor ceil round mod fmod inf nan pi".split()
)
JAVASCRIPT = (
    "await break case catch class const delete enum eval export function new null static this yield NaN".split()
)


def names_of(names, target):
    """Return how the inputs of a controller with some names are called by its function, those with a usable name."""
    names = [n for n in names if n.lower() not in TAKEN]
    lines = "".join(f"input {name}\n" for name in names)
    text = "".join(sources(step_of(f"controller own\n{lines}output y = 0\nevery 1 s\n", target), target).values())
    if target == "st":
        return re.findall(r"^  (\w+) : LREAL;", text[text.index("VAR_INPUT") : text.index("END_VAR")], re.M)
    inside = re.search({"python": r"def step\(([^)]*)", "javascript": r"function own_step\(([^)]*)"}.get(
        target, r"double own_step\(([^)]*)\);"), text)[1]  # fmt: skip
    return [part.split()[-1] for part in inside.removesuffix(", state").split(",")]


class TestNames:
    def test_are_spelt_in_ascii_and_given_out_once(self):
        spelt = {
            "sigma": "sigma",
            "σ": "sigma_2",
            "sigma_2": "sigma_2_2",
            "Σ": "Sigma",
            "dσ_dt": "dsigma_dt",
            "ά": "alpha",
            "größe": "grou00DFe",
            "naïve": "naive",
            "скорость": "u0441u043Au043Eu0440u043Eu0441u0442u044C",
            "_hidden": "hidden",
            "a__b_": "a_b",
            "_1": "n1",
            "A": "A",
            "a": "a",
        }
        assert names_of(spelt, "c") == [*spelt.values()]

    def test_differ_by_more_than_case_where_the_language_does_not_know_it(self):
        assert names_of(["A", "a", "Real"], "st") == ["A", "a_2", "Real_fz"]

    @pytest.mark.parametrize(
        ("target", "words"),
        [
            ("c", C99),
            ("st", [*ST, *map(str.upper, ST)]),
            ("python", keyword.kwlist),
            ("javascript", JAVASCRIPT),
            ("c", ["x0", "v12", "T0", "t3", "C", "c1", "K0", "u1", "rate0", "result1", "Rv1"]),
        ],
    )
    def test_are_never_words_of_the_language_or_of_generated_values(self, target, words):
        own = [w for w in words if w.lower() not in TAKEN]
        found = names_of(own, target)
        assert len(set(found)) == len(own)
        assert not {*found} & {*own}
        assert all(f.startswith(w) for f, w in zip(found, own, strict=True) if target != "st")

    def test_are_never_those_of_the_headers_of_c(self, gcc):
        headers = "".join(f"#include <{h}.h>\n" for h in "float math stdbool stddef stdint stdio string".split())
        run = [["gcc", "-std=gnu17", "-E", *flag, "-xc", "-"] for flag in (["-dM"], [])]
        defined, declared = (subprocess.run(r, input=headers, capture_output=True, text=True, check=True) for r in run)
        macros = set(re.findall(r"#define ([A-Za-z]\w*)", defined.stdout))
        text = re.sub(r"^#.*$", "", declared.stdout, flags=re.M)
        functions = set(re.findall(r"\b(?:extern|\*|int|double|float)\s+\**([A-Za-z]\w*) \(", text))
        assert len(macros) > 100
        assert len(functions) > 200
        own = sorted(n for n in macros | functions if "__" not in n and not n.endswith("_"))
        assert not {*names_of(own, "c")} & macros
        # What a system is called becomes the name of a function.
        for name in ("remove", "stdin", "printf", "fmax"):
            assert (
                f"{name}_fz_step"
                in sources(step_of(f"controller {name}\ninput x\noutput y = x\nevery 1 s\n"), "c")[f"{name}_fz.h"]
            )


PAIR = """system {system}
and product
defuzzifier weighted_average
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
    more = {"otherwise": " else error" if both else "", "both": f" and {y} is low" if both else ""}
    return PAIR.format(system=system, x=x, y=y, u=u, v=v, **more)


def identifiers(text):
    """Return the identifiers of C text without comments, strings, what is included, and functions of its own."""
    text = re.sub(r"^static [^;={]*\n\{.*?^\}", " ", text, flags=re.M | re.S)
    text = re.sub(r'//[^\n]*|"[^"\n]*"|#include[^\n]*|#define|#(if|el|else|endif|error|undef)[^\n]*', " ", text)
    return set(re.findall(r"(?<![\w.])[A-Za-z_]\w*", text))


STEP_NAMES = """controller {controller}
input {x} in [-2, 2]
input {y} in [-2, 2]
state {s} = 0.5
next {s} = 0.5 * {s} + {x}
output {u} = {s} + delay({y}, 5)
output {v} = {x} * {y}
{every}"""


class TestC:
    """Inputs and outputs may be called anything, the files' own names included."""

    def test_every_name_of_the_files_begins_with_that_of_the_block_or_changes_as_an_input(self):
        for unit in [*map(unit_of, ALL), *map(step_of, TEXTS.values())]:
            texts = sources(unit, "c")
            name = next(iter(texts))[:-2]
            members = set(re.findall(r"^    \w+ (\w+)(?:\[\d+\])?;", texts[f"{name}.h"], re.M))
            arguments = set(re.findall(r"\b(?:double|float) (\w+)[,)]", texts[f"{name}.h"]))
            left = identifiers("".join(texts.values())) - members - arguments - {name}
            left = {n for n in left if not n.startswith((f"{name}_", f"{name.upper()}_", "__"))}
            assert not {*names_of(sorted(left), "c")} & left

    @pytest.mark.parametrize(
        "names",
        [
            ("a", "a_is_nan", "A_OK", "A_NAN", "A_NO_RULE_FOR_A_NAN_FZ"),
            ("A", "A_NO_RULE_FOR_VECTORS_FZ", "A_status", "VECTORS", "A_H"),
            *((n, "NAN", "refused", "DBL_MAX", "offsetof") for n in ("inputs", "v", "VECTORS", "stdin", "fp")),
        ],
    )
    def test_those_of_the_file_itself_may_be_those_of_a_system(self, tmp_path, names):
        assert run_c(written(pair(*names)).files, tmp_path, SANITIZED if names[0] == "a" else ()).code == 0

    @pytest.mark.parametrize(("x", "y"), [("s_place", "s_between"), ("NULL", "INT16_MAX")])
    def test_so_may_those_of_fixed_point(self, tmp_path, x, y):
        text = pair(x=x, y=y, u="S_FRACTION", v="EOF", both=False)
        assert run_c(written(text, "c", "--fixed", "Q5.10").files, tmp_path).code == 0

    @pytest.mark.parametrize("every", ["", "every 1 s\n"])
    def test_so_may_those_of_a_controller(self, gcc, tmp_path, every):
        rows = [
            ("a", "a_is_nan", "a_state", "A_H", "A_PERIOD", "a_step"),
            ("A", "state", "outputs", "members", "VECTORS", "turn"),
            ("v", "double", "found", "int", "result", "k"),
            ("inputs", "u0", "s0", "delay_1", "v1", "delay_1_oldest"),
            ("stdin", "NAN", "size_t", "started", "EOF", "main"),
            ("fp", "σ", "sigma", "Σ", "Sigma", "sigma_2"),
        ]
        keys = ("controller", "x", "y", "s", "u", "v")
        units = [step_of(STEP_NAMES.format(every=every, **dict(zip(keys, row, strict=True)))) for row in rows]
        c_selftests([generate(u, "c").files for u in units], tmp_path)

    def test_members_of_states_are_joined_by_underscores_and_numbered(self):
        text = "controller inner\ninput x\nstate s = 0\nnext s = x\noutput y = s\ncontroller own\ninput x\n"
        text += "block a = inner(x)\nstate a_s = 0\nnext a_s = a.y\noutput y = a_s\nevery 1 s\n"
        for own, expected in (
            (TEXTS["inner"], ["a_s", "b_s"]),
            (TEXTS["pid"], ["derivative_1", "started", "derivative_1_filtered", "integral_4_sum"]),
            (text, ["a_s", "a_s_2"]),
        ):
            header = next(iter(sources(step_of(own), "c").values()))
            assert re.findall(r"    double (\w+);", re.search(r"struct \{([^}]*)\} \w+_state;", header)[1]) == expected


class TestPython:
    def test_every_name_of_the_module_changes_as_an_input(self):
        for unit in map(unit_of, ALL):
            ((file, text),) = sources(unit, "python").items()
            tree = ast.parse(text)
            given = {node.arg for node in ast.walk(tree) if isinstance(node, ast.arg)} | {file[:-3]}
            used = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)} - given
            of_main = {"arguments", "values", "value", "point", "name", "error"}
            used = sorted(n for n in used - of_main if not n.startswith("__"))
            assert not {*names_of(used, "python")} & {*used}
            assert {n for n in used if n in dir(builtins)} >= {"float"}

    @pytest.mark.parametrize("system", ["values", "point", "name", "value", "arguments", "error", "zip", "len"])
    def test_a_system_may_be_called_what_its_module_calls_its_own(self, system, capsys):
        names = {"__name__": "generated"}
        unit = prepared(pair(system, x="zip", y="float", u="len", v="print"))
        exec(compile(*sources(unit, "python").values(), "generated", "exec"), names)
        assert names["main"](["0.25", "0"]) == 0
        assert capsys.readouterr().out == "len = 2.5\nprint = 7.5\n"
