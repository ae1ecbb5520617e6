"""Tables: the names of columns decide, not where they are, and results keep the index of rows."""

from collections import namedtuple

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest

from fuzzyctl import ArgumentError, Controller, UnknownNameError, load, loads
from fuzzyctl import compile as compile_system

BACKENDS = ["python", "numpy", "numba"]
VALUES = {"food": [10.0, 0.0, 3.0], "service": [2.0, 9.0, 7.0]}

ADAPTIVE = """system s
input a in [0, 1]
  terms low high
input b in [0, 1]
  terms low high
output y in [0, 1] adaptive rate a
  terms no yes
defuzzifier center_average
table y = a x b
         low  high
  low  | no   no
  high | no   yes
"""


class Columns:
    """A table of the form that polars has: a list of names and columns by name, but no keys."""

    def __init__(self, values):
        self.values = values
        self.columns = list(values)

    def __getitem__(self, name):
        return np.array(self.values[name])


class NamedAxes:
    """An array of the form that DataArrays of xarray have: names of axes, and labels along some of them."""

    def __init__(self, values, dims, **labels):
        self.values, self.dims, self.indexes = np.asarray(values), tuple(dims), labels
        self.shape = self.values.shape

    def __array__(self, dtype=None, copy=None):
        return np.array(self.values, dtype=dtype)

    def __getitem__(self, key):
        assert not isinstance(key, str)
        kept = self.dims[:-1] if isinstance(key, tuple) and isinstance(key[-1], int) else self.dims
        return NamedAxes(self.values[key], kept, **{d: self.indexes[d] for d in kept if d in self.indexes})


def labelled(values):
    return NamedAxes(np.array(list(values.values())).T, ("time", "columns"), columns=list(values), time=[4, 5, 6])


def structured(values):
    found = np.zeros(3, dtype=[(name, float) for name in values])
    for name, column in values.items():
        found[name] = column
    return found


TABLES = {
    "a data frame": pd.DataFrame,
    "a dict of lists": dict,
    "a dict of arrays": lambda values: {n: np.array(v) for n, v in values.items()},
    "a dict of Series": lambda values: {n: pd.Series(v) for n, v in values.items()},
    "a structured array": structured,
    "a record array": lambda values: structured(values).view(np.recarray),
    "a table of Arrow": pa.table,
    "names and columns": Columns,
    "an array with labels along its last axis": labelled,
}


@pytest.fixture
def kernel(tipper):
    return compile_system(tipper, "numpy")


@pytest.mark.parametrize("form", TABLES)
class TestBatch:
    def test_takes_columns_by_name_in_any_order(self, kernel, form):
        expected = kernel.batch(np.array([VALUES["service"], VALUES["food"]]).T).tolist()
        assert kernel.batch(TABLES[form](VALUES)).tolist() == expected
        assert kernel.batch(TABLES[form](dict(reversed(VALUES.items())))).tolist() == expected

    def test_reports_each_column_that_is_no_input_and_each_that_is_missing(self, kernel, form):
        with pytest.raises(ArgumentError, match="no input 'day'"):
            kernel.batch(TABLES[form](VALUES | {"day": [1.0, 2.0, 3.0]}))
        with pytest.raises(ArgumentError, match="a column is missing for: 'service'"):
            kernel.batch(TABLES[form]({"food": VALUES["food"]}))
        misspelt = {"serivce": VALUES["service"], "food": VALUES["food"], "day": [1.0, 2.0, 3.0]}
        expected = (
            r"exactly the inputs service, food; no input 'serivce' \(did you mean 'service'\?\); no input 'day'; "
            r"a column is missing for: 'service'"
        )
        with pytest.raises(ArgumentError, match=expected):
            kernel.batch(TABLES[form](misspelt))


class TestOtherForms:
    def test_a_row_is_one_point(self, kernel):
        frame = pd.DataFrame(VALUES)
        assert kernel.batch(frame.iloc[0]).tolist() == kernel(2.0, 10.0) == kernel(**frame.iloc[0])
        assert kernel.batch({"food": 10.0, "service": 2.0}).tolist() == kernel(2.0, 10.0)

    def test_a_series_of_many_rows_is_no_point_and_the_message_stays_short(self, kernel):
        expected = (
            "points with named columns must have exactly the inputs service, food; no input 0; no input 1; no input 2; "
            "no input 3; no input 4; and 995 more; a column is missing for: 'service', 'food'; "
            "a Series is one point, and its labels are the inputs: several are a data frame"
        )
        with pytest.raises(ArgumentError) as raised:
            kernel.batch(pd.Series(np.zeros(1000)))
        assert str(raised.value) == expected

    def test_an_array_without_labels_is_taken_by_position(self, kernel):
        points = NamedAxes([[2.0, 10.0], [9.0, 0.0]], ("time", "input"), time=[0, 1])
        assert kernel.batch(points).tolist() == kernel.batch(points.values).tolist()

    def test_inputs_along_another_axis_are_refused(self, kernel):
        points = NamedAxes(np.zeros((2, 2)), ("input", "time"), input=["food", "service"], time=[0, 1])
        with pytest.raises(ArgumentError, match="must label the last axis of points, got them on axis 'input'"):
            kernel.batch(points)

    def test_columns_with_other_axes_or_labels_are_refused(self, kernel):
        food = NamedAxes([1.0, 2.0], ["time"], time=[0, 1])
        with pytest.raises(ArgumentError, match="'service' and 'food' have different axes: place and time"):
            kernel.batch({"food": food, "service": NamedAxes([1.0, 2.0], ["place"])})
        with pytest.raises(ArgumentError, match="different labels along 'time'"):
            kernel.batch({"food": food, "service": NamedAxes([1.0, 2.0], ["time"], time=[1, 2])})
        assert kernel.batch({"food": food, "service": food}).shape == (2,)
        assert kernel.batch({"food": food, "service": NamedAxes(2.0, [])}).shape == (2,)

    def test_a_column_that_occurs_twice_is_refused(self, kernel):
        with pytest.raises(ArgumentError, match="column 'food' occurs 2 times"):
            kernel.batch(pd.DataFrame(VALUES)[["food", "service", "food"]])

    @pytest.mark.parametrize(
        "records",
        [
            pd.DataFrame(VALUES).to_dict("records"),
            list(pd.DataFrame(VALUES).itertuples(index=False)),
            [row for _, row in pd.DataFrame(VALUES).iterrows()],
            namedtuple("Point", ["food", "service"])(10.0, 2.0),
        ],
        ids=["dicts", "named tuples", "rows", "a named tuple"],
    )
    def test_records_are_refused_since_a_list_of_them_is_an_array_by_position(self, kernel, records):
        with pytest.raises(ArgumentError, match="records, whose names would be ignored"):
            kernel.batch(records)

    def test_a_column_that_is_no_number_is_named(self, kernel):
        with pytest.raises(ArgumentError, match="input 'food' must be an array of real numbers"):
            kernel.batch(pd.DataFrame(VALUES | {"food": ["a", "b", "c"]}))

    def test_names_with_accents_have_one_form(self):
        system = loads(
            "system s\ninput é in [0, 1]\n  terms a b\noutput y in [0, 1]\n  terms c d\ntable y = é\n"
            "      a  b\n   |  c  d\ndefuzzifier weighted_average\n"
        )
        assert compile_system(system, "python").batch({"e\u0301": [0.25]}).tolist() == [0.25]

    @pytest.mark.parametrize("backend", BACKENDS)
    def test_adaptive_systems_take_columns_by_name(self, backend):
        kernel = compile_system(loads(ADAPTIVE), backend)
        frame = pd.DataFrame({"b": [0.25, 0.5], "a": [0.75, 1.0]})
        state = kernel.start()
        assert kernel.batch(frame, state).tolist() == kernel.batch(frame[["a", "b"]].to_numpy(), state).tolist()

    def test_a_state_and_results_have_no_columns(self):
        kernel = compile_system(loads(ADAPTIVE), "numpy")
        frame = pd.DataFrame(np.zeros((1, 4)))
        with pytest.raises(ArgumentError, match=r"exactly the states y\[1\], .* no state 0"):
            kernel.batch([[0.5, 0.5]], frame)
        with pytest.raises(ArgumentError, match="results must be an array, got a table"):
            kernel.next_state(kernel.start(), pd.DataFrame({"y": [1.0]}))


class TestCallsByName:
    """`system(**frame)` gives one Series for each input, by name."""

    def test_a_column_too_many_and_one_that_is_missing_are_named(self, tipper):
        frame = pd.DataFrame(VALUES)
        with pytest.raises(UnknownNameError, match="no input 'day'"):
            tipper(**frame.assign(day=1.0))
        with pytest.raises(ArgumentError, match="missing for: service"):
            tipper(**frame[["food"]])

    def test_series_with_other_row_labels_are_not_combined_by_position(self, tipper):
        frame = pd.DataFrame(VALUES)
        with pytest.raises(ArgumentError, match="'service' and 'food' have different row labels"):
            tipper(service=frame["service"], food=frame["food"][::-1])
        with pytest.raises(ArgumentError, match="'service' and 'food' have different row labels"):
            compile_system(tipper, "numpy").batch({"service": frame["service"], "food": frame["food"][::-1]})
        shapes = r"they have the shapes service \(3,\), food \(2,\)"
        with pytest.raises(ArgumentError, match=shapes):
            tipper(service=frame["service"], food=np.zeros(2))
        turned = tipper(service=frame["service"], food=frame["food"].to_numpy()[::-1])
        assert turned[0] == pytest.approx(tipper(service=2.0, food=3.0), rel=1e-12)

    @pytest.mark.parametrize("form", [pd.DataFrame, pa.table, structured])
    def test_a_table_for_one_input_is_refused(self, tipper, form):
        with pytest.raises(ArgumentError, match="input 'service' must be an array"):
            tipper(service=form(VALUES), food=8)


# --- results --------------------------------------------------------------------------------------------------------


FRAME = pd.DataFrame({"food": [10.0, 0.0, 3.0], "service": [2.0, 9.0, 7.0]}, index=["a", "b", "c"])


TWO = """system two
input x in [0, 1]
  terms low high
output u in [0, 1]
  terms a=0 b=1
output v in [0, 1]
  terms a=0 b=1
defuzzifier weighted_average
if x is low then u is a, v is b
if x is high then u is b, v is a
"""


def plain(system):
    return compile_system(system, "numpy").batch(FRAME[["service", "food"]].to_numpy())


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_frame_gives_a_series_with_its_index(tipper, backend):
    found = compile_system(tipper, backend).batch(FRAME)
    pd.testing.assert_series_equal(found, pd.Series(plain(tipper), FRAME.index, name="tip"), rtol=1e-12)


@pytest.mark.parametrize(
    "given", [dict(FRAME.items()), {"food": FRAME.food, "service": [2.0, 9.0, 7.0]}], ids=["series", "one series"]
)
def test_series_by_name_do_too(tipper, given):
    expected = pd.Series(plain(tipper), FRAME.index, name="tip")
    pd.testing.assert_series_equal(compile_system(tipper, "numpy").batch(given), expected)
    pd.testing.assert_series_equal(tipper(**given), expected)


def test_several_outputs_are_columns():
    two = loads(TWO)
    frame = pd.DataFrame({"x": [0.0, 0.25]}, index=[7, 9])
    found = compile_system(two, "numpy").batch(frame)
    pd.testing.assert_frame_equal(found, pd.DataFrame({"u": [0.0, 0.25], "v": [1.0, 0.75]}, index=[7, 9]))
    by_name = two(x=frame.x)
    assert {n: list(s.index) for n, s in by_name.items()} == {"u": [7, 9], "v": [7, 9]}
    assert by_name["v"].name == "v"


def test_free_numbers_take_frames(tipper):
    kernel = compile_system(tipper, "numpy", free=["tip.cheap.peak"])
    values = kernel.start()
    assert list(kernel.batch(FRAME, values).index) == ["a", "b", "c"]
    assert list(kernel.degrees(FRAME, values)["food"]["rancid"].index) == ["a", "b", "c"]
    assert list(kernel.strengths(FRAME, values).index) == ["a", "b", "c"]
    assert list(kernel.gradient(FRAME, values)["food"].index) == ["a", "b", "c"]
    assert list(kernel.gradient(FRAME, values, by="state").columns) == ["tip.cheap.peak"]


def test_degrees_strengths_and_gradients_of_a_frame_keep_its_index(tipper):
    kernel = compile_system(tipper, "python")
    array = FRAME[["service", "food"]].to_numpy()
    degrees = kernel.degrees(FRAME)["food"]["delicious"]
    pd.testing.assert_series_equal(
        degrees, pd.Series(kernel.degrees(array)["food"]["delicious"], FRAME.index, name="delicious")
    )
    pd.testing.assert_frame_equal(kernel.strengths(FRAME), pd.DataFrame(kernel.strengths(array), FRAME.index))
    gradient = pd.DataFrame(kernel.gradient(array), FRAME.index, columns=["service", "food"])
    pd.testing.assert_frame_equal(kernel.gradient(FRAME), gradient)


class TestSteps:
    """A controller with a state: its columns are matched by name, in any order, and results keep the index."""

    INPUTS = pd.DataFrame({"level": [0.2, 0.7, 0.4], "reference": [1.0, 0.5, 0.5]}, index=[0.0, 0.1, 0.2])

    @pytest.fixture
    def step(self):
        return compile_system(load("water_tank", block=Controller), "python")

    def test_a_run_over_a_frame_gives_a_series(self, step):
        found, state = step.run(self.INPUTS)
        expected, after = step.run(self.INPUTS[list(step.input_names)].to_numpy())
        pd.testing.assert_series_equal(found, pd.Series(expected, self.INPUTS.index, name="valve"))
        assert (state == after).all()

    def test_a_batch_gives_states_as_it_got_them(self, step):
        states = np.tile(step.start(), (3, 1)) + np.arange(3.0)[:, np.newaxis]
        expected, after = step.batch(self.INPUTS[list(step.input_names)].to_numpy(), states)
        found, arrays = step.batch(self.INPUTS, states)
        pd.testing.assert_series_equal(found, pd.Series(expected, self.INPUTS.index, name="valve"))
        assert type(arrays) is np.ndarray
        frame = pd.DataFrame(states, self.INPUTS.index, columns=list(step.state_names))
        _, kept = step.batch(self.INPUTS, frame[list(reversed(step.state_names))])
        pd.testing.assert_frame_equal(kept, pd.DataFrame(after, frame.index, columns=frame.columns))

    def test_other_names_and_other_rows_are_refused(self, step):
        states = np.tile(step.start(), (3, 1))
        with pytest.raises(ArgumentError, match=r"^points with named .* no input 'levl' \(did you mean 'level'"):
            step.run(self.INPUTS.rename(columns={"level": "levl"}))
        frame = pd.DataFrame(states, self.INPUTS.index, columns=[*step.state_names[:-1], "last"])
        with pytest.raises(ArgumentError, match=r"exactly the states .* no state 'last'"):
            step.batch(self.INPUTS, frame)
        with pytest.raises(ArgumentError, match="'points' and 'state' have different row labels"):
            step.batch(self.INPUTS, pd.DataFrame(states, columns=list(step.state_names)))
