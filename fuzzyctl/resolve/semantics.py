"""Resolution of the statement `semantics`: a profile, and options that differ from it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final, get_args, get_type_hints

from fuzzyctl.diagnostics.fixes import respelt
from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.lang import syntax as sx
from fuzzyctl.model.method import KNOBS, Semantics
from fuzzyctl.model.profiles import PROFILES
from fuzzyctl.resolve.context import Context

_TYPES: Final = get_type_hints(Semantics)
#: What each knob may be; none for a number.
CHOICES: Final[dict[str, tuple[str, ...]]] = {
    name: tuple(word for word in get_args(_TYPES[name]) if isinstance(word, str)) for name in KNOBS
}

#: Knobs that are numbers.
NUMBERS: Final = tuple(name for name, words in CHOICES.items() if not words)


def resolve_semantics(context: Context, statements: Sequence[sx.Statement]) -> Semantics:
    """Resolve the semantics of a system, and enter the profile in force into the context."""
    found = [s for s in statements if isinstance(s, sx.Semantics)]
    if not found:
        return context.profile.semantics
    first, *rest = found
    for again in rest:
        context.is_first(again.keyword, {"semantics": first.keyword})
    if first.profile.text not in PROFILES:
        context.unknown("profile", first.profile, PROFILES, "FZ213")
    else:
        context.profile = PROFILES[first.profile.text]
    semantics = context.profile.semantics
    return replace(semantics, **_knobs(context, first.options), span=first.profile.span)


def _knobs(context: Context, options: Sequence[sx.Option]) -> dict[str, Any]:
    """Resolve the knobs that are given."""
    values: dict[str, Any] = {}
    seen: dict[str, sx.Word] = {}
    for option in options:
        name, word = option.name.text, option.value
        if not context.is_first(option.name, seen):
            continue
        if name not in KNOBS:
            context.unknown("knob", option.name, KNOBS, "FZ213")
        elif name in NUMBERS:
            _number(context, name, word, values)
        elif word.text not in CHOICES[name]:
            near = closest(word.text, CHOICES[name])
            facts = (f"one of: {', '.join(CHOICES[name])}",)
            help_text = f"did you mean '{near}'?" if near else ""
            fix = respelt(word.span, word.text, near, CHOICES[name])
            context.report("FZ213", f"'{name}' knows no '{word.text}'", word.span, facts=facts, help=help_text, fix=fix)
        else:
            values[name] = word.text
    return values


def _number(context: Context, name: str, word: sx.Word, values: dict[str, Any]) -> None:
    """Resolve a knob that is a number; `least` may be `none` as well."""
    if name == "least" and word.text == "none":
        values[name] = None
        return
    try:
        value = float(word.text)
    except ValueError:
        value = math.nan
    if not 0.0 <= value < 1.0 or word.text[0] not in "0123456789.":
        bound = "no number from 0 to below 1" + (", and not 'none'" if name == "least" else "")
        context.report("FZ302", f"{name} = {word.text} is {bound}", word.span)
    else:
        values[name] = value
