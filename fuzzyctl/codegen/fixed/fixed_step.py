"""Fixed-point steps of controllers: integers only, with a proved error bound over all steps.

A state is off by e' <= L e + d after a step: L are slopes of the next states along the states, d is what all roundings
of a step add. A bound e with L e + d <= e holds at every step, by induction.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from fuzzyctl.analysis.induction.prover import ControllerProver
from fuzzyctl.analysis.induction.step_model import ABSORBED, FAR
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.fixed.fixed_format import Format
from fuzzyctl.codegen.fixed.fixed_formats import Formats, fits
from fuzzyctl.codegen.fixed.fixed_program import (
    FLOAT,
    KEEPS_ERROR,
    MOST_OPERATIONS,
    SYSTEM,
    Operations,
    UnsuitedError,
    error_help,
    operations,
    operator_of,
    place_of,
    range_help,
    refused,
    state_words,
)
from fuzzyctl.codegen.fixed.fixed_ranges import CalledSystem, Ends, Ranges
from fuzzyctl.codegen.fixed.fixed_system import finest
from fuzzyctl.codegen.prepare import tidy, with_slots
from fuzzyctl.codegen.simplify import lean
from fuzzyctl.codegen.table import USEFUL, at_most
from fuzzyctl.codegen.unit import Evaluated, Unit
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.expr import Call, Name, Number, walk
from fuzzyctl.kernels.algorithms.grid import grid_of
from fuzzyctl.kernels.algorithms.select import Algorithm
from fuzzyctl.kernels.interval.vector import Array, Enclosure
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.plan.equations import Evaluation
from fuzzyctl.kernels.program.program import Program
from fuzzyctl.kernels.program.traversal import expressions
from fuzzyctl.kernels.step_form import named_step

#: Seconds that the proof of the range of a state may take.
_SECONDS: Final = 2.0
#: Rounds in which formats and errors are found.
_ROUNDS: Final = 24
#: Rounding of sums and products of errors, relative to them.
_OUTWARD: Final = 1.0 + 2.0**-40
#: By how much slopes and roundings are taken larger, relative to them, so that a solution is one after rounding, too.
_ROOM: Final = 2.0**-24


@dataclass(frozen=True)
class FixedStep:
    """Integers that take the place of a step.

    Args:
        unit: The step, in which systems are calls.
        form: The format of inputs and outputs.
        operations: Its operations.
        formats: In which integers.
        systems: The systems that it calls, by number.
        inputs: Ranges that the inputs are held in, as integers of the format.
        errors: Proved bound of |output - output in double precision|, at every step.
        slot_errors: The same of each slot.
    """

    unit: Unit
    form: Format
    operations: Operations
    formats: Formats
    systems: Mapping[int, CalledSystem]
    inputs: tuple[tuple[int, int], ...]
    errors: tuple[float, ...]
    slot_errors: tuple[float, ...]


def fixed_step(unit: Unit, form: Format) -> FixedStep:
    """Turn a step into integers.

    Args:
        unit: The step, in double precision, no number of it free.
        form: The format of inputs and outputs.

    Raises:
        DiagnosticError: With the place and the reason, for a controller without a period; for an operation or a system
            that fixed point has not; for a state whose range, or whose error, has no bound over all steps; for outputs
            that the format does not reach; where no useful bound is found.
    """
    equations = unit.equations
    if equations.period is None:
        message = "fixed point needs a sample time, and the controller has none"
        raise refused(message, unit.controller.span, help_text="add one, such as 'every 10 ms'")
    opaque, systems = _with_calls(unit)
    try:
        result = operations(opaque.program, len(equations.inputs), len(opaque.outputs))
    except UnsuitedError as error:
        raise refused(str(error), place_of(equations, error.node), help_text=FLOAT.removeprefix("or ")) from None
    if len(result.items) > MOST_OPERATIONS:
        message = f"a step has {len(result.items):,} operations, more than {MOST_OPERATIONS:,}"
        raise refused(message, unit.controller.span, help_text=FLOAT.removeprefix("or "))
    bound = _Bound(opaque, form, result, systems)
    bound.run()
    return FixedStep(
        opaque, form, result, bound.formats, systems, bound.integers, tuple(bound.errors), tuple(bound.slot_errors)
    )


def _with_calls(unit: Unit) -> tuple[Unit, dict[int, CalledSystem]]:
    """Return a step in which systems are calls, and the systems by number."""
    numbers: dict[Evaluation, int] = {}
    calls: list[Evaluation] = []

    def point(call: Evaluation) -> Program:
        if call.states:
            _called(call)  # adapts, so that no table interpolates
        key = replace(call, arguments=(), names=(), span=None)
        if key not in numbers:
            numbers[key] = len(calls)
            calls.append(call)
        arguments = tuple(f"x{k}" for k in range(len(call.system.inputs)))
        name, operands = f"{SYSTEM}{numbers[key]}", tuple(map(Name, arguments))
        results = tuple(Call(name, (Number(float(o)), *operands)) for o in range(len(call.system.outputs)))
        return Program(arguments, 0, (), (), results)

    equations = unit.equations
    written, values = named_step(equations, point)
    program, slots = with_slots(lean(tidy(written)), equations.states, len(equations.outputs))
    names = {v.name: n for n, v in reversed(values.items()) if isinstance(v, Name) and "#" not in n}
    read = {n.function for e in expressions(program) for n in walk(e) if isinstance(n, Call)}
    systems = {k: _called(call) for k, call in enumerate(calls) if f"{SYSTEM}{k}" in read}
    parts = tuple(s.unit.systems[0] for s in systems.values())
    return replace(unit, written=program, slots=slots, values=names, systems=parts), systems


def _called(call: Evaluation) -> CalledSystem:
    """Return a system as integers.

    Raises:
        DiagnosticError: For one that does not interpolate.
    """
    flat = plan(call.system)
    grid = grid_of(flat)
    if isinstance(grid, str):
        message = f"fixed point needs systems that interpolate, and '{call.system.name}' does not: {grid}"
        raise refused(message, call.span, help_text=FLOAT.removeprefix("or "))
    part = Evaluated(call.system, Algorithm(flat, grid, "it interpolates"))
    unit = Unit(call.system, Program((), 0, (), (), ()), (part,))
    try:
        return CalledSystem(unit, grid, finest(unit))
    except CodegenError as error:
        raise refused(f"'{call.system.name}': {error}", call.span) from None


class _Bound:
    """Finds formats and errors of a step.

    Args:
        unit: The step.
        form: The format of inputs and outputs.
        found: Its operations.
        systems: The systems that it calls, by number.
    """

    def __init__(self, unit: Unit, form: Format, found: Operations, systems: Mapping[int, CalledSystem]) -> None:
        self.unit, self.form, self.operations, self.systems = unit, form, found, systems
        self.states = unit.equations.states
        self.integers, self.inputs, self.ranges = self._given()
        self.errors: list[float] = []
        self.slot_errors: list[float] = []

    def _given(self) -> tuple[tuple[tuple[int, int], ...], list[Ends], list[Ends]]:
        """Return the ranges of the inputs, as integers and as numbers, and those of the slots.

        Raises:
            DiagnosticError: For a state without a range.
        """
        prover = ControllerProver(self.unit.controller, _SECONDS)
        one = 1 << self.form.fraction
        integers = []
        self.open_inputs = [n for n, (low, high) in prover.inputs.items() if low <= -FAR or high >= FAR]
        for signal in self.unit.controller.inputs:
            low, high = prover.inputs[signal.name]
            least = math.ceil(max(low, self.form.lower) * one)
            most = math.floor(min(high, self.form.upper) * one)
            if least > most:
                message = f"{self.form} has no number in the range of '{signal.name}'"
                raise refused(message, signal.span)
            integers.append((least, most))
        inputs = [(least / one, most / one) for least, most in integers]
        prover.inputs = {s.name: ends for s, ends in zip(self.unit.controller.inputs, inputs, strict=True)}
        ranges, place = [], 0
        for slot in self.unit.slots:
            state = self.states[place]
            low, high = prover.ranges[state.name]
            if not (low > -ABSORBED and high < ABSORBED):
                message = f"no range of {state_words(slot.name)} is proved that holds over all steps"
                raise refused(
                    message, state.span, facts=self._reason(slot.name, low, high), help_text=range_help(slot.name)
                )
            ranges.append((low, high))
            place += slot.length
        return tuple(integers), inputs, ranges

    @staticmethod
    def _reason(name: str, low: float, high: float) -> list[str]:
        ends = [w for w, is_open in (("least", not low > -ABSORBED), ("largest", not high < ABSORBED)) if is_open]
        results = [f"no bound is found of its {' and its '.join(ends)} value"]
        return [*results, KEEPS_ERROR] if operator_of(name) == "integral" else results

    def run(self) -> None:
        """Find formats, and errors that no step makes larger.

        Raises:
            DiagnosticError: If they do not exist.
        """
        count = len(self.unit.slots)
        off: list[float | None] = [0.0] * count
        nothing = [0.0] * len(self.operations.items)
        enclosures = self._ranges(off, nothing).run()
        for _ in range(_ROUNDS):
            ends = [_ends(e) for e in enclosures]
            formats = Formats(self.operations, self.systems, self.form, ends, [s.start for s in self.unit.slots])
            self._require_reach(formats, ends)
            equal = [formats.equal[p] for p in self.operations.stores]
            off = [None if same else e or 0.0 for same, e in zip(equal, off, strict=True)]
            ranges = self.last = self._ranges(off, formats.roundings, formats)
            enclosures = ranges.run()
            if not all(fits(formats.fractions[k], _ends(e)) for k, e in enumerate(enclosures)):
                continue
            errors = self._solved(formats, ranges, enclosures, off)
            if all(bound is None or e <= bound for e, bound in zip(errors, off, strict=True)):
                self.formats, self.slot_errors = formats, errors
                outputs = self.operations.outputs
                self.errors = [0.0 if formats.equal[p] else self._error(p, enclosures, ranges, errors) for p in outputs]
                self._require_useful(enclosures)
                return
            off = [None if bound is None else 2.0 * e for e, bound in zip(errors, off, strict=True)]
        reason = "the errors grow with the ranges that they allow"
        if not off:
            message = f"no integers of 32 bits hold a step in {self.form} with its roundings"
            raise refused(message, self.unit.controller.span, facts=[reason], help_text=FLOAT.removeprefix("or "))
        worst = int(np.argmax([-1.0 if e is None else e for e in off]))
        raise self._not_kept(worst, reason)

    def _ranges(self, off: Sequence[float | None], added: Sequence[float], formats: Formats | None = None) -> Ranges:
        ranges = Ranges(self.operations, self.systems, self.inputs, self.ranges, off, added)
        if formats is None:
            ranges.alike = lambda _: True
        else:
            ranges.alike = formats.equal.__getitem__
        return ranges

    def _require_reach(self, formats: Formats, ends: Sequence[Ends]) -> None:
        """Refuse values that no integer reaches, and outputs that the format does not reach."""
        if formats.beyond:
            low, high = ends[formats.beyond[0]]
            message = f"{self._name(formats.beyond[0])} may be from {low:.9g} to {high:.9g}, beyond integers of 32 bits"
            raise refused(message, self.unit.controller.span, help_text="give inputs and states ranges")
        unit_in_last = 2.0**-self.form.fraction
        for declared, position in zip(self.unit.controller.results, self.operations.outputs, strict=True):
            low, high = ends[self.operations.items[position].operands[0]]
            if low < self.form.lower - unit_in_last or high > self.form.upper + unit_in_last:
                message = f"{self.form} reaches from {self.form.lower:.9g} to {self.form.upper:.9g}"
                message += f", and '{declared.name}' from {low:.9g} to {high:.9g}"
                whole = max(0, math.ceil(math.log2(max(-low, high, 1e-9) * (1 + 1e-9))))
                bits = 15 if self.form.bits == 16 and whole <= 15 else 31
                help_text = f"take --fixed Q{whole}.{bits - whole}" if whole <= bits else "limit it with 'clamp'"
                if self.open_inputs and declared.bounds is None:
                    help_text = f"give {self.open_inputs[0]!r} a range; without one it has that of the format"
                raise refused(message, declared.span, help_text=help_text)

    def _slopes(self, position: int, enclosures: Sequence[Enclosure]) -> Array:
        """Return the largest slopes of a value along all operations."""
        slopes = enclosures[position].slopes
        size = np.zeros(len(self.operations.items))
        return size if slopes is None else np.maximum(np.abs(slopes[0]), np.abs(slopes[1])).max(axis=1) + size

    def _added(self, position: int, enclosures: Sequence[Enclosure], ranges: Ranges) -> tuple[Array, float]:
        """Return the slopes of a value along the slots, and the error by the roundings of a step."""
        slopes = self._slopes(position, enclosures)
        roundings = np.array([r + ranges.jumps.get(k, 0.0) for k, r in enumerate(ranges.roundings)])
        total = float(np.sum(np.where(roundings > 0.0, slopes * roundings, 0.0))) + float(
            enclosures[position].error.max()
        )
        along = np.zeros(len(self.unit.slots))
        for k, item in enumerate(self.operations.items):
            if item.kind == "slot":
                along[item.place] = slopes[k]
        return along, total * _OUTWARD

    def _error(self, position: int, enclosures: Sequence[Enclosure], ranges: Ranges, errors: Sequence[float]) -> float:
        along, total = self._added(position, enclosures, ranges)
        return float(np.sum(np.where(along > 0.0, along * np.array(errors), 0.0)) + total) * _OUTWARD

    def _solved(
        self, formats: Formats, ranges: Ranges, enclosures: Sequence[Enclosure], off: Sequence[float | None]
    ) -> list[float]:
        """Return errors of the slots that no step makes larger, 0 for those that are equal.

        Raises:
            DiagnosticError: If they do not exist.
        """
        slots = [s for s, e in enumerate(off) if e is not None]
        rows = [self._added(self.operations.stores[s], enclosures, ranges) for s in slots]
        matrix = np.array([along[slots] for along, _ in rows]).reshape(len(slots), len(slots))
        added = np.array([total for _, total in rows])
        starts = np.array([2.0 ** -(formats.slots[s] + 1) for s in slots])
        self._require_contraction(slots, matrix)
        # Both grow a little, so that the rounding of the solution does not matter.
        wider, more = matrix * (1.0 + _ROOM), added * (1.0 + _ROOM)
        error = added
        for _ in range(_ROUNDS):
            error = np.linalg.solve(np.eye(len(slots)) - wider, more)
            if np.all(error >= starts):
                break
            more = more + np.maximum(starts - error, 0.0) * (1.0 + _ROOM)
        if not (np.all(error >= starts) and np.all((matrix @ error + added) * _OUTWARD <= error)):
            raise self._not_kept(
                slots[int(np.argmax(error))], "the errors of states that feed one another add up to too much"
            )
        errors = [0.0] * len(off)
        for s, e in zip(slots, error.tolist(), strict=True):
            errors[s] = e
        return errors

    def _require_contraction(self, slots: Sequence[int], matrix: Array) -> None:
        """Refuse errors that the steps do not make smaller."""
        for s, slope in zip(slots, np.diag(matrix).tolist(), strict=True):
            if not slope < 1.0 - 1e-9:
                reason = (
                    KEEPS_ERROR if slope < 1.0 + 1e-6 else f"a step may make an error of it {slope:.3g} times as large"
                )
                raise self._not_kept(s, reason)
        if not np.all(np.isfinite(matrix)):
            raise self._not_kept(slots[0], "its slope has no bound")
        radius = np.abs(np.linalg.eigvals(matrix)).max() if slots else 0.0
        if not radius < 1.0 - 1e-9:
            vectors = np.linalg.matrix_power(matrix + np.eye(len(slots)), 64).sum(axis=1)
            raise self._not_kept(slots[int(np.argmax(vectors))], "states make each other's errors larger step by step")

    def _jump(self) -> list[str]:
        """Return a line that names the largest jump, if there is one."""
        jumps = sorted(self.last.jumps.items(), key=lambda j: -j[1])
        return [f"{self._name(k)} jumps where rounding may decide on which side of a limit it is" for k, _ in jumps[:1]]

    def _not_kept(self, slot: int, reason: str) -> DiagnosticError:
        place = sum(s.length for s in self.unit.slots[:slot])
        name = self.unit.slots[slot].name
        message = f"no bound of the error of {state_words(name)} holds over all steps"
        facts = [reason, *self._jump()]
        return refused(message, self.states[place].span, facts=facts, help_text=error_help(name))

    def _require_useful(self, enclosures: Sequence[Enclosure]) -> None:
        for declared, position, error in zip(
            self.unit.controller.results, self.operations.outputs, self.errors, strict=True
        ):
            low, high = _ends(enclosures[self.operations.items[position].operands[0]])
            if error <= USEFUL * (high - low) or error <= 2.0**-self.form.fraction:
                continue
            message = f"no useful bound is found for the error of '{declared.name}' in {self.form}: at most "
            message += f"{at_most(error)}, of a span of {high - low:.3g}"
            facts = self._jump()
            help_text = "compare inputs, or what is computed from them by sums" if facts else "take more bits"
            raise refused(message, declared.span, facts=facts, help_text=f"{help_text}, {FLOAT}")

    def _name(self, position: int) -> str:
        """Return the name of a value, or of a name that is computed from it."""
        for k in range(position, len(self.operations.items)):
            name = self.unit.values.get(self.operations.names.get(k, ""))
            if name is not None:
                return f"'{name}'" if k == position else f"a part of '{name}'"
        return "a choice"


def _ends(e: Enclosure) -> Ends:
    return float(e.lo.min()), float(e.hi.max())
