"""Derivatives of programs: forward mode, along the chosen arguments."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from fuzzyctl.expr import (
    ONE,
    ZERO,
    Binary,
    Call,
    Compare,
    CompareOp,
    Expr,
    Logic,
    Name,
    Negate,
    Number,
    Where,
    minus,
    plus,
    times,
    walk,
)
from fuzzyctl.kernels.program.builder import is_atom
from fuzzyctl.kernels.program.program import (
    NAN,
    Accumulate,
    Assign,
    Crossings,
    Fold,
    Item,
    Locate,
    Offset,
    Program,
    Quadrature,
    Refuse,
    Statement,
)
from fuzzyctl.kernels.program.traversal import locals_of, needed, parts, reads, rebuilt, renamed, statements, writes

#: Derivatives of a value by the position of the argument, without those that are 0 everywhere.
Derivatives = Mapping[int, Expr]


class NotDifferentiableError(ValueError):
    """Raised for a statement that has no derivative in the intermediate language, with the reason."""


def differentiated(program: Program, by: Sequence[str]) -> Program:
    """Return the program of the derivatives of each result, one after the other, by some arguments.

    Args:
        program: A program without loops over corners.
        by: Names of arguments.

    Raises:
        NotDifferentiableError: For another program.
    """
    tape = _Tape({name: {k: ONE} for k, name in enumerate(by)})
    for statement in program.body:
        tape.copy(statement)
    derivatives = [tape.derivatives(r) for r in program.results]
    results = tuple(row.get(k, ZERO) for row in derivatives for k in range(len(by)))
    return replace(program, body=tuple(tape.body), results=results)


@dataclass
class _Tape:
    """Statements of a program with those of its derivatives."""

    known: dict[str, Derivatives]
    body: list[Statement] = field(default_factory=list)
    count: int = 0
    _written: dict[Expr, Expr] = field(default_factory=dict)

    def copy(self, statement: Statement) -> None:
        """Copy a statement, and write the derivatives of its values."""
        match statement:
            case Assign(name=name, value=value):
                self.body.append(statement)
                self.known[name] = self.derivatives(value)
            case Refuse() | Offset():
                self.body.append(statement)
            case Locate(rest=rest, x=x, knots=knots):
                self.body.append(statement)
                inside = Logic("and", (Compare(">=", x, Number(knots[0])), Compare("<=", x, Number(knots[-1]))))
                self.known[rest] = {k: self.let(Where(inside, d, ZERO)) for k, d in self.derivatives(x).items()}
            case Accumulate():
                self.fold(statement.fold)
            case Fold():
                self.fold(statement)
            case Quadrature():
                self.body.append(statement)
                self.known |= self.integral(statement)
            case _:
                raise NotDifferentiableError(type(statement).__name__)

    def fold(self, loop: Fold) -> None:
        """Carry derivatives along with the values; those by an argument that does not occur in the loop are 0."""
        first = {s.name: self.derivatives(s.value) for s in loop.first}
        wanted = sorted({k for own in first.values() for k in own} | self._read(loop))
        carried = {s.name: {k: Name(self.fresh()) for k in wanted} for s in loop.first}
        inner = _Tape({**self.known, **carried}, count=self.count)
        for statement in loop.body:
            inner.copy(statement)
        then = [s if is_atom(s.value) else Assign(s.name, inner.let(s.value)) for s in loop.then]
        moved: list[Assign] = []
        for original, s in zip(loop.then, then, strict=True):
            own = inner.derivatives(original.value)
            moved += [Assign(carried[s.name][k].name, own.get(k, ZERO)) for k in wanted]
        moved = [Assign(s.name, inner.copied(s.value)) for s in moved]
        self.count = inner.count
        start = [Assign(carried[s.name][k].name, first[s.name].get(k, ZERO)) for s in loop.first for k in wanted]
        assigned = tuple(s for s in inner.body if isinstance(s, Assign))
        self.body.append(Fold(loop.count, loop.counter, (*loop.first, *start), assigned, (*then, *moved)))
        self.known |= carried

    def integral(self, whole: Quadrature) -> dict[str, Derivatives]:
        """Integrate the derivatives of a set, along each argument the same function of other slopes of the arguments.

        A set that bends moves its bends without changing the integral, which is why only jumps have a share of theirs.
        The set itself is added, in the size of the slopes, and taken off again: it shows bends between which the
        derivative may be 0 at all nodes.
        """
        moved = [n for n in whole.given if self.known.get(n)]
        by_name: dict[str, dict[int, Expr]] = {whole.found: {}, whole.area: {}}
        for k in sorted({k for n in moved for k in self.known[n]}):
            slopes = {n: self.named(self.known[n].get(k, ZERO)) for n in moved}
            size = self.named(self._total([self._finite(s) for s in slopes.values()]))
            inner = _Tape({n: {0: s} for n, s in slopes.items()}, count=self.count)
            for statement in whole.body:
                inner.copy(statement)
            slope = inner.let(plus(inner.derivatives(whole.value).get(0, ZERO), size * whole.value))
            arguments = (*whole.given, *(s.name for s in slopes.values()), size.name)
            self.count = inner.count
            of_set = replace(whole, kind="moments", body=tuple(inner.body), value=slope, given=arguments)
            of_jumps = self._of_jumps(replace(whole, given=arguments), slopes)
            moment, area = self._integrated(of_set, of_jumps)
            by_name[whole.area][k] = self.let(area - self.let(size * Name(whole.area)))
            if whole.kind == "half":
                by_name[whole.found][k] = self._of_half(whole, of_set, of_jumps)
            else:
                by_name[whole.found][k] = self.let(moment - self.let(size * Name(whole.found)))
        return dict(by_name)

    def _of_half(self, whole: Quadrature, of_set: Quadrature, of_jumps: Quadrature | None) -> Expr:
        """Return the derivative of the place where the area to the left is half of all; NaN at a gap, where it jumps.

        It moves by half of the change of the area to its right less that to its left, over the degree there.
        """
        place = Name(whole.found)

        def sides(integral: Quadrature) -> Quadrature:
            side = Where(Compare(">", Name(whole.x), place), integral.value, -integral.value)
            marks = () if integral.crossings else (*whole.marks, place)
            return replace(integral, value=side, marks=marks, given=(*integral.given, whole.found))

        _, more = self._integrated(sides(of_set), of_jumps and sides(of_jumps))
        degree = self._at(whole, place)
        slope = self.let(Number(0.5) / self.let(Where(Compare(">", degree, ZERO), degree, NAN)))
        return self._steep(more, slope)

    def _of_jumps(self, whole: Quadrature, slopes: Mapping[str, Name]) -> Quadrature | None:
        """Return the integral of the jumps of a set that move, None for a set without such jumps."""
        compared = comparisons(whole)
        if not compared:
            return None
        tape = _Tape({n: {1: s} for n, s in slopes.items()} | {whole.x: {0: ONE}}, count=self.count)
        for statement in whole.body:
            tape.copy(statement)
        values: list[Expr] = []
        for condition in compared:
            gap = minus(condition.left, condition.right)
            changes = tape.derivatives(gap)
            if len(changes) == 2:
                values += [tape.let(Where(condition, ONE, ZERO)), tape.let(gap), changes[0], changes[1]]
        self.count = tape.count
        crossings = Crossings(needed(tape.body, values), tuple(values))
        return replace(whole, kind="jumps", marks=(), crossings=crossings) if values else None

    def _at(self, whole: Quadrature, place: Name) -> Expr:
        """Write the degree of a set at a place."""
        inside = set().union(*(writes(s) | locals_of(s) for s in whole.body))
        names = {whole.x: place.name} | {n: self.fresh() for n in sorted(inside)}

        def name(local: str) -> str:
            return names.get(local, local)

        self.body += [rebuilt(s, lambda value: renamed(value, name), name) for s in whole.body]
        return self.let(renamed(whole.value, name))

    def _finite(self, slope: Expr) -> Expr:
        size = self.let(Call("abs", (slope,)))
        return self.let(Where(Compare("<", size, Number(math.inf)), size, ZERO))

    def _total(self, parts: Sequence[Expr]) -> Expr:
        total: Expr = ZERO
        for part in parts:
            total = self.let(plus(total, part))
        return total

    def _integrated(self, *integrals: Quadrature | None) -> tuple[Expr, Expr]:
        """Return moment and area of some integrals together."""
        moments: list[Expr] = []
        areas: list[Expr] = []
        for integral in integrals:
            if integral is not None:
                moment, area = self.fresh(), self.fresh()
                self.body.append(replace(integral, found=moment, area=area))
                moments.append(Name(moment))
                areas.append(Name(area))
        return self._total(moments), self._total(areas)

    def _read(self, loop: Fold) -> set[int]:
        return {k for name in reads(loop) for k in self.known.get(name, {})}

    def fresh(self) -> str:
        self.count += 1
        return f"g{self.count}"

    def let(self, value: Expr) -> Expr:
        """Return a name for a value."""
        if is_atom(value):
            return value
        if value not in self._written:
            name = self.fresh()
            self.body.append(Assign(name, value))
            self._written[value] = Name(name)
        return self._written[value]

    def copied(self, value: Expr) -> Expr:
        """Return a name of its own for a value, which keeps it when others change."""
        return value if isinstance(value, Number) else self.named(value)

    def named(self, value: Expr) -> Name:
        """Return a name of its own for a value, a number too."""
        name = self.fresh()
        self.body.append(Assign(name, value))
        return Name(name)

    def derivatives(self, value: Expr) -> Derivatives:
        """Write the derivatives of a value and return them as atoms."""
        match value:
            case Number(value=number):
                return dict.fromkeys(self._all(), NAN) if math.isnan(number) else {}
            case Name(name=name):
                return self.known.get(name, {})
            case Item():
                return {}
            case Negate(operand=operand):
                return {k: self.let(-d) for k, d in self.derivatives(operand).items()}
            case Binary():
                return self._of_binary(value)
            case Where(condition=condition, then=then, otherwise=otherwise):
                return self._branch(condition, then, otherwise)
            case Call(function=function, arguments=arguments):
                return self._of_call(function, arguments)
        raise NotDifferentiableError(type(value).__name__)

    def _all(self) -> list[int]:
        return sorted({k for row in self.known.values() for k in row})

    def _branch(self, condition: Expr, then: Expr, otherwise: Expr) -> Derivatives:
        """Differentiate a choice: where both values are equal ahead of the point, elsewhere in the branch taken."""
        changes, others = self.derivatives(then), self.derivatives(otherwise)
        if NAN in (then, otherwise) or changes == others:
            return self._chosen(lambda _: condition, changes, others)
        ahead, level = self._ahead(condition), Compare("==", self.let(then), self.let(otherwise))

        def chosen(k: int) -> Expr:
            found, apart = ahead(k), Logic("and", (Logic("not", (level,)), condition))
            return found if found == condition else Logic("or", (Logic("and", (level, found)), apart))

        return self._chosen(chosen, changes, others)

    def _chosen(self, condition: Callable[[int], Expr], then: Derivatives, otherwise: Derivatives) -> Derivatives:
        keys = [*then, *(k for k in otherwise if k not in then)]
        pairs = {k: (then.get(k, ZERO), otherwise.get(k, ZERO)) for k in keys}
        return {k: a if a == b else self.let(Where(condition(k), a, b)) for k, (a, b) in pairs.items()}

    def _ahead(self, condition: Expr) -> Callable[[int], Expr]:
        """Return a condition after a small growth of argument k."""
        match condition:
            case Logic(op=joint, operands=operands):
                parts = [self._ahead(o) for o in operands]
                return lambda k: Logic(joint, tuple(part(k) for part in parts))
            case Compare(op=op, left=left, right=right) if left != right:
                sides = self.let(left), self.let(right)
                return _compared(op, sides, (self.derivatives(left), self.derivatives(right)))
        return lambda _: condition

    def _of_binary(self, value: Binary) -> Derivatives:
        a, b = self.derivatives(value.left), self.derivatives(value.right)
        if not a and not b:
            return {}
        keys = [*a, *(k for k in b if k not in a)]
        left, right = self.let(value.left), self.let(value.right)
        match value.op:
            case "+":
                return {k: self.let(plus(a.get(k, ZERO), b.get(k, ZERO))) for k in keys}
            case "-":
                return {k: self._difference(a.get(k, ZERO), b.get(k, ZERO)) for k in keys}
            case "*":
                return self._sum(keys, (a, right), (b, left))
            case "/":
                quotient = self.let(value)
                parts = {k: self._difference(a.get(k, ZERO), self._product(b.get(k, ZERO), quotient)) for k in keys}
                return {k: self.let(p / right) for k, p in parts.items()}
        return self._power(value, (left, a), (right, b))

    def _power(self, value: Expr, base: tuple[Expr, Derivatives], exponent: tuple[Expr, Derivatives]) -> Derivatives:
        """Differentiate a power; by the exponent where the base is above 0, elsewhere it is 0."""
        (left, a), (right, b) = base, exponent
        slope = self.let(
            right * self.let(left ** (right.value - 1.0 if isinstance(right, Number) else self.let(right - 1.0)))
        )
        growth = self.let(
            Where(Compare(">", left, ZERO), self.let(self.let(value) * self.let(Call("log", (left,)))), ZERO)
        )
        changes = {k: self._steep(d, slope) for k, d in a.items()}
        return self._sum([*changes, *(k for k in b if k not in changes)], (changes, ONE), (b, growth))

    def _of_call(self, function: str, arguments: Sequence[Expr]) -> Derivatives:
        changes = [self.derivatives(a) for a in arguments]
        if not any(changes):
            return {}
        atoms = [self.let(a) for a in arguments]
        value = self.let(Call(function, tuple(atoms)))
        match function, atoms:
            case (("min" | "smaller"), [a, b]):
                return self._chosen(_compared("<", (a, b), (changes[0], changes[1])), changes[0], changes[1])
            case (("max" | "larger"), [a, b]):
                return self._chosen(_compared(">", (a, b), (changes[0], changes[1])), changes[0], changes[1])
            case "clip", [x, low, high]:
                return self._clipped((x, low, high), changes)
            case "held", [x]:
                return self._clipped((x, ZERO, ONE), (changes[0], {}, {}))
            case "abs", [x]:
                falling = {k: self.let(-d) for k, d in changes[0].items()}
                return self._chosen(_compared("<", (x, ZERO), (changes[0], {})), falling, changes[0])
            case "divide", _:
                return self._of_binary(Binary("/", arguments[0], arguments[1]))
            case "power", [a, b]:
                return self._power(value, (a, changes[0]), (b, changes[1]))
            case "fmod", [a, b]:
                whole = self.let(self.let(value - a) / b)
                return self._sum(
                    [*changes[0], *(k for k in changes[1] if k not in changes[0])],
                    (changes[0], ONE),
                    (changes[1], whole),
                )
            case "atan2", [y, x]:
                size = self.let(self.let(y * y) + self.let(x * x))
                by_y, by_x = self.let(x / size), self.let(self.let(-y) / size)
                return self._sum(
                    [*changes[0], *(k for k in changes[1] if k not in changes[0])],
                    (changes[0], by_y),
                    (changes[1], by_x),
                )
            case _, [x] if function in STEPS:
                return {}
            case _, [x] if function in SLOPES:
                slope, is_steep = SLOPES[function](x, value, self.let), function in STEEP
                return {
                    k: self._steep(d, slope) if is_steep else self._product(d, slope) for k, d in changes[0].items()
                }
        raise NotDifferentiableError(function)

    def _clipped(self, values: tuple[Expr, Expr, Expr], changes: Sequence[Derivatives]) -> Derivatives:
        """Differentiate a value that is held within a range."""
        (x, low, high), (of_x, of_low, of_high) = values, changes
        inner = self._chosen(_compared(">", (x, high), (of_x, of_high)), of_high, of_x)
        return self._chosen(_compared("<", (x, low), (of_x, of_low)), of_low, inner)

    def _sum(self, keys: Sequence[int], *parts: tuple[Derivatives, Expr]) -> Derivatives:
        """Return for each argument the sum of derivatives times factors."""
        totals: dict[int, Expr] = {}
        for k in keys:
            total: Expr = ZERO
            for part, factor in parts:
                total = self.let(plus(total, self._product(part.get(k, ZERO), factor)))
            totals[k] = total
        return totals

    def _product(self, a: Expr, b: Expr) -> Expr:
        return ZERO if ZERO in (a, b) else self.let(times(a, b))

    def _steep(self, a: Expr, slope: Expr) -> Expr:
        """Return a · slope, 0 if a is 0: a constant has no slope, however steep the function is there."""
        return self.let(Where(Compare("==", a, ZERO), ZERO, self.let(times(a, slope))))

    def _difference(self, a: Expr, b: Expr) -> Expr:
        return self.let(-b) if a == ZERO else self.let(minus(a, b))


def _compared(
    op: CompareOp, sides: tuple[Expr, Expr], changes: tuple[Derivatives, Derivatives]
) -> Callable[[int], Expr]:
    """Return the value of a comparison after argument k has grown a little: for equal sides the changes decide."""
    now, tie = Compare(op, *sides), Compare("==", *sides)

    def ahead(k: int) -> Expr:
        left, right = (own.get(k, ZERO) for own in changes)
        if left == right:
            return now
        match op:
            case "==":
                return Logic("and", (tie, Compare("==", left, right)))
            case "!=":
                return Logic("or", (now, Compare("!=", left, right)))
        beyond = Compare("<" if op in ("<", "<=") else ">", *sides)
        return Logic("or", (beyond, Logic("and", (tie, Compare(op, left, right)))))

    return ahead


#: Functions that are constant between their jumps.
STEPS: Final = ("floor",)

#: Functions whose slope may be infinite.
STEEP: Final = ("sqrt", "log")

#: From an atom, the value of the function there and a function that names a value, to the derivative.
SLOPES: Final[Mapping[str, Callable[[Expr, Expr, Callable[[Expr], Expr]], Expr]]] = {
    "sqrt": lambda x, value, let: let(Number(0.5) / value),
    "exp": lambda x, value, let: value,
    "log": lambda x, value, let: let(ONE / x),
    "sin": lambda x, value, let: let(Call("cos", (x,))),
    "cos": lambda x, value, let: let(-let(Call("sin", (x,)))),
    "tan": lambda x, value, let: let(1.0 + let(value * value)),
}


def comparisons(whole: Quadrature) -> list[Compare]:
    """Return the comparisons at which a set may jump, each before those that depend on it.

    The choice of the smaller or the larger of two values does not count.
    """
    values = [e for s in statements(whole.body) for e in parts(s).values]
    choices = [n for e in (*values, whole.value) for n in walk(e) if isinstance(n, Where) and not _is_extreme(n)]
    return list(dict.fromkeys(n for c in choices for n in walk(c.condition) if isinstance(n, Compare)))


def _is_extreme(choice: Where) -> bool:
    match choice.condition:
        case Compare(op=op, left=a, right=b) if op not in ("==", "!="):
            return {choice.then, choice.otherwise} == {a, b}
    return False
