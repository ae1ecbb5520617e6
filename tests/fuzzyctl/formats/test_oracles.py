"""Files of other tools are read as the readers before the translation read them: numbers, text, acceptance, places.

`python -m pytest -m "long or not long" tests/fuzzyctl/formats/test_oracles.py` draws 2,000 files of each format, and
`python -m tests.oracles.controls` breaks the readers to see that these find it.
"""

import random
import re
from pathlib import Path

import pytest

from tests.fuzz.mutating import mutated
from tests.oracles.comparing import differences
from tests.oracles.drawn_fcl import fcl
from tests.oracles.drawn_fis import fis
from tests.oracles.drawn_fll import fll
from tests.oracles.drawn_fml import fml
from tests.sizes import examples

DRAWN = {"fll": fll, "fis": fis, "fcl": fcl, "fml": fml}
SAMPLES = {
    format: [p.read_text(encoding="utf-8") for p in sorted(Path(__file__).parent.rglob(f"*.{format}"))]
    for format in DRAWN
}
TOKEN = re.compile(r"[\d.]+|[^\W\d]\w*|\n *|.", re.DOTALL)
WORDS = [*"0 -1 1e999 nan -inf 7 ( ) [ ] , ; : = ' \" # % and or not is if then with any x a none".split(), "\n"]


def broken(format, seed):
    """Return a drawn or shipped file with one mistake."""
    rng = random.Random(seed)
    text = rng.choice([DRAWN[format](rng), *SAMPLES[format]])
    return "".join(mutated(rng, TOKEN.findall(text), WORDS, 1))


@pytest.mark.parametrize("format", DRAWN)
def test_drawn_files_are_read_as_before(format):
    for seed in range(examples(2000, 80)):
        text = DRAWN[format](random.Random(seed))
        assert differences(format, text) == [], f"seed {seed}\n{text}"


@pytest.mark.parametrize("format", DRAWN)
def test_broken_files_are_refused_where_they_were(format):
    for seed in range(examples(2000, 80)):
        text = broken(format, seed)
        assert differences(format, text) == [], f"seed {seed}\n{text}"
