"""Start-up: processor time of short commands beside that of importing the libraries that they need.

    python tests/bench/startup.py

Prints seconds of processor time (the least of --runs, with bytecode cached) and ratios: `check` and `eval` beside
`from pydantic import BaseModel; import click`, `--help` and `--version` beside `import click`. Exit code 1 where a
ratio is above its limit.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path

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


def seconds(code, arguments, runs):
    """Return the least processor time of some runs of a program [s]."""
    found = []
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    nothing = subprocess.DEVNULL
    for _ in range(runs):
        process = subprocess.Popen(
            [sys.executable, "-c", code, *arguments], stdout=nothing, stderr=nothing, env=environment
        )
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            sys.exit(f"{code} {arguments} ended with {process.returncode}")
        found.append(usage.ru_utime + usage.ru_stime)
    return min(found)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--runs", type=int, default=10)
    runs = parser.parse_args().runs
    libraries = {code: seconds(code, [], runs) for code in LIBRARIES}
    for code, took in libraries.items():
        print(f"{took:6.3f} s        {code}")
    above = []
    for name, (arguments, library) in COMMANDS.items():
        took = seconds(MAIN, arguments, runs)
        ratio = took / libraries[library]
        print(f"{took:6.3f} s  {ratio:4.2f}  fuzzyctl {name} (limit {LIBRARIES[library]})")
        if ratio > LIBRARIES[library]:
            above.append(name)
    print(f"{len(above)} above the limit: {', '.join(above) or 'none'}")
    return 1 if above else 0


if __name__ == "__main__":
    sys.exit(main())
