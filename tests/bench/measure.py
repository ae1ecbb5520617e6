"""Time per evaluation of every way to evaluate the workloads, in one process, round by round."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

import fuzzyctl
from tests.bench import fll, peers
from tests.bench.workloads import WORKLOADS, Workload

HERE = Path(__file__).parent
FLAGS = ("-O3", "-march=native", "-fno-math-errno", "-fno-trapping-math")
ROUNDS = 7
#: What is done once and takes milliseconds is repeated so often in a round.
REPEATS = 30
#: Points of a loop in Python, and of a batch.
FEW, MANY = 3000, 1_000_000

Timed = dict[str, float]


def build_limits(folder: Path) -> ctypes.CDLL | None:
    """Compile the hand-written C; None without a C compiler."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        return None
    built = folder / "limits.so"
    subprocess.run([compiler, *FLAGS, "-shared", "-fPIC", str(HERE / "limits.c"), "-o", str(built), "-lm"], check=True)
    library = ctypes.CDLL(str(built))
    library.w1_prepare()
    for name in ("w1", "w2", "w3", "w4"):
        getattr(library, f"{name}_waiting").restype = ctypes.c_double
    return library


def pointer(array: np.ndarray[Any, Any]) -> Any:
    """Return where an array begins, as C takes it."""
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def limit(library: ctypes.CDLL, workload: Workload, form: str, points: Any, out: Any) -> None:
    """Evaluate points by the hand-written C, in the form `batch`, `points` or `waiting`."""
    function = getattr(library, f"{workload.name.lower()}_{form}")
    count = ctypes.c_long(len(points))
    if form == "waiting":
        out[0] = function(pointer(points), count)
    else:
        function(pointer(points), pointer(out), count)


def fuzzylite(folder: Path, workload: Workload, include: str = "", library: str = "") -> float | None:
    """Return what fuzzylite's C++ engine needs [ns]; None where it cannot be built.

    Args:
        folder: For what is built.
        workload: What is evaluated.
        include, library: Folders of its headers and its library, where they are not where the compiler looks.
    """
    compiler, program = shutil.which("g++"), folder / "fuzzylite"
    if compiler is None:
        return None
    if not program.exists():
        places = [f"-I{include}"] if include else []
        places += [f"-L{library}", f"-Wl,-rpath,{library}"] if library else []
        source = str(HERE / "fuzzylite.cpp")
        command = [compiler, "-O2", "-std=c++11", source, *places, "-lfuzzylite", "-o", str(program)]
        if subprocess.run(command, capture_output=True).returncode:
            return None
    (folder / "engine.fll").write_text(fll.texts()[workload.name], encoding="utf-8")
    (folder / "points.bin").write_bytes(workload.points(20_000).tobytes())
    command = [str(program), str(folder / "engine.fll"), str(folder / "points.bin")]
    return float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def measure(workload: Workload, library: ctypes.CDLL | None, backends: tuple[str, ...]) -> Timed:
    """Return nanoseconds per evaluation by way of evaluating; the best of some rounds, all ways in each round."""
    ways = _ways(workload, library, backends)
    for run, _ in ways.values():
        run()  # compiles
    best = dict.fromkeys(ways, float("inf"))
    for _ in range(ROUNDS):
        for name, (run, count) in ways.items():
            if count == FEW:
                run()  # what went before has filled the caches with arrays; fuzzylite runs in a process of its own
            for _ in range(REPEATS if count == 1 else 1):
                began = perf_counter()
                run()
                best[name] = min(best[name], (perf_counter() - began) / count * 1e9)
    return best


def _ways(
    workload: Workload, library: ctypes.CDLL | None, backends: tuple[str, ...]
) -> dict[str, tuple[Callable[[], Any], int]]:
    system = fuzzyctl.loads(workload.text, workload.name)
    points = workload.points(MANY)
    out = np.empty(MANY)
    few = [tuple(p) for p in points[:FEW].tolist()]
    ways: dict[str, tuple[Callable[[], Any], int]] = {}
    if library is not None:
        for form in ("points", "waiting", "batch"):
            ways[f"C, {form}"] = (lambda form=form: limit(library, workload, form, points, out), MANY)
    python = fuzzyctl.compile(system, "python")
    ways["call, no compiler"] = (lambda: [python(x, y) for x, y in few], FEW)
    # Once a system, not once an evaluation; many times a round, since the best one counts.
    ways["text to callable"] = (lambda: fuzzyctl.compile(fuzzyctl.loads(workload.text), "python"), 1)
    if "numba" in backends:
        compiled = fuzzyctl.compile(system, "numba")
        names = [v.name for v in system.inputs]
        ways["call, compiled"] = (lambda: [compiled(x, y) for x, y in few], FEW)
        ways["call by name"] = (lambda: [system(**{names[0]: x, names[1]: y}) for x, y in few], FEW)
        ways["loop, compiled"] = (_loop(compiled.jit, points), MANY)
        ways["loop, each waits"] = (_waiting(compiled.jit, points), MANY)
        ways["batch, compiled"] = (lambda: compiled.batch(points, out=out, parallel=False), MANY)
        ways["batch, all cores"] = (lambda: compiled.batch(points, out=out), MANY)
    arrays = fuzzyctl.compile(system, "numpy")
    ways["batch, numpy"] = (lambda: arrays.batch(points[:200_000], out=out[:200_000], parallel=False), 200_000)
    return ways


def _peers(folder: Path, workload: Workload) -> Timed:
    """Return what other Python tools need, those that can be installed and can express the workload."""
    engine, points = folder / "peer.fll", folder / "peer.bin"
    engine.write_text(fll.texts()[workload.name], encoding="utf-8")
    points.write_bytes(workload.points(peers.POINTS).tobytes())
    found: Timed = {}
    for peer, (_, workloads) in peers.PEERS.items():
        python = peers.environment(peer, folder) if workload.name in workloads else None
        value = peers.measure(peer, python, engine, points) if python is not None else None
        if value is not None:
            found[peer] = value
    return found


def _loop(function: Any, points: Any) -> Callable[[], Any]:
    import numba

    @numba.njit
    def loop(points: Any) -> float:
        total = 0.0
        for k in range(points.shape[0]):
            total += function(points[k, 0], points[k, 1])
        return total

    return lambda: loop(points)


def _waiting(function: Any, points: Any) -> Callable[[], Any]:
    import numba

    @numba.njit
    def loop(points: Any) -> float:
        last = 0.0
        for k in range(points.shape[0]):
            last = function(points[k, 0] + 1e-9 * last, points[k, 1])
        return last

    return lambda: loop(points)


def everything(include: str = "", library: str = "", *, with_peers: bool = False) -> dict[str, Timed]:
    """Measure all workloads, beside the hand-written C and fuzzylite where they can be built.

    Args:
        include, library: Folders of fuzzylite's headers and its library, see `fuzzylite`.
        with_peers: Whether to install other Python tools and to measure them, too.
    """
    found = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        limits = build_limits(folder)
        for workload in WORKLOADS:
            times = measure(workload, limits, ("numba", "numpy"))
            engine = fuzzylite(folder, workload, include, library)
            found[workload.name] = ({} if engine is None else {"fuzzylite": engine}) | times
            if with_peers:
                found[workload.name] |= _peers(folder, workload)
    return found
