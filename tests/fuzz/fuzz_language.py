"""Throw texts at the language and watch for anything but a system or diagnostics.

    python tests/fuzz/fuzz_language.py --inputs 100000 --seed 1

Prints how many texts were tried, how many were systems, and the slowest; exit code 1 at the first uncaught exception,
whose text is kept in fuzz-failure.fz. Not part of the test suite, which throws fewer.
"""

import argparse
import random
import re
import sys
import time
from collections import Counter
from pathlib import Path

from mutating import mutated

from fuzzyctl import dumps, loads
from fuzzyctl.formulas import HEDGES, MEMBERSHIP
from fuzzyctl.testing import check_text, run_command

RULES = Path(__file__).parents[2] / "rules"
GOLDEN = Path(__file__).parents[1] / "golden"
GRAMMAR = (RULES.parent / "fuzzyctl" / "lang" / "grammar.lark").read_text(encoding="utf-8")
TOKEN = re.compile(r'"[^"\n]*"|[\d.]+(?:[eE][+-]?\d+)?|[^\W\d]\w*|<=|>=|==|!=|\n *|[^\s]')
WORDS = [
    *re.findall(r"^[A-Z_]+: /([a-z]+)", GRAMMAR, flags=re.MULTILINE),
    *MEMBERSHIP,
    *HEDGES,
    *"a b u x NB ZO PB 0 1 -1 0.5 1e-3 1e999 inf pi nan error".split(),
]
WORDS += "unless any".split()
WORDS += "in unit else adaptive rate extrapolate then is within when from linear function height midpoint min".split()
WORDS += ["\n", "\n", "\n", "\t", *'( ) [ ] , = | @ * / + - ^ < <= == . # " σ ½ ∞'.split()]


def soup(rng, _):
    """Tokens in no order."""
    return " ".join(rng.choices(WORDS, k=rng.randrange(1, 80)))


def noise(rng, _):
    """Bytes, decoded as a file would be."""
    return rng.randbytes(rng.randrange(200)).decode("latin-1")


def edited(rng, seeds):
    """A rule file with some tokens deleted, doubled, swapped, cut or replaced."""
    return " ".join(mutated(rng, TOKEN.findall(rng.choice(seeds)), WORDS, rng.randrange(6)))


def spliced(rng, seeds):
    """Lines of several rule files mixed."""
    lines = [line for s in rng.choices(seeds, k=3) for line in s.split("\n")]
    return "\n".join(rng.choices(lines, k=rng.randrange(1, 60)))


def one(text):
    """Check a text, print what is printed, and format it; returns whether it has no error."""
    blocks, diagnostics = check_text(text, "fuzz")
    "".join(map(str, diagnostics))
    run_command("fmt", "-", stdin=text)
    if any(d.severity == "error" for d in diagnostics):
        return False
    assert blocks or diagnostics, "neither a block nor a diagnostic"
    for block in blocks:
        if block.kind == "system":
            assert loads(dumps(block), block=block.name) == block, "the round trip changed the system"
    return True


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    rng = random.Random(arguments.seed)
    seeds = [p.read_text(encoding="utf-8") for p in sorted([*RULES.glob("*.fz"), *GOLDEN.glob("diagnostics/*.fz")])]
    kinds = Counter()
    slowest = 0.0
    for _ in range(arguments.inputs):
        make = rng.choice([soup, noise, edited, edited, spliced])
        text = make(rng, seeds)
        start = time.perf_counter()
        try:
            kinds["system" if one(text) else "diagnostics"] += 1
        except Exception:
            Path("fuzz-failure.fz").write_text(text, encoding="utf-8")
            print("the text is in fuzz-failure.fz", file=sys.stderr)
            raise
        slowest = max(slowest, time.perf_counter() - start)
    print(f"{arguments.inputs} inputs: {dict(kinds)}; slowest {slowest:.2f} s; no uncaught exception")


if __name__ == "__main__":
    main()
