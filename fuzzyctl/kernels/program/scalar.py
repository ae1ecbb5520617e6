"""Scalar Python functions from expressions and programs, and the functions that printed programs call.

The only text that is ever executed is the printed one of a program, in which every name is a generated one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import count
from math import inf, nan
from numbers import Real
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError, NoRuleFiresError
from fuzzyctl.expr import SCALAR_FUNCTIONS, SOFT, Expr, floor, names_in
from fuzzyctl.kernels.program import quadrature
from fuzzyctl.kernels.program.printer import IEEE_SCALAR, INDENT, INTERPRETED, SCALAR, Dialect, block, text
from fuzzyctl.kernels.program.program import STATE, Program
from fuzzyctl.records import dataclass


def divide(a: float, b: float) -> float:
    """Return a / b."""
    if b != 0.0:
        return a / b
    if a == 0.0 or a != a or b != b:
        return nan
    return math.copysign(inf, a) * math.copysign(1.0, b)


def smaller(a: float, b: float) -> float:
    """Return the smaller number, the second one where one of them is NaN."""
    return a if a < b else b


def larger(a: float, b: float) -> float:
    """Return the larger number, the second one where one of them is NaN."""
    return a if a > b else b


def clip(x: float, low: float, high: float) -> float:
    """Return a number held between two others; NaN stays NaN."""
    return low if x < low else high if x > high else x


def held(x: float) -> float:
    """Return a number held within [0, 1], 0 for NaN."""
    return (x if x < 1.0 else 1.0) if x > 0.0 else 0.0


def power(a: float, b: float) -> float:
    """Return a^b."""
    try:
        return math.pow(a, b)
    except OverflowError:
        return math.copysign(inf, a) if b % 2.0 == 1.0 else inf
    except ValueError:
        return divide(1.0, math.copysign(0.0, a) if b % 2.0 == 1.0 else 0.0) if a == 0.0 else nan


def sqrt(x: float) -> float:
    """Return the square root, NaN of a negative number."""
    return math.sqrt(x) if x >= 0.0 else nan


def exp(x: float) -> float:
    """Return the exponential."""
    try:
        return math.exp(x)
    except OverflowError:
        return inf


def log(x: float) -> float:
    """Return the natural logarithm, -∞ of 0 and NaN of a negative number."""
    return -inf if x == 0.0 else math.log(x) if x > 0.0 else nan


def sin(x: float) -> float:
    """Return the sine, NaN of an infinite angle."""
    return math.sin(x) if -inf < x < inf else nan


def cos(x: float) -> float:
    """Return the cosine, NaN of an infinite angle."""
    return math.cos(x) if -inf < x < inf else nan


def tan(x: float) -> float:
    """Return the tangent, NaN of an infinite angle."""
    return math.tan(x) if -inf < x < inf else nan


def fmod(a: float, b: float) -> float:
    """Return the remainder of a / b with the sign of a, NaN if it does not exist."""
    try:
        return math.fmod(a, b)
    except ValueError:
        return nan


#: The primitives by name.
IEEE_FUNCTIONS: Final[Mapping[str, Callable[..., float]]] = {
    **{f.__name__: f for f in (divide, smaller, larger, clip, held, power, sqrt, exp, log, sin, cos, tan, floor, fmod)},
    "abs": abs,
    "atan2": math.atan2,
}


def scalar_function(expr: Expr) -> Callable[..., float]:
    """Return the function of the names in an expression, in order of appearance."""
    names = ", ".join(dict.fromkeys(n.name for n in names_in(expr))) or "_=0.0"
    return execute(f"def function({names}):\n{INDENT}return {text(expr, SCALAR)}\n", {**_CHOICES, **RUNTIME})


def execute(source: str, namespace: dict[str, Any]) -> Callable[..., Any]:
    """Return the one function that a printed text defines."""
    before = set(namespace)
    execute_all(source, namespace)
    (name,) = set(namespace) - before - {"__builtins__", "__name__", "__loader__"}
    function: Callable[..., Any] = namespace[name]
    return function


def execute_all(source: str, namespace: dict[str, Any]) -> None:
    """Execute a printed text; tracebacks through its functions show its lines."""
    name = f"fuzzyctl kernel {next(_NUMBERS)}"
    namespace.update(__name__=name, __loader__=_Loader(source))
    exec(compile(source, name, "exec"), namespace)  # noqa: S102 - printed from a plan, see above


@dataclass(frozen=True)
class _Loader:
    """Loader of a printed text, which `linecache` asks for its lines."""

    source: str

    def get_source(self, _name: str) -> str:
        return self.source


#: Numbers that tell printed texts apart.
_NUMBERS: Final = count()


def as_number(value: object, what: str = "an input") -> float:
    """Return a real number as a float.

    Raises:
        ArgumentError: For anything else, arrays included.
    """
    if isinstance(value, Real) or getattr(value, "shape", None) == ():
        return float(value)  # type: ignore[arg-type]  # an empty shape is that of an array of one number
    arrays = "; kernel.batch takes arrays" if hasattr(value, "__len__") and not isinstance(value, str) else ""
    raise ArgumentError(f"{what} must be a real number, got {type(value).__name__}{arrays}")


def _ieee(function: Callable[..., float]) -> Callable[..., float]:
    """Return a function that gives NaN where it raised."""

    def safe(*arguments: float) -> float:
        try:
            return function(*arguments)
        except ValueError:
            return math.nan

    return safe


#: The only names that generated text may call: `__builtins__` holds only those of its loops.
RUNTIME: Final[Mapping[str, Any]] = {
    "moments": quadrature.moments,
    "half": quadrature.half,
    "jumps": quadrature.jumps,
    "marked": quadrature.marked,
    "__builtins__": {"range": range, "type": type, "float": float, "abs": abs},
    "nan": math.nan,
    "inf": math.inf,
    "as_number": as_number,
    **IEEE_FUNCTIONS,
}
#: What `scalar_function` calls besides: programs have choices in the place of these.
_CHOICES: Final[Mapping[str, Any]] = {n: _ieee(f) for n, f in SCALAR_FUNCTIONS.items() if n in (*SOFT, "sign")}


#: Name of the array argument that a storing function writes to.
RESULT: Final = "result"


def evaluation_source(program: Program) -> str:
    """Return the text of the function `kernel(x0, ..., C)` that returns the outputs."""
    results = ", ".join(text(r, SCALAR) for r in program.results)
    end = f"return {results}" if len(program.results) == 1 else f"return ({results})"
    return _function("kernel", program, [], [end], INTERPRETED)


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
    namespace: dict[str, Any] = {**RUNTIME, **dict(program.tables)}

    def no_rule_fires(output: str, point: Sequence[float]) -> NoRuleFiresError:
        return NoRuleFiresError(output, point_text(input_names, point))

    namespace["no_rule_fires"] = no_rule_fires
    return execute(source, namespace)


def point_text(names: Sequence[str], point: Sequence[float]) -> str:
    """Return a point for people: `sigma = 0.1, dsigma = -2`."""
    return ", ".join(f"{n} = {float(x):.6g}" for n, x in zip(names, point, strict=True))
