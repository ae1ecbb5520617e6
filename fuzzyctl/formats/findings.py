"""What a reader finds wrong, collected while it reads on."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from fuzzyctl.errors import Diagnostic, Note, closest
from fuzzyctl.source import SourceText, Span


class Findings:
    """Collect the diagnostics of one file.

    Args:
        source: The file.
    """

    def __init__(self, source: SourceText) -> None:
        self.source = source
        self.diagnostics: list[Diagnostic] = []

    @property
    def failed(self) -> bool:
        """Whether there is an error."""
        return any(d.severity == "error" for d in self.diagnostics)

    def error(
        self,
        code: str,
        message: str,
        span: Span | None,
        *,
        help: str = "",
        facts: Iterable[str] = (),
        note: Note | None = None,
    ) -> None:
        """Add an error."""
        notes = (note,) if note is not None else ()
        found = Diagnostic(code, message, span, facts=tuple(facts), help=help, notes=notes, file=self.source.name)
        self.diagnostics.append(found)

    def warning(
        self,
        code: str,
        message: str,
        span: Span | None,
        *,
        help: str = "",
        facts: Iterable[str] = (),
        note: Note | None = None,
    ) -> None:
        """Add a warning."""
        self.error(code, message, span, help=help, facts=facts, note=note)
        self.diagnostics[-1] = replace(self.diagnostics[-1], severity="warning")

    def in_order(self) -> list[Diagnostic]:
        """Return what was found in the order of the places."""
        return sorted(self.diagnostics, key=lambda d: d.span.start if d.span is not None else -1)


def meant(name: str, known: Iterable[str]) -> str:
    """Return a help that names the known word a misspelt one is like, or nothing."""
    near = closest(name, list(known))
    return f"did you mean '{near}'?" if near else ""


def distinct(name: str, taken: Iterable[str]) -> str:
    """Return a name that is not taken yet: the same, or with the first free number behind it."""
    used = set(taken)
    if name not in used:
        return name
    number = 2
    while f"{name}_{number}" in used:
        number += 1
    return f"{name}_{number}"
