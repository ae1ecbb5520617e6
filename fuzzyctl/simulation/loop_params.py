"""Params of a loop and of its blocks, and loops with other values of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError, UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.expr import Expr, Keyword, Number, evaluate, names_in
from fuzzyctl.model.block import Param, ParamValues
from fuzzyctl.model.checks.blocks import computed, ends_of, numbers_of_all
from fuzzyctl.model.checks.terms import has_computed_params, outside_ranges
from fuzzyctl.model.controller import Controller, Instance, State
from fuzzyctl.model.instance_params import with_instance_params
from fuzzyctl.model.loop import Disturbance, Loop, Varied
from fuzzyctl.model.plant import Plant
from fuzzyctl.model.shared_params import with_shared
from fuzzyctl.support.arguments import is_finite


def blocks_of(loop: Loop) -> dict[str, Controller | Plant]:
    """Return the controllers and plants that blocks of a loop are of, by name."""
    blocks: dict[str, Controller | Plant] = {c.name: c for c in loop.controllers}
    return blocks | {p.name: p for p in loop.plants}


def block_params(loop: Loop, instance: Instance) -> dict[str, float]:
    """Return the values of the params of a block of a loop."""
    params = blocks_of(loop)[instance.controller].params
    settings = {a.name: a.value for a in instance.arguments if isinstance(a, Keyword)}
    numbers = {
        p.name: Number(evaluate(settings[p.name], loop.param_values.values)) for p in params if p.name in settings
    }
    return ParamValues([replace(p, expression=numbers.get(p.name, p.expression)) for p in params]).values


def params_of(loop: Loop) -> dict[str, float]:
    """Return the values of all params: `PARAM` of the loop, `BLOCK.PARAM` of its controllers and plants."""
    values = dict(loop.param_values.values)
    for instance in loop.instances:
        values |= {f"{instance.name}.{name}": value for name, value in block_params(loop, instance).items()}
    return values


def starts_of(loop: Loop) -> dict[str, float]:
    """Return the starts of the states of controllers and plants, by `BLOCK.STATE`."""
    values: dict[str, float] = {}
    for instance in loop.instances:
        block, params = loop.callee(instance), block_params(loop, instance)
        values |= {f"{instance.name}.{s.name}": evaluate(s.start, params) for s in block.states}
    return values


def settable_of(loop: Loop) -> dict[str, float]:
    """Return all numbers that can be set: params, starts of states, and the nominal values of disturbances."""
    nominal = {d.name: evaluate(d.nominal, loop.param_values.values) for d in loop.disturbances}
    return params_of(loop) | nominal | starts_of(loop)


def all_settable(loop: Loop) -> dict[str, float]:
    """Return the same, with the params of controllers inside controllers: `BLOCK.INSTANCE.PARAM`."""
    return settable_of(with_instance_params(loop, loop.instance_params))


def timing_params(loop: Loop) -> set[str]:
    """Return the full names of the params that the duration, the step and the periods of controllers depend on."""
    needed = names_behind(loop.params, [e for e in (loop.duration, loop.step) if e is not None])
    names: set[str] = set()
    for instance in loop.instances:
        block = blocks_of(loop)[instance.controller]
        if block.period is None:
            continue
        settings = {a.name: a.value for a in instance.arguments if isinstance(a, Keyword)}
        in_block = names_behind([p for p in block.params if p.name not in settings], [block.period])
        names |= {f"{instance.name}.{name}" for name in in_block}
        needed |= names_behind(loop.params, [settings[name] for name in in_block if name in settings])
    return names | needed


def names_behind(params: Sequence[Param], values: Sequence[Expr]) -> set[str]:
    """Return the names that expressions use, themselves or through params."""
    expressions = {p.name: p.expression for p in params}
    names: set[str] = set()
    stack = list(values)
    while stack:
        new = {n.name for n in names_in(stack.pop())} - names
        names |= new
        stack += [expressions[name] for name in new if name in expressions]
    return names


def short_names(loop: Loop) -> dict[str, str]:
    """Return the full names of all numbers that can be set by the names that they may be given by.

    `BLOCK.PARAM` is also `PARAM` where the loop and its other blocks have none of that name.
    """
    full = list(params_of(loop))
    outer = [name for name in full if name.count(".") <= 1]
    last = [name.rpartition(".")[2] for name in outer]
    short = {n: f for n, f in zip(last, outer, strict=True) if last.count(n) == 1}
    return {name: name for name in full} | short | {name: name for name in settable_of(loop)}


def with_settings(loop: Loop, values: Mapping[str, float]) -> Loop:
    """Return a loop with some params, starts and nominal values set to numbers.

    Raises:
        UnknownNameError: For a name of none of them, or of several.
        ValueOutOfBoundsError: For a value that is not a finite number.
        DiagnosticError: For values outside of their ranges, or of those that follow from them, and for other errors of
            `check` with such numbers, such as a period that is not positive.
    """
    changed = within_ranges(loop, values)
    mistakes = list(numbers_of_all(changed))
    params = changed.param_values
    ends = [e for b in loop.family.values() for e in (b.lower, b.upper)]
    if values.keys() & names_behind(loop.params, ends):  # not for each member of the family
        items: tuple[Varied | Disturbance, ...] = (*changed.varied, *changed.disturbances)
        for item in items:
            mistakes += range_mistakes(item, ends_of(item.bounds, params), params)
    if mistakes:
        raise DiagnosticError(mistakes)
    return changed


def range_mistakes(
    item: Varied | Disturbance, ends: tuple[float, float] | None, params: ParamValues
) -> Iterator[Diagnostic]:
    """Check the range of a number of a family; one number alone is a range, too."""
    bounds = item.bounds
    yield from (e for e in (computed(x, params) for x in (bounds.lower, bounds.upper)) if isinstance(e, Diagnostic))
    if ends is None:
        return
    low, high = ends
    if low > high or (low == high and (bounds.without_lower or bounds.without_upper)):
        message = f"the range of '{item.name}' is empty: {low:g} is not below {high:g}"
        yield Diagnostic("FZ304", message, bounds.span, help="put the smaller end first")
    elif math.isinf(low) or math.isinf(high):
        message = f"the range of '{item.name}' is infinite"
        facts = ("draws and proofs need two finite ends",)
        ends_text = f"{-1 if math.isinf(low) else low:g}, {1 if math.isinf(high) else high:g}"
        help_text = f"write numbers, such as: in [{ends_text}]"
        yield Diagnostic("FZ302", message, bounds.span, facts=facts, help=help_text)


def within_ranges(loop: Loop, values: Mapping[str, float]) -> Loop:
    """Return the same; only the ranges are checked, which is quick.

    Raises:
        UnknownNameError: For a name of none of them, or of several.
        ValueOutOfBoundsError: For a value that is not a finite number.
        DiagnosticError: For values outside of their ranges, or of those that follow from them.
    """
    loop = with_instance_params(loop, values)  # which has the params of controllers inside by name
    names = short_names(loop)
    for name, value in values.items():
        if name not in names:
            raise UnknownNameError("param", name, tuple(names))
        if not is_finite(value):
            raise ValueOutOfBoundsError(f"param {name!r}", value, "a finite number")
    changed = _changed(loop, {names[name]: float(value) for name, value in values.items()})
    violations = outside_ranges(changed, {})
    outside = [Diagnostic("FZ302", f"{o.what} is {o.value:g}, outside of {o.text}", o.bounds.span) for o in violations]
    if outside:
        raise DiagnosticError(outside)
    return changed


def _changed(loop: Loop, settings: Mapping[str, float]) -> Loop:
    """Return a loop with numbers of full names set, unchecked."""
    starts = {name: settings[name] for name in starts_of(loop) if name in settings}
    params = tuple(replace(p, expression=Number(settings[p.name])) if p.name in settings else p for p in loop.params)
    nominal = (replace(d, nominal=Number(settings[d.name])) if d.name in settings else d for d in loop.disturbances)
    values = {name: value for name, value in settings.items() if name not in starts}
    instances = tuple(instance.with_values(values) for instance in loop.instances)
    changed = replace(loop, params=params, disturbances=tuple(nominal), instances=instances)
    return with_shared(_with_starts(changed, starts), settings)


def _with_starts(loop: Loop, starts: Mapping[str, float]) -> Loop:
    """Return a loop with other starts of states; a block that several instances are of is copied."""
    for instance in loop.instances if starts else ():
        block = loop.callee(instance)
        values = {s.name: starts.get(f"{instance.name}.{s.name}") for s in block.states}
        if all(value is None for value in values.values()):
            continue
        states = (replace(s, start=Number(v)) if (v := values[s.name]) is not None else s for s in block.states)
        is_shared = [i.controller for i in loop.instances].count(block.name) > 1
        name = f"{instance.name}.{block.name.rpartition('.')[2]}" if is_shared else block.name
        instances = tuple(replace(i, controller=name) if i is instance else i for i in loop.instances)
        loop = replace(loop, instances=instances)
        if isinstance(block, Plant):
            plant = replace(block, name=name, states=tuple(states))
            loop = replace(loop, plants=(*(p for p in loop.plants if p.name != name), plant))
        elif isinstance(block, Controller):
            controller = replace(block, name=name, states=tuple(states))
            loop = replace(loop, controllers=(*(c for c in loop.controllers if c.name != name), controller))
    return loop


class Ranges:
    """Ranges of free numbers, checked at each run.

    Args:
        loop: The loop.
        names: Full names of params, starts and disturbances.
    """

    def __init__(self, loop: Loop, names: tuple[str, ...]) -> None:
        self._loop, self._names = loop, names
        declared = [(k, _declared(loop, name, {})[0].bounds) for k, name in enumerate(names)]
        bounds = [(k, b, b.lower, b.upper) for k, b in declared if b is not None]
        #: Those with numbers as ends, which are quickly checked, and whether there are no others.
        self._plain = [(k, b, x.value, y.value) for k, b, x, y in bounds if type(x) is type(y) is Number]
        self._only_plain = len(self._plain) == len(bounds) and not has_computed_params(loop)

    def surely_hold(self, values: Sequence[float]) -> bool:
        """Return whether values are finite and in their ranges; False also where that takes longer to say."""
        inside = self._only_plain and all(b.holds(values[k], low, high) for k, b, low, high in self._plain)
        return inside and all(map(math.isfinite, values))

    def require(self, values: Sequence[float]) -> None:
        """Check values.

        Raises:
            ValueOutOfBoundsError: For one that is not finite, or outside the range of its param, and where a param that
                follows from it is.
        """
        settings = dict(zip(self._names, values, strict=True))
        for name, value in settings.items():
            if not math.isfinite(value):
                raise ValueOutOfBoundsError(f"free number '{name}'", value, "a finite number")
            param, numbers = _declared(self._loop, name, settings)
            if param.bounds is not None:
                from fuzzyctl.kernels.free_values import require_bounds  # numpy, which checks do without

                require_bounds(name, value, param.bounds, numbers, param.unit)
        for o in () if self._only_plain else outside_ranges(_changed(self._loop, settings), {}):
            raise ValueOutOfBoundsError(f"{o.what} under these free numbers", o.value, f"in {o.text}")


def _declared(
    loop: Loop, name: str, settings: Mapping[str, float]
) -> tuple[Param | State | Disturbance, dict[str, float]]:
    """Return the declaration of a full name, and the values of the params of its block under some settings."""
    block, dot, _ = name.partition(".") if "." in name else ("", "", name)
    instance = next((i for i in loop.instances if i.name == block), None)
    declared = loop.declared(name)
    assert declared is not None, "only known names are free"
    owner, item = declared
    values = loop.param_values.values if instance is None else block_params(loop, instance)
    changed = {p.name: settings[block + dot + p.name] for p in owner.params if block + dot + p.name in settings}
    return item, values | changed
