"""Generated systems that use everything: backends agree with each other, a plain reference and the proofs."""

import math
from functools import reduce

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, note, settings

from fuzzyctl.analysis.bounds import output_bounds
from fuzzyctl.analysis.coverage import uncovered
from fuzzyctl.analysis.holes import Hole
from fuzzyctl.errors import NoRuleFiresError
from fuzzyctl.expr import Binary, Call, Name, Number, evaluate
from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, DISJUNCTIONS, HEDGES, MEMBERSHIP
from fuzzyctl.kernels.compile import compile as compile_system
from fuzzyctl.kernels.python_backend import scalar_function
from fuzzyctl.model.guarantee import Hedge
from fuzzyctl.model.method import Activation, Defuzzifier, Method
from fuzzyctl.model.rule import And, Consequent, Is, Not, Or, Rule, RuleBlock
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Membership, Output, Term

X, Y = Name("x"), Name("y")


def quick(examples):
    return settings(
        max_examples=examples,
        deadline=None,
        derandomize=True,
        database=None,
        report_multiple_bugs=False,
        suppress_health_check=list(HealthCheck),
        phases=[Phase.generate],
    )


# --- generated systems -----------------------------------------------------------------------------------------------

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
FINITE_CORE = tuple(k for k in (*SHAPES, *SIZED) if k != "sigmoid")
RANGES = ((-0.06, 0.06), (0.0, 10.0), (-3.0, 5.0))
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


FUNCTIONS = (
    Binary("-", Binary("*", X, X), Number(2.0)),
    Call("cos", (X,)),
    Binary("/", Number(1.0), Binary("+", Number(1.0), Binary("^", X, Number(2.0)))),
    Call("max", (X, Number(1.0), Call("min", (X, Number(0.5))))),
)


@st.composite
def functions(draw, count):
    if draw(st.booleans()):
        factors = [draw(st.sampled_from([0.0, 1.0, -2.5])) for _ in range(count + 1)]
        return Membership(kind="linear", arguments=tuple(map(Number, factors)))
    return Membership(kind="function", arguments=(draw(st.sampled_from(FUNCTIONS)),))


@st.composite
def antecedents(draw, variables, depth=2):
    shape = draw(st.sampled_from(["is", "is", "and", "or", "not"])) if depth else "is"
    if shape == "is":
        variable = draw(st.sampled_from(variables))
        hedges = draw(st.lists(st.sampled_from([*HEDGES, "soft"]), max_size=2)) if draw(st.booleans()) else []
        term = draw(st.sampled_from([t for t in variable.terms if t.membership.kind != "linear"]))
        return Is(variable=variable.name, term=term.name, hedges=tuple(hedges))
    part = antecedents(variables, depth=depth - 1)
    if shape == "not":
        return Not(operand=draw(part))
    operands = tuple(draw(st.lists(part, min_size=2, max_size=3)))
    return And(operands=operands) if shape == "and" else Or(operands=operands)


OVER_RULES = ("weighted_average", "center_average", "weighted_sum", "tsukamoto")


@st.composite
def outputs(draw, name, kinds):
    lower, upper = draw(st.sampled_from(RANGES))
    kind = draw(st.sampled_from(kinds))
    resolution = None
    if kind == "centroid":
        shapes, resolution = (AREA, 9) if draw(st.booleans()) else (STRAIGHT, None)
    else:
        shapes = MONOTONE if kind == "tsukamoto" else FINITE_CORE
    terms = [Term(name=n, membership=draw(memberships(lower, upper, shapes))) for n in ("a", "b", "c")]
    return Output(
        name=name,
        lower=Number(lower),
        upper=Number(upper),
        terms=tuple(terms),
        otherwise=draw(st.sampled_from([None, Number(lower - 1.0), "midpoint", "nan", "nan", "error"])),
        defuzzifier=Defuzzifier(kind=kind, resolution=resolution),
        implication=draw(st.sampled_from([*CONJUNCTIONS])) if resolution else draw(st.sampled_from(["min", "product"])),
        aggregation=draw(st.sampled_from([*AGGREGATIONS])) if resolution else draw(st.sampled_from(["max", "sum"])),
    )


@st.composite
def activations(draw):
    kind = draw(st.sampled_from(["general", "first", "last", "highest", "lowest", "proportional", "threshold"]))
    count = draw(st.integers(1, 3)) if kind in ("first", "last", "highest", "lowest") else None
    threshold = Number(draw(st.sampled_from([0.0, 0.25]))) if kind in ("first", "last", "threshold") else None
    comparison = draw(st.sampled_from(["<", "<=", "==", "!=", ">=", ">"])) if kind == "threshold" else None
    return Activation(kind=kind, count=count, threshold=threshold, comparison=comparison)


@st.composite
def block_methods(draw):
    """What a rule block says itself."""
    drawn = {
        "conjunction": st.sampled_from([*CONJUNCTIONS]),
        "disjunction": st.sampled_from([*DISJUNCTIONS]),
        "implication": st.sampled_from(["min", "product", *CONJUNCTIONS]),
        "activation": activations(),
    }
    return {name: draw(strategy) for name, strategy in drawn.items() if draw(st.booleans())}


@st.composite
def systems(draw, kinds=("centroid", *OVER_RULES)):
    inputs = []
    for name in ("x", "y")[: draw(st.integers(1, 2))]:
        lower, upper = draw(st.sampled_from(RANGES))
        terms = [Term(name=n, membership=draw(input_terms(name, lower, upper))) for n in ("a", "b", "c")]
        inputs.append(Input(name=name, lower=Number(lower), upper=Number(upper), terms=tuple(terms)))
    made = [draw(outputs(name, kinds)) for name in "uvw"[: draw(st.integers(1, 3))]]
    activation = draw(activations())
    own = [{}, *(draw(block_methods()) for _ in range(draw(st.sampled_from([0, 0, 1, 2]))))]
    # Which block each rule is of, and the outputs that it sets.
    heads = [
        (draw(st.integers(0, len(own) - 1)), sorted({draw(st.integers(0, len(made) - 1)) for _ in range(2)}))
        for _ in range(draw(st.integers(2, 6)))
    ]
    rules = [[] for _ in own]
    for block, chosen in sorted(heads, key=lambda head: head[0]):
        consequents = []
        for k in chosen:
            term = draw(st.sampled_from("abc"))
            if made[k].defuzzifier.kind in OVER_RULES[:3] and draw(st.booleans()):
                term = draw(functions(len(inputs)))
            consequents.append(Consequent(output=made[k].name, term=term))
        # A rule may read the outputs declared before all those it sets, and before all those that rules set which it
        # is compared with, so that there is no circle.
        compared = own[block].get("activation", activation).kind not in ("general", "threshold")
        first = min(c[0] for b, c in heads if b == block) if compared else chosen[0]
        readable = [*inputs, *made[:first]]
        rules[block].append(
            Rule(
                antecedent=draw(antecedents(readable)),
                consequents=tuple(consequents),
                weight=Number(draw(st.sampled_from([1.0, 1.0, 0.3, 0.0]))),
            )
        )
    method = Method(
        conjunction=draw(st.sampled_from([*CONJUNCTIONS])),
        disjunction=draw(st.sampled_from([*DISJUNCTIONS])),
        activation=activation,
    )
    soft = Hedge(name="soft", parameter="x", expression=Binary("+", Binary("^", X, Number(1.5)), Number(-0.1)))
    return FuzzySystem(
        name="s",
        hedges=(soft,),
        method=method,
        inputs=tuple(inputs),
        outputs=tuple(draw(st.permutations(made))),
        blocks=(
            *rules[0],
            *(RuleBlock(name=f"b{k}", rules=r, **own[k]) for k, r in enumerate(rules) if k > 0 and r),
        ),
    )


@st.composite
def points(draw, system, count=8):
    def one(variable):
        lower, upper = variable.lower.value, variable.upper.value
        inside = st.floats(-0.2, 1.2).map(lambda p: lower + p * (upper - lower))
        return inside | st.integers(-1, 11).map(lambda i: lower + i / 10 * (upper - lower))

    return [tuple(draw(one(i)) for i in system.inputs) for _ in range(count)]


# --- the reference: inference as plainly as possible, on formulas that have tests of their own -----------------------

_FORMULAS = {}


def formula(build, *key):
    if key not in _FORMULAS:
        _FORMULAS[key] = scalar_function(build())
    return _FORMULAS[key]


def norm(among, name):
    return formula(lambda: among[name](Name("a"), Name("b")), "norm", name)


def held(x):
    return min(max(x, 0.0), 1.0)


def degree(membership, variable, x):
    height = membership.height.value
    if membership.kind == "function":
        try:
            own = held(evaluate(membership.arguments[0], {variable: x}))
        except ValueError:  # 1 / x at 0: a quotient by zero is infinite
            own = 1.0 if math.copysign(1.0, x) > 0.0 else 0.0
        return height * own
    p = tuple(a.value for a in membership.arguments)
    return height * formula(lambda: MEMBERSHIP[membership.kind].degree(X, p), membership.kind, p)(x)


def hedged(name, x):
    if name == "any":
        return 1.0
    return held(x**1.5 - 0.1) if name == "soft" else formula(lambda: HEDGES[name](X), "hedge", name)(x)


class Reference:
    """One evaluation of a system at a point."""

    def __init__(self, system, point):
        self.system = system
        self.values = {
            v.name: min(max(x, v.lower.value), v.upper.value) for v, x in zip(system.inputs, point, strict=True)
        }
        self.results = {}
        self.tiny = False
        loose = [r for r in system.blocks if not isinstance(r, RuleBlock)]
        groups = [(system.method, loose), *((b, b.rules) for b in system.blocks if isinstance(b, RuleBlock))]
        #: What the block of a rule says, and the rules of the block, by the identity of the rule.
        self.blocks = {id(rule): group for group in groups for rule in group[1]}

    def method(self, rule, field):
        """What counts for a rule: what its block says, else what the system says."""
        return getattr(self.blocks[id(rule)][0], field) or getattr(self.system.method, field)

    def fired(self, rule):
        return self.truth(rule.antecedent, rule)

    def truth(self, antecedent, rule):
        match antecedent:
            case Is(variable=name, term=term, hedges=hedges):
                variable = next(v for v in (*self.system.inputs, *self.system.outputs) if v.name == name)
                if isinstance(variable, Output):
                    value = self.output(name)
                    self.values[name] = min(max(value, variable.lower.value), variable.upper.value)
                found = degree(variable.term(term).membership, name, self.values[name])
                return reduce(lambda x, h: hedged(h, x), reversed(hedges), found)
            case Not(operand=operand):
                return 1.0 - self.truth(operand, rule)
            case And(operands=operands):
                join = norm(CONJUNCTIONS, self.method(rule, "conjunction"))
                return reduce(join, [self.truth(o, rule) for o in operands])
        join = norm(DISJUNCTIONS, self.method(rule, "disjunction"))
        return reduce(join, [self.truth(o, rule) for o in antecedent.operands])

    def activation(self, rule):
        """Return how far a rule acts; the others matter only for methods that compare them."""
        method, rules = self.method(rule, "activation"), self.blocks[id(rule)][1]
        own = rule.weight.value * self.fired(rule) if rule.weight.value else 0.0
        bound = method.threshold.value if method.threshold else 0.0
        if method.kind == "general":
            return own
        if method.kind == "threshold":
            holds = {"<": own < bound, "<=": own <= bound, "==": own == bound, "!=": own != bound, ">=": own >= bound}
            return own if holds.get(method.comparison, own > bound) else 0.0
        every = [r.weight.value * self.fired(r) for r in rules]
        if method.kind == "proportional":
            return own / sum(every) if sum(every) > 0 else 0.0
        numbers = [k for k, a in enumerate(every) if a > 0 and a >= bound]
        if method.kind == "last":
            numbers.reverse()
        elif method.kind in ("highest", "lowest"):
            numbers.sort(key=lambda k: every[k] if method.kind == "lowest" else -every[k])
        return own if next(k for k, r in enumerate(rules) if r is rule) in numbers[: method.count] else 0.0

    def output(self, name):
        """Return the value of an output, or the word "error"; NaN where it reads one that has no value."""
        if name not in self.results:
            self.results[name] = self._output(self.system.output(name))
        if isinstance(self.results[name], str):
            raise NoRuleFiresError(name, "")
        return self.results[name]

    def _output(self, output):
        rules = [(c.term, r) for r in self.system.rules for c in r.consequents if c.output == output.name]
        for _, rule in rules:
            for other in self.compared(rule):
                self.fired(other)
        if any(math.isnan(self.values.get(n, 0.0)) for n in self._read(output.name)):
            return math.nan
        acting = [(term, self.activation(rule), self.implication(rule, output)) for term, rule in rules]
        acting = [(term, a, implied) for term, a, implied in acting if a > 0]
        self.tiny |= any(a < 1e-12 for _, a, _ in acting)
        value = self._defuzzified(output, acting) if acting else None
        if value is not None:
            return value
        match output.otherwise:
            case "nan":
                return math.nan
            case "midpoint":
                return (output.lower.value + output.upper.value) / 2
            case "error" | None:
                return "error"
        return output.otherwise.value

    def _read(self, name):
        def names(antecedent):
            match antecedent:
                case Is(variable=variable):
                    return {variable}
                case Not(operand=operand):
                    return names(operand)
            return set().union(*(names(o) for o in antecedent.operands))

        rules = [r for r in self.system.rules if any(c.output == name for c in r.consequents)]
        rules = [other for rule in rules for other in self.compared(rule)]
        return set().union(*(names(r.antecedent) for r in rules)) if rules else set()

    def compared(self, rule):
        """The rules that must be known before a rule acts: those it is compared with, or itself."""
        compares = self.method(rule, "activation").kind not in ("general", "threshold")
        return self.blocks[id(rule)][1] if compares else [rule]

    def implication(self, rule, output):
        own, _ = self.blocks[id(rule)]
        return own.implication if isinstance(own, RuleBlock) and own.implication else output.implication

    def _defuzzified(self, output, acting):
        kind = output.defuzzifier.kind
        if kind == "centroid":
            return self._centroid(output, acting)
        total = sum(a for _, a, _ in acting)
        weighted = sum(a * self._consequent(output, term, a) for term, a, _ in acting)
        return weighted if kind == "weighted_sum" else weighted / total

    def _consequent(self, output, term, activation):
        membership = output.term(term).membership if isinstance(term, str) else term
        if membership.kind == "linear":
            *factors, constant = (a.value for a in membership.arguments)
            inputs = [self.values[i.name] for i in self.system.inputs]
            return sum(c * x for c, x in zip(factors, inputs, strict=True)) + constant
        if membership.kind == "function":
            return evaluate(membership.arguments[0], self.values)
        p = tuple(a.value for a in membership.arguments)
        if output.defuzzifier.kind != "tsukamoto":
            return sum(MEMBERSHIP[membership.kind].core(p)) / 2
        share = min(1.0, activation / membership.height.value)
        place = formula(lambda: MEMBERSHIP[membership.kind].inverse(Name("w"), p), "inverse", membership.kind, p)(share)
        return min(max(place, output.lower.value), output.upper.value)

    def _centroid(self, output, acting):
        lower, upper = output.lower.value, output.upper.value
        count = output.defuzzifier.resolution
        if count is None:
            return None
        joined = norm(AGGREGATIONS, output.aggregation)
        area = moment = 0.0
        for i in range(count):
            x = lower + (i + 0.5) * (upper - lower) / count
            terms = [(degree(output.term(t).membership, output.name, x), a, implied) for t, a, implied in acting]
            cuts = [norm(CONJUNCTIONS, implied)(a, mu) for mu, a, implied in terms]
            y = reduce(joined, cuts)
            area, moment = area + y, moment + y * x
        return moment / area if area > 0 else None


def reference(system, point):
    """Return all outputs, "error" where a kernel refuses, and whether activations are far from the smallest numbers."""
    found = Reference(system, point)
    try:
        values = [found.output(o.name) for o in system.outputs]
    except NoRuleFiresError:
        return "error", not found.tiny
    return values, not found.tiny


def evaluated(kernel, point, *, batch=False):
    try:
        result = kernel.batch(np.array(point)) if batch else kernel(*point)
    except NoRuleFiresError:
        return "error"
    return [float(v) for v in np.atleast_1d(result)]


def alike(a, b, system):
    if isinstance(a, str) or isinstance(b, str):
        return a == b
    scales = [max(abs(o.lower.value), abs(o.upper.value), 30.0) for o in system.outputs]
    return all(
        (math.isnan(x) and math.isnan(y)) or abs(x - y) <= 1e-12 * max(s, abs(x))
        for x, y, s in zip(a, b, scales, strict=True)
    )


# --- properties ------------------------------------------------------------------------------------------------------


@quick(150)
@given(st.data())
def test_generated_python_and_numpy_agree_with_the_reference(data):
    system = data.draw(systems())
    kernel, arrays = compile_system(system, "python"), compile_system(system, "numpy")
    exact = any(o.defuzzifier.kind == "centroid" and o.defuzzifier.resolution is None for o in system.outputs)
    for point in data.draw(points(system)):
        found = evaluated(kernel, point)
        batch = evaluated(arrays, point, batch=True)
        note(f"{point} {found} {batch}")
        assert alike(found, batch, system)
        expected, clear = reference(system, point)
        note(f"{expected}")
        if clear and not exact:
            assert alike(found, expected, system)


@pytest.fixture(scope="module")
def _kernel_folder(tmp_path_factory):
    """Keep the kernels of generated systems out of the user's cache."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FUZZYCTL_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.mark.usefixtures("_kernel_folder")
@quick(6)
@given(st.data())
def test_compiled_kernels_agree_with_generated_python(data):
    system = data.draw(systems())
    kernel, compiled = compile_system(system, "python"), compile_system(system, "numba")
    for point in data.draw(points(system, count=30)):
        found = evaluated(kernel, point)
        assert alike(found, evaluated(compiled, point), system)
        assert alike(found, evaluated(compiled, point, batch=True), system)


@quick(120)
@given(st.data())
def test_every_sample_lies_within_the_proved_bounds(data):
    system = data.draw(systems())
    bounds, kernel = output_bounds(system), compile_system(system, "python")
    for point in data.draw(points(system, count=16)):
        found = evaluated(kernel, point)
        if not isinstance(found, str):
            for output, value in zip(system.outputs, found, strict=True):
                bound = bounds[output.name]
                assert math.isnan(value) or bound.lo <= value <= bound.hi


@quick(120)
@given(st.data())
def test_coverage_is_never_wrong(data):
    system = data.draw(systems())
    # Where nothing fires all outputs are NaN, and NaN goes on to those that read them.
    quiet = tuple(o.model_copy(update={"otherwise": "nan"}) for o in system.outputs)
    system = FuzzySystem(**{k: getattr(system, k) for k in type(system).model_fields} | {"outputs": quiet})
    verdicts, kernel = uncovered(system), compile_system(system, "python")
    for k, output in enumerate(system.outputs):
        verdict = verdicts[output.name]
        if verdict is None:
            for point in data.draw(points(system, count=12)):
                assert not math.isnan(evaluated(kernel, point)[k])
        elif isinstance(verdict, Hole):
            assert math.isnan(evaluated(kernel, tuple(verdict.witness.values()))[k])


@quick(24)
@given(st.data())
def test_exact_centroids_are_limits_of_sampled_ones(data):
    lower, upper = data.draw(st.sampled_from(RANGES))
    sets = [data.draw(memberships(lower, upper, STRAIGHT)) for _ in range(3)]
    ramp = Membership(kind="ramp", arguments=(Number(0.0), Number(1.0)))
    inputs = tuple(
        Input(name=n, lower=Number(0.0), upper=Number(1.0), terms=(Term(name="on", membership=ramp),)) for n in "xyz"
    )
    rules = tuple(
        Rule(antecedent=Is(variable=n, term="on"), consequents=(Consequent(output="u", term=n),)) for n in "xyz"
    )
    if data.draw(st.booleans()):
        kinds = st.sampled_from([None, "min", "product", "bounded_difference"])
        rules = tuple(RuleBlock(name=f"b{k}", rules=(r,), implication=data.draw(kinds)) for k, r in enumerate(rules))
    method = Method(
        implication=data.draw(st.sampled_from(["min", "product"])),
        aggregation=data.draw(st.sampled_from(["max", "sum"])),
    )

    def system(resolution):
        output = Output(
            name="u",
            lower=Number(lower),
            upper=Number(upper),
            terms=tuple(Term(name=n, membership=m) for n, m in zip("xyz", sets, strict=True)),
            otherwise="nan",
            defuzzifier=Defuzzifier(resolution=resolution),
        )
        return FuzzySystem(name="s", method=method, inputs=inputs, outputs=(output,), blocks=rules)

    exact, sampled = (compile_system(system(r), "python") for r in (None, 4000))
    for _ in range(2):
        point = tuple(data.draw(st.floats(0.05, 1.0)) for _ in "xyz")
        assert exact(*point) == pytest.approx(sampled(*point), abs=2e-3 * (upper - lower), nan_ok=True)
