"""Print what an evaluation costs, beside hand-written C and fuzzylite's C++ engine, all measured in this run.

    python tests/bench/table.py [--include DIR --library DIR] [--peers] [--json FILE]

gcc builds the C; fuzzylite's engine is measured where its headers and library are found (Debian: libfuzzylite-dev), or
in the folders given; `--peers` installs pyfuzzylite, scikit-fuzzy and simpful for the length of the run. Times are of
this machine now; the ratios are the result.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.bench.measure import everything
from tests.bench.peers import PEERS
from tests.bench.workloads import WORKLOADS

#: Rows, and the row that each is set against.
ROWS = {
    "fuzzylite": "",
    "C, points": "",
    "C, waiting": "",
    "C, batch": "",
    "call, no compiler": "fuzzylite",
    "call, compiled": "fuzzylite",
    "call by name": "fuzzylite",
    "text to callable": "",
    "loop, compiled": "C, points",
    "loop, each waits": "C, waiting",
    "batch, compiled": "C, batch",
    "batch, all cores": "batch, compiled",
    "batch, numpy": "fuzzylite",
}

#: Rows that are there only if they are asked for.
PEER_ROWS = dict.fromkeys(PEERS, "fuzzylite")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--include", default="", help="folder of fuzzylite's headers")
    parser.add_argument("--library", default="", help="folder of fuzzylite's library")
    parser.add_argument("--peers", action="store_true", help="install and measure other Python tools, too")
    parser.add_argument("--json", default="", help="file to write the numbers to")
    arguments = parser.parse_args()
    times = everything(arguments.include, arguments.library, with_peers=arguments.peers)
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(times, indent=2) + "\n", encoding="utf-8")
    print(rendered(times))


def rendered(times: dict[str, dict[str, float]]) -> str:
    """Return a Markdown table: nanoseconds, and in brackets the ratio to what the row is set against."""
    names = [w.name for w in WORKLOADS]
    lines = [f"| ns per evaluation | {' | '.join(names)} | in brackets |", f"|---|{'---|' * len(names)}---|"]
    for row, against in (ROWS | PEER_ROWS).items():
        cells = [_cell(times[n], row, against) for n in names]
        if any(cells):
            lines.append(f"| {row} | {' | '.join(cells)} | {f'times {against!r}' if against else ''} |")
    lines += ["", *(f"{w.name}: {w.what}" for w in WORKLOADS)]
    return "\n".join(lines)


def _cell(times: dict[str, float], row: str, against: str) -> str:
    if row not in times:
        return ""
    value = f"{times[row]:.3g}" if times[row] < 100 else f"{times[row]:.0f}"
    return f"{value} ({times[row] / times[against]:.2g})" if against in times else value


if __name__ == "__main__":
    main()
