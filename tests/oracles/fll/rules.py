"""Parser of `rule: if A is x and B is not y then C is z with 0.5`; `and` binds before `or`."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import ONE, Number
from fuzzyctl.formats.common.infix import Operator, SpanParser
from fuzzyctl.formats.common.report import Findings, ParseError, meant
from fuzzyctl.formats.fll.terms import NOT_BEYOND
from fuzzyctl.model.rule import And, Antecedent, Consequent, Is, Or, Rule
from fuzzyctl.support.shipped import to_number
from tests.oracles.fll.variables import Variable
from tests.oracles.fll.vocabulary import HEDGE_WORDS

_TOKEN: Final = re.compile(r"[()]|[^\s()]+")

_FORM: Final = "a rule is written: if A is x and B is y then C is z with 0.5"

#: What stands behind a term.
_AFTER_TERM: Final = ("and", "or", "then", "with", "(", ")")

#: Deepest nesting of parentheses, and most hedges of a term.
_DEEPEST: Final = 50


class UnreadTermError(ValueError):
    """Raised for a rule that names a term which has been reported."""


class RuleReader:
    """Read the rules of a file.

    Args:
        variables: Inputs and outputs by name.
        findings: Where mistakes go.
    """

    def __init__(self, variables: Mapping[str, Variable], findings: Findings) -> None:
        self.variables = variables
        self.findings = findings

    def read(self, span: Span) -> Rule | None:
        """Return a rule; None for one that is reported as broken or without effect."""
        try:
            return _RuleText(span, self.variables).read(self.findings)
        except UnreadTermError:
            return None
        except ParseError as error:
            self.findings.refuse(error)
            return None


class _RuleText(SpanParser[Antecedent]):
    infix: Mapping[str, Operator] = {"or": Operator(1, run=True), "and": Operator(2, run=True)}
    deepest = _DEEPEST

    def __init__(self, span: Span, variables: Mapping[str, Variable]) -> None:
        self.span = span
        self.variables = variables
        self.tokens = [
            Span(span.source, m.start(), m.end()) for m in _TOKEN.finditer(span.source.text, span.start, span.end)
        ]

    def read(self, findings: Findings) -> Rule | None:
        self._expect("if")
        antecedent = self.parse()
        self._expect("then")
        consequents = self._consequents()
        weight = self._weight()
        if self.next < len(self.tokens):
            place = self.tokens[self.next]
            raise ParseError(f"unexpected '{place.text[:40]}' in the rule", place, help=_FORM)
        if not consequents:
            message, help_text = "the rule sets only disabled outputs, so it has no effect", "enable one, or remove it"
            findings.warning("FZ611", message, self.span, help=help_text)
            return None
        return Rule(antecedent=antecedent, consequents=consequents, weight=weight, span=self.span)

    def _required(self, what: str) -> Span:
        if self.next >= len(self.tokens):
            end = Span(self.span.source, max(self.span.start, self.span.end - 1), self.span.end)
            raise ParseError(f"unexpected end of the rule, expected {what}", end, help=_FORM)
        return self._take()

    def _expect(self, word: str) -> None:
        place = self._required(f"'{word}'")
        if place.text.lower() != word:
            raise ParseError(f"expected '{word}', found '{place.text[:40]}'", place, help=_FORM)

    def _peek(self) -> str:
        return self._text().lower()

    def _joined(self, sign: str, operands: Sequence[Antecedent], places: Sequence[Span]) -> Antecedent:
        return (And if sign == "and" else Or)(operands=tuple(operands), span=self.span)

    def _atom(self) -> Antecedent:
        if self._text() != "(":
            return self._proposition()
        place = self._take()
        inner = self._nested(0, place)
        if self._text() != ")":
            raise ParseError("a parenthesis is not closed", place, "FZ103")
        self.next += 1
        return inner

    def _too_deep(self, place: Span) -> ParseError:
        return ParseError("the rule is nested too deeply", place, "FZ106")

    def _proposition(self) -> Is:
        variable, start = self._variable(output=False)
        hedges = self._hedges(variable)
        if hedges and hedges[-1] == "any" and (self._text() not in variable.names or self._text() in ("and", "or")):
            term = self._any_term(variable, start)
        else:
            term = self._term(variable)
        if not variable.enabled:
            hedges = ("not", "any")  # the propositions of a disabled variable are false, whatever it is
        place = start.to(self.tokens[self.next - 1])
        return Is(variable=variable.name, term=term, hedges=hedges, span=place)

    def _any_term(self, variable: Variable, start: Span) -> str:
        """Return some term: `any` needs none."""
        if not variable.names:
            message = f"'{variable.name}' has no term, which even 'any' needs here"
            raise ParseError(message, start, "FZ203", help="give it a term")
        return variable.names[0]

    def _variable(self, *, output: bool) -> tuple[Variable, Span]:
        place = self._required("a variable")
        name = place.text
        variable = self.variables.get(name)
        if variable is None:
            known = [v.name for v in self.variables.values() if v.is_output or not output]
            message = f"there is no variable '{name[:40]}'"
            facts = (f"variables: {', '.join(known)}",)
            raise ParseError(message, place, "FZ202", help=meant(name, known) or _FORM, facts=facts)
        if output and not variable.is_output:
            message = f"expected an output behind 'then', found the input '{name}'"
            raise ParseError(message, place, "FZ202", help="only outputs are set by rules")
        self._expect("is")
        return variable, place

    def _hedges(self, variable: Variable) -> tuple[str, ...]:
        """Return the hedges before a term; a term of such a name is a term where no term follows it."""
        found: list[str] = []
        while self._text() in HEDGE_WORDS:
            following = self.tokens[self.next + 1].text if self.next + 1 < len(self.tokens) else ""
            if self._text() in variable.names and not (following in variable.names or following in HEDGE_WORDS):
                break
            found.append(self._required("a hedge").text)
            if len(found) > _DEEPEST:
                raise ParseError(
                    f"the rule has more than {_DEEPEST} hedges of one term", self.tokens[self.next - 1], "FZ106"
                )
        return tuple(found)

    def _term(self, variable: Variable) -> str:
        place = self._required("a term")
        if place.text in variable.unread:
            raise UnreadTermError
        if place.text not in variable.names:
            if place.text.lower() in _AFTER_TERM:
                message = f"expected a term of '{variable.name}', found '{place.text}'"
                facts = (f"terms of '{variable.name}': {', '.join(variable.names) or 'none'}",)
                raise ParseError(message, place, help=_FORM, facts=facts)
            message = f"'{variable.name}' has no term '{place.text[:40]}'"
            facts = (f"terms of '{variable.name}': {', '.join(variable.names) or 'none'}",)
            known = [*variable.names, *HEDGE_WORDS]
            raise ParseError(message, place, "FZ203", help=meant(place.text, known), facts=facts)
        return place.text

    def _consequents(self) -> tuple[Consequent, ...]:
        found = []
        while True:
            variable, start = self._variable(output=True)
            hedges = self._hedges(variable)
            term = self._term(variable)
            place = start.to(self.tokens[self.next - 1])
            if variable.enabled:
                found.append(Consequent(output=variable.name, term=term, hedges=hedges, span=place))
            if self._text().lower() != "and":
                return tuple(found)
            self.next += 1

    def _weight(self) -> Number:
        if self._text().lower() != "with":
            return ONE
        self.next += 1
        place = self._required("a weight")
        try:
            value = to_number(place.text)
        except (ValueError, OverflowError):
            value = math.nan
        if math.isnan(value):
            raise ParseError(f"the weight is a number, got '{place.text[:40]}'", place, help=_FORM)
        if not 0 <= value <= 1:
            raise ParseError(f"the weight {place.text[:40]} lies outside [0, 1]", place, "FZ302", help=NOT_BEYOND)
        return ONE if value == 1 else Number(value, span=place)
