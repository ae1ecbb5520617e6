"""What is written as `.fis` or `.fll` is read back as the same system; what cannot be written is said."""

import math
from pathlib import Path

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from fuzzyctl.errors import DiagnosticError, render_all
from fuzzyctl.expr import ONE, Number
from fuzzyctl.formats.registry import FORMATS, format_of
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.loading import loads
from fuzzyctl.model.method import Activation, Method
from fuzzyctl.model.profiles import profile
from fuzzyctl.model.rule import And, Consequent, Is, Or, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, Membership, Output, Term
from fuzzyctl.source import SourceText

SAMPLES = sorted((Path(__file__).parent / "samples").glob("*.f[il][sl]"))

NORMS = [
    ("min", "max"),
    ("product", "probabilistic_sum"),
    ("bounded_difference", "bounded_sum"),
    ("drastic_product", "drastic_sum"),
    ("einstein_product", "einstein_sum"),
    ("hamacher_product", "hamacher_sum"),
]

#: Names as people choose them.
ODD = ["service", "Age_(years)", "cloth amount", "it's", "Sınav Sonucu", "a'b''c", "x:y", "100%", "[1]", "#1", "a;b,c"]


def read(format, text):
    systems, diagnostics = FORMATS[format].read(SourceText(f"t.{format}", text))
    assert systems, f"{render_all(diagnostics)}\n{text}"
    return systems[0], diagnostics


def numbers(low, high):
    return st.one_of(st.floats(low, high, allow_nan=False), st.sampled_from([low, high, (low + high) / 3])).map(
        lambda x: Number(x + 0.0)
    )


@st.composite
def memberships(draw, kinds, *, heights=False):
    formula = MEMBERSHIP[draw(st.sampled_from(kinds))]
    values = sorted(draw(st.lists(st.floats(0.1, 9.9), min_size=4, max_size=4, unique=True)))
    count = 2 if formula.variadic else len(formula.parameters)
    parameters = values[:count] if not formula.variadic else [values[0], 0.25, values[1], 1 / 3, values[2], 1.0]
    assume(formula.mistake(tuple(parameters)) is None)
    height = draw(st.sampled_from([ONE, Number(0.5), Number(1 / 3)])) if heights else ONE
    return Membership(kind=formula.name, arguments=tuple(map(Number, parameters)), height=height)


@st.composite
def terms(draw, kinds, names, *, heights=False):
    count = draw(st.integers(1, 3))
    chosen = draw(st.lists(st.sampled_from(names), min_size=count, max_size=count, unique=True))
    return tuple(Term(name=n, membership=draw(memberships(kinds, heights=heights))) for n in chosen)


MATLAB = ["triangle", "trapezoid", "gaussian", "gaussian2", "bell", "sigmoid", "s_shape", "z_shape", "pi_shape"]
FUZZYLITE = [*MATLAB, "rectangle", "ramp", "piecewise", "concave", "cosine", "spike", "arc", "semi_ellipse"]


@st.composite
def literals(draw, inputs, hedges):
    variable = draw(st.sampled_from(inputs))
    given = draw(st.lists(st.sampled_from(hedges), max_size=2)) if hedges else []
    term = draw(st.sampled_from([t.name for t in variable.terms]))
    if "any" in given:  # nothing is written behind it
        given, term = given[: given.index("any") + 1], variable.terms[0].name
    return Is(variable=variable.name, term=term, hedges=tuple(given))


@st.composite
def fis_rules(draw, inputs, outputs, *, negated):
    """Draw a rule as the format has them: every variable once, all joined by one connective."""
    used = draw(st.lists(st.sampled_from(range(len(inputs))), min_size=1, unique=True).map(sorted))
    operands = []
    for i in used:
        hedges = draw(st.sampled_from([(), ("not",)]))
        operands.append(Is(variable=inputs[i].name, term=draw(st.sampled_from(inputs[i].terms)).name, hedges=hedges))
    kind = draw(st.sampled_from([And, Or]))
    set_ = draw(st.lists(st.sampled_from(range(len(outputs))), min_size=1, unique=True).map(sorted))
    consequents = tuple(
        Consequent(
            output=outputs[i].name,
            term=draw(st.sampled_from(outputs[i].terms)).name,
            hedges=draw(st.sampled_from([(), ("not",)])) if negated else (),
        )
        for i in set_
    )
    antecedent = operands[0] if len(operands) == 1 else kind(operands=tuple(operands))
    weight = draw(st.sampled_from([ONE, Number(0.25), Number(1 / 3)]))
    return Rule(antecedent=antecedent, consequents=consequents, weight=weight)


@st.composite
def matlab_systems(draw):
    sugeno = draw(st.booleans())
    count = draw(st.integers(1, 3))
    names = draw(st.lists(st.sampled_from(ODD), min_size=count + 2, max_size=count + 2, unique=True))
    inputs = tuple(
        Input(name=n, lower=Number(-1.5), upper=draw(numbers(10, 20)), terms=draw(terms(MATLAB, ODD)), extrapolate=True)
        for n in names[:count]
    )
    matlab = profile("matlab")
    outputs = []
    for n in names[count:]:
        made = draw(terms(MATLAB, ODD))
        if sugeno:
            linear = Membership(kind="linear", arguments=tuple(draw(numbers(-2, 2)) for _ in range(count + 1)))
            constant = Membership(kind="constant", arguments=(draw(numbers(-9, 9)),))
            made = tuple(t.model_copy(update={"membership": draw(st.sampled_from([linear, constant]))}) for t in made)
        outputs.append(Output(name=n, lower=Number(0.0), upper=Number(30.0), terms=made, otherwise="midpoint"))
    conjunction, disjunction = draw(st.sampled_from(NORMS[:2]))
    kind = draw(
        st.sampled_from(["weighted_average", "weighted_sum"] if sugeno else ["centroid", "bisector", "mom", "som"])
    )
    method = Method(
        conjunction=conjunction,
        disjunction=disjunction,
        implication=draw(st.sampled_from(["min", "product"])),
        aggregation=draw(st.sampled_from(["max", "sum", "probabilistic_sum"])),
        defuzzifier=matlab.defuzzifier(kind),
        semantics=matlab.semantics,
    )
    rules = tuple(draw(st.lists(fis_rules(inputs, outputs, negated=not sugeno), min_size=1, max_size=4)))
    return FuzzySystem(
        name=draw(st.sampled_from(ODD)), method=method, inputs=inputs, outputs=tuple(outputs), blocks=rules
    )


NAMES = ["low", "mid", "HIGH_1", "é", "Z"]
HEDGES = ["not", "very", "somewhat", "extremely", "seldom", "any"]


@st.composite
def antecedents(draw, inputs, depth=2):
    if depth == 0 or draw(st.booleans()):
        return draw(literals(inputs, HEDGES))
    kind = draw(st.sampled_from([And, Or]))
    operands = draw(st.lists(antecedents(inputs, depth - 1), min_size=2, max_size=3))
    # A group within one of its kind is read as one group.
    return kind(operands=tuple(p for o in operands for p in (o.operands if type(o) is kind else (o,))))


ACTIVATIONS = st.sampled_from(
    [
        Activation(),
        Activation(kind="proportional"),
        Activation(kind="first", count=2, threshold=Number(0.25)),
        Activation(kind="highest", count=1),
        Activation(kind="threshold", comparison=">=", threshold=Number(1 / 3)),
    ]
)


@st.composite
def fuzzylite_inputs(draw):
    return tuple(
        Input(
            name=n,
            label=draw(st.sampled_from(["", "How good it is"])),
            lower=Number(-1.5),
            upper=draw(numbers(10, 20)),
            terms=draw(terms(FUZZYLITE, NAMES, heights=True)),
            extrapolate=draw(st.booleans()),
        )
        for n in ["a", "b1"][: draw(st.integers(1, 2))]
    )


@st.composite
def fuzzylite_outputs(draw, tool, count):
    """Draw outputs of systems with some number of inputs."""
    return tuple(
        Output(
            name=n,
            lower=Number(0.0),
            upper=Number(10.0),
            otherwise=draw(st.sampled_from(["nan", Number(0.75), Hold(start="nan"), Hold(start=Number(2.0))])),
            clamped=draw(st.booleans()),
            aggregation=draw(st.sampled_from(["sum", "max", "bounded_sum"])),
            **draw(made_crisp(tool, count)),
        )
        for n in ["y", "z"][: draw(st.integers(1, 2))]
    )


@st.composite
def made_crisp(draw, tool, count):
    """Draw a defuzzifier and terms that it takes."""
    kind = draw(st.sampled_from(["centroid", "bisector", "som", "lom", "mom", "weighted_average", "weighted_sum"]))
    made = draw(terms(FUZZYLITE, NAMES, heights=True))
    if kind.startswith("weighted"):
        linear = Membership(kind="linear", arguments=tuple(draw(numbers(-2, 2)) for _ in range(count + 1)))
        made = tuple(t.model_copy(update={"membership": linear}) for t in made)
    defuzzifier = tool.defuzzifier(kind)
    if defuzzifier.resolution is not None:
        defuzzifier = defuzzifier.model_copy(update={"resolution": draw(st.sampled_from([50, 1000]))})
    return {"terms": made, "defuzzifier": defuzzifier}


@st.composite
def fuzzylite_methods(draw, tool, first):
    """Draw a method of which one output has the aggregation and the defuzzifier."""
    conjunction, disjunction = draw(st.sampled_from(NORMS))
    return Method(
        conjunction=conjunction,
        disjunction=disjunction,
        implication=draw(st.sampled_from(["min", "product", "nilpotent_minimum"])),
        aggregation=first.aggregation,
        activation=draw(ACTIVATIONS),
        defuzzifier=first.defuzzifier,
        semantics=tool.semantics,
    )


@st.composite
def fuzzylite_rules(draw, inputs, outputs):
    consequents = tuple(
        Consequent(
            output=o.name,
            term=draw(st.sampled_from(o.terms)).name,
            hedges=tuple(draw(st.lists(st.sampled_from(HEDGES), max_size=2))),
        )
        for o in outputs
    )
    weight = draw(st.sampled_from([ONE, Number(0.25), Number(1 / 3)]))
    return Rule(antecedent=draw(antecedents(inputs)), consequents=consequents, weight=weight)


@st.composite
def fuzzylite_systems(draw):
    tool = profile(draw(st.sampled_from(["fuzzylite", "fuzzylite_6", "pyfuzzylite"])))
    inputs = draw(fuzzylite_inputs())
    outputs = draw(fuzzylite_outputs(tool, len(inputs)))
    method = draw(fuzzylite_methods(tool, outputs[0]))
    return FuzzySystem(
        name="drawn",
        title=draw(st.sampled_from(["", "(a, b) -> y"])),
        method=method,
        inputs=inputs,
        outputs=tuple(_own(o, method) for o in outputs),
        blocks=tuple(draw(st.lists(fuzzylite_rules(inputs, outputs), min_size=1, max_size=3))),
    )


def _own(output, method):
    """Return an output without what the method says for it."""
    same = {f: None for f in ("aggregation", "defuzzifier") if getattr(output, f) == getattr(method, f)}
    return output.model_copy(update=same)


QUICK = settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much]
)


@QUICK
@given(matlab_systems())
def test_a_system_with_the_numerics_of_matlab_survives_a_fis_file(system):
    text, losses = FORMATS["fis"].write(system)
    assert [str(x) for x in losses if not x.exact] == []
    back, diagnostics = read("fis", text)
    assert diagnostics == [], render_all(diagnostics)
    assert back == system
    assert FORMATS["fis"].write(back)[0] == text


@QUICK
@given(fuzzylite_systems())
def test_a_system_with_the_numerics_of_fuzzylite_survives_an_fll_file(system):
    text, losses = FORMATS["fll"].write(system)
    assert [str(x) for x in losses if not x.exact] == []
    back, diagnostics = read("fll", text)
    assert diagnostics == [], render_all(diagnostics)
    assert back == system
    assert FORMATS["fll"].write(back)[0] == text


@pytest.mark.parametrize("path", SAMPLES, ids=lambda p: p.name)
def test_samples_survive_their_own_format(path):
    format = format_of(path.name)
    first, _ = read(format.name, path.read_text(encoding="utf-8"))
    text, losses = format.write(first)
    assert [str(x) for x in losses if not x.exact] == []
    back, _ = read(format.name, text)
    assert back == first


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
            ("system 'tip'", "guarantees"),
            ("system 'tip'", "params steep"),
            ("system 'tip'", "the source"),
            ("system 'tip'", "units"),
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
        back, _ = read("fis", text)
        for degree in (0.0, 2.5, 5.5, 8.0, 9.9):
            assert back(service=degree, food=3.0) == pytest.approx(loads(plain)(service=degree, food=3.0), abs=0.05)

    def test_an_average_of_sets_is_written_as_an_average_of_their_middles(self):
        text = TIP.replace("param steep", "defuzzifier center_average\nparam steep").replace("not (", "(")
        system = loads(text.replace("height=0.5", "height=1"))
        for format in ("fis", "fll"):
            text, losses = FORMATS[format].write(system)
            assert [str(x) for x in losses if not x.exact] == []
            back, _ = read(format, text)
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
            back, _ = read(format, text)
            assert math.isclose(back.rules[1].weight.value, third, rel_tol=0)

    @pytest.mark.parametrize(
        ("old", "new", "lost"),
        [
            ("is poor or", "is very poor or", ("rule 1", "hedges 'very'")),
            ("param steep", "and einstein_product\nparam steep", ("system 'tip'", "norm 'einstein_product'")),
        ],
    )
    def test_what_only_octave_reads_is_written_for_octave_and_told(self, old, new, lost):
        text = TIP.replace(old, new, 1).replace("if not (service is poor or food is bad)", "if service is good")
        written, losses = FORMATS["fis"].write(loads(text))
        assert lost in [(x.where, x.what) for x in losses if not x.exact]
        assert ("output 'tip'", "else a value") in [(x.where, x.what) for x in losses]
        back, _ = read("fis", written)
        assert back.method.semantics == profile("octave").semantics
