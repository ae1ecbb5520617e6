"""Resolution of a controller: names, calls and statements that belong together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.block import Guarantee, Node
from fuzzyctl.model.checks.checks import in_order
from fuzzyctl.model.controller import Controller, Instance
from fuzzyctl.model.stateful_operators import OPERATORS
from fuzzyctl.resolve.block_expressions import Inner
from fuzzyctl.resolve.block_names import Find
from fuzzyctl.resolve.block_statements import Statements
from fuzzyctl.resolve.context import Context
from fuzzyctl.resolve.rules import resolve_claim

#: Names that a controller has without declaring them: the time since the step before [s].
GIVEN: Final = ("dt",)


def resolve_controller(
    statements: Sequence[sx.Statement], head: sx.Head, find: Find, context: Context, *, path: str
) -> tuple[Controller, bool, list[Diagnostic]]:
    """Give the statements of a controller their meaning.

    Args:
        statements: Its own, and those that it shares with other blocks of the file.
        head: The `controller` line.
        find: Finds the systems and controllers that it names.
        context: Facts of lines that could not be read; collects mistakes.
        path: The file.

    Returns:
        The controller, without the parts that have no meaning; whether it has such parts; and the diagnostics in order
        of their locations.
    """
    work = _Controller(context, head, find)
    work.declare(statements)
    controller = work.build(statements, path)
    return controller, work.incomplete, in_order(work.context.diagnostics)


class _Controller(Statements):
    kind = "controller"
    given = GIVEN
    own = reserved = OPERATORS.keys()

    def build(self, statements: Sequence[sx.Statement], path: str) -> Controller:
        """Resolve the statements; those without a meaning are reported and left out."""
        parts = self.parts(statements)
        period = None
        for s in statements:
            period = self._period(s, period) if isinstance(s, sx.Every) else period
        claims = [self._require(s) for s in statements if isinstance(s, sx.Require)]
        self.incomplete = self.incomplete or None in claims
        self.require_updates(statements, "next", "next value")
        self.require_outputs(statements)
        return Controller(
            **self.shared_fields(statements, parts),
            updates=parts.get("next", ()),
            instances=parts.get("block", ()),
            period=period,
            path=path,
            guarantees=tuple(c for c in claims if c is not None),
        )

    def _require(self, s: sx.Require) -> Guarantee | None:
        if not isinstance(s, sx.Always):
            return resolve_claim(self.context, s, self.formula)
        message = "'always' belongs to loops: a claim of a controller is about each step"
        self.context.report("FZ214", message, s.span, help="remove 'always' and the times behind the claim")
        return None

    def equation(self, s: sx.Equation) -> Node | None:
        return self._instance(s) if s.keyword.text == "block" else super().equation(s)

    def _instance(self, s: sx.Equation) -> Instance | None:
        form = f"block {s.name.text} = CONTROLLER(input, ..., param=value)"
        if not isinstance(s.value, ex.Call):
            self.context.report(
                "FZ214", "expected a call of a controller", ex.span_of(s.value), help=f"the form is: {form}"
            )
            return None
        block = self.found(s.value.function)
        if block is not None and block.kind != "controller":
            help_text = f"write: let {s.name.text} = {ex.to_text(s.value)}"
            if block.kind == "plant":
                help_text = "add the controller and the plant as blocks of a loop"
            message = f"'{block.name}' is a {block.kind}, and 'block' takes a controller"
            self.context.report("FZ214", message, s.value.span, help=help_text)
            return None
        if block is None:
            self.unknown_call(s.value, "controller", ())
            return None
        if not self.arguments(s.value, [i.name for i in block.inputs], [p.name for p in block.params], self.formula):
            return None
        return Instance(name=s.name.text, controller=block.name, arguments=s.value.arguments, span=s.name.span)

    def _period(self, s: sx.Every, period: ex.Expr | None) -> ex.Expr | None:
        if period is not None:
            self.context.report("FZ215", "'every' is given twice", s.span, help="remove one of them")
        return s.period if self.context.check_names(s.period, self.context.params, "param") else period

    def own_call(self, call: ex.Call, inner: Inner, *, pure: bool) -> bool:
        operator = OPERATORS[call.function]
        if pure:
            return self.refuse_state(call)
        positional = [a for a in call.arguments if not isinstance(a, ex.Keyword)]
        settings = dict(zip(operator.settings, positional[1:], strict=False))
        fine = bool(positional) and len(positional) <= 1 + len(operator.settings)
        for argument in call.arguments:
            if isinstance(argument, ex.Keyword):
                fine = fine and argument.name in operator.settings and argument.name not in settings
                settings[argument.name] = argument.value
        if not fine or len([s for s in operator.settings[: operator.needed] if s in settings]) < operator.needed:
            help_text = f"the form is: {operator.form}"
            self.context.report("FZ303", f"wrong arguments of '{call.function}'", call.span, help=help_text)
            return False
        checks = [inner(positional[0])]
        for name, value in settings.items():
            if name in ("start", "samples"):
                checks.append(self.context.check_names(value, self.context.params, "param"))
            else:
                checks.append(inner(value, name == "hold"))
        return all(checks)
