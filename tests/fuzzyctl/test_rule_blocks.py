"""Rule blocks through the whole package: numbers by hand, every backend, commands, documents, generated code."""

import dataclasses
import json
import math
import runpy

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import ArgumentError, DiagnosticError, build, dumps, loads
from fuzzyctl.testing import check_text, run_command
from tests import sizes

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


class TestNumbers:
    def test_each_block_joins_by_its_own_norms(self):
        text = averages(f"{BOTH}rules p and product\n{EITHER}{BOTH}rules q or bounded_sum\n{EITHER}{BOTH}")
        e, d = 0.6, 0.5
        low = min(e, d) + e * d + min(e, d)
        high = max(e, d) + min(1.0, e + d)
        assert loads(text)(e=e, d=d) == pytest.approx((2 * low + 6 * high) / (low + high), rel=1e-14)

    @pytest.mark.parametrize("backend", sizes.BACKENDS)
    @pytest.mark.parametrize(
        ("activation", "kept"),
        [
            ("highest(count=1)", "0.6 b"),
            ("lowest(count=1)", "0.5 a"),
            ("first(count=1)", "0.6 b"),
            ("last(count=1)", "0.5 a"),
        ],
    )
    def test_activation_methods_choose_within_each_block(self, backend, activation, kept):
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

    def test_rules_of_several_blocks_are_not_compared_with_each_other(self):
        one = "rules p activation highest(count=1)\nif e is on then u is a\nif d is on then u is b\n"
        two = one.replace("if d", "rules q activation highest(count=1)\nif d")
        assert loads(averages(one))(e=0.6, d=0.5) == 2.0
        assert loads(averages(two))(e=0.6, d=0.5) == pytest.approx((2 * 0.6 + 6 * 0.5) / 1.1)

    @pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
    def test_implications_of_blocks_are_those_of_the_sets_that_they_conclude(self, backend):
        blocks = "rules cut implication min\nif e is on then u is a\n"
        blocks += "rules scale implication product\nif d is on then u is b\n"
        h, k = 0.6, 0.5
        # A triangle of width 4 that is cut at h has the area 4 (h - h²/2), one that is scaled by k the area 2 k.
        cut, scaled = 4 * (h - h * h / 2), 2 * k
        kernel = fuzzyctl.compile(loads(sets(blocks)), backend=backend)
        assert kernel(h, k) == pytest.approx((2 * cut + 6 * scaled) / (cut + scaled), rel=1e-11)
        output = sets(blocks).replace("else nan", "else nan implication product").replace("implication min", "")
        assert loads(output)(e=h, d=k) == pytest.approx((2 * 2 * h + 6 * scaled) / (2 * h + scaled), rel=1e-11)

    @pytest.mark.parametrize(("kind", "expected"), [("som", 1.0), ("mom", 2.0), ("lom", 3.0)])
    def test_maxima_of_sets_that_are_cut_and_scaled_have_a_closed_form(self, kind, expected):
        rules = "rules cut\nif e is on then u is a\nrules scale implication product\nif d is on then u is b\n"
        system = loads(sets(rules, kind))
        assert system(e=0.5, d=0.25) == pytest.approx(expected)
        assert system(e=0.25, d=0.5) == pytest.approx(6.0)

    def test_a_system_interpolates_only_if_every_block_joins_by_products(self):
        products = averages("rules p and product\n" + BOTH + "if e is off then u is b\nif d is off then u is b\n")
        mixed = products + "rules q and min\n" + BOTH
        chosen = products + "rules q and product activation highest(count=1)\n" + BOTH
        names = [fuzzyctl.compile(loads(t), "python").algorithm.name for t in (products, mixed, chosen)]
        assert names == ["interpolation", "rules", "rules"]

    def test_blocks_without_settings_compute_by_the_same_program(self):
        split = averages(f"rules p\n{BOTH}rules q and min activation general\n{EITHER}")
        sources = [fuzzyctl.compile(loads(t), "python").source for t in (averages(BOTH + EITHER), split)]
        assert sources[0] == sources[1]

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

    def test_a_block_may_compare_rules_that_read_what_others_set(self):
        kernel = fuzzyctl.compile(loads(averages(self.CHAINED)), backend="python")
        assert [kernel(e, d)[0] for e, d in ((1.0, 1.0), (1.0, 0.0), (0.1, 0.6), (0.9, 0.6))] == [2.0, 6.0, 6.0, 2.0]
        own = self.CHAINED.replace("then u is b", "then v is yes")
        with pytest.raises(DiagnosticError, match="compares the rules of a block at once"):
            loads(averages(own + "if e is off then u is b\n"))
        with pytest.raises(DiagnosticError, match="FZ217"):
            loads(sets(self.CHAINED.replace("if d is on then v is yes", "if u is a and d is on then v is yes")))


class TestProofs:
    OTHER = "output w in [0, 1]\n  c = constant(1)\noutput u"
    RULES = "rules p activation highest(count=1)\nif e is on then u is a\nif e is off then u is b\n"

    def coverage(self, rules):
        text = averages(rules).replace(" else nan", "").replace("output u", self.OTHER)
        return [(d.message.partition(" output")[0], d.span.text) for d in check_text(text)[1] if d.code == "FZ401"]

    def test_a_block_that_may_leave_out_rules_proves_no_coverage_of_the_outputs_of_others(self):
        covered = "if d is on then w is c\nif d is off then w is c\n"
        assert self.coverage(self.RULES + "rules q\n" + covered) == []
        assert self.coverage(self.RULES + covered) == [("no rule moves", "w"), ("no rule moves", "u")]
        assert self.coverage(self.RULES + "rules q\nif d is on then w is c\n") == [("no rule fires for", "w")]

    def test_bounds_are_those_of_all_blocks(self):
        system = loads(averages(f"{EITHER}rules p and product activation threshold(>= 0.3)\n{BOTH}"))
        bound = fuzzyctl.output_bounds(system)["u"]
        values = fuzzyctl.compile(system, backend="numpy").batch(np.random.default_rng(1).random((500, 2)))
        assert bound.lo <= 2.0
        assert np.all((values >= bound.lo) & (values <= bound.hi))

    def test_a_rule_covers_another_only_where_both_join_alike(self):
        few = "if e is on then u is b\nif e is on and d is on then u is a\n"
        many = "if e is on and d is on and d is not off then u is a\n"
        for line, codes in (("rules p\n", ["FZ403"]), ("rules p and min\n", ["FZ403"]), ("rules p and product\n", [])):
            found = [d.code for d in check_text(sets(few + line + many))[1] if d.code == "FZ403"]
            assert found == codes, line

    def test_a_drastic_norm_of_one_block_makes_jumps(self):
        text = averages("rules p and product\nif e is on and d is on then u is a\nif e is off then u is b\n")
        text += "rules q and drastic_product\nif e is on and d is on then u is b\nif d is off then u is b\n"
        (verdict,) = fuzzyctl.prove(loads(text + "require lipschitz(u, e) <= 1000\n"))
        assert not isinstance(verdict, fuzzyctl.Proved)


class TestPython:
    def test_blocks_are_built_with_the_checks_of_files(self):
        base = loads(averages(BOTH))

        def made(*rules):
            return build.system("s", [*base.inputs, *base.outputs], rules, defuzzifier="weighted_average")

        def block(name="late", **settings):
            return build.rule_block(name, [EITHER.strip()], **settings)

        late = block(disjunction="bounded_sum", activation="highest(count=1)")
        assert made(BOTH.strip(), late) == loads(
            averages(BOTH + "rules late or bounded_sum activation highest(count=1)\n" + EITHER)
        )
        for error, message, call in (
            (ArgumentError, "come before all rule blocks", lambda: made(late, BOTH.strip())),
            (ArgumentError, "needs a rule", lambda: build.rule_block("late", [])),
            (DiagnosticError, "there is a rule block 'late' already", lambda: made(late, late)),
            (DiagnosticError, "'or' knows no 'bounded'", lambda: made(block(disjunction="bounded"))),
            (DiagnosticError, "cannot be the name of a rule block", lambda: made(block("a b"))),
            (
                ValueError,
                "come before all rule blocks",
                lambda: dataclasses.replace(base, blocks=(late, *base.blocks)),
            ),
        ):
            with pytest.raises(error, match=message):
                call()

    def test_params_in_thresholds_of_blocks_are_used_and_followed(self):
        text = averages("param k = 0.2\nrules p activation threshold(>= (k))\n" + EITHER)
        system = loads(text)
        assert "FZ216" not in [d.code for d in check_text(text)[1]]
        assert system(e=0.3, d=0.1) == 6.0
        assert math.isnan(system.with_params(k=0.5)(e=0.3, d=0.1))

    def test_a_trace_names_the_block_of_a_rule(self):
        found = fuzzyctl.why(loads(averages(f"{BOTH}rules late\n{EITHER}")), e=0.6, d=0.5)
        assert [r.block for r in sorted(found.rules, key=lambda r: r.block)] == ["", "late"]

    def test_a_profile_of_a_tool_without_activation_methods_does_not_know_those_of_blocks(self):
        system = loads(averages(f"{EITHER}rules late activation highest(count=1)\n{BOTH}"))
        assert fuzzyctl.as_profile(system, "pyfuzzylite").rule_blocks == system.rule_blocks
        with pytest.raises(DiagnosticError, match="has no activation 'highest'"):
            fuzzyctl.as_profile(system, "matlab")


class TestCommands:
    @pytest.fixture
    def run(self, tmp_path):
        """Run a command in a folder with files of some rules."""

        def run(*words, code=0, **files):
            for name, text in files.items():
                (tmp_path / f"{name}.fz").write_text(text, encoding="utf-8")
            result = run_command(*words, folder=tmp_path)
            assert result.exit_code == code, result
            return result.output

        return run

    def test_show_blocks(self, run):
        rules = f"if e is off then u is b\nrules late or bounded_sum implication product\n{EITHER}{BOTH}"
        shown = run("show", "s.fz", s=sets(rules))
        assert "\n  rules late or bounded_sum implication product\n  if e is on or d is on then u is b\n" in shown
        assert "implication  min and product" in shown
        data = json.loads(run("show", "s.fz", "--format", "json"))
        assert data["rules"][1]["method"] == {"or": "bounded_sum", "implication": "product"}
        assert [set(r) for r in data["rules"][1]["rules"]] == [{"rule"}, {"rule"}]
        assert "if e is on or d is on then u is b   (rules late)" in run("why", "s.fz", "e=0.6", "d=0.5")

    def test_compare_settings_and_places_of_blocks(self, run):
        first = averages(f"{BOTH}rules late or bounded_sum\n{EITHER}")
        second = averages(f"rules late or max\n{BOTH}{EITHER}")
        found = run("compare", "--changes", "a.fz", "b.fz", code=1, a=first, b=second)
        assert "~ rule block late: rules late or bounded_sum → rules late or max " in found
        assert "~ block of rule e is on and d is on: none → late " in found
        assert "nothing was changed" in run("compare", "--changes", "a.fz", "b.fz", b=dumps(loads(first)))

    def test_convert_blocks(self, run, tmp_path):
        text = averages(f"{BOTH}rules late or bounded_sum activation first(count=1)\n{EITHER}{BOTH}")
        run("convert", "s.fz", "s.py", s=text)
        assert dumps(runpy.run_path(str(tmp_path / "s.py"))["system"]) == dumps(loads(text))
        run("convert", "s.fz", "s.md", s=averages(f"{BOTH}rules late or bounded_sum\n{EITHER}"))
        page = (tmp_path / "s.md").read_text(encoding="utf-8")
        assert "### Rule block late\n\nIt has its own `or bounded_sum`.\n\n1. `if e is on or d is on" in page

    def test_generate_code_of_blocks(self, run, tmp_path):
        text = averages(f"{EITHER}rules late and product activation highest(count=1)\n{BOTH}{EITHER}")
        for target in ("c", "st", "python"):
            run("codegen", "s.fz", "--target", target, "-o", target, s=text)
        function = runpy.run_path(str(tmp_path / "python" / "s.py"))["s"]
        assert function(0.6, 0.5) == loads(text)(e=0.6, d=0.5)
