"""Writer of `.fis` rules: a number for each variable, with digits behind its point for hedges."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal

from fuzzyctl.expr import Binary, Expr, Name, Number
from fuzzyctl.formats.fis.memberships import number
from fuzzyctl.formats.fis.vocabulary import HEDGES, Dialect
from fuzzyctl.formats.losses import Loss
from fuzzyctl.model.rule import And, Antecedent, Consequent, Is, Not, Or, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable, Output


class WrittenRules:
    """The rules of a system.

    Args:
        system: The system, every consequent a term.
        dialect: Of the tool that is to read them.
        beyond_matlab: Whether it has what MATLAB cannot read anyway.
        reasons: Takes why they cannot be written.
        losses: Takes what they do not say.
    """

    def __init__(
        self, system: FuzzySystem, dialect: Dialect, beyond_matlab: bool, reasons: list[str], losses: list[Loss]
    ) -> None:
        self._system, self._dialect, self._beyond_matlab = system, dialect, beyond_matlab
        self._reasons, self._losses = reasons, losses
        self._powers = {h.name: power for h in system.hedges if (power := _power(h.expression)) is not None}

    def line(self, i: int, rule: Rule) -> str:
        """Return the line of a rule; `i` counts from 1."""
        where = f"rule {i}"
        connective, codes = self._antecedent(rule.antecedent, where)
        if not codes and self._dialect == "fuzzylite" and not self._reasons:
            # It reads no rule without a condition, and has a number for "any".
            connective, codes = 1, {self._some_input(): "0.99" if connective == 1 else "-0.99"}
        if_part = " ".join(codes.get(v.name, "0") for v in self._system.inputs)
        then_part = " ".join(self._consequent(o, rule, where) for o in self._system.outputs)
        return f"{if_part}, {then_part} ({number(self._system.number(rule.weight))}) : {connective}"

    def _some_input(self) -> str:
        return next((v for v in self._system.inputs if v.terms), self._system.inputs[0]).name

    def _antecedent(self, antecedent: Antecedent, where: str) -> tuple[int, dict[str, str]]:
        """Return the connective and the numbers of terms by variable."""
        connective = 2 if isinstance(antecedent, Or) else 1
        operands = antecedent.operands if isinstance(antecedent, And | Or) else (antecedent,)
        codes: dict[str, str] = {}
        for operand in _flat(operands, type(antecedent)):
            literal = _literal(operand)
            if literal is None:
                self._reasons.append(f"{where} mixes 'and', 'or' and 'not' of groups")
                continue
            if literal.hedges == ("any",) and connective == 1:
                continue
            if literal.variable in codes:
                self._reasons.append(f"{where} names '{literal.variable}' twice")
            if literal.variable not in [v.name for v in self._system.inputs]:
                self._reasons.append(f"{where} reads output '{literal.variable}'")
                continue
            if literal.hedges == ("not", "any"):
                connective = 2
                continue
            variable = self._system.input(literal.variable)
            codes[literal.variable] = self._code(variable, literal.term, literal.hedges, where)
        return connective, codes

    def _consequent(self, output: Output, rule: Rule, where: str) -> str:
        found = [c for c in rule.consequents if c.output == output.name]
        if not found:
            return "0"
        if len(found) > 1:
            self._reasons.append(f"{where} sets '{output.name}' twice")
        first: Consequent = found[0]
        assert isinstance(first.term, str)
        return self._code(output, first.term, first.hedges, where)

    def _code(self, variable: LinguisticVariable, term: str, hedges: tuple[str, ...], where: str) -> str:
        place = [t.name for t in variable.terms].index(term) + 1
        sign = ""
        while hedges and hedges[0] == "not":
            sign, hedges = "" if sign else "-", hedges[1:]
        fraction = self._fraction(hedges)
        if fraction is None:
            self._reasons.append(f"{where} has the hedges '{' '.join(hedges)}'")
            return "0"
        if fraction and self._beyond_matlab:
            self._losses.append(Loss(where, f"hedges '{' '.join(hedges)}'", "MATLAB has none; Octave reads them"))
        return f"{sign}{place + fraction:f}" if fraction else f"{sign}{place}"

    def _fraction(self, hedges: tuple[str, ...]) -> Decimal | None:
        if not hedges or hedges in HEDGES:
            return HEDGES.get(hedges, Decimal(0))
        if len(hedges) == 1 and hedges[0] in self._powers and self._dialect != "fuzzylite":
            return self._powers[hedges[0]] / 10
        return None


def _flat(operands: tuple[Antecedent, ...], kind: type[Antecedent]) -> Iterator[Antecedent]:
    """Yield the operands of a group, those of groups of the same kind within it as its own."""
    for operand in operands:
        if isinstance(operand, And | Or) and type(operand) is kind:
            yield from _flat(operand.operands, kind)
        else:
            yield operand


def _literal(antecedent: Antecedent) -> Is | None:
    """Return a proposition, with `not` before it as its first hedge; None for a group."""
    hedges: tuple[str, ...] = ()
    while isinstance(antecedent, Not):
        hedges, antecedent = (*hedges, "not"), antecedent.operand
    if not isinstance(antecedent, Is):
        return None
    return antecedent.model_copy(update={"hedges": (*hedges, *antecedent.hedges)})


def _power(expression: Expr) -> Decimal | None:
    """Return k for a hedge x^k that the digits behind a point can say."""
    match expression:
        case Binary(op="^", left=Name(), right=Number(value=exponent)):
            found = Decimal(repr(exponent))
            return found if 0 < found < 10 and found == round(found, 6) else None
    return None
