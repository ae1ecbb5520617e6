"""A slow, obvious interpreter of systems: what the reference documentation says, in plain Python, point by point.

It shares no code with the kernels: neither formulas nor plans. What it does not know it refuses.
"""

import math
from functools import reduce
from itertools import chain
from random import Random

from fuzzyctl import And, Hold, Is, Not, Or, Output, RuleBlock, RuleTable
from fuzzyctl.expr import evaluate, names_in
from tests.reference import samples
from tests.reference.formulas import FLOAT, HEDGES, INVERSES, core_middle, corners, degree, inverse, norm
from tests.reference.sets import Straight

#: How much degrees and activations may be off by rounding.
NOISE = 1e-13


def literals(antecedent):
    """Return every `input is term` of an antecedent."""
    if isinstance(antecedent, Is):
        return [antecedent]
    parts = [antecedent.operand] if isinstance(antecedent, Not) else antecedent.operands
    return [literal for part in parts for literal in literals(part)]


def rules_of(part):
    """Return the rules of a table, or the one rule."""
    return part.rules() if isinstance(part, RuleTable) else [part]


class NoRuleFiresError(Exception):
    """No rule fires for an output whose `else` is an error."""


class Reference:
    """One evaluation of a system at one point.

    Args:
        system: The system.
        point: A number for each input, in their order.
        previous: The previous value of each output that holds it.
        seed: Of the noise on degrees and activations, as if they were off by rounding; None for no noise.
        given: Values of outputs that are not computed here, such as exact centroids of curved sets.
    """

    def __init__(self, system, point, previous=None, *, seed=None, given=()):
        self.system, self.semantics = system, system.method.semantics
        self.random = None if seed is None else Random(seed)
        self.previous, self.given = previous or {}, dict(given)
        self.variables = {v.name: v for v in (*system.inputs, *system.outputs)}
        self.point = {
            v.name: x if v.extrapolate else min(max(x, self.number(v.lower)), self.number(v.upper))
            for v, x in zip(system.inputs, point, strict=True)
        }
        #: The block of each rule; of rules of no block the method of the system.
        self.blocks = [system.method for b in system.blocks if not isinstance(b, RuleBlock) for _ in rules_of(b)]
        for block in system.blocks:
            if isinstance(block, RuleBlock):
                self.blocks += [block for part in block.rules for _ in rules_of(part)]
        self.results, self.strengths, self.acting, self.effects = {}, {}, {}, {}
        self.triggered = set()
        #: Whether an activation is so small that rounding has taken its digits.
        self.tiny = False
        if self.semantics.chained == "degree":
            for r in range(len(system.rules)):
                self.activation(r)

    def number(self, expr):
        return self.system.number(expr)

    def range(self, variable):
        return self.number(variable.lower), self.number(variable.upper)

    def shaken(self, x):
        return x if self.random is None else x * (1.0 - NOISE * self.random.random())

    def moved(self, x, width):
        return x if self.random is None else x + NOISE * (self.random.random() - 0.5) * width

    def values(self):
        """Return the values of all outputs; "error" where one has none and says so."""
        try:
            return [self.value(o.name) for o in self.system.outputs]
        except NoRuleFiresError:
            return "error"

    # -- degrees and rules

    def membership(self, membership, variable, x):
        height = self.number(membership.height)
        if membership.kind == "function":
            return height * self.function(membership.arguments[0], {variable: x})
        p = [self.number(a) for a in membership.arguments]
        clamped = self.semantics.sigmoid_difference == "clamped"
        return self.shaken(height * degree(FLOAT, membership.kind, p, x, clamped=clamped))

    def function(self, expression, values):
        try:
            return FLOAT.within_unit(evaluate(expression, self.system.values | values))
        except ValueError:  # 1 / x at 0: a quotient by zero is infinite
            return 1.0 if all(math.copysign(1.0, x) > 0.0 for x in values.values()) else 0.0

    def hedged(self, hedges, x):
        """Apply hedges, the last one first."""
        return reduce(lambda x, name: self.hedge(name, x), reversed(hedges), x)

    def hedge(self, name, x):
        own = next((h for h in self.system.hedges if h.name == name), None)
        if own is not None:
            return self.function(own.expression, {own.parameter: x})
        return HEDGES[self.hedge_name(name)](FLOAT, x)

    def hedge_name(self, name):
        return "cube" if name == "extremely" and self.semantics.extremely == "cube" else name

    def degree(self, literal):
        name, declared = literal.variable, self.variables[literal.variable]
        if name in self.point:
            return self.membership(declared.term(literal.term).membership, name, self.point[name])
        if self.semantics.chained == "degree":
            own = [a for term, a in self.effects.get(name, []) if term == literal.term]
            return self.joined(declared, own) if own else 0.0
        low, high = self.range(declared)
        return self.membership(declared.term(literal.term).membership, name, min(max(self.value(name), low), high))

    def method(self, r, field):
        """What counts for a rule: what its block says, else what the system says."""
        own = getattr(self.blocks[r], field)
        return getattr(self.system.method, field) if own is None else own

    def truth(self, antecedent, r):
        match antecedent:
            case Is(hedges=hedges):
                return self.hedged(hedges, self.degree(antecedent))
            case Not(operand=operand):
                return 1.0 - self.truth(operand, r)
            case And(operands=operands):
                return self.join(self.method(r, "conjunction"), [self.truth(o, r) for o in operands])
            case Or(operands=operands):
                return self.join(self.method(r, "disjunction"), [self.truth(o, r) for o in operands])
        raise NotImplementedError(antecedent)

    def join(self, name, parts):
        return reduce(lambda a, b: norm(FLOAT, name, a, b, self.semantics.equal), parts)

    def joined(self, output, parts):
        return self.join(output.aggregation or self.system.method.aggregation, parts)

    def strength(self, r):
        if r not in self.strengths:
            self.strengths[r] = self.truth(self.system.rules[r].antecedent, r)
        return self.strengths[r]

    def compared(self, r):
        """The rules whose strengths decide how far a rule acts: those of its block, or itself."""
        if self.method(r, "activation").kind in ("general", "threshold"):
            return [r]
        return [k for k, block in enumerate(self.blocks) if block is self.blocks[r]]

    def own(self, r):
        """The activation of a rule by itself."""
        weight = self.number(self.system.rules[r].weight)
        return self.strength(r) * (weight if self.semantics.weight == "before" else weight > 0)

    def gated(self, activation):
        # Degrees so far may add up to more than 1, and what is not more than 1 is below 0.
        return activation if activation > (self.semantics.least or 0.0) else 0.0

    def activation(self, r):
        """How far a rule acts, as the activation method of its block says."""
        if r not in self.acting:
            self.acting[r] = self.shaken(self.chosen(r))
            self.tiny |= 0.0 < self.acting[r] < 1e-12
            if self.semantics.chained == "degree":
                for k, c in enumerate(self.system.rules[r].consequents):
                    self.effects.setdefault(c.output, []).append((c.term, self.effect(r, k)))
        return self.acting[r]

    def chosen(self, r):
        method, own = self.method(r, "activation"), self.own(r)
        bound = self.number(method.threshold) if method.threshold else 0.0
        among = {k: self.gated(self.own(k)) for k in self.compared(r)}
        ranked = [k for k, a in among.items() if a > 0.0 and a >= bound]
        match method.kind:
            case "general":
                acts = True
            case "proportional":
                total = sum(among.values())
                return among[r] / total if total > 0.0 else 0.0
            case "threshold":
                holds = {"<": own < bound, "<=": own <= bound, "==": own == bound, ">=": own >= bound, ">": own > bound}
                acts = own != bound if method.comparison == "!=" else holds[method.comparison]
            case "first":
                acts = r in ranked[: method.count]
            case "last":
                acts = r in ranked[-method.count :]
            case "highest":
                acts = r in sorted(ranked, key=lambda k: -among[k])[: method.count]
            case "lowest":
                acts = r in sorted(ranked, key=lambda k: among[k])[: method.count]
            case _:
                raise NotImplementedError(method.kind)
        if acts:
            self.triggered.add(r)
        return among[r] if acts else 0.0

    def effect(self, r, k):
        """The activation of a rule as its consequent number k feels it."""
        rule, how, acts = self.system.rules[r], self.semantics.consequent_hedges, self.activation(r)
        hedges = [list(reversed(c.hedges)) for c in rule.consequents]
        felt = []
        if acts > 0.0 or (self.semantics.least is None and r in self.triggered):
            if how == "carried":
                felt = chain.from_iterable(hedges[: k + 1])
            elif how == "activation":
                felt = hedges[k]
            elif how == "undone" and self.defuzzifier(self.variables[rule.consequents[k].output]).over_rules:
                felt = [INVERSES[self.hedge_name(h)] for h in hedges[k]]
        acts = reduce(lambda a, h: self.hedge(h, a), felt, acts)
        self.tiny |= 0.0 < acts < 1e-12
        return acts * (self.number(rule.weight) if self.semantics.weight == "after" else 1.0)

    # -- outputs

    def defuzzifier(self, output):
        return output.defuzzifier or self.system.method.defuzzifier

    def value(self, name):
        """Return the value of an output; NaN where it reads one that has none."""
        if name not in self.results:
            output = self.variables[name]
            low, high = self.range(output)
            found = self.moved(self.given[name], high - low) if name in self.given else self.inferred(output)
            if found is None or (math.isnan(found) and self.semantics.fallback == "undefined"):
                found = self.otherwise(output)
            self.results[name] = min(max(found, low), high) if output.clamped and not math.isnan(found) else found
        return self.results[name]

    def otherwise(self, output):
        low, high = self.range(output)
        match output.otherwise:
            case "midpoint":
                return (low + high) / 2
            case "nan":
                return math.nan
            case "error" | None:
                raise NoRuleFiresError(output.name)
            case Hold(start=start):
                first = math.nan if start == "nan" else (low + high) / 2 if start is None else self.number(start)
                return self.previous.get(output.name, first)
        return self.number(output.otherwise)

    def concluding(self, output):
        """The rules that name an output, each with the position of the consequent."""
        rules = enumerate(self.system.rules)
        return [(r, k) for r, rule in rules for k, c in enumerate(rule.consequents) if c.output == output.name]

    def parts(self, output):
        """The rules that an output feels: number, position and term of the consequent, activation there."""
        found = [(r, k, self.effect(r, k)) for r, k in self.concluding(output)]
        return [(r, k, self.system.rules[r].consequents[k].term, a) for r, k, a in found if a]

    def inferred(self, output):
        """Return what the rules say; None where they say nothing."""
        if self.semantics.chained == "value":
            read = {name for r, _ in self.concluding(output) for k in self.compared(r) for name in self.read(k)}
            if any([math.isnan(self.value(name)) for name in sorted(read)]):
                return math.nan
        parts, own, (low, high) = self.parts(output), self.defuzzifier(output), self.range(output)
        if own.over_rules:
            return self.average(output, parts)
        if not parts:
            return None
        if own.resolution is None:
            return self.rational(output, parts)
        xs = [self.moved(x, high - low) for x in samples.locations(own, low, high)]
        return samples.defuzzified(own, xs, [self.aggregated(output, parts, x) for x in xs], low, high)

    def read(self, r):
        """The outputs that the antecedent of a rule reads."""
        names = {literal.variable for literal in literals(self.system.rules[r].antecedent)}
        return {name for name in names if isinstance(self.variables[name], Output)}

    def average(self, output, parts):
        s, groups = self.semantics, {}
        for r, _, term, acts in parts:
            at = self.location(output, term, acts)
            key = {"rules": r, "terms": repr(term), "places": at}[s.merge]
            groups.setdefault(key, []).append((at, acts))
        sums = [(own[0][0], self.joined(output, [a for _, a in own])) for own in groups.values()]
        numerator = sum(a * z for z, a in sums if a > 0.0)
        if self.defuzzifier(output).kind.endswith("_sum"):
            return numerator if any(a > 0.0 for _, a in sums) else None
        match s.total:
            case "activations":
                total = sum(a for _, a in sums)
            case "strengths":
                total = sum(self.strength(r) for r, _ in self.concluding(output))
            case "all_rules":
                weights = [self.number(r.weight) if s.weight == "after" else 1.0 for r in self.system.rules]
                total = sum(self.activation(r) * w for r, w in enumerate(weights))
        return numerator / total if total > 0.0 else None

    def location(self, output, term, acts):
        """Where a consequent is: the middle of its core, its function's value, or what Tsukamoto's methods find."""
        own, (low, high) = self.defuzzifier(output), self.range(output)
        membership = term if not isinstance(term, str) else output.term(term).membership
        if own.kind.startswith("inverse"):
            return min(max(self.membership(membership, output.name, acts), low), high)
        if membership.kind == "function":
            return self.consequent(output, membership.arguments[0])
        p = [self.number(a) for a in membership.arguments]
        if membership.kind == "linear":
            return sum(f * x for f, x in zip(p, [*self.point.values(), 1.0], strict=True))
        if own.kind.startswith("tsukamoto"):
            share = min(1.0, acts / self.number(membership.height))
            return min(max(inverse(membership.kind, p, share), low), high)
        return core_middle(membership.kind, p)

    def consequent(self, output, expression):
        read = {n.name for n in names_in(expression)}
        outputs = {o.name: self.value(o.name) for o in self.system.outputs if o.name in read - {output.name}}
        values = self.point | outputs
        if any(math.isnan(x) for name, x in values.items() if name in read):
            return math.nan
        return evaluate(expression, self.system.values | values)

    def aggregated(self, output, parts, x):
        """The degree of the aggregated set at a location."""
        usual = output.implication or self.system.method.implication
        implied = []
        for r, k, term, acts in parts:
            mu, weight = self.membership(output.term(term).membership, output.name, x), 1.0
            if self.semantics.consequent_hedges in ("set", "undone"):
                mu = self.hedged(self.system.rules[r].consequents[k].hedges, mu)
            if self.semantics.weight == "after":  # the weight scales the implied set
                weight = self.number(self.system.rules[r].weight)
            own = self.blocks[r].implication if isinstance(self.blocks[r], RuleBlock) else None
            implied.append(weight * norm(FLOAT, own or usual, acts / weight, mu, self.semantics.equal))
        return self.joined(output, implied)

    def rational(self, output, parts):
        """Return the exact centroid of sets with straight sides, in rational arithmetic until it is rounded."""
        own, (low, high), method = self.defuzzifier(output), self.range(output), self.system.method
        terms = []
        for r, k, term, acts in parts:
            m = output.term(term).membership
            terms.append((corners(m.kind, [self.number(a) for a in m.arguments]), acts))
            if terms[-1][0] is None or self.system.rules[r].consequents[k].hedges or own.kind != "centroid":
                raise NotImplementedError(own)
        found = Straight(terms, method.implication, method.aggregation, low, high).centroid()
        return None if found is None else float(found)
