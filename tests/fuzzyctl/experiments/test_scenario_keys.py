"""Keys of scenarios: their locations, and values of the command line."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl.experiments.scenario_keys import join_key, key_places, literal, override, split_key


class TestKeys:
    @given(
        st.lists(st.text(st.characters(exclude_categories=["C", "Zl", "Zp"], exclude_characters="\"'\\"), min_size=1))
    )
    def test_parts_come_back(self, parts):
        assert split_key(join_key(parts)) == (parts or [""])

    @pytest.mark.parametrize("key", ['a."b', "a=b", "a.'b"])
    def test_what_is_no_dotted_key_is_one_part(self, key):
        assert split_key(key) == [key]


class TestLiteral:
    @pytest.mark.parametrize("value", [0.1, -1e-300, 1e22, 3, True, 'a"b\\c', [1, [2.5]], {"x": 1, "y z": "w"}])
    def test_a_literal_reads_back_as_the_value(self, value):
        data = {}
        override(data, f"key={literal(value)}")
        assert data["key"] == value
        assert type(data["key"]) is type(value)


TEXT = """\
name = "x"
[run]
dt = 0.1
"quoted key" = 1

[[obstacles]]
x = 1.0
[[obstacles]]
x = 2.0

[robots.leader]
friction.coulomb = 3
inline = { a = 1 }
"""


def line(path):
    start, _ = key_places(TEXT)[path]
    return TEXT[:start].count("\n") + 1


class TestKeyPlaces:
    def test_reads_keys_in_quotes_as_toml_does(self):
        text = '"esc\\u0061pe".x = 1\n[\'li\\teral\'."a\\"b=".c]\n"\'" = 2\n'
        assert list(key_places(text)) == [("escape", "x"), ("li\\teral", 'a"b=', "c"), ("li\\teral", 'a"b=', "c", "'")]

    def test_finds_keys_of_the_top_and_of_tables(self):
        assert line(("name",)) == 1
        assert line(("run", "dt")) == 3
        assert line(("run", "quoted key")) == 4

    def test_counts_arrays_of_tables(self):
        assert line(("obstacles", "0", "x")) == 7
        assert line(("obstacles", "1", "x")) == 9

    def test_finds_tables_themselves_and_dotted_keys(self):
        assert line(("robots", "leader")) == 11
        assert line(("robots", "leader", "friction", "coulomb")) == 12

    def test_knows_only_the_parent_of_a_key_in_an_inline_table(self):
        assert line(("robots", "leader", "inline")) == 13
        assert ("robots", "leader", "inline", "a") not in key_places(TEXT)
