"""Derivatives of expressions over a box: forward mode in intervals, through fuzzy systems as well.

Derivatives vary over a box in the few places that are not linear. Their local slopes lie in a convex hull of a few
corners; as each path from an input to a value passes such a place once, the derivatives are multi-affine in the local
slopes, and lie in the convex hull of those at all combinations of corners. Of two systems whose rules have the same
premises, as the model and the law of Takagi and Sugeno, the weights are the same numbers: the coefficients of the
products of weights are averages of combinations, and so are those of a higher degree (Polya).

About a point, differences f(x) - f(c) = S (x - c) take the place of derivatives: S is the slope of a chord, so that a
saturation has a sector about c, and a rule with a linear consequent has its coefficients, whatever its weight.

Source:
    Griewank, Walther: Evaluating Derivatives, 2nd ed. 2008 (forward mode); of a function with kinks the hull of the
    derivatives of its pieces, which holds every difference quotient (Clarke). Krawczyk, Neumaier: Interval slopes for
    rational functions and associated centered forms, 1985. Sala, Arino: Asymptotically necessary and sufficient
    conditions for stability and performance in fuzzy control: applications of Polya's theorem, 2007.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations_with_replacement, compress, permutations
from typing import Any, Final, NamedTuple

import numpy as np

from fuzzyctl.analysis.reach import forms
from fuzzyctl.analysis.reach.forms import DomainError, Form, Value, as_form, corners, ends, hulled
from fuzzyctl.analysis.reach.series import STEPS, Nodes, Series, is_zero

#: Most combinations of corners.
MOST: Final = 256
#: Local slopes whose radius is a smaller part of their size are not varied.
_NARROW: Final = 1e-7
#: Degree that products of the same weights are raised to, more than the products have.
_RAISED: Final = 3


class _Local(NamedTuple):
    """How a node changes with its parts.

    Args:
        parts: Positions of the nodes that it is computed from.
        slopes: Corners of the slopes by them, shape (corners, parts, 2).
        weights: A key of the weights of the rules, if each rule has one corner; else None.
    """

    parts: Sequence[int]
    slopes: Form
    weights: object = None


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

    def vertices(self, values: Sequence[Value], about: Sequence[Value] | None = None, most: int = MOST) -> Form:
        """Return derivatives whose convex hull holds all over one box, shape (vertices, values, names, 2).

        Args:
            values: Of the inputs of the nodes; intervals.
            about: A point of the box: slopes of chords from there are returned in place of derivatives. Its numbers are
                exact, its intervals hold the true ones.
            most: How many vertices to return at most. Places of less effect are enclosed by intervals.

        Raises:
            DomainError: If a value may jump.
        """
        locals_ = self._locals(values, about)
        table: list[Any] = []
        whole = self._summed(locals_, table)
        needed = set(self.nodes.values)
        for at in reversed(locals_):
            if at in needed:
                acts = np.any(locals_[at].slopes, (0, 2)).tolist()
                needed.update(compress(locals_[at].parts, acts))
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
            if len(options) > 1 and effect > 0.0 and at in needed:
                varied[at], effects[at] = options, effect
        count, chosen = 1, list[int]()
        for at in sorted(varied, key=lambda at: -effects[at]):
            if count * len(varied[at]) <= most:
                count *= len(varied[at])
                chosen.append(at)
        if not chosen:
            return whole
        shape = [len(varied[at]) for at in chosen]
        grids = np.meshgrid(*map(np.arange, shape), indexing="ij")
        picked = {at: varied[at][g.reshape(-1)] for at, g in zip(chosen, grids, strict=True)}
        results = self._summed(
            {at: local._replace(slopes=picked.get(at, local.slopes)) for at, local in locals_.items()}, None, picked
        )
        results = np.broadcast_to(results, (count, *results.shape[1:]))
        weights = [locals_[at].weights for at in chosen]
        return _raised(results.reshape(*shape, *results.shape[1:]), weights, most)

    def sectors(self, values: Sequence[Value], about: Sequence[Value]) -> list[str]:
        """Return the sectors of tables of one input over a box, about a point, with the points that attain them."""
        series, centre = (Series(self.nodes, list(v), exact=exact) for v, exact in ((values, False), (about, True)))
        series.extend(), centre.extend()
        texts = []
        for node in self.nodes.nodes:
            if node.kind == "output":
                call = self.nodes.nodes[node.parts[0]]
                system = call.detail.system
                sides = [hulled(as_form(s.coefficients[p][0])) for s in (series, centre) for p in call.parts]
                at = call.detail.grid.inputs[0] if call.detail.grid is not None else 0
                if sector := call.detail.sector(sides[at], sides[at + len(call.parts)], node.detail):
                    least, first, most, last = sector
                    name = system.inputs[at].name
                    texts.append(
                        f"the sector of '{system.name}' is [{least:.6g}, {most:.6g}], "
                        f"attained at {name} = {first:.6g} and {name} = {last:.6g}"
                    )
        return texts

    def _locals(self, values: Sequence[Value], about: Sequence[Value] | None = None) -> dict[int, _Local]:
        """Return how nodes depend on those before them that depend on the inputs."""
        series = Series(self.nodes, [v if isinstance(v, float) else hulled(v) for v in values])
        series.extend()
        centre = None
        if about is not None:
            centre = Series(self.nodes, list(about), exact=True)
            centre.extend()
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
                local = _Local(parts, *self._rules(series, centre, at))
                if not len(local.slopes):
                    chord = None if centre is None else self._chords(series, centre, at)
                    local = _Local(parts, self._slopes(series, at) if chord is None else chord)
                if not np.all(np.isfinite(local.slopes)):
                    raise DomainError("a derivative has no bound")
                results[at] = local
        return results

    def _rules(self, series: Series, centre: Series | None, at: int) -> tuple[Form, object]:
        """Return the coefficients of the rules of a system about 0, and a key of their weights; or no rows."""
        node, nothing = self.nodes.nodes[at], np.zeros((0, 0, 2))
        if centre is None or node.kind != "output":
            return nothing, None
        call = self.nodes.nodes[node.parts[0]]
        if not all(is_zero(centre.coefficients[p][0]) for p in call.parts):
            return nothing, None
        arguments = [hulled(as_form(series.coefficients[p][0])) for p in call.parts]
        rules = call.detail.rules(arguments, node.detail)
        return (nothing, None) if rules is None else (rules, call.detail.weights(call.parts, node.detail))

    def _chords(self, series: Series, centre: Series, at: int) -> Form | None:
        """Return the corners of the slopes of a node about a point; None for those of the derivatives."""
        node = self.nodes.nodes[at]
        value = [series.coefficients[p][0] for p in node.parts]
        there = [centre.coefficients[p][0] for p in node.parts]
        match node.kind:
            case "*":
                if node.parts[0] == node.parts[1]:
                    return _row(value[0], there[0])
                first, second = (float(np.max(forms.radius(as_form(v)))) for v in value)
                return _row(value[1], there[0]) if second <= first else _row(there[1], value[0])
            case "/":
                inverse = forms.inverse(value[1])
                return _row(inverse, forms.negative(forms.times(centre.coefficients[at][0], inverse)))
            case "sin" if is_zero(there[0]):
                (low,), (high,) = ends(as_form(value[0]))
                most = max(abs(low), abs(high))
                if 0.0 < most < 3.0:  # sin(x) / x falls up to pi
                    return np.array([[[math.sin(most) / most * (1.0 - 1e-12), 0.0]], [[1.0, 0.0]]])
            case "sqrt":
                return _row(forms.inverse(forms.plus(as_form(series.coefficients[at][0]), centre.coefficients[at][0])))
            case "min" | "max":
                return _sides(node.kind, value, there)
            case "output":
                call = self.nodes.nodes[node.parts[0]]
                arguments = [hulled(as_form(series.coefficients[p][0])) for p in call.parts]
                points = [hulled(as_form(centre.coefficients[p][0])) for p in call.parts]
                chords: Form | None = call.detail.chords(arguments, points, node.detail)
                return chords
        return None

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
                parts, slopes = locals_[at].parts, locals_[at].slopes
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


def _sides(kind: str, value: Sequence[Value], there: Sequence[Value]) -> Form | None:
    """Return the slopes of a maximum or minimum about a point at which one side is taken.

    With d = a - b, and d0 > 0 at the point, max(a, b) - a = max(-d, 0) has chords of slope -s by d, s at most
    -l / (d0 - l) at the lower end l of d; so has a - min(a, b) with d = b - a.
    """
    order = (0, 1) if kind == "max" else (1, 0)
    apart = [ends(forms.minus(v[order[0]], v[order[1]])) for v in (value, there)]
    (low, high), (low0, high0) = ((float(a[0]), float(b[0])) for a, b in apart)
    if not all(map(math.isfinite, (low, high, low0, high0))):
        return None
    if low0 > 0.0:
        share, first = max(-low, 0.0) / (low0 + max(-low, 0.0)), 0
    elif high0 < 0.0:
        share, first = max(high, 0.0) / (max(high, 0.0) - high0), 1
    else:
        return None
    share = min(share * (1.0 + 1e-12), 1.0)
    rows = np.zeros((2, 2, 2))
    rows[0, first, 0] = 1.0
    rows[1, first, 0], rows[1, 1 - first, 0] = 1.0 - share, share
    rows[1, :, 1] = 1e-15
    return rows if share else rows[:1]


def _raised(grid: Form, weights: Sequence[object], most: int) -> Form:
    """Return the coefficients of the products of weights: places with the same weights share an axis.

    Args:
        grid: Derivatives for each rule of each place, shape (rules of the first place, ..., values, names, 2).
        weights: A key of the weights of each place; None for corners without weights.
        most: The most vertices that a higher degree may lead to.
    """
    places = len(weights)
    for key in dict.fromkeys(w for w in weights if w is not None):
        axes = [k for k, w in enumerate(weights) if w == key]
        if len(axes) < 2:
            continue
        weights = [*(w for w in weights if w != key), key]
        grid = np.moveaxis(grid, axes, range(places - len(axes), places))
        shape, rules = grid.shape, grid.shape[places - 1]
        table = grid.reshape(-1, *shape[places - len(axes) :])
        others = len(table)
        for degree in range(len(axes) + _RAISED, len(axes) - 1, -1):
            chosen = list(combinations_with_replacement(range(rules), degree))
            if degree == len(axes) or others * len(chosen) <= most:
                break
        orders = list(permutations(range(degree), len(axes)))
        means = []
        for rule in chosen:
            picks: list[tuple[Any, ...]] = [(slice(None), *(rule[k] for k in order)) for order in orders]
            parts = np.stack([table[pick] for pick in picks])
            mean = parts.mean(0)
            mean[..., 1] += 1e-15 * len(orders) * np.abs(parts[..., 0]).max(0)
            means.append(mean)
        grid = np.stack(means, 1).reshape(*shape[: places - len(axes)], len(chosen), *shape[places:])
        places = len(weights)
    return grid.reshape(-1, *grid.shape[-3:])


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
