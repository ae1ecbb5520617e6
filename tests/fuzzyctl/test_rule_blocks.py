"""Rule blocks through the whole package: numbers by hand, every backend, commands, comparison, documents, codegen."""

import json
import math

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import DiagnosticError, dumps, loads
from fuzzyctl.analysis.bounds import output_bounds
from fuzzyctl.analysis.check import check_source
from fuzzyctl.analysis.coverage.box_search import Hole
from fuzzyctl.analysis.coverage.coverage import uncovered
from fuzzyctl.analysis.verdicts import Refuted, Undecided
from fuzzyctl.building import build
from fuzzyctl.comparison.changes import changes
from fuzzyctl.convert.markdown import page
from fuzzyctl.convert.python_module import module_text
from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.explain.trace import trace
from fuzzyctl.kernels.algorithms.select import algorithm_of
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.loading.load import examine
from fuzzyctl.model.rule import RuleBlock
from fuzzyctl.model.system import FuzzySystem
from tests.commands import runner
from tests.own_fields import names_of

run = runner()

HEAD = """
system s
defuzzifier {defuzzifier}
input e in [0, 1]
  off = triangle(-inf, 0, 1)
  on = triangle(0, 1, inf)
input d in [0, 1]
  off = triangle(-inf, 0, 1)
  on = triangle(0, 1, inf)
output u in [0, 10] else nan
  a = {a}
  b = {b}
"""


def averages(rules, defuzzifier="weighted_average"):
    return HEAD.format(defuzzifier=defuzzifier, a="constant(2)", b="constant(6)") + rules


def sets(rules, defuzzifier="centroid"):
    return HEAD.format(defuzzifier=defuzzifier, a="triangle(0, 2, 4)", b="triangle(4, 6, 8)") + rules


BOTH = "if e is on and d is on then u is a\n"
EITHER = "if e is on or d is on then u is b\n"


def test_each_block_joins_by_its_own_norms():
    text = averages(f"{BOTH}rules p and product\n{EITHER}{BOTH}rules q or bounded_sum\n{EITHER}{BOTH}")
    e, d = 0.6, 0.5
    low = min(e, d) + e * d + min(e, d)
    high = max(e, d) + min(1.0, e + d)
    assert loads(text)(e=e, d=d) == pytest.approx((2 * low + 6 * high) / (low + high), rel=1e-14)


@pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
@pytest.mark.parametrize(
    ("activation", "kept"),
    [
        ("highest(count=1)", "0.6 b"),
        ("lowest(count=1)", "0.5 a"),
        ("first(count=1)", "0.6 b"),
        ("last(count=1)", "0.5 a"),
    ],
)
def test_activation_methods_choose_within_each_block(backend, activation, kept):
    # The rules of no block and those of q all act; of p one does.
    strength, term = kept.split()
    text = averages(
        f"if d is on then u is a\nrules p activation {activation}\n{EITHER}{BOTH}rules q\nif e is on then u is b\n"
    )
    weights = {"a": 0.5, "b": 0.6}
    weights[term] += float(strength)
    expected = (2 * weights["a"] + 6 * weights["b"]) / sum(weights.values())
    kernel = fuzzyctl.compile(loads(text), backend=backend)
    assert kernel(0.6, 0.5) == pytest.approx(expected, rel=1e-14)
    assert kernel.batch(np.array([[0.6, 0.5]])) == pytest.approx([expected], rel=1e-14)


def test_rules_of_several_blocks_are_not_compared_with_each_other():
    one = "rules p activation highest(count=1)\nif e is on then u is a\nif d is on then u is b\n"
    two = one.replace("if d", "rules q activation highest(count=1)\nif d")
    assert loads(averages(one))(e=0.6, d=0.5) == 2.0
    assert loads(averages(two))(e=0.6, d=0.5) == pytest.approx((2 * 0.6 + 6 * 0.5) / 1.1)


@pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
def test_implications_of_blocks_are_those_of_the_sets_that_they_conclude(backend):
    text = sets(
        "rules cut implication min\nif e is on then u is a\nrules scale implication product\nif d is on then u is b\n"
    )
    h, k = 0.6, 0.5
    # A triangle of width 4 that is cut at h has the area 4 (h - h²/2), one that is scaled by k the area 2 k.
    cut, scaled = 4 * (h - h * h / 2), 2 * k
    kernel = fuzzyctl.compile(loads(text), backend=backend)
    assert kernel(h, k) == pytest.approx((2 * cut + 6 * scaled) / (cut + scaled), rel=1e-11)


@pytest.mark.parametrize(("kind", "expected"), [("som", 1.0), ("mom", 2.0), ("lom", 3.0)])
def test_maxima_of_sets_that_are_cut_and_scaled_have_a_closed_form(kind, expected):
    rules = "rules cut\nif e is on then u is a\nrules scale implication product\nif d is on then u is b\n"
    system = loads(sets(rules, kind))
    assert system(e=0.5, d=0.25) == pytest.approx(expected)
    assert system(e=0.25, d=0.5) == pytest.approx(6.0)


def test_an_implication_of_a_block_counts_more_than_that_of_the_output():
    base = sets("if e is on then u is a\n").replace("else nan", "else nan implication product")
    block = base.replace("if e", "rules cut implication min\nif e")
    assert plan(loads(base)).outputs[0].implication == "product"
    assert plan(loads(block)).outputs[0].implication == "min"


def test_blocks_that_say_nothing_compute_by_the_same_program():
    plain = averages(BOTH + EITHER)
    split = averages(f"rules p\n{BOTH}rules q and min activation general\n{EITHER}")
    assert plan(loads(plain)) == plan(loads(split))
    assert algorithm_of(plan(loads(plain))).point == algorithm_of(plan(loads(split))).point


def test_a_system_interpolates_only_if_every_block_joins_by_products():
    products = averages("rules p and product\n" + BOTH + "if e is off then u is b\nif d is off then u is b\n")
    mixed = products + "rules q and min\n" + BOTH
    chosen = products + "rules q and product activation highest(count=1)\n" + BOTH
    assert [algorithm_of(plan(loads(t))).name for t in (products, mixed, chosen)] == ["interpolation", "rules", "rules"]


CHAINED = """
output v in [0, 1] else 0
  no = triangle(-inf, 0, 1)
  yes = triangle(0, 1, inf)
if d is on then v is yes
if d is off then v is no
rules late activation highest(count=1)
if v is yes and e is on then u is a
if v is no then u is b
"""


def test_a_block_may_compare_rules_that_read_what_others_set():
    system = loads(averages(CHAINED))
    kernel = fuzzyctl.compile(system, backend="python")
    assert [kernel(e, d)[0] for e, d in ((1.0, 1.0), (1.0, 0.0), (0.1, 0.6), (0.9, 0.6))] == [2.0, 6.0, 6.0, 2.0]
    own = CHAINED.replace("then u is b", "then v is yes")
    with pytest.raises(DiagnosticError, match="compares the rules of a block at once"):
        loads(averages(own + "if e is off then u is b\n"))


def test_outputs_that_compared_rules_wait_for_are_no_circle_unless_they_are():
    circle = CHAINED.replace("if d is on then v is yes", "if u is a and d is on then v is yes")
    with pytest.raises(DiagnosticError, match="FZ217"):
        loads(sets(circle))


class TestProofs:
    def test_a_block_that_may_leave_out_rules_proves_nothing_of_coverage(self):
        rules = "rules p activation highest(count=1)\nif e is on then u is a\nif e is off then u is b\n"
        other = averages(rules).replace("output u", "output w in [0, 1] else nan\n  c = constant(1)\noutput u")
        assert uncovered(loads(averages(rules)))["u"] is None
        verdicts = uncovered(loads(other + "if d is on then w is c\nif d is off then w is c\n"))
        assert str(verdicts["w"].reason) == "activation 'highest' may leave out the rules that fire for it"

    def test_rules_of_other_blocks_do_not_take_the_place_of_those_that_are_chosen(self):
        rules = "rules p activation highest(count=1)\nif e is on then u is a\nif e is off then u is b\n"
        text = averages(rules + "rules q\nif d is on then w is c\n")
        text = text.replace("output u", "output w in [0, 1] else nan\n  c = constant(1)\noutput u")
        verdicts = uncovered(loads(text))
        assert verdicts["u"] is None
        assert isinstance(verdicts["w"], Hole)

    def test_bounds_are_those_of_all_blocks(self):
        text = averages(f"{EITHER}rules p and product activation threshold(>= 0.3)\n{BOTH}")
        bound = output_bounds(loads(text))["u"]
        assert bound.lo <= 2.0
        kernel = fuzzyctl.compile(loads(text), backend="numpy")
        values = kernel.batch(np.random.default_rng(1).random((500, 2)))
        assert np.all((values >= bound.lo) & (values <= bound.hi))

    def test_a_rule_covers_another_only_where_both_join_alike(self):
        few = "if e is on then u is b\nif e is on and d is on then u is a\n"
        many = "if e is on and d is on and d is not off then u is a\n"
        for line, codes in (("rules p\n", ["FZ403"]), ("rules p and min\n", ["FZ403"]), ("rules p and product\n", [])):
            text = sets(few + line + many)
            found = [d.code for d in check_source(SourceText("t", text))[1] if d.code == "FZ403"]
            assert found == codes, line

    def test_a_drastic_norm_of_one_block_makes_jumps(self):
        smooth = averages("rules p and product\nif e is on and d is on then u is a\nif e is off then u is b\n")
        jump = smooth + "rules q and drastic_product\nif e is on and d is on then u is b\nif d is off then u is b\n"
        text = jump + "require lipschitz(u, e) <= 1000\n"
        (verdict,) = fuzzyctl.prove(loads(text))
        assert isinstance(verdict, Undecided | Refuted)


class TestPython:
    def test_blocks_are_built_with_the_checks_of_files(self):
        base = loads(averages(BOTH))
        block = build.rule_block("late", [EITHER.strip()], disjunction="bounded_sum", activation="highest(count=1)")
        made = build.system("s", [*base.inputs, *base.outputs], [BOTH.strip(), block], defuzzifier="weighted_average")
        assert made == loads(averages(BOTH + "rules late or bounded_sum activation highest(count=1)\n" + EITHER))
        with pytest.raises(ArgumentError, match="come before all rule blocks"):
            build.system("s", [*base.inputs, *base.outputs], [block, BOTH.strip()])
        with pytest.raises(ArgumentError, match="needs a rule"):
            build.rule_block("late", [])
        with pytest.raises(DiagnosticError, match="there is a rule block 'late' already"):
            build.system("s", [*base.inputs, *base.outputs], [block, block])
        odd = build.rule_block("late", [EITHER.strip()], disjunction="bounded")
        with pytest.raises(DiagnosticError, match="'or' knows no 'bounded'"):
            build.system("s", [*base.inputs, *base.outputs], [odd])
        odd = build.rule_block("a b", [EITHER.strip()])
        with pytest.raises(DiagnosticError, match="cannot be the name of a rule block"):
            build.system("s", [*base.inputs, *base.outputs], [odd])

    def test_rules_of_no_block_stand_before_all_blocks(self):
        base = loads(averages(BOTH))
        fields = {k: getattr(base, k) for k in names_of(FuzzySystem)}
        block = RuleBlock(name="p", rules=base.blocks)
        with pytest.raises(ValueError, match="come before all rule blocks"):
            FuzzySystem(**fields | {"blocks": (block, *base.blocks)})

    def test_params_in_thresholds_of_blocks_are_used_and_followed(self):
        text = averages("param k = 0.2\nrules p activation threshold(>= (k))\n" + EITHER)
        system = loads(text)
        assert "FZ216" not in [d.code for d in examine(SourceText("t", text))[1]]
        assert system(e=0.3, d=0.1) == 6.0
        assert math.isnan(system.with_params(k=0.5)(e=0.3, d=0.1))

    def test_a_trace_names_the_block_of_a_rule(self):
        found = trace(loads(averages(f"{BOTH}rules late\n{EITHER}")), {"e": 0.6, "d": 0.5})
        assert {r.text.split(" then ")[0]: r.block for r in found.rules} == {
            "if e is on and d is on": "",
            "if e is on or d is on": "late",
        }

    def test_a_python_module_builds_the_same_blocks(self):
        system = loads(averages(f"{BOTH}rules late or bounded_sum activation first(count=1)\n{EITHER}{BOTH}"))
        space = {}
        exec(compile(module_text(system), "built", "exec"), space)
        assert dumps(space["system"]) == dumps(system)

    def test_a_page_has_a_heading_for_each_block(self):
        text = page(loads(averages(f"{BOTH}rules late or bounded_sum\n{EITHER}")), {})
        assert "### Rule block late\n\nIt has its own `or bounded_sum`.\n\n1. `if e is on or d is on" in text


class TestChanges:
    def test_what_blocks_say_and_where_rules_stand_is_compared(self):
        first = loads(averages(f"{BOTH}rules late or bounded_sum\n{EITHER}"))
        second = loads(averages(f"rules late or max\n{BOTH}{EITHER}"))
        found = [(c.kind, c.what, c.name, c.before, c.after) for c in changes(first, second)]
        assert found == [
            ("changed", "rule block", "late", "rules late or bounded_sum", "rules late or max"),
            ("changed", "block of rule", "e is on and d is on", "none", "late"),
        ]
        assert changes(first, loads(dumps(first))) == ()

    def test_a_file_explains_its_difference_by_its_rules(self, tmp_path):
        one, other = tmp_path / "a.fz", tmp_path / "b.fz"
        one.write_text(averages(f"{BOTH}{EITHER}"), encoding="utf-8")
        other.write_text(averages(f"{BOTH}rules late or bounded_sum\n{EITHER}"), encoding="utf-8")
        result = run("compare", one, other)
        assert "rules" in result.output, result.output


def test_commands_show_blocks(tmp_path):
    file = tmp_path / "s.fz"
    rules = f"if e is off then u is b\nrules late or bounded_sum implication product\n{EITHER}{BOTH}"
    file.write_text(sets(rules), encoding="utf-8")
    shown = run("show", file).output
    assert "\n  rules late or bounded_sum implication product\n  if e is on or d is on then u is b\n" in shown
    assert "implication  min and product" in shown
    data = json.loads(run("show", file, "--format", "json").output)
    assert data["rules"][1]["method"] == {"or": "bounded_sum", "implication": "product"}
    assert [set(r) for r in data["rules"][1]["rules"]] == [{"rule"}, {"rule"}]
    why = run("why", file, "e=0.6", "d=0.5").output
    assert "if e is on or d is on then u is b   (rules late)" in why


def test_generated_code_knows_blocks(tmp_path):
    file = tmp_path / "s.fz"
    rules = f"{EITHER}rules late and product activation highest(count=1)\n{BOTH}{EITHER}"
    file.write_text(averages(rules), encoding="utf-8")
    for target in ("c", "st", "python"):
        result = run("codegen", file, "--target", target, "-o", tmp_path / target)
        assert result.exit_code == 0, result.output
    (module,) = (tmp_path / "python").glob("*.py")
    space = {}
    exec(compile(module.read_text(encoding="utf-8"), "generated", "exec"), space)
    (function,) = (f for name, f in space.items() if name == "s")
    assert function(0.6, 0.5) == loads(averages(rules))(e=0.6, d=0.5)


def test_a_profile_of_a_tool_without_activation_methods_does_not_know_those_of_blocks():
    system = loads(averages(f"{EITHER}rules late activation highest(count=1)\n{BOTH}"))
    assert fuzzyctl.as_profile(system, "pyfuzzylite").rule_blocks == system.rule_blocks
    with pytest.raises(DiagnosticError, match="has no activation 'highest'"):
        fuzzyctl.as_profile(system, "matlab")
