"""Systems drawn at random: those that use everything the model has, and plain ones for rational arithmetic."""

import math

import hypothesis.strategies as st

from fuzzyctl import (
    Activation,
    And,
    Consequent,
    Defuzzifier,
    FuzzySystem,
    Hedge,
    Hold,
    Input,
    Is,
    Membership,
    Method,
    Not,
    Or,
    Output,
    Rule,
    RuleBlock,
    Semantics,
    Term,
)
from fuzzyctl.expr import Binary, Call, Name, Number
from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, DISJUNCTIONS, HEDGES, MEMBERSHIP, inverse_hedge

#: Names of two inputs, three outputs, three terms and a hedge.
NAMES = ("x", "y", "u", "v", "w", "a", "b", "c", "soft")

#: Parameters of each kind over the range [0, 1]; places are scaled to the range, sizes by its width.
SHAPES = {
    "triangle": [(-0.2, 0.3, 0.6), (-math.inf, 0.2, 0.7), (0.3, 0.8, math.inf)],
    "trapezoid": [(0.1, 0.3, 0.5, 0.9)],
    "rectangle": [(0.25, 0.75)],
    "ramp": [(0.1, 0.9), (0.8, 0.2)],
    "s_shape": [(0.0, 1.0)],
    "z_shape": [(0.2, 0.9)],
    "pi_shape": [(0.0, 0.3, 0.4, 1.0)],
    "concave": [(0.2, 0.7), (0.7, 0.2)],
    "arc": [(0.0, 0.8)],
    "semi_ellipse": [(0.1, 0.9)],
    "singleton": [(0.5,)],
}
SIZED = {
    "gaussian": [("p", 0.4), ("s", 0.2)],
    "gaussian2": [("p", 0.3), ("s", 0.1), ("p", 0.6), ("s", 0.2)],
    "bell": [("p", 0.5), ("s", 0.2), ("n", 2.5)],
    "sigmoid": [("p", 0.5), ("i", 9.0)],
    "sigmoid_difference": [("p", 0.3), ("i", 20.0), ("i", 15.0), ("p", 0.7)],
    "sigmoid_product": [("p", 0.3), ("i", 20.0), ("i", -15.0), ("p", 0.7)],
    "cosine": [("p", 0.5), ("s", 0.8)],
    "spike": [("p", 0.5), ("s", 1.5)],
    "piecewise": [("p", 0.1), ("n", 0.2), ("p", 0.5), ("n", 1.0), ("p", 0.5), ("n", 0.4), ("p", 0.8), ("n", 0.0)],
}
MONOTONE = ("ramp", "s_shape", "z_shape", "concave", "arc", "sigmoid")
STRAIGHT = ("triangle", "trapezoid", "rectangle", "ramp", "piecewise")
AREA = tuple(k for k in (*SHAPES, *SIZED) if k != "singleton")
#: Curved kinds whose alpha-cuts have a closed form.
CURVED = tuple(k for k, f in MEMBERSHIP.items() if f.cut is not None and not f.straight)
FINITE_CORE = tuple(k for k in (*SHAPES, *SIZED) if k != "sigmoid")
RANGES = ((-0.06, 0.06), (0.0, 10.0), (-3.0, 5.0))
PLAIN_RANGES = (*RANGES, (1000.0, 1001.0))
HEIGHTS = st.sampled_from([1.0, 1.0, 1.0, 0.7])


@st.composite
def memberships(draw, lower, upper, kinds):
    kind, width = draw(st.sampled_from(kinds)), upper - lower
    shift = draw(st.sampled_from([0.0, 0.0, -0.2, 0.15]))
    if kind in SHAPES:
        numbers = [lower + (p + shift) * width for p in draw(st.sampled_from(SHAPES[kind]))]
    else:
        scale = {"p": lambda v: lower + (v + shift) * width, "s": lambda v: v * width, "i": lambda v: v / width}
        numbers = [scale.get(what, float)(v) for what, v in SIZED[kind]]
    return Membership(kind=kind, arguments=tuple(map(Number, numbers)), height=Number(draw(HEIGHTS)))


@st.composite
def input_terms(draw, name, lower, upper):
    if draw(st.integers(0, 5)) == 0:
        wave = Call("abs", (Call("sin", (Name(name),)),))
        expr = draw(st.sampled_from([wave, Binary("/", Name(name), Number(2.0)), Binary("/", Number(1.0), Name(name))]))
        return Membership(kind="function", arguments=(expr,), height=Number(draw(HEIGHTS)))
    return draw(memberships(lower, upper, tuple(SHAPES) + tuple(SIZED)))


def functions_of(x):
    return (
        Binary("-", Binary("*", x, x), Number(2.0)),
        Call("cos", (x,)),
        Binary("/", Number(1.0), Binary("+", Number(1.0), Binary("^", x, Number(2.0)))),
        Call("max", (x, Number(1.0), Call("min", (x, Number(0.5))))),
        Binary("*", Call("lt", (x, Number(0.25))), Call("ne", (x, Number(0.0)))),
        Binary("-", Call("ge", (x, Call("cos", (x,)))), Call("eq", (x, Number(0.5)))),
    )


@st.composite
def functions(draw, count, x):
    if draw(st.booleans()):
        factors = [draw(st.sampled_from([0.0, 1.0, -2.5])) for _ in range(count + 1)]
        return Membership(kind="linear", arguments=tuple(map(Number, factors)))
    return Membership(kind="function", arguments=(draw(st.sampled_from(functions_of(Name(x)))),))


@st.composite
def antecedents(draw, variables, hedges=(), depth=2):
    shape = draw(st.sampled_from(["is", "is", "and", "or", "not"])) if depth else "is"
    if shape == "is":
        variable = draw(st.sampled_from(variables))
        chosen = draw(st.lists(st.sampled_from(hedges), max_size=2)) if hedges and draw(st.booleans()) else []
        return Is(variable=variable.name, term=draw(st.sampled_from(variable.terms)).name, hedges=tuple(chosen))
    part = antecedents(variables, hedges, depth - 1)
    if shape == "not":
        return Not(operand=draw(part))
    operands = tuple(draw(st.lists(part, min_size=2, max_size=3)))
    return And(operands=operands) if shape == "and" else Or(operands=operands)


MAXIMA = ("som", "lom", "mom")
TSUKAMOTO = ("tsukamoto", "tsukamoto_sum", "inverse_tsukamoto", "inverse_tsukamoto_sum")
OVER_RULES = ("weighted_average", "center_average", "weighted_sum", *TSUKAMOTO)
OVER_SETS = ("centroid", "bisector", *MAXIMA)
RULES = {
    "centroid": [None, "plain", "trapezoid"],
    "bisector": [None, "interpolated", "first", "nearest", "walk", "two_sided", "between"],
    **{kind: [None, None, "running"] for kind in MAXIMA},
}


@st.composite
def defuzzifiers(draw, kind):
    if kind not in OVER_SETS:
        return Defuzzifier(kind=kind)
    options = {"by": draw(st.sampled_from(["value", "magnitude"]))} if kind in ("som", "lom") else {}
    if kind in MAXIMA:
        options["tolerance"] = draw(st.sampled_from([None, None, 0.01, 0.0]))
    if draw(st.booleans()):
        options["resolution"] = draw(st.sampled_from([2, 9, 10]))
        options["grid"] = draw(st.sampled_from(["midpoint", "endpoints", "left"]))
        options["rule"] = None if options.get("by") == "magnitude" else draw(st.sampled_from(RULES[kind]))
    return Defuzzifier(kind=kind, **options)


def shapes_of(draw, own):
    """Kinds of terms that a defuzzifier takes, and its norms."""
    if own.kind in OVER_SETS and own.resolution is None:
        norms = (draw(st.sampled_from(["min", "product"])), draw(st.sampled_from(["max", "sum"])))
        # Maxima of curved terms have a closed form under `max`; curved areas are integrals, which take longer.
        if norms[1] == "max" and draw(st.integers(0, 3)) == 0:
            return CURVED if own.kind in MAXIMA else AREA, norms
        return STRAIGHT, norms
    norms = (draw(st.sampled_from([*CONJUNCTIONS])), draw(st.sampled_from([*AGGREGATIONS])))
    if own.kind in OVER_SETS or own.kind.startswith("inverse"):
        return AREA, norms
    return (MONOTONE if own.kind in TSUKAMOTO else FINITE_CORE), norms


@st.composite
def outputs(draw, name, terms, kinds, held):
    lower, upper = draw(st.sampled_from(RANGES))
    own = draw(defuzzifiers(draw(st.sampled_from(kinds))))
    shapes, (implication, aggregation) = shapes_of(draw, own)
    terms = [Term(name=n, membership=draw(memberships(lower, upper, shapes))) for n in terms]
    otherwise = [None, Number(lower - 1.0), "midpoint", "nan", "nan", "error"]
    if held:
        otherwise += [Hold(), Hold(start="nan"), Hold(start=Number(upper + 1.0))]
    return Output(
        name=name,
        lower=Number(lower),
        upper=Number(upper),
        terms=tuple(terms),
        otherwise=draw(st.sampled_from(otherwise)),
        defuzzifier=own,
        implication=implication,
        aggregation=aggregation,
        clamped=draw(st.booleans()),
    )


def hedges_of(output, how, soft):
    """The hedges that a consequent of an output may have."""
    own = output.defuzzifier
    if own.over_rules and how == "set":
        return []
    if own.over_rules and how == "undone":
        return [h for h in HEDGES if inverse_hedge(h) is not None]
    if own.over_rules or how not in ("set", "undone") or own.resolution:
        return [*HEDGES, soft]
    if own.kind in MAXIMA:  # of straight sides what `not` makes of them has straight sides, too
        return ["not"] if all(t.membership.kind in STRAIGHT for t in output.terms) else []
    return ["not", "not", "very"]


@st.composite
def activations(draw):
    kind = draw(st.sampled_from(["general", "first", "last", "highest", "lowest", "proportional", "threshold"]))
    count = draw(st.integers(1, 3)) if kind in ("first", "last", "highest", "lowest") else None
    threshold = Number(draw(st.sampled_from([0.0, 0.25]))) if kind in ("first", "last", "threshold") else None
    comparison = draw(st.sampled_from(["<", "<=", "==", "!=", ">=", ">"])) if kind == "threshold" else None
    return Activation(kind=kind, count=count, threshold=threshold, comparison=comparison)


@st.composite
def block_methods(draw, implies):
    """What a rule block says itself; `implies` whether it may say how its rules imply."""
    drawn = {
        "conjunction": st.sampled_from([*CONJUNCTIONS]),
        "disjunction": st.sampled_from([*DISJUNCTIONS]),
        "implication": st.sampled_from(["min", "product", *CONJUNCTIONS]),
        "activation": activations(),
    }
    if not implies:
        del drawn["implication"]
    return {name: draw(strategy) for name, strategy in drawn.items() if draw(st.booleans())}


@st.composite
def systems(draw, kinds=(*OVER_SETS, *OVER_RULES), held=False, names=NAMES):
    """A system; `held` allows outputs that hold their previous value, so that kernels have a state."""
    inputs, named, soft = [], names[5:8], names[8]
    for name in names[: draw(st.integers(1, 2))]:
        lower, upper = draw(st.sampled_from(RANGES))
        terms = [Term(name=n, membership=draw(input_terms(name, lower, upper))) for n in named]
        inputs.append(Input(name=name, lower=Number(lower), upper=Number(upper), terms=tuple(terms)))
    made = [draw(outputs(name, named, kinds, held)) for name in names[2 : draw(st.integers(3, 5))]]
    activation = draw(activations())
    how = draw(st.sampled_from(["set", "activation", "carried", "undone"]))
    # Maxima that are exact have a closed form only where all rules imply in the same way.
    implies = not any(o.defuzzifier.kind in MAXIMA and o.defuzzifier.resolution is None for o in made)
    own = [{}, *(draw(block_methods(implies)) for _ in range(draw(st.sampled_from([0, 0, 1, 2]))))]
    # Which block each rule is of, and the outputs that it sets.
    heads = [
        (draw(st.integers(0, len(own) - 1)), sorted({draw(st.integers(0, len(made) - 1)) for _ in range(2)}))
        for _ in range(draw(st.integers(2, 6)))
    ]
    rules = [[] for _ in own]
    for block, chosen in sorted(heads, key=lambda head: head[0]):
        consequents = []
        for k in chosen:
            term = draw(st.sampled_from(named))
            if made[k].defuzzifier.kind in OVER_RULES[:3] and draw(st.booleans()):
                term = draw(functions(len(inputs), names[0]))
            allowed = hedges_of(made[k], how, soft) if isinstance(term, str) and draw(st.booleans()) else []
            hedges = draw(st.lists(st.sampled_from(allowed), max_size=2)) if allowed else []
            consequents.append(Consequent(output=made[k].name, term=term, hedges=tuple(hedges)))
        # A rule may read the outputs declared before all those it sets, and before all those that rules set which it
        # is compared with, so that there is no circle.
        compared = own[block].get("activation", activation).kind not in ("general", "threshold")
        first = min(c[0] for b, c in heads if b == block) if compared else chosen[0]
        readable = [*inputs, *made[:first]]
        rules[block].append(
            Rule(
                antecedent=draw(antecedents(readable, [*HEDGES, soft])),
                consequents=tuple(consequents),
                weight=Number(draw(st.sampled_from([1.0, 1.0, 0.3, 0.0]))),
            )
        )
    method = Method(
        conjunction=draw(st.sampled_from([*CONJUNCTIONS])),
        disjunction=draw(st.sampled_from([*DISJUNCTIONS])),
        activation=activation,
        semantics=Semantics(consequent_hedges=how),
    )
    power = Binary("-", Binary("^", Name("x"), Number(1.5)), Number(0.1))
    return FuzzySystem(
        name="s",
        hedges=(Hedge(name=soft, parameter="x", expression=power),),
        method=method,
        inputs=tuple(inputs),
        outputs=tuple(draw(st.permutations(made))),
        blocks=(
            *rules[0],
            *(RuleBlock(name=f"b{k}", rules=r, **own[k]) for k, r in enumerate(rules) if k > 0 and r),
        ),
    )


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
        lambda found: tuple(Term(name=n, membership=m) for n, m in zip("abc", found, strict=False))
    )


@st.composite
def plain_systems(draw, averages=None, extrapolate=True):
    """A system of straight sets, centroids and averages, plain enough for rational arithmetic.

    Args:
        averages: Whether its outputs are averages; None for either.
        extrapolate: Whether inputs may go through the formulas beyond their ranges.
    """
    averages = draw(st.booleans()) if averages is None else averages
    resolution = None if averages else draw(st.sampled_from([None, None, None, 7]))
    inputs = []
    for name, (lower, upper) in zip("xyz", draw(st.permutations(PLAIN_RANGES)), strict=False):
        own = draw(terms(lower, upper, ("triangle", "trapezoid", "gaussian", "singleton")))
        free = extrapolate and draw(st.integers(0, 4)) == 0
        inputs.append(Input(name=name, lower=Number(lower), upper=Number(upper), terms=own, extrapolate=free))
    inputs = inputs[: draw(st.integers(1, 3))]
    outputs = []
    for name, (lower, upper) in zip("uv", draw(st.permutations(PLAIN_RANGES)), strict=False):
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


#: What laws are tested on.
KINDS = {"plain": plain_systems(), "any": systems()}
#: Where corners of terms are, and beyond the ends, as parts of a range.
GRID = [*(i / 10 for i in range(-1, 12)), *(i / 8 for i in range(-2, 11))]


@st.composite
def points(draw, system, count=8, special=False):
    """Points around the ranges of the inputs; `special` ones have coordinates that are infinite or NaN."""

    def one(variable):
        lower, upper = variable.lower.value, variable.upper.value
        around = (st.floats(-0.3, 1.3) | st.sampled_from(GRID)).map(lambda p: lower + p * (upper - lower))
        return around | st.sampled_from([math.inf, -math.inf, math.nan]) if special else around

    return [tuple(draw(one(i)) for i in system.inputs) for _ in range(count)]
