"""Check rule files at the limits of the language, and say how much processor time each takes.

    python tests/fuzz/worst.py
    python tests/fuzz/worst.py --size 0.1 piecewise systems

Prints seconds, exit code, memory and name of each worst case of worst_files.py, or of those whose name holds one of
the words given; exit code 1 if one takes longer than --limit. A case that takes much longer is stopped. Not part of
the test suite, which checks smaller files.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from worst_files import CASES

#: Sets limits to processor time and memory, and runs the command line.
PROGRAM = """
import resource, sys
resource.setrlimit(resource.RLIMIT_CPU, (int(sys.argv[1]),) * 2)
resource.setrlimit(resource.RLIMIT_AS, (4 << 30,) * 2)
from fuzzyctl.cli.main import main
sys.argv = ["fuzzyctl", *sys.argv[2:]]
main()
"""

#: Stands for an exit code where a command ends in a traceback.
TRACEBACK = -1


def measured(name, size, command, stop):
    """Run a command on a worst case; returns processor seconds, exit code and largest memory in MiB."""
    with tempfile.TemporaryDirectory() as folder:
        files = CASES[name](size)
        for file, text in files.items():
            Path(folder, file).write_text(text, encoding="utf-8")
        words = [sys.executable, "-c", PROGRAM, str(stop), *command, next(iter(files))]
        with open(os.devnull, "wb") as nothing, tempfile.TemporaryFile() as errors:
            process = subprocess.Popen(words, cwd=folder, stdout=nothing, stderr=errors)
            _, status, usage = os.wait4(process.pid, 0)
            errors.seek(0)
            # A traceback has the exit code of a file with mistakes.
            failed = b"Traceback (most recent call last)" in errors.read()
        process.returncode = TRACEBACK if failed else os.waitstatus_to_exitcode(status)
        return usage.ru_utime + usage.ru_stime, process.returncode, usage.ru_maxrss // 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--size", type=float, default=1.0, help="1 for files at the limits")
    parser.add_argument("--limit", type=float, default=5.0, help="processor seconds that a case may take")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--command", default="check")
    parser.add_argument("words", nargs="*", help="parts of names of cases")
    arguments = parser.parse_args()
    chosen = [name for name in CASES if not arguments.words or any(w in name for w in arguments.words)]
    stop = int(2 * arguments.limit) + 1
    slow = []
    with ThreadPoolExecutor(arguments.jobs) as pool:
        runs = [pool.submit(measured, n, arguments.size, arguments.command.split(), stop) for n in chosen]
        for name, run in zip(chosen, runs, strict=True):
            seconds, code, memory = run.result()
            print(f"{seconds:7.2f} s {code:4d} {memory:5d} MiB  {name}", flush=True)
            if seconds > arguments.limit or code not in (0, 1, 3):
                slow.append(name)
    print(f"{len(chosen)} cases, {len(slow)} above {arguments.limit:g} s: {', '.join(slow) or 'none'}")
    sys.exit(bool(slow))


if __name__ == "__main__":
    main()
