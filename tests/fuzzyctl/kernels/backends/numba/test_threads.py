"""Threads that share loops in machine code; here the loop is a function of Python that tells what it is given."""

import ctypes
import dis
import math
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

pytest.importorskip("numba")

from fuzzyctl import as_profile
from fuzzyctl.kernels.backends.numba import thread_ir as shares
from fuzzyctl.kernels.backends.numba import threads as sharing
from fuzzyctl.kernels.backends.numba.thread_ir import Word
from fuzzyctl.kernels.compile import compile as compile_system

#: Seconds that nothing takes but what never comes.
LONG = 300
LOOP = ctypes.CFUNCTYPE(ctypes.c_int64, *[ctypes.c_int64] * 5)


@pytest.fixture
def cores(monkeypatch):
    """Three threads, whatever the machine and however little there is to do."""
    monkeypatch.setattr(sharing, "ENOUGH", 1e-12)
    monkeypatch.setattr(sharing, "WAKING", 0.0)
    monkeypatch.setattr(sharing, "cores", lambda: 3)


class Clock:
    """A clock that is moved by hand, from any thread."""

    def __init__(self):
        self.now = 1000.0

    def __call__(self):
        return self.now

    def passes(self, seconds):
        self.now += seconds


@pytest.fixture
def clock(monkeypatch):
    """What a point takes, and how long ago something was, by a clock that is moved by hand."""
    for seconds in (sharing.PATIENCE, sharing.LINGERING):
        sharing._looks(seconds)  # kept from here on: measured by the true clock
    clock = Clock()
    monkeypatch.setattr(sharing, "perf_counter", clock)
    monkeypatch.setattr(sharing, "_last", -math.inf)  # not by the true clock, which may be ahead
    return clock


class Together:
    """Holds shares until each of several threads has begun one, so that none comes too late on a busy machine."""

    def __init__(self, count):
        self._count, self._begun, self.all = count, set(), threading.Event()

    def __call__(self, *_):
        self._begun.add(threading.get_ident())
        if len(self._begun) == self._count or not self.all.wait(LONG):
            self.all.set()


class Told:
    """A loop over points of two inputs and one output that writes what it is given, and keeps count.

    Args:
        count: The number of points.
        each: Called with the first and the last point of each share; what it returns the loop returns, -1 for None.
    """

    def __init__(self, count, each=None):
        self.points, self.results = np.zeros((count, 2)), np.full((count, 1), np.nan)
        self.points[:, 0] = np.arange(count)
        self.seen, self.each = [], each
        function = LOOP(self._fill)
        address = ctypes.cast(function, ctypes.c_void_p).value
        self.loop = sharing.Loop(address, np.zeros(1), 2, function)

    def _fill(self, points, _states, results, _table, count):
        first = (results - self.results.ctypes.data) // 8
        assert points == self.points.ctypes.data + 16 * first
        self.seen.append((threading.get_ident(), first, count))
        self.results[first : first + count, 0] = self.points[first : first + count, 0]
        found = None if self.each is None else self.each(first, first + count)
        return -1 if found is None else found

    def run(self, *, looks=False, parallel=True):
        return self.loop.run(self.points, None, self.results, parallel=parallel, looks=looks)

    def threads(self):
        return {thread for thread, _, _ in self.seen}


def asleep(helper):
    """Wait until a thread has nothing to do and looks for nothing."""
    until = time.monotonic() + LONG
    while helper._words[0] != Word.ASLEEP and time.monotonic() < until:
        time.sleep(0.001)
    return helper._words[0] == Word.ASLEEP


@pytest.mark.usefixtures("cores")
class TestShares:
    @pytest.mark.parametrize("count", [0, 1, 2048, 2049, 30_000, 3 * sharing.MOST + 5])
    def test_are_all_points_once(self, count):
        told = Told(count)
        assert told.run() == (None, False)
        taken = sorted((first, size) for _, first, size in told.seen)
        assert sum(size for _, size in taken) == count
        assert [first for first, _ in taken] == [0, *np.cumsum([size for _, size in taken])][: len(taken)]
        assert all(size <= sharing.MOST for _, size in taken)
        np.testing.assert_array_equal(told.results[:, 0], np.arange(count))

    def test_are_taken_by_all_threads(self):
        told = Told(200_000, Together(3))
        told.run()
        assert len(told.threads()) == 3

    def test_are_one_where_a_single_thread_is_wanted(self):
        told = Told(200_000)
        told.run(parallel=False)
        assert told.threads() == {threading.get_ident()}
        told.seen.clear()
        told.run(parallel=False)
        assert [share[1:] for share in told.seen] == [(0, 200_000)]

    def test_are_small_until_it_is_known_how_long_they_take_and_never_long(self, clock):
        told = Told(100_000, lambda first, last: clock.passes(10e-6 * (last - first)))
        told.run(parallel=False)
        sizes = [size for _, _, size in told.seen]
        assert sizes[0] == 1 << 10
        assert max(sizes) <= 2000  # 0.02 s

    def test_of_many_jobs_in_a_row_and_apart_are_right(self):
        random = np.random.default_rng(0)
        for _ in range(300):
            told = Told(int(random.integers(1, 40_000)))
            told.run()
            np.testing.assert_array_equal(told.results[:, 0], told.points[:, 0])
            time.sleep(random.choice([0.0, 1e-4, 4e-4]))  # while the others look for more, fall asleep, or sleep


@pytest.mark.usefixtures("cores")
class TestRefusals:
    def test_the_first_point_counts(self):
        refused = {11_111, 2_500, 19_000}

        def each(first, last):
            time.sleep(0.001)
            hit = [k for k in sorted(refused) if first <= k < last]
            return 2 * (hit[0] - first) + 1 if hit else None

        for _ in range(20):
            assert Told(20_000, each).run()[0] == 2 * 2_500 + 1

    def test_no_share_is_begun_after_one(self):
        told = Told(10**6, lambda *_: 0)
        told.run(parallel=False)
        assert len(told.seen) == 1


@pytest.mark.usefixtures("cores")
class TestNan:
    @pytest.mark.parametrize("count", [1, 15, 16, 17, 40, 5000])
    def test_is_seen_wherever_it_is(self, count):
        for place in {0, count // 2, count - 1}:
            told = Told(count)
            told.points[place, 0] = np.nan
            assert told.run(looks=True) == (None, True)
            assert told.run(looks=False) == (None, False)

    def test_is_not_seen_where_none_is(self):
        told = Told(5000)
        told.points[:, 0] = np.inf
        assert told.run(looks=True) == (None, False)


@pytest.mark.usefixtures("cores")
class TestThreads:
    def test_sleep_when_nothing_comes_and_are_woken_again(self):
        helpers = sharing._crew(sharing.os.getpid()).of(2)
        for _ in range(4):
            assert all(asleep(helper) for helper in helpers)
            slow = Told(200_000, Together(3))
            slow.run()
            assert len(slow.threads()) == 3

    def test_fall_asleep_though_a_job_was_taken_back(self):
        """A job that is posted and left before the thread has begun with it."""
        (helper,) = sharing._Crew().of(1)
        for _ in range(200):
            job = shares.job(*[0] * 13, most=1)
            helper.begin(job)
            shares.functions().leave(job, 10, *shares.nap())
        assert asleep(helper)

    def test_sleep_again_though_they_were_woken_for_nothing(self):
        word = shares.WordsOfThread(Word.ASLEEP)
        served = threading.Thread(target=shares.functions().serve, args=(word, 10), daemon=True)
        served.start()
        served.join(timeout=LONG)
        assert not served.is_alive()
        assert word[0] == Word.ASLEEP

    def test_that_are_busy_elsewhere_are_done_without(self):
        busy, done = Together(3), threading.Event()

        def each(*_):
            busy()
            done.wait(LONG)

        outer, inner = Told(30_000, each), Told(30_000)
        caller = threading.Thread(target=outer.run)
        caller.start()
        assert busy.all.wait(LONG)
        inner.run()
        done.set()
        assert inner.threads() == {threading.get_ident()}
        caller.join(timeout=LONG)
        np.testing.assert_array_equal(outer.results, inner.results)

    def test_write_nothing_after_an_interrupt_and_help_the_next_time(self, tipper, monkeypatch):
        kernel = compile_system(as_profile(tipper, "matlab"), "numba")
        points, out = np.zeros((2_000_000, 2)), np.full(2_000_000, np.nan)
        kernel.batch(points[:5000])
        begin = sharing._Helper.begin

        def interrupted(helper, job):
            begin(helper, job)
            until = time.monotonic() + LONG
            while np.isnan(out).all() and time.monotonic() < until:  # until it writes
                time.sleep(0.001)
            signal.raise_signal(signal.SIGINT)

        with monkeypatch.context() as patch:
            patch.setattr(sharing._Helper, "begin", interrupted)
            with pytest.raises(KeyboardInterrupt):
                kernel.batch(points, out=out)
        written = np.count_nonzero(out == out)
        assert written > 0
        assert not any(helper._words[shares.Of.JOB] for helper in sharing._crew(sharing.os.getpid()).of(2))
        time.sleep(0.02)
        assert np.count_nonzero(out == out) == written
        again = Told(200_000, Together(3))
        again.run()
        assert len(again.threads()) == 3


def test_with_little_to_do_no_thread_is_woken(monkeypatch):
    monkeypatch.setattr(sharing, "cores", lambda: 3)
    told = Told(8000)
    told.loop._pace = 1e-9
    told.run()
    assert told.threads() == {threading.get_ident()}


def test_what_comes_seldom_wakes_nobody_but_what_comes_in_a_row_does(monkeypatch, clock):
    monkeypatch.setattr(sharing, "cores", lambda: 3)
    told = Told(100_000)
    helpers = sharing._crew(sharing.os.getpid()).of(2)
    for _ in range(3):
        assert all(asleep(helper) for helper in helpers)
        clock.passes(2 * sharing.SOON)
        told.loop._pace = 1e-9  # 0.1 ms in all
        told.seen.clear()
        told.run()
        assert len(told.threads()) == 1
    told.loop._pace, told.each = 1e-9, Together(3)
    clock.passes(0.5 * sharing.SOON)
    told.run()
    assert len(told.threads()) == 3


def test_with_more_to_do_for_each_point_threads_are_woken_sooner(monkeypatch, clock):
    monkeypatch.setattr(sharing, "cores", lambda: 3)
    told = Told(8000, lambda *_: clock.passes(0.02))
    told.run()
    assert len(told.threads()) == 1
    told.each = Together(3)
    told.run()
    assert len(told.threads()) == 3


@pytest.mark.usefixtures("cores")
def test_few_points_that_take_long_are_shared(clock):
    told = Told(12, lambda first, last: clock.passes(0.003 * (last - first)))
    told.run(parallel=False)
    told.seen.clear()
    told.each = Together(3)
    told.run()
    assert len(told.threads()) == 3
    assert {size for _, _, size in told.seen} == {1, 2}


def test_what_takes_too_little_to_tell_lowers_the_pace_only(clock):
    told = Told(50, lambda *_: clock.passes(0.5 * sharing._TELLING))
    told.loop._pace = 1e-2
    told.run(parallel=False)
    assert told.loop._pace < 1e-2
    told.loop._pace = 1e-12
    told.run(parallel=False)
    assert told.loop._pace == 1e-12


def test_waiting_for_others_is_no_part_of_what_a_point_takes(monkeypatch, clock):
    monkeypatch.setattr(sharing, "cores", lambda: 2)
    caller, functions, both, waits = threading.get_ident(), shares.functions(), Together(2), threading.Event()

    def leave(*arguments):
        waits.set()
        functions.leave(*arguments)

    def each(*_):
        both()
        if threading.get_ident() == caller:
            clock.passes(0.002)
        else:
            waits.wait(LONG)
            clock.passes(0.2)

    monkeypatch.setattr(sharing, "functions", lambda: functions._replace(leave=leave))
    told = Told(40_000, each)
    told.loop._pace = 1e-6
    told.run()
    assert len(told.threads()) == 2
    points = sum(size for thread, _, size in told.seen if thread == caller)
    shares_taken = sum(thread == caller for thread, _, _ in told.seen)
    assert told.loop._pace == pytest.approx(0.002 * shares_taken / points)


@pytest.mark.usefixtures("cores")
def test_signals_are_left_to_other_threads():
    masks, together = {}, Together(3)

    def each(*_):
        together()
        masks[threading.get_ident()] = signal.pthread_sigmask(signal.SIG_BLOCK, ())

    Told(100_000, each).run()
    own = masks.pop(threading.get_ident())
    assert signal.SIGTERM not in own
    assert len(masks) == 2
    assert all(signal.SIGTERM in mask for mask in masks.values())


@pytest.mark.usefixtures("cores")
def test_where_no_thread_can_be_started_one_does_it_all_and_tries_again_later(monkeypatch, clock):
    tries = []

    def fail(*_):
        tries.append(1)
        raise RuntimeError("can't start new thread")

    crew = sharing._Crew()
    monkeypatch.setattr(sharing, "_crew", lambda _process: crew)
    with monkeypatch.context() as patch:
        patch.setattr(sharing._thread, "start_new_thread", fail)
        for _ in range(3):
            told = Told(50_000)
            told.run()
            np.testing.assert_array_equal(told.results[:, 0], told.points[:, 0])
        assert len(tries) == 1
    clock.passes(2.0)
    slow = Told(200_000, Together(3))
    slow.run()
    assert len(slow.threads()) == 3


AT_EXIT = """
import atexit, numpy as np, fuzzyctl
from fuzzyctl.kernels import sharing
sharing.ENOUGH, sharing.WAKING, sharing.cores = 1e-12, 0.0, lambda: 3
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


@pytest.mark.parametrize("before", [True, False])
def test_a_batch_at_the_end_of_the_interpreter_is_right(before):
    run = subprocess.run(
        [sys.executable, "-c", AT_EXIT.format(before=before)], capture_output=True, text=True, timeout=LONG, check=False
    )
    assert (run.stdout, run.stderr, run.returncode) == ("True\n", "", 0)


INTERRUPTED = {f.__code__ for f in (sharing.Loop._take_with, sharing.Loop._take, sharing._Helper.begin)}


class Interrupt:
    """Interrupts a batch where the interpreter looks for interrupts, at one of the places in turn.

    That is where functions begin, where loops begin anew, and after calls.
    """

    def __init__(self, place):
        self.left, self._called = place, set()

    def __call__(self, frame, _event, _argument):
        if frame.f_code not in INTERRUPTED:
            return None
        frame.f_trace_opcodes = True
        return self._step

    def _step(self, frame, event, _argument):
        if event == "opcode":
            name = dis.opname[frame.f_code.co_code[frame.f_lasti]]
            looks = name == "RESUME" or "BACKWARD" in name or frame in self._called
            self._called.discard(frame)
            if name.startswith("CALL"):
                self._called.add(frame)
            self.left -= looks
            if looks and self.left == 0:
                raise KeyboardInterrupt
        return self._step


@pytest.mark.usefixtures("cores")
def test_an_interrupt_anywhere_costs_no_thread_and_leaves_none_writing():
    told = Told(30_000)
    helpers, place, before = sharing._crew(sharing.os.getpid()).of(2), 0, sys.gettrace()

    def pausing(*_):
        time.sleep(0.001)

    while True:
        place += 1
        assert all(asleep(helper) for helper in helpers)
        interrupt = Interrupt(place)
        told.results[:] = np.nan
        told.each = pausing
        sys.settrace(interrupt)
        try:
            told.run()
        except KeyboardInterrupt:
            pass
        finally:
            sys.settrace(before)
        assert not any(helper._words[shares.Of.JOB] for helper in helpers)
        told.seen.clear()
        time.sleep(0.003)
        assert told.seen == []
        told.each = Together(3)
        told.run()
        assert len(told.threads()) == 3
        if interrupt.left > 0:
            break
    assert place > 20


@pytest.mark.usefixtures("cores")
def test_many_interrupts_cost_no_thread(tipper):
    """Signals as they come, those among them that come while another one is dealt with."""
    kernel = compile_system(tipper, "numba")
    points, out = np.zeros((100_000, 2)), np.empty(100_000)
    kernel.batch(points)

    def handler(_signal, frame):
        for _ in range(6):
            if frame.f_code is sharing.Loop.run.__code__:
                raise KeyboardInterrupt
            frame = frame.f_back

    before = signal.signal(signal.SIGALRM, handler)
    interrupted = 0
    for k in range(600):
        try:
            signal.setitimer(signal.ITIMER_REAL, 20e-6 + 2e-7 * k, 50e-6)
            kernel.batch(points, out=out)
        except KeyboardInterrupt:
            interrupted += 1
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    time.sleep(0.01)
    signal.signal(signal.SIGALRM, before)
    assert interrupted > 50
    assert not any(helper._words[shares.Of.JOB] for helper in sharing._crew(sharing.os.getpid()).of(2))
