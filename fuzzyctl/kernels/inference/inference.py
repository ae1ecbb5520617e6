"""Inference as a program: degrees, firing strengths, activations, outputs."""

from __future__ import annotations

import math
from functools import reduce

from fuzzyctl.expr import (
    ZERO,
    Binary,
    Call,
    Compare,
    Expr,
    Logic,
    Name,
    Number,
    Where,
    names_in,
    replace_names,
    times,
    walk,
)
from fuzzyctl.formulas import IMPLICATIONS, aggregation
from fuzzyctl.kernels.inference.defuzzify.defuzzify import Activation, acting, defuzzify, merged
from fuzzyctl.kernels.plan.build import (
    ITSELF,
    ImpliedPlan,
    InputPlan,
    LetPlan,
    OutputPlan,
    Plan,
    SetPlan,
    chain_name,
    degree_name,
    step_name,
)
from fuzzyctl.kernels.plan.sets import degree_of
from fuzzyctl.kernels.plan.traced import is_free
from fuzzyctl.kernels.program.builder import Builder, any_nan, clip
from fuzzyctl.kernels.program.program import NAN, STATE, Item, Program, Refuse
from fuzzyctl.kernels.program.traversal import embed


def evaluation(plan: Plan, *, many: bool = False, most_pairs: int | None = None) -> Program:
    """Write the program that computes all outputs.

    Args:
        plan: What to compute.
        many: Whether it is for loops over points, which are to have no choices.
        most_pairs: See `Builder`: how large exact centroids may be, in a program that may have tables and integrals.

    Its results are NaN where an input is NaN, and where an output is NaN that they depend on.
    """
    front = _Front(plan, many=many, most_pairs=most_pairs)
    results = _results(front)
    return _program(plan, front.builder, results)


def _results(front: _Front) -> list[Expr]:
    """Write all outputs and return their values."""
    for position in front.plan.order:
        front.write_output(position)
    values = [front.builder.let(front.outputs[position]) for position in range(len(front.plan.outputs))]
    return [Where(front.nan(position), NAN, value) for position, value in enumerate(values)]


def strengths(plan: Plan) -> Program:
    """Write the program that computes the normalised activation ξ_k of each entry of the adaptive state."""
    front = _adaptive_front(plan)
    normalised = _normalised(plan, front)
    results: list[Expr] = [Where(front.nan(o), NAN, xi) for (o, _), xi in zip(plan.states, normalised, strict=True)]
    return _program(plan, front.builder, results, with_state=bool(plan.held))


def rates(plan: Plan) -> Program:
    """Write the program that computes dC_k/dt = rate · ξ_k, zero where C_k would leave the range of its output.

    The rate takes the raw inputs, ξ the clamped ones.
    """
    front = _adaptive_front(plan)
    results: list[Expr] = []
    for s, ((o, _), change) in enumerate(zip(plan.states, _rates(plan, front), strict=True)):
        rate = Where(_leaves(plan.outputs[o], Item(STATE, s), change), ZERO, change)
        results.append(Where(front.nan(o), NAN, rate))
    return _program(plan, front.builder, results)


def evaluation_with_rates(plan: Plan, *, most_pairs: int | None = None) -> Program:
    """Write the program that computes all outputs, then rate · ξ_k, which steps hold within the range."""
    front = _Front(plan, most_pairs=most_pairs)
    results = _results(front)
    rates = [Where(front.nan(o), NAN, change) for (o, _), change in zip(plan.states, _rates(plan, front), strict=True)]
    return _program(plan, front.builder, [*results, *rates])


def _rates(plan: Plan, front: _Front) -> list[Expr]:
    """Write rate · ξ_k of each adaptive consequent."""
    builder = front.builder
    raw = front.with_lets({i.name: x for i, x in zip(plan.inputs, front.raw, strict=True)})
    results: list[Expr] = []
    for (o, _), xi in zip(plan.states, _normalised(plan, front), strict=True):
        output = plan.outputs[o]
        assert output.rate is not None
        rate = builder.let(replace_names(output.rate, dict(raw)))
        # An infinite input times a rule that does not fire would be NaN.
        results.append(builder.let(Where(Compare(">", xi, ZERO), times(rate, xi), ZERO)))
    return results


def trace(plan: Plan) -> Program:
    """Write the program that traces an evaluation.

    Its results are, in this order: all degrees, the activation of each rule, the activation applied to each consequent
    (after hedges and weight) output by output, and all outputs.
    """
    front = _Front(plan)
    for position in plan.order:
        front.write_output(position)
    acts = _activity(front)
    outputs = [front.builder.let(Where(front.nan(o), NAN, front.outputs[o])) for o in range(len(plan.outputs))]
    return _program(plan, front.builder, [*acts, *outputs])


def activity(plan: Plan) -> Program:
    """Write the program that traces the rules alone: the results of `trace` but the outputs.

    Until the rules are written, its statements are those of `evaluation`, under the same names.
    """
    front = _Front(plan)
    read = {k for output in plan.outputs for k in output.reads}
    last = max((n for n, position in enumerate(plan.order) if position in read), default=-1)
    for position in plan.order[: last + 1]:
        front.write_output(position)
    front.builder.statements = [s for s in front.builder.statements if not isinstance(s, Refuse)]
    return _program(plan, front.builder, _activity(front))


def _activity(front: _Front) -> list[Expr]:
    """Return all degrees, the activation of each rule, and the activation applied to each consequent."""
    plan = front.plan
    degrees = [front.degree(i) for i in range(len(plan.degrees))]
    activations = [front.builder.let(front.activations[r]) for r in range(len(plan.rules))]
    effects = [front.effect(entry) for output in plan.outputs for entry in output.implied]
    return [*degrees, *activations, *effects]


def largest_activations(plan: Plan) -> Program:
    """Write the program that computes for each output the largest activation among its rules."""
    front = _read_front(plan)
    builder = front.builder
    results: list[Expr] = []
    for position, output in enumerate(plan.outputs):
        activation: Expr = ZERO
        for entry in output.implied:
            activation = builder.let(Call("max", (activation, front.activations[entry.rule])))
        results.append(Where(front.nan(position), NAN, activation))
    return _program(plan, builder, results)


def degrees(plan: Plan) -> Program:
    """Write the program that computes all degrees of the plan; NaN where the variable is."""
    front = _read_front(plan)
    outputs = [front.outputs.get(k, ZERO) for k in range(len(plan.outputs))]
    variables = [*front.raw, *outputs, *front.lets]
    results: list[Expr] = [
        Where(any_nan([variables[d.variable]]), NAN, front.degree(i)) for i, d in enumerate(plan.degrees)
    ]
    return _program(plan, front.builder, results, with_state=_reads_outputs(plan))


def activations(plan: Plan) -> Program:
    """Write the program that computes the activation of each rule, its weight and activation method included."""
    front = _read_front(plan)
    lacks = any_nan(front.raw)
    results: list[Expr] = [Where(lacks, NAN, front.activations[r]) for r in range(len(plan.rules))]
    return _program(plan, front.builder, results, with_state=_reads_outputs(plan))


def _reads_outputs(plan: Plan) -> bool:
    return any(output.reads for output in plan.outputs)


def _read_front(plan: Plan) -> _Front:
    """Write the rules, and the outputs that some rule or output reads."""
    front = _Front(plan)
    read = {k for output in plan.outputs for k in output.reads}
    for position in plan.order:
        if position in read:
            front.write_output(position)
    # Where an output has no value, others may still have one.
    front.builder.statements = [s for s in front.builder.statements if not isinstance(s, Refuse)]
    return front


def term_degree(term: SetPlan) -> Program:
    """Write the program that computes the degree of one term."""
    builder = Builder()
    x = Name(_raw_name(0))
    value = builder.let(term.degree(x))
    return builder.program([x], [Where(any_nan([x]), NAN, value)])


def _leaves(output: OutputPlan, state: Expr, change: Expr) -> Expr:
    up = Logic("and", (Compare(">=", state, Number(output.upper)), Compare(">", change, ZERO)))
    down = Logic("and", (Compare("<=", state, Number(output.lower)), Compare("<", change, ZERO)))
    return Logic("or", (up, down))


def _program(plan: Plan, builder: Builder, results: list[Expr], *, with_state: bool = True) -> Program:
    state = len(plan.initial_state) if with_state else 0
    return builder.program(raw_names(plan), results, state=state)


def raw_names(plan: Plan) -> tuple[Name, ...]:
    """Return the names of the raw inputs, the arguments of every program."""
    return tuple(Name(_raw_name(i)) for i in range(len(plan.inputs)))


def _raw_name(position: int) -> str:
    return f"x{position}"


def _clamped(builder: Builder, variable: InputPlan, x: Expr) -> Expr:
    return x if variable.extrapolate else builder.let(clip(x, variable.lower, variable.upper))


def _within(builder: Builder, let: LetPlan, x: Expr) -> Expr:
    return x if math.isinf(let.lower) else builder.let(clip(x, let.lower, let.upper))


def _jumps(plan: Plan) -> bool:
    """Return whether a rounding error may decide if a rule acts, as with complements, thresholds and drastic norms."""
    return (
        not plan.all_act
        or plan.least != 0.0
        or bool(plan.chains)
        or any(e.change is not None for o in plan.outputs for e in o.implied)
        or any(not IMPLICATIONS[o.implication].straight or o.mixes_implications for o in plan.outputs)
        or any(not _only_joins(e) for e in (*plan.steps, *plan.strengths))
    )


def _only_joins(strength: Expr) -> bool:
    """Return whether a firing strength is made of minima, maxima and products only."""
    return all(
        isinstance(e, Name | Number)
        or (isinstance(e, Binary) and e.op == "*")
        or (isinstance(e, Call) and e.function in ("min", "max"))
        for e in walk(strength)
    )


class _Front:
    """What all programs of a plan begin with: raw inputs and the activation of each rule.

    Rules that read an output are written once that output is.
    """

    def __init__(self, plan: Plan, *, many: bool = False, most_pairs: int | None = None) -> None:
        self.plan, self.builder, self.many = plan, Builder(most_pairs=most_pairs), many
        self._exact = _jumps(plan)
        self.raw = raw_names(plan)
        self.clamped = [_clamped(self.builder, i, x) for i, x in zip(plan.inputs, self.raw, strict=True)]
        self.outputs: dict[int, Expr] = {}
        self.activations: dict[int, Expr] = {}
        self._own: dict[int, Expr] = {}
        self._known: dict[str, Expr] = {}
        self._fired: dict[int, Expr] = {}
        for i, x in enumerate(self.clamped):
            self._write_degrees(i, x)
        self._values = self.with_lets(dict(zip((i.name for i in plan.inputs), self.clamped, strict=True)))
        self.lets = [self._values[v.name] for v in plan.lets]
        for k, (let, x) in enumerate(zip(plan.lets, self.lets, strict=True)):
            self._write_degrees(len(plan.inputs) + len(plan.outputs) + k, _within(self.builder, let, x))
        self._write_rules()

    def with_lets(self, inputs: dict[str, Expr]) -> dict[str, Expr]:
        """Return values of the inputs by name, and those of the lets for them."""
        values = dict(inputs)
        for let in self.plan.lets:
            for call in let.calls:
                arguments = [self.builder.let(replace_names(a, values)) for a in call.arguments]
                program = evaluation(call.system, most_pairs=self.builder.most_pairs)
                values[call.name] = embed(self.builder, program, arguments)[call.output]
            values[let.name] = self.builder.let(replace_names(let.value, values))
        return values

    def nan(self, position: int) -> Expr:
        """Return whether an output lacks a value because one of its inputs lacks one."""
        return any_nan([*self.raw, *self.lets, *(self.outputs[k] for k in self.plan.outputs[position].reads)])

    def degree(self, position: int) -> Expr:
        """Return a degree of the plan as an atom."""
        return self._known[degree_name(position)]

    def write_output(self, position: int) -> None:
        """Write an output, and the rules that read it."""
        output = self.plan.outputs[position]
        value = self._output(position)
        self.outputs[position] = value
        variable = len(self.plan.inputs) + position
        if any(d.variable == variable for d in self.plan.degrees):
            self._write_degrees(variable, self.builder.let(clip(value, output.lower, output.upper)))
            self._write_rules()

    def _write_degrees(self, variable: int, x: Expr) -> None:
        for i, d in enumerate(self.plan.degrees):
            if d.variable == variable:
                sides = self.many and d.set.has_sides
                degree = d.set.degree_for_many(x, exact=self._exact) if sides else degree_of(self.builder, d.set, x)
                self._known[degree_name(i)] = self.builder.let(degree)

    def _write_rules(self) -> None:
        """Write the steps, strengths and activations that can be computed by now."""
        for i, step in enumerate(self.plan.steps):
            if step_name(i) not in self._known and self._computable(step):
                self._known[step_name(i)] = self.builder.let(replace_names(step, self._known))
        for i, strength in enumerate(self.plan.strengths):
            if i not in self._fired and self._computable(strength):
                self._fired[i] = self.builder.let(replace_names(strength, self._known))
        for group in range(len(self.plan.activations)):
            self._write_group(group)
        if self._write_chains():
            self._write_rules()

    def _write_group(self, group: int) -> None:
        """Write the activations of one group of rules; a method that compares them waits for all of them."""
        method = self.plan.activations[group]
        waiting = [r for r, rule in enumerate(self.plan.rules) if rule.group == group and r not in self.activations]
        rules = [r for r in waiting if self.plan.rules[r].strength in self._fired]
        if method.compares and len(rules) < len(waiting):
            return
        written = [self._activation(r) for r in rules]
        self._own |= dict(zip(rules, written, strict=True))
        # A rule below the threshold does not count among the first, last, highest or lowest ones either.
        counted = method.kind in ("first", "last", "highest", "lowest")
        ready = [self._gated(a) for a in written] if counted else written
        chosen = [self._gated(a) for a in acting(self.builder, method, ready)]
        self.activations |= dict(zip(rules, chosen, strict=True))

    def _gated(self, activation: Expr) -> Expr:
        """Return an activation, or 0 if it does not exceed the threshold of a rule.

        How far rules before have activated a term may add up to more than 1, and what is `not` that is below 0.
        """
        least = self.plan.least or 0.0
        if activation == ZERO or (least == 0.0 and not self.plan.chains):
            return activation
        return self.builder.let(Where(Compare(">", activation, Number(least)), activation, ZERO))

    def _write_chains(self) -> bool:
        """Write how far terms of outputs have been activated by the rules before; return whether there is news."""
        news = False
        for i, chain in enumerate(self.plan.chains):
            output = self.plan.outputs[chain.output]
            entries = [output.implied[k] for k in chain.entries]
            if chain_name(i) in self._known or any(e.rule not in self.activations for e in entries):
                continue
            join = aggregation(output.aggregation, output.equal)
            parts = [self.effect(e) for e in entries]
            self._known[chain_name(i)] = reduce(lambda a, b: self.builder.let(join(a, b)), parts)
            news = True
        return news

    def effect(self, entry: ImpliedPlan) -> Expr:
        """Return the activation applied to a consequent of a rule, after hedges and weight, as an atom."""
        activation = self.activations[entry.rule]
        if entry.change is not None:
            changed = self.builder.let(replace_names(entry.change, {ITSELF: activation}))
            acts = self._acts(entry.rule)
            activation = changed if acts is None else self.builder.let(Where(acts, changed, ZERO))
        return ZERO if activation == ZERO else self.builder.let(times(activation, Number(entry.factor)))

    def _acts(self, rule: int) -> Expr | None:
        """Return whether a rule acts, so that hedges in its consequents count; None for one that always does."""
        method = self.plan.activation_of(rule)
        if self.plan.least is None and method.kind == "general":
            return None
        if self.plan.least is None and method.kind == "threshold":
            return Compare(method.comparison, self._own[rule], Number(method.threshold))
        return Compare(">", self.activations[rule], ZERO)

    def _besides(self, entry: ImpliedPlan) -> tuple[Expr, ...] | None:
        """Return conditions under which a rule acts on a consequent with activation 0; None if it always acts."""
        chosen = self.plan.least is None and not self.plan.activation_of(entry.rule).compares
        if entry.change is None and not chosen:
            return ()
        acts = self._acts(entry.rule)
        return None if acts is None else (acts,)

    def _computable(self, expr: Expr) -> bool:
        return all(n.name in self._known for n in names_in(expr))

    def _activation(self, position: int) -> Expr:
        rule = self.plan.rules[position]
        if rule.weight == 0.0:
            return ZERO
        return self.builder.let(times(self._fired[rule.strength], Number(rule.weight)))

    def _output(self, position: int) -> Expr:
        plan, output = self.plan, self.plan.outputs[position]
        states = {k: s for s, (o, k) in enumerate(plan.states) if o == position}
        active = [
            Activation(self.effect(entry), entry.term, states.get(k), _most(plan, entry), self._besides(entry))
            for k, entry in enumerate(output.implied)
        ]
        inputs = self._values | {plan.outputs[k].name: self.outputs[k] for k in output.reads if k in self.outputs}
        if output.value is not None:
            value = self.builder.let(replace_names(output.value, inputs))
            return self.builder.let(clip(value, output.lower, output.upper)) if output.clamped else value
        firing = [a for a in active if a.strength != ZERO]
        total = self._total(output)
        if output.over_rules:
            firing = merged(self.builder, output, firing, inputs)
        previous = Item(STATE, len(plan.states) + plan.held.index(position)) if position in plan.held else None
        value, fires = defuzzify(self.builder, output, firing, inputs, previous, total)
        if output.clamped:
            value = self.builder.let(clip(value, output.lower, output.upper))
        if output.otherwise == "error":
            quiet = Logic("and", (Logic("not", (fires,)), Logic("not", (self.nan(position),))))
            self.builder.statements.append(Refuse(quiet, output.name))
        return value

    def _total(self, output: OutputPlan) -> Expr | None:
        """Return the divisor of an average, None for the sum of the activations of its rules."""
        match output.total:
            case "strengths":
                rules = [self.plan.rules[e.rule] for e in output.implied]
                return self.builder.total(self._fired[rule.strength] for rule in rules)
            case "all_rules":
                rest = [self._weighted(r) for r in range(len(self.plan.rules))]
                return self.builder.total(rest)
        return None

    def _weighted(self, rule: int) -> Expr:
        """Return the activation of a rule with its weight, wherever that counts."""
        entries = [e for o in self.plan.outputs for e in o.implied if e.rule == rule]
        factor = entries[0].factor if entries else 1.0
        return times(self.activations[rule], Number(factor))


def _most(plan: Plan, entry: ImpliedPlan) -> float:
    """Return the largest activation that a rule can have in one of its consequents."""
    shared = plan.activation_of(entry.rule).kind == "proportional"
    most = 1.0 if shared or entry.change else plan.rules[entry.rule].weight
    # A free weight is at most 1.
    return (1.0 if is_free(most) else most) * (1.0 if is_free(entry.factor) else entry.factor)


def _adaptive_front(plan: Plan) -> _Front:
    """Write what adaptive outputs need: the outputs that they read."""
    front = _Front(plan)
    needed = {r for o, _ in plan.states for r in plan.outputs[o].reads}
    for position in plan.order:
        if position in needed:
            front.write_output(position)
    return front


def _normalised(plan: Plan, front: _Front) -> list[Expr]:
    """Return ξ of each state entry: activation over the sum of the activations of its output, 0 if no rule fires."""
    builder = front.builder
    normalised: list[Expr] = []
    activations = {o: [front.activations[e.rule] for e in plan.outputs[o].implied] for o, _ in plan.states}
    totals = {o: builder.total(values) for o, values in activations.items()}
    for o, k in plan.states:
        values, total = activations[o], totals[o]
        share = Where(Compare(">", total, ZERO), values[k] / total, ZERO)
        normalised.append(builder.let(share) if values[k] != ZERO else ZERO)
    return normalised
