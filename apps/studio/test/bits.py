"""Numbers of the systems below folders, bit for bit, as one text: the same program for CPython and for Pyodide."""

import json
import random
import re
import sys
from pathlib import Path

from fuzzyctl.diagnostics.diagnostic import NoRuleFiresError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.kernels.compile import compile
from fuzzyctl.loading.load import look_through

#: Functions whose last bit is the C library's.
TRANSCENDENTAL = re.compile(r"\b(exp|log|power|sin|cos|tan)\(")
#: Points along each axis of a surface, and points anywhere, some of them outside of the ranges.
SIDE = 41
ANYWHERE = 200


def points(ends):
    """Return the points of a surface over the first two inputs, and some anywhere."""
    drawn = random.Random(20)
    axes = [[a + (b - a) * k / (SIDE - 1) for k in range(SIDE)] for a, b in ends[:2]]
    middle = [0.5 * a + 0.5 * b for a, b in ends[2:]]
    surface = [[x, *rest, *middle] for x in axes[0] for rest in ([[y] for y in axes[1]] if len(axes) > 1 else [[]])]
    return surface + [[a + (b - a) * drawn.uniform(-0.1, 1.1) for a, b in ends] for _ in range(ANYWHERE)]


def evaluated(kernel, point):
    """Return the outputs at a point, in hexadecimal; the output for which no rule fires."""
    try:
        found = kernel(*point)
    except NoRuleFiresError as error:
        return [error.output]
    return [value.hex() for value in (found if isinstance(found, tuple) else (found,))]


def numbers(folders):
    """Return points, the outputs there, and whether no transcendental function computes them, of each system."""
    found = {}
    for path in sorted(p for folder in folders for p in Path(folder).rglob("*.fz")):
        text = path.read_text(encoding="utf-8")
        for system in look_through(SourceText(str(path), text), folder=path.parent).systems:
            kernel = compile(system, backend="python")
            if kernel.plan.initial_state:
                continue  # states are arrays of numpy, which Pyodide lacks
            at = points([(system.number(i.lower), system.number(i.upper)) for i in system.inputs])
            exact = TRANSCENDENTAL.search(kernel.source) is None
            values = [evaluated(kernel, point) for point in at]
            found[f"{path.name} {system.name}"] = {"exact": exact, "points": at, "values": values}
    return json.dumps(found)


if __name__ == "__main__":
    print(numbers(sys.argv[1:]))
