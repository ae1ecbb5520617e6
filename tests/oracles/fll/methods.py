"""Norms, activation methods and defuzzifiers of `.fll` files."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Final, Literal, cast

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Number
from fuzzyctl.formats.common.report import Findings, meant
from fuzzyctl.formats.fll.methods import INVERTED_THERE, KINDS, WeightedType, weighted_kinds
from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, DISJUNCTIONS
from fuzzyctl.model.method import Activation, Defuzzifier
from fuzzyctl.model.profiles import Profile
from tests.oracles.fll.lines import Line
from tests.oracles.fll.terms import number, words
from tests.oracles.fll.variables import Variable
from tests.oracles.fll.vocabulary import ACTIVATION_WORDS, OF_SETS, S_NORMS, T_NORMS, WEIGHTED

_TYPES: Final = ("Automatic", "TakagiSugeno", "Tsukamoto")

_COMPARISONS: Final = ("<", "<=", "==", "!=", ">=", ">")


#: Largest number of samples, and of rules that act.
_MOST: Final = 10**6


def is_none(line: Line | None) -> bool:
    """Whether a method is not given, or said to be none."""
    return line is None or line.value.text.lower() in ("", "none")


def norm(line: Line | None, findings: Findings, *, kind: Literal["and", "or", "aggregation"]) -> str | None:
    """Return a norm as the model calls it, None for none."""
    if line is None or is_none(line):
        return None
    names = T_NORMS if kind == "and" else S_NORMS
    here: Collection[str] = {"and": CONJUNCTIONS, "or": DISJUNCTIONS, "aggregation": AGGREGATIONS}[kind]
    own = names.get(line.value.text)
    if own in here:
        return own
    _refuse(line.value, {n: o for n, o in names.items() if o in here}, f"{line.key} norm", findings)
    return None


def _refuse(place: Span, known: Mapping[str, object], what: str, findings: Findings) -> None:
    message = f"there is no {what} '{place.text[:40]}' here"
    if "function" in place.text.lower():
        help_text = "a norm of one's own is a program, which cannot be read here"
    else:
        help_text = meant(place.text, known)
    findings.error("FZ602", message, place, help=help_text, facts=(f"there are: {', '.join(known)}",))


def activation(line: Line | None, findings: Findings) -> Activation:
    """Return an activation method."""
    if line is None or is_none(line):
        return Activation()
    name, *rest = words(line.value)
    kind = ACTIVATION_WORDS.get(name.text)
    if kind is None:
        _refuse(name, ACTIVATION_WORDS, "activation method", findings)
        return Activation()
    made = _activation(kind, rest, name, findings)
    return made.model_copy(update={"span": line.value}) if made is not None else Activation()


def _activation(kind: str, rest: list[Span], name: Span, findings: Findings) -> Activation | None:
    most = {"first": 2, "last": 2, "highest": 1, "lowest": 1, "threshold": 2}.get(kind, 0)
    if len(rest) > most:
        message = f"'{name.text}' has at most {most} parameters"
        findings.error("FZ303", message, rest[most].to(rest[-1]))
        return None
    if kind == "threshold":
        comparison = rest[0].text if rest else ">"
        if comparison not in _COMPARISONS:
            message = f"'{comparison[:20]}' is not a comparison"
            findings.error("FZ601", message, rest[0], help=f"one of {' '.join(_COMPARISONS)}")
            return None
        bound = number(rest[1], findings) if len(rest) > 1 else Number(0.0)
        return Activation(kind=kind, comparison=comparison, threshold=bound)
    if most == 0:
        return Activation(kind=kind)
    count = _count(rest[0], findings) if rest else 1
    least = None
    if most == 2:
        least = number(rest[1], findings) if len(rest) > 1 else Number(0.0)
    return None if count is None else Activation(kind=kind, count=count, threshold=least)


def _count(span: Span, findings: Findings) -> int | None:
    value = number(span, findings)
    if value is None:
        return None
    if not (0 < value.value <= _MOST and value.value == int(value.value)):
        findings.error("FZ601", f"expected a whole number from 1 to {_MOST}, found '{span.text[:40]}'", span)
        return None
    return int(value.value)


def defuzzifier(line: Line | None, variable: Variable, profile: Profile, findings: Findings) -> Defuzzifier | None:
    """Return the defuzzifier of an output, None where there is none."""
    if line is None or is_none(line):
        return None
    name, *rest = words(line.value)
    if name.text in OF_SETS:
        own = profile.defuzzifier(OF_SETS[name.text])
        resolution = _count(rest[0], findings) if rest else None
        return own if resolution is None else own.model_copy(update={"resolution": resolution})
    if name.text in WEIGHTED:
        return profile.defuzzifier(_weighted(name.text, rest, variable, findings))
    _refuse(name, {**OF_SETS, **WEIGHTED}, "defuzzifier", findings)
    return None


def _weighted(name: str, rest: list[Span], variable: Variable, findings: Findings) -> str:
    given = rest[0].text if rest else "Automatic"
    if given not in _TYPES:
        findings.error("FZ602", f"'{name}' has no type '{given[:40]}'", rest[0], help=f"types: {', '.join(_TYPES)}")
        return "weighted_average"
    found = weighted_kinds((t.membership for t in variable.terms), cast(WeightedType, given)) or {"function"}
    if len(found) > 1:
        message = f"the terms of '{variable.name}' are of several sorts, which '{name}' cannot average"
        help_text = "take numbers and functions only, or sets only, all monotone or none"
        findings.error("FZ214", message, variable.span, help=help_text)
    if given == "Tsukamoto":
        _require_inverted(name, variable, rest[0], findings)
    return KINDS[min(found)][WEIGHTED[name]]


def _require_inverted(name: str, variable: Variable, place: Span, findings: Findings) -> None:
    """Refuse terms that fuzzylite cannot invert either: it stops at the first one that fires."""
    for term in variable.terms:
        if term.membership.kind not in (*INVERTED_THERE, "constant", "linear", "function"):
            message = f"'{name} Tsukamoto' inverts terms, and fuzzylite cannot invert '{term.name}'"
            known = "Arc, Concave, Ramp, Sigmoid, SShape, ZShape"
            help_text = f"terms that it can invert: {known}; or write: {name} TakagiSugeno"
            findings.error("FZ214", message, term.span or place, help=help_text)
