"""Fixed-point C99: integers only, no floating point anywhere; of systems, and what those of controllers share."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.c_source import comment, header_text, period, struct
from fuzzyctl.codegen.c_text import INDENT, wrapped
from fuzzyctl.codegen.comments import described
from fuzzyctl.codegen.fixed.fixed_format import Axis, Entries, Format
from fuzzyctl.codegen.fixed.fixed_system import Fixed, strides_of
from fuzzyctl.codegen.selftests import call_lines
from fuzzyctl.codegen.table import at_most
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.codegen.wrapping import folded

#: Random vectors of the self-test.
RANDOM = 200


def functions(unit: Unit, fixed: Fixed) -> list[str]:
    """Return the lines of a system as static functions, for a source that calls it; see `head` for how."""
    text = SystemText(unit, fixed)
    first, *rest = text.evaluation()
    helpers = [*text.helpers(), ""] if fixed.axes else []
    return [*text.types(), *helpers, f"static {first}", *rest, ""]


class FixedText:
    """Text that systems and steps share in fixed point.

    Args:
        unit: The unit to write.
        form: The format of inputs and outputs.
        errors: Proved bound of each output.
    """

    def __init__(self, unit: Unit, form: Format, errors: Sequence[float]) -> None:
        self.unit, self.form, self.errors, self.layout = unit, form, errors, CLayout(unit, form.bits)

    def header_of(self, about: Sequence[str], declared: Sequence[str], included: Sequence[str]) -> str:
        """Return the text of NAME.h."""
        lines = [f"// Bits behind the point of inputs and outputs: {self.form}."]
        lines += [f"#define {self.layout.name.upper()}_FRACTION {self.form.fraction}", "", *period(self.layout)]
        return header_text(self.layout.name, about, [*lines, *declared], ["stdint", *included])

    def promises(self, against: str, exact: str) -> Iterator[str]:
        """Yield the lines of the header about errors.

        Args:
            against: The proved bound, and the reference of the error.
            exact: The reference of an output.
        """
        one = f"2^{self.form.fraction}"
        yield f"Fixed point {self.form}: an integer X stands for X / {one}; integer arithmetic only."
        yield f"Proved {against}:"
        for name, error in zip(self.unit.outputs, self.errors, strict=True):
            last = f"{at_most(error * 2**self.form.fraction, 4)} / {one}"
            yield f"  |{name} - {exact.format(name)}| <= {at_most(error, 6)}, that is {last}"

    def selftest_head(self, about: Sequence[str], included: Sequence[str], count: int) -> list[str]:
        """Return the comment and the headers of a self-test."""
        lines = [*comment(about), f'#include "{self.layout.name}.h"', ""]
        return [*lines, *(f"#include <{h}.h>" for h in included), "", f"#define VECTORS {count}", ""]

    def table(self, what: str, rows: Sequence[Sequence[int]]) -> Iterator[str]:
        """Yield the lines of a table of vectors."""
        yield f"static const {self.layout.real} {what}[VECTORS][{len(rows[0])}] = {{"
        yield from wrapped([f"{{{', '.join(map(self._word, row))}}}," for row in rows], INDENT, between="")
        yield "};"

    def _word(self, value: int) -> str:
        return f"(-{-value - 1} - 1)" if value == -self.form.most - 1 else str(value)

    def turn(self) -> Iterator[str]:
        """Yield lines that evaluate vector `v` into `found`."""
        inputs = [f"inputs[v][{k}]" for k in range(len(self.layout.arguments))]
        yield from call_lines(self.layout, self.layout.call("&state", "", inputs))

    def report(self) -> Iterator[str]:
        """Yield the lines that end the self-test."""
        yield f'{INDENT}(void)printf("{self.layout.name}: %d vectors, %d failures\\n", VECTORS, failures);'
        yield f"{INDENT}return (failures == 0) ? 0 : 1;\n}}"


class SystemText(FixedText):
    """A system that interpolates.

    Args:
        unit: The system.
        fixed: Its integers.
    """

    def __init__(self, unit: Unit, fixed: Fixed) -> None:
        super().__init__(unit, fixed.format, fixed.errors)
        self.fixed, self.word = fixed, self.layout.real
        self.signed, self.wide = f"int{fixed.format.wide}_t", f"uint{fixed.format.wide}_t"

    def number(self, value: int) -> str:
        """Return an unsigned literal."""
        return f"UINT{self.fixed.format.wide}_C({value})"

    def whole(self, value: int) -> str:
        """Return a signed literal; the least one of a type has none."""
        bits = self.fixed.format.wide
        return f"INT{bits}_C({value})" if value >= 0 else f"(-INT{bits}_C({-value}))"

    def header(self) -> str:
        """Return the text of NAME.h."""
        about = [*described(self._bounded), "", *folded([*self._promises()])]
        return self.header_of(about, [*self.types(), f"{self.layout.evaluation};", ""], [])

    def types(self) -> list[str]:
        """Return the lines of the type of several outputs."""
        members = [(f"{self.word} {o};", "") for o in self.layout.outputs]
        return [*struct(f"{self.layout.name}_outputs", members)] if self.layout.many else []

    @property
    def _bounded(self) -> Unit:
        """The unit with the bounds of the integers in the place of those of the system."""
        one = 1 << self.fixed.format.fraction
        bounds = dict(self.unit.bounds)
        for output, entries in zip(self.unit.plan.outputs, self.fixed.outputs, strict=True):
            lo, hi = entries.ends
            bounds[output.name] = replace(bounds[output.name], lo=lo / one, hi=hi / one)
        return replace(self.unit, bounds=bounds)

    def _promises(self) -> Iterator[str]:
        form = self.form
        yield from self.promises("for every input of the type, against the system in exact arithmetic", "exact {}")
        yield "The bounds of the outputs above are those of the integers."
        outside = [i.name for i in self.unit.plan.inputs if i.lower < form.lower or i.upper > form.upper]
        if outside:
            ends = f"[{form.lower!r}, {form.upper!r}]"
            yield f"Hold {', '.join(outside)} within {ends} before it is converted; nothing changes beyond."

    def source(self) -> str:
        """Return the text of NAME.c."""
        name = self.layout.name
        lines = [*comment([f"{name}.c: see {name}.h."]), f'#include "{name}.h"', "", "#include <stddef.h>", ""]
        if self.fixed.axes:
            lines += [*self.helpers(), ""]
        return "\n".join([*lines, *self.evaluation()]) + "\n"

    def helpers(self) -> Iterator[str]:
        """Yield the functions that find cells and interpolate."""
        name, wide, p = self.layout.name, self.wide, self.fixed.share_bits
        yield "// Place of an input behind the first knot, inputs outside the knots held."
        bounds = f"{self.signed} least, {self.signed} most"
        yield f"static {wide} {name}_place({self.signed} x, {bounds}, unsigned int shift)\n{{"
        yield f"{INDENT}const {self.signed} held = (x < least) ? least : ((x > most) ? most : x);"
        yield f"{INDENT}return (({wide})(held - least)) << shift;\n}}\n"
        yield "// Cell of a place: the last knot at or below it that begins one."
        yield f"static size_t {name}_cell(const {wide} *knots, size_t cells, {wide} place)\n{{"
        yield f"{INDENT}size_t first = 0U;\n{INDENT}size_t beyond = cells;"
        yield f"{INDENT}while ((beyond - first) > 1U) {{"
        yield f"{INDENT * 2}const size_t middle = first + ((beyond - first) / 2U);"
        yield f"{INDENT * 2}if (knots[middle] <= place) {{\n{INDENT * 3}first = middle;"
        yield f"{INDENT * 2}}} else {{\n{INDENT * 3}beyond = middle;\n{INDENT * 2}}}\n{INDENT}}}"
        yield f"{INDENT}return first;\n}}\n"
        yield f"// Share of the way from one knot to the next, in 2^-{p}."
        yield f"static {wide} {name}_share({wide} place, {wide} left, {wide} right)\n{{"
        yield f"{INDENT}const {wide} width = right - left;"
        inside = "((place >= right) ? width : (place - left))"
        yield f"{INDENT}const {wide} beyond = (place <= left) ? {self.number(0)} : {inside};"
        yield f"{INDENT}return ((beyond << {p}U) + (width / 2U)) / width;\n}}\n"
        yield f"static {wide} {name}_between({wide} a, {wide} b, {wide} share)\n{{"
        yield f"{INDENT}const {wide} weighted = (a * ({self.number(1 << p)} - share)) + (b * share);"
        yield f"{INDENT}return (weighted + {self.number(1 << (p - 1))}) >> {p}U;\n}}"

    def evaluation(self) -> Iterator[str]:
        """Yield the lines of the function."""
        axes = self.fixed.axes
        yield f"{self.layout.evaluation}\n{{"
        for d, axis in enumerate(axes):
            yield f"{INDENT}static const {self.wide} K{d}[{len(axis.knots)}] = {{"
            yield from wrapped([f"{k}U" for k in axis.knots], INDENT * 2)
            yield f"{INDENT}}};"
        for o, entries in enumerate(self.fixed.outputs):
            yield f"{INDENT}static const {self._entry_type(entries)} T{o}[{len(entries.values)}] = {{"
            yield from wrapped([f"{v}U" for v in entries.values], INDENT * 2)
            yield f"{INDENT}}};"
        used = {a.input for a in axes}
        yield from (f"{INDENT}(void){x};" for i, x in enumerate(self.layout.arguments) if i not in used)
        for d, axis in enumerate(axes):
            yield from self._located(d, axis)
        if axes:
            parts = " + ".join(f"({s}U * k{d})" if s > 1 else f"k{d}" for d, s in enumerate(strides_of(axes)))
            yield f"{INDENT}const size_t cell = {parts};"
        for o, entries in enumerate(self.fixed.outputs):
            yield f"{INDENT}const {self.wide} v{o} = {self._interpolated(o)};"
            rounded = (
                f"(v{o} + {self.number(1 << (entries.guard - 1))}) >> {entries.guard}U" if entries.guard else f"v{o}"
            )
            value = f"({self.word})({self.whole(entries.base)} + ({self.signed})({rounded}))"
            yield (
                f"{INDENT}outputs->{self.layout.outputs[o]} = {value};"
                if self.layout.many
                else f"{INDENT}return {value};"
            )
        yield "}"

    @staticmethod
    def _entry_type(entries: Entries) -> str:
        bits = max(v.bit_length() for v in entries.values)
        return f"uint{next(b for b in (8, 16, 32, 64) if bits <= b)}_t"

    def _located(self, d: int, axis: Axis) -> Iterator[str]:
        name, x = self.layout.name, self.layout.arguments[axis.input]
        ends = f"{self.whole(axis.least)}, {self.whole(axis.most)}, {axis.shift}U"
        yield f"{INDENT}const {self.wide} u{d} = {name}_place(({self.signed}){x}, {ends});"
        yield f"{INDENT}const size_t k{d} = {name}_cell(K{d}, {len(axis.knots) - 1}U, u{d});"
        yield f"{INDENT}const {self.wide} s{d} = {name}_share(u{d}, K{d}[k{d}], K{d}[k{d} + 1U]);"

    def _interpolated(self, o: int) -> str:
        axes = self.fixed.axes
        if not axes:
            return f"({self.wide})T{o}[0]"
        steps = [sum(s) for s in product(*((0, s) for s in strides_of(axes)))]
        items = [f"T{o}[cell + {s}U]" if s else f"T{o}[cell]" for s in steps]
        for d in reversed(range(len(axes))):
            pairs = zip(items[::2], items[1::2], strict=True)
            items = [f"{self.layout.name}_between({a}, {b}, s{d})" for a, b in pairs]
        return items[0]

    def selftest(self) -> str:
        """Return a program that compares every output with the integer that is expected, exactly."""
        name, points = self.layout.name, self._points()
        about = (
            f"Self-test of {name}: compile with {name}.c and run on the target; exits with 0 if every output is exact."
        )
        lines = self.selftest_head([about], ["stddef", "stdio"], len(points))
        lines += [*self.table("inputs", points), *self.table("expected", [self.fixed.evaluate(p) for p in points])]
        return "\n".join([*lines, "", *self._main()]) + "\n"

    def _points(self) -> list[tuple[int, ...]]:
        """Return ends of the type, places around the knots, and random inputs."""
        form, rng = self.fixed.format, random.Random(1)
        least, most = -form.most - 1, form.most
        axes = {a.input: a for a in self.fixed.axes}
        near: list[list[int]] = []
        for i in range(len(self.layout.arguments)):
            numbers = {least, most, 0}
            if i in axes:
                knots = [axes[i].least + (k >> axes[i].shift) for k in axes[i].knots]
                numbers |= {min(max(k + s, least), most) for k in knots for s in (-1, 0, 1)}
            near.append(sorted(numbers))
        chosen = [tuple(rng.choice(numbers) for numbers in near) for _ in range(RANDOM)]
        inside = [
            tuple(rng.randint(axes[i].least, axes[i].most) if i in axes else 0 for i in range(len(near)))
            for _ in range(RANDOM)
        ]
        return list(dict.fromkeys([tuple([least] * len(near)), tuple([most] * len(near)), *chosen, *inside]))

    def _main(self) -> Iterator[str]:
        name, layout = self.layout.name, self.layout
        yield f"int main(void)\n{{\n{INDENT}int failures = 0;\n{INDENT}long worst = 0;"
        yield f"{INDENT}for (size_t v = 0U; v < (size_t)VECTORS; ++v) {{"
        yield from (INDENT * 2 + line for line in self.turn())
        yield f"{INDENT * 2}for (size_t k = 0U; k < {len(layout.outputs)}U; ++k) {{"
        yield f"{INDENT * 3}const long off = (long)found[k] - (long)expected[v][k];"
        yield f"{INDENT * 3}const long size = (off < 0) ? -off : off;"
        yield f"{INDENT * 3}worst = (size > worst) ? size : worst;"
        yield f"{INDENT * 3}failures += (off == 0) ? 0 : 1;\n{INDENT * 2}}}\n{INDENT}}}"
        yield f'{INDENT}(void)printf("{name}: worst error %ld units in the last place\\n", worst);'
        yield from self.report()
