"""Systems drawn at random with the numerics of MATLAB and of fuzzylite, as their formats can express them."""

import hypothesis.strategies as st
from hypothesis import assume

from fuzzyctl.expr import ONE, Number
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.model.method import Activation, Method
from fuzzyctl.model.profiles import profile
from fuzzyctl.model.rule import And, Consequent, Is, Or, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, Membership, Output, Term

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
    """Draw a method whose aggregation and defuzzifier are those of one output."""
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
