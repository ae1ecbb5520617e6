"""Machine code by which threads share a loop over many points, and the list of numbers by which they speak: a job.

A thread takes shares of a job by moving the place of the first point that nobody has taken. A thread that helps others
has a word: what it is doing, or the job that it is to begin with. A job knows the threads that it was given to, so that
to take it back is one call, in which no interrupt of the interpreter can come.
"""

from __future__ import annotations

import ctypes
import platform
import struct
import sys
from collections.abc import Callable
from enum import IntEnum
from functools import cache
from typing import Final, NamedTuple

from fuzzyctl.kernels.backends.numba import vectorcall as entry


class Place(IntEnum):
    """Where a job has what."""

    CODE = 0  #: Address of the function, int64(points, states, results, table, count).
    POINTS = 1  #: Addresses of its arrays and of its table.
    STATES = 2
    RESULTS = 3
    TABLE = 4
    COUNT = 5  #: The number of points.
    POINT = 6  #: Bytes from one point to the next in the arrays.
    STATE = 7
    RESULT = 8
    DIVISOR = 9  #: A share is what is left by this ...
    LEAST = 10  #: ... but no less.
    REFUSALS = 11  #: The number of kinds of refusals.
    LOOKS = 12  #: Whether to look for NaN among the results.
    NEXT = 24  #: The first point that nobody has taken, apart from what is only read.
    REFUSED = 32  #: The least of what the function returned, counted from the first point of all.
    NAN = 33  #: Whether there was a NaN, or were infinities of both signs.
    MOST = 34  #: Points of the largest share, and about how many are done before `take` returns.
    CHAIN = 35  #: Address of the words of a thread that it was given to; 0 for none.


class Of(IntEnum):
    """Where the words of a thread have what."""

    WORD = 0  #: What it is doing.
    JOB = 1  #: Address of the job that it is given; 0 for none.
    CHAIN = 2  #: Address of the words of another thread that this job was given to.


class Word(IntEnum):
    """What a thread that helps is doing; above these, the address of the job that it is to begin with."""

    ASLEEP = 0
    LINGERS = 1
    BUSY = 2
    WAKES = 3  #: It was asleep when it got a job that was taken back since.


class Posted(IntEnum):
    """What becomes of a job that is posted."""

    REFUSED = 0  #: The thread has another one.
    SEEN = 1  #: It will see it.
    UNSEEN = 2  #: It is asleep, or was to be woken, which an interrupt may have kept from happening.


Job = ctypes.c_int64 * 48
_FIRST: Final = struct.Struct(f"{Place.LOOKS + 1}q{8 * (Place.REFUSED - Place.LOOKS - 1)}x3q")
NEVER: Final = (1 << 63) - 1
#: As long as what a core's cache keeps together, so that no two threads' words get into each other's way.
WordsOfThread = ctypes.c_int64 * 16

#: A sum of results is NaN if one of them is.
_CODE: Final = """
{declared}
define i64 @take(i64* %job) {{
start:
  %code.at = getelementptr i64, i64* %job, i64 {CODE}
  %code.address = load i64, i64* %code.at
  %code = inttoptr i64 %code.address to i64 (i64, i64, i64, i64, i64)*
{loads}
  %next.at = getelementptr i64, i64* %job, i64 {NEXT}
  %most.at = getelementptr i64, i64* %job, i64 {MOST}
  br label %look
look:
  %done = phi i64 [0, %start], [%done, %choose], [%sum, %taken]
  %first = load atomic i64, i64* %next.at monotonic, align 8
  %left = sub i64 %count, %first
  %none = icmp sle i64 %left, 0
  br i1 %none, label %over, label %choose
choose:
  %most = load atomic i64, i64* %most.at monotonic, align 8
  %part = sdiv i64 %left, %divisor
  %small = icmp slt i64 %part, %least
  %more = select i1 %small, i64 %least, i64 %part
  %large = icmp sgt i64 %more, %most
  %less = select i1 %large, i64 %most, i64 %more
  %beyond = icmp sgt i64 %less, %left
  %size = select i1 %beyond, i64 %left, i64 %less
  %last = add i64 %first, %size
  %tried = cmpxchg i64* %next.at, i64 %first, i64 %last acq_rel monotonic
  %mine = extractvalue {{i64, i1}} %tried, 1
  br i1 %mine, label %work, label %look
work:
  %points.skip = mul i64 %first, %point
  %points.own = add i64 %points, %points.skip
  %states.skip = mul i64 %first, %state
  %states.own = add i64 %states, %states.skip
  %results.skip = mul i64 %first, %result
  %results.own = add i64 %results, %results.skip
  %found = call i64 %code(i64 %points.own, i64 %states.own, i64 %results.own, i64 %table, i64 %size)
  %fine = icmp slt i64 %found, 0
  br i1 %fine, label %checked, label %refused
refused:
  %before = mul i64 %first, %refusals
  %where = add i64 %before, %found
  %refused.place = getelementptr i64, i64* %job, i64 {REFUSED}
  %ignored = atomicrmw min i64* %refused.place, i64 %where acq_rel
  %dropped = atomicrmw xchg i64* %next.at, i64 %count acq_rel
  br label %over
checked:
  %unlooked = icmp eq i64 %looks, 0
  br i1 %unlooked, label %taken, label %scan
scan:
  %bytes = mul i64 %size, %result
  %end = add i64 %results.own, %bytes
  br label %many
many:
  %at = phi i64 [%results.own, %scan], [%at.next, %many.more]
  %total = phi <16 x double> [zeroinitializer, %scan], [%total.next, %many.more]
  %at.next = add i64 %at, 128
  %full = icmp ule i64 %at.next, %end
  br i1 %full, label %many.more, label %one
many.more:
  %many.at = inttoptr i64 %at to <16 x double>*
  %values = load <16 x double>, <16 x double>* %many.at, align 8
  %total.next = fadd <16 x double> %total, %values
  br label %many
one:
  %unknown = fcmp uno <16 x double> %total, zeroinitializer
  %unknown.bits = bitcast <16 x i1> %unknown to i16
  %unknown.any = icmp ne i16 %unknown.bits, 0
  br label %single
single:
  %place = phi i64 [%at, %one], [%place.next, %single.more]
  %nan = phi i1 [%unknown.any, %one], [%nan.next, %single.more]
  %rest = icmp ult i64 %place, %end
  br i1 %rest, label %single.more, label %scanned
single.more:
  %single.at = inttoptr i64 %place to double*
  %value = load double, double* %single.at
  %value.nan = fcmp uno double %value, 0.0
  %nan.next = or i1 %nan, %value.nan
  %place.next = add i64 %place, 8
  br label %single
scanned:
  br i1 %nan, label %unpromised, label %taken
unpromised:
  %nan.at = getelementptr i64, i64* %job, i64 {NAN}
  store atomic i64 1, i64* %nan.at monotonic, align 8
  br label %taken
taken:
  %sum = add i64 %done, %size
  %long = icmp sge i64 %sum, %most
  br i1 %long, label %pause, label %look
pause:
  ret i64 %sum
over:
  %nothing.left = xor i64 %done, -1
  ret i64 %nothing.left
}}

define void @serve(i64* %word, i64 %looks) {{
start:
  %woken = cmpxchg i64* %word, i64 {ASLEEP}, i64 {LINGERS} acq_rel acquire
  br label %sleepless
look:
  %k = phi i64 [0, %sleepless], [0, %finished], [%more, %wait]
  %said = load atomic i64, i64* %word acquire, align 8
  %job = icmp ugt i64 %said, {WAKES}
  br i1 %job, label %begin, label %wait
wait:
  {relax}
  %more = add i64 %k, 1
  %enough = icmp sge i64 %more, %looks
  br i1 %enough, label %sleep, label %look
sleep:
  %tried = cmpxchg i64* %word, i64 {LINGERS}, i64 {ASLEEP} acq_rel acquire
  %asleep = extractvalue {{i64, i1}} %tried, 1
  br i1 %asleep, label %end, label %sleepless
sleepless:
  %awake = cmpxchg i64* %word, i64 {WAKES}, i64 {LINGERS} acq_rel acquire
  br label %look
begin:
  %claimed = cmpxchg i64* %word, i64 %said, i64 {BUSY} acq_rel acquire
  %mine = extractvalue {{i64, i1}} %claimed, 1
  br i1 %mine, label %work, label %sleepless
work:
  %at = inttoptr i64 %said to i64*
  %again = call i64 @take(i64* %at)
  %unfinished = icmp sge i64 %again, 0
  br i1 %unfinished, label %work, label %finished
finished:
  store atomic i64 {LINGERS}, i64* %word release, align 8
  br label %look
end:
  ret void
}}

define i64 @post(i64* %words, i64 %job) {{
start:
  %given.at = getelementptr i64, i64* %words, i64 {OF_JOB}
  %given = cmpxchg i64* %given.at, i64 0, i64 %job acq_rel acquire
  %mine = extractvalue {{i64, i1}} %given, 1
  br i1 %mine, label %chain, label %refused
chain:
  %places = inttoptr i64 %job to i64*
  %first.at = getelementptr i64, i64* %places, i64 {CHAIN}
  %next.at = getelementptr i64, i64* %words, i64 {OF_CHAIN}
  %next = load i64, i64* %first.at
  store i64 %next, i64* %next.at
  %own = ptrtoint i64* %words to i64
  store i64 %own, i64* %first.at
  %old = atomicrmw xchg i64* %words, i64 %job acq_rel
  %asleep = icmp eq i64 %old, {ASLEEP}
  %wakes = icmp eq i64 %old, {WAKES}
  %unseen = or i1 %asleep, %wakes
  %posted = select i1 %unseen, i64 {POSTED_UNSEEN}, i64 {POSTED_SEEN}
  ret i64 %posted
refused:
  ret i64 {POSTED_REFUSED}
}}

define void @leave(i64* %job, i64 %looks, i64 %sleep.address, i32 %time) {{
start:
  %count.at = getelementptr i64, i64* %job, i64 {COUNT}
  %count = load i64, i64* %count.at
  %next.at = getelementptr i64, i64* %job, i64 {NEXT}
  %dropped = atomicrmw xchg i64* %next.at, i64 %count acq_rel
  %own = ptrtoint i64* %job to i64
  %sleep = inttoptr i64 %sleep.address to i32 (i32)*
  %chain.at = getelementptr i64, i64* %job, i64 {CHAIN}
  br label %each
each:
  %words.address = load i64, i64* %chain.at
  %none = icmp eq i64 %words.address, 0
  br i1 %none, label %end, label %take.back
take.back:
  %words = inttoptr i64 %words.address to i64*
  %taken = cmpxchg i64* %words, i64 %own, i64 {WAKES} acq_rel acquire
  br label %look
look:
  %k = phi i64 [0, %take.back], [%more, %wait], [0, %nap]
  %said = load atomic i64, i64* %words acquire, align 8
  %busy = icmp eq i64 %said, {BUSY}
  br i1 %busy, label %wait, label %free
wait:
  {relax}
  %more = add i64 %k, 1
  %enough = icmp sge i64 %more, %looks
  br i1 %enough, label %nap, label %look
nap:
  %slept = call i32 %sleep(i32 %time)
  br label %look
free:
  %rest.at = getelementptr i64, i64* %words, i64 {OF_CHAIN}
  %rest = load i64, i64* %rest.at
  store i64 %rest, i64* %chain.at
  %given.at = getelementptr i64, i64* %words, i64 {OF_JOB}
  store atomic i64 0, i64* %given.at release, align 8
  br label %each
end:
  ret void
}}
"""

_LOAD: Final = """
  %{name}.at = getelementptr i64, i64* %job, i64 {place}
  %{name} = load i64, i64* %{name}.at"""

#: Tells the core that a thread only waits.
_RELAX: Final = "call void @llvm.x86.sse2.pause()"


def job(*numbers: int, most: int) -> ctypes.Array[ctypes.c_int64]:
    """Return a job nobody has begun with.

    Args:
        numbers: Those from `Place.CODE` to `Place.LOOKS`.
        most: That at `Place.MOST`.
    """
    made = Job()
    _FIRST.pack_into(made, 0, *numbers, NEVER, 0, most)
    return made


class Functions(NamedTuple):
    """What the machine code offers; `post` alone keeps the lock of the interpreter."""

    take: Callable[..., int]
    """(job): Take shares, and return how many points were done; below 0, it is -1 - those points: none are left."""
    serve: Callable[..., None]
    """(words, looks): Take shares of the jobs that come until none has come for so many looks."""
    post: Callable[..., int]
    """(words, job): Give a job to a thread; see `Posted`."""
    leave: Callable[..., None]
    """(job, looks, *NAP): End a job: whoever it was given to does no more once this returns.

    After so many looks at a thread that is not done it naps before it looks again."""


@cache
def functions() -> Functions:
    """Return the functions, compiled once for each process."""
    relaxes = platform.machine().lower() in ("x86_64", "amd64")
    loads = (_LOAD.format(name=p.name.lower(), place=p.value) for p in Place if Place.CODE < p < Place.NEXT)
    code = _CODE.format(
        declared="declare void @llvm.x86.sse2.pause()" if relaxes else "",
        relax=_RELAX if relaxes else "",
        loads="".join(loads),
        **{name: value.value for kind in (Place, Word) for name, value in kind.__members__.items()},
        **{f"OF_{name}": value.value for name, value in Of.__members__.items()},
        **{f"POSTED_{name}": value.value for name, value in Posted.__members__.items()},
    )
    take, serve, post, leave = entry.loaded(code, "take", "serve", "post", "leave")
    number, address, c_int = ctypes.c_int64, ctypes.c_void_p, ctypes.c_int32
    return Functions(
        ctypes.CFUNCTYPE(number, address)(take),
        ctypes.CFUNCTYPE(None, address, number)(serve),
        ctypes.PYFUNCTYPE(number, address, number)(post),
        ctypes.CFUNCTYPE(None, address, number, number, c_int)(leave),
    )


@cache
def nap() -> tuple[int, int]:
    """Return the address of a function of the operating system that sleeps, and for how long: 50 µs, or 1 ms."""
    if sys.platform == "win32":
        return ctypes.cast(ctypes.windll.kernel32.Sleep, ctypes.c_void_p).value or 0, 1
    return ctypes.cast(ctypes.CDLL(None).usleep, ctypes.c_void_p).value or 0, 50
