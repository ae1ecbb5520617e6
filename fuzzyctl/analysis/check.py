"""All checks of a rule file: the structural ones and those that need a proof."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import Examined, block_name, chosen_if_sound, look_through
from fuzzyctl.model.as_profile import as_profile
from fuzzyctl.model.block import Block
from fuzzyctl.model.checks.checks import check_model, profile_hints
from fuzzyctl.model.profiles import ProfileName
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.records import dataclass
from fuzzyctl.support import arguments
from fuzzyctl.support.files import MAX_BYTES, place_of, read_source

if TYPE_CHECKING:
    from fuzzyctl.analysis.verdicts import Verdict
    from fuzzyctl.analysis.work import Work


@dataclass(frozen=True)
class Checked:
    """One system of a source with its diagnostics.

    Args:
        system: None when there are errors, those of claims apart, which stop nothing.
        verdicts: What quick methods say of its guarantees.
        diagnostics: All of them, sorted by location.
    """

    system: FuzzySystem | None
    verdicts: tuple[Verdict, ...]
    diagnostics: list[Diagnostic]


@overload
def check(
    path: str | os.PathLike[str] | FuzzySystem, *, block: None = None, max_bytes: int = ..., guarantees: bool = ...
) -> tuple[FuzzySystem | None, list[Diagnostic]]: ...
@overload
def check(
    path: str | os.PathLike[str], *, block: str, max_bytes: int = ..., guarantees: bool = ...
) -> tuple[Any, list[Diagnostic]]: ...
def check(
    path: str | os.PathLike[str] | FuzzySystem,
    *,
    block: str | None = None,
    max_bytes: int = MAX_BYTES,
    guarantees: bool = True,
) -> tuple[Block | None, list[Diagnostic]]:
    """Read and check a rule file, or check a system, such as one built in Python or one with other params.

    Args:
        path: The `.fz` file, or the system.
        block: Name of the block to return; None for the only system, or the only block of a file without systems.
        max_bytes: Largest size that is read.
        guarantees: Whether to look for guarantees that are quickly refuted, as the command does. They hold or not for
            given params; who sets params afterwards may leave it out here and prove them then.

    Returns:
        The block, None if there are errors other than claims that do not hold, and all diagnostics sorted by location.

    Raises:
        DiagnosticError: When the file cannot be read as text at all.
        ArgumentError: For an object that is neither a path nor a system.
    """
    guarantees = arguments.flag("'guarantees'", guarantees)
    name, max_bytes = block_name(block), arguments.bytes_allowed(max_bytes)
    if isinstance(path, FuzzySystem):
        diagnostics = check_model(path)
        if not _has_errors(diagnostics):
            diagnostics = [*diagnostics, *_analysed(path, guarantees=guarantees)[1]]
        return (None if any(d.stops for d in diagnostics) else path), diagnostics
    path = arguments.path(path, "; 'loads' takes texts")
    examined = look_through(read_source(path, max_bytes=max_bytes), folder=place_of(path).path.parent)
    _, diagnostics = check_examined(examined, guarantees=guarantees)
    return chosen_if_sound(examined, diagnostics, name, FuzzySystem, Block)


def check_source(
    source: SourceText, *, folder: Path | None = None, guarantees: bool = True, profile: ProfileName | None = None
) -> tuple[tuple[Block, ...], list[Diagnostic]]:
    """Check all systems, controllers, plants and loops of a source text.

    Args:
        source: The text.
        folder: The folder of the files that it uses; None for a text that may not use any.
        guarantees: Whether to look for guarantees that are quickly refuted.
        profile: The profile by whose numerics the systems are analysed; None for the one of the file. Its structure is
            checked as the file is.

    Returns:
        The blocks without errors other than claims that do not hold, and all diagnostics sorted by location.
    """
    return check_examined(look_through(source, folder=folder), guarantees=guarantees, profile=profile)


def check_examined(
    examined: Examined, *, guarantees: bool = True, profile: ProfileName | None = None
) -> tuple[tuple[Block, ...], list[Diagnostic]]:
    """Check all blocks of a source that is read; see `check_source`."""
    from fuzzyctl.analysis.work import Work

    diagnostics, sound, work = examined.diagnostics, [], Work()
    for system in examined.systems:
        system, findings = _under(system, profile, examined.source)
        findings = (
            findings if _has_errors(findings) else [*findings, *_analysed(system, work, guarantees=guarantees)[1]]
        )
        diagnostics = [*diagnostics, *findings]
        if not any(d.stops for d in findings):
            sound.append(system)
    return (*sound, *examined.equations), examined.reported(diagnostics)


def check_changed(examined: Examined, changed: FuzzySystem) -> Checked:
    """Check one system of a source without errors as it is after a change, such as with other params.

    Args:
        examined: The source.
        changed: The system that is analysed.
    """
    verdicts, findings = _analysed(changed, guarantees=True)
    diagnostics = examined.reported([*examined.diagnostics, *findings])
    return Checked(None if any(d.stops for d in diagnostics) else changed, tuple(verdicts), diagnostics)


def _under(
    system: FuzzySystem, profile: ProfileName | None, source: SourceText
) -> tuple[FuzzySystem, list[Diagnostic]]:
    """Return a system under a profile, with diagnostics: why it cannot be, or which parts do not change."""
    if profile is None:
        return system, []
    try:
        return as_profile(system, profile), profile_hints(system, profile)
    except DiagnosticError as error:
        return system, [replace(d, file=d.file or source.name) for d in error.diagnostics]


def _has_errors(diagnostics: list[Diagnostic]) -> bool:
    return any(d.severity == "error" for d in diagnostics)


def _analysed(
    system: FuzzySystem, work: Work | None = None, *, guarantees: bool
) -> tuple[list[Verdict], list[Diagnostic]]:
    """Return verdicts of guarantees, and what only the analysis of a system without structural errors finds."""
    from fuzzyctl.analysis import accuracy, bounds, effects, jumps
    from fuzzyctl.analysis.coverage import coverage, silence
    from fuzzyctl.analysis.work import Work
    from fuzzyctl.kernels.plan.build import plan

    try:
        flat = plan(system)
    except DiagnosticError as error:
        return [], list(error.diagnostics)
    work = Work() if work is None else work
    imprecise = accuracy.diagnostics(system, flat, work)
    uncovered = coverage.uncovered_of(flat, work)
    if not any(uncovered.values()):  # a proof with less work is a proof
        system.derived.setdefault("uncovered", uncovered)
    results = coverage.diagnostics_of(system, flat, uncovered, work)
    idle = effects.diagnostics(system, flat, work)
    if _has_errors(results):
        return [], [*results, *idle]
    results = [
        *results,
        *idle,
        *jumps.diagnostics(system, flat, uncovered, work),
        *bounds.diagnostics(system, flat, uncovered),
        *imprecise,
        *silence.weak_coverage(system, flat),
    ]
    if guarantees and system.guarantees:
        from fuzzyctl.analysis import prove

        verdicts, refuted = prove.quickly(system, work)
        return verdicts, [*results, *refuted]
    return [], results
