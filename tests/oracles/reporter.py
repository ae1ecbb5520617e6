"""Collector of the diagnostics of an oracle."""

from __future__ import annotations

from typing import Any

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import Span


class Reporter:
    """Collects the diagnostics of a reader.

    Attributes:
        diagnostics: The diagnostics so far.
        file: The name of the file, for diagnostics without a location.
    """

    diagnostics: list[Diagnostic]
    file = ""

    @property
    def failed(self) -> bool:
        """Whether there is an error."""
        return any(d.severity == "error" for d in self.diagnostics)

    def error(self, code: str, message: str, span: Span | None, **more: Any) -> None:
        """Add an error; `more` are further fields of a `Diagnostic`."""
        self.diagnostics.append(Diagnostic(code, message, span, "error", file=self.file, **more))

    def warning(self, code: str, message: str, span: Span | None, **more: Any) -> None:
        """Add a warning."""
        self.diagnostics.append(Diagnostic(code, message, span, "warning", file=self.file, **more))
