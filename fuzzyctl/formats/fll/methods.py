"""Methods of fuzzylite: its words for norms, activation methods and defuzzifiers, and the numerics of its versions.

A weighted defuzzifier depends on the terms of its output.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Final, Literal

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Number
from fuzzyctl.formats.common.numerics import defuzzifier_of
from fuzzyctl.formats.common.translation import Translation
from fuzzyctl.formats.fll.lines import Line, words
from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, DISJUNCTIONS, Parameters
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

#: Defuzzifiers that look at a set, by name.
OF_SETS: Final[dict[str, str]] = {
    "Centroid": "centroid",
    "Bisector": "bisector",
    "SmallestOfMaximum": "som",
    "LargestOfMaximum": "lom",
    "MeanOfMaximum": "mom",
}

#: Defuzzifiers that sum over rules: whether they do not divide.
WEIGHTED: Final[dict[str, bool]] = {"WeightedAverage": False, "WeightedSum": True}

ACTIVATION_WORDS: Final[dict[str, str]] = {
    "General": "general",
    "First": "first",
    "Last": "last",
    "Highest": "highest",
    "Lowest": "lowest",
    "Proportional": "proportional",
    "Threshold": "threshold",
}

#: Words of rules that no variable and no term may be called, besides those that are none in rule files either.
RULE_WORDS: Final = frozenset({"if", "with"})


#: Hedges, which have the same names here.
HEDGE_WORDS: Final = ("any", "extremely", "not", "seldom", "somewhat", "very")


# --- norms, activation methods and defuzzifiers --------------------------------------------------------------------

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


# --- weighted defuzzifiers -----------------------------------------------------------------------------------------

WeightedType = Literal["Automatic", "TakagiSugeno", "Tsukamoto"]

#: Consequents that are functions of the inputs.
_FUNCTIONS: Final = ("constant", "linear", "function")

#: The terms that fuzzylite inverts; any other is never monotone to it, even a triangle with an infinite foot.
INVERTED_THERE: Final = frozenset({"arc", "concave", "ramp", "s_shape", "sigmoid", "z_shape"})

#: The defuzzifiers here for an average and for a sum, by what is taken of each rule.
KINDS: Final[dict[str, tuple[str, str]]] = {
    "function": ("weighted_average", "weighted_sum"),
    "inverse": ("tsukamoto", "tsukamoto_sum"),
    "degree": ("inverse_tsukamoto", "inverse_tsukamoto_sum"),
}


def weighted_kinds(memberships: Iterable[Membership], given: WeightedType) -> set[str]:
    """Return the keys of `KINDS` that some terms stand for; more than one for a mix, which nothing defuzzifies."""
    return {_taken(m, given) for m in memberships}


def _taken(membership: Membership, given: WeightedType) -> str:
    if membership.kind in _FUNCTIONS:
        return "function"
    if given == "TakagiSugeno":
        return "degree"
    if given == "Tsukamoto":
        return "inverse"
    return "inverse" if membership.kind in INVERTED_THERE else "degree"


def as_inverted_there(system: FuzzySystem) -> tuple[FuzzySystem, list[str]]:
    """Return a system whose terms of Tsukamoto's method are of kinds that fuzzylite inverts, as far as there are any.

    Returns:
        The system, and a reason for each term that no such kind is the same as.
    """
    reasons: list[str] = []
    outputs = tuple(_output_inverted_there(system, o, reasons) for o in system.outputs)
    return system.model_copy(update={"outputs": outputs}), reasons


def _output_inverted_there(system: FuzzySystem, output: Output, reasons: list[str]) -> Output:
    if defuzzifier_of(system, output).kind not in ("tsukamoto", "tsukamoto_sum"):
        return output
    terms = []
    for term in output.terms:
        own = term.membership
        found = _inverted_there(own.kind, tuple(system.number(a) for a in own.arguments))
        if found is None:
            known = ", ".join(sorted(INVERTED_THERE))
            what = f"term '{term.name}' of '{output.name}' is of the kind '{own.kind}'"
            reasons.append(f"{what}, which fuzzylite cannot invert as it can {known}")
        elif found[0] != own.kind:
            own = own.model_copy(update={"kind": found[0], "arguments": tuple(map(Number, found[1]))})
        terms.append(term.model_copy(update={"membership": own}))
    return output.model_copy(update={"terms": tuple(terms)})


def _inverted_there(kind: str, p: Parameters) -> tuple[str, Parameters] | None:
    """Return the same function as a kind that fuzzylite inverts: sides that rise or fall once are ramps there."""
    if kind in INVERTED_THERE:
        return kind, p
    if kind == "piecewise" and len(p) == 4 and {p[1], p[3]} == {0.0, 1.0} and p[0] != p[2]:
        return "ramp", (p[0], p[2]) if p[1] == 0.0 else (p[2], p[0])
    if kind not in ("triangle", "trapezoid", "pi_shape"):
        return None
    left, left_top, right_top, right = p if len(p) == 4 else (p[0], p[1], p[1], p[2])
    if right == math.inf and -math.inf < left < left_top:
        return ("s_shape" if kind == "pi_shape" else "ramp"), (left, left_top)
    if left == -math.inf and right_top < right < math.inf:
        return ("z_shape", (right_top, right)) if kind == "pi_shape" else ("ramp", (right, right_top))
    return None


def inferred_otherwise(system: FuzzySystem) -> list[str]:
    """Return a reason for each output whose terms alone would tell fuzzylite another method than it has."""
    reasons = []
    for output in system.outputs:
        kind = defuzzifier_of(system, output).kind
        found = weighted_kinds((t.membership for t in output.terms), "Automatic")
        if kind in TSUKAMOTO and not any(kind in KINDS[f] for f in found if len(found) == 1):
            what = "inverts its terms" if found == {"inverse"} else "inverts some of its terms only"
            reasons.append(f"output '{output.name}' has the defuzzifier '{kind}', but fuzzylite {what}")
    return reasons


# --- versions ------------------------------------------------------------------------------------------------------

_GENERATED: Final = re.compile(r"generated (?:with|by) fuzzylite (\d{1,3})\b", re.IGNORECASE)

#: Samples of versions before 6, where a file says no number.
_SAMPLES_BEFORE_6: Final = 200


def version_said(comments: Iterable[str]) -> int | None:
    """Return the major version of fuzzylite that a comment names."""
    found = (_GENERATED.search(c) for c in comments)
    return next((int(match.group(1)) for match in found if match is not None), None)


def profile_of_version(version: int | None) -> Profile:
    """Return the numerics of a version of fuzzylite; those of the newest where none is known."""
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
