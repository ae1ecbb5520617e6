import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl.experiments.settings.overrides import join_key, literal, override, split_key


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
