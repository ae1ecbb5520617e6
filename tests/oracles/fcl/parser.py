"""Parser of FCL: function blocks from tokens; an error discards one statement, and all errors are reported."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.expr import Expr
from fuzzyctl.formats.common.report import ParseError
from tests.oracles.fcl.conditions import RULE_STARTS, rule
from tests.oracles.fcl.cursor import Cursor
from tests.oracles.fcl.formula import formula
from tests.oracles.fcl.names import SHAPE_WORDS
from tests.oracles.fcl.syntax import (
    Declaration,
    FunctionBlock,
    FuzzyBlock,
    Range,
    RuleBlock,
    RuleLine,
    Setting,
    Shape,
    TermLine,
    VariableBlock,
    Word,
)

_VARIABLES: Final = ("VAR_INPUT", "VAR_OUTPUT", "VAR", "VAR_IN_OUT")
_FUZZY: Final = ("FUZZIFY", "DEFUZZIFY")
_ENDS: Final = {
    **dict.fromkeys(_VARIABLES, "END_VAR"),
    "FUZZIFY": "END_FUZZIFY",
    "DEFUZZIFY": "END_DEFUZZIFY",
    "RULEBLOCK": "END_RULEBLOCK",
    "OPTIONS": "END_OPTIONS",
    "OPTION": "END_OPTION",
}
_BLOCKS: Final = (*_VARIABLES, *_FUZZY, "RULEBLOCK", "OPTIONS", "OPTION", "FUNCTION_BLOCK", "END_FUNCTION_BLOCK")
_CLOSERS: Final = tuple(dict.fromkeys(_ENDS.values()))
_FUZZY_STARTS: Final = ("TERM", "RANGE", "METHOD", "ACCU", "DEFAULT", "LOCK", "ENABLED")
_RULE_SETTINGS: Final = ("AND", "OR", "ACT", "ACCU", "ENABLED", "ACTIVATION")


@dataclass(frozen=True)
class FclFile:
    """What a file says.

    Args:
        blocks: Its function blocks.
        comments: Its comments with their marks.
        diagnostics: Mistakes of syntax.
    """

    blocks: tuple[FunctionBlock, ...]
    comments: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]


def parse(source: SourceText) -> FclFile:
    """Return what a source says, as far as it can be read, with all mistakes of syntax."""
    cursor = Cursor(source)
    blocks: list[FunctionBlock] = []
    while cursor.here.kind != "end":
        if cursor.here.word in ("FUNCTION_BLOCK", *_BLOCKS) and cursor.here.word != "END_FUNCTION_BLOCK":
            blocks.append(_function_block(cursor))
        else:
            cursor.report(cursor.unexpected("FUNCTION_BLOCK"), _BLOCKS)
            cursor.accept("END_FUNCTION_BLOCK")
    if not blocks and not cursor.diagnostics:
        help_text = "begin with FUNCTION_BLOCK and a name"
        cursor.diagnostics.append(
            Diagnostic("FZ004", "the file has no FUNCTION_BLOCK", file=source.name, help=help_text)
        )
    return FclFile(tuple(blocks), cursor.comments, tuple(cursor.diagnostics))


def _function_block(cursor: Cursor) -> FunctionBlock:
    first = cursor.here
    name = ""
    if cursor.accept("FUNCTION_BLOCK"):
        words = cursor.rest_of_line((*_VARIABLES, *_FUZZY, "RULEBLOCK", "END_FUNCTION_BLOCK"))
        name = cursor.span(words[0], words[-1]).text if words else ""
        if not words and cursor.here.kind == "name" and cursor.here.word not in _BLOCKS:
            name = cursor.take().text
    else:
        cursor.diagnostics.append(cursor.unexpected("FUNCTION_BLOCK").diagnostic)
    variables: list[VariableBlock] = []
    fuzzy: list[FuzzyBlock] = []
    rules: list[RuleBlock] = []
    while cursor.here.word not in ("END_FUNCTION_BLOCK", "FUNCTION_BLOCK") and cursor.here.kind != "end":
        word = cursor.here.word
        if word in _VARIABLES:
            variables.append(_variable_block(cursor))
        elif word in _FUZZY:
            fuzzy.append(_fuzzy_block(cursor))
        elif word == "RULEBLOCK":
            rules.append(_rule_block(cursor))
        elif word in ("OPTIONS", "OPTION"):
            _options(cursor)
        else:
            cursor.report(cursor.unexpected("a block", _BLOCKS[:-2]), _BLOCKS)
    if not cursor.accept("END_FUNCTION_BLOCK"):
        cursor.diagnostics.append(cursor.unexpected("END_FUNCTION_BLOCK").diagnostic)
    cursor.accept(";")
    return FunctionBlock(name.strip(" ;"), tuple(variables), tuple(fuzzy), tuple(rules), cursor.span(first, first))


def _statements(cursor: Cursor, opening: str, starts: tuple[str, ...], statement: Callable[[], None]) -> None:
    """Take statements up to the end of a block, one after the other."""
    closing = _ENDS[opening]
    stops = (*starts, *_CLOSERS, *_BLOCKS)
    while not cursor.accept(closing):
        if cursor.here.kind == "end" or cursor.here.word in _CLOSERS or _is_block(cursor):
            cursor.diagnostics.append(cursor.unexpected(closing).diagnostic)
            if cursor.here.word in _CLOSERS:
                cursor.take()
            break
        start = cursor.here
        try:
            statement()
            cursor.end_statement(stops)
        except ParseError as error:
            if cursor.here is start:
                cursor.take()  # else the keyword where it begins would end the search for the next statement
            cursor.report(error, stops)
    cursor.accept(";")


def _is_block(cursor: Cursor) -> bool:
    """Whether a block begins here; a variable may have the name of one."""
    return cursor.here.word in _BLOCKS and cursor.after.text not in (":", ",", ":=")


def _variable_block(cursor: Cursor) -> VariableBlock:
    keyword = _keyword(cursor)
    declarations: list[Declaration] = []

    def statement() -> None:
        if cursor.here.word == "RANGE" and cursor.after.text in (":=", ":", "=") and declarations:
            last = declarations.pop()
            declarations.append(Declaration(last.name, last.initial, _range(cursor)))
        else:
            declarations.extend(_declarations(cursor))

    _statements(cursor, keyword.upper, (), statement)
    return VariableBlock(keyword, tuple(declarations))


def _keyword(cursor: Cursor) -> Word:
    token = cursor.take()
    return Word(token.text, cursor.span(token, token))


def _declarations(cursor: Cursor) -> list[Declaration]:
    """Take `a, b : REAL := 5`; the type has no effect on a fuzzy system."""
    names = [cursor.name("a variable")]
    while cursor.accept(","):
        names.append(cursor.name("a variable"))
    cursor.expect(":", what="':' and a type such as REAL")
    cursor.name("a type such as REAL")
    initial: Expr | None = None
    if cursor.accept(":=", "="):
        initial = cursor.value()
        if initial is None:
            raise cursor.unexpected("a number")
    return [Declaration(name, initial) for name in names]


def _fuzzy_block(cursor: Cursor) -> FuzzyBlock:
    keyword = _keyword(cursor)
    variable = Word("", keyword.span)
    try:
        variable = cursor.name("a variable")
        cursor.accept(";")
    except ParseError as error:
        cursor.diagnostics.append(error.diagnostic)
    terms: list[TermLine] = []
    settings: list[Setting] = []
    ranges: list[Range] = []

    def statement() -> None:
        if cursor.here.word == "TERM":
            terms.append(_term(cursor))
        elif cursor.here.word == "RANGE":
            _once(cursor, bool(ranges))
            ranges.append(_range(cursor))
        elif cursor.here.word in _FUZZY_STARTS:
            _once(cursor, cursor.here.word in {s.keyword.upper for s in settings})
            settings.append(_setting(cursor))
        else:
            raise cursor.unexpected("a statement", (*_FUZZY_STARTS, _ENDS[keyword.upper]))

    _statements(cursor, keyword.upper, _FUZZY_STARTS, statement)
    return FuzzyBlock(keyword, variable, tuple(terms), tuple(settings), ranges[0] if ranges else None)


def _once(cursor: Cursor, again: bool) -> None:
    if again:
        token = cursor.here
        message = f"{token.word} is given twice in this block"
        raise ParseError(message, cursor.span(token, token), "FZ215", help="keep one of them")


def _term(cursor: Cursor) -> TermLine:
    first = cursor.take()
    name = cursor.name("the name of a term")
    cursor.expect(":=", ":", "=", what="':='")
    shape = _shape(cursor)
    return TermLine(name, shape, cursor.span(first))


def _shape(cursor: Cursor) -> Shape:
    first = cursor.here
    kind: Word | None = None
    if first.kind == "name" and (first.word in SHAPE_WORDS or not _ends_here(cursor)):
        kind = _keyword(cursor)
    if kind is not None and kind.upper == "FUNCTION":
        expression = formula(cursor)
        return Shape(kind, (), False, expression, cursor.span(first))
    if cursor.here.text == "(":
        arguments = _points(cursor)
        return Shape(kind, tuple(arguments), True, None, cursor.span(first))
    arguments = _arguments(cursor)
    if kind is None and not arguments:
        raise cursor.unexpected("a number, points such as (0, 1) or a shape", SHAPE_WORDS)
    return Shape(kind, tuple(arguments), False, None, cursor.span(first))


def _ends_here(cursor: Cursor) -> bool:
    """Whether a statement of one token ends behind the next one."""
    return cursor.after.text == ";" or cursor.after.first


def _arguments(cursor: Cursor) -> list[Expr]:
    found: list[Expr] = []
    while not cursor.here.first and (value := cursor.value()) is not None:
        found.append(value)
        cursor.accept(",")
    return found


def _points(cursor: Cursor) -> list[Expr]:
    """Take points `(x, y)`, as coordinates one after the other."""
    found: list[Expr] = []
    while cursor.accept("("):
        for closing in (",", ")"):
            value = cursor.value()
            if value is None:
                raise cursor.unexpected("a number")
            found.append(value)
            cursor.expect(closing, what=f"'{closing}'")
        cursor.accept(",")
    return found


def _range(cursor: Cursor) -> Range:
    first = cursor.take()
    cursor.expect(":=", ":", "=", what="':='")
    cursor.expect("(", what="'('")
    low = cursor.value()
    cursor.expect("..", "...", ",", what="'..'")
    high = cursor.value()
    cursor.expect(")", what="')'")
    if low is None or high is None:
        message = "a range has two ends"
        raise ParseError(message, cursor.span(first), help="write, for example: RANGE := (0 .. 10);")
    return Range(low, high, cursor.span(first))


def _setting(cursor: Cursor) -> Setting:
    first = cursor.here
    keyword = _keyword(cursor)
    cursor.expect(":", ":=", "=", what="':'")
    values: list[Word | Expr] = [_setting_value(cursor)]
    while cursor.accept("|"):
        values.append(_setting_value(cursor))
    return Setting(keyword, tuple(values), cursor.span(first))


def _setting_value(cursor: Cursor) -> Word | Expr:
    if cursor.here.kind == "name" and cursor.here.word not in ("NAN", "INF"):
        return cursor.name("a value")
    value = None if cursor.here.first else cursor.value()
    if value is None:
        raise cursor.unexpected("a value")
    return value


def _rule_block(cursor: Cursor) -> RuleBlock:
    keyword = _keyword(cursor)
    words: list[str] = []
    while not cursor.here.first and cursor.here.kind != "end" and cursor.after.text not in (":", ":="):
        words.append(cursor.take().text)
    settings: list[Setting] = []
    rules: list[RuleLine] = []

    def statement() -> None:
        if cursor.here.word == "RULE":
            rules.append(rule(cursor))
        elif cursor.here.word in _RULE_SETTINGS:
            settings.append(_setting(cursor))
        else:
            raise cursor.unexpected("a statement", ("RULE", *_RULE_SETTINGS, "END_RULEBLOCK"))

    _statements(cursor, "RULEBLOCK", RULE_STARTS, statement)
    return RuleBlock(" ".join(words), tuple(settings), tuple(rules), keyword.span)


def _options(cursor: Cursor) -> None:
    """Skip a block of options, whose meaning the standard leaves to each tool."""
    keyword = _keyword(cursor)
    closing = _ENDS[keyword.upper]
    while cursor.here.kind != "end" and cursor.here.word not in (closing, *_BLOCKS):
        cursor.take()
    if not cursor.accept(closing):
        cursor.diagnostics.append(cursor.unexpected(closing).diagnostic)
    message = "a block of options has no effect: the standard leaves their meaning to each tool"
    cursor.diagnostics.append(Diagnostic("FZ603", message, keyword.span, "warning", help="remove it"))
