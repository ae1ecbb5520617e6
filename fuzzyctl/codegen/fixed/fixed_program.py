"""A step of a controller as operations that fixed point has: sums, products, choices, calls of systems."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Final, Literal

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Binary, Call, Compare, Expr, Logic, Name, Negate, Number, Where, span_of, walk
from fuzzyctl.kernels.plan.equations import Equation, Equations
from fuzzyctl.kernels.program.program import Assign, Program, Statement

Kind = Literal[
    "input", "slot", "constant", "scale", "+", "-", "*", "min", "max", "abs", "where",
    "compare", "compared", "and", "or", "not", "argument", "system", "output", "store",
]  # fmt: skip

#: Prefix of the names of calls of systems in the program, before their number.
SYSTEM: Final = "system "
#: Most operations: the slopes of all along all are computed.
MOST_OPERATIONS: Final = 1500
#: Largest whole power that is written as products.
_LARGEST_POWER: Final = 4
#: A comparison with its sides exchanged.
_MIRRORED: Final = {"<": ">", ">": "<", "<=": ">=", ">=": "<=", "==": "==", "!=": "!="}

Operator = Literal["<", "<=", ">", ">=", "==", "!="]
FLOAT: Final = "or write single precision with --float float"
#: Why the error of an integrator has no bound.
KEEPS_ERROR: Final = "it keeps its error, as an integrator does, and each step may add that of a rounding"
#: The replacement of `integral(x)`.
_AS_STATE: Final = (
    "write a state in its place, whose range it keeps and whose addend the format holds whole: "
    "'state sum in [-1, 1] = 0' and 'next sum = clamp(sum + x / 128, -1, 1)'"
)
#: States that operators keep are called after them.
_OPERATOR: Final = re.compile(r"(\w+)#\d+")


class UnsuitedError(ValueError):
    """Raised for an expression that fixed point has not; `node` is that expression."""

    def __init__(self, message: str, node: Expr) -> None:
        super().__init__(message)
        self.node = node


@dataclass(frozen=True)
class Operation:
    """One operation of a step.

    Args:
        kind: `scale` is a product with a constant, `compared` a comparison with one; `argument` is one of a system,
            `output` and `store` are results of the step.
        operands: Positions of operations before it.
        factor: The number of a constant, `scale` or `compared`.
        place: Position of the input, slot or output, or of a system's input or output.
        system: Number of the system.
        op: The comparison.
    """

    kind: Kind
    operands: tuple[int, ...] = ()
    factor: Fraction = Fraction(0)
    place: int = 0
    system: int = 0
    op: Operator = "<"

    @property
    def is_condition(self) -> bool:
        """Whether its value is a truth value."""
        return self.kind in ("compare", "compared", "and", "or", "not")


@dataclass(frozen=True)
class Operations:
    """All operations of a step.

    Args:
        items: Each after those that it reads.
        names: Names of values of the program by position.
        outputs: Positions of the outputs.
        stores: Positions of the new values of the slots.
    """

    items: tuple[Operation, ...]
    names: Mapping[int, str]
    outputs: tuple[int, ...]
    stores: tuple[int, ...]


def operations(program: Program, inputs: int, outputs: int) -> Operations:
    """Return the operations of a step.

    Args:
        program: A step in which systems are calls named `SYSTEM`; its arguments are the inputs, then the slots.
        inputs: Number of inputs.
        outputs: Number of outputs.

    Raises:
        UnsuitedError: For an expression that fixed point has not.
    """
    writer = _Writer()
    for k, name in enumerate(program.arguments):
        kind: Kind = "input" if k < inputs else "slot"
        writer.known[name] = writer.add(Operation(kind, place=k if k < inputs else k - inputs))
    names: dict[int, str] = {}
    for statement in program.body:
        writer.known[_named(statement)] = position = writer.real(statement.value)  # type: ignore[union-attr]
        names.setdefault(position, _named(statement))
    results = [writer.real(r) for r in program.results]
    left = [writer.add(Operation("output", (p,), place=k)) for k, p in enumerate(results[:outputs])]
    stored = [writer.add(Operation("store", (p,), place=k)) for k, p in enumerate(results[outputs:])]
    return Operations(tuple(writer.items), names, tuple(left), tuple(stored))


def _named(statement: Statement) -> str:
    assert isinstance(statement, Assign), "systems are calls"
    return statement.name


class _Writer:
    """Writes operations, each once."""

    def __init__(self) -> None:
        self.items: list[Operation] = []
        self.known: dict[str, int] = {}
        self._places: dict[Operation, int] = {}

    def add(self, item: Operation) -> int:
        if item not in self._places:
            self._places[item] = len(self.items)
            self.items.append(item)
        return self._places[item]

    def constant(self, value: float, node: Expr) -> int:
        if not math.isfinite(value):
            raise UnsuitedError("fixed point has no infinite numbers", node)
        return self.add(Operation("constant", factor=Fraction(value)))

    def real(self, node: Expr) -> int:
        """Write an expression whose value is a number."""
        match node:
            case Number(value=value):
                return self.constant(value, node)
            case Name(name=name):
                return self.known[name]
            case Negate(operand=operand):
                return self.scaled(self.real(operand), Fraction(-1))
            case Binary():
                return self._binary(node)
            case Where(condition=condition, then=then, otherwise=otherwise):
                truth = self.condition(condition)
                if isinstance(truth, bool):
                    return self.real(then if truth else otherwise)
                return self.add(Operation("where", (truth, self.real(then), self.real(otherwise))))
            case Call(function=function, arguments=arguments):
                return self._call(node, function, arguments)
        raise UnsuitedError(f"fixed point has no {type(node).__name__}", node)

    def scaled(self, x: int, factor: Fraction) -> int:
        """Write a product with a number."""
        return x if factor == 1 else self.add(Operation("scale", (x,), factor=factor))

    def _binary(self, node: Binary) -> int:
        left = self.real(node.left)
        if node.op == "^":
            return self._power(node, left)
        right = self.real(node.right)
        sides = (self.items[left], self.items[right])
        match node.op:
            case "/":
                if sides[1].kind != "constant" or not sides[1].factor:
                    raise UnsuitedError("fixed point divides by numbers only", node)
                return self.scaled(left, 1 / sides[1].factor)
            case "*" if sides[1].kind == "constant":
                return self.scaled(left, sides[1].factor)
            case "*" if sides[0].kind == "constant":
                return self.scaled(right, sides[0].factor)
        return self.add(Operation(node.op, (left, right)))

    def _power(self, node: Binary, base: int) -> int:
        exponent = node.right.value if isinstance(node.right, Number) else math.nan
        if exponent not in range(1, _LARGEST_POWER + 1):
            raise UnsuitedError(f"fixed point has no powers but those by 1 to {_LARGEST_POWER}", node)
        power = base
        for _ in range(int(exponent) - 1):
            power = self.add(Operation("*", (power, base)))
        return power

    def _call(self, node: Expr, function: str, arguments: Sequence[Expr]) -> int:
        if function.startswith(SYSTEM):
            system, (output, *inputs) = int(function.removeprefix(SYSTEM)), arguments
            assert isinstance(output, Number)
            places = [
                self.add(Operation("argument", (self.real(a),), place=k, system=system)) for k, a in enumerate(inputs)
            ]
            return self.add(Operation("system", tuple(places), place=int(output.value), system=system))
        match function:
            case "min" | "max":
                call, *others = (self.real(a) for a in arguments)
                for other in others:
                    call = self.add(Operation(function, (call, other)))
                return call
            case "abs":
                return self.add(Operation("abs", (self.real(arguments[0]),)))
        raise UnsuitedError(f"fixed point has no '{function}'", node)

    def condition(self, node: Expr) -> int | bool:
        """Write a condition; return whether it holds where that is known."""
        match node:
            case Compare(op=op, left=left, right=right):
                return self._compared(op, self.real(left), self.real(right))
            case Logic(op="not", operands=(operand,)):
                truth = self.condition(operand)
                return not truth if isinstance(truth, bool) else self.add(Operation("not", (truth,)))
            case Logic(op="and" | "or" as op, operands=operands):
                truths = [self.condition(o) for o in operands]
                settles = op == "or"
                if any(t is settles for t in truths):
                    return settles
                open_ = tuple(t for t in truths if not isinstance(t, bool))
                if len(open_) < 2:
                    return open_[0] if open_ else not settles
                return self.add(Operation(op, open_))
        raise UnsuitedError(f"fixed point has no {type(node).__name__} as a condition", node)

    def _compared(self, op: Operator, left: int, right: int) -> int | bool:
        a, b = self.items[left], self.items[right]
        if b.kind == "constant" and a.kind == "constant":
            return holds(op, a.factor, b.factor)
        if b.kind == "constant":
            return self.add(Operation("compared", (left,), factor=b.factor, op=op))
        if a.kind == "constant":
            mirrored: Operator = _MIRRORED[op]  # type: ignore[assignment]
            return self.add(Operation("compared", (right,), factor=a.factor, op=mirrored))
        return self.add(Operation("compare", (left, right), op=op))


def holds(op: Operator, a: Fraction, b: Fraction) -> bool:
    """Return whether a comparison of two numbers holds."""
    return {"<": a < b, "<=": a <= b, ">": a > b, ">=": a >= b, "==": a == b, "!=": a != b}[op]


def refused(message: str, span: Span | None, *, facts: Sequence[str] = (), help_text: str = "") -> DiagnosticError:
    """Return the exception with one diagnostic."""
    return DiagnosticError([Diagnostic("FZ410", message, span, facts=tuple(facts), help=help_text)])


def place_of(equations: Equations, node: Expr) -> Span | None:
    """Return the place of an expression without a span: that of the first of its kind."""
    exprs = [e for i in equations.body for e in ((i.value,) if isinstance(i, Equation) else i.arguments)]
    for part in (p for e in (*exprs, *equations.updates) for p in walk(e)):
        match node, part:
            case (Call(function=a), Call(function=b)) if a == b:
                return span_of(part)
            case (Binary(op=a), Binary(op=b, right=right)) if a == b and (a == "^" or not isinstance(right, Number)):
                return span_of(part)
    return None


def operator_of(state: str) -> str:
    """Return the operator that keeps a state, an empty text for one that the file declares."""
    result = _OPERATOR.search(state)
    return "" if result is None else result[1]


def state_words(name: str) -> str:
    """Return the name of a state in a message."""
    operator = operator_of(name)
    return f"the state of '{operator}'" if operator else f"state '{name}'"


def range_help(name: str) -> str:
    """Return the help on a state without a proved range."""
    if operator_of(name) == "integral":
        return f"{_AS_STATE}, {FLOAT}"
    return f"give it a range that it keeps, such as with 'clamp', {FLOAT}"


def error_help(name: str) -> str:
    """Return what to write where the error of a state has no bound."""
    if operator_of(name) == "integral":
        return f"{_AS_STATE}, {FLOAT}"
    state = "x" if operator_of(name) else name
    forgetting = f"next {state} = 0.99 * {state} + ..."
    return f"let it forget, as '{forgetting}' does, or add only what the format holds whole, {FLOAT}"
