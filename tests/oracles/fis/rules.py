"""Rules from lines `1 -2, 1 (0.5) : 2`: terms by number, 0 for any, a minus for not, 2 for or."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import ONE, Expr, Name, Number
from fuzzyctl.formats.common.report import Findings, Reading
from fuzzyctl.model.block import Hedge
from fuzzyctl.model.rule import And, Antecedent, Consequent, Is, Or, Rule
from fuzzyctl.support.shipped import to_number
from tests.oracles.fis.sections import Entry, Section
from tests.oracles.fis.variables import Variable
from tests.oracles.fis.vocabulary import Dialect

#: Antecedent numbers, consequent numbers, weight and connective.
_FORM: Final = "a rule is written: 1 2, 1 (1) : 1"

_NUMBER: Final = re.compile(r"[^\s,;():]+")

_CONNECTIVES: Final = {"1": And, "2": Or}

#: What the digits behind the point stand for; `extremely` is another function in fuzzylite than in Octave, which knows
#: all fractions and raises degrees to ten times each.
_HEDGES: Final = {
    Decimal("0.05"): ("somewhat",),
    Decimal("0.2"): ("very",),
    Decimal("0.3"): ("extremely",),
    Decimal("0.4"): ("very", "very"),
}

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

    @property
    def has_hedges(self) -> bool:
        """Whether some number has digits behind the point."""
        return any(c.fraction for c in (*self.antecedent, *self.consequent))


def raw_rules(sections: Sequence[Section], findings: Findings) -> list[RawRule]:
    """Return the rules of a file as written; lines that are none are reported."""
    found = []
    for section in sections:
        for entry in section.entries:
            rule = _raw_rule(entry, findings)
            if rule is not None:
                found.append(rule)
    return found


def _raw_rule(entry: Entry, findings: Findings) -> RawRule | None:
    line = entry.span
    text = line.text.rstrip(";, ")
    comma = text.find(",")
    colon = text.rfind(":")
    opening = text.find("(", comma + 1)
    closing = text.find(")", opening + 1)
    if not 0 <= comma < opening < closing < colon:
        findings.error("FZ601", "the line is not a rule", line, help=_FORM)
        return None
    antecedent = _codes(line, 0, comma, findings)
    consequent = _codes(line, comma + 1, opening, findings)
    weight = _weight(line, opening + 1, closing, findings)
    connective = text[colon + 1 :].strip()
    if connective not in _CONNECTIVES:
        place = Span(line.source, line.start + colon, line.start + len(text))
        message = f"the connective is 1 for and, 2 for or, got '{connective[:20]}'"
        findings.error("FZ601", message, place, help=_FORM)
        return None
    if antecedent is None or consequent is None or weight is None:
        return None
    return RawRule(antecedent, consequent, weight, connective, Span(line.source, line.start, line.start + len(text)))


def _codes(line: Span, start: int, end: int, findings: Findings) -> tuple[Code, ...] | None:
    found: list[Code] = []
    sound = True
    for match in _NUMBER.finditer(line.source.text, line.start + start, line.start + end):
        span = Span(line.source, match.start(), match.end())
        value = _decimal(match.group())
        if value is None:
            findings.error("FZ601", f"'{match.group()[:20]}' is not the number of a term", span, help=_FORM)
            sound = False
            continue
        whole = int(abs(value))
        found.append(Code(whole, value.is_signed() and value != 0, abs(value) - whole, span))
    return tuple(found) if sound else None


def _decimal(text: str) -> Decimal | None:
    """Return the number of a term, exactly as written; None for what is no such number."""
    if len(text) > 20 or not text.isascii() or "_" in text:
        return None
    try:
        value = Decimal(text)
    except InvalidOperation:
        return None
    return value.normalize() if value.is_finite() and abs(value) < 10**6 and "e" not in text.lower() else None


def _weight(line: Span, start: int, end: int, findings: Findings) -> Number | None:
    text = line.text[start:end].strip()
    span = Span(line.source, line.start + start, line.start + end)
    try:
        value = to_number(text)
    except (ValueError, OverflowError):
        findings.error("FZ601", f"the weight is a number, got '{text[:20]}'", span, help=_FORM)
        return None
    if not 0 <= value <= 1:
        findings.error("FZ302", f"the weight {value:.6g} lies outside [0, 1]", span)
        return None
    return Number(value, span=span)


class RuleReader:
    """Make rules of numbers.

    Args:
        inputs: The inputs in order.
        outputs: The outputs in order.
        dialect: Who wrote the file, for hedges.
        sugeno: Whether consequents are numbers or functions.
        findings: Where mistakes go.

    Attributes:
        hedges: Those that the rules need besides the ones there are, by name.
    """

    def __init__(
        self,
        inputs: Sequence[Variable],
        outputs: Sequence[Variable],
        dialect: Dialect,
        sugeno: bool,
        findings: Findings,
    ) -> None:
        self.inputs = inputs
        self.outputs = outputs
        self.dialect = dialect
        self.sugeno = sugeno
        self.findings = findings
        self.hedges: dict[str, Hedge] = {}

    def read(self, raw: RawRule) -> Rule | None:
        """Return a rule; None for one that is reported as broken or without effect."""
        sound = self._fits(raw.antecedent, self.inputs, "input", raw)
        sound &= self._fits(raw.consequent, self.outputs, "output", raw)
        if not sound:
            return None
        consequents = tuple(
            Consequent(output=v.name, term=v.terms[c.number].name, hedges=self._consequent_hedges(c), span=c.span)
            for c, v in zip(raw.consequent, self.outputs, strict=True)
            if c.number
        )
        if not consequents:
            message = "the rule does not name an output, so it has no effect"
            self.findings.warning("FZ603", message, raw.span, help="remove it")
            return None
        antecedent = self._antecedent(raw)
        if antecedent is None:
            return None
        weight = raw.weight if raw.weight.value != 1 else ONE
        return Rule(antecedent=antecedent, consequents=consequents, weight=weight, span=raw.span)

    def _antecedent(self, raw: RawRule) -> Antecedent | None:
        operands = tuple(
            self._condition(c, v)
            for c, v in zip(raw.antecedent, self.inputs, strict=True)
            if c.number or (self._is_any(c) and (c.negated or raw.connective == "2"))
        )
        if not operands:
            return self._always(raw)
        if len(operands) == 1:
            return operands[0]
        return And(operands=operands, span=raw.span) if raw.connective == "1" else Or(operands=operands, span=raw.span)

    def _is_any(self, code: Code) -> bool:
        """Whether a number says `any` of an input without naming a term, as those of fuzzylite do."""
        return self.dialect == "fuzzylite" and code.number == 0 and code.fraction == _ANY and self._named() is not None

    def _named(self) -> Variable | None:
        """Return an input that has terms."""
        return next((v for v in self.inputs if v.terms), None)

    def _condition(self, code: Code, variable: Variable) -> Is:
        if not code.number:  # any term of any input says the same
            variable = variable if variable.terms else self._named() or variable
        term = variable.terms[code.number] if code.number else next(iter(variable.terms.values()))
        return Is(variable=variable.name, term=term.name, hedges=self._hedges(code), span=code.span)

    def _always(self, raw: RawRule) -> Antecedent | None:
        """Return what holds everywhere, for a rule without conditions joined by and; by or it holds nowhere."""
        named = self._named()
        if named is None:
            message = "the rule has no condition, and no input has a term"
            self.findings.error("FZ602", message, raw.span, help="give an input a term")
            return None
        if raw.connective == "1" and self.dialect == "fuzzylite":
            message = "the rule has no condition, so it always acts"
            other = "fuzzylite leaves such a rule out; what only such rules set is 'nan' there"
            self.findings.differs(Reading(message, other, "remove the rule, or give it a condition", raw.span))
        hedges = ("any",) if raw.connective == "1" else ("not", "any")
        if raw.connective == "2":
            message = "the rule has no condition and joins by 'or', so it never acts"
            self.findings.warning("FZ603", message, raw.span, help="with ': 1' it acts always")
        first = next(iter(named.terms.values()))
        return Is(variable=named.name, term=first.name, hedges=hedges, span=raw.span)

    def _fits(self, codes: tuple[Code, ...], variables: Sequence[Variable], what: str, raw: RawRule) -> bool:
        if len(codes) != len(variables):
            due, has = counted(len(variables), what), counted(len(codes), "number")
            facts = (f"{what}s: {', '.join(v.name for v in variables)}",)
            self.findings.error("FZ601", f"the rule has {has} for {due}", raw.span, facts=facts, help=_FORM)
            return False
        sound = True
        for code, variable in zip(codes, variables, strict=True):
            if code.number in variable.terms or (code.number == 0 and code.fraction in (0, _ANY)):
                continue
            sound = False
            if not 0 < code.number <= variable.written:  # else the term has been reported
                self._no_such_term(code, variable)
        return sound

    def _no_such_term(self, code: Code, variable: Variable) -> None:
        named = ", ".join(f"{n} {t.name}" for n, t in list(variable.terms.items())[:20])
        message = f"'{variable.name}' has no term {code.number}"
        facts = (f"terms of '{variable.name}': {named or 'none'}",)
        self.findings.error("FZ607", message, code.span, facts=facts)

    def _hedges(self, code: Code) -> tuple[str, ...]:
        hedges = self._power(code.fraction, code.span) if code.fraction else ()
        return ("not", *hedges) if code.negated else hedges

    def _consequent_hedges(self, code: Code) -> tuple[str, ...]:
        if self.sugeno and code.negated and self.dialect == "matlab":
            message = "a negated consequent has no meaning in a Sugeno system of MATLAB"
            self.findings.error("FZ602", message, code.span, help="remove the minus")
        return self._hedges(code)

    def _power(self, fraction: Decimal, span: Span) -> tuple[str, ...]:
        """Return the hedges for the digits behind the point."""
        if fraction in _HEDGES:
            return _HEDGES[fraction]
        if fraction == _ANY and self.dialect == "fuzzylite":
            return ("any",)
        if self.dialect == "fuzzylite":
            message = f"fuzzylite has no hedge for the fraction {fraction}"
            facts = (".05 somewhat, .2 very, .3 extremely, .4 very very",)
            self.findings.error("FZ602", message, span, facts=facts)
        return self._own(10 * fraction)

    def _own(self, exponent: Decimal) -> tuple[str, ...]:
        """Return a hedge that raises degrees to a power; it gets declared."""
        name = f"power_{exponent.normalize():f}".replace(".", "_")
        power: Expr = Name("x") ** float(exponent)
        self.hedges[name] = Hedge(name=name, parameter="x", expression=power)
        return (name,)
