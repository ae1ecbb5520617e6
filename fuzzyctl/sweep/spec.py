"""What a SPEC of loops says."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field, Strict

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.experiments import sweep_spec
from fuzzyctl.experiments.sweep_spec import Spec, SpecFile
from fuzzyctl.support.reading import files_in
from fuzzyctl.support.shipped import place_of


class LoopSpec(Spec):
    """What a SPEC file says: `scenario` is a file with loops or a shipped name, `controllers` names some of them."""

    against: Annotated[tuple[str, ...], Strict(False)] = Field(
        default=(), description="further files beside the SPEC, or shipped ones, whose loops are run too"
    )


def read(path: Path) -> SpecFile:
    """Read a SPEC file.

    Raises:
        DiagnosticError: With every mistake in it.
    """
    return sweep_spec.read(path, LoopSpec)


def against(file: SpecFile) -> tuple[Path, ...]:
    """Return the further files of a SPEC.

    Raises:
        DiagnosticError: With each that is not there.
    """
    names = file.spec.against if isinstance(file.spec, LoopSpec) else ()
    mistakes = []
    beside = [file.path.parent / name for name in names]
    paths = [place_of(name, folder=file.path.parent).path for name in names]
    for path, there in zip(beside, paths, strict=True):
        if not there.exists():
            near = closest(path.name, files_in(path.parent, {path.suffix}))
            help_text = f"did you mean '{near}'?" if near else ""
            message = f"against: no file '{path.name}': there is no such file"
            mistakes.append(file.diagnostic("FZ904", ("against",), message, help=help_text))
    if mistakes:
        raise DiagnosticError(mistakes)
    return tuple(paths)
