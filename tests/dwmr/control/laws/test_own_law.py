"""A law of one's own, as the how-to page has it: run, compared and swept over one cache."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.dwmr.process import dwmr, in_short

PAGE = Path(__file__).parents[4] / "docs" / "how-to" / "add-a-controller.md"
BLOCK = re.compile(r"<!-- file: (\S+) -->\n```\w+\n(.*?)```", re.DOTALL)
SWEEP = 'scenario = "mine.toml"\nmeasures = ["rmse"]\n[grid]\n"robot.controllers.proportional.k_x" = [0.5, 0.6]\n'
SHORT = ("--set", "run.horizon=1")
ALONE = ("--jobs", "1")
TIME, X = "proportional/t", "proportional/x"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The files of the how-to page, after a first run, whose machine code is on disk."""
    made = tmp_path_factory.mktemp("own")
    for name, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        (made / name).write_text(text, encoding="utf-8")
    (made / "spec.toml").write_text(SWEEP, encoding="utf-8")
    in_short("run", "mine.toml", *SHORT, "-o", "first", cwd=made)
    return made


def results(folder):
    """Return what a run says of its law, times aside."""
    found = json.loads((folder / "summary.json").read_text(encoding="utf-8"))["controllers"]["proportional"]
    return {name: value for name, value in found.items() if name != "wall_s"}


def test_runs_again_from_the_cache_and_is_not_compiled_anew(folder):
    code = (
        "import sys\nfrom pathlib import Path\n"
        "from dwmr.cli.main import main\nfrom dwmr.control.laws import python_law\n"
        "try:\n    main(sys.argv[1:])\nexcept SystemExit as stop:\n    assert not stop.code\n"
        "law = python_law.load('proportional', Path('proportional.py').resolve())\n"
        "print(sum(law.step.stats.cache_hits.values()))\n"
    )
    words = [sys.executable, "-c", code, "run", "mine.toml", *SHORT, "-o", "second"]
    done = subprocess.run(words, capture_output=True, text=True, cwd=folder, check=True)
    assert done.stdout.splitlines()[-1] == "1"
    assert results(folder / "second") == results(folder / "first")


def test_is_compared(folder):
    done = in_short(
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
        done = in_short("compare", "mine.toml", "other/another.toml", *args, cwd=folder)
        found = [e["mean"] for e in json.loads(done.stdout)["entries"] if e["measure"] == "rmse.x_e"]
        assert found[0] == results(folder / "first")["rmse"]["leader"]["x_e"]
        assert found[3] < found[0]


def test_is_swept(folder):
    done = in_short("sweep", "spec.toml", *SHORT, "-o", "swept", cwd=folder)
    assert "2 runs, all to the end" in done.stdout


#: Where a law raises: the text behind which, or for which, a line is put, and what cannot be done then.
STAGES = {
    "imported": ("import numpy as np\n", "import numpy as np\n\n{}\n"),
    "checked": ("def init(", "    def prove(self, rules, robot):\n        {}\n\n\ndef init("),
    "prepared": ("    return Law(", "    {}\n    return Law("),
    "run": ("    signals[0] = effort\n", "    signals[0] = effort\n    {}\n"),
}


def raising(folder, name, stage, statement):
    """Write the law and its scenario into a folder of their own, with a statement put into the law."""
    made = folder / name
    made.mkdir()
    old, new = STAGES[stage]
    text = (folder / "proportional.py").read_text(encoding="utf-8")
    assert old in text
    (made / "proportional.py").write_text(text.replace(old, new.format(statement)), encoding="utf-8")
    shutil.copy(folder / "mine.toml", made)
    return made


#: Each stage and each error once in the test line, all pairs of them before a release.
RAISING = [
    pytest.param(stage, statement, marks=[] if i % 3 == j else [pytest.mark.long])
    for i, stage in enumerate(STAGES)
    for j, statement in enumerate(["raise SystemExit(3)", "raise KeyboardInterrupt", "1 // 0"])
]


@pytest.mark.parametrize(("stage", "statement"), RAISING)
def test_that_raises_is_reported_with_its_file_and_line(folder, stage, statement, monkeypatch):
    if stage == "run":
        monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")  # compiled code has no such exceptions
    made = raising(folder, f"{stage}_{statement.split()[-1][:4]}", stage, statement)
    # Numba has read its variables in this process.
    run = dwmr if stage == "run" else in_short
    done = run("run", "mine.toml", "--set", "run.horizon=0.02", "-o", "out", cwd=made, status=1)
    lines = (made / "proportional.py").read_text(encoding="utf-8").splitlines()
    line = 1 + next(i for i, text in enumerate(lines) if text.strip() == statement)
    kind = {"1": "ZeroDivisionError"}.get(statement[0], statement.removeprefix("raise ").partition("(")[0])
    column = lines[line - 1].index(statement) + 1
    message = f"proportional.py:{line}:{column}: error[FZ001]: the control law proportional cannot be {stage}"
    assert message in done.stderr
    assert f"= {kind}: " in done.stderr
    assert "Traceback" not in done.stderr


def test_that_raises_in_compiled_code_names_its_line_and_keeps_what_was_recorded(folder):
    made = raising(folder, "compiled", "run", "if error.t > 0.5 and error.d > 0.1: gains[9] = 1.0 / signals.size")
    done = in_short("run", "mine.toml", *SHORT, "-o", "out", cwd=made, status=1)
    lines = (made / "proportional.py").read_text(encoding="utf-8").splitlines()
    (line,) = (k for k, text in enumerate(lines, 1) if "gains[9]" in text)
    column = lines[line - 1].index("gains[9]") + 1
    message = f"proportional.py:{line}:{column}: error[FZ001]: the control law proportional cannot be run"
    assert done.stderr.startswith(message)
    assert done.stderr.count("= IndexError: index 9 is out of bounds") == 1
    assert "there, of robot follower1: x_e = " in done.stderr
    summary = json.loads((made / "out" / "summary.json").read_text(encoding="utf-8"))
    stopped = summary["controllers"]["proportional"]["stopped"]
    assert (stopped["t"], stopped["robot"]) == (0.505, "follower1")
    with np.load(made / "out" / "trajectory.npz") as data, np.load(folder / "first" / "trajectory.npz") as whole:
        assert data[TIME].tolist() == whole[TIME].tolist()[:26]  # periods before the error, and none after it
        assert data[X].tolist() == whole[X].tolist()[:26]
    swept = in_short("compare", "mine.toml", "--controller", "proportional", *SHORT, cwd=made, status=1)
    assert "mine.toml cannot be computed" in swept.stderr
    assert "IndexError: index 9" in swept.stderr


def test_an_interruption_while_a_law_works_stays_one(folder):
    made = raising(folder, "interrupted", "checked", "signal.raise_signal(signal.SIGINT)")
    law = made / "proportional.py"
    law.write_text("import signal\n" + law.read_text(encoding="utf-8"), encoding="utf-8")
    done = in_short("run", "mine.toml", *SHORT, "-o", "out", cwd=made, status=130)
    assert done.stderr == "interrupted\n"
