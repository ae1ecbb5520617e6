"""Checks of numbers in guarantees: bounds are computable, finite and in order."""

from __future__ import annotations

import math
from collections.abc import Iterator

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.expr import DIVISION, REPAIRS, Call, Compare, span_of, walk
from fuzzyctl.model.checks.constants import constants, quotients
from fuzzyctl.model.computed_numbers import Numbers


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
