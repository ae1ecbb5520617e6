"""Where two systems differ most."""

import dataclasses
import math
from contextlib import nullcontext

import numpy as np
import pytest

import fuzzyctl
from tests.fuzzyctl.comparison.command import compared, differences

LINE = """\
system line
defuzzifier weighted_average
input x in [0, 4]
  low  = triangle(-inf, 0, {peak})
  high = triangle(0, {peak}, inf)
output y in [0, 8] else {otherwise}
  terms a=0 b={top}
table y = x
     low  high
  |  a    {cell}
"""


def line(peak=4, top=4, otherwise="error", cell="b"):
    return LINE.format(peak=peak, top=top, otherwise=otherwise, cell=cell)


class TestDifferences:
    def test_a_system_does_not_differ_from_itself(self):
        (found,) = differences(line(), line())
        assert (found.largest, found.mean, found.one_sided) == (0.0, 0.0, 0)

    def test_the_largest_difference_of_two_lines_is_where_they_are_farthest_apart(self):
        (found,) = differences(line(), line(top=6), points=100)
        assert found.largest == pytest.approx(2.0, abs=1e-12)
        assert found.point == {"x": 4.0}
        assert (found.first, found.second) == (pytest.approx(4.0), pytest.approx(6.0))
        assert found.mean == pytest.approx(1.0, abs=0.1)

    def test_a_peak_between_the_points_is_found(self):
        """Lines that bend at 1.37 differ most there, and a corner of either file is among the points."""
        (found,) = differences(line(), line(peak=1.37), points=20)
        assert found.point["x"] == pytest.approx(1.37, abs=1e-12)
        assert found.largest == pytest.approx(4 - 1.37, abs=1e-12)

    def test_a_difference_is_looked_for_around_the_worst_point(self):
        """Two Gaussians cross nowhere near a corner; the largest difference of y = x² / 4 and x is at 2."""
        text = "system {0}\ndefuzzifier weighted_average\ninput x in [0, 5]\n  all = rectangle(-inf, 5)\n"
        text += "output y in [0, 9]\n  f = function({1})\nif x is all then y is f\n"
        a, b = (text.format(n, f) for n, f in (("a", "x"), ("b", "x ^ 2 / 4 + 9 * max(0, x - 4)")))
        one = text.format("c", "x - x ^ 2 / 4 - 9 * max(0, x - 4) + 5 * max(0, x - 3.9)")
        assert differences(a, b, points=30)[0].point["x"] == pytest.approx(5.0)
        (found,) = differences(one, text.format("d", "0 * x"), points=30)
        system = fuzzyctl.loads(one)
        best = max(system(x=k / 1000) for k in range(5001))
        worst = max(best, -min(system(x=k / 1000) for k in range(5001)))
        assert found.largest == pytest.approx(worst, rel=1e-5)

    def test_a_point_where_only_one_has_a_value_hides_no_difference_elsewhere(self):
        """One point of many has no value on one side; everywhere else the second is 0 and the first x."""
        text = LINE.replace("{cell}", ".")
        (found,) = differences(line(otherwise="nan"), text.format(peak=4, top=4, otherwise="nan"))
        assert found.largest == pytest.approx(4.0, abs=1e-3)
        assert (found.first, found.second) == (pytest.approx(4.0, abs=1e-3), 0.0)
        assert found.one_sided == 1
        assert found.gap is not None
        assert (found.gap.point, found.gap.first) == ({"x": 4.0}, pytest.approx(4.0))
        assert math.isnan(found.gap.second)
        systems = line(otherwise="nan"), text.format(peak=4, top=4, otherwise="nan")
        assert compared(*systems, "--within", 5).exit_code == 1
        assert found.mean == pytest.approx(2.0, abs=0.01)

    def test_where_nowhere_both_have_a_value_the_difference_is_infinite(self):
        text = "system {}\ndefuzzifier weighted_average\ninput x in [0, 4]\n  low = triangle(-inf, 0, 2)\n"
        text += "  high = triangle(2, 4, inf)\noutput y in [0, 8] else nan\n  terms a=0 b=1\nif x is {} then y is a\n"
        (found,) = differences(text.format("a", "low"), text.format("b", "high"))
        assert math.isinf(found.largest)
        assert math.isnan(found.second) != math.isnan(found.first)
        assert found.gap is not None
        assert compared(*(text.format(*t) for t in (("a", "low"), ("b", "high"))), "--within", 1e9).exit_code == 1

    def test_else_error_is_no_value_rather_than_an_exception(self):
        text = LINE.replace("{cell}", ".").format(peak=4, top=4, otherwise="error")
        (found,) = differences(line(), text)
        assert found.one_sided == 1

    def test_inputs_are_paired_by_name_in_any_order(self, base):
        swapped = base.replace("table u = x x y", "table u = y x x")
        head, y = base.split("input y"), "input y" + base.split("input y")[1].split("output u")[0]
        assert "terms N@0 P@10" in y
        text = head[0].replace("input x", y + "input x") + "output u" + base.split("output u")[1]
        a, b = base, text
        assert [v.name for v in fuzzyctl.loads(b).inputs] == ["y", "x"]
        assert differences(a, b)[0].largest <= 1e-12
        assert swapped != base

    def test_inputs_of_other_names_are_paired_by_position(self, base):
        other = base.replace("input y", "input z").replace("table u = x x y", "table u = x x z")
        assert differences(base, other)[0].largest == 0.0

    def test_inputs_of_one_name_are_paired_by_it_where_another_was_renamed(self, base):
        a = base
        renamed = fuzzyctl.loads(base.replace("input y", "input z").replace("table u = x x y", "table u = x x z"))
        turned = dataclasses.replace(renamed, inputs=renamed.inputs[::-1])
        assert [v.name for v in turned.inputs] == ["z", "x"]
        assert differences(a, fuzzyctl.dumps(turned))[0].largest <= 1e-12

    def test_systems_of_other_inputs_are_refused(self, base):
        assert "different inputs: x, y and x" in compared(base, line()).errors


OUTPUTS = """\
system outputs
input x in [0, 1]
  terms a b
output {} in [0, 9] else nan
  terms low high
output {} in [0, 9] else nan
  terms low high
if x is a then y is low, z is high
if x is b then y is high, z is low
"""


class TestOutputs:
    def test_outputs_in_another_order_are_paired_by_name(self):
        a, b = (OUTPUTS.format(*names) for names in ("yz", "zy"))
        assert [(d.output, d.largest) for d in differences(a, b, points=100)] == [("y", 0.0), ("z", 0.0)]

    def test_each_point_is_evaluated_once_whatever_the_number_of_outputs(self, monkeypatch):
        rows = []
        batch = fuzzyctl.Kernel.batch

        def counting(self, points, *state):
            rows.append(len(points))
            return batch(self, points, *state)

        monkeypatch.setattr(fuzzyctl.Kernel, "batch", counting)
        found = differences(*(OUTPUTS.format(*names) for names in ("yz", "zy")), points=100)
        assert sum(rows) == 2 * found[0].points


class TestLongWork:
    def test_progress_is_reported_and_nothing_else_changes(self, monkeypatch):
        reported = []
        expected = differences(line(), line(peak=1.37), points=1000)
        monkeypatch.setattr("fuzzyctl.cli.compare.status_line", lambda: nullcontext(reported.append))
        assert differences(line(), line(peak=1.37), points=1000) == expected
        assert reported[:2] == ["comparing at 1,000 points: 0 %", "comparing at 1,000 points: 1 %"]
        assert "looking for where y differs most: 91 %" in reported


@pytest.mark.parametrize("count", [3, 12, 70])
def test_systems_of_many_inputs_are_compared_at_no_more_points(count, monkeypatch):
    """Two values of each of 70 inputs are more points than memory has, and arrays have no 70 dimensions."""
    inputs = "".join(f"input x{k} in [0, 1]\n  terms a b\n" for k in range(count))
    rules = "".join(f"if x{k} is a then y is small\n" for k in range(count))
    system = f"system s\n{inputs}output y in [0, 1] else 0\n  terms small large\n{rules}"
    batch, compared_at = fuzzyctl.Kernel.batch, []
    monkeypatch.setattr(
        fuzzyctl.Kernel, "batch", lambda k, points, *s: compared_at.append(points) or batch(k, points, *s)
    )
    (found,) = differences(system, system, points=1000)
    assert (found.points, compared_at[0].shape[1]) == (1000, count)
    assert {0.0, 1.0} <= set(np.concatenate(compared_at)[:100].ravel())
