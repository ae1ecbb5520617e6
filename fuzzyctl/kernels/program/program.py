"""Intermediate language: programs of straight-line assignments, printed by the backends."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import reduce
from itertools import count
from typing import Final

from fuzzyctl.expr import (
    ONE,
    SOFT,
    ZERO,
    Binary,
    Call,
    Compare,
    Expr,
    Logic,
    Name,
    Negate,
    Number,
    Where,
    children,
    replace,
)
from fuzzyctl.kernels.program.primitives import step
from fuzzyctl.records import record

#: Deeper expressions are written as several statements, since parsers stop at some depth (CPython's at 200).
DEEPEST: Final = 40
#: Most values added up in one statement.
SUMMANDS: Final = 32

#: One object, so that programs that hold it compare equal.
NAN: Final = Number(math.nan)


@record(frozen=True, slots=True)
class Place:
    """A position that is computed: the value of an integer name, and some steps further."""

    name: str
    steps: int = 0


@record(frozen=True, slots=True)
class Item(Expr):
    """One number of an array argument or of a constant table.

    Args:
        array: Name of the array.
        index: A position, the name of a loop's counter, or a computed position.
    """

    array: str
    index: int | str | Place


@record(frozen=True, slots=True)
class Assign:
    """Give a name to a value, once."""

    name: str
    value: Expr


@record(frozen=True, slots=True)
class Locate:
    """Find the knot at or below a value, and how far the value lies beyond it.

    Values outside the knots count as the outer knots; NaN gives the first knot and a rest of NaN.

    Args:
        name: Name of the integer: the position of the knot times `stride`.
        rest: Name of the number: x, held within the knots, less the knot.
        x: An atom.
        table: Name of the constant array of the knots.
        knots: Rising, at least one.
        stride: A positive integer.
        wants_rest: Whether anything reads the rest; what is printed for people has no name that nothing reads.
    """

    name: str
    rest: str
    x: Expr
    table: str
    knots: tuple[float, ...]
    stride: int
    wants_rest: bool = True


@record(frozen=True, slots=True)
class Offset:
    """Give a name to an integer: the sum of other integers, each times a constant."""

    name: str
    parts: tuple[tuple[str, int], ...]


@record(frozen=True, slots=True)
class Row:
    """Give names to a row of a constant table; only generated Python has rows, see `python_rows`.

    Args:
        names: One for each number of the row.
        table: Name of the array, which holds rows there.
        place: Name of the integer that says which row.
    """

    names: tuple[str, ...]
    table: str
    place: str


@record(frozen=True, slots=True)
class Branches:
    """Give names to values that depend on where an atom lies; only generated Python has branches.

    Args:
        names: What is given a value.
        x: The atom.
        cuts: Rising; values change there, and at a cut those to its right count.
        values: For each stretch between cuts, and beyond them, one value for each name.
    """

    names: tuple[str, ...]
    x: Expr
    cuts: tuple[float, ...]
    values: tuple[tuple[Expr, ...], ...]


@record(frozen=True, slots=True)
class Guarded:
    """Run statements only where a value is not 0; only generated Python has branches.

    Args:
        name: The value.
        body: What is run.
    """

    name: str
    body: tuple[Assign, ...]


@record(frozen=True, slots=True)
class Accumulate:
    """Add up over the entries of constant tables.

    Args:
        count: Number of entries.
        counter: Name of the position.
        body: Assignments for each entry.
        sums: Names of the sums with what each entry adds; they begin at 0.
    """

    count: int
    counter: str
    body: tuple[Assign, ...]
    sums: tuple[Assign, ...]


@record(frozen=True, slots=True)
class Fold:
    """Carry values along the entries of constant tables: what a sum is not enough for.

    Args:
        count: Number of entries.
        counter: Name of the position.
        first: Names of what is carried, with what it is at first.
        body: Assignments for each entry, from what is carried so far.
        then: The same names as in `first`, with what is carried on; names and numbers that none of the names changes.
    """

    count: int
    counter: str
    first: tuple[Assign, ...]
    body: tuple[Assign, ...]
    then: tuple[Assign, ...]


@record(frozen=True, slots=True)
class Between:
    """Interpolate between two values that the same statements compute; only the kernels' own programs have these.

    Args:
        name: Name of the result: the first value + share · (the second one - the first one).
        side: Name of the counter, an integer: 0 for the first value, 1 for the second one.
        share: How far the result lies from the first value to the second one, an atom.
        body: Statements for each side, among them others of this kind.
        value: What they compute, an atom.
    """

    name: str
    side: str
    share: Expr
    body: tuple[Assign | Offset | Between, ...]
    value: Expr


@record(frozen=True, slots=True)
class Quadrature:
    """Integrate a set that depends on a place, from the first to the last entry of a constant table; see `quadrature`.

    Args:
        found: Name of what is found: the first moment about 0, or the place up to which the area is half.
        area: Name of the area.
        kind: Name of the function: `moments` or `half`.
        x: Name of the place.
        body: Assignments for each place.
        value: The degree there.
        given: Names that body and value read besides the place.
        places: Name of the table, whose entries rise.
        marks: Atoms between the first and the last entry, where the set may bend or jump.
    """

    found: str
    area: str
    kind: str
    x: str
    body: tuple[Assign | Locate, ...]
    value: Expr
    given: tuple[str, ...]
    places: str
    marks: tuple[Expr, ...]

    @property
    def function(self) -> str:
        """The name of the set as a function."""
        return f"set_{self.found}"


@record(frozen=True, slots=True)
class Refuse:
    """Stop where a condition holds: no rule fires for an output that says `else error`."""

    condition: Expr
    output: str

    @property
    def message(self) -> str:
        """What compiled code, whose exceptions are constants, can say."""
        return f"no rule fires for output '{self.output}'"


Statement = Assign | Locate | Offset | Row | Branches | Guarded | Accumulate | Fold | Between | Quadrature | Refuse


@record(frozen=True)
class Program:
    """A function as a list of statements.

    Args:
        arguments: Names of its scalar arguments, the raw inputs.
        state: Length of the array argument `C` with the adaptive consequents; 0 for none.
        tables: Constant arrays by name.
        body: Statements; every name is assigned once.
        results: What it returns, one expression for each output, or stores, one for each entry of the state.
    """

    arguments: tuple[str, ...]
    state: int
    tables: tuple[tuple[str, tuple[float, ...]], ...]
    body: tuple[Statement, ...]
    results: tuple[Expr, ...]


#: Name of the array argument that holds the adaptive consequents.
STATE: Final = "C"


class Builder:
    """Write a program: names for values, each value computed once.

    Args:
        most_pairs: Above how many pairs of lines an exact centroid is an adaptive integral, and terms of many corners
            stand in tables; None where neither is available, in analyses and in other languages.
    """

    def __init__(self, *, most_pairs: int | None = None) -> None:
        self.most_pairs = most_pairs
        self.statements: list[Statement] = []
        self.tables: dict[str, tuple[float, ...]] = {}
        self._known: dict[Expr, Expr] = {}
        self._fresh = count(1)
        self._places: dict[tuple[Expr, tuple[float, ...]], tuple[str, Expr]] = {}

    def inner(self) -> Builder:
        """Return a builder for the body of a loop; it shares names and tables."""
        builder = Builder(most_pairs=self.most_pairs)
        builder.tables, builder._fresh = self.tables, self._fresh
        return builder

    def located(self, x: Expr, knots: tuple[float, ...]) -> tuple[str, Expr]:
        """Return the name of the position of the knot at or below an atom, and how far the atom lies beyond it."""
        if (x, knots) not in self._places:
            name, rest = self.fresh(), self.fresh()
            self.statements.append(Locate(name, rest, x, self.table(knots), knots, 1))
            self._places[x, knots] = name, Name(rest)
        return self._places[x, knots]

    def let(self, value: Expr) -> Expr:
        """Return a name or a number that stands for a value."""
        value = self.flat(value)
        if is_atom(value):
            return value
        if depth(value) > DEEPEST:
            value, _ = self._shallow(value)
        if value not in self._known:
            name = self.fresh()
            self.statements.append(Assign(name, value))
            self._known[value] = Name(name)
        return self._known[value]

    def _shallow(self, value: Expr) -> tuple[Expr, int]:
        """Return a value, and its depth, with names for its deep parts.

        Choices stay whole: only the chosen side may be computed.
        """
        if not isinstance(value, Binary | Call | Negate):
            return value, depth(value)
        parts: list[Expr] = []
        deepest = 0
        for part in children(value):
            own, height = self._shallow(part)
            if height >= DEEPEST:
                own, height = self.let(own), 0
            parts.append(own)
            deepest = max(deepest, height)
        match value:
            case Binary(op=op):
                return Binary(op, parts[0], parts[1]), deepest + 1
            case Call(function=function):
                return Call(function, tuple(parts)), deepest + 1
        return -parts[0], deepest + 1

    def flat(self, value: Expr) -> Expr:
        """Return a value in which `min` and `max` are pairs of atoms, and `sign` and comparisons are choices.

        Printers write those as comparisons, which name each operand twice.
        """

        def change(node: Expr) -> Expr:
            match node:
                case Call(function="min" | "max" as function, arguments=arguments):
                    return reduce(lambda a, b: Call(function, (self.let(a), self.let(b))), arguments)
                case Call(function="clip", arguments=(x, low, high)):
                    return Call("clip", (self.let(x), low, high))
                case Binary(op="*", left=left, right=right) if left == right and not is_atom(left):
                    root = self.let(left)
                    return root * root
                case Call(function="sign", arguments=(x,)):
                    x = self.let(x)
                    negative = Where(Compare("<", x, ZERO), Number(-1.0), times(x, ZERO))
                    return Where(Compare(">", x, ZERO), ONE, negative)
                case Call(function=function, arguments=arguments) if function in SOFT:
                    return step(function, arguments, self.let)
            return node

        return replace(value, change)

    def fresh(self) -> str:
        """Return a name that is not taken."""
        return f"v{next(self._fresh)}"

    def table(self, values: Iterable[float]) -> str:
        """Return the name of a constant array."""
        content = tuple(values)
        for name, known in self.tables.items():
            if known == content:
                return name
        name = f"T{len(self.tables)}"
        self.tables[name] = content
        return name

    def total(self, terms: Iterable[Expr]) -> Expr:
        """Return the sum of some values, 0 for none."""
        total: Expr = ZERO
        for k, part in enumerate(t for t in terms if t != ZERO):
            # Named now and then, so that no sum is deep; the order of the additions stays.
            total = plus(total if k % SUMMANDS else self.let(total), part)
        return self.let(total)

    def largest(self, terms: Iterable[Expr]) -> Expr:
        """Return the largest of some values, 0 for none."""
        parts = list(terms)
        return self.let(Call("max", tuple(parts))) if parts else ZERO

    def smallest(self, terms: Iterable[Expr]) -> Expr:
        """Return the smallest of some values, 0 for none."""
        parts = list(terms)
        return self.let(Call("min", tuple(parts))) if parts else ZERO


def speculated(program: Program) -> Program:
    """Return the same program with both sides of every choice computed beforehand.

    Compilers turn choices between values at hand into selections, and only loops without branches are vectorised. For
    targets where a quotient by zero is harmless.
    """
    builder = Builder()
    builder.tables = dict(program.tables)

    def change(node: Expr) -> Expr:
        if isinstance(node, Where):
            return Where(node.condition, _named(builder, node.then), _named(builder, node.otherwise))
        return node

    for statement in program.body:
        match statement:
            case Assign(name=name, value=value):
                builder.statements.append(Assign(name, replace(value, change)))
            case _:
                builder.statements.append(statement)
    results = tuple(replace(r, change) for r in program.results)
    return Program(program.arguments, program.state, program.tables, tuple(builder.statements), results)


def _named(builder: Builder, value: Expr) -> Expr:
    if is_atom(value):
        return value
    name = f"s{next(builder._fresh)}"
    builder.statements.append(Assign(name, value))
    return Name(name)


def is_atom(value: Expr) -> bool:
    """Return whether a value costs nothing to write twice."""
    return isinstance(value, Name | Number | Item)


def depth(value: Expr) -> int:
    """Return how deep an expression is nested, 0 for an atom."""
    level, deepest = [value], -1
    while level:
        deepest += 1
        level = [part for node in level for part in children(node)]
    return deepest


def plus(a: Expr, b: Expr) -> Expr:
    """Return a + b without what adds nothing."""
    return b if a == ZERO else a if b == ZERO else a + b


def minus(a: Expr, b: Expr) -> Expr:
    """Return a - b without what takes nothing."""
    return a if b == ZERO else a - b


def times(a: Expr, b: Expr) -> Expr:
    """Return a · b; a factor 1 is left out."""
    if a == ONE:
        return b
    if b == ONE:
        return a
    return a * b


def clip(x: Expr, lower: float | Expr, upper: float | Expr) -> Expr:
    """Return an atom held within a range of numbers or atoms; NaN stays NaN."""
    low, high = (end if isinstance(end, Expr) else Number(end) for end in (lower, upper))
    return Call("clip", (x, low, high))


def any_nan(names: Iterable[Expr]) -> Expr:
    """Return whether some value is NaN, the only number that differs from itself."""
    tests = tuple(Compare("!=", x, x) for x in names)
    return tests[0] if len(tests) == 1 else Logic("or", tests)
