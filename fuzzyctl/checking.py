"""All checks of a rule file at once: those of its structure and those that need a proof."""

from __future__ import annotations

import os

from fuzzyctl.errors import Diagnostic
from fuzzyctl.loading import MAX_BYTES, examine, read_source
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.source import SourceText


def check(path: str | os.PathLike[str], *, max_bytes: int = MAX_BYTES) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Read and check a rule file.

    Args:
        path: The `.fz` file.
        max_bytes: Largest size that is read.

    Returns:
        The system, None when there are errors, and all diagnostics in the order of their places.

    Raises:
        DiagnosticError: When the file cannot be read as text at all.
    """
    return check_source(read_source(path, max_bytes=max_bytes))


def check_source(source: SourceText) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Check a source text; see `check`."""
    system, diagnostics = examine(source)
    if system is None:
        return None, diagnostics
    from fuzzyctl.analysis import coverage

    diagnostics = sorted(
        [*diagnostics, *coverage.diagnostics(system)], key=lambda d: d.span.start if d.span is not None else -1
    )
    return (None if any(d.severity == "error" for d in diagnostics) else system), diagnostics
