"""Membership functions and Takagi-Sugeno consequents from FCL terms."""

from __future__ import annotations

from collections.abc import Sequence

from fuzzyctl.diagnostics.suggestions import counted, did_you_mean, listed
from fuzzyctl.expr import ONE, ZERO, Binary, Expr, Name, Number
from fuzzyctl.formats.fcl.names import JFUZZYLOGIC_SHAPES, SHAPE_WORDS, fuzzylite_word
from fuzzyctl.formats.fcl.scope import Scope
from fuzzyctl.formats.fcl.syntax import Shape, TermLine
from fuzzyctl.formats.fll.shapes import TERMS
from fuzzyctl.formats.fll.terms import Place, TermReader
from fuzzyctl.model.variable import Membership


def membership(line: TermLine, scope: Scope, place: Place) -> Membership | None:
    """Return the membership function of a term; None, with an error, for one that cannot be had."""
    shape = line.shape
    if shape.formula is not None:
        return _function(shape, scope, place)
    found = [scope.constant(a, f"parameter {i} of '{line.name.text}'") for i, a in enumerate(shape.arguments, 1)]
    arguments = tuple(a for a in found if a is not None)
    if len(arguments) < len(found):
        return None
    if shape.points and (shape.kind is None or shape.kind.upper == "SINGLETONS"):
        made = _empty_set(shape, arguments, scope) if place.is_input else None
        return made or _points(shape, arguments, scope)
    if shape.kind is None:
        return _single(shape, arguments, scope)
    word = fuzzylite_word(shape.kind.text)
    known = TERMS[word] if word is not None else JFUZZYLOGIC_SHAPES.get(shape.kind.upper)
    if known is None or shape.points:
        facts, help_text = (f"shapes: {listed(SHAPE_WORDS)}",), did_you_mean(shape.kind.upper, SHAPE_WORDS)
        scope.error("FZ601", f"there is no shape '{shape.kind.text}'", shape.kind.span, facts=facts, help=help_text)
        return None
    if known is JFUZZYLOGIC_SHAPES["DSIGM"]:
        scope.clamped_differences = True
    most = {"Constant": 1, "Binary": 3}.get(word or "", len(arguments))
    if len(arguments) > most:
        scope.error("FZ303", f"'{word}' takes {counted(most, 'number')}, got {len(arguments)}", shape.span)
        return None
    reader = TermReader(scope, fuzzylite=word is not None, fll=word is not None)
    made = reader.shape(place, shape.kind.span, known, arguments, shape.span)
    if made is not None and made.kind == "constant":
        return made.model_copy(update={"kind": "singleton"})
    return made


def _empty_set(shape: Shape, arguments: Sequence[Expr], scope: Scope) -> Membership | None:
    """Return a term whose points are all 0, as some files have it for the sake of its range; None for any other."""
    values = [a.value for a in arguments if isinstance(a, Number)]
    if shape.kind is not None or len(values) < len(arguments) or any(values[1::2]):
        return None
    scope.empty_sets.append((min(values[::2]), max(values[::2])))
    message = "the term is 0 everywhere, so that no value belongs to it"
    help_text = "remove it, unless it is there to widen the range"
    scope.warning("FZ603", message, shape.span, help=help_text)
    return Membership(kind="function", arguments=(ZERO,), span=shape.span)


def _points(shape: Shape, arguments: tuple[Expr, ...], scope: Scope) -> Membership | None:
    if shape.kind is None:
        if len(arguments) == 2:  # constant from end to end
            x, y = arguments
            arguments = (x, y, Number(x.value + 1.0) if isinstance(x, Number) else x + 1.0, y)
        return Membership(kind="piecewise", arguments=arguments, span=shape.span)
    if len(arguments) == 2 and arguments[1] == ONE:
        return Membership(kind="singleton", arguments=arguments[:1], span=shape.span)
    message = "a term of several singletons is not available"
    scope.error("FZ602", message, shape.span, help="make a term of each point")
    return None


def _single(shape: Shape, arguments: tuple[Expr, ...], scope: Scope) -> Membership | None:
    if len(arguments) == 1:
        return Membership(kind="singleton", arguments=arguments, span=shape.span)
    message = f"{counted(len(arguments), 'number')} without the word of a shape"
    scope.error("FZ601", message, shape.span, facts=(f"shapes: {listed(SHAPE_WORDS)}",))
    return None


def _function(shape: Shape, scope: Scope, place: Place) -> Membership | None:
    assert shape.formula is not None
    expression = scope.function(shape.formula)
    if expression is None:
        return None
    coefficients = linear_coefficients(expression, list(scope.inputs)) if not place.is_input else None
    if coefficients is not None:
        return Membership(kind="linear", arguments=coefficients, span=shape.span)
    return Membership(kind="function", arguments=(expression,), span=shape.span)


def linear_coefficients(expression: Expr, inputs: list[str]) -> tuple[Expr, ...] | None:
    """Return the coefficients of `a * x + b * y + c` with every input in order, as `write` writes a linear consequent.

    Any other sum stays a function, so that it is computed in the order in which it is written.
    """
    summands: list[Expr] = []
    rest = expression
    while isinstance(rest, Binary) and rest.op == "+" and len(summands) < len(inputs):
        summands.append(rest.right)
        rest = rest.left
    constant, *products = [*summands, rest]
    if not isinstance(constant, Number) or len(products) != len(inputs):
        return None
    found: list[Expr] = []
    for name, summand in zip(inputs, reversed(products), strict=True):
        match summand:
            case Binary(op="*", left=Number() as coefficient, right=Name(name=variable)) if variable == name:
                found.append(coefficient)
            case _:
                return None
    return (*found, constant)
