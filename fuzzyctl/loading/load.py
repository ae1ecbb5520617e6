"""Loader of fuzzy systems: read → parse → assemble → resolve → check."""

from __future__ import annotations

import dataclasses
import os
import re
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeVar

from fuzzyctl.diagnostics.diagnostic import CODES, ArgumentError, Diagnostic, DiagnosticError, Note
from fuzzyctl.diagnostics.fixes import respelt
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.formats.registry import format_of
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.parser import parse
from fuzzyctl.lang.repaired_text import in_original
from fuzzyctl.loading.assembly import Part, bring_in, split, without_other_loops
from fuzzyctl.loading.calls import with_called
from fuzzyctl.loading.linking import link
from fuzzyctl.model.checks.checks import check_model
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.resolve import resolve
from fuzzyctl.support import arguments
from fuzzyctl.support.reading import MAX_BYTES, decode, read_source

if TYPE_CHECKING:
    from fuzzyctl.loading.blocks import Block, Callee
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.loop import Loop
    from fuzzyctl.model.plant import Plant

#: Most systems of a file, and most statements that they share, counted once for each system.
MAX_SYSTEMS: Final = 200
MAX_SHARED: Final = 20_000

_TERM_LINE: Final = re.compile(rf"[ \t]*(?:terms\b|{sx.NAME}[ \t]*=)")
_QUOTED: Final = re.compile(r"'[^']*'")

_Block = TypeVar("_Block", "FuzzySystem", "Controller", "Plant", "Loop", "FuzzySystem | Controller")

#: By file its systems, controllers and plants.
Opened = dict[Path, tuple["Callee", ...]]

__all__ = [
    "MAX_BYTES",
    "decode",
    "examine",
    "examine_all",
    "load",
    "load_all",
    "load_controller",
    "load_loop",
    "load_plant",
    "loads",
    "read_source",
]


def load(path: str | os.PathLike[str], *, system: str | None = None, max_bytes: int = MAX_BYTES) -> FuzzySystem:
    """Read a fuzzy system from a rule file, or from a file of another tool.

    The structure of the file is checked. Gaps between the rules, guarantees and warnings are not: `fuzzyctl.check`
    reports them.

    Args:
        path: The file; its suffix gives the format: `.fll`, `.fis`, `.fcl`, `.fml` and `.xml` are files of other tools,
            every other suffix is a rule file, usually `.fz`.
        system: Name of the system; required if the file holds several.
        max_bytes: Largest size that is read [bytes].

    Returns:
        The system.

    Raises:
        DiagnosticError: With all errors of the file, each with line, column and help; for a file that cannot be read;
            for several systems without a chosen name.
        ArgumentError: For an argument of another type.
        ValueOutOfBoundsError: For `max_bytes` out of its bounds.
    """
    path, system = arguments.path(path, "; 'loads' takes texts"), chosen_name(system)
    source = read_source(path, max_bytes=arguments.bytes_allowed(max_bytes))
    return _required(examine(source, folder=Path(path).parent, system=system, hints=False))


def load_all(path: str | os.PathLike[str], *, max_bytes: int = MAX_BYTES) -> tuple[FuzzySystem, ...]:
    """Read all fuzzy systems of a rule file, in the order written.

    Args:
        path: The file, as for `load`.
        max_bytes: Largest size that is read [bytes].

    Raises:
        DiagnosticError: With all errors of the file.
        ArgumentError: For an argument of another type.
        ValueOutOfBoundsError: For `max_bytes` out of its bounds.
    """
    path = arguments.path(path, "; 'loads' takes texts")
    source = read_source(path, max_bytes=arguments.bytes_allowed(max_bytes))
    systems, diagnostics = examine_all(source, folder=Path(path).parent, hints=False)
    errors = [d for d in diagnostics if d.severity == "error"]
    if errors:
        raise DiagnosticError(errors)
    return systems


def loads(text: str, name: str = "<text>", *, system: str | None = None) -> FuzzySystem:
    """Read a fuzzy system from a text.

    Args:
        text: What a rule file holds; it can use no other files.
        name: Shown in diagnostics; its suffix gives the format, as for `load`.
        system: Name of the system; required if the text holds several.

    Raises:
        DiagnosticError: With all errors of the text; for characters that no text file can hold.
        ArgumentError: For an argument of another type.
    """
    if not isinstance(text, str):
        raise ArgumentError(f"expected the text of a rule file, got {type(text).__name__}; 'load' takes paths")
    source = SourceText(arguments.text("'name'", name), text)
    _require_characters(source)
    return _required(examine(source, system=chosen_name(system), hints=False))


def load_controller(
    path: str | os.PathLike[str], controller: str | None = None, *, max_bytes: int = MAX_BYTES
) -> Controller:
    """Read a controller from a rule file.

    Args:
        path: The file.
        controller: Name of the controller; required if the file holds several.
        max_bytes: Largest size that is read [bytes].

    Raises:
        DiagnosticError: With all errors of the file; for a file that holds no controller, or several without a chosen
            name.
        ArgumentError: For an argument of another type.
        ValueOutOfBoundsError: For `max_bytes` out of its bounds.
    """
    found = _opened(path, max_bytes)
    return _one_of(found, found.controllers, "controller", chosen_name(controller, "controller"))


def load_plant(path: str | os.PathLike[str], plant: str | None = None, *, max_bytes: int = MAX_BYTES) -> Plant:
    """Read a plant from a rule file.

    Args:
        path: The file.
        plant: Name of the plant; required if the file holds several.
        max_bytes: Largest size that is read [bytes].

    Raises:
        DiagnosticError: As for `load_controller`.
        ArgumentError: For an argument of another type.
        ValueOutOfBoundsError: For `max_bytes` out of its bounds.
    """
    found = _opened(path, max_bytes)
    return _one_of(found, found.plants, "plant", chosen_name(plant, "plant"))


def load_loop(path: str | os.PathLike[str], loop: str | None = None, *, max_bytes: int = MAX_BYTES) -> Loop:
    """Read a loop from a rule file, with the controllers and plants that it connects.

    Args:
        path: The file.
        loop: Name of the loop; required if the file holds several.
        max_bytes: Largest size that is read [bytes].

    Raises:
        DiagnosticError: As for `load_controller`.
        ArgumentError: For an argument of another type.
        ValueOutOfBoundsError: For `max_bytes` out of its bounds.
    """
    found = _opened(path, max_bytes)
    return _one_of(found, found.loops, "loop", chosen_name(loop, "loop"))


def _opened(path: str | os.PathLike[str], max_bytes: int) -> Examined:
    """Read a rule file.

    Raises:
        DiagnosticError: With all errors of the file.
    """
    path = arguments.path(path)
    source = read_source(path, max_bytes=arguments.bytes_allowed(max_bytes))
    found = look_through(source, folder=Path(path).parent, hints=False)
    errors = [d for d in found.reported(found.diagnostics) if d.severity == "error"]
    if errors:
        raise DiagnosticError(errors)
    return found


def _one_of(found: Examined, blocks: Sequence[_Block], kind: str, name: str | None) -> _Block:
    chosen = chosen_block(found.source, blocks, kind, name)
    if isinstance(chosen, Diagnostic):
        raise DiagnosticError([chosen])
    return chosen


def chosen_name(name: object, kind: str = "system") -> str | None:
    """Return the name of the system, controller, plant or loop that is chosen among several.

    Raises:
        ArgumentError: For what is no name.
    """
    return None if name is None else arguments.instance(f"'{kind}'", str, f"the name of a {kind}, or None", name)


def _require_characters(source: SourceText) -> None:
    """Refuse what no text file can hold, so that what can be read can be written.

    Raises:
        DiagnosticError: For NUL and for halves of surrogate pairs.
    """
    at = arguments.no_character(source.text)
    if at is not None:  # shown by its number only, since half a pair cannot be printed
        message = f"the text cannot be that of a file: U+{ord(source.text[at]):04X} in line {source.line_of(at)}"
        raise DiagnosticError([Diagnostic("FZ002", message, file=source.name, help="remove it")])


def examine(
    source: SourceText, *, folder: Path | None = None, system: str | None = None, hints: bool = True
) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Parse, assemble, resolve and check a source that holds one system, or several with one chosen by name.

    Args:
        source: The text.
        folder: Where the files stand that it uses; None for a text that may use none.
        system: Name of the system, where there are several.
        hints: Whether to look for what can only be a warning; without it a file is read faster.

    Returns:
        The system, None when there are errors, and all diagnostics, warnings included, in the order of their places.
    """
    found = look_through(source, folder=folder, hints=hints)
    return choose(source, found.systems, found.reported(found.diagnostics), system, found.blocks)


def choose(
    source: SourceText,
    systems: Sequence[FuzzySystem],
    diagnostics: list[Diagnostic],
    system: str | None,
    blocks: Sequence[Block] = (),
) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Pick the one system of a file, or the one named; None when there are errors.

    Where there is none, the other blocks of the file are named.
    """
    if any(d.severity == "error" for d in diagnostics):
        return None, diagnostics
    found = chosen_block(source, systems, "system", system)
    if isinstance(found, Diagnostic) and blocks and not systems:
        found = without_system(source, blocks)
    return (None, [*diagnostics, found]) if isinstance(found, Diagnostic) else (found, diagnostics)


def choose_controller(examined: Examined, name: str | None) -> Controller | None:
    """Return the controller of a file, or the one named; None where a system is meant.

    A file with a controller is meant as its controller: the systems are what it calls.

    Raises:
        DiagnosticError: Where several controllers are there and none is named, and for a name that no block has.
    """
    if not examined.controllers or (name is not None and name in [s.name for s in examined.systems]):
        return None
    found: FuzzySystem | Controller | Diagnostic = chosen_block(
        examined.source, examined.controllers, "controller", name
    )
    if name is not None and isinstance(found, Diagnostic):
        blocks: Sequence[FuzzySystem | Controller] = (*examined.systems, *examined.controllers)
        found = chosen_block(examined.source, blocks, "system or controller", name)
    if isinstance(found, Diagnostic):
        raise DiagnosticError([found])
    assert not isinstance(found, FuzzySystem), "systems are looked for before"
    return found


def without_system(source: SourceText, blocks: Sequence[Block]) -> Diagnostic:
    """Return the diagnostic of a file that holds other blocks in place of a system."""
    held = ", ".join(f"{type(b).__name__.lower()} '{b.name}'" for b in blocks)
    help_text = "give a file with a 'system' block; 'fuzzyctl show' prints controllers, plants and loops"
    return Diagnostic(
        "FZ502", "the file holds no system", facts=(f"it holds: {held}",), help=help_text, file=source.name
    )


def chosen_block(source: SourceText, blocks: Sequence[_Block], kind: str, name: str | None) -> _Block | Diagnostic:
    """Pick the one system or controller of a file, or the one named; what is wrong where there is none."""
    names = [b.name for b in blocks]
    if name is None and len(blocks) == 1:
        return blocks[0]
    return blocks[names.index(name)] if name in names else not_chosen(source, names, kind, name)


def not_chosen(source: SourceText, names: Sequence[str], kind: str, name: str | None) -> Diagnostic:
    """Return why none of the systems or other blocks of a file is chosen."""
    if not names:
        message, help_text = f"the file holds no {kind}", ""
    elif name is None:
        message, help_text = f"the file holds several {kind}s, and none is chosen", f"name one, such as '{names[0]}'"
    else:
        near = closest(name, names)
        message, help_text = f"the file holds no {kind} '{name}'", f"did you mean '{near}'?" if near else ""
    facts = (f"{kind.replace(' or', 's or')}s: {', '.join(names)}",) if names else ()
    return Diagnostic("FZ502", message, facts=facts, help=help_text, file=source.name)


def examine_all(
    source: SourceText, *, folder: Path | None = None, hints: bool = True
) -> tuple[tuple[FuzzySystem, ...], list[Diagnostic]]:
    """Do the same for all systems of a source; those with errors are left out.

    The suffix of the source's name says the format; whatever is no format of another tool is a rule file.
    """
    found = look_through(source, folder=folder, hints=hints)
    return found.systems, found.reported(found.diagnostics)


@dataclasses.dataclass(frozen=True)
class Examined:
    """What a source holds.

    Args:
        source: The text.
        systems: Those without errors.
        diagnostics: All of them, whatever the file allows or denies.
        policy: The lines that say what it does.
        blocks: The controllers, plants and loops without errors, in the order written.
    """

    source: SourceText
    systems: tuple[FuzzySystem, ...]
    diagnostics: list[Diagnostic]
    policy: tuple[sx.Allow, ...] = ()
    blocks: tuple[Block, ...] = ()

    @property
    def controllers(self) -> tuple[Controller, ...]:
        """The controllers."""
        from fuzzyctl.model.controller import Controller

        return tuple(b for b in self.blocks if isinstance(b, Controller))

    @property
    def plants(self) -> tuple[Plant, ...]:
        """The plants."""
        from fuzzyctl.model.plant import Plant

        return tuple(b for b in self.blocks if isinstance(b, Plant))

    @property
    def loops(self) -> tuple[Loop, ...]:
        """The loops."""
        from fuzzyctl.model.loop import Loop

        return tuple(b for b in self.blocks if isinstance(b, Loop))

    def reported(self, diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
        """Return diagnostics in order, as the lines of the file want them."""
        return [in_original(d) for d in apply_policy(in_order(self.source, diagnostics), self.policy)]


def look_through(
    source: SourceText,
    *,
    folder: Path | None = None,
    hints: bool = True,
    opened: Opened | None = None,
    loop: str | None = None,
) -> Examined:
    """Examine all systems of a source; what it allows and denies is left to whoever knows all diagnostics.

    Args:
        source: The text.
        folder: Where the files stand that it uses.
        hints: Whether to look for what can only be a warning.
        opened: The systems of files that have been read for this check already.
        loop: Name of the loop that is wanted; mistakes in other loops of the file are left out.
    """
    foreign = format_of(source.name)
    if foreign is not None:
        from fuzzyctl.formats.foreign import examine_foreign

        return Examined(source, *examine_foreign(foreign, source))
    tree, mistakes = parse(source)
    if loop is not None:
        tree, mistakes = without_other_loops(tree, mistakes, loop)
    tree, more = bring_in(tree, folder)
    diagnostics = [*mistakes, *more]
    broken = bool(more) or (bool(mistakes) and not tree.repaired)
    systems: list[FuzzySystem] = []
    policy = [s for s in tree.statements if isinstance(s, sx.Allow)]
    hints = hints or any(line.keyword.text == "deny" for line in policy)
    parts = split(tree)
    crowd = _crowded(source, parts)
    if crowd is not None:
        return Examined(source, (), [in_original(d) for d in (*diagnostics, crowd)], tuple(policy))
    for part in parts:
        if isinstance(part.head, sx.Head):
            continue
        system, found = _examine_part(part, broken, hints)
        # Warnings are of the file as it is, not of what its repair would be.
        diagnostics.extend(d for d in found if d.severity == "error" or not tree.repaired)
        systems.extend([system] if system is not None else [])
    diagnostics.extend(_same_names(systems))
    used = _Used(tree, folder, {} if opened is None else opened)
    failed = any(d.severity == "error" for d in diagnostics)
    called, wrong = tuple(systems), list[Diagnostic]()
    if any(s.lets for s in systems):
        called, wrong = with_called(systems, used.system, broken=failed)
    linked, more = link(called, used.system, broken=failed or bool(wrong))
    diagnostics.extend(wrong)
    equations: tuple[Block, ...] = ()
    if any(isinstance(part.head, sx.Head) for part in parts):
        from fuzzyctl.loading.blocks import Blocks

        blocks = Blocks(parts, linked, used.block, folder)
        equations = blocks.all()
        diagnostics.extend(_without_follow_ups(source, mistakes, blocks.diagnostics))
    # What was read after repairs is no system of the file, but its mistakes are those of the file.
    found = [in_original(d) for d in (*diagnostics, *more, *used.mistakes)]
    return Examined(source, () if mistakes else linked, found, tuple(policy), () if mistakes else equations)


def _without_follow_ups(source: SourceText, mistakes: list[Diagnostic], found: list[Diagnostic]) -> list[Diagnostic]:
    """Leave out what is wrong with the meaning of lines that begin with no keyword, or have an open parenthesis."""
    lines = {d.span.line for d in mistakes if d.code in ("FZ101", "FZ103") and d.span is not None}
    return [d for d in found if d.span is None or d.span.source.name != source.name or d.span.line not in lines]


def _crowded(source: SourceText, parts: Sequence[Part]) -> Diagnostic | None:
    """Report a file with more systems than are read, or with too much that is read for each of them."""
    place = next((s.name.span for s in parts[-1].tree.statements if isinstance(s, sx.System | sx.Head)), None)
    if len(parts) > MAX_SYSTEMS:
        message = f"the file holds {len(parts)} systems, more than {MAX_SYSTEMS}"
        return Diagnostic("FZ112", message, place, help="spread them over several files")
    shared = len(parts) * len(parts[0].shared)
    if len(parts) > 1 and shared > MAX_SHARED:
        message = (
            f"{len(parts)} systems share {len(parts[0].shared)} statements, {shared} in all, more than {MAX_SHARED}"
        )
        return Diagnostic("FZ112", message, place, help="spread the systems over several files")
    return None


class _Used:
    """The systems of the files that a file uses, read when one of them is named.

    Attributes:
        mistakes: Those of the files read.
    """

    def __init__(self, tree: sx.SyntaxTree, folder: Path | None, opened: Opened) -> None:
        self.opened = opened
        names = dict.fromkeys(s.path for s in tree.statements if isinstance(s, sx.Use))
        self.paths = [folder / name for name in names] if folder is not None else []
        self.blocks: dict[str, Callee] = {}
        self.mistakes: list[Diagnostic] = []

    def block(self, name: str) -> Callee | None:
        """Return the system, controller or plant of that name in the first file that holds one."""
        while name not in self.blocks and self.paths:
            path = self.paths.pop(0)
            self.blocks = {s.name: s for s in self._opened(path)} | self.blocks
        return self.blocks.get(name)

    def system(self, name: str) -> FuzzySystem | None:
        """Return the system of that name in the first file that holds one."""
        found = self.block(name)
        return found if isinstance(found, FuzzySystem) else None

    def _opened(self, path: Path) -> tuple[Callee, ...]:
        """Return the systems of a file, read once however many ways lead to it."""
        key = path.resolve()
        if key not in self.opened:
            self.opened[key] = ()
            found = look_through(read_source(path), folder=path.parent, hints=False, opened=self.opened)
            self.mistakes.extend(d for d in found.reported(found.diagnostics) if d.severity == "error")
            self.opened[key] = (*found.systems, *found.controllers, *found.plants)
        return self.opened[key]


def _examine_part(part: Part, broken: bool, hints: bool) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    system, diagnostics = resolve(part.tree, part.shared, broken)
    if system is not None:
        diagnostics = [*diagnostics, *check_model(system, hints=hints)]
        # What is written once for several systems need not be used by each.
        diagnostics = [d for d in diagnostics if not (d.code in ("FZ208", "FZ216", "FZ219") and part.is_shared(d.span))]
    return (None if any(d.severity == "error" for d in diagnostics) else system), diagnostics


def _same_names(systems: list[FuzzySystem]) -> list[Diagnostic]:
    first: dict[str, FuzzySystem] = {}
    found = []
    for s in systems:
        earlier = first.setdefault(s.name, s)
        if earlier is not s:
            note = (Note(earlier.span, "first declared here"),) if earlier.span is not None else ()
            message = f"system '{s.name}' is declared twice"
            found.append(Diagnostic("FZ201", message, s.span, help="rename one of them", notes=note))
    return found


def in_order(source: SourceText, diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Sort by place, those of used files last, and drop what shared lines give once for each system or variable."""

    def place(d: Diagnostic) -> tuple[bool, str, int]:
        if d.span is None:
            return (False, "", -1)
        return (d.span.source.name != source.name, d.span.source.name, d.span.start)

    unique: dict[object, Diagnostic] = {}
    for d in diagnostics:
        unique.setdefault((d.code, _without_variable(d), place(d)), d)
    return sorted(unique.values(), key=place)


def _without_variable(d: Diagnostic) -> str:
    """Return the message, about a line of terms without its names: several variables may share the line."""
    if d.span is None:
        return d.message
    text = d.span.source.text
    line = text.rfind("\n", 0, d.span.start) + 1
    return _QUOTED.sub("", d.message) if _TERM_LINE.match(text, line) else d.message


def apply_policy(diagnostics: list[Diagnostic], lines: Iterable[sx.Allow]) -> list[Diagnostic]:
    """Drop warnings and hints that the file allows, and turn those that it denies into errors."""
    allowed: set[str] = set()
    denied: set[str] = set()
    found: list[Diagnostic] = []
    for line in lines:
        for word in line.codes:
            if word.text not in CODES:
                near = closest(word.text, CODES)
                help_text = f"did you mean '{near}'?" if near else "'fuzzyctl explain' lists the codes"
                message, fix = f"no diagnostic code '{word.text}'", respelt(word.span, word.text, near, CODES)
                found.append(Diagnostic("FZ213", message, word.span, help=help_text, fix=fix))
            (allowed if line.keyword.text == "allow" else denied).add(word.text)
    return [*found, *enforce(diagnostics, allowed, denied)]


def enforce(diagnostics: Iterable[Diagnostic], allowed: Collection[str], denied: Collection[str]) -> list[Diagnostic]:
    """Drop allowed warnings, and turn denied ones into errors; a code that is both is denied."""
    found = []
    for d in diagnostics:
        if d.severity != "error" and d.code in denied:
            found.append(dataclasses.replace(d, severity="error"))
        elif d.severity == "error" or d.code not in allowed:
            found.append(d)
    return found


def _required(examined: tuple[FuzzySystem | None, list[Diagnostic]]) -> FuzzySystem:
    system, diagnostics = examined
    if system is None:
        raise DiagnosticError([d for d in diagnostics if d.severity == "error"])
    return system
