"""Loader of blocks: read → parse → assemble → resolve → check."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar, overload

from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.loading.examination import Examined, look_through
from fuzzyctl.model.block import Block
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.support import arguments
from fuzzyctl.support.files import MAX_BYTES, decode, place_of, read_source

if TYPE_CHECKING:
    from fuzzyctl.loading.examination import Examined

AnyBlock = TypeVar("AnyBlock", bound=Block)

#: The kinds of blocks.
KINDS: Final = ("system", "controller", "plant", "loop", "block")
#: Repairs of a file without a block of a kind.
_HELP: Final = {
    "system": "give a file with a 'system' block; 'fuzzyctl show' prints controllers, plants and loops",
    "loop": "a 'loop' joins controllers and plants, as in 'fuzzyctl show water_tank'",
}
#: Commands that take the blocks which another command does not.
_INSTEAD: Final = {
    "plant": "'fuzzyctl show' prints a plant, 'simulate' runs a loop with it, 'codegen --step' writes its steps",
    "loop": "'fuzzyctl simulate' runs a loop, 'page' shows its run",
}


def block_name(name: object) -> str | None:
    """Return the name of a block, or None if none is chosen.

    Raises:
        ArgumentError: For an argument of another type.
    """
    return None if name is None else arguments.instance("'block'", str, "the name of a block, or None", name)


def chosen(examined: Examined, name: str | None, *kinds: type[AnyBlock]) -> AnyBlock:
    """Return the block of a name, or without one the only block of the first kind that the file holds.

    Args:
        examined: The file.
        name: Name of the block; None for the only one.
        kinds: The kinds that are meant, the first one preferred; `Block` is any.

    Raises:
        DiagnosticError: For a file without such blocks, for several without a name, and for an unknown name.
    """
    by_kind = [examined.of(kind) for kind in kinds]
    meant = next(filter(None, by_kind), ())
    if name is not None:
        meant = tuple({b.name: b for some in by_kind for b in some if b.name == name}.values())
    if len(meant) == 1:
        return meant[0]
    raise DiagnosticError([_not_chosen(examined, name, kinds, meant)])


def chosen_if_sound(
    examined: Examined, diagnostics: list[Diagnostic], name: str | None, *kinds: type[AnyBlock]
) -> tuple[AnyBlock | None, list[Diagnostic]]:
    """Return the block that is meant with the diagnostics; None after errors other than claims that do not hold."""
    if any(d.stops for d in diagnostics):
        return None, diagnostics
    try:
        return chosen(examined, name, *kinds), diagnostics
    except DiagnosticError as error:
        return None, [*diagnostics, *error.diagnostics]


def _not_chosen(
    examined: Examined, name: str | None, kinds: Sequence[type[Block]], meant: Sequence[Block]
) -> Diagnostic:
    """Return why none of the blocks of a file is chosen."""
    words = sorted((getattr(kind, "kind", "block") for kind in kinds), key=KINDS.index)
    word, plural = ("block", "blocks") if "block" in words else (_either(words), _either([f"{w}s" for w in words]))
    names = dict.fromkeys(b.name for b in (meant or [b for b in examined.blocks if isinstance(b, tuple(kinds))]))
    facts, help_text = [f"{plural}: {', '.join(names)}"] if names else [], ""
    if meant:
        word = meant[0].kind if len({b.kind for b in meant}) == 1 else "block"
        message = f"the file holds several {word}s, and none is chosen"
        facts = [f"{word}s: {', '.join(names)}"]
        for kind in (k for k in words if k != word and name is None):
            others = [b.name for b in examined.blocks if b.kind == kind]
            facts += [f"{kind}s: {', '.join(others)}"] if others else []
        help_text = f"name one: --block {meant[0].name}, in Python block={meant[0].name!r}"
    elif names:
        message, near = f"the file holds no {word} '{name}'", closest(str(name), names)
        help_text = f"did you mean '{near}'?" if near else ""
    else:
        message = f"the file holds no {word}"
        listing = ", ".join(f"{b.kind} '{b.name}'" for b in examined.blocks)
        facts = [f"it holds: {listing}"] if listing else []
        help_text = _HELP.get(words[0], "")
    other = next((b for b in examined.blocks if b.name == name), None)
    if other is not None and names:
        facts.append(f"'{name}' is a {other.kind}{': a loop runs it' if word == 'loop' else ''}")
        help_text = help_text or ("" if word == "loop" else _INSTEAD.get(other.kind, ""))
    return Diagnostic("FZ502", message, facts=tuple(facts), help=help_text, file=examined.source.name)


def _either(words: Sequence[str]) -> str:
    return " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


_Block = TypeVar("_Block", bound=Block)

__all__ = [
    "MAX_BYTES",
    "Examined",
    "decode",
    "examine",
    "examine_all",
    "load",
    "load_all",
    "loads",
    "look_through",
    "opened",
    "read_source",
]


@overload
def load(path: str | os.PathLike[str], *, block: type[_Block], max_bytes: int = MAX_BYTES) -> _Block: ...
@overload
def load(path: str | os.PathLike[str], *, block: str, max_bytes: int = MAX_BYTES) -> Any: ...
@overload
def load(path: str | os.PathLike[str], *, block: None = None, max_bytes: int = MAX_BYTES) -> FuzzySystem: ...
def load(path: str | os.PathLike[str], *, block: str | type[Block] | None = None, max_bytes: int = MAX_BYTES) -> Block:
    """Read a block from a rule file, or from a file of another tool.

    The structure of the file is checked. Gaps between the rules, guarantees and warnings are not: `fuzzyctl.check`
    reports them.

    Args:
        path: The file; its suffix gives the format: `.fll`, `.fis`, `.fcl`, `.fml` and `.xml` are files of other tools,
            every other suffix is a rule file, usually `.fz`. A name without folder and suffix, such as `tipper`, is
            NAME.fz in the current folder, else the shipped file of this name.
        block: Name of the system, controller, plant or loop, or a class, such as `fuzzyctl.Loop`, for the only block of
            that kind. None for the only system, or the only block of a file without systems.
        max_bytes: Largest size that is read [bytes].

    Returns:
        The block.

    Raises:
        DiagnosticError: With all errors of the file, each with line, column and help; for a file that cannot be read;
            for several blocks without a chosen name, and for a name that the file does not hold.
        ArgumentError: For an argument of another type.
        ValueOutOfBoundsError: For `max_bytes` out of its bounds.
    """
    return _chosen(opened(path, max_bytes), block)


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
    return opened(path, max_bytes).systems


@overload
def loads(text: str, name: str = "<text>", *, block: type[_Block]) -> _Block: ...
@overload
def loads(text: str, name: str = "<text>", *, block: str) -> Any: ...
@overload
def loads(text: str, name: str = "<text>", *, block: None = None) -> FuzzySystem: ...
def loads(text: str, name: str = "<text>", *, block: str | type[Block] | None = None) -> Block:
    """Read a block from a text.

    Args:
        text: The text of a rule file; it can use no other files.
        name: Shown in diagnostics; its suffix gives the format, as for `load`.
        block: The block, as for `load`.

    Raises:
        DiagnosticError: With all errors of the text; for characters that no text file can hold.
        ArgumentError: For an argument of another type.
    """
    if not isinstance(text, str):
        raise ArgumentError(f"expected the text of a rule file, got {type(text).__name__}; 'load' takes paths")
    source = SourceText(arguments.text("'name'", name), text)
    _require_characters(source)
    return _chosen(_sound(look_through(source, hints=False)), block)


def opened(path: str | os.PathLike[str], max_bytes: int = MAX_BYTES) -> Examined:
    """Read a file without errors.

    Raises:
        DiagnosticError: With all errors of the file.
        ArgumentError: For an argument of another type.
        ValueOutOfBoundsError: For `max_bytes` out of its bounds.
    """
    path = arguments.path(path, "; 'loads' takes texts")
    source = read_source(path, max_bytes=arguments.bytes_allowed(max_bytes))
    return _sound(look_through(source, folder=place_of(path).path.parent, hints=False))


def _sound(examined: Examined) -> Examined:
    errors = [d for d in examined.reported(examined.diagnostics) if d.severity == "error"]
    if errors:
        raise DiagnosticError(errors)
    return examined


def _chosen(examined: Examined, block: object) -> Block:
    if isinstance(block, type) and issubclass(block, Block):
        return chosen(examined, None, block)
    return chosen(examined, block_name(block), FuzzySystem, Block)


def _require_characters(source: SourceText) -> None:
    """Refuse characters that no text file can hold, so that each text that is read can be written.

    Raises:
        DiagnosticError: For NUL and for halves of surrogate pairs.
    """
    at = arguments.no_character(source.text)
    if at is not None:  # shown by its number only, since half a pair cannot be printed
        message = f"the text cannot be that of a file: U+{ord(source.text[at]):04X} in line {source.line_of(at)}"
        raise DiagnosticError([Diagnostic("FZ002", message, file=source.name, help="remove it")])


def examine(
    source: SourceText, *, folder: Path | None = None, hints: bool = True
) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Parse, assemble, resolve and check a source that holds one system.

    Args:
        source: The text.
        folder: The folder of the files that it uses; None for a text that may not use any.
        hints: Whether to look for warnings; without it a file is read faster.

    Returns:
        The system, None when there are errors, and all diagnostics, warnings included, in the order of their places.
    """
    result = look_through(source, folder=folder, hints=hints)
    return chosen_if_sound(result, result.reported(result.diagnostics), None, FuzzySystem)


def examine_all(
    source: SourceText, *, folder: Path | None = None, hints: bool = True
) -> tuple[tuple[FuzzySystem, ...], list[Diagnostic]]:
    """Do the same for all systems of a source; those with errors are left out.

    The suffix of the source's name says the format; all other suffixes mean a rule file.
    """
    result = look_through(source, folder=folder, hints=hints)
    return result.systems, result.reported(result.diagnostics)
