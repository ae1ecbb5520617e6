"""Start-up: processor time of short commands beside that of importing the libraries that they need.

    python tests/bench/startup.py

Prints seconds of processor time (the least of --runs, with bytecode cached) and ratios: `check` and `eval` beside
`from pydantic import BaseModel; import click`, `--help` and `--version` beside `import click`. Then how many of
fuzzyctl's files `eval` goes through once they are imported, and how many calls. Exit code 1 where a ratio or a number
is above its limit.
"""

import argparse
import os
import subprocess
import sys
from collections import Counter
from functools import partial
from importlib import import_module
from pathlib import Path

from click.testing import CliRunner

ROOT = Path(__file__).parents[2]
TIPPER = str(ROOT / "rules" / "tipper.fz")
MAIN = "from fuzzyctl.cli.main import main; main()"
#: What a command is compared with, and how many times its processor time it may take.
LIBRARIES = {
    "import click": 1.6,
    "from pydantic import BaseModel; import click": 2.0,
}
COMMANDS = {
    "--version": (["--version"], "import click"),
    "--help": (["--help"], "import click"),
    "check tipper.fz": (["check", TIPPER], "from pydantic import BaseModel; import click"),
    "eval tipper.fz": (["eval", TIPPER, "service=7", "food=8"], "from pydantic import BaseModel; import click"),
}
#: Files and calls that `eval tipper.fz` may take.
MOST_FILES, MOST_CALLS = 60, 8000


def walk(arguments):
    """Return how often a command calls the functions of fuzzyctl, by file and name."""
    found = Counter()

    def count(frame, event, _):
        path = Path(frame.f_code.co_filename)
        if event == "call" and path.is_relative_to(ROOT / "fuzzyctl"):
            found[path.relative_to(ROOT).as_posix(), frame.f_code.co_qualname] += 1

    run = partial(CliRunner().invoke, import_module("fuzzyctl.cli.main").main, arguments, catch_exceptions=False)
    run()  # which imports what it needs
    before = sys.getprofile()
    sys.setprofile(count)
    try:
        result = run()
    finally:
        sys.setprofile(before)
    assert result.exit_code == 0, result.output
    return found


def seconds(code, arguments):
    """Return the processor time of a program [s]."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    nothing = subprocess.DEVNULL
    process = subprocess.Popen(
        [sys.executable, "-c", code, *arguments], stdout=nothing, stderr=nothing, env=environment
    )
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        sys.exit(f"{code} {arguments} ended with {process.returncode}")
    return usage.ru_utime + usage.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--runs", type=int, default=10)
    programs = {code: (code, []) for code in LIBRARIES}
    programs |= {name: (MAIN, arguments) for name, (arguments, _) in COMMANDS.items()}
    # In turns, so that all of them run on an equally busy machine.
    rounds = [[seconds(*program) for program in programs.values()] for _ in range(parser.parse_args().runs)]
    least = dict(zip(programs, map(min, zip(*rounds, strict=True)), strict=True))
    above = []
    for name, took in least.items():
        if name in LIBRARIES:
            print(f"{took:6.3f} s        {name}")
            continue
        library = COMMANDS[name][1]
        ratio = took / least[library]
        print(f"{took:6.3f} s  {ratio:4.2f}  fuzzyctl {name} (limit {LIBRARIES[library]})")
        if ratio > LIBRARIES[library]:
            above.append(name)
    found = walk(COMMANDS["eval tipper.fz"][0])
    files = len({file for file, _ in found})
    print(f"{files} files, {found.total()} calls  fuzzyctl eval tipper.fz (limits {MOST_FILES}, {MOST_CALLS})")
    if files > MOST_FILES or found.total() > MOST_CALLS:
        above.append("files or calls")
    print(f"{len(above)} above the limit: {', '.join(above) or 'none'}")
    return 1 if above else 0


if __name__ == "__main__":
    sys.exit(main())
