"""Membership functions and Takagi-Sugeno consequents from FCL terms."""

from __future__ import annotations

import math

from fuzzyctl.diagnostics.suggestions import counted, did_you_mean, listed
from fuzzyctl.expr import ONE, ZERO, Binary, Expr, Name, Number
from fuzzyctl.formats.common.words import ShapeWord
from fuzzyctl.formats.fll.shapes import TERM_WORDS
from fuzzyctl.formats.fll.terms import NOT_BEYOND, membership_as_computed, step_to_itself, with_places
from fuzzyctl.model.variable import Membership
from tests.oracles.fcl.names import (
    FUZZYLITE_SHAPES,
    JFUZZYLOGIC_SHAPES,
    SHAPE_WORDS,
    fuzzylite_word,
)
from tests.oracles.fcl.scope import Scope
from tests.oracles.fcl.syntax import Shape, TermLine


def membership(line: TermLine, scope: Scope, *, of_output: bool) -> Membership | None:
    """Return the membership function of a term; None, with an error, for one that cannot be had."""
    shape = line.shape
    if shape.formula is not None:
        return _function(shape, scope, of_output=of_output)
    arguments = _numbers(shape, scope, line.name.text)
    if arguments is None:
        return None
    if shape.points and (shape.kind is None or shape.kind.upper == "SINGLETONS"):
        made = _empty_set(shape, arguments, scope) if not of_output else None
        return made or _points(shape, arguments, scope)
    if shape.kind is None:
        return _single(shape, arguments, scope)
    word = fuzzylite_word(shape.kind.text)
    variable = _input(scope, of_output=of_output)
    if word is not None and word not in FUZZYLITE_SHAPES:
        made = _special(word, shape, arguments, scope, of_output=of_output)
        has_corners = made is not None and made.kind in ("piecewise", "rectangle")
        return membership_as_computed(made, variable, scope, word=word) if made is not None and has_corners else made
    known = FUZZYLITE_SHAPES[word] if word is not None else JFUZZYLOGIC_SHAPES.get(shape.kind.upper)
    if known is None or shape.points:
        facts, help_text = (f"shapes: {listed(SHAPE_WORDS)}",), did_you_mean(shape.kind.upper, SHAPE_WORDS)
        scope.error("FZ601", f"no shape '{shape.kind.text}'", shape.kind.span, facts=facts, help=help_text)
        return None
    found = _known(known, shape, arguments, scope)
    if found is None or word is None:
        return found
    return membership_as_computed(_as_in_fll(word, found), variable, scope, word=word)


def _input(scope: Scope, *, of_output: bool) -> str | None:
    """Return the input whose terms are read, over which formulas of them are; None for an output."""
    return None if of_output else next(iter(scope.readable))


def _as_in_fll(word: str, found: Membership) -> Membership:
    """Return a membership function of numbers with its parameters as fuzzylite means them, such as a width below 0."""
    values = tuple(a.value for a in found.arguments if isinstance(a, Number))
    if len(values) < len(found.arguments):
        return found
    kind, parameters = TERM_WORDS[word].shape(values)
    arguments = with_places(parameters, [a for a in found.arguments if isinstance(a, Number)])
    return found.model_copy(update={"kind": kind, "arguments": arguments})


def _numbers(shape: Shape, scope: Scope, name: str) -> tuple[Expr, ...] | None:
    found = [scope.number(a, f"parameter {i} of '{name}'") for i, a in enumerate(shape.arguments, 1)]
    return None if any(f is None for f in found) else tuple(f for f in found if f is not None)


def _known(word: ShapeWord, shape: Shape, arguments: tuple[Expr, ...], scope: Scope) -> Membership | None:
    names = word.form.split()
    count = len(names)
    assert shape.kind is not None
    if len(arguments) < count:
        message = f"'{shape.kind.text}' takes {counted(count, 'parameter')}, got {len(arguments)}"
        scope.error("FZ303", message, shape.span, help=f"they are: {', '.join(names)}")
        return None
    height = arguments[count] if word in FUZZYLITE_SHAPES.values() and len(arguments) > count else ONE
    surplus = len(arguments) - count - (height is not ONE)
    if surplus > 0:
        message = f"'{shape.kind.text}' takes {counted(count, 'parameter')}; the rest has no effect"
        scope.warning("FZ603", message, shape.span, help="remove what is left over")
    if word is JFUZZYLOGIC_SHAPES["DSIGM"]:
        scope.clamped_differences = True
    ordered = enumerate(word.ordered(arguments[:count]))
    made = tuple(_doubled(a) if i in word.doubled else a for i, a in ordered)
    return Membership(kind=word.kind, arguments=made, height=height, span=shape.span)


def _doubled(expr: Expr) -> Expr:
    return Number(2.0 * expr.value, "", expr.span) if isinstance(expr, Number) else 2.0 * expr


def _empty_set(shape: Shape, arguments: tuple[Expr, ...], scope: Scope) -> Membership | None:
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
            arguments = (*arguments, arguments[0] + 1.0, arguments[1])
            if isinstance(shape.arguments[0], Number):
                arguments = (*arguments[:2], Number(shape.arguments[0].value + 1.0), arguments[1])
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


def _special(
    word: str, shape: Shape, arguments: tuple[Expr, ...], scope: Scope, *, of_output: bool
) -> Membership | None:
    """Return what fuzzylite's words stand for whose parameters are counted otherwise."""
    count = len(arguments)
    if word == "Constant" and count == 1:
        value = arguments[0]
        if not of_output and isinstance(value, Number) and not 0.0 <= value.value <= 1.0:
            scope.error("FZ302", f"the degree {value.value:g} lies outside [0, 1]", shape.span, help=NOT_BEYOND)
            return None
        if not of_output:  # its degree is its value, whatever the input is
            return Membership(kind="function", arguments=arguments, span=shape.span)
        return Membership(kind="singleton", arguments=arguments, span=shape.span)
    if word == "Binary" and count in (2, 3):
        return _binary(shape, arguments, scope, _input(scope, of_output=of_output))
    if word == "Linear" and count in (len(scope.inputs), len(scope.inputs) + 1):
        constant = () if count > len(scope.inputs) else (ZERO,)  # it may be left out
        return Membership(kind="linear", arguments=(*arguments, *constant), span=shape.span)
    if word == "Discrete" and count >= 2:
        height = arguments[-1] if count % 2 else ONE
        return Membership(kind="piecewise", arguments=arguments[: count - count % 2], height=height, span=shape.span)
    wanted = {
        "Linear": f"a coefficient for each of {counted(len(scope.inputs), 'input')}, and perhaps a constant",
        "Discrete": "pairs x y",
        "Binary": "start, direction",
    }
    scope.error("FZ303", f"'{word}' takes {wanted.get(word, 'one number')}, got {count}", shape.span)
    return None


def _binary(shape: Shape, arguments: tuple[Expr, ...], scope: Scope, variable: str | None) -> Membership | None:
    start, direction = (a.value if isinstance(a, Number) else math.nan for a in arguments[:2])
    if math.isnan(start) or math.isnan(direction):
        scope.error("FZ302", "'Binary' needs two numbers: start and direction", shape.span)
        return None
    if start == direction:
        return step_to_itself(variable, shape.span, scope, word="Binary")
    edge = arguments[0]
    sides = (edge, Number(math.inf)) if direction > start else (Number(-math.inf), edge)
    height = arguments[2] if len(arguments) == 3 else ONE
    return Membership(kind="rectangle", arguments=sides, height=height, span=shape.span)


def _function(shape: Shape, scope: Scope, *, of_output: bool) -> Membership | None:
    assert shape.formula is not None
    expression = scope.function(shape.formula)
    if expression is None:
        return None
    coefficients = linear_coefficients(expression, list(scope.inputs)) if of_output else None
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
