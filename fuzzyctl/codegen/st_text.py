"""Statements of programs as Structured Text, which has neither choices between values nor NaN.

A choice becomes IF, so that only the chosen side is computed. A value that may be NaN has a second variable, `NAME_no`,
that says so; its number is 0 then. The flags follow the same expressions as the numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from fuzzyctl.codegen.c_text import single_text
from fuzzyctl.codegen.errors import CodegenError, unprintable
from fuzzyctl.codegen.simplify import FALSE, TRUE, folding
from fuzzyctl.codegen.st_guards import (
    TESTED,
    function_of,
    guarded,
    is_named,
    may_be_infinite,
    may_be_undefined,
    may_fail,
    needs_guard,
)
from fuzzyctl.codegen.unit import Precision
from fuzzyctl.expr import Binary, Call, Compare, Expr, Logic, Name, Negate, Number, Where, children, replace, walk
from fuzzyctl.kernels.program.printer import ALIASES, PRIMITIVES
from fuzzyctl.kernels.program.program import (
    Accumulate,
    Assign,
    Fold,
    Item,
    Locate,
    Offset,
    Place,
    Refuse,
    Statement,
)
from fuzzyctl.kernels.program.traversal import read

INDENT: Final = "  "
#: The largest numbers of the two types stand for infinity, which has no literal.
LARGEST: Final[Mapping[Precision, float]] = {"double": 1.7976931348623157e308, "float": 3.4028234663852886e38}


@dataclass
class STText:
    """Write statements in Structured Text.

    Args:
        precision: Type of numbers.
        names: Identifiers of the program's arguments.
        partial: Whether functions are called that have no value somewhere.
        infinite: Names of the program that may be infinite; arithmetic with them may have no value.
        undefined: Whether there is such arithmetic.
        reals: Variables declared so far.
        integers: The same for integers.
        flags: The same for truth values: whether another variable has no value.
        notes: Lines of comment before values of the program, by name.
        absent: Flags of arguments that may have no value, by name.
    """

    precision: Precision
    names: Mapping[str, str]
    partial: bool = False
    infinite: set[str] = field(default_factory=set)
    undefined: bool = False
    reals: list[str] = field(default_factory=list)
    integers: list[str] = field(default_factory=list)
    flags: list[str] = field(default_factory=list)
    notes: Mapping[str, Sequence[str]] = field(default_factory=dict)
    absent: Mapping[str, str] = field(default_factory=dict)
    _missing: dict[str, str] = field(default_factory=dict)
    _temporaries: int = 0

    def __post_init__(self) -> None:
        self._missing |= self.absent

    @property
    def real(self) -> str:
        """The type of numbers."""
        return "REAL" if self.precision == "float" else "LREAL"

    def number(self, value: float) -> str:
        """Return a literal."""
        if math.isinf(value):
            value = math.copysign(LARGEST[self.precision], value)
        text = single_text(value) if self.precision == "float" else repr(value)
        if "e" in text:
            mantissa, exponent = text.split("e")
            text = f"{mantissa if '.' in mantissa else mantissa + '.0'}E{int(exponent)}"
        return text if value >= 0 else f"({text})"

    def block(self, statements: Sequence[Statement], refusals: Mapping[str, str], depth: int) -> Iterator[str]:
        """Yield the lines of some statements.

        Args:
            statements: What to print.
            refusals: The line that refuses, for each output that may.
            depth: Levels of indentation.
        """
        pad = INDENT * depth
        for statement in statements:
            match statement:
                case Assign(name=name, value=value):
                    yield from (pad + line for line in self.notes.get(name, ()))
                    yield from self.assigned(self._declared(name), value, depth)
                case Locate():
                    yield from (pad + line for line in self._located(statement))
                case Offset(name=name, parts=parts):
                    self.integers.append(name)
                    yield f"{pad}{name} := {' + '.join(n if s == 1 else f'{s} * {n}' for n, s in parts)};"
                case Accumulate():
                    yield from self.block([statement.fold], refusals, depth)
                case Fold(count=count, counter=k, first=first, body=body, then=then):
                    self.integers.append(k)
                    self._carried([*first, *body, *then])
                    for s in first:
                        yield from self.assigned(self._declared(s.name), s.value, depth)
                    yield f"{pad}FOR {k} := 0 TO {count - 1} DO"
                    yield from self.block(body, refusals, depth + 1)
                    for s in then:
                        yield from self.assigned(s.name, s.value, depth + 1)
                    yield f"{pad}END_FOR;"
                case Refuse(condition=condition, output=output):
                    lines: list[str] = []
                    test = self._condition(self._folded(condition), lines, depth)
                    yield from lines
                    yield from (f"{pad}IF {test} THEN", f"{pad}{INDENT}{refusals[output]}", f"{pad}END_IF;")
                case _:
                    raise unprintable(statement)

    def assigned(self, name: str, value: Expr, depth: int) -> Iterator[str]:
        """Yield lines that give a variable a value, and say whether it has one."""
        value = self._folded(value)
        if may_be_infinite(value, self.infinite):
            self.infinite.add(name)
        flag = self._flag(name) if name in self._missing or self.may_be_missing(value) else ""
        yield from self._set(name, flag, value, depth)

    def _carried(self, statements: Sequence[Assign]) -> None:
        """Give flags to names that may have no value in a later turn of a loop, for any reason."""
        before = -1
        while before != len(self._missing) + len(self.infinite):
            before = len(self._missing) + len(self.infinite)
            for s in statements:
                if may_be_infinite(self._folded(s.value), self.infinite):
                    self.infinite.add(s.name)
                if self.may_be_missing(self._folded(s.value)):
                    self._flag(s.name)

    def _inner(self, value: Expr, lines: list[str], depth: int) -> Expr:
        """Return a value with choices at its head only: inner ones are replaced by names."""
        if isinstance(value, Where | Number | Name | Item):
            return value
        operands = [self._named(o, lines, depth) for o in children(value)]
        function = function_of(value)
        if not self.partial or not needs_guard(function):
            return _with_operands(value, operands)
        atoms = [o if is_named(o) else self._temporary(o, lines, depth) for o in operands]
        absent = [a for a in atoms if isinstance(a, Name) and a.name in self._missing]
        return guarded(function, atoms, absent)

    def _named(self, value: Expr, lines: list[str], depth: int) -> Expr:
        value = self._inner(value, lines, depth)
        return self._temporary(value, lines, depth) if isinstance(value, Where) else value

    def _temporary(self, value: Expr, lines: list[str], depth: int) -> Expr:
        self._temporaries += 1
        name = self._declared(f"c{self._temporaries}")
        lines.extend(self.assigned(name, value, depth))
        return Name(name)

    def _set(self, name: str, flag: str, value: Expr, depth: int) -> Iterator[str]:
        pad = INDENT * depth
        lines: list[str] = []
        value = self._inner(value, lines, depth)
        if isinstance(value, Where):
            test = self._condition(value.condition, lines, depth)
            yield from lines
            yield f"{pad}IF {test} THEN"
            yield from self._set(name, flag, value.then, depth + 1)
            yield f"{pad}ELSE"
            yield from self._set(name, flag, value.otherwise, depth + 1)
            yield f"{pad}END_IF;"
            return
        yield from lines
        if isinstance(value, Number) and math.isnan(value.value):
            yield from (f"{pad}{name} := {self.number(0.0)};", f"{pad}{flag} := TRUE;")
            return
        yield f"{pad}{name} := {self._text(value)};"
        if flag:
            missing = sorted(self._missing[n] for n in read(value) if n in self._missing)
            yield f"{pad}{flag} := {' OR '.join(missing) or 'FALSE'};"
        if may_be_undefined(value, self.infinite):
            self.undefined = True
            lines = [f"{name} := {self.number(0.0)};", f"{flag} := TRUE;"]
            yield from (f"{pad}IF {name} <> {name} THEN", *(pad + INDENT + line for line in lines), f"{pad}END_IF;")

    def _folded(self, expr: Expr) -> Expr:
        return replace(expr, folding(lambda n: not self.partial and n not in self._missing))

    def may_be_missing(self, value: Expr) -> bool:
        """Return whether a value may be NaN, by itself or by a name that it reads."""
        written = any((isinstance(n, Number) and math.isnan(n.value)) or may_fail(n) for n in walk(value))
        undefined = may_be_undefined(value, self.infinite)
        return written or undefined or any(n in self._missing for n in read(value))

    def missing(self, name: str) -> str:
        """Return the text of whether a variable has no value."""
        parts = [self._missing[name]] if name in self._missing else []
        # Functions of the user may give NaN themselves.
        variable = self.names.get(name, name)
        parts += [f"({variable} <> {variable})"] if self.partial else []
        return f"({' OR '.join(parts)})" if len(parts) > 1 else parts[0] if parts else "FALSE"

    def flag_of(self, name: str) -> str:
        """Return the variable that says that another one has no value, or an empty string."""
        return self._missing.get(name, "")

    def _flag(self, name: str) -> str:
        if name not in self._missing:
            self._missing[name] = f"{name}_no"
            self.flags.append(f"{name}_no")
        return self._missing[name]

    def _declared(self, name: str) -> str:
        self.reals.append(name)
        return name

    def _text(self, expr: Expr) -> str:
        """Return an expression without choices."""
        match expr:
            case Number(value=value):
                return self.number(value)
            case Name(name=name):
                return self.names.get(name, name)
            case Item(array=array, index=index):
                return self._item(array, index)
            case Negate(operand=operand):
                return f"(-{self._text(operand)})"
            case Binary(op="^", left=left, right=right):
                return self._call("power", [self._text(left), self._text(right)])
            case Binary(op=op, left=left, right=right):
                return f"({self._text(left)} {op} {self._text(right)})"
            case Call(function=function, arguments=arguments):
                return self._call(function.removesuffix(TESTED), [self._text(a) for a in arguments])
        raise CodegenError(f"a {type(expr).__name__} cannot be printed as a number")

    def _call(self, function: str, texts: Sequence[str]) -> str:
        if function == "whole":
            return f"DINT_TO_{self.real}(TRUNC({texts[0]}))"
        primitive = PRIMITIVES.get(ALIASES.get(function, function))
        if primitive is None or not primitive.st:
            raise CodegenError(f"Structured Text has no standard function for '{function}'", function)
        if primitive.st.isidentifier():
            return f"{primitive.st}({', '.join(texts)})"
        return primitive.st.format(*texts, zero=self.number(0.0), one=self.number(1.0))

    def _item(self, array: str, index: int | str | Place) -> str:
        if isinstance(index, Place):
            return f"{array}[{index.name} + {index.steps}]" if index.steps else f"{array}[{index.name}]"
        return f"{array}[{index}]"

    def _condition(self, expr: Expr, lines: list[str], depth: int) -> str:
        if expr in (TRUE, FALSE):
            return "TRUE" if expr == TRUE else "FALSE"
        match expr:
            case Compare(op="!=", left=left, right=right) if left == right:
                return self.missing(left.name) if isinstance(left, Name) else "FALSE"
            case Compare(op=op, left=left, right=right):
                return self._comparison(op, self._named(left, lines, depth), self._named(right, lines, depth))
            case Logic(op="not", operands=(operand,)):
                return f"(NOT {self._condition(operand, lines, depth)})"
            case Logic(op=op, operands=operands):
                return f"({f' {op.upper()} '.join(self._condition(o, lines, depth) for o in operands)})"
        raise CodegenError(f"a {type(expr).__name__} cannot be printed as a condition")

    def _comparison(self, op: str, left: Expr, right: Expr) -> str:
        """Return a comparison, false if an operand has no value, as that of NaN is."""
        sign = {"==": "=", "!=": "<>"}.get(op, op)
        text = f"({self._text(left)} {sign} {self._text(right)})"
        flags = sorted({self._missing[n] for n in read(left) | read(right) if n in self._missing})
        if not flags:
            return text
        return f"({' AND '.join(f'(NOT {f})' for f in flags)} AND {text})"

    def _located(self, statement: Locate) -> Iterator[str]:
        name, x, knots = statement.name, self._text(statement.x), statement.knots
        self.integers.append(name)
        if statement.wants_rest:
            rest = self._declared(statement.rest)
            absent = sorted(self._missing[n] for n in read(statement.x) if n in self._missing)
            if absent:
                yield f"{self._flag(rest)} := {' OR '.join(absent)};"
            yield f"{rest} := LIMIT({self.number(knots[0])}, {x}, {self.number(knots[-1])});"
            x = rest
        yield f"{name} := 0;"
        if len(knots) > 1:
            # The last knot not beyond the value; loops end early at the first that is.
            last = len(knots) - 1
            yield f"WHILE ({name} < {last}) AND ({x} >= {statement.table}[MIN({name} + 1, {last})]) DO"
            yield f"{INDENT}{name} := {name} + 1;"
            yield "END_WHILE;"
        if statement.wants_rest:
            yield f"{x} := {x} - {statement.table}[{name}];"
        if statement.stride != 1:
            yield f"{name} := {statement.stride} * {name};"


def _with_operands(value: Expr, operands: Sequence[Expr]) -> Expr:
    match value:
        case Negate():
            return -operands[0]
        case Binary(op=op):
            return Binary(op, operands[0], operands[1])
        case Call(function=function):
            return Call(function, tuple(operands))
    return value
