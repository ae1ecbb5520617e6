"""Resolution of `require` lines of systems and controllers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.fixes import respelt_as_suggested, with_decimal_points
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted, did_you_mean
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.block import Guarantee
from fuzzyctl.resolve.context import Context

#: The claims of a guarantee on an output: the forms, and whether the word is a condition by itself.
FORMS: Final[dict[str, tuple[str, bool]]] = {
    "total": ("total(OUTPUT), or total(OUTPUT) >= STRENGTH", True),
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
        truth: Whether a condition is expected, else a number.
    """
    match claim:
        case ex.Compare(op="<=", left=ex.Call(function="lipschitz") as slope, right=bound, span=span):
            parts = all([_check_form(context, slope, False), context.check_names(bound, context.params, "param")])
            return _due(context, truth, "a number", "a comparison", span) and parts
        case ex.Compare(op=">=", left=ex.Call(function="total") as total, right=least, span=span):
            parts = all([_check_form(context, total, True), context.check_names(least, context.params, "param")])
            return _due(context, truth, "a number", "a comparison", span) and parts
        case ex.Compare(left=left, right=right, span=span):
            parts = all([check_claim(context, p, truth=False) for p in (left, right)])
            return _due(context, truth, "a number", "a comparison", span) and parts
        case ex.Logic(op=op, operands=operands, span=span):
            parts = all([check_claim(context, p, truth=True) for p in operands])
            return _due(context, truth, "a number", f"'{op}'", span) and parts
        case ex.Call(function="lipschitz", span=span) if not truth:
            facts = (f"the form is: {FORMS['lipschitz'][0]}",)
            context.report("FZ303", "expected 'lipschitz' alone on the left of '<='", span, facts=facts)
            return False
        case ex.Call(function=function) if function in FORMS:
            return _check_form(context, claim, truth)
        case ex.Call(function=function) if not _is_known(context, function):
            _unknown_function(context, claim)
            return False
        case ex.Call(function=function, span=span):
            parts = all([check_claim(context, p, truth=False) for p in claim.arguments])
            is_due = not truth or context.is_condition(claim)
            return _due(context, is_due, "a condition", "a number", span) and _check_call(context, claim) and parts
        case ex.Name(name=name, span=span):
            names = context.read
            if name not in names and name not in ex.CONSTANTS and "." not in name:
                context.unknown("name", claim, names)
                return False
            return _due(context, not truth or context.is_condition(claim), "a condition", "a number", span)
    parts = all([check_claim(context, p, truth=False) for p in ex.children(claim)])
    return _due(context, not truth, "a condition", "a number", ex.span_of(claim)) and parts


def names_output(context: Context, claim: ex.Expr) -> bool:
    """Whether a claim speaks of any output."""
    named = [
        n.name if isinstance(n, ex.Name) else n.function for n in ex.walk(claim) if isinstance(n, ex.Name | ex.Call)
    ]
    return any(name in context.outputs or "." in name for name in named)


def check_condition(context: Context, condition: ex.Expr) -> bool:
    """Check the condition behind `when`: it holds at a point or not, so that a claim about all points is refused."""
    form = next((n for n in ex.walk(condition) if isinstance(n, ex.Call) and n.function in FORMS), None)
    if form is not None:
        message = f"expected a condition, found '{form.function}', a claim about all points"
        context.report("FZ214", message, form.span, help="compare expressions, such as: when e >= 0")
        return False
    return check_claim(context, condition, truth=True)


def check_tolerance(context: Context, claim: ex.Expr, within: ex.Expr) -> bool:
    """Check the tolerance behind `within`, which only comparisons of numbers take."""
    if isinstance(claim, ex.Call) and claim.function == "total":
        help_text = "remove it: an output is defined everywhere or it is not"
        context.report("FZ214", "'within' does not go with 'total'", ex.span_of(within), help=help_text)
        return False
    return context.check_names(within, context.params, "param")


def _due(context: Context, right: bool, due: str, given: str, span: Span | None) -> bool:
    if not right:
        help_text = "compare it, such as: f <= 1" if due == "a condition" else ""
        context.report("FZ307", f"expected {due}, found {given}", span, help=help_text)
    return right


def _is_known(context: Context, function: str) -> bool:
    return function in ex.FUNCTIONS or function in context.outputs or "." in function


def _check_call(context: Context, call: ex.Call) -> bool:
    if "." in call.function:
        return True
    if call.function in context.outputs:
        due = len(context.inputs)
        if len(call.arguments) == due or context.lost_input:
            return True
        message = f"'{call.function}' takes {counted(due, 'argument')}, not {len(call.arguments)}"
        help_text = f"the form is: {call.function}({', '.join(context.inputs)})"
        fix = with_decimal_points(call.span, len(call.arguments), due)
        context.report("FZ303", message, call.span, help=help_text, fix=fix)
        return False
    return context.check_call(call)


def _unknown_function(context: Context, call: ex.Call) -> None:
    if call.function in context.unread or context.lost_variable or "output" in context.nameless:
        return
    names = [*ex.FUNCTIONS, *FORMS, *context.outputs]
    context.report(
        "FZ202",
        f"no function or output '{call.function}'",
        call.span,
        facts=(f"functions: {', '.join(names)}",),
        help=did_you_mean(call.function, names),
        fix=respelt_as_suggested(call.span, call.function, names),
    )


def _check_form(context: Context, call: ex.Call, truth: bool) -> bool:
    form, is_truth = FORMS[call.function]
    help_text = f"the form is: {form}"
    due = form.split(")")[0].count(",") + 1
    if len(call.arguments) != due:
        message = f"'{call.function}' takes {counted(due, 'argument')}, not {len(call.arguments)}"
        fix = with_decimal_points(call.span, len(call.arguments), due)
        context.report("FZ303", message, call.span, help=help_text, fix=fix)
        return False
    ok = _names(context, call.arguments[0], context.outputs, "output", help_text)
    if call.function == "bounded":
        ok = all([context.check_names(a, context.params, "param") for a in call.arguments[1:]]) and ok
    elif due == 2:
        ok = _names(context, call.arguments[1], context.inputs, "input", help_text) and ok
    if is_truth != truth:
        kind = "a condition" if is_truth else "a number"
        context.report("FZ307", f"'{call.function}' is {kind}", call.span, help=help_text)
        return False
    return ok


def _names(context: Context, given: ex.Expr, among: Mapping[str, object], kind: str, help_text: str) -> bool:
    if isinstance(given, ex.Name):
        if given.name not in among:
            context.unknown(kind, given, among)
        return given.name in among
    context.report("FZ303", f"expected the name of an {kind}", ex.span_of(given), help=help_text)
    return False


def resolve_claim(context: Context, statement: sx.Require, formula: Callable[..., bool]) -> Guarantee | None:
    """Check a `require` line of a controller.

    Args:
        context: Where to report.
        statement: The line.
        formula: Checks an expression over the names of the controller.
    """
    parts = [p for p in (statement.claim, statement.when) if p is not None]
    fine = all([_is_pointwise(context, p) and _is_condition(p, formula) for p in parts])
    if statement.within is not None:
        fine = context.check_names(statement.within, context.params, "param") and fine
    if not fine:
        return None
    return Guarantee(claim=statement.claim, within=statement.within, when=statement.when, span=statement.span)


def _is_pointwise(context: Context, claim: ex.Expr) -> bool:
    """Report words about all points of a system, which a claim about a step does not have."""
    for node in ex.walk(claim):
        if not isinstance(node, ex.Call) or node.function not in FORMS:
            continue
        form = FORMS[node.function][0]
        if node.function != "bounded":
            message = f"'{node.function}' is a claim about a system, not about a step of a controller"
            help_text = f"compare values of a step, or claim it in the system: require {form}"
            context.report("FZ214", message, node.span, help=help_text)
            return False
        if len(node.arguments) != 3:
            message = f"'bounded' takes {counted(3, 'argument')}, not {len(node.arguments)}"
            context.report("FZ303", message, node.span, help=f"the form is: {form}")
            return False
    return True


def _is_condition(claim: ex.Expr, formula: Callable[..., bool]) -> bool:
    """Check a condition, `bounded` among its parts."""
    match claim:
        case ex.Logic(operands=operands):
            return all([_is_condition(o, formula) for o in operands])
        case ex.Call(function="bounded", arguments=arguments):
            return all([formula(a, truth=False, pure=True) for a in arguments])
    return formula(claim, truth=True, pure=True)
