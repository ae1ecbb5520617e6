"""Loader of the commands: from their arguments to systems with params set, under a profile, checked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import wraps
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from fuzzyctl.cli.common import AS, SET, STDIN, SYSTEM, assignments, remark, show, standard_input
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.support.shipped import Place, is_name, place_of, shipped_files

if TYPE_CHECKING:
    from fuzzyctl.diagnostics.source import SourceText
    from fuzzyctl.loading.load import Examined
    from fuzzyctl.model.controller import Controller, EquationBlock
    from fuzzyctl.model.profiles import ProfileName
    from fuzzyctl.model.system import FuzzySystem

AnyBlock = TypeVar("AnyBlock", bound="EquationBlock")


@dataclass(frozen=True)
class Choice:
    """What a command makes of a file.

    Args:
        settings: `NAME=VALUE` for params.
        name: The system, where the file holds several; None for the only one, or for all.
        profile: The profile to compute by; None for what the file says.
        unproved: Whether to write a block although a claim of it does not hold.
    """

    settings: tuple[str, ...] = ()
    name: str | None = None
    profile: ProfileName | None = None
    unproved: bool = False

    def changed(self, system: FuzzySystem) -> FuzzySystem:
        """Return a system with the params set, under the profile.

        Raises:
            DiagnosticError: For what is wrong with the system then; it comes from the command line, not from the file.
        """
        values = assignments(self.settings, [p.name for p in system.params], "param")
        try:
            system = system.with_params(**values) if values else system
        except DiagnosticError as error:
            raise blamed(error, self.settings) from None
        return under(system, self.profile)

    def with_settings(self, block: AnyBlock) -> AnyBlock:
        """Return a controller, plant or loop with the params set.

        Raises:
            DiagnosticError: As `changed`.
        """
        values = assignments(self.settings, params_of(block), "param")
        if not values:
            return block
        from fuzzyctl.loading.block_equations import with_params
        from fuzzyctl.model.instance_params import with_instance_params

        try:
            return with_params(with_instance_params(block, values), values)
        except DiagnosticError as error:
            raise blamed(error, self.settings) from None

    def of_params(self, names: Sequence[str]) -> Choice:
        """Return the same with the settings of some params only."""
        own = tuple(t for t in self.settings if t.partition("=")[0].strip() in names)
        return replace(self, settings=own)


def params_of(block: EquationBlock) -> list[str]:
    """Return the names of the params that can be set: those of a controller's instances are among them."""
    from fuzzyctl.model.instance_params import instance_params

    return [*(p.name for p in block.params), *(instance_params(block) if block.kind == "controller" else ())]


def blamed(error: DiagnosticError, settings: Sequence[str]) -> DiagnosticError:
    """Return mistakes with the settings that they come from."""
    facts = (f"with {' '.join(f'--set {text}' for text in settings)}",)
    help_text = "give --set another value"
    return DiagnosticError([replace(d, facts=(*d.facts, *facts), help=help_text) for d in error.diagnostics])


def chooses(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options `--set`, `--system` and `--as`, and their values as its argument `choice`."""

    @SET
    @SYSTEM
    @AS
    @wraps(command)
    def run(*, settings: tuple[str, ...], name: str | None, profile: ProfileName | None, **others: Any) -> Any:
        return command(choice=Choice(settings, name, profile), **others)

    return run


@dataclass(frozen=True)
class Opened:
    """A file without errors, and the systems of it that a command works on.

    Args:
        file: What the file holds.
        systems: Those chosen, with params set, under the profile.
        diagnostics: Warnings and hints of the file.
        blocks: Controllers, plants and loops that were chosen, with params set.
    """

    file: Examined
    systems: tuple[FuzzySystem, ...]
    diagnostics: list[Diagnostic]
    blocks: tuple[EquationBlock, ...] = ()


def source_of(file: str) -> SourceText:
    """Read a rule file, or standard input for '-'; files that its text uses are found in the current folder."""
    from fuzzyctl.support.reading import decode

    data, place = content_of(file)
    return decode(data, place.name)


def content_of(file: str) -> tuple[bytes, Place]:
    """Read a file as `source_of` does, without decoding it; note on standard error that it hides a shipped one."""
    from fuzzyctl.support.reading import read_bytes, read_place

    if file == "-":
        return read_bytes(standard_input(), STDIN), Place(Path(), STDIN, False)
    data, place = read_place(file)
    remark_hidden(file, place)
    return data, place


def remark_hidden(file: str, place: Place, suffix: str = ".fz") -> None:
    """Note on standard error that a file hides a shipped one, or a shipped one a file of the current folder."""
    if not place.is_shipped and is_name(file) and file in shipped_files(suffix):
        shown = f"'{place.name}'{' of this folder' if place.path.parent == Path() else ''}"
        remark(f"note: {shown} is read in place of the shipped '{file}'")
    elif place.is_shipped and not place_of(file, suffix).is_shipped:
        remark(f"note: the shipped '{file}' is read, not '{place_of(file, suffix).name}' of this folder")


def folder_of(file: str) -> Path:
    """Return the folder of a file argument, in which the files that it uses are found."""
    return place_of(file).path.parent


def examined_file(file: str, **options: Any) -> Examined:
    """Read and examine a file argument, with options of `look_through`.

    Raises:
        DiagnosticError: For a file that cannot be read.
    """
    from fuzzyctl.loading.load import look_through

    return look_through(source_of(file), folder=folder_of(file), **options)


def require_own(place: Place) -> None:
    """Refuse to write a shipped file.

    Raises:
        DiagnosticError: For one, with the command that copies it.
    """
    if place.is_shipped:
        help_text = f"make a copy and change that: fuzzyctl new NAME --from {place.name}"
        raise DiagnosticError([Diagnostic("FZ005", "a shipped file is not changed", file=place.name, help=help_text)])


def open_systems(
    file: str,
    choice: Choice,
    *,
    several: bool = True,
    hints: bool = True,
    blocks: bool = False,
    examined: Examined | None = None,
) -> Opened:
    """Open the systems of a file.

    Args:
        file: The file; '-' is standard input.
        choice: What to make of it.
        several: Whether the command works on several systems.
        hints: Whether to look for what can only be a warning.
        blocks: Whether the command works on controllers, plants and loops as well.
        examined: What the file holds, where it was read before.

    Raises:
        DiagnosticError: With all errors of the file, and its warnings where one system is wanted, as they may explain
            them; for params that the system does not have or take; for a system that the tool of the profile cannot
            evaluate.
    """
    from fuzzyctl.loading.choice import choose, not_chosen, without_system

    if examined is None:
        examined = examined_file(file, hints=hints)
    source = examined.source
    systems, diagnostics = examined.systems, examined.reported(examined.diagnostics)
    chosen = tuple(b for b in examined.blocks if blocks and choice.name in (None, b.name))
    if chosen and choice.name is not None:
        systems = ()
    elif choice.name is not None or not several:
        names = [b.name for b in (*systems, *examined.blocks)]
        if blocks and examined.blocks and choice.name not in [None, *names]:
            raise DiagnosticError(_errors(diagnostics) or [not_chosen(source, names, "block", choice.name)])
        system, diagnostics = choose(source, systems, diagnostics, choice.name, examined.blocks)
        systems = (system,) if system is not None else ()
    elif examined.blocks and not systems and not blocks:
        diagnostics = [*diagnostics, without_system(source, examined.blocks)]
    errors = _errors(diagnostics)
    if errors:
        raise DiagnosticError(errors if several else diagnostics)
    opened = Opened(examined, tuple(map(choice.changed, systems)), diagnostics)
    return replace(opened, blocks=tuple(map(choice.with_settings, chosen))) if chosen else opened


def _errors(diagnostics: Sequence[Diagnostic]) -> list[Diagnostic]:
    return [d for d in diagnostics if d.severity == "error"]


def open_blocks(file: str, choice: Choice) -> Opened:
    """Open the systems, and the other blocks, of a file, or the one named; each takes the settings of its own params.

    Raises:
        DiagnosticError: As `open_systems` does.
    """
    opened = open_systems(file, replace(choice, settings=(), profile=None), blocks=True)
    if not opened.blocks:
        return replace(opened, systems=tuple(map(choice.changed, opened.systems)))
    params = [[p.name for p in s.params] for s in opened.systems] + [params_of(b) for b in opened.blocks]
    assignments(choice.settings, list(dict.fromkeys(chain.from_iterable(params))), "param")
    return replace(
        opened,
        systems=tuple(choice.of_params([p.name for p in s.params]).changed(s) for s in opened.systems),
        blocks=tuple(choice.of_params(params_of(b)).with_settings(b) for b in opened.blocks),
    )


def controllers_of(opened: Opened) -> list[Controller]:
    """Return the controllers among the blocks that are open."""
    from fuzzyctl.model.controller import Controller

    return [b for b in opened.blocks if isinstance(b, Controller)]


def load_checked(file: str, choice: Choice, examined: Examined | None = None) -> FuzzySystem:
    """Open the one system of a file, or the one named, for use: all its checks must pass; warnings are printed."""
    from fuzzyctl.analysis.coverage import coverage

    opened = open_systems(file, choice, several=False, examined=examined)
    system = opened.systems[0]
    diagnostics = opened.file.reported([*opened.file.diagnostics, *coverage.diagnostics(system)])
    if _errors(diagnostics):
        raise DiagnosticError(diagnostics)
    show(diagnostics)
    return system


def under(system: FuzzySystem, profile: ProfileName | None) -> FuzzySystem:
    """Return a system under a profile, or as it is; what stays as it is although the tool has no such thing is said."""
    if profile is None:
        return system
    from fuzzyctl.model.as_profile import as_profile
    from fuzzyctl.model.checks.profile_limits import kept

    changed = as_profile(system, profile)
    show(kept(system, profile))
    return changed
