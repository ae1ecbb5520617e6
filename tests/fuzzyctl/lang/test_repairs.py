import pytest

from fuzzyctl.diagnostics.fixes import fixed
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang.parser import parse

#: A line, whose only mistake is one token, how sure its fix is, and the line after it.
CASES = [
    ("param k = = 1", "sure", "param k = 1"),
    ('input x x in [0, 1] unit "m"', "sure", 'input x in [0, 1] unit "m"'),
    ('input x in [0, 1] uint "m"', "sure", 'input x in [0, 1] unit "m"'),
    ("input x in [0, 1]]", "sure", "input x in [0, 1]"),
    ("output y in [0, 1] elsse 0", "sure", "output y in [0, 1] else 0"),
    ("if a iz b then c is d", "likely", "if a is b then c is d"),
    ("input x in [0 1 1]", "likely", None),
    ("table y = a x b x c", "likely", None),
    ("rules low highest(count=1)", "likely", None),
]


@pytest.mark.parametrize(("line", "applicability", "right"), CASES)
def test_one_token(line, applicability, right):
    source = SourceText("a.fz", f"system t\n{line}\n")
    _, (mistake,) = parse(source)
    if right is None:
        assert mistake.fix is None
    else:
        assert mistake.fix is not None
        assert mistake.fix.applicability == applicability
        assert fixed(source, [mistake.fix]).split("\n")[1].split() == right.split()


def test_several_ways_give_none():
    # `x = ` or `= 1` may be missing, and more.
    source = SourceText("a.fz", "system t\nparam 1\n")
    _, (mistake,) = parse(source)
    assert mistake.fix is None
