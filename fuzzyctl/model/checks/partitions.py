"""Partitions of unity: an input whose degrees sum to 1 except between few neighbours has a probable slip."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.expr import Expr, Negate, Number, to_text
from fuzzyctl.formulas import MEMBERSHIP, Vertex
from fuzzyctl.model.computed_numbers import Numbers
from fuzzyctl.model.variable import Input, Term
from fuzzyctl.records import dataclass

#: How far a sum of degrees may be from 1 by rounding of its terms' corners.
_ROUNDING: Final = 1e-9
#: Most neighbours whose sum one slip may spoil: those on both sides of a term.
_MOST_BAD: Final = 2
#: Most terms of a line that a help writes out.
_MOST_WRITTEN: Final = 12
#: Sets of an input that overlap gaps, counted once for each gap; with more of them it is not a partition.
_MOST_MET: Final = 20_000
#: Where in a stretch a sum is looked at: two places tell a line, and the middle is shown.
_LOOKS: Final = (0.5, 0.2)


@dataclass(frozen=True)
class _Set:
    name: str
    vertices: Sequence[Vertex]
    core: tuple[float, float]

    def degree(self, x: float) -> float:
        """Return the degree of a value that is not a corner."""
        if x < self.vertices[0][0]:
            return self.vertices[0][1]
        for (a, u), (b, v) in pairwise(self.vertices):
            if x < b:
                return u + (v - u) * (x - a) / (b - a)
        return self.vertices[-1][1]


def spoilt_partitions(numbers: Numbers) -> Iterator[Diagnostic]:
    """Find inputs whose degrees sum to 1 between most neighbouring terms, but not between one or two."""
    for variable in numbers.system.inputs:
        sets, ends = _sets(numbers, variable), numbers.range(variable)
        if ends is None:
            continue
        gaps = [(a, b) for a, b in pairwise(sets) if ends[0] <= a.core[1] < b.core[0] <= ends[1]]
        met = _met(sets, gaps)
        if sum(map(len, met)) > _MOST_MET:
            continue
        sums = [_sum_off(group, a.core[1], b.core[0]) for group, (a, b) in zip(met, gaps, strict=True)]
        bad = [k for k, off in enumerate(sums) if off is not None]
        good = len(gaps) - len(bad)
        if bad and len(bad) <= _MOST_BAD and bad[-1] - bad[0] < _MOST_BAD and good >= max(2, len(bad)):
            yield _diagnostic(variable, gaps, sums, bad)


def _sets(numbers: Numbers, variable: Input) -> list[_Set]:
    """Return the terms of an input by their cores; none if one is curved, has a height, or overlaps another's core."""
    results = []
    shapes = numbers.shapes(variable)
    for term, parameters in shapes:
        formula = MEMBERSHIP[term.membership.kind]
        vertices = formula.vertices(parameters)
        if not vertices or numbers.value(term.membership.height) != 1.0:
            return []
        left, right = formula.core(parameters)
        results.append(_Set(term.name, vertices, (left, right)))
    results.sort(key=lambda s: s.core)
    apart = all(a.core[1] <= b.core[0] for a, b in pairwise(results))
    return results if apart and len(shapes) == len(variable.terms) else []


def _met(sets: Sequence[_Set], gaps: Sequence[tuple[_Set, _Set]]) -> list[list[_Set]]:
    """Return for each gap between neighbouring cores the sets that may be above 0 there."""
    starts, stops = [a.core[1] for a, _ in gaps], [b.core[0] for _, b in gaps]
    met: list[list[_Set]] = [[] for _ in gaps]
    for s in sets:
        (low, at_low), (high, at_high) = s.vertices[0], s.vertices[-1]
        first = bisect_right(stops, low) if at_low == 0.0 else 0
        last = bisect_left(starts, high) if at_high == 0.0 else len(gaps)
        for group in met[first:last]:
            group.append(s)
    return met


def _sum_off(sets: Sequence[_Set], low: float, high: float) -> tuple[float, float] | None:
    """Return a point between two cores where the degrees do not sum to 1, and their sum there, or None."""
    if len(sets) == 2 and _is_crossing(sets[0], sets[1], low, high):
        return None
    corners = sorted({low, high} | {x for s in sets for x, _ in s.vertices if low < x < high})
    for a, b in pairwise(corners):
        for share in _LOOKS:
            x = a + share * (b - a)
            total = sum(s.degree(x) for s in sets)
            if a < x < b and abs(total - 1.0) > _ROUNDING:
                return x, total
    return None


def _is_crossing(falling: _Set, rising: _Set, low: float, high: float) -> bool:
    """Return whether one set falls from 1 to 0 between two points while the other rises, as on a `terms` line."""
    return falling.vertices[-2:] == ((low, 1.0), (high, 0.0)) and rising.vertices[:2] == ((low, 0.0), (high, 1.0))


#: A `terms` line: the name of its source, and its number.
_Line = tuple[str, int]


def helps_by_line(terms: Iterable[Term], *, only_peaks: bool) -> dict[_Line, str]:
    """Return for each `terms` line how to remove an unused term of it without changing any number.

    Args:
        terms: The terms of one variable that rules use.
        only_peaks: Whether the peaks of the terms are all that counts.
    """
    results: dict[_Line, list[Term]] = {}
    for term in terms:
        line = _line_of(term)
        if line is not None:
            results.setdefault(line, []).append(term)
    return {line: _help_of(findings, only_peaks) for line, findings in results.items()}


def _help_of(used: Sequence[Term], only_peaks: bool) -> str:
    if len(used) > _MOST_WRITTEN:
        return "use it in a rule, or keep it in its place and write 'allow FZ208'"
    return f"use it in a rule; to remove it, write the others as they are: {_written(used, only_peaks)}"


def removal(term: Term, helps: Mapping[_Line, str], *, only_peaks: bool) -> tuple[tuple[str, ...], str]:
    """Return the effect of removing an unused term, and how to remove it without changing any number.

    Args:
        term: The term.
        helps: Those of the lines of its variable, see `helps_by_line`.
        only_peaks: Whether the peaks of the terms are all that counts.

    Returns:
        The fact, if the removal changes anything, and the help.
    """
    line = _line_of(term)
    help_text = helps.get(line) if line is not None else None
    behind = term.span.source.text[term.span.end : term.span.end + 20] if term.span is not None else ""
    has_peak = behind.lstrip().startswith("@")
    if help_text is None or (has_peak and only_peaks):
        return (), "remove it, or use it in a rule"
    return (
        "without it the terms beside it reach further" if has_peak else "without it the peaks of its line move",
    ), help_text


def _line_of(term: Term) -> _Line | None:
    """Return the `terms` line of a triangle whose feet are the peaks beside it, None for any other term.

    Such a term has no separate membership function in the text, so both have the same location.
    """
    span = term.span
    if span is None or term.membership.kind != "triangle" or term.membership.span != span:
        return None
    return span.source.name, span.line


def _written(terms: Sequence[Term], only_peaks: bool) -> str:
    if only_peaks and len(terms) > 1:
        return f"terms {' '.join(f'{t.name}@{_peak_text(t.membership.arguments[1])}' for t in terms)}"
    return ", ".join(f"{t.name} = triangle({', '.join(map(to_text, t.membership.arguments))})" for t in terms)


def _peak_text(peak: Expr) -> str:
    text = to_text(peak)
    is_number = isinstance(peak, Number) or (isinstance(peak, Negate) and isinstance(peak.operand, Number))
    return text if is_number else f"({text})"


def _diagnostic(
    variable: Input,
    gaps: Sequence[tuple[_Set, _Set]],
    sums: Sequence[tuple[float, float] | None],
    bad: Sequence[int],
) -> Diagnostic:
    first, last = gaps[bad[0]][0].name, gaps[bad[-1]][1].name
    message = f"the degrees of '{variable.name}' sum to 1 between its terms, but not between '{first}' and '{last}'"
    facts = tuple(f"at {variable.name} = {off[0]:.6g} they sum to {off[1]:.6g}" for k in bad if (off := sums[k]))
    help_text = "check the feet and peaks there; where it is meant, write 'allow FZ406'"
    return Diagnostic("FZ406", message, variable.span, "hint", facts, help_text)
