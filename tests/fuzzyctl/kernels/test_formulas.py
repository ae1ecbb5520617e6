"""Lets and outputs that are formulas: their numbers, beside numpy, and what proofs and other formats make of them."""

import math
import runpy

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl.testing import run_command
from tests import sizes

BACKENDS = ("python", "numpy", "numba")

BOTH = """
system both
defuzzifier center_average
and product
param slope = 2
input e in [-1, 1]
  terms Z@0 P@1
input de in [-1, 1]
let s "sliding variable" in [-3, 3] unit "1/s" = slope * e + de
  terms NB Z PB
let g = abs(s) + 1
output u in [-1, 1]
  terms NB@-1 Z@0 PB@1
output w in [-4, 4] unit "V" = g * u
output v in [-1, 1] clamp = w / 2
  low  = ramp(1, -1)
  high = ramp(-1, 1)
output r in [-10, 10]
  a = triangle(-2, -1, 0)
table u = s
    NB Z PB
  | NB Z PB
if v is high and e is P then r is function(w + s)
if v is low or e is Z then r is a
require w <= 4
"""


def by_hand(points):
    e, de = np.clip(points, -1, 1).T
    s = 2 * e + de
    u = np.clip(s / 3, -1, 1)
    w = (abs(s) + 1) * u
    v = np.clip(w / 2, -1, 1)
    high, p = (v + 1) / 2, np.clip(e, 0, 1)
    first, second = high * p, np.maximum(1 - high, 1 - p)
    return np.stack([u, w, v, (first * (w + s) - second) / (first + second)], axis=-1)


class TestNumbers:
    @pytest.mark.parametrize("backend", BACKENDS)
    def test_lets_and_formulas_are_what_numpy_computes(self, backend):
        points = np.random.default_rng(3).uniform(-1.3, 1.3, (500, 2))
        kernel = fuzzyctl.compile(fuzzyctl.loads(BOTH), backend)
        np.testing.assert_allclose(kernel.batch(points), by_hand(points), rtol=1e-12, atol=1e-12)
        assert kernel(*points[0]) == pytest.approx(by_hand(points[:1])[0], rel=1e-12)

    @pytest.mark.parametrize("backend", sizes.BACKENDS)
    def test_a_let_without_a_value_leaves_no_output_with_one(self, backend):
        text = BOTH.replace("slope * e + de", "e / (de - de * 1)")
        kernel = fuzzyctl.compile(fuzzyctl.loads(text), backend)
        assert all(map(math.isnan, kernel(0.0, 0.5)))
        assert np.isnan(kernel.batch([[0.0, 0.5], [0.0, 0.2]])).all()

    def test_a_rate_reads_lets_of_raw_inputs(self):
        text = (
            "system a\ndefuzzifier weighted_average\ninput e in [-1, 1]\n  terms N P\nlet s = 2 * e\n"
            "output F in [-5, 5] adaptive rate s\n  terms N=0 P=0\ntable F = e\n    N P\n  | N P\n"
        )
        kernel = fuzzyctl.compile(fuzzyctl.loads(text), "python")
        rates = [0.0, 0.0]
        kernel.jit_rates(3.0, [0.0, 0.0], rates)
        assert rates == [0.0, 6.0]

    @pytest.mark.parametrize("word", ["let", "s"])
    def test_a_system_may_call_a_variable_let(self, word):
        text = f"system f\ninput {word} in [0, 1]\n  terms a b\noutput y in [0, 1]\n  let = ramp(0, 1)\n"
        text += f"if ({word} is a and\n    {word} is not b\n    or {word} is b) then y is let\n"
        text = text.replace("and\n    ", "and (\n    ").replace("b) then", "b)) then")
        assert fuzzyctl.loads(text)(**{word: 0.0}) == pytest.approx(2 / 3)


class TestTools:
    @pytest.fixture
    def path(self, tmp_path):
        (tmp_path / "both.fz").write_text(BOTH)
        return tmp_path / "both.fz"

    def test_python_builds_the_same_system(self, path):
        assert run_command("convert", path, path.with_suffix(".py")).exit_code == 0
        assert runpy.run_path(str(path.with_suffix(".py")))["system"] == fuzzyctl.loads(BOTH)

    @pytest.mark.parametrize("target", ["fis", "fll", "fcl", "fml"])
    def test_other_formats_refuse_them(self, path, target):
        refused = run_command("convert", path, "-", "--to", target)
        assert refused.exit_code == 1
        for words in ("FZ608", "let 's'", "let 'g'", "output 'w', which is a formula"):
            assert words in refused.errors

    def test_changes_are_named_and_traces_know_them(self, path):
        other = path.with_name("other.fz")
        other.write_text(BOTH.replace("abs(s) + 1", "abs(s) + 2").replace("= g * u", "= g * u / 2"))
        shown = run_command("compare", "--changes", path, other).output
        assert "abs(s) + 2" in shown
        assert "g * u / 2" in shown
        found = fuzzyctl.why(fuzzyctl.loads(BOTH), e=0.5, de=0.25)
        assert found.degrees["s"] == pytest.approx({"NB": 0.0, "Z": 1 - 1.25 / 3, "PB": 1.25 / 3})

    def test_dumps_reads_back(self):
        system = fuzzyctl.loads(BOTH)
        text = fuzzyctl.dumps(system)
        assert fuzzyctl.loads(text) == system
        assert 'let s "sliding variable" in [-3, 3] unit "1/s" = slope * e + de\n  NB = triangle(' in text
        assert 'output w in [-4, 4] unit "V" = g * u\n' in text
        assert "output v in [-1, 1] clamp = w / 2\n" in text

    def test_formulas_have_bounds_and_guarantees_are_proved(self):
        system = fuzzyctl.loads(BOTH)
        bounds = fuzzyctl.output_bounds(system)
        assert (bounds["w"].lo, bounds["w"].hi) == (-4.0, 4.0)
        assert (bounds["v"].lo, bounds["v"].hi) == (-1.0, 1.0)
        assert [type(v).__name__ for v in fuzzyctl.prove(system)] == ["Proved"]

    def test_a_formula_that_leaves_its_range_is_reported(self, tmp_path):
        path = tmp_path / "f.fz"
        path.write_text("system f\ninput x in [0, 1]\noutput y in [0, 3] = 5 * x\n")
        _, found = fuzzyctl.check(path)
        assert [d.code for d in found] == ["FZ408"]
        path.write_text("system f\ninput x in [0, 1]\noutput y in [0, 3] clamp = 5 * x\n")
        assert fuzzyctl.check(path)[1] == []

    def test_names_may_be_words_of_python(self):
        text = (
            "system p\ndefuzzifier weighted_average\ninput lambda in [0, 1]\n  terms N P\nlet def = 2 * lambda\n"
            "output u in [-9, 9]\nif lambda is N then u is function(def)\nif lambda is P then u is function(lambda)\n"
        )
        system = fuzzyctl.loads(text)
        assert fuzzyctl.compile(system, "python")(0.5) == pytest.approx(0.75)
        assert {c.value for r in fuzzyctl.why(system, **{"lambda": 0.5}).rules for c in r.contributions} == {1.0, 0.5}


COVERED = """
system h
defuzzifier center_average
input e in [-1, 1]
let z in [-1, 1] = {value}
  N = triangle(-0.7, -0.5, 0.1)
  P = triangle(-0.1, 0.5, 0.7)
output u in [-1, 1]
  terms N P
table u = z
    N P
  | N P
"""


class TestCoverage:
    def check(self, tmp_path, value):
        path = tmp_path / "h.fz"
        path.write_text(COVERED.format(value=value))
        return fuzzyctl.check(path)[1]

    def test_rules_need_to_fire_only_where_a_let_can_be(self, tmp_path):
        assert self.check(tmp_path, "e / 2") == []

    def test_a_gap_that_a_let_reaches_is_found(self, tmp_path):
        (found,) = self.check(tmp_path, "e")
        assert (found.code, found.message) == ("FZ401", "no rule fires for output 'u' at e = -1")
        assert "it is not known how far around it none does: all that is known of z is the range" in found.facts
