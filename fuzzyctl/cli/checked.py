"""Blocks that pass `fuzzyctl check`, with params set and under the profile, for commands that write them."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar, cast

from fuzzyctl.cli.common import show
from fuzzyctl.cli.loading import Choice
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from fuzzyctl.analysis.verdicts import Verdict
    from fuzzyctl.loading.load import Examined
    from fuzzyctl.model.block import Block
    from fuzzyctl.model.controller import Controller

AnyBlock = TypeVar("AnyBlock", bound="Block")


def checked(examined: Examined, block: AnyBlock, choice: Choice) -> tuple[AnyBlock, tuple[Verdict, ...]]:
    """Return a block with params set, with what is known of its guarantees; warnings are printed.

    Raises:
        DiagnosticError: With all that `fuzzyctl check` finds, if some of it is an error, see `_require_claims`.
    """
    from fuzzyctl.analysis.prove import CLAIM_SECONDS, prove

    changed, verdicts, diagnostics = analysed(examined, block, choice)
    if changed.is_sampled:
        verdicts = prove(cast("Controller", changed), timeout=CLAIM_SECONDS)
    _require_claims([*diagnostics, *claim_reports(verdicts, diagnostics)], choice)
    return changed, verdicts


def analysed(
    examined: Examined, block: AnyBlock, choice: Choice, found: list[Diagnostic] | None = None
) -> tuple[AnyBlock, tuple[Verdict, ...], list[Diagnostic]]:
    """Return a block with params set, what quick methods say of its claims, and what `fuzzyctl check` finds.

    Args:
        examined: The file.
        block: A block of it.
        choice: The params and the profile.
        found: What was found of the file for another block that is no system.

    Raises:
        DiagnosticError: For errors other than claims that do not hold.
    """
    from fuzzyctl.analysis.check import check_changed, check_examined

    changed: Any = choice.changed(block)
    if changed.is_function:
        checked_system = check_changed(examined, changed)
        verdicts, diagnostics = checked_system.verdicts, checked_system.diagnostics
    else:
        verdicts, diagnostics = (), check_examined(examined, profile=choice.profile)[1] if found is None else found
    if any(d.stops for d in diagnostics):
        raise DiagnosticError(diagnostics)
    return changed, verdicts, diagnostics


def _require_claims(diagnostics: list[Diagnostic], choice: Choice) -> None:
    """Print diagnostics; refuse claims that do not hold, unless the choice takes them.

    Raises:
        DiagnosticError: With all of them, if a claim fails.
    """
    if not choice.unproved and any(d.severity == "error" for d in diagnostics):
        unless = "change the rules, claim what holds, or write it all the same with --unproved"
        raise DiagnosticError([replace(d, help=unless) if d.witness is not None else d for d in diagnostics])
    show(diagnostics)


def claim_reports(verdicts: Sequence[Verdict], reported: Sequence[Diagnostic] = ()) -> list[Diagnostic]:
    """Report the claims that are refuted or undecided, but for those that are reported already."""
    from fuzzyctl.analysis.prove import refutation
    from fuzzyctl.analysis.verdicts import Refuted, Undecided

    known = sorted(d.span.start for d in reported if d.witness is not None and d.span is not None)
    help_text = "'fuzzyctl prove' takes the time to decide more"
    found = []
    for v in verdicts:
        if v.span is not None and bisect_left(known, v.span.start) < bisect_left(known, v.span.end):
            continue
        if isinstance(v, Refuted):
            found.append(refutation(v))
        elif isinstance(v, Undecided):
            message = f"the guarantee '{v.claim}' is undecided"
            found.append(Diagnostic("FZ402", message, v.span, "warning", (v.reason,), help_text))
    return found
