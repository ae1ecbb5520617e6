"""Settings of a method as texts, down to the single option."""

from __future__ import annotations

from fuzzyctl.expr import Expr, Number, replace, to_text
from fuzzyctl.formats.fz import activation_text, defuzzifier_text
from fuzzyctl.model.method import KNOBS, Defuzzifier, Method
from fuzzyctl.model.variable import Hold


def settings(method: Method) -> dict[str, str]:
    """Return every setting of a method by the word that rule files use for it."""
    return {
        "and": method.conjunction,
        "or": method.disjunction,
        "implication": method.implication,
        "aggregation": method.aggregation,
        "activation": activation_text(method.activation),
        **defuzzifier_settings(method.defuzzifier),
        **{name: str(getattr(method.semantics, name)) for name in ("profile", *KNOBS)},
    }


def plain_text(expr: Expr) -> str:
    """Return an expression with its numbers as they are, however they were typed: `1.0` is `1`."""
    return to_text(replace(expr, lambda e: Number(e.value) if isinstance(e, Number) else e))


def described(defuzzifier: Defuzzifier) -> str:
    """Return a defuzzifier in one text, which says of an integral that it is exact."""
    exact = defuzzifier.resolution is None and not defuzzifier.over_rules
    return f"{defuzzifier_text(defuzzifier)}, exact" if exact else defuzzifier_text(defuzzifier)


def defuzzifier_settings(defuzzifier: Defuzzifier) -> dict[str, str]:
    """Return kind and options of a defuzzifier."""
    return {
        "defuzzifier": defuzzifier.kind,
        "resolution": "exact" if defuzzifier.resolution is None else str(defuzzifier.resolution),
        "grid": defuzzifier.grid,
        "rule": defuzzifier.rule or "usual",
        "tolerance": "usual" if defuzzifier.tolerance is None else str(defuzzifier.tolerance),
        "by": defuzzifier.by,
    }


def otherwise_text(otherwise: Expr | str | Hold | None) -> str | None:
    """Return the text after `else`."""
    if otherwise is None or isinstance(otherwise, str):
        return otherwise
    if not isinstance(otherwise, Hold):
        return plain_text(otherwise)
    start = otherwise.start
    return "hold" if start is None else f"hold({start if isinstance(start, str) else plain_text(start)})"
