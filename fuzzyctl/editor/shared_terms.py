"""Variables with equal terms: one of them can share its terms with the others, or all stand on one line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from fuzzyctl.diagnostics.fixes import Replacement
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.editor.document import Document
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.edits import masked
from fuzzyctl.lang.lines import tokens

#: What parts the names of a declaration from its range and its clauses.
_RANGE: Final = re.compile(r"\s+in\s*\[")


def shared_terms(document: Document, own: sx.Variable) -> Iterator[tuple[str, list[Replacement]]]:
    """Yield the changes that write terms once which several variables of a block have, each with a title."""
    group = _group(document, own)
    if len(group) < 2:
        return
    first, *others = group
    if own.span.start == first.span.start:
        names = _listed(document, others)
        yield f"share these terms with {names}", [_taking(document, s, first) for s in others]
    else:
        yield f"take the terms of '{first.name.text}'", [_taking(document, own, first)]
    joined = _on_one_line(document, own, group)
    if joined is not None:
        yield joined


def _group(document: Document, own: sx.Variable) -> list[sx.Variable]:
    """Return the variables of the block with the terms of one of them, in the order of the text."""
    block = document.symbols.scope_at(own.span.start)[0]
    terms = _terms(document, own)
    found: dict[int, sx.Variable] = {}
    for s in document.tree.statements:
        if not isinstance(s, sx.Variable) or s.span.source.name != document.source.name:
            continue
        is_equal = document.symbols.scope_at(s.span.start)[0] is block and terms and _terms(document, s) == terms
        if is_equal and (_is_relative(s) or _tail(s)[1] == _tail(own)[1]):
            found.setdefault(s.span.start, s)  # all variables of one line are one declaration
    return list(found.values())


def _terms(document: Document, s: sx.Variable) -> list[list[str]]:
    """Return the words of the term lines; nothing where these cannot be moved."""
    if not s.terms or s.incomplete or s.value is not None or "#" in _below(document, s).text:
        return []
    return [[t.text for t in tokens(line.span.text) if t.kind != "blank"] for line in s.terms]


def _below(document: Document, s: sx.Variable) -> Span:
    """Return what stands below a declaration: from the end of its line to the end of the line of its last term."""
    source, line = document.source, s.terms[-1].span.end_line
    end_of_first = source.line_start(s.span.end_line) + len(source.line_text(s.span.end_line))
    return Span(source, end_of_first, source.line_start(line) + len(source.line_text(line)))


def _is_relative(s: sx.Variable) -> bool:
    """Whether the terms follow the range, so that another range may share them."""
    items = [item for line in s.terms if isinstance(line, sx.TermsLine) for item in line.items]
    return len(s.terms) == 1 and bool(items) and all(i.peak is None and i.value is None for i in items)


def _tail(s: sx.Variable) -> tuple[str, str, str]:
    """Return a declaration in three parts: names, range, clauses."""
    text = s.span.text
    found = _RANGE.search(masked(text))
    at = found.start() if found is not None else len(text)
    close = text.find("]", at) + 1
    return text[:at], "".join(text[at:close].split()), " ".join(text[close:].split())


def _taking(document: Document, s: sx.Variable, of: sx.Variable) -> Replacement:
    below = _below(document, s)
    comment = document.text[s.span.end : below.start]
    return Replacement(Span(document.source, s.span.end, below.end), f" terms of {of.name.text}{comment}")


def _on_one_line(
    document: Document, own: sx.Variable, group: list[sx.Variable]
) -> tuple[str, list[Replacement]] | None:
    """Return the change that joins a variable with those of its group that stand beside it, equal but for the name."""
    like = [s for s in group if s.keyword.text == own.keyword.text and _tail(s)[1:] == _tail(own)[1:]]
    at = next(k for k, s in enumerate(like) if s.span.start == own.span.start)
    run = [like[at]]
    for s in like[at + 1 :]:
        if _is_blank_between(document, run[-1], s):
            run.append(s)
    for s in reversed(like[:at]):
        if _is_blank_between(document, s, run[0]):
            run.insert(0, s)
    if len(run) < 2:
        return None
    heads = [_tail(s)[0] for s in run]
    names = ", ".join([heads[0], *(h[len(own.keyword.text) :].strip() for h in heads[1:])])
    last = _below(document, run[-1])
    text = names + run[0].span.text[len(heads[0]) :] + _below(document, run[0]).text
    return f"declare {_listed(document, run)} on one line", [
        Replacement(Span(document.source, run[0].span.start, last.end), text)
    ]


def _listed(document: Document, declarations: list[sx.Variable]) -> str:
    """Return the names of all variables of some lines."""
    starts = {s.span.start for s in declarations}
    variables = (s for s in document.tree.statements if isinstance(s, sx.Variable) and s.span.start in starts)
    return ", ".join(f"'{s.name.text}'" for s in variables)


def _is_blank_between(document: Document, s: sx.Variable, after: sx.Variable) -> bool:
    """Whether two declarations stand one below the other without comments."""
    ends = (s.span.end, _below(document, s).start), (_below(document, s).end, after.span.start)
    return not any(document.text[a:b].strip() for a, b in (*ends, (after.span.end, _below(document, after).start)))
