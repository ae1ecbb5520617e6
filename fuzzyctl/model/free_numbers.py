"""Numbers of a system by name, such as `e.PS.peak`: each becomes a param of that name.

NAME                    a param
VARIABLE.TERM.PARAMETER a parameter of a membership function, `height` among them
OUTPUT.TERM.INPUT       a coefficient of a linear consequent, `constant` the last one
OUTPUT.weights          the weights of all rules that conclude an output; OUTPUT.weights[K] one of them
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from numbers import Real
from typing import Any, Final, TypeVar

from fuzzyctl.diagnostics.diagnostic import ArgumentError, UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.expr import Expr, Name, Number
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.model.block import Param
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable, Membership, Output, Term
from fuzzyctl.support.arguments import is_finite

_WEIGHTS: Final = re.compile(r"weights(?:\[(\d+)\])?")
_WORD: Final = "free number"
_V = TypeVar("_V", bound=LinguisticVariable)


def parametrised(system: FuzzySystem, names: Sequence[str]) -> tuple[FuzzySystem, tuple[str, ...]]:
    """Return a system in which named numbers are params, and the names of these params.

    Corners that a `terms` line shares stay one number: with `e.PS.peak` move the feet of the neighbours.

    Args:
        system: The system.
        names: As above, in the order in which their values are given.

    Raises:
        UnknownNameError: For a name that the system does not have.
        ArgumentError: For a name given twice, and for a value that is not a finite number.
    """
    free: list[str] = []
    for name in names:
        if not isinstance(name, str):
            raise ArgumentError(f"free must be a list of names, got {type(name).__name__} in it")
        system, members = _freed(system, name)
        repeated = next((n for n in members if n in free), None)
        if repeated is not None:
            raise ArgumentError(f"'{repeated}' cannot be free: it is given twice")
        free += members
    return system, tuple(free)


def with_numbers(system: FuzzySystem, values: Mapping[str, Any]) -> FuzzySystem:
    """Return a system with some of its numbers changed in place; tables whose weights change become single rules.

    Args:
        system: The system.
        values: By name, as above; of `OUTPUT.weights` one number for all or a sequence.

    Raises:
        UnknownNameError: For a name that the system does not have.
        ArgumentError: For a name given twice, a value that is not a number, and another number of weights.
        ValueOutOfBoundsError: For a value that is not finite.
        DiagnosticError: If the system is not well formed with these values.
    """
    declared = {p.name for p in system.params}
    numbers: dict[str, float] = {}
    for name, value in values.items():
        _, names = parametrised(system, [name])
        if not isinstance(value, Real | Iterable):
            raise ArgumentError(f"{_WORD} {name!r} must be a number, got {type(value).__name__}")
        several = [value] * len(names) if isinstance(value, Real) else list(value)
        if len(several) != len(names):
            raise ArgumentError(f"{_WORD} {name!r} has {len(names)} values, got {len(several)}")
        for one, x in zip(names, several, strict=True):
            if not is_finite(x):
                raise ValueOutOfBoundsError(f"{_WORD} {one!r}", x, "a finite number")
            numbers[one] = float(x)
    changed, _ = parametrised(system, list(values))
    params = {n: x for n, x in numbers.items() if n in declared}

    def number(value: Any) -> Any:
        return (
            Number(numbers[value.name])
            if isinstance(value, Name) and value.name in numbers.keys() - declared
            else value
        )

    def with_terms(variables: tuple[_V, ...]) -> tuple[_V, ...]:
        return tuple(
            replace(
                v,
                terms=tuple(
                    _with(t, arguments=tuple(map(number, t.membership.arguments)), height=number(t.membership.height))
                    for t in v.terms
                ),
            )
            for v in variables
        )

    if any(".weights[" in name for name in numbers):
        changed = changed.with_rules([replace(r, weight=number(r.weight)) for r in changed.rules])
    changed = replace(
        changed,
        inputs=with_terms(changed.inputs),
        outputs=with_terms(changed.outputs),
        lets=with_terms(changed.lets),
        params=system.params,
    )
    return changed.with_params(**params)


def _freed(system: FuzzySystem, name: str) -> tuple[FuzzySystem, list[str]]:
    """Return the system with one name as params, and their names."""
    if any(p.name == name for p in system.params):
        return system, [name]
    variable, _, rest = name.partition(".")
    variables = (*system.inputs, *system.outputs, *system.lets)
    declared = next((v for v in variables if v.name == variable), None)
    if declared is None:
        names = [*(p.name for p in system.params), *(v.name for v in variables)]
        raise UnknownNameError(_WORD, name, names)
    if isinstance(declared, Output) and (weights := _WEIGHTS.fullmatch(rest)):
        return _with_weights(system, declared, weights[1])
    word, _, parameter = rest.partition(".")
    term = declared.term(word)
    if term is None:
        words = [f"{variable}.{t.name}" for t in declared.terms]
        raise UnknownNameError(_WORD, name, [*words, f"{variable}.weights"] if isinstance(declared, Output) else words)
    return _with_parameter(system, declared, term, parameter)


def _with_weights(system: FuzzySystem, output: Output, place: str | None) -> tuple[FuzzySystem, list[str]]:
    """Return the system with weights of the rules of an output as params."""
    rules = list(system.rules)
    concluding = list(dict.fromkeys(r for r, _ in system.conclusions.get(output.name, ())))
    chosen = range(len(concluding)) if place is None else [int(place)]
    params: list[Param] = []
    for k in chosen:
        name = f"{output.name}.weights[{k}]"
        if k >= len(concluding):
            raise UnknownNameError(_WORD, name, [f"{output.name}.weights[0] to [{len(concluding) - 1}]"])
        rule = rules[concluding[k]]
        params += _params(system, name, rule.weight)
        rules[concluding[k]] = replace(rule, weight=Name(name))
    system = replace(system.with_rules(rules), params=(*system.params, *params))
    return system, [p.name for p in params]


def _with_parameter(
    system: FuzzySystem, variable: LinguisticVariable, term: Term, parameter: str
) -> tuple[FuzzySystem, list[str]]:
    """Return the system with one parameter of a term as a param."""
    membership, prefix = term.membership, f"{variable.name}.{term.name}"
    parameters = _parameters(system, membership)
    if not parameters:
        raise ArgumentError(f"'{prefix}' is a function: make the numbers in it params, and name these")
    name = f"{prefix}.{parameter}"
    if parameter not in parameters:
        raise UnknownNameError(_WORD, name.removesuffix("."), [f"{prefix}.{p}" for p in parameters])
    if parameter == "height":
        params = _params(system, name, membership.height)
        terms = tuple(_with(t, height=Name(name)) if t is term else t for t in variable.terms)
    else:
        value = membership.arguments[parameters[parameter]]
        params = _params(system, name, value)
        terms = tuple(
            _with(t, arguments=tuple(Name(name) if a is value else a for a in t.membership.arguments))
            for t in variable.terms
        )
    changed = replace(
        system,
        inputs=_with_terms(system.inputs, variable, terms),
        outputs=_with_terms(system.outputs, variable, terms),
        lets=_with_terms(system.lets, variable, terms),
        params=(*system.params, *params),
    )
    return changed, [name]


def _with_terms(among: tuple[_V, ...], variable: LinguisticVariable, terms: tuple[Term, ...]) -> tuple[_V, ...]:
    return tuple(replace(v, terms=terms) if v is variable else v for v in among)


def _params(system: FuzzySystem, name: str, value: Expr) -> list[Param]:
    if isinstance(value, Name) and ("." in value.name):
        raise ArgumentError(f"'{name}' cannot be free: it is given twice, as '{value.name}'")
    if math.isinf(system.number(value)):
        raise ArgumentError(f"'{name}' cannot be free: it is infinite")
    return [Param(name=name, expression=value)]


def _parameters(system: FuzzySystem, membership: Membership) -> dict[str, int]:
    """Return the names of the parameters of a membership function, with their positions."""
    count = len(membership.arguments)
    if membership.kind == "linear":
        return {n: k for k, n in enumerate([*(i.name for i in system.inputs), "constant"])}
    if membership.kind not in MEMBERSHIP:
        return {}
    formula = MEMBERSHIP[membership.kind]
    names = list(formula.parameters)
    if formula.variadic:
        names = [f"{'xy'[k % 2]}{k // 2 + 1}" for k in range(count)]
    results = {n: k for k, n in enumerate(names)}
    if names == ["value"]:
        results["peak"] = 0
    return results | {"height": -1}


def _with(term: Term, **changed: Any) -> Term:
    return replace(term, membership=replace(term.membership, **changed))
