"""Checks of the families of loops, and of the times of claims about every instant."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, Note
from fuzzyctl.expr import span_of
from fuzzyctl.model.block import Bounds, Guarantee, Param, ParamValues
from fuzzyctl.model.checks.blocks import computed, ends_of
from fuzzyctl.model.checks.terms import inside
from fuzzyctl.model.controller import State
from fuzzyctl.model.loop import Always, Disturbance, Loop, Varied
from fuzzyctl.model.shared_params import with_values
from fuzzyctl.simulation.loop_params import names_behind, range_mistakes, timing_params

#: Most numbers in which the members of a family differ.
MOST_VARIED: Final = 12


def mistakes(loop: Loop, params: ParamValues) -> Iterator[Diagnostic]:
    """Check the family of a loop and the times of its claims, as far as its params have values."""
    items: tuple[Varied | Disturbance, ...] = (*loop.varied, *loop.disturbances)
    if len(items) > MOST_VARIED:
        message = f"the members of the family differ in {len(items)} numbers, more than {MOST_VARIED}"
        help_text = "keep the 'for' and 'disturbance' lines that matter most"
        yield Diagnostic("FZ112", message, items[MOST_VARIED].span, help=help_text)
    timing = timing_params(loop) if loop.varied else set()
    owners = {i.name: with_values(block, values).param_values for i, block, values in inside(loop, params)}
    for item in items:
        ends = ends_of(item.bounds, params)
        faults = list(range_mistakes(item, ends, params))
        yield from faults
        if item.name in timing:
            message = f"'{item.name}' cannot differ between members: the sample times or the duration depend on it"
            yield Diagnostic("FZ214", message, item.span, help="remove the line, or give these times numbers")
        elif ends is not None and not faults:
            values = owners.get(item.name.partition(".")[0], params) if "." in item.name else params
            yield from _within(loop, item, ends, values)
    duration = computed(loop.duration, params)
    for claim in loop.always:
        yield from _times(claim, params, duration if isinstance(duration, float) else math.inf)


def _within(
    loop: Loop, item: Varied | Disturbance, ends: tuple[float, float], values: ParamValues
) -> Iterator[Diagnostic]:
    """Check a range by the one that the state or param declares, and the value of the file by the range.

    Args:
        loop: The loop.
        item: The number of the family.
        ends: The ends of its range.
        values: The params of the block that declares it.
    """
    declaration, bounds, text = loop.declared(item.name), item.bounds, item.bounds.text(*ends)
    if declaration is None:
        return
    _, declared = declaration
    match declared:
        case Param(expression=expr) | State(start=expr) | Disturbance(nominal=expr):
            value = computed(expr, values)
    if isinstance(value, Diagnostic):
        if isinstance(item, Disturbance):
            yield value
        return
    limits = None if declared.bounds is None or declared is item else ends_of(declared.bounds, values)
    if limits is not None and declared.bounds is not None and not _holds(declared.bounds, limits, bounds, ends):
        what = "param" if isinstance(declared, Param) else "state"
        message = f"the range of '{item.name}' is {text}, outside of {declared.bounds.text(*limits)}"
        place = declared.bounds.span
        notes = () if place is None else (Note(place, f"the range of the {what} is declared here"),)
        yield Diagnostic("FZ302", message, bounds.span, help="narrow it, or widen the declared range", notes=notes)
    elif value is not None and not bounds.holds(value, *ends):
        if isinstance(item, Disturbance):
            message = f"the value of disturbance '{item.name}' is {value:g}, outside of {text}"
            help_text = "give a value in the range, or widen the range"
            yield Diagnostic("FZ302", message, span_of(item.nominal) or item.span, help=help_text)
        else:
            message = f"'{item.name}' is {value:g} in the file, outside of its family {text}"
            facts = ("a plain run is no member of the family",)
            help_text = f"widen the range, or give '{item.name}' a value in it"
            yield Diagnostic("FZ214", message, item.span, "warning", facts, help_text)


def _holds(outer: Bounds, limits: tuple[float, float], inner: Bounds, ends: tuple[float, float]) -> bool:
    """Return whether a range lies within another one."""
    low = outer.holds(ends[0], *limits) or (inner.without_lower and ends[0] == limits[0])
    return low and (outer.holds(ends[1], *limits) or (inner.without_upper and ends[1] == limits[1]))


def _times(claim: Always, params: ParamValues, duration: float) -> Iterator[Diagnostic]:
    """Check the times of a claim about every instant of a run of a duration [s]."""
    values = [None if e is None else computed(e, params) for e in (claim.begin, claim.end)]
    yield from (v for v in values if isinstance(v, Diagnostic))
    begin, end = values
    for word, time, expr in (("from", begin, claim.begin), ("until", end, claim.end)):
        if isinstance(time, float) and expr is not None and not 0.0 <= time < math.inf:
            why = "below 0" if time < 0 else "not finite"
            message = f"'{word}' is {time:g} s, {why}"
            yield Diagnostic("FZ302", message, span_of(expr), help=f"write a time, such as: {word} 20 s")
    if isinstance(begin, float) and isinstance(end, float) and begin > end and claim.end is not None:
        message = f"'until' is {end:g} s, before 'from', {begin:g} s"
        yield Diagnostic("FZ304", message, span_of(claim.end), help="put the earlier time first")
    elif isinstance(begin, float) and duration < begin < math.inf and claim.begin is not None and not claim.forever:
        message = f"the claim begins at {begin:g} s, and the run ends at {duration:g} s"
        help_text = "begin earlier, lengthen the 'run' line, or write 'forever'"
        facts = ("it is about no instant",)
        yield Diagnostic("FZ214", message, span_of(claim.begin), "warning", facts, help_text)
    elif isinstance(end, float) and duration < end < math.inf and claim.end is not None:
        message = f"the claim ends at {end:g} s, and the run ends at {duration:g} s"
        facts = ("'prove' judges it beyond the run, 'simulate' does not",)
        yield Diagnostic("FZ214", message, span_of(claim.end), "warning", facts, "lengthen the 'run' line")


def why_not_alike(loop: Loop, claim: Guarantee) -> str:
    """Return why members of a family differ in its ranges, or in the times of a claim; an empty text if none does."""
    ranges = [(f"the range of '{name}'", (b.lower, b.upper)) for name, b in loop.family.items()]
    times = (claim.begin, claim.end, claim.within) if isinstance(claim, Always) else ()
    for what, values in (*ranges, ("a time or the tolerance of the claim", times)):
        names = names_behind(loop.params, [e for e in values if e is not None])
        if moving := [v.name for v in loop.varied if v.name in names]:
            return f"'{moving[0]}' cannot vary in a proof: {what} depends on it"
    return ""
