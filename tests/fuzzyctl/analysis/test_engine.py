"""Coverage and bounds of what is more than a table of fuzzy sets."""

import math

import pytest

from fuzzyctl import compile, loads, output_bounds
from fuzzyctl.analysis.coverage.box_search import Hole, Undecided
from fuzzyctl.analysis.coverage.coverage import uncovered

TERMS = "  up = ramp(0, 1)\n  down = ramp(1, 0)\n  all = rectangle(-1, 2)\n  late = s_shape(0.5, 1)\n"
LINE, FIVE = "linear(2, 0, 1)", "constant(5)"
EVERYWHERE = f"if x is up then u is {LINE}\nif x is down then u is {FIVE}\n"


def system(rules=EVERYWHERE, method="weighted_average", head="", terms="", otherwise="", more="", extrapolate=""):
    inputs = "".join(f"input {n} in [0, 1]{extrapolate}\n{TERMS}" for n in "xy")
    return loads(f"system s\ndefuzzifier {method}\n{head}{inputs}output u in [0, 4] {otherwise}\n{terms}{more}{rules}")


THRESHOLD = "if x is all then u is constant(1)\nif x is up then u is constant(9) weight 0.25\n"
PLACES = "  s = sigmoid(1, 3)\n  r = ramp(3, 2)\n"
#: Systems and their bounds, attained but for rounding.
BOUNDS = {
    "linear consequents": (system(), (1, 5)),
    "functions": (
        system("if x is all then u is function(x * x)\nif x is up then u is function(exp(y))\n"),
        (0, math.e),
    ),
    "of an unbounded input": (system(extrapolate=" extrapolate"), (-math.inf, math.inf)),
    "a sum": (
        system(f"if x is up then u is {LINE} weight 0.5\nif x is down then u is {FIVE}\n", "weighted_sum"),
        (0, 6.5),
    ),
    "places in the range": (system("if x is all then u is r\n", "tsukamoto", terms=PLACES), (2, 3)),
    "places at its ends": (
        system("if x is all then u is r\nif x is up then u is s\n", "tsukamoto", terms=PLACES),
        (0, 4),
    ),
    "a rule below a threshold": (system(THRESHOLD, head="activation threshold(>= 0.5)\n"), (1, 1)),
}


@pytest.mark.parametrize("name", BOUNDS)
def test_bounds_are_those_by_hand(name):
    own, (low, high) = BOUNDS[name]
    bound = output_bounds(own)["u"]
    assert (bound.lo, bound.hi) == pytest.approx((low, high), abs=1e-12)
    assert bound.lo <= low
    assert high <= bound.hi


def test_a_sum_of_shares_is_bounded_by_the_largest_shares():
    bound = output_bounds(system(method="weighted_sum", head="activation proportional\n"))["u"]
    assert bound.hi == pytest.approx(3.0 + 5.0)


TWO = "".join(f"if x is {t} and y is all then u is {LINE}\n" for t in ("up", "down"))
CORNER = f"if x is up and y is up then u is {LINE}\n"
EITHER = f"if x is up or x is down then u is {LINE}\n"
SETS = "if x is up then u is set\nif x is down then u is set\n"
#: Systems in which some rule fires everywhere.
COVERED = {
    "functions": system(),
    "any": system(f"if x is any late then u is {LINE}\n"),
    "not": system(f"if x is not late then u is {LINE}\n" + EVERYWHERE),
    "threshold": system(head="activation threshold(>= 0.5)\n"),
    "implication": system(
        *(SETS, "centroid(resolution=8)", "implication bounded_difference\n", "  set = triangle(0, 1, 2)\n")
    ),
    **{n: system(TWO, head=f"and {n}\n") for n in ("einstein_product", "hamacher_product", "product", "min")},
    **{n: system(EITHER, head=f"or {n}\n") for n in ("einstein_sum", "nilpotent_maximum", "drastic_sum")},
    **{k: system(head=f"activation {k}\n") for k in ("first(count=1)", "lowest(count=1)", "proportional")},
}  # fmt: skip


@pytest.mark.parametrize("name", COVERED)
def test_what_is_covered_is_known_to_be(name):
    assert uncovered(COVERED[name]) == {"u": None}


LOW = SETS.replace("set", "low")
#: Systems with a place where no rule fires.
HOLES = {
    **{h: system(f"if x is {h} late then u is {LINE}\n", otherwise="else nan") for h in ("very", "somewhat", "seldom")},
    **{
        n: system(CORNER, head=f"and {n}\n", otherwise="else nan")
        for n in ("bounded_difference", "drastic_product", "nilpotent_minimum")
    },
    "implication": system(
        *(LOW, "centroid(resolution=8)", "implication bounded_difference\n"),
        terms="  low = triangle(0, 1, 2, height=0.4)\n",
        otherwise="else nan",
    ),
    "threshold": system(head="activation threshold(> 0.5)\n", otherwise="else nan"),
}


@pytest.mark.parametrize("name", HOLES)
def test_a_hole_is_shown_at_a_point_where_nothing_fires(name):
    hole = uncovered(HOLES[name])["u"]
    assert isinstance(hole, Hole)
    assert math.isnan(compile(HOLES[name], "python")(*hole.witness.values()))


SECOND = "output v in [0, 1] {} defuzzifier weighted_sum\n  one = constant(1)\n"


def test_methods_that_choose_may_choose_rules_of_another_output():
    rules = EVERYWHERE + "if y is up then v is one\n"
    made = system(rules, head="activation highest(count=1)\n", more=SECOND.format("else nan"))
    assert isinstance(uncovered(made)["u"], Undecided)


@pytest.mark.parametrize(
    ("term", "otherwise", "reason"),
    [
        ("low", "else 0", None),
        ("some", "else 0", "all that is known of u"),
        ("low", "else nan", "'u', which may have no value"),
    ],
)
def test_of_outputs_that_are_read_the_range_is_known(term, otherwise, reason):
    rules = f"if x is up then u is {LINE}\nif u is {term} then v is one\n"
    terms = "  low = ramp(9, 8)\n  some = ramp(4, 0)\n"
    verdict = uncovered(system(rules, terms=terms, otherwise=otherwise, more=SECOND.format("")))["v"]
    assert verdict is None if reason is None else reason in verdict.reason
