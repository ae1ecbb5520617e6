"""Distinct degrees and firing strengths of a plan, from the antecedents of the rules."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, UnknownNameError
from fuzzyctl.expr import MAX_DEPTH, ZERO, Expr, Name, Number, names_in, replace_names, walk
from fuzzyctl.formulas import HEDGES, MEMBERSHIP, Norm, conjunction, disjunction, held, one_minus
from fuzzyctl.formulas import hedge as usual_hedge
from fuzzyctl.kernels.plan.consequents import own_set, set_of, term_of_output
from fuzzyctl.kernels.plan.expressions import constants_of, guarded, require_known
from fuzzyctl.kernels.plan.plan import ChainPlan, DegreePlan, chain_name, degree_name, step_name
from fuzzyctl.kernels.plan.sets import SetPlan
from fuzzyctl.kernels.program.builder import DEEPEST, depth
from fuzzyctl.model.guarantee import Hedge
from fuzzyctl.model.output_dependencies import ordered_lets
from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Output, Term

#: Most operands and operators of the own hedges in all rules, each counted once for what it is applied to.
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
        #: Names by the identity of what they name, with that, which must live as long.
        self._named_parts: dict[int, tuple[Expr, Name]] = {}

    def strength(self, antecedent: Antecedent, rule: int) -> int:
        """Return the position of the firing strength of a rule.

        Args:
            antecedent: Of the rule.
            rule: Its position among all rules.

        Raises:
            DiagnosticError: When it is nested too deeply.
            UnknownNameError: When it names what is not declared.
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
        """Join truths from left to right, with names for what is nested deeply; depths are not measured anew."""
        added = depth(norm(Name("a"), Name("b")))
        found, deep = truths[0], depth(truths[0])
        for truth in truths[1:]:
            own = depth(truth)
            if deep >= DEEPEST:
                found, deep = self._named(found), 0
            if own >= DEEPEST:
                truth, own = self._named(truth), 0
            found, deep = norm(found, truth), added + max(deep, own)
        return found

    def _hedged(self, truth: Expr, hedge: str) -> Expr:
        if hedge in self._hedges:
            return self._own_hedge(self._hedges[hedge], self._named(truth))
        if hedge not in HEDGES:
            raise UnknownNameError("hedge", hedge, [*HEDGES, *self._hedges])
        return usual_hedge(hedge, cube=self._system.method.semantics.extremely == "cube")(self._named(truth))

    def _own_hedge(self, own: Hedge, truth: Expr) -> Expr:
        """Return a hedged truth; computed once for all rules."""
        known = self._applied.get((own.name, truth))
        if known is None:
            body = self._bodies.get(own.name) or self._bodies.setdefault(own.name, self._body(own))
            self._hedged_parts += sum(1 for _ in walk(body))
            if self._hedged_parts > MAX_HEDGED:
                message = f"the own hedges of all rules together have more than {MAX_HEDGED:,} operands and operators"
                raise DiagnosticError([Diagnostic("FZ112", message, own.span, help="use fewer hedges in a row")])
            known = held(replace_names(body, {own.parameter: truth}))
            self._applied[own.name, truth] = known
        return known

    def _body(self, own: Hedge) -> Expr:
        """Return the expression of an own hedge with the numbers that its params have."""
        numbers = constants_of(self._system, {own.parameter})
        require_known(own.expression, {own.parameter}, numbers)
        return guarded(replace_names(own.expression, numbers))

    def _shallow(self, truth: Expr) -> Expr:
        """Return a truth, or a name for it where it is nested deeply."""
        return self._named(truth) if not isinstance(truth, Name | Number) and depth(truth) >= DEEPEST else truth

    def _named(self, truth: Expr) -> Expr:
        """Return a name for what a formula mentions several times."""
        if isinstance(truth, Name | Number):
            return truth
        # Of a long formula the hash takes long, and with hedges in a row each rule asks for the same ones.
        known = self._named_parts.get(id(truth))
        if known is None:
            name = self.steps.setdefault(truth, Name(step_name(len(self.steps))))
            known = self._named_parts[id(truth)] = truth, name
        return known[1]

    def _so_far(self, output: int, term: str) -> Expr:
        """Return how far the rules before have activated a term of an output."""
        name = self._system.outputs[output].name
        terms = [t.name for t in self._system.outputs[output].terms]
        if term not in terms:
            raise UnknownNameError("term", term, terms)
        concluded = [
            (r, c.term) for r, rule in enumerate(self._system.rules) for c in rule.consequents if c.output == name
        ]
        entries = tuple(k for k, (r, own) in enumerate(concluded) if r < self._rule and own == term)
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
        known = self._names.get((position, term))
        if known is not None:
            return known
        declared = self._variables[position]
        if self._system.method.semantics.chained == "degree" and isinstance(declared, Output):
            return self._so_far(position - len(self._system.inputs), term)
        found = declared.term(term)
        if found is None:
            raise UnknownNameError("term", term, [t.name for t in declared.terms])
        degrees = _term_of_output if isinstance(declared, Output) else term_of_input
        name = self._names[position, term] = Name(degree_name(len(self.degrees)))
        self.degrees.append(DegreePlan(position, term, degrees(self._system, declared.name, found)))
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
