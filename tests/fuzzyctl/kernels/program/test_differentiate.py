"""Derivatives of programs: every primitive beside central differences, loops, searches, kinks and refusals."""

import math

import pytest

from fuzzyctl.expr import ONE, Binary, Call, Compare, Logic, Name, Number, Where
from fuzzyctl.kernels.program import scalar as backend
from fuzzyctl.kernels.program.builder import Builder
from fuzzyctl.kernels.program.derivatives import NotDifferentiableError, differentiated
from fuzzyctl.kernels.program.program import Accumulate, Assign, Between, Fold, Item, Locate, Program

X, Y = Name("x0"), Name("x1")


def program_of(value):
    builder = Builder()
    return builder.program([X, Y], [builder.let(value)])


def results(program, *point):
    found = [0.0] * len(program.results)
    backend.compile_source(backend.storing_source(program), program, ["x", "y"])(*point, found)
    return found


def gradient(program, *point):
    return results(differentiated(program, ["x0", "x1"]), *point)


VALUES = [
    X + Y,
    X - Y,
    -X * Y,
    X / Y,
    X**2.0,
    X**Y,
    X**-1.5 * Y,
    *(Call(name, (X * Y,)) for name in ("abs", "sqrt", "exp", "log", "sin", "cos", "tan")),
    Call("abs", (-X * Y,)),
    Call("atan2", (X, Y)),
    Call("divide", (X * X, Y + X)),
    Call("power", (X + Y, Y)),
    Call("fmod", (5.0 * X, Y)),
    Call("mod", (-5.0 * X, Y)),
    Call("floor", (X * 7.0,)) * Y,
    Call("round", (X * 7.0,)) + Y,
    Call("sign", (X - Y,)) * X,
    Call("lt", (X, Y)) * X,
    Call("min", (X, Y, X * Y)),
    Call("max", (X, Y, X * Y)),
    Call("smaller", (X * X, Y)),
    Call("larger", (X * X, Y)),
    Call("clip", (X * 3.0, Y, Y + 1.0)),
    Call("clip", (X, Y, Y + 1.0)),
    Call("held", (X * Y,)),
    Call("held", (5.0 * X,)) * Y,
    Where(Compare("<", X, Y), X * Y, X / Y),
]


@pytest.mark.parametrize("point", [(0.4, 0.7), (0.9, 0.31)])
@pytest.mark.parametrize("value", VALUES, ids=str)
def test_each_primitive_has_its_derivative(value, point):
    program, step = program_of(value), 1e-6
    (x, y) = point
    (left,), (right,) = results(program, x - step, y), results(program, x + step, y)
    (below,), (above,) = results(program, x, y - step), results(program, x, y + step)
    expected = [(right - left) / (2 * step), (above - below) / (2 * step)]
    assert gradient(program, *point) == pytest.approx(expected, rel=1e-7, abs=1e-8)


def test_sums_over_tables_and_values_that_are_carried():
    table = (("T0", (1.0, 2.0, 3.0)),)
    item = Item("T0", "k")
    total = Accumulate(3, "k", (Assign("a", item * X),), (Assign("s", Name("a") * Name("a")),))
    assert gradient(Program(("x0", "x1"), 0, table, (total,), (Name("s"),)), 0.5, 0.0) == [14.0, 0.0]
    body = (Assign("b", Name("p") * X + item * Y), Assign("c", Name("p")))
    then = (Assign("p", Name("b")), Assign("q", Name("c")))
    carried = Fold(3, "k", (Assign("p", Y), Assign("q", ONE)), body, then)
    # p = y x³ + y x² + 2 y x + 3 y, and q is the p before
    found = gradient(Program(("x0", "x1"), 0, table, (carried,), (Name("p"), Name("q"))), 2.0, 3.0)
    assert found == [3 * (12 + 4 + 2), 8 + 4 + 4 + 3, 3 * (4 + 1), 4 + 2 + 2]


def test_the_rest_beyond_a_knot_moves_with_the_value_between_the_knots():
    search = Locate("k", "r", X, "T0", (0.0, 1.0, 2.0), 1)
    program = Program(("x0", "x1"), 0, (("T0", (0.0, 1.0, 2.0)),), (search,), (Name("r") * Y,))
    assert gradient(program, 1.25, 4.0) == [4.0, 0.25]
    assert gradient(program, 2.5, 4.0) == [0.0, 0.0]


def test_at_a_kink_the_slope_ahead_counts():
    assert gradient(program_of(Call("min", (X, 2.0 * Y))), 2.0, 1.0) == [0.0, 0.0]
    assert gradient(program_of(Call("max", (X, 2.0 * Y))), 2.0, 1.0) == [1.0, 2.0]
    assert gradient(program_of(Call("abs", (X * Y,))), 0.0, -1.0) == [1.0, 0.0]
    for function in (lambda x: Call("clip", (x, Number(0.0), ONE)), lambda x: Call("held", (x,))):
        ends = [gradient(program_of(function(x)), at, 0.0)[0] for x in (X, -X) for at in (-1.0, 0.0, 1.0)]
        assert ends == [0.0, 1.0, 0.0, -1.0, 0.0, 0.0]


@pytest.mark.parametrize("op", ["<", "<=", ">", ">=", "==", "!="])
def test_kinks_that_cancel_leave_the_slope(op):
    rising, falling = Compare(op, X, Y), Compare(op, Y, X)
    if op in ("==", "!="):
        program = program_of(Where(Logic("or", (rising, falling)), X + Y, 2.0 * X))
        assert gradient(program, 1.0, 1.0) == [2.0, 0.0] if op == "==" else [1.0, 1.0]
        return
    parts = Where(rising, X - Y, Number(0.0)) + Where(falling, X - Y, Number(0.0))
    assert gradient(program_of(parts), 1.0, 1.0) == [1.0, -1.0]


def test_at_a_jump_the_branch_that_is_taken_counts():
    assert gradient(program_of(Where(Compare("<=", X, Y), 3.0 * X, 5.0 * X)), 1.0, 1.0) == [3.0, 0.0]
    held = Where(Compare(">", X, Number(0.0)), Y / X, 2.0 * Y)
    assert gradient(program_of(held), 0.0, 1.0) == [0.0, 2.0]
    assert gradient(program_of(Call("round", (X,))), 2.0, 1.0) == [0.0, 0.0]


def test_what_does_not_move_has_no_slope_however_steep_the_function():
    assert gradient(program_of(Call("sqrt", (Call("max", (X - 1.0, Number(0.0))),))), 0.5, 0.0) == [0.0, 0.0]
    assert gradient(program_of(Call("max", (X - 1.0, Number(0.0))) ** 0.5), 0.5, 0.0) == [0.0, 0.0]


def test_what_has_no_value_has_no_derivative():
    assert all(map(math.isnan, gradient(program_of(Where(Compare(">", X, Y), Number(math.nan), X)), 1.0, 0.0)))
    assert gradient(program_of(Where(Compare(">", X, Y), Number(math.nan), X)), 0.0, 1.0) == [1.0, 0.0]


def test_loops_over_corners_are_refused():
    loop = Between("v", "k", X, (), Y)
    with pytest.raises(NotDifferentiableError, match="Between"):
        differentiated(Program(("x0", "x1"), 0, (), (loop,), (Name("v"),)), ["x0"])
    with pytest.raises(NotDifferentiableError):
        differentiated(Program(("x0", "x1"), 0, (), (), (Binary("*", Compare("<", X, Y), X),)), ["x0"])
