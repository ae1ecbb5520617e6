"""Scalar Python functions from expressions, and the functions that printed programs call.

The only text that is ever executed is the printed one of a program, in which every name is a generated one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import count
from math import inf, nan
from numbers import Real
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.expr import SCALAR_FUNCTIONS, SOFT, Expr, floor, names_in
from fuzzyctl.kernels.program import quadrature
from fuzzyctl.kernels.program.printer import INDENT, SCALAR, text
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
