"""Hooks of pre-commit and the action for GitHub: their commands do what they say; the services are not run."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parent.parent.parent
HOOKS = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())
ACTION = yaml.safe_load((ROOT / "action.yml").read_text())
BROKEN = "system t\ninput x in [0, 1]\n  terms N P\noutput y in [0,1] else 0\n  terms a b\nif x is M then y is a\n"


def fuzzyctl(words, *files):
    assert words[0] == "fuzzyctl"
    command = [sys.executable, "-m", *words, *map(str, files)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "a.fz"
    path.write_text(BROKEN)
    return path


def test_hooks(path):
    entries = [hook["entry"].split() for hook in HOOKS]
    check, fmt = (fuzzyctl(words, path) for words in entries)
    assert (check.returncode, "has no term 'M'" in check.stderr) == (1, True)
    assert (fmt.returncode, "in [0, 1] else 0" in path.read_text()) == (0, True)
    (pattern,) = {hook["files"] for hook in HOOKS}
    assert re.search(pattern, "rules/a.fz")
    assert not re.search(pattern, "a.fzz")


class TestAction:
    @pytest.fixture
    def repository(self, tmp_path):
        if shutil.which("git") is None or shutil.which("bash") is None:
            pytest.skip("no git or no bash")
        (tmp_path / "deep").mkdir()
        (tmp_path / "deep" / "a b.fz").write_text(BROKEN)
        (tmp_path / "good.fz").write_text(BROKEN.replace("is M", "is N"))
        for words in (["init", "-q"], ["add", "."]):
            subprocess.run(["git", *words], cwd=tmp_path, check=True)
        return tmp_path

    def run(self, folder, files, arguments=""):
        """Run the last step as the service does: its inputs are variables of the environment."""
        step = ACTION["runs"]["steps"][-1]
        given = {"inputs.files": files, "inputs.arguments": arguments}
        inputs = {name: re.sub(r"\$\{\{ (.+) \}\}", lambda m: given[m[1]], x) for name, x in step["env"].items()}
        path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
        words = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]]
        return subprocess.run(
            words, cwd=folder, env={**os.environ, **inputs, "PATH": path}, capture_output=True, text=True, check=False
        )

    def test_it_annotates_files_in_all_folders(self, repository):
        done = self.run(repository, ACTION["inputs"]["files"]["default"])
        assert done.returncode != 0
        (line,) = re.findall("^::error .+", done.stdout, re.M)
        place = r"file=deep/a b\.fz,line=6,endLine=6,col=9,endColumn=9,title=FZ203%3A [^:]+"
        assert re.fullmatch(f"::error {place}::input 'x' has no term 'M'.+", line)

    def test_patterns_and_arguments_are_words(self, repository):
        done = self.run(repository, "good.fz missing*.fz good*")
        assert (done.returncode, done.stdout, "missing" in done.stderr) == (1, "", True)
        for arguments, passes in (("", True), ("--deny warnings", False)):
            done = self.run(repository, "g*.fz good*", arguments)
            assert ((done.returncode == 0), "file=good.fz" in done.stdout) == (passes, True)

    def test_inputs_are_variables_and_no_part_of_a_command(self):
        for step in ACTION["runs"]["steps"]:
            assert "${{" not in step.get("run", "")
            assert ("run" in step) == ("shell" in step) != ("uses" in step)
            for value in step.get("env", {}).values():
                assert set(re.findall(r"inputs\.(\w+)", value)) <= set(ACTION["inputs"])
