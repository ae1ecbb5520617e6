"""Locations of keys that stand in a common table, in a file below, or on the command line."""

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.experiments.settings.locations import Places

BASE = Places(SourceText("base.toml", "[tank]\narea = 2.0\n[tanks.one.valve]\nwidth = 1.0\n"), common={"tanks": "tank"})


def above(text="", overrides=None, hidden=()):
    return Places(SourceText("mine.toml", text), overrides or {}, BASE, frozenset(hidden), BASE.common)


def test_a_key_that_is_taken_over_is_found_in_the_common_table():
    key, span, argument = above().resolve(("tanks", "one", "area"))
    assert (key, span.line, argument) == ("tank.area", 2, "")


def test_a_key_of_its_own_is_found_there():
    key, span, _ = above("[tanks.one]\narea = 3.0\n").resolve(("tanks", "one", "area"))
    assert (key, span.source.name, span.line) == ("tanks.one.area", "mine.toml", 2)


def test_without_a_common_table_the_nearest_parent_is_the_location():
    bare = Places(BASE.source)
    assert bare.resolve(("tanks", "one", "valve", "height"))[1].line == 3
    assert bare.resolve(("tanks", "two", "area"))[1] is None


def test_an_argument_of_the_command_line_is_the_location():
    places = above(overrides={"tank": "tank={}"})
    assert places.resolve(("tanks", "one", "area")) == ("tank.area", None, "tank={}")
    assert places.given("tank", "area")
    assert places.diagnostic("FZ904", "tank.area", "wrong").file == "--set tank={}"


def test_a_table_in_which_an_argument_gave_something_has_its_location():
    places = above(overrides={"tank.pump.power": "tank.pump.power=3"})
    assert places.resolve(("tanks", "one", "pump")) == ("tanks.one.pump", None, "tank.pump.power=3")
    assert places.resolve(("tanks", "one", "valve"))[1].line == 3


def test_what_is_replaced_has_no_location_below():
    width = ("tanks", "one", "valve", "width")
    assert above().resolve(width)[1].line == 4
    assert above(hidden=[width[:3]]).resolve(width)[1].line == 1


def test_a_suggestion_for_an_argument_is_the_whole_key():
    typed = above(overrides={"tank.aera": "tank.aera=1"})
    assert typed.did_you_mean("tank.aera", ["area"]) == "did you mean 'tank.area'?"
    assert above().did_you_mean("tank.aera", ["area"]) == "did you mean 'area'?"
