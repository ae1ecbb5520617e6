"""Proofs that every member of a family converges: the map of a period contracts a set that holds all of them.

All states of a loop, those of plants and controllers, are one vector z; a period maps z to F(z). The derivatives of F
over a ball D of some norm lie in the convex hull of a few matrices, the vertices. If each is at most q < 1 in this
norm, and F maps D into itself, then F has one fixed point in D, and each run that is in D converges to it, its distance
shrinking by q each period (Banach). Without controllers the loop is a differential equation z' = f(z): its vertices
are derivatives of f, and distances shrink at the rate of the largest logarithmic norm of them.

The norm is |B^-1 z|, that is sqrt(z' P z) with P = (B B')^-1: its square is a quadratic Lyapunov function that all
vertices have in common. The columns of B are the modes of the loop; if these do not do, P is the analytic centre of the
matrix inequalities, by a barrier method. Both only propose: rational arithmetic decides.

Source:
    Lohmiller, Slotine: On contraction analysis for non-linear systems, 1998; Banach's fixed-point theorem; Boyd, El
    Ghaoui, Feron, Balakrishnan: Linear Matrix Inequalities in System and Control Theory, 1994 (5.1: common quadratic
    functions of polytopes; 2.4: barriers).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Final, NamedTuple

import numpy as np

from fuzzyctl.analysis.reach import forms
from fuzzyctl.analysis.reach.flow import NoTubeError
from fuzzyctl.analysis.reach.forms import DomainError, Form, Value, as_form, ends, hulled, interval
from fuzzyctl.analysis.reach.reach import ReachableSets
from fuzzyctl.analysis.reach.series import Series, is_zero
from fuzzyctl.analysis.reach.slopes import Slopes
from fuzzyctl.analysis.work import clock

#: Terms of the series of the derivatives of a step.
_TERMS: Final = 8
#: How often the step is cut for them at most.
_PARTS: Final = 64
#: How often a ball is widened, and norms that are tried.
_BALLS: Final = 4
_NORMS: Final = 3
#: How near a point of rest is to the centre, as a part of the radius of a ball.
_NEAR: Final = 1e-6
#: Weights of the barrier method: the first, the factor, and how many; steps of Newton for each.
_FIRST: Final = 1.0
_FACTOR: Final = 8.0
_WEIGHTS: Final = 8
_NEWTON: Final = 12


class Contraction(NamedTuple):
    """A ball that a period maps into itself.

    Args:
        rate: The largest factor by which distances shrink in a period.
        radius: The radius of the ball in the coordinates.
        centre: Of the states, those of plants first.
        basis: Columns: the coordinates. The Lyapunov function is z' P z with P = (basis basis')^-1.
        vertices: Derivatives whose convex hull holds all over the ball, centres and radii, shape (vertices, states,
            states, 2): of the map of a period, or of a differential equation.
        continuous: Whether they are those of a differential equation.
        to_rest: Whether they are chords from a point of rest, so that distances to it shrink, in place of derivatives.
    """

    rate: float
    radius: float
    centre: Form
    basis: Form
    vertices: Form
    continuous: bool
    to_rest: bool

    def rows(self, kept: int) -> list[Form]:
        """Return a parallelotope that holds the ball and a larger one around a point of rest, see `_contracted`.

        Args:
            kept: How many symbols of other signals come first.
        """
        spread = self.basis * self.radius * (1.0 + 3.0 * _NEAR)
        slack = 1e-12 * (1.0 + np.abs(self.centre))
        whole = [self.centre[:, None], slack[:, None], np.zeros((len(self.centre), kept)), spread]
        return list(np.concatenate(whole, 1)[:, None, :])


class LeavesRangeError(Exception):
    """Raised if a state of a plant may leave its range in a ball."""


def contraction(
    sets: ReachableSets, rows: Sequence[Form], free: Sequence[Value], motion: tuple[Form, Form] | None, until: float
) -> Contraction | None:
    """Return a ball that holds some states, and that a period of the loop contracts; None if none is proved.

    Args:
        sets: The loop, its equations without time.
        rows: The states of one box.
        free: Values of its free params.
        motion: How a set moves in a period, see `sets.modes`.
        until: Processor seconds at which the time is over.

    Raises:
        DomainError, NoTubeError, LeavesRangeError: If no bound of the derivatives is known there.
    """
    whole = np.stack(rows)[:, 0, :]
    sizes = np.abs(whole[:, 1:]).sum(1)
    # Not the norm of a mode, which underflows for states that stay constant.
    basis = np.diag(np.where(sizes > 0.0, sizes, sizes.max() or 1.0)) if motion is None else motion[1]
    largest = np.abs(basis).max(0)
    basis = basis / np.where(largest > 0.0, largest, 1.0)
    fixed = [hulled(as_form(f)) for f in free]
    loop = _Family(sets, fixed, bool(sets.plant) and not sets.memory and not sets.held, until)
    outcome: Contraction | Form = np.zeros((0, len(whole), len(whole), 2))
    refusal: DomainError | None = None
    try:
        outcome = _searched(loop, whole, whole[:, 0], basis, None)
    except DomainError as error:  # chords may have a bound where derivatives have none
        refusal = error
    if not isinstance(outcome, Contraction):
        rest = loop.rest(whole, outcome)
        if rest is not None:
            outcome = _searched(loop, whole, *rest)
        elif refusal is not None:
            raise refusal
    return outcome if isinstance(outcome, Contraction) else None


def sectors(sets: ReachableSets, free: Sequence[Value], ball: Contraction) -> list[str]:
    """Return the sectors of tables of one input over a ball, in words, see `Slopes.sectors`."""
    reach = np.sqrt((ball.basis**2).sum(1)) * ball.radius
    loop = _Family(sets, [hulled(as_form(f)) for f in free], ball.continuous, math.inf)
    rows, about = loop.around(ball.centre, reach), loop.around(ball.centre, None)
    if ball.continuous:
        return Slopes(sets.flow.nodes, sets.plant).sectors(*([0.0, *v, *loop.free] for v in (rows, about)))
    flags = [1.0] * len(sets.equations.rates)
    states = [*sets.plant, *sets.memory]
    return Slopes(sets.sample, states).sectors(*([0.0, *v, *loop.free, *flags] for v in (rows, about)))


def _searched(loop: _Family, whole: Form, centre: Form, basis: Form, beside: float | None) -> Contraction | Form:
    """Return a ball around a centre that holds a set and contracts, or the vertices over the last ball that was tried.

    Args:
        loop: The loop.
        whole: The set, one row for each state.
        centre: The centre.
        basis: The coordinates to begin with.
        beside: None for derivatives; else for chords from the point of rest, which is the centre for 0, or lies in a
            ball around it of this part of the radius.
    """
    apart = np.concatenate([(whole[:, 0] - centre)[:, None], whole[:, 1:2] * np.eye(len(whole)), whole[:, 2:]], 1)
    vertices: Form = np.zeros((0, len(whole), len(whole), 2))
    for _ in range(_NORMS):
        exact = _inverted([[Fraction(x) for x in row] for row in basis.tolist()]) if np.isfinite(basis).all() else None
        if exact is None:
            return vertices
        inverse = np.array([[float(x) for x in row] for row in exact])
        sides = np.abs(inverse @ apart).sum(1) + 1e-14 * (np.abs(inverse) @ np.abs(apart)).sum(1)
        radius = float(np.sqrt((sides**2).sum())) * (1.0 + 1e-9) + 1e-300
        outcome = _contracted(loop, centre, basis, inverse, radius, beside)
        if isinstance(outcome, Contraction):
            return outcome
        vertices = outcome
        proposed = common_basis(vertices[..., 0], basis, loop.continuous)
        if proposed is None:
            return vertices
        basis = proposed
    return vertices


def _contracted(
    loop: _Family, centre: Form, basis: Form, inverse: Form, radius: float, beside: float | None
) -> Contraction | Form:
    """Return a ball of at least a radius that contracts, or the vertices over one that does not.

    Raises:
        DomainError, NoTubeError, LeavesRangeError: If no bound of the derivatives is known there.
    """
    bound, limit = (growth_bound, 0.0) if loop.continuous else (norm_bound, 1.0)
    lengths = np.sqrt((basis**2).sum(1)) * (1.0 + 1e-9)
    drift = 0.0 if beside == 0.0 else loop.drift(centre, inverse)
    for _ in range(_BALLS):
        near = radius * (beside or 0.0)  # how far the point of rest may be from the centre
        about = None if beside is None else loop.around(centre, lengths * near if near else None)
        reach = lengths * (radius + 2.0 * near) + 1e-12 * (1.0 + np.abs(centre))
        vertices = loop.vertices(loop.around(centre, reach), about)
        if not proposed_bound(vertices, basis, inverse, loop.continuous) < limit:
            return vertices
        rate = max(bound(v, basis) for v in vertices)
        if not rate < limit:
            return vertices
        needed = drift / (limit - rate) * (1.0 + 1e-9)
        if needed <= (near if beside is not None else radius):
            factor = math.exp(rate * loop.sets.equations.step) if loop.continuous else rate
            return Contraction(factor, radius, centre, basis, vertices, loop.continuous, beside is not None)
        if beside is not None:
            return vertices
        radius = 1.05 * needed
    return vertices


class _Family(NamedTuple):
    """A loop whose free params lie in some intervals.

    Args:
        sets: The loop.
        free: The intervals.
        continuous: Whether it is one differential equation.
        until: Processor seconds at which the time is over.
    """

    sets: ReachableSets
    free: Sequence[Form]
    continuous: bool
    until: float

    def around(self, centre: Form, reach: Form | None) -> list[Value]:
        """Return intervals around a centre, or the numbers themselves."""
        if reach is None:
            return [float(c) for c in centre]
        return [interval(np.array([c - w]), np.array([c + w])) for c, w in zip(centre, reach, strict=True)]

    def vertices(self, box: Sequence[Value], about: Sequence[Value] | None) -> Form:
        """Return the vertices over a box, see `flow_slopes` and `period_slopes`."""
        if clock.used() > self.until:
            raise DomainError("the time is over")
        return (flow_slopes if self.continuous else period_slopes)(self.sets, box, self.free, about)

    def moved(self, centre: Form) -> tuple[Form, Form]:
        """Return how far a point moves in a period at least and at most, or its rates."""
        rows: list[Value] = [np.array([[c, 0.0]]) for c in centre]
        if self.continuous:
            rates = Series(self.sets.flow.nodes, [0.0, *rows, *self.free]).extend()
            low, high = (np.array([float(e[0]) for e in x]) for x in zip(*map(ends, rates), strict=True))
            return low, high
        image = _image(self.sets, [as_form(r) for r in rows], self.free)
        low, high = (np.array([float(e[0]) for e in x]) for x in zip(*map(ends, image), strict=True))
        rounding = 1e-15 * np.abs(centre)
        return low - centre - rounding, high - centre + rounding

    def drift(self, centre: Form, inverse: Form) -> float:
        """Return how far a point moves at most, in the coordinates."""
        low, high = self.moved(centre)
        return float(np.linalg.norm(np.abs(inverse) @ np.maximum(np.abs(low), np.abs(high)))) * (1.0 + 1e-9)

    def rest(self, whole: Form, vertices: Form) -> tuple[Form, Form, float] | None:
        """Return a centre near a point of rest, coordinates, and how near, see `_searched`; None if none is known.

        0 is one if the equations say so in exact numbers; else steps of Newton propose one.
        """
        sizes = np.abs(whole).sum(1)
        basis = np.diag(np.where(sizes > 0.0, sizes, sizes.max() or 1.0))
        size, sets = len(whole), self.sets
        zeros: list[Value] = [0.0] * size
        if bool(np.all(np.abs(whole[:, 0]) <= np.abs(whole[:, 1:]).sum(1) * (1.0 + 1e-9))):
            count = 0 if self.continuous else len(sets.held)
            still = Series(sets.flow.nodes, [0.0, *zeros[: len(sets.plant)], *[0.0] * count, *self.free,
                                             *zeros[len(sets.plant) :]], exact=True).extend()  # fmt: skip
            if not self.continuous:
                flags = [1.0] * len(sets.equations.rates)
                still += Series(sets.sample, [0.0, *zeros, *self.free, *flags], exact=True).extend()
            if all(is_zero(v) for v in still):
                return np.zeros(size), basis, 0.0
        if not len(vertices):
            return None
        centre, slopes = whole[:, 0], vertices[..., 0].mean(0) - (0.0 if self.continuous else np.eye(size))
        for _ in range(3):
            low, high = self.moved(centre)
            try:
                centre = centre - np.linalg.solve(slopes, 0.5 * (low + high))
            except np.linalg.LinAlgError:
                return None
        return (centre, basis, _NEAR) if np.all(np.isfinite(centre)) else None


def _image(sets: ReachableSets, rows: Sequence[Form], free: Sequence[Value]) -> list[Form]:
    """Return the states after a period."""
    count = len(sets.plant)
    results: list[list[Form]] = []

    def keep(_: int, states: list[Form]) -> None:
        results.append(states)

    for _ in sets.run(list(rows[:count]), list(rows[count:]), free, 0, keep):
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
    sets: ReachableSets, rows: Sequence[Value], free: Sequence[Value], about: Sequence[Value] | None = None
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

    Returns:
        Shape (vertices, states, states, 2).
    """
    count, size = len(sets.plant), len(rows)
    plant, memory = [as_form(r) for r in rows[:count]], list(rows[count:])
    flags = [1.0] * len(sets.equations.rates)
    inputs: list[Value] = [0.0, *plant, *memory, *free, *flags]
    beside = None if about is None else [0.0, *about, *free, *flags]
    control = Slopes(sets.sample, [*sets.plant, *sets.memory]).vertices(inputs, beside)
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


def proposed_bound(vertices: Form, basis: Form, inverse: Form, continuous: bool) -> float:
    """Return about the largest bound of the vertices, see `norm_bound` and `growth_bound`."""
    middle = inverse @ vertices[..., 0] @ basis
    if not np.all(np.isfinite(middle)):
        return math.inf
    apart = np.sqrt(((np.abs(inverse) @ vertices[..., 1] @ np.abs(basis)) ** 2).sum((1, 2)))
    if continuous:
        return float((np.linalg.eigvalsh(middle + np.swapaxes(middle, 1, 2))[:, -1] / 2 + apart).max())
    return float((np.linalg.norm(middle, 2, (1, 2)) + apart).max())


def common_basis(centres: Form, basis: Form, continuous: bool) -> Form | None:
    """Return coordinates in which each of some matrices contracts, or nearly; None if a barrier method finds none.

    It maximises t subject to P <= 1 and P - M'PM >= t, or -(M'P + PM) >= t |M|, for the matrices M in the coordinates.

    Args:
        centres: The matrices, shape (vertices, n, n).
        basis: The coordinates to begin with.
        continuous: Whether they are of a differential equation.
    """
    n = len(basis)
    matrices = np.linalg.solve(basis, centres @ basis)
    if not np.all(np.isfinite(matrices)):
        return None
    rows, columns = np.triu_indices(n)
    units = np.zeros((len(rows), n, n))
    units[range(len(rows)), rows, columns] = units[range(len(rows)), columns, rows] = 1.0
    turned = np.swapaxes(matrices, 1, 2)[:, None]
    if continuous:
        moved = turned @ units
        moved = (
            -(moved + np.swapaxes(moved, 2, 3)) / (np.linalg.norm(matrices, 2, (1, 2)) + 1e-300)[:, None, None, None]
        )
    else:
        moved = units - turned @ units @ matrices[:, None]
    linear = np.concatenate([moved, -units[None], units[None]])  # and P <= 1, P >= 0
    constant = np.zeros((len(linear), n, n))
    constant[-2] = np.eye(n)
    slack = np.zeros((len(linear), 1, n, n))
    slack[:-2, 0] = -np.eye(n)
    linear = np.concatenate([linear, slack], 1)
    y = np.append(0.5 * (rows == columns), 0.0)

    def sides(y: Form) -> Form:
        return np.asarray(constant + np.einsum("k,vkij->vij", y, linear))

    y[-1] = float(np.linalg.eigvalsh(sides(y)[:-2])[:, 0].min()) - 1.0
    weight = _FIRST
    try:
        for _ in range(_WEIGHTS):
            y = _centred(sides, linear, y, weight)
            weight *= _FACTOR
        root = np.linalg.cholesky(np.einsum("k,kij->ij", y[:-1], units))
    except np.linalg.LinAlgError:  # its numbers have no digits left
        return None
    if not y[-1] > 0.0:
        return None
    wanted = basis @ np.linalg.inv(root).T
    return np.asarray(wanted / np.abs(wanted).max())


def _centred(sides: Callable[[Form], Form], linear: Form, y: Form, weight: float) -> Form:
    """Return where -weight t - log det of the sides of matrix inequalities is least, by Newton; t is last in y.

    Raises:
        LinAlgError: If a step has no digits.
    """
    for _ in range(_NEWTON):
        factors = np.linalg.inv(np.linalg.cholesky(sides(y)))[:, None]
        steep = factors @ linear @ np.swapaxes(factors, 2, 3)
        flat = steep.swapaxes(0, 1).reshape(len(y), -1)
        gradient = -np.trace(steep, axis1=2, axis2=3).sum(0)
        gradient[-1] -= weight
        step = -np.linalg.solve(flat @ flat.T, gradient)
        decrement = float(-gradient @ step)
        if not decrement > 1e-4:
            break
        length = 1.0 / (1.0 + math.sqrt(decrement)) if decrement > 0.1 else 1.0
        while length > 1e-9 and float(np.linalg.eigvalsh(sides(y + length * step))[:, 0].min()) <= 1e-14:
            length *= 0.5
        if length <= 1e-9:
            break
        y = y + length * step
    return y


def norm_bound(slopes: Form, basis: Form) -> float:
    """Return a bound of the norm of all matrices J between some ends, as maps of vectors whose norm is |basis^-1 z|.

    Of the centre M the bound q is decided in rational arithmetic: q^2 - M' M is positive definite. Infinite for none.
    """
    turned = _turned(slopes, basis)
    if turned is None:
        return math.inf
    middle, apart = turned
    proposed = float(np.linalg.norm(np.array([[float(x) for x in row] for row in middle]), 2))
    q = Fraction(proposed) + Fraction(1, 1 << 40)
    gram = _matrix_product([list(column) for column in zip(*middle, strict=True)], middle)
    return float(q) + apart + 1e-15 if is_positive_definite(_from_diagonal(q * q, gram)) else math.inf


def growth_bound(slopes: Form, basis: Form) -> float:
    """Return a bound of the logarithmic norm of all matrices J between some ends, see `norm_bound`.

    Of the centre M the bound q is decided in rational arithmetic: 2 q - (M + M') is positive definite.
    """
    turned = _turned(slopes, basis)
    if turned is None:
        return math.inf
    middle, apart = turned
    columns = list(zip(*middle, strict=True))
    both = [[x + y for x, y in zip(*pair, strict=True)] for pair in zip(middle, columns, strict=True)]
    proposed = float(np.linalg.eigvalsh(np.array([[float(x) for x in row] for row in both]))[-1]) / 2
    q = Fraction(proposed) + Fraction(1 + abs(proposed)) / (1 << 40)
    rounding = 1e-15 * (1.0 + abs(float(q)))
    return float(q) + apart + rounding if is_positive_definite(_from_diagonal(2 * q, both)) else math.inf


def _turned(slopes: Form, basis: Form) -> tuple[list[list[Fraction]], float] | None:
    """Return the centre of matrices between some ends in some coordinates, and how far others lie from it at most."""
    exact_basis = [[Fraction(x) for x in row] for row in basis.tolist()]
    exact_inverse = _inverted(exact_basis)
    if exact_inverse is None or not np.all(np.isfinite(slopes)):
        return None
    centre = [[Fraction(x) for x in row] for row in slopes[..., 0].tolist()]
    middle = _matrix_product(exact_inverse, _matrix_product(centre, exact_basis))
    exact = np.array([[abs(float(x)) * (1.0 + 1e-15) for x in row] for row in exact_inverse])
    spread = exact @ slopes[..., 1] @ np.abs(basis) * (1.0 + 1e-12)
    return middle, float(np.sqrt((spread**2).sum())) * (1.0 + 1e-12)


def _from_diagonal(value: Fraction, matrix: Sequence[Sequence[Fraction]]) -> list[list[Fraction]]:
    """Return value times the unit matrix, less a matrix."""
    return [[(value if i == k else Fraction(0)) - x for k, x in enumerate(row)] for i, row in enumerate(matrix)]


def is_positive_definite(matrix: Sequence[Sequence[Fraction]]) -> bool:
    """Return whether a symmetric matrix is positive definite, by the pivots of its factors L D L'."""
    rows = [list(row) for row in matrix]
    for k in range(len(rows)):
        if rows[k][k] <= 0:
            return False
        for i in range(k + 1, len(rows)):
            factor = rows[i][k] / rows[k][k]
            for j in range(k, len(rows)):
                rows[i][j] -= factor * rows[k][j]
    return True


def _matrix_product(a: Sequence[Sequence[Fraction]], b: Sequence[Sequence[Fraction]]) -> list[list[Fraction]]:
    columns = list(zip(*b, strict=True))
    return [[sum((x * y for x, y in zip(row, c, strict=True)), Fraction(0)) for c in columns] for row in a]


def _inverted(matrix: Sequence[Sequence[Fraction]]) -> list[list[Fraction]] | None:
    """Return the inverse of a matrix, None if it has none."""
    size = len(matrix)
    rows = [[*row, *(Fraction(i == k) for k in range(size))] for i, row in enumerate(matrix)]
    for k in range(size):
        pivot = max(range(k, size), key=lambda i: abs(rows[i][k]))
        if rows[pivot][k] == 0:
            return None
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(size):
            if i != k and rows[i][k]:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [row[size:] for row in rows]
