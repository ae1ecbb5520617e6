"""Writer of expressions as formulas of `Function` terms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Final

from fuzzyctl.expr import COMPARISONS, Binary, Call, Expr, Name, Negate, Number, number_text

#: fuzzylite's names for functions of the model that both its engines have.
_FUNCTIONS: Final[Mapping[str, str]] = {
    **{n: n for n in ("abs", "sqrt", "exp", "log", "sin", "cos", "tan", "atan2", "min", "max")},
    **{n: n for n in ("floor", "ceil", "fmod", *COMPARISONS)},
    "ne": "neq",
}


def formula(expr: Expr, params: Mapping[str, float], *, python: bool = False) -> str | None:
    """Return an expression as a formula, with parentheses around every operation; None for what has none.

    Args:
        expr: The expression.
        params: Values of the names that are not variables.
        python: Whether pyfuzzylite is to read it, whose `%` and `round` are those of the model; fuzzylite's are not.
    """
    return _Writer(params, python).text(expr)


@dataclass(frozen=True)
class _Writer:
    params: Mapping[str, float]
    python: bool

    def text(self, expr: Expr) -> str | None:
        match expr:
            case Number(value=value):
                return _number(value)
            case Name(name=name):
                return _number(self.params[name]) if name in self.params else name
            case Negate(operand=operand):
                return self._joined("(0 - {})", operand)
            case Binary(op=op, left=left, right=right):
                return self._joined(f"({{}} {op} {{}})", left, right)
            case Call(function="sign", arguments=arguments):
                return self._joined("(gt({0}, 0) - gt(0, {0}))", *arguments)
            case Call(function="mod", arguments=(left, right)) if self.python:
                return self._joined("({} % {})", left, right)
            case Call(function="round", arguments=arguments) if self.python:
                return self._joined("round({})", *arguments)
            case Call(function="min" | "max" as function, arguments=arguments):  # of two there
                form = "{}"
                for _ in arguments[1:]:
                    form = f"{function}({form}, {{}})"
                return self._joined(form, *arguments)
            case Call(function=function, arguments=arguments) if function in _FUNCTIONS:
                return self._joined(f"{_FUNCTIONS[function]}({', '.join('{}' for _ in arguments)})", *arguments)
        return None

    def _joined(self, form: str, *parts: Expr) -> str | None:
        """Return a form with the texts of some parts in it, None where one has none."""
        texts = [text for part in parts if (text := self.text(part)) is not None]
        return form.format(*texts) if len(texts) == len(parts) else None


def _number(value: float) -> str:
    """Return a number without a sign and without an exponent, which formulas there take for sums."""
    text = number_text(abs(value))
    text = f"{Decimal(text):f}" if "e" in text else text
    return text if value >= 0 else f"(0 - {text})"
