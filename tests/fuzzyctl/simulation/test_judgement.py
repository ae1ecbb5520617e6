"""Measures that use each other and params, and requirements on them."""

import math
import re

import pytest

from fuzzyctl import Experiment

TEXT = """
plant p
input u
state x = 0
der x = u
output y = x
loop l
block p = p(1)
param limit = 1.5
{lines}
run 2 s step 0.5 s
"""


def run_of(loop, lines):
    return Experiment(loop(TEXT.format(lines=lines)), "python").run()


def test_measures_may_use_params_and_measures_of_lines_below(loop):
    run = run_of(loop, "measure cost = 2 * area + limit\nmeasure area = integral(abs(p.y - 1)) - final(p.y)")
    assert run.measures == {"cost": pytest.approx(2 * -1 + 1.5), "area": pytest.approx(-1)}


def test_arguments_are_expressions_over_signals_and_time(loop):
    run = run_of(loop, "measure a = maximum(where(p.y > 1, t, -t))\nmeasure b = final(where(p.y > limit, 1, 0))")
    assert run.measures == {"a": 2.0, "b": 1.0}


def test_a_measure_that_cannot_be_computed_has_no_value(loop):
    run = run_of(loop, "measure a = 1 / final(p.y - 2)\nmeasure b = a + 1\nrequire a < 1 or b >= 1")
    assert [math.isnan(v) for v in run.measures.values()] == [True, True]
    assert not run.passed


@pytest.mark.parametrize(
    ("claim", "holds"),
    [
        ("m <= 2", True),
        ("m < 2", False),
        ("m == 2 and m > limit", True),
        ("m < 1 or not m < 2", True),
        ("m != 2", False),
        ("m <= limit", False),
        ("m <= limit within 0.6", True),
        ("m == 2.1 within 0.2", True),
        ("never <= 1000 s", False),
        ("never > 1000 s", True),
        ("m < 2 within 0.1", True),
        ("none > 0 or m == 2", True),
        ("none > 0", False),
        ("not none > 0", False),
    ],
)
def test_requirements_are_checked_on_the_run(loop, claim, holds):
    measures = "measure m = final(p.y)\nmeasure never = settling(p.y, 1)\nmeasure none = 0 / final(p.y - 2)"
    run = run_of(loop, f"{measures}\nrequire {claim}")
    (found,) = run.requirements
    assert (found.text, found.holds, run.passed) == (claim.split(" within")[0], holds, holds)
    known = {"m": "m = 2", "never": "never = inf", "none": "none = none"}
    tolerance = re.findall("within .*", claim)
    assert found.facts == (*dict.fromkeys(known[n] for n in re.findall("never|none|m", found.text)), *tolerance)


def test_no_requirement_holds_in_a_run_that_was_stopped(loop):
    run = run_of(loop, "measure m = final(p.y)\nrequire 1 < 2\nblock q = p(1 / (1 - t))\nrequire not m > 1")
    assert run.stopped is not None
    assert [r.holds for r in run.requirements] == [False, False]


def test_a_summary_is_plain_data(loop):
    summary = run_of(loop, "measure m = final(p.y)\nmeasure never = settling(p.y, 1)\nrequire m <= 2").summary()
    assert summary["measures"] == {"m": 2.0, "never": None}
    assert summary["requirements"] == [{"claim": "m <= 2", "holds": True, "verdict": "met", "facts": ["m = 2"]}]
    assert (summary["loop"], summary["samples"], summary["step_s"], summary["end_s"]) == ("l", 5, 0.5, 2.0)
    assert summary["params"] == {"limit": 1.5}
    assert summary["stopped"] is None
