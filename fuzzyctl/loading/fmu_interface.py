"""Inputs and outputs of plants that are FMUs, read from their descriptions without loading their code."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.expr import Name, Text, walk
from fuzzyctl.lang import syntax as sx
from fuzzyctl.loading.block_files import named_path
from fuzzyctl.model.controller import Result, Signal
from fuzzyctl.model.plant import Plant
from fuzzyctl.simulation.fmu_archive import FmuDescription, FmuError, read_description


def with_fmu(plant: Plant, head: sx.Head, folder: Path | None) -> tuple[Plant, list[Diagnostic]]:
    """Return a plant with the file, inputs and outputs of its FMU; or what is wrong."""
    text = next(e for e in walk(head.formula or Name("")) if isinstance(e, Text))
    span = text.span or head.span
    try:
        path = named_path(text.text, span, folder)
        fmu = read_description(str(path))
    except DiagnosticError as error:
        return plant, list(error.diagnostics)
    except FmuError as error:
        message = f"{span.text} cannot be used: {error.message}"
        return plant, [Diagnostic("FZ218", message, span, facts=error.facts, help=error.help_text)]
    read = dataclasses.replace(
        plant,
        fmu=str(path),
        inputs=tuple(Signal(name=v.identifier, label=v.label, unit=v.unit) for v in fmu.inputs),
        results=tuple(
            Result(name=v.identifier, label=v.label, unit=v.unit, value=Name(v.identifier)) for v in fmu.outputs
        ),
    )
    return read, _unknown_params(plant, fmu)


def _unknown_params(plant: Plant, fmu: FmuDescription) -> list[Diagnostic]:
    """Report params of the plant that the FMU does not have."""
    names = [v.identifier for v in fmu.params]
    facts = (f"its parameters: {listed(names)}" if names else "it has no real parameters",)
    found = []
    for name, span in ((p.name, p.span) for p in plant.params if p.name not in names):
        message = f"the FMU has no parameter '{name}'"
        found.append(Diagnostic("FZ202", message, span, facts=facts, help=did_you_mean(name, names)))
    return found
