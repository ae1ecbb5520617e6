"""The generated ES module needs nothing but an engine of JavaScript, and computes the same numbers."""

import html.parser
import json
import math
import re
import subprocess

import pytest

from fuzzyctl.codegen.files import generate
from fuzzyctl.expr import FUNCTIONS
from tests import sizes
from tests.fuzzyctl.codegen.conftest import ALL, prepared, run_selftests, unit_of, written
from tests.peers.drawing import CONJUNCTIONS, DISJUNCTIONS
from tests.properties.drawn_systems import SHAPES, SIZED

pytestmark = pytest.mark.usefixtures("node")


def agree(units, folder):
    """Run the self-tests of some units, and return what they print."""
    done = run_selftests([generate(unit, "javascript").files for unit in units], folder)
    assert done.code == 0, done.output
    assert done.output.count(" 0 failures") == len(units)
    return done.output


def run(text, folder, script):
    """Write a module as m.mjs and run a script beside it."""
    (module,) = (t for name, t in written(text, "javascript").files.items() if "test" not in name)
    (folder / "m.mjs").write_text(module, encoding="utf-8")
    (folder / "main.mjs").write_text(script, encoding="utf-8")
    return subprocess.run(["node", "main.mjs"], capture_output=True, text=True, check=False, cwd=folder)


def answer(text, folder, script):
    """Return what a script prints as JSON."""
    done = run(text, folder, script)
    assert (done.returncode, done.stderr) == (0, "")
    return json.loads(done.stdout)


def degrees():
    """Return a system whose outputs are the degrees of terms of every membership function over [0, 1]."""
    terms = [f"{kind}({', '.join(map(repr, own))})" for kind, given in SHAPES.items() for own in given]
    terms += [f"{kind}({', '.join(repr(v) for _, v in given)})" for kind, given in SIZED.items()]
    lines = ["system degrees", "defuzzifier weighted_sum", "input x in [0, 1]"]
    lines += [f"  t{k} = {term}" for k, term in enumerate(terms)]
    for k in range(len(terms)):
        lines += [f"output u{k} in [0, 1] else 0", "  one = constant(1)"]
    return "\n".join([*lines, *(f"if x is t{k} then u{k} is one" for k in range(len(terms)))]) + "\n"


TWO = """system {name}
{settings}
input x in [0, 1]
  a = triangle(-inf, 0, 0.8)
  b = gaussian(0.7, 0.2)
input y in [0, 1]
  a = triangle(-inf, 0, 0.9)
  b = sigmoid(0.5, 8)
output u in [0, 1] else 0.5
  p = triangle(-0.2, 0.1, 0.6)
  q = trapezoid(0.3, 0.5, 0.7, 1.3)
if {first} then u is p
if {second} then u is q weight 0.8
"""


#: Both evaluation and rates sample the first output.
ADAPTIVE = """system gains
input x in [0, 1]
  terms low up
output v in [0, 1] defuzzifier centroid(resolution=37)
  off = gaussian(0, 0.3)
  on  = gaussian(1, 0.2)
output k in [-3, 3] adaptive rate 2 - 3 * x defuzzifier weighted_average
  a = constant(-1)
  b = constant(1)
if x is low then v is off
if x is up then v is on
if v is off then k is a
if v is on then k is b
"""


#: Half of the area ends where a gap begins.
GAP = """system gap
implication bounded_difference
defuzzifier bisector
input x in [0, 1]
  any = trapezoid(-inf, 0, 1, inf)
output u in [-1, 1]
  p = gaussian(-0.5, 0.1)
  q = gaussian(0.5, 0.1)
if x is any then u is p weight 0.9
if x is any then u is q weight 0.9
"""


def two(name, settings, first="x is a and y is a", second="x is b or y is b"):
    return TWO.format(name=name, settings=settings, first=first, second=second)


def functions():
    """Return a system whose outputs are the values of the functions of the language."""
    calls = [f"{name}({', '.join(['x', 'y'][:least])})" for name, (least, _) in FUNCTIONS.items()]
    calls += ["min(x, y, 0.25)", "max(x, y, 0.25)", "x ^ y", "abs(x) ^ inf"]
    lines = ["system functions", "defuzzifier weighted_average", "input x in [-2, 2] extrapolate"]
    lines += ["  any = trapezoid(-inf, 0, 1, inf)", "input y in [-3, 3] extrapolate"]
    for k, call in enumerate(calls):
        lines += [f"output u{k} in [-20, 20] else 0", f"  f = function({call})"]
    lines += [f"if x is any then {', '.join(f'u{k} is f' for k in range(len(calls)))}"]
    return "\n".join(lines) + "\n"


def integrals():
    """Return systems with adaptive integrals."""
    pairs = [("product", "sum", "centroid"), ("min", "max", "bisector"), ("min", "max", "centroid")]
    pairs += [("nilpotent_minimum", "nilpotent_maximum", "bisector")]
    for i, a, kind in pairs if sizes.LONG else pairs[:1]:
        text = two("c", f"implication {i}\naggregation {a}\ndefuzzifier {kind}", "x is a", "x is b")
        yield text.replace("triangle(-0.2, 0.1, 0.6)", "gaussian(0.1, 0.2)")
    yield GAP


def sets():
    """Return systems with every norm, hedge and defuzzifier over sets."""
    sampled = "defuzzifier centroid(resolution=11)"
    yield from (two("norms", f"and {n}\nor {m}\n{sampled}") for n, m in zip(CONJUNCTIONS, DISJUNCTIONS, strict=True))
    hedged = two("hedged", sampled, "x is a", "x is b")
    yield hedged + "".join(f"if x is {h} a and y is {h} b then u is {'pq'[k % 2]}\n" for k, h in enumerate(HEDGES))
    for kind in ("centroid", "bisector", "som", "lom", "mom"):
        yield from (two("sets", f"defuzzifier {kind}{more}") for more in ("", "(resolution=11)"))
    yield from (two("sets", f"implication product\naggregation sum\ndefuzzifier {k}") for k in ("centroid", "bisector"))


HEDGES = "very somewhat extremely slightly seldom not any".split()
#: Held values stay where an output has no value.
ROOTS = """system roots
defuzzifier weighted_average
input x in [-2, 2]
  low = triangle(-inf, -2, -1)
  high = triangle(-0.5, 2, inf)
output u in [-9, 9] else hold(3)
if x is low then u is function(sqrt(x + 1.5))
if x is high then u is function(x)
"""
NAMED = """system {0}
defuzzifier weighted_average
input {0} in [0, 1]
  terms low up
output {0}2 in [0, 1] else hold
  p = constant(0)
  q = constant(1)
if {0} is low then {0}2 is p
if {0} is up then {0}2 is q
"""
NAMES = ("_then", "await", "inputs", "find", "NaN", "x_init", "v1", "T0", "state", "compare")


class TestNumbers:
    def test_are_those_of_the_kernel(self, tmp_path):
        units = [*map(unit_of, ALL), *map(prepared, (degrees(), functions(), ROOTS, ADAPTIVE, *sets(), *integrals()))]
        units += [prepared("ais_reaction", algorithm=a) for a in ("rules", "interpolation")]
        units += [prepared("active", algorithm="active"), unit_of("tipper", table=33)]
        units += [prepared(NAMED.format(name)) for name in NAMES]
        printed = agree(units, tmp_path)
        assert "find(T0, " in "".join(generate(unit_of("tipper", table=33), "javascript").files.values())
        exact = {line.split(":")[0] for line in printed.splitlines() if "worst error 0," in line}
        assert exact >= {"ais_reaction", "boundary_layer", "drastic", "holding", "active"}

    def test_of_powers_are_those_of_ieee_754(self, tmp_path):
        text = (
            "system p\ndefuzzifier weighted_average\ninput x in [-2, 2] extrapolate\n"
            "  any = trapezoid(-inf, 0, 1, inf)\ninput y in [-2, 2] extrapolate\noutput u in [-9, 9] else 0\n"
            "if x is any then u is function(x ^ y)\n"
        )
        points = [(1.0, math.inf), (-1.0, -math.inf), (0.0, -1.0), (-8.0, 1 / 3), (2.0, math.inf), (0.5, math.inf)]
        shown = json.dumps([[str(x).replace("inf", "Infinity"), str(y).replace("inf", "Infinity")] for x, y in points])
        script = (
            f"import {{ p }} from './m.mjs';console.log(JSON.stringify({shown}.map(([x, y]) => String(p(+x, +y)))));"
        )
        assert answer(text, tmp_path, script) == ["1", "1", "Infinity", "NaN", "Infinity", "0"]


class TestModule:
    def test_tells_names_units_and_ranges(self, tmp_path):
        script = "import * as m from './m.mjs';console.log(JSON.stringify([m.inputs, m.outputs, Object.keys(m)]));"
        inputs, outputs, names = answer("tipper", tmp_path, script)
        assert [i["name"] for i in inputs] == ["service", "food"]
        assert [(i["lower"], i["upper"]) for i in inputs] == [(0.0, 10.0)] * 2
        assert [o["name"] for o in outputs] == ["tip"]
        assert set(inputs[0]) == {"name", "label", "unit", "lower", "upper", "extrapolate"}
        assert sorted(names) == ["inputs", "outputs", "tipper"]

    def test_returns_an_array_for_several_outputs(self, tmp_path):
        script = "import { chained } from './m.mjs';console.log(JSON.stringify(chained(NaN, 1).map(String)));"
        assert answer("chained", tmp_path, script) == ["NaN", "NaN"]

    @pytest.mark.parametrize(
        ("call", "message"),
        [
            ("f('1', 0)", "TypeError: a number is expected for 'sigma', not string"),
            ("f(1)", "TypeError: a number is expected for 'dsigma', not undefined"),
        ],
    )
    def test_refuses_what_is_no_number(self, tmp_path, call, message):
        done = run("ais_reaction", tmp_path, f"import {{ ais_reaction as f }} from './m.mjs';{call};")
        assert done.returncode == 1
        assert message in done.stderr

    def test_throws_where_no_rule_fires(self, tmp_path):
        script = (
            "import { refusing, NoRuleFiresError } from './m.mjs';"
            "try { refusing(5, 0.9); } catch (e) {"
            " console.log(JSON.stringify([e instanceof NoRuleFiresError, e.output, e.name + ': ' + e.message])); }"
        )
        message = "NoRuleFiresError: no rule fires for output 'u'"
        assert answer("refusing", tmp_path, script) == [True, "u", message]

    def test_leaves_the_state_to_its_caller(self, tmp_path):
        script = (
            "import { holding, holding_init } from './m.mjs';const one = holding_init(), other = holding_init();"
            "const found = [holding(5, 0.9, one), holding(0, -1, one), holding(5, 0.9, one), holding(5, 0.9, other)];"
            "console.log(JSON.stringify([found, one, other]));"
        )
        assert answer("holding", tmp_path, script) == [[3, -4, -4, 3], {"held_u": -4}, {"held_u": 3}]

    def test_adapts_by_a_step_and_not_beyond_the_range(self, tmp_path):
        script = (
            "import * as m from './m.mjs';const state = m.adaptive_init();"
            "for (let k = 0; k < 1000; ++k) m.adaptive_adapt(state, 1, 0.5, 0.1);"
            "console.log(JSON.stringify([m.adaptive_init(), state, m.adaptive_rates(NaN, 0, state).map(String)]));"
        )
        first, last, rates = answer("adaptive", tmp_path, script)
        assert first == {"consequent": [-2, 0, 3]}
        assert last["consequent"][0] == -3
        assert rates == ["NaN"] * 3

    def test_is_no_promise(self, tmp_path):
        text = "system _then\ndefuzzifier weighted_average\ninput x in [0, 1]\n  terms low up\noutput u in [0, 1]\n"
        text += "  p = constant(0)\nif x is low or x is up then u is p\n"
        script = "const m = await import('./m.mjs');console.log(JSON.stringify(Object.keys(m)));"
        assert "then_fz" in answer(text, tmp_path, script)


class TestSelfTest:
    def test_fails_where_a_number_is_another(self, tmp_path):
        files = dict(written("tipper", "javascript").files)
        files["tipper.mjs"] = files["tipper.mjs"].replace("return v", "return 1.0000001 * v")
        done = run_selftests([files], tmp_path)
        assert done.code == 1
        assert re.search(r"tipper: tip: worst error \S+, allowed 3e-11", done.output)

    def test_fails_where_another_output_refuses(self, tmp_path):
        files = dict(written("refusing", "javascript").files)
        files["refusing.mjs"] = files["refusing.mjs"].replace('NoRuleFiresError("u")', 'NoRuleFiresError("v")')
        assert run_selftests([files], tmp_path).code == 1


class Scripts(html.parser.HTMLParser):
    """The elements of a page, and the text of its scripts."""

    def __init__(self):
        super().__init__()
        self.tags, self.scripts = [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)

    def handle_data(self, data):
        self.scripts.append(data)


HOSTILE = "</script><script>alert(1)</script>`${alert(2)}`\u2028<!--<script>\u0085*/ -->"


class TestTitles:
    @pytest.fixture
    def own(self):
        return (
            f'system t "{HOSTILE}"\nsource "{HOSTILE}"\ndefuzzifier weighted_average\ninput x "{HOSTILE}" in [0, 1] '
            f'unit "{HOSTILE}"\n  terms a b\noutput u "{HOSTILE}" in [0, 1] unit "{HOSTILE}"\n  p = constant(0)\n'
            "  q = constant(1)\nif x is a then u is p\nif x is b then u is q\n"
        )

    def test_come_back_as_they_are(self, own, tmp_path):
        script = "import { t, inputs, outputs } from './m.mjs';console.log(JSON.stringify([t(1), inputs, outputs]));"
        value, inputs, outputs = answer(own, tmp_path, script)
        assert value == 1
        assert [inputs[0][key] for key in ("label", "unit")] == [HOSTILE] * 2
        assert [outputs[0][key] for key in ("label", "unit")] == [HOSTILE] * 2

    def test_do_not_end_the_script_of_a_page(self, own):
        for text in written(own, "javascript").files.values():
            page = Scripts()
            page.feed(f"<script type=module>{text}</script>")
            assert page.tags == ["script"]
            assert "".join(page.scripts) == text
            assert "<!--" not in text
            assert "\u2028" not in text
