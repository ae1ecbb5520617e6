"""What `check` finds of guarantees, in no time."""

import pytest

import fuzzyctl
from fuzzyctl.testing import check_text
from tests.effort import at_most_calls

TEXT = """
system s
{method}
input x in [-1, 1]
  N = gaussian(-1, 0.4)
  P = gaussian(1, 0.4)
output u in [-1, 1]
  terms N P
table u = x
   N P
 | N P
require {claim}
"""
CURVED = "and product\ndefuzzifier center_average"


def diagnostics(system):
    return [d for d in fuzzyctl.check(system)[1] if d.code in ("FZ307", "FZ402")]


def found(claim, method=CURVED):
    return [d.code for d in diagnostics(fuzzyctl.loads(TEXT.format(method=method, claim=claim)))]


@pytest.mark.parametrize("claim", ["u <= 0.5", "decreasing(u, x)", "lipschitz(u, x) <= 0.1", "u(-x) == u within 0.1"])
def test_a_broken_claim_about_a_curved_system_is_found(claim):
    assert found(claim) == ["FZ402"]


@pytest.mark.parametrize("claim", ["u <= 1", "increasing(u, x)", "u(-x) == -u within 1e-12"])
def test_what_is_true_or_open_is_not_reported(claim):
    assert found(claim) == []


def test_a_witness_is_shown_where_the_guarantee_stands():
    (found,) = diagnostics(fuzzyctl.loads(TEXT.format(method=CURVED, claim="u <= 0.5")))
    assert found.span.text.startswith("require u")
    assert found.facts[0].startswith("at x = 1: u = ")


def test_a_system_whose_guarantee_is_broken_comes_with_the_error():
    text = TEXT.format(method=CURVED, claim="u <= 0.5")
    systems, found = check_text(text)
    assert [s.name for s in systems] == ["s"]
    assert [d.code for d in found] == ["FZ411", "FZ402"]
    assert [d.code for d in check_text(text, guarantees=False)[1]] == ["FZ411"]
    assert [d.code for d in fuzzyctl.check(systems[0])[1]] == ["FZ411", "FZ402"]
    assert fuzzyctl.check(systems[0], guarantees=False)[0] == systems[0]


def test_the_shipped_files_take_no_time(rules):
    texts = {str(p): p.read_text(encoding="utf-8") for p in sorted(rules.glob("*.fz"))}
    check_text(texts[str(rules / "tipper.fz")])
    with at_most_calls(1_500_000):
        assert [check_text(t, name, folder=rules)[1] for name, t in texts.items()] == [[]] * len(texts)


class TestDivisors:
    """A guarantee that divides by 0 somewhere says so at its place."""

    SYSTEM = """system s
and product
defuzzifier center_average
param k = 0.5
input x in [-1, 1]
  terms N Z P
output u in [-1, 1]
  terms N Z P
table u = x
  N Z P
| N Z P
require {claim}
"""

    @pytest.mark.parametrize(
        ("claim", "divisor"),
        [("1 / u <= 3", "u"), ("u / x >= 0.5", "x"), ("u <= 2 / (u + 1)", "u + 1"), ("u >= -1 when 1 / x > 2", "x")],
    )
    def test_it_is_reported_there(self, claim, divisor):
        (found,) = diagnostics(fuzzyctl.loads(self.SYSTEM.format(claim=claim)))
        assert (found.code, found.span.text) == ("FZ307", divisor)
        assert "which is 0 at x = " in found.message

    @pytest.mark.parametrize("claim", ["u / (u + 2) <= 1", "u / x >= 0.5 when x >= 0.1", "u <= 1 / k", "u / k <= 2"])
    def test_other_quotients_are_fine(self, claim):
        assert diagnostics(fuzzyctl.loads(self.SYSTEM.format(claim=claim))) == []

    @pytest.mark.parametrize("part", ["log(x)", "sqrt(x - 0.5)", "x^-1", "x^0.5", "x^(u / 2 - 0.25)", "log(x + 1)"])
    def test_what_has_no_value_in_part_of_the_range_is_reported(self, part):
        (found,) = diagnostics(fuzzyctl.loads(self.SYSTEM.format(claim=f"u <= 9 + abs({part})")))
        assert (found.code, found.span.text.rstrip(")")) == ("FZ307", part.rstrip(")"))
        assert f"takes '{part}', which has no value at x = " in found.message
        (verdict,) = fuzzyctl.prove(fuzzyctl.loads(self.SYSTEM.format(claim=f"u <= 9 + abs({part})")), timeout=0.1)
        assert f"it takes '{part}'" in verdict.reason

    @pytest.mark.parametrize(
        "claim", ["u <= 9 + log(x + 2)", "x^2 + u <= 2", "u <= x^-2 when x > 0.1", "x <= 0.1 or log(x) <= 5 * (u + 2)"]
    )
    def test_what_has_one_wherever_it_counts_is_not(self, claim):
        assert diagnostics(fuzzyctl.loads(self.SYSTEM.format(claim=claim))) == []
