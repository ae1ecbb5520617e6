"""Plan of a system some of whose numbers are known only at run time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple, cast

from fuzzyctl.diagnostics.diagnostic import ArgumentError, UnknownNameError
from fuzzyctl.expr import names_in
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.kernels.plan.build import Plan, plan
from fuzzyctl.kernels.plan.traced import TRACE, NeedsNumberError, Trace, Traced, number_of
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.free_numbers import parametrised
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable
from fuzzyctl.records import record


@record(frozen=True)
class FreePlan:
    """A plan over free numbers.

    Args:
        system: The system, its free numbers as params.
        names: Of the free numbers, in the order of their values.
        plan: Its numbers are `Traced` where they depend on free ones.
        trace: How they depend.
    """

    system: FuzzySystem
    names: tuple[str, ...]
    plan: Plan
    trace: Trace

    @property
    def values(self) -> tuple[float, ...]:
        """The values of the system itself."""
        return tuple(self.system.values[n] for n in self.names)


def free_plan(system: FuzzySystem, names: Sequence[str]) -> FreePlan:
    """Return the plan of a well-formed system over some of its numbers.

    Args:
        system: The system.
        names: Of the free numbers, see `model.free_numbers`.

    Raises:
        UnknownNameError: For a name that the system does not have.
        ArgumentError: For a name given twice, and for a number that must be known beforehand.
        DiagnosticError: As `plan` does.
    """
    changed, free = parametrised(system, names)
    copy = replace(changed)
    trace = copy.derived[TRACE] = Trace(free, [copy.values[n] for n in free])
    _trace_params(copy, trace)
    try:
        _require_shapes(copy, trace)
        return FreePlan(changed, free, plan(copy), trace)
    except NeedsNumberError as needs:
        raise trace.refusal(needs) from None


def _trace_params(system: FuzzySystem, trace: Trace) -> None:
    """Record the params that are computed from free ones, each after those that it reads."""
    expressions = {p.name: p.expression for p in system.params}
    for name in system.values:
        if name not in trace.numbers and any(n.name in trace.numbers for n in names_in(expressions[name])):
            trace.numbers[name] = cast("Traced", number_of(system, expressions[name]))


def _require_shapes(system: FuzzySystem, trace: Trace) -> None:
    """Record what must hold of ranges, parameters, heights and weights."""
    with trace.strictly():
        for variable in (*system.inputs, *system.outputs, *system.lets):
            assert number_of(system, variable.lower) < number_of(system, variable.upper), "the system is well formed"
            _require_terms(system, variable, trace)
        for weight in dict.fromkeys(rule.weight for rule in system.rules):
            trace.require(">=", number_of(system, weight), 0.0)
            trace.require("<=", number_of(system, weight), 1.0)


def _require_terms(system: FuzzySystem, variable: LinguisticVariable, trace: Trace) -> None:
    for term in variable.terms:
        membership = term.membership
        if membership.kind not in MEMBERSHIP:
            continue
        parameters = tuple(number_of(system, a) for a in membership.arguments)
        MEMBERSHIP[membership.kind].mistake(parameters)
        if MEMBERSHIP[membership.kind].variadic:
            for before, after in pairwise(parameters[::2]):
                trace.require_apart(before, after)
        trace.require(">", number_of(system, membership.height), 0.0)
        trace.require("<=", number_of(system, membership.height), 1.0)


class FreeNumber(NamedTuple):
    """A number of a system that a controller calls."""

    system: str
    name: str


def free_names(controller: Controller, names: Sequence[str]) -> tuple[tuple[str, ...], tuple[float, ...]]:
    """Return the names of free numbers, those of arrays one by one, and their present values.

    Params of instances are among the params of the controller here, see `with_instance_params`.
    """
    values = controller.param_values.values
    systems = {s.name: s for s in controller.systems}
    values_by_name: dict[str, float] = {}
    for name in names:
        if not isinstance(name, str):
            raise ArgumentError(f"free must be a list of names, got {type(name).__name__} in it")
        system, _, rest = name.partition(".")
        if name in values:
            numbers = {name: values[name]}
        elif system in systems and rest:
            changed, parts = _parametrised(systems[system], rest)
            numbers = {f"{system}.{part}": changed.values[part] for part in parts}
        else:
            own_params = controller.settable
            names_known = [*dict.fromkeys(own_params), *(f"{s}.NAME" for s in systems)]
            raise UnknownNameError("free number", name, names_known)
        repeated = next((n for n in numbers if n in values_by_name), None)
        if repeated is not None:
            raise ArgumentError(f"'{repeated}' cannot be free: it is given twice")
        values_by_name |= numbers
    return tuple(values_by_name), tuple(values_by_name.values())


def _parametrised(system: FuzzySystem, name: str) -> tuple[FuzzySystem, tuple[str, ...]]:
    try:
        return parametrised(system, [name])
    except UnknownNameError as error:
        suggestions = [f"{system.name}.{k}" for k in error.known]
        raise UnknownNameError("free number", f"{system.name}.{name}", suggestions) from None
