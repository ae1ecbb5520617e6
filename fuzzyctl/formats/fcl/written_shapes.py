"""FCL text of terms and functions, in the words of a dialect."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from fuzzyctl.expr import (
    COMPARISONS,
    Call,
    Expr,
    Name,
    Negate,
    Number,
    evaluate,
    number_text,
    replace,
    to_text,
    walk,
)
from fuzzyctl.formats.common.words import words_by_kind
from fuzzyctl.formats.fcl.dialect import DialectName
from fuzzyctl.formats.fcl.names import FUZZYLITE_SHAPES, JFUZZYLOGIC_SHAPES
from fuzzyctl.formats.fll.formulas import formula
from fuzzyctl.formats.fll.shapes import as_written
from fuzzyctl.formulas import MEMBERSHIP, Parameters, is_number, is_straight
from fuzzyctl.model.variable import Membership

#: Functions of expressions that jFuzzyLogic has, by its words.
_JFUZZYLOGIC_FUNCTIONS: Final = {"exp": "EXP", "log": "LN", "sin": "SIN", "cos": "COS", "tan": "TAN", "abs": "ABS"}

#: Functions of expressions that fuzzylite has besides, or that are expressions of others there.
_FUZZYLITE_FUNCTIONS: Final = frozenset(
    {*_JFUZZYLOGIC_FUNCTIONS, "sqrt", "min", "max", "atan2", "floor", "ceil", "fmod", "sign", *COMPARISONS}
)

_JFUZZYLOGIC: Final = words_by_kind(JFUZZYLOGIC_SHAPES)
_FUZZYLITE: Final = words_by_kind(FUZZYLITE_SHAPES)
#: Kinds that some dialect has words for, points and numbers included.
SPELT: Final = frozenset({*_JFUZZYLOGIC, *_FUZZYLITE, *(k for k in MEMBERSHIP if is_straight(k) or is_number(k))})


def numbers(membership: Membership, values: Mapping[str, float]) -> Parameters:
    """Return the parameters of a membership function."""
    return tuple(evaluate(a, values) for a in membership.arguments)


def needs_fuzzylite(membership: Membership, values: Mapping[str, float]) -> bool:
    """Whether only fuzzylite has a word for a term."""
    kind = membership.kind
    if kind in ("function", "linear"):
        return any(c not in _JFUZZYLOGIC_FUNCTIONS for c in _functions(membership))
    given = numbers(membership, values)
    if _as_points(membership, given, "jfuzzylogic") or kind in ("singleton", "constant", "piecewise"):
        return False
    if evaluate(membership.height, values) != 1.0 or kind not in _JFUZZYLOGIC:
        return True
    # Of the words without a foot jFuzzyLogic has none for what never ends on one side.
    return kind == "gaussian2" and (given[0] > given[2] or any(map(math.isinf, given)))


def needs_jfuzzylogic(membership: Membership) -> bool:
    """Whether the standard alone, with its points and singletons, has no words for a term."""
    return not is_number(membership.kind) and not is_straight(membership.kind)


def unknown_functions(membership: Membership) -> list[str]:
    """Return the functions of an expression that no FCL tool has."""
    return sorted({c for c in _functions(membership) if c not in _FUZZYLITE_FUNCTIONS})


def _functions(membership: Membership) -> list[str]:
    if membership.kind != "function":
        return []
    return [node.function for node in walk(membership.arguments[0]) if isinstance(node, Call)]


def _as_points(membership: Membership, given: Parameters, dialect: DialectName) -> bool:
    """Whether a term without a word in a dialect is straight, so that points say the same; the standard has none."""
    kind = membership.kind
    if not is_straight(kind) or kind == "piecewise":
        return False
    spelt = dialect == "jfuzzylogic" and kind in _JFUZZYLOGIC
    return not spelt or any(map(math.isinf, given)) or membership.height != Number(1.0)


def shape_text(membership: Membership, values: Mapping[str, float], dialect: DialectName) -> str:
    """Return what stands behind `TERM name :=`; a formula names variables as the file calls them, and no params."""
    kind = membership.kind
    if kind == "function":
        return f"{'Function' if dialect == 'fuzzylite' else 'FUNCTION'} {_formula(membership.arguments[0], dialect)}"
    given = numbers(membership, values)
    height = evaluate(membership.height, values)
    if kind in ("singleton", "constant"):
        return number_text(given[0])
    if kind == "piecewise":
        return _points(tuple(zip(given[::2], given[1::2], strict=True)), height)
    if dialect == "fuzzylite":
        shown = as_written(kind, given)
        parameters = shown if height == 1.0 else (*shown, height)
        return " ".join([_FUZZYLITE[kind][0], *map(number_text, parameters)])
    if _as_points(membership, given, dialect):
        return _points(MEMBERSHIP[kind].vertices(given), height)
    name, word = _JFUZZYLOGIC[kind]
    return " ".join([name, *map(number_text, word.parameters(given))])


def says_otherwise(membership: Membership, values: Mapping[str, float], dialect: DialectName) -> bool:
    """Whether a term is written as points although it is of another kind."""
    return (
        dialect != "fuzzylite"
        and membership.kind not in ("function", "linear", "singleton", "constant")
        and _as_points(membership, numbers(membership, values), dialect)
    )


def _points(points: tuple[tuple[float, float], ...], height: float) -> str:
    return " ".join(f"({number_text(x)}, {number_text(y * height)})" for x, y in points)


def linear_text(membership: Membership, values: Mapping[str, float], inputs: list[str], dialect: DialectName) -> str:
    """Return a linear consequent: a sum over all inputs in order, which reads back as one."""
    given = numbers(membership, values)
    if dialect == "fuzzylite":
        return " ".join(["Linear", *map(number_text, given)])
    products = [f"{number_text(a)} * {name}" for a, name in zip(given, inputs, strict=False)]
    return "FUNCTION " + " + ".join([*products, number_text(given[-1])])


def _formula(expression: Expr, dialect: DialectName) -> str:
    if dialect == "fuzzylite" and (text := formula(expression, {})) is not None:
        return text

    def worded(node: Expr) -> Expr:
        if isinstance(node, Negate):  # jFuzzyLogic has signs at numbers only
            return -1.0 * node.operand
        if isinstance(node, Call) and node.function in _JFUZZYLOGIC_FUNCTIONS:
            return Call(_JFUZZYLOGIC_FUNCTIONS[node.function], node.arguments)
        if isinstance(node, Number):
            return Number(node.value)
        return Number(math.pi) if node == Name("pi") else node

    return to_text(replace(expression, worded))
