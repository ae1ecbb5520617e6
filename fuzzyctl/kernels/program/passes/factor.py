"""Pass that factors common degrees out of sums: a sum over rows of sums over columns.

Where each rule has a consequent of its own, as in first-order Takagi-Sugeno systems, a weighted average multiplies
once for each rule to find its firing strength, and multiplies and adds twice to use it. Taken out of the sum, the
degree of a row is multiplied once a row, and the sum of all strengths becomes a product of one sum for each input.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import count
from typing import Final

from fuzzyctl.expr import ONE, Binary, Expr, Name, Number, names_in, walk
from fuzzyctl.kernels.program.builder import SUMMANDS, times
from fuzzyctl.kernels.program.passes.inline import ONCE
from fuzzyctl.kernels.program.program import Assign, Program, Statement
from fuzzyctl.kernels.program.traversal import expressions, uses

#: Products of two numbers up to this one, and sums of them, stay finite.
LARGEST: Final = 1e150

#: A summand: the degrees that are multiplied, the weight of the rule, and what all that is multiplied by.
_Summand = tuple[tuple[str, ...], Expr, Expr]


def factored(program: Program) -> Program:
    """Return a program that computes the same sums of products in another order, where that takes fewer steps.

    All that is taken out are firing strengths, so no digits are lost: a nested sum of n products is off by n units in
    the last place at most, as the plain one is.
    """
    if not all(isinstance(s, ONCE) for s in program.body) or _may_overflow(program):
        return program
    sums = _Sums(program)
    body: list[Statement] = []
    for statement in program.body:
        if isinstance(statement, Assign) and statement.name in sums.summands:
            body += sums.nested(statement.name)
        else:
            body.append(statement)
    changed = _needed(replace(program, body=tuple(body)))
    return changed if _steps(changed) < _steps(program) else program


class _Sums:
    """The sums of a program whose summands are products with factors in common.

    Attributes:
        summands: Of each such sum its summands, by the name of the sum.
    """

    def __init__(self, program: Program) -> None:
        self._values = {s.name: s.value for s in program.body if isinstance(s, Assign)}
        self._inner: dict[Expr, Name] = {}
        self._fresh = count(1)
        self._parts: set[str] = set()
        self.summands: dict[str, list[_Summand]] = {}
        for name, value in reversed(self._values.items()):
            own = self._split(value) if _is_sum(value) and name not in self._parts else None
            if own is not None and len({left for (left, *_), _, _ in own}) < len(own):
                self.summands[name] = own

    def _split(self, whole: Expr) -> list[_Summand] | None:
        """Return a sum, of names and of names times something, as summands; None for any other sum."""
        found: list[_Summand] = []
        waiting: list[tuple[Expr, Expr]] = [(whole, ONE)]
        while waiting:
            value, factor = waiting.pop()
            match value:
                case Binary(op="+", left=left, right=right):
                    waiting += [(right, factor), (left, factor)]
                    continue
                case Binary(op="*", left=Name(name=name), right=own):
                    factor = times(own, factor)
                case Name(name=name):
                    pass
                case _:
                    return None
            if _is_sum(self._values.get(name)):
                self._parts.add(name)
                waiting.append((self._values[name], factor))
                continue
            degrees, weight = self._strength(name)
            if len(degrees) < 2:
                return None
            found.append((degrees, weight, factor))
        return found

    def _strength(self, name: str) -> tuple[tuple[str, ...], Expr]:
        """Return the degrees whose product a firing strength is, and its weight."""
        match self._values.get(name):
            case Binary(op="*", left=Name(name=own), right=Number() as weight):
                return self._degrees(self._values.get(own)), weight
            case value:
                return self._degrees(value), ONE

    def _degrees(self, value: Expr | None) -> tuple[str, ...]:
        """Return the names that a value is the product of, none for anything else."""
        match value:
            case Name(name=name):
                return self._degrees(self._values.get(name)) or (name,)
            case Binary(op="*", left=left, right=right):
                own = self._degrees(left), self._degrees(right)
                return own[0] + own[1] if all(own) else ()
        return ()

    def nested(self, name: str) -> list[Statement]:
        """Return the statements of a sum with the common factors taken out."""
        statements: list[Statement] = []
        value = self._nested(self.summands[name], statements)
        return [*statements, Assign(name, value)]

    def _nested(self, summands: Sequence[_Summand], statements: list[Statement]) -> Name:
        """Write the sum over what each degree multiplies, once for all degrees that multiply the same."""
        parts: list[Expr] = []
        groups: dict[str, list[_Summand]] = {}
        for (first, *rest), weight, factor in summands:
            if rest:
                groups.setdefault(first, []).append((tuple(rest), weight, factor))
                continue
            degree = Name(first) if weight == ONE else self._named(Name(first) * weight, statements)
            parts.append(times(degree, factor))
        rows: dict[Name, list[Expr]] = {}
        for first, own in groups.items():
            rows.setdefault(self._nested(own, statements), []).append(Name(first))
        parts += [times(self._total(degrees, statements), inner) for inner, degrees in rows.items()]
        return self._total(parts, statements)

    def _total(self, parts: Sequence[Expr], statements: list[Statement]) -> Name:
        """Write a sum as statements that are not deep."""
        total = parts[0]
        for k, part in enumerate(parts[1:], 1):
            total = (total if k % SUMMANDS else self._named(total, statements)) + part
        return self._named(total, statements)

    def _named(self, value: Expr, statements: list[Statement]) -> Name:
        if isinstance(value, Name):
            return value
        if value not in self._inner:
            self._inner[value] = Name(f"f{next(self._fresh)}")
            statements.append(Assign(self._inner[value].name, value))
        return self._inner[value]


def _is_sum(value: Expr | None) -> bool:
    return isinstance(value, Binary) and value.op == "+"


def _may_overflow(program: Program) -> bool:
    """Return whether what a degree of 0 is multiplied by may be infinite once sums are taken apart."""
    numbers = (n.value for e in expressions(program) for n in walk(e) if isinstance(n, Number))
    return any(LARGEST < abs(value) < math.inf for value in numbers)


def _steps(program: Program) -> int:
    """Count the operations of arithmetic."""
    return sum(isinstance(n, Binary) for e in expressions(program) for n in walk(e))


def _needed(program: Program) -> Program:
    """Return a program without assignments that nothing needs."""
    used = uses(program)
    body: list[Statement] = []
    for statement in reversed(program.body):
        if isinstance(statement, Assign) and not used[statement.name]:
            used.subtract(n.name for n in names_in(statement.value))
        else:
            body.append(statement)
    return replace(program, body=tuple(reversed(body)))
