"""Print what the robots' loop takes, and what it would take if it counted references to its arrays.

python tests/bench/robots.py
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from time import process_time

ROOT = Path(__file__).parents[2]
ROUNDS = 21


def answer(counted: bool) -> None:
    """Print the time to compile the paper's run, then for each line that is read the time of one run [s]."""
    import numba

    njit = numba.njit
    if counted:
        numba.njit = lambda *function, _nrt=True, **options: njit(*function, **options)
    from dwmr import Known, find, read, simulate

    began = process_time()
    file, known = read(find("paper")), Known(proved=True)
    simulate(file, known=known)
    print(process_time() - began, flush=True)
    for _ in sys.stdin:
        began = process_time()
        simulate(file, known=known)
        print(process_time() - began, flush=True)


def measured(rounds: int = ROUNDS) -> dict[str, tuple[float, float]]:
    """Return the times to compile and of a run without and with counts [s], taken in turns by two processes."""
    path = os.pathsep.join([str(ROOT), str(ROOT / "apps")])
    with tempfile.TemporaryDirectory() as folder:
        processes = {
            way: subprocess.Popen(
                [sys.executable, __file__, way],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
                env=os.environ | {"PYTHONPATH": path, "FUZZYCTL_CACHE_DIR": str(Path(folder) / way)},
            )
            for way in ("uncounted", "counted")
        }
        compiling = {way: _line(one) for way, one in processes.items()}
        runs: dict[str, list[float]] = {way: [] for way in processes}
        for _ in range(rounds):
            for way, one in processes.items():
                assert one.stdin is not None
                one.stdin.write("\n")
                one.stdin.flush()
                runs[way].append(_line(one))
        for one in processes.values():
            one.communicate()
    return {way: (compiling[way], statistics.median(times)) for way, times in runs.items()}


def _line(process: subprocess.Popen[str]) -> float:
    assert process.stdout is not None
    return float(process.stdout.readline())


def main() -> None:
    """Measure and print a table; times are those of the processor."""
    print("| 200 s of `dwmr run paper`, three robots | to compile | a run |\n|---|---|---|")
    for way, (compiling, run) in measured().items():
        print(f"| references {way} | {compiling:.1f} s | {1e3 * run:.0f} ms |")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        answer(sys.argv[1] == "counted")
    else:
        main()
