"""Tables of results by column."""

import csv
import math

from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl.experiments.results.columns import columns_of, write_csv


def test_a_column_has_one_type():
    rows = [{"a": 1, "b": None, "c": "x"}, {"a": 2.5, "c": 1.5}, {"a": 3, "b": 0.5, "c": True}]
    found = columns_of(rows)
    assert found["a"] == [1.0, 2.5, 3.0]
    assert {type(value) for value in found["a"]} == {float}
    assert found["b"] == [None, None, 0.5]
    assert found["c"] == ['"x"', "1.5", "true"]


@given(values=st.lists(st.one_of(st.none(), st.floats())))
def test_numbers_read_back_bit_for_bit(tmp_path_factory, values):
    path = tmp_path_factory.mktemp("csv") / "table.csv"
    write_csv(path, {"run": list(range(len(values))), "x": values})
    with path.open(newline="", encoding="utf-8") as file:
        read = [float(row["x"]) if row["x"] else None for row in csv.DictReader(file)]
    for value, found in zip(values, read, strict=True):
        assert found == value or (math.isnan(value) and math.isnan(found))
        assert value is None or math.copysign(1.0, found) == math.copysign(1.0, value) or math.isnan(value)
