"""Why a controller has no proved error of fixed point: the place, the reason and what to write instead."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Binary, Call, Expr, Number, span_of, walk
from fuzzyctl.kernels.plan.equations import Equation, Equations

FLOAT: Final = "or write single precision with --float float"
#: Why the error of an integrator has no bound.
KEEPS_ERROR: Final = "it keeps its error, as an integrator does, and each step may add that of a rounding"
#: What takes the place of `integral(x)`.
_AS_STATE: Final = (
    "write a state in its place, whose range it keeps and whose addend the format holds whole: "
    "'state sum in [-1, 1] = 0' and 'next sum = clamp(sum + x / 128, -1, 1)'"
)
#: States that operators keep are called after them.
_OPERATOR: Final = re.compile(r"(\w+)#\d+")


def refused(message: str, span: Span | None, *, facts: Sequence[str] = (), help_text: str = "") -> DiagnosticError:
    """Return the exception with one diagnostic."""
    return DiagnosticError([Diagnostic("FZ410", message, span, facts=tuple(facts), help=help_text)])


def place_of(equations: Equations, node: Expr) -> Span | None:
    """Return where an expression stands that has lost its place: the first of its kind."""
    exprs = [e for i in equations.body for e in ((i.value,) if isinstance(i, Equation) else i.arguments)]
    for part in (p for e in (*exprs, *equations.updates) for p in walk(e)):
        match node, part:
            case (Call(function=a), Call(function=b)) if a == b:
                return span_of(part)
            case (Binary(op=a), Binary(op=b, right=right)) if a == b and (a == "^" or not isinstance(right, Number)):
                return span_of(part)
    return None


def operator_of(state: str) -> str:
    """Return the operator that keeps a state, an empty text for one that the file declares."""
    found = _OPERATOR.search(state)
    return "" if found is None else found[1]


def state_words(name: str) -> str:
    """Return what a state is called in a message."""
    operator = operator_of(name)
    return f"the state of '{operator}'" if operator else f"state '{name}'"


def range_help(name: str) -> str:
    """Return what to write where a state has no proved range."""
    if operator_of(name) == "integral":
        return f"{_AS_STATE}, {FLOAT}"
    return f"give it a range that it keeps, such as with 'clamp', {FLOAT}"


def error_help(name: str) -> str:
    """Return what to write where the error of a state has no bound."""
    if operator_of(name) == "integral":
        return f"{_AS_STATE}, {FLOAT}"
    own = "x" if operator_of(name) else name
    return f"let it forget, as 'next {own} = 0.99 * {own} + ...' does, or add only what the format holds whole, {FLOAT}"
