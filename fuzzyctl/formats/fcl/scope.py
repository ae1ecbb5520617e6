"""Scope of a function block: its names, and the values and functions that use them."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Final

from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.expr import CONSTANTS, FUNCTIONS, Binary, Call, Expr, ExprError, Name, Negate, Number, evaluate, span_of
from fuzzyctl.formats.common.translation import Translation
from fuzzyctl.formats.fcl.dialect import Dialect
from fuzzyctl.formats.fcl.syntax import Word
from fuzzyctl.formats.fll.formulas import ARGUMENTS, expanded

#: Functions of both tools under other names, by what they are here.
_SAME: Final = {"ln": "log", "fabs": "abs"}


class Scope(Translation):
    """The statements of a function block, what is declared in it, and what is wrong with it.

    Args:
        source: The file.
        dialect: The dialect of the file.

    Attributes:
        inputs: Names of VAR_INPUT.
        outputs: Names of VAR_OUTPUT.
        params: Values of the variables of VAR with a constant.
        readable: What functions may name where one is read, with the variable that it is.
        clamped_differences: Whether a difference of sigmoids is 0 where it is negative, as in jFuzzyLogic.
        empty_sets: First and last point of each term, of the variable that is read, which is 0 everywhere.
    """

    def __init__(self, source: SourceText, dialect: Dialect) -> None:
        super().__init__(source)
        self.dialect = dialect
        self.inputs: dict[str, Word] = {}
        self.outputs: dict[str, Word] = {}
        self.params: dict[str, float] = {}
        self.readable: dict[str, str] = {}
        self.clamped_differences = False
        self.empty_sets: list[tuple[float, float]] = []
        self._told: set[str] = set()

    def spelt(self, name: str, known: Collection[str], span: Span) -> str | None:
        """Return a declared name, found by its letters where only capitals differ, as the standard allows."""
        if name in known:
            return name
        alike = [n for n in known if n.lower() == name.lower()]
        if len(alike) != 1:
            return None
        if name not in self._told:
            self._told.add(name)
            message = f"'{name}' is taken for '{alike[0]}'"
            self.warning("FZ604", message, span, help="tools that mind capitals do not know it")
        return alike[0]

    def constant(self, expr: Expr, what: str) -> Expr | None:
        """Return a parameter that is a number or a constant; None, with an error, for any other."""
        if isinstance(expr, Number):
            if not math.isnan(expr.value):
                return expr
            self.error("FZ302", f"{what} is not a number", expr.span)
            return None
        if not isinstance(expr, Name) or expr.name in self.params:
            return expr
        help_text = "write a number, or declare it in a VAR block with ':= value'"
        if expr.name in self.inputs or expr.name in self.outputs:
            if expr.name not in self._told:
                self._told.add(expr.name)
                kind = "input" if expr.name in self.inputs else "output"
                changes = "so the term would change with it; that is not available"
                self.error("FZ602", f"{what} is the {kind} '{expr.name}', {changes}", expr.span, help=help_text)
            return None
        facts = (f"constants: {listed(self.params)}",) if self.params else ()
        help_text = did_you_mean(expr.name, [*self.params]) or help_text
        self.error("FZ202", f"'{expr.name}' is no number and not declared", expr.span, facts=facts, help=help_text)
        return None

    def value(self, expr: Expr) -> float | None:
        """Return the finite value of a parameter, None where it has none."""
        try:
            value = evaluate(expr, self.params)
        except ExprError:
            return None
        return value if math.isfinite(value) else None

    def function(self, expr: Expr) -> Expr | None:
        """Return an expression over inputs and constants with the functions called as here; None with an error."""
        match expr:
            case Name():
                return self._variable(expr)
            case Number(value=value, span=span):
                return expr if math.isfinite(value) else self._refused("a number of a function is not finite", span)
            case Negate(operand=operand, span=span):
                inner = self.function(operand)
                return None if inner is None else Negate(inner, span)
            case Binary(op=op, left=left, right=right, span=span):
                first, second = self.function(left), self.function(right)
                return None if first is None or second is None else Binary(op, first, second, span)
            case Call():
                return self._call(expr)
        return self._refused("this is no expression", span_of(expr))

    def _refused(self, message: str, span: Span | None, **more: object) -> Expr | None:
        self.error("FZ602", message, span, **more)
        return None

    def _variable(self, name: Name) -> Expr | None:
        if name.name in self.readable:
            return Name(self.readable[name.name], name.span)
        if name.name in self.params:
            return name
        if name.name in self.outputs:
            message = f"a function of the output '{name.name}', which is not declared before, is not available"
            return self._refused(message, name.span)
        alike = [n for n in self.readable if n.lower() == name.name.lower()]
        if len(alike) == 1:
            return Name(self.readable[alike[0]], name.span)
        if name.name.lower() in CONSTANTS:
            return Number(CONSTANTS[name.name.lower()], "", name.span)
        known = [*self.readable, *self.params]
        facts, help_text = (f"known: {listed(known)}",), did_you_mean(name.name, known)
        self.error("FZ202", f"no variable '{name.name}'", name.span, facts=facts, help=help_text)
        return None

    def _call(self, call: Call) -> Expr | None:
        arguments = [self.function(a) for a in call.arguments]
        if any(a is None for a in arguments):
            return None
        given = tuple(a for a in arguments if a is not None)
        name = _SAME.get(call.function, call.function)
        if name == "%":
            if self.dialect.name != "fuzzylite":
                return self._refused("the remainder '%' is not available", call.span)
            name = "fmod"
        # LOG is the logarithm to the base 10 in jFuzzyLogic, the natural one in fuzzylite.
        if call.function == "log" and self.dialect.name != "fuzzylite":
            name = "log10"
        least, most = (ARGUMENTS[name],) * 2 if name in ARGUMENTS else FUNCTIONS.get(name, (0, -1))
        if name not in FUNCTIONS and name not in ARGUMENTS:
            known = listed(sorted({*FUNCTIONS, *ARGUMENTS}))
            message = f"the function '{call.function}' is not available"
            return self._refused(message, call.span, facts=(f"functions: {known}",))
        if len(given) < least or (most is not None and len(given) > most):
            self.error("FZ303", f"'{call.function}' does not take {len(given)} arguments", call.span)
            return None
        found = expanded(name, given) if name in ARGUMENTS else Call(name, given, call.span)
        return self._refused("the function is too long", call.span) if found is None else found
