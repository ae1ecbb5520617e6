"""Writes pages to a folder: of the shipped files, of hostile ones, and of the robots; with numbers of kernels."""

from __future__ import annotations

import json
import random
import re
import sys
from pathlib import Path

from click.testing import CliRunner

from dwmr.cli.main import main as robots
from fuzzyctl import compile, load
from fuzzyctl.testing import run_command

#: The shipped rule files.
RULES = Path(__file__).parents[2] / "rules"

#: Nine inputs, names that would be markup, an output that has no value and one that may be infinite.
HOSTILE = """system bad "</script><script>console.error(1)</script> <!-- & <b>"
source "'><img src=x onerror=console.error(2)> \u202e evil"
allow FZ208
defuzzifier center_average
{inputs}
output u "<svg onload=console.error(3)>" in [-1, 1] else nan
  p_with_a_name_that_is_as_long_as_no_line_of_a_phone_and_goes_on_and_on = constant(-1)
  q = constant(1)
output v in [-1e9, 1e9] = 1 / (x0 - 0.5)
if x0 is lo and x1 is lo then u is p_with_a_name_that_is_as_long_as_no_line_of_a_phone_and_goes_on_and_on
if x0 is hi and x1 is hi then u is q
"""
INPUTS = "\n".join(f'input x{k} "\'><img src=x onerror=console.error({k})>" in [0, 1]\n  terms lo hi' for k in range(9))
#: Adaptive integrals, in a system and in the steps of a controller.
CURVED = """system curved
input x in [0, 1]
  terms low high
output u in [0, 1]
  a = gaussian(0.2, 0.1)
  b = bell(0.8, 0.1, 3)
if x is low then u is a
if x is high then u is b

controller law
input e in [0, 1]
output y = previous(y) / 2 + curved(e)
every 0.1 s
"""
#: No value in the middle, neither of the system nor of the controller, and a warning of that.
GAP = """system gap
input x in [0, 10]
  lo = triangle(0, 1, 3)
  hi = triangle(7, 9, 10)
output u in [0, 1] else error
  terms lo hi
if x is lo then u is lo
if x is hi then u is hi

controller law
input e in [0, 10]
output y = gap(e) + previous(y)
every 0.1 s
"""
#: Two systems and two controllers in four loops, systems called more than once.
MANY_BLOCKS = Path(__file__).parents[2] / "apps/gallery/mudi_pal_1999/mudi_pal_1999.fz"
POINTS = 40


def expected(source: Path, section: dict) -> list:
    """Return points of a block with the kernel's outputs, for a controller step by step; none for a loop."""
    if source.stem == "gap":  # where most points have no value
        return []
    drawn = random.Random(5)
    ends = [(_end(i["lower"], -10.0), _end(i["upper"], 10.0)) for i in section.get("inputs", ()) if "lower" in i]
    points = [[a + (b - a) * drawn.uniform(-0.1, 1.1) for a, b in ends] for _ in range(POINTS)]
    if section["kind"] == "controller":
        step = compile(load(source, block=section["name"]), backend="python")
        time = {} if section["period"] else {"dt": 0.01}
        state, found = step.start(), []
        for point in points:
            outputs, state = step(*point, state, **time)
            found.append([[*point, *time.values()], outputs])
    elif section["kind"] == "system":
        kernel = compile(load(source, block=section["name"]), backend="python")
        if kernel.plan.held:  # which go from point to point
            return []
        state = [kernel.start()] if kernel.plan.initial_state else []
        found = [[point, kernel(*point, *state)] for point in points]
    else:
        return []
    return [[point, list(own) if isinstance(own, tuple) else [own]] for point, own in found]


def _end(end: float | None, other: float) -> float:
    return other if end is None else end


def write(folder: Path) -> None:
    (folder / "hostile.fz").write_text(HOSTILE.format(inputs=INPUTS), encoding="utf-8")
    (folder / "curved.fz").write_text(CURVED, encoding="utf-8")
    (folder / "gap.fz").write_text(GAP, encoding="utf-8")
    own = [folder / f"{name}.fz" for name in ("hostile", "curved", "gap")]
    sources = [*sorted(RULES.rglob("*.fz")), MANY_BLOCKS, *own]
    asked = {}
    for source in sources:
        page = folder / f"{source.stem}.html"
        done = run_command("page", source, "-o", page)
        assert done.exit_code == 0, done.errors
        facts = re.search(r'id="facts">(.*?)</script>', page.read_text(encoding="utf-8"), flags=re.DOTALL)
        asked[page.name] = [expected(source, section) for section in json.loads(facts[1])["sections"]]
    report = folder / "report.html"
    done = CliRunner().invoke(
        robots, ["report", "paper", "--controller", "aifqsmc,smc", "--set", "run.horizon=2", "-o", str(report)]
    )
    assert done.exit_code == 0, done.output
    asked[report.name] = []
    (folder / "expected.json").write_text(json.dumps(asked), encoding="utf-8")


if __name__ == "__main__":
    write(Path(sys.argv[1]))
