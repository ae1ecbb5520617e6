"""Fragments of `.fz` text as parts of a model: what Python authors write as texts reads as it does in a file."""

from __future__ import annotations

import re
from typing import Final

from fuzzyctl.errors import ArgumentError, DiagnosticError
from fuzzyctl.expr import ONE, Call, Expr
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.parser import parse
from fuzzyctl.model.guarantee import Guarantee, Hedge
from fuzzyctl.model.rule import And, Antecedent, Cell, Consequent, Is, Not, Or, Rule
from fuzzyctl.model.variable import Membership
from fuzzyctl.source import SourceText

#: A text that begins like a membership function or another consequent: a kind and its parameters.
_KIND: Final = re.compile(r"\s*[^\W\d]\w*\s*\(.*\)\s*", re.DOTALL)


def statement(text: str, shown: str) -> sx.Statement:
    """Parse one statement; `shown` stands for a file name in diagnostics.

    Raises:
        DiagnosticError: For a text that is none.
        ArgumentError: For several.
    """
    tree, mistakes = parse(SourceText(f"<{shown}>", text))
    if mistakes:
        raise DiagnosticError(mistakes)
    if len(tree.statements) != 1:
        raise ArgumentError(f"one {shown} is due, got {len(tree.statements)}")
    return tree.statements[0]


def expression(text: str) -> Expr:
    """Parse an expression such as `(k - 1) / 2`."""
    found = statement(f"param _ = {text}", text)
    if not isinstance(found, sx.Param) or found.unit:
        raise ArgumentError(f"{text!r} is no expression")
    return found.expression


def membership(text: str) -> Membership | None:
    """Parse a kind with its parameters in order, such as `triangle(0, 1, 2)`; None for an expression."""
    found = expression(text) if _KIND.fullmatch(text) else None
    if not isinstance(found, Call):
        return None
    if found.function not in (*MEMBERSHIP, "linear", "function"):
        return None
    return Membership(kind=found.function, arguments=found.arguments)


def rule(text: str) -> Rule:
    """Parse a rule such as `if a is NB then f is NS weight 0.5`."""
    found = statement(text, "rule")
    if not isinstance(found, sx.Rule):
        raise ArgumentError(f"{text!r} is no rule")
    consequents = []
    for c in found.consequents:
        term = c.term.text if isinstance(c.term, sx.Word) else _function(c.term)
        consequents.append(Consequent(output=c.output.text, term=term))
    return Rule(antecedent=_antecedent(found.antecedent), consequents=tuple(consequents), weight=found.weight or ONE)


def antecedent(text: str) -> Antecedent:
    """Parse what stands between `if` and `then`, or behind `with`."""
    found = statement(f"if {text} then _ is _", text)
    if not isinstance(found, sx.Rule) or len(found.consequents) != 1:
        raise ArgumentError(f"{text!r} is no antecedent")
    return _antecedent(found.antecedent)


def cells(text: str) -> tuple[Cell, ...]:
    """Parse the cells of one table row, such as `NB PS*0.5 . NB/PB 0.25 linear(1, 2, 3)`."""
    found = statement(f"table _ = _\n  _\n  | {text}", text)
    if not isinstance(found, sx.Table) or len(found.rows) != 1:
        raise ArgumentError(f"{text!r} is no table row")
    return tuple(_cell(c) for c in found.rows[0].cells)


def guarantee(text: str) -> Guarantee:
    """Parse what stands behind `require`."""
    found = statement(f"require {text}", text)
    if not isinstance(found, sx.Require):
        raise ArgumentError(f"{text!r} is no guarantee")
    return Guarantee(claim=found.claim, within=found.within, when=found.when)


def hedge(name: str, text: str) -> Hedge:
    """Parse a hedge as an expression over `x`, such as `x ^ 3`."""
    return Hedge(name=name, parameter="x", expression=expression(text))


def _cell(cell: sx.CellText) -> Cell:
    return Cell(terms=tuple(_cell_term(t) for t in cell.terms), weight=cell.weight or ONE)


def _cell_term(term: sx.ConsequentTerm) -> str | Membership:
    match term:
        case sx.Word():
            return term.text
        case sx.FunctionTerm():
            return _function(term)
    return Membership(kind="constant", arguments=(term,))


def _function(term: sx.FunctionTerm) -> Membership:
    return Membership(kind=term.kind.text, arguments=term.arguments)


def _antecedent(truth: sx.Truth) -> Antecedent:
    match truth:
        case sx.Literal(variable=variable, hedges=hedges, term=term):
            return Is(variable=variable.text, term=term.text, hedges=tuple(h.text for h in hedges))
        case sx.Negation(operand=operand):
            return Not(operand=_antecedent(operand))
        case sx.Group(operand=operand):
            return _antecedent(operand)
        case sx.Chain(connective=connective, operands=operands):
            parts = tuple(_antecedent(o) for o in operands)
            return And(operands=parts) if connective == "and" else Or(operands=parts)
    raise TypeError(type(truth).__name__)
