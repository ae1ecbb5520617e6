"""Programs as plain Python functions: no compiler, no numpy, a light start.

The only text that is ever executed is what the printer makes of a program, in which every name is a generated one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from numbers import Real
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError, NoRuleFiresError
from fuzzyctl.expr import SCALAR_FUNCTIONS, SOFT, Expr, floor, names_in
from fuzzyctl.kernels.program import quadrature
from fuzzyctl.kernels.program.passes.rows import with_rows
from fuzzyctl.kernels.program.printer import IEEE_SCALAR, INDENT, INTERPRETED, SCALAR, Dialect, block, text
from fuzzyctl.kernels.program.program import STATE, Program

#: Name of the array argument that a storing function writes to.
RESULT: Final = "result"

#: What a function raises for arguments it does not take, and where no rule fires; found and named by the careful way.
REFUSALS: Final = (TypeError, ValueError, ArithmeticError)

#: Stands for an argument that is not given.
_MISSING: Final[Any] = object()


def evaluation_source(program: Program) -> str:
    """Return the text of the function `kernel(x0, ..., C)` that returns the outputs."""
    program, _ = with_rows(program)
    results = ", ".join(text(r, SCALAR) for r in program.results)
    end = f"return {results}" if len(program.results) == 1 else f"return ({results})"
    return _function("kernel", program, [], [end], INTERPRETED)


def call_source(program: Program) -> str:
    """Return the text of the method `call(self, x0, ...)` of a kernel without a state that returns one output.

    The program is one with rows.

    Where an argument is missing, one too many, given by name or no number, where no rule fires and where the result is
    NaN it returns what `self._careful` does with the arguments.
    """
    names = list(program.arguments)
    head = f"def call(self, {', '.join(f'{x}=missing' for x in names)}, /, *more, **named):"
    lines = [*_conversions(program), *_body(program, INTERPRETED)]
    lines.append(f"{INDENT}result = {text(program.results[0], SCALAR)}")
    tried = [f"{INDENT}if not (more or named):", f"{INDENT * 2}try:", *(INDENT * 2 + line for line in lines)]
    tried += [f"{INDENT * 3}if result == result: return result", f"{INDENT * 2}except refusals: pass"]
    return "\n".join([head, *tried, f"{INDENT}return self._careful(given({', '.join(names)}, *more), named)"]) + "\n"


def storing_source(program: Program) -> str:
    """Return the text of the function `store(x0, ..., C, result)` that writes its results into `result`."""
    end = [f"{RESULT}[{k}] = {text(r, IEEE_SCALAR)}" for k, r in enumerate(program.results)]
    return _function("store", program, [RESULT], end, IEEE_SCALAR)


def _function(name: str, program: Program, extra: list[str], end: list[str], dialect: Dialect) -> str:
    arguments = [*program.arguments, *([STATE] if program.state else []), *extra]
    lines = [f"def {name}({', '.join(arguments)}):", *_conversions(program), *_body(program, dialect)]
    return "\n".join([*lines, *(INDENT + line for line in end)]) + "\n"


def _conversions(program: Program) -> list[str]:
    # The check is a tenth of the price of a conversion, and nearly all arguments are floats already.
    return [f"{INDENT}if type({x}) is not float: {x} = as_number({x})" for x in program.arguments]


def _body(program: Program, dialect: Dialect) -> Iterator[str]:
    point = ", ".join(program.arguments)
    return block(
        program.body, dialect, lambda condition, o: [f"if {condition}: raise no_rule_fires({o!r}, ({point},))"]
    )


def compile_source(source: str, program: Program, input_names: Sequence[str]) -> Callable[..., Any]:
    """Turn the text of a function into the function."""
    _, tables = with_rows(program)
    namespace: dict[str, Any] = {**RUNTIME, **tables}

    def no_rule_fires(output: str, point: Sequence[float]) -> NoRuleFiresError:
        return NoRuleFiresError(output, point_text(input_names, point))

    namespace["no_rule_fires"] = no_rule_fires
    return _execute(source, namespace)


def compile_call(program: Program) -> Callable[..., Any]:
    """Return the method `call(self, x0, ...)`, see `call_source`."""
    program, tables = with_rows(program)
    # The careful way says for which output no rule fires.
    return _execute(call_source(program), {**RUNTIME, **tables, **_CALLING, "no_rule_fires": ArithmeticError})


def _given(*arguments: Any) -> tuple[Any, ...]:
    return tuple(a for a in arguments if a is not _MISSING)


_CALLING: Final[Mapping[str, Any]] = {"missing": _MISSING, "given": _given, "refusals": REFUSALS}


def scalar_function(expr: Expr) -> Callable[..., float]:
    """Return the function of the names in an expression, in order of appearance."""
    names = ", ".join(dict.fromkeys(n.name for n in names_in(expr))) or "_=0.0"
    return _execute(f"def function({names}):\n{INDENT}return {text(expr, SCALAR)}\n", {**_CHOICES, **RUNTIME})


def _execute(source: str, namespace: dict[str, Any]) -> Callable[..., Any]:
    before = set(namespace)
    exec(compile(source, "<fuzzyctl kernel>", "exec"), namespace)  # noqa: S102 - printed from a plan, see above
    (name,) = set(namespace) - before - {"__builtins__"}
    function: Callable[..., Any] = namespace[name]
    return function


def point_text(names: Sequence[str], point: Sequence[float]) -> str:
    """Return a point for people: `sigma = 0.1, dsigma = -2`."""
    return ", ".join(f"{n} = {float(x):.6g}" for n, x in zip(names, point, strict=True))


def as_number(value: object, what: str = "an input") -> float:
    """Return a real number as a float.

    Raises:
        ArgumentError: For anything else, arrays included.
    """
    if isinstance(value, Real) or getattr(value, "shape", None) == ():
        return float(value)  # type: ignore[arg-type]  # what has an empty shape is an array of one number
    raise ArgumentError(f"{what} must be a real number, got {type(value).__name__}; kernel.batch takes arrays")


def _ieee(function: Callable[..., float]) -> Callable[..., float]:
    """Return a function of `math` that gives NaN and infinities where Python raises."""

    def safe(*arguments: float) -> float:
        try:
            return function(*arguments)
        except ValueError:
            return math.nan
        except OverflowError:
            return math.inf

    return safe


def _divide(a: float, b: float) -> float:
    if b != 0.0:
        return a / b
    if a == 0.0 or a != a or b != b:
        return math.nan
    return math.copysign(math.inf, a) * math.copysign(1.0, b)


def _log(x: float) -> float:
    return -math.inf if x == 0.0 else math.log(x) if x > 0.0 else math.nan


def power(a: float, b: float) -> float:
    """Return a^b as IEEE 754 has it: infinities and NaN where Python raises."""
    try:
        return math.pow(a, b)
    except OverflowError:
        return math.copysign(math.inf, a) if b % 2.0 == 1.0 else math.inf
    except ValueError:
        return _divide(1.0, math.copysign(0.0, a) if b % 2.0 == 1.0 else 0.0) if a == 0.0 else math.nan


def held(x: float) -> float:
    """Return a number held within [0, 1], 0 for NaN."""
    return (x if x < 1.0 else 1.0) if x > 0.0 else 0.0


#: What generated text may call, and nothing else: `__builtins__` holds only what its loops need.
RUNTIME: Final[Mapping[str, Any]] = {
    "moments": quadrature.moments,
    "half": quadrature.half,
    "marked": quadrature.marked,
    "__builtins__": {"range": range, "type": type, "float": float, "abs": abs},
    "nan": math.nan,
    "inf": math.inf,
    "as_number": as_number,
    "divide": _divide,
    "smaller": lambda a, b: a if a < b else b,
    "larger": lambda a, b: a if a > b else b,
    "held": held,
    "power": power,
    "sqrt": _ieee(math.sqrt),
    "exp": _ieee(math.exp),
    "decay": math.exp,
    "log": _log,
    "sin": _ieee(math.sin),
    "cos": _ieee(math.cos),
    "tan": _ieee(math.tan),
    "atan2": math.atan2,
    "floor": floor,
    "fmod": _ieee(math.fmod),
}
#: What `scalar_function` calls besides: programs have choices in the place of these.
_CHOICES: Final[Mapping[str, Any]] = {n: _ieee(f) for n, f in SCALAR_FUNCTIONS.items() if n in (*SOFT, "sign")}
