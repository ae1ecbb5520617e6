"""Checks the form of guarantees: names, numbers of arguments, and where a truth value or a number is due."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from fuzzyctl import expr as ex
from fuzzyctl.errors import closest
from fuzzyctl.resolve.context import Context
from fuzzyctl.source import Span

#: What a guarantee may say of an output: the forms, and whether the word is a truth value by itself.
FORMS: Final[dict[str, tuple[str, bool]]] = {
    "total": ("total(OUTPUT)", True),
    "bounded": ("bounded(OUTPUT, LOW, HIGH)", True),
    "increasing": ("increasing(OUTPUT, INPUT)", True),
    "decreasing": ("decreasing(OUTPUT, INPUT)", True),
    "lipschitz": ("lipschitz(OUTPUT, INPUT) <= BOUND", False),
}


def check_claim(context: Context, claim: ex.Expr, *, truth: bool) -> bool:
    """Check a claim or a part of one.

    Args:
        context: Where to report.
        claim: The expression.
        truth: Whether a truth value is due, else a number.
    """
    match claim:
        case ex.Compare(left=left, right=right, span=span):
            parts = all([check_claim(context, p, truth=False) for p in (left, right)])
            return _due(context, truth, "a number", "a comparison", span) and parts
        case ex.Logic(op=op, operands=operands, span=span):
            parts = all([check_claim(context, p, truth=True) for p in operands])
            return _due(context, truth, "a number", f"'{op}'", span) and parts
        case ex.Call(function=function) if function in FORMS:
            return _check_form(context, claim, truth)
        case ex.Call(function=function, span=span):
            parts = all([check_claim(context, p, truth=False) for p in claim.arguments])
            return _due(context, not truth, "a truth value", "a number", span) and _check_call(context, claim) and parts
        case ex.Name(name=name, span=span):
            known = [*context.params, *context.inputs, *context.outputs]
            if name not in known and name not in ex.CONSTANTS:
                context.unknown("name", claim, known)
                return False
            return _due(context, not truth, "a truth value", "a number", span)
    parts = all([check_claim(context, p, truth=False) for p in ex.children(claim)])
    return _due(context, not truth, "a truth value", "a number", ex.span_of(claim)) and parts


def _due(context: Context, right: bool, due: str, given: str, span: Span | None) -> bool:
    if not right:
        help_text = "compare it, such as: f <= 1" if due == "a truth value" else ""
        context.report("FZ307", f"{due} is due here, not {given}", span, help=help_text)
    return right


def _check_call(context: Context, call: ex.Call) -> bool:
    if call.function in context.outputs:
        due = len(context.inputs)
        if len(call.arguments) == due or context.lost_input:
            return True
        message = f"'{call.function}' takes {due} arguments, not {len(call.arguments)}"
        context.report("FZ303", message, call.span, facts=(f"inputs: {', '.join(context.inputs)}",))
        return False
    if call.function in ex.FUNCTIONS:
        return context.check_call(call)
    if call.function in context.unread or context.lost_variable:
        return False
    known = [*ex.FUNCTIONS, *FORMS, *context.outputs]
    near = closest(call.function, known)
    context.report(
        "FZ202",
        f"no function or output '{call.function}'",
        call.span,
        facts=(f"functions: {', '.join(known)}",),
        help=f"did you mean '{near}'?" if near else "",
    )
    return False


def _check_form(context: Context, call: ex.Call, truth: bool) -> bool:
    form, is_truth = FORMS[call.function]
    facts = (f"the form is: {form}",)
    due = form.split(")")[0].count(",") + 1
    if len(call.arguments) != due:
        message = f"'{call.function}' takes {due} argument{'' if due == 1 else 's'}, not {len(call.arguments)}"
        context.report("FZ303", message, call.span, facts=facts)
        return False
    ok = _names(context, call.arguments[0], context.outputs, "output", facts)
    if call.function == "bounded":
        ok = all([context.check_names(a, context.params, "param") for a in call.arguments[1:]]) and ok
    elif due == 2:
        ok = _names(context, call.arguments[1], context.inputs, "input", facts) and ok
    if is_truth != truth:
        given = "a truth value" if is_truth else "a number"
        context.report("FZ307", f"'{call.function}' is {given}", call.span, facts=facts)
        return False
    return ok


def _names(context: Context, given: ex.Expr, among: Mapping[str, object], kind: str, facts: tuple[str, ...]) -> bool:
    if isinstance(given, ex.Name):
        if given.name not in among:
            context.unknown(kind, given, among)
        return given.name in among
    context.report("FZ303", f"the name of an {kind} is due here", ex.span_of(given), facts=facts)
    return False
