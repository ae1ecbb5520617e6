"""Inputs, outputs and lets with their terms, from Python calls."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, Literal

from fuzzyctl.building import fragments, values
from fuzzyctl.building.values import Partition, TermSpec, Value, defuzzifier_of
from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.expr import Expr
from fuzzyctl.formulas import MembershipKind
from fuzzyctl.formulas.norms import Aggregation, Conjunction
from fuzzyctl.model import variable
from fuzzyctl.model.method import Defuzzifier
from fuzzyctl.model.variable import Fallback, Input, Let, Membership, Output, Term, as_set
from fuzzyctl.support import arguments

_TERMS: Final = "terms by name or a partition"


def Hold(start: Value | None = None) -> variable.Hold:  # noqa: N802 - it reads as what it makes
    """Return what `otherwise` takes where an output keeps its previous value, as `else hold(START)` does in a file.

    Args:
        start: The value before any rule has fired; None for the middle of the range.
    """
    return variable.Hold(start=None if start is None else values.expression("'start'", start))


def membership(
    kind: MembershipKind | Literal["linear", "function"], *parameters: Value, height: Value = 1
) -> Membership:
    """Return a membership function, such as `membership("triangle", -inf, 0, 1)`.

    Args:
        kind: Its name, as a file writes it.
        parameters: In the order of the file.
        height: Largest degree.
    """
    numbers = tuple(values.expression("a parameter", p) for p in parameters)
    return Membership(
        kind=arguments.text("'kind'", kind), arguments=numbers, height=values.expression("'height'", height)
    )


def input_variable(
    name: str,
    lower: Value,
    upper: Value,
    terms: Mapping[str, TermSpec] | Partition,
    *,
    label: str = "",
    unit: str = "",
    extrapolate: bool = False,
) -> Input:
    """Return an input.

    Args:
        name: An identifier.
        lower: Lower end of the range.
        upper: Upper end of the range.
        terms: Terms by name, or a `partition`.
        label: The label in plots.
        unit: Its unit.
        extrapolate: Whether values outside the range go through the formulas instead of being clamped.
    """
    fields = _variable(name, lower, upper, terms, label, unit)
    return Input(**fields, extrapolate=arguments.flag("'extrapolate'", extrapolate))


def output_variable(
    name: str,
    lower: Value,
    upper: Value,
    terms: Mapping[str, TermSpec] | Partition,
    *,
    label: str = "",
    unit: str = "",
    otherwise: Value | Fallback | Literal["hold"] | variable.Hold | None = None,
    adaptive: Value | None = None,
    clamp: bool = False,
    implication: Conjunction | None = None,
    aggregation: Aggregation | None = None,
    defuzzifier: str | Defuzzifier | None = None,
    value: Value | None = None,
) -> Output:
    """Return an output; the arguments are those of `input_variable`.

    Args:
        name: An identifier.
        lower: Lower end of the range.
        upper: Upper end of the range.
        terms: Terms by name, or a `partition`.
        label: The label in plots.
        unit: Its unit.
        otherwise: The value if no rule fires: a value, "midpoint", "nan", "error", "hold", "hold(0.5)"
            or `Hold(0.5)`.
        adaptive: The rate of adaptive consequents.
        clamp: Whether its value is held within its range.
        implication: Its own implication, None for the system's.
        aggregation: Its own aggregation, None for the system's.
        defuzzifier: Its own defuzzifier, None for the system's.
        value: The expression that it is, in place of rules; None for an output that rules set.
    """
    fields = _variable(name, lower, upper, terms, label, unit, is_output=True)
    method = None if defuzzifier is None else defuzzifier_of(defuzzifier)
    norms = {"implication": implication, "aggregation": aggregation}
    fields |= {"defuzzifier": method, "clamped": arguments.flag("'clamp'", clamp)} | values.texts(
        **{n: v for n, v in norms.items() if v is not None}
    )
    if otherwise is not None:
        fields["otherwise"] = _otherwise(otherwise)
    if adaptive is not None:
        fields["adaptive"] = values.expression("'adaptive'", adaptive)
    if value is not None:
        fields["value"] = values.expression("'value'", value)
    return Output(**fields)


def let_variable(
    name: str,
    value: Value,
    lower: Value | None = None,
    upper: Value | None = None,
    terms: Mapping[str, TermSpec] | Partition | None = None,
    *,
    label: str = "",
    unit: str = "",
) -> Let:
    """Return a let, a named value of the inputs.

    Args:
        name: An identifier.
        value: An expression over params, inputs and other lets.
        lower: Lower end of the range; None for no range.
        upper: Upper end of the range; None for no range.
        terms: Terms by name, or a `partition`; they need a range.
        label: The label in plots.
        unit: Its unit.

    Raises:
        ArgumentError: For one end of a range without the other, and for terms without a range.
    """
    if (lower is None) != (upper is None) or (lower is None and terms):
        raise ArgumentError("a let takes both ends of a range or none, and its terms need them")
    fields = _variable(name, lower or 0, upper or 0, {} if terms is None else terms, label, unit)
    if lower is None:
        fields["lower"], fields["upper"] = variable.ANYWHERE
    return Let(**fields, value=values.expression("'value'", value))


def _otherwise(value: object) -> Expr | variable.Hold | str:
    """Return the value after `else` in a file; expressions may go without their parentheses."""
    if isinstance(value, variable.Hold):
        return value
    if isinstance(value, str) and value.strip() in ("midpoint", "nan", "error"):
        return value.strip()
    if isinstance(value, str) and (hold := fragments.hold(value)) is not None:
        return hold
    return values.expression("'otherwise'", value)


def _variable(
    name: object, lower: object, upper: object, terms: object, label: object, unit: object, *, is_output: bool = False
) -> dict[str, Any]:
    ends = {"lower": values.expression("'lower'", lower), "upper": values.expression("'upper'", upper)}
    if isinstance(terms, Partition):
        named = terms.terms(lower, upper)
    else:
        specs = arguments.mapping("'terms'", _TERMS, terms)
        named = [(n, values.membership(f"term {n!r}", t)) for n, t in specs.items()]
    sets = tuple(Term(name=n, membership=as_set(str(name), m) if is_output else m) for n, m in named)
    return {**values.texts(name=name, label=label, unit=unit), **ends, "terms": sets}
