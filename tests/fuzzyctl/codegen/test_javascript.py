"""The generated ES module needs nothing but an engine of JavaScript, and computes the same numbers."""

import html.parser
import json
import math
import re
import subprocess

import pytest

from fuzzyctl import loads
from fuzzyctl.codegen.files import generate
from fuzzyctl.codegen.names import JAVASCRIPT_FUNCTION_RESERVED
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.codegen.simplify import functions
from fuzzyctl.expr import FUNCTIONS, Number
from fuzzyctl.formulas import CONJUNCTIONS, DISJUNCTIONS, HEDGES
from fuzzyctl.kernels.program.program import Quadrature
from fuzzyctl.model.method import MAXIMA, Defuzzifier, Method
from fuzzyctl.model.rule import Consequent, Is, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Membership, Output, Term
from tests.fuzzyctl.codegen.conftest import ALL, run_selftests
from tests.properties.drawn_systems import SHAPES, SIZED

pytestmark = pytest.mark.usefixtures("node")


def written(unit):
    """Return the text of the module."""
    return next(text for name, text in generate(unit, "javascript").files.items() if "test" not in name)


def agree(units, folder):
    """Run the self-tests of some units, and return what they print."""
    done = run_selftests([generate(unit, "javascript").files for unit in units], folder)
    assert done.code == 0, done.output
    assert done.output.count(" 0 failures") == len(units)
    return done.output


def run(unit, folder, script):
    """Write a module as m.mjs and run a script beside it."""
    (folder / "m.mjs").write_text(written(unit), encoding="utf-8")
    (folder / "main.mjs").write_text(script, encoding="utf-8")
    return subprocess.run(["node", "main.mjs"], capture_output=True, text=True, check=False, cwd=folder)


def answer(unit, folder, script):
    """Return what a script prints as JSON."""
    done = run(unit, folder, script)
    assert (done.returncode, done.stderr) == (0, "")
    return json.loads(done.stdout)


def memberships():
    """Terms of every membership function over [0, 1]."""
    for kind, given in SHAPES.items():
        yield from (Membership(kind=kind, arguments=tuple(map(Number, own))) for own in given)
    for kind, given in SIZED.items():
        yield Membership(kind=kind, arguments=tuple(Number(v) for _, v in given))


def degrees():
    """A system whose outputs are the degrees of terms of every membership function."""
    terms = [Term(name=f"t{k}", membership=m) for k, m in enumerate(memberships())]
    x = Input(name="x", lower=Number(0.0), upper=Number(1.0), terms=tuple(terms))
    one = Term(name="one", membership=Membership(kind="constant", arguments=(Number(1.0),)))
    outputs = [
        Output(name=f"u{k}", lower=Number(0.0), upper=Number(1.0), terms=(one,), otherwise=Number(0.0))
        for k in range(len(terms))
    ]
    rules = [
        Rule(antecedent=Is(variable="x", term=t.name), consequents=(Consequent(output=o.name, term="one"),))
        for t, o in zip(terms, outputs, strict=True)
    ]
    method = Method(defuzzifier=Defuzzifier(kind="weighted_sum"))
    return FuzzySystem(name="degrees", inputs=(x,), outputs=tuple(outputs), blocks=tuple(rules), method=method)


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
    text = TWO.format(name=name, settings=settings, first=first, second=second)
    return prepare(loads(text), text)


class TestNumbers:
    def test_of_systems_of_all_kinds_are_those_of_the_kernel(self, unit_of, tmp_path):
        agree([unit_of(kind) for kind in ALL], tmp_path)

    def test_without_functions_are_so_to_the_last_bit(self, unit_of, tmp_path):
        plain = [u for u in map(unit_of, ALL) if not functions(u.program) - {"min", "max", "clip", "held", "abs"}]
        assert len(plain) >= 8
        output = agree(plain, tmp_path)
        assert output.count("worst error 0,") == output.count("worst error") >= len(plain)

    def test_of_every_membership_function_are(self, tmp_path):
        agree([prepare(degrees(), "")], tmp_path)

    def test_of_every_norm_and_hedge_are(self, tmp_path):
        norms = [*(f"and {n}" for n in CONJUNCTIONS), *(f"or {n}" for n in DISJUNCTIONS)]
        units = [two("norms", f"{norm}\ndefuzzifier centroid(resolution=11)") for norm in norms]
        units += [
            two("hedged", "defuzzifier centroid(resolution=11)", f"x is {h} a", f"y is {h} b or x is b") for h in HEDGES
        ]
        agree(units, tmp_path)

    def test_of_every_way_to_defuzzify_are(self, tmp_path):
        kinds = ["centroid", "bisector", *MAXIMA]
        settings = [f"defuzzifier {kind}" for kind in kinds]
        settings += [f"defuzzifier {kind}(resolution=11)" for kind in kinds]
        settings += [f"implication product\naggregation sum\ndefuzzifier {kind}" for kind in kinds[:2]]
        agree([two("sets", own) for own in settings], tmp_path)

    def test_of_adaptive_integrals_are(self, tmp_path):
        pairs = [("min", "max", "centroid"), ("min", "max", "bisector"), ("product", "sum", "centroid")]
        pairs += [("nilpotent_minimum", "nilpotent_maximum", "bisector")]
        settings = [f"implication {i}\naggregation {a}\ndefuzzifier {kind}" for i, a, kind in pairs]
        texts = [TWO.format(name="c", settings=own, first="x is a", second="x is b") for own in settings]
        texts = [text.replace("triangle(-0.2, 0.1, 0.6)", "gaussian(0.1, 0.2)") for text in texts]
        texts.append(GAP)
        units = [prepare(loads(text), text) for text in texts]
        assert all(any(isinstance(s, Quadrature) for s in u.program.body) for u in units)
        agree(units, tmp_path)

    @pytest.mark.parametrize("algorithm", ["rules", "interpolation", "active"])
    def test_of_every_algorithm_are(self, unit_of, tmp_path, algorithm):
        agree([unit_of("active" if algorithm == "active" else "ais_reaction", algorithm=algorithm)], tmp_path)

    def test_of_a_table_whose_points_are_searched_are(self, unit_of, tmp_path):
        unit = unit_of("tipper", table=33)
        assert "find(T0, " in written(unit)
        agree([unit], tmp_path)

    def test_of_every_function_of_the_language_are(self, tmp_path):
        calls = {name: f"{name}({', '.join(['x', 'y'][:least])})" for name, (least, _) in FUNCTIONS.items()}
        calls |= {"min": "min(x, y, 0.25)", "max": "max(x, y, 0.25)", "power": "x ^ y", "tiny": "abs(x) ^ inf"}
        lines = ["system functions", "defuzzifier weighted_average", "input x in [-2, 2] extrapolate"]
        lines += ["  any = trapezoid(-inf, 0, 1, inf)", "input y in [-3, 3] extrapolate"]
        for k, call in enumerate(calls.values()):
            lines += [f"output u{k} in [-20, 20] else 0", f"  f = function({call})"]
        lines += [f"if x is any then {', '.join(f'u{k} is f' for k in range(len(calls)))}"]
        text = "\n".join(lines) + "\n"
        agree([prepare(loads(text), text)], tmp_path)

    def test_that_are_held_stay_where_an_output_has_no_value(self, tmp_path):
        text = (
            "system roots\ndefuzzifier weighted_average\ninput x in [-2, 2]\n  low = triangle(-inf, -2, -1)\n"
            "  high = triangle(-0.5, 2, inf)\noutput u in [-9, 9] else hold(3)\n"
            "if x is low then u is function(sqrt(x + 1.5))\nif x is high then u is function(x)\n"
        )
        agree([prepare(loads(text), text)], tmp_path)

    def test_of_rates_with_tables_of_their_own_are(self, tmp_path):
        unit = prepare(loads(ADAPTIVE), ADAPTIVE)
        assert unit.rates.tables
        agree([unit], tmp_path)

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
        found = answer(prepare(loads(text), text), tmp_path, script)
        assert found == ["1", "1", "Infinity", "NaN", "Infinity", "0"]


class TestModule:
    def test_tells_names_units_and_ranges(self, unit_of, tmp_path):
        script = "import * as m from './m.mjs';console.log(JSON.stringify([m.inputs, m.outputs, Object.keys(m)]));"
        inputs, outputs, names = answer(unit_of("tipper"), tmp_path, script)
        assert [i["name"] for i in inputs] == ["service", "food"]
        assert [(i["lower"], i["upper"]) for i in inputs] == [(0.0, 10.0)] * 2
        assert [o["name"] for o in outputs] == ["tip"]
        assert set(inputs[0]) == {"name", "label", "unit", "lower", "upper", "extrapolate"}
        assert sorted(names) == ["inputs", "outputs", "tipper"]

    def test_returns_an_array_for_several_outputs(self, unit_of, tmp_path):
        script = "import { chained } from './m.mjs';console.log(JSON.stringify(chained(NaN, 1).map(String)));"
        assert answer(unit_of("chained"), tmp_path, script) == ["NaN", "NaN"]

    @pytest.mark.parametrize(
        ("call", "message"),
        [
            ("f('1', 0)", "TypeError: a number is expected for 'sigma', not string"),
            ("f(1)", "TypeError: a number is expected for 'dsigma', not undefined"),
        ],
    )
    def test_refuses_what_is_no_number(self, unit_of, tmp_path, call, message):
        done = run(unit_of("ais_reaction"), tmp_path, f"import {{ ais_reaction as f }} from './m.mjs';{call};")
        assert done.returncode == 1
        assert message in done.stderr

    def test_throws_where_no_rule_fires(self, unit_of, tmp_path):
        script = (
            "import { refusing, NoRuleFiresError } from './m.mjs';"
            "try { refusing(5, 0.9); } catch (e) {"
            " console.log(JSON.stringify([e instanceof NoRuleFiresError, e.output, e.name + ': ' + e.message])); }"
        )
        message = "NoRuleFiresError: no rule fires for output 'u'"
        assert answer(unit_of("refusing"), tmp_path, script) == [True, "u", message]

    def test_leaves_the_state_to_its_caller(self, unit_of, tmp_path):
        script = (
            "import { holding, holding_init } from './m.mjs';const one = holding_init(), other = holding_init();"
            "const found = [holding(5, 0.9, one), holding(0, -1, one), holding(5, 0.9, one), holding(5, 0.9, other)];"
            "console.log(JSON.stringify([found, one, other]));"
        )
        assert answer(unit_of("holding"), tmp_path, script) == [[3, -4, -4, 3], {"held_u": -4}, {"held_u": 3}]

    def test_adapts_by_a_step_and_not_beyond_the_range(self, unit_of, tmp_path):
        script = (
            "import * as m from './m.mjs';const state = m.adaptive_init();"
            "for (let k = 0; k < 1000; ++k) m.adaptive_adapt(state, 1, 0.5, 0.1);"
            "console.log(JSON.stringify([m.adaptive_init(), state, m.adaptive_rates(NaN, 0, state).map(String)]));"
        )
        first, last, rates = answer(unit_of("adaptive"), tmp_path, script)
        assert first == {"consequent": [-2, 0, 3]}
        assert last["consequent"][0] == -3
        assert rates == ["NaN"] * 3

    @pytest.mark.parametrize(
        "name", ["_then", "await", "inputs", "find", "NaN", "x_init", "v1", "T0", "state", "compare"]
    )
    def test_may_have_any_names(self, name, tmp_path):
        text = (
            f"system {name}\ndefuzzifier weighted_average\ninput {name} in [0, 1]\n  terms low up\n"
            f"output {name}2 in [0, 1] else hold\n  p = constant(0)\n  q = constant(1)\n"
            f"if {name} is low then {name}2 is p\nif {name} is up then {name}2 is q\n"
        )
        agree([prepare(loads(text), text)], tmp_path)

    def test_is_no_promise(self, tmp_path):
        text = "system _then\ndefuzzifier weighted_average\ninput x in [0, 1]\n  terms low up\noutput u in [0, 1]\n"
        text += "  p = constant(0)\nif x is low or x is up then u is p\n"
        script = "const m = await import('./m.mjs');console.log(JSON.stringify(Object.keys(m)));"
        assert "then_fz" in answer(prepare(loads(text), text), tmp_path, script)

    def test_names_no_function_by_a_word_that_means_something(self, tmp_path):
        declared = "".join(f"export function {word}_fz() {{}}\n" for word in sorted(JAVASCRIPT_FUNCTION_RESERVED))
        (tmp_path / "names.mjs").write_text(declared, encoding="utf-8")
        assert subprocess.run(["node", "names.mjs"], cwd=tmp_path, check=False).returncode == 0


class TestSelfTest:
    def test_fails_where_a_number_is_another(self, unit_of, tmp_path):
        files = dict(generate(unit_of("tipper"), "javascript").files)
        files["tipper.mjs"] = files["tipper.mjs"].replace("return v", "return 1.0000001 * v")
        done = run_selftests([files], tmp_path)
        assert done.code == 1
        assert re.search(r"tipper: tip: worst error \S+, allowed 3e-11", done.output)

    def test_fails_where_another_output_refuses(self, unit_of, tmp_path):
        files = dict(generate(unit_of("refusing"), "javascript").files)
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
    def unit(self):
        text = (
            f'system t "{HOSTILE}"\nsource "{HOSTILE}"\ndefuzzifier weighted_average\ninput x "{HOSTILE}" in [0, 1] '
            f'unit "{HOSTILE}"\n  terms a b\noutput u "{HOSTILE}" in [0, 1] unit "{HOSTILE}"\n  p = constant(0)\n'
            "  q = constant(1)\nif x is a then u is p\nif x is b then u is q\n"
        )
        return prepare(loads(text), text)

    def test_come_back_as_they_are(self, unit, tmp_path):
        script = "import { t, inputs, outputs } from './m.mjs';console.log(JSON.stringify([t(1), inputs, outputs]));"
        value, inputs, outputs = answer(unit, tmp_path, script)
        assert value == 1
        assert [inputs[0][key] for key in ("label", "unit")] == [HOSTILE] * 2
        assert [outputs[0][key] for key in ("label", "unit")] == [HOSTILE] * 2

    def test_do_not_end_the_script_of_a_page(self, unit):
        for text in generate(unit, "javascript").files.values():
            page = Scripts()
            page.feed(f"<script type=module>{text}</script>")
            assert page.tags == ["script"]
            assert "".join(page.scripts) == text
            assert "<!--" not in text
            assert "\u2028" not in text
