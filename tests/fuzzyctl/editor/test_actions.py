import pytest

from fuzzyctl.diagnostics.fixes import Fix, fixed
from fuzzyctl.editor.actions import actions
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.lang.formatter import format_source
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM, marked

HEADER = "         bad    fine   great\n"
POOR = "  poor | small  small  large\n"
GOOD = "  good | small  large  large\n"
TABLE = "table tip = service x food\n" + HEADER + POOR + GOOD
LINES = "  bad = triangle(-inf, 0, 5)\n  fine = triangle(0, 5, 10)\n  great = triangle(5, 10, inf)\n"
UNEVEN = "  bad = triangle(-inf, 0, 4)\n  fine = triangle(0, 4, 10)\n  great = triangle(4, 10, inf)\n"
PARTITION = "  terms bad fine great\n"
AS_LINES = "write the terms as functions, one a line"
AS_ONE = "write the terms as one line of peaks"
ELSE = "add 'else midpoint', the output where no rule fires"


def rows(*lines):
    return SYSTEM.replace(TABLE, "table tip = service x food\n" + "".join(lines))


def terms(lines):
    return SYSTEM.replace(PARTITION, lines)


#: A text, where the cursor stands, the title of an action, and lines that the text has afterwards.
CASES = {
    "a missing row": (rows(HEADER, POOR), "bad    fine", "add 1 missing row", ["  good |  .      .      ."]),
    "at the head of the table": (rows(HEADER, POOR), "table tip", "add 1 missing row", ["  good |  .      .      ."]),
    "in a row": (rows(HEADER, POOR), "small  small", "add 1 missing row", ["  good |  .      .      ."]),
    "the first row": (rows(HEADER, GOOD), "bad    fine", "add 1 missing row", ["  poor |  .      .      ."]),
    "two rows": (rows(HEADER), "bad    fine", "add 2 missing rows", ["  poor |  .    .     ."]),
    "header and rows": (rows(), "table tip", "add 2 missing rows", ["          bad  fine  great"]),
    "a missing column": (
        rows("  bad  great\n", "  poor | small large\n", "  good | small large\n"),
        "bad  great",
        "add 1 missing column",
        ["          bad    great  fine", "  poor |  small  large  ."],
    ),
    "two columns": (
        rows("  fine\n", "  poor | large\n", "  good | small\n"),
        "fine\n  poor",
        "add 2 missing columns",
        ["          fine   bad  great", "  good |  small  .    ."],
    ),
    "rows beside columns": (rows("  bad  fine\n", POOR), "bad  fine\n", "add 1 missing column",
        ["          bad    fine   great"]),
    "comments stay": (
        rows(HEADER, POOR[:-1] + "  # why\n"),
        "bad    fine",
        "add 1 missing row",
        ["  poor |  small  small  large  # why"],
    ),
    "a table of one input": (
        LOOP.replace("    N  Z  P\n  | N  Z  P\n", "    N  Z\n  | N  Z\n"),
        "N  Z\n  |",
        "add 1 missing column",
        ["     N  Z  P", "  |  N  Z  ."],
    ),
    "an output without else": (
        SYSTEM.replace(" else 0", ""), "tip in", ELSE, ["output tip in [0, most] else midpoint"]),
    "else before a comment": (
        SYSTEM.replace(" else 0", "  # tip"), "tip in", ELSE, ["output tip in [0, most] else midpoint  # tip"]
    ),
    "else behind a unit": (
        SYSTEM.replace(" else 0", ' unit "%"'), "tip in", ELSE, ['output tip in [0, most] unit "%" else midpoint']
    ),
    "else from a term": (SYSTEM.replace(" else 0", ""), "small=0", ELSE, ["output tip in [0, most] else midpoint"]),
    "a partition as functions": (SYSTEM, "bad fine", AS_LINES, LINES.splitlines()),
    "at the input": (SYSTEM, 'food "Food"', AS_LINES, LINES.splitlines()),
    "peaks as functions": (terms("  terms bad@0 fine@4 great@10\n"), "bad@0", AS_LINES, UNEVEN.splitlines()),
    "values as functions": (SYSTEM, "small=0", AS_LINES, ["  small = singleton(0)", "  large = singleton(most)"]),
    "functions as a partition": (terms(LINES), "fine = ", AS_ONE, ["  terms bad fine great"]),
    "peaks that are params": (
        terms(UNEVEN.replace("4", "most / 5")),
        "fine = ",
        AS_ONE,
        ["  terms bad@0 fine@most / 5 great@10"],
    ),
    "functions as peaks": (terms(UNEVEN), "fine = ", AS_ONE, ["  terms bad@0 fine@4 great@10"]),
    "constants as values": (
        SYSTEM.replace("  terms small=0 large=most\n", "  small = singleton(0)\n  large = singleton(20)\n"),
        "small = ",
        AS_ONE,
        ["  terms small=0 large=20"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_an_action_writes(case):
    text, at, title, wanted = CASES[case]
    document, offset = marked(text, at, "table" if "table" in text[: text.index(at)] else "")
    found = {a.title: a for a in actions(document, offset)}
    action = found[title]
    after = fixed(document.source, [Fix(action.replacements, "sure")])
    assert set(wanted) <= set(after.split("\n")), after
    after_document, place = marked(after, after.split("\n")[0])
    assert title not in {a.title for a in actions(after_document, place)}
    assert [d for d in after_document.mistakes if d.code.startswith("FZ1")] == []
    if action.rewrites:
        assert plan(after_document.examined.systems[0]) == plan(document.examined.systems[0])
    if "missing" in title:
        assert format_source(after_document.source).count("|") == after.count("|")


NOTHING = {
    "a complete table": (SYSTEM, "bad    fine"),
    "an output with else": (SYSTEM, "tip in"),
    "ramps that are no partition": (SYSTEM, "poor = "),
    "terms with a comment": (terms(LINES.replace("5)\n", "5)  # why\n", 1)), "fine = "),
    "feet beyond the peaks": (terms(LINES.replace("(5, 10, inf)", "(4, 10, inf)")), "fine = "),
    "a height": (terms(LINES.replace("(0, 5, 10)", "(0, 5, 10) height 0.5")), "fine = "),
    "overlapping terms": (terms(LINES.replace("(0, 5, 10)", "(0, 5, 9)")), "fine = "),
    "a guarantee": (SYSTEM, "require"),
    "a broken text": ("table\n", "table"),
    "an empty text": ("", ""),
}


@pytest.mark.parametrize("case", NOTHING)
def test_nothing_to_write(case):
    text, at = NOTHING[case]
    found = [a.title for a in actions(*marked(text, at, "table" if case == "a complete table" else ""))]
    assert [t for t in found if t != AS_LINES] == []


def test_there_and_back():
    document, offset = marked(SYSTEM, "bad fine")
    there = fixed(document.source, [Fix(actions(document, offset)[0].replacements, "sure")])
    (back,) = actions(*marked(there, "bad = "))
    assert fixed(marked(there, "bad = ")[0].source, [Fix(back.replacements, "sure")]) == SYSTEM
    assert back.rewrites
