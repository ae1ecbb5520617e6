"""Summary of a controller, plant or loop as plain data for `fuzzyctl show`."""

from __future__ import annotations

from typing import Any

from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Expr, to_text
from fuzzyctl.formats.fz_blocks import function_text
from fuzzyctl.formats.fz_strings import bounds_text, guarantee_text
from fuzzyctl.kernels.plan.expansion import equations_of
from fuzzyctl.loading.block_equations import in_order
from fuzzyctl.model.controller import Definition, EquationBlock, Instance, Result, Signal, State
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.plant import Plant


def block_summary(block: EquationBlock) -> dict[str, Any]:
    """Return what `fuzzyctl show --format json` prints of a controller, plant or loop.

    `statements` holds lines by heading; equations are in the order in which they are computed.
    """

    def number(expr: Expr | None) -> float | None:
        return None if expr is None else block.number(expr)

    data: dict[str, Any] = {
        "kind": block.kind,
        "name": block.name,
        "title": block.title,
        "source": block.citation,
        "file": block.path,
        "params": [
            {"name": p.name, "value": block.values[p.name], "expression": to_text(p.expression), "unit": p.unit}
            for p in block.params
        ],
    }
    if block.is_sampled:
        data["period"] = number(block.period)
    if isinstance(block, Loop):
        data |= {"duration": number(block.duration), "step": number(block.step)}
    statements = {"Functions": [function_text(f).removeprefix("function ") for f in block.functions]}
    statements |= _loop(block) if isinstance(block, Loop) else _equations(block)
    return data | {"statements": {heading: lines for heading, lines in statements.items() if lines}}


def _equations(block: Any) -> dict[str, list[str]]:
    states = [_signal(s) for s in block.states]
    prime, heading, external = "next", "Next values", ""
    if isinstance(block, Plant):
        prime, heading, external = "d/dt", "Derivatives", block.external
    elif hidden := len(equations_of(block).states) - len(states):
        states.append(f"and {counted(hidden, 'number')} of operators, systems and blocks")
    return {
        "Inputs": [_signal(i) for i in block.inputs],
        "States": states,
        "Blocks": [_instance(i) for i in block.instances],
        "Equations in order": [f'in "{external}"'] if external else [_defined(d) for d in in_order(block)],
        heading: [] if external else [f"{prime} {_defined(d)}" for d in block.changes],
        "Outputs": [_signal(r) for r in block.outputs],
    }


def _signal(signal: Signal) -> str:
    """Return an input, state or output as a file writes it; texts may hold what no file can."""
    label, unit = (f' {word}"{text}"' if text else "" for word, text in (("", signal.label), ("unit ", signal.unit)))
    start = f" = {to_text(signal.start)}" if isinstance(signal, State) else ""
    return f"{signal.name}{label}{bounds_text(signal.bounds)}{unit}{start}"


def _loop(loop: Loop) -> dict[str, list[str]]:
    return {
        "Blocks": [_instance(i) for i in loop.instances],
        "Signals": [_defined(d) for d in loop.definitions],
        "Measures": [f"{_defined(m)}{f' [{m.unit}]' if m.unit else ''}" for m in loop.measures],
        "Requirements, checked on a run": [guarantee_text(g) for g in loop.requirements],
    }


def _defined(d: Definition | Result) -> str:
    return f"{d.name} = {to_text(d.value)}"


def _instance(instance: Instance) -> str:
    return f"{instance.name} = {instance.controller}({', '.join(map(to_text, instance.arguments))})"
