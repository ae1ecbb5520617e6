"""Blocks of a rule file, their params, and what `check` finds in them beyond the tables of tests/golden/mistakes."""

import math
from itertools import permutations

import pytest

import fuzzyctl
from fuzzyctl import DiagnosticError, dumps, loads
from fuzzyctl.testing import check_text

BLOCKS = """controller law
  param K = 2
  input e in [-K, K]
  output u = K*e
  every 0.1 s

plant lag
  input u
  state x = 0
  der x = u - x
  output y = x

loop ring
  block p = lag(c.u)
  block c = law(1 - p.y)
  run 1 s
"""
SYSTEM = "system s\ndefuzzifier center_average\ninput e in [-1, 1]\n  terms N P\noutput u in [-1, 1]\n  terms N P\n"
SYSTEM += "table u = e\n   N P\n | N P\n"


def errors_in(text):
    return [(d.code, d.span.text) for d in check_text(text)[1] if d.severity == "error"]


def test_every_block_has_a_kind_inputs_outputs_and_ranges():
    blocks = [fuzzyctl.load("tipper"), *(loads(BLOCKS, block=name) for name in ("law", "lag", "ring"))]
    tipper, law, lag, ring = blocks
    assert [b.kind for b in blocks] == ["system", "controller", "plant", "loop"]
    assert [len(b.inputs) for b in blocks] == [2, 1, 1, 0]
    assert [[o.name for o in b.outputs] for b in blocks] == [["tip"], ["u"], ["y"], []]
    assert all(isinstance(b, fuzzyctl.Block) for b in blocks)
    assert [ring.callee(i) for i in ring.instances] == [lag, law]
    assert law.range_of(law.inputs[0]) == (-2.0, 2.0)
    assert lag.range_of(lag.inputs[0]) == (-math.inf, math.inf)
    assert tipper.range_of(tipper.inputs[0]) == (0.0, 10.0)
    assert law.values == {"K": 2.0}


class TestParams:
    def test_any_order_gives_the_same_values(self):
        lines = ["param a = 1\n", "param b = a + 2\n", "param c = a + b\n", "param d = 5\n"]
        for order in permutations(lines):
            assert loads("".join(order) + SYSTEM + "require u <= c + d\n").values == {"a": 1, "b": 3, "c": 4, "d": 5}

    def test_a_long_chain_needs_no_recursion(self):
        chain = "".join(f"param p{k} = p{k + 1} + 1\n" for k in range(3000)) + "param p3000 = 0\n"
        assert loads(chain + SYSTEM + "require u <= p0\n").values["p0"] == 3000

    @pytest.mark.parametrize(
        ("first", "code", "place"),
        [
            ("param a = b\nparam b = a\n", "FZ308", "a"),
            ("param a = inf\n", "FZ307", "a"),
            ("param a = 1 / 0\n", "FZ307", "1 / 0"),
            ("param a = gone\n", "FZ202", "gone"),
        ],
        ids=["circle", "infinite", "quotient", "name"],
    )
    def test_one_cause_is_reported_once_and_costs_only_those_that_need_it(self, first, code, place):
        rest = "param d = a + 1\nparam z = 1\n"
        assert errors_in(f"{first}{rest}{SYSTEM}require u <= d\nrequire u <= z + 9\n") == [(code, place)]


class TestLetsInGuarantees:
    def test_are_written_out_for_proofs(self):
        lines = "let b = 2 * a\nlet a = e + 1\nlet c = b + a\nrequire u >= c when b >= 0\n"
        (verdict,) = fuzzyctl.prove(loads(SYSTEM + lines))
        assert isinstance(verdict, fuzzyctl.Refuted)
        e = verdict.witness.point["e"]
        assert dict(verdict.witness.sides)["b"] == pytest.approx(2 * (e + 1))

    @pytest.mark.parametrize("step", ["a{0} + a{0}", "a{0} + 1"], ids=["twice as large", "deeper"])
    def test_that_become_too_large_are_refused_at_once(self, step):
        lets = "let a0 = e + 1\n" + "".join(f"let a{k + 1} = {step.format(k)}\n" for k in range(300))
        assert errors_in(SYSTEM + lets + "require u <= a300\nrequire u <= 9 when a300 > 0\nrequire u <= a2 + 9\n") == [
            ("FZ112", "require u <= a300"),
            ("FZ112", "require u <= 9 when a300 > 0"),
        ]


class TestHints:
    def test_a_file_is_loaded_with_them_unless_it_denies_them(self, changed):
        unused = changed(("\ninput x", "\nparam k = 1\ninput x"), after="if x is N and y is N then u is P\n")
        outside = changed(("Z = triangle(-2, 0, 2)", "Z = triangle(-2, 9, 12)"))
        for text, codes in ((unused, ["FZ209", "FZ216"]), (outside, ["FZ306"])):
            system, diagnostics = loads(text), check_text(text)[1]
            assert {d.severity for d in diagnostics} == {"warning"}
            assert sorted({d.code for d in diagnostics}) == codes
            assert [d.code for d in fuzzyctl.check(system)[1]] == [d.code for d in diagnostics]
            with pytest.raises(DiagnosticError, match=codes[-1]):
                loads(f"{text}deny {codes[-1]}\n")

    @pytest.mark.parametrize("defuzzifier", ["center_average", "centroid"])
    @pytest.mark.parametrize("terms", ["terms A B C", "terms A@-1 B@0.25 C@2"])
    @pytest.mark.parametrize("used", ["AB", "BC", "AC"])
    def test_the_advice_for_an_unused_term_keeps_every_number(self, terms, used, defuzzifier):
        text = "system s\ninput x in [0, 40]\n  terms low high\n"
        text += f"output u in [-1, 2] defuzzifier {defuzzifier}\n  {terms}\n"
        text += f"if x is low then u is {used[0]}\nif x is high then u is {used[1]}\n"
        (found,) = (d for d in check_text(text)[1] if d.code == "FZ208")
        written = found.help.rpartition("as they are: ")[2]
        if found.help == "remove it, or use it in a rule":
            written = " ".join(word for word in terms.split() if word[0] in f"t{used}")
        system, advised = loads(text), loads(text.replace(terms, written.replace("), ", ")\n  ")))
        assert [t.name for t in advised.outputs[0].terms] == list(used)
        for x in (0, 3, 11, 20, 29.5, 40):
            assert advised(x=x) == pytest.approx(system(x=x), abs=1e-12)

    @pytest.mark.parametrize("consequent", ["linear(0, 1, 2)", "linear(1, 0, 2)", "function(x * z)", "function(x)"])
    def test_an_input_is_used_by_consequents_of_terms_as_by_those_of_rules(self, consequent):
        head = "system pdc\ndefuzzifier weighted_average\nparam k = 2\ninput x in [-1, 1]\n  terms N P\n"
        head += "input z in [-1, 1]\noutput u in [-9, 9]\n{}if x is N then u is {}\nif x is P then u is {}\n"
        texts = (
            head.format("", consequent, "linear(k, 0, 0)"),
            head.format(f"  t = {consequent}\n  s = linear(k, 0, 0)\n", "t", "s"),
        )
        in_rules, in_terms = ([d.code for d in check_text(text)[1]] for text in texts)
        assert in_rules == in_terms == ([] if "z" in consequent or "1, 2" in consequent else ["FZ211"])

    def test_every_warning_can_be_allowed(self):
        codes = sorted({d.code for text in (SYSTEM, "") for d in check_text(text + "param k = 1\n")[1]})
        assert codes == ["FZ004", "FZ216"]
        assert check_text(f"{SYSTEM}param k = 1\nallow FZ216\n")[1] == []


def test_a_printed_system_is_the_same_in_all_its_checks(base):
    assert check_text(dumps(loads(base)))[1] == check_text(base)[1] == []
