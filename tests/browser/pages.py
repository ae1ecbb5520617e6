"""Writes pages of the shipped files and of hostile names to a folder, with what kernels give at 40 points of each."""

from __future__ import annotations

import json
import random
import sys
from pathlib import Path

from click.testing import CliRunner

from fuzzyctl import compile, load, loads
from fuzzyctl.cli.main import main
from fuzzyctl.support.shipped import rules_folder

#: Nine inputs, names that would be markup, an output that has no value and one that may be infinite.
HOSTILE = """system bad "</script><script>console.error(1)</script> <!-- & <b>"
source "'><img src=x onerror=console.error(2)> \u202e evil"
allow FZ208
defuzzifier center_average
{inputs}
output u "<svg onload=console.error(3)>" in [-1, 1] else nan
  p = constant(-1)
  q = constant(1)
output v in [-1e9, 1e9] = 1 / (x0 - 0.5)
if x0 is lo and x1 is lo then u is p
if x0 is hi and x1 is hi then u is q
"""
INPUTS = "\n".join(f'input x{k} "\'><img src=x onerror=console.error({k})>" in [0, 1]\n  terms lo hi' for k in range(9))


def points(system, count=40):
    drawn = random.Random(5)
    ends = [(system.number(i.lower), system.number(i.upper)) for i in system.inputs]
    return [[a + (b - a) * drawn.uniform(-0.1, 1.1) for a, b in ends] for _ in range(count)]


def expected(system):
    """Return points with the kernel's outputs; none for a system whose outputs are held from point to point."""
    kernel = compile(system, backend="python")
    if kernel.plan.held:
        return []
    state = [kernel.initial_state()] if kernel.plan.initial_state else []
    found = []
    for point in points(system):
        outputs = kernel(*point, *state)
        found.append([point, list(outputs) if isinstance(outputs, tuple) else [outputs]])
    return found


def write(folder: Path) -> None:
    (folder / "hostile.fz").write_text(HOSTILE.format(inputs=INPUTS), encoding="utf-8")
    sources = [*sorted(rules_folder().rglob("*.fz")), folder / "hostile.fz"]
    asked = {}
    for source in sources:
        page = folder / f"{source.stem}.html"
        done = CliRunner().invoke(main, ["page", str(source), "-o", str(page)])
        assert done.exit_code == 0, done.output
        text = source.read_text(encoding="utf-8")
        if "\nsystem " in "\n" + text:
            system = loads(text) if source.parent == folder else load(source)
            asked[page.name] = expected(system)
        else:
            asked[page.name] = []
    (folder / "expected.json").write_text(json.dumps(asked), encoding="utf-8")


if __name__ == "__main__":
    write(Path(sys.argv[1]))
