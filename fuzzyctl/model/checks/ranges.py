"""Ranges of params and starts of blocks inside a block, where some params have other values than in the file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from fuzzyctl.expr import Expr, Keyword, Number, names_in
from fuzzyctl.model.controller import EquationBlock, Instance
from fuzzyctl.model.guarantee import Bounds
from fuzzyctl.model.params import ParamValues
from fuzzyctl.records import record


@record(frozen=True, slots=True)
class Outside:
    """A number outside of its range: what it is, its value, the range, and the range with the numbers of its ends."""

    what: str
    value: float
    bounds: Bounds
    text: str


def outside_ranges(block: EquationBlock, given: Mapping[str, float], path: str = "") -> Iterator[Outside]:
    """Yield the params and starts of states that leave their ranges, those of blocks inside too.

    Where some do, what follows from them is left out.

    Args:
        block: A well-formed block.
        given: Values of its params in place of those that it has.
        path: What names are preceded by, such as `law.`.
    """
    own = [replace(p, expression=Number(given[p.name])) if p.name in given else p for p in block.params]
    params = ParamValues(own, partial=True)
    chosen = [(f"param '{path}{p.name}'", p.expression, p.bounds) for p in own if p.name in given]
    others = [(f"param '{path}{p.name}'", p.expression, p.bounds) for p in own if p.name not in given]
    others += [(f"the start of state '{path}{s.name}'", s.start, s.bounds) for s in block.states]
    found = [*_outside(chosen, params)] or [*_outside(others, params)]
    yield from found
    if found:
        return
    for instance, inner, known in inside(block, params):
        yield from outside_ranges(inner, known, f"{path}{instance.name}.")


def _outside(ranged: Sequence[tuple[str, Expr, Bounds | None]], params: ParamValues) -> Iterator[Outside]:
    for what, number, bounds in ranged:
        if bounds is None:
            continue
        value, low, high = (params.of(e) for e in (number, bounds.lower, bounds.upper))
        if value is not None and low is not None and high is not None and not bounds.holds(value, low, high):
            yield Outside(what, value, bounds, bounds.text(low, high))


def has_computed_params(block: EquationBlock) -> bool:
    """Whether a param, or the end of its range, follows from others, in the block or in one inside it."""
    ranges = [(p.expression, p.bounds.lower, p.bounds.upper) for p in block.params if p.bounds is not None]
    if any(names_in(e) for own in ranges for e in own):
        return True
    for instance in block.instances:
        inner = block.callee(instance)
        given, ranged = _given(instance, inner), {p.name for p in inner.params if p.bounds is not None}
        if any(names_in(e) for name, e in given.items() if name in ranged) or has_computed_params(inner):
            return True
    return False


def inside(block: EquationBlock, params: ParamValues) -> Iterator[tuple[Instance, EquationBlock, dict[str, float]]]:
    """Yield the instances of a block, what they are of, and the values that they give its params, as far as known."""
    for instance in block.instances:
        inner = block.callee(instance)
        numbers = {name: params.of(e) for name, e in _given(instance, inner).items()}
        yield instance, inner, {name: value for name, value in numbers.items() if value is not None}


def _given(instance: Instance, inner: EquationBlock) -> dict[str, Expr]:
    """Return what an instance gives the params of its block."""
    names = {p.name for p in inner.params}
    return {a.name: a.value for a in instance.arguments if isinstance(a, Keyword) and a.name in names}
