"""Blocks `InputVariable` and `OutputVariable` of `.fll` files."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

from fuzzyctl.diagnostics.diagnostic import Note
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Expr, Number
from fuzzyctl.formats.common.ranges import linear_range, warn_of_degrees_beyond
from fuzzyctl.formats.common.report import Findings
from fuzzyctl.model.variable import Fallback, Hold, Membership, Term
from tests.oracles.fll.lines import Block, Line
from tests.oracles.fll.terms import Place, TermReader, number, words


@dataclass(frozen=True)
class Variable:
    """A variable as read.

    Args:
        name: Its name.
        label: Its description.
        lower, upper: The ends of its range, perhaps infinite.
        terms: Its terms.
        enabled: Whether it is enabled; the propositions of a disabled one are false.
        lock_range: Whether it is held within its range.
        block: Where it is declared.
        unread: Names of terms that are declared and could not be read, which has been reported.
        is_output: Whether it is an output.
    """

    name: str
    label: str
    lower: Number
    upper: Number
    terms: tuple[Term, ...]
    enabled: bool
    lock_range: bool
    block: Block
    unread: frozenset[str]
    is_output: bool

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its terms."""
        return tuple(t.name for t in self.terms)

    @property
    def span(self) -> Span:
        """Where its name stands."""
        value = self.block.head.value
        return value if value.start < value.end else self.block.head.span


def own_name(block: Block, findings: Findings) -> str:
    """Return the name of a variable; what no name of a rule can hold is left out, as fuzzylite does."""
    given = block.head.value.text
    name = "".join(c for c in given if not c.isspace() and c not in "()")
    if not name:
        message = "the variable has no name"
        findings.error("FZ212", message, block.head.span, help=f"write: {block.head.span.text.strip(': ')}: NAME")
    elif name != given:
        message = f"'{given[:60]}' is not a name for rules; it becomes '{name[:60]}'"
        findings.warning("FZ604", message, block.head.value, help="names have no blanks and no parentheses")
    return name


def flag(line: Line | None, usual: bool, findings: Findings) -> bool:
    """Return a switch, or the usual one where it is not given."""
    if line is None:
        return usual
    text = line.value.text.lower()
    if text in ("true", "false"):
        return text == "true"
    findings.error("FZ601", f"'{line.key}' is true or false, got '{line.value.text[:40]}'", line.value)
    return usual


def read_variable(block: Block, name: str, place: Place, findings: Findings) -> Variable:
    """Return a variable; what cannot be read is reported."""
    terms = TermReader(place, findings)
    read = [t for line in block.all("term") if (t := terms.read(line)) is not None]
    lower, upper = _range(block, findings)
    if place.is_input:
        warn_of_degrees_beyond(read, name, (lower.value, upper.value), findings)
    else:
        joined = block.line("aggregation")
        sets = [t for t in read if t.membership.kind == "formula"]
        below = joined is None or joined.value.text != "Maximum"
        warn_of_degrees_beyond(sets, name, (lower.value, upper.value), findings, below=below)
    label = block.line("description")
    return Variable(
        name=name,
        label=label.value.text.replace('"', "'") if label is not None else "",
        lower=lower,
        upper=upper,
        terms=tuple(read),
        enabled=flag(block.line("enabled"), True, findings),
        lock_range=flag(block.line("lock-range"), False, findings),
        block=block,
        unread=frozenset(w[0].text for line in block.all("term") if (w := words(line.value))) - {t.name for t in read},
        is_output=not place.is_input,
    )


def _range(block: Block, findings: Findings) -> tuple[Number, Number]:
    line = block.line("range")
    if line is None:
        return Number(-math.inf), Number(math.inf)
    ends = words(line.value)
    if len(ends) != 2:
        findings.error("FZ601", "a range has two numbers", line.value, help="write, for example: range: 0.0 10.0")
        return Number(0.0), Number(1.0)
    lower, upper = (number(end, findings) for end in ends)
    return lower or Number(0.0), upper or Number(1.0)


class Ranged(Protocol):
    """A variable with the range that a file gives it."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def lower(self) -> Number:
        """The lower end."""

    @property
    def upper(self) -> Number:
        """The upper end."""

    @property
    def span(self) -> Span:
        """Where its name stands."""


def finite_range(
    variable: Ranged, ends: Iterable[float], findings: Findings, kind: str = "infinite"
) -> tuple[Number, Number]:
    """Return a finite range: the one given, or what some places reach where it is infinite, or as `kind` says."""
    lower, upper = variable.lower, variable.upper
    if math.isfinite(lower.value) and math.isfinite(upper.value):
        return lower, upper
    finite = [e for e in ends if math.isfinite(e)]
    low = lower.value if math.isfinite(lower.value) else min(finite, default=0.0)
    high = upper.value if math.isfinite(upper.value) else max(finite, default=1.0)
    if low >= high:
        low, high = (low, low + 1.0) if math.isfinite(lower.value) else (high - 1.0, high)
    message = f"the range of '{variable.name}' is {kind}; [{low:.6g}, {high:.6g}] is what its terms need"
    findings.warning("FZ603", message, lower.span or variable.span, help="give it a finite range")
    return Number(low), Number(high)


def corners(memberships: Iterable[Membership]) -> list[float]:
    """Return the numbers of some memberships, which lie about where they matter."""
    return [a.value for m in memberships for a in m.arguments if isinstance(a, Number)]


def reached(membership: Membership, ranges: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Return the least and largest value of a constant or linear consequent over the ranges of the inputs."""
    given = [a.value for a in membership.arguments if isinstance(a, Number)]
    if membership.kind not in ("constant", "linear") or not given:
        return math.inf, -math.inf
    return linear_range(given, ranges)


def otherwise(block: Block, findings: Findings) -> Expr | Fallback | Hold | None:
    """Return what an output is where no rule fires: its default, or its previous value where that is locked."""
    line = block.line("default")
    default: Number | None = None
    if line is not None and line.value.text.lower() not in ("nan", "-nan"):
        default = number(line.value, findings)
    locked = block.line("lock-previous", "lock-valid")
    if flag(locked, False, findings):
        return Hold(start=default if default is not None else "nan")
    return default if default is not None else "nan"


def named_twice(blocks: Sequence[Block], names: Sequence[str], findings: Findings) -> None:
    """Report variables of one name, which rules could not tell apart."""
    first: dict[str, Block] = {}
    for block, name in zip(blocks, names, strict=True):
        earlier = first.setdefault(name, block)
        if earlier is not block:
            note = Note(earlier.head.span, "first declared here")
            findings.error("FZ201", f"variable '{name}' is declared twice", block.head.value, notes=(note,))
