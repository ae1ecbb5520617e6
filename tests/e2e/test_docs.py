"""Runs every example of docs/ and README.md, and holds the reference pages to the code they describe.

How an example is written:

- ```console: `$ command` lines run one after the other in the page's folder; what stands below a command must be what
  it prints, standard output and standard error together, where `...` matches anything. A command that fails must be
  followed by `$ echo $?`, so that the reader sees it too.
- ```python: doctests where it begins with `>>>`, otherwise plain code; one namespace a page.
- `<!-- file: NAME -->` before a block of any kind: the block is a file that the commands find, and is not run.
- ```fz without a file name: a whole system must pass `fuzzyctl check`; a fragment is completed first (`completed`).
- ```toml without a file name must be TOML; ```text and ```json are read by people only.
- ``` without a language is ```fz where it begins with `system`.

Each page begins in an empty folder with a copy of the shipped rules/.
"""

from __future__ import annotations

import doctest
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

import click
import pytest
from pydantic import BaseModel

import fuzzyctl
from dwmr.cli.main import main as dwmr_commands
from dwmr.scenario import Scenario
from fuzzyctl import build, errors, expr, formulas
from fuzzyctl.assembly import MAX_FILES
from fuzzyctl.checking import check_source
from fuzzyctl.cli.main import main as fuzzyctl_commands
from fuzzyctl.lang import syntax
from fuzzyctl.lang.builder import MAX_NAME
from fuzzyctl.lang.grammar import grammar_text
from fuzzyctl.lang.parser import parse
from fuzzyctl.model.method import ACTIVATIONS, DEFUZZIFIERS, Grid
from fuzzyctl.model.profiles import PROFILES
from fuzzyctl.model.variable import Fallback
from fuzzyctl.resolve.claims import FORMS
from fuzzyctl.resolve.defuzzifiers import RESOLUTIONS
from fuzzyctl.resolve.rules import MAX_OUTPUTS, MAX_RULES
from fuzzyctl.resolve.variables import MAX_TERMS
from fuzzyctl.source import SourceText

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = [*sorted(DOCS.rglob("*.md")), ROOT / "README.md"]

#: The lines of README that make the environment the tests run in.
SET_UP = "python3 -m venv"


@dataclass(frozen=True)
class Block:
    """A fenced block: where it begins, its language, its text, and the file it is to be written to."""

    line: int
    language: str
    text: str
    file: str


def blocks(page: Path) -> Iterator[Block]:
    """Yield the fenced blocks of a page."""
    lines = iter(enumerate(page.read_text(encoding="utf-8").splitlines(), start=1))
    file = ""
    for number, line in lines:
        if match := re.fullmatch(r"<!-- file: (\S+) -->", line.strip()):
            file = match[1]
        elif match := re.match(r"( *)```(\w*)", line):
            indent, content = len(match[1]), []
            for _, inner in lines:
                if inner.strip() == "```":
                    break
                content.append(inner[indent:])
            else:
                raise ValueError(f"{page}:{number}: the block is not closed")
            yield Block(number, match[2], "\n".join(content) + "\n", file)
            file = ""
        elif line.strip():
            file = ""


class Session:
    """Runs the blocks of one page in one folder."""

    def __init__(self, page: Path, folder: Path) -> None:
        self.page, self.folder = page, folder
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
        return f"{self.page.relative_to(ROOT)}:{block.line}"

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
        _, found = check_source(SourceText(self.where(block), completed(block.text)), guarantees=False)
        mistakes = [d for d in found if d.severity == "error"]
        assert not mistakes, errors.render_all(mistakes)

    def run_python(self, block: Block) -> None:
        """Run doctests or plain code."""
        if not block.text.startswith(">>> "):
            exec(compile(block.text, self.where(block), "exec"), self.names)
            return
        test = doctest.DocTestParser().get_doctest(block.text, self.names, self.where(block), None, 0)
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
        environment |= {"PATH": scripts, "NO_COLOR": "1", "COLUMNS": "160", "MPLBACKEND": "Agg", "PYTHONUTF8": "1"}
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


def _trimmed(text: str) -> str:
    return "\n".join(line.rstrip() for line in text.splitlines()).strip("\n") + "\n"


def completed(text: str) -> str:
    """Complete a fragment of a rule file to a whole system.

    Whatever the fragment does not declare is added: `system example`, the inputs `e` and `de` and the output `u`, each
    with the terms N, Z and P over [-1, 1], and rules that use every term of the output.
    """
    tree, _ = parse(SourceText("fragment", text))
    kinds = {type(s) for s in tree.statements}
    inputs = [s for s in tree.statements if isinstance(s, syntax.Variable) and s.keyword.text == "input"]
    outputs = [s for s in tree.statements if isinstance(s, syntax.Variable) and s.keyword.text == "output"]
    added = []
    if syntax.System not in kinds:
        added.append("system example")
    if not inputs:
        added += ["input e in [-1, 1]", "terms N Z P", "input de in [-1, 1]", "terms N Z P"]
    if not outputs:
        added += ["output u in [-1, 1] else 0", "terms N Z P"]
    if not kinds & {syntax.Rule, syntax.Table}:
        head = "e is N"
        if inputs:
            head = f"{inputs[0].name.text} is {_terms(inputs[0])[0]}"
        for name, terms in [(o.name.text, _terms(o)) for o in outputs] or [("u", ["N", "Z", "P"])]:
            added += [f"if {head} then {name} is {term}" for term in terms]
            added.append(f"if not {head} then {name} is {terms[0]}")
    return "\n".join([text.rstrip("\n"), *added, ""])


def _terms(variable: syntax.Variable) -> list[str]:
    names: list[str] = []
    for line in variable.terms:
        names += [i.name.text for i in line.items] if isinstance(line, syntax.TermsLine) else [line.name.text]
    return names


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_every_example_of_a_page_does_what_the_page_says(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(ROOT / "rules", tmp_path / "rules")
    (tmp_path / ".venv").symlink_to(sys.prefix)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    session = Session(page, tmp_path)
    for block in blocks(page):
        session.run(block)
    session.end()


class TestTheRunnerItself:
    """A runner that lets everything pass would be worse than none."""

    @pytest.mark.parametrize(
        "text",
        [
            "```console\n$ echo one\ntwo\n```\n",
            "```console\n$ false\n$ echo on\non\n```\n",
            "```console\n$ false\n```\n",
            "```python\n>>> 1 + 1\n3\n```\n",
            "```python\nassert 1 + 1 == 3\n```\n",
            "```fz\nparam a = missing\n```\n",
            "```fz\nthis is nothing\n```\n",
            "```toml\na = \n```\n",
            "```ruby\nputs 1\n```\n",
        ],
    )
    def test_a_broken_example_fails(self, text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
        with pytest.raises((AssertionError, tomllib.TOMLDecodeError)):
            self.run(text, tmp_path)

    @pytest.mark.parametrize(
        "text",
        [
            "```console\n$ echo one two\none ...\n$ false\n$ echo $?\n1\n```\n",
            "```python\na = 1\n```\n\n```python\n>>> a + 1\n2\n```\n",
            "<!-- file: a.txt -->\n```text\nhello\n```\n\n```console\n$ cat a.txt\nhello\n```\n",
            "```fz\nparam a = 1  # used by nothing\n```\n",
        ],
    )
    def test_a_right_example_passes(self, text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
        self.run(text, tmp_path)

    def run(self, text: str, folder: Path) -> None:
        page = folder / "page.md"
        page.write_text(text, encoding="utf-8")
        session = Session(ROOT / "docs" / "page.md", folder)
        for block in blocks(page):
            session.run(block)
        session.end()


def _without_code(page: Path) -> str:
    text = page.read_text(encoding="utf-8")
    return re.sub(r"^( *)```.*?^ *```$", "", text, flags=re.MULTILINE | re.DOTALL)


def _anchors(page: Path) -> set[str]:
    headings = re.findall(r"^#+ (.+)$", _without_code(page), flags=re.MULTILINE)
    plain = [re.sub(r"[^\w\- ]", "", h.replace("`", "").lower()) for h in headings]
    return {h.replace(" ", "-") for h in plain}


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_every_relative_link_leads_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", _without_code(page)):
        if "://" in target or target.startswith("mailto:"):
            continue
        name, _, anchor = target.partition("#")
        path = (page.parent / name).resolve() if name else page
        assert path.exists(), f"{page}: {target} leads nowhere"
        if anchor:
            assert anchor in _anchors(path), f"{page}: {target}: {path.name} has no such heading"


def _reference(name: str) -> str:
    return (DOCS / "reference" / name).read_text(encoding="utf-8")


def _options(text: str) -> set[str]:
    return set(re.findall(r"(?<![\w-])--?[a-z][\w-]*", text))


class TestReference:
    """The reference pages name what there is, and nothing else."""

    def test_the_index_links_every_page(self) -> None:
        # The pages of the diagnostic codes hang below their own index.
        indexes = [DOCS / "index.md", DOCS / "reference" / "diagnostics.md"]
        linked = {
            (index.parent / t).resolve()
            for index in indexes
            for t in re.findall(r"\]\(([^)#]+)", index.read_text(encoding="utf-8"))
        }
        assert {p for p in DOCS.rglob("*.md") if p.name != "index.md"} <= linked

    def test_every_diagnostic_code_is_listed_with_its_title(self) -> None:
        form = r"^\| \[(FZ\d{3})\]\(diagnostics/\1\.md\) \| ([^|]+?) \|"
        rows = dict(re.findall(form, _reference("diagnostics.md"), flags=re.MULTILINE))
        assert rows == errors.CODES

    @pytest.mark.parametrize("program", ["fuzzyctl", "dwmr"])
    def test_the_options_of_every_command_are_those_it_has(self, program: str) -> None:
        group = {"fuzzyctl": fuzzyctl_commands, "dwmr": dwmr_commands}[program]
        assert isinstance(group, click.Group)
        sections = dict(re.findall(r"^## (.+?)\n(.*?)(?=^## |\Z)", _reference("commands.md"), flags=re.M | re.S))
        described = {title.strip("`") for title in sections if title.startswith(f"`{program} ")}
        assert described == {f"{program} {name}" for name in group.commands}
        for name, command in group.commands.items():
            text = re.sub(r"^```.*?^```$", "", sections[f"`{program} {name}`"], flags=re.M | re.S)
            has = {o for p in command.params if isinstance(p, click.Option) for o in p.opts}
            rows = "\n".join(re.findall(r"^\| (`-.*?) \|", text, flags=re.MULTILINE))
            assert _options(rows) == has, f"{program} {name}"
            assert _options(text) == has, f"{program} {name}"

    def test_every_public_name_is_described(self) -> None:
        text = _reference("api.md")
        assert [n for n in fuzzyctl.__all__ if f"`{n}" not in text and f".{n}" not in text] == []

    def test_every_word_of_the_language_is_described(self) -> None:
        keywords = re.findall(r"^[A-Z_]+\.\d: /(\w+)", grammar_text(), flags=re.MULTILINE)
        assert set(syntax.STATEMENT_KEYWORDS) <= set(keywords)
        words = [
            *keywords,
            *syntax.RESERVED,
            *formulas.CONJUNCTIONS,
            *formulas.DISJUNCTIONS,
            *formulas.IMPLICATIONS,
            *formulas.AGGREGATIONS,
            *formulas.HEDGES,
            *ACTIVATIONS,
            *DEFUZZIFIERS,
            *PROFILES,
            *FORMS,
            *get_args(Fallback),
            *get_args(Grid),
            *expr.FUNCTIONS,
            *expr.CONSTANTS,
        ]
        page = _without_code(DOCS / "reference" / "language.md")
        shown = set(re.findall(r"\w+", " ".join(re.findall(r"`([^`\n]+)`", page))))
        assert [w for w in words if w not in shown] == []

    def test_every_membership_function_is_described_with_its_parameters(self) -> None:
        rows = dict(re.findall(r"^\| `(\w+)\(([^`]*)\)` \|", _reference("language.md"), flags=re.MULTILINE))
        for name, formula in formulas.MEMBERSHIP.items():
            assert rows[name].startswith(", ".join(formula.parameters)), name
            assert rows[name].endswith("...") == formula.variadic, name

    def test_every_hedge_is_described_with_its_formula(self) -> None:
        rows = dict(re.findall(r"^\| `(\w+)` \| ([^|]+) \|$", _reference("language.md"), flags=re.MULTILINE))
        assert {name: rows.get(name) for name in formulas.HEDGES} == formulas.HEDGE_SUMMARIES

    def test_the_limits_are_those_of_the_code(self) -> None:
        text = _reference("language.md").split("## Limits")[1].split("##")[0].replace("\u00a0", " ")
        limits = [expr.MAX_DEPTH, MAX_NAME, MAX_TERMS, MAX_OUTPUTS, MAX_RULES, MAX_FILES, RESOLUTIONS[1]]
        assert [n for n in limits if f"| {n:,}".replace(",", " ") not in text and f"| {n}" not in text] == []

    def test_every_name_of_the_build_module_is_described(self) -> None:
        text = _reference("api.md")
        assert [n for n in build.__all__ if f"`build.{n}(" not in text] == []

    def test_every_shipped_rule_file_is_described(self) -> None:
        text = _reference("rule-files.md")
        assert [p.name for p in (ROOT / "rules").glob("*.fz") if f"## `{p.name}`" not in text] == []

    def test_every_key_of_a_scenario_is_described(self) -> None:
        text = _reference("scenario.md")
        assert [k for k in sorted(set(_keys(Scenario))) if f"`{k}`" not in text] == []


def _keys(model: type[BaseModel]) -> Iterator[str]:
    """Yield the keys of a scenario's section and of those below it."""
    for name, field in model.model_fields.items():
        yield name
        for below in _models(field.annotation):
            yield from _keys(below)


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in getattr(annotation, "__args__", ()):
        yield from _models(argument)


#: How far a run may be from what a page prints: SMC chatters, so its numbers depend on the integration step.
BANDS = {"aifqsmc": 0.02, "fcafsmc": 0.02, "smc": 0.25}


class TestNumbersOfThePaper:
    """docs/explanation/the-paper.md prints a table of errors; the run must still give it."""

    def test_the_table_is_what_the_run_gives(self, tmp_path: Path) -> None:
        text = (DOCS / "explanation" / "the-paper.md").read_text(encoding="utf-8")
        cell = r"([\d.]+) \([\d.]+\)"
        rows = re.findall(rf"^\| (\w+) \| (\w+) \| {cell} \| {cell} \| {cell} \|$", text, flags=re.MULTILINE)
        assert len(rows) == 9
        session = Session(DOCS / "explanation" / "the-paper.md", tmp_path)
        shown = session.shell("dwmr run paper --controller all --format json")
        runs = json.loads(shown)["controllers"]
        for controller, robot, *values in rows:
            measured = runs[controller]["rmse"][robot]
            for key, value in zip(("x_e", "y_e", "theta_e"), values, strict=True):
                expected = pytest.approx(float(value), rel=BANDS[controller])
                assert measured[key] == expected, (controller, robot, key)
