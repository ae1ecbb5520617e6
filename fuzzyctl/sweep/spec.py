"""What a SPEC of loops says."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field, Strict

from fuzzyctl.experiments.sweep import spec_file
from fuzzyctl.experiments.sweep.spec import Spec
from fuzzyctl.experiments.sweep.spec_file import SpecFile


class LoopSpec(Spec):
    """What a SPEC file says: `scenario` is a rule file with loops, `controllers` names some of them."""

    against: Annotated[tuple[str, ...], Strict(False)] = Field(
        default=(), description="further files beside the SPEC, whose loops are run too"
    )


def read(path: Path) -> SpecFile:
    """Read a SPEC file.

    Raises:
        DiagnosticError: With every mistake in it.
    """
    return spec_file.read(path, LoopSpec)


def against(file: SpecFile) -> tuple[Path, ...]:
    """Return the further files of a SPEC."""
    spec = file.spec
    return tuple(file.path.parent / name for name in spec.against) if isinstance(spec, LoopSpec) else ()
