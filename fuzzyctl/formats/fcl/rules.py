"""Rules of FCL as nodes: names as they are declared, AND and OR by the precedence of the dialect."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Final

from fuzzyctl.expr import ONE, Expr
from fuzzyctl.formats.common.infix import InfixParser, Operator
from fuzzyctl.formats.fcl import syntax as fcl
from fuzzyctl.formats.fcl.scope import Scope
from fuzzyctl.lang import syntax as sx

#: The standard has AND before OR, jFuzzyLogic reads both from left to right.
_AND_FIRST: Final = {"AND": Operator(2, run=True), "OR": Operator(1, run=True)}
_FROM_THE_LEFT: Final = dict.fromkeys(("AND", "OR"), Operator(1, run=True))


class RuleReader:
    """Makes nodes of rules.

    Args:
        scope: Where mistakes go.
        inputs: Terms of each input.
        outputs: Terms of each output.

    Attributes:
        mixed: The first place where AND and OR stand beside each other without parentheses, and differ by dialect.
    """

    def __init__(self, scope: Scope, inputs: Mapping[str, Sequence[str]], outputs: Mapping[str, Sequence[str]]) -> None:
        self._scope, self._outputs = scope, outputs
        self._variables = {**inputs, **outputs}
        self.mixed: fcl.Joined | None = None

    def rule(self, line: fcl.RuleLine) -> sx.Rule | None:
        """Return a rule; None if its weight is no number, which is reported."""
        weight: Expr | None = ONE
        if line.weight is not None:
            weight = self._scope.constant(line.weight, "the weight")
        antecedent = self._truth(line.condition)
        consequents = []
        for clause in line.conclusions:
            output, hedges, term = self._clause(clause, self._outputs)
            consequents.append(sx.ConsequentText(output, term, hedges))
        return sx.Rule(line.span, antecedent, tuple(consequents), weight) if weight is not None else None

    def _truth(self, condition: fcl.Condition) -> sx.Truth:
        match condition:
            case fcl.Clause(span=span):
                return sx.Literal(span, *self._clause(condition, self._variables))
            case fcl.Negated(operand=operand, span=span):
                return sx.Negation(span, self._truth(operand))
            case fcl.Joined(operators=operators):
                words = [o.upper for o in operators]
                if "OR" in words and "AND" in words[words.index("OR") :]:
                    self.mixed = self.mixed or condition
                infix = _FROM_THE_LEFT if self._scope.dialect.name == "jfuzzylogic" else _AND_FIRST
                return _Joining(condition, [self._truth(o) for o in condition.operands], infix).parse()
        raise TypeError(type(condition).__name__)

    def _clause(
        self, clause: fcl.Clause, known: Mapping[str, Sequence[str]]
    ) -> tuple[sx.Word, tuple[sx.Word, ...], sx.Word]:
        """Return variable, hedges and term of a clause; `any` needs no term, since it is 1 for each."""
        scope, place = self._scope, clause.variable.span
        name = scope.spelt(clause.variable.text, known, place) or clause.variable.text
        terms, (*before, last) = known.get(name, ()), clause.words
        if last.text.lower() == "any" and last.text not in terms and terms:
            before, term = [*before, last], terms[0]
        else:
            term = scope.spelt(last.text, terms, last.span) or last.text
        hedges = tuple(sx.Word(w.text.lower(), w.span) for w in before)
        return sx.Word(name, place), hedges, sx.Word(term, last.span)


class _Joining(InfixParser[sx.Truth, None]):
    """Joins conditions by the precedence of a dialect; a run of one operator is one node."""

    def __init__(self, condition: fcl.Joined, operands: Sequence[sx.Truth], infix: Mapping[str, Operator]) -> None:
        self.infix, self._span = infix, condition.span
        self._operands = iter(operands)
        self._operators = deque(o.upper for o in condition.operators)

    def _peek(self) -> str:
        return self._operators[0] if self._operators else ""

    def _take(self) -> None:
        self._operators.popleft()

    def _atom(self) -> sx.Truth:
        return next(self._operands)

    def _joined(self, sign: str, operands: Sequence[sx.Truth], places: Sequence[None]) -> sx.Truth:
        return sx.Chain(self._span, sign.lower(), tuple(operands))
