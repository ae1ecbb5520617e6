"""Intermediate language: statements and programs, printed by the backends."""

from __future__ import annotations

import math
from typing import Final

from fuzzyctl.expr import Expr, Name, Number
from fuzzyctl.records import record

#: One object, so that programs that hold it compare equal.
NAN: Final = Number(math.nan)


@record(frozen=True, slots=True)
class Place:
    """A position that is computed: the value of an integer name, and some steps further."""

    name: str
    steps: int = 0


@record(frozen=True, slots=True)
class Item(Expr):
    """One number of an array argument or of a constant table.

    Args:
        array: Name of the array.
        index: A position, the name of a loop's counter, or a computed position.
    """

    array: str
    index: int | str | Place


@record(frozen=True, slots=True)
class Assign:
    """Give a name to a value, once."""

    name: str
    value: Expr


@record(frozen=True, slots=True)
class Locate:
    """Find the knot at or below a value, and how far the value lies beyond it.

    Values outside the knots count as the outer knots; NaN gives the first knot and a rest of NaN.

    Args:
        name: Name of the integer: the position of the knot times `stride`.
        rest: Name of the number: x, held within the knots, less the knot.
        x: An atom.
        table: Name of the constant array of the knots.
        knots: Rising, at least one.
        stride: A positive integer.
        wants_rest: Whether the rest is read; text for people has no unused names.
    """

    name: str
    rest: str
    x: Expr
    table: str
    knots: tuple[float, ...]
    stride: int
    wants_rest: bool = True


@record(frozen=True, slots=True)
class Offset:
    """Give a name to an integer: the sum of other integers, each times a constant."""

    name: str
    parts: tuple[tuple[str, int], ...]


@record(frozen=True, slots=True)
class Accumulate:
    """Add up over the entries of constant tables.

    Args:
        count: Number of entries.
        counter: Name of the position.
        body: Assignments for each entry.
        sums: Names of the sums with the summands of each entry; they begin at 0.
    """

    count: int
    counter: str
    body: tuple[Assign, ...]
    sums: tuple[Assign, ...]

    @property
    def fold(self) -> Fold:
        """The same as values that are carried along."""
        first = tuple(Assign(s.name, Number(0.0)) for s in self.sums)
        then = tuple(Assign(s.name, Name(s.name) + s.value) for s in self.sums)
        return Fold(self.count, self.counter, first, self.body, then)


@record(frozen=True, slots=True)
class Fold:
    """Carry values along the entries of constant tables, for more than sums.

    Args:
        count: Number of entries.
        counter: Name of the position.
        first: Names of the values, with their first ones.
        body: Assignments for each entry, from the old values.
        then: The same names as in `first`, with the new values; names and numbers that stay as they are.
    """

    count: int
    counter: str
    first: tuple[Assign, ...]
    body: tuple[Assign, ...]
    then: tuple[Assign, ...]


@record(frozen=True, slots=True)
class Between:
    """Interpolate between two values that the same statements compute; only the kernels' own programs have these.

    Args:
        name: Name of the result: the first value + share · (the second one - the first one).
        side: Name of the counter, an integer: 0 for the first value, 1 for the second one.
        share: How far the result lies from the first value to the second one, an atom.
        body: Statements for each side, among them others of this kind.
        value: The result of the body, an atom.
    """

    name: str
    side: str
    share: Expr
    body: tuple[Statement, ...]
    value: Expr


@record(frozen=True, slots=True)
class Crossings:
    """The comparisons at which a set that is integrated may jump.

    Args:
        body: Statements for each place.
        values: Of each comparison, those first that change others, four atoms: whether it holds, 1 or 0; by how much
            its sides differ; and the derivatives of this by the place and by what the set is differentiated by.
    """

    body: tuple[Statement, ...]
    values: tuple[Expr, ...]


@record(frozen=True, slots=True)
class Quadrature:
    """Integrate a set that depends on a place, from the first to the last entry of a constant table; see `quadrature`.

    Args:
        found: Name of the result: the first moment about 0, or the place up to which the area is half.
        area: Name of the area.
        kind: Name of the function: `moments`, `half`, or `jumps`, which finds the parts of jumps in the derivatives of
            moment and area.
        x: Name of the place.
        body: Statements for each place.
        value: The degree there.
        given: Names that body and value read besides the place.
        places: Name of the table, whose entries rise.
        marks: Atoms between the first and the last entry, where the set may bend or jump.
        crossings: For `jumps` where they are and how fast they move, else None.
    """

    found: str
    area: str
    kind: str
    x: str
    body: tuple[Statement, ...]
    value: Expr
    given: tuple[str, ...]
    places: str
    marks: tuple[Expr, ...]
    crossings: Crossings | None = None

    @property
    def function(self) -> str:
        """The name of the set as a function."""
        return f"set_{self.found}"

    @property
    def crossing_function(self) -> str:
        """The name of its crossings as a function."""
        return f"crossing_{self.found}"


@record(frozen=True, slots=True)
class Refuse:
    """Stop where a condition holds: no rule fires for an output that says `else error`."""

    condition: Expr
    output: str

    @property
    def message(self) -> str:
        """What compiled code, whose exceptions are constants, can say."""
        return f"no rule fires for output '{self.output}'"


Statement = Assign | Locate | Offset | Accumulate | Fold | Between | Quadrature | Refuse


@record(frozen=True)
class Program:
    """A function as a list of statements.

    Args:
        arguments: Names of its scalar arguments, the raw inputs.
        state: Length of the array argument `C` with the adaptive consequents; 0 for none.
        tables: Constant arrays by name.
        body: Statements; every name is assigned once.
        results: Its results, one expression for each output, or stores, one for each entry of the state.
    """

    arguments: tuple[str, ...]
    state: int
    tables: tuple[tuple[str, tuple[float, ...]], ...]
    body: tuple[Statement, ...]
    results: tuple[Expr, ...]


#: Name of the array argument that holds the adaptive consequents.
STATE: Final = "C"
