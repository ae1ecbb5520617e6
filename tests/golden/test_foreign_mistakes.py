"""Files of other tools with one mistake each: every one is answered at its place, in words of its format.

After an intended change of wording: FUZZYCTL_UPDATE_GOLDEN=1 python -m pytest tests/golden/test_foreign_mistakes.py,
then read the difference.
"""

import os
from pathlib import Path

import pytest

from fuzzyctl.diagnostics.diagnostic import render_all
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.foreign import examine_foreign
from fuzzyctl.formats.registry import FORMATS

TABLE = Path(__file__).parent / "foreign_mistakes.txt"
FORMATS_TESTS = Path(__file__).parent.parent / "fuzzyctl" / "formats"
SAMPLES = {
    "fll": FORMATS_TESTS / "samples" / "tipper.fll",
    "fis": FORMATS_TESTS / "samples" / "tipper.fis",
    "fcl": FORMATS_TESTS / "fcl" / "jfuzzylogic.fcl",
    "fml": FORMATS_TESTS / "fml" / "mamdani.fml",
}

#: By format what is broken and how, each with its line and column.
MISTAKES = {
    "fll": [
        ("  term: cheap Constant", "  trem: cheap Constant", 37, 3),
        ("range: 0.000 30.000", "range: 0.000 ten", 20, 16),
        ("term: good Triangle", "term: good Trianlge", 10, 14),
        ("Triangle 2.500 5.000 7.500", "Triangle 2.500 5.000", 10, 9),
        ("Triangle 2.500 5.000 7.500", "Triangle 7.500 2.500 five", 10, 35),
        ("aggregation: Maximum", "aggregation: Maximun", 22, 16),
        ("Centroid 200", "Centroid many", 23, 25),
        ("Centroid 200", "Centre 200", 23, 16),
        ("conjunction: AlgebraicProduct", "conjunction: Product", 42, 16),
        ("activation: General", "activation: Highest none", 45, 23),
        ("if service is poor", "if servise is poor", 46, 12),
        ("if service is poor", "if service is por", 46, 23),
        ("if (service is excellent", "if ((service is excellent", 49, 12),
        ("with 0.5", "with 1.5", 48, 90),
        ("OutputVariable: tsTip", "OutputVariable: service", 29, 17),
    ],
    "fis": [
        ("Type='mamdani'", "Type='mamdami'", 3, 6),
        ("AndMethod='min'", "AndMethod='minimum_of'", 8, 11),
        ("DefuzzMethod='centroid'", "DefuzzMethod='wtaver'", 12, 14),
        ("[Input2]", "[Inputs]", 22, 1),
        ("Range=[0 30]", "Range=[0 ten]", 31, 10),
        ("Range=[0 30]", "Range=[30]", 31, 7),
        ("Range=[0 30]\n", "", 29, 1),
        ("'trimf',[0 5 10]", "'trimf',[0 5]", 33, 5),
        ("'trimf',[0 5 10]", "'trinf',[0 5 10]", 33, 14),
        ("'trimf',[0 5 10]", "'trimf',[10 5 0]", 33, 5),
        ("'trimf',[0 5 10]", "'trimf',[0 5 10", 33, 21),
        ("1 1, 1 (1) : 2", "1 5, 1 (1) : 2", 38, 3),
        ("1 1, 1 (1) : 2", "1 1 1, 1 (1) : 2", 38, 1),
        ("1 1, 1 (1) : 2", "1 1, 1 (1.5) : 2", 38, 9),
        ("1 1, 1 (1) : 2", "1 1, 1 (1) : 4", 38, 12),
    ],
    "fcl": [
        ("gap : REAL;", "gap REAL;", 7, 6),
        ("RANGE := (0 .. 5)", "RANGE := (0 .. )", 7, 14),
        ("TRAPE 0 0 1 2", "TRAPE 0 0 1", 17, 15),
        ("TRAPE 0 0 1 2", "TRAPEZ 0 0 1 2", 17, 15),
        ("TRAPE 0 0 1 2", "TRAPE 0 0 one 2", 17, 25),
        ("FUZZIFY closing", "FUZZIFY closng", 22, 9),
        ("METHOD : COG;", "METHOD : COK;", 31, 11),
        ("METHOD : COGF", "METOD : COGF", 39, 2),
        ("TRIAN 0.3 0.6 1", "TRIAN 1 0.6 0.3", 29, 0),
        ("AND : PROD", "AND : PRDO", 44, 8),
        ("DEFAULT := 0;", "DEFAULT := never;", 32, 13),
        ("IF gap IS near", "IF gab IS near", 48, 14),
        ("IF gap IS near", "IF gap IS neer", 48, 21),
        ("THEN speed IS stop", "THN speed IS stop", 48, 0),
        ("WITH 0.9", "WITH much", 49, 71),
    ],
    "fml": [
        ('<fuzzyTerm name="slow"', '<fuzyTerm name="slow"', 8, 15),
        ('param1="10.0" param2="40.0"', 'param1="10.0" param2="forty"', 23, 46),
        ('<zShape param1="10.0" param2="40.0"/>', '<zShape param1="10.0"/>', 23, 17),
        ("<gaussianShape", "<gaussShape", 26, 17),
        ('param1="0.0" param2="1.0" param3="3.0"', 'param1="3.0" param2="1.0" param3="0.0"', 38, 17),
        ('interpolationMethod="linear"', 'interpolationMethod="spline"', 29, 52),
        ('domainleft="0.0" domainright="30.0"', 'domainleft="0.0"', 5, 9),
        ('name="distance"', 'name="speed"', 21, 29),
        ('accumulation="MAX"', 'accumulation="MAXIMUM"', 36, 109),
        ('defuzzifier="COG"', 'defuzzifier="COOG"', 36, 127),
        ('connector="and" weight', 'connector="xor" weight', 46, 54),
        ('weight="0.9"', 'weight="1.9"', 66, 65),
        ('<clause modifier="very">', '<clause modifier="verry">', 52, 34),
        ("<term>full</term>", "<term>ful</term>", 61, 25),
        ("<variable>force</variable>", "<variable>speed</variable>", 60, 25),
        ("<gaussianShape", "<customShape", 26, 17),
        ("<point x", "<pont x", 30, 21),
        ("<circularDefinition>", "<circularDefinition><not/>", 13, 37),
        ('type="output"', 'type="outputs"', 36, 87),
        ("<variable>distance</variable>", "<variable>distanc</variable>", 53, 21),
        ("<then>", "<clause><variable>force</variable><term>full</term></clause><then>", 58, 17),
        ('weight="0.9"', 'weight="heavy"', 66, 65),
    ],
}
CASES = [(format, *case) for format, cases in MISTAKES.items() for case in cases]


def answer(format, old, new):
    """Return the first error of a broken file and all of its answer, as text."""
    path = SAMPLES[format]
    text = path.read_text(encoding="utf-8")
    assert old in text, old
    _, found = examine_foreign(FORMATS[format], SourceText(path.name, text.replace(old, new, 1)))
    errors = [d for d in found if d.severity == "error"]
    return errors[0], f"--- {old.strip()} -> {new.strip()}\n{render_all(errors)}\n"


@pytest.mark.parametrize(("format", "old", "new", "line", "column"), CASES)
def test_each_is_answered_at_its_place(format, old, new, line, column):
    error, _ = answer(format, old, new)
    assert (error.span.line, error.span.column) == (line, column or error.span.column)
    assert error.span.text.strip() or not new.strip()


def test_they_are_as_in_the_table():
    shown = "\n".join(answer(format, old, new)[1] for format, old, new, _, _ in CASES)
    if os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
        TABLE.write_text(shown, encoding="utf-8", newline="\n")
    assert TABLE.read_text(encoding="utf-8") == shown
