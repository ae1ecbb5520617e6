"""Derivatives of expressions over a box: forward mode in intervals, through fuzzy systems as well.

Derivatives vary over a box in the few places that are not linear. Their local slopes lie in a convex hull of a few
corners; as each path from an input to a value passes such a place once, the derivatives are multi-affine in the local
slopes, and lie in the convex hull of those at all combinations of corners.

Source:
    Griewank, Walther: Evaluating Derivatives, 2nd ed. 2008 (forward mode); of a function with kinks the hull of the
    derivatives of its pieces, which holds every difference quotient (Clarke).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np

from fuzzyctl.analysis.reach import forms
from fuzzyctl.analysis.reach.forms import DomainError, Form, Value, as_form, ends, hulled
from fuzzyctl.analysis.reach.series import STEPS, Nodes, Series
from fuzzyctl.analysis.reach.surfaces import corners

#: Most combinations of corners.
MOST: Final = 256
#: Local slopes whose radius is a smaller part of their size are not varied.
_NARROW: Final = 1e-7


class _Local(NamedTuple):
    """How a node changes with its parts.

    Args:
        parts: Positions of the nodes that it is computed from.
        slopes: Corners of the slopes by them, shape (corners, parts, 2).
    """

    parts: Sequence[int]
    slopes: Form


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
        return np.asarray(self._summed(self._locals(values))[0])

    def vertices(self, values: Sequence[Value], most: int = MOST) -> Form:
        """Return derivatives whose convex hull holds all over one box, shape (vertices, values, names, 2).

        Args:
            values: Of the inputs of the nodes; intervals.
            most: How many vertices to return at most. Places of less effect are enclosed by intervals.

        Raises:
            DomainError: If a value may jump.
        """
        locals_ = self._locals(values)
        table: list[Any] = []
        whole = self._summed(locals_, table)
        varied: dict[int, Form] = {}
        effects: dict[int, float] = {}
        for at, local in locals_.items():
            options = local.slopes
            if len(options) == 1:
                spread = options[0, :, 1] > _NARROW * np.abs(options[0, :, 0])
                options = _split(options[0], spread)
            low, high = ends(local.slopes)
            reach = [float(np.abs(table[p][..., 0]).max(initial=0.0)) for p in local.parts]
            effect = float(((high.max(0) - low.min(0)) * np.array(reach)).sum())
            if len(options) > 1 and effect > 0.0:
                varied[at], effects[at] = options, effect
        count, chosen = 1, list[int]()
        for at in sorted(varied, key=lambda at: -effects[at]):
            if count * len(varied[at]) <= most:
                count *= len(varied[at])
                chosen.append(at)
        if not chosen:
            return whole
        grids = np.meshgrid(*(np.arange(len(varied[at])) for at in chosen), indexing="ij")
        picked = {at: varied[at][g.reshape(-1)] for at, g in zip(chosen, grids, strict=True)}
        return self._summed({at: _Local(v.parts, picked.get(at, v.slopes)) for at, v in locals_.items()}, None, picked)

    def _locals(self, values: Sequence[Value]) -> dict[int, _Local]:
        """Return how nodes depend on those before them that depend on the inputs."""
        series = Series(self.nodes, [v if isinstance(v, float) else hulled(v) for v in values])
        series.extend()
        moving = set(self._columns)
        results: dict[int, _Local] = {}
        for at, node in enumerate(self.nodes.nodes):
            if node.kind in ("number", "input", "compare", "logic", "system"):
                continue
            parts = self.nodes.nodes[node.parts[0]].parts if node.kind == "output" else node.parts
            if node.kind == "where":
                parts = parts[1:]
                self._picked(series, at, [], [])  # the choice itself may jump
            if any(p in moving for p in parts):
                moving.add(at)
                slopes = self._slopes(series, at)
                if not np.all(np.isfinite(slopes)):
                    raise DomainError("a derivative has no bound")
                results[at] = _Local(parts, slopes)
        return results

    def _summed(
        self, locals_: dict[int, _Local], table: list[Any] | None = None, picked: dict[int, Form] | None = None
    ) -> Form:
        """Return the derivatives of the wanted values by the chain rule, shape (vertices, values, names, 2).

        Args:
            locals_: Of the nodes.
            table: Filled with the derivatives of all nodes.
            picked: Nodes whose slopes have one entry for each vertex, in place of corners.
        """
        zero: Form = np.zeros((1, len(self._columns), 2))
        table = [] if table is None else table
        for at in range(len(self.nodes.nodes)):
            if at in self._columns:
                total: Value = np.eye(1, len(self._columns), self._columns[at])[..., None] * [1.0, 0.0]
            elif at in locals_:
                parts, slopes = locals_[at]
                if len(slopes) > 1 and at not in (picked or {}):
                    low, high = ends(slopes)
                    slopes = forms.interval(low.min(0), high.max(0))[None]
                total = zero
                for p, slope in zip(parts, np.moveaxis(slopes, 1, 0), strict=True):
                    if table[p].any() and slope.any():
                        total = forms.plus(total, forms.times(table[p], slope[:, None]))
            else:
                total = zero
            table.append(total)
        rows = [np.asarray(table[at]) for at in self.nodes.values]
        count = max((len(r) for r in rows), default=1)
        if not rows:
            return np.zeros((1, 0, len(self._columns), 2))
        return np.stack([np.broadcast_to(r, (count, *r.shape[1:])) for r in rows], 1)

    def _slopes(self, series: Series, at: int) -> Form:
        """Return the corners of the slopes of a node by its parts, shape (corners, parts, 2)."""
        node = self.nodes.nodes[at]
        value = [series.coefficients[p][0] for p in node.parts]
        result = series.coefficients[at][0]
        match node.kind:
            case "negative":
                return _row(-1.0)
            case "+":
                return _row(1.0, 1.0)
            case "*":
                return _row(value[1], value[0])
            case "/":
                inverse = forms.inverse(value[1])
                return _row(inverse, forms.negative(forms.times(result, inverse)))
            case "sin":
                return _row(series.coefficients[node.detail][0])
            case "cos":
                return _row(forms.negative(series.coefficients[node.detail][0]))
            case "exp":
                return _row(result)
            case "log":
                return _row(forms.inverse(value[0]))
            case "sqrt":
                return _row(forms.scaled(forms.inverse(result), 0.5))
            case "power":
                return _row(forms.scaled(forms.powered(value[0], node.detail - 1.0), node.detail))
            case "abs":
                return self._picked(series, at, [1.0], [-1.0])
            case "min" | "max" | "where":
                return self._picked(series, at, [1.0, 0.0], [0.0, 1.0])
            case "output":
                call = self.nodes.nodes[node.parts[0]]
                arguments = [hulled(as_form(series.coefficients[p][0])) for p in call.parts]
                return np.asarray(call.detail.gradients(arguments, node.detail))
        if isinstance(result, float):
            return np.zeros((1, len(node.parts), 2))
        what = "jumps" if node.kind in STEPS else "has no known derivative"
        raise DomainError(f"'{node.kind}' {what}")

    def _picked(self, series: Series, at: int, first: Sequence[float], second: Sequence[float]) -> Form:
        yes, no = series.choices[at]
        if bool(np.all(yes & ~no)):
            return _row(*first)
        if bool(np.all(no & ~yes)):
            return _row(*second)
        if self.nodes.nodes[at].kind == "where":
            raise DomainError("a choice is open, whose value may jump")
        return np.concatenate([_row(*first), _row(*second)])


def _row(*slopes: Value) -> Form:
    """Return slopes by several parts as one corner."""
    return np.array([hulled(as_form(s))[0] for s in slopes]).reshape(1, -1, 2)


def _split(slopes: Form, wide: Any) -> Form:
    """Return the corners of slopes that vary, shape (corners, parts, 2)."""
    if not wide.any():
        return slopes[None]
    points = corners(slopes[wide])
    out = np.broadcast_to(slopes, (len(points), *slopes.shape)).copy()
    out[:, wide] = points
    return out
