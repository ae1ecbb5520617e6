"""Statements of programs as lines of C99: every value a constant, every table static."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from fuzzyctl.codegen.errors import CodegenError, unprintable
from fuzzyctl.codegen.simplify import FALSE, TRUE
from fuzzyctl.codegen.unit import Precision
from fuzzyctl.expr import Binary, Call, Compare, Expr, Logic, Name, Negate, Number, Where
from fuzzyctl.kernels.program.builder import is_atom
from fuzzyctl.kernels.program.printer import ALIASES, PRIMITIVES
from fuzzyctl.kernels.program.program import (
    Accumulate,
    Assign,
    Fold,
    Item,
    Locate,
    Offset,
    Place,
    Program,
    Refuse,
    Statement,
)
from fuzzyctl.kernels.program.traversal import read, reads

INDENT: Final = "    "
#: From here on numbers round to none of single precision.
_BEYOND: Final = 2.0**128 - 2.0**103
#: Most knots counted by comparisons; more are searched by bisection.
COUNTED: Final = 9


@dataclass
class CText:
    """Write expressions and statements of one program in C.

    Args:
        precision: Type of numbers.
        prefix: Name of the block, before the names of its functions.
        names: Identifiers of the program's arguments.
        notes: Lines of comment before values of the program, by name.
        helpers: Primitives used so far that need a function.
        libm: Whether <math.h> is used so far.
    """

    precision: Precision
    prefix: str
    names: Mapping[str, str]
    notes: Mapping[str, Sequence[str]] = field(default_factory=dict)
    helpers: set[str] = field(default_factory=set)
    libm: bool = False

    def number(self, value: float) -> str:
        """Return a literal of the precision that reads back as the same number.

        Raises:
            CodegenError: For a number beyond the largest one of the precision.
        """
        if math.isnan(value):
            return f"{self.prefix}_no_number()"
        if math.isinf(value):
            self.libm = True
            infinity = "(float)INFINITY" if self.precision == "float" else "(double)INFINITY"
            return infinity if value > 0 else f"(-({infinity}))"
        text = repr(value) if self.precision == "double" else f"{single_text(value)}F"
        return text if math.copysign(1.0, value) > 0 else f"({text})"

    def text(self, expr: Expr) -> str:
        """Return an expression, in parentheses if it is compound."""
        match expr:
            case Number(value=value):
                return self.number(value)
            case Name(name=name):
                return self.names.get(name, name)
            case Item(array=array, index=index):
                return self._item(array, index)
            case Negate(operand=operand):
                return f"(-{self.text(operand)})"
            case Binary(op="^", left=left, right=right):
                return self._call("power", (left, right))
            case Binary(op=op, left=left, right=right):
                return f"({self.text(left)} {op} {self.text(right)})"
            case Where(condition=condition, then=then, otherwise=otherwise):
                return f"({self.condition(condition)} ? {self.text(then)} : {self.text(otherwise)})"
            case Call(function=function, arguments=arguments):
                return self._call(ALIASES.get(function, function), arguments)
        raise CodegenError(f"a {type(expr).__name__} cannot be printed as a number")

    def condition(self, expr: Expr) -> str:
        """Return a truth value."""
        if expr in (TRUE, FALSE):
            return "true" if expr == TRUE else "false"
        match expr:
            case Compare(op="!=", left=left, right=right) if left == right:
                # Compilers may take x != x for false (-ffinite-math-only); the bits of a NaN they must leave alone.
                return f"{self.prefix}_is_nan({self.text(left)})"
            case Compare(op=op, left=left, right=right):
                return f"({self.text(left)} {op} {self.text(right)})"
            case Logic(op="not", operands=(operand,)):
                return f"(!{self.condition(operand)})"
            case Logic(op=op, operands=operands):
                sign = " && " if op == "and" else " || "
                return f"({sign.join(self.condition(o) for o in operands)})"
        raise CodegenError(f"a {type(expr).__name__} cannot be printed as a condition")

    def _item(self, array: str, index: int | str | Place) -> str:
        match index:
            case Place(name=name, steps=0):
                return f"{array}[{name}]"
            case Place(name=name, steps=steps):
                return f"{array}[{name} + {steps}U]"
            case int():
                return f"{array}[{index}U]"
        return f"{array}[{index}]"

    def _call(self, function: str, arguments: Sequence[Expr]) -> str:
        texts = [self.text(a) for a in arguments]
        primitive = PRIMITIVES.get(function)
        if primitive is None:
            raise CodegenError(f"the function {function!r} has no text in C", function)
        if primitive.c.isidentifier():
            self.libm = True
            suffix = "f" if self.precision == "float" else ""
            return f"{primitive.c}{suffix}({', '.join(texts)})"
        if function == "divide":
            return f"({texts[0]} / {texts[1]})"
        if function in ("smaller", "larger", "clip") and all(is_atom(a) for a in arguments):
            return self._selection(function, arguments, texts)
        self.helpers.add(function)
        return f"{self.prefix}_{function}({', '.join(texts)})"

    def _selection(self, function: str, arguments: Sequence[Expr], texts: Sequence[str]) -> str:
        if function != "clip":
            sign = "<" if function == "smaller" else ">"
            return f"(({texts[0]} {sign} {texts[1]}) ? {texts[0]} : {texts[1]})"
        x, low, high = texts
        value = x
        if not _is(arguments[2], math.inf):
            value = f"(({x} > {high}) ? {high} : {value})"
        if not _is(arguments[1], -math.inf):
            value = f"(({x} < {low}) ? {low} : {value})"
        return value

    def tables(self, program: Program, notes: Mapping[str, Sequence[str]]) -> Iterator[str]:
        """Yield the declarations of the constant tables; knots that are compared one by one are in the text.

        Args:
            program: Whose tables.
            notes: Lines of comment before each of them, by name.
        """
        counted = {s.table for s in program.body if isinstance(s, Locate) and not _reads_table(s)}
        others = set().union(*(reads(s) for s in program.body if not isinstance(s, Locate) or _reads_table(s)))
        unread = counted - others.union(*map(read, program.results))
        for name, values in program.tables:
            if name in unread:
                continue
            yield from (INDENT + line for line in notes[name])
            yield f"{INDENT}static const {self.precision} {name}[{len(values)}] = {{"
            texts = [self.number(v) for v in values]
            yield from wrapped(texts, INDENT * 2)
            yield f"{INDENT}}};"

    def block(self, statements: Sequence[Statement], refusals: Mapping[str, str], depth: int) -> Iterator[str]:
        """Yield the lines of some statements.

        Args:
            statements: What to print.
            refusals: The line that refuses, for each output that may.
            depth: Levels of indentation.
        """
        pad, real = INDENT * depth, self.precision
        for statement in statements:
            match statement:
                case Assign(name=name, value=value):
                    yield from (pad + line for line in self.notes.get(name, ()))
                    yield f"{pad}const {real} {name} = {bare(self.text(value))};"
                case Locate():
                    yield from (pad + line for line in self._located(statement))
                case Offset(name=name, parts=parts):
                    total = " + ".join(n if s == 1 else f"({s}U * {n})" for n, s in parts)
                    yield f"{pad}const size_t {name} = {total};"
                case Accumulate():
                    yield from self.block([statement.fold], refusals, depth)
                case Fold(count=count, counter=k, first=first, body=body, then=then):
                    yield from (f"{pad}{real} {s.name} = {bare(self.text(s.value))};" for s in first)
                    yield f"{pad}for (size_t {k} = 0U; {k} < {count}U; ++{k}) {{"
                    yield from self.block(body, refusals, depth + 1)
                    yield from (f"{pad}{INDENT}{s.name} = {bare(self.text(s.value))};" for s in then)
                    yield f"{pad}}}"
                case Refuse(condition=condition, output=output):
                    yield f"{pad}if ({bare(self.condition(condition))}) {{"
                    yield f"{pad}{INDENT}{refusals[output]}"
                    yield f"{pad}}}"
                case _:
                    raise unprintable(statement)

    def _located(self, statement: Locate) -> Iterator[str]:
        """Yield lines that find a knot: all comparisons where they are few, else halving."""
        name, rest, x = statement.name, statement.rest, self.text(statement.x)
        knots = [self.number(k) for k in statement.knots]
        if any(a >= b for a, b in zip(self.rounded(statement.knots), self.rounded(statement.knots[1:]), strict=False)):
            raise CodegenError("two knots are the same in this precision; use double")
        if statement.wants_rest:
            position = f"(({x} < {knots[0]}) ? {knots[0]} : (({x} > {knots[-1]}) ? {knots[-1]} : {x}))"
            yield f"const {self.precision} {rest}_x = {bare(position)};"
            x = f"{rest}_x"
        if len(knots) <= COUNTED:
            count = " + ".join(f"(({x} >= {k}) ? 1U : 0U)" for k in knots[1:]) or "0U"
            yield f"const size_t {name}_k = {count};"
        else:
            yield f"size_t {name}_k = 0U;"
            first = 1 << ((len(knots) - 1).bit_length() - 1)
            yield f"for (size_t {name}_h = {first}U; {name}_h > 0U; {name}_h /= 2U) {{"
            ahead = f"{name}_k + {name}_h"
            yield f"{INDENT}if ((({ahead}) < {len(knots)}U) && ({statement.table}[{ahead}] <= {x})) {{"
            yield f"{INDENT}{INDENT}{name}_k += {name}_h;"
            yield f"{INDENT}}}"
            yield "}"
        stride = f"{name}_k" if statement.stride == 1 else f"{statement.stride}U * {name}_k"
        yield f"const size_t {name} = {stride};"
        if statement.wants_rest:
            yield f"const {self.precision} {rest} = {rest}_x - {statement.table}[{name}_k];"

    def rounded(self, values: Sequence[float]) -> list[float]:
        """Return numbers as the precision has them."""
        return list(values) if self.precision == "double" else [single(v) for v in values]

    def helper_lines(self) -> Iterator[str]:
        """Yield the functions of primitives that were used."""
        zero, one, real = self.number(0.0), self.number(1.0), self.precision
        for name in sorted(self.helpers):
            primitive = PRIMITIVES[name]
            parameters = ", ".join(f"{real} {a}" for a in primitive.arguments.split())
            yield f"static {real} {self.prefix}_{name}({parameters})"
            yield f"{{\n{INDENT}return {primitive.c.format(zero=zero, one=one)};\n}}\n"


def _reads_table(statement: Locate) -> bool:
    return statement.wants_rest or len(statement.knots) > COUNTED


def bare(text: str) -> str:
    """Return an expression without parentheses around all of it."""
    if not text.startswith("("):
        return text
    level = 0
    for k, character in enumerate(text):
        level += (character == "(") - (character == ")")
        if level == 0:
            return text[1:-1] if k == len(text) - 1 else text
    return text


def wrapped(texts: Sequence[str], pad: str, width: int = 110, between: str = ",") -> Iterator[str]:
    """Yield texts joined by commas, or something else, in lines of a width."""
    line = pad
    for k, text in enumerate(texts):
        piece = text + (between if k + 1 < len(texts) else "")
        if len(line) + len(piece) > width and line.strip():
            yield line.rstrip()
            line = pad
        line += piece + " "
    yield line.rstrip()


def single(value: float) -> float:
    """Return the nearest number of single precision.

    Raises:
        CodegenError: For one that is too large.
    """
    try:
        # The machine's own order of bytes would give infinity instead of the error.
        result: float = struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        raise CodegenError(f"{value!r} is too large for single precision; use double") from None
    return result


def single_text(value: float) -> str:
    """Return the shortest text that reads back as the same number of single precision."""
    number = single(value)
    for digits in range(1, 10):
        text = f"{number:.{digits}g}"
        if abs(float(text)) < _BEYOND and single(float(text)) == number:
            break
    text = repr(float(text))
    return text


def _is(expr: Expr, value: float) -> bool:
    return isinstance(expr, Number) and expr.value == value
