"""Numbers in guarantees."""

import pytest

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import examine

HEAD = """system s
defuzzifier weighted_average
param one = 1
input x in [0, 1]
  terms N P
output u in [0, 5]
  terms a=0 b=5
table u = x
      N  P
   |  a  b
"""


def found(claim):
    _, diagnostics = examine(SourceText("s.fz", f"{HEAD}require u <= 9 * one\nrequire {claim}\n"))
    return [(d.code, d.message, d.span.text) for d in diagnostics if d.severity == "error"]


@pytest.mark.parametrize(
    ("claim", "place"),
    [
        ("u <= x / 0", "x / 0"),
        ("u <= x / (one - 1)", "x / (one - 1"),
        ("u <= 1 when (x + u) / sin(0) > 1", "x + u) / sin(0"),
        ("u + x / -0.0 <= 3", "x / -0.0"),
    ],
)
def test_what_is_divided_by_a_number_that_is_0_is_reported(claim, place):
    assert found(claim) == [("FZ307", "division by zero", place)]


@pytest.mark.parametrize("claim", ["u <= 1 / (one - 1)", "u <= x + 1 / 0"])
def test_numbers_alone_are_reported_once(claim):
    ((code, message, _),) = found(claim)
    assert (code, message) == ("FZ307", "division by zero")


@pytest.mark.parametrize("claim", ["u <= x / one", "u <= 5 / (x + 1)", "x / (1 - 0.5) >= u - 5"])
def test_other_quotients_are_fine(claim):
    assert found(claim) == []
