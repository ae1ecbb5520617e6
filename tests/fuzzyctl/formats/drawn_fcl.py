"""Systems drawn at random that FCL can express."""

import hypothesis.strategies as st

from fuzzyctl.expr import ONE, Number
from fuzzyctl.formats.common.words import DUAL_OF
from fuzzyctl.model.method import Method
from fuzzyctl.model.profiles import PROFILES
from fuzzyctl.model.rule import And, Consequent, Is, Not, Or, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Hold, Input, Output
from tests.fuzzyctl.formats.drawn_parts import variables

CONJUNCTIONS = ("min", "product", "bounded_difference")
NAMES = ["low", "Mid", "high_1", "x", "NB"]


@st.composite
def antecedents(draw, inputs, hedges, depth=0):
    form = draw(st.sampled_from(["is", "is", "and", "or", "not"] if depth < 3 else ["is"]))
    if form == "is":
        variable = draw(st.sampled_from(inputs))
        term = draw(st.sampled_from(variable.terms)).name
        return Is(variable=variable.name, term=term, hedges=tuple(draw(st.lists(st.sampled_from(hedges), max_size=2))))
    if form == "not":
        return Not(operand=draw(antecedents(inputs, hedges, depth + 1)))
    operands = draw(st.lists(antecedents(inputs, hedges, depth + 1), min_size=2, max_size=3))
    return (And if form == "and" else Or)(operands=tuple(operands))


@st.composite
def systems(draw):
    """Draw systems that FCL can express, with the numerics of each dialect."""
    profile = PROFILES[draw(st.sampled_from(["exact", "jfuzzylogic", "fuzzylite"]))]
    # The standard, whose numerics are exact, has points only; what else is straight comes back as points.
    straight = ["piecewise"] if profile.name == "exact" else ["piecewise", "triangle", "trapezoid"]
    curved = [] if profile.name == "exact" else ["gaussian", "bell", "sigmoid", "cosine"]
    more = (
        ["ramp", "rectangle", "s_shape", "pi_shape", "sigmoid_product", "spike"] if profile.name == "fuzzylite" else []
    )
    hedges = ["not", "very", "seldom"] if profile.name == "fuzzylite" else ["not"]
    inputs = tuple(
        draw(variables(name, straight + curved + more, NAMES, Input, extrapolate=True)) for name in ("angle", "rate")
    )
    averaged = draw(st.booleans())
    kind = "weighted_average" if averaged else draw(st.sampled_from(["centroid", "bisector", "som", "lom", "mom"]))
    starts = [Hold(start="nan"), Number(2.5)]
    starts += [] if profile.name == "jfuzzylogic" else ["nan"]
    starts += [Hold(start=Number(-1.0))] if profile.name == "fuzzylite" else []
    output = draw(
        variables(
            "force",
            ["singleton"] if averaged else straight + curved + more,
            NAMES,
            Output,
            otherwise=draw(st.sampled_from(starts)),
        )
    )
    conjunction = draw(st.sampled_from(CONJUNCTIONS))
    semantics = profile.semantics
    rules = tuple(
        Rule(
            antecedent=draw(antecedents(inputs, hedges)),
            consequents=(Consequent(output="force", term=draw(st.sampled_from(output.terms)).name),),
            weight=draw(st.sampled_from([ONE, Number(0.25)])),
        )
        for _ in range(draw(st.integers(1, 4)))
    )
    return FuzzySystem(
        name="drawn",
        method=Method(
            conjunction=conjunction,
            disjunction=DUAL_OF[conjunction],
            implication="min" if averaged else draw(st.sampled_from(["min", "product"])),
            aggregation="sum" if averaged else draw(st.sampled_from(["max", "bounded_sum", "sum"])),
            defuzzifier=profile.defuzzifier(kind),
            semantics=semantics,
        ),
        inputs=inputs,
        outputs=(output,),
        blocks=rules,
    )
