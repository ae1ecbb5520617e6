"""Types as a user's checker sees them; `mypy` of the repository checks `user_code.py` on each change, too."""

import subprocess
import sys
import tomllib
from pathlib import Path
from typing import get_args, get_type_hints

import pytest

from fuzzyctl import UnknownNameError, as_profile, build, load
from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, DISJUNCTIONS, MEMBERSHIP

ROOT = Path(__file__).parents[2]
USER_CODE = Path(__file__).parent / "user_code.py"


def words(function, parameter):
    """Return the words that the type of a parameter has."""
    parts = get_type_hints(function)[parameter]
    return {word for part in get_args(parts) for word in get_args(part) or [part]} - {type(None)}


def test_types_have_the_words_that_are_accepted():
    with pytest.raises(UnknownNameError) as error:
        as_profile(load("tipper"), "nope")
    assert words(as_profile, "name") == set(error.value.known)
    assert words(build.system, "conjunction") == set(CONJUNCTIONS)
    assert words(build.system, "disjunction") == set(DISJUNCTIONS)
    assert words(build.system, "aggregation") == set(AGGREGATIONS)
    assert words(build.membership, "kind") == {*MEMBERSHIP, "linear", "function"}


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
