"""Diagnostics, their rendering, and the exceptions of the public API."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field
from typing import Any, Literal

from fuzzyctl.diagnostics.codes import CODES as CODES
from fuzzyctl.diagnostics.codes import WARNINGS as WARNINGS
from fuzzyctl.diagnostics.fixes import Fix
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.diagnostics.terminal import printable, spelt
from fuzzyctl.records import dataclass

#: A hint is not a mistake by itself; it fails nothing, unless its code is denied.
Severity = Literal["error", "warning", "hint"]


@dataclass(frozen=True)
class Note:
    """Point at a second place that explains a diagnostic."""

    span: Span
    message: str


@dataclass(frozen=True, repr=False)
class Diagnostic:
    """Describe one mistake: what, where, the facts, and a way out; `print` has the text of the command line.

    Args:
        code: A key of `CODES`.
        message: One line without a full stop that names the thing and its mistake.
        span: Where it is, or None when it has no place in a text.
        severity: "error", "warning" or "hint".
        facts: Lines that help to see why, such as the names that would have been right.
        help: What to do about it, or an empty string; lines to be typed may follow, each as a separate line.
        notes: Other places that matter.
        file: Shown as the place when there is no span.
        fix: The repair as data, where it is known.
        witness: Of a claim, values of inputs and states at which it fails.
    """

    code: str
    message: str
    span: Span | None = None
    severity: Severity = "error"
    facts: tuple[str, ...] = ()
    help: str = ""
    notes: tuple[Note, ...] = ()
    file: str = ""
    fix: Fix | None = None
    witness: Mapping[str, float] | None = field(default=None, hash=False)

    def __post_init__(self) -> None:
        if self.code not in CODES:
            raise KeyError(f"diagnostic code {self.code!r} is not in codes.CODES")

    def __repr__(self) -> str:
        place = f"{self.place}: " if self.place else ""
        return printable(f"Diagnostic({place}{self.severity}[{self.code}]: {self.message})")

    def __str__(self) -> str:
        return render(self)

    @property
    def place(self) -> str:
        """`file:line:column`, as far as it is known."""
        return str(self.span) if self.span is not None else self.file

    @property
    def stops(self) -> bool:
        """Whether nothing can be drawn, run or written: an error, but for claims, which are verdicts."""
        return self.severity == "error" and self.witness is None

    @property
    def explanations(self) -> tuple[str, ...]:
        """The facts, then the notes, each with its place."""
        return (*self.facts, *(f"{n.message} ({_other_place(n.span, self)})" for n in self.notes))

    def as_dict(self) -> dict[str, Any]:
        """Return the diagnostic as plain data, for `--format json`."""
        data: dict[str, Any] = {
            "code": self.code,
            "severity": self.severity,
            "message": self.message,
            "file": self.span.source.name if self.span else self.file or None,
        }
        if self.span is not None:
            last = max(self.span.start, self.span.end)
            source = self.span.source
            data |= {
                "line": self.span.line,
                "column": self.span.column,
                "end_line": source.line_of(last),
                "end_column": source.column_of(last),
            }
        data["facts"] = list(self.facts)
        data["help"] = self.help or None
        data["notes"] = [{"file": n.span.source.name, "line": n.span.line, "message": n.message} for n in self.notes]
        data["fix"] = self.fix.as_dict() if self.fix is not None else None
        return data


def render(
    diagnostic: Diagnostic, *, color: bool = False, width: int | None = None, encoding: str | None = None
) -> str:
    """Return a diagnostic as text with its source line and a caret under the place.

    Args:
        diagnostic: The diagnostic; characters of its texts that a terminal would act on are replaced.
        color: Whether to use the colours of a terminal.
        width: Columns of the terminal, at which lines are wrapped; None leaves each message on one line.
        encoding: Of where it is printed, for columns and the place of the caret; None for one that has all characters.
    """
    tint = paint if color else _plain
    tone = _TONES[diagnostic.severity]
    place = f"{printable(diagnostic.place)}: " if diagnostic.place else ""
    kind = f"{diagnostic.severity}[{diagnostic.code}]"
    before = _width(spelt(f"{place}{kind}: ", encoding))
    message = wrapped(spelt(printable(diagnostic.message), encoding), width, first=before, indent=4)
    lines = [f"{tint(place, 'bold')}{tint(kind, tone)}: {tint(message[0], 'bold')}".rstrip(" ")]
    lines.extend(f"    {tint(line, 'bold')}" for line in message[1:])
    margin = 1
    if diagnostic.span is not None:
        margin = len(str(diagnostic.span.line)) + 1
        lines.extend(_excerpt(diagnostic.span, margin, tint, tone, width, encoding))
    pad = " " * margin

    def add(text: str, label: str = "") -> None:
        colon = ": " if label else ""
        head, *below = (spelt(printable(line), encoding) for line in text.split("\n"))
        first, *rest = wrapped(head, width, first=margin + 2 + len(label + colon), indent=margin + 2)
        lines.append(f"{pad}= {tint(label, 'cyan')}{colon}{first}")
        lines.extend(f"{pad}  {line}" for line in (*rest, *(f"  {line}" for line in below)))

    for text in diagnostic.explanations:
        add(text)
    if diagnostic.help:
        add(diagnostic.help, "help")
    return "\n".join(lines)


def wrapped(text: str, width: int | None, *, first: int, indent: int) -> list[str]:
    """Return a text as lines that fit a terminal, cut at blanks; longer words stay whole.

    Args:
        text: The text.
        width: Columns of the terminal; None gives one line.
        first: Columns in front of the first line.
        indent: Columns in front of the others.
    """
    if width is None:
        return [text]
    lines, left, blank = [""], width - first, ""
    for word in text.split(" "):
        needed = _width(blank + word)
        if needed > left and (blank or first > indent):
            lines.append(word)
            left = width - indent - _width(word)
        else:
            lines[-1] += blank + word
            left -= needed
        blank = " "
    return lines


#: Most diagnostics shown as text; a file with more of them is not a rule file.
MOST_SHOWN = 200


def first_of(diagnostics: Sequence[Diagnostic], most: int) -> list[Diagnostic]:
    """Return some diagnostics in the order given: the first errors, and where there are fewer, others."""
    errors_first = sorted(range(len(diagnostics)), key=lambda i: diagnostics[i].severity != "error")
    return [diagnostics[i] for i in sorted(errors_first[:most])]


def render_all(
    diagnostics: Iterable[Diagnostic], *, color: bool = False, width: int | None = None, encoding: str | None = None
) -> str:
    """Return several diagnostics as text, one blank line between them; see `render`.

    Of very many only some are shown; see `first_of`.
    """
    found = list(diagnostics)
    shown = [render(d, color=color, width=width, encoding=encoding) for d in first_of(found, MOST_SHOWN)]
    if len(found) > MOST_SHOWN:
        shown.append(f"... and {len(found) - MOST_SHOWN} more")
    return "\n\n".join(shown)


def _other_place(span: Span, diagnostic: Diagnostic) -> str:
    same = diagnostic.span is not None and diagnostic.span.source.name == span.source.name
    return f"line {span.line}" if same else f"{span.source.name}:{span.line}"


#: Columns of a source line that are shown at most, and at least in a narrow terminal.
_WIDEST, _NARROWEST = 160, 20


def _excerpt(span: Span, margin: int, paint: Any, tone: str, width: int | None, encoding: str | None) -> list[str]:
    raw = span.source.line_text(span.line)
    offset = span.column - 1
    length = max(1, min(span.end - span.start, len(raw) - offset))
    columns = _WIDEST
    if width is not None:
        widest = max((_width(spelt(printable(c), encoding)) for c in set(raw)), default=1)
        columns = min(_WIDEST, max(_NARROWEST, width - margin - 2)) // max(widest, 1)
    shown, offset = _window(raw, offset, columns)
    end = offset + max(1, min(length, len(shown) - offset))
    before, marked, behind = (
        spelt(printable(part), encoding) for part in (shown[:offset], shown[offset:end], shown[end:])
    )
    caret = " " * _width(before) + paint("^" * max(1, _width(marked)), tone)
    bar = paint(" " * margin + "|", "blue")
    return [bar, f"{paint(f'{span.line:>{margin - 1}} |', 'blue')} {before}{marked}{behind}", f"{bar} {caret}"]


def _window(raw: str, offset: int, width: int) -> tuple[str, int]:
    """Cut a very long line to the part around the place."""
    if len(raw) <= width:
        return raw, offset
    first = max(0, min(offset - width // 3, len(raw) - width))
    return raw[first : first + width], offset - first


def _width(text: str) -> int:
    """Columns a text takes on a terminal."""
    wide = {"W": 2, "F": 2}
    return sum(0 if unicodedata.combining(c) else wide.get(unicodedata.east_asian_width(c), 1) for c in text)


_TONES: dict[Severity, str] = {"error": "red", "warning": "yellow", "hint": "cyan"}
_STYLES = {"bold": "1", "red": "1;31", "green": "1;32", "yellow": "1;33", "cyan": "36", "blue": "34"}


def paint(text: str, style: str) -> str:
    """Return a text in a style of `_STYLES` for a terminal."""
    return f"\x1b[{_STYLES[style]}m{text}\x1b[0m" if text else text


def _plain(text: str, style: str) -> str:
    return text


class FuzzyctlError(Exception):
    """Base of all exceptions that fuzzyctl raises on purpose."""


class DiagnosticError(FuzzyctlError):
    """Raised when a text or a file has mistakes; carries all of them.

    Args:
        diagnostics: The mistakes and warnings found, in order of their places.
    """

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        self.diagnostics: tuple[Diagnostic, ...] = tuple(diagnostics)
        super().__init__(self.diagnostics)

    def __str__(self) -> str:
        return render_all(self.diagnostics)


class UnknownNameError(FuzzyctlError, KeyError):
    """Raised when an input, output, term or param of that name does not exist."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        self.kind, self.name, self.known = kind, name, tuple(known)
        hint = did_you_mean(name, self.known)
        super().__init__(
            f"no {kind} {name!r}; there are: {', '.join(self.known) or 'none'}{'; ' + hint if hint else ''}"
        )

    def __str__(self) -> str:
        return str(self.args[0])


class ValueOutOfBoundsError(FuzzyctlError, ValueError):
    """Raised when a value given to the API breaks a bound.

    Args:
        name: The name of the value.
        value: The value.
        bound: The bound it breaks, in words such as "> 0".
        unit: Its unit, or an empty string.
    """

    def __init__(self, name: str, value: object, bound: str, unit: str = "") -> None:
        self.name, self.value, self.bound, self.unit = name, value, bound, unit
        super().__init__(f"{name} must be {bound}{' ' + unit if unit else ''}, got {value!r}")


class ArgumentError(FuzzyctlError, TypeError):
    """Raised when a call lacks an argument or has one too many."""


class NoRuleFiresError(FuzzyctlError, ArithmeticError):
    """Raised at evaluation when no rule fires and the output says `else error`, or has no `else` at all."""

    def __init__(self, output: str, point: str) -> None:
        self.output, self.point = output, point
        super().__init__(f"no rule fires for output {output!r} at {point}; 'else VALUE' would say what it is there")


class BackendUnavailableError(FuzzyctlError, ImportError):
    """Raised for the name of a backend whose package cannot be imported."""

    def __init__(self, backend: str, reason: str) -> None:
        self.backend, self.reason = backend, reason
        super().__init__(f"backend {backend!r} is not available here: {reason}; backend='auto' takes the best there is")
