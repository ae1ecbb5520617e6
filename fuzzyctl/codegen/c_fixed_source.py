"""Fixed-point C99: integers only, no floating point anywhere."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import replace
from itertools import product

from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.c_source import comment
from fuzzyctl.codegen.c_text import INDENT, wrapped
from fuzzyctl.codegen.comments import described
from fuzzyctl.codegen.fixed import Fixed, strides_of
from fuzzyctl.codegen.fixed_format import Axis, Entries
from fuzzyctl.codegen.rounding_text import at_most
from fuzzyctl.codegen.unit import Unit

#: Random vectors of the self-test.
RANDOM = 200


def files(unit: Unit, fixed: Fixed) -> dict[str, str]:
    """Return header, source and self-test by the names of their files."""
    text = _FixedText(unit, fixed)
    name = text.layout.name
    return {f"{name}.h": text.header(), f"{name}.c": text.source(), f"{name}_selftest.c": text.selftest()}


def functions(unit: Unit, fixed: Fixed) -> list[str]:
    """Return the lines of a system as static functions, for a source that calls it; see `head` for how."""
    text = _FixedText(unit, fixed)
    first, *rest = text._evaluation()
    types = [*text.types(), ""] if text.layout.many else []
    helpers = [*text._helpers(), ""] if fixed.axes else []
    return [*types, *helpers, f"static {first}", *rest, ""]


class _FixedText:
    def __init__(self, unit: Unit, fixed: Fixed) -> None:
        self.unit, self.fixed, self.layout = unit, fixed, CLayout(unit)
        self.word = f"int{fixed.format.bits}_t"
        self.signed, self.wide = f"int{fixed.format.wide}_t", f"uint{fixed.format.wide}_t"

    def number(self, value: int) -> str:
        """Return an unsigned literal."""
        return f"UINT{self.fixed.format.wide}_C({value})"

    def whole(self, value: int) -> str:
        """Return a signed literal; the least one of a type has none."""
        bits = self.fixed.format.wide
        return f"INT{bits}_C({value})" if value >= 0 else f"(-INT{bits}_C({-value}))"

    @property
    def head(self) -> str:
        parameters = [f"{self.word} {i}" for i in self.layout.arguments]
        if self.layout.many:
            return f"void {self.layout.name}({', '.join([*parameters, f'{self.layout.name}_outputs *outputs'])})"
        return f"{self.word} {self.layout.name}({', '.join(parameters)})"

    def header(self) -> str:
        """Return the text of NAME.h."""
        name, form = self.layout.name, self.fixed.format
        guard = f"{name.upper()}_H"
        lines = comment([*described(self._bounded), "", *self._promises()])
        lines += [f"#ifndef {guard}", f"#define {guard}", ""]
        lines += ["#include <stdint.h>", "", "#ifdef __cplusplus", 'extern "C" {', "#endif", ""]
        lines += [
            f"// Bits behind the point of inputs and outputs: {form}.",
            f"#define {name.upper()}_FRACTION {form.fraction}",
        ]
        if self.layout.many:
            lines += ["", *self.types()]
        lines += ["", f"{self.head};", "", "#ifdef __cplusplus", "}", "#endif", "", f"#endif // {guard}"]
        return "\n".join(lines) + "\n"

    def types(self) -> list[str]:
        """Return the lines of the type of several outputs."""
        members = [f"{INDENT}{self.word} {o};" for o in self.layout.outputs]
        return ["typedef struct {", *members, f"}} {self.layout.name}_outputs;"]

    @property
    def _bounded(self) -> Unit:
        """The unit with the bounds of the integers in the place of those of the system."""
        one = 1 << self.fixed.format.fraction
        bounds = dict(self.unit.bounds)
        for output, entries in zip(self.unit.plan.outputs, self.fixed.outputs, strict=True):
            lo, hi = entries.ends
            bounds[output.name] = replace(bounds[output.name], lo=lo / one, hi=hi / one)
        return replace(self.unit, bounds=bounds)

    def _promises(self) -> list[str]:
        form = self.fixed.format
        lines = [f"Fixed point {form}: an integer X stands for X / 2^{form.fraction}; integer arithmetic only."]
        lines.append("Proved for every input of the type, against the system in exact arithmetic:")
        for o, error in zip(self.unit.plan.outputs, self.fixed.errors, strict=True):
            last = f"{at_most(error * 2**form.fraction, 4)} / 2^{form.fraction}"
            lines.append(f"  |{o.name} - exact {o.name}| <= {at_most(error, 6)}, that is {last}")
        lines.append("The bounds of the outputs above are those of the integers.")
        outside = [i.name for i in self.unit.plan.inputs if i.lower < form.lower or i.upper > form.upper]
        if outside:
            ends = f"[{form.lower!r}, {form.upper!r}]"
            lines.append(f"Hold {', '.join(outside)} within {ends} before it is converted; nothing changes beyond.")
        return lines

    def source(self) -> str:
        """Return the text of NAME.c."""
        name = self.layout.name
        lines = [*comment([f"{name}.c: see {name}.h."]), f'#include "{name}.h"', "", "#include <stddef.h>", ""]
        if self.fixed.axes:
            lines += [*self._helpers(), ""]
        return "\n".join([*lines, *self._evaluation()]) + "\n"

    def _helpers(self) -> Iterator[str]:
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

    def _evaluation(self) -> Iterator[str]:
        _name, axes = self.layout.name, self.fixed.axes
        yield f"{self.head}\n{{"
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
        name, word = self.layout.name, self.word
        points = self._points()
        results = [self.fixed.evaluate(p) for p in points]
        about = (
            f"Self-test of {name}: compile with {name}.c and run on the target; exits with 0 if every output is exact."
        )
        lines = [*comment([about]), f'#include "{name}.h"', ""]
        lines += [f"#include <{h}.h>" for h in ("stddef", "stdio")] + ["", f"#define VECTORS {len(points)}", ""]
        for what, rows in (("inputs", points), ("expected", results)):
            lines.append(f"static const {word} {what}[VECTORS][{len(rows[0])}] = {{")
            lines += wrapped([f"{{{', '.join(map(self._word, row))}}}" for row in rows], INDENT)
            lines.append("};")
        return "\n".join([*lines, "", *self._main()]) + "\n"

    def _word(self, value: int) -> str:
        return f"(-{-value - 1} - 1)" if value == -self.fixed.format.most - 1 else str(value)

    def _points(self) -> list[tuple[int, ...]]:
        """Return ends of the type, places around the knots, and random inputs."""
        form, rng = self.fixed.format, random.Random(1)
        least, most = -form.most - 1, form.most
        axes = {a.input: a for a in self.fixed.axes}
        near: list[list[int]] = []
        for i in range(len(self.layout.arguments)):
            own = {least, most, 0}
            if i in axes:
                knots = [axes[i].least + (k >> axes[i].shift) for k in axes[i].knots]
                own |= {min(max(k + s, least), most) for k in knots for s in (-1, 0, 1)}
            near.append(sorted(own))
        chosen = [tuple(rng.choice(own) for own in near) for _ in range(RANDOM)]
        inside = [
            tuple(rng.randint(axes[i].least, axes[i].most) if i in axes else 0 for i in range(len(near)))
            for _ in range(RANDOM)
        ]
        return list(dict.fromkeys([tuple([least] * len(near)), tuple([most] * len(near)), *chosen, *inside]))

    def _main(self) -> Iterator[str]:
        name, layout = self.layout.name, self.layout
        inputs = ", ".join(f"inputs[v][{k}]" for k in range(len(layout.arguments)))
        yield f"int main(void)\n{{\n{INDENT}int failures = 0;\n{INDENT}long worst = 0;"
        yield f"{INDENT}for (size_t v = 0U; v < (size_t)VECTORS; ++v) {{"
        if layout.many:
            yield f"{INDENT * 2}{name}_outputs outputs;\n{INDENT * 2}{name}({inputs}, &outputs);"
        found = ", ".join(f"outputs.{o}" for o in layout.outputs) if layout.many else f"{name}({inputs})"
        yield f"{INDENT * 2}const {self.word} found[{len(layout.outputs)}] = {{{found}}};"
        yield f"{INDENT * 2}for (size_t k = 0U; k < {len(layout.outputs)}U; ++k) {{"
        yield f"{INDENT * 3}const long off = (long)found[k] - (long)expected[v][k];"
        yield f"{INDENT * 3}const long size = (off < 0) ? -off : off;"
        yield f"{INDENT * 3}worst = (size > worst) ? size : worst;"
        yield f"{INDENT * 3}failures += (off == 0) ? 0 : 1;\n{INDENT * 2}}}\n{INDENT}}}"
        yield f'{INDENT}(void)printf("{name}: worst error %ld units in the last place\\n", worst);'
        yield f'{INDENT}(void)printf("{name}: %d vectors, %d failures\\n", VECTORS, failures);'
        yield f"{INDENT}return (failures == 0) ? 0 : 1;\n}}"
