"""Units in guarantees."""

import pytest

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import examine

HEAD = """system s
defuzzifier weighted_average
param room = 3 unit "m"
param speed = 2 unit "m/s"
param bare = 1
param rate = 1 unit "1/s"
param time = 1 unit "s"
param quick = 1 unit "m·s^-1"
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
            "lipschitz(f, v) <= time",
            "lipschitz(f, v) <= room / speed",
            "lipschitz(f, v) <= bare + 2",
            "lipschitz(f, x) <= 3 within room",
            "increasing(f, v) within room",
            "total(f) >= bare / 2",
            "v <= quick",
            "f(x, quick) <= 9",
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
            ("lipschitz(f, v) <= speed", "speed"),
            ("lipschitz(f, v) <= rate", "rate"),
            ("lipschitz(f, x) <= room", "room"),
            ("lipschitz(f, v) <= time + speed", "speed"),
            ("f <= 5 and lipschitz(f, v) <= rate + 2", "rate + 2"),
            ("lipschitz(f, x) <= 3 within speed", "speed"),
            ("decreasing(f, v) within speed", "speed"),
            ("bounded(f, 0, 5) within speed", "speed"),
            ("total(f) >= rate", "rate"),
            ("lt(f, speed) >= 1", "speed"),
            ("floor(f) <= speed", "speed"),
            ("mod(f, speed) <= 5", "speed"),
        ],
    )
    def test_what_may_not_is_reported_at_its_place(self, claim, place):
        (d,) = found(claim)
        assert d.code == "FZ312"
        assert d.span.text == place

    @pytest.mark.parametrize(
        ("claim", "message"),
        [
            ("lipschitz(f, v) <= rate", "'rate' is measured in 1/s, a slope of 'f' along 'v' in m per m/s"),
            ("lipschitz(f, x) <= room", "'room' is measured in m, a slope of 'f' along 'x' has no unit"),
            ("total(f) >= rate", "'rate' is measured in 1/s, a strength has no unit"),
        ],
    )
    def test_says_what_is_due(self, claim, message):
        assert found(claim)[0].message == message

    @pytest.mark.parametrize(("old", "new"), [('x in [0, 1] unit "m"', "x in [0, 1]"), ('5] unit "m"', "5]")])
    def test_a_slope_of_what_has_no_unit_may_have_any(self, old, new):
        text = HEAD.replace(old, new) + "require lipschitz(f, x) <= room\n"
        _, diagnostics = examine(SourceText("s.fz", text))
        assert not any(d.code == "FZ312" for d in diagnostics)
