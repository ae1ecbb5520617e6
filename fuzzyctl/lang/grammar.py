"""Grammar of logical lines: a line becomes a node, or a diagnostic.

Computing the tables of the grammar takes longer than reading a file, so they are shipped beside it. They belong to one
version of lark and to one text of the grammar; with any other they are computed. After a change of either write them
anew: `python -m fuzzyctl.lang.grammar`.
"""

from __future__ import annotations

import io
import pickle
import pkgutil
import re
import threading
import zlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, Final, NoReturn

import lark
from lark import Lark, Token
from lark.common import LexerConf
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken
from lark.lexer import Lexer

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang.builder import Builder
from fuzzyctl.lang.lines import MEMBER, QUANTITY, TOKEN, LineKind, LogicalLine
from fuzzyctl.lang.mistakes import describe

#: The file of the tables: a line with their key, then what `Lark.save` writes.
TABLES: Final = "grammar.tables"

#: Terminals of signs; the grammar accepts only one of two kinds at a place.
_SIGNS: Final[dict[str, tuple[str, ...]]] = {
    **dict.fromkeys(("<=", ">=", "!=", "<", ">"), ("COMPARE",)),
    **dict.fromkeys("+-", ("SUM",)),
    "==": ("COMPARE", "EQUAL"), "=": ("EQUAL",), "*": ("STAR", "PRODUCT"), "/": ("SLASH", "PRODUCT"), "^": ("POWER",),
    "(": ("LPAR",), ")": ("RPAR",), "[": ("LSQB",), "]": ("RSQB",), ",": ("COMMA",), "@": ("AT",), "|": ("VBAR",),
    ".": ("DOT",), ":": ("COLON",), "×": ("X",),
}  # fmt: skip
#: Lengths of the tokens of terminals that are shorter than a sign.
_SHORT: Final = {"EQUAL": 1, "DOT": 1}

#: The text that may follow a number without a unit.
_ENDS: Final = re.compile(r"(?![\w.])")

_STARTS: Final = ("statement", "block_statement", "term_line", "header", "row", "label", "cell")

# Lark calls the builder while it parses, and the builder must know the place of the line; one parse at a time.
_LOCK = threading.Lock()


@cache
def grammar_text() -> str:
    """Return the text of the grammar."""
    return (pkgutil.get_data("fuzzyctl.lang", "grammar.lark") or b"").decode().replace("\r\n", "\n")


def key() -> str:
    """Return the key of tables: the version of lark, and a checksum of the grammar with its start symbols."""
    return f"{lark.__version__} {zlib.crc32((grammar_text() + ' '.join(_STARTS)).encode()):08x}"


def computed_tables() -> bytes:
    """Return the content of the file of tables."""
    machine = Lark(grammar_text(), parser="lalr", lexer="contextual", start=list(_STARTS), maybe_placeholders=True)
    tables = io.BytesIO()
    machine.save(tables)
    return f"{key()}\n".encode() + tables.getvalue()


def shipped_tables() -> bytes:
    """Return the content of the file of tables, b"" without the file."""
    try:
        return pkgutil.get_data("fuzzyctl.lang", TABLES) or b""
    except OSError:
        return b""


def _tables() -> bytes:
    """Return the shipped tables if they fit, else computed ones."""
    shipped = shipped_tables()
    return shipped if shipped.startswith(f"{key()}\n".encode()) else computed_tables()


class LineLexer(Lexer):
    """Names the tokens of a line: a word is a keyword only where the grammar accepts one."""

    __future_interface__ = 2  # of lark: the state of the parser is an argument

    def __init__(self, conf: LexerConf) -> None:
        #: Keywords, each with its terminals and with what must follow, the strictest first.
        self.keywords: dict[str, list[tuple[str, re.Pattern[str] | None]]] = {}
        for terminal in sorted(conf.terminals, key=lambda t: -t.priority):
            word, pattern = re.match("[a-z]*", terminal.pattern.value), terminal.pattern.value
            if word is not None and word[0]:
                follows = None if pattern in (rf"{word[0]}\b", r"x\b|×") else re.compile(pattern)
                self.keywords.setdefault(word[0], []).append((terminal.name, follows))

    def lex(self, lexer_state: Any, parser_state: Any) -> Iterator[Token]:
        """Yield the tokens of a line.

        Raises:
            UnexpectedToken: For one that the grammar does not accept at its place.
            UnexpectedCharacters: For a character that begins no token.
        """
        text: str = getattr(lexer_state.text, "text", lexer_state.text)
        states, at = parser_state.parse_conf.states, 0
        while at < len(text):
            token = TOKEN.match(text, at)
            assert token is not None, "any character is matched"
            kind, at = token.lastgroup, token.end()
            if kind == "blank" or kind == "comment":
                continue
            accepted = states[parser_state.position]
            first = None
            for name, end in self._terminals(text, token):
                first = first or (name, end)
                if name in accepted:
                    break
            else:
                self._refuse(text, token.start(), first, accepted)
            yield Token(name, text[token.start() : end], token.start(), end_pos=end)
            at = end

    def _terminals(self, text: str, token: re.Match[str]) -> Iterator[tuple[str, int]]:
        """Yield the terminals that a token may be and where it ends then, in the order of their priorities."""
        start, end = token.span()
        match token.lastgroup:
            case "name":
                for name, follows in self.keywords.get(token[0], ()):
                    if follows is None or follows.match(text, start):
                        yield name, end
                if text.startswith(".", end) and (member := MEMBER.match(text, start)):
                    yield "MEMBER", member.end()
                yield "NAME", end
            case "number":
                if quantity := QUANTITY.match(text, start):
                    yield "QUANTITY", quantity.end()
                if quantity is None or _ENDS.match(text, end):
                    yield "NUMBER", end
                if token[0].startswith("."):
                    yield "DOT", start + 1
            case "sign":
                for name in _SIGNS[token[0]]:
                    yield name, start + _SHORT.get(name, len(token[0]))
            case "text" if token[0].endswith('"', 1):
                yield "STRING", end

    @staticmethod
    def _refuse(text: str, at: int, first: tuple[str, int] | None, accepted: dict[str, Any]) -> NoReturn:
        expected = {name for name in accepted if name.isupper() and name != "$END"} or {"<END-OF-FILE>"}
        if first is None:
            raise UnexpectedCharacters(text, at, 1, at + 1, allowed=expected)  # type: ignore[no-untyped-call]
        token = Token(first[0], text[at : first[1]], at, end_pos=first[1])
        raise UnexpectedToken(token, expected)  # type: ignore[no-untyped-call]


@cache
def _machine() -> tuple[Lark, Builder]:
    builder = Builder()
    tables = pickle.loads(_tables().partition(b"\n")[2])
    # Functions and classes are not saved.
    tables["data"]["options"]["transformer"] = builder
    tables["data"]["parser"]["lexer_conf"]["lexer_type"] = LineLexer
    return Lark.load(tables), builder


def parse_line(source: SourceText, line: LogicalLine, kind: LineKind) -> tuple[Any, list[Diagnostic]]:
    """Parse one line as one kind; the node is None when it could not be read."""
    machine, builder = _machine()
    with _LOCK:
        builder.begin(source, line)
        try:
            node = machine.parse(line.code(source), start=kind)
        except UnexpectedInput as error:
            return None, [describe(source, line, error)]
        return (None if builder.problems else node), builder.problems


def read_line(source: SourceText, line: LogicalLine, kind: LineKind) -> tuple[Any, int]:
    """Parse one line without a diagnostic: the node, None when it cannot be read, and where reading stops."""
    machine, builder = _machine()
    with _LOCK:
        builder.begin(source, line)
        try:
            node = machine.parse(line.code(source), start=kind)
        except UnexpectedInput as error:
            # The token of the end of a line has the place of the one before it.
            is_end = isinstance(error, UnexpectedToken) and error.token.type == "$END"
            return None, line.end if is_end else line.start + (error.pos_in_stream or 0)  # type: ignore[redundant-expr]
        if builder.problems:
            span = builder.problems[0].span
            return None, span.start if span is not None else line.start
        return node, line.end


if __name__ == "__main__":
    Path(__file__).with_name(TABLES).write_bytes(computed_tables())
