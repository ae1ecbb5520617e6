"""What is written in a format without losses is read back as the same system; what cannot be written is said."""

import math

import pytest

from fuzzyctl import DiagnosticError, compile, loads
from tests.frozen.foreign import kept
from tests.fuzzyctl.formats.files import FORMATS, SAMPLES, read, write
from tests.sizes import examples


def texts(name):
    """Return the texts of kept sound files: a tenth of them in the test line."""
    return ["\n".join(file["text"]) for file in kept(name) if "numbers" in file][:: examples(1, 10)]


def survives(format, system):
    """Whether a system can be written without losses; its text then has the same numbers, and is read again so."""
    try:
        text, lossy = write(format, system)
        kernel = compile(system, "python")
    except DiagnosticError:
        return False
    # The reports of `convert` name the rules of one term that Tsukamoto's method joins.
    if lossy or (system.method.semantics.merge == "rules" and "tsukamoto" in system.method.defuzzifier.kind):
        return False
    back = read(format, text)
    assert read(format, write(format, back)[0]) == back
    ends = [system.range_of(i) for i in system.inputs]
    points = [[low + (high - low) * ((7 * k + j) % 10) / 9 for j, (low, high) in enumerate(ends)] for k in range(9)]
    expected = pytest.approx(kernel.batch(points), rel=1e-11, abs=1e-12, nan_ok=True)
    assert compile(back, "python").batch(points) == expected, text
    return True


@pytest.mark.parametrize("format", FORMATS)
def test_systems_of_a_format_survive_it(format):
    survived = [survives(format, read(format, text)) for text in texts(format)]
    assert sum(survived) > len(survived) / 2


@pytest.mark.parametrize("format", FORMATS)
def test_systems_that_are_written_without_losses_compute_the_same_numbers(format):
    assert any([survives(format, loads(text)) for text in texts("fz")])


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_samples_survive_their_own_format(name):
    format = "fml" if name.endswith(".xml") else name[-3:]
    first = read(name, SAMPLES[name])
    text, lossy = write(format, first)
    assert lossy == []
    back = read(format, text)
    assert back.rules == first.rules
    assert [v.terms for v in back.outputs] == [v.terms for v in first.outputs]
    assert read(format, write(format, back)[0]) == back


TIP = """\
system tip "Tip"
source "A book"
param steep = 0.5
input service "Service" in [0, 10] unit "points"
  poor = triangle(-inf, 0, 5)
  good = trapezoid(4, 6, 7, inf)
  best = triangle(6, 10, 10, height=0.5)
input food in [0, 10]
  bad = ramp(10, 0)
  fair = rectangle(4, 6)
output tip in [0, 30] else 15
  low = triangle(0, 5, 10)
  high = triangle(10, 20, 30)
require bounded(tip, 0, 30)
if service is poor or food is bad then tip is low
if not (service is poor or food is bad) then tip is high weight (steep)
if service is best and food is not fair then tip is high
"""


class TestWhatIsLost:
    def lost(self, format, system):
        _, losses = FORMATS[format].write(system)
        return [(x.where, x.what) for x in losses if x.exact], [(x.where, x.what) for x in losses if not x.exact]

    def test_words_for_people_params_and_guarantees_do_not_change_numbers(self):
        system = loads(TIP)
        exact, others = self.lost("fll", system)
        assert exact == [
            ("input 'service'", "the unit"),
            ("system 'tip'", "guarantees"),
            ("system 'tip'", "params steep"),
            ("system 'tip'", "the source"),
        ]
        assert others == [("output 'tip'", "defuzzifier centroid without samples")]

    def test_a_negated_group_becomes_its_dual_in_fll_and_is_refused_in_fis(self):
        system = loads(TIP)
        text, _ = FORMATS["fll"].write(system)
        assert "rule: if service is not poor and food is not bad then tip is high with 0.5" in text
        with pytest.raises(DiagnosticError) as caught:
            FORMATS["fis"].write(system)
        (found,) = caught.value.diagnostics
        assert (found.code, found.facts) == ("FZ608", ("rule 2 mixes 'and', 'or' and 'not' of groups",))

    def test_a_negated_group_has_no_dual_where_the_norms_are_none(self):
        with pytest.raises(DiagnosticError) as caught:
            FORMATS["fll"].write(loads(TIP.replace("param steep", "and product\nparam steep")))
        assert caught.value.diagnostics[0].facts == ("rule 2 negates a group",)

    def test_shoulders_steps_and_low_triangles_have_a_form_in_fis(self):
        plain = TIP.replace("if not (service is poor or food is bad)", "if service is good")
        text, losses = FORMATS["fis"].write(loads(plain))
        assert "MF1='poor':'linzmf',[0 5]" in text
        assert "MF2='good':'linsmf',[4 6]" in text
        assert "MF3='best':'trapmf',[6 14 10 10]" in text
        assert "MF2='fair':'trapmf',[4 4 6 6]" in text
        lost = [(x.where, x.what) for x in losses if not x.exact]
        # The low triangle is 0.5 where 'service' is held at 10, and 0 beyond.
        held = ("input 'service'", "clamped to its range")
        assert lost == [held, ("output 'tip'", "defuzzifier centroid without samples")]
        back = read("fis", text)
        for degree in (0.0, 2.5, 5.5, 8.0, 9.9):
            assert back(service=degree, food=3.0) == pytest.approx(loads(plain)(service=degree, food=3.0), abs=0.05)

    def test_an_average_of_sets_is_written_as_an_average_of_their_middles(self):
        text = TIP.replace("param steep", "defuzzifier center_average\nparam steep").replace("not (", "(")
        system = loads(text.replace("height=0.5", "height=1"))
        for format in ("fis", "fll"):
            text, lossy = write(format, system)
            assert lossy == []
            back = read(format, text)
            for s, f in ((1.0, 2.0), (4.5, 9.0), (9.0, 1.0)):
                assert back(service=s, food=f) == pytest.approx(system(service=s, food=f), rel=1e-12)

    @pytest.mark.parametrize(
        ("old", "new", "format", "reason"),
        [
            (
                "output tip in [0, 30] else 15",
                "output tip in [0, 30] adaptive rate 1",
                "fll",
                "output 'tip' is adaptive",
            ),
            ("if service is poor or", "if service is slightly poor or", "fll", "rule 1 has the hedge 'slightly'"),
            ("if service is poor or", "if service is slightly poor or", "fis", "rule 1 has the hedges 'slightly'"),
            (
                "if service is poor or food is bad",
                "if service is poor or service is good",
                "fis",
                "rule 1 names 'service' twice",
            ),
            (
                "triangle(6, 10, 10, height=0.5)",
                "gaussian(6, 1, height=0.5)",
                "fis",
                "term 'best' of 'service' has the height 0.5",
            ),
        ],
    )
    def test_what_a_format_cannot_hold_at_all_is_refused_with_the_reason(self, old, new, format, reason):
        assert old in TIP
        text = TIP.replace(old, new).replace("not (", "(")
        if "adaptive" in new:
            text = text.replace("param steep = 0.5", "param steep = 0.5\ndefuzzifier weighted_average")
            text = text.replace("triangle(0, 5, 10)", "constant(5)").replace("triangle(10, 20, 30)", "constant(20)")
        with pytest.raises(DiagnosticError) as caught:
            FORMATS[format].write(loads(text))
        assert reason in caught.value.diagnostics[0].facts

    def test_numbers_keep_all_their_digits(self):
        third = 1 / 3
        system = loads(TIP.replace("param steep = 0.5", "param steep = 1/3").replace("not (", "("))
        for format in ("fis", "fll"):
            text, _ = FORMATS[format].write(system)
            assert repr(third) in text
            back = read(format, text)
            assert math.isclose(back.rules[1].weight.value, third, rel_tol=0)

    @pytest.mark.parametrize(
        ("old", "new", "lost"),
        [
            ("is poor or", "is very poor or", ("rule 1", "hedges 'very'")),
            ("param steep", "and einstein_product\nparam steep", ("system 'tip'", "norm 'einstein_product'")),
        ],
    )
    def test_what_only_octave_reads_is_written_for_octave_and_reported(self, old, new, lost):
        text = TIP.replace(old, new, 1).replace("if not (service is poor or food is bad)", "if service is good")
        written, losses = FORMATS["fis"].write(loads(text))
        assert lost in [(x.where, x.what) for x in losses if not x.exact]
        assert ("output 'tip'", "else a value") in [(x.where, x.what) for x in losses]
        assert read("fis", written).method.semantics.profile == "octave"
