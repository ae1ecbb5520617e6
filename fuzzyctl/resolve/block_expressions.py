"""Expressions of controllers, plants and loops: known names, conditions and numbers, calls with their arguments."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from typing import Any, Final

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.fixes import Fix, Replacement, respelt_as_suggested
from fuzzyctl.diagnostics.suggestions import a_or_an, counted, did_you_mean, listed
from fuzzyctl.model.controller import EquationBlock
from fuzzyctl.model.forms import NEEDED, Form
from fuzzyctl.model.loop import MEASURES, SIGNALS
from fuzzyctl.model.stateful_operators import OPERATORS
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.resolve.block_names import CALLED, FUNCTIONS, Names

#: Checks a part of an expression, as a condition, as a number, or as either where that is None.
Inner = Callable[..., bool]

#: Names that functions of a block may use.
PARAMETERS: Final = "parameter or param"

#: Descriptions of arguments that only some functions take.
_ODD = {ex.Items: "a list", ex.Text: "a text", ex.Pair: "a pair 'a: b'"}


class Expressions(Names):
    """Checks of the expressions of a block."""

    def own_call(self, call: ex.Call, inner: Inner, *, pure: bool) -> bool:
        """Check a call of a function that only such blocks have."""
        raise NotImplementedError

    def elsewhere(self, call: ex.Call) -> str:
        """Return what to do in place of calling a function that only other blocks have; empty for no such function."""
        return ""

    def instead_of(self, name: str, kind: str) -> str:
        """Return what to write in place of a name of the block where another kind is expected; empty for nothing."""
        return ""

    def formula(
        self,
        expr: ex.Expr,
        *,
        truth: bool | None = None,
        names: Set[str] | None = None,
        kind: str = "name",
        pure: bool = False,
    ) -> bool:
        """Check an expression.

        Args:
            expr: The expression.
            truth: Whether a condition is expected, or a number; None for either.
            names: The names that it may use; None for all of the block.
            kind: What these are.
            pure: Whether calls that have a state are refused.
        """

        def inner(part: ex.Expr, truth: bool | None = False) -> bool:
            return self.formula(part, truth=truth, names=names, kind=kind, pure=pure)

        match expr:
            case ex.Compare(left=left, right=right):
                return all([inner(left), inner(right), self._fits(expr, truth)])
            case ex.Logic(operands=operands):
                return all([*(inner(o, True) for o in operands), self._fits(expr, truth)])
            case ex.Name():
                return self._name(expr, names, kind) and self._fits(expr, truth, named=kind != PARAMETERS)
            case ex.Call():
                return self._call(expr, inner, pure=pure) and self._fits(expr, truth)
            case ex.Keyword(name=name, span=span):
                self.context.report("FZ303", f"unexpected named argument '{name}'", span, help="write the value alone")
                return False
            case ex.Items() | ex.Text() | ex.Pair():
                self.context.report(
                    "FZ303", f"expected a number, found {_ODD[type(expr)]}", expr.span, help="write one number"
                )
                return False
        return all([inner(part) for part in ex.children(expr)]) and self._fits(expr, truth)

    def constant(self, expr: ex.Expr) -> bool:
        """Check an expression that may use params only."""
        return self.formula(expr, truth=False, names=self.context.params.keys(), kind="param", pure=True)

    def _name(self, expr: ex.Name, names: Set[str] | None, kind: str) -> bool:
        name = expr.name
        scope = self.names if names is None else names
        if name.partition(".")[0] in self.lost:
            return False
        if name not in scope and name not in ex.CONSTANTS:
            if help_text := self.instead_of(name, kind) if name in self.names else "":
                self.context.report("FZ202", f"no {kind} '{name}'", expr.span, help=help_text)
            else:
                self.context.unknown(kind, expr, self.ordered(scope))
            return False
        if outputs := self.members.get(name):
            message = f"'{name}' has several outputs" if len(outputs) > 1 else f"'{name}' is a block, not a value"
            self.context.report("FZ214", message, expr.span, help=f"write one of: {listed(outputs)}")
            return False
        return True

    def _fits(self, expr: ex.Expr, truth: bool | None, *, named: bool = True) -> bool:
        """Check that an expression is a condition or a number; one that has a name, or is called, may be both."""
        if truth and not (named and self.context.is_condition(expr)):
            self.context.no_condition(expr)
            return False
        if truth is False and isinstance(expr, ex.Compare | ex.Logic):
            number, span = f"where({ex.to_text(expr)}, 1, 0)", expr.span
            fix = None if span is None else Fix((Replacement(span, number),), "likely")
            message = "expected a number, found a condition"
            self.context.report("FZ307", message, span, help=f"write {number}", fix=fix)
            return False
        return True

    def _call(self, call: ex.Call, inner: Inner, *, pure: bool) -> bool:
        function, arguments = call.function, call.arguments
        if function == "where" and len(arguments) == 3:
            return all([inner(arguments[0], True), inner(arguments[1]), inner(arguments[2])])
        if function in FUNCTIONS:
            return self._counted(call, FUNCTIONS[function]) and all([inner(a) for a in arguments])
        functions = self.context.functions
        if function in functions:
            return self._counted(call, [p.text for p in functions[function].parameters]) and all(
                [inner(a) for a in arguments]
            )
        if function in self.own:
            return self.own_call(call, inner, pure=pure)
        if function in ex.FUNCTIONS:
            return self.context.check_call(call) and all([inner(a) for a in arguments])
        block: Any = self.found(function)
        if block is not None and block.is_function:
            return self._system(call, block, inner, pure=pure)
        if block is not None:
            self._refuse_block(call, block)
        else:
            self.unknown_call(call, "function or system", [*ex.FUNCTIONS, *FUNCTIONS, *self.own, *functions])
        return False

    def _system(self, call: ex.Call, system: FuzzySystem, inner: Inner, *, pure: bool) -> bool:
        if (pure or self.kind != "controller") and system.keeps_state:
            return self.refuse_state(call)
        return self.arguments(call, [i.name for i in system.inputs], [p.name for p in system.params], inner)

    def _refuse_block(self, call: ex.Call, block: EquationBlock) -> None:
        what = block.kind
        help_text = f"give it a name: block NAME = {ex.to_text(call)}"
        if self.kind == "plant" or (self.kind == "controller" and what == "plant"):
            help_text = f"add both as blocks of a loop: block NAME = {ex.to_text(call)}"
        message = f"'{call.function}' is {a_or_an(what)}, which has a state of its own"
        self.context.report("FZ214", message, call.span, help=help_text)

    def refuse_state(self, call: ex.Call) -> bool:
        """Report a call with a state in a place that cannot keep one."""
        if self.kind == "controller":
            message = f"'{call.function}' keeps a state, which only 'let', 'next', 'output' and 'block' lines may have"
            help_text = "give it a name with 'let', and pass that name on"
        else:
            message = f"'{call.function}' keeps a state from one sample to the next, which only controllers have"
            help_text = "call it in a controller"
        self.context.report("FZ214", message, call.span, help=help_text)
        return False

    def unknown_call(self, call: ex.Call, what: str, known: Sequence[str]) -> None:
        """Report a call of an unknown name."""
        context = self.context
        is_lost = call.function in context.unread or call.function in context.broken
        if call.function in context.broken and (call.function in self.own or call.function in OPERATORS):
            message = f"'{call.function}' is a function of {self.kind}s, and a block has the same name"
            context.report("FZ201", message, call.span, help="rename the block")
            return
        if is_lost or not context.nameless.isdisjoint(CALLED):
            return
        other = self.elsewhere(call)
        if other:
            owner = _owner(call.function)
            self.context.report("FZ214", f"'{call.function}' belongs to {owner}", call.span, help=other)
            return
        system, _, output = call.function.partition(".")
        called = self.found(system) if output else None
        if called is not None and called.is_function:
            # In a system the same call is written with its output.
            several = f"let NAME = {system}(...)' and read 'NAME.{output}"
            form = several if len(called.outputs) > 1 else f"{system}(...)"
            self.context.report("FZ202", f"no {what} '{call.function}'", call.span, help=f"write '{form}'")
            return
        facts = [f"functions: {', '.join(known)}"] if known else []
        callees = self.context.callees()
        for kind in what.split(" or "):
            names = sorted(n for n, k in callees.items() if k == kind)
            facts += [f"{kind}s: {listed(names)}"] if names else []
            known = [*known, *names]
        near = did_you_mean(call.function, known)
        kinds = what.replace("or system", "or a system")
        help_text = near or f"declare a {kinds} of that name, or 'use' a file that does"
        fix = respelt_as_suggested(call.span, call.function, known)
        self.context.report(
            "FZ202", f"no {what} '{call.function}'", call.span, facts=tuple(facts), help=help_text, fix=fix
        )

    def _counted(self, call: ex.Call, expected: Sequence[str]) -> bool:
        named = next((a for a in call.arguments if isinstance(a, ex.Keyword)), None)
        if named is not None:
            message = f"'{call.function}' takes its arguments by position"
            self.context.report("FZ303", message, named.span, help="write the value alone")
            return False
        if len(call.arguments) == len(expected):
            return True
        message = f"'{call.function}' takes {counted(len(expected), 'argument')}, not {len(call.arguments)}"
        help_text = f"the form is: {call.function}({', '.join(expected)})"
        self.context.report("FZ303", message, call.span, help=help_text)
        return False

    def arguments(self, call: ex.Call, inputs: Sequence[str], params: Sequence[str], inner: Inner) -> bool:
        """Check the arguments of a block: its inputs in order or by name, its params by name."""
        positional = [a for a in call.arguments if not isinstance(a, ex.Keyword)]
        form = f"the form is: {call.function}({', '.join(inputs)})"
        fine = True
        bound = set(inputs[: len(positional)])
        if len(positional) > len(inputs):
            message = f"'{call.function}' takes {counted(len(inputs), 'input')}, not {len(positional)}"
            self.context.report("FZ303", message, call.span, help=form)
            fine = False
        for argument in call.arguments:
            if not isinstance(argument, ex.Keyword):
                fine = inner(argument, truth=False) and fine
            elif argument.name in bound:
                self.context.report(
                    "FZ303", f"argument '{argument.name}' is given twice", argument.span, help="remove one of them"
                )
                fine = False
            elif argument.name in inputs:
                fine = inner(argument.value, truth=False) and fine
            elif argument.name in params:
                fine = self.context.check_names(argument.value, self.context.params, "param") and fine
            else:
                names = [*inputs, *params]
                facts = (f"inputs: {', '.join(inputs)}", *((f"params: {', '.join(params)}",) if params else ()))
                message = f"'{call.function}' has no input or param '{argument.name}'"
                help_text = did_you_mean(argument.name, names)
                fix = respelt_as_suggested(argument.span, argument.name, names)
                self.context.report("FZ202", message, argument.span, facts=facts, help=help_text, fix=fix)
                fine = False
            if isinstance(argument, ex.Keyword):
                bound.add(argument.name)
        missing = [name for name in inputs if name not in bound]
        if fine and missing:
            message = f"'{call.function}' lacks a value for: {', '.join(missing)}"
            self.context.report("FZ303", message, call.span, help=form)
        return fine and not missing

    def form(self, call: ex.Call, forms: Mapping[str, Form], inner: Inner) -> bool:
        """Check a call of a function with named arguments: its signals by `inner`, its settings over params only."""
        form = forms[call.function]
        positional = [a for a in call.arguments if not isinstance(a, ex.Keyword)]
        bound = dict(zip(form.names, positional, strict=False))
        fine = len(positional) <= len(form.names) and not form.pairs
        for argument in call.arguments:
            if isinstance(argument, ex.Keyword):
                fine = fine and argument.name in form.names and argument.name not in bound
                bound[argument.name] = argument.value
        needed = [*form.signals, *(n for n, default in form.settings.items() if default is NEEDED)]
        if not fine or not set(needed) <= bound.keys():
            return self._wrong_arguments(call, form)
        return all([self._argument(name, value, call, form, inner) for name, value in bound.items()])

    def _argument(self, name: str, value: ex.Expr, call: ex.Call, form: Form, inner: Inner) -> bool:
        if name in form.texts or name in form.lists:
            expected = ex.Text if name in form.texts else ex.Items
            if not isinstance(value, expected):
                message = f"expected {_ODD[expected]} for '{name}'"
                span = ex.span_of(value) or call.span
                self.context.report("FZ303", message, span, help=f"the form is: {form.form}")
                return False
            return True
        return inner(value, truth=False) if name in form.signals else self.constant(value)

    def _wrong_arguments(self, call: ex.Call, form: Form) -> bool:
        help_text = f"the form is: {form.form}"
        self.context.report("FZ303", f"wrong arguments of '{call.function}'", call.span, help=help_text)
        return False


def _owner(function: str) -> str:
    """Return the blocks that have a function."""
    if function in OPERATORS:
        return "controllers"
    if function in MEASURES and function not in SIGNALS:
        return "'measure' lines of loops"
    return "loops" if function in SIGNALS else "plants of one line"
