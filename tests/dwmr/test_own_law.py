"""A law of one's own, as the how-to page has it: run, compared and swept, each in a new process over one cache."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.dwmr.process import dwmr

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "add-a-controller.md"
BLOCK = re.compile(r"<!-- file: (\S+) -->\n```\w+\n(.*?)```", re.DOTALL)
SWEEP = 'scenario = "mine.toml"\nmeasures = ["rmse"]\n[grid]\n"robot.controllers.proportional.k_x" = [0.5, 0.6]\n'
SHORT = ("--set", "run.horizon=1")
ALONE = ("--jobs", "1")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The files of the how-to page, after a first run, whose machine code is on disk."""
    made = tmp_path_factory.mktemp("own")
    for name, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        (made / name).write_text(text, encoding="utf-8")
    (made / "spec.toml").write_text(SWEEP, encoding="utf-8")
    dwmr("run", "mine.toml", *SHORT, "-o", "first", cwd=made)
    return made


def results(folder):
    """Return what a run says of its law, times aside."""
    found = json.loads((folder / "summary.json").read_text(encoding="utf-8"))["controllers"]["proportional"]
    return {name: value for name, value in found.items() if name != "wall_s"}


def test_runs_again_from_the_cache(folder):
    dwmr("run", "mine.toml", *SHORT, "-o", "second", cwd=folder)
    assert results(folder / "second") == results(folder / "first")


def test_is_loaded_from_the_cache_and_not_compiled_anew(folder):
    code = (
        "from pathlib import Path\nfrom dwmr import controllers\n"
        "law = controllers.find('proportional', Path())\nprint(sum(law.step.stats.cache_hits.values()))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=folder, check=True)
    assert done.stdout == "1\n"


def test_is_compared(folder):
    done = dwmr(
        "compare", "mine.toml", "--controller", "proportional,smc", *SHORT, *ALONE, "--format", "json", cwd=folder
    )
    found = json.loads(done.stdout)["entries"]
    (one,) = [e for e in found if (e["controller"], e["robot"], e["measure"]) == ("proportional", "leader", "rmse.x_e")]
    assert one["mean"] == results(folder / "first")["rmse"]["leader"]["x_e"]


def test_of_one_name_in_two_folders_is_each_its_own(folder):
    other = folder / "other"
    other.mkdir()
    text = (folder / "proportional.py").read_text(encoding="utf-8")
    (other / "proportional.py").write_text(text.replace("= gains[0] *", "= 2.0 * gains[0] *"), encoding="utf-8")
    shutil.copy(folder / "mine.toml", other / "another.toml")
    args = ("--controller", "proportional", *SHORT, *ALONE, "--format", "json")
    for _ in range(2):
        done = dwmr("compare", "mine.toml", "other/another.toml", *args, cwd=folder)
        found = [e["mean"] for e in json.loads(done.stdout)["entries"] if e["measure"] == "rmse.x_e"]
        assert found[0] == results(folder / "first")["rmse"]["leader"]["x_e"]
        assert found[3] < found[0]


def test_that_cannot_be_prepared_is_reported_with_its_error(folder):
    broken = folder / "broken"
    broken.mkdir()
    text = (folder / "proportional.py").read_text(encoding="utf-8")
    (broken / "proportional.py").write_text(text.replace("return Law(", "return 1 // 0, Law("), encoding="utf-8")
    shutil.copy(folder / "mine.toml", broken)
    done = dwmr("compare", "broken/mine.toml", "--controller", "proportional", *SHORT, *ALONE, cwd=folder, status=1)
    assert "the control law proportional cannot be prepared" in done.stderr
    assert "ZeroDivisionError" in done.stderr
    assert "changed" not in done.stderr


def test_is_swept(folder):
    done = dwmr("sweep", "spec.toml", *SHORT, "-o", "swept", cwd=folder)
    assert "2 runs, all to the end" in done.stdout
