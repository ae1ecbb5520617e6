"""Diagnostics of a reader, collected while it reads on."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import closest

#: Files with more lines than this, comments and blank lines left out, are not read; nor lists with more numbers.
MOST_LINES: Final = 20_000


@dataclass(frozen=True)
class Reading:
    """A text that two tools read differently.

    Args:
        message: The reading here.
        other: The reading of the other tool.
        way_out: A text that both read alike.
        span: The place of the text.
    """

    message: str
    other: str
    way_out: str
    span: Span


class ParseError(ValueError):
    """Raised at a text that cannot be read, with its diagnostic."""

    def __init__(
        self, message: str, span: Span | None, code: str = "FZ601", *, help: str = "", facts: tuple[str, ...] = ()
    ) -> None:
        super().__init__(message)
        self.diagnostic = Diagnostic(code, message, span, facts=facts, help=help)


class Findings:
    """The diagnostics of one file, collected while a reader reads on.

    Args:
        source: The file.

    Attributes:
        diagnostics: The diagnostics so far.
        file: The name of the file.
    """

    def __init__(self, source: SourceText) -> None:
        self.source, self.file = source, source.name
        self.diagnostics: list[Diagnostic] = []

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

    def refuse(self, error: ParseError) -> None:
        """Add the error of a text that cannot be read."""
        self.diagnostics.append(replace(error.diagnostic, file=self.source.name))

    def differs(self, reading: Reading) -> None:
        """Add a warning of a text that tools read differently."""
        self.warning("FZ609", reading.message, reading.span, help=reading.way_out, facts=(reading.other,))

    def given_twice(self, what: str, span: Span, earlier: Span) -> None:
        """Add the error of a repetition."""
        self.error("FZ215", f"{what} is given twice", span, notes=(Note(earlier, "first given here"),))

    def too_many(self, count: int, span: Span) -> bool:
        """Whether there are too many lines; report the first one beyond the limit."""
        if count == MOST_LINES + 1:
            message = f"the file has more than {MOST_LINES:,} lines"
            self.error("FZ112", message, span, help="the rest is not read")
        return count > MOST_LINES

    def in_order(self) -> list[Diagnostic]:
        """Return the diagnostics in the order of their places."""
        return sorted(self.diagnostics, key=lambda d: d.span.start if d.span is not None else -1)


def meant(name: str, known: Iterable[str]) -> str:
    """Return a help that names the known word nearest to a misspelt one, or nothing."""
    near = closest(name, list(known))
    return f"did you mean '{near}'?" if near else ""


class Names:
    """Give out names, each once: a name that is taken gets the first free number behind it.

    Args:
        taken: Names that are not to be given out.
        fold: Makes equal names of two that cannot be told apart, such as a change of case.
    """

    def __init__(self, taken: Iterable[str] = (), fold: Callable[[str], str] = str) -> None:
        self._fold = fold
        self._taken = set(map(fold, taken))
        self._last: dict[str, int] = {}

    def take(self, name: str) -> str:
        """Return a name that was not given out yet, and give it out."""
        free, number = name, self._last.get(name, 1)
        while self._fold(free) in self._taken:
            number += 1
            free = f"{name}_{number}"
        self._last[name] = number
        self._taken.add(self._fold(free))
        return free
