"""Names over curves do not overlap."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import fuzzyctl
from fuzzyctl.plot.memberships import MOST, Label, draw_labels, draw_variable, lanes

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


def label(at, text="ab", height=1.0):
    return Label(text, at, height, "black")


class TestLanes:
    def test_names_far_from_each_other_share_a_line(self):
        assert lanes([label(0.1), label(0.5), label(0.9)], 0, 1, 400) == [0, 0, 0]

    def test_names_at_one_place_stand_above_each_other(self):
        assert lanes([label(0.5), label(0.5), label(0.51)], 0, 1, 400) == [0, 1, 2]

    def test_names_at_other_heights_need_no_line_of_their_own(self):
        assert lanes([label(0.5), label(0.5, height=0.5)], 0, 1, 400) == [0, 0]

    def test_names_that_find_no_line_have_none(self):
        found = lanes([label(0.5)] * 50, 0, 1, 400)
        assert found[:MOST] == list(range(MOST))
        assert found[MOST:] == [None] * (50 - MOST)

    def test_names_take_the_width_of_their_letters(self):
        assert lanes([label(0.45, "WWWWW"), label(0.55, "WWWWW")], 0, 1, 400) == [0, 1]
        assert lanes([label(0.45, "iiiii"), label(0.55, "iiiii")], 0, 1, 400) == [0, 0]

    def test_names_stay_within_the_axis(self):
        assert lanes([label(0.0, "wide"), label(0.02, "wide"), label(1.0, "wide")], 0, 1, 400) == [0, 1, 0]

    @settings(max_examples=30)
    @given(st.lists(st.floats(0, 1), max_size=MOST))
    def test_drawn_names_do_not_overlap(self, places):
        figure = Figure(figsize=(7.5, 2.6))
        ax = figure.subplots()
        figure.subplots_adjust(left=0.07, right=0.93)
        ax.set(xlim=(0, 1), ylim=(0, 2.2))
        draw_labels(ax, [label(x, "NEAR_1") for x in places], 0, 1)
        figure.canvas.draw()
        boxes = [t.get_window_extent() for t in ax.texts]
        assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])


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

    def drawn(self, text):
        system = fuzzyctl.loads(text)
        figure = Figure(figsize=(7.5, 2.6), layout="constrained")
        FigureCanvasAgg(figure)
        ax = draw_variable(figure.subplots(), system, system.output("y"))
        figure.canvas.draw()
        return ax, [t.get_window_extent() for t in ax.texts]

    def test_are_as_high_as_the_singleton(self):
        ax, _ = self.drawn(self.SYSTEM)
        tops = {
            c.get_segments()[0][0][0]: c.get_segments()[0][1][1] for c in ax.collections if hasattr(c, "get_segments")
        }
        assert tops == {0.0: 1.0, -0.15: 1.0, 0.02: 0.5, -0.3: 0.4, -1.0: 1.0, -0.98: 1.0}

    def test_run_through_no_name_and_no_name_through_another(self):
        ax, boxes = self.drawn(self.SYSTEM)
        assert len(boxes) == 7
        assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])
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
        ax, boxes = self.drawn(f"{head}output y in [-1, 1] else 0\n{terms}{rules}if x is high then y is name0\n")
        assert [t.get_text() for t in ax.texts] == [*names[:MOST], "and 4 more"]
        assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])


class TestTerms:
    @pytest.fixture
    def system(self):
        return fuzzyctl.loads(CONSTANTS)

    def test_names_of_constants_near_each_other_are_told_apart(self, system):
        figure = Figure(figsize=(7.5, 2.6), layout="constrained")
        ax = draw_variable(figure.subplots(), system, system.output("y"))
        figure.canvas.draw()
        boxes = [t.get_window_extent() for t in ax.texts]
        assert len(boxes) == 5
        assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])
        assert all(ax.get_window_extent().y1 >= box.y1 for box in boxes)

    def test_functions_of_the_inputs_are_written_out(self, system):
        ax = draw_variable(Figure().subplots(), system, system.output("z"))
        assert [t.get_text() for t in ax.texts] == ["f = function(x / 2)", "g = linear(1, 2)"]
        assert ax.get_ylabel() == ""

    def test_of_many_functions_some_are_written_and_the_rest_counted(self, system):
        z = system.output("z")
        terms = tuple(z.terms[0].model_copy(update={"name": f"f{k}"}) for k in range(20))
        ax = draw_variable(Figure().subplots(), system, z.model_copy(update={"terms": terms}))
        assert [t.get_text() for t in ax.texts][-1] == "and 14 more"
