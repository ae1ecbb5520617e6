"""Terms, surfaces and curves as they are drawn, by their data and labels."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import fuzzyctl

THREE = "system t\n{}defuzzifier weighted_average\noutput u in [0, 1] else 0\n  terms p=0 q=1\nif a is hi then u is q\n"
THREE = THREE.format("".join(f"input {name} in [0, {k + 1}]\n  terms lo hi\n" for k, name in enumerate("abc")))
TREE = """system first
defuzzifier weighted_average
input a in [0, 1]
  terms low high
output x in [0, 1]
  terms small=0 large=1
table x = a
   low    high
 | small  large

controller tree
input a in [0, 1]
input b in [0, 2]
state n = 2
next n = n + a
output y = first(a) + 2 * n + b
every 10 ms
"""


@pytest.fixture
def system(base):
    return fuzzyctl.loads(base)


def test_each_term_is_a_line_that_reaches_its_peak(system):
    ax = fuzzyctl.plot.terms(system, "x")
    assert [np.max(line.get_ydata()) for line in ax.get_lines()] == [1, 1, 1]
    assert [t.get_text() for t in ax.texts] == ["N", "Z", "P"]
    assert ax.get_xlim() == (-1, 1)
    assert fuzzyctl.plot.terms(system, "y").get_xlabel() == "y [m]"


def test_every_variable_has_its_panel():
    panels = fuzzyctl.plot.terms(fuzzyctl.load("ais_reaction"))
    assert [a.get_xlabel() for a in panels] == ["σ*", "dσ*/dt [1/s]", "f"]


def test_the_lines_of_a_map_are_where_the_system_has_their_values(system):
    """Inputs of one range hide swapped axes; the function is not symmetric, so that a swap shows."""
    ax = fuzzyctl.plot.surface(system, "y", "x", resolution=81, ax=Figure().add_subplot())
    lines = ax.collections[-1]
    points = [(level, *v) for level, path in zip(lines.levels, lines.get_paths(), strict=True) for v in path.vertices]
    assert len(points) > 100
    for level, y, x in points[::9]:
        assert system(x=x, y=y) == pytest.approx(level, abs=0.05)


def test_a_curve_is_at_mid_range_of_other_inputs_or_at_their_values(system):
    for at, y in (({}, 5.0), ({"y": 2.0}, 2.0)):
        ax = fuzzyctl.plot.surface(system, "x", at={"y": y} if at else {"y": 5.0}, resolution=5)
        x, u = ax.lines[0].get_data()
        assert u[1] == pytest.approx(system(x=x[1], y=y), rel=1e-12)
    ax = fuzzyctl.plot.surface(fuzzyctl.loads(THREE), "a", "b", resolution=2)
    assert "c = 1.5" in ax.get_title()


def test_labels_name_variable_and_unit(system):
    ax = system.plot(resolution=5)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x", "y [m]")
    solid = fuzzyctl.plot.surface(system, resolution=3, ax=Figure().add_subplot(projection="3d"))
    assert solid.get_zlabel() == "u"


@pytest.mark.parametrize(
    ("x", "y", "fixed", "axes"),
    [
        (None, None, {}, ["a", "b"]),
        ("b", None, {}, ["b", "a"]),
        ("b", None, {"a": 1, "c": 1}, ["b"]),
        (None, None, {"a": 1}, ["b", "c"]),
        ("c", "a", {}, ["c", "a"]),
        (None, "a", {}, ["b", "a"]),
    ],
)
def test_named_axes_come_first(x, y, fixed, axes):
    ax = fuzzyctl.plot.surface(fuzzyctl.loads(THREE), x, y, at=fixed, resolution=2)
    assert [ax.get_xlabel(), ax.get_ylabel()][: len(axes)] == axes


def test_a_controller_is_drawn_at_its_start_or_another_state():
    tree = fuzzyctl.loads(TREE, block="tree")
    x, y = fuzzyctl.plot.surface(tree, "a", at={"b": 1}).lines[0].get_data()
    expected = fuzzyctl.compile(tree, "python").batch(np.column_stack([x, np.ones_like(x)]))[0]
    np.testing.assert_allclose(y, expected)
    other = fuzzyctl.plot.surface(tree, "a", at={"b": 1}, state={"n": 5}).lines[0].get_ydata()
    np.testing.assert_allclose(y + 6, other)
    assert [ax.get_xlabel() for ax in fuzzyctl.plot.terms(tree)] == ["a", "x"]
    assert fuzzyctl.plot.terms(tree, "a").get_xlabel() == "a"
