"""Assembly of a file with the files that it uses: rule files and tables in CSV files; split into systems."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, Note
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.parser import parse
from fuzzyctl.records import dataclass
from fuzzyctl.support.files import files_in, is_below, read_source

#: Most files that one file may use, directly and through others.
MAX_FILES: Final = 64

#: Most characters of all files that one file brings in, a file as often as it is named.
MAX_BROUGHT: Final = 1 << 20

#: What `use` takes from a file.
_DECLARATIONS = (sx.Param, sx.Hedge, sx.Variable, sx.Function)


@dataclass(frozen=True)
class Part:
    """The statements of one system or controller.

    Args:
        tree: Its own statements.
        shared: Statements that it has in common with others: those before the first of several, and those of used
            files.
        head: Its first line, None for a system without a `system` line.
    """

    tree: sx.SyntaxTree
    shared: tuple[sx.Statement, ...]
    head: sx.System | sx.Head | None = None

    def is_shared(self, span: Span | None) -> bool:
        """Whether a place lies in a shared statement or in the lines below it."""
        return span is not None and any(
            span.source == s.span.source and s.span.start <= span.start <= _end(s) for s in self.shared
        )


def _end(statement: sx.Statement) -> int:
    below = statement.terms if isinstance(statement, sx.Variable) else ()
    return max([statement.span.end, *(line.span.end for line in below)])


def split(tree: sx.SyntaxTree) -> list[Part]:
    """Split a file into its systems and other blocks; lines before the first of several belong to all of them."""
    heads = [i for i, s in enumerate(tree.statements) if isinstance(s, sx.System | sx.Head)]
    if len(heads) < 2:
        first = tree.statements[heads[0]] if heads else None
        assert first is None or isinstance(first, sx.System | sx.Head)
        return [Part(tree, tree.used, first)]
    # One tuple for all of them: systems times statements would fill the memory.
    shared = (*tree.used, *tree.statements[: heads[0]])
    ends = [*heads[1:], len(tree.statements)]
    parts = []
    for a, b in zip(heads, ends, strict=True):
        head = tree.statements[a]
        assert isinstance(head, sx.System | sx.Head)
        parts.append(Part(dataclasses.replace(tree, statements=tree.statements[a:b]), shared, head))
    return parts


def without_other_loops(
    tree: sx.SyntaxTree, mistakes: list[Diagnostic], name: str
) -> tuple[sx.SyntaxTree, list[Diagnostic]]:
    """Return a tree and its mistakes without all loops but one; all of it if no loop has that name."""
    heads = [s for s in tree.statements if isinstance(s, sx.System | sx.Head)]
    loops = [h for h in heads if isinstance(h, sx.Head) and h.keyword.text == "loop"]
    if name not in [h.name.text for h in loops]:
        return tree, mistakes
    # Lines, as the statements may be those of a repaired text.
    ends = [*(h.span.line for h in heads[1:]), tree.source.line_of(len(tree.source.text)) + 1]
    left_out = [
        range(h.span.line, end) for h, end in zip(heads, ends, strict=True) if h in loops and h.name.text != name
    ]

    def stays(span: Span | None) -> bool:
        return span is None or not any(span.line in lines for lines in left_out)

    rest = [d for d in mistakes if stays(d.span)]
    statements = tuple(s for s in tree.statements if stays(s.span))
    return dataclasses.replace(tree, statements=statements, repaired=tree.repaired and bool(rest)), rest


def bring_in(tree: sx.SyntaxTree, folder: Path | None) -> tuple[sx.SyntaxTree, list[Diagnostic]]:
    """Read the files that a tree uses, and its tables in CSV files.

    Args:
        tree: The syntax tree.
        folder: The folder of the file; only files there and below can be used. None for a text without a file.

    Returns:
        The tree with `used` statements and filled tables, and the mistakes of all files read.
    """
    reader = _Reader(folder)
    statements = tuple(reader.fill(s) for s in reader.without_repeats(tree.statements))
    used = reader.use(tree.statements, (tree.source.name,))
    tree = dataclasses.replace(
        tree,
        statements=statements,
        used=tuple(used),
        unread=tree.unread | reader.unread,
        lost_variable=tree.lost_variable or reader.lost_variable,
        lost_input=tree.lost_input or reader.lost_input,
        lost_file=reader.lost_file,
        nameless=tree.nameless | reader.nameless,
    )
    return tree, reader.diagnostics


def path_below(folder: Path, name: str) -> Path | None:
    """Return the path of a file that a rule file in a folder names; None for one that lies elsewhere.

    A rule file from elsewhere must not be able to show files of other folders.
    """
    path = folder / name
    return path if is_below(path, folder) and not Path(name).is_absolute() else None


def files_read(path: Path, without: Collection[Path] = ()) -> tuple[Path, ...]:
    """Return the files that a rule file brings in, directly and through others, its tables in CSV files among them.

    Args:
        path: The rule file; it is not among them.
        without: Rule files that are left out, and what only these bring in.

    Raises:
        DiagnosticError: When it cannot be read; files that it names and that cannot be read are left out.
    """
    tree, _ = parse(read_source(path, only_regular=True))
    reader = _Reader(path.parent)
    reader.seen.update(without)
    for statement in tree.statements:
        reader.fill(statement)
    reader.use(tree.statements, (tree.source.name,))
    return tuple(dict.fromkeys(reader.read))


def _repeated(statement: sx.System, first: Span) -> Diagnostic:
    message = f"'system {statement.name.text}' is given twice"
    notes = (Note(first, "first given here"),)
    return Diagnostic("FZ215", message, statement.span, help="remove one of them", notes=notes)


class _Reader:
    """Reads files of one folder, each once."""

    def __init__(self, folder: Path | None) -> None:
        self.folder = folder
        self.diagnostics: list[Diagnostic] = []
        self.seen: set[Path] = set()
        #: Files that could be read, in the order of reading.
        self.read: list[Path] = []
        #: Mistakes of the files that were read, as in a syntax tree.
        self.unread: frozenset[str] = frozenset()
        self.nameless: frozenset[str] = frozenset()
        self.lost_variable = self.lost_input = self.lost_file = False
        #: Characters that may still be brought in, and the files read so far.
        self.left = MAX_BROUGHT
        self.sources: dict[Path, SourceText] = {}

    def without_repeats(self, statements: tuple[sx.Statement, ...]) -> Iterator[sx.Statement]:
        """Leave out `system` lines that repeat a name and have an empty block, or follow one with an empty block."""
        first: dict[str, int] = {}
        for i, s in enumerate(statements):
            if isinstance(s, sx.System):
                earlier = first.setdefault(s.name.text, i)
                is_empty = i + 1 == len(statements) or isinstance(statements[i + 1], sx.System)
                if earlier < i and (is_empty or earlier == i - 1):
                    self.diagnostics.append(_repeated(s, statements[earlier].span))
                    continue
            yield s

    def use(self, statements: tuple[sx.Statement, ...], chain: tuple[str, ...]) -> list[sx.Statement]:
        results: list[sx.Statement] = []
        for s in statements:
            if not isinstance(s, sx.Use):
                continue
            path = self._path(s.path, s.path_span)
            if path is None:
                self._lose_all()
                continue
            if str(path) in chain or path.name in {Path(c).name for c in chain if Path(c).parent == path.parent}:
                way = " → ".join(Path(c).name for c in (*chain, str(path)))
                self._report("a file uses itself", s.path_span, facts=(way,), help="remove one 'use'")
            elif path not in self.seen and len(self.seen) == MAX_FILES:
                self._report(f"more than {MAX_FILES} files are used", s.path_span)
                self._lose_all()
                return results
            elif path not in self.seen:
                self.seen.add(path)
                results.extend(self._declarations(path, s.path_span, (*chain, str(path))))
        return results

    def _declarations(self, path: Path, place: Span, chain: tuple[str, ...]) -> list[sx.Statement]:
        source = self._read(path, place)
        if source is None:
            self._lose_all()
            return []
        tree, mistakes = parse(source)
        self.unread |= tree.unread
        self.nameless |= tree.nameless
        self.lost_variable = self.lost_variable or tree.lost_variable
        self.lost_input = self.lost_input or tree.lost_input
        self.diagnostics.extend(mistakes)
        heads = [i for i, s in enumerate(tree.statements) if isinstance(s, sx.System | sx.Head)]
        common = tree.statements[: heads[0]] if heads else tree.statements
        return [*self.use(common, chain), *(s for s in common if isinstance(s, _DECLARATIONS))]

    def _lose_all(self) -> None:
        self.lost_variable = self.lost_input = self.lost_file = True

    def fill(self, statement: sx.Statement) -> sx.Statement:
        if not isinstance(statement, sx.Table) or not statement.csv or statement.csv_span is None:
            return statement
        if statement.header is not None or statement.rows:
            self._report("the table has rows here and in a file", statement.csv_span, help="keep one of them")
            return dataclasses.replace(statement, incomplete=True)
        path = self._path(statement.csv, statement.csv_span)
        source = self._read(path, statement.csv_span) if path is not None else None
        if source is None:
            return dataclasses.replace(statement, incomplete=True)
        from fuzzyctl.lang.csv_table import parse_csv_table

        table, mistakes = parse_csv_table(statement, source)
        self.diagnostics.extend(mistakes)
        return table

    def _path(self, name: str, place: Span) -> Path | None:
        if self.folder is None:
            self._report("a text without a file cannot use files", place, help="write it to a file and load that")
            return None
        path = path_below(self.folder, name)
        if path is None:
            self._report(f"'{name}' lies outside the folder of this file", place, help="move it there or below")
        return path

    def _read(self, path: Path, place: Span) -> SourceText | None:
        if self.left < 0:
            return None
        try:
            source = self.sources.get(path) or read_source(path, only_regular=True)
            self.sources[path] = source
            self.read.append(path)
            self.left -= len(source.text)
            if self.left < 0:
                message = f"the files that this one names hold more than {MAX_BROUGHT:,} characters together"
                self._report(message, place, help="leave some out; a file counts as often as it is named")
                self.lost_file = True
                return None
            return source
        except DiagnosticError as error:
            (why,) = error.diagnostics
            help_text = self._similar(path, place) if why.code == "FZ001" and not os.path.lexists(path) else why.help
            self._report(f"{place.text} cannot be used: {why.message}", place, facts=why.facts, help=help_text)
            return None

    def _similar(self, path: Path, place: Span) -> str:
        """Name the file of that kind that was most likely meant, relative to the file that uses it."""
        user = Path(place.source.name).name
        files = files_in(path.parent, {path.suffix.lower()} - {""})
        names = [name for name in files if name != user or path.parent != self.folder]
        near = closest(path.name, names)
        return f"did you mean '{path.with_name(near).relative_to(self.folder or path.parent)}'?" if near else ""

    def _report(self, message: str, place: Span, *, facts: tuple[str, ...] = (), help: str = "") -> None:
        self.diagnostics.append(Diagnostic("FZ218", message, place, facts=facts, help=help))
