"""Diagnostics, their codes, their rendering, and the exceptions of the public API."""

from __future__ import annotations

import difflib
import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

from fuzzyctl.peer_words import PEER_REMARKS, PEER_WORDS
from fuzzyctl.source import Span

#: A hint is no mistake by itself; it fails nothing, unless its code is denied.
Severity = Literal["error", "warning", "hint"]

#: Every diagnostic code with its title. Numbers are never given twice: FZ0 files, FZ1 syntax, FZ2 names and rules,
#: FZ3 numbers and membership functions, FZ4 coverage and proofs, FZ5 values given to a command, FZ6 files of other
#: tools, FZ9 scenarios and runs.
CODES: dict[str, str] = {
    "FZ001": "the file cannot be read",
    "FZ002": "the file is not UTF-8 text",
    "FZ003": "the file is too large",
    "FZ004": "the file declares no system",
    "FZ005": "the file cannot be written",
    "FZ006": "the file is laid out otherwise",
    "FZ101": "the line is not a statement",
    "FZ102": "unexpected text in a statement",
    "FZ103": "a parenthesis is not closed",
    "FZ104": "a string is not closed",
    "FZ105": "a character has no place in the language",
    "FZ106": "nesting is too deep",
    "FZ107": "a name is too long",
    "FZ108": "a number is out of range",
    "FZ109": "AND and OR are mixed without parentheses",
    "FZ110": "a line has no statement it could belong to",
    "FZ111": "the language version is not supported",
    "FZ112": "too many statements, terms, outputs or rules",
    "FZ201": "a name is declared twice",
    "FZ202": "a name is not declared",
    "FZ203": "a variable has no such term",
    "FZ204": "a table row is missing",
    "FZ205": "a table column is missing",
    "FZ206": "a table header is given twice",
    "FZ207": "a table row has the wrong number of cells",
    "FZ208": "a term is used by no rule",
    "FZ209": "two rules have the same antecedent",
    "FZ210": "an output has no rule",
    "FZ211": "an input is used by no rule",
    "FZ212": "a statement is missing",
    "FZ213": "an option is not known",
    "FZ214": "statements do not fit together",
    "FZ215": "a statement is given twice",
    "FZ216": "a param is used by nothing",
    "FZ217": "outputs depend on each other in a circle",
    "FZ218": "a file cannot be used",
    "FZ219": "a hedge is used by nothing",
    "FZ301": "feet and peaks are out of order",
    "FZ302": "a parameter has a bad value",
    "FZ303": "wrong number of parameters",
    "FZ304": "a range is empty",
    "FZ305": "terms are out of order",
    "FZ306": "a peak or an 'else' value lies outside the range",
    "FZ307": "an expression cannot be computed",
    "FZ308": "a param depends on itself",
    "FZ309": "terms leave a part of a range uncovered",
    "FZ310": "a table jumps",
    "FZ311": "a table is symmetric but for one cell",
    "FZ312": "units do not match",
    "FZ401": "in some region no rule fires",
    "FZ402": "a bound cannot be guaranteed",
    "FZ403": "a rule never acts",
    "FZ404": "a term never matters",
    "FZ405": "an output jumps",
    "FZ406": "degrees do not sum to 1",
    "FZ501": "a value is missing",
    "FZ502": "a name is not known to the system",
    "FZ503": "a value is not a number",
    "FZ504": "a value lies outside the range",
    "FZ505": "a points file is malformed",
    "FZ601": "the line is not of its format",
    "FZ602": "the file asks for what is not available",
    "FZ603": "a part of the file has no effect",
    "FZ604": "a name is changed",
    "FZ605": "the file is read in another encoding",
    "FZ606": "a count does not match",
    "FZ607": "an index is out of range",
    "FZ608": "the format cannot express the system",
    "FZ609": "tools read it differently",
    "FZ610": "a range is estimated",
    "FZ611": "a part that is switched off is left out",
    "FZ901": "a scenario file is malformed",
    "FZ902": "a scenario has an unknown key",
    "FZ903": "a scenario value is missing",
    "FZ904": "a scenario value is not admissible",
    "FZ905": "a rule file does not fit its role",
    "FZ906": "the constraint G_AIS > 0 is not guaranteed",
    "FZ907": "the boundary layer is not guaranteed to be positive",
    "FZ908": "a run was stopped",
    "FZ909": "the output folder cannot be written",
    "FZ910": "a path file is malformed",
}


#: Codes of rule files that are warnings or hints, at least in some of their cases; all others are errors always.
WARNINGS: frozenset[str] = frozenset(
    {"FZ208", "FZ209", "FZ211", "FZ214", "FZ216", "FZ219", "FZ305", "FZ306", "FZ309", "FZ310", "FZ311"}
    | {"FZ403", "FZ404", "FZ405", "FZ406"}
)


@dataclass(frozen=True)
class Note:
    """Point at a second place that explains a diagnostic."""

    span: Span
    message: str


@dataclass(frozen=True)
class Diagnostic:
    """Describe one mistake: what, where, the facts, and a way out.

    Args:
        code: A key of `CODES`.
        message: One line without a full stop that names the thing and what is wrong with it.
        span: Where it is, or None when it has no place in a text.
        severity: "error", "warning" or "hint".
        facts: Lines that help to see why, such as the names that would have been right.
        help: What to do about it, or an empty string.
        notes: Other places that matter.
        file: Shown as the place when there is no span.
    """

    code: str
    message: str
    span: Span | None = None
    severity: Severity = "error"
    facts: tuple[str, ...] = ()
    help: str = ""
    notes: tuple[Note, ...] = ()
    file: str = ""

    def __post_init__(self) -> None:
        if self.code not in CODES:
            raise KeyError(f"diagnostic code {self.code!r} is not in errors.CODES")

    @property
    def place(self) -> str:
        """`file:line:column`, as far as it is known."""
        return str(self.span) if self.span is not None else self.file

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
        return data


def render(diagnostic: Diagnostic, *, color: bool = False) -> str:
    """Return a diagnostic as text with its source line and a caret under the place."""
    paint = _paint if color else _plain
    tone = _TONES[diagnostic.severity]
    place = f"{diagnostic.place}: " if diagnostic.place else ""
    head = f"{paint(place, 'bold')}{paint(f'{diagnostic.severity}[{diagnostic.code}]', tone)}: "
    lines = [head + paint(diagnostic.message, "bold")]
    margin = 1
    if diagnostic.span is not None:
        margin = len(str(diagnostic.span.line)) + 1
        lines.extend(_excerpt(diagnostic.span, margin, paint, tone))
    pad = " " * margin
    lines.extend(f"{pad}= {fact}" for fact in diagnostic.facts)
    lines.extend(f"{pad}= {note.message} ({_other_place(note.span, diagnostic)})" for note in diagnostic.notes)
    if diagnostic.help:
        lines.append(f"{pad}= {paint('help', 'cyan')}: {diagnostic.help}")
    return "\n".join(lines)


#: So many diagnostics are shown as text; a file with more of them is no rule file.
MOST_SHOWN = 200


def render_all(diagnostics: Iterable[Diagnostic], *, color: bool = False) -> str:
    """Return several diagnostics as text, one blank line between them; of very many only the first."""
    found = list(diagnostics)
    shown = [render(d, color=color) for d in found[:MOST_SHOWN]]
    if len(found) > MOST_SHOWN:
        shown.append(f"... and {len(found) - MOST_SHOWN} more")
    return "\n\n".join(shown)


def _other_place(span: Span, diagnostic: Diagnostic) -> str:
    same = diagnostic.span is not None and diagnostic.span.source.name == span.source.name
    return f"line {span.line}" if same else f"{span.source.name}:{span.line}"


def _excerpt(span: Span, margin: int, paint: Any, tone: str) -> list[str]:
    raw = span.source.line_text(span.line)
    offset = span.column - 1
    length = max(1, min(span.end - span.start, len(raw) - offset))
    shown, offset = _window(raw, offset, length)
    length = max(1, min(length, len(shown) - offset))
    caret = " " * _width(shown[:offset]) + paint("^" * max(1, _width(shown[offset : offset + length])), tone)
    bar = paint(" " * margin + "|", "blue")
    return [bar, f"{paint(f'{span.line:>{margin - 1}} |', 'blue')} {_visible(shown)}", f"{bar} {caret}"]


def _window(raw: str, offset: int, length: int, width: int = 160) -> tuple[str, int]:
    """Cut a very long line to the part around the place."""
    if len(raw) <= width:
        return raw, offset
    first = max(0, min(offset - width // 3, len(raw) - width))
    return raw[first : first + width], offset - first


def _visible(text: str) -> str:
    """Replace what a terminal would act on: tabs become one blank, other control characters their picture."""
    return "".join(
        " " if c == "\t" else chr(0x2400 + ord(c)) if ord(c) < 32 else "␡" if ord(c) == 127 else c for c in text
    )


def _width(text: str) -> int:
    """Columns a text takes on a terminal."""
    wide = {"W": 2, "F": 2}
    return sum(0 if unicodedata.combining(c) else wide.get(unicodedata.east_asian_width(c), 1) for c in text)


_TONES: dict[Severity, str] = {"error": "red", "warning": "yellow", "hint": "cyan"}
_STYLES = {"bold": "1", "red": "1;31", "yellow": "1;33", "cyan": "36", "blue": "34"}


def _paint(text: str, style: str) -> str:
    return f"\x1b[{_STYLES[style]}m{text}\x1b[0m" if text else text


def _plain(text: str, style: str) -> str:
    return text


#: Letters of other alphabets that look like ASCII ones; fullwidth and other forms are found by Unicode's NFKC.
_ALIKE = str.maketrans(
    "АВЕЅІЈКМНОРСТУХаеѕіјорсухԁԛԝΑΒΕΖΗΙΚΜΝΟΡΤΥΧονı",
    "ABESIJKMHOPCTYXaesijopcyxdqwABEZHIKMNOPTYXovi",
)


def look_alikes(name: str) -> tuple[str, ...]:
    """Describe the letters of a name that look like ASCII ones but are others."""
    found = []
    for c in dict.fromkeys(name):
        plain = unicodedata.normalize("NFKC", c).translate(_ALIKE)
        if not c.isascii() and plain != c and plain.isascii():
            found.append(
                f"'{c}' in it is U+{ord(c):04X} ({unicodedata.name(c, 'unnamed')}), which looks like '{plain}'"
            )
    return tuple(found)


#: With more names than this only those that are one letter away are found.
_MOST_COMPARED = 64

#: How alike two names must be to be taken for a slip: in names of two letters one may differ.
_LIKE = 0.5


def listed(names: Iterable[str], most: int = 20) -> str:
    """Return names separated by commas, cut where there are very many."""
    known = list(names)
    rest = len(known) - most
    return ", ".join(known) if rest <= 0 else f"{', '.join(known[:most])} and {rest} more"


def counted(count: int, noun: str) -> str:
    """Return a number with its noun, such as `1 term` and `2 terms`."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def closest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name that a misspelt one most likely means, or None."""
    names = list(known)
    plain = unicodedata.normalize("NFKC", name).translate(_ALIKE)
    if plain != name and plain in names:
        return plain
    bare = _bare(name)
    if bare in PEER_WORDS and name not in names:
        # What another tool calls it means more than what is spelt alike.
        meant = next((word for word in PEER_WORDS[bare] if word in names), None)
        if meant is not None or not PEER_WORDS[bare]:
            return meant
    if len(names) > _MOST_COMPARED:
        return _one_letter_away(name, tuple(names))
    folded = {_bare(n): n for n in reversed(names)}
    if bare in folded:
        return folded[bare]
    found = difflib.get_close_matches(name, names, n=1, cutoff=_LIKE)
    if found:
        return found[0]
    near = difflib.get_close_matches(bare, list(folded), n=1, cutoff=_LIKE)
    return folded[near[0]] if near else None


def _bare(name: str) -> str:
    """Return a name without what spellings differ in: capitals and underscores."""
    return name.casefold().replace("_", "")


def _one_letter_away(name: str, known: tuple[str, ...]) -> str | None:
    """Return a name with one letter more, less, changed or swapped with its neighbour.

    Comparing letter by letter with a thousand names takes milliseconds, and a file may hold thousands of mistakes.
    """
    index = _shortened(known)
    return next((index[s] for s in _without_a_letter(name.casefold()) if s in index), None)


@lru_cache(maxsize=4)
def _shortened(known: tuple[str, ...]) -> dict[str, str]:
    """Map every name, whole and without any one of its letters, to itself."""
    index: dict[str, str] = {}
    for name in known:
        for short in _without_a_letter(name.casefold()):
            index.setdefault(short, name)
    return index


def _without_a_letter(name: str) -> list[str]:
    # From the end on: of two names that are as near, the one that begins alike is meant.
    return [name, *(name[:i] + name[i + 1 :] for i in reversed(range(min(len(name), 200))))]


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return a help text that names the closest known name, or an empty string."""
    best = closest(name, known)
    remark = PEER_REMARKS.get(_bare(name), "")
    return f"did you mean '{best}'?{' ' if remark else ''}{remark}" if best is not None else ""


class FuzzyctlError(Exception):
    """Base of all exceptions that fuzzyctl raises on purpose."""


class DiagnosticError(FuzzyctlError):
    """Raised when a text or a file has mistakes; carries all of them.

    Args:
        diagnostics: The mistakes and warnings found, in order of their places.
    """

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        self.diagnostics: tuple[Diagnostic, ...] = tuple(diagnostics)
        super().__init__("\n" + render_all(self.diagnostics))


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
        name: What the value is for.
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
    """Raised when a backend is asked for by name whose package cannot be imported."""

    def __init__(self, backend: str, reason: str) -> None:
        self.backend, self.reason = backend, reason
        super().__init__(f"backend {backend!r} is not available here: {reason}; backend='auto' takes the best there is")
