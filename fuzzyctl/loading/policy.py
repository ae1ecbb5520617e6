"""Order of diagnostics, and the lines of a file that allow or deny some."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Collection, Iterable
from typing import Final

from fuzzyctl.diagnostics.diagnostic import CODES, Diagnostic
from fuzzyctl.diagnostics.fixes import respelt
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.lang import syntax as sx

_TERM_LINE: Final = re.compile(rf"[ \t]*(?:terms\b|{sx.NAME}[ \t]*=)")
_QUOTED: Final = re.compile(r"'[^']*'")


def in_order(source: SourceText, diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Sort by place, those of used files last, and drop what shared lines give once for each system or variable."""

    def place(d: Diagnostic) -> tuple[bool, str, int]:
        if d.span is None:
            return (False, "", -1)
        return (d.span.source.name != source.name, d.span.source.name, d.span.start)

    unique: dict[object, Diagnostic] = {}
    for d in diagnostics:
        unique.setdefault((d.code, _without_variable(d), place(d)), d)
    return sorted(unique.values(), key=place)


def _without_variable(d: Diagnostic) -> str:
    """Return the message, about a line of terms without its names: several variables may share the line."""
    if d.span is None:
        return d.message
    text = d.span.source.text
    line = text.rfind("\n", 0, d.span.start) + 1
    return _QUOTED.sub("", d.message) if _TERM_LINE.match(text, line) else d.message


def apply_policy(diagnostics: list[Diagnostic], lines: Iterable[sx.Allow]) -> list[Diagnostic]:
    """Drop warnings and hints that the file allows, and turn those that it denies into errors."""
    allowed: set[str] = set()
    denied: set[str] = set()
    results: list[Diagnostic] = []
    for line in lines:
        for word in line.codes:
            if word.text not in CODES:
                near = closest(word.text, CODES)
                help_text = f"did you mean '{near}'?" if near else "'fuzzyctl explain' lists the codes"
                message, fix = f"no diagnostic code '{word.text}'", respelt(word.span, word.text, near, CODES)
                results.append(Diagnostic("FZ213", message, word.span, help=help_text, fix=fix))
            (allowed if line.keyword.text == "allow" else denied).add(word.text)
    return [*results, *enforce(diagnostics, allowed, denied)]


def enforce(diagnostics: Iterable[Diagnostic], allowed: Collection[str], denied: Collection[str]) -> list[Diagnostic]:
    """Drop allowed warnings, and turn denied ones into errors; a code that is both is denied."""
    results = []
    for d in diagnostics:
        if d.severity != "error" and d.code in denied:
            results.append(dataclasses.replace(d, severity="error"))
        elif d.severity == "error" or d.code not in allowed:
            results.append(d)
    return results
