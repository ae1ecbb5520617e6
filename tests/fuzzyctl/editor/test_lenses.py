import pytest

from fuzzyctl.analysis.verdicts import Undecided
from fuzzyctl.editor.lights import COMMANDS, PROVE, SIMULATE, SURFACE, WHY, arguments, lenses, point_text, prove
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM, marked

BASE = SYSTEM.replace("require tip >= 0\n", "")


def claiming(*claims):
    return BASE + "".join(f"require {c}\n" for c in claims)


#: A text, and the lenses of its lines after proofs: line, begin of the title, command, block.
CASES = {
    "a system": (BASE, ["1 surface surface tip"]),
    "a system with a guarantee": (SYSTEM, ["1 surface surface tip", "1 prove prove tip", "19 ✓ proved prove tip"]),
    "two guarantees": (
        claiming("tip >= 0", "tip <= 20"), ["1 s", "1 p", "19 ✓ proved prove tip", "20 ✓ proved prove tip"]),
    "a refuted one": (claiming("tip <= 19"), ["1 s", "1 p", "19 ✗ refuted at service = why tip"]),
    "both": (claiming("tip <= 19", "tip >= 0"), ["1 s", "1 p", "19 ✗ refuted why tip", "20 ✓ prove tip"]),
    "a mistake": (claiming("tap >= 0"), ["1 s", "1 p", "19 … not proved: there are mistakes prove tip"]),
    "a loop": (LOOP, ["1 surface surface surface", "11 prove prove law", "28 simulate simulate closed"]),
    "a claim about a run": (
        LOOP + "require iae <= 9\n", ["1 s", "11 p", "28 s", "34 … judged by a run simulate closed"]),
    "a plant": ("plant lag = tf(num=[1], den=[1, 1])\n", []),
    "no head": ("input x in [0, 1]\n", []),
    "an empty text": ("", []),
    "a broken text": ("system\nrequire\n", []),
    "two systems": ("system a\nsystem b\n", ["1 surface surface a", "2 surface surface b"]),
    "a claim without a head": ("require x >= 0\n", ["1 … not proved: there are mistakes prove "]),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_lenses_of(case):
    text, wanted = CASES[case]
    document, _ = marked(text + "§")
    prove(document)
    found = lenses(document)
    assert len(found) == len(wanted), found
    for lens, line in zip(found, wanted, strict=True):
        assert lens.command in COMMANDS
        number, rest = line.split(" ", 1)
        assert lens.span.line == int(number)
        assert lens.title[0] == rest[0]
        if " " in rest:
            title, command, block = rest.rsplit(" ", 2)
            assert (lens.title.startswith(title), lens.command, lens.block) == (True, f"fuzzyctl.{command}", block)


def test_before_proofs_it_is_not_known():
    assert lenses(marked(SYSTEM, "tip")[0])[-1].title == "… not proved yet"


def test_long_reasons_are_cut():
    document, offset = marked(SYSTEM, "require")
    document.verdicts[offset, "tip"] = Undecided("tip >= 0", "x" * 500)
    assert len(lenses(document)[-1].title) == 162


def test_a_counterexample_goes_to_why():
    document, _ = marked(claiming("tip <= 19") + "§")
    prove(document)
    lens = lenses(document)[-1]
    assert arguments(lens.command, lens.block, lens.point, "")[:4] == ["why", "-", "--block", "tip"]
    assert point_text(lens.point) == " ".join(arguments(lens.command, lens.block, lens.point, "")[4:])


@pytest.mark.parametrize(
    ("command", "block", "given"),
    [
        (SURFACE, "tip", ["plot-surface", "-", "--block", "tip", "-o", "a.svg"]),
        (SURFACE, "", ["plot-surface", "-", "-o", "a.svg"]),
        (WHY, "tip", ["why", "-", "--block", "tip", "x=0.5", "y=-1"]),
        (PROVE, "tip", ["prove", "-", "--block", "tip"]),
        (SIMULATE, "fill", ["simulate", "-", "--block", "fill"]),
        (SIMULATE, "", ["simulate", "-"]),
    ],
)
def test_commands_as_arguments(command, block, given):
    assert arguments(command, block, {"x": 0.5, "y": -1.0}, "a.svg") == given
