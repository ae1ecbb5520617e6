"""A slow, obvious interpreter of systems: what the reference says, in plain Python, point by point.

It shares no code with the kernels: neither formulas nor plans. What it does not know it refuses.
"""

import math
from functools import reduce
from itertools import chain

from fuzzyctl.expr import evaluate, names_in
from fuzzyctl.model.rule import And, Is, Not, Or, RuleBlock, rules_of
from fuzzyctl.model.variable import Hold


def near(a, b, equal):
    """Whether two degrees count as equal."""
    return a == b or abs(a - b) < equal


def norm(name, a, b, equal):
    match name:
        case "min":
            return min(a, b)
        case "max":
            return max(a, b)
        case "product":
            return a * b
        case "sum":
            return a + b
        case "probabilistic_sum":
            return a + b * (1.0 - a)
        case "bounded_sum":
            return min(1.0, a + b)
        case "bounded_difference":
            return max(0.0, a + b - 1.0)
        case "drastic_product":
            return min(a, b) if near(max(a, b), 1.0, equal) else 0.0
        case "drastic_sum":
            return max(a, b) if near(min(a, b), 0.0, equal) else 1.0
        case "nilpotent_minimum":
            return min(a, b) if a + b > 1.0 and not near(a + b, 1.0, equal) else 0.0
        case "nilpotent_maximum":
            return max(a, b) if a + b < 1.0 and not near(a + b, 1.0, equal) else 1.0
    raise NotImplementedError(name)


def hedged(name, x, cube):
    match name:
        case "very":
            return x * x
        case "somewhat":
            return math.sqrt(x)
        case "not":
            return 1.0 - x
        case "any":
            return 1.0
        case "extremely" if cube:
            return x**3
        case "extremely":
            return 2 * x * x if x <= 0.5 else 1 - 2 * (1 - x) ** 2
    raise NotImplementedError(name)


def undone(name, x, cube):
    match name:
        case "very":
            return math.sqrt(x)
        case "somewhat":
            return x * x
        case "not":
            return 1.0 - x
        case "extremely" if cube:
            return x ** (1 / 3)
    raise NotImplementedError(name)


def sigmoid(x, inflection, slope):
    return 1 / (1 + math.exp(-slope * (x - inflection)))


class Reference:
    """One evaluation of a system at one point.

    Args:
        system: The system.
        point: A number for each input, by name.
        previous: The previous value of each output that holds it.
    """

    def __init__(self, system, point, previous=None):
        self.system, self.semantics = system, system.method.semantics
        self.variables = {v.name: v for v in (*system.inputs, *system.outputs)}
        self.previous = previous or {}
        self.point = {
            v.name: point[v.name]
            if v.extrapolate
            else min(max(point[v.name], self.number(v.lower)), self.number(v.upper))
            for v in system.inputs
        }
        self.values = {}
        self.acting = {}
        self.triggered = {}
        #: The block of each rule; of rules of no block the method of the system.
        self.blocks = [system.method for b in system.blocks if not isinstance(b, RuleBlock) for _ in rules_of(b)]
        for block in system.blocks:
            if isinstance(block, RuleBlock):
                self.blocks += [block for part in block.rules for _ in rules_of(part)]
        self.effects = {}
        if self.semantics.chained == "degree":
            for r in range(len(system.rules)):
                self.activation(r)

    def number(self, expr):
        return self.system.number(expr)

    def outputs(self):
        return {o.name: self.value(o.name) for o in self.system.outputs}

    # -- degrees and rules

    def membership(self, membership, x):
        p = [self.number(a) for a in membership.arguments]
        match membership.kind:
            case "triangle" | "trapezoid":
                a, b, *c, d = p
                c = c[0] if membership.kind == "trapezoid" else b
                if x < b:
                    return 1.0 if a == -math.inf else max(0.0, (x - a) / (b - a))
                return 1.0 if x <= c or d == math.inf else max(0.0, (d - x) / (d - c))
            case "gaussian":
                return math.exp(-0.5 * ((x - p[0]) / p[1]) ** 2)
            case "sigmoid_difference":
                difference = sigmoid(x, p[0], p[1]) - sigmoid(x, p[3], p[2])
                clamped = self.semantics.sigmoid_difference == "clamped"
                return max(0.0, difference) if clamped else abs(difference)
        raise NotImplementedError(membership.kind)

    def degree(self, literal):
        declared = self.variables[literal.variable]
        if literal.variable in self.point:
            return self.membership(declared.term(literal.term).membership, self.point[literal.variable])
        if self.semantics.chained == "degree":
            own = [a for term, a in self.effects.get(literal.variable, []) if term == literal.term]
            return self.joined(declared, own) if own else 0.0
        low, high = self.number(declared.lower), self.number(declared.upper)
        value = min(max(self.value(literal.variable), low), high)
        return self.membership(declared.term(literal.term).membership, value)

    def method(self, r, field):
        """What counts for a rule: what its block says, else what the system says."""
        own = getattr(self.blocks[r], field)
        return getattr(self.system.method, field) if own is None else own

    def truth(self, antecedent, r):
        equal = self.semantics.equal
        match antecedent:
            case Is(hedges=hedges):
                found = self.degree(antecedent)
                for name in reversed(hedges):
                    found = hedged(name, found, self.semantics.extremely == "cube")
                return found
            case Not(operand=operand):
                return 1.0 - self.truth(operand, r)
            case And(operands=operands):
                name = self.method(r, "conjunction")
                return reduce(lambda a, b: norm(name, a, b, equal), [self.truth(o, r) for o in operands])
            case Or(operands=operands):
                name = self.method(r, "disjunction")
                return reduce(lambda a, b: norm(name, a, b, equal), [self.truth(o, r) for o in operands])
        raise NotImplementedError(antecedent)

    def activation(self, r):
        """How far a rule acts; what its consequents feel of it is noted for later rules."""
        if r not in self.acting:
            rule = self.system.rules[r]
            fired = self.truth(rule.antecedent, r)
            self.acting[r] = (fired, self.chosen(r))
            for k, c in enumerate(rule.consequents):
                self.effects.setdefault(c.output, []).append((c.term, self.effect(r, k)))
        return self.acting[r]

    def own(self, r):
        """The activation of a rule by itself."""
        rule = self.system.rules[r]
        weight = self.number(rule.weight)
        fired = self.truth(rule.antecedent, r)
        return fired * weight if self.semantics.weight == "before" else fired * (weight > 0)

    def gated(self, activation):
        least = self.semantics.least
        # Degrees so far may add up to more than 1, and what is not more than 1 is below 0.
        return activation if activation > (least or 0.0) else 0.0

    def chosen(self, r):
        """The activation of a rule as the activation method of its block lets it act."""
        method, own = self.method(r, "activation"), self.own(r)
        self.triggered[r] = True
        match method.kind:
            case "general":
                return self.gated(own)
            case "threshold" if method.comparison == ">=":
                self.triggered[r] = own >= self.number(method.threshold)
                return self.gated(own) if self.triggered[r] else 0.0
            case "highest":
                among = {k: self.gated(self.own(k)) for k, b in enumerate(self.blocks) if b is self.blocks[r]}
                best = sorted((k for k, a in among.items() if a > 0.0), key=lambda k: (-among[k], k))
                self.triggered[r] = r in best[: method.count]
                return among[r] if self.triggered[r] else 0.0
        raise NotImplementedError(method.kind)

    def effect(self, r, k):
        """The activation of a rule as its consequent number k feels it."""
        rule, how, cube = self.system.rules[r], self.semantics.consequent_hedges, self.semantics.extremely == "cube"
        acts = self.activation(r)[1]
        output = self.variables[rule.consequents[k].output]
        hedges = [list(reversed(c.hedges)) for c in rule.consequents]
        if acts > 0.0 or (self.semantics.least is None and self.triggered[r]):
            if how == "carried":
                acts = reduce(lambda a, h: hedged(h, a, cube), chain.from_iterable(hedges[: k + 1]), acts)
            elif how == "activation":
                acts = reduce(lambda a, h: hedged(h, a, cube), hedges[k], acts)
            elif how == "undone" and self.defuzzifier(output).over_rules:
                acts = reduce(lambda a, h: undone(h, a, cube), hedges[k], acts)
        return acts * (self.number(rule.weight) if self.semantics.weight == "after" else 1.0)

    # -- outputs

    def defuzzifier(self, output):
        return output.defuzzifier or self.system.method.defuzzifier

    def joined(self, output, parts):
        name = output.aggregation or self.system.method.aggregation
        return reduce(lambda a, b: norm(name, a, b, self.semantics.equal), parts)

    def value(self, name):
        if name not in self.values:
            output = self.variables[name]
            over_rules = self.defuzzifier(output).over_rules
            found = self.average(output) if over_rules else self.centroid(output)
            if math.isnan(found):
                found = self.otherwise(output)
            if output.clamped:
                low, high = self.number(output.lower), self.number(output.upper)
                found = found if math.isnan(found) else min(max(found, low), high)
            self.values[name] = found
        return self.values[name]

    def otherwise(self, output):
        low, high = self.number(output.lower), self.number(output.upper)
        match output.otherwise:
            case "midpoint":
                return (low + high) / 2
            case "nan" | None:
                return math.nan
            case Hold(start=start):
                first = math.nan if start == "nan" else (low + high) / 2 if start is None else self.number(start)
                return self.previous.get(output.name, first)
        return self.number(output.otherwise)

    def place(self, output, term):
        """Where a consequent is: the middle of its core, or the value of its function."""
        membership = term if not isinstance(term, str) else output.term(term).membership
        match membership.kind:
            case "constant":
                return self.number(membership.arguments[0])
            case "triangle":
                return self.number(membership.arguments[1])
            case "linear":
                *factors, constant = (self.number(a) for a in membership.arguments)
                return sum(f * self.point[v.name] for f, v in zip(factors, self.system.inputs, strict=True)) + constant
            case "function":
                values = self.system.values | self.point
                reads = [o.name for o in self.system.outputs if o.name != output.name]
                values |= {n: self.value(n) for n in reads if n in {m.name for m in names_in(membership.arguments[0])}}
                read = {n.name for n in names_in(membership.arguments[0])}
                if any(math.isnan(values[n]) for n in read if n in values):
                    return math.nan
                return evaluate(membership.arguments[0], values)
        raise NotImplementedError(membership.kind)

    def concluding(self, output):
        """The rules that name an output, each with the position of the consequent."""
        rules = enumerate(self.system.rules)
        return [(r, k) for r, rule in rules for k, c in enumerate(rule.consequents) if c.output == output.name]

    def average(self, output):
        kind, s = self.defuzzifier(output).kind, self.semantics
        parts = []
        for r, k in self.concluding(output):
            term = self.system.rules[r].consequents[k].term
            parts.append((term, self.place(output, term), self.effect(r, k)))
        groups = {}
        for r, (term, place, acts) in enumerate(parts):
            key = {"rules": r, "terms": repr(term), "places": place}[s.merge]
            groups.setdefault(key, []).append((place, acts))
        sums = [(own[0][0], self.joined(output, [a for _, a in own])) for own in groups.values()]
        numerator = sum(a * z for z, a in sums if a > 0.0)
        if kind == "weighted_sum":
            return numerator if any(a > 0.0 for _, a in sums) else math.nan
        match s.total:
            case "activations":
                total = sum(a for _, a in sums)
            case "strengths":
                total = sum(self.activation(r)[0] for r, _ in self.concluding(output))
            case "all_rules":
                after = s.weight == "after"
                weights = [self.number(r.weight) if after else 1.0 for r in self.system.rules]
                total = sum(self.activation(r)[1] * w for r, w in enumerate(weights))
        return numerator / total if total > 0.0 else math.nan

    def centroid(self, output):
        own, s = self.defuzzifier(output), self.semantics
        low, high, n = self.number(output.lower), self.number(output.upper), own.resolution
        step = {"midpoint": (high - low) / n, "left": (high - low) / n, "endpoints": (high - low) / max(n - 1, 1)}
        shift = 0.5 if own.grid == "midpoint" else 0.0
        xs = [low + (i + shift) * step[own.grid] for i in range(n)]
        effects = [(r, k, self.effect(r, k)) for r, k in self.concluding(output)]
        usual = output.implication or self.system.method.implication
        degrees = []
        for x in xs:
            parts = []
            for r, k, acts in effects:
                c, weight = self.system.rules[r].consequents[k], 1.0
                mu = self.membership(output.term(c.term).membership, x)
                if s.consequent_hedges in ("set", "undone"):
                    mu = reduce(lambda a, h: hedged(h, a, s.extremely == "cube"), reversed(c.hedges), mu)
                if s.weight == "after":
                    # The weight scales the implied set.
                    weight = self.number(self.system.rules[r].weight)
                    acts = acts / weight if weight else 0.0
                own_block = isinstance(self.blocks[r], RuleBlock)
                implication = (self.blocks[r].implication if own_block else None) or usual
                parts.append(weight * norm(implication, acts, mu, s.equal))
            degrees.append(self.joined(output, parts))
        ends = [0.5 if own.rule == "trapezoid" and i in (0, n - 1) else 1.0 for i in range(n)]
        area = sum(w * d for w, d in zip(ends, degrees, strict=True))
        moment = sum(w * d * x for w, d, x in zip(ends, degrees, xs, strict=True))
        return moment / area if area > 0.0 else math.nan
