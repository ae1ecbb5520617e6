import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl.experiments.settings.overrides import join_key, split_key


class TestKeys:
    @given(
        st.lists(st.text(st.characters(exclude_categories=["C", "Zl", "Zp"], exclude_characters="\"'\\"), min_size=1))
    )
    def test_parts_come_back(self, parts):
        assert split_key(join_key(parts)) == (parts or [""])

    @pytest.mark.parametrize("key", ['a."b', "a=b", "a.'b"])
    def test_what_is_no_dotted_key_is_one_part(self, key):
        assert split_key(key) == [key]
