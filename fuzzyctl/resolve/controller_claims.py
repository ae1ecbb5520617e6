"""Resolution of `require` lines of controllers."""

from __future__ import annotations

from collections.abc import Callable

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.guarantee import Guarantee
from fuzzyctl.resolve.claims import FORMS
from fuzzyctl.resolve.context import Context


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
