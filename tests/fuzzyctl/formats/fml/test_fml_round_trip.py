"""Systems written as FML read back as they were, and no text breaks the reader."""

import math

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.expr import ONE, Binary, Call, Name, Number
from fuzzyctl.formats.common.identifiers import as_read
from fuzzyctl.formats.fml import read, write
from fuzzyctl.formats.fml.vocabulary import HEDGES, MODIFIERS
from fuzzyctl.kernels.compile import compile as compile_system
from fuzzyctl.kernels.compile import degree_function
from fuzzyctl.loading.load import loads
from fuzzyctl.model.block import Hedge
from fuzzyctl.model.checks.checks import check_model
from fuzzyctl.model.method import Defuzzifier, Method, Semantics
from fuzzyctl.model.rule import And, Consequent, Is, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, Membership, Output, Term
from tests.effort import at_most
from tests.fuzzyctl.formats.drawn_fml import systems
from tests.fuzzyctl.formats.drawn_parts import number
from tests.sizes import examples


def read_back(text):
    system, diagnostics = read(SourceText("drawn.fml", text))
    assert system is not None, [(str(d.span), d.message) for d in diagnostics]
    return system


@settings(deadline=None, max_examples=examples(60), suppress_health_check=list(HealthCheck))
@given(systems())
def test_what_is_written_reads_back_as_the_same_system(system):
    assume(not any(d.severity == "error" and d.code != "FZ214" for d in check_model(system)))
    text, losses = write(system)
    assert losses == [], text
    back = read_back(text)
    assert back == as_read(system)[0], text
    assert read_back(write(back)[0]) == back


def minimal(**update):
    x = Input(name="x", lower=number(0), upper=number(1), terms=(term("a", "triangle", 0, 0, 1),))
    y = Output(name="y", lower=number(0), upper=number(4), terms=(term("b", "triangle", 0, 1, 1),), otherwise=ONE)
    rule = Rule(antecedent=Is(variable="x", term="a"), consequents=(Consequent(output="y", term="b"),))
    return FuzzySystem(**({"name": "m", "inputs": (x,), "outputs": (y,), "blocks": (rule,)} | update))


def term(name, kind, *values, height=1):
    membership = Membership(kind=kind, arguments=tuple(map(number, values)), height=number(height))
    return Term(name=name, membership=membership)


def with_output(**update):
    return minimal(outputs=(minimal().outputs[0].model_copy(update=update),))


def hedged(*hedges, own=False):
    if own:
        bent = Hedge(name="bent", parameter="x", expression=Binary("^", Name("x"), Number(3.5)))
        return hedged("bent", *hedges).model_copy(update={"hedges": (bent,)})
    return minimal(
        blocks=(minimal().blocks[0].model_copy(update={"antecedent": Is(variable="x", term="a", hedges=hedges)}),)
    )


def concluding(*hedges):
    consequent = Consequent(output="y", term="b", hedges=hedges)
    return minimal(blocks=(minimal().blocks[0].model_copy(update={"consequents": (consequent,)}),))


def lossy(system):
    return [str(x) for x in write(system)[1] if not x.exact]


@pytest.mark.parametrize(
    ("system", "said"),
    [
        (with_output(otherwise=Hold()), "else hold"),
        (with_output(otherwise="nan"), "else nan"),
        (with_output(adaptive=ONE), "adaptive"),
        (with_output(clamped=True), "clamp"),
        (with_output(terms=(term("b", "bell", 2, 1, 3),)), "written as 101 points"),
        (
            minimal(method=Method(defuzzifier=Defuzzifier(resolution=101))),
            "grid=midpoint): becomes centroid without samples",
        ),
        (minimal(method=Method(aggregation="sum")), "aggregation sum"),
        (
            minimal(
                method=Method(semantics=Semantics(weight="after")),
                blocks=(minimal().blocks[0].model_copy(update={"weight": Number(0.5)}),),
            ),
            "weight after: before under 'exact'",
        ),
        (hedged("very", own=True), "hedge 'bent': FML has no such modifier"),
        (concluding("very", "very"), "hedges 'very very': FML has one modifier for a conclusion; they are left out"),
        (concluding("not", "very"), "hedges 'not very': FML has one modifier for a conclusion; only not is kept"),
    ],
    ids=lambda v: v if isinstance(v, str) else "",
)
def test_what_fml_has_no_words_for_is_said(system, said):
    assert lossy(minimal()) == []
    assert any(said in x for x in lossy(system)), lossy(system)


def test_knobs_that_nothing_uses_are_no_loss():
    unused = Semantics(weight="after", merge="terms", chained="degree", equal=0.1, places="free", none_active="range")
    assert write(minimal(method=Method(semantics=unused)))[1] == []


@pytest.mark.parametrize(
    ("kind", "values", "written"),
    [
        ("triangle", (-math.inf, 0.25, 1), '<leftLinearShape param1="0.25" param2="1"/>'),
        ("trapezoid", (0.25, 1, 1, math.inf), '<rightLinearShape param1="0.25" param2="1"/>'),
        ("ramp", (1, 0.25), '<leftLinearShape param1="0.25" param2="1"/>'),
        ("ramp", (0.25, 1), '<rightLinearShape param1="0.25" param2="1"/>'),
        ("pi_shape", (0.25, 1, 2, math.inf), '<sShape param1="0.25" param2="1"/>'),
        ("pi_shape", (-math.inf, 0, 0.25, 1), '<zShape param1="0.25" param2="1"/>'),
        ("trapezoid", (-math.inf, 0, 0.25, math.inf), '<point x="0" y="1"/>'),
    ],
)
def test_shoulders_have_shapes_of_their_own(kind, values, written):
    x = minimal().inputs[0].model_copy(update={"terms": (term("a", kind, *values),)})
    text, losses = write(minimal(inputs=(x,)))
    assert written in text
    assert all(x.exact for x in losses)
    before, after = compile_system(minimal(inputs=(x,))), compile_system(read_back(text))
    assert [after(v / 8) for v in range(9)] == [before(v / 8) for v in range(9)]


MONOTONE = [
    ("ramp", (0, 3)),
    ("ramp", (4, 1)),
    ("triangle", (0, 3, math.inf)),
    ("triangle", (2, 2, math.inf)),
    ("trapezoid", (-math.inf, 0, 1, 3)),
    ("s_shape", (0, 3)),
    ("z_shape", (0, 3)),
    ("pi_shape", (0, 3, 4, math.inf)),
    ("gaussian2", (3, 1, math.inf, 2)),
    ("gaussian2", (-math.inf, 2, 1, 1)),
    ("piecewise", (0, 0, 1, 0.8, 4, 1)),
]


@pytest.mark.parametrize(("kind", "values"), MONOTONE)
def test_tsukamotos_terms_are_written_as_monotone_shapes(kind, values):
    method = Method(defuzzifier=Defuzzifier(kind="tsukamoto"), aggregation="sum")
    system = minimal(
        outputs=(minimal().outputs[0].model_copy(update={"terms": (term("b", kind, *values),)}),), method=method
    )
    text, losses = write(system)
    assert [x for x in losses if not x.exact] == []
    again = read_back(text)
    assert not [d for d in check_model(again) if d.severity == "error"]
    before, after = compile_system(system), compile_system(again)
    places = [v / 8 for v in range(9)]
    assert [after(v) for v in places] == pytest.approx([before(v) for v in places], rel=1e-15, abs=1e-15)


def test_what_no_file_can_hold_is_reported_with_all_reasons_before_anything_is_written():
    rule = minimal().blocks[0]
    hedged = rule.model_copy(update={"consequents": (Consequent(output="y", term="b", hedges=("very",)),)})
    empty = Input(name="z", lower=number(0), upper=number(1), terms=())
    method = Method(defuzzifier=Defuzzifier(kind="weighted_average"), aggregation="sum")
    with pytest.raises(DiagnosticError) as caught:
        write(minimal(inputs=(minimal().inputs[0], empty), blocks=(hedged,), method=method))
    (found,) = caught.value.diagnostics
    assert found.code == "FZ608"
    assert found.facts == (
        "input 'z' has no terms, and every fuzzyVariable has some",
        "rule 1: a consequent of an average, 'y', has no modifiers",
    )
    with pytest.raises(DiagnosticError) as caught:
        write(with_output(defuzzifier=Defuzzifier(kind="tsukamoto_sum")))
    assert caught.value.diagnostics[0].facts == ("output 'y': there is no defuzzifier 'tsukamoto_sum'",)


WITHOUT_DEGREES = [("bell", 0, 0, 2), ("spike", 0, 0), ("piecewise", 0, 0, 1, math.inf)]


@pytest.mark.parametrize("parameters", WITHOUT_DEGREES)
def test_a_term_without_finite_degrees_is_refused(parameters):
    x = minimal().inputs[0].model_copy(update={"terms": (term("a", *parameters),)})
    with pytest.raises(DiagnosticError) as caught:
        write(minimal(inputs=(x,)))
    (refusal,) = caught.value.diagnostics
    reason = "term 'a' of 'x' has no shape in FML, and no finite degrees to write as points"
    assert (refusal.code, refusal.facts) == ("FZ608", (reason,))


@pytest.mark.parametrize(
    "hedges", [("not", "very"), ("very", "not"), ("very", "very", "very"), ("not", "extremely", "somewhat", "seldom")]
)
@pytest.mark.parametrize("norms", [("min", "max"), ("product", "probabilistic_sum")])
def test_several_hedges_are_modifiers_of_terms_that_other_terms_define(hedges, norms):
    conjunction, disjunction = norms
    both = And(operands=(Is(variable="x", term="a", hedges=hedges), Is(variable="x", term="a")))
    method = Method(conjunction=conjunction, disjunction=disjunction)
    system = hedged(*hedges).model_copy(update={"method": method})
    system = system.model_copy(
        update={"blocks": (*system.blocks, system.blocks[0].model_copy(update={"antecedent": both}))}
    )
    text, losses = write(system)
    assert losses == []
    assert [r.antecedent for r in read_back(text).rules] == [r.antecedent for r in system.rules]


def test_a_hedge_without_a_modifier_leaves_the_others():
    text, losses = write(hedged("very", own=True))
    assert [x.what for x in losses] == ["hedge 'bent'"]
    assert read_back(text).rules[0].antecedent == Is(variable="x", term="a", hedges=("very",))


@pytest.mark.parametrize("word", [word for word, name in MODIFIERS.items() if name in HEDGES])
def test_hedges_that_are_modifiers_of_the_standard_are_known_by_what_they_do(word):
    own = HEDGES[MODIFIERS[word]].model_copy(update={"name": "mine"})
    system = hedged("mine").model_copy(
        update={"hedges": (own,), "method": Method(semantics=Semantics(extremely="cube"))}
    )
    text, losses = write(system)
    assert f'<clause modifier="{word}">' in text
    assert losses == []


@pytest.mark.parametrize(("kind", "values", "exact"), [("ramp", (0, 1), True), ("gaussian", (0, 1), False)])
def test_inputs_that_are_not_held_are_a_loss_where_their_terms_go_on(kind, values, exact):
    x = minimal().inputs[0].model_copy(update={"terms": (term("a", kind, *values),), "extrapolate": True})
    (loss,) = write(minimal(inputs=(x,)))[1]
    assert loss.what == "values outside the range"
    assert loss.exact is exact


def test_linear_consequents_begin_with_their_constant_and_functions_are_a_loss():
    linear = Term(name="b", membership=Membership(kind="linear", arguments=(number(3), number(2))))
    method = Method(defuzzifier=Defuzzifier(kind="weighted_average"), aggregation="sum")
    system = minimal(outputs=(minimal().outputs[0].model_copy(update={"terms": (linear,)}),), method=method)
    text, losses = write(system)
    assert '<tskTerm name="b" order="1">\n        <tskValue>2</tskValue>\n        <tskValue>3</tskValue>' in text
    assert losses == []
    assert read_back(text) == system
    wave = Membership(kind="function", arguments=(Call("sin", (Binary("*", Name("x"), Number(2.0)),)),))
    function = minimal(
        outputs=(minimal().outputs[0].model_copy(update={"terms": (Term(name="b", membership=wave),)}),), method=method
    )
    assert "linear functions only" in lossy(function)[0]


WORDS = st.sampled_from(
    ["<", ">", "/>", "</", "fuzzySystem", "knowledgeBase", "&amp;", "&x;", '"', "name=", "param1=", "<!--", "<![CDATA["]
)


@settings(deadline=None, max_examples=examples(200))
@given(st.data())
def test_any_change_of_a_file_is_read_or_reported(data):
    text, _ = write(minimal())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text)))
        until = min(len(text), at + data.draw(st.integers(0, 40)))
        text = text[:at] + data.draw(st.text(max_size=6) | WORDS) + text[until:]
    with at_most(20):
        system, diagnostics = read(SourceText("x.fml", text))
        assert system is not None or diagnostics


def test_a_large_file_takes_bounded_time():
    text, _ = write(minimal())
    head, tail = text.split("    <rule ", 1)
    rule, end = tail.split("</rule>\n", 1)
    with at_most(20):
        system = read_back(head + ("    <rule " + rule + "</rule>\n") * 2000 + end)
        assert len(system.rules) == 2000
        read(SourceText("x.fml", "<fuzzySystem>" + "<x/>" * 100_000 + "</fuzzySystem>"))


CURVES = ["sigmoid(500, -5)", "sigmoid_difference(200, 40, 30, 800)", "bell(500, 0.001, 60)", "function(sin(x)^2)"]


@pytest.mark.parametrize("term", CURVES)
def test_curves_over_a_wide_range_are_written_as_points(term):
    output = "output y in [0, 1]\n  l = triangle(0, 0.2, 0.4)\n"
    system = loads(f"system s\ninput x in [0, 1000]\n  a = {term}\n{output}if x is a then y is l\n")
    text, losses = write(system)
    assert [x.what for x in losses if not x.exact] == ["term 'a'"]
    before, after = (degree_function(s, s.inputs[0], s.inputs[0].terms[0]) for s in (system, read_back(text)))
    assert [after(x) for x in range(0, 1001, 10)] == [before(x) for x in range(0, 1001, 10)]


@pytest.mark.parametrize(("knob", "degree"), [("magnitude", 1 / (1 + math.exp(7.49))), ("clamped", 0.0)])
def test_points_have_the_degrees_that_the_system_computes(knob, degree):
    text = f"system s\nsemantics exact (sigmoid_difference={knob})\ninput x in [0, 10]\n"
    text += "  a = sigmoid_difference(3.8, 4.4, 10.7, 0.7)\noutput y in [0, 1]\n  l = triangle(0, 0.2, 0.4)\n"
    written, _ = write(loads(text + "if x is a then y is l\n"))
    arguments = read_back(written).inputs[0].terms[0].membership.arguments
    assert arguments[1].value == pytest.approx(degree, abs=1e-6)  # at 0, where the difference is negative
