"""Affine enclosures of fuzzy systems over boxes of their inputs: a secant plane with its exact error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations, product
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from fuzzyctl.analysis.branch_and_bound.boxed_system import System
from fuzzyctl.analysis.reach import forms
from fuzzyctl.analysis.reach.forms import DomainError, Form, Mask, Value, as_form, corners, ends
from fuzzyctl.analysis.reach.series import Nodes, Series
from fuzzyctl.analysis.reach.slopes import Slopes
from fuzzyctl.kernels.algorithms.grid import Grid, Table, grid_of
from fuzzyctl.kernels.interval import vector
from fuzzyctl.kernels.interval.vector import Enclosure, boxes
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.plan.sets import SetPlan
from fuzzyctl.model.system import FuzzySystem


class SystemSurface:
    """Encloses the outputs of a system that does not adapt.

    Args:
        system: The system.
    """

    def __init__(self, system: FuzzySystem) -> None:
        self.system, self.plan = system, plan(system)
        grid = grid_of(self.plan)
        self.grid = grid if isinstance(grid, Grid) else None

    @np.errstate(all="ignore")
    def __call__(self, inputs: Sequence[Value]) -> list[Value]:
        """Return forms of the outputs."""
        if all(isinstance(a, float) for a in inputs):
            inputs = [as_form(inputs[0]), *inputs[1:]]
        width = max(as_form(a).shape[-1] for a in inputs)
        arguments = [forms.widened(as_form(a), width) for a in inputs]
        count = max(a.shape[0] for a in arguments)
        arguments = [np.broadcast_to(a, (count, width)) for a in arguments]
        if not all(np.all(np.isfinite(a)) for a in arguments):
            raise DomainError(f"an input of system '{self.system.name}' has no bound")
        if self.grid is None:
            return self._by_parts(arguments, range(len(self.system.outputs)))
        return [self._of_table(t, arguments, e) for t, e in zip(self.grid.outputs, self._boxed.errors, strict=True)]

    @cached_property
    def _boxed(self) -> System:
        return System(self.system, self.plan)

    @cached_property
    def _without_else(self) -> System:
        """The system without values where no rule fires."""
        outputs = tuple(replace(o, otherwise=math.nan) for o in self.plan.outputs)
        return System(self.system, replace(self.plan, outputs=outputs))

    def _of_table(self, table: Table, arguments: Sequence[Form], error: float) -> Value:
        assert self.grid is not None
        if not np.isfinite(error):
            return self._by_parts(arguments, [self.grid.outputs.index(table)])[0]
        sides = [arguments[i] for i in self.grid.inputs]
        shape = tuple(len(k) for k in self.grid.knots)
        value: Value = self._plane(np.array(table.value).reshape(shape), sides)
        if table.weight:
            value = forms.times(value, forms.inverse(self._plane(np.array(table.weight).reshape(shape), sides)))
        out = as_form(value).copy()
        out[..., 1] += 2.0 * error
        return forms.padded(out, np.abs(out[..., 0]))

    def _plane(self, values: Form, sides: Sequence[Form]) -> Form:
        """Return a plane near a multilinear function over boxes, with the largest distance from it.

        On a cell of the grid the function less a plane is multilinear, so that its extremes over a box lie at corners
        of the parts of cells inside of it.

        Args:
            values: At the knots.
            sides: The inputs.
        """
        assert self.grid is not None
        knots = [np.array(k) for k in self.grid.knots]
        count = sides[0].shape[0]
        slopes, middle, error = np.empty((len(sides), count)), np.empty(count), np.empty(count)
        for box in range(count):
            points, heights = _over_slabs(values, knots, [s[box] for s in sides])
            moved = points - np.array([s[box, 0] for s in sides])
            best = None
            for slope in _slopes(moved, heights):
                rest = heights - moved @ slope
                least, most = rest.min(), rest.max()
                if best is None or most - least < best[1] - best[0]:
                    best = least, most, slope
            assert best is not None
            size = np.abs(values).max() + np.abs(moved).max(0) @ np.abs(best[2])
            slopes[:, box], middle[box] = best[2], 0.5 * (best[0] + best[1])
            error[box] = 0.5 * (best[1] - best[0]) + 64 * 2.0**-53 * size
        return _planes(sides, slopes, middle, error)

    def slopes(self, inputs: Sequence[Form]) -> list[Form]:
        """Return the derivatives of each output by the inputs over one box, shape (inputs, 2): centres and radii.

        Raises:
            DomainError: If an output has none there.
        """
        results = []
        for k in range(len(self.system.outputs)):
            low, high = ends(self.gradients(inputs, k))
            results.append(forms.interval(low.min(0), high.max(0)))
        return results

    @np.errstate(all="ignore")
    def gradients(self, inputs: Sequence[Form], output: int) -> Form:
        """Return gradients of an output whose convex hull holds all over one box, shape (gradients, inputs, 2).

        Raises:
            DomainError: If gradients have no bound.
        """
        if self.grid is not None and not any(t.weight for t in self.grid.outputs):
            return self._gradients_of_table(self.grid.outputs[output], inputs)
        (enclosure,) = self._enclosed(*self._cut([forms.hulled(as_form(a)) for a in inputs]), [output]).over
        assert enclosure.slopes is not None
        below, above = (np.broadcast_to(s, (len(inputs), len(enclosure.lo))) for s in enclosure.slopes)
        if not (np.all(np.isfinite(below)) and np.all(np.isfinite(above))):
            raise DomainError(f"the slopes of system '{self.system.name}' have no bound there")
        return corners(forms.interval(below.min(1), above.max(1)))

    def exactly(self, inputs: Sequence[Value]) -> list[Value]:
        """Return the outputs in exact arithmetic where they are known: at 0, and at knots; else forms."""
        results = self(inputs)
        if not all(isinstance(a, float) for a in inputs):
            return results
        for k in range(len(results)):
            if not any(inputs) and self.rules([as_form(a) for a in inputs], k) is not None:
                results[k] = 0.0
            elif self.grid is not None and not self.grid.outputs[k].weight:
                sides = [inputs[i] for i in self.grid.inputs]
                if all(x in knots for x, knots in zip(sides, self.grid.knots, strict=True)):
                    shape = [len(knots) for knots in self.grid.knots]
                    at = tuple(knots.index(x) for x, knots in zip(sides, self.grid.knots, strict=True))
                    results[k] = float(np.array(self.grid.outputs[k].value).reshape(shape)[at])
        return results

    @np.errstate(all="ignore")
    def rules(self, inputs: Sequence[Form], output: int) -> Form | None:
        """Return coefficients of each rule such that the output is an average of these times the inputs over one box.

        Returns:
            Shape (rules, inputs, 2), or None if the output is no average of functions that are 0 at 0.
        """
        plan, result = self.plan, self.plan.outputs[output]
        plain = not (plan.has_formulas or plan.states or plan.held or plan.chains or result.reads or result.clamped)
        over_rules = result.averages and not (result.sums or result.inverts or result.takes_degrees)
        over_rules &= (result.merge, result.total) == ("rules", "activations")
        if not (plain and over_rules and result.implied and all(e.change is None for e in result.implied)):
            return None
        for side, a in zip(plan.inputs, inputs, strict=True):
            (low,), (high,) = ends(a)
            if not side.extrapolate and not side.lower <= low <= high <= side.upper:
                return None
        rows = [self._coefficients(result.terms[e.term], inputs) for e in result.implied]
        if any(row is None for row in rows):
            return None
        try:  # an `else` is no average
            self._enclosed(*self._cut([forms.hulled(as_form(a)) for a in inputs]), [output], self._without_else)
        except DomainError:
            return None
        return np.stack([row for row in rows if row is not None])

    def _coefficients(self, term: SetPlan, inputs: Sequence[Form]) -> Form | None:
        """Return coefficients of a consequent by the inputs, None if it is not 0 at 0."""
        if term.expression is None:
            return np.zeros((len(inputs), 2)) if term.peak == 0.0 else None
        names = [i.name for i in self.plan.inputs]
        nodes = Nodes(names, [], [term.expression])
        at_zero = Series(nodes, [0.0] * len(names), exact=True).extend()[0]
        if not (isinstance(at_zero, float) and at_zero == 0.0):
            return None
        whole = [forms.interval(np.minimum(low, 0.0), np.maximum(high, 0.0)) for low, high in map(ends, inputs)]
        return np.asarray(Slopes(nodes, names).over(whole)[0])

    def weights(self, arguments: Sequence[int], output: int) -> object:
        """Return a key of the weights of the rules, given the positions of the values that are its inputs.

        Two outputs for which it is the same have the same weights.
        """
        plan, result = self.plan, self.plan.outputs[output]
        degrees = [(arguments[d.variable], d.set, plan.inputs[d.variable]) for d in plan.degrees]
        premises = [(at, term, i.lower, i.upper, i.extrapolate) for at, term, i in degrees]
        rules = [(plan.rules[e.rule], e.factor) for e in result.implied]
        means = (result.kind, result.implication, result.aggregation, result.equal, result.fallback, plan.least)
        return repr((premises, plan.steps, plan.strengths, rules, plan.activations, means))

    def chords(self, inputs: Sequence[Form], about: Sequence[Form], output: int) -> Form | None:
        """Return slopes S whose convex hull has f(x) - f(c) = S (x - c) for all x of one box, c near a point.

        Of several inputs one after the other goes from x to c: the slope along each is that of a chord, for the inputs
        before it at c and those after it anywhere in the box. In each of these the surface is linear between knots,
        and so are the slopes of chords from one point; along the chord itself they are monotone between knots.

        Returns:
            Shape (corners, inputs, 2), None for a system that is no table.
        """
        if self.grid is None or any(t.weight for t in self.grid.outputs):
            return None
        table = self.grid.outputs[output]
        knots = [np.array(k) for k in self.grid.knots]
        values = np.array(table.value).reshape([len(k) for k in knots])
        ranges = [tuple(float(e[0]) for e in ends(inputs[i])) for i in self.grid.inputs]
        points = [tuple(float(e[0]) for e in ends(about[i])) for i in self.grid.inputs]
        axes = [np.array([low, *k[(k > low) & (k < high)], high]) for k, (low, high) in zip(knots, ranges, strict=True)]
        box = np.zeros((len(inputs), 2))
        steep = [float(np.abs(ends(g)).max()) for g in self.slopes_of(table, inputs)]
        errors = [most * (last - first) for most, (first, last) in zip(steep, points, strict=True)]
        off = 1e-14 * np.abs(values).max() + sum(errors)
        for axis, i in enumerate(self.grid.inputs):
            first, last = points[axis]
            middle = 0.5 * (first + last)
            near = max(1e-8 * (knots[axis][-1] - knots[axis][0]), 1e3 * (last - first))
            # Beside the point: the slopes of the cells there.
            sides = [about[j] if order < axis else inputs[j] for order, j in enumerate(self.grid.inputs)]
            sides[axis] = forms.interval(np.array([middle - near]), np.array([middle + near]))
            low, high = ends(self.slopes_of(table, self._arguments(sides))[axis])
            steepest = [float(low), float(high)]
            beside = np.abs(axes[axis] - middle) > near
            if beside.any():
                at = [np.array([0.5 * sum(p)]) for p in points[:axis]]
                grids = [*at, np.append(axes[axis][beside], middle), *axes[axis + 1 :]]
                mesh = np.stack([m.reshape(-1) for m in np.meshgrid(*grids, indexing="ij")], -1)
                heights = np.moveaxis(_interpolated(values, knots, mesh).reshape([len(g) for g in grids]), axis, -1)
                apart = axes[axis][beside] - middle
                slopes = (heights[..., :-1] - heights[..., -1:]) / apart
                error = (2.0 * off + np.abs(slopes).max() * (last - first)) / np.abs(apart).min() * 1.01
                steepest += [float(slopes.min()) - error, float(slopes.max()) + error]
            box[i] = forms.interval(np.array(min(steepest)), np.array(max(steepest)))
        return corners(box)

    def sector(self, side: Form, about: Form, output: int) -> tuple[float, float, float, float] | None:
        """Return the least slope of a chord from a point of a table of one input, where it ends, and the largest.

        Beside the point the slope is that of the cell: then the chord ends at the next knot, or the end of the range.
        """
        if self.grid is None or len(self.grid.inputs) > 1 or self.grid.outputs[output].weight:
            return None
        knots, values = np.array(self.grid.knots[0]), np.array(self.grid.outputs[output].value)
        (low,), (high,) = ends(side)
        centre = float(about[0, 0])
        points = np.array([low, *knots[(knots > low) & (knots < high)], high])
        points = points[np.abs(points - centre) > 1e-8 * (knots[-1] - knots[0])]
        slopes = (np.interp(points, knots, values) - np.interp(centre, knots, values)) / (points - centre)
        least, most = int(slopes.argmin()), int(slopes.argmax())
        return float(slopes[least]), float(points[least]), float(slopes[most]), float(points[most])

    def _arguments(self, sides: Sequence[Form]) -> list[Form]:
        """Return the inputs of the system from those of the grid."""
        assert self.grid is not None
        arguments: list[Form] = [np.zeros((1, 2)) for _ in self.system.inputs]
        for i, side in zip(self.grid.inputs, sides, strict=True):
            arguments[i] = side
        return arguments

    def slopes_of(self, table: Table, inputs: Sequence[Form]) -> list[Form]:
        """Return the slopes of a table by each input of the grid."""
        assert self.grid is not None
        low, high = ends(self._gradients_of_table(table, inputs))
        return [forms.interval(low[:, i].min(), high[:, i].max()) for i in self.grid.inputs]

    def _gradients_of_table(self, table: Table, inputs: Sequence[Form]) -> Form:
        """Return the gradients of a multilinear function at the corners of the parts of cells in one box.

        On a part of a cell the gradient is multilinear, so that it lies in the hull of those at the corners. The slope
        along an input does not depend on this input, and is that of the whole cell.
        """
        assert self.grid is not None
        knots = [np.array(k) for k in self.grid.knots]
        values = np.array(table.value).reshape([len(k) for k in knots])
        # Of each axis the cells that the box meets, twice, and weights of the knots at the ends of their parts in it.
        cells, shares = [], list[Form]()
        for k, i in zip(knots, self.grid.inputs, strict=True):
            low, high = (float(e[0]) for e in ends(inputs[i]))
            met = np.flatnonzero((np.append(k, np.inf) >= low) & (np.insert(k, 0, -np.inf) <= high))
            at = np.clip(np.stack([np.insert(k, 0, low)[met], np.append(k, high)[met]], 1), low, high).reshape(-1)
            cells.append(np.repeat(met, 2))
            shares.append(np.stack([np.interp(at, k, row) for row in np.eye(len(k))], 1))
        results = np.zeros((*(len(c) for c in cells), len(inputs), 2))
        for axis, i in enumerate(self.grid.inputs):
            lengths = np.diff(knots[axis])
            steep = np.moveaxis(np.diff(values, axis=axis), axis, -1) / lengths
            steep = np.moveaxis(np.pad(steep, [(0, 0)] * (values.ndim - 1) + [(1, 1)]), -1, axis)
            for other, share in enumerate(shares):
                if other != axis:
                    steep = np.moveaxis(np.tensordot(share, steep, (1, other)), 0, other)
            results[..., i, 0] = np.take(steep, cells[axis], axis)
            results[..., i, 1] = 64 * 2.0**-53 * np.abs(values).max() / max(float(lengths.min(initial=1.0)), 1e-300)
        return forms.hull_points(results.reshape(-1, len(inputs), 2))

    @cached_property
    def _curved(self) -> list[int]:
        """Inputs that the surface is not linear in, as far as is known: those of the rules' conditions."""
        inputs = range(len(self.system.inputs))
        read = {d.variable for d in self.plan.degrees}
        return [i for i in inputs if i in read or self.plan.has_formulas]

    def _cut(self, sides: Sequence[Form]) -> tuple[Form, Form]:
        """Return ends of boxes that together hold a set, shape (inputs, boxes); cut where terms bend, and between."""
        axes = whole = [np.array([low[0], high[0]]) for low, high in map(ends, sides)]
        share = max(2, round(_PARTS ** (1.0 / max(len(self._curved), 1))))
        for even in (share, 1):
            axes = list(whole)
            for i in self._curved:
                low, high = whole[i]
                knots = np.array([low, *sorted(x for x in self._boxed.breakpoints(i) if low < x < high), high])
                axes[i] = np.concatenate([knots, 0.5 * (knots[:-1] + knots[1:]), np.linspace(low, high, even + 1)])
            axes = [np.unique(a) for a in axes]
            if math.prod(max(len(a) - 1, 1) for a in axes) <= _MOST_PARTS:
                break
        else:
            axes = whole
        first, last = [a[:-1] if len(a) > 1 else a for a in axes], [a[1:] if len(a) > 1 else a for a in axes]
        low, high = (np.stack([m.reshape(-1) for m in np.meshgrid(*e, indexing="ij")]) for e in (first, last))
        met = _meets(sides, self._curved, low, high)
        return low[:, met], high[:, met]

    def _enclosed(self, low: Form, high: Form, wanted: Sequence[int], boxed: System | None = None) -> _Parts:
        """Return outputs over boxes; a box in which they may have no value is cut into parts.

        Args:
            low, high: Ends of the boxes, shape (inputs, boxes).
            wanted: Positions of the outputs.
            boxed: The system without the values of its `else`, to take such a value for none.

        Raises:
            DomainError: If there may be a place without a value.
        """
        boxed = boxed or self._boxed
        done, most = list[_Parts](), boxed.batch
        waiting = [(low, high, np.arange(low.shape[1]), _ROUNDS)]
        while waiting:
            low, high, origin, rounds = waiting.pop()
            if len(origin) > most:
                waiting += [(low[:, p], high[:, p], origin[p], rounds) for p in (slice(most), slice(most, None))]
                continue
            count, centre = len(origin), 0.5 * (low + high)
            places = boxes(np.concatenate([low, centre], 1), np.concatenate([high, centre], 1))
            results, gaps = boxed.evaluate(places, wanted, gaps=True, sparse=True)
            full = ~np.broadcast_to(gaps, 2 * count)[:count]
            nothing = np.zeros(count, bool)
            over = [e.taken(np.concatenate([full, nothing])) for e in results]
            there = [e.taken(np.concatenate([nothing, full])) for e in results]
            done.append(_Parts(low[:, full], high[:, full], origin[full], over, there))
            low, high, origin = low[:, ~full], high[:, ~full], origin[~full]
            if len(origin) * 2 ** len(self._curved) > (_MOST_PARTS if rounds else 0):
                raise DomainError(f"system '{self.system.name}' may have no value")
            for i in self._curved:
                middle = 0.5 * (low[i] + high[i])
                low, high, origin = np.tile(low, 2), np.tile(high, 2), np.tile(origin, 2)
                low[i, len(middle) :] = high[i, : len(middle)] = middle
            waiting += [(low, high, origin, rounds - 1)] if len(origin) else []
        columns = [[vector.joined(e) for e in zip(*(d[k] for d in done), strict=True)] for k in (3, 4)]
        low, high = (np.concatenate([d[k] for d in done], 1) for k in (0, 1))
        return _Parts(low, high, np.concatenate([d.origin for d in done]), *columns)

    def _by_parts(self, arguments: Sequence[Form], wanted: Sequence[int]) -> list[Value]:
        """Return forms of outputs by mean values in the parts of a set.

        On a part with the centre m the function less s (x - c) lies in f(m) - s (m - c) + (G - s)(x - m), G the slopes
        over the part, and in its range less s (x - c).
        """
        if self.plan.states or self.plan.held:
            raise DomainError(f"system '{self.system.name}' has a state")
        count = arguments[0].shape[0]
        sides = [[a[box : box + 1] for a in arguments] for box in range(count)]
        cut = [self._cut(s) for s in sides]
        low, high = (np.concatenate(e, 1) for e in zip(*cut, strict=True))
        parts = self._enclosed(low, high, wanted)
        owner = np.repeat(np.arange(count), [low.shape[1] for low, _ in cut])[parts.origin]
        results: list[Value] = [
            np.concatenate([_secant(sides[box], parts, k, owner == box) for box in range(count)])
            for k in range(len(wanted))
        ]
        if count == 1:
            for k, output in enumerate(wanted):
                if (rules := self.rules(arguments, output)) is not None:
                    results[k] = forms.narrower(as_form(results[k]), _between_rules(rules, arguments))
        if any(not np.all(np.isfinite(as_form(r))) for r in results):
            raise DomainError(f"system '{self.system.name}' has no finite bound")
        return results


class _Parts(NamedTuple):
    """Outputs over parts of boxes.

    Args:
        low, high: Ends of the parts, shape (inputs, parts).
        origin: The box that each is a part of.
        over, there: Of each output the enclosures over the parts, and at their centres.
    """

    low: Form
    high: Form
    origin: npt.NDArray[np.intp]
    over: list[Enclosure]
    there: list[Enclosure]


def _meets(sides: Sequence[Form], axes: Sequence[int], low: Form, high: Form) -> Mask:
    """Return which boxes may meet a set: those that no line along one of its symbols parts from it."""
    met = np.ones(low.shape[1], bool)
    for i, j in combinations(axes, 2):
        x, y = sides[i][0], sides[j][0]
        steps = np.stack([x[2:], y[2:]])
        longest = np.argsort(-np.abs(steps).max(0))[:_LINES]
        for normal in np.stack([-steps[1, longest], steps[0, longest]], -1):
            reach = np.abs(normal @ steps).sum() + np.abs(normal) @ np.abs([x[1], y[1]])
            middle = normal @ (0.5 * (low + high)[[i, j]]) - normal @ np.array([x[0], y[0]])
            half = np.abs(normal) @ (0.5 * (high - low)[[i, j]])
            size = np.abs(normal) @ (np.abs(low[[i, j]]) + np.abs(high[[i, j]]))
            met &= np.abs(middle) <= (reach + half) * (1.0 + _ASIDE) + _ASIDE * size
    return met


def _secant(sides: Sequence[Form], parts: _Parts, output: int, own: Mask) -> Form:
    """Return a plane near an output over one set, with the largest distance from it over some of the parts."""
    over, there = parts.over[output].taken(own), parts.there[output].taken(own)
    centre = 0.5 * (parts.low + parts.high)[:, own]
    reach = np.maximum(parts.high[:, own] - centre, centre - parts.low[:, own])
    moved = centre - np.array([s[0, 0] for s in sides])[:, None]
    middle, off = 0.5 * (there.lo + there.hi), 0.5 * (there.hi - there.lo) + over.error
    assert over.slopes is not None
    below, above = (np.broadcast_to(s, moved.shape) for s in over.slopes)
    best: tuple[float, float, Form, float] | None = None
    for slope in _slopes(moved.T, middle) if np.all(np.isfinite(middle)) else [np.zeros(len(sides))]:
        steep = np.maximum(np.abs(above - slope[:, None]), np.abs(below - slope[:, None]))
        spread = np.where(reach > 0.0, steep * reach, 0.0).sum(0) + off
        height, line = middle - slope @ moved, np.abs(slope) @ reach
        size = np.abs(there.lo) + np.abs(there.hi) + np.abs(slope) @ np.abs(moved) + line
        slack = 64 * 2.0**-53 * (size + np.abs([spread, over.lo, over.hi]))
        ends_of_rest = height - spread - slack[0], height + spread + slack[0]
        shift = slope @ moved
        least = np.fmax(ends_of_rest[0], over.lo - shift - line - slack[1]).min()
        most = np.fmin(ends_of_rest[1], over.hi - shift + line + slack[2]).max()
        if best is None or most - least < best[1] - best[0]:
            best = float(least), float(most), slope, float(size.max())
    assert best is not None
    least, most, slope, size = best
    error = 0.5 * (most - least) + 64 * 2.0**-53 * size
    return _planes(sides, slope[:, None], np.array([0.5 * (least + most)]), np.array([error]))


def _between_rules(rules: Form, sides: Sequence[Form]) -> Form:
    """Return a form of any average of coefficients times the inputs."""
    totals: list[Form] = []
    for rule in rules:
        total: Value = 0.0
        for slope, side in zip(rule, sides, strict=True):
            total = forms.plus(total, forms.times(slope[None], side))
        totals.append(as_form(total))
    mean = as_form(forms.scaled(sum(totals[1:], totals[0]), 1.0 / len(totals)))
    most = np.max([np.abs(np.stack(ends(forms.minus(t, mean)))).max(0) for t in totals], 0)
    out = mean.copy()
    out[..., 1] = most
    return forms.padded(out, most)


def _planes(sides: Sequence[Form], slopes: Form, middle: Form, error: Form) -> Form:
    """Return forms of middle + sum of slope (side - its centre), one slope of each side for each box."""
    out = np.zeros_like(sides[0])
    size = np.abs(middle) + error
    for side, slope in zip(sides, slopes, strict=True):
        part = side * slope[:, None]
        out[:, 1] += np.abs(part[:, 1])
        out[:, 2:] += part[:, 2:]
        size = size + np.abs(part[:, 1:]).sum(-1)
    out[:, 0] = middle
    out[:, 1] += error
    return forms.padded(out, size * len(sides))


#: About how many parts a set is cut into, and at most; how often those that may have no value are cut again.
_PARTS: Final = 64
_MOST_PARTS: Final = 1024
_ROUNDS: Final = 4
#: Symbols along whose directions parts are tried that may not meet a set.
_LINES: Final = 6
#: Slabs that a plane set is cut into.
SLABS: Final = 12
#: By which part of its size corners of a plane set may be misplaced by rounding.
_ASIDE: Final = 1e-12


def _over_slabs(values: Form, knots: Sequence[Form], sides: Sequence[Form]) -> tuple[Form, Form]:
    """Return points, shape (points, inputs), and heights of a multilinear function there.

    On a part of a cell of the grid the function less a plane is multilinear, so that its extremes lie at corners. The
    corners of boxes are returned that together hold the set of the inputs, each cut at the knots.
    """
    ranges = [ends(s) for s in sides]
    if len(sides) == 2:
        x, low, high = _slabs(sides[0], sides[1], knots[0])
        y = np.clip(knots[1], low[:, None], high[:, None])
        y = np.concatenate([low[:, None], y, high[:, None]], 1)
        xs = np.stack([x[:-1], x[1:]], 1)
        shape = (len(low), 2, y.shape[1])
        points = np.stack([np.broadcast_to(xs[:, :, None], shape), np.broadcast_to(y[:, None, :], shape)], -1)
        points = points.reshape(-1, 2)
    else:
        axes = [
            np.array([float(low), *(k for k in axis if low < k < high), float(high)])
            for axis, (low, high) in zip(knots, ranges, strict=True)
        ]
        points = np.stack([m.reshape(-1) for m in np.meshgrid(*axes, indexing="ij")], -1)
    return points, _interpolated(values, knots, points)


def _slabs(x: Form, y: Form, knots: Form) -> tuple[Form, Form, Form]:
    """Return the ends of slabs of x, and in each the least and the largest y of the set of both."""
    (low, high), steps = ends(x), np.stack([x[2:], y[2:]], -1)
    steps = np.concatenate([steps, [[x[1], 0.0], [0.0, y[1]]]])
    steps = steps[np.abs(steps).sum(1) > 0.0]
    cuts = np.linspace(low, high, SLABS + 1)
    cuts = np.unique(np.concatenate([cuts, np.clip(knots, low, high)]))
    if len(cuts) == 1:
        cuts = np.array([low, high])
    bottom, top = ends(y)
    if not len(steps) or not high > low:
        return cuts, np.full(len(cuts) - 1, bottom), np.full(len(cuts) - 1, top)
    turned = np.where((steps[:, :1] < 0.0) | ((steps[:, :1] == 0.0) & (steps[:, 1:] < 0.0)), -steps, steps)
    order = np.argsort(np.arctan2(turned[:, 1], turned[:, 0]))
    # All relative to the centre, where a narrow set has digits left.
    first = -turned.sum(0)
    lower = first + 2.0 * np.concatenate([[[0.0, 0.0]], np.cumsum(turned[order], 0)])
    upper = first + 2.0 * np.concatenate([[[0.0, 0.0]], np.cumsum(turned[order[::-1]], 0)])
    beside, slack = _ASIDE * np.abs(turned).sum(0)
    slack += 8 * 2.0**-53 * abs(y[0])
    begin, end = cuts[:-1] - x[0] - beside, cuts[1:] - x[0] + beside
    least, most = _least(lower, begin, end), -_least(upper * [1.0, -1.0], begin, end)
    return cuts, np.maximum(y[0] + least - slack, bottom), np.minimum(y[0] + most + slack, top)


def _least(line: Form, begin: Form, end: Form) -> Form:
    """Return the least heights of a convex line over ranges, given its corners from left to right."""
    lowest = line[np.argmin(line[:, 1])]
    at_side = np.interp(np.where(end < lowest[0], end, begin), line[:, 0], line[:, 1])
    return np.where((begin <= lowest[0]) & (lowest[0] <= end), lowest[1], at_side)


def _interpolated(values: Form, knots: Sequence[Form], points: Form) -> Form:
    """Return a multilinear function at some points, shape (points,)."""
    heights = np.zeros(len(points))
    places = []
    for axis, k in enumerate(knots):
        at = np.clip(points[:, axis], k[0], k[-1])
        index = np.clip(np.searchsorted(k, at, "right") - 1, 0, max(len(k) - 2, 0))
        share = (at - k[index]) / (k[index + 1] - k[index]) if len(k) > 1 else np.zeros(len(at))
        places.append((index, share))
    for corner in product((0, 1), repeat=len(knots)):
        weight = np.ones(len(points))
        where = []
        for (index, share), up, k in zip(places, corner, knots, strict=True):
            weight = weight * (share if up else 1.0 - share)
            where.append(np.minimum(index + up, len(k) - 1))
        heights += weight * values[tuple(where)]
    return heights


def _slopes(points: Form, heights: Form) -> list[Form]:
    """Return candidates for the slopes of a plane near some heights; points are relative to the centre."""
    size = np.abs(points).max(0)
    scale = np.where(size > 0.0, size, 1.0)
    columns = np.concatenate([points / scale, np.ones((len(points), 1))], 1)
    fitted = np.linalg.lstsq(columns, heights, rcond=1e-9)[0][:-1] / scale
    return [np.where(size > 0.0, fitted, 0.0), np.zeros(len(scale))]
