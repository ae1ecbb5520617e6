"""Pass that guards statements: firing strengths of rules with a degree 0 are skipped in generated Python.

Of the terms of a partition all but two are 0 at any point, and with them the rules that name them. Where such rules
only take part in maxima, as they do before sets are joined, a test for each term saves most of the work.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from fuzzyctl.expr import ZERO, Binary, Call, Expr, Name, Number
from fuzzyctl.kernels.program.program import Assign, Branches, Guarded, Program, Refuse, Statement
from fuzzyctl.kernels.program.traversal import uses

#: Fewer strengths than this cost less than the tests.
LEAST: Final = 8


def skipping(program: Program) -> Program:
    """Return a program that leaves out strengths that are 0; the same numbers come out, as maxima have no rounding.

    A program in which something else is not computed point by point in plain steps stays as it is.
    """
    if not all(isinstance(s, Assign | Branches | Refuse) for s in program.body):
        return program
    found = _Found(program)
    if len(found.strengths) < LEAST:
        return program
    first = min(k for k, s in enumerate(program.body) if isinstance(s, Assign) and s.name in found.strengths)
    if any(isinstance(s, Branches) for s in program.body[first:]):
        return program
    gone = found.strengths.keys() | found.links.keys()
    rest = [s for s in program.body[first:] if not (isinstance(s, Assign) and s.name in gone)]
    return replace(program, body=(*program.body[:first], *found.statements(), *rest))


class _Found:
    """The strengths of a program that are 0 where a degree is, and the maxima that they take part in.

    Attributes:
        strengths: What strengths are, by name, those that nothing but maxima and each other use.
        links: The steps of these maxima: to which maximum each belongs.
    """

    def __init__(self, program: Program) -> None:
        self.degrees = {n: n for s in program.body if isinstance(s, Branches) for n in s.names}
        self.assigned = {s.name: s.value for s in program.body if isinstance(s, Assign)}
        self.uses = uses(program)
        self.guards: dict[str, str] = {}
        for name, value in self.assigned.items():
            guard = self._guard(value)
            if guard is not None:
                self.guards[name] = guard
        self.links: dict[str, str] = {}
        self.maxima = self._maxima()
        leaves = {leaf for own in self.maxima.values() for leaf in own}
        self.strengths = {n: self.assigned[n] for n in self.guards if n in leaves}

    def _guard(self, value: Expr) -> str | None:
        """Return a degree where which is 0 a value is, too; None where that is not known."""
        match value:
            case Name(name=name):
                return self.degrees.get(name)
            case Call(function="min", arguments=parts):
                pass
            case Binary(op="*", left=left, right=right):
                parts = (left, right)
            case _:
                return None
        guards = [self._guard(p) for p in parts if not _is_share(p)]
        return guards[0] if guards and all(g is not None for g in guards) else None

    def _maxima(self) -> dict[str, list[str]]:
        """Return the maxima over strengths that nothing else uses, each with these strengths."""
        chains: dict[str, list[str]] = {}
        for name, value in self.assigned.items():
            match value:
                case Call(function="max", arguments=(Name(name=left), Name(name=right))):
                    parts = [self._leaves(chains, p) for p in (left, right)]
                    if all(p for p in parts):
                        chains[name] = [leaf for p in parts for leaf in p]
                        self.links |= {n: name for n in (left, right) if n in chains} | {name: name}
        return {name: own for name, own in chains.items() if self.links[name] == name}

    def _leaves(self, chains: dict[str, list[str]], name: str) -> list[str]:
        if self.uses[name] != 1:
            return []
        return chains.get(name) or ([name] if name in self.guards else [])

    def statements(self) -> list[Statement]:
        """Return what computes the maxima: each is 0 at first, and grows with the strengths that are not 0."""
        found: list[Statement] = [Assign(name, ZERO) for name in self.maxima]
        of_degree: dict[str, list[Assign]] = {}
        for name, leaves in self.maxima.items():
            for leaf in leaves:
                grown = Assign(name, Call("max", (Name(leaf), Name(name))))
                of_degree.setdefault(self.guards[leaf], []).extend([Assign(leaf, self.strengths[leaf]), grown])
        return found + [Guarded(degree, tuple(body)) for degree, body in of_degree.items()]


def _is_share(value: Expr) -> bool:
    """Return whether a value is a number that makes no degree negative or NaN."""
    return isinstance(value, Number) and 0.0 <= value.value < math.inf
