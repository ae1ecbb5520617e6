"""A unit as a FUNCTION_BLOCK of IEC 61131-3, whose variables keep the state.

A function block rather than a function, for systems without a state too: its tables are set up once for each instance,
those of a function at each call.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from fuzzyctl.codegen.c_layout import member_name
from fuzzyctl.codegen.comments import (
    argument_notes,
    described,
    number_notes,
    printable,
    result_notes,
    slot_notes,
    table_notes,
    value_notes,
)
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.names import ST_RESERVED, Names
from fuzzyctl.codegen.simplify import functions, quotient, with_prefix
from fuzzyctl.codegen.st_guards import PARTIAL
from fuzzyctl.codegen.st_text import INDENT, LARGEST, STText
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.codegen.wrapping import broken, folded
from fuzzyctl.expr import Expr, Name, Number, walk
from fuzzyctl.kernels.program.program import Program, Refuse
from fuzzyctl.kernels.program.traversal import expressions, map_expressions

#: The input that takes the time since the step before, and that of the steps of adaptive consequents.
TIME = "time_step"


def block_name(unit: Unit) -> str:
    """Return the name of the function block, and of its file."""
    return Names(ST_RESERVED, fold=True).claim(unit.block.name)


def function_block(unit: Unit) -> str:
    """Return the text of NAME.st.

    Inputs are VAR_INPUT, `time_step` last without a period. Each output has a BOOL `NAME_valid`:
    FALSE if an input is NaN (of a controller, not finite) or the output has no value; the output is 0 then. A
    state is in the block. Adaptive consequents change by one Euler step of `time_step` seconds after each
    evaluation (0: none).

    Args:
        unit: A controller is prepared with `guarded`.
    """
    return _Block(unit).text()


def comment(text: str) -> str:
    """Return one line as a comment, without sequences that end it or begin another."""
    return f"(* {printable(text).replace('(*', '( *').replace('*)', '* )')} *)"


def comments(texts: Sequence[str]) -> list[str]:
    """Return lines as comments, long ones in several."""
    return [comment(line) for line in folded([printable(text) for text in texts])]


class _Block:
    def __init__(self, unit: Unit) -> None:
        self.unit, self.name = unit, block_name(unit)
        words = [*ST_RESERVED, self.name.lower(), TIME, "refused", "valid", *([] if unit.is_step else ["adapted"])]
        names = Names(words, fold=True)
        self.arguments = [names.claim(i) for i in unit.inputs]
        self.arguments += [TIME] if unit.takes_time else []
        self.outputs = [names.claim(o) for o in unit.outputs]
        self.valid = [names.claim(f"{o}_valid") for o in self.outputs]
        self.numbers = [names.claim(member_name(n.name)) for n in unit.numbers]
        self.consequents = [names.claim(f"consequent_{k}") for k in range(len(unit.consequents))]
        self.slots = [names.claim(member_name(s.name)) for s in unit.slots]
        self.flags = [names.claim(f"{s}_no") for s in self.slots] if unit.is_step else []
        self.oldest = [
            names.claim(f"{n}_oldest") if s.length > 1 else "" for n, s in zip(self.slots, unit.slots, strict=True)
        ]
        #: Slots that may hold no value, from the first step on or later.
        self.missing = {k for k, s in enumerate(unit.slots) if math.isnan(s.start)}
        if not unit.is_step and self.missing:
            output = unit.outputs[unit.plan.held[min(self.missing)]]
            raise CodegenError(
                f"output '{output}' holds NaN at first, which Structured Text has no number for; write 'hold(VALUE)'"
            )
        self.rates = with_prefix(map_expressions(unit.rates, quotient), "R") if unit.rates is not None else None
        if self.rates is not None and any(isinstance(s, Refuse) for s in self.rates.body):
            raise CodegenError("rates that may be refused are not written in Structured Text")

    def text(self) -> str:
        unit = self.unit
        numbers = (n for e in expressions(unit.program) for n in walk(e) if isinstance(n, Number))
        partial = bool(functions(unit.program) & PARTIAL) or (
            unit.is_step and any(math.isnan(n.value) for n in numbers)
        )
        while True:
            before = (partial, len(self.missing))
            partial = partial or bool(self.missing)
            writer = self._writer(partial=partial)
            body = list(self._evaluation(writer))
            partial = partial or writer.undefined  # selections have to look for operands without a value, too
            if (partial, len(self.missing)) == before:
                break
        # Rates take the inputs as they are.
        infinite = set(unit.program.arguments[: len(self.arguments)])
        rates = STText(unit.precision, writer.names, partial=True, infinite=infinite)
        adapted = list(self._adaptation(rates, self.rates)) if self.rates is not None else []
        head = [comment(line) if line else "" for line in self._head(writer)]
        lines = [*head, f"FUNCTION_BLOCK {self.name}", *self._interface(writer), *self._variables([writer, rates])]
        lines += [*self._constants(writer), "", *body, *adapted, "END_FUNCTION_BLOCK"]
        return "\n".join(broken(lines, INDENT)) + "\n"

    def _place(self, k: int, name: str) -> str:
        """Return the text of an entry of a slot, the oldest of a delay."""
        return f"{name}[{self.oldest[k]}]" if self.oldest[k] else name

    def _writer(self, *, partial: bool) -> STText:
        arguments, unit = self.unit.program.arguments, self.unit
        slots = [self._place(k, name) for k, name in enumerate(self.slots)]
        names = dict(zip(arguments, [*self.arguments, *self.consequents, *slots, *self.numbers], strict=True))
        missing = {f"s{k}": self._place(k, self.flags[k]) for k in self.missing}
        extrapolated = [] if unit.is_step else [i.extrapolate for i in unit.plan.inputs]
        infinite = {name for name, is_open in zip(arguments, extrapolated, strict=False) if is_open}
        notes = {name: comments(note) for name, note in value_notes(unit).items()}
        return STText(unit.precision, names, partial=partial, infinite=infinite, notes=notes, absent=missing)

    def _head(self, writer: STText) -> Iterator[str]:
        yield from (*described(self.unit), "")
        if self.unit.is_step:
            yield "Where an output is not valid, it is 0: no step was made, or nothing gives it a value."
            positive = f" or {TIME} is not positive" if self.unit.takes_time else ""
            yield f"Where an input is NaN or infinite{positive}, the state stays as it is."
            if writer.partial:
                yield "Functions are called only where they have a value; a quotient by 0 counts as the largest number."
            return
        yield "Where an output is not valid, it is 0: an input is NaN, or no rule gives it a value."
        if writer.partial:
            yield "Nor is it where a function that it depends on has no value, such as the root of -1; functions are"
            yield "called only where they have one, and a quotient by 0 counts as the largest number."
        if writer.undefined:
            yield "Infinite inputs that are extrapolated may give a difference or a product without a value."
        if self.consequents:
            yield "Adaptive consequents change by one Euler step of time_step seconds after each evaluation."

    def _interface(self, writer: STText) -> Iterator[str]:
        yield "VAR_INPUT"
        for name, note in zip(self.arguments, argument_notes(self.unit), strict=True):
            yield from (INDENT + line for line in comments([note] if note else []))
            yield f"{INDENT}{name} : {writer.real};"
        for name, number, note in zip(self.numbers, self.unit.numbers, number_notes(self.unit), strict=True):
            yield from (INDENT + line for line in comments([note] if note else []))
            yield f"{INDENT}{name} : {writer.real} := {writer.number(number.start).strip('()')};"
        if self.rates is not None:
            yield f"{INDENT}{TIME} : {writer.real} := {writer.number(0.0)};"
        yield from ("END_VAR", "VAR_OUTPUT")
        for name, valid, note in zip(self.outputs, self.valid, result_notes(self.unit), strict=True):
            yield from (INDENT + line for line in comments([note] if note else []))
            yield from (f"{INDENT}{name} : {writer.real};", f"{INDENT}{valid} : BOOL;")
        yield "END_VAR"

    def _variables(self, writers: Sequence[STText]) -> Iterator[str]:
        real = writers[0].real
        yield "VAR"
        for name, start in zip(self.consequents, self.unit.consequents, strict=True):
            yield f"{INDENT}{name} : {real} := {writers[0].number(start).strip('()')};"
        for k, (slot, note) in enumerate(zip(self.unit.slots, slot_notes(self.unit), strict=True)):
            yield from (INDENT + line for line in comments([note] if self.unit.is_step else []))
            yield from (INDENT + line for line in self._slot(writers[0], k, slot.length))
        if self.unit.refusals:
            yield f"{INDENT}refused : BOOL;"
        for kind, names in (
            (real, [n for w in writers for n in w.reals]),
            ("DINT", [n for w in writers for n in w.integers]),
            ("BOOL", [n for w in writers for n in w.flags]),
        ):
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

    def _constants(self, writer: STText) -> Iterator[str]:
        """Yield the declarations of constant tables, each behind its notes."""
        programs = [self.unit.program, *([self.rates] if self.rates is not None else [])]
        if not any(program.tables for program in programs):
            return
        yield "VAR CONSTANT"
        for program in programs:
            notes = table_notes(self.unit, program)
            for name, values in program.tables:
                yield from (INDENT + line for line in comments(notes[name]))
                yield f"{INDENT}{name} : ARRAY[0..{len(values) - 1}] OF {writer.real} := ["
                texts = [writer.number(v).strip("()") for v in values]
                rows = [", ".join(texts[k : k + 8]) for k in range(0, len(texts), 8)]
                yield ",\n".join(INDENT * 2 + row for row in rows) + "];"
        yield "END_VAR"

    def _guard(self, writer: STText) -> str:
        if not self.unit.is_step:  # IEEE 754: NaN is the only number that does not equal itself
            return " AND ".join(f"({a} = {a})" for a in self.arguments)
        # False for NaN and for infinities.
        largest = writer.number(LARGEST[self.unit.precision])
        tests = [f"(ABS({a}) <= {largest})" for a in (*self.arguments, *self.numbers)]
        tests += [f"({TIME} > {writer.number(0.0)})"] if self.unit.takes_time else []
        return " AND ".join(tests) or "TRUE"

    def _evaluation(self, writer: STText) -> Iterator[str]:
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
            yield from self._result(writer, f"result{k}", value, output, self.valid[k], depth)
        yield from self._stores(writer, depth) if self.unit.is_step else self._holds(INDENT * depth)
        if self.unit.refusals:
            yield f"{INDENT}END_IF;"
        yield "END_IF;"

    @staticmethod
    def _result(writer: STText, name: str, value: Expr, output: str, valid: str, depth: int) -> Iterator[str]:
        """Yield lines that compute a value and store it in an output, 0 without a value."""
        pad = INDENT * depth
        yield from writer.assigned(name, value, depth)
        writer.reals.append(name)
        yield f"{pad}{output} := {name};"
        missing = writer.missing(name)
        yield f"{pad}{valid} := {'TRUE' if missing == 'FALSE' else f'NOT {missing}'};"
        if missing != "FALSE":
            yield from (f"{pad}IF {missing} THEN", f"{pad}{INDENT}{output} := {writer.number(0.0)};", f"{pad}END_IF;")

    def _stores(self, writer: STText, depth: int) -> Iterator[str]:
        """Yield lines that store the state; earlier lines have read it."""
        pad = INDENT * depth
        texts = []
        for k, value in enumerate(self.unit.taken):
            text = f"u{k}"
            if isinstance(value, Number) and math.isfinite(value.value):
                text = writer.number(value.value)
            elif isinstance(value, Name) and value.name in writer.reals:
                text = value.name
            else:
                yield from writer.assigned(text, value, depth)
                writer.reals.append(text)
            texts.append(text)
        for k, (text, slot) in enumerate(zip(texts, self.unit.slots, strict=True)):
            if writer.flag_of(text):
                self.missing.add(k)
            if k in self.missing:
                yield f"{pad}{self._place(k, self.flags[k])} := {writer.flag_of(text) or 'FALSE'};"
            yield f"{pad}{self._place(k, self.slots[k])} := {text};"
            if slot.length > 1:
                yield f"{pad}{self.oldest[k]} := ({self.oldest[k]} + 1) MOD {slot.length};"

    def _holds(self, pad: str) -> Iterator[str]:
        """Yield lines that keep the outputs of a system that hold their value."""
        for slot, o in zip(self.slots, self.unit.plan.held, strict=True):
            yield from (f"{pad}IF {self.valid[o]} THEN", f"{pad}{INDENT}{slot} := {self.outputs[o]};", f"{pad}END_IF;")

    def _adaptation(self, writer: STText, rates: Program) -> Iterator[str]:
        yield f"IF {self._guard(writer)} AND ({TIME} > {writer.number(0.0)}) THEN"
        yield from writer.block(rates.body, {}, 1)
        for k, (o, _) in enumerate(self.unit.plan.states):
            output, state = self.unit.plan.outputs[o], self.consequents[k]
            yield from writer.assigned(f"rate{k}", rates.results[k], 1)
            writer.reals.append(f"rate{k}")
            low, high = writer.number(output.lower), writer.number(output.upper)
            step = f"{state} := LIMIT({low}, ({state} + ({TIME} * rate{k})), {high});"
            if f"rate{k}_no" in writer.flags:
                yield from (f"{INDENT}IF NOT rate{k}_no THEN", f"{INDENT * 2}{step}", f"{INDENT}END_IF;")
            else:
                yield f"{INDENT}{step}"
        yield "END_IF;"
