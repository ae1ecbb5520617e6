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
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, Final, NamedTuple

import numpy as np

from fuzzyctl.analysis.reach.forms import DomainError, Form, Value, as_form, ends, hulled, interval
from fuzzyctl.analysis.reach.reach import ReachableSets, flow_slopes, image, period_slopes
from fuzzyctl.analysis.reach.series import Series, is_zero
from fuzzyctl.analysis.reach.slopes import MOST, Slopes
from fuzzyctl.analysis.work import clock

#: Most samples after which controllers of several rates sample together again.
MOST_CYCLE: Final = 64
#: Fewest vertices at each sample of a cycle that are allowed; the more samples, the fewer.
_FEWEST: Final = 8
#: Doublings of a series of powers of matrices.
_DOUBLINGS: Final = 40
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

#: A matrix of rational numbers.
Exact = list[list[Fraction]]


class Ball(NamedTuple):
    """The states z with |basis^-1 (z - centre)| <= radius, at one sample of a cycle.

    Args:
        centre: Of the states, those of plants first.
        basis: Columns: the coordinates. The Lyapunov function is z' P z with P = (basis basis')^-1.
        radius: The radius of the ball in the coordinates.
        near: How far a point of rest is from the centre at most; 0 unless distances to it shrink.
        rate: The largest factor by which distances shrink up to the next sample.
    """

    centre: Form
    basis: Form
    radius: float
    near: float
    rate: float


class Contraction(NamedTuple):
    """A ball that a cycle of samples maps into itself.

    Args:
        rate: The largest factor by which distances shrink in a cycle.
        balls: One for each sample of the cycle: each is mapped into the next one, the last into the first.
        continuous: Whether the loop is a differential equation.
        to_rest: Whether distances to a point of rest shrink, in place of all distances.
    """

    rate: float
    balls: tuple[Ball, ...]
    continuous: bool
    to_rest: bool

    def rows(self, kept: int) -> list[Form]:
        """Return a parallelotope that holds the first ball and a larger one around a point of rest, see `_contracted`.

        Args:
            kept: How many symbols of other signals come first.
        """
        ball = self.balls[0]
        spread = ball.basis * ball.radius * (1.0 + 3.0 * _NEAR)
        slack = 1e-12 * (1.0 + np.abs(ball.centre))
        whole = [ball.centre[:, None], slack[:, None], np.zeros((len(spread), kept)), spread]
        return list(np.concatenate(whole, 1)[:, None, :])


@np.errstate(over="ignore", invalid="ignore")  # sets that diverge
def contraction(
    sets: ReachableSets, rows: Sequence[Form], free: Sequence[Value], motion: tuple[Form, Form] | None, until: float
) -> Contraction | None:
    """Return a ball that holds some states, and that a cycle of the loop contracts; None if none is proved.

    Args:
        sets: The loop, its equations without time.
        rows: The states of one box at the begin of a cycle.
        free: Values of its free params.
        motion: How a set moves in a cycle, see `sets.modes`.
        until: Processor seconds at which the time is over.

    Raises:
        DomainError, NoTubeError, LeavesRangeError: If no bound of the derivatives is known there.
    """
    if sets.cycle > MOST_CYCLE:
        return None
    whole = np.stack(rows)[:, 0, :]
    sizes = np.abs(whole[:, 1:]).sum(1)
    # Not the norm of a mode, which underflows for states that stay constant.
    basis = np.diag(np.where(sizes > 0.0, sizes, sizes.max() or 1.0)) if motion is None else motion[1]
    largest = np.abs(basis).max(0)
    basis = basis / np.where(largest > 0.0, largest, 1.0)
    fixed = [hulled(as_form(f)) for f in free]
    loop = _Family(sets, fixed, bool(sets.plant) and not sets.memory and not sets.held, until)
    outcome: Contraction | list[Form] = []
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


def sectors(sets: ReachableSets, free: Sequence[Value], proof: Contraction) -> list[str]:
    """Return the sectors of tables of one input over a ball, in words, see `Slopes.sectors`."""
    ball = proof.balls[0]
    reach = np.sqrt((ball.basis**2).sum(1)) * ball.radius
    loop = _Family(sets, [hulled(as_form(f)) for f in free], proof.continuous, math.inf)
    rows, about = loop.around(ball.centre, reach), loop.around(ball.centre, None)
    if proof.continuous:
        return Slopes(sets.flow.nodes, sets.plant).sectors(*([0.0, *v, *loop.free] for v in (rows, about)))
    states = [*sets.plant, *sets.memory]
    return Slopes(sets.sample, states).sectors(*([0.0, *v, *loop.free, *sets.flags(0)] for v in (rows, about)))


def _searched(loop: _Family, whole: Form, centre: Form, basis: Form, beside: float | None) -> Contraction | list[Form]:
    """Return a ball around a centre that holds a set and contracts, or the vertices over the last balls tried.

    Args:
        loop: The loop.
        whole: The set, one row for each state.
        centre: The centre.
        basis: The coordinates to begin with.
        beside: None for derivatives; else for chords from the point of rest, which is the centre for 0, or lies in a
            ball around it of this part of the radius.
    """
    apart = np.concatenate([(whole[:, 0] - centre)[:, None], whole[:, 1:2] * np.eye(len(whole)), whole[:, 2:]], 1)
    vertices: list[Form] = []
    centres = [centre] * loop.cycle if beside == 0.0 else loop.path(centre)[:-1]
    bases: list[Form] | None = [basis] if loop.cycle == 1 else loop.bases(centres, basis, chords=beside is not None)
    for _ in range(_NORMS):
        if bases is None or (inverses := _exact_inverses(bases)) is None:
            return vertices
        inverse = _rounded(inverses[0])
        sides = np.abs(inverse @ apart).sum(1) + 1e-14 * (np.abs(inverse) @ np.abs(apart)).sum(1)
        radius = float(np.sqrt((sides**2).sum())) * (1.0 + 1e-9) + 1e-300
        outcome = _contracted(loop, centres, bases, inverses, radius, beside)
        if isinstance(outcome, Contraction):
            return outcome
        vertices = outcome
        bases = common_bases([v[..., 0] for v in vertices], bases, loop.continuous)
    return vertices


def _contracted(
    loop: _Family,
    centres: Sequence[Form],
    bases: Sequence[Form],
    inverses: Sequence[Exact],
    radius: float,
    beside: float | None,
) -> Contraction | list[Form]:
    """Return balls that contract, the first of at least a radius, or the vertices over balls that do not.

    A ball of radius r lies in one of radius q r + d at the next sample: q bounds the slopes, d is the distance between
    the image of its centre and the next centre.

    Raises:
        DomainError, NoTubeError, LeavesRangeError: If no bound of the derivatives is known there.
    """
    bound, limit = (growth_bound, 0.0) if loop.continuous else (norm_bound, 1.0)
    following = [*inverses[1:], inverses[0]]
    rounded = [_rounded(inverse) for inverse in following]
    lengths = [np.sqrt((b**2).sum(1)) * (1.0 + 1e-9) for b in bases]
    drifts = [0.0] * loop.cycle if beside == 0.0 else loop.drifts(centres, rounded)
    for _ in range(_BALLS):
        begin = near = radius * (beside or 0.0)  # how far the point of rest may be from the centre
        size, total, drift = radius, 1.0, 0.0
        vertices, balls = list[Form](), list[Ball]()
        for k, (centre, basis) in enumerate(zip(centres, bases, strict=True)):
            about = None if beside is None else loop.around(centre, lengths[k] * near if near else None)
            reach = lengths[k] * (size + 2.0 * near) + 1e-12 * (1.0 + np.abs(centre))
            vertices.append(loop.vertices(loop.around(centre, reach), about, k))
            if len(balls) < k or not proposed_bound(vertices[k], basis, rounded[k], loop.continuous) < limit:
                continue
            rate = max(bound(v, basis, following[k]) for v in vertices[k])
            if rate < limit:
                balls.append(Ball(centre, basis, size, near, rate))
                total, drift = total * rate * (1.0 + 1e-15), (abs(rate) * drift + drifts[k]) * (1.0 + 1e-15)
                size, near = ((rate * a + drifts[k]) * (1.0 + 1e-12) for a in (size, near))
        if len(balls) < loop.cycle:
            return vertices
        needed = drift / (limit - total) * (1.0 + 1e-9)
        if needed <= (begin if beside is not None else radius):
            factor = math.exp(total * loop.sets.equations.step) if loop.continuous else total
            return Contraction(factor, tuple(balls), loop.continuous, beside is not None)
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

    @property
    def cycle(self) -> int:
        """After how many samples the controllers sample together again."""
        return self.sets.cycle

    def around(self, centre: Form, reach: Form | None) -> list[Value]:
        """Return intervals around a centre, or the numbers themselves."""
        if reach is None:
            return [float(c) for c in centre]
        return [interval(np.array([c - w]), np.array([c + w])) for c, w in zip(centre, reach, strict=True)]

    def vertices(self, box: Sequence[Value], about: Sequence[Value] | None, phase: int) -> Form:
        """Return the vertices over a box, see `flow_slopes` and `period_slopes`."""
        if clock.used() > self.until:
            raise DomainError("the time is over")
        if self.continuous:
            return flow_slopes(self.sets, box, self.free, about)
        return period_slopes(self.sets, box, self.free, about, phase, max(MOST // self.cycle, _FEWEST))

    def moved(self, centre: Form, phase: int) -> tuple[Form, Form]:
        """Return the ends of the image of a point at the next sample, or of its rates."""
        rows: list[Value] = [np.array([[c, 0.0]]) for c in centre]
        if self.continuous:
            results = Series(self.sets.flow.nodes, [0.0, *rows, *self.free]).extend()
        else:
            results = [*image(self.sets, [as_form(r) for r in rows], self.free, phase)]
        low, high = (np.array([float(e[0]) for e in x]) for x in zip(*map(ends, results), strict=True))
        return low, high

    def path(self, centre: Form) -> list[Form]:
        """Return a point and about its images up to the end of a cycle."""
        points = [centre]
        for phase in range(self.cycle):
            low, high = self.moved(points[-1], phase)
            points.append(0.5 * (low + high) + (centre if self.continuous else 0.0))
        return points

    def drifts(self, centres: Sequence[Form], inverses: Sequence[Form]) -> list[float]:
        """Return how far the image of each centre is from the next one at most, in the coordinates there."""
        results = []
        for k, (centre, inverse) in enumerate(zip(centres, inverses, strict=True)):
            target = np.zeros(len(centre)) if self.continuous else centres[(k + 1) % self.cycle]
            low, high = self.moved(centre, k)
            apart = np.maximum(np.abs(low - target), np.abs(high - target)) + 1e-15 * np.abs(target)
            results.append(float(np.linalg.norm(np.abs(inverse) @ apart)) * (1.0 + 1e-9))
        return results

    def bases(self, centres: Sequence[Form], basis: Form, *, chords: bool) -> list[Form] | None:
        """Return coordinates for each sample of a cycle in which the slopes at some points shrink.

        With M of these slopes, P = Q + M' P M / r^2, the next P on the right, gives a linear loop a common rate r; the
        first P is a series, summed by doubling.
        """
        target = np.linalg.inv(basis @ basis.T)
        slopes = []
        for k, centre in enumerate(centres):
            box = self.around(centre, 1e-9 * (1e-6 + np.abs(centre)))
            slopes.append(self.vertices(box, self.around(centre, None) if chords else None, k)[..., 0].mean(0))
        whole = np.eye(len(basis))
        for m in slopes:
            whole = m @ whole
        radius = float(np.abs(np.linalg.eigvals(whole)).max())
        rate = (math.sqrt(radius) if radius < 1.0 else 1.1 * radius) ** (1.0 / self.cycle) or 0.5
        slopes = [m / rate for m in slopes]
        first = np.zeros_like(target)
        for m in reversed(slopes):
            first = target + m.T @ first @ m
        power = whole / rate**self.cycle
        for _ in range(_DOUBLINGS):
            first, power = first + power.T @ first @ power, power @ power
        forms = [first]
        for m in reversed(slopes[1:]):
            forms.append(target + m.T @ forms[-1] @ m)
        forms = [forms[0], *forms[:0:-1]]
        try:
            return [np.linalg.inv(np.linalg.cholesky(0.5 * (p + p.T) / np.abs(first).max())).T for p in forms]
        except np.linalg.LinAlgError:  # no digits are left
            return None

    def rest(self, whole: Form, vertices: Sequence[Form]) -> tuple[Form, Form, float] | None:
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
            for flags in [] if self.continuous else {tuple(sets.flags(k)) for k in range(self.cycle)}:
                still += Series(sets.sample, [0.0, *zeros, *self.free, *flags], exact=True).extend()
            if all(is_zero(v) for v in still):
                return np.zeros(size), basis, 0.0
        if not vertices:
            return None
        centre, slopes = whole[:, 0], np.eye(size)
        for v in vertices:
            slopes = v[..., 0].mean(0) @ slopes
        slopes = slopes - (0.0 if self.continuous else np.eye(size))
        for _ in range(3):
            try:
                centre = centre - np.linalg.solve(slopes, self.path(centre)[-1] - centre)
            except np.linalg.LinAlgError:
                return None
        return (centre, basis, _NEAR) if np.all(np.isfinite(centre)) else None


def proposed_bound(vertices: Form, basis: Form, inverse: Form, continuous: bool) -> float:
    """Return about the largest bound of the vertices, see `norm_bound` and `growth_bound`."""
    middle = inverse @ vertices[..., 0] @ basis
    if not np.all(np.isfinite(middle)):
        return math.inf
    apart = np.sqrt(((np.abs(inverse) @ vertices[..., 1] @ np.abs(basis)) ** 2).sum((1, 2)))
    if continuous:
        return float((np.linalg.eigvalsh(middle + np.swapaxes(middle, 1, 2))[:, -1] / 2 + apart).max())
    return float((np.linalg.norm(middle, 2, (1, 2)) + apart).max())


def common_bases(centres: Sequence[Form], bases: Sequence[Form], continuous: bool) -> list[Form] | None:
    """Return coordinates in which some matrices contract, or nearly; None if a barrier method finds none.

    It maximises t subject to P <= 1 and P - M'RM >= t, or -(M'P + PM) >= t |M|, for the matrices M in the coordinates;
    R is the form of the next sample of a cycle, which is P if there is one sample.

    Args:
        centres: The matrices of each sample, shapes (vertices, n, n).
        bases: The coordinates to begin with at each sample.
        continuous: Whether the matrices are of a differential equation.
    """
    n, phases = len(bases[0]), len(bases)
    rows, columns = np.triu_indices(n)
    size = len(rows)
    units = np.zeros((size, n, n))
    units[range(size), rows, columns] = units[range(size), columns, rows] = 1.0
    sides = list[_Side]()
    for k, (basis, group) in enumerate(zip(bases, centres, strict=True)):
        following = (k + 1) % phases
        matrices = np.linalg.solve(bases[following], group @ basis)
        if not np.all(np.isfinite(matrices)):
            return None
        turned = np.swapaxes(matrices, 1, 2)[:, None]
        before, after = np.broadcast_to(units, (len(group), size, n, n)), turned @ units @ matrices[:, None]
        if continuous:
            moved = turned @ units
            lengths = (np.linalg.norm(matrices, 2, (1, 2)) + 1e-300)[:, None, None, None]
            linear = -(moved + np.swapaxes(moved, 2, 3)) / lengths
        else:
            linear = before - after if phases == 1 else np.concatenate([before, -after], 1)
        places = [*range(k * size, (k + 1) * size)]
        both = places if phases == 1 else [*places, *range(following * size, (following + 1) * size)]
        slack = np.broadcast_to(-np.eye(n), (len(group), 1, n, n))
        sides.append(_Side(np.array([*both, phases * size]), np.concatenate([linear, slack], 1), np.zeros((1, n, n))))
        ends_of = np.stack([-units, units])  # P <= 1, P >= 0
        sides.append(_Side(np.array(places), ends_of, np.stack([np.eye(n), np.zeros((n, n))])))
    y = np.append(np.tile(0.5 * (rows == columns), phases), 0.0)
    y[-1] = min(s.least(y) for s in sides[::2]) - 1.0
    weight = _FIRST
    try:
        for _ in range(_WEIGHTS):
            y = _centred(sides, y, weight)
            weight *= _FACTOR
        forms = np.einsum("pk,kij->pij", y[:-1].reshape(phases, size), units)
        roots = np.linalg.cholesky(forms)
    except np.linalg.LinAlgError:  # its numbers have no digits left
        return None
    if not y[-1] > 0.0:
        return None
    wanted = [basis @ np.linalg.inv(root).T for basis, root in zip(bases, roots, strict=True)]
    largest = max(float(np.abs(w).max()) for w in wanted)
    return [np.asarray(w / largest) for w in wanted]


class _Side(NamedTuple):
    """Matrix inequalities: constant + the sum of y[place] times linear, for each of some matrices, is not negative.

    Args:
        places: Of the variables in y.
        linear: The coefficients, shape (matrices, places, n, n).
        constant: Shape (matrices or 1, n, n).
    """

    places: Any
    linear: Form
    constant: Form

    def at(self, y: Form) -> Form:
        """Return the matrices."""
        return np.asarray(self.constant + np.einsum("k,vkij->vij", y[self.places], self.linear))

    def least(self, y: Form) -> float:
        """Return the least eigenvalue of the matrices."""
        return float(np.linalg.eigvalsh(self.at(y))[:, 0].min())


def _centred(sides: Sequence[_Side], y: Form, weight: float) -> Form:
    """Return where -weight t - log det of the sides of matrix inequalities is least, by Newton; t is last in y.

    Raises:
        LinAlgError: If a step has no digits.
    """
    for _ in range(_NEWTON):
        gradient, curvature = np.zeros(len(y)), np.zeros((len(y), len(y)))
        for side in sides:
            factors = np.linalg.inv(np.linalg.cholesky(side.at(y)))[:, None]
            steep = factors @ side.linear @ np.swapaxes(factors, 2, 3)
            flat = steep.swapaxes(0, 1).reshape(len(side.places), -1)
            gradient[side.places] -= np.trace(steep, axis1=2, axis2=3).sum(0)
            curvature[np.ix_(side.places, side.places)] += flat @ flat.T
        gradient[-1] -= weight
        step = -np.linalg.solve(curvature, gradient)
        decrement = float(-gradient @ step)
        if not decrement > 1e-4:
            break
        length = 1.0 / (1.0 + math.sqrt(decrement)) if decrement > 0.1 else 1.0
        while length > 1e-9 and min(s.least(y + length * step) for s in sides) <= 1e-14:
            length *= 0.5
        if length <= 1e-9:
            break
        y = y + length * step
    return y


def norm_bound(slopes: Form, basis: Form, inverse: Exact | None = None) -> float:
    """Return a bound of the norm of all matrices J between some ends, from the norm |basis^-1 z| to |inverse z|.

    The inverse is that of the basis if none is named. Of the centre M the bound q is decided in rational arithmetic:
    q^2 - M' M is positive definite. Infinite for none.
    """
    turned = _turned(slopes, basis, inverse)
    if turned is None:
        return math.inf
    middle, apart = turned
    proposed = float(np.linalg.norm(np.array([[float(x) for x in row] for row in middle]), 2))
    q = Fraction(proposed) + Fraction(1, 1 << 40)
    gram = _matrix_product([list(column) for column in zip(*middle, strict=True)], middle)
    return float(q) + apart + 1e-15 if is_positive_definite(_from_diagonal(q * q, gram)) else math.inf


def growth_bound(slopes: Form, basis: Form, inverse: Exact | None = None) -> float:
    """Return a bound of the logarithmic norm of all matrices J between some ends, see `norm_bound`.

    Of the centre M the bound q is decided in rational arithmetic: 2 q - (M + M') is positive definite.
    """
    turned = _turned(slopes, basis, inverse)
    if turned is None:
        return math.inf
    middle, apart = turned
    columns = list(zip(*middle, strict=True))
    both = [[x + y for x, y in zip(*pair, strict=True)] for pair in zip(middle, columns, strict=True)]
    proposed = float(np.linalg.eigvalsh(np.array([[float(x) for x in row] for row in both]))[-1]) / 2
    q = Fraction(proposed) + Fraction(1 + abs(proposed)) / (1 << 40)
    rounding = 1e-15 * (1.0 + abs(float(q)))
    return float(q) + apart + rounding if is_positive_definite(_from_diagonal(2 * q, both)) else math.inf


def _turned(slopes: Form, basis: Form, inverse: Exact | None) -> tuple[Exact, float] | None:
    """Return the centre of matrices between some ends in some coordinates, and how far others lie from it at most."""
    exact_basis = [[Fraction(x) for x in row] for row in basis.tolist()]
    exact_inverse = inverse or _inverted(exact_basis)
    if exact_inverse is None or not np.all(np.isfinite(slopes)):
        return None
    centre = [[Fraction(x) for x in row] for row in slopes[..., 0].tolist()]
    middle = _matrix_product(exact_inverse, _matrix_product(centre, exact_basis))
    exact = np.array([[abs(float(x)) * (1.0 + 1e-15) for x in row] for row in exact_inverse])
    spread = exact @ slopes[..., 1] @ np.abs(basis) * (1.0 + 1e-12)
    return middle, float(np.sqrt((spread**2).sum())) * (1.0 + 1e-12)


def _exact_inverses(bases: Sequence[Form]) -> list[Exact] | None:
    """Return the inverses of some matrices of numbers, None if one has none."""
    inverses = list[Exact]()
    for basis in bases:
        exact = _inverted([[Fraction(x) for x in row] for row in basis.tolist()]) if np.isfinite(basis).all() else None
        if exact is None:
            return None
        inverses.append(exact)
    return inverses


def _rounded(matrix: Exact) -> Form:
    return np.array([[float(x) for x in row] for row in matrix])


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
