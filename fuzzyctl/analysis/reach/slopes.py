"""Derivatives of expressions over a box: forward mode in intervals, through fuzzy systems as well.

Source:
    Griewank, Walther: Evaluating Derivatives, 2nd ed. 2008 (forward mode); of a function with kinks the hull of the
    derivatives of its pieces, which holds every difference quotient (Clarke).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from fuzzyctl.analysis.reach import forms
from fuzzyctl.analysis.reach.forms import DomainError, Form, Value, as_form, ends, hulled
from fuzzyctl.analysis.reach.series import STEPS, Nodes, Series
from fuzzyctl.analysis.reach.surfaces import SystemSurface


class Slopes:
    """Derivatives of the wanted values of some nodes.

    Args:
        nodes: The nodes.
        names: Names of the inputs by which they are taken.
    """

    def __init__(self, nodes: Nodes, names: Sequence[str]) -> None:
        self.nodes = nodes
        self._columns = {nodes.names[n]: k for k, n in enumerate(names)}

    def over(self, values: Sequence[Value]) -> Form:
        """Return the derivatives, shape (values, names, 2): centres and radii, for one box.

        Args:
            values: Of the inputs of the nodes; intervals.

        Raises:
            DomainError: If a value may jump.
        """
        series = Series(self.nodes, [v if isinstance(v, float) else hulled(v) for v in values])
        series.extend()
        zero: Form = np.zeros((len(self._columns), 2))
        table: list[Any] = []
        for at, node in enumerate(self.nodes.nodes):
            parts = [table[p] for p in node.parts]
            if at in self._columns:
                slope = zero.copy()
                slope[self._columns[at], 0] = 1.0
            elif node.kind in ("number", "input", "compare", "logic"):
                slope = zero
            else:
                slope = self._of(series, at, parts, zero)
            table.append(slope)
        return np.stack([table[at] for at in self.nodes.values]) if self.nodes.values else np.zeros((0, *zero.shape))

    def _of(self, series: Series, at: int, parts: Sequence[Any], zero: Form) -> Any:
        node = self.nodes.nodes[at]
        value = [series.coefficients[p][0] for p in node.parts]
        result = series.coefficients[at][0]
        match node.kind:
            case "negative":
                return forms.negative(parts[0])
            case "+":
                return forms.plus(parts[0], parts[1])
            case "*":
                return forms.plus(_times(parts[0], value[1]), _times(parts[1], value[0]))
            case "/":
                inverse = forms.inverse(value[1])
                return _times(as_form(forms.minus(parts[0], _times(parts[1], result))), inverse)
            case "sin" | "cos":
                other = series.coefficients[node.detail][0]
                return _times(parts[0], other if node.kind == "sin" else forms.negative(other))
            case "exp":
                return _times(parts[0], result)
            case "log":
                return _times(parts[0], forms.inverse(value[0]))
            case "sqrt":
                return zero if not parts[0].any() else _times(parts[0], forms.scaled(forms.inverse(result), 0.5))
            case "power":
                steep = forms.scaled(forms.powered(value[0], node.detail - 1.0), node.detail)
                return _times(parts[0], steep)
            case "abs" | "min" | "max" | "where":
                first, second = (parts[0], as_form(forms.negative(parts[0]))) if node.kind == "abs" else parts[-2:]
                return self._picked(series, at, first, second)
            case "system":
                return self._of_system(node.detail, value, parts, zero)
            case "output":
                return parts[0][node.detail]
        if not any(p.any() for p in parts) or isinstance(result, float):
            return zero
        what = "jumps" if node.kind in STEPS else "has no known derivative"
        raise DomainError(f"'{node.kind}' {what}")

    def _picked(self, series: Series, at: int, first: Form, second: Form) -> Form:
        yes, no = series.choices[at]
        if bool(np.all(yes & ~no)):
            return first
        if bool(np.all(no & ~yes)):
            return second
        if self.nodes.nodes[at].kind == "where":
            raise DomainError("a choice is open, whose value may jump")
        low, high = (np.stack(e) for e in zip(ends(first), ends(second), strict=True))
        return forms.interval(low.min(0), high.max(0))

    def _of_system(
        self, surface: SystemSurface, value: Sequence[Value], parts: Sequence[Form], zero: Form
    ) -> list[Form]:
        results = []
        for slopes in surface.slopes([as_form(v) for v in value]):
            total: Value = zero
            for slope, part in zip(slopes, parts, strict=True):
                total = forms.plus(total, _times(part, slope[None]))
            results.append(as_form(total))
        return results


def _times(a: Form, b: Value) -> Form:
    if isinstance(b, float) and b == 0.0:
        return np.zeros_like(a)
    if not math.isfinite(float(np.max(np.abs(as_form(b))))):
        raise DomainError("a derivative has no bound")
    return as_form(forms.times(a, b))
