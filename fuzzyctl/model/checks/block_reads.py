"""Checks of names in controllers, plants and loops: each param, input, let and state should have an effect."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.suggestions import listed
from fuzzyctl.expr import Expr, Name, names_in
from fuzzyctl.model.checks.block_numbers import expressions
from fuzzyctl.model.controller import Definition, EquationBlock, Signal
from fuzzyctl.model.guarantee import Bounds, Param
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.plant import Plant


def unread_names(block: EquationBlock) -> Iterator[Diagnostic]:
    """Find written params, inputs, lets and states without effect on outputs, claims and measures."""
    if isinstance(block, Plant) and block.external:  # the code reads them
        return
    reads: defaultdict[str, set[str]] = defaultdict(set)
    for reader, expr, parameters in (*expressions(block), *_settings(block)):
        reads[reader].update({n.name.partition(".")[0] for n in names_in(expr)} - parameters)
    live: set[str] = set()
    ahead = [""]
    while ahead:
        names = reads[ahead.pop()] - live
        live |= names
        ahead += names
    kinds: list[tuple[str, Sequence[Param | Definition | Signal]]] = [("param", block.params)]
    kinds += [("let", block.definitions)]
    kinds += [("input", block.inputs), ("state", block.states)]
    # States of transfer functions and matrices are not written.
    unread = {d.name: (kind, d) for kind, items in kinds for d in items if d.name not in live and d.span is not None}
    readers: defaultdict[str, list[str]] = defaultdict(list)
    for reader in unread:
        for name in reads[reader] - {reader}:
            readers[name].append(f"'{reader}'")
    for name, (kind, item) in unread.items():
        facts = (f"read only by {listed(readers[name])}, without effect on an output",) if readers[name] else ()
        message = f"no equation reads input '{name}'" if kind == "input" else f"{kind} '{name}' is not used"
        code = "FZ211" if kind == "input" else "FZ216"
        yield Diagnostic(code, message, item.span, "warning", facts, "remove it, or use it")


def _settings(block: EquationBlock) -> Iterator[tuple[str, Expr, set[str]]]:
    """Yield the remaining expressions: values of params, starts, ranges, periods and tolerances."""
    ranges: list[tuple[str, Bounds | None]] = [(p.name, p.bounds) for p in block.params]
    settings: list[tuple[str, Expr | None]] = [(p.name, p.expression) for p in block.params]
    if isinstance(block, Loop):
        settings += [("", block.duration), ("", block.step), *(("", r.within) for r in block.requirements)]
    ranges += [(s.name, s.bounds) for s in (*block.inputs, *block.states)] + [("", r.bounds) for r in block.outputs]
    settings += [(s.name, s.start) for s in block.states]
    # A range of a state is a claim, and a run stops where a plant leaves it.
    settings += [("", Name(s.name)) for s in block.states if s.bounds is not None]
    settings += [("", block.period), *(("", g.within) for g in block.guarantees)]
    settings += [(name, end) for name, bounds in ranges if bounds is not None for end in (bounds.lower, bounds.upper)]
    yield from ((name, expr, set()) for name, expr in settings if expr is not None)
