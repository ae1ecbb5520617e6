"""FML text of rules: conditions with one connector, others as terms of an aggregated variable."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from xml.sax.saxutils import escape, quoteattr

from fuzzyctl.formats.common.report import Names
from fuzzyctl.formats.fml.hedges import own_modifier
from fuzzyctl.formats.fml.vocabulary import MODIFIERS, NORMS, word_for
from fuzzyctl.formats.losses import Loss
from fuzzyctl.model.method import OVER_RULES, RuleMethod
from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Output


@dataclass(frozen=True)
class RuleBase:
    """A rule base as it is written.

    Args:
        name: Its name.
        kind: `mamdani`, `tsk` or `tsukamoto`.
        implication: Its activation method.
        method: How its rules join.
        rules: Its rules with their numbers in the system, each with the consequents that belong here.
    """

    name: str
    kind: str
    implication: str
    method: RuleMethod
    rules: tuple[tuple[int, Rule], ...]


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
        self._defined: dict[str, list[str]] = {}
        self._composed: dict[tuple[str, str, tuple[str, ...]], str] = {}

    def kind(self, output: Output) -> str:
        """Return what sort of rules conclude on an output: `mamdani`, `tsk` or `tsukamoto`."""
        defuzzifier = output.defuzzifier or self._system.method.defuzzifier
        if defuzzifier.kind == "tsukamoto":
            return "tsukamoto"
        return "tsk" if defuzzifier.kind in OVER_RULES else "mamdani"

    def groups(self) -> Iterator[RuleBase]:
        """Yield the rule bases: of the rules of one block, or of none, one sort and one activation method."""
        found: dict[tuple[int, str, str], list[tuple[int, Rule]]] = {}
        for index, (rule, method) in enumerate(zip(self._system.rules, self._system.rule_methods, strict=True)):
            parts: dict[tuple[int, str, str], list[object]] = {}
            for c in rule.consequents:
                output = self._system.output(c.output)
                kind = self.kind(output)
                implication = self._system.implication_of(index, output) if kind == "mamdani" else "min"
                parts.setdefault((method.block, kind, implication), []).append(c)
            for key, consequents in parts.items():
                part = rule.model_copy(update={"consequents": tuple(consequents)})
                found.setdefault(key, []).append((index + 1, part))
        names = Names(b.name for b in self._system.rule_blocks)
        named: set[int] = set()
        for number, ((block, kind, implication), rules) in enumerate(found.items(), 1):
            own = f"rules{number}" if block < 0 else self._system.rule_blocks[block].name
            first = block >= 0 and block not in named
            named.add(block)
            method = self._system.rule_methods[rules[0][0] - 1]
            yield RuleBase(own if first else names.take(own), kind, implication, method, tuple(rules))

    def condition(self, index: int, rule: Rule) -> tuple[str, list[str]]:
        """Return the connector of a rule and its clauses; what is joined in itself is a term of its own."""
        self._method = self._system.rule_methods[index - 1]
        clauses = [self._part(p, f"rule{index}_{k}") for k, p in enumerate(_parts(rule.antecedent), 1)]
        return ("or" if isinstance(rule.antecedent, Or) else "and"), clauses

    def _part(self, antecedent: Antecedent, name: str) -> str:
        """Return a condition as a clause; one of several is a term of that name, negated by a modifier."""
        inner, negated = _stripped(antecedent)
        if not isinstance(inner, And | Or):
            return self._literal(antecedent)
        self._defined[name] = list(self._tree(inner, name))
        return self._clause(self.variable, name, "not" if negated else "")

    def definitions(self) -> Iterator[str]:
        """Yield the variable whose terms are the conditions that rules needed until now, where there are such."""
        if not self._defined:
            return
        yield f'<aggregatedFuzzyVariable name={quoteattr(self.variable)} type="input">'
        for name, lines in self._defined.items():
            yield f'  <aggregatedFuzzyTerm name="{name}">'
            yield from (f"    {line}" for line in lines)
            yield "  </aggregatedFuzzyTerm>"
        yield "</aggregatedFuzzyVariable>"

    def _tree(self, antecedent: And | Or, name: str) -> Iterator[str]:
        """Yield a condition as a tree of pairs, since the schema joins two at a time."""
        tag = "and" if isinstance(antecedent, And) else "or"
        method = self._method
        words, attribute = NORMS[tag]
        norm = method.conjunction if tag == "and" else method.disjunction
        word = word_for(words, norm, next(iter(words)))
        *before, last = antecedent.operands
        yield f'<{tag} {attribute}="{word}">'
        first = before[0] if len(before) == 1 else antecedent.model_copy(update={"operands": tuple(before)})
        for k, part in enumerate((first, last), 1):
            inner, negated = _stripped(part)
            if isinstance(inner, And | Or) and not negated:
                yield from (f"  {line}" for line in self._tree(inner, f"{name}_{k}"))
            else:
                yield f"  {self._part(part, f'{name}_{k}')}"
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
        modifiers = tuple(m for m in map(self._modifier, hedges) if m)
        return self._modified(antecedent.variable, antecedent.term, modifiers)

    def _modified(self, variable: str, term: str, modifiers: tuple[str, ...]) -> str:
        """Return a clause; as it has one modifier, the others are those of a term that it names.

        That term is the condition joined with itself by MIN, since a term is defined by a pair.
        """
        if len(modifiers) > 1:
            key = (variable, term, modifiers[1:])
            if key not in self._composed:
                clause = self._modified(*key)
                self._composed[key] = name = f"modified{len(self._composed) + 1}"
                self._defined[name] = ['<and t-norm="MIN">', f"  {clause}", f"  {clause}", "</and>"]
            variable, term = self.variable, self._composed[key]
        return self._clause(variable, term, modifiers[0] if modifiers else "")

    def conclusion(self, variable: str, term: str, hedges: tuple[str, ...], tag: str) -> str:
        """Return the clause of a conclusion, which has one modifier and cannot name terms that others define."""
        if len(hedges) > 1:
            # A conclusion that is negated says the opposite of one that is not: of all hedges this one is kept.
            kept = hedges[:1] if hedges[0] == "not" else ()
            why = f"FML has one modifier for a conclusion; {'only not is kept' if kept else 'they are left out'}"
            self.losses.append(Loss("rules", f"hedges '{' '.join(hedges)}'", why))
            hedges = kept
        return self._clause(variable, term, self._modifier(hedges[0]) if hedges else "", tag)

    def _clause(self, variable: str, term: str, modifier: str, tag: str = "clause") -> str:
        said = f' modifier="{modifier}"' if modifier else ""
        named = f"<variable>{escape(variable)}</variable><term>{escape(term)}</term>"
        return f"<{tag}{said}>{named}</{tag}>"

    def _modifier(self, hedge: str) -> str:
        if hedge == "extremely":
            return "extremely" if self._system.method.semantics.extremely == "cube" else "intensify"
        own = next((h for h in self._system.hedges if h.name == hedge), None)
        word = own_modifier(own) if own is not None else word_for(MODIFIERS, hedge) or None
        if word is None:
            self.losses.append(Loss("rules", f"hedge '{hedge}'", "FML has no such modifier; it is left out"))
        return word or ""


def _parts(antecedent: Antecedent) -> tuple[Antecedent, ...]:
    """Return what the connector of a rule joins."""
    return antecedent.operands if isinstance(antecedent, And | Or) else (antecedent,)


def _stripped(antecedent: Antecedent) -> tuple[Antecedent, bool]:
    """Return a condition without the negations before it, and whether they negate it."""
    negated = False
    while isinstance(antecedent, Not):
        antecedent, negated = antecedent.operand, not negated
    return antecedent, negated
