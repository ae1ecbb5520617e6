"""Batches: layouts of points, places for results, threads, and the memory that they take."""

import math
import os
import signal
import subprocess
import sys
import threading
import time
import tracemalloc
import warnings

import numpy as np
import pytest

from fuzzyctl import ArgumentError, NoRuleFiresError, loads
from fuzzyctl import compile as compile_system
from fuzzyctl.kernels.backends import blocks

BACKENDS = ("numpy", "numba")
#: Seconds that nothing takes but what never comes.
LONG = 300
#: Points of the first block, whose time is measured, in tests of threads.
TRIED = 10

GAP = """
system gap
and product
defuzzifier weighted_average
input x in [0, 10]
  low = triangle(-inf, 2, 4)
  high = triangle(6, 8, inf)
input y in [-1, 1]
  terms low high
output u in [0, 1] {otherwise}
  a = constant(0)
  b = constant(1)
if x is low and y is low then u is a
if x is low and y is high then u is b
if x is high then u is b
"""


POLE = """
system pole
defuzzifier weighted_average
input x in [-1, 1]
  any = triangle(-inf, 0, inf)
output y in [0, 1]
  pole = function(x ^ -1)
if x is any then y is pole
"""


@pytest.mark.parametrize("backend", BACKENDS)
def test_infinities_of_both_signs_are_results_like_others(backend):
    pole = compile_system(loads(POLE), backend)
    points = np.array([[0.0], [-0.0], [0.5]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert pole.batch(points).tolist() == [math.inf, -math.inf, 2.0]


@pytest.fixture(params=BACKENDS)
def kernel(request, tipper):
    return compile_system(tipper, request.param)


@pytest.fixture
def many(monkeypatch):
    """Two threads, whatever the machine and however little there is to do, in small shares."""
    monkeypatch.setattr(blocks, "TRIED", TRIED)
    monkeypatch.setattr(blocks, "TELLING", 0.0)
    monkeypatch.setattr(blocks, "ENOUGH", 1e-12)
    monkeypatch.setattr(blocks, "PROMPT", LONG)
    monkeypatch.setattr(blocks, "cores", lambda: 2)


@pytest.fixture
def arrays(tipper):
    """A kernel whose batches are shared among threads."""
    pytest.importorskip("numba")
    return compile_system(tipper, "numba")


@pytest.fixture
def clock(monkeypatch):
    """What a point takes by a clock that is moved by hand, with three cores."""

    class Clock:
        now = 1000.0

        def __call__(self):
            return self.now

    clock = Clock()
    monkeypatch.setattr(blocks, "perf_counter", clock)
    monkeypatch.setattr(blocks, "cores", lambda: 3)
    return clock


def shares_of(count, clock, seconds, *, parallel=True):
    """Return the number of other threads and the sizes of what is filled at a time, if a point takes some seconds."""
    caller, helpers, sizes, begun = threading.get_ident(), [0], [], blocks._begun

    def fill(points, _states, _results):
        sizes.append(len(points))
        if threading.get_ident() == caller:
            clock.now += seconds * len(points)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(blocks, "_begun", lambda work, count: helpers.append(count) or begun(work, count))
        blocks.run_compiled(fill, np.zeros((count, 2)), None, np.zeros((count, 1)), parallel=parallel)
    assert sum(sizes) == count
    return helpers[-1], sizes


class TestWork:
    def test_that_is_short_is_done_by_one_thread(self, clock):
        assert shares_of(300_000, clock, 1.5e-9)[0] == 0

    def test_that_is_long_is_shared_though_there_are_few_points(self, clock):
        assert shares_of(5000, clock, 1e-6)[0] == 2

    def test_of_two_milliseconds_is_shared_in_parts_that_are_worth_a_thread(self, clock):
        helpers, sizes = shares_of(20_000, clock, 1e-7)
        assert helpers == 2
        assert min(sizes[1:-1]) * 1e-7 >= 0.99 * blocks.ENOUGH

    def test_is_not_shared_where_one_thread_is_wanted(self, clock):
        assert shares_of(10**6, clock, 1e-6, parallel=False)[0] == 0

    @pytest.mark.parametrize("seconds", [1e-8, 1e-6, 1e-3])
    def test_can_be_interrupted_soon(self, clock, seconds):
        _, sizes = shares_of(10**6, clock, seconds, parallel=False)
        assert len(sizes) > 2
        assert max(sizes) <= max(blocks.PROMPT / seconds, blocks.TRIED)

    @pytest.mark.parametrize("count", [0, 1, 512, 513])
    def test_is_done_once_whatever_its_size(self, clock, count):
        points, results = np.arange(2.0 * count).reshape(count, 2), np.zeros((count, 1))

        def fill(points, _states, results):
            results += points[:, 1:]

        blocks.run_compiled(fill, points, None, results)
        np.testing.assert_array_equal(results[:, 0], points[:, 1])


def test_states_of_later_blocks_are_their_own(adaptive):
    points = np.linspace(-0.4, 0.4, 20_001)[:, None]
    state = np.random.default_rng(3).uniform(-2, 2, (20_001, 7))
    found, python = compile_system(adaptive, "numpy").batch(points, state), compile_system(adaptive, "python")
    for i in (0, 8191, 8192, 16384, 20_000):
        assert found[i] == pytest.approx(python(points[i, 0], state[i]), rel=1e-14, abs=1e-15)


def points_for(count, seed=0):
    return np.random.default_rng(seed).uniform(-1, 11, (count, 2))


class TestLayouts:
    @pytest.mark.parametrize("count", [0, 3, 2 * blocks.BLOCK + 1])
    def test_of_every_kind_give_the_same(self, kernel, count):
        points = points_for(count)
        expected = kernel.batch(points)
        frozen = points.copy()
        frozen.flags.writeable = False
        strided = np.repeat(points, 2, axis=0)[::2]
        for given in (np.asfortranarray(points), frozen, strided, points[::-1][::-1], points.tolist()):
            if count or isinstance(given, np.ndarray):
                np.testing.assert_array_equal(kernel.batch(given), expected)
        single = points.astype(np.float32)
        np.testing.assert_array_equal(kernel.batch(single), kernel.batch(single.astype(float)))

    @pytest.mark.parametrize("kind", ["matrix", "memmap", "odd address"])
    def test_of_other_classes_and_at_odd_addresses_are_points_like_others(self, kernel, kind, tmp_path):
        values = np.array([[3.0, 8.0], [9.5, 1.0]])
        points = {
            "matrix": lambda: values.view(np.matrix),
            "memmap": lambda: np.memmap(tmp_path / "points", dtype=float, mode="w+", shape=values.shape),
            "odd address": lambda: np.zeros(values.nbytes + 1, np.uint8)[1:].view(float).reshape(values.shape),
        }[kind]()
        points[...] = values
        out = np.memmap(tmp_path / "results", dtype=float, mode="w+", shape=(2,))
        assert kernel.batch(points, out=out) is out
        assert out.tolist() == pytest.approx([kernel(3.0, 8.0), kernel(9.5, 1.0)], rel=1e-12)

    def test_give_what_single_points_give_over_several_blocks(self, kernel, tipper):
        points, python = points_for(20_000), compile_system(tipper, "python")
        found = kernel.batch(points)
        for i in (*range(50), 8191, 8192, 16384, 19_999):
            assert found[i] == pytest.approx(python(*points[i]), rel=1e-12)

    def test_whole_numbers_and_truths_count_as_numbers(self, kernel):
        np.testing.assert_array_equal(kernel.batch(np.array([[1, 2], [3, 4]])), kernel.batch([[1.0, 2.0], [3.0, 4.0]]))
        np.testing.assert_array_equal(kernel.batch(np.array([[True, False]])), kernel.batch([[1.0, 0.0]]))

    def test_shapes_are_kept(self, kernel):
        points = points_for(24).reshape(2, 3, 4, 2)
        np.testing.assert_array_equal(kernel.batch(points), kernel.batch(points.reshape(24, 2)).reshape(2, 3, 4))
        assert kernel.batch(np.empty((3, 0, 2))).shape == (3, 0)


class TestOut:
    def test_is_written_to_and_returned(self, kernel):
        out = np.full(5, 99.0)
        assert kernel.batch(points_for(5), out=out) is out
        np.testing.assert_array_equal(out, kernel.batch(points_for(5)))

    @pytest.mark.parametrize(
        ("out", "words"),
        [
            (np.empty(4), r"shape \(5,\), got \(4,\)"),
            (np.empty(5, dtype=np.float32), "float64, got float32"),
            (np.empty(10)[::2], "contiguous, aligned and writable"),
            (np.zeros(41, np.uint8)[1:].view(float), "contiguous, aligned and writable"),
            ([0.0] * 5, "float64, got list"),
            (np.ma.zeros(5), "MaskedArray"),
            (np.broadcast_to(0.0, 5), "contiguous, aligned and writable"),
        ],
    )
    def test_of_another_kind_is_refused(self, kernel, out, words):
        with pytest.raises(ArgumentError, match=words):
            kernel.batch(points_for(5), out=out)


@pytest.mark.usefixtures("many")
class TestThreads:
    def test_give_what_one_gives(self, kernel):
        points = points_for(12_345)
        np.testing.assert_array_equal(kernel.batch(points), kernel.batch(points, parallel=False))

    @pytest.mark.parametrize("backend", BACKENDS)
    @pytest.mark.parametrize("otherwise", ["else error", ""])
    def test_of_several_errors_the_first_point_is_named(self, backend, otherwise):
        kernel = compile_system(loads(GAP.format(otherwise=otherwise)), backend)
        points = np.tile([[1.0, 0.0]], (4000, 1))
        points[[3500, 1200, 3999]] = [[5.0, 0.5], [4.5, 0.25], [5.5, 0.0]]
        with pytest.raises(NoRuleFiresError, match=r"x = 4.5, y = 0.25"):
            kernel.batch(points)

    def test_share_the_points(self, arrays, monkeypatch):
        kernel = arrays
        own, seen, both = kernel._fill, [], threading.Event()

        def fill(points, states, results):
            seen.append((threading.get_ident(), len(points)))
            if len({thread for thread, _ in seen}) == 2:
                both.set()
            if len(points) > TRIED:
                both.wait(LONG)  # until the other thread has begun, too
            own(points, states, results)

        monkeypatch.setitem(kernel.__dict__, "_fill", fill)
        kernel.batch(points_for(12_345))
        assert len({thread for thread, _ in seen}) == 2
        assert sum(count for _, count in seen) == 12_345

    def test_help_several_callers_at_once(self, kernel):
        points = [points_for(6000, seed) for seed in range(4)]
        expected = [kernel.batch(p, parallel=False) for p in points]
        found = {}

        def call(k):
            for _ in range(3):
                found[k] = kernel.batch(points[k])

        callers = [threading.Thread(target=call, args=(k,)) for k in range(4)]
        for caller in callers:
            caller.start()
        for caller in callers:
            caller.join(timeout=LONG)
        for k in range(4):
            np.testing.assert_array_equal(found[k], expected[k])

    def test_that_cannot_be_begun_are_done_without(self, arrays, monkeypatch):
        def start(_):
            raise RuntimeError("can't create new thread at interpreter shutdown")

        blocks._pool.cache_clear()
        monkeypatch.setattr(threading.Thread, "start", start)
        points = points_for(5000)
        np.testing.assert_array_equal(arrays.batch(points), arrays.batch(points, parallel=False))

    def test_write_nothing_after_interrupts_and_help_the_next_call(self, arrays, monkeypatch):
        own, caller, points, out, naps = arrays._fill, threading.get_ident(), points_for(20_000), np.zeros(20_000), []
        helps, napped = threading.Event(), threading.Event()

        def fill(points, states, results):
            if len(points) == TRIED:
                return
            if threading.get_ident() == caller:
                helps.wait(LONG)
                raise KeyboardInterrupt
            helps.set()
            napped.wait(LONG)  # until the caller waits for it
            own(points, states, results)

        def nap(seconds):
            naps.append(seconds)
            if len(naps) < 4:
                raise KeyboardInterrupt
            napped.set()
            time.sleep(seconds)

        monkeypatch.setitem(arrays.__dict__, "_fill", fill)
        monkeypatch.setattr(blocks, "sleep", nap)
        with pytest.raises(KeyboardInterrupt):
            arrays.batch(points, out=out)
        left = out.copy()
        assert len(naps) >= 4
        assert left.any()
        assert not left[-500:].any()
        time.sleep(0.03)
        np.testing.assert_array_equal(out, left)
        monkeypatch.setitem(arrays.__dict__, "_fill", own)
        np.testing.assert_array_equal(arrays.batch(points), arrays.batch(points, parallel=False))

    def test_leave_signals_to_the_caller(self, arrays, monkeypatch):
        own, both, masks = arrays._fill, threading.Event(), {}

        def fill(points, states, results):
            masks[threading.get_ident()] = signal.pthread_sigmask(signal.SIG_BLOCK, ())
            if len(masks) == 2:
                both.set()
            if len(points) > TRIED:
                both.wait(LONG)
            own(points, states, results)

        monkeypatch.setitem(arrays.__dict__, "_fill", fill)
        arrays.batch(points_for(20_000))
        assert signal.SIGTERM not in masks.pop(threading.get_ident())
        assert all(signal.SIGTERM in mask for mask in masks.values())

    @pytest.mark.parametrize("before", [True, pytest.param(False, marks=pytest.mark.long)])
    def test_may_be_gone_at_the_end_of_the_interpreter(self, before):
        code = AT_EXIT.format(before=before)
        run = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, timeout=LONG, check=False, env=os.environ
        )
        assert (run.stdout, run.stderr, run.returncode) == ("True\n", "", 0)

    @pytest.mark.skipif(not hasattr(os, "fork"), reason="needs processes that are copies of another")
    def test_of_a_copied_process_are_its_own(self, kernel):
        points = points_for(5000)
        expected = kernel.batch(points)
        with warnings.catch_warnings():  # that threads are not copied is what is tested
            warnings.simplefilter("ignore", DeprecationWarning)
            child = os.fork()
        if child == 0:
            os._exit(0 if np.array_equal(kernel.batch(points), expected) else 1)
        until = time.monotonic() + LONG
        while (done := os.waitpid(child, os.WNOHANG)) == (0, 0) and time.monotonic() < until:
            time.sleep(0.01)
        if done == (0, 0):
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
        assert done == (child, 0)

    def test_nan_stays_where_it_is(self, kernel):
        points = points_for(5000)
        points[[0, 2499, 2500, 4999], [0, 1, 0, 1]] = math.nan
        assert np.flatnonzero(np.isnan(kernel.batch(points))).tolist() == [0, 2499, 2500, 4999]


AT_EXIT = """
import atexit, numpy as np, fuzzyctl
from fuzzyctl.kernels.backends import blocks
blocks.ENOUGH, blocks.cores = 1e-12, lambda: 3
system = fuzzyctl.loads('''system s
defuzzifier weighted_average
input x in [0, 1]
  terms low high
output y in [0, 1]
  zero = constant(0)
  one = constant(1)
if x is low then y is zero
if x is high then y is one''')
kernel = fuzzyctl.compile(system, "numba")
x = np.linspace(0, 1, 20_001)[:, np.newaxis]
if {before}:
    kernel.batch(x)
atexit.register(lambda: print(abs(kernel.batch(x) - x[:, 0]).max() < 1e-15))
"""


class TestMemory:
    """Beyond the results a batch takes about a megabyte, however many points there are."""

    @pytest.mark.parametrize("backend", BACKENDS)
    @pytest.mark.parametrize(
        "layout",
        [
            np.asarray,
            np.asfortranarray,
            lambda p: p.astype(np.float32),
            lambda p: p.reshape(400, 250, 2).transpose(1, 0, 2),
            lambda p: np.broadcast_to(p[:250, np.newaxis], (250, 400, 2)),
        ],
    )
    def test_does_not_grow_with_the_points(self, backend, layout, tipper):
        kernel = compile_system(tipper, backend)
        kernel.batch(points_for(10))
        points = layout(points_for(100_000))
        out = np.empty(points.shape[:-1])
        tracemalloc.start()
        kernel.batch(points, out=out)
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        # Arrays of the blocks of all threads, blocks that are converted, and whatever Python needs itself.
        assert most < blocks.COMPUTED + blocks.CONVERTED + 5e4 == 1e6

    @pytest.mark.parametrize("defuzzifier", ["centroid(resolution=101)", "mom(resolution=101)", "bisector"])
    @pytest.mark.parametrize("shape", ["triangle({}, {}, {})", "gaussian({1}, 0.2)"])
    def test_of_samples_and_integrals_is_less_than_a_megabyte(self, defuzzifier, shape):
        names = [f"t{k}" for k in range(5)]
        own = "".join(f"  {n} = {shape.format(k - 1, k, k + 1)}\n" for k, n in enumerate(names))
        rows = "".join(f"  {n} | {' '.join(names[(i + j) // 2] for j in range(5))}\n" for i, n in enumerate(names))
        text = (
            f"system s\ndefuzzifier {defuzzifier}\ninput x in [0, 4]\n  terms {' '.join(names)}\ninput y in [0, 4]\n"
            f"  terms {' '.join(names)}\noutput u in [0, 4]\n{own}table u = x x y\n  {' '.join(names)}\n{rows}"
        )
        kernel = compile_system(loads(text), "numpy")
        points = points_for(400 if "=" not in defuzzifier and shape.startswith("gaussian") else 8_000) % 4.0
        out = np.empty(len(points))
        kernel.batch(points[:100])
        tracemalloc.start()
        kernel.batch(points, out=out)
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert most < 1e6

    @pytest.mark.parametrize("backend", BACKENDS)
    def test_of_a_sequence_does_not_grow_either(self, backend):
        kernel = compile_system(loads(GAP.format(otherwise="else hold(0.5)")), backend)
        points, out = np.tile([5.0, 0.0], (100_000, 1)), np.empty(100_000)
        points[::7, 0] = 1.0
        kernel.batch(points[:10])
        tracemalloc.start()
        kernel.batch(points, out=out)
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert most < 1.5 * 2**20
        assert out.tolist() == [0.5] * 100_000


class TestListed:
    @pytest.mark.parametrize("shape", [(7, 2), (3, 5, 2), (2, 3, 4, 2), (4, 1, 1, 2), (3, 0, 2)])
    def test_gives_the_points_in_the_order_of_their_indices(self, shape):
        values = np.arange(float(np.prod(shape))).reshape(shape)
        for points in (values, np.asfortranarray(values), np.moveaxis(values, 0, -2) if len(shape) > 2 else values):
            flat = points.reshape(-1, 2)
            for first in range(len(flat) + 1):
                for last in range(first, len(flat) + 1):
                    assert blocks.listed(points, first, last).tolist() == flat[first:last].tolist()


@pytest.mark.parametrize("backend", ["numba", "numpy", "python"])
def test_memory_that_is_shared_is_refused_and_side_by_side_is_not(backend, ais):
    kernel, memory = compile_system(ais, backend), np.zeros(3000)
    with pytest.raises(ArgumentError, match="share memory"):
        kernel.batch(memory[:2000].reshape(1000, 2), out=memory[1500:2500])
    kernel.batch(memory[:2000].reshape(1000, 2), out=memory[2000:])
    assert memory[2000:] == pytest.approx(np.full(1000, kernel(0.0, 0.0)))
