"""Units as texts."""

import pytest

from fuzzyctl.model.checks import dimensions
from fuzzyctl.model.checks.dimensions import are_same, dimension, surely_differ


def test_each_text_is_read_once(monkeypatch):
    read = []
    tokens = dimensions._tokens
    monkeypatch.setattr(dimensions, "_tokens", lambda text: (read.append(text), tokens(text))[1])
    for _ in range(10):
        assert not are_same("widgets/s", "gadgets per s")
        assert not surely_differ("gadgets per s", "widgets/s")
    assert sorted(read) == ["gadgets per s", "widgets/s"]


class TestSame:
    @pytest.mark.parametrize(
        "text",
        [
            "m s^-1",
            "m s-1",
            "m·s⁻¹",
            "m * s**-1",
            "m.s^(-1)",
            "m per s",
            "(m)/(s)",
            "[m/s]",
            " m / s ",
            "m/sec",
            "1/(s/m)",
            "m³/s/m²",
            "Hz m",
        ],
    )
    def test_however_it_is_spelt(self, text):
        assert are_same("m/s", text)
        assert not surely_differ(text, "m", "s")

    @pytest.mark.parametrize(
        ("a", "b"),
        [
            ("N", "kg m/s²"),
            ("V/A", "\N{OHM SIGN}"),
            ("\N{MICRO SIGN}m", "\N{GREEK SMALL LETTER MU}m"),
            ("kWh", "kW h"),
            ("apples/s", "apples per s"),
            ("T1/m", "T1 m^-1"),
            ("-", "1"),
            ("[-]", ""),
            ("L", "dm^3"),
        ],
    )
    def test_others(self, a, b):
        assert are_same(a, b)

    @pytest.mark.parametrize(
        ("a", "b"),
        [
            ("m/s", "km/h"),
            ("°C", "K"),
            ("m", "mm"),
            ("%", "1"),
            ("T1", "T"),
            ("m2", "m"),
            ("J/kg K", "J/(kg K)"),
            ("m", "apples"),
            ("(m", "m"),
            ("m", "m/"),
        ],
    )
    def test_what_is_not(self, a, b):
        assert not are_same(a, b)


class TestSurelyDiffer:
    @pytest.mark.parametrize(
        ("unit", "above", "below"),
        [
            ("m", "m", "s"),
            ("cm/s", "m", "s"),
            ("m", "m", "m"),
            ("s/m", "m", "s"),
            ("apples", "apples", "h"),
            ("rad", "rad", "s"),
            ("m/s", "m/s", "s"),
        ],
    )
    def test_where_there_is_no_doubt(self, unit, above, below):
        assert surely_differ(unit, above, below)

    @pytest.mark.parametrize(
        ("unit", "above", "below"),
        [
            ("m", "m", "rad"),  # which is 1
            ("1/s", "rad", "s"),
            ("rpm", "rev", "min"),
            ("apples", "m", "s"),
            ("K/s", "°C", "s"),
            ("J/kg K", "m", "s"),
            ("a ? b", "m", "s"),
            ("m", "50 m", "s"),
        ],
    )
    def test_where_words_leave_one(self, unit, above, below):
        assert not surely_differ(unit, above, below)


@pytest.mark.parametrize(
    "text", ["(" * 5000 + "m", "m" * 5000, "m^999999999", "1.5 m", "m^^2", "()m", "()", "·", "m s^", "²"]
)
def test_any_text_may_be_asked_of(text):
    assert dimension(text) is None or isinstance(are_same(text, "m"), bool)
