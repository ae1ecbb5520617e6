"""The parts of expressions that depend on params only."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from fuzzyctl.expr import FUNCTIONS, Binary, Call, Expr, Name, Negate, Number, children, walk

#: Whether a name has a value before anything runs.
IsKnown = Callable[[str], bool]


def constants(expr: Expr, is_known: IsKnown) -> list[Expr]:
    """Return the largest parts of an expression that depend on params only, from left to right; numbers are none.

    Parts of the choices of `where` are none either: its condition may leave them out.
    """
    found, whole = _parts(expr, is_known)
    return [expr] if whole and not isinstance(expr, Number) else found


def quotients(expr: Expr, is_known: IsKnown) -> Iterator[tuple[Expr, Expr]]:
    """Yield quotients and remainders of what depends on variables, each with a divisor that depends on params only."""
    choices = {id(n) for node in walk(expr) if _is_choice(node) for c in children(node)[1:] for n in walk(c)}
    for node in walk(expr):
        divisor = _divisor(node)
        if divisor is not None and id(node) not in choices:
            (_, whole), (_, below) = _parts(node, is_known), _parts(divisor, is_known)
            if below and not whole:
                yield node, divisor


def _divisor(expr: Expr) -> Expr | None:
    match expr:
        case Binary(op="/", right=divisor) | Call(function="mod" | "fmod", arguments=(_, divisor)):
            return divisor
    return None


def _is_choice(expr: Expr) -> bool:
    return isinstance(expr, Call) and expr.function == "where"


def _parts(expr: Expr, is_known: IsKnown) -> tuple[list[Expr], bool]:
    """Return the largest parts below an expression that depend on params only, and whether all of it does."""
    inner = children(expr)[:1] if _is_choice(expr) else children(expr)
    parts = [(child, *_parts(child, is_known)) for child in inner]
    whole = _is_arithmetic(expr, is_known) and all(is_whole for _, _, is_whole in parts)
    if whole:
        return [], True
    found: list[Expr] = []
    for child, below, is_whole in parts:
        found += below if not is_whole else [] if isinstance(child, Number) else [child]
    return found, False


def _is_arithmetic(expr: Expr, is_known: IsKnown) -> bool:
    match expr:
        case Name(name=name):
            return is_known(name)
        case Call(function=function):
            return function in FUNCTIONS
    return isinstance(expr, Number | Negate | Binary)
