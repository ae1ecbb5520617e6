"""Places where an output changes at once."""

import math
import re
from types import SimpleNamespace

import pytest

from fuzzyctl import check, loads
from fuzzyctl.testing import check_text

SWITCH = """system s
param p = 6
and product
defuzzifier weighted_average
input x in [0, 10]{where}
  A = {a}
  B = {b}
input y in [-1, 1]
  terms N P
output u in [0, 5]{otherwise}
  terms low=1 high=4
table u = x x y
      N    P
 A |  low  low
 B |  low  {cell}
"""


def jump(a="ramp(6, 4)", b="ramp(4, 6)", otherwise="", cell="high", where=""):
    """Return what is reported of the largest jump, None without one; its values are those of the system there."""
    system = loads(SWITCH.format(a=a, b=b, otherwise=otherwise, cell=cell, where=where))
    for found in (d for d in check(system)[1] if d.code == "FZ405"):
        size, name, at = re.fullmatch(r"output 'u' jumps by (\S+) at (\w+) = (\S+)", found.message).groups()
        before, after, other, y = re.fullmatch(r"from (\S+) to (\S+) for (\w+) = (\S+)", found.facts[0]).groups()
        near = [math.nextafter(float(at), side) for side in (-math.inf, math.inf)]
        values = [system(**{name: x, other: float(y)}) for x in (near[0], float(at), near[1])]
        assert {float(before), float(after)} <= set(values)
        numbers = {"at": float(at), "size": float(size), "before": float(before), "after": float(after)}
        silent = found.facts[1].startswith("no rule fires beyond")
        return SimpleNamespace(input=name, others={other: float(y)}, silent=silent, **numbers)
    return None


class TestJumps:
    def test_a_partition_has_none(self):
        assert jump() is None

    def test_terms_that_jump_are_shown_with_place_and_size(self):
        found = jump("rectangle(-inf, 3)", "rectangle(3, inf)")
        assert (found.input, found.at) == ("x", 3.0)
        assert found.others == {"y": 1.0}
        assert found.size == pytest.approx(3.0)
        assert not found.silent

    def test_a_formula_jumps_where_it_compares(self):
        found = jump("function(lt(x, p / 2))", "function(ge(x, p / 2))", where="").at
        assert found == 3.0

    def test_a_term_whose_jump_changes_nothing_is_none(self):
        assert jump("rectangle(-inf, 3)", "rectangle(3, inf)", cell="low") is None

    def test_a_missing_cell_jumps_where_its_neighbours_end(self):
        found = jump(otherwise=" else 0", cell=".")
        assert found.silent
        assert {found.before, found.after} == {1.0, 0.0}

    def test_else_at_the_same_value_does_not(self):
        assert jump(otherwise=" else 1", cell=".") is None

    def test_nan_is_no_jump_and_what_is_held_is_not_looked_at(self):
        assert jump(otherwise=" else nan", cell=".") is None
        assert jump(otherwise=" else hold", cell=".") is None

    def test_a_gap_between_terms_has_a_message_of_its_own(self):
        assert jump("ramp(3, 2)", "ramp(6, 7)", otherwise=" else 3") is None

    def test_an_end_of_a_range_that_is_clamped_is_a_place(self):
        found = jump("rectangle(-inf, 10)", "rectangle(10, inf)")
        assert (found.at, found.size) == (10.0, pytest.approx(1.5))

    def test_else_at_the_end_of_a_range_is_a_jump(self):
        found = jump("ramp(10, 5)", "ramp(5, 10)", otherwise=" else 0", cell=".")
        assert (found.at, found.before, found.after, found.silent) == (10.0, 1.0, 0.0, True)

    def test_an_end_of_a_range_that_is_left_is_none(self):
        assert jump("rectangle(-inf, 10)", "rectangle(10, inf)", where=" extrapolate") is None


@pytest.mark.parametrize("where", ["", " extrapolate"])
def test_the_ends_of_a_range_are_no_place_to_jump(where):
    """Shoulders written with both corners at the end of the range, as other tools do, leave nothing beyond it."""
    text = f"""
system valve
input t in [10, 30]{where}
  cold = triangle(10, 10, 25)
  warm = triangle(15, 30, 30)
output u in [0, 1] else midpoint
  shut = triangle(0, 0, 0.6)
  open = triangle(0.4, 1, 1)
if t is cold then u is open
if t is warm then u is shut
"""
    _, diagnostics = check(loads(text))
    assert [d.code for d in diagnostics] == []


class TestMaxima:
    """Maxima pass from one term to the next at once: that is their nature, and no news of a file."""

    @pytest.mark.parametrize(("defuzzifier", "codes"), [("som", []), ("mom", []), ("lom", []), ("centroid", ["FZ405"])])
    def test_their_jumps_are_not_reported(self, defuzzifier, codes):
        text = SWITCH.format(a="rectangle(-inf, 3)", b="rectangle(3, inf)", otherwise="", cell="high", where="")
        text = text.replace("low=1 high=4", "low high").replace("and product\ndefuzzifier weighted_average\n", "")
        found = check_text(f"defuzzifier {defuzzifier}\n{text}", "s.fz")[1]
        assert [d.code for d in found if d.code != "FZ216"] == codes
