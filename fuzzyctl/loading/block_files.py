"""Plants in Python and FMUs, whose interfaces are read without running them, and CSV signals."""

from __future__ import annotations

import ast
import csv
import dataclasses
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.fixes import respelt_as_suggested
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import closest, did_you_mean, listed
from fuzzyctl.expr import Call, Name, Number, Text, walk
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.controller import Result, Signal, State
from fuzzyctl.model.forms import bound
from fuzzyctl.model.loop import SIGNALS, Loop
from fuzzyctl.model.plant import Plant
from fuzzyctl.support.files import files_in, is_below, read_source, record_file

if TYPE_CHECKING:
    from fuzzyctl.simulation.fmu_archive import FmuDescription

#: The assignments of a plant in Python, the form of each and an example.
_INTERFACE: Final = {
    "inputs": ("a tuple of names", 'inputs = ("u",)'),
    "states": ("a dictionary from names to numbers", 'states = {"x": 0.0}'),
    "outputs": ("a tuple of names", 'outputs = ("y",)'),
}

_Report = Callable[[str, tuple[str, ...], str], Diagnostic]


def with_interface(plant: Plant, head: sx.Head, folder: Path | None) -> tuple[Plant, list[Diagnostic]]:
    """Return a plant in Python with its file and the inputs, states and outputs that this assigns; or a diagnostic."""
    text = next(e for e in walk(head.formula or Name("")) if isinstance(e, Text))
    span = text.span or head.span

    def report(message: str, facts: tuple[str, ...], help_text: str) -> Diagnostic:
        return Diagnostic("FZ218", message, span, facts=facts, help=help_text)

    try:
        path, source = named_file(text.text, span, folder)
        interface = _assigned(source, report)
    except DiagnosticError as error:
        return plant, list(error.diagnostics)
    read = dataclasses.replace(
        plant,
        python=str(path),
        inputs=tuple(Signal(name=n) for n in interface["inputs"]),
        states=tuple(State(name=n, start=Number(float(v))) for n, v in interface["states"].items()),
        results=tuple(Result(name=n, value=Name(n)) for n in interface["outputs"]),
    )
    return read, []


def named_path(name: str, span: Span, folder: Path | None) -> Path:
    """Return the path of a file below a folder.

    Raises:
        DiagnosticError: For a file elsewhere, with the place that names it.
    """
    why, help_text = "", ""
    path = Path(name) if folder is None else folder / name
    if folder is None:
        why, help_text = "a text without a file cannot use files", "write it to a file and load that"
    elif Path(name).is_absolute() or not is_below(path, folder):
        why, help_text = f"'{name}' lies outside the folder of this file", "move it there or below"
    if why:
        raise DiagnosticError([Diagnostic("FZ218", why, span, help=help_text)])
    return path


def named_file(name: str, span: Span, folder: Path | None) -> tuple[Path, SourceText]:
    """Return the path and the text of a file below a folder.

    Raises:
        DiagnosticError: For a file elsewhere, or one that cannot be read, with the place that names it.
    """
    path = named_path(name, span, folder)
    try:
        return path, read_source(path, only_regular=True)
    except DiagnosticError as error:
        (first,) = error.diagnostics
        near = closest(path.name, files_in(path.parent, {path.suffix.lower()} - {""}))
        help_text = f"did you mean '{Path(name).with_name(near)}'?" if near and first.code == "FZ001" else first.help
        message = f"{span.text} cannot be used: {first.message}"
        raise DiagnosticError([Diagnostic("FZ218", message, span, facts=first.facts, help=help_text)]) from None


def _assigned(source: SourceText, report: _Report) -> dict[str, dict[str, float]]:
    """Return the literal values of the interface, names without a value with 0.

    Raises:
        DiagnosticError: With all mistakes in it.
    """
    try:
        tree = ast.parse(source.text)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        line = getattr(error, "lineno", None)
        facts = (f"{source.name}{f':{line}' if line else ''}: {getattr(error, 'msg', error)}",)
        raise DiagnosticError(
            [report("the file is not Python", facts, "fix it, and run it with python once")]
        ) from None
    nodes = {name: node for target in tree.body for name, node in _assignment(target)}
    results: dict[str, dict[str, float]] = {name: {} for name in _INTERFACE}
    mistakes: list[Diagnostic] = []
    for name, (form, example) in _INTERFACE.items():
        node = nodes.get(name)
        at = f"{source.name}:{node.lineno}: " if node is not None else ""
        values = _literal(node)
        if values is None:
            message = f"the file assigns no '{name}'" if node is None else f"'{name}' is not written out as {form}"
            facts = (f"{at}names and starts are read without running the file, so they are written out",)
            mistakes.append(report(message, facts, f"write in it: {example}"))
        for n, value in values or ():
            first = next((of for of, names in results.items() if n in names), None)
            if not n.isidentifier() or n in sx.RESERVED:
                facts = (f"{at}a name has letters, digits and underscores, and is not a keyword",)
                mistakes.append(report(f"'{n}' of '{name}' is not a name", facts, "rename it"))
            elif first is not None:
                help_text = "inputs, states and outputs share one set of names; rename one of them"
                mistakes.append(report(f"'{n}' of '{name}' is declared twice", (f"{at}first in '{first}'",), help_text))
            else:
                results[name][n] = value
    if mistakes:
        raise DiagnosticError(mistakes)
    return results


def _assignment(node: ast.stmt) -> list[tuple[str, ast.expr]]:
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    value = getattr(node, "value", None)
    return [(t.id, value) for t in targets if isinstance(t, ast.Name) and value is not None]


def _literal(node: ast.expr | None) -> list[tuple[str, float]] | None:
    """Return the names of a tuple or list of texts, or of a dictionary with numbers; None for anything else."""
    try:
        value = ast.literal_eval(node) if node is not None else None
    except (ValueError, TypeError, SyntaxError, MemoryError, RecursionError):
        return None
    if isinstance(value, dict):
        pairs = list(value.items())
    else:
        pairs = [(n, 0.0) for n in value] if isinstance(value, tuple | list) else [(None, 0.0)]
    return pairs if all(isinstance(n, str) and _is_number(v) for n, v in pairs) else None


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < float("inf")


def check_csv(loop: Loop, folder: Path | None) -> list[Diagnostic]:
    """Check that the files of `csv` signals can be read and have the columns that are named."""
    results = []
    values = [d.value for d in loop.definitions] + [a for i in loop.instances for a in i.arguments]
    for call in (e for value in values for e in walk(value)):
        if isinstance(call, Call) and call.function == "csv":
            results.extend(_check_columns(call, folder))
    return results


def _check_columns(call: Call, folder: Path | None) -> list[Diagnostic]:
    texts = {n: e for n, e in bound(SIGNALS["csv"], call).items() if isinstance(e, Text)}
    try:
        file = texts["file"]
        assert file.span is not None
        _, source = named_file(file.text, file.span, folder)
    except DiagnosticError as error:
        return list(error.diagnostics)
    header = [name.strip() for name in next(csv.reader(source.text.splitlines()), [])]
    columns = []
    for setting in ("column", "time"):
        name = texts[setting].text
        if name and name not in header:
            message = f"'{file.text}' has no column '{name}'"
            facts = (f"columns: {listed(header)}",) if header else ("the file is empty",)
            help_text = did_you_mean(name, header)
            columns.append(Diagnostic("FZ202", message, texts[setting].span, facts=facts, help=help_text))
    return columns


def with_fmu(plant: Plant, head: sx.Head, folder: Path | None) -> tuple[Plant, list[Diagnostic]]:
    """Return a plant with the file, inputs and outputs of its FMU; or a diagnostic."""
    from fuzzyctl.simulation.fmu_archive import FmuError, read_description  # archives and XML, for FMUs only

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
    result = _unknown_params(plant, fmu)
    if missing := fmu.missing_binary():
        result.append(Diagnostic("FZ712", missing.message, span, "warning", missing.facts, missing.help_text))
    return _with_signals(plant, fmu), result


def fmu_plant(path: str | os.PathLike[str], name: str = "plant") -> Plant:
    """Return the plant that an FMU is, as `plant NAME = fmu("FILE")` takes it from a rule file.

    Its code is not loaded before a loop with it is run.

    Args:
        path: The FMU, of FMI 2.0 or 3.0, for co-simulation.
        name: The name of the plant.

    Raises:
        DiagnosticError: For a file that is no such FMU.
    """
    from fuzzyctl.simulation.fmu_archive import FmuError, read_description

    try:
        fmu = read_description(os.fspath(path))
    except FmuError as error:
        diagnostic = Diagnostic("FZ218", error.message, facts=error.facts, help=error.help_text, file=os.fspath(path))
        raise DiagnosticError([diagnostic]) from None
    return _with_signals(Plant(name=name), fmu)


def _with_signals(plant: Plant, fmu: FmuDescription) -> Plant:
    outputs = [Result(name=v.identifier, label=v.label, unit=v.unit, value=Name(v.identifier)) for v in fmu.outputs]
    inputs = [Signal(name=v.identifier, label=v.label, unit=v.unit) for v in fmu.inputs]
    return dataclasses.replace(plant, fmu=fmu.path, inputs=tuple(inputs), results=tuple(outputs))


def _unknown_params(plant: Plant, fmu: FmuDescription) -> list[Diagnostic]:
    """Report params of the plant that the FMU does not have."""
    names = [v.identifier for v in fmu.params]
    facts = (f"its parameters: {listed(names)}" if names else "it has no real parameters",)
    unknown_params = []
    for name, span in ((p.name, p.span) for p in plant.params if p.name not in names):
        message = f"the FMU has no parameter '{name}'"
        help_text, fix = did_you_mean(name, names), respelt_as_suggested(span, name, names)
        unknown_params.append(Diagnostic("FZ202", message, span, facts=facts, help=help_text, fix=fix))
    return unknown_params
