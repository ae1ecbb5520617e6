"""Loader of fuzzy systems: read → parse → assemble → resolve → check."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.choice import choose, chosen_block, chosen_name
from fuzzyctl.loading.examination import Examined, look_through
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.support import arguments
from fuzzyctl.support.reading import MAX_BYTES, decode, read_source
from fuzzyctl.support.shipped import place_of

if TYPE_CHECKING:
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.loop import Loop
    from fuzzyctl.model.plant import Plant


_Block = TypeVar("_Block", "FuzzySystem", "Controller", "Plant", "Loop", "FuzzySystem | Controller")

__all__ = [
    "MAX_BYTES",
    "Examined",
    "chosen_block",
    "decode",
    "examine",
    "examine_all",
    "load",
    "load_all",
    "load_controller",
    "load_loop",
    "load_plant",
    "loads",
    "look_through",
    "read_source",
]


def load(path: str | os.PathLike[str], *, system: str | None = None, max_bytes: int = MAX_BYTES) -> FuzzySystem:
    """Read a fuzzy system from a rule file, or from a file of another tool.

    The structure of the file is checked. Gaps between the rules, guarantees and warnings are not: `fuzzyctl.check`
    reports them.

    Args:
        path: The file; its suffix gives the format: `.fll`, `.fis`, `.fcl`, `.fml` and `.xml` are files of other tools,
            every other suffix is a rule file, usually `.fz`. A name without folder and suffix, such as `tipper`, is
            NAME.fz in the current folder, else the shipped file of this name.
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
    return _required(examine(source, folder=place_of(path).path.parent, system=system, hints=False))


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
    systems, diagnostics = examine_all(source, folder=place_of(path).path.parent, hints=False)
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
        path: The file, as for `load`.
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
        path: The file, as for `load`.
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
        path: The file, as for `load`.
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
    found = look_through(source, folder=place_of(path).path.parent, hints=False)
    errors = [d for d in found.reported(found.diagnostics) if d.severity == "error"]
    if errors:
        raise DiagnosticError(errors)
    return found


def _one_of(found: Examined, blocks: Sequence[_Block], kind: str, name: str | None) -> _Block:
    chosen = chosen_block(found.source, blocks, kind, name)
    if isinstance(chosen, Diagnostic):
        raise DiagnosticError([chosen])
    return chosen


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


def examine_all(
    source: SourceText, *, folder: Path | None = None, hints: bool = True
) -> tuple[tuple[FuzzySystem, ...], list[Diagnostic]]:
    """Do the same for all systems of a source; those with errors are left out.

    The suffix of the source's name says the format; whatever is no format of another tool is a rule file.
    """
    found = look_through(source, folder=folder, hints=hints)
    return found.systems, found.reported(found.diagnostics)


def _required(examined: tuple[FuzzySystem | None, list[Diagnostic]]) -> FuzzySystem:
    system, diagnostics = examined
    if system is None:
        raise DiagnosticError([d for d in diagnostics if d.severity == "error"])
    return system
