"""Degrees that sum to 1, but not everywhere."""

import pytest

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import examine

TERMS = [
    "A = triangle(-inf, 0, 2)",
    "B = triangle(0, 2, 4)",
    "C = triangle(2, 4, 6)",
    "D = triangle(4, 6, 8)",
    "E = triangle(6, 8, inf)",
]


def found(terms, more=""):
    text = "system s\ndefuzzifier center_average\ninput x in [0, 8]\n" + "".join(f"  {t}\n" for t in terms)
    names = [t.split()[0] for t in terms]
    text += "output u in [0, 1] else 0\n  terms l=0\n" + "".join(f"if x is {n} then u is l\n" for n in names)
    _, diagnostics = examine(SourceText("s.fz", text + more))
    return [(d.span.line, *d.facts) for d in diagnostics if d.code == "FZ406"]


class TestSpoiltPartitions:
    def test_a_partition_of_unity_is_fine(self):
        assert found(TERMS) == []

    @pytest.mark.parametrize(
        ("position", "term", "facts"),
        [
            (2, "C = triangle(2.5, 4, 6)", ["at x = 2.25 they sum to 0.875"]),
            (2, "C = triangle(1, 4, 6)", ["at x = 1.5 they sum to 1.16667", "at x = 3 they sum to 1.16667"]),
            (1, "B = triangle(0, 2.5, 4)", None),
            (4, "E = triangle(6, 7, inf)", None),
        ],
    )
    def test_one_slip_is_found(self, position, term, facts):
        ((line, *got),) = found([*TERMS[:position], term, *TERMS[position + 1 :]])
        assert line == 3
        assert facts is None or got == facts

    @pytest.mark.parametrize(
        "terms",
        [
            ["A = triangle(-inf, 0, 3)", "B = triangle(-1, 2, 5)", "C = triangle(1, 4, 7)", "D = triangle(3, 6, inf)"],
            ["A = gaussian(0, 1)", "B = gaussian(2, 1)", "C = gaussian(4, 1)", "D = gaussian(6, 1)"],
            [TERMS[0], "B = triangle(0, 2, 3)", TERMS[2]],
            [*TERMS[:4], "E = triangle(6, 8, inf, height=0.9)"],
            ["A = triangle(-1, 1, 2)", "B = triangle(1, 2, 3)", "C = triangle(2, 3, 4)", "D = triangle(3, 4, 9)"],
            [*TERMS, "F = triangle(9, 10, inf)"],
        ],
    )
    def test_other_designs_are_left_in_peace(self, terms):
        assert found(terms) == []
