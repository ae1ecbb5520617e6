"""Parser of FCL: function blocks from tokens; an error discards one statement, and all errors are reported."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import ONE, Expr
from fuzzyctl.formats.common.report import ParseError
from fuzzyctl.formats.fcl.tokens import MAX_DEPTH, Cursor, Formula, Token
from fuzzyctl.formats.fcl.words import SHAPE_WORDS
from fuzzyctl.lang import syntax as sx
from fuzzyctl.records import record

VARIABLES: Final = ("VAR_INPUT", "VAR_OUTPUT", "VAR", "VAR_IN_OUT")
_FUZZY: Final = ("FUZZIFY", "DEFUZZIFY")
_OPTIONS: Final = ("OPTIONS", "OPTION")
_ENDS: Final = {
    **dict.fromkeys(VARIABLES, "END_VAR"),
    **{word: f"END_{word}" for word in (*_FUZZY, "RULEBLOCK", *_OPTIONS)},
}
_BLOCKS: Final = (*_ENDS, "FUNCTION_BLOCK", "END_FUNCTION_BLOCK")
_CLOSERS: Final = tuple(dict.fromkeys(_ENDS.values()))

#: Keywords of the statements in a block; those of variables have none.
_STATEMENTS: Final = {
    **dict.fromkeys(VARIABLES, ()),
    **dict.fromkeys(_FUZZY, ("TERM", "RANGE", "METHOD", "ACCU", "DEFAULT", "LOCK", "ENABLED")),
    "RULEBLOCK": ("RULE", "AND", "OR", "ACT", "ACCU", "ENABLED", "ACTIVATION"),
}

#: Words that are neither hedges nor terms; the others end a rule without a semicolon only if they begin a line.
_AFTER_TERM: Final = frozenset({"AND", "OR", "THEN", "WITH", "IF", "IS", "RULE", "END_RULEBLOCK", "END_FUNCTION_BLOCK"})
_AFTER_RULE: Final = frozenset({"ACCU", "ACT", "ENABLED", "ACTIVATION"})


@dataclass(frozen=True)
class Range:
    """`RANGE := (low .. high)`."""

    low: Expr
    high: Expr
    span: Span


@dataclass(frozen=True)
class Declaration:
    """A variable of a VAR block; `initial` is the constant behind `:=`."""

    name: sx.Word
    initial: Expr | None
    range: Range | None = None


@dataclass(frozen=True)
class TermLine:
    """`TERM name := shape;`.

    Args:
        name: The name.
        kind: The word of the shape, such as TRIAN or Triangle; None for a list of points and for a lone number.
        arguments: Parameters, or the coordinates of points one after the other.
        points: Whether the shape is a list of points.
        formula: The expression of FUNCTION, else None.
        shape: The location of the shape.
        span: The location of the whole line.
    """

    name: sx.Word
    kind: sx.Word | None
    arguments: tuple[Expr, ...]
    points: bool
    formula: Expr | None
    shape: Span
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


@record(frozen=True, slots=True, eq=False)
class Joined(sx.Truth):
    """Conditions joined by AND and OR as written, without precedence, which depends on the dialect."""

    operands: tuple[sx.Truth, ...]
    operators: tuple[str, ...]


@dataclass
class Block:
    """A block of variables, FUZZIFY or DEFUZZIFY of a variable, or RULEBLOCK.

    Args:
        keyword: Its keyword.
        name: The variable, or the name of the rule block.
        declarations: Its variables.
        terms: Its terms.
        settings: Its settings in order.
        range: Its range.
        rules: Its rules; the weights are those of the file.
    """

    keyword: sx.Word
    name: sx.Word
    declarations: list[Declaration] = field(default_factory=list)
    terms: list[TermLine] = field(default_factory=list)
    settings: list[Setting] = field(default_factory=list)
    range: Range | None = None
    rules: list[sx.Rule] = field(default_factory=list)

    def setting(self, keyword: str) -> Setting | None:
        """Return the last setting of a keyword."""
        return next((s for s in reversed(self.settings) if s.keyword.text.upper() == keyword), None)

    def has(self, keyword: str, word: str) -> bool:
        """Return whether a word in capitals is a value of a setting."""
        values = [value for s in self.settings if s.keyword.text.upper() == keyword for value in s.values]
        return any(isinstance(value, sx.Word) and value.text.upper() == word for value in values)


@dataclass
class FunctionBlock:
    """FUNCTION_BLOCK: one fuzzy system."""

    name: str
    span: Span
    blocks: list[Block] = field(default_factory=list)

    def of(self, *keywords: str) -> list[Block]:
        """Return the blocks of some keywords."""
        return [block for block in self.blocks if block.keyword.text.upper() in keywords]


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

    def _require(self, keyword: str) -> None:
        """Take a keyword, or report that it is missing."""
        if not self.accept(keyword):
            self.diagnostics.append(self.unexpected(keyword).diagnostic)

    def _function_block(self) -> FunctionBlock:
        block = FunctionBlock("", self.span(self.here, self.here))
        if self.here.word == "FUNCTION_BLOCK":
            block.name = self._block_name()
        else:
            self._require("FUNCTION_BLOCK")
        while (word := self.here.word) not in _BLOCKS[-2:] and self.here.kind != "end":
            if word in _STATEMENTS:
                block.blocks.append(self._block())
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
        stops = (*_STATEMENTS, "END_FUNCTION_BLOCK")
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

    def _block(self) -> Block:
        keyword = self.word()
        opening = keyword.text.upper()
        block = Block(keyword, self._heading(keyword))
        stops = {*_STATEMENTS[opening], *_CLOSERS, *_BLOCKS} - {"AND", "OR"}  # which join conditions
        while not self.accept(_ENDS[opening]):
            start = self.here
            # A variable may have the name of a block.
            is_block = start.word in _BLOCKS and self.after.text not in (":", ",", ":=")
            if start.kind == "end" or start.word in _CLOSERS or is_block:
                self._require(_ENDS[opening])
                self.accept(*_CLOSERS)
                break
            try:
                self._statement(block, opening)
                self.end_statement(stops)
            except ParseError as error:
                if self.here is start:
                    self.take()  # else the keyword where it begins would end the search for the next statement
                self.skip_statement(error, stops)
        self.accept(";")
        return block

    def _heading(self, keyword: sx.Word) -> sx.Word:
        """Take the variable of FUZZIFY and DEFUZZIFY, or the name of a rule block; variables have none."""
        words: list[str] = []
        if keyword.text.upper() in _FUZZY:
            try:
                name = self.name("a variable")
                self.accept(";")
            except ParseError as error:
                self.diagnostics.append(error.diagnostic)
            else:
                return name
        elif keyword.text.upper() == "RULEBLOCK":
            while not self.here.first and self.here.kind != "end" and self.after.text not in (":", ":="):
                words.append(self.take().text)
        return sx.Word(" ".join(words), keyword.span)

    def _statement(self, block: Block, opening: str) -> None:
        word = self.here.word
        if opening in VARIABLES:
            self._declaration(block.declarations)
            return
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

    def _declaration(self, declarations: list[Declaration]) -> None:
        """Take `a, b : REAL := 5`, whose type has no effect on a fuzzy system, or the range of the last variable."""
        if self.here.word == "RANGE" and self.after.text in (":=", ":", "=") and declarations:
            last = declarations.pop()
            declarations.append(Declaration(last.name, last.initial, self._range()))
            return
        names = [self.name("a variable")]
        while self.accept(","):
            names.append(self.name("a variable"))
        self.expect(":", expected="':' and a type such as REAL")
        self.name("a type such as REAL")
        initial = self.required("a number") if self.accept(":=", "=") else None
        declarations += [Declaration(name, initial) for name in names]

    def _term(self) -> TermLine:
        first, name = self.take(), self.name("the name of a term")
        self.expect(":=", ":", "=")
        start, kind = self.here, None
        is_last = self.after.text == ";" or self.after.first
        if start.kind == "name" and (start.word in SHAPE_WORDS or not is_last):
            kind = self.word()
        formula = Formula(self).parse() if kind is not None and kind.text.upper() == "FUNCTION" else None
        points = formula is None and self.here.text == "("
        arguments = self._points() if points else self._arguments() if formula is None else []
        if kind is None and not arguments:
            raise self.unexpected("a number, points such as (0, 1) or a shape", SHAPE_WORDS)
        return TermLine(name, kind, tuple(arguments), points, formula, self.span(start), self.span(first))

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
        return token.word in _AFTER_TERM or (token.first and token.word in _AFTER_RULE)
