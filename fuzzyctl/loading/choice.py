"""The one block of a file that is meant, and what is reported if there is none."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, TypeVar

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.model.block import Block
from fuzzyctl.support import arguments

if TYPE_CHECKING:
    from fuzzyctl.loading.examination import Examined

AnyBlock = TypeVar("AnyBlock", bound=Block)

#: What a block may be.
KINDS: Final = ("system", "controller", "plant", "loop", "block")
#: Repairs of a file without a block of a kind.
_HELP: Final = {
    "system": "give a file with a 'system' block; 'fuzzyctl show' prints controllers, plants and loops",
    "loop": "a 'loop' joins controllers and plants, as in 'fuzzyctl show water_tank'",
}
#: What works for a block that a command does not take.
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
    known = dict.fromkeys(b.name for b in (meant or [b for b in examined.blocks if isinstance(b, tuple(kinds))]))
    facts, help_text = [f"{plural}: {', '.join(known)}"] if known else [], ""
    if meant:
        word = meant[0].kind if len({b.kind for b in meant}) == 1 else "block"
        message = f"the file holds several {word}s, and none is chosen"
        facts = [f"{word}s: {', '.join(known)}"]
        for kind in (k for k in words if k != word and name is None):
            others = [b.name for b in examined.blocks if b.kind == kind]
            facts += [f"{kind}s: {', '.join(others)}"] if others else []
        help_text = f"name one: --block {meant[0].name}, in Python block={meant[0].name!r}"
    elif known:
        message, near = f"the file holds no {word} '{name}'", closest(str(name), known)
        help_text = f"did you mean '{near}'?" if near else ""
    else:
        message = f"the file holds no {word}"
        held = ", ".join(f"{b.kind} '{b.name}'" for b in examined.blocks)
        facts = [f"it holds: {held}"] if held else []
        help_text = _HELP.get(words[0], "")
    other = next((b for b in examined.blocks if b.name == name), None)
    if other is not None and known:
        facts.append(f"'{name}' is a {other.kind}{': a loop runs it' if word == 'loop' else ''}")
        help_text = help_text or ("" if word == "loop" else _INSTEAD.get(other.kind, ""))
    return Diagnostic("FZ502", message, facts=tuple(facts), help=help_text, file=examined.source.name)


def _either(words: Sequence[str]) -> str:
    return " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
