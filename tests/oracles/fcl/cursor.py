"""Cursor over the tokens of an FCL file: current token, expected token, and recovery after an error."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.expr import Expr, Name, Number
from fuzzyctl.formats.common.report import ParseError
from fuzzyctl.support.shipped import TOO_LARGE
from tests.oracles.fcl.syntax import Word
from tests.oracles.fcl.tokens import Token, tokenize

#: Deepest nesting of parentheses.
MAX_DEPTH: Final = 100

#: Most syntax errors reported one by one; a file with more is no FCL, or has one broken location above them.
_MOST_ERRORS: Final = 1000

#: Words that are numbers.
_NUMBERS: Final = {"NAN": math.nan, "INF": math.inf, "INFINITY": math.inf}


class Cursor:
    """The tokens of a source, read from left to right.

    Args:
        source: The text.

    Attributes:
        source: The text.
        comments: All its comments.
        diagnostics: What was found so far.
    """

    def __init__(self, source: SourceText) -> None:
        found = tokenize(source)
        self.source, self.comments = source, found.comments
        self.diagnostics: list[Diagnostic] = list(found.diagnostics)
        self._tokens = found.tokens
        self._at = 0
        self._errors = 0

    @property
    def here(self) -> Token:
        """The token that comes next."""
        return self._tokens[self._at]

    @property
    def after(self) -> Token:
        """The token behind the next one."""
        return self._tokens[min(self._at + 1, len(self._tokens) - 1)]

    @property
    def before(self) -> Token:
        """The token that was taken last."""
        return self._tokens[max(self._at - 1, 0)]

    def take(self) -> Token:
        """Take the next token; the end is never passed."""
        token = self.here
        if token.kind != "end":
            self._at += 1
        return token

    def accept(self, *texts: str) -> Token | None:
        """Take the next token if it is one of some symbols, or keywords in capitals."""
        token = self.here
        if token.text in texts or (token.word and token.word in texts):
            return self.take()
        return None

    def expect(self, *texts: str, what: str) -> Token:
        """Take the next token, which must be one of some symbols or keywords."""
        token = self.accept(*texts)
        if token is None:
            raise self.unexpected(what)
        return token

    def unexpected(self, what: str, known: Collection[str] = ()) -> ParseError:
        """Return the error that another token is found where `what` is expected."""
        token = self.here
        if token.kind == "end":
            message = f"unexpected end of file, expected {what}"
        else:
            message = f"expected {what}, found '{_short(token.text)}'"
        facts = (f"possible here: {listed(known)}",) if known else ()
        help_text = did_you_mean(token.word, known) if known and token.word else ""
        return ParseError(message, self.span(token), facts=facts, help=help_text)

    def span(self, first: Token, last: Token | None = None) -> Span:
        """Return the place from a token to another one, or to the one taken last."""
        if last is None:
            last = self.before if self.before.start >= first.start else first
        return Span(self.source, first.start, max(last.end, first.end))

    def name(self, what: str) -> Word:
        """Take a name; one may begin with digits, such as `2nd`."""
        token = self.here
        if token.kind == "number" and self.after.kind == "name" and self.after.start == token.end:
            self.take()
        elif token.kind != "name":
            raise self.unexpected(what)
        last = self.take()
        span = Span(self.source, token.start, last.end)
        return Word(span.text, span)

    def value(self) -> Expr | None:
        """Take a number with its sign, or a name that stands for one; None where neither stands."""
        first = self.here
        sign = self.take().text if first.text in ("+", "-") else ""
        token = self.here
        number = float(token.text) if token.kind == "number" else _NUMBERS.get(token.word)
        if number is not None:
            self.take()
            if math.isinf(number) and not token.word:
                raise ParseError(TOO_LARGE, self.span(first), "FZ108")
            return Number(-number if sign == "-" else number, "", self.span(first))
        if token.kind == "name" and not sign:
            self.take()
            return Name(token.text, self.span(token))
        if sign:
            raise self.unexpected("a number")
        return None

    def end_statement(self, starts: Collection[str]) -> None:
        """Take the semicolon; it may be missing at the end of a line, and before a keyword that begins a statement."""
        if self.accept(";"):
            while self.accept(";"):
                pass
            return
        token = self.here
        if token.kind != "end" and not token.first and token.word not in starts:
            raise self.unexpected("a semicolon")

    def report(self, error: ParseError, stops: Collection[str]) -> None:
        """Note a mistake, and go on behind the next semicolon or at a keyword that begins a line."""
        self._errors += 1
        if self._errors <= _MOST_ERRORS:
            self.diagnostics.append(error.diagnostic)
        elif self._errors == _MOST_ERRORS + 1:
            message = f"too many errors ({_MOST_ERRORS}); further errors are not reported"
            self.diagnostics.append(Diagnostic("FZ601", message, error.diagnostic.span, help="is this an FCL file?"))
        while self.here.kind != "end":
            token = self.here
            if token.first and token.word in stops:
                return
            if self.take().text == ";":
                return

    def rest_of_line(self, stops: Collection[str]) -> list[Token]:
        """Take the tokens that are left on the line of the one taken last, up to a keyword that begins a block."""
        taken: list[Token] = []
        while self.here.kind != "end" and not self.here.first and self.here.word not in stops:
            taken.append(self.take())
        return taken


def _short(text: str) -> str:
    return text if len(text) <= 40 else text[:39] + "…"
