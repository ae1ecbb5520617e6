"""Kernels compiled by numba: what is kept on disk, functions for other compiled code, and values that share code."""

import bisect
import ctypes
import errno
import gc
import linecache
import math
import os
import pickle
import shutil
import stat
import subprocess
import sys
import weakref
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numba
import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import compile as compile_system
from fuzzyctl import loads
from fuzzyctl.kernels.algorithms.select import algorithm_of
from fuzzyctl.kernels.backends.numba import disk_cache
from fuzzyctl.kernels.backends.numba import source as numba_backend
from fuzzyctl.kernels.backends.numba.source import Numbers
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
from fuzzyctl import compile, loads
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

    def test_a_second_process_compiles_nothing(self, folder, forget):
        assert compile_system(loads(TEXT.format(peak=0.75)), "numba").jit
        second = run()
        assert second.stdout.strip() == "1", second.stderr

    @pytest.mark.long
    def test_processes_may_compile_the_same_at_the_same_time(self, folder):
        with ThreadPoolExecutor(2) as pool:
            done = list(pool.map(lambda _: run(), range(2)))
        assert [d.returncode for d in done] == [0, 0], done
        assert not list(folder.glob("*.tmp"))
        assert run().stdout.strip() == "1"

    @pytest.mark.parametrize("suffix", ["nbi", "nbc"])
    @pytest.mark.parametrize("damage", [lambda b: b"", lambda b: b"garbage", lambda b: bytes(200), lambda b: b[:40]])
    def test_damaged_entries_are_thrown_away(self, folder, forget, suffix, damage):
        system = loads(TEXT.format(peak=0.5))
        assert compile_system(system, "numba").jit
        (entry,) = (folder / "__pycache__").glob(f"*.{suffix}")
        entry.write_bytes(damage(entry.read_bytes()))
        forget()
        kernel = compile_system(system, "numba")
        assert (hits(kernel), kernel(0.25)) == (0, 0.5)
        forget()
        assert hits(compile_system(system, "numba")) == 1

    @pytest.mark.parametrize(
        ("place", "name", "error"),
        [
            ("IndexDataCacheFile", "_load_data", PermissionError(errno.EACCES, "permission denied")),
            ("CompileResultCacheImpl", "rebuild", ModuleNotFoundError("No module named '<dynamic>'")),
            ("CompileResultCacheImpl", "rebuild", RuntimeError("LLVM")),
        ],
    )
    def test_entries_that_cannot_be_used_are_compiled(self, folder, forget, monkeypatch, place, name, error):
        system = loads(TEXT.format(peak=0.5))
        assert compile_system(system, "numba").jit
        forget()

        def fails(*_):
            raise error

        with monkeypatch.context() as patch:
            patch.setattr(getattr(numba.core.caching, place), name, fails)
            kernel = compile_system(system, "numba")
            assert (hits(kernel), kernel(0.25)) == (0, 0.5)
        forget()
        assert hits(compile_system(system, "numba")) == 1

    def test_code_of_another_signature_is_not_run(self, tmp_path, monkeypatch):
        """Two processes that begin with the same index write two signatures to one file."""
        monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "cache"))
        path, text = tmp_path / "module.py", "def twice(x):\n    return x + x\n"
        path.write_text(text)

        def twice():
            linecache.checkcache()
            names = {"__name__": "module", "__file__": str(path)}
            exec(compile(text, str(path), "exec"), names)
            return disk_cache.with_disk_cache(numba.njit(names["twice"]))

        first = twice()
        assert (first(2.5), first(3)) == (5.0, 6)
        of_floats, of_integers = sorted((tmp_path / "cache").rglob("*.nbc"))
        shutil.copy(of_integers, of_floats)
        second = twice()
        assert (second(2.5), second(3)) == (5.0, 6)
        assert sum(second.stats.cache_hits.values()) == 1

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


def test_where_nothing_is_to_be_compiled_numpy_takes_over():
    """Tools that count lines or step through code set this variable."""
    code = """
import warnings
from fuzzyctl import BackendUnavailableError, compile, loads
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


# --- values ----------------------------------------------------------------------------------------------------------

INTERPOLATED = """
system s
param peak = {peak}
defuzzifier weighted_average
input x in [0, 1]
  lo = triangle(-inf, 0, peak)
  mid = triangle(0, peak, 1)
  hi = triangle(peak, 1, inf)
output u in [-9, 9]
  a = singleton({value})
  b = singleton(3)
  c = singleton(-1)
if x is lo then u is a
if x is mid then u is b
if x is hi then u is c
"""

MAMDANI = """
system s
defuzzifier centroid{samples}
input x in [0, 10]
  lo = gaussian(0, {width})
  hi = gaussian(10, {width})
input y in [0, 10]
  terms lo hi
output u in [0, 30]
  small = triangle(0, 5, {corner})
  large = triangle(10, 25, 30)
output v in [0, 1] defuzzifier weighted_average
  no = singleton(0.125)
  yes = singleton({width} / 10)
if x is lo and y is lo then u is small, v is no
if x is hi or y is hi then u is large, v is yes
"""

ADAPTIVE = """
system s
defuzzifier weighted_average
input x in [-1, 1]
  n = triangle(-inf, -{half}, 0)
  z = triangle(-{half}, 0, {half})
  p = triangle(0, {half}, inf)
output F in [-2, 2] adaptive rate {gamma} * x
  a = singleton(-1)
  b = singleton(0)
  c = singleton(1)
if x is n then F is a
if x is z then F is b
if x is p then F is c
"""


@pytest.fixture
def compiled(monkeypatch, tmp_path):
    """Return the names of kernels that are compiled; the cache is empty at first."""
    monkeypatch.setenv("FUZZYCTL_CACHE_DIR", str(tmp_path))
    for name in [n for n in sys.modules if n.startswith("fuzzyctl_kernel_")]:
        monkeypatch.delitem(sys.modules, name)
    return lambda: {n for n in sys.modules if n.startswith("fuzzyctl_kernel_")}


PAIRS = [
    (INTERPOLATED.format(peak=0.25, value=7), INTERPOLATED.format(peak=0.375, value=-6.5), 1),
    (MAMDANI.format(width=3, corner=12, samples=""), MAMDANI.format(width=4.5, corner=11, samples=""), 2),
    # How many samples a set covers is the length of a loop, so the corners stay.
    pytest.param(
        MAMDANI.format(width=3, corner=12, samples="(resolution=51)"),
        MAMDANI.format(width=4.5, corner=12, samples="(resolution=51)"),
        2,
        marks=pytest.mark.long,
    ),
]


@numba.njit
def at(f, point):
    return f(point[0]) if len(point) == 1 else f(point[0], point[1])


@pytest.mark.parametrize(("first", "second", "inputs"), PAIRS, ids=["interpolated", "exact", "sampled"])
def test_values_of_further_systems_compile_nothing(compiled, first, second, inputs):
    third = second.replace("4.5", "3.5").replace("0.375", "0.4375")
    points = np.random.default_rng(1).uniform(-2, 12, (40, inputs))
    points[0] = math.nan
    known = set()
    for text in (first, second, third):
        value, plain = compile_system(loads(text), "numba").value, compile_system(loads(text), "python")
        assert len(compiled()) == 1
        assert known <= compiled()
        known = compiled()
        for point in map(tuple, points.tolist()):
            assert at(value, point) == pytest.approx(plain(*point), rel=1e-13, nan_ok=True)


@pytest.mark.parametrize(("half", "gamma"), [(0.3, 2.5), (0.45, 4.0)])
def test_values_of_adaptive_systems_and_their_rates(half, gamma):
    kernel = compile_system(loads(ADAPTIVE.format(half=half, gamma=gamma)), "numba")
    value, rates = kernel.value, kernel.rates_value

    @numba.njit
    def both(f, g, x, state, change):
        g(x, state, change)
        return f(x, state)

    state, change, expected = np.array([-0.5, 0.25, 1.5]), np.empty(3), np.empty(3)
    kernel.jit_rates(0.2, state, expected)
    assert both(value, rates, 0.2, state, change) == kernel(0.2, state) == value(0.2, state)
    assert change.tolist() == expected.tolist() != [0, 0, 0]
    rates(0.2, state, change)
    assert change.tolist() == expected.tolist()


def test_a_value_is_of_its_signature_only():
    """Code that takes kernels as values is compiled once for all of them."""

    @numba.njit
    def slope(f, x):
        return (f(x + 1e-3) - f(x - 1e-3)) / 2e-3

    for peak in (0.25, 0.5, 0.75):
        kernel = compile_system(loads(INTERPOLATED.format(peak=peak, value=7)), "numba")
        assert slope(kernel.value, 0.01) == pytest.approx((kernel(0.011) - kernel(0.009)) / 2e-3, rel=1e-12)
    assert len(slope.signatures) == 1


def test_the_code_of_a_value_stays_when_the_value_is_gone():
    """Compiled code keeps the address only, in a list of functions for example."""
    value = compile_system(loads(INTERPOLATED.format(peak=0.5, value=3)), "numba").value
    address, gone = value.__wrapper_address__(), weakref.ref(value)
    del value
    gc.collect()
    assert gone() is None
    assert ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(address)(0.0) == 3.0


def test_values_are_made_anew_in_other_processes():
    kernel = compile_system(loads(ADAPTIVE.format(half=0.3, gamma=2.5)), "numba")
    state, own, other = np.array([-0.5, 0.25, 1.5]), np.empty(3), np.empty(3)
    assert pickle.loads(pickle.dumps(kernel.value))(0.2, state) == kernel.value(0.2, state)
    kernel.rates_value(0.2, state, own)
    pickle.loads(pickle.dumps(kernel.rates_value))(0.2, state, other)
    assert own.tolist() == other.tolist()


def test_sets_that_are_integrated_keep_their_numbers():
    text = MAMDANI.format(width=3, corner=12, samples="").replace("triangle(0, 5, 12)", "gaussian(5, 2)")
    flat = plan(loads(text))
    kernel = compile_system(loads(text), "numba")
    assert not Numbers(kernel.algorithm.point).shares
    assert flat.outputs
    assert kernel(2.0, 3.0) == pytest.approx(compile_system(loads(text), "python")(2.0, 3.0), rel=1e-11)


CURVED = """system {name}
defuzzifier centroid
input e in [-1, 1]
  N = triangle(-inf, -1, 1)
  P = triangle(-1, 1, inf)
output u in [-1, 1]
  N = gaussian(-1, {width})
  P = gaussian(1, 0.4)
if e is N then u is N
if e is P then u is P
"""


@pytest.mark.parametrize(("output", "count"), [("g(x) + g(0.5 * x)", 1), ("g(x) + h(x)", 2)])
def test_curved_sets_that_are_called_again_are_compiled_once(output, count):
    own = "".join(CURVED.format(name=name, width=width) for name, width in (("g", 0.4), ("h", 0.5)))
    step = fuzzyctl.compile(loads(f"{own}controller c\ninput x\noutput u = {output}\nevery 1 s\n", block="c"), "numba")
    assert numba_backend.storing_source(step.form.point("numba")).count("def stretch_") == count
