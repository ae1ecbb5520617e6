"""Half-typed lines: each statement of controllers, plants and loops, cut behind each of its words, is one diagnostic.

After an intended change of wording: FUZZYCTL_UPDATE_GOLDEN=1 python -m pytest -m "long or not long" tests/golden, then
read the difference.
"""

import os
import re
from functools import cache
from pathlib import Path

import pytest

from fuzzyctl.testing import check_text
from tests import sizes

TABLE = Path(__file__).parent / "half_typed.txt"
TEXT = TABLE.with_suffix(".fz").read_text(encoding="utf-8")
LINES = TEXT.splitlines()
WORD = re.compile(r'"[^"]*"|[^\W\d]\w*|\d+\.?\d*|<=|>=|\S')

#: All places where a line may be cut: its number, from 0, and its first characters.
CUTS = [(k, line[: m.end()]) for k, line in enumerate(LINES) for m in list(WORD.finditer(line))[:-1]]
#: In the test line every seventh, which differs from line to line.
SOME = CUTS if sizes.LONG else CUTS[::7]


@cache
def errors(k, text):
    """The errors of the file with another text in one line, as (line, code, message)."""
    whole = "\n".join([*LINES[:k], text, *LINES[k + 1 :]]) + "\n"
    return [(d.span.line, d.code, d.message) for d in check_text(whole)[1] if d.severity == "error"]


def row(k, text):
    """The row of the table: where a cut line is still a statement, it says so."""
    found = "\n".join(f"    {code} {message}" for _, code, message in errors(k, text))
    return f"{k + 1}: {text}\n{found or '    no error'}"


def test_the_whole_text_has_no_mistake():
    assert errors(0, LINES[0]) == []


def test_each_cut_is_one_diagnostic_in_its_line():
    for k, text in SOME:
        assert [line for line, _, _ in errors(k, text)] in ([k + 1], []), text


def test_they_are_as_in_the_table():
    if sizes.LONG and os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
        TABLE.write_text("\n".join(row(*cut) for cut in CUTS) + "\n", encoding="utf-8", newline="\n")
    table = TABLE.read_text(encoding="utf-8")
    for cut in SOME:
        assert f"{row(*cut)}\n" in table


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (1, "functin"), (4, "inpt e"), (6, "sate s in [-1, 1] = 0"), (7, "otput u"), (8, "nxt s = sat(s)"), (8, "ne"),
        (11, 'contoller law "A law"'), (11, "cont law"), (17, "st"), (24, 'plnt tank "A tank"'), (24, "plan tank"),
        (27, "s"), (29, "dr h = 0"), (30, "o"), (32, "plant lag = t"), (35, "loo fill"), (43, "meas over"), (44, "r"),
    ],
)  # fmt: skip
def test_a_misspelt_or_half_typed_keyword_is_one_diagnostic(number, text):
    assert [line for line, _, _ in errors(number - 1, text)] == [number]
