"""Loops of files for the commands: opened, chosen by name, with params set."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from fuzzyctl.cli.common import assignments, show
from fuzzyctl.cli.loading import blamed, examined_file
from fuzzyctl.diagnostics.diagnostic import DiagnosticError

if TYPE_CHECKING:
    from fuzzyctl.model.loop import Loop


def chosen_loops(file: str, name: str | None) -> list[tuple[str, Loop]]:
    """Open the loops of a file, or the one named, each with the name of the file; warnings are printed.

    Raises:
        DiagnosticError: With all errors of the file, but those of other loops than the one named; for a file without
            loops, and a name of none.
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
    known = list(dict.fromkeys(n for own in (*names, *(loop.instance_params for loop in loops)) for n in own))
    values = assignments(texts, known, "param")
    changed = []
    for loop, own in zip(loops, names, strict=True):
        try:
            changed.append(with_settings(loop, {n: v for n, v in values.items() if n in own}))
        except DiagnosticError as error:
            raise blamed(error, texts) from None
    return changed
