"""Streams of noise: a stream for each `noise` of a loop."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Iterator
from dataclasses import replace as with_fields

from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.expr import Call, Expr, Keyword, Number, evaluate, replace, walk
from fuzzyctl.model.forms import bound
from fuzzyctl.model.loop import SIGNALS, Loop


def with_streams(loop: Loop) -> Loop:
    """Return a loop whose noises without a seed have one from the name of their signal.

    The only noise without a seed keeps the seed 0, if no other has it.
    """
    calls = [c for _, value in _signals(loop) for c in _noises(value)]
    seeds = [_seed(c, loop) for c in calls if _is_seeded(c)]
    if len(calls) == len(seeds) or (len(calls) == len(seeds) + 1 and 0.0 not in seeds):
        return loop
    values = [_streamed(name, value) for name, value in _signals(loop)]
    rest = iter(values)
    definitions = tuple(with_fields(d, value=next(rest)) for d in loop.definitions)
    instances = tuple(with_fields(i, arguments=tuple(next(rest) for _ in i.arguments)) for i in loop.instances)
    return with_fields(loop, definitions=definitions, instances=instances)


def equal_seeds(loop: Loop) -> Iterator[Diagnostic]:
    """Warn of noises with one seed, which are the same numbers."""
    first: dict[float, Call] = {}
    for call in (c for _, value in _signals(loop) for c in _noises(value) if _is_seeded(c)):
        seed = _seed(call, loop)
        before = first.setdefault(seed, call)
        if before is not call:
            notes = () if before.span is None else (Note(before.span, "the other one"),)
            message = f"two noises have the seed {seed:g}: they are the same numbers"
            help_text = "leave the seeds out, so that each draws other numbers, or make one signal of both with 'let'"
            yield Diagnostic("FZ214", message, call.span, severity="warning", notes=notes, help=help_text)


def _signals(loop: Loop) -> Iterator[tuple[str, Expr]]:
    """Yield the lets of a loop, and the arguments of its blocks as `BLOCK.INPUT`."""
    yield from ((d.name, d.value) for d in loop.definitions)
    inputs = {b.name: [s.name for s in b.inputs] for b in (*loop.controllers, *loop.plants)}
    for i in loop.instances:
        names = itertools.chain(inputs[i.controller], itertools.repeat(""))
        for a, name in zip(i.arguments, names, strict=False):
            yield f"{i.name}.{a.name if isinstance(a, Keyword) else name}", a


def _noises(value: Expr) -> Iterator[Call]:
    return (e for e in walk(value) if isinstance(e, Call) and e.function == "noise")


def _is_seeded(call: Call) -> bool:
    return len(call.arguments) > 1


def _seed(call: Call, loop: Loop) -> float:
    return evaluate(bound(SIGNALS["noise"], call)["seed"], loop.param_values.values)


def _streamed(signal: str, value: Expr) -> Expr:
    """Return the value of a signal with seeds: of its name, and of `NAME.2` for the second noise in it."""
    count = itertools.count(1)

    def change(node: Expr) -> Expr:
        if not (isinstance(node, Call) and node.function == "noise") or _is_seeded(node):
            return node
        number = next(count)
        name = signal if number == 1 else f"{signal}.{number}"
        seed = int.from_bytes(hashlib.blake2b(name.encode(), digest_size=6).digest(), "little")
        return Call("noise", (*node.arguments, Keyword("seed", Number(float(seed)))), node.span)

    return replace(value, change)
