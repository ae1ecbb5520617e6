"""A rule file after the fixes that its diagnostics carry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.fixes import Applicability, Fix, fixed
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import look_through

#: Rounds of fixing; each shows what the mistakes of the round before hid.
_ROUNDS: Final = 8


@dataclass(frozen=True)
class Fixed:
    """A text after fixes.

    Args:
        source: The text; the very one that was given where nothing was fixed.
        repaired: The diagnostics whose fixes were made, with their locations in the text of their round.
    """

    source: SourceText
    repaired: tuple[Diagnostic, ...]


def fix_source(source: SourceText, *, folder: Path | None = None, likely: bool = False) -> Fixed:
    """Make the fixes of a text, again and again until none is left.

    Fixes are kept only where fewer errors remain than before them: a line that can be read may show the next mistake.

    Args:
        source: The text of a rule file.
        folder: Where the files stand that it uses.
        likely: Whether to make fixes that are only likely.
    """
    wanted: tuple[Applicability, ...] = ("sure", "likely") if likely else ("sure",)
    errors = errors_of(source, folder)
    best, fewest = Fixed(source, ()), len(errors)
    made: list[Diagnostic] = []
    for _ in range(_ROUNDS):
        chosen = [d for d in errors if d.fix is not None and d.fix.applicability in wanted]
        after = _after(source, chosen)
        if after is None:
            break
        source, errors = after, errors_of(after, folder)
        made += chosen
        if len(errors) < fewest:
            best, fewest = Fixed(source, tuple(made)), len(errors)
    return best


def _after(source: SourceText, chosen: Sequence[Diagnostic]) -> SourceText | None:
    fixes: list[Fix] = [d.fix for d in chosen if d.fix is not None]
    text = fixed(source, fixes)
    return replace(source, text=text) if text != source.text else None


def errors_of(source: SourceText, folder: Path | None) -> list[Diagnostic]:
    """Return the errors of a text, those that need a proof left out."""
    examined = look_through(source, folder=folder, hints=False)
    return [d for d in examined.reported(examined.diagnostics) if d.severity == "error"]
