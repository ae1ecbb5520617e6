"""Antecedents and consequents of a plan's rules."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from functools import reduce
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, UnknownNameError
from fuzzyctl.expr import (
    MAX_DEPTH,
    ZERO,
    Expr,
    Name,
    Number,
    names_in,
    replace_names,
    walk,
)
from fuzzyctl.formulas import (
    HEDGES,
    MEMBERSHIP,
    VARIANTS,
    Norm,
    conjunction,
    disjunction,
    held,
    inverse_hedge,
    one_minus,
)
from fuzzyctl.formulas import hedge as usual_hedge
from fuzzyctl.kernels.plan.plan import ChainPlan, DegreePlan, ImpliedPlan, chain_name, degree_name, step_name
from fuzzyctl.kernels.plan.sets import ITSELF, SetPlan
from fuzzyctl.kernels.plan.traced import constants_of, guarded, is_free, number_of, over_inputs, require_known
from fuzzyctl.kernels.program.builder import DEEPEST, depth
from fuzzyctl.model.block import Hedge
from fuzzyctl.model.rule import And, Antecedent, Consequent, Is, Not, Or, Rule
from fuzzyctl.model.system import FuzzySystem, ordered_lets
from fuzzyctl.model.variable import Membership, Output, Term


def set_of(system: FuzzySystem, membership: Membership) -> SetPlan:
    """Return a membership function with numbers, in the variant that the semantics ask for."""
    height = number_of(system, membership.height)
    variant = f"{membership.kind} {getattr(system.method.semantics, membership.kind, '')}"
    kind = variant if variant in VARIANTS else membership.kind
    return SetPlan(kind, tuple(number_of(system, a) for a in membership.arguments), height)


def own_set(system: FuzzySystem, variable: str, membership: Membership, kind: str) -> SetPlan:
    """Return a set that is an expression over the variable itself and params."""
    numbers = constants_of(system, {variable})
    require_known(membership.arguments[0], {variable}, numbers)
    inside: dict[str, Expr] = {**numbers, variable: Name(ITSELF)}
    expression = guarded(replace_names(membership.arguments[0], inside))
    return SetPlan(kind, (), number_of(system, membership.height), expression)


def term_of_output(system: FuzzySystem, output: str, membership: Membership) -> SetPlan:
    """Return a term of an output with numbers: a set, or a consequent that is a function."""
    if membership.kind == "formula":
        return own_set(system, output, membership, "formula")
    return consequent_of(system, membership)


def consequent_of(system: FuzzySystem, membership: Membership) -> SetPlan:
    """Return a consequent with numbers: a set, or a function of the inputs and of other outputs."""
    match membership.kind:
        case "linear":
            *factors, constant = (number_of(system, a) for a in membership.arguments)
            names = [i.name for i in system.inputs]
            parts = [c * Name(n) for c, n in zip(factors, names, strict=True) if c != 0.0]
            reach = _reach(system, factors, constant)
            return SetPlan("linear", (), expression=_sum([*parts, Number(constant)]), reach=reach)
        case "function":
            return SetPlan(
                "function", (), expression=guarded(over_inputs(system, membership.arguments[0], outputs=True))
            )
    return set_of(system, membership)


def _reach(system: FuzzySystem, factors: Sequence[float], constant: float) -> tuple[float, float] | None:
    """Return the bounds of a linear consequent while the inputs are in their ranges; None if they need not be."""
    if any(map(is_free, (*factors, constant))):
        return None
    low = high = constant
    for factor, variable in zip(factors, system.inputs, strict=True):
        if factor == 0.0:
            continue
        if variable.extrapolate:
            return None
        ends = sorted(factor * number_of(system, end) for end in (variable.lower, variable.upper))
        low, high = low + ends[0], high + ends[1]
    return (low, high) if math.isfinite(high - low) else None


def _sum(parts: list[Expr]) -> Expr:
    return reduce(lambda a, b: a + b, [p for p in parts if p != ZERO] or [ZERO])


class Conclusions:
    """Collect the consequents of the rules in one output."""

    def __init__(self, system: FuzzySystem, output: Output) -> None:
        self.system, self.output = system, output
        self.semantics = system.method.semantics
        self.over_rules = (output.defuzzifier or system.method.defuzzifier).over_rules
        #: That of the first rule; of others whose rule blocks say something else the terms say it.
        implication = output.implication or system.method.implication
        self.implication = implication if self.over_rules else system.implications_of(output)[0]
        self.terms = [term_of_output(system, output.name, term.membership) for term in output.terms]
        self.positions = {term.name: i for i, term in enumerate(output.terms)}
        self.unnamed: dict[SetPlan, int] = {}
        self.implied: list[ImpliedPlan] = []

    def add(self, position: int, rule: Rule, place: int) -> None:
        """Add a consequent of a rule, the one at a place among all of its consequents."""
        consequent = rule.consequents[place]
        factor = number_of(self.system, rule.weight) if self.semantics.weight == "after" else 1.0
        term = self._term(consequent)
        changes: list[Expr] = []
        if not self.over_rules and self.semantics.consequent_hedges in ("set", "undone"):
            changes += self._hedges(consequent)
        implication = self.implication if self.over_rules else self.system.implication_of(position, self.output)
        if factor != 1.0 and not self.over_rules and implication == "min":
            changes.append(factor * Name(ITSELF))
        other = implication if implication != self.implication else None
        if changes or other:
            term = self._own(dataclasses.replace(self.terms[term], changes=tuple(changes), implication=other))
        self.implied.append(ImpliedPlan(position, term, factor, self._change(rule, place)))

    def _term(self, consequent: Consequent) -> int:
        term = consequent.term
        if isinstance(term, Membership):
            return self._own(consequent_of(self.system, term))
        if term not in self.positions:
            raise UnknownNameError("term", term, self.positions)
        return self.positions[term]

    def _own(self, term: SetPlan) -> int:
        """Return the position of a consequent without a name."""
        position = self.unnamed.setdefault(term, len(self.terms))
        if position == len(self.terms):
            self.terms.append(term)
        return position

    def _hedges(self, consequent: Consequent, *, undone: bool = False) -> list[Expr]:
        """Return the functions of hedges, the nearest to the term first, or their inverses."""
        return [hedge_change(self.system, hedge, undone=undone) for hedge in reversed(consequent.hedges)]

    def _change(self, rule: Rule, place: int) -> Expr | None:
        """Return the function of a consequent's hedges, applied to the activation of its rule."""
        how = self.semantics.consequent_hedges
        if how == "set" or (how == "undone" and not self.over_rules):
            return None
        before = rule.consequents[:place] if how == "carried" else ()
        changes = [
            c
            for consequent in (*before, rule.consequents[place])
            for c in self._hedges(consequent, undone=how == "undone")
        ]
        if not changes:
            return None
        return reduce(lambda whole, change: replace_names(change, {ITSELF: whole}), changes)


def hedge_change(system: FuzzySystem, hedge: str, *, undone: bool) -> Expr:
    """Return a hedge, or its inverse, as an expression over `ITSELF`."""
    x, cube = Name(ITSELF), system.method.semantics.extremely == "cube"
    declared = next((h for h in system.hedges if h.name == hedge), None)
    if declared is not None:
        numbers = constants_of(system, {declared.parameter})
        require_known(declared.expression, {declared.parameter}, numbers)
        return held(guarded(replace_names(declared.expression, {**numbers, declared.parameter: x})))
    if hedge not in HEDGES:
        raise UnknownNameError("hedge", hedge, [*HEDGES, *(h.name for h in system.hedges)])
    change = inverse_hedge(hedge, cube=cube) if undone else usual_hedge(hedge, cube=cube)
    assert change is not None, "hedges without an inverse are refused"
    return change(x)


#: Most operands and operators of the own hedges in all rules, each counted once for each operand.
MAX_HEDGED: Final = 100_000


class Antecedents:
    """Collects the distinct degrees and firing strengths of a system.

    Args:
        system: The system.

    Attributes:
        degrees: Each degree that some rule uses, once.
        steps: Names of parts that are mentioned more than once.
        strengths: Position of each firing strength.
        chains: Terms of outputs whose activation so far counts.
    """

    def __init__(self, system: FuzzySystem) -> None:
        self._system = system
        self._variables = (*system.inputs, *system.outputs, *ordered_lets(system))
        self._positions = {v.name: i for i, v in enumerate(self._variables)}
        self._hedges = {h.name: h for h in system.hedges}
        self.degrees: list[DegreePlan] = []
        self._names: dict[tuple[int, str], Name] = {}
        self.steps: dict[Expr, Name] = {}
        self.strengths: dict[Expr, int] = {}
        self.chains: list[ChainPlan] = []
        self._rule = 0
        self._bodies: dict[str, Expr] = {}
        self._applied: dict[tuple[str, Expr], Expr] = {}
        self._hedged_parts = 0
        #: Names by the identity of their objects, with the objects, which must live as long.
        self._named_parts: dict[int, tuple[Expr, Name]] = {}

    def strength(self, antecedent: Antecedent, rule: int) -> int:
        """Return the position of the firing strength of a rule.

        Args:
            antecedent: Of the rule.
            rule: Its position among all rules.

        Raises:
            DiagnosticError: When it is nested too deeply.
            UnknownNameError: For an undeclared name.
        """
        self._rule = rule
        if not isinstance(antecedent, Is) and _nesting(antecedent) > MAX_DEPTH:
            message = f"an antecedent is nested more than {MAX_DEPTH} deep"
            raise DiagnosticError([Diagnostic("FZ106", message, help="join the parts with one 'and' or 'or'")])
        return self.strengths.setdefault(self._truth(antecedent), len(self.strengths))

    def _truth(self, antecedent: Antecedent) -> Expr:
        if type(antecedent) is Is:  # more than half of all parts are
            degree = self._degree(antecedent.variable, antecedent.term)
            return reduce(self._hedged, reversed(antecedent.hedges), degree) if antecedent.hedges else degree
        match antecedent:
            case Not(operand=operand):
                return one_minus(self._shallow(self._truth(operand)))
            case And(operands=operands):
                return self._join(conjunction, self._system.rule_methods[self._rule].conjunction, operands)
            case Or(operands=operands):
                return self._join(disjunction, self._system.rule_methods[self._rule].disjunction, operands)
        raise TypeError(f"{type(antecedent).__name__} is no antecedent")

    def _join(self, norms: Callable[[str, float], Norm], name: str, operands: tuple[Antecedent, ...]) -> Expr:
        norm, truths = norms(name, self._system.method.semantics.equal), [self._truth(operand) for operand in operands]
        if len(list(names_in(norm(Name("a"), Name("b"))))) == 2:  # each operand once, so that nesting stays short
            return self._chain(norm, truths)
        return reduce(lambda a, b: norm(self._named(a), self._named(b)), truths)

    def _chain(self, norm: Norm, truths: list[Expr]) -> Expr:
        """Join truths from left to right, with names for deeply nested ones; depths are not measured anew."""
        added = depth(norm(Name("a"), Name("b")))
        truth_so_far, deep = truths[0], depth(truths[0])
        for truth in truths[1:]:
            height = depth(truth)
            if deep >= DEEPEST:
                truth_so_far, deep = self._named(truth_so_far), 0
            if height >= DEEPEST:
                truth, height = self._named(truth), 0
            truth_so_far, deep = norm(truth_so_far, truth), added + max(deep, height)
        return truth_so_far

    def _hedged(self, truth: Expr, hedge: str) -> Expr:
        if hedge in self._hedges:
            return self._own_hedge(self._hedges[hedge], self._named(truth))
        if hedge not in HEDGES:
            raise UnknownNameError("hedge", hedge, [*HEDGES, *self._hedges])
        return usual_hedge(hedge, cube=self._system.method.semantics.extremely == "cube")(self._named(truth))

    def _own_hedge(self, hedge: Hedge, truth: Expr) -> Expr:
        """Return a hedged truth; computed once for all rules."""
        name = self._applied.get((hedge.name, truth))
        if name is None:
            body = self._bodies.get(hedge.name) or self._bodies.setdefault(hedge.name, self._body(hedge))
            self._hedged_parts += sum(1 for _ in walk(body))
            if self._hedged_parts > MAX_HEDGED:
                message = f"the own hedges of all rules together have more than {MAX_HEDGED:,} operands and operators"
                raise DiagnosticError([Diagnostic("FZ112", message, hedge.span, help="use fewer hedges in a row")])
            name = held(replace_names(body, {hedge.parameter: truth}))
            self._applied[hedge.name, truth] = name
        return name

    def _body(self, hedge: Hedge) -> Expr:
        """Return the expression of an own hedge with the numbers that its params have."""
        numbers = constants_of(self._system, {hedge.parameter})
        require_known(hedge.expression, {hedge.parameter}, numbers)
        return guarded(replace_names(hedge.expression, numbers))

    def _shallow(self, truth: Expr) -> Expr:
        """Return a truth, or a name for it where it is nested deeply."""
        return self._named(truth) if not isinstance(truth, Name | Number) and depth(truth) >= DEEPEST else truth

    def _named(self, truth: Expr) -> Expr:
        """Return a name for a part that a formula mentions several times."""
        if isinstance(truth, Name | Number):
            return truth
        # Of a long formula the hash takes long, and with hedges in a row each rule asks for the same ones.
        step = self._named_parts.get(id(truth))
        if step is None:
            name = self.steps.setdefault(truth, Name(step_name(len(self.steps))))
            step = self._named_parts[id(truth)] = truth, name
        return step[1]

    def _so_far(self, output: int, term: str) -> Expr:
        """Return how far the rules before have activated a term of an output."""
        name = self._system.outputs[output].name
        terms = [t.name for t in self._system.outputs[output].terms]
        if term not in terms:
            raise UnknownNameError("term", term, terms)
        concluded = [
            (r, c.term) for r, rule in enumerate(self._system.rules) for c in rule.consequents if c.output == name
        ]
        entries = tuple(k for k, (r, other) in enumerate(concluded) if r < self._rule and other == term)
        if not entries:
            return ZERO
        chain = ChainPlan(output, entries)
        if chain not in self.chains:
            self.chains.append(chain)
        return Name(chain_name(self.chains.index(chain)))

    def _degree(self, variable: str, term: str) -> Expr:
        if variable not in self._positions:
            raise UnknownNameError("input", variable, self._positions)
        position = self._positions[variable]
        atom = self._names.get((position, term))
        if atom is not None:
            return atom
        declared = self._variables[position]
        if self._system.method.semantics.chained == "degree" and isinstance(declared, Output):
            return self._so_far(position - len(self._system.inputs), term)
        membership = declared.term(term)
        if membership is None:
            raise UnknownNameError("term", term, [t.name for t in declared.terms])
        degrees = _term_of_output if isinstance(declared, Output) else term_of_input
        name = self._names[position, term] = Name(degree_name(len(self.degrees)))
        self.degrees.append(DegreePlan(position, term, degrees(self._system, declared.name, membership)))
        return name


def _nesting(antecedent: Antecedent) -> int:
    level: list[Antecedent] = [antecedent]
    deepest = -1
    while level:
        deepest += 1
        inner: list[Antecedent] = []
        for part in level:
            match part:
                case Not(operand=operand):
                    inner.append(operand)
                case And(operands=operands) | Or(operands=operands):
                    inner.extend(operands)
        level = inner
    return deepest


def term_of_input(system: FuzzySystem, variable: str, term: Term) -> SetPlan:
    """Return a term of an input with numbers, a function of the input as an expression over `ITSELF`."""
    membership = term.membership
    if membership.kind != "function":
        return set_of(system, membership)
    return own_set(system, variable, membership, "function")


def _term_of_output(system: FuzzySystem, variable: str, term: Term) -> SetPlan:
    if term.membership.kind not in (*MEMBERSHIP, "formula"):
        message = f"term '{term.name}' of output '{variable}' is a function of the inputs, so nothing can be it"
        raise DiagnosticError([Diagnostic("FZ214", message, term.span, help="give the output fuzzy sets as terms")])
    return term_of_output(system, variable, term.membership)
