"""XML elements with locations, and checks of their attributes and children.

Entity expansion and unlimited nesting are refused.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final
from xml.parsers import expat

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.expr import Number
from fuzzyctl.formats.common.report import ParseError
from fuzzyctl.formats.common.translation import Meaning, Translation
from fuzzyctl.lang import syntax as sx
from fuzzyctl.support.files import to_number

#: Deepest nesting of elements.
MAX_DEPTH: Final = 100

#: Attributes that name the computer of an element, by default the local one.
_ADDRESSES: Final = ("networkaddress", "ip")

#: Most misplaced elements reported one by one.
_MOST_STRANGERS: Final = 20

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
        """Yield the children with some names, given in small letters."""
        return (c for c in self.children if c.name in names)

    def place(self, attribute: str) -> Span:
        """Return the location of the value of an attribute, or of the element if it is missing."""
        return self._places.get(attribute.lower(), self.span)

    @cached_property
    def _places(self) -> dict[str, Span]:
        """Locations of attributes, by one walk through the start tag; values may hold `>`."""
        source = self.span.source
        places: dict[str, Span] = {}
        match = _ATTRIBUTE.match(source.text, self.span.end)
        while match is not None:
            places[match.group(1).lower()] = Span(source, match.start(2), match.end(2))
            match = _ATTRIBUTE.match(source.text, match.end())
        return places


# --- parsing ---------------------------------------------------------------------------------------------------------


def parse_document(source: SourceText) -> tuple[Element | None, list[Diagnostic]]:
    """Return the root element of a document; None, with a diagnostic, if it is broken or refused."""
    if not source.text.strip():
        help_text = "FML of IEEE 1855 begins with <fuzzySystem name=...>"
        return None, [Diagnostic("FZ004", "the file is empty", file=source.name, help=help_text)]
    parser = _Parser(source)
    try:
        parser.parse()
    except ParseError as error:
        return None, [error.diagnostic]
    except expat.ExpatError as error:
        return None, [parser.broken(error)]
    return parser.root, []


class _Parser:
    def __init__(self, source: SourceText) -> None:
        self._source = source
        self._data = source.text.encode("utf-8", "replace")
        self._ascii = len(self._data) == len(source.text)
        self._last = (0, 0)  # an offset in bytes and in characters
        self._open: list[Element] = []
        self.root: Element | None = None

    def parse(self) -> None:
        # The text is decoded already, so that the declared encoding has no effect.
        parser = expat.ParserCreate("utf-8")
        parser.buffer_text = True
        parser.StartElementHandler = lambda tag, attributes: self._start(parser, tag, attributes)
        parser.EndElementHandler = lambda _tag: self._open.pop()
        parser.CharacterDataHandler = self._characters
        parser.StartDoctypeDeclHandler = lambda *_: self._refuse_declarations(parser)
        parser.EntityDeclHandler = lambda *_: self._refuse_declarations(parser)
        parser.Parse(self._data, True)

    def _offset(self, at: int) -> int:
        """Return the offset in characters of an offset in bytes; calls come in rising order."""
        if self._ascii:
            return at
        start, characters = self._last if at >= self._last[0] else (0, 0)
        self._last = (at, characters + len(self._data[start:at].decode("utf-8", "replace")))
        return self._last[1]

    def _start(self, parser: Any, tag: str, attributes: dict[str, str]) -> None:
        start = self._offset(parser.CurrentByteIndex)
        span = Span(self._source, start, start + 1 + len(tag))
        if len(self._open) >= MAX_DEPTH:
            raise ParseError(f"elements are nested more than {MAX_DEPTH} deep", span, "FZ106")
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
        raise ParseError(message, span, "FZ602", help="remove <!DOCTYPE ...>; FML needs none")

    def broken(self, error: expat.ExpatError) -> Diagnostic:
        """Return the diagnostic of broken XML."""
        lines = self._source.text.split("\n")
        line = min(max(error.lineno, 1), len(lines))
        start = sum(len(text) + 1 for text in lines[: line - 1]) + min(error.offset, len(lines[line - 1]))
        facts = tuple(f"not closed: <{e.tag}> of line {e.span.line}" for e in self._open[-3:])
        if error.code == expat.errors.codes[expat.errors.XML_ERROR_UNDEFINED_ENTITY]:
            return self._undefined_entity(start)
        reason = expat.ErrorString(error.code) or "broken"
        ends = reason in ("no element found", "unclosed token")
        message = "the file ends before its XML does" if ends and self._open else f"the XML is broken: {reason}"
        return Diagnostic("FZ601", message, self._character(start), facts=facts)

    def _character(self, start: int) -> Span:
        return Span(self._source, start, min(start + 1, len(self._source.text)))

    def _undefined_entity(self, start: int) -> Diagnostic:
        """Return the diagnostic of the first undefined entity from an offset on, the start of its element."""
        match = _ENTITY.search(self._source.text, start)
        span = Span(self._source, *match.span()) if match is not None else self._character(start)
        help_text = "write &amp; for an ampersand; other characters stand for themselves"
        return Diagnostic("FZ601", f"there is no entity '{span.text[:40]}'", span, help=help_text)


# --- checks ----------------------------------------------------------------------------------------------------------


class Markup(Translation):
    """The statements and diagnostics of a document.

    Args:
        source: The file.
        draft: Whether names of shapes begin with a capital, as before the standard.
    """

    def __init__(self, source: SourceText, *, draft: bool) -> None:
        super().__init__(source)
        self.draft = draft
        self._doubts: dict[str, Span] = {}

    def check_parts(self, element: Element, attributes: Collection[str], children: Collection[str]) -> None:
        """Warn of attributes without effect, and report misplaced elements."""
        for name, value in element.attributes.items():
            is_address = name in _ADDRESSES and value in ("", "127.0.0.1")
            if name not in attributes and not is_address:
                message = f"the attribute '{name}' of <{element.tag}> has no effect"
                self.warning("FZ603", message, element.place(name), help=did_you_mean(name, attributes))
        strangers = [c for c in element.children if c.name not in children]
        for child in strangers[:_MOST_STRANGERS]:
            if child.foreign:
                self.warning("FZ603", f"<{child.tag}> of another namespace has no effect", child.span)
                continue
            facts = (f"possible here: {listed(children)}",) if children else ()
            message, help_text = f"<{child.tag}> does not belong in <{element.tag}>", did_you_mean(child.name, children)
            self.error("FZ601", message, child.span, facts=facts, help=help_text)
        if len(strangers) > _MOST_STRANGERS:
            message = f"{len(strangers) - _MOST_STRANGERS} more elements do not belong in <{element.tag}>"
            self.error("FZ601", message, element.span)

    def only_child(self, element: Element, *names: str) -> Element | None:
        """Return the first child with one of some names; report a second one."""
        elements = list(element.all(*names))
        for again in elements[1:2]:
            message = f"a second <{again.tag}> in <{element.tag}>"
            self.error("FZ215", message, again.span, help="one is read; write another element for the other")
        return elements[0] if elements else None

    def name_of(self, element: Element) -> sx.Word | None:
        """Return the name of an element; None, with an error, if it is missing."""
        text = self._required(element, "name")
        return sx.Word(text, element.place("name")) if text else None

    def _required(self, element: Element, attribute: str) -> str:
        text = one_line(element.attributes.get(attribute, ""))
        if not text:
            help_text = f'write: <{element.tag} {attribute}="..."'
            self.error("FZ601", f"<{element.tag}> has no '{attribute}'", element.span, help=help_text)
        return text

    def number_of(self, element: Element, attribute: str, default: Number | None = None) -> Number | None:
        """Return a numeric attribute, or the default; None, with an error, if it is missing or invalid."""
        if default is not None and not element.attributes.get(attribute, "").strip():
            return default
        text = self._required(element, attribute)
        return self.finite_number(text, f"'{attribute}'", element.place(attribute)) if text else None

    def finite_number(self, text: str, description: str, span: Span) -> Number | None:
        """Return a finite number, None with an error for any other text."""
        try:
            value = to_number(text)
        except (ValueError, OverflowError):
            value = math.nan
        if not math.isfinite(value):
            self.error("FZ601", f"{description} is '{text.strip()[:40]}', which is not a finite number", span)
            return None
        return Number(value, "", span)

    def choice(
        self,
        element: Element,
        attribute: str,
        words: Mapping[str, Meaning],
        default: Meaning,
        description: str = "method",
    ) -> Meaning:
        """Return the meaning of the word in an attribute, or the default."""
        text = element.attributes.get(attribute, "").strip()
        if not text:
            return default
        meaning = self.look_up(element.place(attribute), words, description, word=text.upper(), code="FZ213")
        return default if meaning is None else meaning

    def is_true(self, element: Element, attribute: str) -> bool:
        """Return whether an attribute is true; report a value that is neither true nor false."""
        return self.choice(element, attribute, {"TRUE": True, "FALSE": False}, False, "truth value")

    def doubt(self, message: str, span: Span) -> None:
        """Note a difference between tools at its first place."""
        self._doubts.setdefault(message, span)

    def report_doubts(self) -> None:
        """Warn of each difference between tools once."""
        for message, span in self._doubts.items():
            self.warning("FZ609", message, span, help="compare with the tool that wrote the file")


def one_line(text: str) -> str:
    """Return a text with runs of blanks and line ends as one blank, so that a name is the same everywhere."""
    return " ".join(text.split())
