"""Lookup tables of drawn rule tables, in double precision and in integers, stay within the errors proved of them."""

import math
import re
import shutil

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from fuzzyctl import compile as compile_system
from fuzzyctl import loads
from tests.fuzzyctl.codegen.conftest import written
from tests.fuzzyctl.codegen.steps.targets import by_doubles, by_integers
from tests.properties.around import points_around
from tests.properties.running import quick
from tests.properties.test_active import systems as active_tables


@pytest.fixture(autouse=True)
def _soon(monkeypatch):
    """Let bounds be found soon; they are wider then, and hold as well."""
    monkeypatch.setattr("fuzzyctl.codegen.table_error.MOST_OPERATIONS", 400_000)


def points_along(source):
    """Return the points of a table along each input, from its C."""
    tables = re.findall(r"// points of the table along .*?\{(.*?)\}", source, re.DOTALL)
    return [[float(x.strip(" \n()")) for x in table.split(",")] for table in tables]


@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
@quick(14, 2)
@given(case=active_tables(otherwise=(" else -3",)), data=st.data())
def test_errors_hold_for_all_rules(tmp_path_factory, case, data):
    text, knots = case
    text = text.replace(" extrapolate", "")
    assume(len(knots) < 3)
    size = data.draw(st.sampled_from([9, 20, 33] if len(knots) == 2 else [9, 60, 300]))
    table = written(text, "c", "--table", str(size))
    if table.code:
        assert "no useful bound" in table.errors or "too large" in table.errors  # both answers are honest
        return
    rules, along = compile_system(loads(text), "numpy", algorithm="rules"), points_along(table.files["s.c"])
    points = points_around([[*own, *along[k]] for k, own in enumerate(knots)], seed=1, count=300)
    points = points[np.isfinite(points).all(axis=1)]
    (found,) = by_doubles([table.files], [points], tmp_path_factory.mktemp("table"))
    errors = [table.data["errors"][name] for name in rules.output_names]
    assert (np.abs(found - rules.batch(points).reshape(found.shape)).max(axis=0) <= errors).all()
    reach = max(np.abs(found).max(), *(abs(k) for own in along for k in own))
    whole = max(1, math.ceil(math.log2(reach + 1.0)))
    bits = data.draw(st.sampled_from([15, 31]))
    fixed = written(text, "c", "--table", str(size), "--fixed", f"Q{whole}.{bits - whole}")
    assert fixed.code == 0, fixed.errors
    one, most = 1 << (bits - whole), (1 << bits) - 1
    integers = np.clip(np.round(points * one), -most - 1, most).astype(np.int64)
    (computed,) = by_integers([fixed.files], [integers], tmp_path_factory.mktemp("fixed"))
    exact = rules.batch(integers / one).reshape(computed.shape)
    errors = [fixed.data["errors"][name] for name in rules.output_names]
    assert (np.abs(computed / one - exact).max(axis=0) <= errors).all()
