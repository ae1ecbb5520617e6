"""Blocks that pass `fuzzyctl check`, with params set and under the profile, for commands that write them."""

from __future__ import annotations

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
        DiagnosticError: With all that `fuzzyctl check` finds, if some of it is an error.
    """
    from fuzzyctl.analysis.check import check_changed

    checked = check_changed(examined, choice.changed, system=choice.name)
    if checked.system is None:
        raise DiagnosticError(checked.diagnostics)
    show([*checked.diagnostics, *undecided(checked.verdicts)])
    return checked.system, checked.verdicts


def checked_block(examined: Examined, block: _Block, choice: Choice) -> _Block:
    """Return a controller or plant; warnings are printed.

    Raises:
        DiagnosticError: With all that `fuzzyctl check` finds, if some of it is an error.
    """
    from fuzzyctl.analysis.check import check_examined

    _, diagnostics = check_examined(examined, profile=choice.profile)
    if any(d.severity == "error" for d in diagnostics):
        raise DiagnosticError(diagnostics)
    show(diagnostics)
    return block_under(choice.with_settings(block), choice.profile)


def block_under(block: _Block, profile: ProfileName | None) -> _Block:
    """Return a block whose systems are under a profile."""
    from fuzzyctl.model.controller import Controller

    systems = tuple(under(s, profile) for s in block.systems)
    if isinstance(block, Controller):
        return replace(block, systems=systems, controllers=tuple(block_under(c, profile) for c in block.controllers))
    return replace(block, systems=systems)


def undecided(verdicts: tuple[Verdict, ...]) -> list[Diagnostic]:
    """Warn of guarantees that quick methods leave open."""
    from fuzzyctl.analysis.verdicts import Undecided

    help_text = "'fuzzyctl prove' takes the time to decide more"
    return [
        Diagnostic("FZ402", f"the guarantee '{v.claim}' is undecided", v.span, "warning", (v.reason,), help_text)
        for v in verdicts
        if isinstance(v, Undecided)
    ]
