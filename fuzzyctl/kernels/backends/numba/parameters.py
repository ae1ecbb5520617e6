"""Machine code without numbers: systems that differ in nothing else share it, and hand it theirs as a table.

A system whose param has another value is another function, which numba would compile anew: a third of a second for each
value of a sweep. Here the numbers of a program and its constant tables stand in one array, which is an argument.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Final

from fuzzyctl.kernels.program.printer import Dialect, counted, index_text, number, searched
from fuzzyctl.kernels.program.program import Locate, Place, Program, Quadrature

#: Name of the argument.
TABLE: Final = "K"

#: Numbers that tell a compiler more than an entry of a table does.
_PLAIN: Final = (0.0, 1.0)


class Numbers:
    """The numbers of one program, in the order in which its text names them.

    Attributes:
        values: They, once the text is written.
        shares: Whether they stand in the table; the functions of sets that are integrated do not see it.

    Args:
        program: The program.
    """

    def __init__(self, program: Program) -> None:
        self.values: list[float] = []
        self.shares = not any(isinstance(s, Quadrature) for s in program.body)
        self._named: set[int] = set()
        self._places: dict[str, int] = {}
        for name, values in program.tables if self.shares else ():
            self._places[name] = len(self.values)
            self.values += values

    def dialect(self, base: Dialect, most_counted: int) -> Dialect:
        """Return a dialect that takes numbers and tables from the argument; more knots than that are searched."""
        if not self.shares:
            return base
        locate = partial(self._locate, most_counted)
        return replace(base, constant=self._constant, item=self._item, locate=locate)

    def taken(self) -> list[str]:
        """Return lines that give names to the numbers that the text names, as far as it is written."""
        return [f"{TABLE}{k} = {TABLE}[{k}]" for k in sorted(self._named)]

    def _constant(self, value: float) -> str:
        if value in _PLAIN or value - value != 0.0:
            return number(value)
        self.values.append(value)
        return self._name(len(self.values) - 1)

    def _name(self, position: int) -> str:
        self._named.add(position)
        return f"{TABLE}{position}"

    def _item(self, array: str, index: int | str | Place) -> str:
        first = self._places.get(array)
        if first is None:
            return f"{array}[{index_text(index)}]"
        return f"{TABLE}[{first} + {index_text(index)}]" if first else f"{TABLE}[{index_text(index)}]"

    def _locate(self, most: int, statement: Locate, x: str) -> list[str]:
        first = self._places[statement.table]
        if len(statement.knots) > most:
            return searched(statement, x, TABLE, first)
        knots = [self._name(first + k) for k in range(len(statement.knots))]
        return counted(statement, x, knots, self._item(statement.table, statement.name))
