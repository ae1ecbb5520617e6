import bisect
import errno
import math
import os
import re
import stat
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numba
import numpy as np
import pytest

from fuzzyctl import loads
from fuzzyctl.kernels.algorithms.select import algorithm_of
from fuzzyctl.kernels.backends.numba import source as numba_backend
from fuzzyctl.kernels.backends.numba.source import Numbers
from fuzzyctl.kernels.compile import compile as compile_system
from fuzzyctl.kernels.plan.build import plan

TEXT = """
system s
defuzzifier weighted_average
input x in [0, 1]
  lo = triangle(-inf, 0, {peak})
  hi = triangle(0, {peak}, inf)
output u in [0, 1]
  a = singleton(0)
  b = singleton(1)
if x is lo then u is a
if x is hi then u is b
"""

CODE = f"""
from fuzzyctl import loads
from fuzzyctl.kernels.compile import compile
kernel = compile(loads('''{TEXT.format(peak=0.75)}'''), "numba")
assert abs(kernel(0.375) - 0.5) < 1e-15
print(sum(kernel.jit.stats.cache_hits.values()))
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("FUZZYCTL_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache" / "kernels"


@pytest.fixture
def forget(monkeypatch):
    """Let modules be loaded again, as a new process would."""

    def drop():
        for name in [n for n in sys.modules if n.startswith("fuzzyctl_kernel_")]:
            monkeypatch.delitem(sys.modules, name)

    drop()
    return drop


def hits(kernel):
    """Return how often the machine code of a kernel came from the cache."""
    return sum(kernel.jit.stats.cache_hits.values())


def run():
    return subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=False, env=os.environ)


class TestCache:
    def test_is_where_the_variable_says_and_private(self, folder, forget):
        assert compile_system(loads(TEXT.format(peak=0.5)), "numba").jit
        assert [p.suffix for p in folder.iterdir() if p.is_file()] == [".py"]
        assert list((folder / "__pycache__").glob("*.nbi"))
        if os.name == "posix":
            assert stat.S_IMODE(folder.stat().st_mode) == 0o700

    def test_a_second_process_compiles_nothing(self, folder):
        first, second = run(), run()
        assert (first.stdout.strip(), second.stdout.strip()) == ("0", "1"), first.stderr + second.stderr

    @pytest.mark.long
    def test_processes_may_compile_the_same_at_the_same_time(self, folder):
        with ThreadPoolExecutor(2) as pool:
            done = list(pool.map(lambda _: run(), range(2)))
        assert [d.returncode for d in done] == [0, 0], done
        assert not list(folder.glob("*.tmp"))
        assert run().stdout.strip() == "1"

    def test_damaged_entries_are_thrown_away(self, folder, forget):
        system = loads(TEXT.format(peak=0.5))
        assert compile_system(system, "numba").jit
        for entry in (folder / "__pycache__").glob("*.nb*"):
            entry.write_bytes(b"garbage")
        forget()
        kernel = compile_system(system, "numba")
        assert kernel(0.25) == 0.5
        forget()
        assert hits(compile_system(system, "numba")) == 1

    def test_threads_may_compile_the_same_at_the_same_time(self, folder, forget):
        system = loads(TEXT.format(peak=0.6))
        with ThreadPoolExecutor(8) as pool:
            found = list(pool.map(lambda _: compile_system(system, "numba")(0.3), range(8)))
        assert found == [0.5] * 8

    def test_a_changed_module_is_written_anew(self, folder, forget):
        system = loads(TEXT.format(peak=0.5))
        assert compile_system(system, "numba").jit
        (module,) = folder.glob("*.py")
        module.write_text("raise SystemExit('not what was generated')")
        forget()
        assert compile_system(system, "numba")(0.25) == 0.5

    def test_without_a_home_costs_only_time(self, monkeypatch, forget):
        def none():
            raise RuntimeError("Could not determine home directory.")

        for name in ("FUZZYCTL_CACHE_DIR", "XDG_CACHE_HOME"):
            monkeypatch.delenv(name, raising=False)
        monkeypatch.setattr(Path, "home", none)
        assert compile_system(loads(TEXT.format(peak=0.25)), "numba")(0.125) == 0.5

    def test_a_folder_that_is_full_costs_only_time(self, folder, monkeypatch, forget):
        def full(*_, **__):
            raise OSError(errno.ENOSPC, "no space left on device")

        monkeypatch.setattr(numba_backend.tempfile, "mkstemp", full)
        assert compile_system(loads(TEXT.format(peak=0.25)), "numba")(0.125) == 0.5
        assert not list(folder.iterdir())

    def test_a_folder_that_cannot_be_made_costs_only_time(self, tmp_path, monkeypatch, forget):
        (tmp_path / "file").write_text("")
        monkeypatch.setenv("FUZZYCTL_CACHE_DIR", str(tmp_path / "file"))
        assert compile_system(loads(TEXT.format(peak=0.25)), "numba")(0.125) == 0.5


class TestJit:
    def test_can_be_called_in_other_compiled_code(self, ais):
        function = compile_system(ais, "numba").jit

        @numba.njit
        def total(points):
            sum_ = 0.0
            for i in range(points.shape[0]):
                sum_ += function(points[i, 0], points[i, 1])
            return sum_

        points = np.random.default_rng(3).uniform(-0.5, 0.5, (100, 2))
        assert total(points) == pytest.approx(compile_system(ais, "python").batch(points).sum())

    def test_is_compiled_for_floats_and_nothing_else(self, ais):
        function = compile_system(ais, "numba").jit
        assert [str(s) for s in function.signatures] == ["(float64, float64)"]
        assert not function._can_compile

    def test_gives_a_tuple_for_several_outputs(self, gappy):
        assert compile_system(gappy(), "numba").jit(1.0, -0.5) == (10.0, 2.0)

    def test_passes_as_a_function_pointer_so_that_callers_need_not_be_recompiled(self, ais):
        kind = numba.types.FunctionType(numba.types.float64(numba.types.float64, numba.types.float64))

        @numba.njit(numba.types.float64(kind, numba.types.float64))
        def apply(function, x):
            return function(x, x)

        assert apply(compile_system(ais, "numba").jit, 0.01) == compile_system(ais, "python")(0.01, 0.01)


def test_minima_and_maxima_are_no_branches_since_compiling_many_takes_long():
    seven = " ".join(f"t{k}" for k in range(7))
    rows = "\n".join(f"  t{i} | " + " ".join(f"t{min(max(i + j - 3, 0), 6)}" for j in range(7)) for i in range(7))
    variables = "".join(f"{v} in [-1, 1]\n  terms {seven}\n" for v in ("input a", "input b", "output u"))
    kernel = compile_system(
        loads(f"system s\ndefuzzifier centroid\n{variables}table u = a x b\n  {seven}\n{rows}\n"),
        "numba",
        algorithm="rules",
    )
    assert kernel.source.count("smaller(") >= 49
    assert not any(" = (v" in line and " if v" in line for line in kernel.source.splitlines())


FLAT = """
system flat
and product
defuzzifier weighted_average
input x in [0, 1]
  terms low high
input y in [0, 1]
  terms low high
output p in [0, 1]
  terms A=0 B=1
output q in [0, 1]
  terms A=0 B=1
table p = x x y
        low high
  low  | A B
  high | B A
table q = x x y
        low high
  low  | A A
  high | B B
"""


def test_nan_of_an_input_that_changes_nothing_is_kept():
    """The output q is the same for all y."""
    kernel = compile_system(loads(FLAT), "numba")
    found = kernel.batch([[0.25, math.nan], [math.nan, 0.5], [0.25, 0.5]])
    assert np.isnan(found[:2]).all()
    assert found[2].tolist() == [0.5, 0.25]


def test_names_cannot_be_taken_for_others():
    """numba takes v1 at the instruction 5722 for v15 at 722."""
    source = numba_backend.evaluation_source(compile_system(loads(FLAT), "python").algorithm.point)
    code = source.partition("def kernel")[2]
    assert not re.search(r"\b[A-Za-z]\d+\b", code)
    assert "v1_" in code


def test_where_nothing_is_to_be_compiled_numpy_takes_over():
    """Tools that count lines or step through code set this variable."""
    code = """
import warnings
from fuzzyctl import compile, loads
from fuzzyctl.diagnostics.diagnostic import BackendUnavailableError
system = loads(TEXT)
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    print(compile(system).backend, compile(system)(0.375))
print(said[0].message)
try:
    compile(system, "numba")
except BackendUnavailableError as error:
    print(error)
"""
    text = code.replace("TEXT", repr(TEXT.format(peak=0.75)))
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True, env=environment)
    first, *rest = done.stdout.splitlines()
    assert first == "numpy 0.5"
    assert all("NUMBA_DISABLE_JIT is set" in line for line in rest)
    assert len(rest) == 2


def test_search_finds_the_last_number_that_is_not_above():
    names = {"njit": lambda **_: lambda function: function}
    exec(numba_backend._SEARCH, names)
    for count in range(1, 70):
        table = [-1.0, *(math.sqrt(k) for k in range(count)), 1e9]
        own = table[1:-1]
        for x in (y for k in own for y in (k, math.nextafter(k, 99.0), math.nextafter(k, -99.0), math.inf, -math.inf)):
            assert names["search"](table, 1, count, x) == max(bisect.bisect_right(own, x) - 1, 0)
        assert names["search"](table, 1, count, math.nan) == 0


@pytest.mark.parametrize(
    ("terms", "searched", "searched_in_loops"),
    [(8, False, False), (9, True, False), (48, True, False), (49, True, True)],
)
def test_few_knots_are_compared_and_more_searched(terms, searched, searched_in_loops):
    names = " ".join(f"t{k}" for k in range(terms))
    rules = "\n".join(f"if x is t{k} then u is c{k % 2}" for k in range(terms))
    system = loads(
        f"system s\nand product\ndefuzzifier weighted_average\ninput x in [0, 1]\n  terms {names}\n"
        f"output u in [0, 1]\n  terms c0 c1\n{rules}\n"
    )
    program = algorithm_of(plan(system)).point
    point, loop = numba_backend.evaluation_source(program), numba_backend.batch_source(program)
    assert ("search(" in point) == ("search(" in numba_backend.evaluation_source(program, Numbers(program))) == searched
    assert ("search(" in loop) == searched_in_loops
