"""Parser of rule files: logical lines to a syntax tree, with all errors found in one pass."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from itertools import chain, pairwise
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.foreign import (
    ELSE_WORDS,
    Headless,
    describe_barless,
    describe_headless,
    foreign,
    headless,
    is_barless_row,
    is_nameless,
    looks_like_term,
    looks_like_variable,
    misplaced_else,
)
from fuzzyctl.lang.lines import LineKind, LogicalLine, half_typed, keyword_behind, meant_head, split
from fuzzyctl.lang.mistakes import describe_unknown_line, meant_keyword, orphan

#: Most unreadable lines reported; parsing stops after them.
MAX_MISTAKES: Final = 500

#: Most operators of a file; signs of numbers behind '(', '[', ',', '=' and '|' do not count.
MAX_OPERATORS: Final = 80_000

#: Most lines of controllers, plants and loops, and most lets, of a file.
MAX_EQUATIONS: Final = 10_000

#: Most words, numbers and parentheses of a file.
MAX_WORDS: Final = 80_000

_WORDS = re.compile(sx.NAME)
_WORD_OR_PARENTHESIS = re.compile(r"[\w.]+|\(")
_OPERATOR = re.compile(r'"[^"\n]*"?|#[^\n]*|[0-9.][eE][-+]|[(\[,=|]\s*[-+](?=[\s0-9.])|([-+*/^])')


def parse(source: SourceText) -> tuple[sx.SyntaxTree, list[Diagnostic]]:
    """Parse a rule file.

    Args:
        source: Its text.

    Returns:
        The tree of all lines that could be read, and a diagnostic for each that could not.
    """
    reading = _read_lines(source)
    tree, mistakes, foreign = reading
    if not mistakes and not foreign:
        return tree, mistakes
    # Files without mistakes need no repairs.
    from fuzzyctl.lang.foreign import other_format
    from fuzzyctl.lang.recovery import recover

    if (mistake := other_format(source)) is not None:
        return _nothing(source), [mistake]
    return recover(source, reading, _read_lines, _stops)


def _nothing(source: SourceText) -> sx.SyntaxTree:
    """Return the tree of a file that is not read."""
    return sx.SyntaxTree(source, (), lost_variable=True, lost_input=True)


def _read_lines(source: SourceText) -> tuple[sx.SyntaxTree, list[Diagnostic], list[Diagnostic]]:
    """Parse a text as it is written; mistakes of lines that only other tools write so come third."""
    assembler = _Assembler(source)
    if (mistake := _crowded(source)) is not None:
        return _nothing(source), [mistake], []
    lines = (line for line in split(source) if line.kind != "blank")
    for line, below in pairwise(chain(lines, (None,))):
        assert line is not None, "only the last one has none below"
        if len(assembler.diagnostics) >= MAX_MISTAKES:
            assembler.give_up(line, f"too many errors ({MAX_MISTAKES}); parsing stopped", "fix the errors above first")
            break
        try:
            assembler.take(line, below)
        except _TooMuchError as error:
            assembler.give_up(line, str(error), "spread them over several files")
            break
    return *assembler.finish(), assembler.foreign


def _crowded(source: SourceText) -> Diagnostic | None:
    """Report a file with more operators than any controller has, which would take long to read."""
    if len(source.text) <= MAX_OPERATORS:
        return None
    places = [m.start() for m in _OPERATOR.finditer(source.text) if m[1]]
    if len(places) <= MAX_OPERATORS:
        return None
    message = f"the file has {len(places):,} operators, more than {MAX_OPERATORS:,}"
    at = places[MAX_OPERATORS]
    help_text = "write what is computed as a number, or spread the systems over several files"
    return Diagnostic("FZ112", message, Span(source, at, at + 1), help=help_text)


def _stops(source: SourceText, line: LogicalLine, kind: LineKind) -> int | None:
    """Return the offset where reading a line as one kind stops, or of a word of another tool; None for neither."""
    if kind in ("unknown", "blank"):
        return line.start
    from fuzzyctl.lang import grammar

    node, at = grammar.read_line(source, line, kind)
    if node is None:
        return at
    odd = foreign(node, source.text)
    return None if odd is None else odd.span.start if odd.span is not None else line.start


def parse_line(source: SourceText, line: LogicalLine, kind: LineKind) -> tuple[Any, list[Diagnostic]]:
    """Parse one logical line, or one field of a CSV file, as one kind; the node is None when it could not be read."""
    # Commands that read no rule file do without lark.
    from fuzzyctl.lang import grammar

    return grammar.parse_line(source, line, kind)


class _TooMuchError(Exception):
    """A file has more of something than is read in seconds; its text is the message."""


class _Assembler:
    """Attaches term lines, headers and rows to the statement above them."""

    def __init__(self, source: SourceText) -> None:
        self.source = source
        self.statements: list[sx.Statement] = []
        self.diagnostics: list[Diagnostic] = []
        #: What lines below belong to: "variable", "table", "broken" (swallow them) or "" (nothing).
        self.block = ""
        self.lines: list[Any] = []
        self.incomplete = False
        self.unread: set[str] = set()
        self.lost_variable = False
        self.lost_input = False
        self.nameless: set[str] = set()
        #: Whether the head of a block of equations could not be read.
        self.headless = False
        #: Rows of the table that lack their bar.
        self.barless: list[LogicalLine] = []
        #: Lines that can be read and are written as another tool has them.
        self.foreign: list[Diagnostic] = []
        #: A `with` line that waits for its table.
        self.condition: sx.With | None = None
        self.equations = self.words = 0

    def take(self, line: LogicalLine, below: LogicalLine | None) -> None:
        """Take the next line; `below` is the one after it."""
        if line.kind == "term_line" and line.word == "param" and is_nameless(self.source, line):
            line = dataclasses.replace(line, kind="statement")
        if line.in_block:
            self._take_block_line(line)
            return
        if self.block == "variable" and line.word.lower() in ELSE_WORDS:
            misplaced = misplaced_else(self.source, line, self.statements[-1])
            if misplaced is not None:
                self.diagnostics.append(misplaced)
                self.incomplete = True
                return
        if self.block == "table" and line.mistake is None and self._lacks_bar(line, below):
            self.barless.append(line)
            return
        belongs = line.kind in ("term_line", "header", "row") or (line.kind == "statement" and line.word == "terms")
        is_term = line.kind == "term_line" and line.code(self.source).endswith(")")
        what = headless(self.source, line, below) if line.kind in ("unknown", "term_line") and not is_term else ""
        if what == "header" and self.block == "table":
            # Rows below a table from a file are reported where the file is read.
            self._take_below(dataclasses.replace(line, kind="header"))
        elif what and (self.block != "broken" or what == "variable") and line.mistake is None:
            self._headless(line, what)
        elif line.kind == "unknown":
            self._unknown(line)
        elif belongs:
            self._take_below(line)
        else:
            self._close_block()
            self._take_statement(line)

    def _take_block_line(self, line: LogicalLine) -> None:
        """Take a line of a controller, plant or loop, which is one statement.

        The lines below a head that cannot be read belong to no other block, and their mistakes are reported.
        """
        self._close_block()
        self._drop_condition()
        node = self._parse(line, line.kind) if line.kind != "unknown" else None
        if line.kind != "unknown" and line.word in sx.HEADS:
            self.headless = node is None
        if line.kind == "unknown":
            self.diagnostics.append(line.mistake or describe_unknown_line(self.source, line, ""))
            code, keywords = line.code(self.source), sx.BLOCKS[line.in_block]
            self.headless = self.headless or meant_head(code, line.in_block) is not None
            meant = half_typed(line.word, keywords) if line.word else None
            if meant is not None:
                self.unread.add(meant)
                # A line that begins with one letter may be any of them.
                named = keywords if len(line.word) < 3 else (meant,)
                self.nameless.update(named if code.strip() == line.word else ())
        if node is None or self.headless:
            self._remember_words(line)
            if is_nameless(self.source, line):
                self.nameless.add(line.word)
        else:
            self.statements.append(node)

    def _lacks_bar(self, line: LogicalLine, below: LogicalLine | None) -> bool:
        header = next((n for n in self.lines if isinstance(n, sx.HeaderLine)), None)
        head = self.statements[-1]
        if header is None or line.kind != "unknown" or not isinstance(head, sx.Table):
            return False
        # Names above a row are not a second header.
        above_row = headless(self.source, line, below) == "header"
        return above_row or is_barless_row(self.source, line, len(header.terms), head.second is not None)

    def give_up(self, line: LogicalLine, message: str, help: str) -> None:
        """Report that parsing stops at a line: such a text is not a rule file, and further messages do not help."""
        place = Span(self.source, line.start, max(line.start, line.end))
        self.diagnostics.append(Diagnostic("FZ112", message, place, help=help))
        self.unread.update(_WORDS.findall(self.source.text, line.start))
        self.lost_input = self.lost_variable = True

    def _headless(self, line: LogicalLine, what: Headless) -> None:
        """Report a head without its keyword, once for the block that follows."""
        self._remember_words(line)
        self.diagnostics.append(describe_headless(self.source, line, what))
        self._begin_broken_block()
        self.lost_input = self.lost_input or what == "variable"

    def _begin_broken_block(self) -> None:
        self._close_block()
        self.block = "broken"
        # Its table is what could not be read.
        self.condition = None

    def _unknown(self, line: LogicalLine) -> None:
        self._remember_words(line)
        if self.block == "broken":
            return
        self.incomplete = True
        self.diagnostics.append(line.mistake or describe_unknown_line(self.source, line, self.block))
        self.condition = None
        meant = meant_keyword(line.word)
        if meant is not None and line.code(self.source).strip() == line.word:
            self.nameless.add(meant)
        meant = keyword_behind(line.code(self.source)) or meant
        is_variable = looks_like_variable(self.source, line)
        if meant in ("input", "output", "table") or is_variable:
            # It was the head of the block that follows.
            self._begin_broken_block()
            self.lost_input = self.lost_input or meant == "input" or is_variable

    def _take_statement(self, line: LogicalLine) -> None:
        node = self._parse(line, line.kind)
        if line.word != "table":
            self._drop_condition()
        elif node is None:
            self.condition = None
        if isinstance(node, sx.With):
            self.condition = node
        elif isinstance(node, sx.Table) and self.condition is not None:
            self.statements.append(dataclasses.replace(node, condition=self.condition.condition))
            self.condition = None
        elif node is not None:
            self.statements.append(node)
        else:
            self._remember_words(line)
            self.lost_input = self.lost_input or line.word == "input"
            if is_nameless(self.source, line):
                self.nameless.add(line.word)
        if line.word in ("input", "output", "let"):
            self.block = "variable" if node is not None else "broken"
        elif line.word == "table":
            self.block = "table" if node is not None else "broken"
        elif node is None and line.mistake is not None:
            # Whatever the open parenthesis swallowed may have been the beginning of a block.
            self.block = "broken"

    def _take_below(self, line: LogicalLine) -> None:
        wanted = "variable" if line.kind in ("term_line", "statement") else "table"
        if self.block == "broken":
            # Mistakes in the lines of a block whose head could not be read are reported, too.
            self._remember_words(line)
            self._parse(line, line.kind)
            return
        if self.block == "variable" and line.kind == "row" and looks_like_term(self.source, line):
            # A stray bar makes no row of it.
            wanted, line = "variable", dataclasses.replace(line, kind="term_line")
        if self.block != wanted:
            self._remember_words(line)
            self.diagnostics.append(line.mistake or orphan(self.source, line, wanted))
            self._begin_broken_block()
            self.lost_variable = self.lost_variable or wanted == "variable"
            return
        node = self._parse(line, line.kind)
        if node is None:
            self.incomplete = True
            self._remember_words(line)
        else:
            self.lines.append(node)

    def _parse(self, line: LogicalLine, kind: LineKind) -> Any:
        if line.mistake is not None:
            self.diagnostics.append(line.mistake)
            return None
        self._count(line)
        node, problems = parse_line(self.source, line, kind)
        self.diagnostics.extend(problems)
        odd = foreign(node, self.source.text)
        self.foreign.extend([odd] if odd is not None else [])
        return node

    def _count(self, line: LogicalLine) -> None:
        """Count the words that take long to read."""
        self.equations += bool(line.in_block) or line.word == "let"
        if self.equations > MAX_EQUATIONS:
            raise _TooMuchError(f"more than {MAX_EQUATIONS:,} lines of controllers, plants, loops and lets")
        self._count_words(line)

    def _count_words(self, line: LogicalLine) -> None:
        self.words += sum(1 for _ in _WORD_OR_PARENTHESIS.finditer(self.source.text, line.start, line.end))
        if self.words > MAX_WORDS:
            raise _TooMuchError(f"more than {MAX_WORDS:,} words, numbers and parentheses")

    def _drop_condition(self) -> None:
        """Report a `with` line that no table follows."""
        if self.condition is not None:
            message = "expected a table after the 'with' line"
            self.diagnostics.append(Diagnostic("FZ110", message, self.condition.span, help="put a table below it"))
        self.condition = None

    def _remember_words(self, line: LogicalLine) -> None:
        self.unread.update(_WORDS.findall(self.source.text, line.start, line.end))
        self._count_words(line)

    def _close_block(self) -> None:
        if self.barless:
            self.diagnostics.append(describe_barless(self.source, self.barless, self.statements[-1]))
            self.incomplete = True
        if self.block in ("variable", "table"):
            self.statements.extend(self._with_lines(self.statements.pop()))
        self.block, self.lines, self.incomplete, self.barless = "", [], False, []

    def _with_lines(self, head: sx.Statement) -> Iterator[sx.Statement]:
        """Yield the head of a block with the lines below it, each variable of a line by itself."""
        lines = tuple(self.lines)
        if isinstance(head, sx.Variable):
            first = dataclasses.replace(head, terms=lines, incomplete=self.incomplete, others=())
            yield first
            for name, label in head.others:
                yield dataclasses.replace(first, name=name, label=label)
        elif isinstance(head, sx.Table):
            header = next((n for n in lines if isinstance(n, sx.HeaderLine)), None)
            rows = tuple(n for n in lines if isinstance(n, sx.RowLine))
            yield dataclasses.replace(head, header=header, rows=rows, incomplete=self.incomplete)

    def finish(self) -> tuple[sx.SyntaxTree, list[Diagnostic]]:
        self._close_block()
        self._drop_condition()
        tree = sx.SyntaxTree(
            self.source,
            tuple(self.statements),
            unread=frozenset(self.unread),
            lost_variable=self.lost_variable,
            lost_input=self.lost_input or self.lost_variable,
            nameless=frozenset(self.nameless),
        )
        return tree, self.diagnostics
