"""Checks of single numbers: whether each has a value, and whether that value is allowed.

They look at whatever can be computed, so that a mistake hides no other one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import (
    DIVISION,
    FUNCTIONS,
    REPAIRS,
    Binary,
    Call,
    Compare,
    Expr,
    Name,
    Negate,
    Number,
    children,
    span_of,
    to_text,
    walk,
)
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.model.block import ParamCycleError
from fuzzyctl.model.computed_numbers import Numbers, Shape, parameters
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import ANYWHERE, Hold, LinguisticVariable, Membership


def uncomputable_numbers(numbers: Numbers) -> Iterator[Diagnostic]:
    """Find params that depend on themselves, divisions by zero, and values that are not finite."""
    for why in numbers.params.errors:
        if isinstance(why, ParamCycleError):
            yield Diagnostic("FZ308", why.message, why.span, help="break the cycle: give one of them a number")
        else:
            yield Diagnostic("FZ307", why.message, why.span, help=why.help)
    infinite = list(_infinite_ranges(numbers))
    yield from infinite
    seen: set[_Place | None] = set()
    for expr, may_be_infinite, what in computed_numbers(numbers.system):
        # The ends of a range are also peaks of an even partition; one place gives one diagnostic.
        place, value = _place(span_of(expr)), numbers.value(expr)
        if value is not None and (may_be_infinite or math.isfinite(value)):
            seen.add(place)
            continue
        if (place is not None and place in seen) or (place is None and infinite and not isinstance(expr, Number)):
            continue
        error = numbers.failure(expr)
        reason = _place(error.span if error is not None else None)
        if reason is None or reason not in seen:
            yield from _uncomputable(numbers, expr, may_be_infinite, what)
        seen.update((place, reason))


#: A span in short, which costs less to look for than the span itself.
_Place = tuple[str, int, int]


def _place(span: Span | None) -> _Place | None:
    return None if span is None else (span.source.name, span.start, span.end)


def _uncomputable(numbers: Numbers, expr: Expr, may_be_infinite: bool, what: str) -> Iterator[Diagnostic]:
    error, value = numbers.failure(expr), numbers.value(expr)
    if error is not None:
        place = error.span or span_of(expr)
        yield Diagnostic("FZ307", f"{what}: {error.message}", place, help=error.help)
    elif value is not None and math.isinf(value) and not may_be_infinite:
        yield Diagnostic("FZ302", f"{what} is infinite", span_of(expr), help="only feet may be infinite")


def _infinite_ranges(numbers: Numbers) -> Iterator[Diagnostic]:
    for v in numbers.variables:
        ends = (numbers.value(v.lower), numbers.value(v.upper))
        if (v.lower, v.upper) != ANYWHERE and any(e is not None and math.isinf(e) for e in ends):
            place = _range_span(v)
            yield Diagnostic("FZ302", f"the range of '{v.name}' is infinite", place, help="only feet may be infinite")


def computed_numbers(system: FuzzySystem) -> Iterator[tuple[Expr, bool, str]]:
    """Yield every expression of a system that is to be a number, with whether it may be infinite and its description.

    Plain finite numbers, which nearly all are, are left out.
    """
    for param in system.params:
        for end, bound in (
            () if param.bounds is None else (("lower", param.bounds.lower), ("upper", param.bounds.upper))
        ):
            if not _is_plain(bound):
                yield bound, True, f"the {end} end of the range of '{param.name}'"
    for variable in system.variables:
        if not _is_plain(variable.lower):
            yield variable.lower, True, f"the lower end of '{variable.name}'"
        if not _is_plain(variable.upper):
            yield variable.upper, True, f"the upper end of '{variable.name}'"
        for term in variable.terms:
            if not all(map(_is_plain, term.membership.arguments)):
                yield from parameters(term.membership, term.name)
            if not _is_plain(term.membership.height):
                yield term.membership.height, False, f"the height of '{term.name}'"
    for output in system.outputs:
        if isinstance(output.otherwise, Expr):
            yield output.otherwise, False, f"the 'else' value of '{output.name}'"
        elif isinstance(output.otherwise, Hold) and isinstance(output.otherwise.start, Expr):
            yield output.otherwise.start, False, f"the value that '{output.name}' holds at first"
    for rule in system.rules:
        if not _is_plain(rule.weight):
            yield rule.weight, False, "the weight"
        for c in rule.consequents:
            if isinstance(c.term, Membership):
                yield from parameters(c.term, c.output)
    for activation in (system.method.activation, *(b.activation for b in system.rule_blocks)):
        if activation is not None and activation.threshold is not None:
            yield activation.threshold, False, "the threshold"
    for guarantee in system.guarantees:
        if guarantee.within is not None:
            yield guarantee.within, False, "the tolerance"


def _is_plain(expr: Expr) -> bool:
    return type(expr) is Number and -math.inf < expr.value < math.inf


def empty_ranges(numbers: Numbers) -> Iterator[Diagnostic]:
    """Find ranges whose lower end is not below the upper one."""
    for v in numbers.variables:
        ends = numbers.ends(v)
        if ends is None or numbers.range(v) is not None:
            continue
        low, high = ends
        if math.isinf(high - low):
            message = f"the range of '{v.name}' is wider than a number can be: [{low:.6g}, {high:.6g}]"
            yield Diagnostic("FZ304", message, v.span, help="take another unit")
        else:
            message = f"the range of '{v.name}' is empty: [{low:.6g}, {high:.6g}]"
            help_text = "swap the ends" if low > high else "give it an upper end above the lower one"
            yield Diagnostic("FZ304", message, _range_span(v), help=help_text)


def params_outside(numbers: Numbers) -> Iterator[Diagnostic]:
    """Find params outside of the ranges that they declare, and empty ranges."""
    for param in numbers.system.params:
        bounds, value = param.bounds, numbers.value(param.expression)
        if bounds is None:
            continue
        low, high = numbers.value(bounds.lower), numbers.value(bounds.upper)
        if low is None or high is None or value is None:
            continue
        if not low < high:
            message = f"the range of '{param.name}' is empty: {low:g} is not below {high:g}"
            yield Diagnostic("FZ304", message, bounds.span, help="put the smaller end first")
        elif not bounds.holds(value, low, high):
            message = f"param '{param.name}' is {value:g}, outside of {bounds.text(low, high)}"
            help_text = "give a value in the range, or widen the range"
            yield Diagnostic("FZ302", message, span_of(param.expression) or param.span, help=help_text)


def bad_parameters(numbers: Numbers) -> Iterator[Diagnostic]:
    """Find feet out of order, infinite feet of the wrong sign and widths that are not positive."""
    seen: set[tuple[str, int]] = set()
    for v in numbers.variables:
        for term, values in numbers.given(v):
            mistake = MEMBERSHIP[term.membership.kind].mistake(values)
            if mistake is None:
                continue
            # The peaks of one `terms` line share their mistakes: one of them is enough.
            line = (v.name, term.span.line if term.span is not None else id(term))
            if line in seen or (numbers.range(v) is None and _comes_from_range(v, (term, values))):
                continue
            seen.add(line)
            yield _bad_shape(v, (term, values), mistake)


def _comes_from_range(v: LinguisticVariable, shape: Shape) -> bool:
    """Whether a term belongs to a bare `terms` line: its peak is computed from the range, which has another check."""
    term, _ = shape
    if not _is_of_partition(shape):
        return False
    peak = span_of(term.membership.arguments[1])
    return peak is None or peak in (span_of(v.lower), span_of(v.upper))


def _is_of_partition(shape: Shape) -> bool:
    term, values = shape
    return term.span is not None and term.span == term.membership.span and len(values) == 3


def _bad_shape(v: LinguisticVariable, shape: Shape, mistake: str) -> Diagnostic:
    term, values = shape
    if _is_of_partition(shape):
        # Its feet are the peaks beside it, which are all that was written.
        message = f"the peaks of '{v.name}' are out of order: {values[1]:.6g} of '{term.name}', then {values[2]:.6g}"
        return Diagnostic("FZ301", message, term.span, help="list the terms from left to right")
    unordered = "greater than" in mistake
    formula = MEMBERSHIP[term.membership.kind]
    order = f"; the order is {', '.join(formula.parameters)}" if unordered and not formula.variadic else ""
    help_text = "give the points from left to right" if unordered and formula.variadic else ""
    if unordered and not formula.variadic:
        points = sorted(zip(values, map(to_text, term.membership.arguments), strict=True), key=lambda p: p[0])
        help_text = f"from left to right it is: {formula.name}({', '.join(text for _, text in points)})"
    message = f"term '{term.name}' of '{v.name}': {mistake}{order}"
    place = term.membership.span or term.span
    return Diagnostic("FZ301" if unordered else "FZ302", message, place, help=help_text)


def bad_heights(numbers: Numbers) -> Iterator[Diagnostic]:
    """Find heights outside (0, 1]."""
    for variable in numbers.variables:
        for term in variable.terms:
            height = numbers.finite(term.membership.height)
            if height is not None and not 0 < height <= 1:
                message = f"the height {height:.6g} of '{term.name}' of '{variable.name}' lies outside (0, 1]"
                yield Diagnostic("FZ302", message, span_of(term.membership.height) or term.span)


def bad_tolerances(numbers: Numbers) -> Iterator[Diagnostic]:
    """Find tolerances below 0."""
    for guarantee in numbers.system.guarantees:
        value = numbers.finite(guarantee.within) if guarantee.within is not None else None
        if value is not None and value < 0:
            place = span_of(guarantee.within) if guarantee.within is not None else None
            message, help_text = f"the tolerance {value:.6g} is below 0", "write a small number >= 0"
            yield Diagnostic("FZ302", message, place or guarantee.span, help=help_text)


def bad_weights(numbers: Numbers) -> Iterator[Diagnostic]:
    """Find weights outside [0, 1]."""
    for rule in numbers.system.rules:
        weight = numbers.finite(rule.weight)
        if weight is not None and not 0 <= weight <= 1:
            place = span_of(rule.weight) or rule.span
            yield Diagnostic("FZ302", f"the weight {weight:.6g} lies outside [0, 1]", place)


def _range_span(v: LinguisticVariable) -> Span | None:
    first, last = span_of(v.lower), span_of(v.upper)
    return (first.to(last) if first is not None and last is not None else first or last) or v.span


#: Whether a name has a value before anything runs.
IsKnown = Callable[[str], bool]


def constants(expr: Expr, is_known: IsKnown) -> list[Expr]:
    """Return the largest parts of an expression that depend on params only, from left to right, without numbers.

    Parts of the choices of `where` are left out, too: its condition may skip them.
    """
    result, whole = _parts(expr, is_known)
    return [expr] if whole and not isinstance(expr, Number) else result


def quotients(expr: Expr, is_known: IsKnown) -> Iterator[tuple[Expr, Expr]]:
    """Yield quotients and remainders that depend on variables, with divisors that depend on params only."""
    choices = {id(n) for node in walk(expr) if _is_choice(node) for c in children(node)[1:] for n in walk(c)}
    for node in walk(expr):
        divisor = _divisor(node)
        if divisor is not None and id(node) not in choices:
            (_, whole), (_, below) = _parts(node, is_known), _parts(divisor, is_known)
            if below and not whole:
                yield node, divisor


def _divisor(expr: Expr) -> Expr | None:
    match expr:
        case Binary(op="/", right=divisor) | Call(function="mod" | "fmod", arguments=(_, divisor)):
            return divisor
    return None


def _is_choice(expr: Expr) -> bool:
    return isinstance(expr, Call) and expr.function == "where"


def _parts(expr: Expr, is_known: IsKnown) -> tuple[list[Expr], bool]:
    """Return the largest parts below an expression that depend on params only, and whether all of it does."""
    inner = children(expr)[:1] if _is_choice(expr) else children(expr)
    parts = [(child, *_parts(child, is_known)) for child in inner]
    whole = _is_arithmetic(expr, is_known) and all(is_whole for _, _, is_whole in parts)
    if whole:
        return [], True
    results: list[Expr] = []
    for child, below, is_whole in parts:
        results += below if not is_whole else [] if isinstance(child, Number) else [child]
    return results, False


def _is_arithmetic(expr: Expr, is_known: IsKnown) -> bool:
    match expr:
        case Name(name=name):
            return is_known(name)
        case Call(function=function):
            return function in FUNCTIONS
    return isinstance(expr, Number | Negate | Binary)


def uncomputable_claims(numbers: Numbers) -> Iterator[Diagnostic]:
    """Find parts of guarantees that depend on params only and have no value, or no finite one."""
    variables = {v.name for v in numbers.variables}

    def is_known(name: str) -> bool:
        return name not in variables and "." not in name

    for guarantee in numbers.system.guarantees:
        for expr in (guarantee.claim, guarantee.when):
            for constant in constants(expr, is_known) if expr is not None else ():
                place = span_of(constant) or guarantee.span
                error, value = numbers.failure(constant), numbers.value(constant)
                if error is not None:
                    yield Diagnostic("FZ307", error.message, error.span or place, help=error.help)
                elif value is not None and math.isinf(value):
                    message = "a number of the guarantee is infinite"
                    yield Diagnostic("FZ302", message, place, help="only feet may be infinite; leave the bound out")
            for quotient, divisor in quotients(expr, is_known) if expr is not None else ():
                if numbers.value(divisor) == 0.0:
                    place = span_of(quotient) or guarantee.span
                    yield Diagnostic("FZ307", DIVISION, place, help=REPAIRS[DIVISION])


def bad_claims(numbers: Numbers) -> Iterator[Diagnostic]:
    """Find bounds that no output can keep: a lower one above the upper one, and a negative slope."""
    for guarantee in numbers.system.guarantees:
        for node in walk(guarantee.claim):
            if isinstance(node, Call) and node.function == "bounded":
                low, high = (numbers.finite(a) for a in node.arguments[1:])
                if low is not None and high is not None and low > high:
                    message = f"the lower bound {low:.6g} is greater than the upper one, {high:.6g}"
                    yield Diagnostic("FZ302", message, node.span or guarantee.span, help="swap them")
            elif isinstance(node, Compare) and isinstance(node.left, Call) and node.left.function == "total":
                least = numbers.finite(node.right)
                if least is not None and not 0 < least <= 1:
                    message = f"the strength {least:.6g} lies outside (0, 1]"
                    yield Diagnostic("FZ302", message, span_of(node.right) or guarantee.span)
            elif isinstance(node, Compare) and isinstance(node.left, Call) and node.left.function == "lipschitz":
                bound = numbers.finite(node.right)
                if bound is not None and bound < 0:
                    message = f"the bound {bound:.6g} of a slope is below 0"
                    yield Diagnostic("FZ302", message, span_of(node.right) or guarantee.span)


#: Each needs no more than the numbers it looks at, so all run on whatever part of a system could be resolved.
VALUE_CHECKS: Final[tuple[Callable[[Numbers], Iterator[Diagnostic]], ...]] = (
    uncomputable_numbers,
    uncomputable_claims,
    empty_ranges,
    params_outside,
    bad_parameters,
    bad_heights,
    bad_weights,
    bad_tolerances,
    bad_claims,
)
