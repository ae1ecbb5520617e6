"""Differences of two blocks as text and as plain data."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

from fuzzyctl.comparison.differences import Difference
from fuzzyctl.comparison.explanation import Cause, Explanation

#: Least part of a difference that a cause is named for.
LEAST_SHARE: Final = 1e-3


def compared_data(d: Difference, explained: Explanation | None) -> dict[str, Any]:
    """Return a difference and its explanation as plain data; null stands for no value, and for an infinite one."""
    gap, largest = d.gap, () if explained is None else explained.largest
    return {
        "output": d.output,
        "largest": _plain(d.largest),
        "point": d.point,
        "first": _plain(d.first),
        "second": _plain(d.second),
        "mean": d.mean,
        "points": d.points,
        "one_sided": d.one_sided,
        "causes": _causes_data(largest),
        "causes_of_mean": _causes_data(largest if explained is None else explained.mean or largest),
        "gap": None
        if gap is None
        else {
            "point": gap.point,
            "first": _plain(gap.first),
            "second": _plain(gap.second),
            "causes": _causes_data(() if explained is None else explained.gap),
        },
    }


def _causes_data(causes: tuple[Cause, ...]) -> list[dict[str, Any]]:
    return [{"name": c.name, "first": c.before, "second": c.after, "explains": c.explains} for c in causes]


def _plain(value: float) -> float | None:
    return value if math.isfinite(value) else None


def compared_text(
    first: str,
    block: Any,
    second: str,
    differences: Sequence[Difference],
    explanations: Sequence[Explanation | None],
) -> list[str]:
    """Return the lines of a comparison.

    Args:
        first: The label of the first block.
        block: Either of them, for the units.
        second: The label of the second block.
        differences: The difference of each output.
        explanations: The explanation of each, None if none is searched for.
    """
    count = differences[0].points
    lines = [f"{first}  and  {second}: {count:,} point{'' if count == 1 else 's'}"]
    units = {o.name: o.unit for o in block.outputs} | {f"next {s.name}": s.unit for s in block.states}
    for d, explained in zip(differences, explanations, strict=True):
        unit = units.get(d.output, "")
        lines += [f"  {line}" for line in _output(d, explained, f" {unit}" if unit else "", _beyond(block, d))]
    return lines


def _beyond(block: Any, d: Difference) -> list[str]:
    """Name the inputs that are outside of their range in a block at the point of a difference."""
    ranges = {v.name: block.range_of(v) for v in block.inputs if v.name in d.point}
    return [
        f"{name} is outside its range there, [{low:.6g}, {high:.6g}]"
        for name, (low, high) in ranges.items()
        if not low <= d.point[name] <= high
    ]


def _output(d: Difference, explained: Explanation | None, unit: str, beyond: Sequence[str] = ()) -> list[str]:
    if d.largest == 0.0 and d.gap is None:
        return [f"{d.output}: no difference"]
    lines = [f"{d.output}: no difference where both have a value"]
    # Where each point has one value only there is nothing to say but that.
    if d.largest > 0.0 and d.valued:
        at = _where(d.point, d.first, d.second, unit)
        lines = [f"{d.output}: largest difference {d.largest:.3g}{unit} at {at}", *_indented(beyond)]
        mean = [f"  on average {d.mean:.3g}"]
        if explained is None:
            lines += mean
        else:
            causes = ["  that is rounding"] if explained.rounding else _indented(_causes(explained.largest))
            # Causes of the mean stand below it where they are others.
            causes_of_mean = _indented(_indented(_causes(explained.mean))) if explained.mean else []
            lines += [*causes, *mean, *causes_of_mean] if causes_of_mean else [*mean, *causes]
    elif not d.valued:
        lines = [f"{d.output}: nowhere have both a value"]
    if d.gap is not None:
        at = _where(d.gap.point, d.gap.first, d.gap.second, unit)
        lines.append(f"  at {d.one_sided:,} of {d.points:,} points only one has a value, such as {at}")
        if explained is not None:
            settings = [_cause(c) for c in explained.gap] or ["several of what differs at once"]
            lines += [f"    gone with {setting}" for setting in settings]
    return lines


def _where(point: Mapping[str, float], first: float, second: float, unit: str) -> str:
    where = ", ".join(f"{name} = {value:.6g}" for name, value in point.items())
    return f"{where}: {first:.10g} and {second:.10g}{unit}"


def _indented(lines: Sequence[str]) -> list[str]:
    return [f"  {line}" for line in lines]


def _causes(causes: tuple[Cause, ...]) -> list[str]:
    """Return one line for each cause with a part worth naming, the largest first, and for the unexplained rest."""
    largest = sorted((c for c in causes if abs(c.explains) >= LEAST_SHARE), key=lambda c: -abs(c.explains))
    names = [_cause(c) for c in largest]
    parts = [c.explains for c in largest]
    rest = 1.0 - sum(c.explains for c in causes)
    if abs(rest) >= LEAST_SHARE:
        names, parts = [*names, "the rest: several of what differs at once"], [*parts, rest]
    width = max(map(len, names), default=0)
    return [f"{name:{width}}  explains {100 * part:.3g} %" for name, part in zip(names, parts, strict=True)]


def _cause(c: Cause) -> str:
    return f"{c.name}: {c.before} → {c.after}" if c.before or c.after else c.name
