"""What commands print and leave behind: transcripts/NAME.txt, with each answer below its command.

`==== LAW` begins a section in a folder of its own, with `base.fz` of conftest.py and the files above the first section:

- `NAME:` and indented lines are a file, `NAME = OTHER: OLD => NEW ;; ...` is another one with changed parts;
- `$ COMMAND` is run. Below it are standard output after `>`, standard error after `!` without the lines on how to use a
  command, and the exit code after `=` if it is not 0. `< FILE` at its end is standard input, `| TEXT` keeps the lines
  with a text, and `A=B` in front is a variable of the environment. `cat FILE`, `ls` and `mkdir FOLDER` exist as well.

After an intended change: FUZZYCTL_UPDATE_GOLDEN=1 python -m pytest tests/fuzzyctl/cli/test_transcripts.py, then read
the difference.
"""

import os
import re
import shlex
from pathlib import Path

import pytest

from fuzzyctl.testing import run_command

FOLDER = Path(__file__).parent / "transcripts"
LINE = re.compile(r"(?P<values>(?:[A-Z_]+=\S* )*)(?P<words>.*?)(?: < (?P<stdin>\S+))?(?: \| (?P<kept>.+))?")
LEFT_OUT = ("> ", "! ", "= ", ">\n", "!\n")


def parts_of(text):
    """Return the lines of a section as files and commands: each with its own lines first."""
    lines = [line for line in text.splitlines(keepends=True) if not line.startswith(LEFT_OUT)]
    parts = []
    for line in lines:
        if parts and (line.startswith("    ") or not line.strip()):
            parts[-1] += line
        else:
            parts.append(line)
    return parts


def make(part, folder):
    """Write a file of a section."""
    head, _, rest = part.partition("\n")
    if copied := re.fullmatch(r"(\S+) = (\S+): (.*)", head):
        name, other, changes = copied.groups()
        text = (folder / other).read_bytes().decode()
        for change in changes.split(" ;; "):
            old, new = (x.replace("\\n", "\n").replace("\\r", "\r") for x in re.split(" =>(?: |$)", change))
            assert old in text, f"{other} has no '{old}'"
            text = text.replace(old, new)
    else:
        name, text = head.removesuffix(":"), re.sub("^    ", "", rest.rstrip("\n"), flags=re.MULTILINE) + "\n"
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(text.encode())


def answer(command, folder):
    """Return the lines that a command prints, with their marks."""
    form = LINE.fullmatch(command)
    name, *words = shlex.split(form["words"])
    if name == "fuzzyctl":
        stdin = (folder / form["stdin"]).read_bytes().decode() if form["stdin"] else None
        values = {"COLUMNS": "100", **dict(v.split("=") for v in form["values"].split())}
        done = run_command(*words, stdin=stdin, folder=folder, **values)
        output, code = done.output, done.exit_code
        errors = re.sub(r"^Usage: .*\nTry .*\n\n", "", done.errors)
    else:
        output, errors, code = {"cat": cat, "ls": ls, "mkdir": mkdir}[name](folder, *words), "", 0
    lines = [*(f"> {x}" for x in output.splitlines()), *(f"! {x}" for x in errors.splitlines())]
    kept = [x.rstrip() for x in lines if (form["kept"] or "") in x]
    return [*(kept or ["> nothing"] * bool(form["kept"])), *([f"= {code}"] if code else [])]


def cat(folder, *names):
    return "".join(
        path.read_text() if path.exists() else f"no file {path.name}\n" for path in map(folder.joinpath, names)
    )


def ls(folder):
    return " ".join(sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())) + "\n"


def mkdir(folder, name):
    (folder / name).mkdir()
    return ""


def written(text, base, folder):
    """Return a transcript with the answers of today."""
    shared, *sections = re.split(r"^(?===== )", text, flags=re.MULTILINE)
    found = [shared]
    for number, section in enumerate(sections):
        title, _, rest = section.partition("\n")
        here = folder / str(number)
        here.mkdir()
        (here / "base.fz").write_text(base, encoding="utf-8")
        for part in parts_of(shared):
            make(part, here)
        found.append(f"{title}\n")
        for part in parts_of(rest):
            found.append(part)
            if part.startswith("$ "):
                command, end = part.rstrip("\n"), part[len(part.rstrip("\n")) + 1 :]
                found[-1] = "\n".join([command, *answer(command[2:], here)]) + "\n" + end
            elif part.strip():
                make(part, here)
    return "".join(found)


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.txt")), ids=lambda p: p.stem)
def test_commands_answer_as_written(path, base, tmp_path, monkeypatch):
    monkeypatch.setenv("NO_COLOR", "1")
    found = written(path.read_text(encoding="utf-8"), base, tmp_path)
    if os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
        path.write_text(found, encoding="utf-8")
    assert path.read_text(encoding="utf-8") == found
