"""Results of data frames keep their index."""

import numpy as np
import pandas as pd
import pytest

import fuzzyctl
from fuzzyctl.kernels.backends.arguments import labelled
from fuzzyctl.support.shipped import rules_folder

FRAME = pd.DataFrame({"food": [10.0, 0.0, 3.0], "service": [2.0, 9.0, 7.0]}, index=["a", "b", "c"])
TWO = """system two
input x in [0, 1]
  terms low high
output u in [0, 1]
  terms a=0 b=1
output v in [0, 1]
  terms a=0 b=1
defuzzifier weighted_average
table u, v = x
  low  high
  a, b b, a
"""


@pytest.fixture(scope="module")
def tipper():
    return fuzzyctl.load(rules_folder() / "tipper.fz")


@pytest.fixture(scope="module")
def two():
    rules = "if x is low then u is a, v is b\nif x is high then u is b, v is a\n"
    return fuzzyctl.loads(TWO.partition("table")[0] + rules)


def plain(system):
    return fuzzyctl.compile(system, "numpy").batch(FRAME[["service", "food"]].to_numpy())


@pytest.mark.parametrize("backend", ["python", "numpy"])
def test_a_frame_gives_a_series_with_its_index(tipper, backend):
    found = fuzzyctl.compile(tipper, backend).batch(FRAME)
    pd.testing.assert_series_equal(found, pd.Series(plain(tipper), FRAME.index, name="tip"), rtol=1e-12)


@pytest.mark.parametrize(
    "given", [dict(FRAME.items()), {"food": FRAME.food, "service": [2.0, 9.0, 7.0]}], ids=["series", "one series"]
)
def test_series_by_name_do_too(tipper, given):
    expected = pd.Series(plain(tipper), FRAME.index, name="tip")
    pd.testing.assert_series_equal(fuzzyctl.compile(tipper, "numpy").batch(given), expected)
    pd.testing.assert_series_equal(tipper(**given), expected)


def test_a_number_beside_a_series_broadcasts(tipper):
    assert list(tipper(service=FRAME.service, food=3.0).index) == ["a", "b", "c"]


def test_several_outputs_are_columns(two):
    frame = pd.DataFrame({"x": [0.0, 0.25]}, index=[7, 9])
    found = fuzzyctl.compile(two, "numpy").batch(frame)
    pd.testing.assert_frame_equal(found, pd.DataFrame({"u": [0.0, 0.25], "v": [1.0, 0.75]}, index=[7, 9]))
    by_name = two(x=frame.x)
    assert {n: list(s.index) for n, s in by_name.items()} == {"u": [7, 9], "v": [7, 9]}
    assert by_name["v"].name == "v"


def test_free_numbers_take_frames(tipper):
    kernel = fuzzyctl.compile(tipper, "numpy", free=["tip.cheap.peak"])
    values = kernel.start()
    assert list(kernel.batch(FRAME, values).index) == ["a", "b", "c"]
    assert list(kernel.degrees(FRAME, values)["food"]["rancid"].index) == ["a", "b", "c"]
    assert list(kernel.strengths(FRAME, values).index) == ["a", "b", "c"]
    assert list(kernel.gradient(FRAME, values)["food"].index) == ["a", "b", "c"]
    assert list(kernel.gradient(FRAME, values, by="state").columns) == ["tip.cheap.peak"]


def test_arrays_rows_and_given_results_stay_as_they_are(tipper):
    kernel = fuzzyctl.compile(tipper, "numpy")
    assert type(kernel.batch(FRAME[["service", "food"]].to_numpy())) is np.ndarray
    assert kernel.batch(FRAME.iloc[0]).shape == ()
    out = np.empty(3)
    assert kernel.batch(FRAME, out=out) is out


def test_results_of_another_shape_have_no_row_labels():
    results = np.zeros((2, 3))
    assert labelled(results, ["u"], FRAME) is results
    assert labelled(np.zeros((3, 2, 2)), ["u", "v"], FRAME).shape == (3, 2, 2)


def test_degrees_strengths_and_gradients_of_a_frame_keep_its_index(tipper):
    kernel = fuzzyctl.compile(tipper, "python")
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
        text = rules_folder() / "loops" / "water_tank.fz"
        return fuzzyctl.compile(fuzzyctl.load(text, block=fuzzyctl.Controller), "python")

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
        with pytest.raises(
            fuzzyctl.ArgumentError, match=r"^points with named .* no input 'levl' \(did you mean 'level'"
        ):
            step.run(self.INPUTS.rename(columns={"level": "levl"}))
        frame = pd.DataFrame(states, self.INPUTS.index, columns=[*step.state_names[:-1], "last"])
        with pytest.raises(fuzzyctl.ArgumentError, match=r"exactly the states .* no state 'last'"):
            step.batch(self.INPUTS, frame)
        with pytest.raises(fuzzyctl.ArgumentError, match="'points' and 'state' have different row labels"):
            step.batch(self.INPUTS, pd.DataFrame(states, columns=list(step.state_names)))
