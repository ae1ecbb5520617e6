"""Params of a loop and of its blocks, and loops with other values of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, UnknownNameError
from fuzzyctl.expr import Expr, Keyword, Number, evaluate, names_in
from fuzzyctl.model.controller import Controller, Instance
from fuzzyctl.model.guarantee import Param
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.params import ParamValues
from fuzzyctl.model.plant import Plant
from fuzzyctl.model.shared_params import with_shared


def blocks_of(loop: Loop) -> dict[str, Controller | Plant]:
    """Return the controllers and plants that blocks of a loop are of, by name."""
    found: dict[str, Controller | Plant] = {c.name: c for c in loop.controllers}
    return found | {p.name: p for p in loop.plants}


def block_params(loop: Loop, instance: Instance) -> dict[str, float]:
    """Return the values of the params of a block of a loop."""
    params = blocks_of(loop)[instance.controller].params
    given = {a.name: a.value for a in instance.arguments if isinstance(a, Keyword)}
    numbers = {p.name: Number(evaluate(given[p.name], loop.param_values.values)) for p in params if p.name in given}
    return ParamValues([replace(p, expression=numbers.get(p.name, p.expression)) for p in params]).values


def params_of(loop: Loop) -> dict[str, float]:
    """Return the values of all params: `PARAM` of the loop, `BLOCK.PARAM` of its controllers and plants."""
    found = dict(loop.param_values.values)
    for instance in loop.instances:
        found |= {f"{instance.name}.{name}": value for name, value in block_params(loop, instance).items()}
    return found


def timing_params(loop: Loop) -> set[str]:
    """Return the full names of the params that the duration, the step and the periods of controllers depend on."""
    needed = _depends(loop.params, [e for e in (loop.duration, loop.step) if e is not None])
    found: set[str] = set()
    for instance in loop.instances:
        block = blocks_of(loop)[instance.controller]
        if not isinstance(block, Controller) or block.period is None:
            continue
        given = {a.name: a.value for a in instance.arguments if isinstance(a, Keyword)}
        own = _depends([p for p in block.params if p.name not in given], [block.period])
        found |= {f"{instance.name}.{name}" for name in own}
        needed |= _depends(loop.params, [given[name] for name in own if name in given])
    return found | needed


def _depends(params: Sequence[Param], values: Sequence[Expr]) -> set[str]:
    """Return the names that expressions use, themselves or through params."""
    expressions = {p.name: p.expression for p in params}
    found: set[str] = set()
    stack = list(values)
    while stack:
        new = {n.name for n in names_in(stack.pop())} - found
        found |= new
        stack += [expressions[name] for name in new if name in expressions]
    return found


def short_names(loop: Loop) -> dict[str, str]:
    """Return the full names of all params by the names that they may be given by.

    `BLOCK.PARAM` is also `PARAM` where the loop and its other blocks have none of that name.
    """
    full = list(params_of(loop))
    last = [name.rpartition(".")[2] for name in full]
    return {name: name for name in full} | {n: f for n, f in zip(last, full, strict=True) if last.count(n) == 1}


def with_settings(loop: Loop, values: Mapping[str, float]) -> Loop:
    """Return a loop with some params set to numbers.

    Raises:
        UnknownNameError: For a name of no param, or of several.
        DiagnosticError: For values outside of the ranges of their params.
    """
    names = short_names(loop)
    for name in values:
        if name not in names:
            raise UnknownNameError("param", name, tuple(names))
    settings = {names[name]: float(value) for name, value in values.items()}
    outside = [d for name, value in settings.items() for d in _outside(loop, name, value)]
    if outside:
        raise DiagnosticError(outside)
    params = tuple(replace(p, expression=Number(settings[p.name])) if p.name in settings else p for p in loop.params)
    instances = tuple(_set(instance, settings) for instance in loop.instances)
    return with_shared(replace(loop, params=params, instances=instances), settings)


def _outside(loop: Loop, name: str, value: float) -> Iterator[Diagnostic]:
    """Report a value outside of the range of its param."""
    block, _, own = name.rpartition(".")
    owner: Loop | Controller | Plant = loop
    if block:
        owner = blocks_of(loop)[next(i.controller for i in loop.instances if i.name == block)]
    bounds = next(p.bounds for p in owner.params if p.name == own)
    if bounds is None:
        return
    low, high = (evaluate(e, owner.param_values.values) for e in (bounds.lower, bounds.upper))
    above = value > low if bounds.without_lower else value >= low
    below = value < high if bounds.without_upper else value <= high
    if not (above and below):
        text = bounds.span.text if bounds.span is not None else f"[{low:g}, {high:g}]"
        yield Diagnostic("FZ302", f"param '{name}' is {value:g}, outside of {text}", bounds.span)


def _set(instance: Instance, settings: Mapping[str, float]) -> Instance:
    own = {n.partition(".")[2]: v for n, v in settings.items() if n.partition(".")[0] == instance.name and "." in n}
    if not own:
        return instance
    kept = [a for a in instance.arguments if not (isinstance(a, Keyword) and a.name in own)]
    given = [Keyword(name, Number(value)) for name, value in own.items()]
    return replace(instance, arguments=(*kept, *given))
