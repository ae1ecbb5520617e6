"""The pages of docs/ and README.md: their examples, and what runs them.

How an example is written:

- ```console: `$ command` lines run one after the other in the page's folder; what stands below a command must be what
  it prints, standard output and standard error together, where `...` matches anything. A command that fails must be
  followed by `$ echo $?`, so that the reader sees it too.
- ```python: doctests where it begins with `>>>`, otherwise plain code; one namespace a page.
- `<!-- file: NAME -->` before a block of any kind: the block is a file that the commands find, and is not run.
- ```fz without a file name: a whole system must pass `fuzzyctl check`; a fragment is completed first (`completed`).
- `<!-- once -->` before ```console: the block is left out when the page is followed again. Its first command must stand
  in a later block as well, which shows what it does then, and runs each time.
- ```toml without a file name must be TOML; ```text and ```json are read by people only.
- ``` without a language is ```fz where it begins with `system`.

Each page begins in an empty folder, the README with a copy of the shipped rules/. How-tos, tutorials and README are
followed twice, the second time over what the first one left; those that take seconds, or write no file, only before a
release (tests/sizes.py). In the test line commands of the project run within the test's process, before a release all
are run by a shell. `follow_pages.py` follows all pages in one folder, with the wheel alone.
"""

from __future__ import annotations

import doctest
import os
import re
import subprocess
import sys
import sysconfig
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fuzzyctl.testing import check_text
from tests.e2e.commands import run_here

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = [*sorted(DOCS.rglob("*.md")), ROOT / "README.md"]

#: Pages that are followed by hand from the first line to the last one, perhaps once more in the same folder.
FOLLOWED = [page for page in PAGES if page.parent.name in ("how-to", "tutorial") or page.parent == ROOT]

#: The lines of README that make the environment the tests run in.
SET_UP = "python3 -m venv"


@dataclass(frozen=True)
class Block:
    """A fenced block: where it begins, its language, its text, the file it is to be written to, and if it runs once."""

    line: int
    language: str
    text: str
    file: str
    once: bool


def blocks(page: Path) -> Iterator[Block]:
    """Yield the fenced blocks of a page."""
    lines = iter(enumerate(page.read_text(encoding="utf-8").splitlines(), start=1))
    file, once = "", False
    for number, line in lines:
        if match := re.fullmatch(r"<!-- file: (\S+) -->", line.strip()):
            file = match[1]
        elif line.strip() == "<!-- once -->":
            once = True
        elif match := re.match(r"( *)```(\w*)", line):
            indent, content = len(match[1]), []
            for _, inner in lines:
                if inner.strip() == "```":
                    break
                content.append(inner[indent:])
            else:
                raise ValueError(f"{page}:{number}: the block is not closed")
            yield Block(number, match[2], "\n".join(content) + "\n", file, once)
            file, once = "", False
        elif line.strip():
            file, once = "", False


def follow(page: Path, folder: Path, times: int = 1) -> None:
    """Run all blocks of a page in a folder, several times in a row."""
    for time in range(times):
        session = Session(page, folder, f" (followed {time} times before)" if time else "")
        found = list(blocks(page))
        for place, block in enumerate(found):
            if not block.once:
                session.run(block)
                continue
            again = block.text.partition("\n")[0]
            is_shown = any(f"\n{again}\n" in f"\n{later.text}" for later in found[place + 1 :] if not later.once)
            assert is_shown, f"{session.where(block)}: the page does not say what '{again}' does the second time"
            if time == 0:
                session.run(block)
        session.end()


def needs(page: Path) -> tuple[str, ...]:
    """Return the packages that the first line below the title of a page installs, such as `fuzzyctl[data]`."""
    line = page.read_text(encoding="utf-8").split("\n", 3)[2]
    return tuple(re.findall(r"`pip install '?([\w\[\]]+)'?`", line))


def written(page: Path) -> Iterator[tuple[str, str]]:
    """Yield the names of the files and folders that a page writes, each with its text or the command that writes it."""
    for block in blocks(page):
        if block.file:
            yield block.file, block.text
        if block.language == "console":
            for part in re.split(r"^\$ ", block.text.replace("\\\n> ", ""), flags=re.MULTILINE)[1:]:
                command, _, printed = part.partition("\n")
                for name in re.findall(r"(?: -o| >) (\S+)", command) + re.findall(
                    r"(?m)^wrote (\S+?):?(?= |$)", printed
                ):
                    yield name, command


def _in_process() -> bool:
    from tests import sizes  # it imports pytest, which followers of pages do not have

    return not sizes.LONG


class Session:
    """Runs the blocks of one page in one folder; remark stands behind their places.

    Commands of the project run within this process, if `in_process` is set, or in the test line if it is None.
    """

    def __init__(self, page: Path, folder: Path, remark: str = "", in_process: bool | None = None) -> None:
        self.page, self.folder, self.remark = page, folder, remark
        self.in_process = _in_process() if in_process is None else in_process
        self.names: dict[str, Any] = {"__name__": "__docs__"}
        self.status = 0

    def run(self, block: Block) -> None:
        """Run one block."""
        if block.file:
            path = self.folder / block.file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text, encoding="utf-8")
            if block.language != "fz":
                return
        if SET_UP in block.text:
            return
        action = getattr(self, f"run_{block.language}", None)
        assert action is not None, f"{self.where(block)}: no rule for a block of language '{block.language}'"
        action(block)

    def where(self, block: Block) -> str:
        """Return the place of a block."""
        page = self.page.relative_to(ROOT) if self.page.is_relative_to(ROOT) else self.page
        return f"{page}:{block.line}{self.remark}"

    def run_text(self, block: Block) -> None:
        """Leave what is for people only."""

    run_json = run_text

    def run_(self, block: Block) -> None:
        """Run a block without a language, as README has them for its first lines."""
        if block.text.startswith("system "):
            self.run_fz(block)

    def run_toml(self, block: Block) -> None:
        """Read it."""
        tomllib.loads(block.text)

    def run_fz(self, block: Block) -> None:
        """Check a whole system, or a fragment within one. Files may hold mistakes: a command shows them."""
        if block.file:
            return
        _, found = check_text(completed(block.text), self.where(block), guarantees=False)
        mistakes = [d for d in found if d.severity == "error"]
        assert not mistakes, "\n".join(map(str, mistakes))

    def run_python(self, block: Block) -> None:
        """Run doctests or plain code."""
        if not block.text.startswith(">>> "):
            exec(compile(block.text, self.where(block), "exec"), self.names)
            return
        test = doctest.DocTestParser().get_doctest(_with_marks(block.text), self.names, self.where(block), None, 0)
        report: list[str] = []
        runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS, verbose=False)
        runner.run(test, out=report.append, clear_globs=False)
        self.names.update(test.globs)
        assert not runner.failures, "".join(report)

    def run_console(self, block: Block) -> None:
        """Run the commands and compare what they print."""
        parts = re.split(r"^\$ ", block.text, flags=re.MULTILINE)
        assert not parts[0].strip(), f"{self.where(block)}: a console block begins with '$ '"
        for part in parts[1:]:
            command, _, wanted = part.partition("\n")
            while command.endswith("\\"):
                more, _, wanted = wanted.partition("\n")
                command = f"{command[:-1]}{more.removeprefix('>')}"
            if command != "echo $?":
                assert self.status == 0, f"{self.where(block)}: the command before '{command}' left with {self.status}"
            got = self.shell(command)
            same = doctest.OutputChecker().check_output(_trimmed(wanted), _trimmed(got), doctest.ELLIPSIS)
            assert same, f"{self.where(block)}: $ {command}\n--- the page says\n{wanted}--- it printed\n{got}"

    def shell(self, command: str) -> str:
        """Run one command of a shell session and return what it prints."""
        environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONWARNINGS", "FORCE_COLOR")}
        scripts = os.pathsep.join([sysconfig.get_path("scripts"), os.environ.get("PATH", "")])
        shown = {"NO_COLOR": "1", "COLUMNS": "160", "MPLBACKEND": "Agg", "PYTHONUTF8": "1"}
        if self.in_process and (found := run_here(command, shown)):
            self.status, printed = found
            return printed
        environment |= {"PATH": scripts, "VIRTUAL_ENV": sys.prefix, **shown}
        done = subprocess.run(
            ["/bin/sh", "-c", f"(exit {self.status}); {command}"],
            cwd=self.folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=300,
            check=False,
        )
        self.status = done.returncode
        return done.stdout.decode()

    def end(self) -> None:
        """Refuse a last command that failed unseen."""
        assert self.status == 0, f"the last command left with {self.status}; show it with '$ echo $?'"


def _with_marks(text: str) -> str:
    """Mark the empty lines within printed text as doctests want them; those before `>>>` end it."""
    return re.sub(r"\n(?=\n+(?!>>> |\n|\Z))", "\n<BLANKLINE>", text)


def _trimmed(text: str) -> str:
    return "\n".join(line.rstrip() for line in text.splitlines()).strip("\n") + "\n"


def completed(text: str) -> str:
    """Complete a fragment of a rule file to a whole system.

    Whatever the fragment does not declare is added: `system example`, the inputs `e` and `de` and the output `u`, each
    with the terms N, Z and P over [-1, 1], and rules that use every term of the output.
    """
    own = re.split(r"^(?:controller|plant|loop) ", text, maxsplit=1, flags=re.MULTILINE)[0]  # without other blocks
    lines = re.sub(r"#.*", "", own).splitlines()
    keywords = {line.split()[0] for line in lines if line.strip()}
    names = {kind: [m[1] for line in lines if (m := re.match(rf"{kind} (\w+)", line))] for kind in ("input", "output")}
    added = []
    if "system" not in keywords:
        added.append("system example")
    if not names["input"]:
        added += ["input e in [-1, 1]", "terms N Z P", "input de in [-1, 1]", "terms N Z P"]
    if not names["output"]:
        added += ["output u in [-1, 1] else 0", "terms N Z P"]
    if not keywords & {"if", "table", "otherwise"}:
        head = "e is N"
        if names["input"]:
            head = f"{names['input'][0]} is {_terms(lines, 'input', names['input'][0])[0]}"
        for name, terms in [(o, _terms(lines, "output", o)) for o in names["output"]] or [("u", ["N", "Z", "P"])]:
            added += [f"if {head} then {name} is {term}" for term in terms]
            added.append(f"if not {head} then {name} is {terms[0]}")
    return "\n".join([text.rstrip("\n"), *added, ""])


def _terms(lines: list[str], kind: str, name: str) -> list[str]:
    """Return the terms of a variable: those of its `terms` lines, and of its lines `NAME = ...`."""
    below = iter(lines)
    next(line for line in below if re.match(rf"{kind} {name}\b", line))
    found: list[str] = []
    for line in below:
        if match := re.match(r" +terms (.*)", line):
            found += re.findall(r"(?:^| )([^\W\d]\w*)", match[1])
        elif match := re.match(r" +(\w+) *=", line):
            found.append(match[1])
        elif line.strip():
            break
    return found


def without_code(page: Path) -> str:
    text = page.read_text(encoding="utf-8")
    return re.sub(r"^( *)```.*?^ *```$", "", text, flags=re.MULTILINE | re.DOTALL)


def anchors(page: Path) -> set[str]:
    headings = re.findall(r"^#+ (.+)$", without_code(page), flags=re.MULTILINE)
    plain = [re.sub(r"[^\w\- ]", "", h.replace("`", "").lower()) for h in headings]
    return {h.replace(" ", "-") for h in plain}
