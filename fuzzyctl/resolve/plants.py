"""Resolution of a plant: differential equations, or a form of one line."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.fixes import respelt_as_suggested
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted, did_you_mean
from fuzzyctl.expr import ZERO, Expr, Name
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.block import Param, ParamValues
from fuzzyctl.model.checks.checks import in_order
from fuzzyctl.model.controller import Definition, Result, Signal
from fuzzyctl.model.forms import bound
from fuzzyctl.model.loop import MEASURES, SIGNALS, TIME
from fuzzyctl.model.plant import PLANT_FUNCTIONS, PLANTS, Plant
from fuzzyctl.model.stateful_operators import OPERATORS
from fuzzyctl.resolve.block_expressions import Expressions, Inner
from fuzzyctl.resolve.block_names import Find
from fuzzyctl.resolve.block_statements import Statements
from fuzzyctl.resolve.context import Context
from fuzzyctl.resolve.linear import LinearPlant, Root, is_finite, sections, times


def one_line_plant(names: Expressions, call: ex.Call, params: Sequence[Param]) -> dict[str, Any] | None:
    """Return the fields of the model of a plant of one line; None after a mistake, which is reported.

    Args:
        names: The names of the plant, and where mistakes are reported.
        call: Its form, with the right arguments.
        params: Its params.
    """
    arguments = bound(PLANTS[call.function], call)
    if call.function in ("python", "fmu"):
        file = arguments["file"]
        assert isinstance(file, ex.Text)
        return {call.function: file.text}
    work = _OneLine(names, call, ParamValues(params, partial=True))
    plant = {"tf": work.tf, "zpk": work.zpk, "ss": work.ss}[call.function](arguments)
    return None if plant is None else work.fields(plant)


class _OneLine:
    def __init__(self, names: Expressions, call: ex.Call, values: ParamValues) -> None:
        self.names, self.call, self.values = names, call, values

    def report(self, code: str, message: str, span: Span | None, **rest: Any) -> None:
        self.names.context.report(code, message, span or self.call.span, **rest)

    def _constant(self, expr: Expr) -> bool:
        """Check an expression over params, and that it has a value."""
        return self.names.constant(expr) and self._has_value(expr)

    def _has_value(self, expr: Expr) -> bool:
        try:
            ex.evaluate(expr, self.values.values)
        except ex.ExprError as error:
            if not self.values.lacks(expr):
                self.report("FZ307", error.message, error.span, help=error.help)
            return False
        return True

    def fields(self, plant: LinearPlant) -> dict[str, Any] | None:
        """Return the fields of the model, after the checks of their names and numbers."""
        declarations: list[Signal | Definition] = [*plant.inputs, *plant.states, *plant.results, *plant.definitions]
        for name in (item.name for item in declarations if item.name in self.names.context.params):
            message = f"'{name}' is a name of the plant itself and cannot name a param"
            self.report("FZ201", message, self.names.context.params[name].name.span, help="rename it")
            return None
        equations: list[Definition | Result] = [*plant.definitions, *plant.derivatives, *plant.results]
        if not all(is_finite(e.value) for e in equations):
            self.report("FZ307", "the coefficients are too large or too small", None, help="scale them")
            return None
        fields = ("inputs", "states", "definitions", "results", "derivatives")
        return {name: tuple(getattr(plant, name)) for name in fields}

    def tf(self, given: dict[str, Expr]) -> LinearPlant | None:
        num, den = self._coefficients("num", given["num"]), self._coefficients("den", given["den"])
        if num is None or den is None:
            return None
        if len(num) > len(den):
            self._improper("numerator", len(num) - 1, "denominator", len(den) - 1, given["num"])
            return None
        plant = LinearPlant(self.values)
        (u,) = plant.takes(["u"], given["delay"])
        plant.gives("y", plant.fraction(num, den, u))
        return plant

    def _improper(self, above: str, most: int, below: str, least: int, place: Expr) -> None:
        message = f"the transfer function is not proper: its {above} has order {most}, its {below} {least}"
        facts = ("a plant that differentiates its input answers a step with an impulse",)
        help_text = "add the fast poles that the plant has, or remove zeros"
        self.report("FZ221", message, ex.span_of(place), facts=facts, help=help_text)

    def _coefficients(self, name: str, items: Expr) -> list[Expr] | None:
        """Return the coefficients of a polynomial that does not begin with 0."""
        assert isinstance(items, ex.Items)
        if not items.items:
            self.report("FZ303", f"'{name}' is empty", items.span, help=f"the form is: {PLANTS['tf'].form}")
            return None
        if not all([self._constant(c) for c in items.items]):
            return None
        if self.values.of(items.items[0]) == 0:
            message = f"the leading coefficient of '{name}' is 0"
            facts = ("coefficients begin with that of the highest power",)
            help_text = "remove it" if len(items.items) > 1 else "write another number"
            self.report("FZ302", message, ex.span_of(items.items[0]), facts=facts, help=help_text)
            return None
        return list(items.items)

    def zpk(self, given: dict[str, Expr]) -> LinearPlant | None:
        zeros, poles = self._roots(given["zeros"]), self._roots(given["poles"])
        if not self._has_value(given["gain"]) or zeros is None or poles is None:
            return None
        above, below = (sum(map(len, roots)) for roots in (zeros, poles))
        if above > below:
            self._improper("list of zeros", above, "list of poles", below, given["zeros"])
            return None
        plant = LinearPlant(self.values)
        (value,) = plant.takes(["u"], given["delay"])
        for number, (num, den) in enumerate(sections(zeros, poles), start=1):
            section = plant.fraction(num, den, value)
            value = plant.defines(f"section{number}", section)
        plant.gives("y", times(given["gain"], value))
        return plant

    def _roots(self, items: Expr) -> list[Root] | None:
        assert isinstance(items, ex.Items)
        roots: list[Root] = []
        fine = True
        for item in items.items:
            if isinstance(item, ex.Call) and item.function == "pair":
                fine = self._is_pair(item) and fine
                roots.append((item.arguments[0], item.arguments[-1]) if item.arguments else (ZERO, ZERO))
            else:
                fine = self._constant(item) and fine
                roots.append((item,))
        return roots if fine else None

    def _is_pair(self, pair: ex.Call) -> bool:
        if len(pair.arguments) != 2:
            message = f"'pair' takes 2 arguments, not {len(pair.arguments)}"
            help_text = "the form is: pair(real part, imaginary part)"
            self.report("FZ303", message, pair.span, help=help_text)
            return False
        return all([self._constant(a) for a in pair.arguments])

    def ss(self, given: dict[str, Expr]) -> LinearPlant | None:
        rows = {name: self._matrix(name, given[name]) for name in "ABCD"}
        a, b, c, d = (rows[name] for name in "ABCD")
        if a is None or b is None or c is None or d is None or not self._fits("A", a, len(a), len(a), given):
            return None
        order = len(a)
        b = _upright(b) if _is_flat(given["B"]) and order != 1 else b
        count, outputs = len(b[0]) if b and b[0] else 1, len(c)
        d = _upright(d) if _is_flat(given["D"]) and outputs != 1 else d
        d = d or [[ZERO] * count for _ in range(outputs)]
        sizes = {"B": (b, order, count), "C": (c, outputs, order), "D": (d, outputs, count)}
        if not all([self._fits(name, *size, given) for name, size in sizes.items()]):
            return None
        plant = LinearPlant(self.values)
        inputs = plant.takes(_numbered("u", count), given["delay"])
        states: list[Expr] = [Name(plant.state(k + 1)) for k in range(order)]
        for of_states, of_inputs in zip(a, b, strict=True):
            plant.adds(plant.total([*zip(of_states, states, strict=True), *zip(of_inputs, inputs, strict=True)]))
        for name, of_states, of_inputs in zip(_numbered("y", outputs), c, d, strict=True):
            plant.gives(name, plant.total([*zip(of_states, states, strict=True), *zip(of_inputs, inputs, strict=True)]))
        return plant

    def _matrix(self, name: str, items: Expr) -> list[list[Expr]] | None:
        """Return the rows of a matrix, one for a flat list; none for one that is left out."""
        if not isinstance(items, ex.Items):
            return []
        flat = [item for item in items.items if not isinstance(item, ex.Items)]
        rows = [list(item.items) for item in items.items if isinstance(item, ex.Items)]
        if not items.items or (flat and rows):
            message = f"'{name}' is empty" if not items.items else f"'{name}' mixes rows and numbers"
            self.report("FZ303", message, items.span, help=f"the form is: {PLANTS['ss'].form}")
            return None
        rows = [flat] if flat else rows
        return rows if all([self._constant(e) for row in rows for e in row]) else None

    def _fits(self, name: str, rows: list[list[Expr]], high: int, wide: int, given: dict[str, Expr]) -> bool:
        if len(rows) == high and all(len(row) == wide for row in rows):
            return True
        widths = " and ".join(str(w) for w in dict.fromkeys(map(len, rows)))
        size = f"{counted(len(rows), 'row')} of {widths}"
        message = f"'{name}' has {size}, not {counted(high, 'row')} of {wide}"
        facts = ("A is n x n, B n x inputs, C outputs x n, D outputs x inputs",)
        self.report("FZ222", message, ex.span_of(given[name]), facts=facts, help="give each row its entries")
        return False


def _is_flat(items: Expr) -> bool:
    return isinstance(items, ex.Items) and not any(isinstance(item, ex.Items) for item in items.items)


def _upright(rows: list[list[Expr]]) -> list[list[Expr]]:
    """Return a flat list as a column."""
    return [[entry] for entry in rows[0]]


def _numbered(name: str, count: int) -> list[str]:
    return [name] if count == 1 else [f"{name}{k + 1}" for k in range(count)]


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
        result = None
        if self.form(formula, PLANTS, self.constant):
            result = one_line_plant(self, formula, params)
        self.incomplete = self.incomplete or result is None
        return result or {}

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


#: The replacement of an operator of controllers in a plant.
_IN_PLANTS = {
    "previous": "use a state, or delay(x, 0.1 s)",
    "difference": "use a state and its derivative",
    "derivative": "use a state: the right side of its 'der' line is its derivative",
    "integral": "write a state with its derivative: state s = 0, der s = x",
    "lowpass": "write a state with its derivative: state s = 0, der s = (x - s) / time",
    "rate_limit": "write a state with its derivative: state s = 0, der s = clamp((x - s) / time, -rate, rate)",
}
