"""Method of fuzzylite's weighted defuzzifiers, which depends on the terms of the output."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final, Literal

from fuzzyctl.expr import Number
from fuzzyctl.formats.common.numerics import defuzzifier_of
from fuzzyctl.formulas import Parameters
from fuzzyctl.model.method import TSUKAMOTO
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Membership, Output

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
