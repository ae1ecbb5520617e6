"""Values of free numbers: arrays or mappings, checked against bounds and against the conditions of a program."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError, DiagnosticError, UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.expr import ONE, ZERO, Expr, Name, Number, Where, evaluate, names_in, replace_names, to_text
from fuzzyctl.kernels.backends.arguments import float_array, row_array
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.free import FreePlan
from fuzzyctl.kernels.plan.plan import Plan
from fuzzyctl.kernels.plan.traced import NeedsNumberError, Trace, Traced, atom, is_free
from fuzzyctl.kernels.program import scalar
from fuzzyctl.kernels.program.builder import Builder
from fuzzyctl.kernels.program.program import STATE, Item, Program, Quadrature, Statement
from fuzzyctl.kernels.program.traversal import embed, map_expressions, reads, uses
from fuzzyctl.model.block import Bounds


def free_program(free: FreePlan, write: Callable[[Plan], Program] = inference.evaluation) -> Program:
    """Write a program whose arguments are the inputs, then the free numbers.

    Args:
        free: What to compute.
        write: Writes the program of a plan.

    Raises:
        ArgumentError: For a number that must be known before the program is written.
    """
    try:
        program = _with_given(map_expressions(write(free.plan), _named), free.trace)
        _require_plain_tables(program)
    except NeedsNumberError as needs:
        raise free.trace.refusal(needs) from None
    builder = Builder()
    used = [n for n in uses(program) if n in free.trace.definitions or Name(n) in free.trace.arguments]
    names = _defined(builder, free, used)
    inputs = [Name(x) for x in program.arguments]
    body = embed(builder, replace(program, arguments=(*program.arguments, *used)), [*inputs, *(names[n] for n in used)])
    return builder.program([*inputs, *free.trace.arguments], body)


def condition_program(free: FreePlan) -> Program:
    """Write the program of the free numbers whose results are 1 for each condition that holds, else 0."""
    conditions = list(free.trace.conditions)
    builder = Builder()
    names = _defined(builder, free, [n.name for c in conditions for n in names_in(c)])
    results: list[Expr] = [Where(replace_names(c, names), ONE, ZERO) for c in conditions]
    return builder.program(free.trace.arguments, results)


def with_values_as_array(program: Program, values: Sequence[str]) -> Program:
    """Return a program that takes some of its arguments as an array, its state."""
    items: dict[str, Expr] = {name: Item(STATE, k) for k, name in enumerate(values)}

    def change(node: Expr) -> Expr:
        return items.get(node.name, node) if isinstance(node, Name) else node

    arguments = tuple(a for a in program.arguments if a not in items)
    return replace(map_expressions(program, change), arguments=arguments, state=len(values))


def with_named_state(program: Program) -> tuple[Program, tuple[str, ...]]:
    """Return a program that takes its state as its last arguments, and their names; see `with_values_as_array`."""
    names = tuple(f"s{k}" for k in range(program.state))

    def change(node: Expr) -> Expr:
        if isinstance(node, Item) and node.array == STATE:
            assert isinstance(node.index, int), "states are read one by one"
            return Name(names[node.index])
        return node

    return replace(map_expressions(program, change), arguments=(*program.arguments, *names), state=0), names


def _named(node: Expr) -> Expr:
    """Return the name of a number that is not known yet."""
    return atom(node.value) if isinstance(node, Number) and is_free(node.value) else node


def _with_given(program: Program, trace: Trace) -> Program:
    """Return a program whose integrals are given the free numbers that they read."""
    free = {*trace.definitions, *(a.name for a in trace.arguments)}

    def changed(statement: Statement) -> Statement:
        if not isinstance(statement, Quadrature):
            return statement
        added = sorted(reads(statement) & free - set(statement.given))
        return replace(statement, given=(*statement.given, *added))

    return replace(program, body=tuple(map(changed, program.body)))


def _require_plain_tables(program: Program) -> None:
    number = next((v for _, values in program.tables for v in values if is_free(v)), None)
    if number is not None:
        raise NeedsNumberError(cast("Traced", number))


def _defined(builder: Builder, free: FreePlan, wanted: Sequence[str]) -> dict[str, Expr]:
    """Write the definitions that some names need, and return what all names stand for."""
    trace = free.trace
    needed, waiting = set[str](), list(wanted)
    while waiting:
        name = waiting.pop()
        if name not in needed:
            needed.add(name)
            waiting += [n.name for n in names_in(trace.definitions.get(name, ZERO))]
    atoms: dict[str, Expr] = {a.name: a for a in trace.arguments}
    for name, value in trace.definitions.items():
        if name in needed:
            atoms[name] = builder.let(replace_names(value, atoms))
    return atoms


if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]


class FreeValues:
    """Takes and checks values of the free numbers of a plan.

    Args:
        free: The plan.
        prefix: Prefix of the names in messages: that of a system inside a controller.
    """

    def __init__(self, free: FreePlan, prefix: str = "") -> None:
        self._free, self._names = free, tuple(f"{prefix}{name}" for name in free.names)
        self._known = b""
        self._bounds = [
            (k, p.bounds, p.unit) for k, name in enumerate(free.names) for p in free.system.params if p.name == name
        ]

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """The ends of the range that each param declares; infinite for another number."""
        ranges = [(-math.inf, math.inf)] * len(self._names)
        for k, bounds, _ in self._bounds:
            if bounds is not None:
                ranges[k] = ends_of(bounds, self._free.system.values)
        return ranges

    def of(self, given: Any) -> FloatArray:
        """Return values as a contiguous array of shape (..., free).

        Raises:
            UnknownNameError: For a name that is not free.
            ArgumentError: For an array of another shape or not of numbers.
            ValueOutOfBoundsError: For values outside the bounds of their params, or that the system cannot have.
        """
        if isinstance(given, Mapping):
            given = changed_values(self._names, self._free.values, given)
        values = row_array(self._names, given, "state")
        if values.ndim == 0 or values.shape[-1] != len(self._names):
            raise ArgumentError(f"the state must have the shape (..., {len(self._names)}), got {values.shape}")
        values = np.ascontiguousarray(values)
        key = values.tobytes() if values.ndim == 1 else b""
        if not key or key != self._known:
            self._require(values.reshape(math.prod(values.shape[:-1]), len(self._names)))
            self._known = key
        return values

    def _require(self, rows: FloatArray) -> None:
        for k, name in enumerate(self._names):
            _require_all(np.isfinite(rows[:, k]), name, rows[:, k], "a finite number")
        for k, bounds, unit in self._bounds:
            if bounds is not None:
                require_bounds(self._names[k], rows[:, k], bounds, self._free.system.values, unit)
        broken = self._broken(rows)
        if broken is not None:
            raise self._reason(*broken)

    def _broken(self, rows: FloatArray) -> tuple[FloatArray, int] | None:
        """Return the first values under which some condition does not hold, and the condition."""
        holds = np.empty((len(rows), len(self._free.trace.conditions)))
        if holds.shape[1] == 0:
            return None
        if len(rows) == 1:
            self._one(*rows[0].tolist(), holds[0])
        else:
            self._many(rows, None, holds)
        bad = np.argwhere(holds != 1.0)
        return None if not len(bad) else (rows[bad[0, 0]], int(bad[0, 1]))

    def _reason(self, values: FloatArray, condition: int) -> ValueOutOfBoundsError:
        """Return why the system cannot have some values, or why the program does not hold for them."""
        broken = list(self._free.trace.conditions)[condition]
        names = {n.name for n in names_in(broken)}
        read = zip(self._names, zip(*map(self._free.trace.sources, names), strict=True), strict=True)
        by_name = {n: float(v) for n, v in zip(self._names, values, strict=True)}
        readings = {n: by_name[n] for n, depends in read if any(depends)}
        numbers = dict(zip(self._free.names, by_name.values(), strict=True))
        what, value = ", ".join(map(repr, readings)), next(iter(readings.values())) if len(readings) == 1 else readings
        try:
            self._free.system.with_params(**numbers)
        except DiagnosticError as error:
            reason = error.diagnostics[0].message
            return ValueOutOfBoundsError(f"free number {what}", value, f"one that the system can have ({reason})")
        return ValueOutOfBoundsError(f"free number {what}", value, f"{self._shown(broken)}, as it was compiled")

    def _shown(self, condition: Expr) -> str:
        """Return a condition over the free numbers as text."""
        names: dict[str, Expr] = {a.name: Name(n) for a, n in zip(self._free.trace.arguments, self._names, strict=True)}
        if all(n.name in names for n in names_in(condition)):
            return f"such that {to_text(replace_names(condition, names))}"
        return "such that the corners stay in their order"

    @cached_property
    def _one(self) -> Any:
        program = condition_program(self._free)
        return scalar.compile_source(scalar.storing_source(program), program, self._names)

    @cached_property
    def _many(self) -> Any:
        from fuzzyctl.kernels.backends import numpy_backend

        return numpy_backend.compile_batch(condition_program(self._free), self._names)


def changed_values(names: Sequence[str], start: Sequence[float], changed: Mapping[str, Any]) -> FloatArray:
    """Return values, some of them changed; the name of an array stands for all of its entries.

    Raises:
        UnknownNameError: For a name that is not among them.
        ArgumentError: For an array of another length or not of numbers.
    """
    values = np.array(start, dtype=np.float64)
    for name, value in changed.items():
        places = [k for k, n in enumerate(names) if name in (n, n.partition("[")[0])]
        if not places:
            raise UnknownNameError("free number", name, names)
        array = float_array(value, f"free number {name!r}")
        if array.shape not in ((), (len(places),)):
            raise ArgumentError(f"free number {name!r} has {len(places)} values, got the shape {array.shape}")
        values[places] = array
    return values


def ends_of(bounds: Bounds, numbers: Mapping[str, float]) -> tuple[float, float]:
    """Return the ends of a range, where params have some values."""
    return evaluate(bounds.lower, numbers), evaluate(bounds.upper, numbers)


def require_bounds(name: str, values: Any, bounds: Bounds, numbers: Mapping[str, float], unit: str) -> None:
    """Raise `ValueOutOfBoundsError` for the first value outside the bounds of a param."""
    low, high = ends_of(bounds, numbers)
    column = np.atleast_1d(values)
    above = column > low if bounds.without_lower else column >= low
    below = column < high if bounds.without_upper else column <= high
    _require_all(above & below, name, column, f"in {bounds.text(low, high)}", unit)


def _require_all(holds: Any, name: str, column: FloatArray, bound: str, unit: str = "") -> None:
    if not np.all(holds):
        raise ValueOutOfBoundsError(f"free number {name!r}", float(column[~holds][0]), bound, unit)
