"""Translation of an FML document: attributes and elements, and what tools read differently."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Final

from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.expr import Number
from fuzzyctl.formats.common.translation import Meaning, Translation
from fuzzyctl.formats.fml.document import Element
from fuzzyctl.lang import syntax as sx
from fuzzyctl.support.numerals import to_number

#: Attributes that any element may have.
_EVERYWHERE: Final = frozenset({"networkaddress", "ip"})

#: Most misplaced elements reported one by one.
_MOST_STRANGERS: Final = 20


class Markup(Translation):
    """The statements of a document.

    Args:
        source: The file.
        draft: Whether shapes are spelt with a capital, as before the standard.

    Attributes:
        unsure: Where something stands that tools read differently, by what it is.
    """

    def __init__(self, source: SourceText, *, draft: bool) -> None:
        super().__init__(source)
        self.draft = draft
        self.unsure: dict[str, Span] = {}

    def known(self, element: Element, attributes: Collection[str], children: Collection[str]) -> None:
        """Tell attributes without effect, and refuse elements that do not belong here."""
        for name, value in element.attributes.items():
            if name in _EVERYWHERE:
                if value not in ("", "127.0.0.1"):
                    message = f"{name} '{value}' has no effect: the system is evaluated here"
                    self.warning("FZ603", message, element.place(name))
            elif name not in attributes:
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

    def only(self, element: Element, *names: str) -> Element | None:
        """Return the child of one of some names; further ones are refused, as nothing would read them."""
        elements = list(element.all(*names))
        for again in elements[1:2]:
            message = f"a second <{again.tag}> in <{element.tag}>"
            self.error("FZ215", message, again.span, help="one is read; write another element for the other")
        return elements[0] if elements else None

    def name(self, element: Element) -> sx.Word | None:
        """Return the name of an element; None, with an error, for none."""
        text = self._required(element, "name")
        return None if text is None else sx.Word(text, element.place("name"))

    def _required(self, element: Element, attribute: str) -> str | None:
        text = one_line(element.attributes.get(attribute, ""))
        if not text:
            help_text = f'write: <{element.tag} {attribute}="..."'
            self.error("FZ601", f"<{element.tag}> has no '{attribute}'", element.span, help=help_text)
        return text or None

    def value(self, element: Element, attribute: str, usual: Number | None = None) -> Number | None:
        """Return an attribute that is a number, or the usual one; None, with an error, for a missing or wrong one."""
        if usual is not None and not element.attributes.get(attribute, "").strip():
            return usual
        text = self._required(element, attribute)
        return None if text is None else self.parsed(text, f"'{attribute}'", element.place(attribute))

    def parsed(self, text: str, what: str, span: Span) -> Number | None:
        """Return a finite number, None with an error for any other text."""
        try:
            value = to_number(text)
        except (ValueError, OverflowError):
            value = math.nan
        if not math.isfinite(value):
            self.error("FZ601", f"{what} is '{text.strip()[:40]}', which is not a finite number", span)
            return None
        return Number(value, "", span)

    def choice(
        self,
        element: Element,
        attribute: str,
        words: Mapping[str, Meaning],
        usual: Meaning,
        what: str = "method",
    ) -> Meaning:
        """Return what the word in an attribute means, the usual thing where there is none."""
        text = element.attributes.get(attribute, "").strip()
        if not text:
            return usual
        meaning = self.look_up(element.place(attribute), words, what, word=text.upper(), code="FZ213")
        return usual if meaning is None else meaning

    def flag(self, element: Element, attribute: str) -> bool:
        """Return whether an attribute is true; report what is neither true nor false."""
        return self.choice(element, attribute, {"TRUE": True, "FALSE": False}, False, "truth value")

    def tell_unsure(self) -> None:
        """Say once for each what tools read differently."""
        for message, span in self.unsure.items():
            self.warning("FZ609", message, span, help="compare with the tool that wrote the file")


def one_line(text: str) -> str:
    """Return a text with runs of blanks and line ends as one blank, so that a name is the same everywhere."""
    return " ".join(text.split())
