"""Fast path of the parser for the most frequent lines: block heads, table rows, terms, rules without parentheses.

The grammar reads them too, token by token and ten times slower; a test holds the two to each other. Whatever is not as
plain as this is left to the grammar, and with it every mistake.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Callable, Iterator
from typing import Any, Final

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.fast_path_expressions import NAME as _NAME
from fuzzyctl.lang.fast_path_expressions import NUMBER as _NUMBER
from fuzzyctl.lang.fast_path_expressions import NotPlainError, Reader, finite
from fuzzyctl.lang.lines import LineKind, LogicalLine

_END: Final = r"[ \t\r]*"
_STOP: Final = rf"{_END}\Z"
_PARAMETER: Final = rf"[ \t]*-?(?:{_NUMBER}|{_NAME})[ \t]*"

_HEADER: Final = re.compile(rf"[ \t]*{_NAME}(?:[ \t]+{_NAME})*{_END}")
_ROW: Final = re.compile(rf"[ \t]*({_NAME})?[ \t]*\|((?:[ \t]+(?:{_NAME}|-?{_NUMBER}|\.))+){_END}")
_CELL: Final = re.compile(r"[^ \t\r]+")
_TERM: Final = re.compile(rf"[ \t]*({_NAME})[ \t]*=[ \t]*({_NAME})[ \t]*\(({_PARAMETER}(?:,{_PARAMETER})*)\){_END}")
_FORMULA: Final = re.compile(rf"[ \t]*({_NAME})[ \t]*=[ \t]*({_NAME})[ \t]*(?=\()")
_STRING: Final = r'"([^"\n]*)"'
_TITLE: Final = re.compile(rf"[ \t]*(system)[ \t]+({_NAME})(?:[ \t]*{_STRING})?{_STOP}")
_SOURCE: Final = re.compile(rf"[ \t]*source[ \t]*{_STRING}{_STOP}")
_SETTING: Final = re.compile(rf"[ \t]*(and|or|implication|aggregation|defuzzifier)[ \t]+({_NAME}){_STOP}")
_UNIT: Final = rf"unit[ \t]*{_STRING}"
_BOUNDS: Final = rf"in[ \t]*([\[(])({_PARAMETER}),({_PARAMETER})([\])])"
_PARAM: Final = re.compile(rf"[ \t]*param[ \t]+({_NAME})(?:[ \t]+{_BOUNDS})?[ \t]*=([^\"#\n]*?)(?:\b{_UNIT})?{_STOP}")
_REQUIRE: Final = re.compile(r"[ \t]*require\b")
_VARIABLE: Final = re.compile(
    rf"[ \t]*(input|output)[ \t]+({_NAME})(?:[ \t]*{_STRING}[ \t]*|[ \t]+)in[ \t]*"
    rf"\[({_PARAMETER}),({_PARAMETER})\](?:[ \t]*(unit)[ \t]*({_STRING}))?"
    rf"(?:[ \t]*(else)[ \t]+(?:(-?{_NUMBER})|({_NAME})))?{_STOP}"
)
_LET: Final = re.compile(
    rf"[ \t]*(let)[ \t]+({_NAME})(?:[ \t]*{_STRING})?(?:[ \t]*\bin[ \t]*\[({_PARAMETER}),({_PARAMETER})\])?"
    rf"(?:[ \t]*\b(unit)[ \t]*({_STRING}))?[ \t]*="
)
_HEAD: Final = re.compile(rf"[ \t]*(controller|plant|loop)[ \t]+({_NAME})(?:[ \t]*{_STRING})?{_STOP}")
_USE: Final = re.compile(rf"[ \t]*use[ \t]*({_STRING}){_STOP}")
_EVERY: Final = re.compile(r"[ \t]*every\b")
_EQUATION: Final = re.compile(rf"[ \t]*(let|next|der|block)[ \t]+({_NAME})[ \t]*=")
_SIGNAL: Final = re.compile(
    rf"[ \t]*(input|output|state)[ \t]+({_NAME})(?:[ \t]*{_STRING})?(?:[ \t]*\b{_BOUNDS})?(?:[ \t]*\b{_UNIT})?"
    rf"(?:[ \t]*(=)|{_STOP})"
)
_MEASURE: Final = re.compile(rf"[ \t]*(measure)[ \t]+({_NAME})(?:[ \t]*{_STRING})?(?:[ \t]*\b{_UNIT})?[ \t]*=")
_TERMS: Final = re.compile(rf"[ \t]*terms((?:[ \t]+{_NAME})+){_STOP}")
_TABLE: Final = re.compile(rf"[ \t]*table[ \t]+({_NAME})[ \t]*=[ \t]*({_NAME})(?:[ \t]+x[ \t]+({_NAME}))?{_STOP}")
#: A name of a plain rule.
_PART: Final = rf"(?!(?:if|is|and|or|not|then|weight|linear|function|constant)\b){_NAME}"
_HEDGES: Final = rf"(?:(?:not\b|{_PART})[ \t]+){{0,95}}"
_IS: Final = rf"{_PART}[ \t]+is[ \t]+{_HEDGES}{_PART}"
_RULE: Final = re.compile(
    rf"[ \t]*if[ \t]+({_IS}(?:(?:[ \t]+and[ \t]+{_IS}){{0,90}}|(?:[ \t]+or[ \t]+{_IS}){{0,90}}))"
    rf"[ \t]+then[ \t]+({_IS}(?:[ \t]*,[ \t]*{_IS})*)(?:{_STOP}|[ \t]+weight[ \t]*(?:(-?{_NUMBER}){_STOP}|(?=\()))"
)
_PAIR: Final = re.compile(rf"({_PART})[ \t]+is[ \t]+({_HEDGES})({_PART})")
#: Operands and hedges count as levels; with more, the grammar looks whether they are too many.
_LEVELS: Final = 95
_WORD: Final = re.compile(_NAME)
_VALUE: Final = re.compile(rf"(-?)({_NUMBER}|{_NAME})")


def read(source: SourceText, line: LogicalLine, kind: LineKind) -> Any:
    """Return the node of a plain line, None for any other line."""
    try:
        return _read(source, line, kind)
    except (NotPlainError, RecursionError):  # of a caller that is itself deep in recursion
        return None


def _read(source: SourceText, line: LogicalLine, kind: LineKind) -> Any:
    text = source.text[line.start : line.end]
    whole = Span(source, line.start + len(text) - len(text.lstrip()), line.end)
    if kind == "header" and _HEADER.fullmatch(text):
        return sx.HeaderLine(whole, tuple(_word(source, line.start, m) for m in _WORD.finditer(text)))
    if kind == "row" and (row := _ROW.fullmatch(text)):
        label = None if row[1] is None else _word(source, line.start, row, 1)
        cells = tuple(_cell(source, line.start, m) for m in _CELL.finditer(text, *row.span(2)))
        return sx.RowLine(whole, label, cells)
    if kind == "term_line" and (term := _TERM.fullmatch(text)):
        return _term(source, line.start, whole, term)
    if kind == "term_line" and (formula := _FORMULA.match(text)):
        return _formula(source, line.start, whole, formula)
    statements = _BLOCK_STATEMENTS if kind == "block_statement" else _STATEMENTS if kind == "statement" else {}
    if statement := statements.get(line.word):
        form, build = statement
        found = form.match(text)
        return None if found is None else build(source, line.start, whole, found)
    return None


def _system(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.System:
    return sx.System(whole, _word(source, base, found, 2), _text(found[3]))


def _citation(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.Citation:
    return sx.Citation(whole, _text(found[1]))


def _setting(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.Setting:
    return sx.Setting(whole, _word(source, base, found, 1), _word(source, base, found, 2), ())


def _param(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.Param:
    reader = Reader(source, base + found.start(6), base + found.end(6))
    value = reader.sum()
    _require_end(reader)
    return sx.Param(whole, _word(source, base, found, 1), value, _text(found[7]), _bounds(source, base, found, 2))


def _bounds(source: SourceText, base: int, found: re.Match[str], first: int) -> sx.Bounds | None:
    """Return a range that is written in four groups; None where there is none."""
    if found[first] is None:
        return None
    lower, upper = _number(source, base, found, first + 1), _number(source, base, found, first + 2)
    place = Span(source, base + found.start(first), base + found.end(first + 3))
    return sx.Bounds(lower, upper, found[first] == "(", found[first + 3] == ")", place)


def _head(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.Head:
    return sx.Head(whole, _word(source, base, found, 1), _word(source, base, found, 2), _text(found[3]))


def _use(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.Use:
    return sx.Use(whole, _text(found[2]), _at(source, base, found, 1))


def _every(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.Every:
    reader = Reader(source, base + found.end(), whole.end)
    period = reader.sum()
    _require_end(reader)
    return sx.Every(whole, period)


def _equation(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.Equation:
    value = _claim(source, base + found.end(), whole.end)
    return sx.Equation(whole, _word(source, base, found, 1), _word(source, base, found, 2), value)


def _signal(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.Signal:
    if (found[1] == "input") != (found[9] is None):
        raise NotPlainError
    value = None if found[9] is None else _claim(source, base + found.end(), whole.end)
    keyword, name = _word(source, base, found, 1), _word(source, base, found, 2)
    return sx.Signal(whole, keyword, name, _text(found[3]), _bounds(source, base, found, 4), _text(found[8]), value)


def _measure(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.Signal:
    keyword, name = _word(source, base, found, 1), _word(source, base, found, 2)
    value = _claim(source, base + found.end(), whole.end)
    return sx.Signal(whole, keyword, name, _text(found[3]), None, _text(found[4]), value)


def _claim(source: SourceText, start: int, end: int) -> ex.Expr:
    """Return the expression or condition that ends a line."""
    reader = Reader(source, start, end)
    value = reader.claim()
    _require_end(reader)
    return value


def _guarantee(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.Require:
    reader = Reader(source, base + found.end(), whole.end)
    claim = reader.claim()
    within = when = None
    if reader.name == "within":
        reader.advance()
        within = reader.sum()
    if reader.name == "when":
        reader.advance()
        when = reader.claim()
    _require_end(reader)
    return sx.Require(whole, claim, within, when)


def _require_end(reader: Reader) -> None:
    if not reader.at_end:
        raise NotPlainError


def _variable(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.Variable:
    lower, upper = _number(source, base, found, 4), _number(source, base, found, 5)
    clauses = _unit_clause(source, base, found, 6)
    if found[9] is not None:
        value = _word(source, base, found, 11) if found[10] is None else _number(source, base, found, 10)
        clauses = (
            *clauses,
            sx.FallbackClause(value, Span(source, base + found.start(9), base + found.end(found.lastindex or 0))),
        )
    keyword, name = _word(source, base, found, 1), _word(source, base, found, 2)
    return sx.Variable(whole, keyword, name, _text(found[3]), lower, upper, clauses)


def _let(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.Variable:
    lower: ex.Expr = ex.Number(-math.inf)
    upper: ex.Expr = ex.Number(math.inf)
    ranged = found[4] is not None
    if ranged:
        lower, upper = _number(source, base, found, 4), _number(source, base, found, 5)
    clauses = _unit_clause(source, base, found, 6)
    value = _claim(source, base + found.end(), whole.end)
    keyword, name = _word(source, base, found, 1), _word(source, base, found, 2)
    label = _text(found[3])
    return sx.Variable(whole, keyword, name, label, lower, upper, clauses, value=value, ranged=ranged)


def _unit_clause(source: SourceText, base: int, found: re.Match[str], first: int) -> tuple[sx.Clause, ...]:
    """Return what is written in three groups: the word `unit`, the unit in quotes, its text."""
    if found[first] is None:
        return ()
    place = Span(source, base + found.start(first), base + found.end(first + 1))
    return (sx.UnitClause(_text(found[first + 2]), place),)


def _partition(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.TermsLine:
    words = (_word(source, base, m) for m in _WORD.finditer(found.string, *found.span(1)))
    return sx.TermsLine(whole, tuple(sx.PartitionItem(w, None, None) for w in words))


def _table(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.Table:
    second = None if found[3] is None else _word(source, base, found, 3)
    return sx.Table(whole, (_word(source, base, found, 1),), _word(source, base, found, 2), second, "", None)


def _rule(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.Rule:
    operands = tuple(
        sx.Literal(variable.span.to(term.span), variable, hedges, term)
        for variable, hedges, term in _pairs(source, base, found, 1)
    )
    if len(operands) + max(len(o.hedges) for o in operands) > _LEVELS:
        raise NotPlainError
    antecedent: sx.Truth = operands[0]
    if len(operands) > 1:
        between = found.string[operands[0].span.end - base : operands[1].span.start - base]
        antecedent = sx.Chain(operands[0].span.to(operands[-1].span), between.strip(), operands)
    consequents = tuple(
        sx.ConsequentText(output, term, hedges) for output, hedges, term in _pairs(source, base, found, 2)
    )
    return sx.Rule(whole, antecedent, consequents, _weight(source, base, whole, found))


def _weight(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> ex.Expr | None:
    if found[3] is not None:
        return _number(source, base, found, 3)
    if base + found.end() == whole.end:
        return None
    reader = Reader(source, base + found.end(), whole.end)
    value = reader.parenthesis()
    _require_end(reader)
    return value


def _pairs(
    source: SourceText, base: int, found: re.Match[str], group: int
) -> Iterator[tuple[sx.Word, tuple[sx.Word, ...], sx.Word]]:
    """Yield variables with the hedges and names of their terms."""
    for pair in _PAIR.finditer(found.string, *found.span(group)):
        hedges = tuple(_word(source, base, m) for m in _WORD.finditer(found.string, *pair.span(2)))
        yield _word(source, base, pair, 1), hedges, _word(source, base, pair, 3)


#: By the first word of a statement what a plain one looks like, and what it is.
_STATEMENTS: Final[dict[str, tuple[re.Pattern[str], Callable[[SourceText, int, Span, re.Match[str]], Any]]]] = {
    "system": (_TITLE, _system),
    "source": (_SOURCE, _citation),
    **dict.fromkeys(("and", "or", "implication", "aggregation", "defuzzifier"), (_SETTING, _setting)),
    "param": (_PARAM, _param),
    **dict.fromkeys(("input", "output"), (_VARIABLE, _variable)),
    "let": (_LET, _let),
    "require": (_REQUIRE, _guarantee),
    "terms": (_TERMS, _partition),
    "table": (_TABLE, _table),
    "if": (_RULE, _rule),
    "use": (_USE, _use),
}

#: The same of the lines of controllers, plants and loops.
_BLOCK_STATEMENTS: Final = {
    "every": (_EVERY, _every),
    **dict.fromkeys(("let", "next", "der", "block"), (_EQUATION, _equation)),
    **dict.fromkeys(("input", "output", "state"), (_SIGNAL, _signal)),
    "measure": (_MEASURE, _measure),
    **{word: _STATEMENTS[word] for word in ("system", "source", "use", "param", "require")},
    **dict.fromkeys(sx.HEADS, (_HEAD, _head)),
}


def _text(found: str | None) -> str:
    return "" if found is None else unicodedata.normalize("NFC", found)


def _number(source: SourceText, base: int, found: re.Match[str], group: int) -> ex.Expr:
    value = _VALUE.search(found.string, *found.span(group))
    assert value is not None, "the form of the line holds one"
    return _value(source, base, value, _at(source, base, value))


def _at(source: SourceText, base: int, found: re.Match[str], group: int = 0) -> Span:
    first, last = found.span(group)
    return Span(source, base + first, base + last)


def _word(source: SourceText, base: int, found: re.Match[str], group: int = 0) -> sx.Word:
    first, last = found.span(group)
    return sx.Word(found[group], Span(source, base + first, base + last))


def _cell(source: SourceText, base: int, found: re.Match[str]) -> sx.CellText:
    first, last = found.span()
    place = Span(source, base + first, base + last)
    text = found[0]
    if text == ".":
        return sx.CellText((), None, place)
    if text[0].isalpha() or text[0] == "_":
        return sx.CellText((sx.Word(text, place),), None, place)
    number = _VALUE.fullmatch(text)
    assert number is not None, "the form of the line holds one"
    return sx.CellText((_value(source, base + first, number, place),), None, place)


def _term(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.TermLine:
    arguments = []
    for value in _VALUE.finditer(found.string, *found.span(3)):
        place = _at(source, base, value)
        arguments.append(sx.Argument(_value(source, base, value, place), None, place))
    name, kind = _word(source, base, found, 1), _word(source, base, found, 2)
    return sx.TermLine(whole, name, kind, tuple(arguments))


def _formula(source: SourceText, base: int, whole: Span, found: re.Match[str]) -> sx.TermLine:
    """Return a term whose parameters are expressions."""
    reader = Reader(source, base + found.end(), whole.end)
    arguments: list[sx.Argument] = []
    while not arguments or reader.sign == ",":
        reader.advance()
        value = reader.sum()
        arguments.append(sx.Argument(value, None, ex.span_of(value) or whole))
    reader.expect(")")
    _require_end(reader)
    name, kind = _word(source, base, found, 1), _word(source, base, found, 2)
    return sx.TermLine(whole, name, kind, tuple(arguments))


def _value(source: SourceText, base: int, found: re.Match[str], place: Span) -> ex.Expr:
    """Return a parameter."""
    sign, text = found[1], found[2]
    if not (text[0].isdigit() or text[0] == "."):
        name = ex.Name(text, _at(source, base, found, 2))
        return ex.Negate(name, place) if sign else name
    value = finite(text)
    return ex.Number(-value if sign else value, sign + text, place)
