"""Lookup tables of drawn rule tables, in double precision and in integers, stay within the errors proved of them."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from fuzzyctl import compile as compile_system
from fuzzyctl import loads
from fuzzyctl.codegen import table_error
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.fixed.fixed_format import Format
from fuzzyctl.codegen.fixed.fixed_system import fixed_point
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.codegen.vectors import Reference
from tests.properties.around import points_around
from tests.properties.running import quick
from tests.properties.test_active import systems as active_tables


@pytest.fixture(autouse=True)
def _soon(monkeypatch):
    """Let bounds be found soon; they are wider then, and hold as well."""
    monkeypatch.setattr(table_error, "MOST_OPERATIONS", 400_000)


@quick(14, 2)
@given(case=active_tables(otherwise=(" else -3",)), data=st.data())
def test_errors_hold_for_all_rules(case, data):
    text, knots = case
    system = loads(text.replace(" extrapolate", ""))
    assume(len(knots) < 3)
    try:
        unit = prepare(system, text, table=data.draw(st.sampled_from([9, 20, 33] if len(knots) == 2 else [9, 60, 300])))
    except CodegenError as error:
        assert "no useful bound" in str(error) or "too large" in str(error)  # noqa: PT017 - both answers are honest
        return
    rules, table = compile_system(system, "numpy", algorithm="rules"), Reference(unit)
    points = points_around([[*own, *unit.algorithm.grid.knots[k]] for k, own in enumerate(knots)], seed=1, count=300)
    points = points[np.isfinite(points).all(axis=1)]
    found = np.array([table.evaluate(p).outputs for p in points.tolist()])
    assert (np.abs(found - rules.batch(points).reshape(found.shape)).max(axis=0) <= unit.table.errors).all()
    reach = max(np.abs(found).max(), *(abs(k) for own in unit.algorithm.grid.knots for k in own))
    whole = max(1, math.ceil(math.log2(reach + 1.0)))
    fixed = fixed_point(unit, Format(whole, data.draw(st.sampled_from([15, 31])) - whole))
    one = 1 << fixed.format.fraction
    integers = np.clip(np.round(points * one), -fixed.format.most - 1, fixed.format.most).astype(np.int64)
    computed = np.array([fixed.evaluate(p) for p in integers.tolist()]) / one
    exact = rules.batch(integers / one).reshape(computed.shape)
    assert (np.abs(computed - exact).max(axis=0) <= fixed.errors).all()
