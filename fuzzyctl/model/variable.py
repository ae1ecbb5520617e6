"""Linguistic variables: inputs, outputs and their terms."""

from __future__ import annotations

import math
from typing import Final, Literal

from fuzzyctl.expr import ONE, Expr, Number, names_in
from fuzzyctl.model.block import Node
from fuzzyctl.model.method import Defuzzifier
from fuzzyctl.records import dataclass

#: Words for an output without a firing rule, besides a value and the previous output: the middle of the range, NaN, an
#: error. A word of a separate type, so that `nan` is never a float in the model.
Fallback = Literal["midpoint", "nan", "error"]


@dataclass(frozen=True, kw_only=True)
class Hold(Node):
    """Where no rule fires an output keeps its previous value.

    Args:
        start: Its value before any rule has fired; None for the middle of the range.
    """

    start: Expr | Literal["nan"] | None = None


@dataclass(frozen=True, kw_only=True, repr=False)
class Membership(Node):
    """A kind of membership function, or of Takagi-Sugeno consequent, with its parameters.

    Args:
        kind: A key of `formulas.MEMBERSHIP`; for terms of outputs also `linear`, whose parameters are a coefficient for
            each input and a constant; `function` has one parameter, an expression over the variable itself in a term
            of an input, over the inputs in a term of an output; `formula`, written as `function` too, is a fuzzy set of
            an output: an expression over the output itself.
        arguments: In the order of `formulas.MEMBERSHIP[kind].parameters`.
        height: The largest degree, which multiplies the function; in (0, 1].
    """

    kind: str
    arguments: tuple[Expr, ...]
    height: Expr = ONE


def as_set(output: str, membership: Membership) -> Membership:
    """Return a term of an output, as a fuzzy set if it is a function that names the output itself."""
    if membership.kind != "function" or output not in {n.name for n in names_in(membership.arguments[0])}:
        return membership
    return membership.model_copy(update={"kind": "formula"})


@dataclass(frozen=True, kw_only=True, repr=False)
class Term(Node):
    """A named fuzzy set of a linguistic variable."""

    name: str
    membership: Membership


@dataclass(frozen=True, kw_only=True, repr=False)
class LinguisticVariable(Node):
    """Base of inputs and outputs: a name, a label for plots, a unit, a universe of discourse and terms."""

    name: str
    label: str = ""
    unit: str = ""
    lower: Expr
    upper: Expr
    terms: tuple[Term, ...]

    @property
    def title(self) -> str:
        """The label, or the name without one."""
        return self.label or self.name

    @property
    def axis_label(self) -> str:
        """The text at the axis of a plot: label and unit."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title

    def term(self, name: str) -> Term | None:
        """Return the term of that name, or None."""
        return next((t for t in self.terms if t.name == name), None)


@dataclass(frozen=True, kw_only=True, repr=False)
class Input(LinguisticVariable):
    """An input. Values outside the range are clamped to it, or go through the formulas where it says `extrapolate`."""

    extrapolate: bool = False


@dataclass(frozen=True, kw_only=True, repr=False)
class Output(LinguisticVariable):
    """An output.

    Args:
        otherwise: Its value if no rule fires; None promises that some rule always fires.
        adaptive: For adaptive consequents the rate dC_k/dt divided by ξ_k, an expression over params and inputs;
            None for fixed ones. The terms then give the initial consequents and the range bounds them.
        clamped: Whether its value is held within its range, as a sum of functions of the inputs may leave it.
        implication: Its own implication, None for the system's.
        aggregation: Its own aggregation, None for the system's.
        defuzzifier: Its own defuzzifier, None for the system's.
        value: An expression over params, inputs, lets and other outputs that it is, in place of rules; None for rules.
    """

    otherwise: Expr | Fallback | Hold | None = None
    adaptive: Expr | None = None
    clamped: bool = False
    implication: str | None = None
    aggregation: str | None = None
    defuzzifier: Defuzzifier | None = None
    value: Expr | None = None


@dataclass(frozen=True, kw_only=True, repr=False)
class Let(LinguisticVariable):
    """A name for the value of an expression over params, inputs and other lets.

    Antecedents read its terms within its range, `ANYWHERE` for one without; expressions read its value.
    """

    value: Expr


#: Ends of the range of a let that has none.
ANYWHERE: Final = (Number(-math.inf), Number(math.inf))
