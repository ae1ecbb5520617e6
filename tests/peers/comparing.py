"""Runs a peer and fuzzyctl on the same systems and says where their numbers differ."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from math import isfinite
from pathlib import Path
from random import Random

import numpy as np

import fuzzyctl
from fuzzyctl import FuzzySystem
from tests.peers.catalogue import Peer
from tests.peers.drawing import MAXIMA
from tests.peers.literal import literal_norms

#: Largest difference that counts as agreement, relative to the larger of the value and the width of the output's range.
AGREEMENT = 1e-9
#: What a driver writes for a point that a peer stops at, and what stands for it here.
STOPPED, SKIPPED = "error", -1.2345e300
#: How far a point is moved, relative to the range of an input, to see whether it stands at a jump.
NUDGES = (0.0, 1e-16, 1e-15, 1e-13, 1e-11)
#: How widely our own values may scatter there, relative to the width of the output's range, other than at a jump.
SCATTER = 1e-2
#: The averages that have no value where the sums are 0 because all activations are.
AVERAGE_OF = {
    "weighted_sum": "weighted_average",
    "tsukamoto_sum": "tsukamoto",
    "inverse_tsukamoto_sum": "inverse_tsukamoto",
}
#: Number of orders of the rules that are tried where their activations tie.
ORDERS = 8


@dataclass(frozen=True, eq=False)
class Case:
    """A system with its points, and the text that a peer takes."""

    name: str
    system: FuzzySystem
    text: str
    points: Sequence[Sequence[float]]


@dataclass(frozen=True)
class Disagreement:
    """A place where a peer's number is another one."""

    case: Case
    row: int
    output: int
    ours: float
    theirs: float


@dataclass
class Tally:
    """What came out.

    Args:
        systems: How many were evaluated by both.
        values: How many numbers were compared.
        largest: Largest relative difference among those that agree.
        at_jumps: Values where ours takes the peer's within a rounding error of the inputs.
        emptied: Values where rules act, but leave an empty set, of a peer that then has no value, or any.
        tied: Values where ours takes the peer's when rules of equal activation are chosen in another order.
        rounded: Values where ours takes the peer's with the norms as the peer writes them, which lose digits near 1.
        refused: What a peer did not evaluate, with its words.
        failed: What fuzzyctl did not evaluate.
        disagreements: The rest.
    """

    systems: int = 0
    values: int = 0
    largest: float = 0.0
    at_jumps: int = 0
    emptied: int = 0
    tied: int = 0
    rounded: int = 0
    refused: list[tuple[Case, str]] = field(default_factory=list)
    failed: list[tuple[Case, str]] = field(default_factory=list)
    disagreements: list[Disagreement] = field(default_factory=list)


def outputs_of_peer(peer: Peer, cases: Sequence[Case]) -> dict[str, np.ndarray | str]:
    """Return the outputs of a peer by case, shape (points, outputs), or what it said instead."""
    command = peer.command()
    assert command is not None, f"{peer.name} is not installed"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for case in cases:
            (folder / f"{case.name}{peer.suffix}").write_text(case.text)
            lines = (" ".join(map(repr, p)) for p in case.points)
            (folder / f"{case.name}.points").write_text("".join(f"{line}\n" for line in lines))
        done = subprocess.run([*command, str(folder)], capture_output=True, text=True, check=False)
        return {case.name: _outputs(folder / case.name, len(case.system.outputs), done.stderr) for case in cases}


def _outputs(path: Path, width: int, stderr: str) -> np.ndarray | str:
    if path.with_suffix(".out").exists():
        lines = path.with_suffix(".out").read_text().splitlines()
        return np.array([[float(n) if n != STOPPED else SKIPPED for n in line.split()] for line in lines]).reshape(
            len(lines), width
        )
    error = path.with_suffix(".err")
    return error.read_text().strip() if error.exists() else f"no answer: {stderr[-300:]}"


@lru_cache(maxsize=1)
def _kernel(case: Case) -> fuzzyctl.Kernel:
    return fuzzyctl.compile(case.system, backend="numpy")


def evaluated(case: Case) -> np.ndarray:
    """Return our outputs, shape (points, outputs); points are a sequence."""
    return np.reshape(_kernel(case).run(np.array(case.points))[0], (len(case.points), len(case.system.outputs)))


@lru_cache(maxsize=1)
def _literal_kernel(case: Case) -> fuzzyctl.Kernel:
    """Return the kernel with norms as the peers write them."""
    with literal_norms(case.system.method.semantics.equal):
        kernel = fuzzyctl.compile(case.system, backend="numpy")
        kernel.batch(np.array(case.points[:1]))  # compiles
    return kernel


@lru_cache(maxsize=1)
def _shaken_kernel(case: Case) -> fuzzyctl.Kernel:
    """Return the kernel with norms whose results are less by one unit in the last place."""
    with literal_norms(case.system.method.semantics.equal, shaken=True):
        kernel = fuzzyctl.compile(case.system, backend="numpy")
        kernel.batch(np.array(case.points[:1]))
    return kernel


def differences(ours: np.ndarray, theirs: np.ndarray, widths: np.ndarray) -> np.ndarray:
    """Return relative differences; 0 where both are NaN or the same infinity, infinite where only one is."""
    same = (ours == theirs) | (np.isnan(ours) & np.isnan(theirs))
    with np.errstate(invalid="ignore", over="ignore"):
        scale = np.maximum(np.maximum(np.abs(ours), np.abs(theirs)), widths)
        relative = np.abs(ours - theirs) / scale
    relative[~np.isfinite(relative)] = np.inf
    relative[same | (theirs == SKIPPED)] = 0.0
    return relative


def widths_of(system: FuzzySystem) -> np.ndarray:
    """Return the width of the range of each output."""
    return np.array([system.number(o.upper) - system.number(o.lower) for o in system.outputs])


def compare(case: Case, theirs: np.ndarray, tally: Tally, *, empties: bool = True) -> None:
    """Compare a case, and add what came out.

    Args:
        case: The case.
        theirs: The outputs of the peer.
        tally: What to add to.
        empties: Whether the peer makes of an empty set, and of a sum of nothing, what the output is where no rule
            fires.
    """
    try:
        ours = evaluated(case)
    except Exception as error:  # noqa: BLE001 - a crash is a finding, and must not end the run
        tally.failed.append((case, f"{type(error).__name__}: {error}"))
        return
    tally.systems += 1
    widths = widths_of(case.system)
    relative = differences(ours, theirs, widths)
    held = [k for k, o in enumerate(case.system.outputs) if type(o.otherwise).__name__ == "Hold"]
    for output in range(relative.shape[1]):
        rows = len(case.points)
        for row in np.flatnonzero(relative[:, output] > AGREEMENT):
            place = (int(row), output, theirs[row, output], widths[output])
            jumps = reaches(_kernel(case), case, *place)
            emptied = not jumps and _leaves_nothing(case, int(row), output, empties=empties)
            tied = not jumps and not emptied and _tied(case, *place)
            if jumps or emptied or tied or noisy(case, int(row), output, ours) or _rounded(case, *place):
                tally.at_jumps += jumps
                tally.emptied += emptied
                tally.tied += tied
                tally.rounded += not jumps and not emptied and not tied
                relative[row, output] = 0.0
                if output in held:  # what it holds from here on is another number
                    rows = int(row)
                    break
                continue
            tally.disagreements.append(
                Disagreement(case, int(row), output, float(ours[row, output]), float(theirs[row, output]))
            )
        own = relative[:rows, output]
        tally.values += rows
        tally.largest = max(tally.largest, float(own[own <= AGREEMENT].max(initial=0.0)))


def reaches(kernel: fuzzyctl.Kernel, case: Case, row: int, output: int, value: float, width: float) -> bool:
    """Return whether our output takes a value within a rounding error of the inputs of a point.

    It does at jumps, and where it amplifies rounding: there our own values scatter as widely as the peer's is away.
    """
    random = Random(row)
    widths = [_width(case, k) for k in range(len(case.system.inputs))]
    points = [
        [
            x + random.choice((-1.0, 0.0, 1.0)) * nudge * max(abs(x), w) if isfinite(x) else x
            for x, w in zip(case.points[row], widths, strict=True)
        ]
        for nudge in NUDGES
        for _ in range(12)
    ]
    state = None
    if kernel.n_states:
        state = kernel.start()
        if row:
            _, state = kernel.run(np.array(case.points[:row]))
    ours = np.reshape(kernel.batch(np.array(points), state), (len(points), -1))[:, output]
    if (differences(ours, np.full(len(points), value), np.array(width)) <= AGREEMENT).any():
        return True
    if not np.isfinite(ours).all():
        return False
    spread = float(np.ptp(ours))
    return bool(spread <= SCATTER * width and np.min(ours) - spread <= value <= np.max(ours) + spread)


def _leaves_nothing(case: Case, row: int, output: int, *, empties: bool) -> bool:
    """Return whether the set of an output is 0 at all samples, or hedges make 0 of all that is summed up."""
    outputs = list(case.system.outputs)
    own = outputs[output].defuzzifier or case.system.method.defuzzifier
    if empties:
        return False
    kind = AVERAGE_OF.get(own.kind, own.kind) if own.over_rules else "lom"
    other = {"kind": kind, "rule": None, "tolerance": 0.0}
    changed = {"defuzzifier": own.model_copy(update=other), "otherwise": "nan", "clamped": False}
    outputs[output] = outputs[output].model_copy(update=changed)
    kernel = fuzzyctl.compile(case.system.model_copy(update={"outputs": tuple(outputs)}), backend="numpy")
    return bool(np.isnan(np.reshape(kernel.run(np.array(case.points))[0], (len(case.points), -1))[row, output]))


def _tied(case: Case, row: int, output: int, value: float, width: float) -> bool:
    """Return whether a value is ours where the highest or lowest activations are chosen in another order of the rules.

    Tools choose any of equal ones, here it is the first. Rules that read outputs are in order for other reasons, and
    activations that are compared are not theirs.
    """
    if not any(m.activation.kind in ("highest", "lowest") for m in case.system.rule_methods):
        return False
    return any(reaches(kernel, case, row, output, value, width) for kernel in _reordered(case))


@lru_cache(maxsize=1)
def _reordered(case: Case) -> list[fuzzyctl.Kernel]:
    """Return kernels of the same rules in other orders within their blocks, the reverse one first."""
    random, system = Random(0), case.system
    own = [m.block for m in system.rule_methods]
    places = [[r for r, block in enumerate(own) if block == b] for b in sorted(set(own))]
    orders = [[p[::-1] for p in places], *([random.sample(p, len(p)) for p in places] for _ in range(ORDERS - 1))]
    systems = (system.with_rules([system.rules[r] for p in order for r in p]) for order in orders)
    return [fuzzyctl.compile(s, backend="numpy") for s in systems]


def _rounded(case: Case, row: int, output: int, value: float, width: float) -> bool:
    """Return whether rounding in norms, or in what is made of them, explains a value."""
    own = case.system.outputs[output].defuzzifier or case.system.method.defuzzifier
    if own.kind in MAXIMA and among_maxima(case, row, output, value, width):
        return True
    if _vanishes(case, row, output):
        return True
    return any(reaches(kernel(case), case, row, output, value, width) for kernel in (_literal_kernel, _shaken_kernel))


def _vanishes(case: Case, row: int, output: int) -> bool:
    """Return whether all activations are so small that rounding of them shows, such as that of 1 + a - 1.

    They may be 0 here, and not where the inputs are off by their last digit.
    """
    name, random = case.system.outputs[output].name, Random(row)
    largest = 0.0
    for nudge in (0.0, *(6 * [1e-16])):
        moved = [
            x + random.choice((-1.0, 1.0)) * nudge * max(abs(x), _width(case, k)) if isfinite(x) else x
            for k, x in enumerate(case.points[row])
        ]
        found = fuzzyctl.why(case.system, dict(zip((i.name for i in case.system.inputs), moved, strict=True)))
        largest = max(
            largest, *(c.effective_activation for r in found.rules for c in r.contributions if c.output == name), 0.0
        )
    return 0.0 < largest < 2.0**-53 / AGREEMENT


def among_maxima(case: Case, row: int, output: int, value: float, width: float) -> bool:
    """Return whether a value lies between samples whose degrees are largest but for rounding."""
    ends = []
    for kind in ("som", "lom"):
        outputs = list(case.system.outputs)
        own = outputs[output].defuzzifier or case.system.method.defuzzifier
        method = own.model_copy(update={"kind": kind, "by": "value", "tolerance": 1e-12})
        outputs[output] = outputs[output].model_copy(update={"defuzzifier": method})
        kernel = fuzzyctl.compile(case.system.model_copy(update={"outputs": tuple(outputs)}), backend="numpy")
        ends.append(np.reshape(kernel.run(np.array(case.points))[0], (len(case.points), -1))[row, output])
    slack = AGREEMENT * max(width, abs(value))
    return bool(ends[0] < ends[1] and ends[0] - slack <= value <= ends[1] + slack)


def noisy(case: Case, row: int, output: int, ours: np.ndarray) -> bool:
    """Return whether our number changes when norms are written as the peers write them, that is by their rounding."""
    literal = np.reshape(_literal_kernel(case).run(np.array(case.points))[0], ours.shape)
    return bool(differences(literal, ours, widths_of(case.system))[row, output] > AGREEMENT)


def _width(case: Case, position: int) -> float:
    variable = case.system.inputs[position]
    return case.system.number(variable.upper) - case.system.number(variable.lower)


def report(peer: Peer, tally: Tally) -> Iterator[str]:
    """Yield lines for people."""
    yield f"{peer.name} {peer.version} beside profile {peer.profile}"
    yield f"  systems evaluated by both: {tally.systems}"
    yield f"  numbers compared: {tally.values}"
    yield f"  largest relative difference among those that agree: {tally.largest:.2g}"
    yield f"  at jumps, where rounding decides: {tally.at_jumps}"
    yield f"  at empty sets, which the tool reads otherwise: {tally.emptied}"
    yield f"  at ties of activations, where tools choose any: {tally.tied}"
    yield f"  with the peer's rounding of norms: {tally.rounded}"
    yield f"  refused by {peer.name}: {len(tally.refused)}"
    yield f"  refused by fuzzyctl: {len(tally.failed)}"
    cases = {d.case.name for d in tally.disagreements}
    yield f"  numbers that disagree: {len(tally.disagreements)} in {len(cases)} systems"
