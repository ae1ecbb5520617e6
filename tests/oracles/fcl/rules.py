"""Resolution of FCL rules: names are looked up; precedence of AND and OR follows the dialect."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.expr import ONE, Expr
from fuzzyctl.formats.common.infix import InfixParser, Operator
from fuzzyctl.formulas import HEDGES
from fuzzyctl.model.rule import And, Antecedent, Consequent, Is, Not, Or, Rule
from tests.oracles.fcl import syntax as sx
from tests.oracles.fcl.scope import Scope

_AND: Final = "AND"

#: The standard has AND before OR, jFuzzyLogic reads both from left to right.
_AND_FIRST: Final = {_AND: Operator(2, run=True), "OR": Operator(1, run=True)}
_FROM_THE_LEFT: Final = dict.fromkeys((_AND, "OR"), Operator(1, run=True))


@dataclass(frozen=True)
class Vocabulary:
    """The variables and their terms that rules may name.

    Args:
        inputs: Terms of each input.
        outputs: Terms of each output.
    """

    inputs: Mapping[str, tuple[str, ...]]
    outputs: Mapping[str, tuple[str, ...]]

    @property
    def variables(self) -> dict[str, tuple[str, ...]]:
        """Terms of every variable."""
        return {**self.inputs, **self.outputs}


class RuleResolver:
    """Resolves the rules of a function block.

    Args:
        scope: Where mistakes go.
        vocabulary: The names.

    Attributes:
        mixed: The first place where AND and OR stand beside each other without parentheses.
    """

    def __init__(self, scope: Scope, vocabulary: Vocabulary) -> None:
        self._scope, self._vocabulary = scope, vocabulary
        self.mixed: sx.Joined | None = None

    def rule(self, line: sx.RuleLine) -> Rule | None:
        """Return a rule; None, with errors, for one that names what there is not."""
        antecedent = self._antecedent(line.condition)
        consequents = [self._consequent(c) for c in line.conclusions]
        weight: Expr | None = ONE
        if line.weight is not None:
            weight = self._scope.number(line.weight, "the weight")
        if antecedent is None or weight is None or any(c is None for c in consequents):
            return None
        found = tuple(c for c in consequents if c is not None)
        return Rule(antecedent=antecedent, consequents=found, weight=weight, span=line.span)

    def _antecedent(self, condition: sx.Condition) -> Antecedent | None:
        match condition:
            case sx.Clause():
                return self._is(condition)
            case sx.Negated(operand=operand, span=span):
                inner = self._antecedent(operand)
                return None if inner is None else Not(operand=inner, span=span)
            case sx.Joined():
                return self._joined(condition)
        raise TypeError(type(condition).__name__)

    def _joined(self, condition: sx.Joined) -> Antecedent | None:
        resolved = [self._antecedent(o) for o in condition.operands]
        if any(r is None for r in resolved):
            return None
        operands = [r for r in resolved if r is not None]
        operators = [o.upper for o in condition.operators]
        if len(set(operators)) > 1:
            self.mixed = self.mixed or condition
        infix = _FROM_THE_LEFT if self._scope.dialect.name == "jfuzzylogic" else _AND_FIRST
        return _Joining(operands, operators, infix).parse()

    def _is(self, clause: sx.Clause) -> Is | None:
        variables = self._vocabulary.variables
        variable = self._scope.spelt(clause.variable.text, variables, clause.variable.span)
        if variable is None:
            self._unknown_variable(clause, list(variables))
            return None
        hedges, term = self._words(clause, variable, variables[variable])
        return None if term is None else Is(variable=variable, term=term, hedges=hedges, span=clause.span)

    def _consequent(self, clause: sx.Clause) -> Consequent | None:
        outputs = self._vocabulary.outputs
        variable = self._scope.spelt(clause.variable.text, outputs, clause.variable.span)
        if variable is None:
            self._unknown_variable(clause, list(outputs), kind="output")
            return None
        hedges, term = self._words(clause, variable, outputs[variable])
        return None if term is None else Consequent(output=variable, term=term, hedges=hedges, span=clause.span)

    def _unknown_variable(self, clause: sx.Clause, known: list[str], kind: str = "variable") -> None:
        message = f"no {kind} '{clause.variable.text}'"
        facts = (f"{kind}s: {listed(known)}",)
        help_text = did_you_mean(clause.variable.text, known)
        self._scope.error("FZ202", message, clause.variable.span, facts=facts, help=help_text)

    def _words(self, clause: sx.Clause, variable: str, terms: tuple[str, ...]) -> tuple[tuple[str, ...], str | None]:
        """Return hedges and term of a clause; `any` needs no term, since it is 1 for each."""
        words = list(clause.words)
        if words[-1].text.lower() == "any" and words[-1].text not in terms and terms:
            term: str | None = terms[0]
        else:
            term = self._term(words.pop(), variable, terms)
        hedges = [w.text.lower() for w in words]
        for word, hedge in zip(words, hedges, strict=True):
            if hedge not in HEDGES:
                facts = (f"hedges: {listed(HEDGES)}",)
                help_text = did_you_mean(hedge, HEDGES)
                self._scope.error("FZ602", f"no hedge '{word.text}'", word.span, facts=facts, help=help_text)
                term = None
        return tuple(hedges), term

    def _term(self, word: sx.Word, variable: str, terms: tuple[str, ...]) -> str | None:
        term = self._scope.spelt(word.text, terms, word.span)
        if term is None:
            message = f"'{variable}' has no term '{word.text}'"
            facts = (f"terms: {listed(terms)}",)
            self._scope.error("FZ203", message, word.span, facts=facts, help=did_you_mean(word.text, terms))
        return term


class _Joining(InfixParser[Antecedent, None]):
    """Joins resolved conditions by the precedence of a dialect; a run of one operator is one node."""

    def __init__(self, operands: list[Antecedent], operators: list[str], infix: Mapping[str, Operator]) -> None:
        self.infix = infix
        self._operands = iter(operands)
        self._operators = deque(operators)

    def _peek(self) -> str:
        return self._operators[0] if self._operators else ""

    def _take(self) -> None:
        self._operators.popleft()

    def _atom(self) -> Antecedent:
        return next(self._operands)

    def _joined(self, sign: str, operands: Sequence[Antecedent], places: Sequence[None]) -> Antecedent:
        return (And if sign == _AND else Or)(operands=tuple(operands))


def same_either_way(condition: sx.Joined) -> bool:
    """Whether AND and OR mixed give the same from the left and with AND first: all ANDs stand before all ORs."""
    operators = [o.upper for o in condition.operators]
    first_or = operators.index("OR") if "OR" in operators else len(operators)
    return _AND not in operators[first_or:]
