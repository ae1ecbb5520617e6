"""Lookup tables: the outputs at even steps of the inputs, multilinear between, with a proved bound of their error."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, Context
from itertools import pairwise, product
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.analysis.coverage.coverage import uncovered_of
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.diagnostics.diagnostic import NoRuleFiresError
from fuzzyctl.kernels.algorithms.grid import STEEPEST, Grid, Table
from fuzzyctl.kernels.algorithms.select import Algorithm
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.program import scalar

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

#: Most entries of a table.
MOST_ENTRIES: Final = 1 << 16
#: Most corners of the boxes on which a table and an interpolating system are both multilinear.
_MOST_CORNERS: Final = 1 << 22
#: Most of a coefficient, whose sums are numbers still.
_LARGEST: Final = 1e300
#: A bound beyond this part of an output's span says nothing.
USEFUL: Final = 0.5


@dataclass(frozen=True)
class Tabulated:
    """A lookup table in place of a system.

    Args:
        grid: Its knots and entries.
        errors: Proved bound of the error of each output, for all inputs.
        proof: How the bounds were found.
    """

    grid: Grid
    errors: tuple[float, ...]
    proof: str


def tabulated(algorithm: Algorithm, points: int) -> Tabulated:
    """Tabulate a system.

    Args:
        algorithm: The system; one that interpolates has a table without error if its knots lie on those of the table.
        points: Points along each input, at least 2.

    Raises:
        CodegenError: For a system with a state, without a value somewhere, with an input that has no ends, or without
            a useful bound of the error; for a table that is too large.
    """
    flat, grid = algorithm.plan, algorithm.grid
    _require_suited(flat, grid)
    inputs, knots = _axes(flat, grid, points)
    if math.prod(map(len, knots)) > MOST_ENTRIES:
        raise CodegenError(
            f"a table of {points} points along {len(inputs)} inputs has more than {MOST_ENTRIES:,} entries"
        )
    slopes = _steepest(flat, inputs, knots)
    values = _values(algorithm, inputs, knots)
    if max(max(map(abs, entries)) for entries in values) > _LARGEST / slopes:
        raise CodegenError("the values of the outputs are too large for a table of these ranges")
    tables = tuple(Table(entries, (), min(entries), max(entries)) for entries in values)
    result = Grid(inputs, knots, tables)
    if grid is not None and not any(t.weight for t in grid.outputs):
        errors, proof = _compared(grid, result), "exact, at all corners of both partitions"
    else:
        from fuzzyctl.codegen.table_error import enclosed  # numpy, which other targets do without

        errors, proof = enclosed(flat, result), "by interval analysis of each cell"
    for output, entries, error in zip(flat.outputs, values, errors, strict=True):
        span = max(output.upper - output.lower, max(entries) - min(entries))
        if not error <= USEFUL * span:
            raise CodegenError(
                f"no useful bound is found for the error of a table of {output.name!r} with {points} points along each "
                f"input: at most {at_most(error)}, of a span of {span:.3g}; take more points"
            )
    return Tabulated(result, errors, proof)


def _require_suited(flat: Plan, grid: Grid | None) -> None:
    if flat.initial_state:
        raise CodegenError("a system with a state has no table")
    for name, verdict in uncovered_of(flat).items():
        otherwise = next(o.otherwise for o in flat.outputs if o.name == name)
        if verdict is not None and (not isinstance(otherwise, float) or math.isnan(otherwise)):
            raise CodegenError(f"{name!r} may have no value where no rule fires, so it has no table")
    open_ended = next((i.name for i in flat.inputs if i.extrapolate), None)
    if grid is None and open_ended is not None:
        raise CodegenError(f"{open_ended!r} is extrapolated, so a table has no ends")


def _axes(flat: Plan, grid: Grid | None, points: int) -> tuple[tuple[int, ...], tuple[tuple[float, ...], ...]]:
    """Return the inputs of the table and its knots: over the range, or the part of it where something changes."""
    if grid is None:
        inputs = tuple(range(len(flat.inputs)))
        ends = [(i.lower, i.upper) for i in flat.inputs]
    else:
        inputs, ends = grid.inputs, [(k[0], k[-1]) for k in grid.knots]
    knots = []
    for a, b in ends:
        inner = [a + (b - a) * (k / (points - 1)) for k in range(1, points - 1)]
        knots.append(tuple(sorted({a, *inner, b})))
    return inputs, tuple(knots)


def _steepest(flat: Plan, inputs: Sequence[int], knots: Sequence[Sequence[float]]) -> float:
    """Return the largest product of slopes, each from 0 to 1 between neighbours, or 1 if that is larger.

    Raises:
        CodegenError: For ranges where such products would leave double precision.
    """
    least = most = 1.0
    for i, axis in zip(inputs, knots, strict=True):
        widths = [b - a for a, b in pairwise(axis)]
        if not all(1.0 / STEEPEST < w < STEEPEST for w in widths):
            raise CodegenError(f"the range of {flat.inputs[i].name!r} is too small or too large for a table")
        least, most = least * min(1.0, *widths), most * max(1.0, *widths)
    if not 1.0 / STEEPEST < least <= most < STEEPEST:
        raise CodegenError("the ranges of the inputs together are too small or too large for a table")
    return 1.0 / least


def _values(algorithm: Algorithm, inputs: Sequence[int], knots: Sequence[Sequence[float]]) -> list[tuple[float, ...]]:
    """Return each output at the knots, the last input varying fastest."""
    flat, program = algorithm.plan, algorithm.printed
    names = [i.name for i in flat.inputs]
    kernel: Callable[..., Any] = scalar.compile_source(scalar.evaluation_source(program), program, names)
    point = [0.0 if i.extrapolate else i.lower for i in flat.inputs]
    rows = []
    for combination in product(*knots):
        for i, x in zip(inputs, combination, strict=True):
            point[i] = x
        try:
            result = kernel(*point)
        except NoRuleFiresError as error:
            raise CodegenError(str(error)) from None
        row = result if isinstance(result, tuple) else (result,)
        if not all(map(math.isfinite, row)):
            raise CodegenError(f"an output has no value at {scalar.point_text(names, point)}")
        rows.append(row)
    return list(zip(*rows, strict=True))


# --- systems that interpolate: both functions are multilinear on common boxes, so is their difference ----------------


def _compared(exact: Grid, table: Grid) -> tuple[float, ...]:
    """Return the largest difference of two multilinear functions: it lies at a corner of their common boxes."""
    import numpy as np

    joint = [tuple(sorted({*a, *b})) for a, b in zip(exact.knots, table.knots, strict=True)]
    if math.prod(map(len, joint)) > _MOST_CORNERS:
        raise CodegenError(f"the error of the table is not bounded: it has more than {_MOST_CORNERS:,} corners to test")
    errors = []
    for reference, other in zip(exact.outputs, table.outputs, strict=True):
        with np.errstate(all="ignore"):  # a value that overflows has no useful bound
            difference = _at(reference.value, exact.knots, joint) - _at(other.value, table.knots, joint)
        # Entries are rounded, and so are the weights of this comparison.
        slack = 64.0 * len(joint) * 2.0**-52 * max(map(abs, reference.value))
        errors.append(float(np.max(np.abs(difference))) + slack)
    return tuple(errors)


def _at(values: Sequence[float], knots: Sequence[Sequence[float]], places: Sequence[Sequence[float]]) -> FloatArray:
    """Return a multilinear function at the combinations of some places along each input."""
    import numpy as np

    result = np.array(values, dtype=np.float64).reshape([len(k) for k in knots])
    for axis, (grid, at) in enumerate(zip(knots, places, strict=True)):
        weights = np.array([np.interp(at, grid, row) for row in np.eye(len(grid))]).reshape(len(grid), len(at))
        result = np.moveaxis(np.tensordot(result, weights, axes=(axis, 0)), -1, axis)
    return result


def at_most(bound: float, digits: int = 3) -> str:
    """Return a proved bound in a few digits, rounded up where it has more: read back, it is never below the bound.

    Args:
        bound: Not negative.
        digits: Significant ones; at most 15, so that the printed number is the rounded one.
    """
    text = f"{bound:.{digits}g}"
    if not math.isfinite(bound) or float(text) >= bound:
        return text
    return f"{float(Context(prec=digits, rounding=ROUND_CEILING).create_decimal_from_float(bound)):.{digits}g}"
