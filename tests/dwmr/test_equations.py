"""Every equation of the paper is found by its number: in a source of the code, and in the table of the explanation.

Sources are those of functions, and of the control laws and rule files.
"""

import ast
import re
from pathlib import Path

from tests.shipped import LAWS, SYSTEMS

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "apps" / "dwmr"
PAGE = ROOT / "docs" / "explanation" / "the-paper.md"
LAST = 78

_BOUND = "a step of the proof: a bound of Eq. (26) or (37), which are evaluated themselves"
_CONDITION = "a step of the proof: a condition for a bound to be negative; the sign itself is counted along the run"
#: Equations no function computes, each with its reason.
EXCEPTIONS = {
    **dict.fromkeys((27, 28, 29, 32, 33, 36, 38, 39, 42), _BOUND),
    **dict.fromkeys((30, 31, 34, 35, 40, 41, 43), _CONDITION),
    48: "the follower's posture as it is, not as it should be: the state that the plant integrates",
    50: "rates of separation and bearing: a step towards Eq. (51), which holds what the control law needs of them",
    54: "its part V_PD is printed in another paper that is not open; without it the sum says nothing new",
    55: "the derivative of Eq. (54)",
    **dict.fromkeys((73, 74), "in a recorded run the function of the mode in force, which is that of Eq. (10) or (23)"),
}


def numbers(text):
    """Return the equations a text names: Eq. (1), Eqs. (2), (3), Eqs. (4)-(6)."""
    part = r"\(\d+\)(?:-\(\d+\))?"
    found = set()
    for match in re.finditer(rf"Eqs?\. ({part}(?:(?:, and |, | and | or ){part})*)", " ".join(text.split())):
        for first, last in re.findall(r"\((\d+)\)(?:-\((\d+)\))?", match[1]):
            found |= set(range(int(first), int(last or first) + 1))
    return found


def sources():
    """Return the equations by module.function, from Source sections, and by file and name of the rule files."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        module = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            text = (ast.get_docstring(node) or "") if isinstance(node, ast.FunctionDef) else ""
            if "Source:" in text:
                found.setdefault(f"{module}.{node.name}", set()).update(numbers(text.split("Source:")[1]))
    line = re.compile(r'^(?:controller|system) (\w+).*\nsource "(.*)"$', re.MULTILINE)
    for path in (*LAWS, *SYSTEMS):
        for name, source in line.findall(path.read_text(encoding="utf-8")):
            found[f"rules/{path.name}: {name}"] = numbers(source)
    return found


def rows():
    """Return the rows of the page's table: equations, and what stands in the column that says where."""
    section = PAGE.read_text(encoding="utf-8").split("## Where each equation is")[1].split("\n## ")[0]
    for line in section.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 3 and cells[0].startswith("("):
            yield numbers(f"Eqs. {cells[0]}"), cells[2]


class TestDocstrings:
    def test_every_equation_is_the_source_of_a_function_or_an_exception(self):
        covered = set().union(*sources().values())
        assert set(range(1, LAST + 1)) - covered - set(EXCEPTIONS) == set()

    def test_no_equation_beyond_the_last_is_named(self):
        assert max(set().union(*sources().values())) <= LAST

    def test_exceptions_are_not_computed_after_all(self):
        """Ranges such as Eqs. (47)-(51) may run over them; a function that names one by itself computes it."""
        text = " ".join(" ".join(p.read_text(encoding="utf-8").split()) for p in PACKAGE.rglob("control/laws/*.py"))
        text += " ".join(p.read_text(encoding="utf-8") for p in LAWS)
        assert numbers(text) & set(EXCEPTIONS) == set()


class TestTable:
    def test_has_every_equation_once(self):
        listed = [n for found, _ in rows() for n in sorted(found)]
        assert sorted(listed) == list(range(1, LAST + 1))

    def test_names_functions_that_have_the_equation_as_their_source(self):
        known = sources()
        for found, where in rows():
            named = re.findall(r"`([\w./: ]+)`", where)
            if named:
                assert found <= set().union(*(known[name] for name in named)), (found, named)
                assert all(found & known[name] for name in named), (found, named)

    def test_says_of_exceptions_only_that_they_are_not_computed(self):
        not_computed = {n for found, where in rows() for n in found if "`" not in where}
        assert not_computed == set(EXCEPTIONS)

    def test_says_which_rows_of_an_equation_are_not_computed(self):
        section = PAGE.read_text(encoding="utf-8").split("## Where each equation is")[1]
        assert "third row of Eq. (3), the rate ω_ar, and the first row of Eq. (5)," in " ".join(section.split())
        text = (PACKAGE / "control" / "formation.py").read_text(encoding="utf-8")
        assert "Eq. (3), first two rows" in text
        assert "Eq. (5), second row" in text
