"""Plants of one line: their arguments are checked and become linear equations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import ZERO, Expr, Name
from fuzzyctl.model.controller import Definition, Result, Signal
from fuzzyctl.model.forms import bound
from fuzzyctl.model.guarantee import Param
from fuzzyctl.model.params import ParamValues
from fuzzyctl.model.plant import PLANTS
from fuzzyctl.resolve.block_expressions import Expressions
from fuzzyctl.resolve.linear import LinearPlant, Root, is_finite, sections, times


def one_line_plant(names: Expressions, call: ex.Call, params: Sequence[Param]) -> dict[str, Any] | None:
    """Return the fields of the model of a plant of one line; None after a mistake, which is reported.

    Args:
        names: The names of the plant, and where mistakes are reported.
        call: Its form, with the right arguments.
        params: Its params.
    """
    given = bound(PLANTS[call.function], call)
    if call.function in ("python", "fmu"):
        file = given["file"]
        assert isinstance(file, ex.Text)
        return {call.function: file.text}
    work = _OneLine(names, call, ParamValues(params, partial=True))
    plant = {"tf": work.tf, "zpk": work.zpk, "ss": work.ss}[call.function](given)
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
        own: list[Signal | Definition] = [*plant.inputs, *plant.states, *plant.results, *plant.definitions]
        for name in (item.name for item in own if item.name in self.names.context.params):
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
        found = f"{counted(len(rows), 'row')} of {widths}"
        message = f"'{name}' has {found}, not {counted(high, 'row')} of {wide}"
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
