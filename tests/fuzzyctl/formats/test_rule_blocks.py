"""Rule blocks in the formats of other tools: kept with their names and methods, or reported as a loss."""

import pytest

from fuzzyctl import loads
from tests.fuzzyctl.formats.files import FORMATS, read

SYSTEM = """
system s
defuzzifier centroid(resolution=101, grid=endpoints)
input e in [-1, 1]
  terms N P
input d in [-1, 1]
  terms N P
output u in [-1, 1] else 0
  N = triangle(-3, -1, 1)
  P = triangle(-1, 1, 3)
if e is N then u is N
rules fast and product implication product activation highest(count=1)
if e is N and d is N then u is N
if e is P and d is P then u is P
"""


def lost(format, text):
    _, losses = FORMATS[format].write(loads(text))
    return {(x.where, x.what) for x in losses if not x.exact}


@pytest.mark.parametrize("format", ["fcl", "fml"])
def test_an_activation_that_a_format_has_not_is_reported(format):
    reported = {what for _, what in lost(format, SYSTEM)}
    assert "activation highest" in reported
    assert reported - {what for _, what in lost(format, SYSTEM.replace(" activation highest(count=1)", ""))} == {
        "activation highest"
    }


@pytest.mark.parametrize("format", ["fll", "fcl", "fml"])
def test_rules_of_no_block_stay_such(format):
    system = loads(SYSTEM.replace(" activation highest(count=1)", ""))
    back = read(format, FORMATS[format].write(system)[0])
    assert [b.name for b in back.rule_blocks] == ["fast"]
    assert [(m.block, m.implication) for m in back.rule_methods] == [(-1, None), (0, "product"), (0, "product")]
    assert [m.conjunction for m in back.rule_methods][1:] == ["product"] * 2


class TestFis:
    def test_one_method_is_written_and_what_differs_is_reported(self):
        assert lost("fis", SYSTEM) - lost("fis", SYSTEM.replace(" activation highest(count=1)", "")) == {
            ("rule block 'fast'", "activation highest")
        }
        plain = SYSTEM.replace(" activation highest(count=1)", "")
        reported = lost("fis", plain) - lost("fis", plain.replace("rules fast and product implication product", ""))
        assert reported == {("rule block 'fast'", "and product"), ("rule block 'fast'", "implication product")}

    def test_blocks_that_do_not_differ_change_no_number(self):
        same = SYSTEM.replace("if e is N then u is N\n", "").replace(" activation highest(count=1)", "")
        text, losses = FORMATS["fis"].write(loads(same))
        assert ("rule block 'fast'", "the block") in {(x.where, x.what) for x in losses if x.exact}
        assert [x.where for x in losses if not x.exact and "rule block" in x.where] == []
        assert "AndMethod='prod'" in text
        assert "ImpMethod='prod'" in text
        assert not read("fis", text).rule_blocks
