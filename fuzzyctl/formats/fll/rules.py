"""Parser of rules in words, `if A is x and B is not y then C is z with 0.5`; `and` binds before `or`."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import ONE, Number
from fuzzyctl.formats.common.infix import Operator, SpanParser
from fuzzyctl.formats.common.report import ParseError, meant
from fuzzyctl.formats.common.translation import Translation
from fuzzyctl.lang import syntax as sx

_TOKEN: Final = re.compile(r"[()]|[^\s()]+")

_FORM: Final = "a rule is written: if A is x and B is y then C is z with 0.5"

#: The words and signs that may follow a term.
_AFTER_TERM: Final = ("and", "or", "then", "with", "(", ")")

#: Deepest nesting of parentheses, and most hedges of a term.
_DEEPEST: Final = 50


class RuleText(SpanParser[sx.Truth]):
    """Parser of one rule.

    Args:
        span: Its text.
        terms: The names of the terms of each variable, which may be words of rules.
        hedges: The words for hedges.
        disabled: Variables whose propositions are false.
        translation: Takes a mistake.
    """

    infix: Mapping[str, Operator] = {"or": Operator(1, run=True), "and": Operator(2, run=True)}
    deepest = _DEEPEST

    def __init__(
        self,
        span: Span,
        terms: Mapping[str, Sequence[str]],
        hedges: Collection[str],
        disabled: Collection[str],
        translation: Translation,
    ) -> None:
        self.span, self.terms, self.hedges, self.disabled = span, terms, hedges, disabled
        self.translation = translation
        self.conditions: list[sx.Literal] = []
        self.consequents: list[sx.ConsequentText] = []
        text = span.source.text
        self.tokens = [Span(span.source, m.start(), m.end()) for m in _TOKEN.finditer(text, span.start, span.end)]

    def read(self) -> sx.Rule | None:
        """Return the rule; report a mistake and return the part before it, so that its names are checked."""
        weight: Number | None = ONE
        try:
            self._expect("if")
            antecedent = self.parse()
            self._expect("then")
            self._consequents()
            weight = self._weight()
            if self.next < len(self.tokens):
                place = self.tokens[self.next]
                raise ParseError(f"unexpected '{place.text[:40]}' in the rule", place, help=_FORM)
        except ParseError as error:
            self.translation.refuse(error)
            if not self.conditions:
                return None
            antecedent = sx.Chain(self.span, "and", tuple(self.conditions))
        return sx.Rule(self.span, antecedent, tuple(self.consequents), weight)

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

    def _joined(self, sign: str, operands: Sequence[sx.Truth], places: Sequence[Span]) -> sx.Truth:
        return sx.Chain(self.span, sign, tuple(operands))

    def _atom(self) -> sx.Truth:
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

    def _proposition(self) -> sx.Literal:
        variable = self._variable()
        names = self.terms.get(variable.text, ())
        hedges = self._hedges(names)
        is_any = bool(hedges) and hedges[-1].text == "any"
        if is_any and (self._text() not in names or self._text() in ("and", "or")):
            if not names and variable.text in self.terms:
                message = f"'{variable.text}' has no term, which even 'any' needs here"
                raise ParseError(message, variable.span, "FZ203", help="give it a term")
            term = sx.Word(names[0] if names else "any", hedges[-1].span)  # it is 1 whatever the term
        else:
            term = self._term(variable, names)
        place = variable.span.to(self.tokens[self.next - 1])
        if variable.text in self.disabled:
            hedges = (sx.Word("not", place), sx.Word("any", place))
        self.conditions.append(sx.Literal(place, variable, hedges, term))
        return self.conditions[-1]

    def _variable(self) -> sx.Word:
        place = self._required("a variable")
        if place.text not in self.terms and self._peek() != "is":
            raise self._no_variable(place)
        self._expect("is")
        return sx.Word(place.text, place)

    def _no_variable(self, place: Span) -> ParseError:
        facts = (f"variables: {', '.join(self.terms)}",)
        help_text = meant(place.text, self.terms) or _FORM
        return ParseError(f"there is no variable '{place.text[:40]}'", place, "FZ202", help=help_text, facts=facts)

    def _hedges(self, names: Collection[str]) -> tuple[sx.Word, ...]:
        """Return the hedges before a term; a term with the name of a hedge is a term if no term follows it."""
        hedges: list[sx.Word] = []
        while self._text() in self.hedges:
            following = self.tokens[self.next + 1].text if self.next + 1 < len(self.tokens) else ""
            if self._text() in names and not (following in names or following in self.hedges):
                break
            place = self._take()
            hedges.append(sx.Word(place.text, place))
            if len(hedges) > _DEEPEST:
                raise ParseError(f"the rule has more than {_DEEPEST} hedges of one term", place, "FZ106")
        return tuple(hedges)

    def _term(self, variable: sx.Word, names: Collection[str]) -> sx.Word:
        if variable.text not in self.terms and self._peek() in ("", *_AFTER_TERM):
            raise self._no_variable(variable.span)
        place = self._required("a term")
        if place.text not in names and place.text.lower() in _AFTER_TERM:
            message = f"expected a term of '{variable.text}', found '{place.text}'"
            facts = (f"terms of '{variable.text}': {', '.join(names) or 'none'}",)
            raise ParseError(message, place, help=_FORM, facts=facts)
        return sx.Word(place.text, place)

    def _consequents(self) -> None:
        while True:
            output = self._variable()
            names = self.terms.get(output.text, ())
            hedges = self._hedges(names)
            self.consequents.append(sx.ConsequentText(output, self._term(output, names), hedges))
            if self._peek() != "and":
                return
            self.next += 1

    def _weight(self) -> Number | None:
        if self._peek() != "with":
            return ONE
        self.next += 1
        return self.translation.weight(self._required("a weight"), _FORM)
