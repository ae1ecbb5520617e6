"""Loader of the commands: from their arguments to blocks with params set, under a profile, checked."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import wraps
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

from fuzzyctl.cli.common import AS, BLOCK, SET, STDIN, assignments, remark, show, standard_input
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.records import dataclass
from fuzzyctl.support.files import Place, is_name, place_of, shipped_files

if TYPE_CHECKING:
    from fuzzyctl.analysis.verdicts import Verdict
    from fuzzyctl.diagnostics.source import SourceText
    from fuzzyctl.loading.load import Examined
    from fuzzyctl.model.block import Block
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.loop import Loop
    from fuzzyctl.model.profiles import ProfileName
    from fuzzyctl.model.system import FuzzySystem

AnyBlock = TypeVar("AnyBlock", bound="Block")


@dataclass(frozen=True)
class Choice:
    """The options that choose a block and change it.

    Args:
        settings: `NAME=VALUE` for params.
        name: The block; None for the only one, or for all.
        profile: The profile to compute by; None for that of the file.
        unproved: Whether to write a block although a claim of it does not hold.
    """

    settings: tuple[str, ...] = ()
    name: str | None = None
    profile: ProfileName | None = None
    unproved: bool = False

    def changed(self, block: AnyBlock) -> AnyBlock:
        """Return a block with the params set, under the profile.

        Raises:
            DiagnosticError: For mistakes of the block then; they come from the command line, not from the file.
        """
        if block.kind == "loop":
            block = cast("AnyBlock", settings_of(self.settings, [cast("Loop", block)])[0])
        elif values := assignments(self.settings, block.settable, "param"):
            try:
                block = block.with_params(**values)
            except DiagnosticError as error:
                raise blamed(error, self.settings) from None
        return under(block, self.profile)

    def of_params(self, names: Sequence[str]) -> Choice:
        """Return the same with the settings of some params only."""
        settings = tuple(t for t in self.settings if t.partition("=")[0].strip() in names)
        return replace(self, settings=settings)


def settable(block: Block) -> list[str]:
    """Return the names that `--set` takes for a block: of a loop those of its blocks, and starts of states, too."""
    if block.kind != "loop":
        return block.settable
    from fuzzyctl.simulation.loop_params import short_names

    loop = cast("Loop", block)
    return [*short_names(loop), *loop.instance_params]


def blamed(error: DiagnosticError, settings: Sequence[str]) -> DiagnosticError:
    """Return mistakes with the settings that they come from."""
    facts = (f"with {' '.join(f'--set {text}' for text in settings)}",)
    help_text = "give --set another value"
    return DiagnosticError([replace(d, facts=(*d.facts, *facts), help=help_text) for d in error.diagnostics])


def chooses(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options `--set`, `--block` and `--as`, and their values as its argument `choice`."""

    @SET
    @BLOCK
    @AS
    @wraps(command)
    def run(*, settings: tuple[str, ...], name: str | None, profile: ProfileName | None, **others: Any) -> Any:
        return command(choice=Choice(settings, name, profile), **others)

    return run


@dataclass(frozen=True)
class Opened:
    """A file without errors, and the blocks of it that a command works on.

    Args:
        file: The examined file.
        blocks: Those chosen, with params set, under the profile.
        diagnostics: Warnings and hints of the file.
    """

    file: Examined
    blocks: tuple[Block, ...]
    diagnostics: list[Diagnostic]

    def of(self, kind: type[AnyBlock]) -> list[AnyBlock]:
        """Return the chosen blocks of a kind."""
        return [b for b in self.blocks if isinstance(b, kind)]


def source_of(file: str) -> SourceText:
    """Read a rule file, or standard input for '-'; files that its text uses are found in the current folder."""
    from fuzzyctl.support.files import decode

    data, place = content_of(file)
    return decode(data, place.name)


def content_of(file: str) -> tuple[bytes, Place]:
    """Read a file as `source_of` does, without decoding it; note on standard error that it hides a shipped one."""
    from fuzzyctl.support.files import read_bytes, read_place

    if file == "-":
        return read_bytes(standard_input(), STDIN), Place(Path(), STDIN, False)
    data, place = read_place(file)
    remark_hidden(file, place)
    return data, place


def remark_hidden(file: str, place: Place, suffix: str = ".fz") -> None:
    """Note on standard error that a file hides a shipped one, or a shipped one a file of the current folder."""
    if not place.is_shipped and is_name(file) and file in shipped_files(suffix):
        label = f"'{place.name}'{' of this folder' if place.path.parent == Path() else ''}"
        remark(f"note: {label} is read in place of the shipped '{file}'")
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


def open_blocks(file: str, choice: Choice, *, hints: bool = True) -> Opened:
    """Open the blocks of a file, or the one named; each takes the settings of its params.

    Args:
        file: The file; '-' is standard input.
        choice: The block, its params and its profile.
        hints: Whether to search for warnings and hints.

    Raises:
        DiagnosticError: With all errors of the file; for an unknown name; for params that no block has or takes; for a
            system that the tool of the profile cannot evaluate.
    """
    from fuzzyctl.loading.load import chosen
    from fuzzyctl.model.block import Block

    examined, diagnostics = _without_errors(file, hints=hints)
    blocks = examined.blocks if choice.name is None else (chosen(examined, choice.name, Block),)
    names = [settable(b) if choice.settings else [] for b in blocks]
    assignments(choice.settings, list(dict.fromkeys(chain.from_iterable(names))), "param")
    changed = (choice.of_params(params).changed(b) for b, params in zip(blocks, names, strict=True))
    return Opened(examined, tuple(changed), diagnostics)


def open_block(
    file: str, name: str | None, *kinds: type[AnyBlock], examined: Examined | None = None
) -> tuple[AnyBlock, Examined, list[Diagnostic]]:
    """Open the one block of a file that is meant, see `loading.load.chosen`.

    Returns:
        The block as it is written; the file with its warnings and hints.

    Raises:
        DiagnosticError: As `open_blocks`, with the warnings of a file with errors, as they may explain them.
    """
    from fuzzyctl.loading.load import chosen

    examined, diagnostics = _without_errors(file, examined, warnings=True)
    return chosen(examined, name, *kinds), examined, diagnostics


def _without_errors(
    file: str, examined: Examined | None = None, *, hints: bool = True, warnings: bool = False
) -> tuple[Examined, list[Diagnostic]]:
    if examined is None:
        examined = examined_file(file, hints=hints)
    diagnostics = examined.reported(examined.diagnostics)
    if errors := _errors(diagnostics):
        raise DiagnosticError(diagnostics if warnings else errors)
    return examined, diagnostics


def _errors(diagnostics: Sequence[Diagnostic]) -> list[Diagnostic]:
    return [d for d in diagnostics if d.severity == "error"]


def load_evaluable(file: str, choice: Choice, examined: Examined | None = None) -> Any:
    """Open the one system of a file, else the one controller, or the one named, as `load_checked` does."""
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.system import FuzzySystem

    kinds: tuple[type[Block], ...] = (FuzzySystem, Controller)
    return load_checked(file, choice, *kinds, examined=examined)


def load_checked(file: str, choice: Choice, *kinds: type[AnyBlock], examined: Examined | None = None) -> AnyBlock:
    """Open the one block of a file for use: all checks of its systems must pass; warnings are printed."""
    from fuzzyctl.analysis.coverage import coverage

    block, examined, _ = open_block(file, choice.name, *kinds, examined=examined)
    block = choice.changed(block)
    gaps = chain.from_iterable(map(coverage.diagnostics, block.all_systems))
    diagnostics = examined.reported([*examined.diagnostics, *gaps])
    if _errors(diagnostics):
        raise DiagnosticError(diagnostics)
    show(diagnostics)
    return block


def under(block: AnyBlock, profile: ProfileName | None) -> AnyBlock:
    """Return a block whose systems are under a profile; settings that the tool lacks are kept, with a warning."""
    if profile is None:
        return block
    from fuzzyctl.model.as_profile import as_profile
    from fuzzyctl.model.checks.checks import profile_hints

    def changed(system: FuzzySystem) -> FuzzySystem:
        under_profile = as_profile(system, profile)
        show(profile_hints(system, profile))
        return under_profile

    return block.with_systems(changed)


def checked(examined: Examined, block: AnyBlock, choice: Choice) -> tuple[AnyBlock, tuple[Verdict, ...]]:
    """Return a block with params set and the verdicts on its guarantees; warnings are printed.

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
    examined: Examined, block: AnyBlock, choice: Choice, of_file: list[Diagnostic] | None = None
) -> tuple[AnyBlock, tuple[Verdict, ...], list[Diagnostic]]:
    """Return a block with params set, quick verdicts on its claims, and the diagnostics of `fuzzyctl check`.

    Args:
        examined: The file.
        block: A block of it.
        choice: The params and the profile.
        of_file: The diagnostics of the file, if another block that is not a system has them.

    Raises:
        DiagnosticError: For errors other than claims that do not hold.
    """
    from fuzzyctl.analysis.check import check_changed, check_examined

    changed: Any = choice.changed(block)
    if changed.is_function:
        checked_system = check_changed(examined, changed)
        verdicts, diagnostics = checked_system.verdicts, checked_system.diagnostics
    else:
        verdicts, diagnostics = (), check_examined(examined, profile=choice.profile)[1] if of_file is None else of_file
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

    starts = sorted(d.span.start for d in reported if d.witness is not None and d.span is not None)
    help_text = "'fuzzyctl prove' takes the time to decide more"
    reports = []
    for v in verdicts:
        if v.span is not None and bisect_left(starts, v.span.start) < bisect_left(starts, v.span.end):
            continue
        if isinstance(v, Refuted):
            reports.append(refutation(v))
        elif isinstance(v, Undecided):
            message = f"the guarantee '{v.claim}' is undecided"
            reports.append(Diagnostic("FZ402", message, v.span, "warning", (v.reason,), help_text))
    return reports


def chosen_loops(file: str, name: str | None) -> list[tuple[str, Loop]]:
    """Open the loops of a file, or the one named, each with the name of the file; warnings are printed.

    Raises:
        DiagnosticError: With all errors of the file, but those of other loops than the one named; for a file without
            loops, and an unknown name.
    """
    from fuzzyctl.loading.load import chosen
    from fuzzyctl.model.loop import Loop

    examined = examined_file(file, loop=name)
    diagnostics = examined.reported(examined.diagnostics)
    if any(d.severity == "error" for d in diagnostics):
        raise DiagnosticError(diagnostics)
    show(diagnostics)
    if name is None and examined.loops:
        return [(file, loop) for loop in examined.loops]
    return [(file, chosen(examined, name, Loop))]


def settings_of(texts: Sequence[str], loops: Sequence[Loop]) -> list[Loop]:
    """Set params of several loops by `NAME=VALUE`; each must be a param of one of them at least.

    Raises:
        DiagnosticError: For mistakes in the texts, and values outside of the ranges of their params.
    """
    if not texts:
        return list(loops)
    from fuzzyctl.model.instance_params import with_instance_params
    from fuzzyctl.simulation.loop_params import short_names, with_settings

    loops = [with_instance_params(loop, [t.partition("=")[0].strip() for t in texts]) for loop in loops]
    names = [short_names(loop) for loop in loops]
    params = list(dict.fromkeys(n for group in (*names, *(loop.instance_params for loop in loops)) for n in group))
    values = assignments(texts, params, "param")
    changed = []
    for loop, group in zip(loops, names, strict=True):
        try:
            changed.append(with_settings(loop, {n: v for n, v in values.items() if n in group}))
        except DiagnosticError as error:
            raise blamed(error, texts) from None
    return changed
