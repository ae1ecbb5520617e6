"""Blocks that pass `fuzzyctl check`, with params set and under the profile, for commands that write them."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

from fuzzyctl.cli.common import show
from fuzzyctl.cli.loading import Choice, under
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from fuzzyctl.analysis.verdicts import Verdict
    from fuzzyctl.loading.load import Examined
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.plant import Plant
    from fuzzyctl.model.profiles import ProfileName
    from fuzzyctl.model.system import FuzzySystem

_Block = TypeVar("_Block", bound="Controller | Plant")


def checked_system(examined: Examined, choice: Choice) -> tuple[FuzzySystem, tuple[Verdict, ...]]:
    """Return a system with what is known of its guarantees; warnings are printed.

    Raises:
        DiagnosticError: With all that `fuzzyctl check` finds, if some of it is an error, see `_require_claims`.
    """
    from fuzzyctl.analysis.check import check_changed

    checked = check_changed(examined, choice.changed, system=choice.name)
    if checked.system is None:
        raise DiagnosticError(checked.diagnostics)
    _require_claims([*checked.diagnostics, *claim_reports(checked.verdicts, checked.diagnostics)], choice)
    return checked.system, checked.verdicts


def checked_block(examined: Examined, block: _Block, choice: Choice) -> tuple[_Block, tuple[Verdict, ...]]:
    """Return a controller or plant with what is known of its guarantees; warnings are printed.

    Raises:
        DiagnosticError: With all that `fuzzyctl check` finds, if some of it is an error, see `_require_claims`.
    """
    from fuzzyctl.analysis.check import check_examined
    from fuzzyctl.analysis.prove import CLAIM_SECONDS, prove
    from fuzzyctl.model.controller import Controller

    _, diagnostics = check_examined(examined, profile=choice.profile)
    if any(d.stops for d in diagnostics):
        raise DiagnosticError(diagnostics)
    chosen = block_under(choice.with_settings(block), choice.profile)
    verdicts = prove(chosen, timeout=CLAIM_SECONDS) if isinstance(chosen, Controller) else ()
    _require_claims([*diagnostics, *claim_reports(verdicts)], choice)
    return chosen, verdicts


def _require_claims(diagnostics: list[Diagnostic], choice: Choice) -> None:
    """Print diagnostics; refuse claims that do not hold, unless the choice takes them.

    Raises:
        DiagnosticError: With all of them, if a claim fails.
    """
    if not choice.unproved and any(d.severity == "error" for d in diagnostics):
        unless = "change the rules, claim what holds, or write it all the same with --unproved"
        raise DiagnosticError([replace(d, help=unless) if d.witness is not None else d for d in diagnostics])
    show(diagnostics)


def block_under(block: _Block, profile: ProfileName | None) -> _Block:
    """Return a block whose systems are under a profile."""
    systems = tuple(under(s, profile) for s in block.systems)
    return replace(block, systems=systems, controllers=tuple(block_under(c, profile) for c in block.controllers))


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
