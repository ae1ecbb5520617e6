"""Print what an evaluation costs under node, beside generated C, and how far functions of node are from those of C.

    python tests/bench/javascript.py

Both are written by `fuzzyctl codegen` and run over the same points, one call after the other; gcc -O2 builds the C. Of
the functions the largest difference is printed in units in the last place (ulp), over points drawn where rule files
call them. Times are of this machine now.
"""

from __future__ import annotations

import json
import math
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Final

sys.path.insert(0, str(Path(__file__).parents[2]))

import numpy as np
from numpy.typing import NDArray

from fuzzyctl import loads
from fuzzyctl.codegen.files import generate
from fuzzyctl.codegen.prepare import prepare
from tests.bench.workloads import WORKLOADS, Workload

POINTS: Final = 20_000
ROUNDS: Final = 30

#: Calls the function at all points, some rounds; prints the best time of a call [ns], writes the outputs of the last.
_NODE = """import {{ readFileSync, writeFileSync }} from "node:fs";
import {{ {name} }} from "./{name}.mjs";
const bytes = readFileSync("points.bin");
const points = new Float64Array(bytes.buffer, bytes.byteOffset, bytes.length / 8);
const found = new Float64Array(points.length / 2);
let best = Infinity;
for (let round = 0; round < {rounds}; ++round) {{
    const begin = process.hrtime.bigint();
    for (let k = 0; k < found.length; ++k) {{
        found[k] = {name}(points[2 * k], points[2 * k + 1]);
    }}
    best = Math.min(best, Number(process.hrtime.bigint() - begin) / found.length);
}}
writeFileSync("node.bin", found);
console.log(best);
"""

_C = """#define _POSIX_C_SOURCE 199309L
#include "{name}.h"
#include <stdio.h>
#include <time.h>
static double points[2 * {count}], found[{count}];
int main(void)
{{
    double best = 1e300;
    FILE *file = fopen("points.bin", "rb");
    if (fread(points, sizeof points, 1, file) != 1)
        return 1;
    fclose(file);
    for (int round = 0; round < {rounds}; ++round) {{
        struct timespec begin, end;
        clock_gettime(CLOCK_MONOTONIC, &begin);
        for (int k = 0; k < {count}; ++k)
            found[k] = {name}(points[2 * k], points[2 * k + 1]);
        clock_gettime(CLOCK_MONOTONIC, &end);
        const double time = 1e9 * (double)(end.tv_sec - begin.tv_sec) + (double)(end.tv_nsec - begin.tv_nsec);
        best = time / {count} < best ? time / {count} : best;
    }}
    file = fopen("c.bin", "wb");
    fwrite(found, sizeof found, 1, file);
    fclose(file);
    printf("%.17g\\n", best);
    return 0;
}}
"""

#: Where rule files call functions: membership functions of points some widths away, powers of degrees, user's own.
_CALLS: Final[dict[str, tuple[Callable[..., float], list[tuple[float, float]]]]] = {
    "exp": (math.exp, [(-40.0, 5.0)]),
    "log": (math.log, [(1e-6, 100.0)]),
    "sin": (math.sin, [(-10.0, 10.0)]),
    "cos": (math.cos, [(-10.0, 10.0)]),
    "tan": (math.tan, [(-1.5, 1.5)]),
    "atan2": (math.atan2, [(-1.0, 1.0), (-1.0, 1.0)]),
    "pow": (math.pow, [(1e-3, 10.0), (-6.0, 6.0)]),
    "sqrt": (math.sqrt, [(0.0, 100.0)]),
}

_FUNCTIONS = """import { readFileSync } from "node:fs";
const calls = JSON.parse(readFileSync("calls.json", "utf8"));
console.log(JSON.stringify(calls.map(([name, rows]) => rows.map((row) => Math[name](...row)))));
"""


def costs(workload: Workload, count: int = POINTS, rounds: int = ROUNDS) -> dict[str, float]:
    """Return nanoseconds of a call in C and under node, and the largest difference of their outputs."""
    unit = prepare(loads(workload.text), workload.text)
    with tempfile.TemporaryDirectory() as own:
        folder = Path(own)
        workload.points(count).tofile(folder / "points.bin")
        for target in ("c", "javascript"):
            for file, text in generate(unit, target).files.items():
                (folder / file).write_text(text, encoding="utf-8")
        name = unit.system.name
        (folder / "main.c").write_text(_C.format(name=name, count=count, rounds=rounds), encoding="utf-8")
        (folder / "main.mjs").write_text(_NODE.format(name=name, rounds=rounds), encoding="utf-8")
        command = ["gcc", "-O2", "-std=c99", "main.c", f"{name}.c", "-o", "main", "-lm"]
        subprocess.run(command, check=True, cwd=folder)
        found = {"C": _printed(["./main"], folder), "node": _printed(["node", "main.mjs"], folder)}
        outputs: list[NDArray[np.float64]] = [np.fromfile(folder / f"{which}.bin") for which in ("c", "node")]
    return found | {"difference": float(np.max(np.abs(outputs[0] - outputs[1])))}


def _printed(command: list[str], folder: Path) -> float:
    return float(subprocess.run(command, check=True, cwd=folder, capture_output=True, text=True).stdout)


def differences(count: int = 100_000) -> dict[str, float]:
    """Return by function the largest difference between node and C [ulp]."""
    rng = np.random.default_rng(1)
    drawn = {
        name: np.stack([rng.uniform(*ends, count) for ends in ranges], axis=1).tolist()
        for name, (_, ranges) in _CALLS.items()
    }
    with tempfile.TemporaryDirectory() as own:
        folder = Path(own)
        (folder / "calls.json").write_text(json.dumps(list(drawn.items())), encoding="utf-8")
        (folder / "functions.mjs").write_text(_FUNCTIONS, encoding="utf-8")
        done = subprocess.run(["node", "functions.mjs"], check=True, cwd=folder, capture_output=True, text=True)
    largest = {}
    for (name, rows), found in zip(drawn.items(), json.loads(done.stdout), strict=True):
        function = _CALLS[name][0]
        wanted = [function(*row) for row in rows]
        largest[name] = max(abs(a - b) / math.ulp(b) for a, b in zip(found, wanted, strict=True))
    return largest


def main() -> None:
    """Measure and print."""
    missing = [tool for tool in ("gcc", "node") if shutil.which(tool) is None]
    if missing:
        sys.exit(f"needs {' and '.join(missing)}")
    print("| | C, gcc -O2 [ns] | node [ns] | node [million calls/s] | largest difference |\n|---|---|---|---|---|")
    for workload in WORKLOADS:
        found = costs(workload)
        numbers = f"{found['C']:.1f} | {found['node']:.1f} | {1e3 / found['node']:.0f} | {found['difference']:.1e}"
        print(f"| {workload.name}, {workload.what} | {numbers} |")
    print("\n| function | largest difference between node and C [ulp] |\n|---|---|")
    for name, ulps in differences().items():
        print(f"| {name} | {ulps:.0f} |")


if __name__ == "__main__":
    main()
