"""Text of programs: one way to write each node for scalar Python (and numba) and one for numpy arrays."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from fuzzyctl.expr import Binary, Call, Compare, Expr, Logic, Name, Negate, Number, Where
from fuzzyctl.kernels.program import Accumulate, Assign, Item, Refuse, Statement

INDENT = "    "


@dataclass(frozen=True)
class Dialect:
    """How a target writes what targets write differently.

    Args:
        where: Text of a choice, from the texts of condition, value and other value.
        smaller: Text of the smaller of two atoms.
        larger: Text of the larger of two atoms.
        logic: Texts of `and`, `or`, `not`.
        item: Text of an array item.
        divide: Text of a quotient.
    """

    where: Callable[[str, str, str], str]
    smaller: Callable[[str, str], str]
    larger: Callable[[str, str], str]
    logic: tuple[str, str, str]
    item: Callable[[str, int | str], str] = lambda array, index: f"{array}[{index}]"
    divide: Callable[[str, str], str] = lambda a, b: f"({a} / {b})"


SCALAR = Dialect(
    where=lambda c, a, b: f"({a} if {c} else {b})",
    smaller=lambda a, b: f"({a} if {a} < {b} else {b})",
    larger=lambda a, b: f"({a} if {a} > {b} else {b})",
    logic=(" and ", " or ", "not "),
)

#: Plain Python where a quotient may be 0/0 or 1/0, which Python refuses and IEEE 754 (so numpy, numba) does not.
IEEE_SCALAR = replace(SCALAR, divide=lambda a, b: f"divide({a}, {b})")

ARRAYS = Dialect(
    where=lambda c, a, b: f"where({c}, {a}, {b})",
    smaller=lambda a, b: f"minimum({a}, {b})",
    larger=lambda a, b: f"maximum({a}, {b})",
    logic=(" & ", " | ", "logical_not"),
    # Constants stay plain Python numbers, and Python refuses to divide those by zero.
    divide=lambda a, b: f"divide({a}, {b})",
)


def text(expr: Expr, dialect: Dialect) -> str:
    """Return an expression as source text; everything compound stands in parentheses."""
    return _Writer(dialect).text(expr)


@dataclass(frozen=True)
class _Writer:
    dialect: Dialect

    def text(self, expr: Expr) -> str:
        match expr:
            case Number(value=value):
                return number(value)
            case Name(name=name):
                return name
            case Item(array=array, index=index):
                return self.dialect.item(array, index)
            case Negate(operand=operand):
                return f"(-{self.text(operand)})"
            case Binary(op="/", left=left, right=right):
                return self.dialect.divide(self.text(left), self.text(right))
            case Binary(op="^", left=left, right=right):
                return f"power({self.text(left)}, {self.text(right)})"
            case Binary(op=op, left=left, right=right) | Compare(op=op, left=left, right=right):
                return f"({self.text(left)} {op} {self.text(right)})"
            case Logic(op="not", operands=(operand,)):
                return f"({self.dialect.logic[2]}({self.text(operand)}))"
            case Logic(op=logic, operands=operands):
                return f"({self.dialect.logic[logic == 'or'].join(self.text(o) for o in operands)})"
            case Where(condition=condition, then=then, otherwise=otherwise):
                return self.dialect.where(self.text(condition), self.text(then), self.text(otherwise))
            case Call(function="min", arguments=(a, b)):
                return self.dialect.smaller(self.text(a), self.text(b))
            case Call(function="max", arguments=(a, b)):
                return self.dialect.larger(self.text(a), self.text(b))
            case Call(function=function, arguments=arguments):
                return f"{function}({', '.join(self.text(a) for a in arguments)})"
        raise TypeError(f"{type(expr).__name__} has no text in a program")


def number(value: float) -> str:
    """Return a number that reads back bit for bit."""
    if math.isnan(value):
        return "nan"
    if math.isinf(value):
        return "inf" if value > 0 else "(-inf)"
    return repr(value) if value >= 0 else f"({value!r})"


def block(
    statements: tuple[Statement, ...], dialect: Dialect, refuse: Callable[[str, str], list[str]], depth: int = 1
) -> Iterator[str]:
    """Yield the lines of some statements.

    Args:
        statements: What to print.
        dialect: For which target.
        refuse: Lines of a refusal, from the text of its condition and the output's name.
        depth: Levels of indentation.
    """
    pad = INDENT * depth
    for statement in statements:
        match statement:
            case Assign(name=name, value=value):
                yield f"{pad}{name} = {text(value, dialect)}"
            case Accumulate(count=count, counter=counter, body=body, sums=sums):
                yield from (f"{pad}{s.name} = 0.0" for s in sums)
                yield f"{pad}for {counter} in range({count}):"
                yield from block(body, dialect, refuse, depth + 1)
                yield from (f"{pad}{INDENT}{s.name} = {s.name} + {text(s.value, dialect)}" for s in sums)
            case Refuse(condition=condition, output=output):
                yield from (pad + line for line in refuse(text(condition, dialect), output))
