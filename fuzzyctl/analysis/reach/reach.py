"""Reachable sets of a loop: the controllers at their samples, the plants between them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Final

import numpy as np

from fuzzyctl.analysis.reach import forms
from fuzzyctl.analysis.reach.flow import Flow, NoTubeError
from fuzzyctl.analysis.reach.forms import DomainError, Form, Mask, Value, as_form, ends, hulled, interval, padded
from fuzzyctl.analysis.reach.series import Nodes, Series
from fuzzyctl.analysis.reach.sets import is_long, modes, reduced, with_symbols
from fuzzyctl.analysis.reach.slopes import MOST, Slopes
from fuzzyctl.analysis.reach.surfaces import SystemSurface
from fuzzyctl.expr import Expr, Name, names_in
from fuzzyctl.kernels.plan.equations import Evaluation
from fuzzyctl.model.loop import TIME
from fuzzyctl.simulation.equations import LoopEquations, PlantState, reached, without_adaptation
from fuzzyctl.simulation.expansion import free_name
from fuzzyctl.simulation.members import Tube

#: After how many samples a step of half as many parts is tried again, and most parts of a step.
_RETRY: Final = 16
MOST_SUBSTEPS: Final = 256
#: Samples of a run that are seen as a line.
_SEEN: Final = 400
#: Terms of the series of the derivatives of a step.
_TERMS: Final = 8
#: How often the step is cut for them at most.
_PARTS: Final = 64

Checkpoint = Callable[[int, list[Form]], list[Form] | None]


@dataclass
class Step:
    """The set over a part of a step.

    Args:
        time: At its begin [s].
        length: Its length [s].
        truths: For each condition masks of the boxes in which it surely holds, and surely fails, over the step.
        states: Forms of the plants' states over it.
        memory: Forms of the controllers' states over it.
        outputs: Ends of the outputs of plants over its stretches of equal length, shape (stretches, boxes) or
            (stretches, 1), by name.
    """

    time: float
    length: float
    truths: list[tuple[Mask, Mask]]
    states: list[Form]
    memory: list[Form]
    outputs: dict[str, tuple[Form, Form]]
    #: Returns the set at its begin; None if it has no length.
    begin: Callable[[], Step] | None = None


@dataclass
class Record:
    """The outputs of plants over the steps of some boxes."""

    outputs: list[str]
    steps: list[Step] = field(default_factory=list)

    def add(self, step: Step) -> None:
        """Keep the outputs of a step."""
        if step.length:
            self.steps.append(replace(step, truths=[], states=[], memory=[], begin=None))

    def tube(self, boxes: Sequence[int]) -> Tube:
        """Return the hull over some of the boxes."""
        if not self.steps:
            return Tube(np.zeros(0), np.zeros(0), {})
        names = [n for n in self.outputs if all(n in s.outputs for s in self.steps)]
        bounds = {}
        for name in names:
            low = [part[boxes].min() if len(part) > 1 else part[0] for s in self.steps for part in s.outputs[name][0]]
            high = [part[boxes].max() if len(part) > 1 else part[0] for s in self.steps for part in s.outputs[name][1]]
            bounds[name] = np.array(low), np.array(high)
        count = len(bounds[names[0]][0]) // len(self.steps) if names else 1
        starts = [s.time + k * s.length / count for s in self.steps for k in range(count)]
        return Tube(np.array(starts), np.array([*starts[1:], self.steps[-1].time + self.steps[-1].length]), bounds)


class LeavesRangeError(Exception):
    """Raised if a state of a plant may leave its range in a ball."""


class ReachableSets:
    """Encloses all runs of a loop.

    Args:
        equations: The loop, with the expressions that claims compare as its signals `#0`, `#1` and so on.
        count: How many of these there are.
        given: Columns that are known before the run, shape (samples, columns).
        outputs: Names of the outputs of plants that steps enclose, too, where they can.
    """

    def __init__(self, equations: LoopEquations, count: int, given: Form, outputs: Sequence[str] = ()) -> None:
        if equations.delays:
            raise DomainError("the loop has dead times, whose past is not part of its states")
        if equations.externals:
            raise DomainError(f"the equations of block '{equations.externals[0].block}' are not known")
        if np.isnan(given).any():
            raise DomainError("a column that is given has missing values")
        equations = without_adaptation(equations)
        self.equations, self.given = equations, given
        #: All expressions of the loop.
        self.expressions = [
            *(e for i in equations.body for e in (i.arguments if isinstance(i, Evaluation) else (i.value,))),
            *(s.derivative for s in equations.plant_states),
            *equations.updates,
            *(equations.signals[f"#{k}"] for k in range(count)),
        ]
        self.free = [free_name(n) for n in equations.free]
        surfaces: dict[object, SystemSurface] = {}
        tables = {}
        for item in equations.body:
            if isinstance(item, Evaluation):
                surfaces.setdefault(item.system, SystemSurface(item.system))
                tables[id(item)] = surfaces[item.system]
        plant = [s.name for s in equations.plant_states]
        memory = [s.name for s in equations.states]
        columns = [n for names in equations.given for n in names]
        claims = [equations.signals[f"#{k}"] for k in range(count)]
        visible = [equations.signals[n] for n in outputs]
        derivatives: list[Expr] = [s.derivative for s in equations.plant_states]
        # A claim may use functions that are not smooth: the flow has only the equations that the derivatives need.
        (between, inputs), (claimed, compared) = reached(equations, derivatives), reached(equations, claims)
        drawn, read = reached(equations, visible)
        self.held = list(dict.fromkeys([*inputs, *compared, *read]))
        shared = [TIME, *plant]
        acting = dict(equations.disturbances)
        body = [i for i in equations.body if isinstance(i, Evaluation) or i.name not in acting]
        between, claimed, drawn = (
            [i for i in items if isinstance(i, Evaluation) or i.name not in acting]
            for items in (between, claimed, drawn)
        )
        fixed = [*self.held, *self.free, *(c for c in columns if c not in self.held), *memory, *acting]
        self.spread = [0.5 * (high - low) + 1e-15 * (abs(low) + abs(high)) for low, high, _ in acting.values()]
        self.centres = [0.5 * (high + low) for low, high, _ in acting.values()]
        nodes = Nodes([*shared, *fixed], between, derivatives, tables)
        self.flow = Flow(nodes, len(plant), Slopes(nodes, [*plant, *acting]) if acting else None, self.spread)
        self.claims = Nodes([*shared, *fixed], claimed, [], tables)
        for condition in claims:
            self.claims.ask(condition)
        #: How many stretches of a step show its outputs: more where there are few steps.
        self.stretches = 4 if equations.samples < _SEEN else 1
        self.outputs, self.shown = list(outputs), Nodes([*shared, *fixed], drawn, visible, tables)
        inputs = [*shared, *memory, *self.free, *columns, *equations.rates, *acting, *equations.errors]
        self.sample = Nodes(inputs, body, [*map(Name, self.held), *equations.updates], tables)
        self.plant, self.memory, self.columns = plant, memory, columns

    def _truths(self, values: Sequence[Value]) -> list[tuple[Mask, Mask]]:
        series = Series(self.claims, values)
        series.extend()
        return series.truths()

    def _shown(self, values: Sequence[Value]) -> dict[str, tuple[Form, Form]]:
        """Return the outputs over the stretches of a step, whose time is the first value."""
        try:
            results = Series(self.shown, values).extend()
        except DomainError:  # which a claim about the output reports
            return {}
        width, count = as_form(values[0]).shape[-1], self.stretches
        parts = [[_over_part(r, width, k, count) for k in range(count)] for r in results]
        pairs = ([ends(part) for part in row] for row in parts)
        return {
            name: (np.array([a for a, _ in row]), np.array([b for _, b in row]))
            for name, row in zip(self.outputs, pairs, strict=True)
        }

    def _instant(self, time: float, x: list[Form], m: list[Form], constants: Sequence[Value]) -> Step:
        at = [time, *x, *constants]
        return Step(time, 0.0, self._truths(at), x, m, self._shown(at))

    def run(
        self,
        x: list[Form],
        m: list[Form],
        free: Sequence[Value],
        kept: int,
        periods: Checkpoint | None = None,
        first: int = 0,
    ) -> Iterator[Step]:
        """Yield the sets over the steps of a run.

        Args:
            x, m: Forms of the plants' and the controllers' states at the begin, shape (boxes, 2 + symbols).
            free: Values of the free params.
            kept: How many of the first symbols are never reduced.
            periods: Called before each sample but the first with its number and the states, those of plants first;
                returns the states to go on with, or None to end a run that has no other end.
            first: Number of the first sample.

        Raises:
            DomainError, NoTubeError: If no enclosure is known.
        """
        equations, step = self.equations, self.equations.step
        before: list[Form] = []
        acting: list[Value] = [np.array([[c, s]]) for c, s in zip(self.centres, self.spread, strict=True)]
        errors: list[Value] = [np.array([[0.0, e]]) for e in equations.errors.values()]
        count = 1
        for k in itertools.count(first):
            time = k * step
            columns = [float(v) for v in self.given[k]] if self.columns else []
            values = [_number(a) for a in m]
            inputs = [time, *x, *values, *free, *columns, *self.flags(k), *acting, *errors]
            results = Series(self.sample, inputs).extend()
            outputs, updates = results[: len(self.held)], results[len(self.held) :]
            other = [v for n, v in zip(self.columns, columns, strict=True) if n not in self.held]
            constants: list[Value] = [*outputs, *free, *other, *values]
            if k + 1 == equations.samples and periods is None:
                yield self._instant(time, x, m, [*constants, *acting])
                return
            part, count = 0, max(count // 2, 1) if k % _RETRY == 0 else count
            while part < count:
                length = step / count
                begin = time + part * length
                try:
                    end, over = self.flow.advance(begin, length, x, [*constants, *self.centres])
                except NoTubeError:
                    if count >= MOST_SUBSTEPS:
                        raise
                    count, part = 2 * count, 2 * part
                    continue
                width = over[0].shape[-1] if over else 2
                at = [_over(begin, length, width), *over, *constants, *acting]
                start = partial(self._instant, begin, x, m, [*constants, *acting])
                yield Step(begin, length, self._truths(at), over, m, self._shown(at), start)
                x, part = end, part + 1
            boxes = max(a.shape[0] for a in (*x, *m))
            m = [np.broadcast_to(u, (boxes, u.shape[-1])) for u in map(as_form, updates)]
            rows = with_symbols([*x, *m], kept)
            if is_long(rows, kept):
                rows = reduced(rows, kept, modes(before, rows) if before else None)
            before = rows
            if periods is not None:
                changed = periods(k + 1, rows)
                if changed is None:
                    return
                before, rows = rows if changed is rows else [], changed
            x, m = rows[: len(x)], rows[len(x) :]

    @property
    def cycle(self) -> int:
        """After how many samples all controllers sample together again."""
        return math.lcm(*self.equations.rates.values())

    def flags(self, k: int) -> list[float]:
        """Return the values of the flags at a sample, see `LoopEquations.rates`."""
        return [1.0 if k % n == 0 else 0.0 for n in self.equations.rates.values()]

    def why_aperiodic(self) -> str:
        """Return why the loop is not the same at each period, an empty text if it is."""
        if self.equations.given or any(n.name == TIME for e in self.expressions for n in names_in(e)):
            return "the loop depends on the time, so that no set of its states says what comes after it"
        return ""


def image(sets: ReachableSets, rows: Sequence[Form], free: Sequence[Value], phase: int = 0) -> list[Form]:
    """Return the states a period later than the sample of a number."""
    count = len(sets.plant)
    results: list[list[Form]] = []

    def keep(_: int, states: list[Form]) -> None:
        results.append(states)

    for _ in sets.run(list(rows[:count]), list(rows[count:]), free, 0, keep, phase):
        pass
    return results[-1]


def flow_slopes(
    sets: ReachableSets, rows: Sequence[Value], free: Sequence[Value], about: Sequence[Value] | None = None
) -> Form:
    """Return the vertices of the derivatives of a loop without controllers, see `period_slopes`."""
    _require_ranges(sets, rows)
    beside = None if about is None else [0.0, *about, *free]
    return Slopes(sets.flow.nodes, sets.plant).vertices([0.0, *rows, *free], beside)


def period_slopes(
    sets: ReachableSets,
    rows: Sequence[Value],
    free: Sequence[Value],
    about: Sequence[Value] | None = None,
    phase: int = 0,
    most: int = MOST,
) -> Form:
    """Return the vertices of the derivatives of the states after a period by those at its begin.

    Between samples the derivatives X of a plant's states by something obey X' = A X + B with A and B those of the
    equations along the solution: X is enclosed by the series of Peano and Baker, whose integrals lie in the products of
    the intervals that hold A and B. The vertices are those of the controllers.

    Args:
        sets: The loop.
        rows: A box of states.
        free: Values of its free params.
        about: A point of the box for chords from there in place of derivatives.
        phase: Number of the sample at the begin: it decides which controllers run.
        most: How many vertices to return at most.

    Returns:
        Shape (vertices, states, states, 2).
    """
    count, size = len(sets.plant), len(rows)
    plant, memory = [as_form(r) for r in rows[:count]], list(rows[count:])
    flags = sets.flags(phase)
    inputs: list[Value] = [0.0, *plant, *memory, *free, *flags]
    beside = None if about is None else [0.0, *about, *free, *flags]
    control = Slopes(sets.sample, [*sets.plant, *sets.memory]).vertices(inputs, beside, most)
    if not count:
        return control[:, len(sets.held) :]
    results = Series(sets.sample, inputs).extend()
    outputs = [as_form(v) for v in results[: len(sets.held)]]
    length = sets.equations.step
    tube, parts = plant, 1
    while True:
        try:
            tube = _tubes(sets, plant, [*outputs, *free, *memory], parts)
            break
        except NoTubeError:
            if parts >= _PARTS:
                raise
            parts *= 2
    _require_ranges(sets, tube)
    between = Slopes(sets.flow.nodes, [*sets.plant, *sets.held])
    slopes = between.over([np.array([[0.5 * length, 0.5 * length]]), *tube, *outputs, *free, *memory])
    a, b = slopes[:, :count], slopes[:, count:]
    identity = np.stack([np.eye(count), np.zeros((count, count))], -1)
    moved = _series(a, identity, length, 1)
    by_held = _driven(a, b, length)
    total = np.zeros((len(control), size, size, 2))
    total[:, :count] = _product(by_held, control[:, : len(outputs)])
    total[:, :count, :count] = as_form(forms.plus(moved, total[:, :count, :count]))
    total[:, count:] = control[:, len(outputs) :]
    return total


def _require_ranges(sets: ReachableSets, rows: Sequence[Value]) -> None:
    for state, row in zip(sets.equations.plant_states, rows, strict=False):
        low, high = (float(e[0]) for e in ends(row))
        if not (state.holds(low) and state.holds(high)):
            raise LeavesRangeError(f"state '{state.name}' may leave its range: it lies in [{low:.4g}, {high:.4g}]")


def _tubes(sets: ReachableSets, plant: Sequence[Form], constants: Sequence[Value], parts: int) -> list[Form]:
    """Return intervals that hold the plants' states over a whole period."""
    length = sets.equations.step / parts
    states = list(plant)
    low: list[list[Form]] = []
    high: list[list[Form]] = []
    for part in range(parts):
        tube, _ = sets.flow.tube(part * length, length, states, constants)
        end, _ = sets.flow.advance(part * length, length, states, constants)
        states = [hulled(e) for e in end]
        for ends_of, at in ((low, 0), (high, 1)):
            ends_of.append([ends(t)[at] for t in tube])
    least, most = np.array(low).min(0), np.array(high).max(0)
    return [interval(a, b) for a, b in zip(least, most, strict=True)]


def _series(a: Form, first: Form, length: float, divisor: int) -> Form:
    """Return bounds of the sum of A^k F length^k / (divisor (divisor + 1) ...), the first term being F.

    With F = 1 and the divisor 1 it holds X(length) for X' = A X from X = 1; with F = B length and the divisor 2 that
    for X' = A X + B from X = 0. Each term is an integral of products of A, or of A and B, at different times, which
    lies in the product of the intervals: so B is a factor of each term, not of their sum.
    """
    size = len(a)
    term, total = first, first
    for _ in range(_TERMS):
        term = as_form(forms.scaled(_product(a, term), length / divisor))
        total = as_form(forms.plus(total, term))
        divisor += 1
    norm = float(np.max(np.abs(a[..., 0]) + a[..., 1], initial=0.0)) * size * length
    if not norm <= 0.5 * divisor:
        raise NoTubeError
    rest = total.copy()
    last = float(np.max(np.abs(term[..., 0]) + term[..., 1], initial=0.0))
    rest[..., 1] += 2.0 * last * size * norm / divisor + 1e-300
    return rest


def _driven(a: Form, b: Form, length: float) -> Form:
    """Return bounds of X(length) for X' = A X + B from X = 0."""
    return _series(a, as_form(forms.scaled(b, length)), length, 2)


def _product(a: Form, b: Form) -> Form:
    """Return the product of matrices of intervals, shapes (..., rows, n, 2) and (..., n, columns, 2)."""
    total: Value = np.zeros((*b.shape[:-3], a.shape[-3], b.shape[-2], 2))
    for k in range(a.shape[-2]):
        total = forms.plus(total, forms.times(a[..., :, k, None, :], b[..., None, k, :, :]))
    return as_form(total)


def within(state: PlantState, low: Form, high: Form) -> Mask:
    """Return whether all values of a state surely lie in its range."""
    above = low > state.low if state.without_low else low >= state.low
    return above & (high < state.high if state.without_high else high <= state.high)


def _number(a: Form) -> Value:
    """Return a form of one number as this number, so that counters stay exact."""
    return float(a[0, 0]) if not a[:, 1:].any() and bool(np.all(a[:, 0] == a[0, 0])) else a


def _over_part(a: Value, width: int, part: int, count: int) -> Value:
    """Return a form over one of several parts of a step; the last of `width` columns is the time."""
    if isinstance(a, float) or a.shape[-1] < width:
        return a
    a = a.copy()
    a[..., 0] += a[..., -1] * ((2 * part + 1) / count - 1.0)
    a[..., -1] /= count
    return padded(a, np.abs(a[..., 0]))


def _over(begin: float, length: float, width: int) -> Form:
    """Return the times of a step; the last symbol is the time."""
    time = np.zeros((1, width))
    time[0, 0], time[0, -1] = begin + 0.5 * length, 0.5 * length
    return padded(time, begin + length)
