"""Verdicts of proofs: proved, refuted by a witness, or undecided."""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING

from fuzzyctl.analysis.coverage.box_search import Side
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.operations import Displayed
from fuzzyctl.records import dataclass

if TYPE_CHECKING:
    from fuzzyctl.simulation.members import Tube


@dataclass(frozen=True, repr=False)
class Proved(Displayed):
    """A guarantee that holds for all inputs.

    Args:
        claim: The guarantee as a rule file writes it.
        span: Its place, if it came from a text.
        note: The numbers that the proof is about, where these are not the numbers that kernels return.
        data: Numbers of the proof, if they are kept: of `require stable` the ball, with its quadratic function and the
            vertices of the derivatives.
    """

    claim: str
    span: Span | None = field(default=None, compare=False, repr=False)
    note: str = ""
    data: object = field(default=None, compare=False, repr=False)

    def __repr__(self) -> str:
        return _line("Proved", self.claim, self.note)


@dataclass(frozen=True)
class Witness:
    """A point that breaks a guarantee, evaluated by a kernel.

    Args:
        point: Values of the inputs.
        sides: The sides of the comparison there: texts with their values.
        other: A second point, for claims that compare two, such as `increasing`.
        in_full: Whether numbers with fewer digits do not break it.
    """

    point: dict[str, float]
    sides: tuple[tuple[str, float], ...]
    other: dict[str, float] | None = None
    in_full: bool = field(default=False, compare=False, repr=False)

    def __str__(self) -> str:
        point = ", ".join(f"{n} = {v!r}" if self.in_full else f"{n} = {_digits(v)}" for n, v in self.point.items())
        values = ", ".join(f"{text} {'is' if ' = ' in text else '='} {v:.12g}" for text, v in self.sides)
        return f"at {point}: {values}" if values else f"at {point}" if point else "in the run of the file"


def _digits(x: float) -> str:
    """Return a number with 12 digits, or in full beside one with few: a claim may hold at that one."""
    short = f"{x:.12g}"
    return repr(x) if float(short) == float(f"{x:.6g}") != x else short


@dataclass(frozen=True, repr=False)
class Refuted(Displayed):
    """A guarantee that a witness breaks; see `Proved`.

    Args:
        claim: The guarantee.
        witness: The point.
        span: Its place in the text.
        note: Of a controller, whether a run reaches the state of the witness.
    """

    claim: str
    witness: Witness
    span: Span | None = field(default=None, compare=False, repr=False)
    note: str = ""

    def __repr__(self) -> str:
        return _line("Refuted", self.claim, str(self.witness), self.note)


@dataclass(frozen=True, repr=False)
class Undecided(Displayed):
    """A guarantee that is neither proved nor refuted; see `Proved`.

    Args:
        claim: The guarantee.
        reason: What would decide it.
        boxes: Where it is open: some of the boxes that remain, the ends of each input by name.
        remaining: How many boxes remain.
        span: Its place in the text.
    """

    claim: str
    reason: str
    boxes: tuple[dict[str, Side], ...] = ()
    remaining: int = 0
    span: Span | None = field(default=None, compare=False, repr=False)

    def __repr__(self) -> str:
        return _line("Undecided", self.claim, self.reason)


def _line(word: str, claim: str, *facts: str) -> str:
    return printable(f"{word}({'; '.join(filter(None, (claim, *facts)))})")


Verdict = Proved | Refuted | Undecided


class Verdicts(tuple[Verdict, ...], Displayed):
    """Verdicts in the order of the guarantees; a notebook shows them as a table.

    `tube` encloses the outputs of the plants of a loop for all members of its family, and is None without claims that
    take it. `fuzzyctl.plot.runs(run, tube=verdicts.tube)` draws it behind a run.
    """

    tube: Tube | None = None
