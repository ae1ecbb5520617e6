"""Generated systems: backends agree with each other and with an obvious reference, and stay inside proved bounds."""

import math
import warnings
from fractions import Fraction
from itertools import combinations, pairwise, product

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, assume, given, note, settings

from fuzzyctl.analysis.bounds import output_bounds
from fuzzyctl.analysis.coverage import uncovered
from fuzzyctl.analysis.degrees import breakpoints
from fuzzyctl.analysis.holes import Hole
from fuzzyctl.errors import NoRuleFiresError
from fuzzyctl.expr import Number
from fuzzyctl.kernels.compile import compile as compile_system
from fuzzyctl.kernels.plan import plan
from fuzzyctl.model.method import Defuzzifier, Method
from fuzzyctl.model.rule import And, Consequent, Is, Not, Or, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Input, Membership, Output, Term

TERM_NAMES = ("low", "mid", "high")  # shared by all variables on purpose


def quick(examples):
    slow = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much]
    return settings(
        max_examples=examples,
        deadline=None,
        derandomize=True,
        database=None,
        report_multiple_bugs=False,
        suppress_health_check=slow,
        phases=[Phase.generate],
    )


# --- generated systems ---------------------------------------------------------------------------------------------


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


# --- the reference: written from the model, as plainly as possible ---------------------------------------------------


def degree(membership, x):
    p = [a.value for a in membership.arguments]
    if membership.kind == "gaussian":
        return math.exp(-0.5 * ((x - p[0]) / p[1]) ** 2) if math.isfinite(x) else 0.0
    if membership.kind == "singleton":
        return 1.0 if x == p[0] else 0.0
    a, b, c, d = (p[0], p[1], p[1], p[2]) if membership.kind == "triangle" else p
    if b <= x <= c or (x < b and a == -math.inf) or (x > c and d == math.inf):
        return 1.0
    if x <= a or x >= d:
        return 0.0
    return (x - a) / (b - a) if x < b else (d - x) / (d - c)


CONJUNCTION = {"min": min, "product": lambda a, b: a * b, "bounded_difference": lambda a, b: max(0.0, a - (1.0 - b))}
# With the same rounding as the kernels, since whether a bounded difference fires may hang on the last digit.
DISJUNCTION = {
    "max": max,
    "probabilistic_sum": lambda a, b: a + b * (1.0 - a),
    "bounded_sum": lambda a, b: min(1.0, a + b),
}


def truth(system, antecedent, point):
    match antecedent:
        case Is(variable=variable, term=term):
            return degree(system.input(variable).term(term).membership, point[variable])
        case Not(operand=operand):
            return 1.0 - truth(system, operand, point)
    method, values = system.method, [truth(system, o, point) for o in antecedent.operands]
    norm = CONJUNCTION[method.conjunction] if isinstance(antecedent, And) else DISJUNCTION[method.disjunction]
    result = values[0]
    for value in values[1:]:
        result = norm(result, value)
    return result


def corners(membership):
    p = [a.value for a in membership.arguments]
    a, b, c, d = (p[0], p[1], p[1], p[2]) if membership.kind == "triangle" else p
    return [(a, 0), (b, 1), (c, 1), (d, 0)]


def limits(membership, x0, x1):
    """Degrees at both ends of an interval without corners inside, as limits from inside."""
    (a, _), (b, _), (c, _), (d, _) = corners(membership)
    middle = (x0 + x1) / 2
    if middle <= a or middle >= d:
        return Fraction(0), Fraction(0)
    if b <= middle <= c or (middle < b and a == -math.inf) or (middle > c and d == math.inf):
        return Fraction(1), Fraction(1)
    if middle < b:
        a, b = Fraction(a), Fraction(b)
        return (x0 - a) / (b - a), (x1 - a) / (b - a)
    c, d = Fraction(c), Fraction(d)
    return (d - x0) / (d - c), (d - x1) / (d - c)


def rational_centroid(system, output, activations):
    """The centroid of the aggregated set in rational arithmetic, over all points where it can bend."""
    lower, upper = Fraction(output.lower.value), Fraction(output.upper.value)
    shapes = [(output.term(term).membership, Fraction(a)) for term, a in activations if a > 0.0]
    cuts = {lower, upper}
    for membership, _ in shapes:
        cuts |= {Fraction(x) for x, _ in corners(membership) if math.isfinite(x) and lower <= Fraction(x) <= upper}
    area = moment = Fraction(0)
    for x0, x1 in pairwise(sorted(cuts)):
        ends = [limits(m, x0, x1) for m, _ in shapes]
        heights = [a for _, a in shapes]
        if system.method.implication == "min":
            lines = [*ends, *((a, a) for a in heights)]
        else:
            lines = [(a * u, a * v) for a, (u, v) in zip(heights, ends, strict=True)]
        bends = {Fraction(0), Fraction(1)}
        for (u0, u1), (v0, v1) in combinations(lines, 2):
            if (u0 - v0) * (u1 - v1) < 0:
                bends.add((u0 - v0) / ((u0 - v0) - (u1 - v1)))

        def height(t, ends=ends, heights=heights):
            degrees = [u + (v - u) * t for u, v in ends]
            if system.method.implication == "min":
                cut = [min(a, d) for a, d in zip(heights, degrees, strict=True)]
            else:
                cut = [a * d for a, d in zip(heights, degrees, strict=True)]
            return max(cut, default=Fraction(0)) if system.method.aggregation == "max" else sum(cut, Fraction(0))

        for t0, t1 in pairwise(sorted(bends)):
            y0, y1 = height(t0), height(t1)
            a, b = x0 + (x1 - x0) * t0, x0 + (x1 - x0) * t1
            area += (b - a) * (y0 + y1) / 2
            moment += (b - a) * (y0 * (2 * a + b) + y1 * (a + 2 * b)) / 6
    return moment / area if area else None


def sampled_centroid(system, output, activations):
    lower, upper, n = output.lower.value, output.upper.value, system.method.defuzzifier.resolution
    area = moment = 0.0
    for i in range(n):
        midpoint = system.method.defuzzifier.grid == "midpoint"
        x = lower + ((i + 0.5) / n if midpoint else i / (n - 1)) * (upper - lower)
        cut = []
        for term, a in activations:
            d = degree(output.term(term).membership, x)
            cut.append(min(a, d) if system.method.implication == "min" else a * d)
        y = max(cut, default=0.0) if system.method.aggregation == "max" else sum(cut)
        area, moment = area + y, moment + y * x
    return moment / area if area else None


def activations_of(system, output, point):
    return [
        (c.term, rule.weight.value * truth(system, rule.antecedent, point))
        for rule in system.rules
        for c in rule.consequents
        if c.output == output.name
    ]


def reference(system, output, point):
    """Return the value of an output, or the word of its `else` that has none."""
    activations = activations_of(system, output, point)
    if system.method.defuzzifier.averages:
        total = sum(a for _, a in activations)
        value = None
        if total > 0.0:
            peaks = [np.mean(core(output.term(t).membership)) for t, _ in activations]
            value = sum(a * p for p, (_, a) in zip(peaks, activations, strict=True)) / total
    elif system.method.defuzzifier.resolution is None:
        value = rational_centroid(system, output, activations)
    else:
        value = sampled_centroid(system, output, activations)
    if value is not None:
        return float(value)
    match output.otherwise:
        case "nan":
            return math.nan
        case "midpoint":
            return (output.lower.value + output.upper.value) / 2
        case "error" | None:
            return "error"
    return output.otherwise.value


def core(membership):
    p = [a.value for a in membership.arguments]
    return {"triangle": p[1:2], "trapezoid": p[1:3], "gaussian": p[:1], "singleton": p[:1]}[membership.kind]


def clamped(system, point):
    return {
        v.name: x if v.extrapolate else min(max(x, v.lower.value), v.upper.value)
        for v, x in zip(system.inputs, point, strict=True)
    }


def clear(system, point):
    """Whether activations are well above the smallest numbers, where sums and products lose their digits."""
    values = [a for o in system.outputs for _, a in activations_of(system, o, clamped(system, point))]
    return all(a == 0.0 or a > 1e-12 for a in values)


def tolerance(output):
    lower, upper = output.lower.value, output.upper.value
    return 1e-13 * (upper - lower) + 4e-16 * max(abs(lower), abs(upper), 1.0)


def evaluate(kernel, point):
    try:
        result = kernel(*point)
    except NoRuleFiresError:
        return "error"
    return list(result) if isinstance(result, tuple) else [result]


def evaluate_batch(kernel, point):
    try:
        return list(np.atleast_1d(kernel.batch(np.array(point))))
    except NoRuleFiresError:
        return "error"


def alike(a, b, tolerances):
    if isinstance(a, str) or isinstance(b, str):
        return a == b
    return all((math.isnan(x) and math.isnan(y)) or abs(x - y) <= t for x, y, t in zip(a, b, tolerances, strict=True))


# --- properties ------------------------------------------------------------------------------------------------------


@quick(120)
@given(st.data())
def test_generated_python_and_numpy_agree_with_the_reference(data):
    system = data.draw(systems())
    kernel, arrays = compile_system(system, "python"), compile_system(system, "numpy")
    tolerances = [tolerance(o) for o in system.outputs]
    for point in data.draw(points(system)):
        found = evaluate(kernel, point)
        assert alike(found, evaluate_batch(arrays, point), tolerances)
        if any(math.isnan(x) for x in point):
            assert all(math.isnan(x) for x in found)
        elif clear(system, point):
            expected = [reference(system, o, clamped(system, point)) for o in system.outputs]
            note(f"{point} {found} {expected}")
            assert alike(found, "error" if "error" in expected else expected, tolerances)


@st.composite
def joined_sets(draw):
    """Two to five overlapping sets whose activations are the inputs themselves."""
    lower, upper = draw(st.sampled_from(RANGES))
    sets = draw(st.lists(linear_terms(lower, upper), min_size=2, max_size=5))
    ramp = Membership(kind="triangle", arguments=(Number(0.0), Number(1.0), Number(math.inf)))
    inputs = tuple(
        Input(name=f"x{i}", lower=Number(0.0), upper=Number(1.0), terms=(Term(name="on", membership=ramp),))
        for i in range(len(sets))
    )
    output = Output(
        name="u",
        lower=Number(lower),
        upper=Number(upper),
        terms=tuple(Term(name=f"t{i}", membership=m) for i, m in enumerate(sets)),
        otherwise="nan",
    )
    rules = tuple(
        Rule(antecedent=Is(variable=f"x{i}", term="on"), consequents=(Consequent(output="u", term=f"t{i}"),))
        for i in range(len(sets))
    )
    method = Method(
        implication=draw(st.sampled_from(["min", "product"])), aggregation=draw(st.sampled_from(["max", "sum"]))
    )
    return FuzzySystem(name="s", method=method, inputs=inputs, outputs=(output,), blocks=rules)


@quick(80)
@given(st.data())
def test_exact_centroids_are_exact(data):
    system = data.draw(joined_sets())
    kernel = compile_system(system, "python")
    output = system.outputs[0]
    lower, upper = output.lower.value, output.upper.value
    degrees = st.integers(0, 4).map(lambda i: i / 4) | st.floats(1e-9, 1.0)
    for _ in range(4):
        point = tuple(data.draw(degrees) for _ in system.inputs)
        expected = rational_centroid(system, output, [(f"t{i}", a) for i, a in enumerate(point)])
        found = kernel(*point)
        if expected is None:
            assert math.isnan(found)
        else:
            # 1e-14 of the range, and the last digit that a result near the ends of the range can have.
            assert abs(Fraction(found) - expected) <= 1e-14 * (upper - lower) + math.ulp(max(abs(lower), abs(upper)))


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
    tolerances = [tolerance(o) for o in system.outputs]
    for point in data.draw(points(system, count=30)):
        found = evaluate(kernel, point)
        assert alike(found, evaluate(compiled, point), tolerances)
        assert alike(found, evaluate_batch(compiled, point), tolerances)


@quick(80)
@given(st.data())
def test_every_sample_lies_within_the_proved_bounds(data):
    system = data.draw(systems())
    bounds, kernel = output_bounds(system), compile_system(system, "python")
    for point in data.draw(points(system, count=12)):
        found = evaluate(kernel, point)
        if not isinstance(found, str):
            for output, value in zip(system.outputs, found, strict=True):
                bound = bounds[output.name]
                assert math.isnan(value) or bound.lo <= value <= bound.hi


@quick(80)
@given(st.data())
def test_exact_bounds_are_attained_where_they_say(data):
    system = data.draw(systems(averages=True))
    kernel = compile_system(system, "python")
    for k, output in enumerate(system.outputs):
        bound = output_bounds(system)[output.name]
        for end, at in ((bound.lo, bound.lo_at), (bound.hi, bound.hi_at)):
            found = evaluate(kernel, tuple(at.values())) if at else "nowhere"
            if not isinstance(found, str):
                assert found[k] == end
        assume(bound.exact)
        assert bound.lo_at is not None
        assert bound.hi_at is not None


def critical_points(system):
    """Corners of the input terms with their neighbours among the floats, and points between."""
    flat = plan(system)
    axes = []
    for i, variable in enumerate(flat.inputs):
        own = breakpoints(variable, [d.set for d in flat.degrees if d.variable == i])
        between = [(a + b) / 2 for a, b in pairwise(own)]
        near = [math.nextafter(x, side) for x in own for side in (-math.inf, math.inf)]
        axes.append(sorted({*own, *between, *(x for x in near if variable.lower <= x <= variable.upper)})[::2])
    return list(product(*axes))[:400]


@quick(80)
@given(st.data())
def test_coverage_agrees_with_sampling_at_corners_and_beside_them(data):
    system = data.draw(systems(averages=True, extrapolate=False))
    verdicts = uncovered(system)
    for output in system.outputs:
        verdict = verdicts[output.name]

        def fires(point, output=output):
            return any(a > 0.0 for _, a in activations_of(system, output, clamped(system, point)))

        if verdict is None:
            assert all(fires(point) for point in critical_points(system))
        elif isinstance(verdict, Hole):
            assert not fires(tuple(verdict.witness.values()))
            for ends in product(*((s.lower, s.upper) for s in verdict.region.values())):
                inside = [s.middle * 0.5 + e * 0.5 for s, e in zip(verdict.region.values(), ends, strict=True)]
                assert not fires(inside)


@quick(60)
@given(st.data())
def test_arrays_give_what_points_give_and_warn_about_nothing(data):
    system = data.draw(systems(extrapolate=False))
    for output in system.outputs:
        assume(output.otherwise not in ("error", None))
    kernel = compile_system(system, "numpy")
    batch = np.array(data.draw(points(system, count=8))).reshape(2, 4, -1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = kernel.batch(batch)
    width = len(system.outputs)
    assert found.shape == ((2, 4) if width == 1 else (2, 4, width))
    for index in np.ndindex(2, 4):
        single = evaluate(kernel, batch[index].tolist())
        assert alike(single, np.atleast_1d(found[index]), [tolerance(o) for o in system.outputs])
