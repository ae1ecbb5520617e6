"""Bounds are printed so that they still hold."""

import math
import re

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl import loads
from fuzzyctl.cli.codegen import codegen
from fuzzyctl.codegen.comments import described
from fuzzyctl.codegen.fixed.c_fixed_step import files
from fuzzyctl.codegen.fixed.fixed_format import to_format
from fuzzyctl.codegen.fixed.fixed_system import fixed_point
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.codegen.table import at_most

BENT = """system bent
and product
defuzzifier center_average
input x in [0, 1]
  terms a@0 b@0.5 c@1
output y in [0, 1]
  terms A=0 B=0.60049 C=1
table y = x
    a b c
  | A B C
"""


@given(st.floats(0, 1e300), st.integers(1, 15))
def test_a_bound_is_never_rounded_down_and_by_one_digit_at_most(bound, digits):
    read = float(at_most(bound, digits))
    assert bound <= read <= bound * (1 + 1.001 * 10.0 ** (1 - digits)) + 5e-324


@pytest.mark.parametrize(
    ("bound", "text"), [(0.10049, "0.101"), (0.1, "0.1"), (0.9999, "1"), (0.0, "0"), (2e-7, "2e-07")]
)
def test_a_bound_keeps_three_digits(bound, text):
    assert at_most(bound) == text


def test_a_bound_without_end_says_so():
    assert at_most(math.inf) == "inf"


class TestStatedErrors:
    """A table of two points is off by 0.10049 in the middle."""

    def test_of_a_table_are_not_below_what_happens(self, tmp_path):
        (tmp_path / "bent.fz").write_text(BENT, encoding="utf-8")
        arguments = [str(tmp_path / "bent.fz"), "--target", "c", "--table", "2", "-o", str(tmp_path)]
        printed = CliRunner().invoke(codegen, arguments).output
        assert "proved: y is off by 0.101 at most" in printed
        assert "|y - exact y| <= 0.101 " in "\n".join(described(prepare(loads(BENT), BENT, table=2)))

    def test_of_fixed_point_are_not_below_what_is_proved(self):
        unit = prepare(loads(BENT), BENT, table=2)
        fixed = fixed_point(unit, to_format("Q1.14"))
        header = files(unit, fixed)["bent.h"]
        bound, steps = re.search(r"\|y - exact y\| <= (\S+), that is (\S+) / 2\^14", header).groups()
        assert float(bound) >= fixed.errors[0]
        assert float(steps) >= fixed.errors[0] * 2**14
