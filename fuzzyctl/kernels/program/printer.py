"""Printer of programs: text of each node for scalar Python (and numba) and for numpy arrays."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import reduce
from itertools import pairwise
from typing import Final, NamedTuple

from fuzzyctl.expr import FUNCTIONS, Binary, Call, Compare, Expr, Logic, Name, Negate, Number, Where, walk
from fuzzyctl.expr import replace as replace_in
from fuzzyctl.kernels.program.program import (
    STATE,
    Accumulate,
    Assign,
    Between,
    Fold,
    Item,
    Locate,
    Offset,
    Place,
    Quadrature,
    Refuse,
    Statement,
)
from fuzzyctl.records import record


class Primitive(NamedTuple):
    """One function.

    Args:
        arguments: Names of its arguments.
        numpy: For arrays.
        numba: For compiled Python, after the header of its modules.
        c: For C99, with literals of the precision for {zero} and {one}.
        st: For IEC 61131-3, with arguments by position; empty where it has no such function.
        javascript: For JavaScript; a word with a dot is a function of its library.
    """

    arguments: str
    numpy: str
    numba: str
    c: str
    st: str
    javascript: str


def _library(arguments: str, name: str, st: str, *, numpy: str = "", c: str = "", javascript: str = "") -> Primitive:
    return Primitive(arguments, numpy or name, name, c or name, st, javascript or f"Math.{name}")


#: By name; a comment describes the computation if the name does not.
PRIMITIVES: Final[Mapping[str, Primitive]] = {
    # Quotient of IEEE 754: infinite or NaN for a divisor of 0.
    "divide": Primitive("a b", "divide", "a / b", "a / b", "({0} / {1})", "a / b"),
    # The second argument where one of them is NaN.
    "smaller": Primitive("a b", "where(a < b, a, b)", "smaller", "(a < b) ? a : b", "MIN", "a < b ? a : b"),
    "larger": Primitive("a b", "where(a > b, a, b)", "larger", "(a > b) ? a : b", "MAX", "a > b ? a : b"),
    # The first argument held between the others; NaN stays NaN.
    "clip": Primitive(
        "x low high",
        "clip",
        "clip",
        "(x < low) ? low : ((x > high) ? high : x)",
        "LIMIT({1}, {0}, {2})",
        "x < low ? low : x > high ? high : x",
    ),
    # The argument held within [0, 1], 0 for NaN.
    "held": Primitive(
        "x",
        "where(x > 0.0, where(x < 1.0, x, 1.0), 0.0)",
        "(x if x < 1.0 else 1.0) if x > 0.0 else 0.0",
        "(x > {zero}) ? ((x < {one}) ? x : {one}) : {zero}",
        "LIMIT({zero}, {0}, {one})",
        "x > 0 ? (x < 1 ? x : 1) : 0",
    ),
    "abs": _library("x", "abs", "ABS", c="(x > {zero}) ? x : ({zero} - x)"),
    # JavaScript's own is NaN where IEEE 754 has 1.
    "power": _library(
        "a b",
        "power",
        "EXPT",
        c="pow",
        javascript="a === 1 || (a === -1 && Math.abs(b) === Infinity) ? 1 : Math.pow(a, b)",
    ),
    "sqrt": _library("x", "sqrt", "SQRT"),
    "exp": _library("x", "exp", "EXP"),
    "log": _library("x", "log", "LN"),
    "sin": _library("x", "sin", "SIN"),
    "cos": _library("x", "cos", "COS"),
    "tan": _library("x", "tan", "TAN"),
    "atan2": _library("y x", "atan2", "", numpy="arctan2"),
    # The largest whole number that is not above the argument.
    "floor": _library("x", "floor", ""),
    # The remainder with the sign of the first argument.
    "fmod": _library("a b", "fmod", "", javascript="a % b"),
}

#: Other names of primitives: what `expr` calls them.
ALIASES: Final[Mapping[str, str]] = {"min": "smaller", "max": "larger"}


INDENT = "    "

#: More knots than this are searched by compiled code, which costs as much at eight and a third at 64 of them.
MOST_COUNTED = 8
#: So it is in loops over many points, where comparisons become vector instructions: as much at some fifty.
MOST_COUNTED_MANY = 48


def index_text(index: int | str | Place) -> str:
    """Return a position within an array."""
    if isinstance(index, Place):
        return f"{index.name} + {index.steps}" if index.steps else index.name
    return str(index)


@record(frozen=True)
class Dialect:
    """Texts that differ between targets.

    Args:
        where: Text of a choice, from the texts of condition, value and other value.
        smaller: Text of the smaller of two atoms.
        larger: Text of the larger of two atoms.
        clip: Text of an atom held between two atoms; NaN stays NaN.
        logic: Texts of `and`, `or`, `not`.
        locate: Lines that find a knot.
        nested: Whether functions are defined where they are used.
        integral: Text of a call that integrates, from the texts of the arguments of the set and of its marks.
        item: Text of an array item.
        divide: Text of a quotient.
        constant: Text of a number.
    """

    where: Callable[[str, str, str], str]
    smaller: Callable[[str, str], str]
    larger: Callable[[str, str], str]
    clip: Callable[[str, str, str], str]
    logic: tuple[str, str, str]
    locate: Callable[[Locate, str], list[str]]
    item: Callable[[str, int | str | Place], str] = lambda array, index: f"{array}[{index_text(index)}]"
    divide: Callable[[str, str], str] = lambda a, b: f"({a} / {b})"
    nested: bool = False
    integral: Callable[[Quadrature, str, str], str] = lambda s, given, marks: (
        f"{s.kind}({s.function}, marked({s.places}, {marks}), {given})"
        if s.crossings is None
        else f"{s.kind}({s.function}, {s.crossing_function}, {s.places}, {given})"
    )
    constant: Callable[[float], str] = lambda value: number(value)


def counted(statement: Locate, x: str, constants: Sequence[str] = (), item: str = "") -> list[str]:
    """Return lines without branches: each knot but the first counts if it is not beyond the value.

    Args:
        statement: The search.
        x: Text of the value.
        constants: Texts of the knots; empty for the numbers themselves.
        item: Text of the knot found; empty for an item of the table.
    """
    name, rest = statement.name, statement.rest
    knots = constants or [number(k) for k in statement.knots]
    first, last = knots[0], knots[-1]
    clipped = f"{rest} = ({first} if {x} < {first} else ({last} if {x} > {last} else {x}))"
    count = " + ".join(["0", *(f"({rest} >= {k})" for k in knots[1:])])
    lines = [clipped, f"{name} = {count}", f"{rest} = {rest} - {item or f'{statement.table}[{name}]'}"]
    return lines if statement.stride == 1 else [*lines, f"{name} = {statement.stride} * {name}"]


def searched(statement: Locate, x: str, table: str = "", first: int = 0) -> list[str]:
    """Return lines that call `search`, which halves the knots without branches, as often as a compiler knows.

    Args:
        statement: The search.
        x: Text of the value.
        table: Name of the array of the knots; empty for their own.
        first: Where they begin in it.
    """
    name, rest, count = statement.name, statement.rest, len(statement.knots)
    array = table or statement.table
    low, high = f"{array}[{first}]", f"{array}[{first + count - 1}]"
    lines = [
        f"{rest} = ({low} if {x} < {low} else ({high} if {x} > {high} else {x}))",
        f"{name} = search({array}, {first}, {count}, {rest})",
        f"{rest} = {rest} - {array}[{first} + {name}]",
    ]
    return lines if statement.stride == 1 else [*lines, f"{name} = {statement.stride} * {name}"]


def counted_or_searched(statement: Locate, x: str, most: int = MOST_COUNTED) -> list[str]:
    """Return lines for compilers: comparisons with all knots where there are at most `most`, else a search."""
    return counted(statement, x) if len(statement.knots) <= most else searched(statement, x)


def decided(statement: Locate, x: str) -> list[str]:
    """Return lines that halve the knots until one is left: least work for an interpreter."""
    name, rest, knots = statement.name, statement.rest, statement.knots

    def halved(first: int, last: int) -> list[str]:
        if first < last:
            middle = (first + last + 1) // 2
            upper, lower = halved(middle, last), halved(first, middle - 1)
            test = f"if {x} >= {number(knots[middle])}:"
            return [test, *(INDENT + line for line in upper), "else:", *(INDENT + line for line in lower)]
        beyond = f"{x} - {number(knots[first])}" if knots[first] else x
        if first == len(knots) - 1:
            beyond = "0.0" if first else f"({x} - {x} if {x} != {x} else 0.0)"
        elif first == 0:
            beyond = f"0.0 if {x} < {number(knots[0])} else {beyond}"
        place = f"{name} = {first * statement.stride}"
        return [place, f"{rest} = {beyond}"] if statement.wants_rest else [place]

    return halved(0, len(knots) - 1)


SCALAR = Dialect(
    where=lambda c, a, b: f"({a} if {c} else {b})",
    smaller=lambda a, b: f"({a} if {a} < {b} else {b})",
    larger=lambda a, b: f"({a} if {a} > {b} else {b})",
    clip=lambda x, a, b: f"({a} if {x} < {a} else ({b} if {x} > {b} else {x}))",
    logic=(" and ", " or ", "not "),
    locate=counted_or_searched,
)

#: Scalar Python as it is interpreted, not compiled.
INTERPRETED = replace(SCALAR, locate=decided, nested=True)

#: Plain Python where a quotient may be 0/0 or 1/0, which Python refuses and IEEE 754 (so numpy, numba) does not.
IEEE_SCALAR = replace(INTERPRETED, divide=lambda a, b: f"divide({a}, {b})")


def _array_item(array: str, index: int | str | Place) -> str:
    """Return items at many positions; a constant step is cheaper to take off the array than to add to each position."""
    if not isinstance(index, Place):
        return f"{array}[{index}]"
    return f"{array}[{index.steps}:].take({index.name})" if index.steps else f"{array}.take({index.name})"


ARRAYS = Dialect(
    where=lambda c, a, b: f"where({c}, {a}, {b})",
    smaller=lambda a, b: f"minimum({a}, {b})",
    larger=lambda a, b: f"maximum({a}, {b})",
    clip=lambda x, a, b: f"clip({x}, {a}, {b})",
    logic=(" & ", " | ", "logical_not"),
    locate=lambda s, x: [f"{s.name}, {s.rest} = locate({x}, {s.table}, {s.stride})"],
    item=_array_item,
    # Constants stay plain Python numbers, and Python refuses to divide those by zero.
    divide=lambda a, b: f"divide({a}, {b})",
)


def text(expr: Expr, dialect: Dialect) -> str:
    """Return an expression as source text; compound parts are in parentheses."""
    return _Writer(dialect).text(expr)


@record(frozen=True)
class _Writer:
    dialect: Dialect

    def text(self, expr: Expr) -> str:
        match expr:
            case Number(value=value):
                return self.dialect.constant(value)
            case Name(name=name):
                return name
            case Item(array=array, index=index):
                return self.dialect.item(array, index)
            case Negate(operand=operand):
                return f"(-{self.text(operand)})"
            case (
                Binary(op="-", left=kept, right=Number(value=0.0)) | Binary(op="*", left=Number(value=1.0), right=kept)
            ):
                return self.text(kept)
            case Binary(op="/", left=left, right=right):
                return self.dialect.divide(self.text(left), self.text(right))
            case Binary(op="^", left=left, right=Number(value=value)):
                return f"power({self.text(left)}, {number(value)})"
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
            case Call(function="min" | "max" as function, arguments=(_, *_) as arguments):
                join = self.dialect.smaller if function == "min" else self.dialect.larger
                return reduce(join, map(self.text, arguments))
            case Call(function="clip", arguments=(a, b, c)):
                return self.dialect.clip(self.text(a), self.text(b), self.text(c))
            case Call(function=function, arguments=arguments):
                _check_count(function, len(arguments))
                return f"{function}({', '.join(self.text(a) for a in arguments)})"
        raise TypeError(f"{type(expr).__name__} has no text in a program")


def _check_count(function: str, count: int) -> None:
    """Raise TypeError for a call that no backend can compute."""
    if function in PRIMITIVES:
        least = most = len(PRIMITIVES[function].arguments.split())
    elif function in FUNCTIONS:
        least, most = FUNCTIONS[function][0], FUNCTIONS[function][1] or count
    else:
        raise TypeError(f"no function '{function}'")
    if not least <= count <= most:
        raise TypeError(f"'{function}' takes {least} argument{'s' * (least != 1)}, not {count}")


def _tuple(texts: Sequence[str]) -> str:
    return f"({', '.join(texts)},)" if texts else "()"


def set_functions(statement: Quadrature, dialect: Dialect) -> Iterator[str]:
    """Yield the lines of the function that a quadrature integrates, and those of its crossings."""
    yield from _of_place(statement.function, statement, statement.body, text(statement.value, dialect), dialect)
    if (crossings := statement.crossings) is not None:
        values = _tuple([text(v, dialect) for v in crossings.values])
        yield from _of_place(statement.crossing_function, statement, crossings.body, values, dialect)


def _of_place(
    name: str, statement: Quadrature, body: tuple[Statement, ...], value: str, dialect: Dialect
) -> Iterator[str]:
    yield f"def {name}({statement.x}, given):"
    if statement.given:
        yield f"{INDENT}{', '.join(statement.given)}, = given"
    yield from block(body, dialect, lambda condition, output: [])
    yield f"{INDENT}return {value}"


def _offset(parts: Sequence[tuple[str, int]]) -> str:
    return " + ".join(name if stride == 1 else f"{stride} * {name}" for name, stride in parts)


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
            case Locate(x=x):
                yield from (pad + line for line in dialect.locate(statement, text(x, dialect)))
            case Offset(name=name, parts=parts):
                yield f"{pad}{name} = {_offset(parts)}"
            case Accumulate(count=count, counter=counter, body=body, sums=sums):
                yield from (f"{pad}{s.name} = 0.0" for s in sums)
                yield f"{pad}for {counter} in range({count}):"
                yield from block(body, dialect, refuse, depth + 1)
                yield from (f"{pad}{INDENT}{s.name} = {s.name} + {text(s.value, dialect)}" for s in sums)
            case Fold(count=count, counter=counter, first=first, body=body, then=then):
                yield from block(first, dialect, refuse, depth)
                yield f"{pad}for {counter} in range({count}):"
                yield from block((*body, *then), dialect, refuse, depth + 1)
            case Between(name=name, side=side, share=share, body=body, value=value):
                share_text, other = text(share, dialect), text(value, dialect)
                yield f"{pad}{name} = 0.0"
                yield f"{pad}for {side} in range(2):"
                yield from block(body, dialect, refuse, depth + 1)
                yield f"{pad}{INDENT}{name} = ({name} + {share_text} * ({other} - {name}) if {side} else {other})"
            case Quadrature(found=found, area=area, given=given):
                if dialect.nested:
                    yield from (pad + line for line in set_functions(statement, dialect))
                read, marks = (_tuple(t) for t in (given, [text(m, dialect) for m in statement.marks]))
                yield f"{pad}{found}, {area} = {dialect.integral(statement, read, marks)}"
            case Refuse(condition=condition, output=output):
                yield from (pad + line for line in refuse(text(condition, dialect), output))


#: Fewest results of a loop.
LEAST_LOOP: Final = 4
#: Name of the counter of a loop.
COUNTER: Final = "place"


@record(frozen=True)
class Run:
    """Results one after the other, each that of the one before with the next numbers of the state.

    Args:
        first: Position of the first one.
        count: How many there are.
        value: The first one.
    """

    first: int
    count: int
    value: Expr

    @property
    def is_loop(self) -> bool:
        """Whether it is long enough for a loop."""
        return self.count >= LEAST_LOOP

    @property
    def is_shifted(self) -> bool:
        """Whether each next state is its own number of the state, or the one before, as in a delay."""
        return self.is_loop and all(item.index in (self.first, self.first - 1) for item in _items(self.value))

    def in_loop(self) -> Expr:
        """Return the value with positions that the counter of a loop moves."""
        return _moved(self.value, lambda index: Place(COUNTER, index))


def runs(results: Sequence[Expr]) -> list[Run]:
    """Return some results as runs, in order."""
    breaks = [
        k
        for k, (a, b) in enumerate(pairwise(results), start=1)
        if not (_items(b) and _moved(a, lambda index: index + 1) == b)
    ]
    ends = [0, *breaks, len(results)]
    long = [(a, b) for a, b in pairwise(ends) if b - a >= LEAST_LOOP]
    groups: list[Run] = []
    place = 0
    for a, b in [*long, (len(results), len(results))]:
        groups += [Run(k, 1, results[k]) for k in range(place, a)]
        groups += [Run(a, b - a, results[a])] if b > a else []
        place = b
    return groups


def store_lines(results: Sequence[Expr], dialect: Dialect, target: Callable[[str], str]) -> Iterator[str]:
    """Yield lines that store results.

    Args:
        results: The stored values; none reads a value stored before.
        dialect: For which target.
        target: Text of where a result goes, from the text of its position.
    """
    for run in runs(results):
        if run.is_loop:
            yield f"for {COUNTER} in range({run.count}):"
            yield f"{INDENT}{target(f'{COUNTER} + {run.first}')} = {text(run.in_loop(), dialect)}"
        else:
            yield f"{target(str(run.first))} = {text(run.value, dialect)}"


def _items(value: Expr) -> list[Item]:
    return [n for n in walk(value) if isinstance(n, Item) and n.array == STATE and isinstance(n.index, int)]


def _moved(value: Expr, change: Callable[[int], int | Place]) -> Expr:
    """Return a value that reads numbers of the state at other positions."""

    def moved(node: Expr) -> Expr:
        if isinstance(node, Item) and node.array == STATE and isinstance(node.index, int):
            return Item(STATE, change(node.index))
        return node

    return replace_in(value, moved)
