"""The order in which equations can be computed, and algebraic loops, for which there is none."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.expr import names_in
from fuzzyctl.kernels.plan.equations import Equation, Equations, Evaluation


def ordered(body: list[Equation | Evaluation]) -> tuple[Equation | Evaluation, ...]:
    """Return equations each after those that it reads.

    Raises:
        DiagnosticError: For an algebraic loop.
    """
    makers: dict[str, Equation | Evaluation] = {}
    for item in body:
        makers |= dict.fromkeys(item.defined if isinstance(item, Evaluation) else (item.name,), item)
    ordered: dict[int, Equation | Evaluation] = {}
    for item in body:
        if id(item) not in ordered:
            _visit(item, makers, ordered)
    return tuple(ordered.values())


def feedthrough(equations: Equations) -> dict[str, tuple[str, ...]]:
    """Return the inputs that each output depends on within the same step."""
    depends = {name: frozenset((name,)) for name in equations.inputs}
    for item in equations.body:
        read = frozenset[str]().union(*(depends[n] for n in _reads(item) if n in depends))
        depends |= dict.fromkeys(item.defined if isinstance(item, Evaluation) else (item.name,), read)
    values = {o: frozenset[str]().union(*(depends.get(n.name, ()) for n in names_in(v))) for o, v in equations.outputs}
    return {output: tuple(i for i in equations.inputs if i in found) for output, found in values.items()}


def _reads(item: Equation | Evaluation) -> list[str]:
    values = (*item.arguments, *(v for _, v in item.free)) if isinstance(item, Evaluation) else (item.value,)
    return [n.name for value in values for n in names_in(value)]


def _visit(
    start: Equation | Evaluation,
    makers: Mapping[str, Equation | Evaluation],
    ordered: dict[int, Equation | Evaluation],
) -> None:
    """Put an equation behind those that it reads, without recursion: chains of equations may be long."""
    open_items = {id(start): start}
    path = [(start, _needed(start, makers))]
    while path:
        item, needed = path[-1]
        following = next((n for n in needed if id(n) not in ordered), None)
        if following is None:
            ordered.setdefault(id(item), item)
            del open_items[id(item)]
            path.pop()
        elif id(following) in open_items:
            members = [open_one for open_one, _ in path]
            raise DiagnosticError([_loop(members[members.index(following) :])])
        else:
            open_items[id(following)] = following
            path.append((following, _needed(following, makers)))


def _needed(
    item: Equation | Evaluation, makers: Mapping[str, Equation | Evaluation]
) -> Iterator[Equation | Evaluation]:
    return iter([makers[n] for n in _reads(item) if n in makers])


def _loop(items: list[Equation | Evaluation]) -> Diagnostic:
    """Return the diagnostic of equations that read each other in a circle."""
    written = [item for item in items if _shown(item)] or items
    named = list(dict.fromkeys(map(_shown, written)))
    span = next((item.span for item in (*written, *items) if item.span is not None), None)
    chain = " → ".join([*named, named[0]])
    message = f"algebraic loop: '{named[0]}' depends on itself within one step"
    help_text = f"let a value of the step before break it, such as previous({named[0]})"
    return Diagnostic("FZ220", message, span, facts=(chain,), help=help_text)


def _shown(item: Equation | Evaluation) -> str:
    """Return the name of an equation as its author wrote it; empty for one that the expansion made."""
    if isinstance(item, Evaluation):
        return item.system.name
    return "" if "#" in item.name else item.name
