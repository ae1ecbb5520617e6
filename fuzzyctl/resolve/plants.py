"""Resolution of a plant: differential equations, or a form of one line."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.fixes import respelt_as_suggested
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.checks.checks import in_order
from fuzzyctl.model.loop import MEASURES, SIGNALS, TIME
from fuzzyctl.model.plant import PLANT_FUNCTIONS, PLANTS, Plant
from fuzzyctl.model.stateful_operators import OPERATORS
from fuzzyctl.resolve.block_expressions import Inner
from fuzzyctl.resolve.block_names import Find
from fuzzyctl.resolve.block_statements import Statements
from fuzzyctl.resolve.context import Context
from fuzzyctl.resolve.one_line_plants import one_line_plant


def resolve_plant(
    statements: Sequence[sx.Statement], head: sx.Head, find: Find, context: Context, *, path: str
) -> tuple[Plant, bool, list[Diagnostic]]:
    """Give the statements of a plant their meaning; as `resolve_controller`."""
    work = _Plant(context, head, find)
    work.declare(statements)
    plant = work.build(statements, path)
    return plant, work.incomplete, in_order(work.context.diagnostics)


class _Plant(Statements):
    kind = "plant"
    given = (TIME,)
    own = PLANT_FUNCTIONS.keys()

    def build(self, statements: Sequence[sx.Statement], path: str) -> Plant:
        """Resolve the statements; those without a meaning are reported and left out."""
        parts = self.parts(statements)
        fields = self.shared_fields(statements, parts)
        if self.head.formula is not None:
            self._refuse_statements(statements)
            fields |= self._one_line(self.head.formula, fields["params"])
        else:
            self.require_updates(statements, "der", "derivative")
            self.require_outputs(statements)
            fields["derivatives"] = parts.get("der", ())
        return Plant(**fields, path=path)

    def _refuse_statements(self, statements: Sequence[sx.Statement]) -> None:
        """Report statements that a plant of one line does not have."""
        for s in statements:
            if isinstance(s, sx.Signal | sx.Equation):
                message = f"'{s.keyword.text}' does not go with a plant of one line, which is complete"
                help_text = "remove it, or write the plant with 'state' and 'der' lines"
                self.context.report("FZ214", message, s.keyword.span, help=help_text)

    def _one_line(self, formula: ex.Expr, params: Sequence[Any]) -> dict[str, Any]:
        forms = "; ".join(form.form for form in PLANTS.values())
        if not isinstance(formula, ex.Call) or formula.function not in PLANTS:
            name = formula.function if isinstance(formula, ex.Call) else ""
            help_text = did_you_mean(name, list(PLANTS)) or f"the forms are: {forms}"
            message = "expected tf, zpk, ss, python or fmu"
            fix = respelt_as_suggested(ex.span_of(formula), name, list(PLANTS))
            self.context.report("FZ214", message, ex.span_of(formula), help=help_text, fix=fix)
            self.incomplete = True
            return {}
        found = None
        if self.form(formula, PLANTS, self.constant):
            found = one_line_plant(self, formula, params)
        self.incomplete = self.incomplete or found is None
        return found or {}

    def own_call(self, call: ex.Call, inner: Inner, *, pure: bool) -> bool:
        if pure:
            message = f"'{call.function}' keeps past values, which only 'let', 'der' and 'output' lines may have"
            self.context.report("FZ214", message, call.span, help="give it a name with 'let'")
            return False
        return self.form(call, PLANT_FUNCTIONS, inner)

    def elsewhere(self, call: ex.Call) -> str:
        if call.function in OPERATORS:
            return f"a plant is continuous: {_IN_PLANTS.get(call.function, 'call it in a controller')}"
        if call.function in SIGNALS or call.function in MEASURES:
            return "add an input, and connect the signal in a loop"
        return "write it as: plant NAME = " + PLANTS[call.function].form if call.function in PLANTS else ""


#: What a plant has in place of an operator of controllers.
_IN_PLANTS = {
    "previous": "use a state, or delay(x, 0.1 s)",
    "difference": "use a state and its derivative",
    "derivative": "use a state: the right side of its 'der' line is its derivative",
    "integral": "write a state with its derivative: state s = 0, der s = x",
    "lowpass": "write a state with its derivative: state s = 0, der s = (x - s) / time",
    "rate_limit": "write a state with its derivative: state s = 0, der s = clamp((x - s) / time, -rate, rate)",
}
