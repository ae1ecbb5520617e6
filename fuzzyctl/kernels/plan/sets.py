"""Fuzzy sets and consequents of a plan, with numbers as parameters."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property, reduce
from itertools import groupby, pairwise
from typing import Final

from fuzzyctl.expr import (
    COMPARISONS,
    ONE,
    Binary,
    Call,
    Compare,
    Expr,
    ExprError,
    Name,
    Number,
    Where,
    evaluate,
    names_in,
    replace,
    replace_names,
    walk,
)
from fuzzyctl.formulas import Vertex, formula_of, held
from fuzzyctl.formulas.formula import is_infinite
from fuzzyctl.formulas.inverse import solved
from fuzzyctl.kernels.plan.traced import is_free
from fuzzyctl.kernels.program.builder import Builder, clip
from fuzzyctl.kernels.program.program import Item, Place
from fuzzyctl.records import record

#: The name of the variable itself in the expression of a `function` term of an input.
ITSELF: Final = "x"


@record(frozen=True)
class SetPlan:
    """A fuzzy set, or a consequent of Takagi-Sugeno, with its parameters as numbers.

    Args:
        kind: A key of `formulas.MEMBERSHIP`, `linear`, `function` or `formula`.
        parameters: Its parameters, none for the last three.
        height: The largest degree.
        expression: For `linear` and `function` consequents over the names of the inputs, for a `function` term of an
            input, and a `formula` of an output, over `ITSELF`.
        changes: The changes of its degree by hedges and weights, one after the other, each an expression over `ITSELF`.
        implication: How rules imply it, where that is not the implication of the output; None where it is.
        reach: For a `linear` consequent of inputs that are clamped the numbers it lies between, up to rounding; kernels
            hold what they compute within. None if it is unknown.
    """

    kind: str
    parameters: tuple[float, ...]
    height: float = 1.0
    expression: Expr | None = None
    reach: tuple[float, float] | None = None
    changes: tuple[Expr, ...] = ()
    implication: str | None = None

    def degree(self, x: Expr) -> Expr:
        """Return the degree of x."""
        if self.expression is not None:
            degree = held(replace_names(self.expression, {ITSELF: x}))
        else:
            degree = formula_of(self.kind).degree(x, self.parameters)
        return self.finished(degree)

    @cached_property
    def degree_of_x(self) -> Expr:
        """The degree of a name `x`, built once: that of a function of many points is a large expression."""
        return self.degree(Name("x"))

    def finished(self, value: Expr) -> Expr:
        """Return what height, hedges and weights make of the degree that the function itself has."""
        whole = value if self.height == 1.0 else self.height * value
        return reduce(lambda degree, change: replace_names(change, {ITSELF: degree}), self.changes, whole)

    def degree_for_many(self, x: Expr, *, exact: bool) -> Expr:
        """Return the degree of x as vector instructions like it: without choices, for triangles and trapezoids.

        Each side is a line, the smaller of them counts, held within [0, 1].

        Args:
            x: An atom.
            exact: Whether it must be the same number as `degree`; if not, it is 0 or 1 at the same corners and may
                differ by rounding between them, where a product is cheaper than a quotient.
        """
        sides = _sides(self)
        if sides is None:
            return self.degree(x)
        degree = clip(reduce(lambda a, b: Call("min", (a, b)), [_line(x, *s, exact=exact) for s in sides]), 0.0, 1.0)
        return degree if self.height == 1.0 else self.height * degree

    @property
    def reads_inputs(self) -> bool:
        """Whether it is a consequent that is a function of the inputs, and no set."""
        return self.expression is not None and self.kind != "formula"

    @property
    def is_free(self) -> bool:
        """Whether some number of it is known only at run time."""
        exprs = [*self.changes, *([] if self.expression is None else [self.expression])]
        inside = (node.value for e in exprs for node in walk(e) if isinstance(node, Number))
        return any(map(is_free, (*self.parameters, self.height, *inside)))

    @property
    def has_sides(self) -> bool:
        """Whether it is a triangle or trapezoid without jumps."""
        return _sides(self) is not None

    @cached_property
    def vertices(self) -> tuple[Vertex, ...]:
        """Corners of a piecewise-linear set, empty for a curved one."""
        if self.expression is not None or not all(map(_is_straight, self.changes)):
            return ()
        corners = [(x, self.height * y) for x, y in formula_of(self.kind).vertices(self.parameters)]
        for change in self.changes:
            corners = [(x, evaluate(change, {ITSELF: y})) for x, y in corners]
        return tuple(corners)

    @property
    def pieces(self) -> tuple[float, ...]:
        """Finite places where the formula changes, such as corners; of an expression those it compares x with."""
        if self.expression is not None:
            return tuple(sorted(set(_compared(self.expression))))
        formula = formula_of(self.kind)
        places = [*formula.core(self.parameters), *formula.pieces(self.parameters)]
        return tuple(sorted({x for x in places if not is_infinite(x)}))

    @property
    def peak(self) -> float:
        """The middle of the core, which averages take (Eq. (18) of Goto, Bertol, Martins)."""
        left, right = formula_of(self.kind).core(self.parameters)
        return left if left == right else 0.5 * left + 0.5 * right

    def share(self, activation: Expr, *, limited: bool = True) -> Expr:
        """Return an activation relative to the height; `limited` to at most 1, which it may pass."""
        share = activation if self.height == 1.0 else activation / self.height
        return Call("min", (ONE, share)) if limited else share

    def inverse(self, share: Expr) -> Expr:
        """Return where a monotone set has a share, which must be a name, of its height."""
        if self.kind == "formula" and self.expression is not None:
            place = solved(self.expression, ITSELF, share)
            assert place is not None, "tsukamoto takes formulas that can be solved only"
            return place
        result = formula_of(self.kind).inverse(share, self.parameters)
        assert result is not None, "tsukamoto takes monotone sets only"
        return result


def _compared(expression: Expr) -> Iterator[float]:
    """Yield the numbers that an expression over `ITSELF` compares it with."""
    for node in walk(expression):
        if isinstance(node, Call) and node.function in COMPARISONS and Name(ITSELF) in node.arguments:
            values = [_value(a) for a in node.arguments if not names_in(a)]
            yield from (v for v in values if v is not None and math.isfinite(v))


def _value(expression: Expr) -> float | None:
    """Return the value of an expression without names, None where it has none."""

    def plain(node: Expr) -> Expr:
        match node:
            case Call(function="divide", arguments=(a, b)):
                return a / b
        return node

    try:
        return evaluate(replace(expression, plain), {})
    except ExprError:
        return None


def _is_straight(change: Expr) -> bool:
    """Return whether a change of degrees is a line: a complement or a factor."""
    match change:
        case Binary(op="-" | "*", left=Number(), right=Name()):
            return True
    return False


def _sides(term: SetPlan) -> list[tuple[float, float]] | None:
    """Return foot and top of the sides of a triangle or trapezoid, None for any other set."""
    if term.expression is not None or term.changes:
        return None
    corners = formula_of(term.kind).vertices(term.parameters)
    tops = [x for x, y in corners if y == 1.0]
    feet = [x for x, y in corners if y == 0.0]
    if not feet or len(tops) + len(feet) < len(corners) or len({x for x, _ in corners}) < len(corners):
        return None
    left, right = [x for x in feet if x < tops[0]], [x for x in feet if x > tops[-1]]
    if len(left) > 1 or len(right) > 1 or len(left) + len(right) < len(feet):  # else there is a valley between tops
        return None
    return [(x, tops[0]) for x in left] + [(x, tops[-1]) for x in right]


def _line(x: Expr, foot: float, top: float, *, exact: bool) -> Expr:
    """Return the line that is 0 at the foot and 1, or by rounding a bit more, at the top."""
    beyond = x - foot if top > foot else foot - x
    slope = 1.0 / abs(top - foot)
    if exact or math.isinf(slope):
        return beyond / abs(top - foot)
    while slope * abs(top - foot) < 1.0:
        slope = math.nextafter(slope, math.inf)
    return beyond * slope


#: Most corners of a term that is written as choices; a larger one is a table.
MOST_CHOICES: Final = 32


def degree_of(builder: Builder, term: SetPlan, x: Expr) -> Expr:
    """Return the degree of an atom: from tables for a term of many corners, where the program may have them."""
    is_large = builder.most_pairs is not None and term.kind == "piecewise" and len(term.parameters) > 2 * MOST_CHOICES
    return term.finished(_looked_up(builder, term.parameters, x)) if is_large else term.degree(x)


def _looked_up(builder: Builder, parameters: tuple[float, ...], x: Expr) -> Expr:
    """Search the stretch of x and go straight between its ends, as the formula of `piecewise` does."""
    corners = zip(parameters[::2], parameters[1::2], strict=True)
    degrees = {place: [y for _, y in rows] for place, rows in groupby(corners, key=lambda corner: corner[0])}
    places = tuple(degrees)
    first, last = ([rows[k] for rows in degrees.values()] for k in (0, -1))
    rises = [b - a for a, b in zip(last, first[1:], strict=False)]
    widths = [b - a for a, b in pairwise(places)]
    name, rest = builder.located(x, places)

    def item(values: list[float]) -> Expr:
        return Item(builder.table(values), Place(name))

    run = item([*rises, 0.0]) * (rest / item([*widths, 1.0]))
    degree: Expr = item(last) + run
    tops = [max(rows) for rows in degrees.values()]
    if tops != last:  # at a jump the largest degree holds
        degree = Where(Compare("==", x, item(list(places))), item(tops), degree)
    if first[0] != last[0]:
        degree = Where(Compare("<", x, Number(places[0])), Number(first[0]), degree)
    return degree
