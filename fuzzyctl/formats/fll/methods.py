"""Norms, activation methods and defuzzifiers of `.fll` files."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Final, Literal

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Number
from fuzzyctl.formats.common.translation import Translation
from fuzzyctl.formats.fll.lines import Line, words
from fuzzyctl.formats.fll.vocabulary import ACTIVATION_WORDS, OF_SETS, S_NORMS, T_NORMS, WEIGHTED
from fuzzyctl.formats.fuzzylite.weighted import INVERTED_THERE, KINDS, WeightedType, weighted_kinds
from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, DISJUNCTIONS
from fuzzyctl.model.method import Activation, Defuzzifier
from fuzzyctl.model.profiles import Profile
from fuzzyctl.model.variable import Term

_TYPES: Final[dict[str, WeightedType]] = {
    "Automatic": "Automatic",
    "TakagiSugeno": "TakagiSugeno",
    "Tsukamoto": "Tsukamoto",
}

_DEFUZZIFIERS: Final[dict[str, str | bool]] = {**OF_SETS, **WEIGHTED}

_COMPARISONS: Final = ("<", "<=", "==", "!=", ">=", ">")

#: Most numbers behind an activation method.
_PARAMETERS: Final = {"first": 2, "last": 2, "highest": 1, "lowest": 1, "threshold": 2}

#: Largest number of samples, and of rules that act.
_MOST: Final = 10**6


def is_none(line: Line | None) -> bool:
    """Whether a method is not given, or said to be none."""
    return line is None or line.value.text.lower() in ("", "none")


def norm(line: Line | None, translation: Translation, kind: Literal["and", "or", "aggregation"]) -> str | None:
    """Return a norm as the model calls it, None for none."""
    if line is None or is_none(line):
        return None
    here: Collection[str] = {"and": CONJUNCTIONS, "or": DISJUNCTIONS, "aggregation": AGGREGATIONS}[kind]
    table = {word: own for word, own in (T_NORMS if kind == "and" else S_NORMS).items() if own in here}
    otherwise = "a norm of your own is a program, which cannot be read here"
    return translation.look_up(line.value, table, f"{line.key} norm", otherwise=otherwise)


def activation(line: Line | None, translation: Translation) -> Activation:
    """Return an activation method."""
    if line is None or is_none(line):
        return Activation()
    name, *rest = words(line.value)
    kind = translation.look_up(name, ACTIVATION_WORDS, "activation method")
    most = _PARAMETERS.get(kind or "", 0)
    if kind is not None and len(rest) > most:
        message = f"'{name.text}' has at most {most} parameters"
        translation.error("FZ303", message, rest[most].to(rest[-1]))
    if kind is None or len(rest) > most:
        return Activation()
    last = translation.number(rest[1]) if len(rest) > 1 else Number(0.0)
    if kind != "threshold":
        count = (_count(rest[0], translation) if rest else 1) if most else None
        if most and count is None:
            return Activation()
        return Activation(kind=kind, count=count, threshold=last if most == 2 else None, span=line.value)
    comparison = rest[0].text if rest else ">"
    if comparison not in _COMPARISONS:
        message = f"'{comparison[:20]}' is no comparison"
        translation.error("FZ601", message, rest[0], help=f"one of {' '.join(_COMPARISONS)}")
        return Activation()
    return Activation(kind=kind, comparison=comparison, threshold=last, span=line.value)


def _count(span: Span, translation: Translation) -> int | None:
    value = translation.number(span)
    if value is None:
        return None
    if not (0 < value.value <= _MOST and value.value == int(value.value)):
        translation.error("FZ601", f"expected a whole number from 1 to {_MOST}, found '{span.text[:40]}'", span)
        return None
    return int(value.value)


def defuzzifier(
    line: Line | None, name: str, place: Span, terms: Sequence[Term], profile: Profile, translation: Translation
) -> Defuzzifier | None:
    """Return the defuzzifier of an output, None where there is none.

    Args:
        line: The line that names it.
        name: The output.
        place: Where that is declared.
        terms: Its terms, on which weighted ones depend.
        profile: The numerics of the file.
        translation: Where mistakes go.
    """
    if line is None or is_none(line):
        return None
    word, *rest = words(line.value)
    meaning = translation.look_up(word, _DEFUZZIFIERS, "defuzzifier")
    if isinstance(meaning, str):
        own = profile.defuzzifier(meaning)
        resolution = _count(rest[0], translation) if rest else None
        return own if resolution is None else own.model_copy(update={"resolution": resolution})
    if meaning is None:
        return None
    given = translation.look_up(rest[0], _TYPES, f"type of '{word.text}'") if rest else "Automatic"
    given = given or "Automatic"
    if given == "Tsukamoto":
        _require_inverted(word.text, terms, rest[0], translation)
    kind = weighted(terms, given, name, place, translation)
    return profile.defuzzifier(KINDS[kind][meaning])


def weighted(terms: Sequence[Term], given: WeightedType, name: str, place: Span, translation: Translation) -> str:
    """Return what fuzzylite's weighted defuzzifiers take of the terms of an output: a key of `KINDS`."""
    found = weighted_kinds((t.membership for t in terms), given) or {"function"}
    if len(found) > 1:
        message = f"the terms of '{name}' are of several sorts, which no average takes together"
        help_text = "take numbers and functions only, or sets only, all monotone or none"
        translation.error("FZ214", message, place, help=help_text)
    return min(found)


def _require_inverted(name: str, terms: Sequence[Term], place: Span, translation: Translation) -> None:
    """Refuse terms that fuzzylite cannot invert either: it stops at the first one that fires."""
    for term in terms:
        if term.membership.kind not in (*INVERTED_THERE, "constant", "linear", "function"):
            message = f"'{name} Tsukamoto' inverts terms, and fuzzylite cannot invert '{term.name}'"
            known = "Arc, Concave, Ramp, Sigmoid, SShape, ZShape"
            help_text = f"terms that it can invert: {known}; or write: {name} TakagiSugeno"
            translation.error("FZ214", message, term.span or place, help=help_text)
