"""Inputs and outputs of plants that are FMUs, read from their descriptions without loading their code."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.fixes import respelt_as_suggested
from fuzzyctl.diagnostics.suggestions import closest, did_you_mean, listed
from fuzzyctl.expr import Name, Text, walk
from fuzzyctl.lang import syntax as sx
from fuzzyctl.loading.block_files import named_path
from fuzzyctl.model.controller import Result, Signal
from fuzzyctl.model.plant import Plant
from fuzzyctl.simulation.fmu_archive import FmuDescription, FmuError, read_description
from fuzzyctl.support.reading import files_in, record_file


def with_fmu(plant: Plant, head: sx.Head, folder: Path | None) -> tuple[Plant, list[Diagnostic]]:
    """Return a plant with the file, inputs and outputs of its FMU; or what is wrong."""
    text = next(e for e in walk(head.formula or Name("")) if isinstance(e, Text))
    span = text.span or head.span
    try:
        path = named_path(text.text, span, folder)
        fmu = read_description(str(path))
        record_file(path)
    except DiagnosticError as error:
        return plant, list(error.diagnostics)
    except FmuError as error:
        message = f"{span.text} cannot be used: {error.message}"
        near = None if os.path.exists(path) else closest(path.name, files_in(path.parent, {".fmu"}))
        help_text = f"did you mean '{Path(text.text).with_name(near)}'?" if near else error.help_text
        return plant, [Diagnostic("FZ218", message, span, facts=error.facts, help=help_text)]
    found = _unknown_params(plant, fmu)
    if missing := fmu.missing_binary():
        found.append(Diagnostic("FZ712", missing.message, span, "warning", missing.facts, missing.help_text))
    return _with_signals(plant, fmu), found


def fmu_plant(path: str | os.PathLike[str], name: str = "plant") -> Plant:
    """Return the plant that an FMU is, as `plant NAME = fmu("FILE")` takes it from a rule file.

    Its code is not loaded before a loop with it is run.

    Args:
        path: The FMU, of FMI 2.0 or 3.0, for co-simulation.
        name: What the plant is called.

    Raises:
        DiagnosticError: For a file that is no such FMU.
    """
    try:
        fmu = read_description(os.fspath(path))
    except FmuError as error:
        found = Diagnostic("FZ218", error.message, facts=error.facts, help=error.help_text, file=os.fspath(path))
        raise DiagnosticError([found]) from None
    return _with_signals(Plant(name=name), fmu)


def _with_signals(plant: Plant, fmu: FmuDescription) -> Plant:
    outputs = [Result(name=v.identifier, label=v.label, unit=v.unit, value=Name(v.identifier)) for v in fmu.outputs]
    inputs = [Signal(name=v.identifier, label=v.label, unit=v.unit) for v in fmu.inputs]
    return dataclasses.replace(plant, fmu=fmu.path, inputs=tuple(inputs), results=tuple(outputs))


def _unknown_params(plant: Plant, fmu: FmuDescription) -> list[Diagnostic]:
    """Report params of the plant that the FMU does not have."""
    names = [v.identifier for v in fmu.params]
    facts = (f"its parameters: {listed(names)}" if names else "it has no real parameters",)
    found = []
    for name, span in ((p.name, p.span) for p in plant.params if p.name not in names):
        message = f"the FMU has no parameter '{name}'"
        help_text, fix = did_you_mean(name, names), respelt_as_suggested(span, name, names)
        found.append(Diagnostic("FZ202", message, span, facts=facts, help=help_text, fix=fix))
    return found
