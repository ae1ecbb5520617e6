"""Parser of FCL rules: IF condition THEN conclusions WITH weight."""

from __future__ import annotations

from typing import Final

from fuzzyctl.expr import Expr
from fuzzyctl.formats.common.report import ParseError
from tests.oracles.fcl.cursor import MAX_DEPTH, Cursor
from tests.oracles.fcl.syntax import Clause, Condition, Joined, Negated, RuleLine, Word

#: Keywords that begin a statement of a RULEBLOCK, or end it.
RULE_STARTS: Final = ("RULE", "END_RULEBLOCK", "ACCU", "ACT", "ENABLED", "ACTIVATION", "END_FUNCTION_BLOCK")

#: Those of them that are no names of terms, wherever they stand on a line.
_NO_TERMS: Final = ("RULE", "END_RULEBLOCK", "END_FUNCTION_BLOCK")

#: Words that end the hedges and the term of a clause.
_STOPS: Final = frozenset({"AND", "OR", "THEN", "WITH", "IF", "IS"})


def rule(cursor: Cursor) -> RuleLine:
    """Take a rule whose keyword RULE comes next."""
    first = cursor.take()
    name = _rule_name(cursor)
    cursor.expect("IF", what="IF")
    condition = _condition(cursor, 0)
    cursor.expect("THEN", what="AND, OR or THEN")
    conclusions = [_conclusion(cursor)]
    while cursor.accept(",", "AND"):
        conclusions.append(_conclusion(cursor))
    weight: Expr | None = None
    if cursor.accept("WITH"):
        weight = cursor.value()
        if weight is None:
            raise cursor.unexpected("a weight")
    return RuleLine(name, condition, tuple(conclusions), weight, cursor.span(first))


def _rule_name(cursor: Cursor) -> str:
    """Take everything up to the colon; a missing one is no loss where IF follows."""
    words: list[str] = []
    while cursor.here.text != ":" and cursor.here.word != "IF":
        if cursor.here.kind == "end" or cursor.here.text == ";" or len(words) > 20:
            raise cursor.unexpected("':' and IF")
        words.append(cursor.take().text)
    cursor.accept(":")
    return " ".join(words)


def _condition(cursor: Cursor, depth: int) -> Condition:
    first = cursor.here
    operands, operators = [_operand(cursor, depth)], []
    while (token := cursor.accept("AND", "OR")) is not None:
        operators.append(Word(token.text, cursor.span(token, token)))
        operands.append(_operand(cursor, depth))
    return operands[0] if not operators else Joined(tuple(operands), tuple(operators), cursor.span(first))


def _operand(cursor: Cursor, depth: int) -> Condition:
    token = cursor.here
    if depth >= MAX_DEPTH:
        message = f"conditions are nested more than {MAX_DEPTH} deep"
        raise ParseError(message, cursor.span(token, token), "FZ106")
    if token.word == "NOT" and cursor.after.word != "IS":
        cursor.take()
        return Negated(_operand(cursor, depth + 1), cursor.span(token))
    if cursor.accept("("):
        inside = _condition(cursor, depth + 1)
        cursor.expect(")", what="AND, OR or ')'")
        return inside
    return _clause(cursor, "a condition such as 'x IS low'")


def _conclusion(cursor: Cursor) -> Clause:
    depth = 0
    while cursor.accept("("):
        depth += 1
    clause = _clause(cursor, "a conclusion such as 'y IS high'")
    for _ in range(depth):
        cursor.expect(")", what="')'")
    return clause


def _clause(cursor: Cursor, what: str) -> Clause:
    first = cursor.here
    variable = cursor.name(what)
    cursor.expect("IS", what="IS")
    words = [cursor.name("a term")]
    while cursor.here.kind == "name" and cursor.here.word not in _STOPS and not _begins_statement(cursor):
        if cursor.after.word == "IS":
            break  # the variable of a clause whose AND, OR or THEN is missing
        words.append(cursor.name("a term"))
        if len(words) > MAX_DEPTH:
            message = f"a term has more than {MAX_DEPTH} hedges"
            raise ParseError(message, cursor.span(first), "FZ106")
    return Clause(variable, tuple(words), cursor.span(first))


def _begins_statement(cursor: Cursor) -> bool:
    """Whether the next token begins a statement, for rules that lack their semicolon."""
    token = cursor.here
    return token.word in RULE_STARTS and (token.first or token.word in _NO_TERMS)
