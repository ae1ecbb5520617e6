"""Rule blocks in the formats of other tools: kept with their names and methods, or reported as a loss."""

import pytest
from hypothesis import HealthCheck, given, settings

from fuzzyctl.diagnostics.diagnostic import render_all
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.common.identifiers import as_read
from fuzzyctl.formats.common.words import DUAL_OF
from fuzzyctl.formats.registry import FORMATS
from fuzzyctl.loading.load import loads
from tests.fuzzyctl.formats.blocked import blocked, keeps_blocks
from tests.fuzzyctl.formats.drawn_engines import ACTIVATIONS, NORMS, fuzzylite_systems
from tests.fuzzyctl.formats.drawn_fcl import CONJUNCTIONS
from tests.fuzzyctl.formats.drawn_fcl import systems as fcl_systems
from tests.fuzzyctl.formats.drawn_fml import systems as fml_systems
from tests.sizes import examples

QUICK = settings(max_examples=examples(40), deadline=None, suppress_health_check=list(HealthCheck))


def read(format, text):
    systems, diagnostics = FORMATS[format].read(SourceText(f"t.{format}", text))
    assert systems, f"{render_all(diagnostics)}\n{text}"
    return systems[0], diagnostics


@QUICK
@given(blocked(fuzzylite_systems(), NORMS, ACTIVATIONS))
def test_rule_blocks_survive_an_fll_file(system):
    text, losses = FORMATS["fll"].write(system)
    assert [str(x) for x in losses if not x.exact] == []
    back, diagnostics = read("fll", text)
    assert diagnostics == [], render_all(diagnostics)
    keeps_blocks(system, back)


@QUICK
@given(blocked(fcl_systems(), [(c, DUAL_OF[c]) for c in CONJUNCTIONS]))
def test_rule_blocks_survive_an_fcl_file(system):
    text, losses = FORMATS["fcl"].write(system)
    assert [str(x) for x in losses if not x.exact] == []
    back, _ = read("fcl", text)
    keeps_blocks(system, back)


@QUICK
@given(blocked(fml_systems(), [("min", "max"), ("product", "probabilistic_sum")]))
def test_rule_blocks_survive_an_fml_file(system):
    text, losses = FORMATS["fml"].write(system)
    assert [str(x) for x in losses if not x.exact] == []
    back, _ = read("fml", text)
    keeps_blocks(as_read(system)[0], back)


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
    back, _ = read(format, FORMATS[format].write(system)[0])
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
        back, _ = read("fis", text)
        assert not back.rule_blocks
