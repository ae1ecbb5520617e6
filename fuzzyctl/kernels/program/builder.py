"""Builder of programs: names for values, each value computed once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import reduce
from itertools import count
from typing import Final

from fuzzyctl.expr import (
    COMPARISONS,
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
    plus,
    replace,
    times,
)
from fuzzyctl.kernels.program.program import Assign, Item, Locate, Place, Program, Statement

_HALF: Final = Number(0.5)


def step(function: str, arguments: Sequence[Expr], let: Callable[[Expr], Expr]) -> Expr:
    """Return a function of `expr.SOFT` as a choice over `floor` and `fmod`.

    Args:
        function: Its name.
        arguments: Its arguments.
        let: Names a value, so that it is computed once.
    """
    a, *others = (let(x) for x in arguments)
    match function, others:
        case "ceil", []:
            return -Call("floor", (-a,))
        case "round", []:
            return _rounded(a, let)
        case "mod", [b]:
            rest = let(Call("fmod", (a, b)))
            below = Logic("and", (Compare("<", rest, ZERO), Compare(">", b, ZERO)))
            above = Logic("and", (Compare(">", rest, ZERO), Compare("<", b, ZERO)))
            return Where(Logic("or", (below, above)), rest + b, rest)
        case "ne", [b]:  # without "!=", which some targets cannot tell from a test for NaN
            return Where(Compare("==", a, b), ZERO, ONE)
        case _, [b] if function in COMPARISONS:
            return Where(Compare(COMPARISONS[function], a, b), ONE, ZERO)
    return Call(function, (a, *others))


def _rounded(x: Expr, let: Callable[[Expr], Expr]) -> Expr:
    """Return the nearest whole number; halfway between two the even one, which is twice another."""
    below = let(Call("floor", (x,)))
    rest = let(x - below)
    half = let(_HALF * below)
    ties = Logic("and", (Compare("==", rest, _HALF), Compare("==", Call("floor", (half,)), half)))
    stays = Logic("or", (Compare("<", rest, _HALF), ties))
    # Where there is nothing beyond a whole number, it is that one, or x is infinite or NaN.
    up = Where(Compare(">", rest, ZERO), below + 1.0, below)
    return Where(Logic("and", (Compare(">", rest, ZERO), stays)), below, up)


#: Deeper expressions are written as several statements, since parsers stop at some depth (CPython's at 200).
DEEPEST: Final = 40
#: Function of programs: the value of the last of some places at or below the first argument; behind it places, rising,
#: each with its value.
LAST_ENTRY: Final = "last_entry"
#: Most values added up in one statement.
SUMMANDS: Final = 32


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
        """Return an atom for a value: itself, or the name that is assigned to it."""
        if is_atom(value):
            return value
        value = self.flat(value)
        if is_atom(value):
            return value
        if depth(value) > DEEPEST:
            value, _ = self._shallow(value)
        atom = self._known.get(value)
        if atom is None:
            atom = self._known[value] = Name(self.fresh())
            self.statements.append(Assign(atom.name, value))
        return atom

    def _shallow(self, value: Expr) -> tuple[Expr, int]:
        """Return a value, and its depth, with names for its deep parts.

        Choices stay whole: only the chosen side may be computed.
        """
        if not isinstance(value, Binary | Call | Negate):
            return value, depth(value)
        parts: list[Expr] = []
        deepest = 0
        for part in children(value):
            shallow, height = self._shallow(part)
            if height >= DEEPEST:
                shallow, height = self.let(shallow), 0
            parts.append(shallow)
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

        return replace(value, self._flat_node)

    def _flat_node(self, node: Expr) -> Expr:
        if isinstance(node, Name | Number):  # most are
            return node
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
            case Call(function=function, arguments=(x, *entries)) if function == LAST_ENTRY:
                numbers = [e.value for e in entries if isinstance(e, Number)]
                place, _ = self.located(self.let(x), tuple(numbers[::2]))
                return Item(self.table(numbers[1::2]), Place(place))
            case Call(function=function, arguments=arguments) if function in SOFT:
                return step(function, arguments, self.let)
        return node

    def fresh(self) -> str:
        """Return a name that is not taken."""
        return f"v{next(self._fresh)}"

    def table(self, values: Iterable[float]) -> str:
        """Return the name of a constant array."""
        content = tuple(values)
        for name, constants in self.tables.items():
            if constants == content:
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

    def program(self, arguments: Iterable[Name], results: Iterable[Expr], *, state: int = 0) -> Program:
        """Return the statements as a program; `state` is the length of its array argument."""
        names, tables = tuple(x.name for x in arguments), tuple(self.tables.items())
        return Program(names, state, tables, tuple(self.statements), tuple(results))

    def smallest(self, terms: Iterable[Expr]) -> Expr:
        """Return the smallest of some values, 0 for none."""
        parts = list(terms)
        return self.let(Call("min", tuple(parts))) if parts else ZERO


def is_atom(value: Expr) -> bool:
    """Return whether a value costs nothing to write twice."""
    return isinstance(value, Name | Number | Item)


def depth(value: Expr) -> int:
    """Return how deep an expression is nested, 0 for an atom."""
    deepest, level = 0, children(value)
    while level:
        deepest += 1
        below: list[Expr] = []
        for node in level:
            if not isinstance(node, Name | Number):
                below += children(node)
        level = tuple(below)
    return deepest


def clip(x: Expr, lower: float | Expr, upper: float | Expr) -> Expr:
    """Return an atom held within a range of numbers or atoms; NaN stays NaN."""
    low, high = (end if isinstance(end, Expr) else Number(end) for end in (lower, upper))
    return Call("clip", (x, low, high))


def any_nan(names: Iterable[Expr]) -> Expr:
    """Return whether some value is NaN, the only number that differs from itself."""
    tests = tuple(Compare("!=", x, x) for x in names)
    return tests[0] if len(tests) == 1 else Logic("or", tests)


def sorted_atoms(builder: Builder, values: Sequence[Expr]) -> list[Expr]:
    """Write atoms in rising order, by the merge exchange of Batcher (Knuth, volume 3, 5.2.2, algorithm M)."""
    atoms = list(values)
    for i, j in _exchanges(len(atoms)):
        low, high = (builder.let(Call(f, (atoms[i], atoms[j]))) for f in ("min", "max"))
        atoms[i], atoms[j] = low, high
    return atoms


def _exchanges(count: int) -> Iterator[tuple[int, int]]:
    top = 1 << max(0, (count - 1).bit_length() - 1)
    p = top if count > 1 else 0
    while p > 0:
        q, r, d = top, 0, p
        while True:
            yield from ((i, i + d) for i in range(count - d) if i & p == r)
            if q == p:
                break
            d, q, r = q - p, q // 2, p
        p //= 2
