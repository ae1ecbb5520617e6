"""Methods of fuzzylite: its words for norms, activation methods and defuzzifiers, and the numerics of its versions.

A weighted defuzzifier depends on the terms of its output.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Final, Literal, get_args

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Number
from fuzzyctl.formats.common.losses import defuzzifier_of
from fuzzyctl.formats.common.translation import Translation
from fuzzyctl.formats.common.words import one_sided
from fuzzyctl.formats.fll.lines import Line, words
from fuzzyctl.formulas import DISJUNCTIONS, Parameters
from fuzzyctl.model.method import TSUKAMOTO, Activation, Defuzzifier
from fuzzyctl.model.profiles import PROFILES, Profile
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Membership, Output, Term

T_NORMS: Final[dict[str, str]] = {
    "Minimum": "min",
    "AlgebraicProduct": "product",
    "BoundedDifference": "bounded_difference",
    "DrasticProduct": "drastic_product",
    "EinsteinProduct": "einstein_product",
    "HamacherProduct": "hamacher_product",
    "NilpotentMinimum": "nilpotent_minimum",
}

S_NORMS: Final[dict[str, str]] = {
    "Maximum": "max",
    "AlgebraicSum": "probabilistic_sum",
    "BoundedSum": "bounded_sum",
    "NormalizedSum": "bounded_sum",  # (a + b) / max(1, a + b) is min(1, a + b)
    "DrasticSum": "drastic_sum",
    "EinsteinSum": "einstein_sum",
    "HamacherSum": "hamacher_sum",
    "NilpotentMaximum": "nilpotent_maximum",
    "UnboundedSum": "sum",
}

#: Defuzzifiers of a set, by name.
OF_SETS: Final[dict[str, str]] = {
    "Centroid": "centroid",
    "Bisector": "bisector",
    "SmallestOfMaximum": "som",
    "LargestOfMaximum": "lom",
    "MeanOfMaximum": "mom",
}

#: Defuzzifiers over rules, by name: whether they are sums.
WEIGHTED: Final[dict[str, bool]] = {"WeightedAverage": False, "WeightedSum": True}

#: Types of weighted defuzzifiers.
WeightedType = Literal["Automatic", "TakagiSugeno", "Tsukamoto"]

#: The quantities of each rule in a weighted defuzzifier, with the average and the sum of the model.
KINDS: Final[dict[str, tuple[str, str]]] = {
    "function": ("weighted_average", "weighted_sum"),
    "inverse": ("tsukamoto", "tsukamoto_sum"),
    "degree": ("inverse_tsukamoto", "inverse_tsukamoto_sum"),
}

#: All defuzzifiers by the kind of the model, as files have them.
DEFUZZIFIERS: Final[dict[str, str]] = {
    **{kind: word for word, kind in OF_SETS.items()},
    **{
        KINDS[quantity][is_sum]: f"{word} {'Tsukamoto' if quantity == 'inverse' else 'TakagiSugeno'}"
        for word, is_sum in WEIGHTED.items()
        for quantity in KINDS
    },
    "center_average": "WeightedAverage TakagiSugeno",
}

ACTIVATION_WORDS: Final[dict[str, str]] = {
    "General": "general",
    "First": "first",
    "Last": "last",
    "Highest": "highest",
    "Lowest": "lowest",
    "Proportional": "proportional",
    "Threshold": "threshold",
}

#: Words of rules that are not names of variables and terms, besides those of rule files.
RULE_WORDS: Final = frozenset({"if", "with"})

#: Hedges, which have the same names here.
HEDGE_WORDS: Final = ("any", "extremely", "not", "seldom", "somewhat", "very")


# --- norms, activation methods and defuzzifiers --------------------------------------------------------------------

_TYPES: Final[dict[str, WeightedType]] = {name: name for name in get_args(WeightedType)}

_MEANINGS: Final[dict[str, str | bool]] = {**OF_SETS, **WEIGHTED}

_NORMS: Final = {
    "and": T_NORMS,
    "or": {word: norm for word, norm in S_NORMS.items() if norm in DISJUNCTIONS},
    "aggregation": S_NORMS,
}

_COMPARISONS: Final = ("<", "<=", "==", "!=", ">=", ">")

#: Most numbers behind an activation method.
_PARAMETERS: Final = {"first": 2, "last": 2, "highest": 1, "lowest": 1, "threshold": 2}

#: Largest number of samples, and of rules that act.
_MOST: Final = 10**6


def is_none(line: Line | None) -> bool:
    """Return whether a method is missing or `none`."""
    return line is None or line.value.text.lower() in ("", "none")


def norm(line: Line | None, translation: Translation, kind: Literal["and", "or", "aggregation"]) -> str | None:
    """Return the name of a norm in the model, or None."""
    if line is None or is_none(line):
        return None
    otherwise = "a norm of your own is a program, which cannot be read here"
    return translation.look_up(line.value, _NORMS[kind], f"{line.key} norm", otherwise=otherwise)


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
    if comparison in _COMPARISONS:
        return Activation(kind=kind, comparison=comparison, threshold=last, span=line.value)
    message = f"'{comparison[:20]}' is not a comparison"
    translation.error("FZ601", message, rest[0], help=f"one of {' '.join(_COMPARISONS)}")
    return Activation()


def _count(span: Span, translation: Translation) -> int | None:
    number = translation.number(span)
    if number is not None and 0 < number.value <= _MOST and number.value == int(number.value):
        return int(number.value)
    if number is not None:
        translation.error("FZ601", f"expected a whole number from 1 to {_MOST}, found '{span.text[:40]}'", span)
    return None


def defuzzifier(
    line: Line | None, name: str, place: Span, terms: Sequence[Term], profile: Profile, translation: Translation
) -> Defuzzifier | None:
    """Return the defuzzifier of an output, or None.

    Args:
        line: The line that names it.
        name: The output.
        place: The place of its declaration.
        terms: Its terms, on which weighted defuzzifiers depend.
        profile: The numerics of the file.
        translation: Takes mistakes.
    """
    if line is None or is_none(line):
        return None
    word, *rest = words(line.value)
    meaning = translation.look_up(word, _MEANINGS, "defuzzifier")
    if meaning is None:
        return None
    if isinstance(meaning, str):
        usual = profile.defuzzifier(meaning)
        resolution = _count(rest[0], translation) if rest else None
        return usual if resolution is None else usual.model_copy(update={"resolution": resolution})
    type = translation.look_up(rest[0], _TYPES, f"type of '{word.text}'") if rest else None
    if type == "Tsukamoto":
        _require_inverted(word.text, terms, rest[0], translation)
    kind = weighted(terms, type or "Automatic", name, place, translation)
    return profile.defuzzifier(KINDS[kind][meaning])


def weighted(terms: Sequence[Term], type: WeightedType, name: str, place: Span, translation: Translation) -> str:
    """Return the quantity of each rule in a weighted defuzzifier, a key of `KINDS`; report a mix of terms."""
    kinds = weighted_kinds((t.membership for t in terms), type) or {"function"}
    if len(kinds) > 1:
        message = f"the terms of '{name}' are of several sorts, which no average takes together"
        help_text = "take numbers and functions only, or sets only, all monotone or none"
        translation.error("FZ214", message, place, help=help_text)
    return min(kinds)


def _require_inverted(name: str, terms: Sequence[Term], place: Span, translation: Translation) -> None:
    """Refuse terms that fuzzylite cannot invert either: it stops at the first one that fires."""
    for term in terms:
        if term.membership.kind not in (*INVERTED_THERE, *_FUNCTIONS):
            message = f"'{name} Tsukamoto' inverts terms, and fuzzylite cannot invert '{term.name}'"
            kinds = "Arc, Concave, Ramp, Sigmoid, SShape, ZShape"
            help_text = f"terms that it can invert: {kinds}; or write: {name} TakagiSugeno"
            translation.error("FZ214", message, term.span or place, help=help_text)


# --- weighted defuzzifiers -----------------------------------------------------------------------------------------

#: Consequents that are functions of the inputs.
_FUNCTIONS: Final = ("constant", "linear", "function")

#: The terms that fuzzylite inverts; any other is never monotone to it, even a triangle with an infinite foot.
INVERTED_THERE: Final = frozenset({"arc", "concave", "ramp", "s_shape", "sigmoid", "z_shape"})


def weighted_kinds(memberships: Iterable[Membership], type: WeightedType) -> set[str]:
    """Return the keys of `KINDS` of some terms; several for a mix, which no defuzzifier takes."""

    def quantity(kind: str) -> str:
        if kind in _FUNCTIONS:
            return "function"
        return "inverse" if type == "Tsukamoto" or (type == "Automatic" and kind in INVERTED_THERE) else "degree"

    return {quantity(m.kind) for m in memberships}


def as_inverted_there(system: FuzzySystem) -> tuple[FuzzySystem, list[str]]:
    """Return a system whose terms of Tsukamoto's method are of kinds that fuzzylite inverts.

    Returns:
        The system, and a reason for each term that no such kind is the same as.
    """
    reasons: list[str] = []

    def replacement(output: Output, term: Term) -> Term:
        membership = term.membership
        shape = _inverted_there(membership.kind, tuple(system.number(a) for a in membership.arguments))
        if shape is None:
            kinds = ", ".join(sorted(INVERTED_THERE))
            subject = f"term '{term.name}' of '{output.name}' is of the kind '{membership.kind}'"
            reasons.append(f"{subject}, which fuzzylite cannot invert as it can {kinds}")
        if shape is None or shape[0] == membership.kind:
            return term
        update = {"kind": shape[0], "arguments": tuple(map(Number, shape[1]))}
        return term.model_copy(update={"membership": membership.model_copy(update=update)})

    outputs = tuple(
        output.model_copy(update={"terms": tuple(replacement(output, t) for t in output.terms)})
        if defuzzifier_of(system, output).kind in KINDS["inverse"]
        else output
        for output in system.outputs
    )
    return system.model_copy(update={"outputs": outputs}), reasons


def _inverted_there(kind: str, p: Parameters) -> tuple[str, Parameters] | None:
    """Return the same function as a kind that fuzzylite inverts: sides that rise or fall once are ramps there."""
    if kind == "piecewise" and len(p) == 4 and {p[1], p[3]} == {0.0, 1.0} and p[0] != p[2]:
        return "ramp", (p[0], p[2]) if p[1] == 0.0 else (p[2], p[0])
    kind, p = one_sided(kind, p)
    return (kind, p) if kind in INVERTED_THERE else None


def inferred_otherwise(system: FuzzySystem) -> list[str]:
    """Return a reason for each output for whose terms fuzzylite would choose another method."""
    reasons = []
    for output in system.outputs:
        kind = defuzzifier_of(system, output).kind
        quantities = weighted_kinds((t.membership for t in output.terms), "Automatic")
        if kind in TSUKAMOTO and not (len(quantities) == 1 and kind in KINDS[min(quantities)]):
            action = "inverts its terms" if quantities == {"inverse"} else "inverts some of its terms only"
            reasons.append(f"output '{output.name}' has the defuzzifier '{kind}', but fuzzylite {action}")
    return reasons


# --- versions ------------------------------------------------------------------------------------------------------

_GENERATED: Final = re.compile(r"generated (?:with|by) fuzzylite (\d{1,3})\b", re.IGNORECASE)

#: Samples of versions before 6, if a file gives no number.
_SAMPLES_BEFORE_6: Final = 200


def version_said(comments: Iterable[str]) -> int | None:
    """Return the major version of fuzzylite that a comment names."""
    matches = map(_GENERATED.search, comments)
    return next((int(match.group(1)) for match in matches if match is not None), None)


def profile_of_version(version: int | None) -> Profile:
    """Return the numerics of a version of fuzzylite; those of the newest if it is unknown."""
    if version is None or version > 6:
        return PROFILES["fuzzylite"]
    six = PROFILES["fuzzylite_6"]
    if version == 6:
        return six
    older = {
        kind: d.model_copy(update={"resolution": _SAMPLES_BEFORE_6}) if d.resolution is not None else d
        for kind, d in six.defuzzifiers.items()
    }
    return replace(six, defuzzifiers=MappingProxyType(older))
