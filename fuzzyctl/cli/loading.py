"""Loader of the commands: from their arguments to systems with params set, under a profile, checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from fuzzyctl.cli.common import STDIN, assignments, show, standard_input
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from fuzzyctl.diagnostics.source import SourceText
    from fuzzyctl.kernels.plan.plan import Plan
    from fuzzyctl.loading.load import Examined
    from fuzzyctl.model.system import FuzzySystem


@dataclass(frozen=True)
class Opened:
    """A file without errors, and the systems of it that a command works on.

    Args:
        file: What the file holds.
        systems: Those chosen, with params set, under the profile; one or more.
        diagnostics: Warnings and hints of the file.
    """

    file: Examined
    systems: tuple[FuzzySystem, ...]
    diagnostics: list[Diagnostic]


@dataclass(frozen=True)
class Loaded:
    """A system that has passed all checks, and its plan."""

    system: FuzzySystem
    plan: Plan


def source_of(file: str) -> SourceText:
    """Read a rule file, or standard input for '-'; files that its text uses are found in the current folder."""
    from fuzzyctl.support.reading import read_source, read_stream

    return read_stream(standard_input(), STDIN) if file == "-" else read_source(file)


def open_systems(
    file: str,
    settings: Sequence[str] = (),
    name: str | None = None,
    profile: str | None = None,
    *,
    several: bool = True,
    hints: bool = True,
) -> Opened:
    """Open the systems of a file.

    Args:
        file: The file; '-' is standard input.
        settings: `NAME=VALUE` for params.
        name: Of the only system that is wanted; None for all.
        profile: The profile to compute by; None for what the file says.
        several: Whether the command works on several systems; else `name` chooses one where there are several.
        hints: Whether to look for what can only be a warning.

    Raises:
        DiagnosticError: With all errors of the file, and its warnings where one system is wanted, as they may explain
            them; for params that the system does not have or take; for a system that the tool of the profile cannot
            evaluate.
    """
    from fuzzyctl.loading.load import choose, look_through

    source = source_of(file)
    examined = look_through(source, folder=Path(file).parent, hints=hints)
    systems, diagnostics = examined.systems, examined.told(examined.diagnostics)
    if name is not None or not several:
        system, diagnostics = choose(source, systems, diagnostics, name)
        systems = (system,) if system is not None else ()
    errors = [d for d in diagnostics if d.severity == "error"]
    if errors:
        raise DiagnosticError(errors if several else diagnostics)
    return Opened(examined, tuple(changed(system, settings, profile) for system in systems), diagnostics)


def load_checked(
    file: str, settings: Sequence[str] = (), name: str | None = None, profile: str | None = None
) -> Loaded:
    """Open the one system of a file, or the one named, for use: all its checks must pass; warnings are printed."""
    from fuzzyctl.analysis.coverage import coverage
    from fuzzyctl.kernels.plan.build import plan

    opened = open_systems(file, settings, name, profile, several=False)
    system = opened.systems[0]
    flat = plan(system)
    found = coverage.diagnostics_of(system, flat, coverage.uncovered_of(flat))
    diagnostics = opened.file.told([*opened.file.diagnostics, *found])
    if any(d.severity == "error" for d in diagnostics):
        raise DiagnosticError(diagnostics)
    show(diagnostics)
    return Loaded(system, flat)


def changed(system: FuzzySystem, settings: Sequence[str], profile: str | None) -> FuzzySystem:
    """Return a system with params set, under a profile.

    Raises:
        DiagnosticError: For what is wrong with the system then; it comes from the command line, not from the file.
    """
    values = assignments(settings, [p.name for p in system.params], "param")
    try:
        system = system.with_params(**values) if values else system
    except DiagnosticError as error:
        facts = (f"with {' '.join(f'--set {text}' for text in settings)}",)
        blamed = [replace(d, facts=(*d.facts, *facts), help="give --set another value") for d in error.diagnostics]
        raise DiagnosticError(blamed) from None
    return under(system, profile)


def under(system: FuzzySystem, profile: str | None) -> FuzzySystem:
    """Return a system under a profile, or as it is; what stays as it is although the tool has no such thing is said."""
    if profile is None:
        return system
    from fuzzyctl.model.checks.profile_limits import kept
    from fuzzyctl.model.profiles import as_profile

    changed = as_profile(system, profile)
    show(kept(system, profile))
    return changed
