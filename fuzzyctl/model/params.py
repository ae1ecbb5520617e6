"""Evaluation of params in order of dependency; an error affects only params that depend on it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import CONSTANTS, ExprError, evaluate, names_in
from fuzzyctl.model.block import Param

#: Repair of a param that is infinite.
FINITE: Final = "give it a finite number, a large one where nothing is limited"


class ParamCycleError(ExprError):
    """Raised when a param depends on itself."""

    def __init__(self, names: list[str], span: Span | None) -> None:
        super().__init__(f"param '{names[0]}' depends on itself: {' → '.join(names)}", span)


class ParamValues:
    """Values of params, as far as they can be computed.

    Args:
        params: The params.
        partial: Whether some may be missing; a name that is not among them is then no mistake.

    Attributes:
        values: By name.
        failed: Names of those without a value.
        errors: Why, once for each cause.
    """

    def __init__(self, params: Sequence[Param], *, partial: bool = False) -> None:
        self.partial = partial
        self.values: dict[str, float] = {}
        self.failed: set[str] = set()
        self.errors: list[ExprError] = []
        self._by_name = {p.name: p for p in params}
        self._names: dict[str, list[ex.Name]] = {}
        for param in params:
            self._settle(param)

    def _settle(self, start: Param) -> None:
        """Compute a param and the params that it needs, without recursion: chains of params may be long."""
        open_names = [start.name]
        is_open = {start.name}
        while open_names:
            param = self._by_name[open_names[-1]]
            needed = None if self._is_settled(param.name) else self._needed(param)
            if needed is None:
                self._compute(param)
                is_open.discard(open_names.pop())
            elif needed.name in is_open:
                cycle = open_names[open_names.index(needed.name) :]
                self.errors.append(ParamCycleError([*cycle, needed.name], needed.span))
                self.failed.update(cycle)
            else:
                open_names.append(needed.name)
                is_open.add(needed.name)

    def _is_settled(self, name: str) -> bool:
        return name in self.values or name in self.failed

    def _needed(self, param: Param) -> ex.Name | None:
        names = self._names.get(param.name)
        if names is None:
            names = self._names[param.name] = names_in(param.expression)
        return next((n for n in names if n.name in self._by_name and not self._is_settled(n.name)), None)

    def _compute(self, param: Param) -> None:
        if self._is_settled(param.name):
            return
        self.failed.add(param.name)
        if self._lacks(self._names.pop(param.name)):
            return
        try:
            value = evaluate(param.expression, self.values)
            if math.isinf(value):
                error = ExprError(f"param '{param.name}' is infinite", param.span)
                error.help = FINITE
                raise error
        except ExprError as error:
            self.errors.append(error)
            return
        self.failed.discard(param.name)
        self.values[param.name] = value

    def of(self, expr: ex.Expr) -> float | None:
        """Return the value of an expression over params, None where it has none."""
        try:
            return evaluate(expr, self.values)
        except ExprError:
            return None

    def lacks(self, expr: ex.Expr) -> bool:
        """Whether an expression has no value because it uses a param without a value."""
        return (bool(self.failed) or self.partial) and self._lacks(names_in(expr))

    def _lacks(self, names: Iterable[ex.Name]) -> bool:
        unknown = {n.name for n in names if n.name not in self.values and n.name not in CONSTANTS}
        return any(n in self.failed for n in unknown) or (self.partial and bool(unknown))
