"""Rules as lines `1 -2, 1 (0.5) : 2`: terms by number, 0 for any, a minus for not, digits for hedges, 2 for or."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from functools import cached_property
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Binary, Expr, Name, Number
from fuzzyctl.formats.common.report import Reading
from fuzzyctl.formats.common.translation import Translation
from fuzzyctl.formats.fis.dialects import ANY, HEDGES, Dialect
from fuzzyctl.formats.fis.sections import Section
from fuzzyctl.formats.fis.shapes import number
from fuzzyctl.formats.registry import Loss
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.rule import And, Antecedent, Is, Not, Or, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable, Membership, Output, Term

#: Antecedent numbers, consequent numbers, weight and connective.
_FORM: Final = "a rule is written: 1 2, 1 (1) : 1"

_NUMBER: Final = re.compile(r"[^\s,;():]+")

_DECIMAL: Final = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)", re.ASCII)

_CONNECTIVES: Final = {"1": "and", "2": "or"}


@dataclass(frozen=True)
class Variable:
    """A variable of a file, whose terms rules name by number; unreadable terms are None."""

    section: Section
    name: sx.Word
    ends: tuple[Number, Number]
    terms: Sequence[Term | None]

    @property
    def sound(self) -> list[Term]:
        """The readable terms."""
        return [t for t in self.terms if t is not None]

    @property
    def memberships(self) -> list[Membership]:
        """The membership functions of the readable terms."""
        return [t.membership for t in self.sound]


# --- read ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Code:
    """The number of a term in a rule: which, whether negated, and its hedge as a fraction."""

    number: int
    negated: bool
    fraction: Decimal
    span: Span


@dataclass(frozen=True)
class CodedRule:
    """A rule in numbers."""

    antecedent: tuple[Code, ...]
    consequent: tuple[Code, ...]
    weight: Number
    connective: str
    span: Span

    @property
    def has_hedges(self) -> bool:
        """Whether some number has digits behind the point."""
        return any(c.fraction for c in (*self.antecedent, *self.consequent))


def coded_rules(sections: Sequence[Section], translation: Translation) -> list[CodedRule]:
    """Return the rules of a file in numbers; report mistakes."""
    rules = (_coded_rule(entry.span, translation) for section in sections for entry in section.entries)
    return [rule for rule in rules if rule is not None]


def _coded_rule(line: Span, translation: Translation) -> CodedRule | None:
    text = line.text.rstrip(";, ")
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
    return CodedRule(antecedent, consequent, weight, _CONNECTIVES[connective], part(0, len(text)))


def _codes(part: Span, translation: Translation) -> tuple[Code, ...] | None:
    codes, is_sound = [], True
    for match in _NUMBER.finditer(part.source.text, part.start, part.end):
        text, span = match.group(), Span(part.source, match.start(), match.end())
        value = Decimal(text).normalize() if len(text) <= 20 and _DECIMAL.fullmatch(text) else None
        if value is None or abs(value) >= 10**6:
            translation.error("FZ601", f"'{text[:20]}' is not the number of a term", span, help=_FORM)
            is_sound = False
        else:
            whole = int(abs(value))
            codes.append(Code(whole, value.is_signed() and value != 0, abs(value) - whole, span))
    return tuple(codes) if is_sound else None


@dataclass
class RuleReader:
    """Translates rules in numbers.

    Args:
        inputs: The inputs in order.
        outputs: The outputs in order.
        dialect: The tool that wrote the file, for hedges.
        sugeno: Whether consequents are numbers or functions.
        translation: Takes the rules, their hedges, and mistakes.
        powers: The names of hedges declared so far.
    """

    inputs: Sequence[Variable]
    outputs: Sequence[Variable]
    dialect: Dialect
    sugeno: bool
    translation: Translation
    powers: set[str] = field(default_factory=set)

    @cached_property
    def some_input(self) -> Variable | None:
        """An input that has terms."""
        return next((v for v in self.inputs if v.sound), None)

    def read(self, rule: CodedRule) -> None:
        """Add a rule; report a mistake, or that it has no effect."""
        fits = self._fits(rule.antecedent, self.inputs, "input", rule)
        if not (self._fits(rule.consequent, self.outputs, "output", rule) and fits):
            return
        consequents = [
            sx.ConsequentText(sx.Word(v.name.text, c.span), _term(c, v), self._consequent_hedges(c))
            for c, v in zip(rule.consequent, self.outputs, strict=True)
            if c.number
        ]
        if not consequents:
            message = "the rule does not name an output, so it has no effect"
            self.translation.warning("FZ603", message, rule.span, help="remove it")
            return
        antecedent = self._antecedent(rule)
        if antecedent is not None:
            self.translation.statements.append(sx.Rule(rule.span, antecedent, tuple(consequents), rule.weight))

    def _antecedent(self, rule: CodedRule) -> sx.Truth | None:
        operands = tuple(
            self._condition(c, v)
            for c, v in zip(rule.antecedent, self.inputs, strict=True)
            if c.number or (self._is_any(c) and (c.negated or rule.connective == "or"))
        )
        if len(operands) > 1:
            return sx.Chain(rule.span, rule.connective, operands)
        return operands[0] if operands else self._always(rule)

    def _is_any(self, code: Code) -> bool:
        """Whether a number says `any` of an input without naming a term, as those of fuzzylite do."""
        return self.dialect == "fuzzylite" and code.number == 0 and code.fraction == ANY and self.some_input is not None

    def _condition(self, code: Code, variable: Variable) -> sx.Literal:
        if not code.number and not variable.sound:  # any term of any input says the same
            variable = self.some_input or variable
        return sx.Literal(code.span, sx.Word(variable.name.text, code.span), self._hedges(code), _term(code, variable))

    def _always(self, rule: CodedRule) -> sx.Truth | None:
        """Return a condition that always holds, for a rule without conditions; joined by `or` it never holds."""
        if self.some_input is None:
            message = "the rule has no condition, and no input has a term"
            self.translation.error("FZ602", message, rule.span, help="give an input a term")
            return None
        if rule.connective == "or":
            message = "the rule has no condition and joins by 'or', so it never acts"
            self.translation.warning("FZ603", message, rule.span, help="with ': 1' it acts always")
        elif self.dialect == "fuzzylite":
            message = "the rule has no condition, so it always acts"
            other = "fuzzylite leaves such a rule out; what only such rules set is 'nan' there"
            self.translation.differs(Reading(message, other, "remove the rule, or give it a condition", rule.span))
        hedges = ("any",) if rule.connective == "and" else ("not", "any")
        name, term = self.some_input.name.text, self.some_input.sound[0].name
        words = tuple(sx.Word(h, rule.span) for h in hedges)
        return sx.Literal(rule.span, sx.Word(name, rule.span), words, sx.Word(term, rule.span))

    def _fits(self, codes: tuple[Code, ...], variables: Sequence[Variable], what: str, rule: CodedRule) -> bool:
        """Whether there is a number for each variable, and each is that of a term; report a mistake."""
        if len(codes) != len(variables):
            facts = (f"{what}s: {', '.join(v.name.text for v in variables)}",)
            message = f"the rule has {counted(len(codes), 'number')} for {counted(len(variables), what)}"
            self.translation.error("FZ601", message, rule.span, facts=facts, help=_FORM)
            return False
        return all([self._has(v, c) for c, v in zip(codes, variables, strict=True)])

    def _has(self, variable: Variable, code: Code) -> bool:
        if code.number == 0 and code.fraction in (0, ANY):
            return True
        if 0 < code.number <= len(variable.terms):
            return variable.terms[code.number - 1] is not None  # an unreadable term has been reported
        name = variable.name.text
        known = [f"{n} {t.name}" for n, t in enumerate(variable.terms, 1) if t is not None]
        facts = (f"terms of '{name}': {', '.join(known[:20]) or 'none'}",)
        self.translation.error("FZ607", f"'{name}' has no term {code.number}", code.span, facts=facts)
        return False

    def _consequent_hedges(self, code: Code) -> tuple[sx.Word, ...]:
        if self.sugeno and code.negated and self.dialect == "matlab":
            message = "a negated consequent has no meaning in a Sugeno system of MATLAB"
            self.translation.error("FZ602", message, code.span, help="remove the minus")
        return self._hedges(code)

    def _hedges(self, code: Code) -> tuple[sx.Word, ...]:
        hedges = self._hedges_of_fraction(code.fraction, code.span) if code.fraction else ()
        return tuple(sx.Word(h, code.span) for h in (("not", *hedges) if code.negated else hedges))

    def _hedges_of_fraction(self, fraction: Decimal, span: Span) -> tuple[str, ...]:
        """Return the hedges for the digits behind the point."""
        known = next((hedges for hedges, digits in HEDGES.items() if digits == fraction), None)
        if known is not None:
            return known
        if self.dialect != "fuzzylite":
            return (self._power(10 * fraction, span),)
        if fraction != ANY:
            message = f"fuzzylite has no hedge for the fraction {fraction}"
            facts = (".05 somewhat, .2 very, .3 extremely, .4 very very",)
            self.translation.error("FZ602", message, span, facts=facts)
        return ("any",)

    def _power(self, exponent: Decimal, span: Span) -> str:
        """Return the name of a hedge that raises degrees to a power, and declare it."""
        name = f"power_{exponent.normalize():f}".replace(".", "_")
        if name not in self.powers:
            self.powers.add(name)
            power = Name("x") ** float(exponent)
            self.translation.statements.append(sx.Hedge(span, sx.Word(name, span), sx.Word("x", span), power))
        return name


def _term(code: Code, variable: Variable) -> sx.Word:
    term = variable.terms[code.number - 1] if code.number else variable.sound[0]
    assert term is not None
    return sx.Word(term.name, code.span)


# --- written -------------------------------------------------------------------------------------------------------


@dataclass
class RuleWriter:
    """Writes the rules of a system.

    Args:
        system: The system, every consequent a term.
        dialect: The tool that is to read them.
        beyond_matlab: Whether MATLAB cannot read the file anyway.
        reasons: Takes the reasons why rules cannot be written.
        losses: Takes their losses.
    """

    system: FuzzySystem
    dialect: Dialect
    beyond_matlab: bool
    reasons: list[str]
    losses: list[Loss]

    def __post_init__(self) -> None:
        self._inputs = {v.name: v for v in self.system.inputs}
        self._powers = {h.name: power for h in self.system.hedges if (power := _exponent(h.expression)) is not None}

    def lines(self) -> Iterator[str]:
        """Yield the lines of all rules."""
        for i, rule in enumerate(self.system.rules, 1):
            where = f"rule {i}"
            connective, codes = self._antecedent(rule.antecedent, where)
            if not codes and self.dialect == "fuzzylite" and not self.reasons:
                # It reads no rule without a condition, and has a number for "any".
                some = next((v for v in self.system.inputs if v.terms), self.system.inputs[0])
                connective, codes = 1, {some.name: f"{ANY if connective == 1 else -ANY}"}
            conditions = " ".join(codes.get(name, "0") for name in self._inputs)
            conclusions = " ".join(self._consequent(o, rule, where) for o in self.system.outputs)
            yield f"{conditions}, {conclusions} ({number(self.system.number(rule.weight))}) : {connective}"

    def _antecedent(self, antecedent: Antecedent, where: str) -> tuple[int, dict[str, str]]:
        """Return the connective and the numbers of terms by variable."""
        connective = 2 if isinstance(antecedent, Or) else 1
        codes: dict[str, str] = {}
        for operand in _operands(antecedent, type(antecedent)):
            literal = _literal(operand)
            if literal is None:
                self.reasons.append(f"{where} mixes 'and', 'or' and 'not' of groups")
                continue
            if literal.hedges == ("any",) and connective == 1:
                continue
            if literal.variable in codes:
                self.reasons.append(f"{where} names '{literal.variable}' twice")
            if literal.variable not in self._inputs:
                self.reasons.append(f"{where} reads output '{literal.variable}'")
            elif literal.hedges == ("not", "any"):
                connective = 2
            else:
                variable = self._inputs[literal.variable]
                codes[literal.variable] = self._code(variable, literal.term, literal.hedges, where)
        return connective, codes

    def _consequent(self, output: Output, rule: Rule, where: str) -> str:
        consequents = [c for c in rule.consequents if c.output == output.name]
        if not consequents:
            return "0"
        if len(consequents) > 1:
            self.reasons.append(f"{where} sets '{output.name}' twice")
        return self._code(output, str(consequents[0].term), consequents[0].hedges, where)

    def _code(self, variable: LinguisticVariable, term: str, hedges: tuple[str, ...], where: str) -> str:
        place = [t.name for t in variable.terms].index(term) + 1
        sign = ""
        while hedges and hedges[0] == "not":
            sign, hedges = "" if sign else "-", hedges[1:]
        fraction = self._fraction(hedges)
        if fraction is None:
            self.reasons.append(f"{where} has the hedges '{' '.join(hedges)}'")
            return "0"
        if fraction and self.beyond_matlab:
            self.losses.append(Loss(where, f"hedges '{' '.join(hedges)}'", "MATLAB has none; Octave reads them"))
        return f"{sign}{place + fraction:f}" if fraction else f"{sign}{place}"

    def _fraction(self, hedges: tuple[str, ...]) -> Decimal | None:
        if not hedges or hedges in HEDGES:
            return HEDGES.get(hedges, Decimal(0))
        if len(hedges) == 1 and hedges[0] in self._powers and self.dialect != "fuzzylite":
            return self._powers[hedges[0]] / 10
        return None


def _operands(antecedent: Antecedent, kind: type[Antecedent]) -> Iterator[Antecedent]:
    """Yield the operands of a group, with those of groups of the same kind within it; else the antecedent itself."""
    if isinstance(antecedent, And | Or) and type(antecedent) is kind:
        for operand in antecedent.operands:
            yield from _operands(operand, kind)
    else:
        yield antecedent


def _literal(antecedent: Antecedent) -> Is | None:
    """Return a proposition, with `not` before it as its first hedge; None for a group."""
    hedges: tuple[str, ...] = ()
    while isinstance(antecedent, Not):
        hedges, antecedent = (*hedges, "not"), antecedent.operand
    if not isinstance(antecedent, Is):
        return None
    return antecedent.model_copy(update={"hedges": (*hedges, *antecedent.hedges)})


def _exponent(expression: Expr) -> Decimal | None:
    """Return k of a hedge x^k if the digits behind a point can say it."""
    match expression:
        case Binary(op="^", left=Name(), right=Number(value=value)):
            exponent = Decimal(repr(value))
            return exponent if 0 < exponent < 10 and exponent == round(exponent, 6) else None
    return None
