"""Run commands on rule files at the limits of the language, and print how much processor time each takes.

    python tests/fuzz/worst.py
    python tests/fuzz/worst.py --size 0.1 piecewise systems
    python tests/fuzz/worst.py --limit 20 --command "compare --changes FILE FILE"
    python tests/fuzz/worst.py --command "prove --bounds" --command "page FILE -o page.html"

Prints seconds, exit code, memory, command and name of each worst case of worst_files/, or of those whose name contains
one of the words given; exit code 1 if one takes longer than --limit or more than --memory, or ends in a
traceback. A case that takes much longer is stopped. Not part of the test suite, which checks smaller files.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from worst_files import CASES

#: Sets limits to processor time and memory, lets time limits count processor time, which no other process of the
#: machine makes more, and runs the command line.
PROGRAM = """
import resource, sys, time
resource.setrlimit(resource.RLIMIT_CPU, (int(sys.argv[1]),) * 2)
resource.setrlimit(resource.RLIMIT_AS, (4 << 30,) * 2)
from fuzzyctl.analysis.work import clock
from fuzzyctl.cli.main import main
clock.now = time.process_time
sys.argv = ["fuzzyctl", *sys.argv[2:]]
main()
"""

#: The commands that run by default.
COMMANDS = ("check", "prove --bounds", "simulate FILE -o run", "page FILE -o page.html")
#: Stands for an exit code where a command ends in a traceback.
TRACEBACK = -1


def words_of(command, files):
    """Return the words of a command: FILE stands for the first of some files, INPUTS for values of its inputs."""
    (file, text), *_ = files.items()
    inputs = [f"{name}=0.3" for name in dict.fromkeys(re.findall(r"^input (\w+) in", text, re.MULTILINE))]
    words = command.split()
    words = words if "FILE" in words else [*words, "FILE"]
    return [w for word in words for w in (inputs if word == "INPUTS" else [file if word == "FILE" else word])]


def measured(name, size, command, stop):
    """Run a command on a worst case; returns processor seconds, exit code and largest memory in MiB."""
    with tempfile.TemporaryDirectory() as folder:
        files = CASES[name](size)
        for file, text in files.items():
            Path(folder, file).write_text(text, encoding="utf-8")
        words = [sys.executable, "-c", PROGRAM, str(stop), *words_of(command, files)]
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
    parser.add_argument("--memory", type=int, default=1024, help="MiB that a case may take")
    help_text = (
        f"with FILE and INPUTS where they are not at the end; may be repeated; without it: {', '.join(COMMANDS)}"
    )
    parser.add_argument("--command", action="append", dest="commands", help=help_text)
    parser.add_argument("words", nargs="*", help="parts of names of cases")
    arguments = parser.parse_args()
    chosen = [name for name in CASES if not arguments.words or any(w in name for w in arguments.words)]
    stop = int(2 * arguments.limit) + 1
    slow = []
    with ThreadPoolExecutor(arguments.jobs) as pool:
        cases = [(command, name) for command in arguments.commands or COMMANDS for name in chosen]
        runs = [pool.submit(measured, name, arguments.size, command, stop) for command, name in cases]
        for (command, name), run in zip(cases, runs, strict=True):
            seconds, code, memory = run.result()
            print(f"{seconds:7.2f} s {code:4d} {memory:5d} MiB  {command.split()[0]} {name}", flush=True)
            if seconds > arguments.limit or memory > arguments.memory or code not in (0, 1, 2, 3):
                slow.append(f"{command.split()[0]} {name}")
    print(f"{len(cases)} cases, {len(slow)} above the limits: {', '.join(slow) or 'none'}")
    sys.exit(bool(slow))


if __name__ == "__main__":
    main()
