"""What is written as FML computes the same numbers when it is read back, or the losses say so."""

import math

import pytest

from fuzzyctl import DiagnosticError, build, compile, dumps, loads
from tests.fuzzyctl.formats.files import FORMATS, SAMPLES, read, replaced, rules, write
from tests.fuzzyctl.formats.one_term import degrees, with_membership

MINIMAL = """\
system m
input x in [0, 1]
  a = triangle(0, 0, 1)
output y in [0, 4] else 1
  b = triangle(0, 1, 1)
if x is a then y is b
"""
TERM_A, TERM_B, RULE = "triangle(0, 0, 1)", "triangle(0, 1, 1)", "if x is a then y is b"


def changed(*pairs):
    return loads(replaced(MINIMAL, *pairs))


def method(*words):
    return ("input", "\n".join([*words, "input"]))


def lossy(system):
    return [str(loss) for loss in FORMATS["fml"].write(system)[1] if not loss.exact]


AVERAGE = method("defuzzifier weighted_average")
BENT = method("hedge bent(x) = x^3.5")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ([("else 1", "else hold")], "else hold"),
        ([("else 1", "else nan")], "else nan"),
        ([("else 1", "else 1 adaptive rate 1"), AVERAGE, (TERM_B, "constant(1)")], "adaptive"),
        ([("else 1", "else 1 clamp")], "clamp"),
        ([(TERM_B, "bell(2, 1, 3)")], "written as 101 points"),
        ([method("defuzzifier centroid(resolution=101)")], "grid=midpoint): becomes centroid without samples"),
        ([method("aggregation sum")], "aggregation sum"),
        (
            [method("semantics exact(weight=after)"), ("y is b", "y is b weight 0.5")],
            "weight after: before under 'exact'",
        ),
        ([BENT, ("x is a", "x is bent very a")], "hedge 'bent': FML has no such modifier"),
        (
            [("y is b", "y is very very b")],
            "hedges 'very very': FML has one modifier for a conclusion; they are left out",
        ),
        ([("y is b", "y is not very b")], "hedges 'not very': FML has one modifier for a conclusion; only not is kept"),
        ([AVERAGE, (TERM_B, "function(sin(x * 2))")], "linear functions only"),
    ],
)
def test_losses_are_the_parts_that_fml_has_no_words_for(changes, said):
    assert lossy(changed()) == []
    found = lossy(changed(*changes))
    assert any(said in x for x in found), found


def test_knobs_without_a_use_are_no_loss():
    knobs = "weight=after, merge=terms, chained=degree, equal=0.1, places=free, none_active=range"
    assert FORMATS["fml"].write(changed(method(f"semantics exact({knobs})")))[1] == []


@pytest.mark.parametrize(
    ("term", "written"),
    [
        ("triangle(-inf, 0.25, 1)", '<leftLinearShape param1="0.25" param2="1"/>'),
        ("trapezoid(0.25, 1, 1, inf)", '<rightLinearShape param1="0.25" param2="1"/>'),
        ("ramp(1, 0.25)", '<leftLinearShape param1="0.25" param2="1"/>'),
        ("ramp(0.25, 1)", '<rightLinearShape param1="0.25" param2="1"/>'),
        ("pi_shape(0.25, 1, 2, inf)", '<sShape param1="0.25" param2="1"/>'),
        ("pi_shape(-inf, 0, 0.25, 1)", '<zShape param1="0.25" param2="1"/>'),
        ("trapezoid(-inf, 0, 0.25, inf)", '<point x="0" y="1"/>'),
    ],
)
def test_shoulders_have_shapes_of_their_own(term, written):
    system = changed((TERM_A, term))
    text, lost = write("fml", system)
    assert written in text
    assert lost == []
    places = [v / 8 for v in range(9)]
    assert degrees(read("fml", text), places) == degrees(system, places)


@pytest.mark.parametrize(
    "term",
    [
        *("ramp(0, 3)", "ramp(4, 1)", "triangle(0, 3, inf)", "triangle(2, 2, inf)", "trapezoid(-inf, 0, 1, 3)"),
        *("s_shape(0, 3)", "z_shape(0, 3)", "pi_shape(0, 3, 4, inf)", "gaussian2(3, 1, inf, 2)"),
        *("gaussian2(-inf, 2, 1, 1)", "piecewise(0, 0, 1, 0.8, 4, 1)"),
    ],
)
def test_tsukamotos_terms_are_written_as_monotone_shapes(term):
    system = changed(method("defuzzifier tsukamoto"), (TERM_B, term))
    text, lost = write("fml", system)
    assert lost == []
    points = [[v / 8] for v in range(9)]
    values = pytest.approx(compile(system, "python").batch(points), rel=1e-15, abs=1e-15)
    assert compile(read("fml", text), "python").batch(points) == values


@pytest.mark.parametrize(
    ("system", "reasons"),
    [
        (
            changed(
                method("defuzzifier weighted_average", "semantics exact(consequent_hedges=activation)"),
                *((TERM_B, "constant(1)"), ("y is b", "y is very b")),
            ),
            ["rule 1: a consequent of an average, 'y', has no modifiers"],
        ),
        (
            changed(method("defuzzifier tsukamoto_sum"), (TERM_B, "ramp(0, 3)")),
            ["output 'y': there is no defuzzifier 'tsukamoto_sum'"],
        ),
        *(
            (
                with_membership(changed(), kind=kind, arguments=tuple(map(build.expression, values))),
                ["term 'a' of 'x' has no shape in FML, and no finite degrees to write as points"],
            )
            for kind, values in (("bell", (0, 0, 2)), ("spike", (0, 0)), ("piecewise", (0, 0, 1, math.inf)))
        ),
        (read("fis", SAMPLES["pendulum.fis"]), ["input 'push' has no terms, and every fuzzyVariable has some"]),
    ],
)
def test_a_system_that_no_file_can_hold_is_refused_with_the_reasons(system, reasons):
    with pytest.raises(DiagnosticError) as caught:
        FORMATS["fml"].write(system)
    assert [(d.code, [*d.facts]) for d in caught.value.diagnostics] == [("FZ608", reasons)]


@pytest.mark.parametrize("hedges", ["not very", "very not", "very very very", "not extremely somewhat seldom"])
@pytest.mark.parametrize("norms", [("min", "max"), ("product", "probabilistic_sum")])
def test_several_hedges_are_modifiers_of_terms_that_other_terms_define(hedges, norms):
    both = f"if x is {hedges} a then y is b\nif x is {hedges} a and x is a then y is b"
    system = changed(method(f"and {norms[0]}", f"or {norms[1]}"), (RULE, both))
    text, losses = FORMATS["fml"].write(system)
    assert losses == []
    assert rules("fml", text) == both.splitlines()


def test_a_hedge_without_a_modifier_leaves_the_others():
    text, lost = write("fml", changed(BENT, ("x is a", "x is bent very a")))
    assert lost == ["hedge 'bent'"]
    assert rules("fml", text) == ["if x is very a then y is b"]


@pytest.mark.parametrize("word", ["plus", "intensify", "slightly"])
def test_hedges_that_are_modifiers_of_the_standard_are_known_by_their_formula(word):
    text, _ = write("fml", changed((RULE, f"{RULE}\n{RULE}")))
    for modifier in (word, "extremely"):
        text = text.replace("<clause><variable>x<", f'<clause modifier="{modifier}"><variable>x<', 1)
    system = read("fml", text)
    renamed = loads(dumps(system).replace(system.hedges[0].name, "mine"))
    assert renamed.hedges[0].name == "mine"
    assert FORMATS["fml"].write(renamed) == (text, [])


@pytest.mark.parametrize(("term", "exact"), [("ramp(0, 1)", True), ("gaussian(0, 1)", False)])
def test_inputs_that_are_not_held_are_a_loss_where_their_terms_go_on(term, exact):
    system = changed((TERM_A, term), ("in [0, 1]", "in [0, 1] extrapolate"))
    (loss,) = FORMATS["fml"].write(system)[1]
    assert (loss.what, loss.exact) == ("values outside the range", exact)


def test_linear_consequents_begin_with_their_constant():
    system = changed(AVERAGE, (TERM_B, "linear(3, 2)"))
    text, lost = write("fml", system)
    assert '<tskTerm name="b" order="1">\n        <tskValue>2</tskValue>\n        <tskValue>3</tskValue>' in text
    assert lost == []
    assert read("fml", text).outputs[0].terms == system.outputs[0].terms


@pytest.mark.parametrize(
    "term", ["sigmoid(500, -5)", "sigmoid_difference(200, 40, 30, 800)", "bell(500, 0.001, 60)", "function(sin(x)^2)"]
)
def test_curves_over_a_wide_range_are_written_as_points(term):
    system = changed(("in [0, 1]", "in [0, 1000]"), (TERM_A, term))
    text, lost = write("fml", system)
    assert lost == ["term 'a'"]
    places = range(0, 1001, 10)
    assert degrees(read("fml", text), places) == degrees(system, places)


@pytest.mark.parametrize(("knob", "degree"), [("magnitude", 1 / (1 + math.exp(2.1))), ("clamped", 0.0)])
def test_points_have_the_degrees_that_the_system_computes(knob, degree):
    system = changed(
        *(method(f"semantics exact(sigmoid_difference={knob})"), ("in [0, 1]", "in [0, 10]")),
        (TERM_A, "sigmoid_difference(3.8, 4.4, 0.7, 3)"),
    )
    # At 0 the difference is negative.
    assert degrees(read("fml", write("fml", system)[0]), [0]) == pytest.approx([degree], abs=1e-6)
