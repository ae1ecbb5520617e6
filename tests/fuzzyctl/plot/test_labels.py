"""Names over curves do not overlap."""

from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import fuzzyctl
from tests import sizes

#: Most names above each other at one place.
MOST = 6

CONSTANTS = """\
system s
defuzzifier weighted_average
input x in [0, 1]
  low = triangle(-inf, 0, 1)
  high = triangle(0, 1, inf)
output y in [-1, 1]
  terms f4=-0.18 f5=-0.19 f2=0.45 f3=0.04 f9=0.04
output z in [0, 1]
  f = function(x / 2)
  g = linear(1, 2)
if x is low then y is f4, z is f
if x is high then y is f5, z is g
"""


def drawn(text, output="y"):
    """Return the axes of an output's terms, and the boxes of their names."""
    figure = Figure(figsize=(7.5, 2.6), layout="constrained")
    FigureCanvasAgg(figure)
    ax = fuzzyctl.plot.terms(fuzzyctl.loads(text), output, ax=figure.subplots())
    figure.canvas.draw()
    return ax, [t.get_window_extent() for t in ax.texts]


def overlapping(boxes):
    return [(a, b) for k, a in enumerate(boxes) for b in boxes[:k] if a.overlaps(b)]


@settings(max_examples=sizes.examples(30, 8), deadline=None)
@given(st.lists(st.floats(-1, 1), min_size=1, max_size=MOST), st.sampled_from(["i", "ab", "WWWWW"]))
def test_names_at_any_places_do_not_overlap(places, name):
    terms = "".join(f"  {name}{k} = singleton({x!r})\n" for k, x in enumerate(places))
    rules = "".join(f"if x is low then y is {name}{k}\n" for k in range(len(places)))
    head = CONSTANTS.split("output")[0]
    _, boxes = drawn(f"{head}output y in [-1, 1] else 0\n{terms}{rules}if x is high then y is {name}0\n")
    assert len(boxes) == len(places)
    assert not overlapping(boxes)


class TestUprights:
    """Lines of singletons, drawn as high as they are."""

    SYSTEM = """system s
defuzzifier weighted_average
input x in [0, 1]
  low = triangle(-inf, 0, 1)
  high = triangle(0, 1, inf)
output y in [-1, 1]
  around = triangle(-1, 0, 1, height=0.9)
  at_zero = singleton(0)
  WWW = singleton(-0.15)
  half = singleton(0.02, height=0.5)
  wide_name = singleton(-0.3, height=0.4)
  left = singleton(-1)
  next = singleton(-0.98)
if x is low then y is around
if x is high then y is at_zero
"""

    def test_are_as_high_as_the_singleton(self):
        ax, _ = drawn(self.SYSTEM)
        tops = {
            c.get_segments()[0][0][0]: c.get_segments()[0][1][1] for c in ax.collections if hasattr(c, "get_segments")
        }
        assert tops == {0.0: 1.0, -0.15: 1.0, 0.02: 0.5, -0.3: 0.4, -1.0: 1.0, -0.98: 1.0}

    def test_run_through_no_name_and_no_name_through_another(self):
        ax, boxes = drawn(self.SYSTEM)
        assert len(boxes) == 7
        assert not overlapping(boxes)
        lines = [c.get_segments()[0] for c in ax.collections if hasattr(c, "get_segments")]
        for (x, _), (_, top) in lines:
            end = ax.transData.transform((x, top))
            assert not [b for b in boxes if b.x0 < end[0] < b.x1 and b.y0 < end[1]]
        left = ax.get_window_extent().x0
        assert all(b.x0 >= left for b in boxes)

    def test_of_many_at_one_place_some_are_named_and_the_rest_counted(self):
        names = [f"name{k}" for k in range(10)]
        terms = "".join(f"  {name} = singleton({0.001 * k})\n" for k, name in enumerate(names))
        rules = "".join(f"if x is low then y is {name}\n" for name in names)
        head = self.SYSTEM.split("output")[0]
        ax, boxes = drawn(f"{head}output y in [-1, 1] else 0\n{terms}{rules}if x is high then y is name0\n")
        assert [t.get_text() for t in ax.texts] == [*names[:MOST], "and 4 more"]
        assert not overlapping(boxes)


def test_names_of_constants_near_each_other_are_told_apart():
    ax, boxes = drawn(CONSTANTS)
    assert len(boxes) == 5
    assert not overlapping(boxes)
    assert all(ax.get_window_extent().y1 >= box.y1 for box in boxes)


def test_functions_of_the_inputs_are_written_out_and_many_are_counted():
    ax, _ = drawn(CONSTANTS, "z")
    assert [t.get_text() for t in ax.texts] == ["f = function(x / 2)", "g = linear(1, 2)"]
    assert ax.get_ylabel() == ""
    many = CONSTANTS.replace(
        "  g = linear(1, 2)\n", "  g = linear(1, 2)\n" + "".join(f"  f{k} = linear(1, {k})\n" for k in range(18))
    )
    assert [t.get_text() for t in drawn(f"{many}".replace("system s", "system s\nallow FZ208"), "z")[0].texts][
        -1
    ] == "and 14 more"
