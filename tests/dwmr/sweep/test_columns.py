"""Columns of what is kept of a run, and the tables of a comparison that show those of the safety filter."""

import io

from rich.console import Console

from dwmr.sweep import comparison
from dwmr.sweep.comparison import Entry, print_comparison
from dwmr.sweep.robots import columns_of, unit_of

MEASURES = {
    "stopped": None, "t_end": 9.0,
    "safety": {
        "acts": {"a": 0.25, "b": 0.5, "c": 0.0}, "disc_gap": {"a": 0.1, "b": 0.1, "c": None},
        "infeasible": [{"robot": "a", "with": "obstacles.0"}, {"robot": "b", "with": "a"}],
        "missed": [{"robot": "b", "with": "obstacles.1"}],
    },
}  # fmt: skip


def row(measures):
    return dict(columns_of(measures, ("safety",), ("a", "b", "c")))


def test_moments_of_the_filter_are_counted_for_each_robot_that_they_concern():
    found = row(MEASURES)
    assert [found[f"safety.infeasible.{robot}"] for robot in "abc"] == [2, 1, 0]
    assert [found[f"safety.missed.{robot}"] for robot in "abc"] == [0, 1, 0]
    assert (found["safety.acts.b"], found["safety.disc_gap.a"], found["safety.disc_gap.c"]) == (0.5, 0.1, None)
    assert unit_of("safety.disc_gap.a") == "m"
    assert unit_of("safety.acts.a") == unit_of("safety.missed.a") == ""


def test_a_run_without_a_filter_has_no_columns_of_it():
    assert not any(name.startswith("safety") for name in row({"stopped": None, "t_end": 9.0}))


def test_a_comparison_has_a_table_of_the_filter_where_there_is_one():
    names = [measure.replace(".*", "") for measure in comparison.FILTER]
    values = dict(zip(names, (0.125, 0.5, 2.0, 0.0), strict=True))
    found = [Entry("guarded", "smc", "a", name, "-", 1, value, None, None, 0) for name, value in values.items()]
    found += [Entry(name, "smc", "a", "rmse.x_e", "m", 1, 1.0, None, None, 0) for name in ("guarded", "open")]
    text = io.StringIO()
    print_comparison(Console(file=text, width=100), found, 1)
    assert "guarded: safety filter" in text.getvalue()
    assert "0.125    50.0          2       0" in text.getvalue()
    assert "open: safety filter" not in text.getvalue()
