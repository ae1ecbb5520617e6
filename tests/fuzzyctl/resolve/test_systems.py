"""The meaning of the lines of a system: its parts, its method and its numbers."""

import math

import pytest

import fuzzyctl
from fuzzyctl import DiagnosticError, ValueOutOfBoundsError, dumps, loads
from fuzzyctl.testing import check_text
from tests.layout import laid_out


def with_settings(changed, *lines):
    return changed(("\ninput x", "\n" + "\n".join(lines) + "\ninput x"))


class TestRules:
    def test_cells_become_rules_row_by_row(self, base):
        rules = loads(base).rules
        assert [[(p.variable, p.term) for p in r.antecedent.operands] for r in rules[:2]] == [
            [("x", "N"), ("y", "N")],
            [("x", "N"), ("y", "P")],
        ]
        assert [r.consequents[0].term for r in rules] == ["N", "Z", "N", "P", "Z", "P"]

    def test_rows_and_columns_may_stand_in_any_order(self, base, changed):
        other = changed(
            ("       N  P\n", "       P  N\n"),
            ("N |  N  Z", "N |  Z  N"),
            ("Z |  N  P", "Z |  P  N"),
            ("P |  Z  P", "P |  P  Z"),
        )
        point = {"x": 0.3, "y": 2.0}
        assert loads(other)(**point) == pytest.approx(loads(base)(**point), rel=1e-14)

    def test_a_dot_is_no_rule_and_a_weight_belongs_to_the_cell(self, changed):
        system = loads(changed(("N |  N  Z", "N |  .  Z*0.5")))
        assert len(system.rules) == 5
        assert system.number(system.rules[0].weight) == 0.5

    def test_a_table_may_set_two_outputs(self, changed):
        text = changed(("table u", "output v in [0, 1]\n  A = triangle(0, 0.5, 1)\n\ntable u, v"))
        for row in ("N  Z", "N  P", "Z  P"):
            a, b = row.split()
            text = text.replace(f"|  {row}", f"|  {a}/A  {b}/A", 1)
        assert [c.output for c in loads(text).rules[0].consequents] == ["u", "v"]

    def test_a_condition_joins_each_rule_of_a_table(self):
        system = loads(
            "system s\ndefuzzifier weighted_average\n"
            "input m in [0, 1]\n  terms slow fast\ninput x in [0, 1]\n  terms L H\n"
            "output u in [0, 10]\n  terms A=0 B=10\n"
            "with m is slow\ntable u = x\n  L H\n | A B\nwith m is fast\ntable u = x\n  L H\n | B A\n"
        )
        assert [system(m=0.0, x=1.0), system(m=1.0, x=1.0)] == [10.0, 0.0]

    def test_a_table_may_cross_lets(self):
        text = "system s\ndefuzzifier center_average\ninput e in [-1, 1]\n  terms N P\n"
        text += "let z in [-2, 2] = 2 * e\n  terms A B\noutput u in [-1, 1]\n  terms N P\n"
        assert loads(text + "table u = z x e\n    N P\n  A | N P\n  B | P P\n")(e=-1.0) == -1.0

    def test_not_binds_tighter_than_and_and_parentheses_group(self, changed):
        plain, grouped = (
            loads(changed(after=f"if {a} then u is Z weight (1 / 2)\n")).rules[-1]
            for a in ("not x is N and y is P", "x is N and (y is P or y is N)")
        )
        assert [type(p).__name__ for p in (plain.antecedent, *plain.antecedent.operands)] == ["And", "Not", "Is"]
        assert [type(p).__name__ for p in (grouped.antecedent, *grouped.antecedent.operands)] == ["And", "Is", "Or"]

    def test_a_later_rule_reads_the_crisp_value_of_an_output(self):
        system = loads(
            "system s\ndefuzzifier weighted_average\ninput x in [0, 1]\n  terms L H\n"
            "output mid in [0, 2]\n  L = triangle(-inf, 0, 2)\n  H = triangle(0, 2, inf)\n"
            "output u in [0, 10]\n  terms A=0 B=10\n"
            "if x is L then mid is L\nif x is H then mid is H\nif mid is L then u is A\nif mid is H then u is B\n"
        )
        assert system(x=0.25) == {"mid": 0.5, "u": 2.5}

    @pytest.mark.parametrize(
        "claim",
        [
            "u(-x, 10 - y) == -u within 1e-12",
            "total(u) >= 0.1 within 0.01 when x > 0",
            "not total(u) >= 1 / 2",
            "lipschitz(u, x) <= 2 * 3",
            "bounded(u, -2, 2) within 0.1 when x > 0",
            "not u < -2 and increasing(u, x)",
        ],
    )
    def test_a_guarantee_is_kept(self, changed, claim):
        assert f"require {claim}\n" in dumps(loads(changed(after=f"require {claim}\n")))


BLOCKS = """
system s
input e in [-1, 1]
  terms N P
input d in [-1, 1]
  terms N P
output u in [-1, 1] else 0
  terms N P
output v in [-1, 1] else 0
  terms N P
table v = d
  N P
  | P N
"""
FAST = "rules fast and product or bounded_sum implication product activation highest(count=1)\n"
RULE = "if e is N and d is N then u is N\n"
MIRRORED = "if e is P and d is P then u is P\n"


class TestRuleBlocks:
    def test_a_block_holds_what_stands_below_it_up_to_the_next_one(self):
        system = loads(BLOCKS + FAST + RULE + MIRRORED + "rules slow\ntable u = d\n  N P\n  | P N\n")
        fast, slow = system.rule_blocks
        assert (fast.name, fast.conjunction, fast.disjunction, fast.implication) == (
            "fast", "product", "bounded_sum", "product",
        )  # fmt: skip
        assert (fast.activation.kind, fast.activation.count) == ("highest", 1)
        assert (slow.name, slow.conjunction, slow.activation) == ("slow", None, None)
        assert [len(b.rules) for b in system.rule_blocks] == [2, 1]
        assert [m.block for m in system.rule_methods] == [-1, -1, 0, 0, 1, 1]
        assert [m.conjunction for m in system.rule_methods] == ["min"] * 2 + ["product"] * 2 + ["min"] * 2

    def test_other_statements_may_stand_between_the_rules_of_a_block(self):
        system = loads(BLOCKS + FAST + RULE + "param k = 1\nrequire u <= k\nor max\n" + MIRRORED)
        assert len(system.rule_blocks[0].rules) == 2
        assert system.method.disjunction == "max"

    def test_a_block_prints_as_it_is_written(self):
        text = dumps(loads(BLOCKS + FAST + RULE + MIRRORED))
        assert f"\n\n{FAST}\n{RULE}{MIRRORED}" in text
        assert laid_out(text) == text
        typed = "rules  fast   and product activation  highest( count = 1 )\n" + RULE
        assert laid_out(typed) == "rules fast and product activation highest(count=1)\n" + RULE

    def test_a_block_that_starts_before_several_systems_ends_at_the_first(self):
        shared = "input e in [-1, 1]\n  terms N P\noutput u in [-1, 1]\n  terms N P\nrules a and product\n"
        text = shared + "if e is N then u is N\nsystem s\nif e is P then u is P\nsystem t\nif e is P then u is P\n"
        system = loads(text, block="s")
        assert [(b.name, len(b.rules)) for b in system.rule_blocks] == [("a", 1)]
        assert [m.block for m in system.rule_methods] == [-1, 0]


class TestSettings:
    def test_those_of_the_exact_profile_are_the_defaults(self, base, changed):
        method = loads(base).method
        assert (method.conjunction, method.disjunction, method.implication, method.aggregation) == (
            "min", "max", "min", "max",
        )  # fmt: skip
        assert (method.defuzzifier.kind, method.defuzzifier.resolution) == ("centroid", None)
        assert loads(with_settings(changed, "semantics exact")) == loads(base) == loads("fz 1\n" + base)

    @pytest.mark.parametrize(
        ("line", "fields"),
        [
            ("activation general", ("general", None, None, None)),
            ("activation first(count=2, threshold=0.1)", ("first", 2, 0.1, None)),
            ("activation highest(count=1)", ("highest", 1, None, None)),
            ("activation threshold(>= 0.5)", ("threshold", None, 0.5, ">=")),
        ],
    )
    def test_activation_methods_are_read(self, changed, line, fields):
        system = loads(with_settings(changed, line).replace("[-2, 2]", "[-2, 2] else 0"))
        found = system.method.activation
        threshold = None if found.threshold is None else system.number(found.threshold)
        assert (found.kind, found.count, threshold, found.comparison) == fields
        assert loads(dumps(system)) == system

    @pytest.mark.parametrize(
        "text",
        [
            "bisector",
            "bisector(resolution=101, grid=endpoints, rule=first)",
            "centroid(resolution=9, rule=trapezoid)",
            "som(by=magnitude)",
            "mom(resolution=7, grid=left, tolerance=1e-9)",
            "som(resolution=9, rule=running, tolerance=1e-6)",
            "bisector(resolution=9, rule=between, tolerance=1e-6)",
            "inverse_tsukamoto_sum",
        ],
    )
    def test_options_of_defuzzifiers_are_read_and_written(self, changed, text):
        system = loads(with_settings(changed, f"defuzzifier {text}"))
        kind, _, options = text.rstrip(")").partition("(")
        found = system.method.defuzzifier
        assert found.kind == kind
        for option in filter(None, options.split(", ")):
            name, value = option.split("=")
            assert str(getattr(found, name)) == (value if name in ("grid", "rule", "by") else str(eval(value)))
        assert loads(dumps(system)).method.defuzzifier == found

    def test_a_profile_sets_the_knobs_and_what_is_written_overrides_it(self, changed):
        text = "semantics matlab(weight=after, least=1e-6)\ndefuzzifier centroid(resolution=201)"
        method = loads(with_settings(changed, text)).method
        assert (method.semantics.weight, method.semantics.least, method.semantics.merge) == ("after", 1e-6, "rules")
        assert (method.defuzzifier.resolution, method.defuzzifier.grid) == (201, "endpoints")
        own = loads(with_settings(changed, "semantics matlab\ndefuzzifier centroid(resolution=exact)")).method
        assert own.defuzzifier == loads(changed()).method.defuzzifier
        method = loads(with_settings(changed, "semantics fuzzylite\ndefuzzifier centroid")).method
        assert (method.semantics.profile, method.defuzzifier.resolution, method.defuzzifier.grid) == (
            "fuzzylite", 1000, "midpoint",
        )  # fmt: skip

    def test_a_profile_says_what_an_output_is_where_no_rule_fires(self, changed):
        assert loads(with_settings(changed, "semantics matlab")).outputs[0].otherwise == "midpoint"
        jfuzzylogic = loads(with_settings(changed, "semantics jfuzzylogic"))
        assert jfuzzylogic.outputs[0].otherwise.start == "nan"
        assert jfuzzylogic.method.aggregation == "sum"

    def test_an_output_may_have_its_own_method(self, changed):
        output = loads(changed(("[-2, 2]", "[-2, 2] aggregation sum defuzzifier centroid(resolution=50)"))).outputs[0]
        assert (output.aggregation, output.defuzzifier.kind, output.defuzzifier.resolution) == ("sum", "centroid", 50)

    def test_a_hedge_of_the_file_is_an_expression_over_params(self, changed):
        text = with_settings(changed, "defuzzifier center_average", "param p = 3", "hedge cubed(z) = z^p")
        system = loads(text + "if x is cubed Z then u is P\nif x is not very Z then u is N\n")
        assert system.rules[-1].antecedent.hedges == ("not", "very")
        assert "hedge cubed(z) = z^p" in dumps(system)

    def test_citations_join(self, changed):
        assert loads(with_settings(changed, 'source "a"', 'source "b"')).citation == "a; b"


def parameters(system, variable, term):
    return tuple(system.number(a) for a in variable.term(term).membership.arguments)


class TestVariables:
    def test_peaks_make_triangles_that_meet_at_each_other_with_shoulders_at_the_ends(self, changed):
        rows = [("       N  P\n", "       N  Z  P\n"), ("N |  N  Z", "N |  N  Z  Z"), ("Z |  N  P", "Z |  N  P  P")]
        system = loads(changed(("terms N@0 P@10", "terms N@0 Z@2 P@10"), *rows, ("P |  Z  P", "P |  Z  P  P")))
        y = system.input("y")
        assert [parameters(system, y, t) for t in "NZP"] == [(-math.inf, 0, 2), (0, 2, 10), (2, 10, math.inf)]

    def test_bare_names_are_spread_over_the_range_with_0_exactly_in_the_middle(self):
        system = loads(
            "system s\ninput x in [-0.4, 0.4]\n  terms A B C D E F G\n"
            "output u in [0, 1]\n  terms A=0 B=0 C=0 D=0 E=0 F=0 G=0\n"
            "defuzzifier weighted_average\ntable u = x\n  A B C D E F G\n | A B C D E F G\n"
        )
        peaks = [parameters(system, system.input("x"), t)[1] for t in "ABCDEFG"]
        assert (peaks[0], peaks[3]) == (-0.4, 0)
        assert peaks == [-p for p in reversed(peaks)]

    def test_parameters_may_be_named_and_computed_from_params(self, changed):
        text = changed(
            ("Z = triangle(-1, 0, 1)", "Z = triangle(right=k, left=-k, peak=0)"),
            ("\ninput x", "\nparam k = 2 / 2\ninput x"),
        )
        assert parameters(loads(text), loads(text).input("x"), "Z") == (-1, 0, 1)

    @pytest.mark.parametrize(
        ("clause", "value"),
        [("else 0.5", 0.5), ("else (1 / 4)", 0.25), ("else midpoint", "midpoint"), ("else nan", "nan")],
    )
    def test_an_output_says_what_it_is_where_no_rule_fires(self, changed, clause, value):
        system = loads(changed(("[-2, 2]", f"[-2, 2] {clause}")))
        found = system.outputs[0].otherwise
        assert (found if isinstance(value, str) else system.number(found)) == value

    @pytest.mark.parametrize(("function", "value"), [("linear(1, 2, 3)", 7.5), ("function(x * k)", 1.0)])
    def test_an_input_that_only_a_function_reads_needs_no_terms(self, function, value):
        system = loads(
            "system s\ndefuzzifier weighted_average\ninput x in [0, 1]\n  all = trapezoid(-1, 0, 1, 2)\n"
            f"input k in [0, 9]\noutput y in [0, 9]\n  f = {function}\nif x is all then y is f\n"
        )
        assert system(x=0.5, k=2) == value
        assert loads(dumps(system)) == system

    def test_the_range_of_a_param_holds_for_values_given_later(self):
        system = loads(
            "system s\nand product\ndefuzzifier center_average\nparam top = 2\nparam k in [0.1, top] = 1\n"
            "input x in [-1, 1]\n  terms N P\noutput u in [-1, 1]\n  N = constant(-k)\n  P = constant(k)\n"
            "table u = x\n   N P\n | N P\n"
        )
        assert loads(dumps(system)) == system
        assert system.with_params(k=2).values["k"] == 2.0
        with pytest.raises(DiagnosticError, match="outside of"):
            system.with_params(k=3)
        with pytest.raises(ValueOutOfBoundsError, match=r"in \[0.1, 2\]"):
            fuzzyctl.compile(system, "python", free=["k"]).batch([[0.0]], [3.0])

    def test_the_terms_that_variables_share_are_limited(self):
        names = ", ".join(f"x{k}" for k in range(60))
        lines = f"system s\ninput {names} in [0, 1]\n  terms {' '.join(f't{k}' for k in range(500))}\n"
        assert "FZ112" in [d.code for d in check_text(lines)[1]]


class TestConsequents:
    BASE = (
        "system s\ndefuzzifier weighted_average\ninput x in [0, 1]\n  terms L H\ninput y in [0, 10]\n  terms L H\n"
        "output u in [-9, 99]\n  A = linear(1, 2, 3)\n  B = function(x * y - 1)\n  C = constant(5)\n"
    )

    def test_are_functions_of_the_inputs(self):
        system = loads(
            self.BASE
            + "table u = x x y\n     L  H\n L | A  B\n H | C  0.5\nif x is L and y is L then u is linear(0, 1, 0)\n"
        )
        x, y = 0.25, 4.0
        w = {k: min(0.75 if k[0] == "L" else 0.25, 0.6 if k[1] == "L" else 0.4) for k in ("LL", "LH", "HL", "HH")}
        values = [(w["LL"], x + 2 * y + 3), (w["LH"], x * y - 1), (w["HL"], 5), (w["HH"], 0.5), (w["LL"], y)]
        expected = sum(a * z for a, z in values) / sum(a for a, _ in values)
        assert system(x=x, y=y) == pytest.approx(expected, rel=1e-14)

    def test_monotone_ones_are_inverted(self):
        system = loads(
            "system s\ndefuzzifier tsukamoto\ninput x in [0, 1]\n  terms L H\n"
            "output u in [0, 10]\n  A = ramp(10, 0)\n  B = ramp(0, 10)\nif x is L then u is A\nif x is H then u is B\n"
        )
        # At x = 0.3: A fires with 0.7, inverse 3; B with 0.3, inverse 3.
        assert system(x=0.3) == pytest.approx(3.0, rel=1e-14)


class TestFunctions:
    WHOLE = """
param k = 2
function hump(x, c, w) = 1 / (1 + ((x - c) / w)^2)
function gain(a) = k * abs(a)
function twice(a) = gain(gain(a))
system s
defuzzifier weighted_average
input e in [-1, 1]
  near = hump(0, 0.5)
  far  = function(1 - hump(e, 0, 0.5))
let g = twice(e)
output u in [-9, 9]
  a = function(gain(e) + 1)
output y in [0, 20] = gain(u)
if e is near then u is a
if e is far then u is function(twice(e) + 0 * g)
"""

    def test_are_what_their_expressions_are(self):
        system = loads(self.WHOLE)
        near = 1 / (1 + (0.25 / 0.5) ** 2)
        u = near * (2 * 0.25 + 1) + (1 - near) * 4 * 0.25
        assert system(e=0.25) == pytest.approx({"u": u, "y": 2 * u}, rel=1e-15)
        tripled = 3 * (near * 1.75 + (1 - near) * 9 * 0.25)
        assert system.with_params(k=3)(e=0.25)["y"] == pytest.approx(tripled, rel=1e-15)

    def test_are_written_out_in_the_text_of_a_system(self):
        system = loads(self.WHOLE)
        assert "near = function(1 / (1 + ((e - 0) / 0.5)^2))" in dumps(system)
        assert loads(dumps(system)) == system

    def test_that_controllers_share_may_clamp(self):
        text = "function sat(x, most) = clamp(2 * x, -most, most)\nsystem s\ndefuzzifier weighted_average\n"
        system = loads(text + "input e in [-1, 1]\noutput u in [-1, 1] = sat(e, 0.5) + sat(e, 1)\n")
        assert [system(e=x) for x in (-1.0, 0.1, 0.4)] == pytest.approx([-1.5, 0.4, 1.3])
        assert loads(dumps(system)) == system

    def test_of_a_long_chain_expand_too_deep(self):
        chain = "".join(f"function g{i}(x) = 1 + g{i + 1}(x)\n" for i in range(300)) + "function g300(x) = x\n"
        _, found = check_text(chain + "system s\ninput e in [-1, 1]\noutput u in [0, 1] = g0(e)\n")
        assert [d.code for d in found if d.severity == "error"] == ["FZ106"]

    @pytest.mark.parametrize("word", ["let", "state", "next", "block", "every"])
    def test_of_controllers_have_words_that_systems_name_terms_by(self, word, changed):
        text = changed(("Z = triangle(-1, 0, 1)", f"{word} = triangle(-1, 0, 1)"), ("Z |  N  P", f"{word} |  N  P"))
        assert loads(text).inputs[0].terms[1].name == word


def test_one_of_several_systems_must_be_named(base):
    text = base + base.replace("system base", "system other")
    with pytest.raises(DiagnosticError, match="systems: base, other"):
        loads(text)
    assert loads(text, block="other").name == "other"
    with pytest.raises(DiagnosticError, match="did you mean 'other'"):
        loads(text, block="othr")


@pytest.mark.parametrize("head", ["controller pi\ninput e", "plant pi\ninput e"])
def test_pi_is_the_name_of_blocks_and_a_number_in_expressions(head):
    loop = "loop l\nblock b = pi(cos(pi))\nrun 1 s step 10 ms\nmeasure total = final(b.u)\nrequire total < 0\n"
    assert [d for d in check_text(f"{head}\noutput u = e / pi\n{loop}")[1] if d.severity == "error"] == []


def test_the_form_in_the_help_for_each_signal_and_measure_is_one_that_is_read():
    head = "plant tank\ninput u\nstate h = 0\nder h = u - h\noutput y = h\n"
    head += "loop l\nblock b = tank(r)\nlet r = steps(0: 1)\nlet x = r\nlet u = r\nlet y = b.y\nlet reference = r\n"
    head += "run 9 s step 10 ms\n"

    def errors(line):
        return [d for d in check_text(f"{head}{line}\n")[1] if d.severity == "error"]

    names = errors("let q = unknown(1)")[0].facts[0].partition("where, ")[2].split(", ")
    assert len(names) > 15
    for name in names:
        kind = "let" if name in ("steps", "pulse", "ramp", "sine", "noise", "csv") else "measure"
        form = errors(f"{kind} q = {name}(zz=1)")[0].help.removeprefix("the form is: ")
        for old, new in {"(begin, end": "(1, 2", "(sigma": "(0.1", "(frequency": "(2"}.items():
            form = form.replace(old, new)
        assert name == "csv" or not errors(f"{kind} q = {form}"), form
