"""Params before the first block of a file, which belong to all of its blocks: one line, one number."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, TypeVar

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Number
from fuzzyctl.model.controller import EquationBlock

Block = TypeVar("Block", bound=EquationBlock)


def with_values(block: Block, values: Mapping[str, float]) -> Block:
    """Return a block with some of its params set to numbers, and with them those that the blocks inside it share.

    Args:
        block: A block.
        values: By name; names of no param do not count.
    """
    params = tuple(
        dataclasses.replace(p, expression=Number(values[p.name], span=p.span)) if p.name in values else p
        for p in block.params
    )
    return with_shared(dataclasses.replace(block, params=params), values)


def with_shared(block: Block, values: Mapping[str, float]) -> Block:
    """Return a block whose systems, controllers and plants have its values of the params that they share with it.

    Args:
        block: A block, whose own params are left as they are.
        values: Values of its params, by name; other names do not count.
    """
    written: dict[Span | None, float] = {p.span: values[p.name] for p in block.params if p.name in values and p.span}
    return _with_inner(block, written) if written else block


def _with_inner(block: Block, written: Mapping[Span | None, float]) -> Block:
    changed: dict[str, Any] = {
        "systems": tuple(
            system.with_params(**numbers)
            if (numbers := {p.name: written[p.span] for p in system.params if p.span in written})
            else system
            for system in block.systems
        ),
        "controllers": tuple(_with_written(c, written) for c in block.controllers),
        "plants": tuple(_with_written(p, written) for p in block.plants),
    }
    return dataclasses.replace(block, **changed)


def _with_written(block: Block, written: Mapping[Span | None, float]) -> Block:
    params = tuple(
        dataclasses.replace(p, expression=Number(written[p.span], span=p.span)) if p.span in written else p
        for p in block.params
    )
    return _with_inner(dataclasses.replace(block, params=params), written)
