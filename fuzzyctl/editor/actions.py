"""Code actions that write lacking parts of a rule file or rewrite them, and the layout of some lines."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.fixes import Fix, Replacement, fixed
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.editor.document import Document
from fuzzyctl.expr import ONE, to_text
from fuzzyctl.formats.fz import membership_text
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.formatter import format_source
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable


@dataclass(frozen=True)
class Action:
    """A change that is offered.

    Args:
        title: A title for the user.
        replacements: The change.
        rewrites: Whether the file means the same afterwards.
    """

    title: str
    replacements: tuple[Replacement, ...]
    rewrites: bool = False


def actions(document: Document, offset: int) -> list[Action]:
    """Return the changes that are possible at an offset besides repairs of mistakes."""
    statement = _statement_at(document, offset)
    offers: Iterator[Action] = iter(())
    if isinstance(statement, sx.Table) and not statement.csv:
        offers = _table(document, statement)
    elif isinstance(statement, sx.Variable):
        offers = _variable(document, statement)
    return list(offers)


def repairs(found: Sequence[Diagnostic], first: int, last: int) -> list[Diagnostic]:
    """Return the diagnostics that have a repair, and stand or are repaired within the offsets `first` to `last`."""
    repairable = []
    for d in found:
        if d.fix is None or d.span is None:
            continue
        spans = [Span(d.span.source, r.span.start, r.span.end) for r in d.fix.replacements] + [d.span]
        if any(s.start <= last and first <= max(s.end, s.start) for s in spans):
            repairable.append(d)
    return repairable


def repair_title(d: Diagnostic) -> str:
    """Return the title of the repair of a diagnostic."""
    return d.help.split("\n")[0] if d.help else f"repair: {d.message}"


def _statement_at(document: Document, offset: int) -> sx.Statement | None:
    """Return the statement whose lines, those below it included, hold an offset."""
    line = document.source.line_of(offset)
    for s in document.tree.statements:
        if s.span.source.name == document.source.name and s.span.line <= line <= _last_line(s):
            return s
    return None


def _last_line(s: sx.Statement) -> int:
    below: tuple[sx.Statement, ...] = ()
    if isinstance(s, sx.Variable):
        below = s.terms
    elif isinstance(s, sx.Table) and not s.csv:
        below = (*((s.header,) if s.header is not None else ()), *s.rows)
    return max(line.span.end_line for line in (s, *below))


# -- tables


def _table(document: Document, table: sx.Table) -> Iterator[Action]:
    terms = document.symbols.scope_at(table.span.start)[0].terms
    rows = list(terms.get(table.first.text, ())) if table.second is not None else []
    columns = list(terms.get(table.second.text if table.second is not None else table.first.text, ()))
    header = table.header
    given = {r.label.text for r in table.rows if r.label is not None}
    more_rows = [name for name in rows if name not in given]
    more_columns = [] if header is None else [c for c in columns if c not in {w.text for w in header.terms}]
    if more_rows and (header is not None or not table.rows):
        width = len(header.terms) if header is not None else len(columns)
        new = [f"  {name} |" + "  ." * width for name in more_rows]
        if header is None:
            new.insert(0, "    " + "  ".join(columns))
        at = _end_of_line(document.source, _last_line(table))
        change = Replacement(Span(document.source, at, at), "".join(f"\n{line}" for line in new))
        yield _with_layout(document, f"add {counted(len(more_rows), 'missing row')}", [change], table)
    if more_columns and header is not None:
        lines = [(header.span, "  ".join(more_columns)), *((r.span, "  ." * len(more_columns)) for r in table.rows)]
        changes = [Replacement(Span(document.source, s.end, s.end), f"  {text.strip()}") for s, text in lines]
        yield _with_layout(document, f"add {counted(len(more_columns), 'missing column')}", changes, table)


def _end_of_line(source: SourceText, line: int) -> int:
    return source.line_start(line) + len(source.line_text(line))


def _with_layout(document: Document, title: str, changes: list[Replacement], table: sx.Table) -> Action:
    """Return an action that also aligns the lines of the table."""
    source = document.source
    after = SourceText(source.name, fixed(source, [Fix(tuple(changes), "sure")]))
    first, last = table.span.line, _last_line(table)
    added = after.line_count - source.line_count
    laid = fixed(after, [Fix(tuple(laid_out(after, first, last + added)), "sure")])
    lines = laid.split("\n")[first - 1 : last + added]
    place = Span(source, source.line_start(first), _end_of_line(source, last))
    return Action(title, (Replacement(place, "\n".join(lines)),))


# -- variables


def _variable(document: Document, s: sx.Variable) -> Iterator[Action]:
    source = document.source
    if s.keyword.text == "output" and s.value is None and not any(isinstance(c, sx.FallbackClause) for c in s.clauses):
        at = Span(source, s.span.end, s.span.end)
        yield Action("add 'else midpoint', the output where no rule fires", (Replacement(at, " else midpoint"),))
    if len(s.terms) == 1 and isinstance(s.terms[0], sx.TermsLine):
        yield from _rewritten(document, s, "write the terms as functions, one a line", _as_lines)
    elif s.terms and all(isinstance(line, sx.TermLine) for line in s.terms):
        yield from _rewritten(document, s, "write the terms as one line of peaks", _as_partition)


def _as_lines(_: FuzzySystem, variable: LinguisticVariable) -> list[str]:
    return [f"  {t.name} = {membership_text(t.membership)}" for t in variable.terms]


def _as_partition(system: FuzzySystem, variable: LinguisticVariable) -> list[str]:
    """Return the `terms` line that means the same functions; an empty list without one."""
    sets = [t.membership for t in variable.terms]
    names = [t.name for t in variable.terms]
    if any(m.height != ONE for m in sets):
        return []
    if {m.kind for m in sets} == {"singleton"}:
        values = [to_text(m.arguments[0]) for m in sets]
        return ["  terms " + " ".join(f"{n}={v}" for n, v in zip(names, values, strict=True))]
    if {m.kind for m in sets} != {"triangle"} or len(sets) < 2:
        return []
    corners = [tuple(system.number(e) for e in m.arguments) for m in sets]
    peaks = [peak for _, peak, _ in corners]
    if corners != _triangles(peaks):
        return []
    low, high, last = system.number(variable.lower), system.number(variable.upper), len(peaks) - 1
    even = [low, *((low * (last - k) + high * k) / last for k in range(1, last)), high]
    at = ["" if peaks == even else f"@{to_text(m.arguments[1])}" for m in sets]
    return ["  terms " + " ".join(f"{n}{p}" for n, p in zip(names, at, strict=True))]


def _triangles(peaks: list[float]) -> list[tuple[float, ...]]:
    """Return the corners of triangles that each reach from the peak before to the peak behind."""
    ends = [-math.inf, *peaks, math.inf]
    return [tuple(ends[k : k + 3]) for k in range(len(peaks))]


def _rewritten(
    document: Document, s: sx.Variable, title: str, form: Callable[[FuzzySystem, LinguisticVariable], list[str]]
) -> Iterator[Action]:
    """Yield the action that writes the terms in another form that means the same."""
    for system in document.examined.systems:
        for variable in system.variables:
            if variable.span is None or variable.span.start != s.name.span.start:
                continue
            lines = form(system, variable)
            first, last = s.terms[0].span, s.terms[-1].span
            start = document.text.rfind("\n", 0, first.start) + 1
            change = Replacement(Span(document.source, start, last.end), "\n".join(lines))
            if lines and "#" not in change.span.text:
                yield Action(title, (change,), rewrites=True)
            return


def laid_out(source: SourceText, first: int, last: int) -> list[Replacement]:
    """Return the changes that give some lines their canonical layout; blank lines stay.

    Args:
        source: The text.
        first, last: Lines, from 1.
    """
    after = [line for line in format_source(source).split("\n") if line.strip()]
    before = [n for n in range(1, source.line_count + 1) if source.line_text(n).strip()]
    if len(before) != len(after):  # as where lines were joined
        return []
    changes = []
    for n, now in zip(before, after, strict=True):
        line = source.line_text(n)
        if first <= n <= last and line != now:
            at = source.line_start(n)
            changes.append(Replacement(Span(source, at, at + len(line)), now))
    return changes


def typed(document: Document, offset: int, character: str) -> list[Replacement]:
    """Return the changes of a table's lines after a character was typed in it.

    Behind `|` the lines above the cursor's are laid out, not its own, which is still being written; behind a line feed
    all that stand above it. Elsewhere nothing changes.

    Args:
        document: The document, with the character in it.
        offset: The offset behind the character.
        character: "|" or a line feed.
    """
    line = document.source.line_of(offset)
    kinds = {document.source.line_of(x.start): x for x in document.lines}
    at = line - 1
    while at in kinds and kinds[at].kind in ("row", "header"):
        at -= 1
    if at == line - 1 or at not in kinds or kinds[at].word != "table":
        return []
    if character == "|":
        own = kinds.get(line)
        if own is None or own.kind != "row":
            return []
    return laid_out(document.source, at, line - 1)
