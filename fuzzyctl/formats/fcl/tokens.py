"""Tokens of FCL without its comments, a cursor over them, and the expressions of FUNCTION."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from typing import Final, NamedTuple, cast

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.expr import Binary, BinaryOp, Call, Expr, Name, Negate, Number, span_of
from fuzzyctl.formats.common.infix import InfixParser, Operator
from fuzzyctl.formats.common.report import ParseError
from fuzzyctl.lang import syntax as sx
from fuzzyctl.support.files import TOO_LARGE

#: A token, a comment or a run of one character without meaning. A number stops before `..`, a name may contain dots.
_TOKEN: Final = re.compile(
    r"""(?P<blank>[\s\ufeff\u200b]+)
    | (?P<comment>\(\*.*?\*\) | /\*.*?\*/ | \{.*?\} | (?://|\#)[^\n]*)
    | (?P<open>\(\*|/\*|\{)
    | (?P<number>(?:[0-9]+(?:\.(?!\.)[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)
    | (?P<name>[^\W\d]\w*(?:\.(?!\.)\w+)*)
    | (?P<symbol>:=|\.\.+|[:;,()+\-*/^%|=])
    | (?P<bad>.)(?P=bad)*
    """,
    re.VERBOSE | re.DOTALL,
)

_CLOSINGS: Final = {"(*": "*)", "/*": "*/", "{": "}"}

#: Most runs of characters without meaning, and most syntax errors, that are reported one by one.
_MOST_BAD: Final = 100
_MOST_ERRORS: Final = 1000

#: Deepest nesting of parentheses, and most hedges of a term.
MAX_DEPTH: Final = 100

#: Longest chain of terms, so that no expression is deeper than any reader of it can go.
_MOST_OPERATORS: Final = 80

#: Words for numbers.
_NUMBERS: Final = {"NAN": math.nan, "INF": math.inf, "INFINITY": math.inf}


class Token(NamedTuple):
    """A token with its location.

    Args:
        kind: `name`, `number` or `symbol`; `end` for the end of the file.
        text: Its characters.
        start: Offset of the first character.
        end: Offset behind the last one.
        first: Whether it is the first on its line.
    """

    kind: str
    text: str
    start: int
    end: int
    first: bool

    @property
    def word(self) -> str:
        """A name in capitals, for keywords; an empty text for any other token."""
        return self.text.upper() if self.kind == "name" else ""


class Cursor:
    """The tokens of a source, read from left to right.

    Args:
        source: The text.

    Attributes:
        source: The text.
        comments: All its comments, with their marks.
        diagnostics: The diagnostics so far.
    """

    def __init__(self, source: SourceText) -> None:
        self.source = source
        self.comments: list[str] = []
        self.diagnostics: list[Diagnostic] = []
        self._tokens: list[Token] = []
        self._next = 0
        self._errors = 0
        self._tokenize()

    def _tokenize(self) -> None:
        text, at, first = self.source.text, 0, True
        while (match := _TOKEN.match(text, at)) is not None:
            kind, at = str(match.lastgroup), match.end()
            if kind == "open":
                opening, span = match.group(), Span(self.source, match.start(), at)
                message, help_text = f"the comment that begins here with '{opening}' does not end", _CLOSINGS[opening]
                self.diagnostics.append(Diagnostic("FZ601", message, span, help=f"write '{help_text}' where it ends"))
                self.comments.append(text[match.start() :])
                break
            if kind == "comment":
                self.comments.append(match.group())
            if kind in ("blank", "comment"):
                first = first or "\n" in match.group()
            elif kind == "bad":
                self._report_bad(Span(self.source, match.start(), at))
            else:
                self._tokens.append(Token(kind, match.group(), match.start(), at, first))
                first = False
        self._tokens.append(Token("end", "", len(text), len(text), True))

    def _report_bad(self, span: Span) -> None:
        """Report a run of one character that FCL does not have."""
        if len(self.diagnostics) < _MOST_BAD:
            char = span.text[0]
            description = f"'{char}' (U+{ord(char):04X})" if char.isprintable() else f"U+{ord(char):04X}"
            message = f"the character {description} has no meaning in FCL"
            self.diagnostics.append(Diagnostic("FZ601", message, span, help="remove it"))
        elif len(self.diagnostics) == _MOST_BAD:
            message = "there are more characters that have no meaning in FCL"
            self.diagnostics.append(Diagnostic("FZ601", message, span, help="is this an FCL file?"))

    @property
    def here(self) -> Token:
        """The next token."""
        return self._tokens[self._next]

    @property
    def after(self) -> Token:
        """The token after the next one."""
        return self._tokens[min(self._next + 1, len(self._tokens) - 1)]

    def take(self) -> Token:
        """Take the next token; the end is never passed."""
        token = self.here
        self._next += token.kind != "end"
        return token

    def accept(self, *texts: str) -> Token | None:
        """Take the next token if it is one of some symbols, or keywords in capitals."""
        token = self.here
        return self.take() if token.text in texts or (token.word and token.word in texts) else None

    def expect(self, *texts: str, expected: str = "") -> Token:
        """Take the next token, which must be one of some symbols or keywords; `expected` describes them."""
        token = self.accept(*texts)
        if token is None:
            raise self.unexpected(expected or f"'{texts[0]}'")
        return token

    def unexpected(self, expected: str, known: Collection[str] = ()) -> ParseError:
        """Return the error that the next token is not as expected; `known` lists the words that are possible."""
        token = self.here
        text = token.text if len(token.text) <= 40 else token.text[:39] + "…"
        message = f"expected {expected}, found '{text}'"
        if token.kind == "end":
            message = f"unexpected end of file, expected {expected}"
        facts = (f"possible here: {listed(known)}",) if known else ()
        help_text = did_you_mean(token.word, known) if known and token.word else ""
        return ParseError(message, self.span(token, token), facts=facts, help=help_text)

    def span(self, first: Token, last: Token | None = None) -> Span:
        """Return the span from a token to another one, or to the one taken last."""
        if last is None:
            last = self._tokens[max(self._next - 1, 0)]
        return Span(self.source, first.start, max(last.end, first.end))

    def word(self) -> sx.Word:
        """Take a token as a word."""
        token = self.take()
        return sx.Word(token.text, self.span(token, token))

    def name(self, expected: str) -> sx.Word:
        """Take a name, which may begin with digits, such as `2nd`."""
        first = self.here
        if first.kind == "number" and self.after.kind == "name" and self.after.start == first.end:
            self.take()
        elif first.kind != "name":
            raise self.unexpected(expected)
        span = self.span(first, self.take())
        return sx.Word(span.text, span)

    def value(self) -> Expr | None:
        """Take a number with its sign, or a name; return None for any other token."""
        first = self.here
        sign = self.take().text if first.text in ("+", "-") else ""
        token = self.here
        number = float(token.text) if token.kind == "number" else _NUMBERS.get(token.word)
        if number is not None:
            self.take()
            if math.isinf(number) and not token.word:
                raise ParseError(TOO_LARGE, self.span(first), "FZ108")
            return Number(-number if sign == "-" else number, "", self.span(first))
        if sign:
            raise self.unexpected("a number")
        if token.kind != "name":
            return None
        self.take()
        return Name(token.text, self.span(token))

    def required(self, expected: str) -> Expr:
        """Take a value, which must be there."""
        value = self.value()
        if value is None:
            raise self.unexpected(expected)
        return value

    def end_statement(self, starts: Collection[str]) -> None:
        """Take the semicolons; they may lack at the end of a line, and before a keyword that begins a statement."""
        token = self.here
        if token.text != ";" and token.kind != "end" and not token.first and token.word not in starts:
            raise self.unexpected("a semicolon")
        while self.accept(";"):
            pass

    def skip_statement(self, error: ParseError, stops: Collection[str]) -> None:
        """Report an error, and go on behind the next semicolon or at a keyword that begins a line."""
        self._errors += 1
        if self._errors <= _MOST_ERRORS:
            self.diagnostics.append(error.diagnostic)
        elif self._errors == _MOST_ERRORS + 1:
            message = f"too many errors ({_MOST_ERRORS}); further errors are not reported"
            self.diagnostics.append(Diagnostic("FZ601", message, error.diagnostic.span, help="is this an FCL file?"))
        while self.here.kind != "end" and not (self.here.first and self.here.word in stops):
            if self.take().text == ";":
                return


class Formula(InfixParser[Expr, Token]):
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
