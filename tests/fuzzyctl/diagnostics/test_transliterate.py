"""Names in ASCII, for C, Structured Text and the like."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl.diagnostics.terminal import in_ascii


@pytest.mark.parametrize(
    ("name", "spelt"),
    [
        ("service", "service"),
        ("a_1", "a_1"),
        ("σ", "sigma"),
        ("ς", "sigma"),
        ("Δσ", "Deltasigma"),
        ("ώ", "omega"),
        ("größe", "grou00DFe"),
        ("é", "e"),
        ("e\u0301", "e"),
        ("a b", "a_b"),
        ("ж", "u0436"),
        ("x′", "xu2032"),
    ],
)
def test_letters_are_spelt_out(name, spelt):
    assert in_ascii(name) == spelt


@given(st.text())
def test_nothing_else_is_left(name):
    assert re.fullmatch(r"[A-Za-z0-9_]*", in_ascii(name))


@given(st.from_regex(r"[A-Za-z0-9_]*", fullmatch=True))
def test_what_is_in_ascii_stays(name):
    assert in_ascii(name) == name
