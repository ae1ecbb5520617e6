"""Resolution of defuzzifier options, such as `bisector(resolution=101, grid=endpoints, rule=first)`."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Final

from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.method import DEFUZZIFIERS, Defuzzifier
from fuzzyctl.resolve.context import Context

#: Bounds of the number of samples of a set.
RESOLUTIONS: Final = (2, 1_000_000)


def resolve_options(context: Context, kind: str, options: Iterable[sx.Option]) -> Defuzzifier:
    """Return a defuzzifier with its options, each given at most once; report what has no meaning."""
    known = DEFUZZIFIERS[kind].options
    given: dict[str, sx.Option] = {}
    fields: dict[str, Any] = {}
    for option in options:
        name = option.name.text
        if not known:
            context.report("FZ213", f"'{kind}' takes no options", option.name.span, help="remove it")
        elif name not in known:
            context.unknown("option", option.name, tuple(known), "FZ213")
        else:
            given[name] = option
            value = _value(context, option, known[name])
            if value is not None:
                fields[name] = value
    _require_samples(context, kind, given)
    return Defuzzifier(kind=kind, **fields)


def _value(context: Context, option: sx.Option, words: tuple[str, ...]) -> str | int | float | None:
    """Return the value of an option, None where it has been reported."""
    text, span = option.value.text, option.value.span
    match option.name.text:
        case "resolution":
            low, high = (1, RESOLUTIONS[1]) if context.foreign else RESOLUTIONS
            if text.isdecimal() and low <= int(text) <= high:
                return int(text)
            context.report("FZ302", f"resolution = {text} is no whole number from {low} to {high}", span)
        case "tolerance":
            value = _number(text)
            if 0.0 <= value < 1.0:
                return value
            message = f"tolerance = {text} is no number from 0 up to 1"
            context.report("FZ302", message, span, help="it is a part of the largest degree, such as 1e-9")
        case name if text not in words:
            context.report("FZ213", f"no {name} '{text}'", span, facts=(f"one of: {', '.join(words)}",))
        case _:
            return text
    return None


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _require_samples(context: Context, kind: str, given: dict[str, sx.Option]) -> None:
    for name in ("grid", "rule"):
        if name in given and "resolution" not in given and given[name].value.text != "polygon":
            what = "has no grid" if name == "grid" else "needs no rule"
            example = f"{kind}(resolution=1000, {name}={given[name].value.text})"
            message = f"'{name}' needs 'resolution': the exact {kind} {what}"
            context.report("FZ214", message, given[name].name.span, help=f"write, for example, {example}")
