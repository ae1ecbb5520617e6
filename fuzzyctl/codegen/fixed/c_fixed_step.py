"""A fixed-point step as C99: integers only, without heap and without globals."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Final

from fuzzyctl.codegen import c_source
from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.c_source import as_comments, comment
from fuzzyctl.codegen.c_text import INDENT
from fuzzyctl.codegen.comments import described, printable, result_notes
from fuzzyctl.codegen.fixed.c_fixed_system import FixedText, SystemText, functions
from fuzzyctl.codegen.fixed.fixed_program import Operation, Operator
from fuzzyctl.codegen.fixed.fixed_step import FixedStep
from fuzzyctl.codegen.fixed.fixed_system import Fixed
from fuzzyctl.codegen.names import C_FUNCTION_RESERVED, Names
from fuzzyctl.codegen.sequence import sequence_of_points
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.codegen.wrapping import broken, folded
from fuzzyctl.kernels.kernel import Kernel
from fuzzyctl.kernels.step_form import StepForm

#: Steps of the self-test.
STEPS: Final = 200

_HELPERS: Final = (
    """static int32_t {name}_rounded(int64_t x, unsigned int shift)
{{
    // Unsigned and moved up by 2^63, since C leaves open how negative numbers are shifted.
    const uint64_t raised = ((uint64_t)x + (UINT64_C(1) << (shift - 1U))) + (UINT64_C(1) << 63U);
    return (int32_t)((int64_t)(raised >> shift) - (int64_t)(UINT64_C(1) << (63U - shift)));
}}
""",
    """static int32_t {name}_within(int64_t x, int64_t least, int64_t most)
{{
    return (int32_t)((x < least) ? least : ((x > most) ? most : x));
}}
""",
)


def files(unit: Unit, fixed: Fixed | FixedStep) -> dict[str, str]:
    """Return header, source and self-test of a block by the names of their files."""
    text = _StepText(fixed) if isinstance(fixed, FixedStep) else SystemText(unit, fixed)
    name = text.layout.name
    return {f"{name}.h": text.header(), f"{name}.c": text.source(), f"{name}_selftest.c": text.selftest()}


def literal(value: int) -> str:
    """Return a signed literal of 64 bits."""
    return f"INT64_C({value})" if value >= 0 else f"(-INT64_C({-value}))"


class _StepText(FixedText):
    def __init__(self, fixed: FixedStep) -> None:
        super().__init__(fixed.unit, fixed.form, fixed.errors)
        self.fixed, self.items, self.formats = fixed, fixed.operations.items, fixed.formats
        names = Names([*C_FUNCTION_RESERVED, *(f"{self.layout.name}_{suffix}" for suffix in ("step", "init", "state"))])
        self.read = self._read()
        #: The systems that are called, under unique names, by number.
        self.systems = {}
        for k in sorted({self.items[k].system for k in self.read if self.items[k].kind == "system"}):
            unit = fixed.systems[k].unit
            name = names.claim(f"{self.layout.name}_{unit.system.name}")
            self.systems[k] = dataclasses.replace(unit, block=dataclasses.replace(unit.system, name=name))

    # The header.

    def header(self) -> str:
        """Return the text of NAME.h."""
        about = [*described(self.unit, "held within their ranges"), "", *folded(self._promises())]
        declared = [*self._types(), *broken(c_source.prototypes(self.layout), INDENT)]
        return self.header_of(about, declared, ["stddef"] if any(k for _, k in self.layout.members) else [])

    def _promises(self) -> list[str]:
        against = "for every sequence of inputs and at every step, against double precision"
        lines, one = [*self.promises(against, "{} in double precision")], 1 << self.form.fraction
        for signal, (least, most) in zip(self.unit.controller.inputs, self.fixed.inputs, strict=True):
            lines.append(f"{signal.name} counts as {least / one!r} below it, and as {most / one!r} above.")
        return [printable(line) for line in lines]

    def _types(self) -> Iterator[str]:
        layout, unit = self.layout, self.unit
        if layout.many:
            members = [f"{layout.real} {o};" for o in layout.outputs]
            yield from c_source.struct(f"{layout.name}_outputs", zip(members, result_notes(unit), strict=True))
        if layout.members:
            slots = zip(unit.slots, self.formats.slots, strict=True)
            notes = [f"{slot.name}, {bits} bits behind the point" for slot, bits in slots]
            yield from c_source.struct(f"{layout.name}_state", c_source.state_members(layout, "int32_t", notes))

    # The source.

    def source(self) -> str:
        """Return the text of NAME.c."""
        name = self.layout.name
        step = list(self._step())
        lines = [*comment([f"{name}.c: see {name}.h."]), f'#include "{name}.h"', ""]
        lines += ["#include <stdbool.h>", "#include <stddef.h>", "#include <stdint.h>", ""]
        for k, system in self.systems.items():
            lines += functions(system, self.fixed.systems[k].fixed)
        used = "\n".join(step)
        lines += [
            h.format(name=name)
            for h, what in zip(_HELPERS, ("rounded", "within"), strict=True)
            if f"{name}_{what}(" in used
        ]
        lines += [*(self._init() if self.layout.members else ()), *step]
        return "\n".join(broken(lines, INDENT)) + "\n"

    def _init(self) -> Iterator[str]:
        slots = zip(self.unit.slots, self.formats.slots, strict=True)
        starts = [f"(int32_t){literal(round(slot.start * 2.0**bits))}" for slot, bits in slots]
        yield from (*c_source.init(self.layout, starts), "")

    def _step(self) -> Iterator[str]:
        layout, read = self.layout, self.read
        yield f"{layout.evaluation}\n{{"
        for k, item in enumerate(self.items):
            if item.kind == "input" and k not in read:
                yield f"{INDENT}(void){layout.arguments[item.place]};"
            elif k in read and item.kind not in ("output", "store"):
                name = self.unit.values.get(self.fixed.operations.names.get(k, ""), "")
                yield from (INDENT + line for line in as_comments({"": [name] if name else []})[""])
                yield from self._assigned(k, item)
        for k in (*self.fixed.operations.outputs, *self.fixed.operations.stores):
            yield f"{INDENT}const int32_t v{k} = {self._value(k, self.items[k])};"
        stores = zip(self.fixed.operations.stores, layout.slots, layout.members, self.unit.slots, strict=True)
        for k, place, (_, oldest), slot in stores:
            yield f"{INDENT}{place} = v{k};"
            yield from (INDENT + line for line in c_source.next_oldest(oldest, slot.length))
        for k, name in zip(self.fixed.operations.outputs, layout.outputs, strict=True):
            yield f"{INDENT}{f'outputs->{name} =' if layout.many else 'return'} ({layout.real})v{k};"
        yield "}"

    def _read(self) -> set[int]:
        """Return the operations that an output or a slot depends on."""
        results = {*self.fixed.operations.outputs, *self.fixed.operations.stores}
        for k in range(len(self.items) - 1, -1, -1):
            if k in results:
                results.update(self.items[k].operands)
        return results

    def _assigned(self, k: int, item: Operation) -> Iterator[str]:
        if item.is_condition:
            yield f"{INDENT}const bool v{k} = {self._condition(item)};"
            return
        if item.kind == "system":
            callee = CLayout(self.systems[item.system])
            arguments = ", ".join(f"v{p}" for p in item.operands)
            if callee.many:
                yield f"{INDENT}{callee.name}_outputs o{k};"
                yield f"{INDENT}{callee.name}({arguments}, &o{k});"
                yield f"{INDENT}const int32_t v{k} = o{k}.{callee.outputs[item.place]};"
                return
            yield f"{INDENT}const int32_t v{k} = {callee.name}({arguments});"
            return
        yield f"{INDENT}const int32_t v{k} = {self._value(k, item)};"

    def _aligned(self, position: int, fraction: int) -> str:
        """Return a value as an integer of 64 bits with more bits behind the point."""
        shift = fraction - self.formats.fractions[position]
        return f"((int64_t)v{position} * {literal(1 << shift)})" if shift else f"(int64_t)v{position}"

    def _moved(self, text: str, fraction: int, wanted: int) -> str:
        """Return an integer of 32 bits from one of 64 bits with as many bits behind the point, or more."""
        return (
            f"{self.layout.name}_rounded({text}, {fraction - wanted}U)" if fraction > wanted else f"(int32_t)({text})"
        )

    def _converted(self, position: int, wanted: int) -> str:
        """Return a value with other bits behind the point."""
        fraction = self.formats.fractions[position]
        return (
            f"v{position}"
            if fraction == wanted
            else self._moved(self._aligned(position, max(fraction, wanted)), max(fraction, wanted), wanted)
        )

    def _value(self, k: int, item: Operation) -> str:
        bits, fractions = self.formats.fractions[k], [self.formats.fractions[p] for p in item.operands]
        match item.kind:
            case "input":
                least, most = self.fixed.inputs[item.place]
                x = f"(int64_t){self.layout.arguments[item.place]}"
                return f"{self.layout.name}_within({x}, {literal(least)}, {literal(most)})"
            case "slot":
                return self.layout.slots[item.place]
            case "constant":
                return f"(int32_t){literal(round(item.factor * (1 << bits)))}"
            case "scale":
                factor, fraction = self.formats.factors[k]
                return self._moved(f"(int64_t)v{item.operands[0]} * {literal(factor)}", fractions[0] + fraction, bits)
            case "*":
                a, b = item.operands
                return self._moved(f"(int64_t)v{a} * (int64_t)v{b}", sum(fractions), bits)
            case "where":
                condition, a, b = item.operands
                return f"v{condition} ? {self._converted(a, bits)} : {self._converted(b, bits)}"
            case "argument" | "output":
                form = self.form if item.kind == "output" else self.fixed.systems[item.system].fixed.format
                x = self._aligned(item.operands[0], max(bits, fractions[0]))
                x = self._moved(x, fractions[0], bits) if fractions[0] > bits else x
                return f"{self.layout.name}_within({x}, {literal(-form.most - 1)}, {literal(form.most)})"
            case "store":
                return self._converted(item.operands[0], bits)
        fraction = max(fractions)
        texts = [self._aligned(p, fraction) for p in item.operands]
        return self._moved(_combined(item.kind, texts), fraction, bits)

    def _condition(self, item: Operation) -> str:
        match item.kind:
            case "compare":
                fraction = max(self.formats.fractions[p] for p in item.operands)
                return f" {item.op} ".join(self._aligned(p, fraction) for p in item.operands)
            case "compared":
                (x,) = item.operands
                op, bound = self._threshold(item.op, item, x)
                return f"(int64_t)v{x} {op} {literal(bound)}"
            case "not":
                return f"!v{item.operands[0]}"
        return f" {'&&' if item.kind == 'and' else '||'} ".join(f"v{p}" for p in item.operands)

    def _threshold(self, op: Operator, item: Operation, x: int) -> tuple[Operator, int]:
        """Return a comparison with an integer that holds where that with the number does."""
        scaled = item.factor * (1 << self.formats.fractions[x])
        nowhere = 1 << 40
        match op:
            case "<" | ">=":
                bound = math.ceil(scaled)
            case ">" | "<=":
                bound = math.floor(scaled)
            case _:
                bound = int(scaled) if scaled.denominator == 1 else nowhere
        return op, max(-nowhere, min(bound, nowhere))

    # The self-test.

    def selftest(self) -> str:
        """Return a program that makes the steps of a sequence and compares them with the proved bounds."""
        name, (points, expected) = self.layout.name, self._sequence()
        about = (
            f"Self-test of {name}: compile with {name}.c and run on the target; exits with 0 if every output lies where"
        )
        about_all = [about, "it is proved to lie: around that of double precision."]
        lines = self.selftest_head(about_all, ["stddef", "stdint", "stdio"], len(points))
        lines += self.table("inputs", points) if points[0] else []
        for which, what in enumerate(("least", "most")):
            lines += self.table(what, [[ends[which] for ends in row] for row in expected])
        return "\n".join([*lines, "", *self._main()]) + "\n"

    def _sequence(self) -> tuple[list[list[int]], list[list[tuple[int, int]]]]:
        """Return the inputs of a sequence, and between which integers the outputs lie."""
        form, step = self.form, Kernel(StepForm(self.unit.equations), "python")
        one, state = 1 << form.fraction, step.start()
        points, expected = [], []
        for point in sequence_of_points(self.unit, self.fixed.inputs, STEPS):
            outputs, state = step(*(x / one for x in point), state)
            values = (outputs,) if len(step.output_names) == 1 else outputs
            rows = []
            for value, error in zip(values, self.fixed.errors, strict=True):
                low, high = math.ceil((value - error) * one), math.floor((value + error) * one)
                rows.append((max(low, -form.most - 1), min(high, form.most)))
            points.append(point)
            expected.append(rows)
        return points, expected

    def _main(self) -> Iterator[str]:
        pad, layout, name = INDENT, self.layout, self.layout.name
        yield f"int main(void)\n{{\n{pad}int failures = 0;"
        # The second time shows that the state begins anew.
        yield f"{pad}for (size_t turn = 0U; turn < 2U; ++turn) {{"
        if layout.members:
            yield from (f"{pad * 2}{name}_state state;", f"{pad * 2}{name}_init(&state);")
        yield f"{pad * 2}for (size_t v = 0U; v < (size_t)VECTORS; ++v) {{"
        yield from (pad * 3 + line for line in self.turn())
        yield f"{pad * 3}for (size_t k = 0U; k < {len(layout.outputs)}U; ++k) {{"
        yield f"{pad * 4}failures += ((found[k] >= least[v][k]) && (found[k] <= most[v][k])) ? 0 : 1;"
        yield from (f"{pad * 3}}}", f"{pad * 2}}}", f"{pad}}}", *self.report())


def _combined(kind: str, texts: list[str]) -> str:
    """Return a sum, difference, minimum, maximum or magnitude of integers of 64 bits."""
    match kind:
        case "min" | "max":
            a, b = texts
            return f"({a} {'<' if kind == 'min' else '>'} {b}) ? {a} : {b}"
        case "abs":
            (x,) = texts
            return f"({x} < 0) ? (-{x}) : {x}"
    return f" {kind} ".join(texts)
