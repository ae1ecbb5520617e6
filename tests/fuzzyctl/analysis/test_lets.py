"""Lets in proofs: those that no rule reads leave a system what it is, and witnesses say what they are."""

import pytest

from fuzzyctl import Proved, loads, prove
from fuzzyctl.analysis.extremes import extents
from tests.fuzzyctl.analysis.proving import LINE, words

#: Which is proved without time for a surface that is known exactly.
SYMMETRIC = "u(-e, -de) == -u within 1e-12"


@pytest.mark.parametrize(
    ("value", "is_exact"),
    [
        ("e - de", True),
        ("de / (e + 2)", True),
        ("sqrt(e + 1.5) * max(e, de)", True),
        ("1 / e", False),  # which has no value at e = 0, where neither has any output
        ("0 * log(e)", False),
        ("min(e, log(e))", False),
        ("inf * e", False),
    ],
)
def test_a_let_that_no_rule_reads_leaves_the_surface_exact_where_it_has_a_value(value, is_exact):
    assert words(LINE + f"let a = {value}\n", SYMMETRIC, timeout=0) == ["Proved" if is_exact else "Undecided"]


def test_proofs_and_bounds_are_those_of_the_system_without_it():
    claims = "require increasing(u, e)\nrequire u == u(e, de) within 1e-9\n"
    plain, named = loads(LINE + claims), loads(LINE + "let a = e - de\n" + claims)
    assert [type(v) for v in prove(named)] == [type(v) for v in prove(plain)] == [Proved, Proved]
    assert [e.lo for e in extents(named)] == [e.lo for e in extents(plain)]


def test_a_witness_says_what_the_lets_of_the_claim_are():
    system = loads(LINE + "let a = e - de\nlet b = 2 * a\nlet d = 3 * e\nrequire u <= b - 9\n")
    (verdict,) = prove(system)
    point, sides = verdict.witness.point, dict(verdict.witness.sides)
    assert next(iter(sides)) == "b"
    assert "d" not in sides
    assert sides["b"] == 2 * (point["e"] - point["de"])
