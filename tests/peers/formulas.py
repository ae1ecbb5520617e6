"""Store what fuzzylite and pyfuzzylite compute of formulas: of each operator and function, and of drawn compositions.

    python tests/peers/formulas.py

asks the engines that `environments.py` has made and writes tests/peers/vectors/PEER_formulas.json. Formulas on which an
engine differs on purpose from its profile, such as sums of truths, are left out; `known_bugs.py` has those.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from random import Random

sys.path.insert(0, str(Path(__file__).parents[2]))

import numpy as np

import fuzzyctl
from tests.peers.catalogue import PEERS, Peer
from tests.peers.comparing import Case, outputs_of_peer

VECTORS = Path(__file__).parent / "vectors"
#: Numbers halfway between whole ones, whole ones, others, and 0.
POINTS = ((0.0, 0.0), (1.0, 2.0), (2.5, -1.0), (-1.5, 2.0), (-2.5, -0.75), (0.5, 0.3), (7.25, 1.0))
COMPARISONS = ("lt", "le", "gt", "ge", "eq", "neq")
ONE = (
    "acos",
    "asin",
    "atan",
    "ceil",
    "cos",
    "cosh",
    "exp",
    "abs",
    "fabs",
    "floor",
    "log",
    "log10",
    "round",
    "sin",
    "sinh",
)
ONE += ("sqrt", "tan", "tanh", "log1p", "acosh", "asinh", "atanh")
TWO = (*COMPARISONS, "min", "max", "pow", "atan2", "fmod")
FIXED = (
    *(f"{f}(a)" for f in ONE),
    *(f"{f}(a, b)" for f in TWO),
    *("a + b", "a - b - 1", "a * b", "a / b / 2", "a % b", "a % 3 * b", "2 ^ a ^ 0.5", "~a ^ 2", "!a", "!a * 2"),
    *("a and b", "a or b", "1 or a and b", "!(a - b)", "!lt(a, b)", "lt(a, b) and gt(b, 1) or a", "1 + 0 and b"),
)
#: Those that only pyfuzzylite reads.
PYTHON = ("a ** b", ".-a ^ 2", ".+a", "pi * a")
HEAD = """Engine: formulas
InputVariable: a
  enabled: true
  range: -10 10
  lock-range: false
  term: any Constant 1
InputVariable: b
  enabled: true
  range: -10 10
  lock-range: false
  term: any Constant 1
"""
OUTPUT = """OutputVariable: u{k}
  enabled: true
  range: -10 10
  lock-range: false
  aggregation: none
  defuzzifier: WeightedAverage TakagiSugeno
  default: nan
  lock-previous: false
  term: f Function {formula}
"""
#: Sets of an output as formulas, below 0 beyond their feet, where the union with others holds them at 0.
SETS = """Engine: sets
InputVariable: a
  enabled: true
  range: -10 10
  lock-range: true
  term: low Ramp 5 -5
  term: high Ramp -5 5
InputVariable: b
  enabled: true
  range: -10 10
  lock-range: true
  term: low Ramp 2 0
OutputVariable: u
  enabled: true
  range: 0 4
  lock-range: false
  aggregation: Maximum
  defuzzifier: {defuzzifier}
  default: nan
  lock-previous: false
  term: left Function lt(x, 1) * x + ge(x, 1) * (2.5 - x) / 1.5
  term: right Function gt(x, 2) * le(x, 3) * (x - 2) + gt(x, 3) * (lt(x, 3.2) or gt(x, 3.5))
  term: steps Function floor(x) / 5
RuleBlock: all
  enabled: true
  conjunction: none
  disjunction: none
  implication: {implication}
  activation: General
  rule: if a is low then u is left
  rule: if a is high then u is right
  rule: if b is low then u is steps
"""
BLOCK = """RuleBlock: all
  enabled: true
  conjunction: none
  disjunction: none
  implication: none
  activation: General
  rule: if a is any then {consequents}
"""


def main() -> None:
    """Store the vectors of the engines that are installed."""
    for name, profile in (("fuzzylite", "fuzzylite"), ("pyfuzzylite", "pyfuzzylite")):
        peer = PEERS[name]
        if peer.command() is None:
            print(f"{name}: not installed; run: python tests/peers/environments.py --peer {name}")
            continue
        random = Random(8)
        formulas = [*FIXED, *(PYTHON if name == "pyfuzzylite" else ()), *(drawn(random, 4) for _ in range(60))]
        text = file_of(formulas, profile)
        cases = [case(text, measured(peer, text, len(formulas)))]
        for defuzzifier, implication in (("Centroid 100", "Minimum"), ("Centroid 75", "AlgebraicProduct")):
            text = f"# numerics of {profile}\n{SETS.format(defuzzifier=defuzzifier, implication=implication)}"
            cases.append(case(text, measured(peer, text, 1)))
        described = {"peer": name, "version": peer.version, "profile": profile, "cases": cases}
        path = VECTORS / f"{name}_formulas.json"
        path.write_text(json.dumps(described, indent=0) + "\n")
        print(f"{path.name}: {len(formulas)} formulas, {path.stat().st_size:,} bytes")


def drawn(random: Random, depth: int) -> str:
    """Return a formula: truths are operands of logic and factors, never of sums."""
    if depth == 0:
        return random.choice(("a", "b", "0.5", "2"))
    x, y = (drawn(random, random.randrange(depth)) for _ in range(2))
    truth = f"{random.choice(COMPARISONS)}({x}, {y})"
    if random.random() < 0.3:
        truth = f"({truth} {random.choice(('and', 'or'))} !gt({y}, {x}))"
    return random.choice(
        (
            f"({x} {random.choice('+-*/')} {y})",
            f"{random.choice(('floor', 'ceil', 'abs', 'atan', 'tanh'))}({x})",
            f"fmod({x}, {y})",
            f"(1 * {truth}) * {x}",
            f"{truth} * {y} + !{truth} * {x}",
        )
    )


def file_of(formulas: list[str], profile: str) -> str:
    """Return the formulas as consequents of one rule that always acts."""
    outputs = "".join(OUTPUT.format(k=k, formula=f) for k, f in enumerate(formulas))
    rule = " and ".join(f"u{k} is f" for k in range(len(formulas)))
    return f"# numerics of {profile}\n{HEAD}{outputs}{BLOCK.format(consequents=rule)}"


def measured(peer: Peer, text: str, width: int) -> np.ndarray:
    """Return what the peer computes."""
    system = fuzzyctl.loads(text, "formulas.fll")
    found = outputs_of_peer(peer, [Case("formulas", system, text, [list(p) for p in POINTS])])["formulas"]
    assert isinstance(found, np.ndarray), found
    assert found.shape == (len(POINTS), width)
    return found


def case(text: str, theirs: np.ndarray) -> dict:
    """Return a case as `store.py` writes it, after a look at what differs here."""
    system = fuzzyctl.loads(text, "formulas.fll")
    ours = fuzzyctl.compile(system, backend="numpy").batch(np.array(POINTS)).reshape(theirs.shape)
    for row, k in zip(*np.nonzero(~np.isclose(ours, theirs, rtol=1e-9, atol=1e-9, equal_nan=True)), strict=True):
        formula = [line for line in text.splitlines() if "Function" in line][k]
        print(f"{formula.strip()} at {POINTS[row]}: {theirs[row, k]}, here {ours[row, k]}")
    return {
        "suffix": ".fll",
        "text": text.splitlines(),
        "points": [" ".join(map(repr, p)) for p in POINTS],
        "outputs": [" ".join(map(repr, row)) for row in theirs.tolist()],
    }


if __name__ == "__main__":
    main()
