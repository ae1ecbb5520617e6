"""Each way in which the sets could be too small breaks a test."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[3]

#: What is broken, its module, a text of it and what takes its place, and the tests that find it.
MUTANTS = {
    "a polynomial has no remainder": (
        "flow", "scaled(hulled(rest), step ** len(coefficients)) if", "0.0 if", "flow"),
    "the remainder is that of the begin": (
        "flow",
        "series = Series(self.nodes, [clock, *tube, *fixed])",
        "series = Series(self.nodes, [clock, *start, *fixed])",
        "flow"),
    "a tube is not checked": (
        "flow", "if all(_holds(a, b)", "if attempt or all(_holds(a, b)", "flow"),
    "a tube is that of a shorter step": (
        "flow", "low + np.minimum(change[0], 0.0)", "low + np.minimum(0.5 * change[0], 0.0)", "flow"),
    "time does not pass within a step": (
        "flow", "[1.0 if k == 1 else 0.0,", "[0.0,", "flow"),
    "a step has one time": (
        "flow",
        "interval(np.array([time]), np.array([time + step]))",
        "interval(np.array([time]), np.array([time]))",
        "flow"),
    "half of what a disturbance does": (
        "flow", "return np.asarray(total * (1.0 + 1e-12)", "return np.asarray(total * 0.5", "flow"),
    "a disturbance does not spread": (
        "flow", "growth = largest[:, :n].copy()", "growth = 0.0 * largest[:, :n]", "flow"),
    "the slope over a step has no width": (
        "flow", "total[..., 1] += forms.radius(slope)", "total[..., 1] += 0.0", "flow"),
    "a sine has no top": (
        "forms", "np.where(top | wide, 1.0,", "np.where(wide, 1.0,", "forms"),
    "a secant has no error": (
        "forms", "error = 0.5 * (above - below) +", "error = 0.0 * (above - below) +", "forms"),
    "a maximum has no gap": (
        "forms", "-share * low) * (1.0 + _SUM), 0.0)", "-share * low) * 0.0, 0.0)", "forms"),
    "a product is linear": (
        "forms", "np.maximum(ra * rb - 0.5 * np.add.reduce(both, -1), 0.0)", "0.0 * ra", "forms"),
    "squares lie in the middle": (
        "forms",
        "np.maximum(ra * rb - 0.5 * np.add.reduce(both, -1), 0.0)",
        "np.maximum(ra * rb - np.add.reduce(both, -1), 0.0)",
        "forms"),
    "sums do not round": (
        "forms", "_SUM: Final = 8 * 2.0**-53", "_SUM: Final = 0.0", "forms"),
    "a root has half its error": (
        "forms", "0.5 * above * (1.0 + 1e-12) +", "0.25 * above +", "forms"),
    "a choice forgets errors": (
        "forms", "either[..., 1] += 0.5 * np.abs(first[..., 1] - second[..., 1])", "either[..., 1] += 0.0", "forms"),
    "constants do not round": (
        "forms", "            return near(total)", "            return total", "forms"),
    "a jump is not seen": (
        "series", '(node.kind == "compare" and not _decided(table[at][0]))', "False", "series flow"),
    "a bend is not seen": (
        "series", "if not _decided((yes, no)) and not (", "if False and not (", "series"),
    "a bend takes its own side": (
        "series", "    if whole is None:\n        return own", "    return own", "series"),
    "a plane has no error": (
        "surfaces", "error[box] = 0.5 * (best[1] - best[0]) +", "error[box] = 0.0 * (best[1] - best[0]) +", "surfaces"),
    "a plane is not cut at knots": (
        "surfaces",
        "y = np.concatenate([low[:, None], y, high[:, None]], 1)",
        "y = np.stack([low, high], 1)",
        "surfaces"),
    "corners of a slab are missed": (
        "surfaces",
        "return np.where((begin <= lowest[0]) & (lowest[0] <= end), lowest[1], at_side)",
        "return at_side",
        "surfaces"),
    "a system always has a value": (
        "surfaces", "full = ~np.broadcast_to(gaps, 2 * count)[:count]", "full = np.ones(count, bool)", "surfaces"),
    "slopes are those at the centre": (
        "surfaces", "np.where(reach > 0.0, steep * reach, 0.0).sum(0) + off", "off", "surfaces"),
    "parts are left out whose middle is not in the set": (
        "surfaces", "np.abs(middle) <= (reach + half) * (1.0 + _ASIDE)", "np.abs(middle) <= reach", "surfaces"),
    "a jump has the slope of its sides": (
        "surfaces", "least = np.fmax(ends_of_rest[0],", "least = np.fmax(height,", "surfaces"),
    "parts end before the end of a set": (
        "surfaces", "[np.unique(a) for a in axes]", "[np.unique(a)[:-1] for a in axes]", "surfaces"),
    "a value that ends at 0 is 0": (
        "kernels.interval.program",
        "not (np.any(enclosure.lo) or np.any(enclosure.hi))",
        "not np.any(enclosure.lo)",
        "surfaces"),
    "inputs of integers are not rounded": (
        "simulation.equations", 'limited + Name(f"{signal}#error")', "limited", "integers"),
    "integers have the outputs of numbers": (
        "simulation.equations", 'Name(signal) + Name(f"{signal}#error")', "Name(signal)", "integers"),
    "errors and noise are half of what they are": (
        "reach", "[np.array([[0.0, e]]) for e in", "[np.array([[0.0, 0.5 * e]]) for e in", "integers"),
    "generators are dropped": (
        "sets", "new[k, :, k] = errors[k]", "new[k, :, k] = 0.0", "sets"),
    "a box is as long as its longest": (
        "sets", "lengths = np.abs(inside).sum(1)", "lengths = np.abs(inside).max(1)", "sets"),
    "a set that is a little wider lies inside": (
        "sets", "<= 1.0 - wrong", "<= 1.1 - wrong", "sets prover"),
    "what stays does not count": (
        "sets", "stacked[:, 2 : 2 + width] - self.kept]", "0.0 * self.kept]", "sets"),
    "a slow controller runs always": (
        "reach", "1.0 if k % n == 0 else 0.0", "1.0", "reach"),
    "memory stays": (
        "reach", "for u in map(as_form, updates)]", "for u in m]", "reach"),
    "the last step of a claim is missed": (
        "prover", "replace(equations, samples=equations.samples + 1)", "equations", "prover"),
    "a claim is not examined in a ball": (
        "prover", "return not during[0][0][1]", "return True", "prover"),
    "states may leave their ranges": (
        "prover", "outside = ~within(state, low, high)", "outside = np.zeros(1, bool)", "prover"),
    "an input acts as in the mean of a period": (
        "reach",
        "return _series(a, as_form(forms.scaled(b, length)), length, 2)",
        "return _product(_series(a, np.eye(len(a))[..., None] * [length, 0.0], length, 2), b)",
        "stability"),
    "a series ends": (
        "reach", "rest[..., 1] += 2.0 * last", "rest[..., 1] += 0.0 * last", "stability"),
    "vertices have no width": (
        "stability", "spread = exact @ slopes[..., 1]", "spread = 0.0 * exact @ slopes[..., 1]", "stability"),
    "a bound is what is proposed": (
        "stability",
        "return float(q) + apart + 1e-15 if is_positive_definite(",
        "return float(q) * 0.99 + apart if is_positive_definite(",
        "stability"),
    "a ball may leave the range of a state": (
        "reach", "if not (state.holds(low) and state.holds(high)):", "if False:", "stability"),
    "a bend has one slope": (
        "slopes", "return np.concatenate([_row(*first), _row(*second)])", "return _row(*first)", "stability"),
    "the narrowest cells do not count": (
        "surfaces", "(np.append(k, np.inf) >= low)", "(np.append(k, np.inf) >= low + 2e-7)", "stability"),
    "weights are those of the first rules": (
        "slopes", "mean = parts.mean(0)", "mean = parts[0].copy()", "stability"),
    "a limit is reached less than it is": (
        "slopes", "share = min(share * (1.0 + 1e-12), 1.0)", "share = min(share * 0.9, 1.0)", "stability"),
    "a sine is steeper than its chord": (
        "slopes", "math.sin(most) / most * (1.0 - 1e-12)", "math.sin(most) / most * 1.05", "stability"),
    "a sector ends at the ends of a range": (
        "surfaces", "[low, *k[(k > low) & (k < high)], high]", "[low, high]", "stability"),
    "a ball stays, wherever its centre moves": (
        "stability", "needed = drift / (limit - total)", "needed = 0.0 * drift / (limit - total)", "stability"),
    "the second sample of a cycle is the first": (
        "stability", "return period_slopes(self.sets, box, self.free, about, phase,",
        "return period_slopes(self.sets, box, self.free, about, 0,", "stability_rates"),
    "a ball is smaller than the image of the one before": (
        "stability", "(rate * a + drifts[k]) * (1.0 + 1e-12) for a in (size, near)",
        "0.1 * rate * a + drifts[k] for a in (size, near)", "stability_rates"),
    "consequents adapt where their rules do not fire": (
        "simulation.equations", "replace_names(output.rate, inputs) * share", "replace_names(output.rate, inputs)",
        "adaptive"),
    "a consequent leaves the range of its output": (
        "simulation.equations",
        'Call("clip", (moved, Number(output.lower), Number(output.upper)))',
        "moved",
        "adaptive"),
    "an adaptive output has no value where no rule fires": (
        "simulation.equations", "fixed = replace(output, adaptive=None, terms=terms)",
        "fixed = replace(output, adaptive=None, terms=terms, otherwise=ZERO)", "adaptive"),
}  # fmt: skip


def place(module):
    """Return the module of a mutant within the package; those of this room have a single name."""
    return module if "." in module else f"analysis.reach.{module}"


@pytest.mark.long
@pytest.mark.parametrize("name", MUTANTS)
def test_a_set_that_is_too_small_is_found(name):
    module, old, new, files = MUTANTS[name]
    mutant = json.dumps([f"fuzzyctl.{place(module)}", old, new])
    tests = [str(HERE / f"test_{f}.py") for f in files.split()]
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-p",
        "tests.fuzzyctl.analysis.reach.mutant",
        "-n",
        "0",
        "-q",
        "-x",
        *tests,
    ]
    done = subprocess.run(
        command,
        cwd=ROOT,
        env=os.environ | {"FUZZYCTL_REACH_MUTANT": mutant},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1, done.stdout[-2000:] + done.stderr[-2000:]
    assert "places in" not in done.stdout + done.stderr


def test_each_mutant_has_its_place():
    for module, old, _, _ in MUTANTS.values():
        path = ROOT.joinpath("fuzzyctl", *place(module).split("."))
        assert path.with_suffix(".py").read_text(encoding="utf-8").count(old) == 1, old
