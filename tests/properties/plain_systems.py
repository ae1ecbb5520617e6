"""Systems drawn at random that are plain enough for rational arithmetic: straight sets, centroids and averages."""

import math

import hypothesis.strategies as st

from fuzzyctl.expr import Number
from fuzzyctl.model.method import Defuzzifier, Method
from fuzzyctl.model.rule import And, Consequent, Is, Not, Or, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Membership, Output, Term

TERM_NAMES = ("low", "mid", "high")  # shared by all variables on purpose


@st.composite
def linear_terms(draw, lower, upper, kinds=("triangle", "trapezoid")):
    kind = draw(st.sampled_from(kinds))
    if kind == "gaussian":
        place = draw(st.integers(0, 8)) / 8
        sigma = (upper - lower) * draw(st.sampled_from([0.05, 0.2, 0.5]))
        return Membership(kind=kind, arguments=(Number(lower + place * (upper - lower)), Number(sigma)))
    if kind == "singleton":
        return Membership(kind=kind, arguments=(Number(lower + draw(st.integers(0, 8)) / 8 * (upper - lower)),))
    count = 3 if kind == "triangle" else 4
    # A grid makes corners coincide, so that sides are vertical and terms meet; floats make them miss each other.
    place = st.integers(-2, 10).map(lambda i: i / 8) | st.floats(-0.2, 1.2).map(lambda p: round(p, 9))
    spots = sorted(draw(st.lists(place, min_size=count, max_size=count)))
    values = [lower + p * (upper - lower) for p in spots]
    if draw(st.integers(0, 3)) == 0:
        values[0] = -math.inf
    if draw(st.integers(0, 3)) == 0:
        values[-1] = math.inf
    return Membership(kind=kind, arguments=tuple(Number(v) for v in values))


def terms(lower, upper, kinds):
    return st.lists(linear_terms(lower, upper, kinds), min_size=1, max_size=3).map(
        lambda found: tuple(Term(name=n, membership=m) for n, m in zip(TERM_NAMES, found, strict=False))
    )


@st.composite
def antecedents(draw, inputs, depth=2):
    shape = draw(st.sampled_from(["is", "is", "and", "or", "not"])) if depth else "is"
    if shape == "is":
        variable = draw(st.sampled_from(inputs))
        return Is(variable=variable.name, term=draw(st.sampled_from(variable.terms)).name)
    part = antecedents(inputs, depth=depth - 1)
    if shape == "not":
        return Not(operand=draw(part))
    operands = tuple(draw(st.lists(part, min_size=2, max_size=3)))
    return And(operands=operands) if shape == "and" else Or(operands=operands)


RANGES = ((-0.06, 0.06), (0.0, 10.0), (-3.0, 5.0), (1000.0, 1001.0))


@st.composite
def systems(draw, averages=None, extrapolate=True):
    averages = draw(st.booleans()) if averages is None else averages
    resolution = None if averages else draw(st.sampled_from([None, None, None, 7]))
    inputs = []
    for name, (lower, upper) in zip("xyz", draw(st.permutations(RANGES)), strict=False):
        own = draw(terms(lower, upper, ("triangle", "trapezoid", "gaussian", "singleton")))
        free = extrapolate and draw(st.integers(0, 4)) == 0
        inputs.append(Input(name=name, lower=Number(lower), upper=Number(upper), terms=own, extrapolate=free))
    inputs = inputs[: draw(st.integers(1, 3))]
    outputs = []
    for name, (lower, upper) in zip("uv", draw(st.permutations(RANGES)), strict=False):
        kinds = ("triangle", "trapezoid")
        kinds = (*kinds, "singleton") if averages else kinds if resolution is None else (*kinds, "gaussian")
        otherwise = draw(st.sampled_from([None, Number(lower - 1.0), Number(lower), "midpoint", "nan", "error"]))
        own = draw(terms(lower, upper, kinds))
        outputs.append(Output(name=name, lower=Number(lower), upper=Number(upper), terms=own, otherwise=otherwise))
    outputs = outputs[: draw(st.integers(1, 2))]
    rules = []
    for _ in range(draw(st.integers(1, 6))):
        chosen = draw(st.sampled_from([outputs[:1], outputs, outputs[-1:]]))
        consequents = tuple(
            Consequent(output=o.name, term=draw(st.sampled_from(o.terms)).name) for o in dict.fromkeys(chosen)
        )
        weight = Number(draw(st.sampled_from([1.0, 1.0, 1.0, 0.3, 0.0])))
        rules.append(Rule(antecedent=draw(antecedents(inputs)), consequents=consequents, weight=weight))
    method = Method(
        conjunction=draw(st.sampled_from(["min", "product", "bounded_difference"])),
        disjunction=draw(st.sampled_from(["max", "probabilistic_sum", "bounded_sum"])),
        implication=draw(st.sampled_from(["min", "product"])),
        aggregation=draw(st.sampled_from(["max", "sum"])),
        defuzzifier=Defuzzifier(
            kind="weighted_average" if averages else "centroid",
            resolution=resolution,
            grid=draw(st.sampled_from(["midpoint", "endpoints"])),
        ),
    )
    return FuzzySystem(name="s", method=method, inputs=tuple(inputs), outputs=tuple(outputs), blocks=tuple(rules))


@st.composite
def points(draw, system, count=6, special=True):
    def one(variable):
        lower, upper = variable.lower.value, variable.upper.value
        inside = st.floats(-0.3, 1.3).map(lambda p: lower + p * (upper - lower))
        on_grid = st.integers(-2, 10).map(lambda i: lower + i / 8 * (upper - lower))
        return inside | on_grid | (st.sampled_from([math.inf, -math.inf, math.nan]) if special else on_grid)

    return [tuple(draw(one(i)) for i in system.inputs) for _ in range(count)]
