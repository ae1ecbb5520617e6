"""Systems drawn at random that FML can express."""

import hypothesis.strategies as st
from hypothesis import assume

from fuzzyctl.expr import ONE, Number
from fuzzyctl.model.method import Defuzzifier, Method, Semantics
from fuzzyctl.model.rule import And, Consequent, Is, Not, Or, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Output
from tests.fuzzyctl.formats.drawn_parts import NUMBERS, number, variables

SETS = ("triangle", "trapezoid", "gaussian", "rectangle", "s_shape", "z_shape", "piecewise")
NAMES = ["low", "Mid", "über alles", "a<b & 'c' \"d\"", "NB"]


def measured(name, kinds, make, **more):
    """A variable that may have a unit."""
    units = st.sampled_from(["", "%", "rad/s"])
    return units.flatmap(lambda unit: variables(name, kinds, NAMES, make, unit=unit, **more))


@st.composite
def literals(draw, inputs):
    variable = draw(st.sampled_from(inputs))
    hedges = draw(st.sampled_from([(), (), ("not",), ("very",), ("slightly",), ("extremely",), ("not", "very", "any")]))
    return Is(variable=variable.name, term=draw(st.sampled_from(variable.terms)).name, hedges=hedges)


@st.composite
def antecedents(draw, inputs):
    """Draw conditions joined by one connector, whose parts may be trees of pairs."""
    kind = draw(st.sampled_from([None, And, Or]))
    if kind is None:
        return draw(literals(inputs))
    parts = st.one_of(literals(inputs), pairs(inputs, 2), pairs(inputs, 1).map(lambda a: Not(operand=a)))
    return kind(operands=tuple(draw(st.lists(parts, min_size=2, max_size=3))))


@st.composite
def pairs(draw, inputs, depth):
    deeper = pairs(inputs, depth - 1) if depth > 1 else literals(inputs)
    part = st.one_of(literals(inputs), deeper, deeper.map(lambda a: a if isinstance(a, Is) else Not(operand=a)))
    operands = draw(part), draw(part)
    assume(operands[0] != operands[1])  # a condition joined with itself is read as itself, where it is modified
    return draw(st.sampled_from([And, Or]))(operands=operands)


@st.composite
def systems(draw):
    inputs = tuple(draw(measured(name, (*SETS, "singleton"), Input)) for name in ("angle", "rate in °/s"))
    averaged = draw(st.booleans())
    defuzzifier = (
        "weighted_average" if averaged else draw(st.sampled_from(["centroid", "bisector", "som", "lom", "mom"]))
    )
    output = draw(measured("force", ["constant"] if averaged else SETS, Output, otherwise=draw(NUMBERS.map(number))))
    rules = tuple(
        Rule(
            antecedent=draw(antecedents(inputs)),
            consequents=(Consequent(output="force", term=draw(st.sampled_from(output.terms)).name),),
            weight=draw(st.sampled_from([ONE, Number(0.25)])),
        )
        for _ in range(draw(st.integers(1, 4)))
    )
    uses = " ".join(map(repr, rules))
    return FuzzySystem(
        name="drawn <1>",
        method=Method(
            conjunction=draw(st.sampled_from(["min", "product", "nilpotent_minimum"])) if "And(" in uses else "min",
            disjunction=draw(st.sampled_from(["max", "hamacher_sum"])) if "Or(" in uses else "max",
            implication="min" if averaged else draw(st.sampled_from(["min", "product", "einstein_product"])),
            aggregation="sum" if averaged else draw(st.sampled_from(["max", "bounded_sum"])),
            defuzzifier=Defuzzifier(kind=defuzzifier),
            semantics=draw(st.sampled_from([Semantics(), Semantics(extremely="cube")]))
            if "extremely" in uses
            else Semantics(),
        ),
        inputs=inputs,
        outputs=(output,),
        blocks=rules,
    )
