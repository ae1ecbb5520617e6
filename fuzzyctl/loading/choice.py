"""The one system, controller, plant or loop of a file that is meant, and what is reported where there is none."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeVar

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.support import arguments

if TYPE_CHECKING:
    from fuzzyctl.loading.examination import Examined
    from fuzzyctl.model.block import Block
    from fuzzyctl.model.controller import Controller
    from fuzzyctl.model.loop import Loop
    from fuzzyctl.model.plant import Plant

_Block = TypeVar("_Block", "FuzzySystem", "Controller", "Plant", "Loop", "FuzzySystem | Controller")


def chosen_name(name: object, kind: str = "system") -> str | None:
    """Return the name of the system, controller, plant or loop that is chosen among several.

    Raises:
        ArgumentError: For what is no name.
    """
    return None if name is None else arguments.instance(f"'{kind}'", str, f"the name of a {kind}, or None", name)


def choose(
    source: SourceText,
    systems: Sequence[FuzzySystem],
    diagnostics: list[Diagnostic],
    system: str | None,
    blocks: Sequence[Block] = (),
) -> tuple[FuzzySystem | None, list[Diagnostic]]:
    """Pick the one system of a file, or the one named.

    It is None if there are errors other than claims that do not hold. Of a file without systems the blocks are named.
    """
    if any(d.stops for d in diagnostics):
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
    held = ", ".join(f"{b.kind} '{b.name}'" for b in blocks)
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
        message = f"the file holds no {kind}"
        help_text = "a 'loop' joins controllers and plants, as in 'fuzzyctl show water_tank'" if kind == "loop" else ""
    elif name is None:
        message, help_text = f"the file holds several {kind}s, and none is chosen", f"name one, such as '{names[0]}'"
    else:
        near = closest(name, names)
        message, help_text = f"the file holds no {kind} '{name}'", f"did you mean '{near}'?" if near else ""
    facts = (f"{kind.replace(' or', 's or')}s: {', '.join(names)}",) if names else ()
    return Diagnostic("FZ502", message, facts=facts, help=help_text, file=source.name)
