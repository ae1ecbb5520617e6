"""A `.fis` file names one aggregation for all outputs: which one, and what that changes."""

import pytest

from fuzzyctl.formats.fis import write
from fuzzyctl.loading.load import loads

HYBRID = """\
system hybrid
semantics fuzzylite
input x in [0, 10]
  low = triangle(-inf, 0, 10)
  high = ramp(0, 10)
output y in [0, 4] defuzzifier weighted_average aggregation {aggregation}
  p = constant(1)
output z in [0, 4] defuzzifier centroid aggregation max
  q = triangle(0, 1, 4)
if x is low then y is p, z is q
"""


class TestAggregations:
    @pytest.mark.parametrize(("aggregation", "lost"), [("sum", ["aggregation max"]), ("max", [])])
    def test_rules_of_one_term_are_joined_before_an_average(self, aggregation, lost):
        text = f"{HYBRID.format(aggregation=aggregation)}if x is high then y is p\n"
        _, losses = write(loads(text))
        assert [x.what for x in losses if x.what.startswith("aggregation")] == lost

    def test_an_average_that_joins_rules_otherwise_is_a_loss_behind_sets(self):
        text = f"{HYBRID.format(aggregation='sum')}if x is high then y is p\n"
        y, z = text.index("output y"), text.index("output z")
        rules = text.index("if x is low")
        _, losses = write(loads(text[:y] + text[z:rules] + text[y:z] + text[rules:]))
        assert [x.what for x in losses if x.what.startswith("aggregation")] == ["aggregation sum"]

    def test_an_average_that_joins_nothing_leaves_the_choice_to_sets(self):
        written, losses = write(loads(HYBRID.format(aggregation="sum")))
        assert "AggMethod='max'" in written
        assert [x.what for x in losses if x.what.startswith("aggregation")] == []
