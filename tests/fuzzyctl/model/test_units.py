"""Units in guarantees."""

import pytest

from fuzzyctl.loading import examine
from fuzzyctl.source import SourceText

HEAD = """system s
defuzzifier weighted_average
param room = 3 unit "m"
param speed = 2 unit "m/s"
param bare = 1
input x in [0, 1] unit "m"
  terms N P
input v in [0, 1] unit "m/s"
  terms N P
output f in [0, 5] unit "m"
  terms a=0 b=5
table f = x x v
      N  P
 N |  a  b
 P |  b  a
"""


def found(claim):
    _, diagnostics = examine(SourceText("s.fz", f"{HEAD}require f <= bare * room * speed\nrequire {claim}\n"))
    return [d for d in diagnostics if d.severity == "error"]


class TestUnits:
    @pytest.mark.parametrize(
        "claim",
        [
            "f <= room",
            "f <= 5",
            "f + x <= bare",
            "f <= 2 * speed",
            "f(x, v) >= -room",
            "f(0.5, v / 2) <= 5 when v >= speed",
            "bounded(f, 0, room)",
            "lipschitz(f, v) <= speed",
            "f <= 5 within room",
            "max(f, x) + abs(x) <= 9",
        ],
    )
    def test_what_may_be_compared_is(self, claim):
        assert found(claim) == []

    @pytest.mark.parametrize(
        ("claim", "place"),
        [
            ("f <= speed", "speed"),
            ("f <= 5 when x >= speed", "speed"),
            ("f + v <= 5", "v"),
            ("-f >= -v", "-v"),
            ("f(v, 0.5) >= 0", "v"),
            ("bounded(f, 0, speed)", "speed"),
            ("max(f, v) <= 9", "v"),
            ("f <= 5 or f >= v", "v"),
            ("f <= 5 within speed", "speed"),
            ("2 * (f + v) <= 5", "v"),
        ],
    )
    def test_what_may_not_is_reported_at_its_place(self, claim, place):
        (d,) = found(claim)
        assert d.code == "FZ312"
        assert d.span.text == place
