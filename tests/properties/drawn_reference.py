"""Inference as plainly as possible, on formulas that have tests of their own: what drawn systems are held to."""

import math
from functools import reduce
from itertools import accumulate, pairwise
from random import Random

from fuzzyctl.diagnostics.diagnostic import NoRuleFiresError
from fuzzyctl.expr import Name, evaluate
from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, DISJUNCTIONS, HEDGES, MEMBERSHIP, inverse_hedge
from fuzzyctl.kernels.program.scalar import scalar_function
from fuzzyctl.model.rule import And, Is, Not, RuleBlock
from fuzzyctl.model.variable import Hold, Output

X = Name("x")
#: How much degrees and activations may be off by rounding.
NOISE = 1e-13

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


def undone(name, x):
    return formula(lambda: inverse_hedge(name)(X), "inverse hedge", name)(x)


class Reference:
    """One evaluation of a system at a point; with a seed as if degrees and activations were off by rounding.

    Exact defuzzifiers it does not know: the values of such outputs are given, and off by rounding, too.
    """

    def __init__(self, system, point, seed=None, given=()):
        self.system, self.random, self.given = system, None if seed is None else Random(seed), dict(given)
        self.values = {
            v.name: min(max(x, v.lower.value), v.upper.value) for v, x in zip(system.inputs, point, strict=True)
        }
        self.results = {}
        self.tiny = False
        loose = [r for r in system.blocks if not isinstance(r, RuleBlock)]
        groups = [(system.method, loose), *((b, b.rules) for b in system.blocks if isinstance(b, RuleBlock))]
        #: What the block of a rule says, and the rules of the block, by the identity of the rule.
        self.blocks = {id(rule): group for group in groups for rule in group[1]}

    def shaken(self, x):
        return x if self.random is None else x * (1.0 - NOISE * self.random.random())

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
                found = self.shaken(degree(variable.term(term).membership, name, self.values[name]))
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
            output = self.system.output(name)
            value = self._given(output) if name in self.given else self._output(output)
            if output.clamped and not isinstance(value, str) and not math.isnan(value):
                value = min(max(value, output.lower.value), output.upper.value)
            self.results[name] = value
        if isinstance(self.results[name], str):
            raise NoRuleFiresError(name, "")
        return self.results[name]

    def _given(self, output):
        width = output.upper.value - output.lower.value
        off = 0.0 if self.random is None else NOISE * (self.random.random() - 0.5) * width
        return self.given[output.name] + off

    def _output(self, output):
        rules = [(k, r) for r in self.system.rules for k, c in enumerate(r.consequents) if c.output == output.name]
        for _, rule in rules:
            for other in self.compared(rule):
                self.fired(other)
        if any(math.isnan(self.values.get(n, 0.0)) for n in self._read(output.name)):
            return math.nan
        acting = [(rule.consequents[k], rule, k, self.shaken(self.activation(rule))) for k, rule in rules]
        self.tiny |= any(0.0 < a < 1e-12 for *_, a in acting)
        felt = [(c, self.felt(output, rule, k, a), self.implication(rule, output)) for c, rule, k, a in acting if a > 0]
        self.tiny |= any(0.0 < a < 1e-12 for _, a, _ in felt)
        felt = [(c, a, implied) for c, a, implied in felt if a > 0]
        value = self._defuzzified(output, felt) if felt else None
        if value is not None:
            return value
        if isinstance(output.otherwise, Hold):  # what is held at first
            start = output.otherwise.start
            return math.nan if start == "nan" else self._middle(output) if start is None else start.value
        match output.otherwise:
            case "nan":
                return math.nan
            case "midpoint":
                return self._middle(output)
            case "error" | None:
                return "error"
        return output.otherwise.value

    def _middle(self, output):
        return (output.lower.value + output.upper.value) / 2

    def felt(self, output, rule, position, activation):
        """What hedges in consequents make of an activation that is above 0."""
        how, own = self.system.method.semantics.consequent_hedges, rule.consequents[position]
        if how == "carried":
            before = [h for c in rule.consequents[:position] for h in reversed(c.hedges)]
            return reduce(lambda a, h: hedged(h, a), [*before, *reversed(own.hedges)], activation)
        if how == "activation":
            return reduce(lambda a, h: hedged(h, a), reversed(own.hedges), activation)
        if how == "undone" and output.defuzzifier.over_rules:
            return reduce(lambda a, h: undone(h, a), reversed(own.hedges), activation)
        return activation

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

    def _defuzzified(self, output, felt):
        own = output.defuzzifier
        if not own.over_rules:
            return None if own.resolution is None else self._place(output, felt)
        total = sum(a for _, a, _ in felt)
        weighted = sum(a * self._consequent(output, c.term, a) for c, a, _ in felt)
        return weighted if own.kind.endswith("_sum") else weighted / total

    def _consequent(self, output, term, activation):
        membership = output.term(term).membership if isinstance(term, str) else term
        if membership.kind == "linear":
            *factors, constant = (a.value for a in membership.arguments)
            inputs = [self.values[i.name] for i in self.system.inputs]
            return sum(c * x for c, x in zip(factors, inputs, strict=True)) + constant
        if membership.kind == "function":
            return evaluate(membership.arguments[0], self.values)
        p = tuple(a.value for a in membership.arguments)
        if output.defuzzifier.kind.startswith("inverse"):
            place = degree(membership, output.name, activation)
            return min(max(place, output.lower.value), output.upper.value)
        if "tsukamoto" not in output.defuzzifier.kind:
            return sum(MEMBERSHIP[membership.kind].core(p)) / 2
        share = min(1.0, activation / membership.height.value)
        place = formula(lambda: MEMBERSHIP[membership.kind].inverse(Name("w"), p), "inverse", membership.kind, p)(share)
        return min(max(place, output.lower.value), output.upper.value)

    def _place(self, output, felt):
        """The place that the defuzzifier finds in the samples of the aggregated set; None in an empty one."""
        lower, upper, own = output.lower.value, output.upper.value, output.defuzzifier
        count = own.resolution
        width, cells = upper - lower, count - 1 if own.grid == "endpoints" else count
        shift = 0.5 if own.grid == "midpoint" else 0.0
        places = [lower + (i + shift) * width / cells for i in range(count)]
        if self.random is not None:
            places = [x + NOISE * (self.random.random() - 0.5) * width for x in places]
        samples = [self._aggregated(output, felt, x) for x in places]
        # The bisector from both ends does not look at the first sample.
        if max(samples[1:] if own.rule == "two_sided" else samples) <= 0.0:
            return None
        if own.kind == "centroid":
            ends = [0.5 if own.rule == "trapezoid" and i in (0, count - 1) else 1.0 for i in range(count)]
            area = sum(w * y for w, y in zip(ends, samples, strict=True))
            moment = sum(w * y * x for w, y, x in zip(ends, samples, places, strict=True))
            return moment / area if area > 0.0 else None
        if own.kind == "bisector":
            return BISECTORS[own.rule or "interpolated"](places, samples, width / cells, output)
        return maximum(own, places, samples)

    def _aggregated(self, output, felt, x):
        cuts = []
        for consequent, activation, implied in felt:
            own = self.shaken(degree(output.term(consequent.term).membership, output.name, x))
            if self.system.method.semantics.consequent_hedges in ("set", "undone"):
                own = reduce(lambda a, h: hedged(h, a), reversed(consequent.hedges), own)
            cuts.append(norm(CONJUNCTIONS, implied)(activation, own))
        return reduce(norm(AGGREGATIONS, output.aggregation), cuts)


def running(own, places, samples):
    """A largest degree so far, as fuzzylite 6 has it."""
    same, most, place, end, stays = own.tolerance or 0.0, -1.0, places[0], places[0], False
    for x, y in zip(places, samples, strict=True):
        equal = y == most or abs(y - most) < same
        if own.kind == "lom" and (equal or y > most):
            most, place = y, x
        elif own.kind != "lom" and not equal and y > most:
            most, place, end, stays = y, x, x, True
        elif equal and stays:
            end = x
        elif not equal and y < most:
            stays = False
    return 0.5 * (place + end) if own.kind == "mom" else place


def maximum(own, places, samples):
    if own.rule == "running":
        return running(own, places, samples)
    bound = (1.0 - (1e-9 if own.tolerance is None else own.tolerance)) * max(samples)
    largest = [x for x, y in zip(places, samples, strict=True) if y >= bound]
    if own.kind == "mom":
        return sum(largest) / len(largest)
    return (min if own.kind == "som" else max)(largest, key=abs if own.by == "magnitude" else None)


def first(places, samples, step, output):
    half = sum(samples) / 2
    return next(x for x, area in zip(places, accumulate(samples), strict=True) if area >= half)


def nearest(places, samples, step, output):
    away = [abs(area / sum(samples) - 0.5) for area in accumulate(samples)]
    best = [x for x, d in zip(places, away, strict=True) if d == min(away)]
    return sum(best) / len(best)


def walk(places, samples, step, output):
    areas = [(a + b) / 2 for a, b in pairwise(samples)]
    left, right, k = 0.0, sum(areas), 0
    if right <= 0.0:
        return None
    while left < right:
        left, right, k = left + areas[k], right - areas[k], k + 1
    return places[k] if areas[k - 1] >= left - right else places[k - 1]


def two_sided(places, samples, step, output):
    low, high, below, above = 0, len(samples) - 1, 0.0, 0.0
    while low < high:
        if below <= above:
            low, below = low + 1, below + samples[low + 1]
        else:
            high, above = high - 1, above + samples[high - 1]
    return places[low] if below > 0.0 else None


def between(places, samples, step, output):
    same, low, high, below, above = output.defuzzifier.tolerance or 0.0, 0, len(samples), 0.0, 0.0
    while low < high:
        if below <= above or below - above < same:
            low, below = low + 1, below + samples[low]
        else:
            high, above = high - 1, above + samples[high - 1]
    left = places[low - 1] if low else output.lower.value
    right = places[high] if high < len(samples) else output.upper.value
    return (below * right + above * left) / (below + above)


def interpolated(places, samples, step, output):
    """Up to where the area is half; cells are flat, or between the ends of the range straight."""
    straight = output.defuzzifier.grid == "endpoints"
    starts = places if output.defuzzifier.grid != "midpoint" else [x - step / 2 for x in places]
    lines = pairwise(samples) if straight else ((y, y) for y in samples)
    cells = [(x, a, b) for x, (a, b) in zip(starts, lines, strict=False) if a + b > 0.0]
    rest = sum(a + b for _, a, b in cells) / 4
    for k, (x, a, b) in enumerate(cells):
        area = (a + b) / 2
        if abs(rest - area) <= 1e-13 * area and k + 1 < len(cells):
            return (x + step + cells[k + 1][0]) / 2  # the middle of a gap, if there is one
        if rest <= area:
            root = math.sqrt(max(0.0, a * a + 2 * (b - a) * rest))
            return x + step * min(1.0, 2 * rest / (a + root))
        rest -= area
    return cells[-1][0] + step if cells else None


BISECTORS = {
    "interpolated": interpolated,
    "first": first,
    "nearest": nearest,
    "walk": walk,
    "two_sided": two_sided,
    "between": between,
}


def reference(system, point, seed=None, given=()):
    """Return all outputs, "error" where a kernel refuses, and whether activations are far from the smallest numbers."""
    found = Reference(system, point, seed, given)
    try:
        values = [found.output(o.name) for o in system.outputs]
    except NoRuleFiresError:
        return "error", not found.tiny
    return values, not found.tiny
