"""The changes of the page "Extend fuzzyctl", applied to a copy of the package."""

import json
import os
import re
import shutil
import subprocess
import sys
from types import SimpleNamespace

import pytest

from tests.e2e.pages import DOCS, ROOT

PAGE = (DOCS / "how-to" / "extend-fuzzyctl.md").read_text(encoding="utf-8")
ADDITION = re.compile(r"<!-- add to: (\S+) (above|below): (.*?) -->\n```text\n(.*?)```\n", re.DOTALL)
FILE = re.compile(r"<!-- file: (\S+) -->\n```\w+\n(.*?)```\n", re.DOTALL)
COMMAND = re.compile(r"^\$ fuzzyctl (.*)\n((?:(?!\$ |```).*\n)*)", re.MULTILINE)


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    """A copy of the package with the changes of the page."""
    folder = tmp_path_factory.mktemp("checkout")
    shutil.copytree(ROOT / "fuzzyctl", folder / "fuzzyctl", ignore=shutil.ignore_patterns("__pycache__"))
    for name, text in FILE.findall(PAGE):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    for name, side, line, addition in ADDITION.findall(PAGE):
        path = folder / name
        text = path.read_text(encoding="utf-8")
        before, found, after = text.partition(line)
        assert text.count(line) == 1, f"{name} has no single line {line}"
        rest, end, after = (found + after).partition("\n")
        text = before + rest + end + addition + after if side == "below" else before + addition + rest + end + after
        path.write_text(text, encoding="utf-8")
    return folder


#: Runs commands one after the other; each line is the arguments of one, and is answered by a line.
SERVER = """
import json, sys
from fuzzyctl.testing import run_command
for line in sys.stdin:
    done = run_command(*json.loads(line))
    print(json.dumps([done.exit_code, done.output, done.errors]), flush=True)
"""


@pytest.fixture(scope="module")
def run(checkout):
    """Return a function that runs a command in the changed package, all of them in one process."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "encoding": "utf-8"}
    environment = {**os.environ, "PYTHONPATH": str(checkout), "PYTHONUTF8": "1", "MPLBACKEND": "Agg"}
    with subprocess.Popen([sys.executable, "-c", SERVER], cwd=checkout, env=environment, **pipes) as server:

        def run(*arguments):
            server.stdin.write(json.dumps(arguments) + "\n")
            server.stdin.flush()
            return SimpleNamespace(
                **dict(zip(("code", "output", "errors"), json.loads(server.stdout.readline()), strict=True))
            )

        yield run
        server.stdin.close()


@pytest.mark.parametrize(("command", "printed"), COMMAND.findall(PAGE))
def test_commands_print_what_the_page_says(run, command, printed):
    assert run(*command.split()).output == printed


def test_the_new_check_warns(run, checkout):
    (checkout / "one.fz").write_text(
        "system s\ninput x in [0, 1]\n  a = cauchy(0, 1)\noutput y in [0, 1]\n  terms low high\n"
        "defuzzifier center_average\nif x is a then y is low\n",
        encoding="utf-8",
    )
    assert "warning[FZ399]: input 'x' has one term" in run("check", "one.fz").errors


@pytest.mark.parametrize(
    "arguments",
    [
        ("check", "dim.fz"),
        ("prove", "dim.fz", "--bounds", "--timeout", "0.5"),
        ("why", "dim.fz", "light=0.2", "motion=0.8"),
        ("plot", "dim.fz", "-o", "dim.png"),
        ("plot", "dim.fz", "--terms", "-o", "terms.png"),
        ("page", "dim.fz", "-o", "dim.html"),
        *(("codegen", "dim.fz", "--target", t, "-o", f"out-{t}") for t in ("c", "st", "javascript", "python")),
    ],
)
def test_the_new_kind_and_norm_are_known_everywhere(run, arguments):
    done = run(*arguments)
    assert done.code == 0, done.output + done.errors


@pytest.mark.parametrize("suffix", ["fis", "fll", "fcl", "fml"])
def test_what_another_format_has_no_word_for_is_said(run, checkout, suffix):
    done = run("convert", "dim.fz", f"dim.{suffix}")
    assert done.code == 1
    assert "FZ608" in done.errors or "cannot be expressed, and changes numbers" in done.errors
    assert not (checkout / f"dim.{suffix}").exists()


def test_the_new_format_is_written_and_read_back(run, checkout):
    assert run("convert", "lamp.tri", "again.tri").code == 0
    assert (checkout / "again.tri").read_text(encoding="utf-8") == (checkout / "lamp.tri").read_text(encoding="utf-8")
    assert "FZ608" in run("convert", "dim.fz", "dim.tri").errors


def test_mistakes_in_the_new_format_are_reported_at_their_places(run, checkout):
    text = (checkout / "lamp.tri").read_text(encoding="utf-8")
    (checkout / "wrong.tri").write_text(text.replace("is dark", "is drak").replace("0 1 2", "0 1 x"), encoding="utf-8")
    message = run("check", "wrong.tri").errors
    assert "wrong.tri:3:21: error[FZ601]: 'x' is not a number" in message
    assert "wrong.tri:7:13: error[FZ203]: input 'light' has no term 'drak'" in message
