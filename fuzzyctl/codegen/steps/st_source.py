"""A step as a FUNCTION_BLOCK of IEC 61131-3, whose variables keep the state."""

from __future__ import annotations

import math
from collections.abc import Iterator

from fuzzyctl.codegen.names import ST_RESERVED, Names
from fuzzyctl.codegen.simplify import functions
from fuzzyctl.codegen.st_guards import PARTIAL
from fuzzyctl.codegen.st_source import comment, comments, constants, result
from fuzzyctl.codegen.st_text import INDENT, LARGEST, STText
from fuzzyctl.codegen.steps.c_layout import member_name
from fuzzyctl.codegen.steps.unit import (
    StepUnit,
    described_step,
    input_notes,
    number_notes,
    signal_note,
    slot_notes,
    step_table_notes,
)
from fuzzyctl.codegen.wrapping import broken
from fuzzyctl.expr import Name, Number, walk
from fuzzyctl.kernels.program.program import Program
from fuzzyctl.kernels.program.traversal import expressions

#: The input that takes the time since the step before.
TIME = "time_step"


def block_name(unit: StepUnit) -> str:
    """Return the name of the function block, and of its file."""
    return Names(ST_RESERVED, fold=True).claim(unit.controller.name)


def function_block(unit: StepUnit) -> str:
    """Return the text of NAME.st.

    Inputs are VAR_INPUT, `time_step` last where there is no period. Each output has a BOOL `NAME_valid` beside it:
    FALSE where an input is no finite number, or nothing gives a value; the output is 0 then.

    Args:
        unit: Prepared with `guarded`.
    """
    return _Block(unit).text()


class _Block:
    def __init__(self, unit: StepUnit) -> None:
        self.unit, self.name = unit, block_name(unit)
        names = Names([*ST_RESERVED, self.name.lower(), TIME, "refused", "valid"], fold=True)
        self.arguments = [names.claim(i) for i in unit.equations.inputs]
        self.arguments += [TIME] if unit.equations.period is None else []
        self.outputs = [names.claim(o) for o in unit.outputs]
        self.valid = [names.claim(f"{o}_valid") for o in self.outputs]
        self.numbers = [names.claim(member_name(n.name)) for n in unit.numbers]
        self.slots = [names.claim(member_name(s.name)) for s in unit.slots]
        self.flags = [names.claim(f"{s}_no") for s in self.slots]
        self.oldest = [
            names.claim(f"{n}_oldest") if s.length > 1 else "" for n, s in zip(self.slots, unit.slots, strict=True)
        ]
        #: Slots that may hold no value, from the first step on or later.
        self.missing = {k for k, s in enumerate(unit.slots) if math.isnan(s.start)}

    def text(self) -> str:
        partial = bool(functions(self.unit.program) & PARTIAL) or _holds_nan(self.unit.program)
        while True:
            before = (partial, len(self.missing))
            partial = partial or bool(self.missing)
            writer = self._writer(partial=partial)
            body = list(self._step(writer))
            partial = partial or writer.undefined  # selections have to look for what has no value, too
            if (partial, len(self.missing)) == before:
                break
        head = [comment(line) if line else "" for line in self._head(writer)]
        lines = [*head, f"FUNCTION_BLOCK {self.name}", *self._interface(writer), *self._variables(writer)]
        tables = constants(writer, self.unit.program.tables, step_table_notes(self.unit))
        lines += [*tables, "", *body, "END_FUNCTION_BLOCK"]
        return "\n".join(broken(lines, INDENT)) + "\n"

    def _place(self, k: int, name: str) -> str:
        """Return the text of an entry of a slot, the oldest of a delay."""
        return f"{name}[{self.oldest[k]}]" if self.oldest[k] else name

    def _writer(self, *, partial: bool) -> STText:
        own = self.unit.program.arguments
        slots = [self._place(k, name) for k, name in enumerate(self.slots)]
        names = dict(zip(own, [*self.arguments, *slots, *self.numbers], strict=True))
        missing = {f"s{k}": self._place(k, self.flags[k]) for k in self.missing}
        notes = {value: comments([name]) for value, name in self.unit.values.items()}
        return STText(self.unit.precision, names, partial=partial, notes=notes, absent=missing)

    def _head(self, writer: STText) -> Iterator[str]:
        yield from (*described_step(self.unit), "")
        yield "Where an output is not valid, it is 0: no step was made, or nothing gives it a value."
        positive = f" or {TIME} is not positive" if TIME in self.arguments else ""
        yield f"Where an input is NaN or infinite{positive}, the state stays as it is."
        if writer.partial:
            yield "Functions are called only where they have a value; a quotient by 0 counts as the largest number."

    def _interface(self, writer: STText) -> Iterator[str]:
        yield "VAR_INPUT"
        for name, note in zip(self.arguments, input_notes(self.unit), strict=True):
            yield from (INDENT + line for line in comments([note] if note else []))
            yield f"{INDENT}{name} : {writer.real};"
        for name, number, note in zip(self.numbers, self.unit.numbers, number_notes(self.unit), strict=True):
            yield from (INDENT + line for line in comments([note] if note else []))
            yield f"{INDENT}{name} : {writer.real} := {writer.number(number.start).strip('()')};"
        yield from ("END_VAR", "VAR_OUTPUT")
        for name, valid, signal in zip(self.outputs, self.valid, self.unit.controller.results, strict=True):
            note = signal_note(self.unit, signal)
            yield from (INDENT + line for line in comments([note] if note else []))
            yield from (f"{INDENT}{name} : {writer.real};", f"{INDENT}{valid} : BOOL;")
        yield "END_VAR"

    def _variables(self, writer: STText) -> Iterator[str]:
        yield "VAR"
        for k, (slot, note) in enumerate(zip(self.unit.slots, slot_notes(self.unit), strict=True)):
            yield from (INDENT + line for line in comments([note]))
            yield from (INDENT + line for line in self._slot(writer, k, slot.length))
        if self.unit.refusals:
            yield f"{INDENT}refused : BOOL;"
        for kind, names in ((writer.real, writer.reals), ("DINT", writer.integers), ("BOOL", writer.flags)):
            yield from (f"{INDENT}{name} : {kind};" for name in dict.fromkeys(names))
        yield "END_VAR"

    def _slot(self, writer: STText, k: int, length: int) -> Iterator[str]:
        start = self.unit.slots[k].start
        value = writer.number(0.0 if math.isnan(start) else start).strip("()")
        flag = f" := {'TRUE' if math.isnan(start) else 'FALSE'}"
        if length == 1:
            yield f"{self.slots[k]} : {writer.real} := {value};"
            if k in self.missing:
                yield f"{self.flags[k]} : BOOL{flag};"
            return
        yield f"{self.slots[k]} : ARRAY[0..{length - 1}] OF {writer.real} := [{length}({value})];"
        if k in self.missing:
            yield f"{self.flags[k]} : ARRAY[0..{length - 1}] OF BOOL := [{length}({flag.removeprefix(' := ')})];"
        yield f"{self.oldest[k]} : DINT;"

    def _guard(self, writer: STText) -> str:
        # False for NaN and for infinities.
        largest = writer.number(LARGEST[self.unit.precision])
        tests = [f"(ABS({a}) <= {largest})" for a in (*self.arguments, *self.numbers)]
        tests += [f"({TIME} > {writer.number(0.0)})"] if TIME in self.arguments else []
        return " AND ".join(tests) or "TRUE"

    def _step(self, writer: STText) -> Iterator[str]:
        for output, valid in zip(self.outputs, self.valid, strict=True):
            yield from (f"{output} := {writer.number(0.0)};", f"{valid} := FALSE;")
        if self.unit.refusals:
            yield "refused := FALSE;"
        yield f"IF {self._guard(writer)} THEN"
        yield from writer.block(self.unit.program.body, dict.fromkeys(self.unit.refusals, "refused := TRUE;"), 1)
        depth = 1
        if self.unit.refusals:
            yield f"{INDENT}IF NOT refused THEN"
            depth = 2
        for k, (output, value) in enumerate(zip(self.outputs, self.unit.results, strict=True)):
            yield from result(writer, f"result{k}", value, output, self.valid[k], depth)
        yield from self._stores(writer, depth)
        if self.unit.refusals:
            yield f"{INDENT}END_IF;"
        yield "END_IF;"

    def _stores(self, writer: STText, depth: int) -> Iterator[str]:
        """Yield lines that store the state; what is read of it is read before."""
        pad = INDENT * depth
        taken = []
        for k, value in enumerate(self.unit.taken):
            own = f"u{k}"
            if isinstance(value, Number) and math.isfinite(value.value):
                own = writer.number(value.value)
            elif isinstance(value, Name) and value.name in writer.reals:
                own = value.name
            else:
                yield from writer.assigned(own, value, depth)
                writer.reals.append(own)
            taken.append(own)
        for k, (own, slot) in enumerate(zip(taken, self.unit.slots, strict=True)):
            if writer.flag_of(own):
                self.missing.add(k)
            if k in self.missing:
                yield f"{pad}{self._place(k, self.flags[k])} := {writer.flag_of(own) or 'FALSE'};"
            yield f"{pad}{self._place(k, self.slots[k])} := {own};"
            if slot.length > 1:
                yield f"{pad}{self.oldest[k]} := ({self.oldest[k]} + 1) MOD {slot.length};"


def _holds_nan(program: Program) -> bool:
    """Return whether NaN is written in a program."""
    return any(isinstance(n, Number) and math.isnan(n.value) for e in expressions(program) for n in walk(e))
