"""Params of controllers inside a block by name, such as `linear.k_s`: each becomes a param of the block itself."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TypeVar

from fuzzyctl.expr import Keyword, Name, Number, evaluate
from fuzzyctl.model.block import Param
from fuzzyctl.model.controller import Controller, EquationBlock, Instance
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.shared_params import with_values

Block = TypeVar("Block", bound=EquationBlock)


def with_instance_params(block: Block, names: Iterable[str]) -> Block:
    """Return a block that computes the same, with some params of its instances as its params.

    Args:
        block: A controller, or a loop, whose own blocks have their params by name anyway.
        names: `INSTANCE.PARAM`, `INSTANCE.INSTANCE.PARAM` and so on; other names do not count.
    """
    for name in names:
        if "." in str(name):  # values of other types are refused by their reader
            block, _ = _with_one(block, name, block)
    return block


def _with_one(block: Block, name: str, present: EquationBlock) -> tuple[Block, Param | None]:
    """Return a block with one of these params, and the param, or None.

    Args:
        block: The block.
        name: `INSTANCE.PARAM` and so on.
        present: The block with the values at its place, as instances give each other params.
    """
    first, _, rest = name.partition(".")
    inner, callee = _controller_of(block, first), _controller_of(present, first)
    if inner is None or callee is None or any(p.name == name for p in block.params):
        return block, None
    instance = next(i for i in block.instances if i.name == first)
    arguments = {a.name: a.value for a in instance.arguments if isinstance(a, Keyword)}
    numbers = {
        p.name: evaluate(arguments[p.name], present.param_values.values) for p in callee.params if p.name in arguments
    }
    callee = with_values(callee, numbers)
    if "." in rest:
        changed, param = _with_one(inner, rest, callee)
        if param is None:
            return block, None
        # A copy of the controller: other instances of the same one keep theirs.
        changed = replace(changed, name=f"{first}.{inner.name.removeprefix(f'{first}.')}")
        block = _with_instance(block, instance, replace(instance, controller=changed.name))
        block = replace(block, controllers=(*(c for c in block.controllers if c.name != changed.name), changed))
    else:
        param = next((_as_numbers(p, callee) for p in callee.params if p.name == rest), None)
    if isinstance(block, Loop) or param is None:
        return block, param
    lifted = replace(param, name=name, expression=arguments.get(rest, param.expression))
    instance = next(i for i in block.instances if i.name == first)
    others = tuple(a for a in instance.arguments if not (isinstance(a, Keyword) and a.name == rest))
    block = _with_instance(block, instance, replace(instance, arguments=(*others, Keyword(rest, Name(name)))))
    return replace(block, params=(*block.params, lifted)), param


def _controller_of(block: EquationBlock, instance: str) -> Controller | None:
    """Return the controller that an instance is of; None for no instance, or that of a plant."""
    name = next((i.controller for i in block.instances if i.name == instance), None)
    return next((c for c in block.controllers if c.name == name), None)


def _with_instance(block: Block, old: Instance, new: Instance) -> Block:
    return replace(block, instances=tuple(new if i is old else i for i in block.instances))


def _as_numbers(param: Param, controller: Controller) -> Param:
    """Return a param with its present value, and the ends of its range, as numbers; on no line of the file."""
    values, bounds = controller.param_values.values, param.bounds
    if bounds is not None:
        lower, upper = (Number(evaluate(e, values)) for e in (bounds.lower, bounds.upper))
        bounds = replace(bounds, lower=lower, upper=upper)
    return replace(param, expression=Number(values[param.name]), bounds=bounds, span=None)
