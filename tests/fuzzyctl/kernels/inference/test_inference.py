"""The program of the rules alone begins as the trace does, and leaves out what only outputs need."""

import pytest

from fuzzyctl import loads
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.program.program import Refuse
from fuzzyctl.kernels.program.traversal import read, writes
from tests.frozen.systems import SYSTEMS


@pytest.mark.parametrize("name", SYSTEMS)
def test_activity_begins_as_the_trace_does(name):
    planned = plan(loads(SYSTEMS[name]))
    trace, activity = inference.trace(planned), inference.activity(planned)
    count = len(planned.degrees) + len(planned.rules)
    assert activity.results[:count] == trace.results[:count]
    assert len(activity.results) == len(trace.results) - len(planned.outputs)
    wanted = set().union(*map(read, activity.results[:count]))
    last = max((k for k, s in enumerate(activity.body) if writes(s) & wanted), default=-1)
    assert [s for s in trace.body if not isinstance(s, Refuse)][: last + 1] == list(activity.body[: last + 1])


def test_activity_does_not_defuzzify_what_no_rule_reads():
    planned = plan(loads(SYSTEMS["centroid_min_max"]))
    assert 3 * len(inference.activity(planned).body) < len(inference.trace(planned).body)
