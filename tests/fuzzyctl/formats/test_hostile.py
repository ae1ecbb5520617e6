"""Any text in a file of another tool gives a system or diagnostics, in time that grows with its size.

tests/fuzz/fuzz_formats.py throws more.
"""

import random
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.effort import at_most
from tests.fuzz.mutating import mutated
from tests.fuzzyctl.formats import files
from tests.fuzzyctl.formats.files import SAMPLES
from tests.sizes import examples

FIS, FLL, FCL = SAMPLES["tipper.fis"], SAMPLES["tipper.fll"], SAMPLES["standard.fcl"]
FML = SAMPLES["mamdani.fml"]
TOKEN = re.compile(r"[\d.]+|[^\W\d]\w*|\n *|.", re.DOTALL)
ODD = [
    *"0 -1 1e999 nan -inf ( ) [ ] , ; : = ' \" # % < > / & <!-- <![CDATA[ &x; (* *) /*".split(),
    "\n",
    "\r",
    "\x00",
    "é",
]


def examined(name, text):
    system, diagnostics = files.examined(name, text)
    assert system is not None or any(d.severity == "error" for d in diagnostics)
    "".join(map(str, diagnostics))
    for d in diagnostics:
        assert d.span is None or 0 <= d.span.start <= d.span.end <= len(text)
    return system, diagnostics


@settings(max_examples=examples(300), deadline=None)
@given(st.sampled_from(sorted(SAMPLES)), st.integers(0, 2**32), st.integers(1, 4))
def test_mutated_files_are_read_or_refused(name, seed, count):
    rng = random.Random(seed)
    tokens = mutated(rng, TOKEN.findall(SAMPLES[name]), ODD, count)
    examined(name, "".join(tokens))


@settings(max_examples=examples(100), deadline=None)
@given(st.sampled_from(["x.fis", "x.fll", "x.fcl", "x.fml"]), st.text(max_size=200))
def test_any_text_is_read_or_refused(name, text):
    examined(name, text)


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_files_cut_off_anywhere_are_read_or_refused(name):
    text = SAMPLES[name]
    for end in range(0, len(text), examples(7, 29)):
        examined(name, text[:end])


N, MANY = examples(20_000, 5_000), examples(4000, 1000)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("quotes.fis", FIS.replace("'cheap'", "'" * N)),
        ("quoted.fis", FIS.replace("'cheap'", "'" + "' " * N)),
        ("blanks.fis", FIS.replace("'cheap'", "'cheap'" + " " * N)),
        ("brackets.fis", FIS.replace("[0 5 10]", "[" * N)),
        ("numbers.fis", FIS.replace("[0 5 10]", f"[{'1 ' * N}]")),
        ("digits.fis", FIS.replace("[0 5 10]", f"[{'9' * N}]")),
        ("signs.fis", FIS.replace("[0 5 10]", f"[{'-' * N}1]")),
        ("parentheses.fis", FIS.replace("[0 5 10]", f"[{'(' * N}]")),
        ("powers.fis", FIS.replace("[0 5 10]", f"[{'2^' * N}1]")),
        ("sections.fis", "[System]\nName='a'\n" + "[Input1]\n" * N),
        ("names.fis", FIS.replace("MF1='cheap'", "MF1='a':'trimf',[0 1 2]\n" * MANY + "MF1='cheap'")),
        ("rule.fis", FIS + "1 " * N + ", 1 (1) : 1\n"),
        ("formula.fis", FIS.replace("'trimf',[0 5 10]", f"'function',[{'1+' * N}1]")),
        ("colons.fll", ":" * N),
        ("names.fll", FLL.replace("  term: cheap", "  term: a Triangle 0 1 2\n" * MANY + "  term: cheap", 1)),
        ("variables.fll", "Engine: a\n" + "InputVariable: a\n" * N),
        ("and.fll", FLL + "  rule: if " + "service is poor and " * 1500 + "food is rancid then mTip is cheap\n"),
        ("parentheses.fll", FLL + "  rule: if " + "(" * N),
        ("hedges.fll", FLL + "  rule: if service is " + "very " * N + "poor then mTip is cheap\n"),
        ("points.fll", FLL.replace("  term: cheap", f"  term: a Discrete {'1 0.5 ' * N}\n  term: cheap", 1)),
        ("keys.fll", "Engine: a;" + "term:;" * N),
        ("formula.fll", FLL.replace("25 + sin(service)", "(" * N)),
        ("words.fcl", FCL.replace("RULE 1 ", "x ; " * N + "RULE 1 ", 1)),
        ("symbols.fcl", FCL.replace("RULE 1 ", "@ " * N + "RULE 1 ", 1)),
        ("not.fcl", FCL.replace("IF ", "IF " + "NOT " * N, 1)),
        ("parentheses.fcl", FCL.replace("IF ", "IF " + "(" * N, 1)),
        ("open.fcl", FCL.replace("RULE 1 ", "(* " * N + "RULE 1 ", 1)),
        ("rules.fcl", FCL.replace("RULE 1 ", "RULE 0 : IF trend IS rising THEN valve IS shut; " * MANY + "RULE 1 ", 1)),
        ("long.fll", FLL.replace("25 + sin(service)", "1+" * N + "1 ")),
        ("rule.fcl", "RULE 1 : IF (" * N),
        ("term.fcl", "TERM a := (" * N),
        ("elements.fml", "<fuzzySystem>" + "<x/>" * N + "</fuzzySystem>"),
        ("rules.fml", FML.replace("<rule ", '<rule name="r"><antecedent/></rule><rule ' * MANY, 1)),
    ],
    ids=lambda x: x if len(x) < 30 else "",
)
def test_large_files_take_time_that_grows_with_their_size(name, text):
    with at_most(examples(8, 3)):  # half a second, and a tenth of it, on a quiet machine; quadratic time is thirty
        examined(name, text)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("x.fll", FLL.replace("if service is", "if service is " + "not " * N, 1)),
        ("x.fcl", FCL.replace(" IS ", " IS " + "very " * N, 1)),
    ],
)
def test_hedges_without_end_are_refused(name, text):
    system, diagnostics = examined(name, text)
    assert system is None
    assert [d.code for d in diagnostics if d.severity == "error"] == ["FZ106"]


def test_lines_without_end_are_not_all_read():
    (error,) = examined("x.fis", "# nothing\n" * 20_001)[1]
    assert (error.code, error.span.line) == ("FZ112", 20_001)


def test_mistakes_without_end_are_not_all_reported():
    _, diagnostics = examined("words.fcl", FCL.replace("RULE 1 ", "x ; " * 3000 + "RULE 1 ", 1))
    assert 1000 < len(diagnostics) < 1010
    (last,) = (d for d in diagnostics if "too many errors" in d.message)
    assert last.span.column == 5 + 4 * 1000  # the thousand and first
