"""Throw texts at the readers of other tools' formats and watch for anything but a system or diagnostics.

    python tests/fuzz/fuzz_formats.py --inputs 100000 --seed 1 [--format fis]

Prints how many texts were tried, how many were systems, and the slowest; exit code 1 at the first uncaught exception
or at a text that takes longer than --seconds, kept in fuzz-failure.FORMAT. What is read is also written, and read
again. Not part of the test suite, which throws fewer.
"""

import argparse
import random
import re
import sys
import time
from collections import Counter
from pathlib import Path

from drawn_fcl import fcl
from drawn_fis import fis
from drawn_fll import fll
from drawn_fml import fml
from mutating import mutated

from fuzzyctl import DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.registry import FORMATS
from fuzzyctl.loading.load import examine_all

DRAWN = {"fll": fll, "fis": fis, "fcl": fcl, "fml": fml}
SAMPLES = Path(__file__).parent.parent / "fuzzyctl" / "formats"
TOKEN = re.compile(r"[\d.]+(?:[eE][+-]?\d+)?|[^\W\d]\w*|\n *|.", re.DOTALL)
WORDS = [*"0 1 -1 0.5 1e-3 1e999 inf -inf nan pi ( ) [ ] { } , ; : = ' \" < > / * + - ^ % # \\ \t".split(" ")]
WORDS += ["\n", "\r", "\n\n", "\x00", "\ufeff", "é", "\u2019", "x" * 300, "(" * 200, "9" * 400, "", " "]


def seeds(format):
    """Return sample files of a format, and what is written of them in it."""
    suffixes = FORMATS[format].suffixes
    return [p.read_text(encoding="utf-8-sig") for p in sorted(SAMPLES.rglob("*")) if p.suffix in suffixes]


def edited(rng, texts):
    """A shipped or drawn file with some tokens or lines deleted, doubled, swapped, cut or replaced."""
    count = rng.choice([1, 1, 1, 2, 3, 8])
    return "".join(mutated(rng, TOKEN.findall(rng.choice(texts)), WORDS, count))


def whole(rng, texts):
    """A shipped or drawn file as it is."""
    return rng.choice(texts)


def soup(rng, texts):
    """Tokens of a file in no order."""
    tokens = TOKEN.findall(rng.choice(texts))
    return "".join(rng.choices([*tokens, *WORDS], k=rng.randrange(1, 120)))


def noise(rng, _):
    """Bytes, decoded as a file would be."""
    return rng.randbytes(rng.randrange(200)).replace(b"\x00", b"0").decode("latin-1")


def tried(format, text):
    """Return what a text was; raises whatever is no diagnostic."""
    source = SourceText(f"fuzz{FORMATS[format].suffixes[0]}", text)
    systems, diagnostics = examine_all(source)
    "".join(map(str, diagnostics))
    if not systems:
        assert any(d.severity == "error" for d in diagnostics), "neither a system nor an error"
        return "refused"
    for system in systems:
        try:
            written, losses = FORMATS[format].write(system)
        except DiagnosticError:
            return "read, not written"
        if any(loss.what == "the system" for loss in losses):  # such as one without a rule
            return "read, not written"
        again, mistakes = FORMATS[format].read(SourceText(source.name, written))
        assert again, f"what was written is not read:\n{written}\n{mistakes}"
    return "read and written"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--inputs", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--format", choices=[*FORMATS], action="append")
    parser.add_argument("--seconds", type=float, default=2.0)
    options = parser.parse_args()
    rng = random.Random(options.seed)
    for format in options.format or FORMATS:
        texts = seeds(format)
        if not texts:
            continue
        counts, slowest = Counter(), 0.0
        for _ in range(options.inputs):
            kind = rng.choice([edited, edited, edited, edited, whole, soup, noise])
            text = kind(rng, rng.choice([texts, [DRAWN[format](rng)]]))
            start = time.perf_counter()
            try:
                counts[tried(format, text)] += 1
                took = time.perf_counter() - start
                assert took < options.seconds, f"{took:.1f} s"
            except Exception:
                Path(f"fuzz-failure.{format}").write_text(text, encoding="utf-8", errors="surrogatepass", newline="")
                raise
            slowest = max(slowest, took)
        print(f"{format}: {dict(counts)}, slowest {slowest:.3f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
