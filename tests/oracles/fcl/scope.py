"""Scope of a function block: its names, and the values and functions that use them."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import did_you_mean, listed
from fuzzyctl.expr import CONSTANTS, FUNCTIONS, Binary, Call, Expr, ExprError, Name, Negate, Number, evaluate, span_of
from fuzzyctl.formats.fll.formulas import ARGUMENTS, expanded
from fuzzyctl.model.block import Param, ParamValues
from tests.oracles.fcl.dialect import Dialect
from tests.oracles.fcl.syntax import Word
from tests.oracles.reporter import Reporter

#: Functions of both tools under other names, by what they are here.
_SAME: Final = {"ln": "log", "fabs": "abs"}


@dataclass
class Scope(Reporter):
    """What is declared in a function block, and what was found wrong in it.

    Args:
        dialect: The dialect of the file.
        inputs: Names of VAR_INPUT.
        outputs: Names of VAR_OUTPUT.
        params: Variables of VAR with a constant.
        diagnostics: Filled while resolving.
        readable: What functions may name where one is resolved, with the variable that it stands for.
        clamped_differences: Whether a difference of sigmoids is 0 where it is negative, as in jFuzzyLogic.
        empty_sets: First and last point of each term, of the variable that is read, which is 0 everywhere.
    """

    dialect: Dialect
    inputs: dict[str, Word] = field(default_factory=dict)
    outputs: dict[str, Word] = field(default_factory=dict)
    params: dict[str, Param] = field(default_factory=dict)
    diagnostics: list[Diagnostic] = field(default_factory=list)
    clamped_differences: bool = False
    readable: dict[str, str] = field(default_factory=dict)
    empty_sets: list[tuple[float, float]] = field(default_factory=list)
    _told: set[str] = field(default_factory=set)

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

    def number(self, expr: Expr, what: str) -> Expr | None:
        """Return a parameter that is a number or a constant; None, with an error, for any other."""
        if isinstance(expr, Number):
            if not math.isnan(expr.value):
                return expr
            self.error("FZ302", f"{what} is not a number", expr.span)
            return None
        if isinstance(expr, Name):
            return self._constant(expr, what)
        return expr

    def _constant(self, name: Name, what: str) -> Expr | None:
        if name.name in self.params:
            return name
        place = name.span
        if name.name in self.inputs or name.name in self.outputs:
            if name.name in self._told:
                return None
            self._told.add(name.name)
            kind = "input" if name.name in self.inputs else "output"
            message = f"{what} is the {kind} '{name.name}', so the term would change with it; that is not available"
            self.error("FZ602", message, place, help="write a number, or declare it in a VAR block with ':= value'")
            return None
        known = [*self.params]
        help_text = did_you_mean(name.name, known) or "write a number, or declare it in a VAR block with ':= value'"
        facts = (f"constants: {listed(known)}",) if known else ()
        self.error("FZ202", f"'{name.name}' is neither a number nor declared", place, facts=facts, help=help_text)
        return None

    def value(self, expr: Expr) -> float | None:
        """Return the finite value of a parameter, None where it has none."""
        try:
            value = evaluate(expr, ParamValues(tuple(self.params.values())).values)
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
        return self._refused("this is not an expression", span_of(expr))

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
        help_text = did_you_mean(name.name, known)
        self.error("FZ202", f"no variable '{name.name}'", name.span, facts=(f"known: {listed(known)}",), help=help_text)
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
            message = f"the function '{call.function}' is not available"
            known = listed(sorted({*FUNCTIONS, *ARGUMENTS}))
            return self._refused(message, call.span, facts=(f"functions: {known}",))
        if len(given) < least or (most is not None and len(given) > most):
            self.error("FZ303", f"'{call.function}' does not take {len(given)} arguments", call.span)
            return None
        found = expanded(name, given) if name in ARGUMENTS else Call(name, given, call.span)
        return self._refused("the function is too long", call.span) if found is None else found
