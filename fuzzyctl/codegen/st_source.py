"""A unit as a FUNCTION_BLOCK of IEC 61131-3.

A function block rather than a function, for systems without a state too: its tables are set up once for each instance,
those of a function at each call.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from fuzzyctl.codegen.comments import argument_notes, result_notes, table_notes, value_notes
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.names import ST_RESERVED, Names
from fuzzyctl.codegen.simplify import functions, quotient, with_prefix
from fuzzyctl.codegen.st_guards import PARTIAL
from fuzzyctl.codegen.st_text import INDENT, STText
from fuzzyctl.codegen.unit import Unit, described, printable
from fuzzyctl.codegen.wrapping import broken, folded
from fuzzyctl.expr import Expr
from fuzzyctl.kernels.program.program import Refuse
from fuzzyctl.kernels.program.traversal import map_expressions


def block_name(unit: Unit) -> str:
    """Return the name of the function block, and of its file."""
    return Names(ST_RESERVED, fold=True).claim(unit.system.name)


def function_block(unit: Unit) -> str:
    """Return the text of NAME.st.

    Inputs are VAR_INPUT. Each output has a BOOL `NAME_valid` beside it: FALSE where an input is NaN or no rule gives a
    value; the output is 0 then. A state stands in the block: what is held, and the consequents of adaptive outputs,
    which change by one Euler step of `time_step` seconds after each evaluation (0: none).
    """
    return _Block(unit).text()


def _require_first_values(unit: Unit) -> None:
    """Refuse outputs that hold NaN at first: a declaration has no text for it."""
    held = unit.plan.initial_state[len(unit.plan.states) :]
    empty = [unit.plan.outputs[o].name for o, value in zip(unit.plan.held, held, strict=True) if math.isnan(value)]
    if empty:
        raise CodegenError(
            f"output '{empty[0]}' holds NaN at first, which Structured Text has no number for; write 'hold(VALUE)'"
        )


def comment(text: str) -> str:
    """Return one line as a comment that nothing in it ends or begins anew."""
    return f"(* {printable(text).replace('(*', '( *').replace('*)', '* )')} *)"


def comments(texts: Sequence[str]) -> list[str]:
    """Return lines as comments, long ones in several."""
    return [comment(line) for line in folded([printable(text) for text in texts])]


def constants(
    writer: STText, tables: Sequence[tuple[str, Sequence[float]]], notes: Mapping[str, Sequence[str]]
) -> Iterator[str]:
    """Yield the declarations of constant tables, each behind its notes."""
    if not tables:
        return
    yield "VAR CONSTANT"
    for name, values in tables:
        yield from (INDENT + line for line in comments(notes[name]))
        yield f"{INDENT}{name} : ARRAY[0..{len(values) - 1}] OF {writer.real} := ["
        texts = [writer.number(v).strip("()") for v in values]
        rows = [", ".join(texts[k : k + 8]) for k in range(0, len(texts), 8)]
        yield ",\n".join(INDENT * 2 + row for row in rows) + "];"
    yield "END_VAR"


def result(writer: STText, name: str, value: Expr, output: str, valid: str, depth: int) -> Iterator[str]:
    """Yield lines that compute a value and store it in an output, 0 where there is none."""
    pad = INDENT * depth
    yield from writer.assigned(name, value, depth)
    writer.reals.append(name)
    yield f"{pad}{output} := {name};"
    missing = writer.missing(name)
    yield f"{pad}{valid} := {'TRUE' if missing == 'FALSE' else f'NOT {missing}'};"
    if missing != "FALSE":
        yield from (f"{pad}IF {missing} THEN", f"{pad}{INDENT}{output} := {writer.number(0.0)};", f"{pad}END_IF;")


class _Block:
    def __init__(self, unit: Unit) -> None:
        self.unit, self.name = unit, block_name(unit)
        names = Names([*ST_RESERVED, self.name.lower(), "time_step", "refused", "valid", "adapted"], fold=True)
        self.inputs = [names.claim(i.name) for i in unit.plan.inputs]
        self.outputs = [names.claim(o.name) for o in unit.plan.outputs]
        self.valid = [names.claim(f"{o}_valid") for o in self.outputs]
        adaptive = [f"consequent_{k}" for k in range(len(unit.plan.states))]
        self.states = [names.claim(s) for s in (*adaptive, *(f"held_{self.outputs[o]}" for o in unit.plan.held))]
        self.rates = with_prefix(map_expressions(unit.rates, quotient), "R") if unit.rates is not None else None
        if self.rates is not None and any(isinstance(s, Refuse) for s in self.rates.body):
            raise CodegenError("rates that may be refused are not written in Structured Text")
        _require_first_values(unit)

    def text(self) -> str:
        arguments = dict(zip(self.unit.evaluation.arguments, self.inputs, strict=True))
        writer = self._writer(arguments, partial=bool(functions(self.unit.evaluation) & PARTIAL))
        body = list(self._evaluation(writer))
        if writer.undefined and not writer.partial:  # selections have to look for what has no value, too
            writer = self._writer(arguments, partial=True)
            body = list(self._evaluation(writer))
        # Rates take the inputs as they are.
        rates = STText(self.unit.precision, arguments, self.states, partial=True, infinite=set(arguments))
        adapted = list(self._adaptation(rates)) if self.rates is not None else []
        head = [comment(line) if line else "" for line in self._head(writer)]
        lines = [*head, f"FUNCTION_BLOCK {self.name}", *self._interface(writer)]
        lines += [*self._variables([writer, rates]), *self._constants(writer)]
        lines += ["", *body, *adapted, "END_FUNCTION_BLOCK"]
        return "\n".join(broken(lines, INDENT)) + "\n"

    def _writer(self, arguments: Mapping[str, str], *, partial: bool) -> STText:
        infinite = {a for a, i in zip(arguments, self.unit.plan.inputs, strict=True) if i.extrapolate}
        notes = {name: comments(own) for name, own in value_notes(self.unit).items()}
        return STText(self.unit.precision, arguments, self.states, partial=partial, infinite=infinite, notes=notes)

    def _head(self, writer: STText) -> list[str]:
        lines = [
            *described(self.unit),
            "",
            "Where an output is not valid, it is 0: an input is NaN, or no rule gives it a value.",
        ]
        if writer.partial:
            lines.append(
                "Nor is it where a function that it depends on has no value, such as the root of -1; functions are"
            )
            lines.append("called only where they have one, and a quotient by 0 counts as the largest number.")
        if writer.undefined:
            lines.append("Infinite inputs that are extrapolated may give a difference or a product without a value.")
        if self.unit.plan.states:
            lines.append("Adaptive consequents change by one Euler step of time_step seconds after each evaluation.")
        return lines

    def _interface(self, writer: STText) -> Iterator[str]:
        yield "VAR_INPUT"
        for i, note in zip(self.inputs, argument_notes(self.unit), strict=True):
            yield from (INDENT + line for line in comments([note]))
            yield f"{INDENT}{i} : {writer.real};"
        if self.rates is not None:
            yield f"{INDENT}time_step : {writer.real} := {writer.number(0.0)};"
        yield "END_VAR"
        yield "VAR_OUTPUT"
        for output, valid, note in zip(self.outputs, self.valid, result_notes(self.unit), strict=True):
            yield from (INDENT + line for line in comments([note]))
            yield from (f"{INDENT}{output} : {writer.real};", f"{INDENT}{valid} : BOOL;")
        yield "END_VAR"

    def _variables(self, writers: Sequence[STText]) -> Iterator[str]:
        yield "VAR"
        for state, value in zip(self.states, self.unit.plan.initial_state, strict=True):
            yield f"{INDENT}{state} : {writers[0].real} := {writers[0].number(value).strip('()')};"
        if self.unit.refusals:
            yield f"{INDENT}refused : BOOL;"
        for kind, names in (
            (writers[0].real, [n for w in writers for n in w.reals]),
            ("DINT", [n for w in writers for n in w.integers]),
            ("BOOL", [n for w in writers for n in w.flags]),
        ):
            yield from (f"{INDENT}{name} : {kind};" for name in dict.fromkeys(names))
        yield "END_VAR"

    def _constants(self, writer: STText) -> Iterator[str]:
        tables = [*self.unit.evaluation.tables, *(self.rates.tables if self.rates is not None else ())]
        notes = table_notes(self.unit, self.unit.evaluation)
        notes |= table_notes(self.unit, self.rates) if self.rates is not None else {}
        yield from constants(writer, tables, notes)

    def _numbers(self) -> str:
        # IEEE 754: NaN is the only number that does not equal itself.
        return " AND ".join(f"({i} = {i})" for i in self.inputs)

    def _evaluation(self, writer: STText) -> Iterator[str]:
        for output, valid in zip(self.outputs, self.valid, strict=True):
            yield from (f"{output} := {writer.number(0.0)};", f"{valid} := FALSE;")
        if self.unit.refusals:
            yield "refused := FALSE;"
        yield f"IF {self._numbers()} THEN"
        yield from writer.block(self.unit.evaluation.body, dict.fromkeys(self.unit.refusals, "refused := TRUE;"), 1)
        depth = 1
        if self.unit.refusals:
            yield f"{INDENT}IF NOT refused THEN"
            depth = 2
        pad = INDENT * depth
        for k, (output, value) in enumerate(zip(self.outputs, self.unit.evaluation.results, strict=True)):
            yield from result(writer, f"result{k}", value, output, self.valid[k], depth)
        for entry, o in enumerate(self.unit.plan.held, start=len(self.unit.plan.states)):
            yield f"{pad}IF {self.valid[o]} THEN"
            yield f"{pad}{INDENT}{self.states[entry]} := {self.outputs[o]};"
            yield f"{pad}END_IF;"
        if self.unit.refusals:
            yield f"{INDENT}END_IF;"
        yield "END_IF;"

    def _adaptation(self, writer: STText) -> Iterator[str]:
        assert self.rates is not None
        flat = self.unit.plan
        yield f"IF {self._numbers()} AND (time_step > {writer.number(0.0)}) THEN"
        yield from writer.block(self.rates.body, {}, 1)
        for k, (o, _) in enumerate(flat.states):
            output = flat.outputs[o]
            yield from writer.assigned(f"rate{k}", self.rates.results[k], 1)
            writer.reals.append(f"rate{k}")
            low, high = writer.number(output.lower), writer.number(output.upper)
            step = f"LIMIT({low}, ({self.states[k]} + (time_step * rate{k})), {high})"
            if f"rate{k}_no" in writer.flags:
                yield f"{INDENT}IF NOT rate{k}_no THEN"
                yield f"{INDENT * 2}{self.states[k]} := {step};"
                yield f"{INDENT}END_IF;"
            else:
                yield f"{INDENT}{self.states[k]} := {step};"
        yield "END_IF;"
