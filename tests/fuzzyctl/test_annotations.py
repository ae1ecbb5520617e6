"""Types as a user's checker sees them; `mypy` of the repository checks `user_code.py` on each change, too."""

import subprocess
import sys
import tomllib
from pathlib import Path
from typing import get_args

import pytest

from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, DISJUNCTIONS, MEMBERSHIP, MembershipKind
from fuzzyctl.formulas.norms import Aggregation, Conjunction, Disjunction
from fuzzyctl.model.profiles import PROFILES, ProfileName

ROOT = Path(__file__).parents[2]
USER_CODE = Path(__file__).parent / "user_code.py"


def test_names_are_those_that_are_accepted():
    assert get_args(ProfileName) == tuple(PROFILES)
    assert get_args(Conjunction) == tuple(CONJUNCTIONS)
    assert get_args(Disjunction) == tuple(DISJUNCTIONS)
    assert {name for part in get_args(Aggregation) for name in get_args(part)} == set(AGGREGATIONS)
    assert get_args(MembershipKind) == tuple(MEMBERSHIP)


def test_user_code_is_checked_with_the_project():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["mypy"]
    assert settings["modules"] == ["tests.fuzzyctl.user_code"]
    assert settings["strict"]


def test_types_exist_for_checkers_only():
    assert not (ROOT / "fuzzyctl" / "annotations.py").exists()
    assert (ROOT / "fuzzyctl" / "py.typed").exists()


@pytest.fixture
def mypy(tmp_path):
    """Checks a file as a user does: strictly, without the settings of the project, with matplotlib's own types."""

    def check(path):
        command = [sys.executable, "-m", "mypy", "--strict", "--config-file=", f"--cache-dir={tmp_path}", str(path)]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False).stdout

    return check


@pytest.mark.long
def test_user_code_is_accepted_and_its_wrong_lines_are_reported(mypy, tmp_path):
    assert mypy(USER_CODE) == "Success: no issues found in 1 source file\n"
    wrong = tmp_path / "wrong.py"
    wrong.write_text(
        "import fuzzyctl\n"
        "system = fuzzyctl.load('x.fz')\n"
        "reveal_type(system(x=1.0))\n"
        "system.plot(ax=3)\n"
        "fuzzyctl.plot.terms(system).get_title()\n"
        "fuzzyctl.compile(system, 'numpyy')\n",
        encoding="utf-8",
    )
    found = [line.split(":", 2)[1:] for line in mypy(wrong).splitlines() if ": error:" in line or "Revealed" in line]
    assert [line for line, _ in found] == ["3", "4", "5", "6"]
    assert "NamedOutputs" in found[0][1]
