"""Scenarios in layers, of an application of tanks."""

import pytest

from fuzzyctl import DiagnosticError
from fuzzyctl.experiments.scenario_layers import Shipped, UnknownScenarioError, merge, overlay, read_layers


@pytest.fixture
def shipped(tmp_path):
    """The shipped scenarios of an application: one, named 'small'."""
    folder = tmp_path / "shipped"
    folder.mkdir()
    (folder / "small.toml").write_text("[tank]\narea = 2.0\nlevel = 1.0\n[tanks.one]\n", encoding="utf-8")
    return Shipped(folder, "begin one with 'tanks new'", {"tanks": "tank"})


def written(tmp_path, text, name="mine.toml"):
    (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path / name


def mistake(path, shipped):
    with pytest.raises(DiagnosticError) as caught:
        read_layers(path, shipped)
    (found,) = caught.value.diagnostics
    return found


class TestShipped:
    def test_is_found_by_name_and_files_by_path(self, tmp_path, shipped):
        assert shipped.names() == ("small",)
        assert shipped.find("small") == shipped.path("small")
        path = written(tmp_path, "")
        assert shipped.find(str(path)) == path

    @pytest.mark.parametrize("name", ["smal", "a" * 300, "a\0b"])
    def test_an_unknown_name_is_reported_with_those_that_exist(self, shipped, name):
        with pytest.raises(UnknownScenarioError, match="neither a file nor one of the shipped scenarios: small"):
            shipped.find(name)

    def test_the_nearest_name_is_suggested(self, shipped):
        with pytest.raises(UnknownScenarioError, match="did you mean 'small'"):
            shipped.find("smal")


class TestLayers:
    def test_lie_over_the_shipped_scenario_that_is_extended(self, tmp_path, shipped):
        path = written(tmp_path, 'extends = "small"\n[tank]\nlevel = 3.0\n')
        layers = read_layers(path, shipped)
        assert [layer.path for layer in layers] == [path, shipped.path("small")]
        data, places = merge(layers, {}, shipped.common)
        assert data == {"tank": {"area": 2.0, "level": 3.0}, "tanks": {"one": {}}}
        assert places.diagnostic("FZ904", "tank.area", "x").span.line == 2
        assert places.diagnostic("FZ904", "tank.level", "x").span.line == 3

    def test_an_empty_file_is_answered_with_the_way_to_begin_one(self, tmp_path, shipped):
        assert mistake(written(tmp_path, ""), shipped).help == "begin one with 'tanks new'"

    def test_an_unknown_base_is_reported_at_its_line(self, tmp_path, shipped):
        found = mistake(written(tmp_path, '\nextends = "smal"\n'), shipped)
        assert (found.span.line, found.help) == (2, "did you mean 'small'?")

    def test_a_circle_is_reported(self, tmp_path, shipped):
        written(tmp_path, 'extends = "mine.toml"\n', "base.toml")
        assert "in a circle" in mistake(written(tmp_path, 'extends = "base.toml"\n'), shipped).message


class TestOverlay:
    def test_shares_nothing_that_could_change(self):
        below, above = {"a": {"b": [1]}}, {"c": {"d": [2]}}
        merged = overlay(below, above)
        merged["a"]["b"].append(3)
        merged["c"]["d"].append(3)
        assert (below, above) == ({"a": {"b": [1]}}, {"c": {"d": [2]}})

    def test_a_table_of_another_kind_replaces(self):
        below, above = {"a": {"kind": "x", "b": 1}}, {"a": {"kind": "y"}}
        assert overlay(below, above) == {"a": {"kind": "y"}}
        assert overlay(below, {"a": {"c": 2}}) == {"a": {"kind": "x", "b": 1, "c": 2}}


class TestPlaces:
    """A table of `tanks` takes over what the common table `tank` says."""

    @pytest.mark.parametrize(
        ("path", "arguments", "key", "line", "argument"),
        [
            (("tanks", "one", "area"), {}, "tank.area", 2, ""),
            (("tanks", "one", "valve", "width"), {}, "tanks.one.valve.width", 4, ""),
            (("tanks", "one", "valve", "height"), {}, "tanks.one.valve.height", 3, ""),
            (("tanks", "two", "area"), {}, "tank.area", 2, ""),
            (("pumps", "two", "area"), {}, "pumps.two.area", None, ""),
            (("tanks", "one", "area"), {"tank": "tank={}"}, "tank.area", None, "tank={}"),
            (("tanks", "one", "pump"), {"tank.pump.x": "tank.pump.x=3"}, "tanks.one.pump", None, "tank.pump.x=3"),
        ],
    )  # fmt: skip
    def test_of_a_key_are_its_own_the_common_or_the_nearest(self, tmp_path, path, arguments, key, line, argument):
        shipped = Shipped(tmp_path, "", {"tanks": "tank"})
        own = written(tmp_path, "[tank]\narea = 2.0\n[tanks.one.valve]\nwidth = 1.0\n")
        _, places = merge(read_layers(own, shipped), arguments, shipped.common)
        found, span, given = places.resolve(path)
        assert (found, span.line if span else None, given) == (key, line, argument)

    def test_of_what_is_replaced_are_none_below(self, tmp_path, shipped):
        written(tmp_path, '[tanks.one.valve]\nkind = "a"\nwidth = 1.0\n', "base.toml")
        own = written(tmp_path, 'extends = "base.toml"\n[tanks.one.valve]\nkind = "b"\n')
        _, places = merge(read_layers(own, shipped), {}, shipped.common)
        assert places.resolve(("tanks", "one", "valve", "width"))[1].source.name == str(own)

    def test_suggest_the_whole_key_for_an_argument(self, tmp_path, shipped):
        layers = read_layers(written(tmp_path, "[tank]\narea = 2.0\n"), shipped)
        for arguments, words in (({"tank.aera": "tank.aera=1"}, "'tank.area'"), ({}, "'area'")):
            _, places = merge(layers, arguments, shipped.common)
            assert places.did_you_mean("tank.aera", ["area"]) == f"did you mean {words}?"
