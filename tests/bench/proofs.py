"""How long proofs take: the shipped guarantees, and bounds to 1 % of a seven by seven rule base.

python tests/bench/proofs.py
"""

import time
from pathlib import Path

from fuzzyctl import load, loads, prove
from fuzzyctl.analysis.extremes import _BySubdivision
from fuzzyctl.analysis.witnesses import Judge
from fuzzyctl.kernels.plan.build import plan
from tests import shipped

RULES = Path(__file__).resolve().parents[2] / "rules"
NAMES = ["NB", "NM", "NS", "ZO", "PS", "PM", "PB"]


def seven_by_seven(method: str, terms: str) -> str:
    """A rule base as controllers have it, without the symmetry that would make bounds trivial."""
    rows = "\n".join(
        f"  {r} | {' '.join(NAMES[min(6, max(0, i + j - 3))] for j in range(7))}" for i, r in enumerate(NAMES)
    )
    inputs = "".join(f"input {n} in [-3, 3]\n{terms}\n" for n in ("e", "de"))
    table = f"table u = e x de\n  {' '.join(NAMES)}\n{rows}\n"
    return f"system pd\n{method}\n{inputs}output u in [-3, 3]\n{{outputs}}\n{table}"


GAUSSIANS = "\n".join(f"  {n} = gaussian({k - 3}, 0.5)" for k, n in enumerate(NAMES))
SUGENO = seven_by_seven("and product\ndefuzzifier weighted_average", GAUSSIANS).format(
    outputs="\n".join(f"  {n} = linear({0.2 + 0.1 * k}, {0.5 - 0.1 * k}, {k - 3})" for k, n in enumerate(NAMES))
)
MAMDANI = seven_by_seven("and min\ndefuzzifier centroid", "  terms " + " ".join(NAMES)).format(
    outputs="  terms " + " ".join(NAMES)
)


def to_one_percent(text: str) -> tuple[float, float, float, float]:
    """Return the seconds for both ends of the output, the bounds, and the larger part of what is attained left open."""
    system = loads(text)
    begun = time.perf_counter()
    finder = _BySubdivision(system, plan(system), 60.0, Judge(system))
    ends = [finder.least(0, sign) for sign in (1, -1)]
    seconds = time.perf_counter() - begun
    found = [finder.judge.outputs(point)["u"] for _, point in ends if point is not None]
    gap = max(abs(bound - value) for (bound, _), value in zip(ends, found, strict=True))
    return seconds, ends[0][0], ends[1][0], gap / (found[1] - found[0])


def main() -> None:
    """Measure and print."""
    systems = [load(path) for path in shipped.SYSTEMS]
    for system in systems:
        prove(system)
    begun = time.process_time()
    count = sum(len(prove(system)) for system in systems)
    print(f"shipped guarantees: {count} in {time.process_time() - begun:.3f} s")
    for name, text in (("7x7 Gaussian Sugeno", SUGENO), ("7x7 Mamdani min/max/centroid", MAMDANI)):
        seconds, low, high, gap = to_one_percent(text)
        print(f"{name}: [{low:.5g}, {high:.5g}] in {seconds:.2f} s, {gap:.2%} of what is attained is open")


if __name__ == "__main__":
    main()
