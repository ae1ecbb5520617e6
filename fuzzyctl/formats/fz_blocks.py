"""Writer of controllers, plants and loops as `.fz` text that reads back as the same ones."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.expr import to_text
from fuzzyctl.formats.fz_strings import bounds_text, guarantee_text, param_text, quoted, require_names
from fuzzyctl.model.block import Param
from fuzzyctl.model.controller import EquationBlock, Function, Signal
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.plant import Plant


def block_lines(block: EquationBlock) -> Iterator[str]:
    """Yield the lines of a block, without those that it calls.

    Raises:
        ValueOutOfBoundsError: For what a rule file cannot hold.
    """
    require_names([block.name, *_names(block)])
    if isinstance(block, Plant) and block.calls:
        raise ArgumentError(f"plant '{block.name}' is functions in Python, which no rule file can hold")
    formula = _formula(block) if isinstance(block, Plant) and block.external else ""
    yield f"{block.kind} {block.name}{quoted(' ', block.title, 'title')}{formula}"
    if block.citation:
        yield f"source{quoted(' ', block.citation, 'citation')}"
    yield from sections(block)


def _formula(plant: Plant) -> str:
    folder, path = Path(plant.path).parent, Path(plant.external)
    relative = (path.relative_to(folder) if path.is_relative_to(folder) else path).as_posix()
    return f" = {'python' if plant.python else 'fmu'}({quoted('', relative, 'file')})"


def _names(block: EquationBlock) -> list[str]:
    named: list[Iterable[Param | Function | Signal]] = [block.params, block.functions]
    named += [block.inputs, block.states, block.outputs]
    named += [block.disturbances] if isinstance(block, Loop) else []
    return [item.name for items in named for item in items] + [d.name for d in block.definitions]


def sections(block: EquationBlock) -> Iterator[str]:
    """Yield the statements of a block in groups, a blank line before each."""
    for lines in _groups(block):
        if lines:
            yield ""
            yield from lines


def _groups(block: EquationBlock) -> Iterator[list[str]]:
    yield [function_text(f) for f in block.functions]
    yield [param_text(p) for p in block.params]
    lets = [f"let {d.name} = {to_text(d.value)}" for d in block.definitions]
    blocks = [f"block {i.name} = {i.controller}({', '.join(map(to_text, i.arguments))})" for i in block.instances]
    if isinstance(block, Loop):
        yield blocks
        yield lets
        yield [f"for {v.name}{bounds_text(v.bounds)}" for v in block.varied]
        yield [signal_text("disturbance", d) for d in block.disturbances]
        yield [
            f"measure {m.name}{quoted(' ', m.label, 'label')}{quoted(' unit ', m.unit, 'unit')} = {to_text(m.value)}"
            for m in block.measures
        ]
        step = "" if block.step is None else f" step {to_text(block.step)}"
        yield [f"run {to_text(block.duration)}{step}"]
        yield [f"require {guarantee_text(g)}" for g in (*block.requirements, *block.guarantees)]
        return
    if isinstance(block, Plant) and block.external:
        return
    yield [signal_text("input", i) for i in block.inputs]
    yield [signal_text("state", s) for s in block.states]
    yield blocks
    yield lets
    keyword = "der" if isinstance(block, Plant) else "next"
    yield [f"{keyword} {d.name} = {to_text(d.value)}" for d in block.changes]
    yield [signal_text("output", r) for r in block.outputs]
    yield [f"every {to_text(block.period)}"] if block.period is not None else []
    yield [f"require {guarantee_text(g)}" for g in block.guarantees]


def function_text(function: Function) -> str:
    """Return a `function` line."""
    return f"function {function.name}({', '.join(function.parameters)}) = {to_text(function.expression)}"


def signal_text(keyword: str, signal: Signal) -> str:
    """Return an `input`, `state`, `output` or `disturbance` line."""
    label, unit = quoted(" ", signal.label, "label"), quoted(" unit ", signal.unit, "unit")
    value = next((getattr(signal, name) for name in ("start", "value", "nominal") if hasattr(signal, name)), None)
    defined = "" if value is None else f" = {to_text(value)}"
    return f"{keyword} {signal.name}{label}{bounds_text(signal.bounds)}{unit}{defined}"
