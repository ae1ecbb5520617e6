"""XML elements with locations; entity expansion and unlimited nesting are refused."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final
from xml.parsers import expat

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText, Span

#: Deepest nesting of elements.
MAX_DEPTH: Final = 100

#: An attribute of a start tag with its value.
_ATTRIBUTE: Final = re.compile(r"""\s+([^\s=<>/]+)\s*=\s*("[^"]*"|'[^']*')""")

#: An entity that XML does not define.
_ENTITY: Final = re.compile(r"&(?!(?:amp|lt|gt|quot|apos);|#)[^\s;<>&\"']*;")


@dataclass(eq=False)
class Element:
    """An element of an XML document.

    Args:
        tag: Its name as written, without a namespace prefix.
        foreign: Whether it has a namespace prefix, so that it may belong to another language.
        attributes: Values by name in small letters.
        span: Its start tag up to the end of its name.
        children: The elements in it.
        text: The characters directly in it.
    """

    tag: str
    foreign: bool
    attributes: dict[str, str]
    span: Span
    children: list[Element] = field(default_factory=list)
    text: str = ""

    @property
    def name(self) -> str:
        """Its name in small letters, as elements are compared."""
        return self.tag.lower()

    def all(self, *names: str) -> Iterator[Element]:
        """Yield the children of some names, given in small letters."""
        return (c for c in self.children if c.name in names)

    def place(self, attribute: str) -> Span:
        """Return where an attribute stands, the element where it has none."""
        return self._places.get(attribute.lower(), self.span)

    @cached_property
    def _places(self) -> dict[str, Span]:
        """Where each attribute stands, found in one walk through the start tag; values may hold `>`."""
        source, found = self.span.source, {}
        match = _ATTRIBUTE.match(source.text, self.span.end)
        while match is not None:
            found[match.group(1).lower()] = Span(source, match.start(2), match.end(2))
            match = _ATTRIBUTE.match(source.text, match.end())
        return found


class _RefusedError(Exception):
    """Raised at what is refused, with its diagnostic."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic


def parse_document(source: SourceText) -> tuple[Element | None, list[Diagnostic]]:
    """Return the root element of a document; None, with a diagnostic, for one that is no XML or that is refused."""
    if not source.text.strip():
        help_text = "FML of IEEE 1855 begins with <fuzzySystem name=...>"
        return None, [Diagnostic("FZ004", "the file is empty", file=source.name, help=help_text)]
    reader = _Reader(source)
    try:
        reader.parse()
    except _RefusedError as refused:
        return None, [refused.diagnostic]
    except expat.ExpatError as error:
        return None, [reader.broken(error)]
    return reader.root, []


class _Reader:
    def __init__(self, source: SourceText) -> None:
        self._source = source
        self._data = source.text.encode("utf-8", "replace")
        self._ascii = len(self._data) == len(source.text)
        self._seen = (0, 0)
        self._open: list[Element] = []
        self.root: Element | None = None

    def parse(self) -> None:
        # The text is decoded already, so that an encoding which the document declares says nothing any more.
        parser = expat.ParserCreate("utf-8")
        parser.buffer_text = True
        parser.StartElementHandler = lambda tag, attributes: self._start(parser, tag, attributes)
        parser.EndElementHandler = lambda _tag: self._open.pop()
        parser.CharacterDataHandler = self._characters
        parser.StartDoctypeDeclHandler = lambda *_: self._refuse_declarations(parser)
        parser.EntityDeclHandler = lambda *_: self._refuse_declarations(parser)
        parser.Parse(self._data, True)

    def _offset(self, at: int) -> int:
        """Return the offset in characters of one in bytes; they are asked for in rising order."""
        if self._ascii:
            return at
        seen_bytes, seen = self._seen
        if at < seen_bytes:
            seen_bytes, seen = 0, 0
        self._seen = (at, seen + len(self._data[seen_bytes:at].decode("utf-8", "replace")))
        return self._seen[1]

    def _start(self, parser: Any, tag: str, attributes: dict[str, str]) -> None:
        start = self._offset(parser.CurrentByteIndex)
        span = Span(self._source, start, start + 1 + len(tag))
        if len(self._open) >= MAX_DEPTH:
            raise _RefusedError(Diagnostic("FZ106", f"elements are nested more than {MAX_DEPTH} deep", span))
        plain = {n.lower(): v for n, v in attributes.items() if ":" not in n and n != "xmlns"}
        element = Element(tag.rpartition(":")[2], ":" in tag, plain, span)
        if self._open:
            self._open[-1].children.append(element)
        else:
            self.root = element
        self._open.append(element)

    def _characters(self, text: str) -> None:
        if self._open:
            self._open[-1].text += text

    def _refuse_declarations(self, parser: Any) -> None:
        start = self._offset(parser.CurrentByteIndex)
        message = "a document type declaration is refused: it could expand without end, or read other files"
        span = Span(self._source, start, start + len("<!DOCTYPE"))
        raise _RefusedError(Diagnostic("FZ602", message, span, help="remove <!DOCTYPE ...>; FML needs none"))

    def broken(self, error: expat.ExpatError) -> Diagnostic:
        """Return what is wrong with a document that is no XML."""
        lines = self._source.text.split("\n")
        line = min(max(error.lineno, 1), len(lines))
        start = sum(len(text) + 1 for text in lines[: line - 1]) + min(error.offset, len(lines[line - 1]))
        facts = tuple(f"not closed: <{e.tag}> of line {e.span.line}" for e in self._open[-3:])
        if error.code == expat.errors.codes[expat.errors.XML_ERROR_UNDEFINED_ENTITY]:
            return self._undefined_entity(start)
        reason = expat.ErrorString(error.code) or "broken"
        ends = reason in ("no element found", "unclosed token")
        message = "the file ends before its XML does" if ends and self._open else f"the XML is broken: {reason}"
        return Diagnostic("FZ601", message, Span(self._source, start, start + 1), facts=facts)

    def _undefined_entity(self, start: int) -> Diagnostic:
        """Return the diagnostic of the first entity from a place on that XML does not have; it begins its element."""
        match = _ENTITY.search(self._source.text, start)
        span = Span(self._source, *match.span()) if match is not None else Span(self._source, start, start + 1)
        help_text = "write &amp; for an ampersand; other characters stand for themselves"
        return Diagnostic("FZ601", f"there is no entity '{span.text[:40]}'", span, help=help_text)
