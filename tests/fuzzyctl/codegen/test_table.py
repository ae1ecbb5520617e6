"""Lookup tables stay within their proved errors; where none is found there is no table."""

import random
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from fuzzyctl import loads
from fuzzyctl.codegen import table_error
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.codegen.vectors import Reference, points
from fuzzyctl.kernels.algorithms.select import Algorithm
from fuzzyctl.kernels.compile import compile as compile_system
from fuzzyctl.kernels.inference.inference import evaluation
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.program.program import Accumulate
from tests.fuzzyctl.codegen.conftest import prepared
from tests.fuzzyctl.codegen.structured_text import differences


def worst(unit, count=40_000, seed=4):
    """Return the largest difference of table and system at random points in and around the ranges."""
    rng = np.random.default_rng(seed)
    columns = []
    for i, variable in enumerate(unit.plan.inputs):
        span = variable.upper - variable.lower
        knots = unit.algorithm.grid.knots[unit.algorithm.grid.inputs.index(i)]
        columns.append(
            np.concatenate(
                [rng.uniform(variable.lower - 0.1 * span, variable.upper + 0.1 * span, count), rng.choice(knots, 500)]
            )
        )
    points = np.stack(columns, axis=1)
    grid = unit.algorithm.grid
    held = np.stack([np.clip(points[:, i], k[0], k[-1]) for i, k in zip(grid.inputs, grid.knots, strict=True)], axis=1)
    shape = [len(k) for k in grid.knots]
    tables = [RegularGridInterpolator(grid.knots, np.reshape(t.value, shape))(held) for t in grid.outputs]
    table = np.stack(tables, axis=1)
    exact = compile_system(unit.system, "numpy").batch(points).reshape(len(points), -1)
    return np.abs(table - exact).max(axis=0)


class TestError:
    @pytest.mark.parametrize("points", [3, 7, 8, 20, 64])
    def test_bounds_every_difference_and_is_attained_where_both_are_multilinear(self, unit_of, points):
        unit = unit_of("ais_reaction", table=points)
        (error,) = worst(unit)
        assert error <= unit.table.errors[0] <= 1.25 * error

    @pytest.mark.parametrize("points", [5, 9, 17, 33])
    def test_is_rounding_where_the_knots_lie_on_the_table(self, unit_of, points):
        unit = unit_of("ais_reaction", table=points)
        assert unit.table.errors[0] < 1e-12

    @pytest.mark.parametrize(("name", "points"), [("tipper", 33), ("exact", 33), ("middle", 65), ("norms", 33)])
    def test_bounds_curved_systems_by_intervals(self, unit_of, name, points):
        try:
            unit = unit_of(name, table=points)
        except CodegenError as error:
            assert "no useful bound" in str(error)  # noqa: PT017 - both answers are honest
            return
        assert "interval" in unit.table.proof
        assert (worst(unit, 5000) <= unit.table.errors).all()

    def test_bounds_sums_over_many_samples_entry_by_entry(self):
        text = (
            "system s\ndefuzzifier centroid(resolution=50)\ninput x in [0, 1]\n  a = ramp(1, 0)\n  b = ramp(0, 1)\n"
            "output y in [0, 1]\n  p = triangle(-0.5, 0, 0.5)\n  q = triangle(0.5, 1, 1.5)\n"
            "if x is a then y is p\nif x is b then y is q\n"
        )
        unit = prepare(loads(text), text, table=65)
        assert any(isinstance(s, Accumulate) for s in evaluation(plan(unit.system)).body)
        assert worst(unit, 5000)[0] <= unit.table.errors[0] < 0.01

    def test_of_a_smooth_curve_falls_with_the_points(self):
        text = (
            "system s\ndefuzzifier weighted_average\ninput x in [0, 1]\n  a = gaussian(0, 0.5)\n"
            "  b = gaussian(1, 0.5)\n"
            "output u in [0, 1]\n  p = constant(0)\n  q = constant(1)\nif x is a then u is p\nif x is b then u is q\n"
        )
        units = [prepare(loads(text), text, table=n) for n in (9, 33, 129)]
        bounds = [u.table.errors[0] for u in units]
        assert bounds[0] > bounds[1] > bounds[2]
        assert all(worst(u)[0] <= b for u, b in zip(units, bounds, strict=True))
        assert bounds[2] < 0.01

    def test_of_a_table_along_diagonals_is_near_what_is_attained(self):
        names = "NB NS ZO PS PB".split()
        rows = "\n".join(
            f"  {n} | {' '.join(names[min(max(i + j - 2, 0), 4)] for j in range(5))}" for i, n in enumerate(names)
        )
        terms = f"  terms {' '.join(names)}"
        variables = "\n".join(f"{v} in [-1, 1]\n{terms}" for v in ("input e", "input de", "output u"))
        text = f"system pd\ndefuzzifier centroid\n{variables}\ntable u = e x de\n  {' '.join(names)}\n{rows}\n"
        unit = prepare(loads(text), text, table=20)
        (error,) = worst(unit)
        assert error <= unit.table.errors[0] <= 2.0 * error

    def test_a_jump_is_in_the_bound_or_refused(self):
        text = (
            "system s\ndefuzzifier weighted_average\ninput x in [0, 1]\n  a = rectangle(-inf, 0.47)\n"
            "  b = rectangle(0.47, inf)\noutput u in [0, 10]\n  p = constant(0)\n  q = constant(2)\n"
            "if x is a then u is p\nif x is b then u is q\n"
        )
        unit = prepare(loads(text), text, table=17)
        assert unit.table.errors[0] >= 1.0


class TestRefusal:
    @pytest.mark.parametrize(
        ("name", "points", "reason"),
        [
            ("fcafsmc", 9, "a state has no table"),
            ("holding", 9, "a state has no table"),
            ("refusing", 9, "'u' may have no value"),
            ("silent", 9, "'u' may have no value"),
            ("open", 9, "'x' is extrapolated"),
            ("ais_reaction", 1000, "more than 65,536 entries"),
            ("ais_reaction", 2, "at most 0.846, of a span of 1.18; take more points"),
            ("takagi", 8, "no useful bound is found"),
        ],
    )
    def test_names_its_reason(self, unit_of, name, points, reason):
        with pytest.raises(CodegenError, match=reason):
            unit_of(name, table=points)


LARGE = """system large
and min
defuzzifier weighted_average
input x in [0, {width}]
  terms a b
input y in [0, 1]
  terms a b
output u in [-{value}, {value}]
  terms p q
table u = x x y
    a b
 a | p q
 b | q p
"""


class TestSizes:
    """Beyond what numbers can be nothing is written, and no warning of a library is seen."""

    @pytest.mark.parametrize(
        ("value", "width", "reason"),
        [
            ("1e305", "1", "the values of the outputs are too large for a table of these ranges"),
            ("1", "1e300", "the range of 'x' is too small or too large for a table"),
            ("1", "1e-320", "the range of 'x' is too small or too large for a table"),
            ("1e60", "1e-245", "the values of the outputs are too large"),
        ],
    )
    def test_that_no_slope_has_are_refused(self, recwarn, value, width, reason):
        text = LARGE.format(value=value, width=width)
        with pytest.raises(CodegenError, match=reason):
            prepare(loads(text), text, table=5)
        assert not list(recwarn)

    @pytest.mark.parametrize(("value", "width"), [("1e298", "1"), ("1e50", "1e-240"), ("1e-200", "1e200")])
    def test_that_numbers_have_are_written(self, recwarn, compiled, value, width):
        text = LARGE.format(value=value, width=width)
        unit = prepare(loads(text), text, table=5)
        assert not list(recwarn)
        assert 0.01 * float(value) <= unit.table.errors[0] <= 0.2 * float(value)
        built = compiled(unit)
        assert built.code == 0, built.output

    def test_of_errors_beyond_all_that_is_attained_show_no_warning(self, recwarn, monkeypatch):
        """The table is the function, so that each difference in a box, 1e298, is without measure beside that of 0."""
        monkeypatch.setattr(table_error, "MOST_OPERATIONS", 400_000)
        text = LARGE.format(value="1e298", width="1").replace("and min", "and product")
        unit = prepare(loads(text), text, table=2, algorithm="rules")
        assert not list(recwarn)
        assert worst(unit, 500)[0] <= unit.table.errors[0]


@pytest.mark.parametrize("name", ["ais_reaction", "tipper", "boundary_layer"])
def test_values_of_a_table_stay_within_the_bounds_of_its_header(unit_of, name):
    unit = unit_of(name, table=20)
    for output, table in zip(unit.plan.outputs, unit.algorithm.grid.outputs, strict=True):
        assert unit.bounds[output.name].lo <= table.low <= min(table.value)
        assert max(table.value) <= table.high <= unit.bounds[output.name].hi


def test_code_of_a_table_agrees_with_the_system(compiled, unit_of, sanitized):
    unit = unit_of("boundary_layer", table=20)
    assert isinstance(unit.algorithm, Algorithm)
    built = compiled(unit, sanitized)
    assert built.code == 0, built.output


@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("name", ["tipper", "ais_reaction"])
class TestSelftest:
    """Expected are values of the table, which its code computes but for rounding, however far off the table is."""

    def test_passes(self, compiled, unit_of, sanitized, name, precision):
        built = compiled(unit_of(name, table=33, precision=precision), sanitized)
        assert built.code == 0, built.output

    def test_sees_every_output_moved_by_less_than_the_error_of_the_table(self, compiled, unit_of, name, precision):
        unit = unit_of(name, table=33, precision=precision)
        off = 4.0 * unit.tolerance(0)
        assert name != "tipper" or off < 0.01 * unit.table.errors[0]

        def change(file, text):
            moved = re.sub(r"(        result = )([^;]+);", rf"\g<1>(\g<2>) + ({unit.precision}){off!r};", text)
            assert file != f"{name}.c" or moved != text
            return moved if file == f"{name}.c" else text

        built = compiled(unit, change=change)
        assert built.code == 1, built.output


QUOTIENT = """system quotient
and product
defuzzifier weighted_average
input x in [0, 1]
  terms a b c d e f g h
input y in [0, 1]
  terms a b c d e f g h
input z in [0, 1]
  terms a b
output u in [-1, 1]
  p = constant(-1)
  q = constant(0.3)
  r = constant(1)
if x is a then u is p weight 0.7
if x is not a and y is a then u is q weight 0.2
if x is e and y is not f then u is r
if y is not a and z is a then u is p
if z is b then u is q weight 0.5
"""


class TestMemory:
    """Cells of many coefficients are not stored on small targets: the values at their corners say the same."""

    @pytest.fixture(params=["table", "quotient", "few"])
    def small(self, request, monkeypatch):
        """Prepare one of some systems whose values at the knots are stored."""
        if request.param != "table":
            monkeypatch.setattr("fuzzyctl.codegen.prepare.MOST_COEFFICIENTS", 0)

        def of_options(**options):
            if request.param == "quotient":
                return prepare(loads(QUOTIENT), QUOTIENT, small=True, **options)
            more = {"table": 33} if request.param == "table" else {}
            return prepared("ais_reaction", small=True, **more, **options)

        return of_options

    @pytest.mark.parametrize("precision", ["double", "float"])
    def test_code_passes_its_self_test(self, compiled, small, sanitized, precision):
        built = compiled(small(precision=precision), sanitized)
        assert built.code == 0, built.output

    def test_values_at_the_knots_are_all_that_is_stored(self, small):
        unit = small()
        grid, tables = unit.algorithm.grid, unit.program.tables
        sums = sum(1 + bool(t.weight) for t in grid.outputs)
        assert sum(len(values) for _, values in tables) <= sums * grid.size + 2 * sum(map(len, grid.knots))

    def test_code_agrees_with_the_polynomials_of_the_cells(self, small):
        unit = small()
        cells = Algorithm(unit.plan, unit.algorithm.grid, "")
        assert cells.printed.tables != unit.algorithm.printed.tables
        own, other = Reference(unit), Reference(replace(unit, systems=(replace(unit.systems[0], algorithm=cells),)))
        tried = points(unit, random.Random(5))
        found = np.array([[r.evaluate(p).outputs for p in tried] for r in (own, other)])
        assert np.array_equal(np.isnan(found[0]), np.isnan(found[1]))
        assert np.nanmax(np.abs(found[0] - found[1])) <= 1e-12

    def test_structured_text_agrees(self, small):
        assert differences(small()) <= 1.0

    def test_systems_of_few_cells_and_other_targets_keep_the_coefficients(self, unit_of):
        for options in ({"small": True}, {"table": 33}):
            unit = unit_of("ais_reaction", **options)
            cells = Algorithm(unit.plan, unit.algorithm.grid, "")
            assert unit.algorithm.printed == cells.printed
