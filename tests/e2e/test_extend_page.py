"""The changes of the page "Extend fuzzyctl", applied to a copy of the package."""

import re
import shutil
import subprocess
import sys

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


def run(checkout, *arguments):
    call = [sys.executable, "-m", "fuzzyctl", *arguments]
    done = subprocess.run(call, cwd=checkout, capture_output=True, text=True, encoding="utf-8", check=False)
    assert "Traceback" not in done.stderr, done.stderr
    return done


@pytest.mark.parametrize(("command", "printed"), COMMAND.findall(PAGE))
def test_commands_print_what_the_page_says(checkout, command, printed):
    assert run(checkout, *command.split()).stdout == printed


def test_the_new_check_warns(checkout):
    (checkout / "one.fz").write_text(
        "system s\ninput x in [0, 1]\n  a = cauchy(0, 1)\noutput y in [0, 1]\n  terms low high\n"
        "defuzzifier center_average\nif x is a then y is low\n",
        encoding="utf-8",
    )
    assert "warning[FZ399]: input 'x' has one term" in run(checkout, "check", "one.fz").stderr


@pytest.mark.parametrize(
    "arguments",
    [
        ("check", "dim.fz"),
        ("prove", "dim.fz", "--bounds"),
        ("why", "dim.fz", "light=0.2", "motion=0.8"),
        ("plot", "dim.fz", "-o", "dim.png"),
        ("plot", "dim.fz", "--terms", "-o", "terms.png"),
        ("page", "dim.fz", "-o", "dim.html"),
        *(("codegen", "dim.fz", "--target", t, "-o", f"out-{t}") for t in ("c", "st", "javascript", "python")),
    ],
)
def test_the_new_kind_and_norm_are_known_everywhere(checkout, arguments):
    done = run(checkout, *arguments)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("suffix", ["fis", "fll", "fcl", "fml"])
def test_what_another_format_has_no_word_for_is_said(checkout, suffix):
    done = run(checkout, "convert", "dim.fz", f"dim.{suffix}")
    assert done.returncode == 1
    assert "FZ608" in done.stderr or "cannot be expressed, and changes numbers" in done.stderr
    assert not (checkout / f"dim.{suffix}").exists()


def test_the_new_format_is_written_and_read_back(checkout):
    assert run(checkout, "convert", "lamp.tri", "again.tri").returncode == 0
    assert (checkout / "again.tri").read_text(encoding="utf-8") == (checkout / "lamp.tri").read_text(encoding="utf-8")
    assert "FZ608" in run(checkout, "convert", "dim.fz", "dim.tri").stderr


def test_mistakes_in_the_new_format_are_reported_at_their_places(checkout):
    text = (checkout / "lamp.tri").read_text(encoding="utf-8")
    (checkout / "wrong.tri").write_text(text.replace("is dark", "is drak").replace("0 1 2", "0 1 x"), encoding="utf-8")
    message = run(checkout, "check", "wrong.tri").stderr
    assert "wrong.tri:3:21: error[FZ601]: 'x' is not a number" in message
    assert "wrong.tri:7:13: error[FZ203]: input 'light' has no term 'drak'" in message
