"""Functions of a file in the expressions and terms of a system: calls are replaced by their bodies."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Final

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.fixes import with_decimal_points
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.lang import syntax as sx
from fuzzyctl.resolve.context import Context

#: Most parts of an expression whose functions are expanded.
MOST_PARTS: Final = 2_000


def declare_function(context: Context, statement: sx.Function) -> None:
    """Enter a function; report a name that is taken."""
    name = statement.name
    earlier = context.functions.get(name.text)
    if name.text not in ex.FUNCTIONS and earlier is None:
        context.functions[name.text] = statement
        return
    note = (earlier.name.span, "first declared here") if earlier is not None else None
    context.report("FZ201", f"there is a function '{name.text}' already", name.span, note=note, help="rename it")


def expanded(context: Context, expr: ex.Expr) -> ex.Expr | None:
    """Return an expression without calls of functions of the file; None where one of them has a mistake."""
    if not any(isinstance(part, ex.Call) and part.function in context.functions for part in ex.walk(expr)):
        return expr
    return _Expansion(context).expanded(expr, {})


def applied(context: Context, word: sx.Word, arguments: list[ex.Expr]) -> ex.Expr | None:
    """Return a function of the file at arguments: a variable, then its parameters."""
    count, due = len(arguments) - 1, len(context.functions[word.text].parameters) - 1
    if count != due:
        message = f"'{word.text}' takes {counted(due, 'parameter')} besides the variable, not {count}"
        names = ", ".join(p.text for p in context.functions[word.text].parameters[1:])
        context.report("FZ303", message, word.span, help=f"the form is: {word.text}({names})")
        return None
    return expanded(context, ex.Call(word.text, tuple(arguments), word.span))


class _Expansion:
    """Expands one expression."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self.path: list[str] = []
        self.parts = 0
        self.level = 0
        #: Whether it has been reported that the expression is too large.
        self.failed = False

    def expanded(self, expr: ex.Expr, names: Mapping[str, ex.Expr]) -> ex.Expr | None:
        """Return an expression with values for some names; None if a function has a mistake, which is reported."""
        value = names.get(expr.name, expr) if isinstance(expr, ex.Name) else expr
        if value is not expr or isinstance(expr, ex.Name):
            return value if self._is_small(value, expr) else None
        if not self._is_small(ex.ZERO, expr):
            return None
        self.level += 1
        parts = [self.expanded(part, names) for part in ex.children(expr)]
        self.level -= 1
        operands = [part for part in parts if part is not None]
        if len(operands) < len(parts):
            return None
        if isinstance(expr, ex.Call) and expr.function in self.context.functions:
            return self._applied(expr, operands)
        if self.path and self._is_clamp(expr):
            x, low, high = operands
            return ex.Call("min", (ex.Call("max", (x, low), ex.span_of(expr)), high), ex.span_of(expr))
        return ex.rebuilt(expr, operands) if operands else expr

    def _is_small(self, value: ex.Expr, place: ex.Expr) -> bool:
        """Count the parts of a value; report an expression that grows too large or too deep, once."""
        depth, level = 1, ex.children(value)
        self.parts += 1
        while level:
            depth += 1
            self.parts += len(level)
            level = tuple(part for node in level for part in ex.children(node))
        if self.parts <= MOST_PARTS and self.level + depth <= ex.MAX_DEPTH:
            return True
        if not self.failed:
            many = self.parts > MOST_PARTS
            code, what = ("FZ112", f"to more than {MOST_PARTS:,} parts") if many else ("FZ106", "too deep")
            message, help_text = f"the expression expands {what}", "give parts a name with 'let'"
            self.context.report(code, message, ex.span_of(place), help=help_text)
        self.failed = True
        return False

    def _applied(self, call: ex.Call, arguments: list[ex.Expr]) -> ex.Expr | None:
        context, function = self.context, self.context.functions[call.function]
        name, parameters = call.function, [p.text for p in function.parameters]
        if name in self.path:
            circle = " → ".join([*self.path[self.path.index(name) :], name])
            context.report(
                "FZ217",
                f"function '{name}' calls itself",
                function.name.span,
                facts=(circle,),
                help="remove one of these calls",
            )
            return None
        if len(arguments) != len(parameters):
            message = f"'{name}' takes {counted(len(parameters), 'argument')}, not {len(arguments)}"
            fix = with_decimal_points(call.span, len(arguments), len(parameters))
            context.report("FZ303", message, call.span, help=f"the form is: {name}({', '.join(parameters)})", fix=fix)
            return None
        if not self._is_sound(function, dict.fromkeys((*parameters, *context.params))):
            return None
        self.path.append(name)
        result = self.expanded(function.expression, dict(zip(parameters, arguments, strict=True)))
        self.path.pop()
        return result

    def _is_sound(self, function: sx.Function, known: Collection[str]) -> bool:
        """Check that a function uses its parameters and params only."""
        nodes = [n for n in ex.walk(function.expression) if not self._is_call(n)]
        return all([self._is_known(n, known) for n in nodes if isinstance(n, ex.Name | ex.Call)])

    def _is_call(self, node: ex.Expr) -> bool:
        return self._is_clamp(node) or (isinstance(node, ex.Call) and node.function in self.context.functions)

    @staticmethod
    def _is_clamp(node: ex.Expr) -> bool:
        """Return whether a part is a `clamp` of functions that controllers share."""
        return isinstance(node, ex.Call) and node.function == "clamp" and len(node.arguments) == 3

    def _is_known(self, node: ex.Expr, known: Collection[str]) -> bool:
        if isinstance(node, ex.Call):
            return self.context.check_call(node)
        return self.context.check_names(node, known, "parameter or param")
