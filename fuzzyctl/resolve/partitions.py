"""Resolves `terms` lines: names with peaks, with values, or with neither, which are spaced evenly over the range."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Sequence
from typing import Final

from fuzzyctl import expr as ex
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.variable import Membership, Term
from fuzzyctl.resolve.context import Context

_INFINITY = ex.Name("inf")
_RUN_IN: Final = re.compile(r"(.*?\D)(\d+)")


def partition(context: Context, statement: sx.Variable, line: sx.TermsLine) -> list[Term | None]:
    """Expand a `terms` line: triangles by their peaks, uniform triangles over the range, or singletons by value."""
    items = line.items
    kinds = {_form(i) for i in items}
    if len(kinds) > 1:
        odd = next(i for i in items if _form(i) != _form(items[0]))
        context.report(
            "FZ214",
            "one 'terms' line mixes peaks (@), values (=) and bare names",
            odd.name.span,
            help=_joined(items) or "give every term a peak, or every term a value, or none of them anything",
        )
        return [None] * len(items)
    if any(
        e is not None and not context.check_names(e, context.params, "param") for i in items for e in (i.peak, i.value)
    ):
        return [None] * len(items)
    if kinds == {"="}:
        return [_made("singleton", (i.value,), i.name) for i in items]
    if len(items) == 1:
        context.report("FZ214", "a partition needs two terms or more", items[0].name.span, help="write triangle(...)")
        return [None]
    peaks = [i.peak for i in items] if kinds == {"@"} else _uniform(statement, len(items))
    return [
        _made(
            "triangle",
            (peaks[k - 1] if k else ex.Negate(_INFINITY), p, peaks[k + 1] if k + 1 < len(peaks) else _INFINITY),
            i.name,
        )
        for k, (i, p) in enumerate(zip(items, peaks, strict=True))
    ]


def _form(item: sx.PartitionItem) -> str:
    return "@" if item.peak is not None else "=" if item.value is not None else ""


def _joined(items: Sequence[sx.PartitionItem]) -> str:
    """Say how a name is written that ran into its number, such as Z0 for Z@0 or Z=0."""
    sign = next(form for form in map(_form, items) if form)
    run = next((found for i in items if not _form(i) and (found := _RUN_IN.fullmatch(i.name.text))), None)
    return f"write {run[1]}{sign}{run[2]}" if run is not None else ""


def _uniform(statement: sx.Variable, count: int) -> list[ex.Expr]:
    """Peaks from end to end of the range: lower + k (upper - lower) / (count - 1), the ends themselves exact."""
    lower, upper = statement.lower, statement.upper
    if not any(isinstance(n, ex.Name | ex.Call) for e in (lower, upper) for n in ex.walk(e)):
        with contextlib.suppress(ex.ExprError):  # a range without a value has a diagnostic of its own
            # Numbers, so that the system reads well when it is printed; the same as those of the expressions below.
            low, high = ex.evaluate(lower, {}), ex.evaluate(upper, {})
            inner = [(low * (count - 1 - k) + high * k) / (count - 1) for k in range(1, count - 1)]
            return [lower, *map(ex.Number, inner), upper]
    peaks: list[ex.Expr] = [lower]
    for k in range(1, count - 1):
        # A weighted mean of the ends is symmetric where the range is: the middle of [-a, a] is exactly 0.
        peaks.append((lower * float(count - 1 - k) + upper * float(k)) / float(count - 1))
    peaks.append(upper)
    return peaks


def _made(kind: str, arguments: tuple[ex.Expr | None, ...], word: sx.Word) -> Term:
    given = tuple(a for a in arguments if a is not None)
    return Term(name=word.text, membership=Membership(kind=kind, arguments=given, span=word.span), span=word.span)
