"""Diagnostics and attributes of an FML document while it is read."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.expr import Number
from fuzzyctl.support.shipped import to_number
from tests.oracles.fml.document import Element
from tests.oracles.reporter import Reporter

#: Attributes that any element may have.
_EVERYWHERE: Final = frozenset({"networkaddress", "ip"})

#: Most misplaced elements reported one by one.
_MOST_STRANGERS: Final = 20


@dataclass
class Scope(Reporter):
    """The diagnostics of a document.

    Args:
        draft: Whether shapes are spelt with a capital, as before the standard.
        diagnostics: What was found so far.
        unsure: Where something stands that tools read differently, by what it is.
    """

    draft: bool = False
    diagnostics: list[Diagnostic] = field(default_factory=list)
    unsure: dict[str, Span] = field(default_factory=dict)

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
                message = f"<{child.tag}> of another namespace has no effect"
                self.warning("FZ603", message, child.span)
                continue
            facts = (f"possible here: {listed(children)}",) if children else ()
            help_text = did_you_mean(child.name, children)
            message = f"<{child.tag}> does not belong in <{element.tag}>"
            self.error("FZ601", message, child.span, facts=facts, help=help_text)
        if len(strangers) > _MOST_STRANGERS:
            message = f"{len(strangers) - _MOST_STRANGERS} more elements do not belong in <{element.tag}>"
            self.error("FZ601", message, element.span)

    def only(self, element: Element, *names: str) -> Element | None:
        """Return the child of one of some names; further ones are refused, as nothing would read them."""
        found = list(element.all(*names))
        for again in found[1:2]:
            message = f"a second <{again.tag}> in <{element.tag}>"
            self.error("FZ215", message, again.span, help="one is read; write another element for the other")
        return found[0] if found else None

    def required(self, element: Element, attribute: str) -> str | None:
        """Return the value of an attribute, None, with an error, where it is missing or empty.

        Runs of blanks and line ends count as one blank, as in elements, so that a name is the same in both.
        """
        value = " ".join(element.attributes.get(attribute, "").split())
        if not value:
            help_text = f'write: <{element.tag} {attribute}="..."'
            self.error("FZ601", f"<{element.tag}> has no '{attribute}'", element.span, help=help_text)
            return None
        return value

    def number(self, element: Element, attribute: str) -> Number | None:
        """Return an attribute that is a number; None, with an error, for one that is missing or none."""
        text = self.required(element, attribute)
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

    def choice(self, element: Element, attribute: str, words: Mapping[str, str], usual: str) -> str:
        """Return what the word in an attribute stands for, `usual` where there is none."""
        text = element.attributes.get(attribute, "").strip()
        if not text:
            return usual
        if text.upper() in words:
            return words[text.upper()]
        facts = (f"values: {listed(words)}",)
        if text.lower().startswith("custom"):
            self.error("FZ602", f"the custom method '{text}' is not available", element.place(attribute), facts=facts)
        else:
            help_text = did_you_mean(text.upper(), words)
            message = f"no value '{text}' of '{attribute}'"
            self.error("FZ213", message, element.place(attribute), facts=facts, help=help_text)
        return usual

    def tell_unsure(self) -> None:
        """Say once for each what tools read differently."""
        for message, span in self.unsure.items():
            self.warning("FZ609", message, span, help="compare with the tool that wrote the file")
