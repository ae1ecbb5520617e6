"""Rules that can never act and terms that are never used.

Each report is proved; a rule or term without a report may still be without effect for another reason.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from math import prod
from typing import Any, Final

from fuzzyctl.analysis.degrees import Truths, activation_in, cells, degree_in, degrees_read
from fuzzyctl.analysis.work import Work, units_of
from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Number, number_text
from fuzzyctl.formats.fz import antecedent_text
from fuzzyctl.kernels.interval.scalar import Interval, hull
from fuzzyctl.kernels.plan.build import DegreePlan, Plan, degree_name
from fuzzyctl.model.method import Semantics
from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or, Rule, literals
from fuzzyctl.model.system import FuzzySystem

#: Most cells looked at for one rule that names an input twice.
MOST_CELLS: Final = 2000
#: Most units of work for a degree: of one with many corners only the formulas on the way to its piece are evaluated.
_MOST_ENCLOSED: Final = 200
#: Units of work for a degree looked for, a degree in a cell, and two rules that are compared.
_SCANNED, _CELL, _PAIR = 0.1, 10, 2
#: Most rules of one consequent that are compared with each other.
MOST_COMPARED: Final = 300

#: A term of a variable, by their names.
Named = tuple[str, str]


def diagnostics(system: FuzzySystem, flat: Plan, work: Work) -> list[Diagnostic]:
    """Report rules that never act and terms of inputs whose degree is 0 in the whole range, each cause once."""
    semantics = system.method.semantics
    if semantics.least is None or semantics.chained != "value":
        return []  # there a rule may act that does not fire, or fire though its terms lie apart
    idle = _Idle(system, flat, work)
    results = [_dead_term(system, idle, term) for term in idle.zero]
    for position, rule in enumerate(system.rules):
        named = {(i.variable, i.term) for i in literals(rule.antecedent)}
        if position in idle.dead and not named & idle.zero.keys():
            results.append(_dead_rule(idle, rule, idle.dead[position]))
        elif position in idle.covered:
            results.append(_covered_rule(rule, idle.covered[position]))
    return results


class _Idle:
    """Rules, terms and inputs without effect.

    Attributes:
        zero: Terms of inputs that no value in the range belongs to, with the range.
        dead: Positions of rules that never fire, each with the reason.
        covered: Positions of rules that another one always outdoes, each with that rule.
        dead_with: Positions of rules of `dead` that name a term.
        lost: Terms that only rules of `dead` name, besides those of `zero`.
    """

    def __init__(self, system: FuzzySystem, flat: Plan, work: Work) -> None:
        self.system, self.flat, self.work = system, flat, work
        self.degrees = [_reach(flat, d, work) for d in flat.degrees]
        self.zero = dict(self._zero_terms())
        self.dead = dict(self._dead_rules())
        self.covered = dict(self._covered_rules())
        alive = {t for r, rule in enumerate(system.rules) if r not in self.dead for t in _terms_of(rule)}
        self.dead_with: dict[Named, list[int]] = {}
        for r in self.dead:
            for term in _terms_of(system.rules[r]):
                self.dead_with.setdefault(term, []).append(r)
        self.lost = self.dead_with.keys() - alive - self.zero.keys()

    def _zero_terms(self) -> Iterator[tuple[Named, Interval]]:
        for degree, reach in zip(self.flat.degrees, self.degrees, strict=True):
            if degree.variable < len(self.flat.inputs) and reach[1] <= 0.0:
                variable = self.flat.inputs[degree.variable]
                yield (variable.name, degree.term), (variable.lower, variable.upper)

    def _dead_rules(self) -> Iterator[tuple[int, str]]:
        flat = self.flat
        truths = Truths(flat, {degree_name(i): reach for i, reach in enumerate(self.degrees)})
        fired = [truths.strength(strength) for strength in flat.strengths]
        reach = [activation_in(flat, rule, fired[rule.strength]) for rule in flat.rules]
        for r, rule in enumerate(flat.rules):
            weight = self.system.rules[r].weight
            if rule.weight == 0.0:
                # A weight that params compute may be switched on by them.
                if isinstance(weight, Number):
                    yield r, "its weight is 0"
            elif reach[r][1] <= 0.0:
                yield r, self._reason(r)
            elif self._names_an_input_twice(r) and not self._fires_somewhere(r):
                yield r, "the terms that it names of one input do not overlap"

    def _reason(self, r: int) -> str:
        method = self.flat.activation_of(r)
        if method.kind == "general":
            return "its firing strength is 0 everywhere"
        return f"'activation {method.kind}' always leaves it out: its threshold is {number_text(method.threshold)}"

    def _names_an_input_twice(self, r: int) -> bool:
        counts = Counter(i.variable for i in literals(self.system.rules[r].antecedent))
        return max(counts.values()) > 1

    def _fires_somewhere(self, r: int) -> bool:
        """Return whether a rule may fire in some cell between the corners of its terms."""
        flat = self.flat
        strength = flat.strengths[flat.rules[r].strength]
        if not self.work.takes(_SCANNED * len(flat.degrees)):
            return True
        read = degrees_read(flat, [strength])
        plans = {n: d for i, d in enumerate(flat.degrees) if (n := degree_name(i)) in read}
        variables = sorted({d.variable for d in plans.values()})
        sides = [cells(flat.variable(v), [d.set for d in plans.values() if d.variable == v]) for v in variables]
        count = prod(len(s) for s in sides)
        if count > MOST_CELLS or not self.work.takes(count * (_CELL * len(plans) + units_of(strength))):
            return True
        for box in product(*sides):
            at = dict(zip(variables, box, strict=True))
            degrees = {n: degree_in(d.set, at[d.variable].floats) for n, d in plans.items()}
            fired = Truths(flat, degrees).strength(strength)
            if activation_in(flat, flat.rules[r], fired)[1] > 0.0:
                return True
        return False

    def _covered_rules(self) -> Iterator[tuple[int, Rule]]:
        """Yield rules whose every consequent another one gives at least as much everywhere, where the larger counts."""
        if not self.flat.all_act or self.system.method.semantics != Semantics():
            return
        rivals: dict[tuple[int, int], list[int]] = {}
        for o, output in enumerate(self.flat.outputs):
            if not output.over_rules and output.aggregation == "max":
                for entry in output.implied:
                    rivals.setdefault((o, entry.term), []).append(entry.rule)
        entries = Counter(e.rule for output in self.flat.outputs for e in output.implied)
        outdone: dict[int, list[int]] = {}
        antecedents = {r: _said(self.system.rules[r].antecedent) for rules in rivals.values() for r in rules}
        for rules in rivals.values():
            count = len(rules)
            for r in rules if count <= MOST_COMPARED and self.work.takes(_PAIR * count * count) else ():
                better = next(
                    (s for s in rules if s != r and s not in self.dead and self._outdoes(antecedents, s, r)), None
                )
                if better is not None and r not in self.dead:
                    outdone.setdefault(r, []).append(better)
        for r, better_ones in outdone.items():
            if len(better_ones) == entries[r]:
                yield r, self.system.rules[better_ones[0]]

    def _outdoes(self, antecedents: Mapping[int, _Said], s: int, r: int) -> bool:
        first, second = antecedents[s], antecedents[r]
        one, other = self.system.rule_methods[s], self.system.rule_methods[r]
        if (one.conjunction, one.disjunction) != (other.conjunction, other.disjunction):
            return False
        # Rules with the same antecedent have another message.
        return self.flat.rules[s].weight >= self.flat.rules[r].weight and first != second and _at_most(second, first)


def _reach(flat: Plan, degree: DegreePlan, work: Work) -> Interval:
    """Enclose the degrees that a term has in the range of its variable; all there are where there is no work left."""
    whole, result = (0.0, degree.set.height), None
    units = units_of(degree.set.degree_of_x)
    for cell in cells(flat.variable(degree.variable), [degree.set]):
        if result == whole or not work.takes(min(units, _MOST_ENCLOSED)):
            return whole
        ends = degree_in(degree.set, cell.floats)
        result = ends if result is None else hull([result, ends])
    return result or whole


#: An antecedent as a tuple: its kind, then its operands or words. Tuples of texts are compared a hundred times faster
#: than models are, and every rule of a consequent is compared with all others of it.
_Said = tuple[str, tuple[Any, ...]]


def _said(antecedent: Antecedent) -> _Said:
    match antecedent:
        case Is(variable=variable, term=term, hedges=hedges):
            return "is", (variable, term, hedges)
        case Not(operand=operand):
            return "not", (_said(operand),)
        case And(operands=operands) | Or(operands=operands):
            return type(antecedent).__name__.lower(), tuple(map(_said, operands))
    raise TypeError(type(antecedent).__name__)


def _at_most(a: _Said, b: _Said) -> bool:
    """Return whether the truth of a is at most that of b everywhere, whatever the norms are."""
    if a == b:
        return True
    if b[0] == "or" and (_within(_joined(a, "or"), b[1]) or any(_at_most(a, part) for part in b[1])):
        return True
    return a[0] == "and" and (_within(_joined(b, "and"), a[1]) or any(_at_most(part, b) for part in a[1]))


def _joined(antecedent: _Said, kind: str) -> Sequence[_Said]:
    return antecedent[1] if antecedent[0] == kind else (antecedent,)


def _within(few: Sequence[_Said], many: Sequence[_Said]) -> bool:
    # Of most pairs the first part settles it.
    return len(few) <= len(many) and few[0] in many and not Counter(few) - Counter(many)


def _terms_of(rule: Rule) -> set[Named]:
    read = {(i.variable, i.term) for i in literals(rule.antecedent)}
    return read | {(c.output, c.term) for c in rule.consequents if isinstance(c.term, str)}


def _lost(idle: _Idle, rules: Sequence[Rule]) -> list[str]:
    """Return what else never matters because these rules never act."""
    terms = sorted({t for rule in rules for t in _terms_of(rule)} & idle.lost)
    return [f"so term '{term}' of '{variable}' never matters" for variable, term in terms]


def _dead_term(system: FuzzySystem, idle: _Idle, named: Named) -> Diagnostic:
    name, term = named
    low, high = idle.zero[named]
    variable = system.input(name)
    rules = [system.rules[r] for r in idle.dead_with.get(named, ())]
    message = f"term '{term}' of '{name}' has degree 0 in the whole range [{low:.6g}, {high:.6g}]"
    facts = [f"{counted(len(rules), 'rule')} with it never fire{'s' if len(rules) == 1 else ''}"] if rules else []
    declared = variable.term(term)
    location = declared.span if declared is not None else variable.span
    help_text = "widen the range, or move the term into it"
    return Diagnostic("FZ404", message, location, "warning", (*facts, *_lost(idle, rules)), help_text)


def _dead_rule(idle: _Idle, rule: Rule, reason: str) -> Diagnostic:
    message = f"the rule 'if {antecedent_text(rule.antecedent, top=True)}' never acts"
    return Diagnostic("FZ403", message, rule.span, "warning", (reason, *_lost(idle, [rule])), "remove or fix it")


def _covered_rule(rule: Rule, better: Rule) -> Diagnostic:
    message = f"the rule 'if {antecedent_text(rule.antecedent, top=True)}' changes nothing"
    other = f"'if {antecedent_text(better.antecedent, top=True)}' gives the same consequent at least as much"
    notes = (Note(better.span, other),) if better.span is not None else ()
    facts = () if notes else (other,)
    return Diagnostic("FZ403", message, rule.span, "warning", facts, "remove one of them, or make them differ", notes)
