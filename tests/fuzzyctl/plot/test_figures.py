"""Public plots: data and axes in, axes out, and pyplot not involved."""

import dataclasses
import math
import re
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

import fuzzyctl


@pytest.fixture(scope="module")
def tipper():
    return fuzzyctl.load("tipper")


@pytest.fixture(scope="module")
def run():
    loop = fuzzyctl.load("pendulum", block=fuzzyctl.Loop)
    return fuzzyctl.simulate(loop, backend="python", GE=3)


PLOTS = {
    "surface": lambda s, r, **ax: s.plot(resolution=5, **ax),
    "curve": lambda s, r, **ax: fuzzyctl.plot.surface(s, "food", at={"service": 3}, resolution=5, **ax),
    "kernel": lambda s, r, **ax: fuzzyctl.plot.surface(fuzzyctl.compile(s, "numpy"), resolution=5, **ax),
    "one variable": lambda s, r, **ax: fuzzyctl.plot.terms(s, "food", **ax),
    "terms": lambda s, r, **ax: fuzzyctl.plot.terms(s, **ax),
    "rules": lambda s, r, **ax: fuzzyctl.plot.rules(s, {"service": 7}, food=8, most=2, **ax),
    "run": lambda s, r, **ax: r.plot(**ax),
    "runs": lambda s, r, **ax: fuzzyctl.plot.runs(r, r, labels=["a", "b"], **ax),
}


@pytest.mark.parametrize("name", PLOTS)
class TestEachPlot:
    def test_a_notebook_shows_what_it_returns(self, tipper, run, name):
        found = PLOTS[name](tipper, run)
        assert found._repr_png_().startswith(b"\x89PNG")
        if isinstance(found, tuple):
            assert len(found) > 2
            assert "<svg" in found._repr_svg_()

    def test_it_draws_in_the_axes_given(self, tipper, run, name):
        figure = Figure(figsize=(8, 8))
        left, right = figure.subplots(1, 2)
        found = PLOTS[name](tipper, run, ax=right)
        if isinstance(found, tuple):
            assert right not in figure.axes  # the panels take its place
            assert all(ax.get_figure(root=True) is figure for ax in found)
        else:
            assert found is right
            assert found.has_data()
        assert not left.has_data()
        figure.draw_without_rendering()

    def test_what_are_no_axes_is_refused(self, tipper, run, name):
        with pytest.raises(fuzzyctl.ArgumentError, match="'ax' must be axes of matplotlib, or None, got Figure"):
            PLOTS[name](tipper, run, ax=Figure())


def test_axes_of_three_dimensions_take_a_surface_and_others_a_map(tipper):
    figure = Figure()
    solid, flat = figure.add_subplot(1, 2, 1, projection="3d"), figure.add_subplot(1, 2, 2)
    assert tipper.plot(ax=solid, resolution=3).get_zlabel() == "Tip [%]"
    assert tipper.plot(ax=flat, resolution=3).get_ylabel() == "Food"


def test_labels_are_no_formulas_in_the_figure_of_a_caller(tipper):
    food = dataclasses.replace(tipper.input("food"), label="$\\frac{$")
    system = dataclasses.replace(tipper, inputs=(tipper.inputs[0], food))
    figure = Figure()
    ax = fuzzyctl.plot.surface(system, "food", at={"service": 3}, resolution=3, ax=figure.subplots())
    figure.draw_without_rendering()
    assert ax.get_xlabel() == "$\\frac{$"


def test_powers_of_ten_along_an_axis_are_formulas(tipper):
    food = tipper.input("food")
    food = dataclasses.replace(food, lower=fuzzyctl.build.expression(0.1), label="$\\frac{$")
    ax = Figure().subplots()
    ax.set_xscale("log")
    fuzzyctl.plot.terms(dataclasses.replace(tipper, inputs=(tipper.inputs[0], food)), "food", ax=ax)
    ax.figure.draw_without_rendering()
    assert "$" in ax.get_xticklabels()[1].get_text()
    assert all(label.get_parse_math() for label in ax.get_xticklabels())
    assert not ax.xaxis.label.get_parse_math()


@pytest.mark.parametrize("number", [np.int64(3), np.float32(3), np.array(3), True + 2])
def test_any_real_number_is_a_value_of_an_input(tipper, number):
    assert tipper.plot("food", at={"service": number}, resolution=2).get_title().endswith("(Service = 3)")


def test_a_row_of_a_frame_is_a_point(tipper):
    row = pd.Series({"food": 8.0, "service": 7.0})
    assert fuzzyctl.why(tipper, row).outputs == fuzzyctl.why(tipper, food=8, service=7).outputs
    assert tipper.plot("food", at=row[["service"]], resolution=2).get_title().endswith("(Service = 7)")


def test_where_nothing_is_finite_the_picture_says_so():
    text = "system n\ninput x in [0, 1]\n  low = triangle(0, 0, 0.2)\noutput u in [0, 1] else nan\n  terms a=0 b=1\n"
    system = fuzzyctl.loads(
        f"{text}input z in [0, 1]\n  terms low high\ndefuzzifier weighted_average\nif x is low then u is b\n"
    )
    assert [t.get_text() for t in system.plot("z", at={"x": 0.9}).texts] == ["u has no finite value here"]
    assert not list(system.plot("x", at={"z": 0.5}).texts)
    assert system.plot(resolution=5)._repr_png_()


@pytest.mark.parametrize(
    ("call", "part"),
    [
        (lambda s: s.plot("foo"), "no input 'foo'"),
        (lambda s: s.plot(3), "the name of an input must be a text, got int"),
        (lambda s: s.plot("food", "food"), "'food' is named for both axes"),
        (lambda s: s.plot(output="tpi"), "did you mean 'tip'"),
        (lambda s: s.plot("food", at={"food": 1}), "'food' is an axis and has a value"),
        (lambda s: s.plot(at={"food": math.nan}), "input 'food' must be a number that is not NaN"),
        (lambda s: s.plot(at={"food": 1, "service": 1}), "all inputs have values"),
        (lambda s: s.plot(at={"food": "3"}), "input 'food' must be a real number, got str"),
        (lambda s: s.plot(at={"food": 10**400}), "input 'food' must be within the range of floats"),
        (lambda s: s.plot(at=pd.DataFrame({"food": [1]})), "'at' must be numbers by name of the input, got DataFrame"),
        (lambda s: fuzzyctl.why(s, food=10**400, service=1), "input 'food' must be within the range of floats"),
        (lambda s: s.plot(at=3), "'at' must be numbers by name of the input, got int"),
        (lambda s: s.plot(resolution=1), "'resolution' must be from 2 to 2001, got 1"),
        (lambda s: s.plot(resolution=2.5), "'resolution' must be an integer, got float"),
        (lambda s: fuzzyctl.plot.surface("tipper.fz"), "must be a FuzzySystem, a Controller or a Kernel, got str"),
        (lambda s: fuzzyctl.plot.terms(s, "fod"), "no variable with terms 'fod'"),
        (lambda s: fuzzyctl.plot.terms(s, ax=Figure().add_axes((0, 0, 1, 1))), "must be one of the subplots"),
        (lambda s: fuzzyctl.plot.rules(s, service=1, food=1, most=0), "'most' must be from 1 to 100, got 0"),
        (lambda s: fuzzyctl.plot.runs(), "at least one run must be given"),
        (lambda s: fuzzyctl.plot.runs(s), "a run must be a Run, got FuzzySystem"),
    ],
)
def test_mistakes_are_named(tipper, call, part):
    with pytest.raises(fuzzyctl.FuzzyctlError, match=re.escape(part)):
        call(tipper)


def test_runs_need_a_label_each(run):
    with pytest.raises(fuzzyctl.ArgumentError, match="'labels' must have one label for each of 1 runs, got 2"):
        fuzzyctl.plot.runs(run, labels=["a", "b"])


def test_a_kernel_gives_the_surface_of_its_system(tipper):
    of_system, of_kernel = (
        fuzzyctl.plot.surface(s, "food", at={"service": 3}).get_lines()[0].get_ydata()
        for s in (tipper, fuzzyctl.compile(tipper, "python"))
    )
    assert np.array_equal(of_system, of_kernel)


def test_neither_repr_nor_import_loads_matplotlib_and_no_plot_loads_pyplot():
    code = """
import sys, fuzzyctl
system = fuzzyctl.load("tipper")
repr(system), str(system), system._repr_html_(), dir(fuzzyctl.plot)
assert "matplotlib" not in sys.modules
before = None
system.plot(resolution=3)
import matplotlib
assert "matplotlib.pyplot" not in sys.modules
assert not matplotlib.rcParams["axes.grid"]
"""
    subprocess.run([sys.executable, "-c", code], check=True)
