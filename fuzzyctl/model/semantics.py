"""Semantics as data: how a tool computes outputs from firing strengths.

Two tools that read the same model print different numbers because they differ in such details. Each detail is a knob
here; a profile is the set of knobs of one tool.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

from fuzzyctl.model.node import Node


@dataclass(frozen=True, kw_only=True)
class Semantics(Node):
    """The knobs of inference that no norm, activation method or defuzzifier names; the defaults are `exact`.

    Args:
        profile: Name of the profile the knobs came from.
        weight: Whether a rule's weight multiplies its firing strength before implication, or the implied set after it.
        merge: What a sum over rules runs over: `rules`; `terms`, where rules of one consequent term are first joined by
            the aggregation; or `places`, the same for consequents at one place.
        total: What an average divides by: the `activations` of the rules summed over; their firing `strengths`, weights
            left out; or the activations of `all_rules`, those included that do not name the output.
        least: A rule acts only if its activation is above it; None for rules that always act. A rule of activation 0
            that acts has an effect only if a hedge in its consequent makes something of it.
        equal: Degrees that differ by less count as equal where a drastic, nilpotent or Hamacher norm asks for equality.
        chained: An output in an antecedent counts with its crisp `value`, or with the `degree` up to which its term has
            been activated by the rules before.
        consequent_hedges: A hedge in a consequent changes the `set`; the `activation`; or the activation of this and of
            all later consequents of the rule, `carried`. `undone` changes the set too, but where an output sums over
            rules the activation, by the inverse of the hedge.
        extremely: What that hedge is: `contrast`, 2x² up to ½ and 1 - 2(1 - x)² above; or `cube`, x³.
        sigmoid_difference: What the difference of two sigmoids is where it is negative: its `magnitude`, or 0,
            `clamped`.
        places: Places that `tsukamoto` finds are `clamped` to the range of the output, or `free`.
        none_active: What the maxima of a set are that is 0 everywhere: none, so that the output is what it is where no
            rule fires, `otherwise`; or all of the `range`.
        fallback: Where an output is what its `else` says: where it is `unfired`; or wherever it has no value,
            `undefined`, such as where a function in a consequent has none.
    """

    profile: str = "exact"
    weight: Literal["before", "after"] = "before"
    merge: Literal["rules", "terms", "places"] = "rules"
    total: Literal["activations", "strengths", "all_rules"] = "activations"
    least: float | None = 0.0
    equal: float = 0.0
    chained: Literal["value", "degree"] = "value"
    consequent_hedges: Literal["set", "activation", "carried", "undone"] = "set"
    extremely: Literal["contrast", "cube"] = "contrast"
    sigmoid_difference: Literal["magnitude", "clamped"] = "magnitude"
    places: Literal["clamped", "free"] = "clamped"
    none_active: Literal["otherwise", "range"] = "otherwise"
    fallback: Literal["unfired", "undefined"] = "unfired"

    @property
    def joins_rules(self) -> bool:
        """Whether the aggregation matters to sums over rules, and to what reads how far a term has been activated."""
        return self.merge != "rules" or self.chained == "degree"

    def text(self, knob: str) -> str:
        """Return the value of a knob as rule files write it."""
        value = getattr(self, knob)
        return "none" if value is None else value if isinstance(value, str) else repr(float(value))


#: Names of the knobs.
KNOBS = tuple(f.name for f in fields(Semantics) if f.name not in ("span", "profile"))
