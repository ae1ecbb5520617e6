"""Rules as FML: conditions joined by one connector, others as terms of an aggregated variable."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final
from xml.sax.saxutils import escape, quoteattr

from fuzzyctl.formats.fml.names import CONJUNCTION_WORDS, DISJUNCTION_WORDS
from fuzzyctl.formats.losses import Loss
from fuzzyctl.model.method import OVER_RULES
from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or, Rule, literals
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Membership, Output

#: Modifiers for hedges, apart from `extremely`, which depends on what is meant by it.
_MODIFIERS: Final = {
    "very": "very",
    "somewhat": "somewhat",
    "slightly": "more_or_less",
    "seldom": "seldom",
    "any": "any",
    "not": "not",
    "plus": "plus",
}


def takes_numbers(membership: Membership) -> bool:
    """Whether a term is a number."""
    return membership.kind in ("singleton", "constant")


class WrittenRules:
    """The rules of a system as FML has them.

    Args:
        system: The system.

    Attributes:
        losses: What of them FML cannot express.
        variable: Name of the variable whose terms are nested conditions.
    """

    def __init__(self, system: FuzzySystem) -> None:
        self._system = system
        self.losses: list[Loss] = []
        taken = {v.name for v in (*system.inputs, *system.outputs)}
        self.variable = "conditions"
        while self.variable in taken:
            self.variable += "_"
        self._defined: dict[str, Antecedent] = {
            f"rule{i}_{k}": _stripped(part)[0]
            for i, r in enumerate(system.rules, 1)
            for k, part in enumerate(_parts(r.antecedent), 1)
            if _is_joined(part)
        }

    def kind(self, output: Output) -> str:
        """Return what sort of rules conclude on an output: `mamdani`, `tsk` or `tsukamoto`."""
        defuzzifier = output.defuzzifier or self._system.method.defuzzifier
        if defuzzifier.kind == "tsukamoto":
            return "tsukamoto"
        return "tsk" if defuzzifier.kind in OVER_RULES else "mamdani"

    def groups(self) -> Iterator[tuple[tuple[str, str], list[tuple[int, Rule]]]]:
        """Yield the rules of each rule base: of one sort, and of one activation method."""
        found: dict[tuple[str, str], list[tuple[int, Rule]]] = {}
        for index, rule in enumerate(self._system.rules, 1):
            parts: dict[tuple[str, str], list[object]] = {}
            for c in rule.consequents:
                output = self._system.output(c.output)
                kind = self.kind(output)
                implication = output.implication or self._system.method.implication
                parts.setdefault((kind, implication if kind == "mamdani" else "min"), []).append(c)
            for key, consequents in parts.items():
                part = rule.model_copy(update={"consequents": tuple(consequents)})
                found.setdefault(key, []).append((index, part))
        yield from found.items()

    def unnamed(self, output: str) -> dict[str, Membership]:
        """Return names for the consequents of an output that have none."""
        taken = {t.name for t in self._system.output(output).terms}
        found: dict[str, Membership] = {}
        for rule in self._system.rules:
            for c in rule.consequents:
                if c.output == output and isinstance(c.term, Membership) and c.term not in found.values():
                    number = len(found) + 1
                    while f"c{number}" in taken:
                        number += 1
                    taken.add(f"c{number}")
                    found[f"c{number}"] = c.term
        return found

    def name_of(self, output: str, membership: Membership) -> str:
        """Return the name of a consequent that has none."""
        return next(n for n, m in self.unnamed(output).items() if m == membership)

    def reads(self, output: str) -> bool:
        """Whether rules read an output."""
        return any(i.variable == output for r in self._system.rules for i in literals(r.antecedent))

    def condition(self, index: int, rule: Rule) -> tuple[str, list[str]]:
        """Return the connector of a rule and its clauses; what is joined in itself is a term of its own."""
        clauses = []
        for k, part in enumerate(_parts(rule.antecedent), 1):
            if _is_joined(part):
                modifier = "not" if _stripped(part)[1] else ""
                clauses.append(self._clause(self.variable, f"rule{index}_{k}", modifier))
            else:
                clauses.append(self._literal(part))
        return ("or" if isinstance(rule.antecedent, Or) else "and"), clauses

    def negates_inside(self) -> bool:
        """Whether several conditions are negated at once where FML has no modifier."""
        return any(_negates_joined(d) for d in self._defined.values())

    def definitions(self) -> Iterator[str]:
        """Yield the variable whose terms are nested conditions, where there are such."""
        if not self._defined:
            return
        yield f'<aggregatedFuzzyVariable name={quoteattr(self.variable)} type="input">'
        for name, antecedent in self._defined.items():
            yield f'  <aggregatedFuzzyTerm name="{name}">'
            yield from (f"    {line}" for line in self._tree(antecedent))
            yield "  </aggregatedFuzzyTerm>"
        yield "</aggregatedFuzzyVariable>"

    def _tree(self, antecedent: Antecedent) -> Iterator[str]:
        """Yield a condition as a tree of pairs, since the schema joins two at a time."""
        if _is_joined(antecedent):
            antecedent, _ = _stripped(antecedent)  # a negation is told as a loss
        if not isinstance(antecedent, And | Or):
            yield self._literal(antecedent)
            return
        tag = "and" if isinstance(antecedent, And) else "or"
        method = self._system.method
        words, norm = (
            (CONJUNCTION_WORDS, method.conjunction) if tag == "and" else (DISJUNCTION_WORDS, method.disjunction)
        )
        word = next((w for w, meaning in words.items() if meaning == norm), next(iter(words)))
        attribute = "t-norm" if tag == "and" else "t-conorm"
        *before, last = antecedent.operands
        yield f'<{tag} {attribute}="{word}">'
        first = before[0] if len(before) == 1 else antecedent.model_copy(update={"operands": tuple(before)})
        for part in (first, last):
            yield from (f"  {line}" for line in self._tree(part))
        yield f"</{tag}>"

    def _literal(self, antecedent: Antecedent) -> str:
        hedges: tuple[str, ...] = ()
        while isinstance(antecedent, Not):
            hedges = ("not",) if not hedges else ()
            antecedent = antecedent.operand
        assert isinstance(antecedent, Is)
        hedges = (*hedges, *antecedent.hedges)
        while hedges[:2] == ("not", "not"):
            hedges = hedges[2:]
        return self.clause(antecedent.variable, antecedent.term, hedges, "clause")

    def clause(self, variable: str, term: str, hedges: tuple[str, ...], tag: str) -> str:
        """Return a clause; FML has one modifier for it."""
        if len(hedges) > 1:
            # A condition that is negated says the opposite of one that is not: of all hedges this one is kept.
            kept = hedges[:1] if hedges[0] == "not" else ()
            why = "FML has one modifier; only 'not' is kept" if kept else "FML has one modifier; they are left out"
            self.losses.append(Loss("rules", f"hedges '{' '.join(hedges)}'", why))
            hedges = kept
        modifier = self._modifier(hedges[0]) if hedges else ""
        return self._clause(variable, term, modifier, tag)

    def _clause(self, variable: str, term: str, modifier: str, tag: str = "clause") -> str:
        said = f' modifier="{modifier}"' if modifier else ""
        named = f"<variable>{escape(variable)}</variable><term>{escape(term)}</term>"
        return f"<{tag}{said}>{named}</{tag}>"

    def _modifier(self, hedge: str) -> str:
        if hedge == "extremely":
            return "extremely" if self._system.method.semantics.extremely == "cube" else "intensify"
        own = next((h for h in self._system.hedges if h.name == hedge), None)
        if hedge not in _MODIFIERS or (own is not None and not _is_plus(own)):
            self.losses.append(Loss("rules", f"hedge '{hedge}'", "FML has no such modifier; it is left out"))
            return ""
        return _MODIFIERS[hedge]


def _is_plus(hedge: object) -> bool:
    from fuzzyctl.formats.fml.reader import PLUS

    return hedge == PLUS


def _parts(antecedent: Antecedent) -> tuple[Antecedent, ...]:
    """Return what the connector of a rule joins."""
    return antecedent.operands if isinstance(antecedent, And | Or) else (antecedent,)


def _is_joined(antecedent: Antecedent) -> bool:
    return isinstance(_stripped(antecedent)[0], And | Or)


def _stripped(antecedent: Antecedent) -> tuple[Antecedent, bool]:
    """Return a condition without the negations before it, and whether they negate it."""
    negated = False
    while isinstance(antecedent, Not):
        antecedent, negated = antecedent.operand, not negated
    return antecedent, negated


def _negates_joined(antecedent: Antecedent) -> bool:
    """Whether several conditions are negated at once somewhere below."""
    match antecedent:
        case And(operands=operands) | Or(operands=operands):
            return any((_is_joined(o) and _stripped(o)[1]) or _negates_joined(_stripped(o)[0]) for o in operands)
    return False
