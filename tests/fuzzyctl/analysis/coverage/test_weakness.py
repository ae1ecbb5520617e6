"""Weak coverage: FZ411 where tails alone keep the rules active."""

import random

import pytest

import fuzzyctl
from fuzzyctl.testing import run_command

SMOKER = """system smoker
defuzzifier weighted_average
input error in [-40, 40]
  cold = gaussian(-40, {0})
  fine = gaussian(0, {1})
  hot  = gaussian(40, {0})
output damper in [0, 1]
  terms shut=0 half=0.5 open=1
if error is cold then damper is open
if error is fine then damper is half
if error is hot then damper is shut
"""
NARROW, WIDE = SMOKER.format(10, 5), SMOKER.format(15, 12)


def weak(text):
    return [d for d in fuzzyctl.check(fuzzyctl.loads(text))[1] if d.code == "FZ411"]


def product_of(inputs, sigma):
    terms = f"\n  low = gaussian(0, {sigma})\n  high = gaussian(1, {sigma})\n"
    rules = "".join(
        f"if {' and '.join(f'{i} is {t}' for i, t in zip(inputs, bits, strict=True))} then y is {bits[0]}\n"
        for k in range(2 ** len(inputs))
        for bits in [["low" if k >> j & 1 else "high" for j in range(len(inputs))]]
    )
    variables = "".join(f"input {i} in [0, 1]{terms}" for i in inputs)
    output = "output y in [0, 1]\n  terms low=0 high=1\n"
    return f"system s\nand product\ndefuzzifier weighted_average\n{variables}{output}{rules}"


def test_the_claim_of_the_edit_is_refuted_until_terms_are_widened():
    (warning,) = weak(NARROW)
    assert [r.text for r in warning.fix.replacements] == ["\nrequire total(damper) >= 0.1"]
    claimed = NARROW + "require total(damper) >= 0.1\n"
    assert [type(v) for v in fuzzyctl.prove(fuzzyctl.loads(claimed))] == [fuzzyctl.Refuted]
    assert weak(claimed)[0].fix is None
    repaired = claimed.replace(", 10)", ", 15)").replace(", 5)", ", 12)")
    assert [type(v) for v in fuzzyctl.prove(fuzzyctl.loads(repaired))] == [fuzzyctl.Proved]
    assert not weak(repaired)


def test_a_smaller_claim_says_that_the_gap_is_meant():
    assert not weak(NARROW + "require total(damper) >= 0.02\n")


def test_the_point_has_the_activation_that_is_said():
    rng = random.Random(1)
    reported = 0
    for _ in range(16):
        text = SMOKER.format(round(rng.uniform(4, 20), 1), round(rng.uniform(3, 16), 1))
        system = fuzzyctl.loads(text)
        lowest = min(max(r.activation for r in fuzzyctl.why(system, error=e / 4).rules) for e in range(-160, 161, 2))
        found = weak(text)
        assert len(found) == (lowest < 0.1 - 1e-3) or abs(lowest - 0.1) < 2e-3
        if found:
            reported += 1
            said, place = found[0].message.split(" by more than ")[1].split(" at error = ")
            strongest = max(r.activation for r in fuzzyctl.why(system, error=float(place)).rules)
            assert float(said) == pytest.approx(strongest, rel=0.05)
            assert strongest <= 1.11 * lowest
    assert 2 <= reported < 14


@pytest.mark.parametrize(("sigma", "is_weak"), [(0.45, False), (0.2, True)])
def test_products_of_many_halves_are_no_weak_rules(sigma, is_weak):
    assert bool(weak(product_of("abcd", sigma))) == is_weak


def test_straight_terms_and_gaps_with_an_else_are_not_reported():
    assert not weak(NARROW.replace("gaussian(0, 5)", "triangle(-41, 0, 41)"))
    assert not weak(NARROW.replace("10)", "0.4)").replace("5)", "0.4)").replace("[0, 1]\n", "[0, 1] else 0\n"))


def test_foreign_files_are_searched_within_the_ranges():
    fis = fuzzyctl.dumps(fuzzyctl.loads(NARROW.replace("[-40, 40]", "[-40, 40] extrapolate")))
    assert len(weak(fis.replace("[0, 1]", "[0, 1] else midpoint"))) == 1


def test_the_command_leaves_the_claim_to_the_editor(tmp_path):
    path = tmp_path / "smoker.fz"
    path.write_text(NARROW)
    result = run_command("check", "--fix", "likely", path)
    assert (result.exit_code, path.read_text()) == (0, NARROW)
    assert "--fix" not in run_command("check", path).output
