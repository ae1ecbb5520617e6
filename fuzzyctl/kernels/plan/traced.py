"""Numbers that are known only at run time: arithmetic with them is recorded.

A plan and its program are made for given numbers. Free numbers go the same way as `Traced` objects: each operation adds
a definition, each comparison goes the way of the present value and adds a condition, under which the program holds for
other values as well.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from functools import reduce
from typing import Any, Final, cast

from fuzzyctl.diagnostics.diagnostic import ArgumentError, UnknownNameError
from fuzzyctl.expr import (
    CONSTANTS,
    ZERO,
    Binary,
    BinaryOp,
    Call,
    Compare,
    CompareOp,
    Expr,
    Name,
    Negate,
    Number,
    children,
    evaluate,
    names_in,
    replace,
    replace_names,
)
from fuzzyctl.model.system import FuzzySystem

_OPERATIONS: Final[dict[BinaryOp, Callable[[float, float], float]]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "^": lambda a, b: a**b,
}
_CLOSED: Final[dict[CompareOp, CompareOp]] = {"<": "<=", ">": ">="}
_INVERSE: Final[dict[CompareOp, CompareOp]] = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}


class NeedsNumberError(TypeError):
    """Raised where a number must be known before the program is written.

    Args:
        traced: The number.
    """

    def __init__(self, traced: Traced) -> None:
        super().__init__("the number must be known before the program is written")
        self.traced = traced


class Traced:
    """A number that is known only at run time.

    Args:
        trace: Records its use.
        name: Its name among the definitions.
        value: Its present value.
    """

    __slots__ = ("name", "trace", "value")

    def __init__(self, trace: Trace, name: str, value: float) -> None:
        self.trace, self.name, self.value = trace, name, value

    def __repr__(self) -> str:
        return f"Traced({self.name})"

    def __hash__(self) -> int:
        return hash(self.name)

    def __bool__(self) -> bool:
        return True

    def __float__(self) -> float:
        raise NeedsNumberError(self)

    def __add__(self, other: Any) -> Any:
        return self.trace.binary("+", self, other)

    def __radd__(self, other: Any) -> Any:
        return self.trace.binary("+", other, self)

    def __sub__(self, other: Any) -> Any:
        return self.trace.binary("-", self, other)

    def __rsub__(self, other: Any) -> Any:
        return self.trace.binary("-", other, self)

    def __mul__(self, other: Any) -> Any:
        return self.trace.binary("*", self, other)

    def __rmul__(self, other: Any) -> Any:
        return self.trace.binary("*", other, self)

    def __truediv__(self, other: Any) -> Any:
        return self.trace.binary("/", self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return self.trace.binary("/", other, self)

    def __pow__(self, other: Any) -> Any:
        return self * self if other == 2 else self.trace.binary("^", self, other)

    def __neg__(self) -> Traced:
        return self.trace.let(Negate(Name(self.name)), -self.value)

    def __abs__(self) -> Traced:
        return self.trace.let(Call("abs", (Name(self.name),)), abs(self.value))

    def __lt__(self, other: Any) -> bool:
        return self.trace.compare("<", self, other)

    def __le__(self, other: Any) -> bool:
        return self.trace.compare("<=", self, other)

    def __gt__(self, other: Any) -> bool:
        return self.trace.compare(">", self, other)

    def __ge__(self, other: Any) -> bool:
        return self.trace.compare(">=", self, other)

    def __eq__(self, other: object) -> bool:
        """Whether it is the same number whatever its value; programs for unequal numbers hold for equal ones, too."""
        same = isinstance(other, Traced) and other.name == self.name
        if not same and self.trace.strict and isinstance(other, Traced | float | int):
            return self.trace.compare("==", self, other)
        return same


class Trace:
    """Record of arithmetic with free numbers.

    Args:
        names: Of the free numbers.
        values: Their present values.

    Attributes:
        numbers: Numbers that depend on free ones, by the name of the param.
        definitions: Expressions over free numbers and earlier definitions, by name.
        conditions: Conditions under which the record is valid.
        strict: Whether a comparison for equality is recorded as well.
    """

    def __init__(self, names: Sequence[str], values: Sequence[float]) -> None:
        self.names = tuple(names)
        self.definitions: dict[str, Expr] = {}
        self.conditions: dict[Expr, None] = {}
        self.strict = False
        self._known: dict[Expr, Traced] = {}
        arguments = [Traced(self, f"p{k}", v) for k, v in enumerate(values)]
        self.arguments = tuple(Name(t.name) for t in arguments)
        self.numbers: dict[str, Traced] = dict(zip(names, arguments, strict=True))

    def concerns(self, expr: Expr) -> bool:
        """Return whether an expression depends on a free number."""
        return type(expr) is not Number and any(n in self.numbers for n in _names(expr))

    def number(self, expr: Expr, values: dict[str, float], guarded: Callable[[Expr], Expr]) -> Traced:
        """Return the value of an expression over params, which is finite."""
        if isinstance(expr, Name):
            return self.numbers[expr.name]
        numbers: dict[str, Expr] = {n: Number(v) for n, v in values.items()}
        numbers |= {n: Name(t.name) for n, t in self.numbers.items()}
        numbers |= {"inf": Number(math.inf), "pi": Number(math.pi)}
        result = self.let(guarded(replace_names(expr, numbers)), evaluate(expr, values))
        self.conditions[Compare("<", Call("abs", (Name(result.name),)), Number(math.inf))] = None
        return result

    def let(self, value: Expr, present: float) -> Traced:
        """Return the number that an expression defines."""
        if value not in self._known:
            name = f"n{len(self.definitions)}"
            self.definitions[name] = value
            self._known[value] = Traced(self, name, present)
        return self._known[value]

    def binary(self, op: BinaryOp, a: Any, b: Any) -> Any:
        """Return the result of an operation, a plain number where it is one whatever the values."""
        if isinstance(a, Expr) or isinstance(b, Expr):
            return NotImplemented
        a, b = (float(x) if isinstance(x, int | Fraction) else x for x in (a, b))
        simple = self._simplified(op, a, b)
        if simple is not None:
            return simple
        try:
            present = _OPERATIONS[op](_present(a), _present(b))
        except ZeroDivisionError:
            raise NeedsNumberError(a if isinstance(a, Traced) else b) from None
        if op == "/" and isinstance(b, Traced):
            self.require("!=", b, 0.0)
        return self.let(Binary(op, atom(a), atom(b)), present)

    def _simplified(self, op: BinaryOp, a: Traced | float, b: Traced | float) -> Traced | float | None:
        match op:
            case "-" if a == b:
                return 0.0
            case "/" if a == b:
                return 1.0
            case "+" | "-" if b == 0.0:
                return a
            case "+" if a == 0.0:
                return b
            case "+":
                return self._undone("-", b, a) or self._undone("-", a, b)
            case "*" if 0.0 in (a, b):
                return 0.0
            case "*" | "/" if b == 1.0:
                return a
            case "*" if a == 1.0:
                return b
            case "/" if a == 0.0:
                return 0.0
            case "*":
                return self._undone("/", a, b) or self._undone("/", b, a)
        return None

    def _undone(self, op: BinaryOp, result: Traced | float, by: Traced | float) -> Traced | float | None:
        """Return a of (a / b) b and of (a - b) + b, None for other operands."""
        definition = self.definitions.get(result.name) if isinstance(result, Traced) else None
        match definition:
            case Binary(op=found, left=left, right=right) if found == op and right == atom(by):
                return left.value if isinstance(left, Number) else self._named(left)
        return None

    def _named(self, name: Expr) -> Traced:
        assert isinstance(name, Name), "operands of definitions are atoms"
        definition = self.definitions.get(name.name)
        return (
            next(t for t in self.numbers.values() if t.name == name.name)
            if definition is None
            else self._known[definition]
        )

    def compare(self, op: CompareOp, a: Traced, b: Any) -> bool:
        """Return how a comparison goes with the present values, which from now on is a condition."""
        other = float(b) if isinstance(b, int | Fraction) else b
        present = _present(other)
        holds = _COMPARISONS[op](a.value, present)
        left, right = atom(a), atom(other)
        if left == right or math.isinf(present):
            return holds
        if a.value == present and not self.strict and op not in ("==", "!="):
            return self._untied(op, left, right)
        relation = op if holds else _INVERSE[op]
        # Comparisons hold at the ends as well; `binary` needs divisors that are not 0.
        self.conditions[Compare(relation if self.strict else _CLOSED.get(relation, relation), left, right)] = None
        return holds

    def require(self, op: CompareOp, a: object, b: float) -> None:
        """Add a condition on a number if it is free."""
        if isinstance(a, Traced):
            self.conditions[Compare(op, atom(a), Number(b))] = None

    def require_apart(self, before: Any, after: Any) -> None:
        """Add the condition that one number stays below another one if one of them is free.

        Raises:
            ArgumentError: For numbers that are equal: at a jump the formula is another one.
        """
        if not isinstance(before, Traced) and not isinstance(after, Traced):
            return
        if _present(before) == _present(after):
            number = before if isinstance(before, Traced) else after
            raise ArgumentError(f"{self._listed(number)} cannot be free: the set jumps there")
        self.conditions[Compare("<", atom(before), atom(after))] = None

    def refusal(self, needs: NeedsNumberError) -> ArgumentError:
        """Return why a number cannot be free: the value that depends on it before the program is written."""
        reason = (
            "exact bisectors, maxima, polygons and integrals of curved sets are worked out from the corners themselves"
        )
        return ArgumentError(f"{self._listed(needs.traced)} cannot be free: {reason}")

    def _listed(self, number: Traced) -> str:
        pairs = zip(self.names, self.sources(number.name), strict=True)
        return ", ".join(f"'{name}'" for name, depends in pairs if depends)

    def sources(self, name: str) -> tuple[bool, ...]:
        """Return for each free number whether a definition depends on it."""
        names, waiting = set[str](), [name]
        while waiting:
            current = waiting.pop()
            if current not in names:
                names.add(current)
                waiting += [n.name for n in names_in(self.definitions.get(current, ZERO))]
        return tuple(a.name in names for a in self.arguments)

    def _untied(self, op: CompareOp, left: Expr, right: Expr) -> bool:
        """Return how a comparison of two numbers goes that are equal at present: as the first such one decided."""
        if op in (">", ">="):
            left, right = right, left
        if Compare("<=", right, left) in self.conditions:
            return False
        self.conditions[Compare("<=", left, right)] = None
        return True

    @contextmanager
    def strictly(self) -> Iterator[None]:
        """Record comparisons for equality, too."""
        self.strict = True
        try:
            yield
        finally:
            self.strict = False


_COMPARISONS: Final[dict[CompareOp, Callable[[float, float], bool]]] = {
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
}


def atom(x: Any) -> Expr:
    """Return a number as an expression over the names of definitions."""
    return Name(x.name) if isinstance(x, Traced) else Number(x)


def is_free(x: object) -> bool:
    """Return whether a number is known only at run time."""
    return isinstance(x, Traced)


def least(values: Iterable[Any]) -> Any:
    """Return the least of some numbers, whatever the values of those that are free."""
    return _extreme("min", min, list(values))


def greatest(values: Iterable[Any]) -> Any:
    """Return the greatest of some numbers, whatever the values of those that are free."""
    return _extreme("max", max, list(values))


def _extreme(name: str, of_floats: Callable[[Iterable[float]], float], values: list[Any]) -> Any:
    traced = list(dict.fromkeys(v for v in values if isinstance(v, Traced)))
    plain = [v for v in values if not isinstance(v, Traced)]
    if not traced:
        return of_floats(plain)
    arguments = [*([Number(of_floats(plain))] if plain else []), *map(atom, traced)]
    present = of_floats([*plain, *(t.value for t in traced)])
    return traced[0].trace.let(Call(name, tuple(arguments)), present) if len(arguments) > 1 else traced[0]


def exact(x: Any) -> Fraction:
    """Return a number in rational arithmetic; a free one stays as it is."""
    return cast("Fraction", x) if isinstance(x, Traced) else Fraction(x)


def rounded(x: Any) -> float:
    """Return a number of rational arithmetic as a float; a free one stays as it is."""
    return cast("float", x) if isinstance(x, Traced) else float(x)


def _present(x: Any) -> float:
    return x.value if isinstance(x, Traced) else float(x)


def _names(expr: Expr) -> Iterator[str]:
    if isinstance(expr, Name):
        yield expr.name
    for part in children(expr):
        yield from _names(part)


#: Key of the trace among the values that are derived from a system with free numbers.
TRACE = "trace"


def guarded(expr: Expr) -> Expr:
    """Return an expression that a user wrote so that every target computes the same, and none raises.

    Quotients follow IEEE 754, and `min` and `max` compare, so that all targets agree where an operand has no value.
    """

    def change(node: Expr) -> Expr:
        match node:
            case Binary(op="/", left=left, right=right):
                return Call("divide", (left, right))
            case Call(function="min" | "max" as function, arguments=arguments):
                pair = "smaller" if function == "min" else "larger"
                return reduce(lambda a, b: Call(pair, (a, b)), arguments)
        return node

    return replace(expr, change)


def number_of(system: FuzzySystem, expr: Expr) -> float:
    """Compute an expression over the params; one that depends on free numbers is a `Traced`."""
    trace: Trace | None = system.derived.get(TRACE)
    if trace is not None and trace.concerns(expr):
        return cast("float", trace.number(expr, system.values, guarded))
    # + 0.0 makes -0.0 a plain zero, so that equal systems have equal plans.
    return float(system.number(expr)) + 0.0


def constants_of(system: FuzzySystem, hidden: set[str]) -> dict[str, Expr]:
    """Return params and named constants as numbers, without those that a variable of the same name hides."""
    trace: Trace | None = system.derived.get(TRACE)
    free = {} if trace is None else cast("dict[str, float]", trace.numbers)
    return {n: Number(v) for n, v in (CONSTANTS | system.values | free).items() if n not in hidden}


def require_known(expr: Expr, variables: set[str], numbers: dict[str, Expr]) -> None:
    """Raise `UnknownNameError` for a name that is neither a variable nor a number."""
    for name in names_in(expr):
        if name.name not in variables and name.name not in numbers:
            raise UnknownNameError("input", name.name, sorted(variables))


def over_inputs(system: FuzzySystem, expr: Expr, *, outputs: bool = False, more: Collection[str] = ()) -> Expr:
    """Return an expression over the names of inputs, lets, and perhaps outputs, params replaced by numbers."""
    inputs = {v.name for v in (*system.inputs, *system.lets, *(system.outputs if outputs else ()))} | set(more)
    numbers = constants_of(system, inputs)
    require_known(expr, inputs, numbers)
    return replace_names(expr, numbers)
