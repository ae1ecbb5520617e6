"""Parser of FCL: function blocks from tokens; an error discards one statement, and all errors are reported."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final, cast

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import ONE, Binary, BinaryOp, Call, Expr, Negate, Number, span_of
from fuzzyctl.formats.common.infix import InfixParser, Operator
from fuzzyctl.formats.common.report import ParseError
from fuzzyctl.formats.fcl.tokens import Cursor, Token
from fuzzyctl.formats.fcl.words import SHAPE_WORDS
from fuzzyctl.lang import syntax as sx
from fuzzyctl.records import record

#: Deepest nesting of parentheses, and most hedges of a term.
MAX_DEPTH: Final = 100

#: Longest chain of terms, so that no expression is deeper than any reader of it can go.
_MOST_OPERATORS: Final = 80

VARIABLES: Final = ("VAR_INPUT", "VAR_OUTPUT", "VAR", "VAR_IN_OUT")
_FUZZY: Final = ("FUZZIFY", "DEFUZZIFY")
_OPTIONS: Final = ("OPTIONS", "OPTION")
_ENDS: Final = {
    **dict.fromkeys(VARIABLES, "END_VAR"),
    **{word: f"END_{word}" for word in (*_FUZZY, "RULEBLOCK", *_OPTIONS)},
}
_BLOCKS: Final = (*_ENDS, "FUNCTION_BLOCK", "END_FUNCTION_BLOCK")
_CLOSERS: Final = tuple(dict.fromkeys(_ENDS.values()))

#: Keywords of the statements in a block.
_STATEMENTS: Final = {
    **dict.fromkeys(_FUZZY, ("TERM", "RANGE", "METHOD", "ACCU", "DEFAULT", "LOCK", "ENABLED")),
    "RULEBLOCK": ("RULE", "AND", "OR", "ACT", "ACCU", "ENABLED", "ACTIVATION"),
}

#: Words behind a term; AND and OR join conditions, so that they do not end a rule that lacks its semicolon.
_AFTER_TERM: Final = frozenset({"AND", "OR", "THEN", "WITH", "IF", "IS"})
#: Words that end a rule without a semicolon if they begin a line, and those that are no names of terms at all.
_AFTER_RULE: Final = frozenset({"ACCU", "ACT", "ENABLED", "ACTIVATION"})
_NO_TERMS: Final = frozenset({"RULE", "END_RULEBLOCK", "END_FUNCTION_BLOCK"})


@dataclass(frozen=True)
class Range:
    """`RANGE := (low .. high)`."""

    low: Expr
    high: Expr
    span: Span


@dataclass(frozen=True)
class Declaration:
    """A variable of a VAR block; `initial` is the constant behind `:=`."""

    keyword: str
    name: sx.Word
    initial: Expr | None
    range: Range | None = None


@dataclass(frozen=True)
class Shape:
    """The shape of a term, behind `TERM name :=`.

    Args:
        kind: Its word, such as TRIAN or Triangle; None for a list of points and for a lone number.
        arguments: Parameters, or the coordinates of points one after the other.
        points: Whether it is a list of points.
        formula: The expression of FUNCTION, else None.
        span: Its location.
    """

    kind: sx.Word | None
    arguments: tuple[Expr, ...]
    points: bool
    formula: Expr | None
    span: Span


@dataclass(frozen=True)
class TermLine:
    """`TERM name := shape;`."""

    name: sx.Word
    shape: Shape
    span: Span


@dataclass(frozen=True)
class Setting:
    """`KEYWORD : value` or `KEYWORD := value`; values of several words are separated by `|`."""

    keyword: sx.Word
    values: tuple[sx.Word | Expr, ...]
    span: Span

    @property
    def word(self) -> sx.Word | None:
        """The value if it is a single word."""
        return self.values[0] if len(self.values) == 1 and isinstance(self.values[0], sx.Word) else None

    def has(self, word: str) -> bool:
        """Return whether a word in capitals is one of the values."""
        return any(isinstance(v, sx.Word) and v.text.upper() == word for v in self.values)


@record(frozen=True, slots=True, eq=False)
class Joined(sx.Truth):
    """Conditions joined by AND and OR as written, without precedence, which depends on the dialect."""

    operands: tuple[sx.Truth, ...]
    operators: tuple[str, ...]


@dataclass
class Block:
    """FUZZIFY or DEFUZZIFY of a variable, or RULEBLOCK.

    Args:
        keyword: Its keyword.
        name: The variable, or the name of the rule block.
        terms: Its terms.
        settings: Its settings in order.
        range: Its range.
        rules: Its rules; the weights are those of the file.
    """

    keyword: sx.Word
    name: sx.Word
    terms: list[TermLine] = field(default_factory=list)
    settings: list[Setting] = field(default_factory=list)
    range: Range | None = None
    rules: list[sx.Rule] = field(default_factory=list)

    def setting(self, keyword: str) -> Setting | None:
        """Return the last setting of a keyword."""
        return next((s for s in reversed(self.settings) if s.keyword.text.upper() == keyword), None)


@dataclass
class FunctionBlock:
    """FUNCTION_BLOCK: one fuzzy system."""

    name: str
    span: Span
    declarations: list[Declaration] = field(default_factory=list)
    fuzzy: list[Block] = field(default_factory=list)
    rules: list[Block] = field(default_factory=list)


class Parser(Cursor):
    """Parser of one file."""

    def parse(self) -> list[FunctionBlock]:
        """Return the function blocks, as far as they can be read."""
        blocks: list[FunctionBlock] = []
        while self.here.kind != "end":
            if self.here.word in _BLOCKS[:-1]:
                blocks.append(self._function_block())
            else:
                self.skip_statement(self.unexpected("FUNCTION_BLOCK"), _BLOCKS)
                self.accept("END_FUNCTION_BLOCK")
        if not blocks and not self.diagnostics:
            message, help_text = "the file has no FUNCTION_BLOCK", "begin with FUNCTION_BLOCK and a name"
            self.diagnostics.append(Diagnostic("FZ004", message, file=self.source.name, help=help_text))
        return blocks

    def _require(self, *closing: str) -> None:
        """Take a keyword, or report that it is missing."""
        if not self.accept(*closing):
            self.diagnostics.append(self.unexpected(closing[0]).diagnostic)

    def _function_block(self) -> FunctionBlock:
        block = FunctionBlock("", self.span(self.here, self.here))
        if self.here.word == "FUNCTION_BLOCK":
            block.name = self._block_name()
        else:
            self._require("FUNCTION_BLOCK")
        while self.here.word not in ("END_FUNCTION_BLOCK", "FUNCTION_BLOCK") and self.here.kind != "end":
            word = self.here.word
            if word in VARIABLES:
                self._variables(block)
            elif word in _STATEMENTS:
                (block.rules if word == "RULEBLOCK" else block.fuzzy).append(self._block())
            elif word in _OPTIONS:
                self._options()
            else:
                self.skip_statement(self.unexpected("a block", _BLOCKS[:-2]), _BLOCKS)
        self._require("END_FUNCTION_BLOCK")
        self.accept(";")
        return block

    def _block_name(self) -> str:
        """Take the name of a function block: the rest of its line, or a word on the next one."""
        self.take()
        first, last = self.here, None
        stops = (*VARIABLES, *_STATEMENTS, "END_FUNCTION_BLOCK")
        while self.here.kind != "end" and not self.here.first and self.here.word not in stops:
            last = self.take()
        if last is not None:
            return self.span(first, last).text.strip(" ;")
        return self.take().text if self.here.kind == "name" and self.here.word not in _BLOCKS else ""

    def _options(self) -> None:
        """Skip a block of options, whose meaning the standard leaves to each tool."""
        keyword = self.word()
        closing = _ENDS[keyword.text.upper()]
        while self.here.kind != "end" and self.here.word not in (closing, *_BLOCKS):
            self.take()
        self._require(closing)
        message = "a block of options has no effect: the standard leaves their meaning to each tool"
        self.diagnostics.append(Diagnostic("FZ603", message, keyword.span, "warning", help="remove it"))

    # --- statements ------------------------------------------------------------------------------------------------

    def _statements(self, opening: str, statement: Callable[[], None]) -> None:
        """Take statements up to the end of a block, one after the other."""
        stops = {*_STATEMENTS.get(opening, ()), *_CLOSERS, *_BLOCKS} - {"AND", "OR"}  # which join conditions
        while not self.accept(_ENDS[opening]):
            start = self.here
            # A variable may have the name of a block.
            is_block = start.word in _BLOCKS and self.after.text not in (":", ",", ":=")
            if start.kind == "end" or start.word in _CLOSERS or is_block:
                self._require(_ENDS[opening])
                self.accept(*_CLOSERS)
                break
            try:
                statement()
                self.end_statement(stops)
            except ParseError as error:
                if self.here is start:
                    self.take()  # else the keyword where it begins would end the search for the next statement
                self.skip_statement(error, stops)
        self.accept(";")

    def _variables(self, block: FunctionBlock) -> None:
        keyword, declarations = self.take().word, list[Declaration]()

        def statement() -> None:
            if self.here.word == "RANGE" and self.after.text in (":=", ":", "=") and declarations:
                last = declarations.pop()
                declarations.append(Declaration(keyword, last.name, last.initial, self._range()))
            else:
                declarations.extend(self._declarations(keyword))

        self._statements(keyword, statement)
        block.declarations += declarations

    def _declarations(self, keyword: str) -> list[Declaration]:
        """Take `a, b : REAL := 5`; the type has no effect on a fuzzy system."""
        names = [self.name("a variable")]
        while self.accept(","):
            names.append(self.name("a variable"))
        self.expect(":", expected="':' and a type such as REAL")
        self.name("a type such as REAL")
        initial = self.required("a number") if self.accept(":=", "=") else None
        return [Declaration(keyword, name, initial) for name in names]

    def _block(self) -> Block:
        keyword = self.word()
        opening = keyword.text.upper()
        block = Block(keyword, self._rule_block_name() if opening == "RULEBLOCK" else self._fuzzy_variable(keyword))

        def statement() -> None:
            word = self.here.word
            if word not in _STATEMENTS[opening]:
                raise self.unexpected("a statement", (*_STATEMENTS[opening], _ENDS[opening]))
            is_second = block.setting(word) is not None or (word == "RANGE" and block.range is not None)
            if is_second and opening != "RULEBLOCK":
                message, span = f"{word} is given twice in this block", self.span(self.here, self.here)
                raise ParseError(message, span, "FZ215", help="keep one of them")
            if word == "TERM":
                block.terms.append(self._term())
            elif word == "RULE":
                block.rules.append(self._rule())
            elif word == "RANGE":
                block.range = self._range()
            else:
                block.settings.append(self._setting())

        self._statements(opening, statement)
        return block

    def _rule_block_name(self) -> sx.Word:
        first, words = self.here, list[str]()
        while not self.here.first and self.here.kind != "end" and self.after.text not in (":", ":="):
            words.append(self.take().text)
        return sx.Word(" ".join(words), self.span(first, first))

    def _fuzzy_variable(self, keyword: sx.Word) -> sx.Word:
        try:
            name = self.name("a variable")
            self.accept(";")
        except ParseError as error:
            self.diagnostics.append(error.diagnostic)
            return sx.Word("", keyword.span)
        return name

    def _term(self) -> TermLine:
        first = self.take()
        name = self.name("the name of a term")
        self.expect(":=", ":", "=")
        return TermLine(name, self._shape(), self.span(first))

    def _shape(self) -> Shape:
        first, kind = self.here, None
        is_last = self.after.text == ";" or self.after.first
        if first.kind == "name" and (first.word in SHAPE_WORDS or not is_last):
            kind = self.word()
        formula = _Formula(self).parse() if kind is not None and kind.text.upper() == "FUNCTION" else None
        points = formula is None and self.here.text == "("
        arguments = self._points() if points else self._arguments() if formula is None else []
        if kind is None and not arguments:
            raise self.unexpected("a number, points such as (0, 1) or a shape", SHAPE_WORDS)
        return Shape(kind, tuple(arguments), points, formula, self.span(first))

    def _arguments(self) -> list[Expr]:
        arguments: list[Expr] = []
        while not self.here.first and (value := self.value()) is not None:
            arguments.append(value)
            self.accept(",")
        return arguments

    def _points(self) -> list[Expr]:
        """Take points `(x, y)`, as coordinates one after the other."""
        coordinates: list[Expr] = []
        while self.accept("("):
            for closing in (",", ")"):
                coordinates.append(self.required("a number"))
                self.expect(closing)
            self.accept(",")
        return coordinates

    def _range(self) -> Range:
        first = self.take()
        self.expect(":=", ":", "=")
        self.expect("(")
        low = self.value()
        self.expect("..", "...", ",")
        high = self.value()
        self.expect(")")
        if low is None or high is None:
            help_text = "write, for example: RANGE := (0 .. 10);"
            raise ParseError("a range has two ends", self.span(first), help=help_text)
        return Range(low, high, self.span(first))

    def _setting(self) -> Setting:
        first = self.here
        keyword = self.word()
        self.expect(":", ":=", "=")
        values = [self._setting_value()]
        while self.accept("|"):
            values.append(self._setting_value())
        return Setting(keyword, tuple(values), self.span(first))

    def _setting_value(self) -> sx.Word | Expr:
        if self.here.kind == "name" and self.here.word not in ("NAN", "INF"):
            return self.name("a value")
        if self.here.first:
            raise self.unexpected("a value")
        return self.required("a value")

    # --- rules -----------------------------------------------------------------------------------------------------

    def _rule(self) -> sx.Rule:
        first, words = self.take(), 0
        while self.here.text != ":" and self.here.word != "IF":  # a missing colon is no loss before IF
            if self.here.kind == "end" or self.here.text == ";" or words > 20:
                raise self.unexpected("':' and IF")
            self.take()
            words += 1
        self.accept(":")
        self.expect("IF", expected="IF")
        condition = self._condition(0)
        self.expect("THEN", expected="AND, OR or THEN")
        consequents = [self._conclusion()]
        while self.accept(",", "AND"):
            consequents.append(self._conclusion())
        weight = self.required("a weight") if self.accept("WITH") else ONE
        return sx.Rule(self.span(first), condition, tuple(consequents), weight)

    def _condition(self, depth: int) -> sx.Truth:
        first = self.here
        operands, operators = [self._operand(depth)], []
        while (token := self.accept("AND", "OR")) is not None:
            operators.append(token.word)
            operands.append(self._operand(depth))
        return Joined(self.span(first), tuple(operands), tuple(operators)) if operators else operands[0]

    def _operand(self, depth: int) -> sx.Truth:
        token = self.here
        if depth >= MAX_DEPTH:
            message = f"conditions are nested more than {MAX_DEPTH} deep"
            raise ParseError(message, self.span(token, token), "FZ106")
        if token.word == "NOT" and self.after.word != "IS":
            self.take()
            operand = self._operand(depth + 1)
            return sx.Negation(self.span(token), operand)
        if self.accept("("):
            condition = self._condition(depth + 1)
            self.expect(")", expected="AND, OR or ')'")
            return condition
        return self._proposition("a condition such as 'x IS low'")

    def _conclusion(self) -> sx.ConsequentText:
        depth = 0
        while self.accept("("):
            depth += 1
        proposition = self._proposition("a conclusion such as 'y IS high'")
        for _ in range(depth):
            self.expect(")")
        return sx.ConsequentText(proposition.variable, proposition.term, proposition.hedges)

    def _proposition(self, expected: str) -> sx.Literal:
        first = self.here
        variable = self.name(expected)
        self.expect("IS", expected="IS")
        words = [self.name("a term")]
        # A variable before IS belongs to a condition whose AND, OR or THEN is missing.
        while self.here.kind == "name" and not self._ends_proposition(self.here) and self.after.word != "IS":
            words.append(self.name("a term"))
            if len(words) > MAX_DEPTH:
                raise ParseError(f"a term has more than {MAX_DEPTH} hedges", self.span(first), "FZ106")
        return sx.Literal(self.span(first), variable, tuple(words[:-1]), words[-1])

    def _ends_proposition(self, token: Token) -> bool:
        return token.word in _AFTER_TERM | _NO_TERMS or (token.first and token.word in _AFTER_RULE)


class _Formula(InfixParser[Expr, Token]):
    """Parser of FUNCTION expressions; functions have the names of the file, in small letters."""

    infix: Mapping[str, Operator] = {
        **dict.fromkeys(("+", "-"), Operator(1)),
        **dict.fromkeys(("*", "/", "%"), Operator(2)),
        "^": Operator(4),
    }
    prefix: Mapping[str, int] = {"+": 3, "-": 3}
    deepest = MAX_DEPTH

    def __init__(self, cursor: Cursor) -> None:
        self._cursor = cursor
        self._operators = 0
        self._take = cursor.take

    def _peek(self) -> str:
        return self._cursor.here.text

    def _operand(self, least: int) -> Expr:
        return self._atom() if least > self.infix["^"].level and self._peek() == "+" else super()._operand(least)

    def _unary(self, sign: str, operand: Expr, place: Token) -> Expr:
        if sign == "+":
            return operand
        span = self._from(place.start, operand)
        return Number(-operand.value, "", span) if isinstance(operand, Number) else Negate(operand, span)

    def _binary(self, sign: str, left: Expr, right: Expr, place: Token) -> Expr:
        cursor = self._cursor
        self._operators += 1
        if self._operators > _MOST_OPERATORS:
            message = f"the expression has more than {_MOST_OPERATORS} operators"
            raise ParseError(message, span_of(right), "FZ106")
        if sign == "%":
            return Call("%", (left, right), cursor.span(place, place))
        if sign == "^" and self._peek() == "^":
            message = "'a ^ b ^ c' is read from the left by some tools, from the right by others"
            raise ParseError(message, cursor.span(cursor.here, cursor.here), help="write parentheses")
        first = span_of(left)
        assert first is not None
        return Binary(cast(BinaryOp, sign), left, right, self._from(first.start, right))

    def _atom(self) -> Expr:
        cursor, token = self._cursor, self._cursor.here
        if cursor.accept("("):
            inside = self._nested(0, token)
            cursor.expect(")")
            return inside
        if token.kind == "name" and cursor.after.text == "(":
            return self._call(cursor.take())
        if token.kind not in ("name", "number"):
            raise cursor.unexpected("a number, a variable or '('")
        return cursor.required("a number, a variable or '('")

    def _call(self, name: Token) -> Expr:
        cursor = self._cursor
        cursor.take()
        self._enter(name)
        arguments = [self.parse()]
        while cursor.accept(","):
            arguments.append(self.parse())
        self.depth -= 1
        cursor.expect(")")
        return Call(name.text.lower(), tuple(arguments), cursor.span(name))

    def _from(self, start: int, last: Expr) -> Span:
        span = span_of(last)
        assert span is not None
        return Span(self._cursor.source, start, span.end)

    def _too_deep(self, place: Token) -> ParseError:
        message = f"parentheses are nested more than {MAX_DEPTH} deep"
        return ParseError(message, self._cursor.span(self._cursor.here, self._cursor.here), "FZ106")
