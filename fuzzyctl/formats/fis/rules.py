"""Rules from lines `1 -2, 1 (0.5) : 2`: terms by number, 0 for any, a minus for not, 2 for or."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Name, Number
from fuzzyctl.formats.common.report import Reading
from fuzzyctl.formats.common.translation import Translation
from fuzzyctl.formats.fis.sections import Entry, Section
from fuzzyctl.formats.fis.vocabulary import HEDGES, Dialect
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.variable import Term

#: Antecedent numbers, consequent numbers, weight and connective.
_FORM: Final = "a rule is written: 1 2, 1 (1) : 1"

_NUMBER: Final = re.compile(r"[^\s,;():]+")

_CONNECTIVES: Final = {"1": "and", "2": "or"}

#: What fuzzylite writes for `any`, whatever the term.
_ANY: Final = Decimal("0.99")


@dataclass(frozen=True)
class Code:
    """The number of a term in a rule: which, whether negated, and its hedge as a fraction."""

    number: int
    negated: bool
    fraction: Decimal
    span: Span


@dataclass(frozen=True)
class RawRule:
    """A rule as written."""

    antecedent: tuple[Code, ...]
    consequent: tuple[Code, ...]
    weight: Number
    connective: str
    span: Span


@dataclass(frozen=True)
class Numbered:
    """A variable whose terms rules name by number; those that could not be read are None."""

    name: str
    terms: Sequence[Term | None]

    @property
    def first(self) -> Term | None:
        """The first term that could be read."""
        return next((t for t in self.terms if t is not None), None)


def raw_rules(sections: Sequence[Section], translation: Translation) -> list[RawRule]:
    """Return the rules of a file as written; lines that are none are reported."""
    found = (_raw_rule(entry, translation) for section in sections for entry in section.entries)
    return [rule for rule in found if rule is not None]


def has_hedges(rules: Sequence[RawRule]) -> bool:
    """Whether some number has digits behind the point."""
    return any(c.fraction for r in rules for c in (*r.antecedent, *r.consequent))


def _raw_rule(entry: Entry, translation: Translation) -> RawRule | None:
    line, text = entry.span, entry.span.text.rstrip(";, ")
    comma, colon = text.find(","), text.rfind(":")
    opening = text.find("(", comma + 1)
    closing = text.find(")", opening + 1)
    if not 0 <= comma < opening < closing < colon:
        translation.error("FZ601", "the line is not a rule", line, help=_FORM)
        return None

    def part(start: int, end: int) -> Span:
        return Span(line.source, line.start + start, line.start + end)

    antecedent = _codes(part(0, comma), translation)
    consequent = _codes(part(comma + 1, opening), translation)
    weight = translation.weight(part(opening + 1, closing), _FORM)
    connective = text[colon + 1 :].strip()
    if connective not in _CONNECTIVES:
        message = f"the connective is 1 for and, 2 for or, got '{connective[:20]}'"
        translation.error("FZ601", message, part(colon, len(text)), help=_FORM)
        return None
    if antecedent is None or consequent is None or weight is None:
        return None
    return RawRule(antecedent, consequent, weight, _CONNECTIVES[connective], part(0, len(text)))


def _codes(part: Span, translation: Translation) -> tuple[Code, ...] | None:
    found: list[Code | None] = []
    for match in _NUMBER.finditer(part.source.text, part.start, part.end):
        span = Span(part.source, match.start(), match.end())
        value = _decimal(match.group())
        if value is None:
            translation.error("FZ601", f"'{match.group()[:20]}' is no number of a term", span, help=_FORM)
            found.append(None)
            continue
        whole = int(abs(value))
        found.append(Code(whole, value.is_signed() and value != 0, abs(value) - whole, span))
    sound = tuple(c for c in found if c is not None)
    return sound if len(sound) == len(found) else None


def _decimal(text: str) -> Decimal | None:
    """Return the number of a term, exactly as written; None for what is no such number."""
    if len(text) > 20 or not text.isascii() or "_" in text or "e" in text.lower():
        return None
    try:
        value = Decimal(text)
    except InvalidOperation:
        return None
    return value.normalize() if value.is_finite() and abs(value) < 10**6 else None


class RuleReader:
    """Makes nodes of numbers.

    Args:
        inputs: The inputs in order.
        outputs: The outputs in order.
        dialect: Who wrote the file, for hedges.
        sugeno: Whether consequents are numbers or functions.
        translation: Takes the rules, their hedges, and mistakes.
    """

    def __init__(
        self,
        inputs: Sequence[Numbered],
        outputs: Sequence[Numbered],
        dialect: Dialect,
        sugeno: bool,
        translation: Translation,
    ) -> None:
        self.inputs, self.outputs, self.dialect, self.sugeno = inputs, outputs, dialect, sugeno
        self.translation = translation
        self.powers: set[str] = set()
        #: An input that has terms.
        self.named = next((v for v in inputs if v.first is not None), None)

    def read(self, raw: RawRule) -> None:
        """Add a rule, unless it has a mistake or no effect, which is reported."""
        sound = self._fits(raw.antecedent, self.inputs, "input", raw)
        if not (self._fits(raw.consequent, self.outputs, "output", raw) and sound):
            return
        consequents = [
            sx.ConsequentText(sx.Word(v.name, c.span), self._term(c, v), self._consequent_hedges(c))
            for c, v in zip(raw.consequent, self.outputs, strict=True)
            if c.number
        ]
        if not consequents:
            message = "the rule names no output, so it has no effect"
            self.translation.warning("FZ603", message, raw.span, help="remove it")
            return
        antecedent = self._antecedent(raw)
        if antecedent is not None:
            self.translation.statements.append(sx.Rule(raw.span, antecedent, tuple(consequents), raw.weight))

    def _antecedent(self, raw: RawRule) -> sx.Truth | None:
        operands = tuple(
            self._condition(c, v)
            for c, v in zip(raw.antecedent, self.inputs, strict=True)
            if c.number or (self._is_any(c) and (c.negated or raw.connective == "or"))
        )
        if len(operands) > 1:
            return sx.Chain(raw.span, raw.connective, operands)
        return operands[0] if operands else self._always(raw)

    def _is_any(self, code: Code) -> bool:
        """Whether a number says `any` of an input without naming a term, as those of fuzzylite do."""
        return self.dialect == "fuzzylite" and code.number == 0 and code.fraction == _ANY and self.named is not None

    def _condition(self, code: Code, variable: Numbered) -> sx.Literal:
        if not code.number and variable.first is None:  # any term of any input says the same
            variable = self.named or variable
        return sx.Literal(code.span, sx.Word(variable.name, code.span), self._hedges(code), self._term(code, variable))

    def _term(self, code: Code, variable: Numbered) -> sx.Word:
        term = variable.terms[code.number - 1] if code.number else variable.first
        assert term is not None
        return sx.Word(term.name, code.span)

    def _always(self, raw: RawRule) -> sx.Truth | None:
        """Return what holds everywhere, for a rule without conditions joined by and; by or it holds nowhere."""
        if self.named is None or self.named.first is None:
            message = "the rule has no condition, and no input has a term"
            self.translation.error("FZ602", message, raw.span, help="give an input a term")
            return None
        if raw.connective == "or":
            message = "the rule has no condition and joins by 'or', so it never acts"
            self.translation.warning("FZ603", message, raw.span, help="with ': 1' it acts always")
        elif self.dialect == "fuzzylite":
            message = "the rule has no condition, so it always acts"
            other = "fuzzylite leaves such a rule out; what only such rules set is 'nan' there"
            self.translation.differs(Reading(message, other, "remove the rule, or give it a condition", raw.span))
        words = ("any",) if raw.connective == "and" else ("not", "any")
        name, term = sx.Word(self.named.name, raw.span), sx.Word(self.named.first.name, raw.span)
        return sx.Literal(raw.span, name, self._words(words, raw.span), term)

    def _fits(self, codes: tuple[Code, ...], variables: Sequence[Numbered], what: str, raw: RawRule) -> bool:
        if len(codes) != len(variables):
            expected, has = counted(len(variables), what), counted(len(codes), "number")
            facts = (f"{what}s: {', '.join(v.name for v in variables)}",)
            message = f"the rule has {has} for {expected}"
            self.translation.error("FZ601", message, raw.span, facts=facts, help=_FORM)
            return False
        return all([self._has(v, c) for c, v in zip(codes, variables, strict=True)])

    def _has(self, variable: Numbered, code: Code) -> bool:
        if code.number == 0 and code.fraction in (0, _ANY):
            return True
        if 0 < code.number <= len(variable.terms):
            return variable.terms[code.number - 1] is not None  # else the term has been reported
        known = [f"{n} {t.name}" for n, t in enumerate(variable.terms, 1) if t is not None]
        facts = (f"terms of '{variable.name}': {', '.join(known[:20]) or 'none'}",)
        self.translation.error("FZ607", f"'{variable.name}' has no term {code.number}", code.span, facts=facts)
        return False

    def _words(self, hedges: Sequence[str], span: Span) -> tuple[sx.Word, ...]:
        return tuple(sx.Word(h, span) for h in hedges)

    def _hedges(self, code: Code) -> tuple[sx.Word, ...]:
        hedges = self._power(code.fraction, code.span) if code.fraction else ()
        return self._words(("not", *hedges) if code.negated else hedges, code.span)

    def _consequent_hedges(self, code: Code) -> tuple[sx.Word, ...]:
        if self.sugeno and code.negated and self.dialect == "matlab":
            message = "a negated consequent has no meaning in a Sugeno system of MATLAB"
            self.translation.error("FZ602", message, code.span, help="remove the minus")
        return self._hedges(code)

    def _power(self, fraction: Decimal, span: Span) -> tuple[str, ...]:
        """Return the hedges for the digits behind the point."""
        known = next((hedges for hedges, digits in HEDGES.items() if digits == fraction), None)
        if known is not None:
            return known
        if self.dialect != "fuzzylite":
            return self._own(10 * fraction, span)
        if fraction != _ANY:
            message = f"fuzzylite has no hedge for the fraction {fraction}"
            facts = (".05 somewhat, .2 very, .3 extremely, .4 very very",)
            self.translation.error("FZ602", message, span, facts=facts)
        return ("any",)

    def _own(self, exponent: Decimal, span: Span) -> tuple[str, ...]:
        """Return a hedge that raises degrees to a power; it gets declared."""
        name = f"power_{exponent.normalize():f}".replace(".", "_")
        if name not in self.powers:
            self.powers.add(name)
            power = Name("x") ** float(exponent)
            self.translation.statements.append(sx.Hedge(span, sx.Word(name, span), sx.Word("x", span), power))
        return (name,)
