"""A rule file after the fixes that its diagnostics carry."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.fixes import Applicability, Fix, fixed
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang.syntax import NAME
from fuzzyctl.loading.load import look_through

#: Rounds of fixing; each shows the mistakes that those of the round before hid.
_ROUNDS: Final = 8

#: Codes of definitions that depend on themselves.
_CIRCLES: Final = frozenset({"FZ217", "FZ220", "FZ308"})


@dataclass(frozen=True)
class Fixed:
    """A text after fixes.

    Args:
        source: The text; the same object if no fix was made.
        repaired: The diagnostics whose fixes were made, with their locations in the text of their round.
    """

    source: SourceText
    repaired: tuple[Diagnostic, ...]


def fix_source(source: SourceText, *, folder: Path | None = None, likely: bool = False) -> Fixed:
    """Make the fixes of a text, again and again until none is left.

    Fixes are kept only where fewer errors remain than before them: a line that can be read may show the next mistake.

    Args:
        source: The text of a rule file.
        folder: The folder of the files that it uses.
        likely: Whether to make fixes that are only likely.
    """
    wanted: tuple[Applicability, ...] = ("sure", "likely") if likely else ("sure",)
    errors = errors_of(source, folder)
    best, fewest = Fixed(source, ()), len(errors)
    repairs: list[Diagnostic] = []
    for _ in range(_ROUNDS):
        chosen = [d for d in errors if d.fix is not None and d.fix.applicability in wanted]
        if likely and not _keeps_meaning(source, chosen, folder):
            chosen = [d for d in chosen if _keeps_meaning(source, [d], folder)]
        after = _after(source, chosen)
        if after is None:
            break
        source, errors = after, errors_of(after, folder)
        repairs += chosen
        if len(errors) < fewest:
            best, fewest = Fixed(source, tuple(repairs)), len(errors)
    return best


def _after(source: SourceText, chosen: Sequence[Diagnostic]) -> SourceText | None:
    fixes: list[Fix] = [d.fix for d in chosen if d.fix is not None]
    text = fixed(source, fixes)
    return replace(source, text=text) if text != source.text else None


def _keeps_meaning(source: SourceText, chosen: Sequence[Diagnostic], folder: Path | None) -> bool:
    """Return whether the likely ones of some fixes make no other claim, no circle and no warning about their words."""
    guesses = [r for d in chosen if d.fix is not None and d.fix.applicability == "likely" for r in d.fix.replacements]
    lines = source.text.split("\n")
    of_claims = (r for r in guesses if lines[r.span.line - 1].lstrip().startswith("require"))
    if not guesses or any(re.search(r"[\w<>=]", r.span.text + r.text) for r in of_claims):  # a decimal point may do
        return not guesses
    after = _after(source, chosen)
    before = {(d.code, d.message) for d in _diagnostics_of(source, folder)}
    results = [d for d in _diagnostics_of(after or source, folder) if (d.code, d.message) not in before]
    words = {w for r in guesses for w in re.findall(NAME, f"{r.span.text} {r.text}")}
    return not any(
        d.code in _CIRCLES or (d.severity == "warning" and not words.isdisjoint(re.findall(rf"'({NAME})'", d.message)))
        for d in results
    )


def errors_of(source: SourceText, folder: Path | None) -> list[Diagnostic]:
    """Return the errors of a text, those that need a proof left out."""
    return [d for d in _diagnostics_of(source, folder) if d.severity == "error"]


def _diagnostics_of(source: SourceText, folder: Path | None) -> list[Diagnostic]:
    examined = look_through(source, folder=folder, hints=False)
    return list(examined.reported(examined.diagnostics))
