"""Certificates of loops: a problem and hints for `fuzzyctl.analysis.verify`, which searches for nothing.

The sets are those of the checker's own arithmetic: hints, such as tubes, bases and balls, are proposed in floating
point and tried at once.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import numpy as np

from fuzzyctl.analysis import verify_numbers as numbers
from fuzzyctl.analysis.reach import stability
from fuzzyctl.analysis.reach.flow import NoTubeError
from fuzzyctl.analysis.reach.forms import DomainError
from fuzzyctl.analysis.reach.prover import ANCHORS, LOOKS, LoopProver
from fuzzyctl.analysis.reach.reach import LeavesRangeError, ReachableSets
from fuzzyctl.analysis.reach.sets import _boxed, modes
from fuzzyctl.analysis.reach.surfaces import _over_slabs, _slopes
from fuzzyctl.analysis.reach.translation import NoCertificateError, problem_of
from fuzzyctl.analysis.verify import CONVERGES, Loop
from fuzzyctl.analysis.verify_numbers import ONE, keyed
from fuzzyctl.analysis.work import clock
from fuzzyctl.formats.fz_strings import guarantee_text
from fuzzyctl.model.loop import Always, Stable
from fuzzyctl.model.loop import Loop as LoopBlock
from fuzzyctl.simulation.sample_times import ALIGNED

#: Order of the Taylor polynomials, and most parts of a period.
_ORDER: Final = 4
_PARTS: Final = 64
#: Lines along which the inputs of a table move together.
_SHEARS: Final = 4
#: Seconds that the search for an invariant set may take.
_SECONDS: Final = 60.0
#: How often a range is halved at most, each half again.
_CUTS: Final = 3
#: Rates of a ball that are tried: parts of the way from the proposed one to 1; near balls as parts of the ball.
_SLOWER: Final = (0.02, 0.3, 0.9)
_NEAR: Final = (1e-9, 1e-6, 1e-3)
#: Most combinations of corners of slopes.
_CORNERS: Final = 256
#: Symbols for each state from which on they are reduced, and to which.
_MOST: Final = 16
_LEFT: Final = 7


class Search:
    """The hints of a run, found sample by sample.

    Args:
        loop: The checker of the loop.
        ranges: Of the params, then of the states.
    """

    def __init__(self, loop: Loop, ranges: Sequence[Any]) -> None:
        self.loop, self.ranges = loop, ranges
        box = [numbers.enclosed(*ends) for ends in ranges]
        forms = [[a[0], 0, *[0] * i, a[1]] for i, a in enumerate(box)]
        self.fixed = keyed(param=forms[: loop.params], disturbance=loop.noise)
        self.rows = forms[loop.params :]
        self.steps: list[dict[str, Any]] = []
        self.before: list[list[int]] = []

    def sample(self) -> tuple[dict[Any, Any], list[list[int]], dict[str, Any]]:
        """Return the values that are held from a sample on, the next memory, and the planes of all tables."""
        n, k = len(self.loop.rates), len(self.steps)
        signals = self.loop.given[k] if self.loop.given else []
        inputs = self.fixed | keyed(state=self.rows[:n], memory=self.rows[n:], given=signals)
        inputs |= {("time",): [k * self.loop.period, 0]}
        hints: dict[str, Any] = {}
        values = self.loop.series(inputs, None, hints)
        for i, (op, *rest) in enumerate(self.loop.nodes):
            if op == "table":
                hints[str(i)] = _plane(self.loop.tables[rest[0]], [values(p) for p in rest[1:]])
        return inputs | keyed(held=[values(i) for i in self.loop.values]), [values(i) for i in self.loop.next], hints

    def period(self, anchor: bool = False, count: int = 1) -> None:
        """Find the hints of a period of at least some parts, and go on by it."""
        loop, n, k = self.loop, len(self.loop.rates), len(self.steps)
        inputs, memory, hints = self.sample()
        hint: dict[str, Any] = {"tables": hints}
        while True:
            hint["parts"], x = [], self.rows[:n]
            try:
                for j in range(count):
                    a, b = ((k * count + i) * loop.period // count for i in (j, j + 1))
                    hint["parts"].append(self.part(inputs, x, a, b - a))
                    x, _, _ = loop.advance(inputs, x, a, b - a, hint["parts"][-1])
                break
            except AssertionError:
                count *= 2
                if count > _PARTS:
                    raise
        self.before, rows = self.rows, [*x, *memory]
        columns = numbers.columns_of(rows, loop.params)
        self.rows = [[a[0], 0, *symbols] for a, symbols in zip(rows, zip(*columns, strict=True), strict=True)]
        if anchor or len(self.rows[0]) - 2 - loop.params > _MOST * len(rows):
            hint |= self.smaller(anchor) | ({"anchor": True} if anchor else {})
        self.steps.append(hint)

    def come_back(self, sets: ReachableSets | None, begin: float, until: float) -> dict[str, Any]:
        """Go on until a set lies within an earlier one, or in a ball that contracts, and return the hints.

        Args:
            sets: The sets of the loop to look for balls, None to look for none.
            begin: The first sample that a claim is about.
            until: Processor seconds at which the time is over.

        Raises:
            NoCertificateError: If neither is found in time.
        """
        p, anchor, reason = self.loop.params, None, ""
        converges = any(clauses == CONVERGES for _, clauses, _, _ in self.loop.claims)
        while True:
            k = len(self.steps)
            if sets is not None and k in LOOKS and k >= begin:
                try:
                    if (ball := self.contraction(sets, until)) is not None:
                        hint = self.ball(ball)  # which takes the place of an anchor
                        return {
                            "steps": [{k: v for k, v in s.items() if k != "anchor"} for s in self.steps],
                            "ball": hint,
                        }
                except (NoTubeError, DomainError, LeavesRangeError, AssertionError) as error:
                    reason = f": {error}"
            place = k + 1 in ANCHORS and k + 1 >= begin and not converges
            self.period(place)
            if place:
                rows = [[a[0], 0, *a[2 : 2 + p]] for a in self.rows]
                anchor = rows, *numbers.hinted(self.steps[-1]["set"])
            elif anchor is not None:
                with suppress(AssertionError):
                    self.loop.inside(self.rows, *anchor)
                    return {"steps": self.steps}
            if clock.used() > until:
                what = "is shown to contract" if converges else "lies in an earlier one"
                raise NoCertificateError(f"no set of the first {k + 1} periods {what}{reason}")

    def contraction(self, sets: ReachableSets, until: float) -> stability.Contraction | None:
        """Return a ball around the set that may contract, None after some processor seconds."""
        free = [_floats([self.fixed["param", i]]) for i in range(self.loop.params)]
        rows = [a[None] for a in _floats(self.rows)]
        width = min(map(len, [*self.before, *self.rows]))
        before, after = ([a[None, :width] for a in _floats(r)] for r in (self.before or self.rows, self.rows))
        return stability.contraction(sets, rows, free, modes(before, after) if self.before else None, until)

    def ball(self, proposed: stability.Contraction) -> dict[str, Any]:
        """Return the hint of a ball.

        Raises:
            AssertionError: If the checker refuses it.
        """
        (ball,) = proposed.balls  # several samples of a cycle have no certificate
        loop, basis, centre, radius = self.loop, ball.basis, ball.centre.tolist(), ball.radius * (1.0 + 1e-6)
        refused = AssertionError()
        for share in _NEAR if proposed.to_rest else (1.0,):
            near, searches = radius * share, list[Search]()
            for size in (radius, near):
                searches.append(Search(loop, self.ranges))
                reach = (size * np.linalg.norm(basis, axis=1) * (1.0 + 1e-9)).tolist()
                searches[-1].rows = [
                    [c, 0, *[0] * (loop.params + i), e]
                    for i, (c, e) in enumerate(zip(numbers.hinted(centre), numbers.hinted(reach), strict=True))
                ]
                searches[-1].period(count=len(searches[0].steps[0]["parts"]) if searches[0].steps else 1)
            (whole,), (inner,) = (s.steps for s in searches)
            values = [loop.pass_by(1, s.before, s.steps[0], s.fixed, ())[1] for s in searches]
            hint = {"periods": [inner, whole], "vary": self._varied(*values)}
            for slower in _SLOWER:
                rate = proposed.rate + (1.0 - proposed.rate) * slower
                hint["form"] = [basis.tolist(), np.linalg.inv(basis).tolist(), centre, [radius, near, rate]]
                try:
                    loop.contract(len(self.steps) + 1, self.rows, hint, self.fixed, loop.claims)
                    return hint
                except AssertionError as error:
                    refused = error
        raise refused

    def _varied(self, x: Any, y: Any) -> list[int]:
        """Return the nodes whose slopes are varied, those of most effect first."""
        loop = self.loop
        needed, widths = [*loop.values, *loop.next], dict[int, list[float]]()
        while needed:
            at = needed.pop()
            if at not in widths:
                slopes = loop.slopes(x, y, at) if loop.nodes[at][0] not in ("state", "memory") else []
                widths[at] = [a[1] / ONE for _, a in slopes if a[1] > 1e-7 * abs(a[0]) and a[1] >> (numbers.BITS // 2)]
                needed += [j for j, _ in slopes]
        count, chosen = 1, list[int]()
        for at in sorted(widths, key=lambda at: -max(widths[at], default=0.0)):
            if widths[at] and count << len(widths[at]) <= _CORNERS:
                count <<= len(widths[at])
                chosen.append(at)
        return chosen

    def part(self, inputs: Any, x: list[list[int]], begin: int, step: int) -> dict[str, Any]:
        """Return a tube over a part of a period.

        Raises:
            AssertionError: If none is found.
        """
        loop, starts = self.loop, [numbers.ends(a) for a in x]
        fixed = inputs | {("time",): numbers.between(begin, begin + step)}
        tube = starts
        for attempt in range(12):
            span = fixed | keyed(state=[numbers.between(*t) for t in tube])
            values = loop.series(span)
            moved = []
            for (low, high), r in zip(starts, loop.rates, strict=True):
                slow, fast = numbers.ends(values(r))
                moved.append(
                    (low + min(0, slow * step >> numbers.BITS), high + max(0, (fast * step >> numbers.BITS) + 1))
                )
            if attempt and all(a <= c and d <= b for (a, b), (c, d) in zip(tube, moved, strict=True)):
                hint = {"tube": [[a / ONE, b / ONE] for a, b in tube], "order": _ORDER}
                return hint | ({"apart": self._apart(span, step)} if loop.noise else {})
            grown = []
            for low, high in moved:
                more = (high - low) // 20 + (ONE >> 40)
                grown.append([_rounded((low - more) / ONE), _rounded((high + more) / ONE)])
            tube = numbers.hinted(grown)
        raise AssertionError("no tube is found")

    def _apart(self, inputs: Any, step: int) -> list[float]:
        """Return how far disturbances may move each state."""
        n = len(self.loop.rates)
        keys = [*(("state", j) for j in range(n)), *(("disturbance", j) for j in range(len(self.loop.noise)))]
        slopes = [self.loop.series(inputs, {key: [ONE, 0]}) for key in keys]
        largest = np.array([[max(map(abs, numbers.ends(s(r, 1)))) / ONE for s in slopes] for r in self.loop.rates])
        largest = largest.reshape(n, len(keys))
        sources = largest[:, n:] @ np.array([w[1] / ONE for w in self.loop.noise])
        apart = np.zeros(n)
        for _ in range(60):
            apart = step / ONE * (largest[:, :n] @ apart + sources) * (1.0 + 1e-9) + 1e-24
        return [float(a) for a in apart * 1.001]

    def smaller(self, anchor: bool) -> dict[str, Any]:
        """Return a set of fewer symbols that holds the set, and go on with it."""
        params = self.loop.params
        rows = _floats(self.rows)
        g = rows[:, 2 + params :]
        scale = np.maximum(np.abs(g).sum(1), 1e-9)
        sized = np.abs(g / scale[:, None])
        order = np.argsort(sized.max(0) - sized.sum(0))
        large = [] if anchor else sorted(int(k) for k in order[: _LEFT * len(rows)])
        width = min(len(r) for r in self.before)
        motion = modes(*([a[None, :width] for a in _floats(r)] for r in (self.before, self.rows)))
        rest = np.concatenate([np.delete(g, large, 1), np.diag(1e-8 * scale)], 1)
        columns, _ = _boxed(rest, scale, motion)
        columns = columns * (1.02 if anchor else 1.0 + 1e-9)
        hint = [columns.tolist(), np.linalg.inv(columns).tolist(), (1e-11 * scale).tolist()]
        basis, _, slack = numbers.hinted(hint)
        keep = [*range(params), *(params + k for k in large)]
        self.rows = [
            [a[0], e, *(a[2 + k] for k in keep), *row] for a, e, row in zip(self.rows, slack, basis, strict=True)
        ]
        return {"set": hint, "keep": keep[params:]}


def _floats(x: Any) -> Any:
    """Return nested lists of units as an array; rows are filled up with zeros."""
    rows = [_floats(y) if isinstance(y, list) else y / ONE for y in x]
    if rows and isinstance(rows[0], np.ndarray) and rows[0].ndim == 1:
        width = max(map(len, rows))
        rows = [np.pad(r, (0, width - len(r))) for r in rows]
    return np.array(rows)


def _rounded(x: float) -> float:
    return float(f"{x:.12g}")


def _plane(table: Any, inputs: list[list[int]]) -> list[list[float]]:
    """Return the slopes of a plane near a table, and those of lines along which its inputs move together."""
    ratios: list[float] = []
    for other in inputs[1:]:  # of the symbols that move both most
        pairs = [(x / ONE, y / ONE) for x, y in zip(inputs[0][2:], other[2:], strict=False) if x]
        pairs.sort(key=lambda p: -abs(p[0]) - abs(p[1]))
        ratios += [y / x for x, y in pairs[:_SHEARS] if abs(y) < 1e6 * abs(x)]
    sides = list(_floats(inputs))
    knots, values = table
    points, heights = _over_slabs(_floats(values), [_floats(k) for k in knots], sides)
    moved = points - np.array([a[0] for a in sides])
    slopes = min(_slopes(moved, heights), key=lambda s: float(np.ptp(heights - moved @ s)))
    return [[float(x) for x in slopes], ratios]


def certificate_of(
    prover: LoopProver, proved: Sequence[Always | Stable]
) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """Return the certificates of proved claims of a loop, and by claim why it has none.

    Args:
        prover: Of the loop.
        proved: Claims in its `own` that are proved.
    """
    groups: list[list[Always | Stable]] = [[c for c in proved if isinstance(c, Always) and not c.forever]]
    groups += [[c] for c in proved if isinstance(c, Stable) or c.forever]
    parts, reasons = list[dict[str, Any]](), dict[str, str]()
    for claims in filter(None, groups):
        try:
            parts.append(_source(prover.loop, claims, prover.settings) | _certified(prover, claims))
        except (NoCertificateError, AssertionError) as error:
            reasons |= {guarantee_text(c): str(error) for c in claims}
        except RecursionError:
            reasons |= dict.fromkeys(map(guarantee_text, claims), "its equations are nested too deeply")
    return parts, reasons


def _source(item: LoopBlock, claims: Sequence[Always | Stable], settings: Sequence[str]) -> dict[str, Any]:
    """Return where a loop comes from: files with their hashes, and the lines of the claims."""
    blocks = (item, *item.systems, *item.controllers, *item.plants, *(s for c in item.controllers for s in c.systems))
    paths = dict.fromkeys(b.path for b in blocks if b.path)
    hashes = {p: hashlib.sha256(Path(p).read_bytes()).hexdigest() for p in paths if Path(p).is_file()}
    lines = [f"require {guarantee_text(c)}" for c in claims]
    return {"kind": "loop", "loop": item.name, "lines": lines, "sha256": hashes, "settings": [*settings]}


def is_of(part: dict[str, Any], loop: LoopBlock) -> bool:
    """Return whether the equations, ranges and claims of a part of a certificate are those of a loop."""
    prover = LoopProver(loop, 0.0)
    lines, claims = [*part["lines"]], list[Always | Stable]()
    for claim in prover.own:  # a file may have a line twice
        if isinstance(claim, Always | Stable) and (text := f"require {guarantee_text(claim)}") in lines:
            lines.remove(text)
            claims.append(claim)
    apart = any(isinstance(c, Stable) or c.forever for c in claims)  # these have a part each
    if lines or not claims or (apart and len(claims) > 1):
        return False
    problem = json.loads(json.dumps(_problem(prover, claims)[0]))
    return all(part.get(key) == value for key, value in problem.items())


def _certified(prover: LoopProver, claims: Sequence[Always | Stable]) -> dict[str, Any]:
    """Return the certificate of claims that end together, or never."""
    problem, ranges, sets = _problem(prover, claims)
    loop = Loop(problem)
    numbers.WORK[0] = 0
    converges = any(isinstance(c, Stable) for c in prover.own)
    proof = _proof(loop, ranges, clock.used() + _SECONDS, _CUTS, sets if converges else None)
    return problem | {"proofs": [proof | {"claims": [*range(len(loop.claims))]}]}


def _problem(
    prover: LoopProver, claims: Sequence[Always | Stable]
) -> tuple[dict[str, Any], list[list[float]], ReachableSets]:
    """Return a loop and claims that end together, or never, as data, the ranges of params and states, and its sets."""
    number, loop = prover.loop.number, prover.loop
    timed = [c for c in claims if isinstance(c, Always)]
    forever = not timed or timed[0].forever
    ends = [math.inf if forever else number(loop.duration if c.end is None else c.end) for c in timed]
    begins = [0.0 if c.begin is None else number(c.begin) for c in timed]
    sets = prover.sets(timed, max(ends, default=math.inf))
    step = sets.equations.step
    texts = [
        (guarantee_text(c), _periods(begin, step), None if forever else _periods(end, step))
        for c, begin, end in zip(timed, begins, ends, strict=True)
    ]
    at = {d.state: [d.low, d.high] for d in prover.dimensions if d.state}
    states = [(s.name, s.start) for s in sets.equations.plant_states]
    states += [(s.name, s.start) for s in sets.equations.states]
    starts = [at.get(name, [start, start]) for name, start in states]
    params = [[d.low, d.high] for d in prover.dimensions if not d.state]
    texts = texts or [(guarantee_text(claims[0]), 0.0, None)]
    return problem_of(sets, texts, starts, params, exact=not timed), [*params, *starts], sets


def _proof(
    loop: Loop, ranges: Sequence[list[float]], until: float, cuts: int, sets: ReachableSets | None
) -> dict[str, Any]:
    """Return the steps that show all claims, for two halves of the ranges if they do not show them for the whole.

    Args:
        loop: The checker of the loop.
        ranges: Ends of the ranges of params and states.
        until: Processor seconds at which the time is over.
        cuts: How often a range may still be halved.
        sets: The sets of the loop if it is claimed to converge, else None.

    Raises:
        AssertionError, NoCertificateError: If they do not show them.
    """
    search = Search(loop, ranges)
    try:
        if any(math.isinf(end) for *_, end in loop.claims):
            proof = search.come_back(sets, max(begin for _, _, begin, _ in loop.claims) / ONE, until)
        else:
            while len(search.steps) * ONE < max(end for *_, end in loop.claims):
                search.period()
            proof = {"steps": [*search.steps, {"tables": search.sample()[2], "parts": []}]}
        loop.run(proof, loop.claims, ranges)
    except AssertionError:
        widths = [(high - low) / (abs(high) + abs(low) + 1e-9) for low, high in ranges]
        if not cuts or clock.used() > until or max(widths) == 0.0:
            raise
        side = widths.index(max(widths))
        low, high = ranges[side]
        middle = 0.5 * (low + high)
        halves = [[*ranges[:side], half, *ranges[side + 1 :]] for half in ([low, middle], [middle, high])]
        return {"cut": [side, middle], "halves": [_proof(loop, half, until, cuts - 1, sets) for half in halves]}
    return proof


def _periods(time: float, step: float) -> float:
    """Return a time in periods; one that differs from a sample by rounding is this sample."""
    count = time / step
    return float(round(count)) if abs(count - round(count)) <= ALIGNED * max(count, 1.0) else count
