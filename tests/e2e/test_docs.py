"""Runs every example of docs/ and README.md, and follows every link; see `pages` for how examples are written."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from tests import sizes
from tests.e2e.pages import DOCS, FOLLOWED, PAGES, ROOT, Session, anchors, follow, without_code, written
from tests.e2e.pictures import excess, is_example, pictures
from tests.own_files import own_files
from tests.physics import require_renderer

#: Pages that take seconds: they are followed a second time only before a release.
SLOW = (
    *(
        "another-plant.md",
        "drive-robots-with-ros.md",
        "exchange-fmus.md",
        "edit-a-rule-and-run-again.md",
        "evaluate-many-points.md",
        "first-steps.md",
    ),
    *(
        "make-a-scenario.md",
        "run-in-a-physics-engine.md",
        "run-many-times.md",
        "show-a-run.md",
        "simulate-a-loop.md",
        "tune-numbers.md",
    ),
    *("write-a-control-law.md", "add-a-controller.md", "your-own-plant.md", "use-a-kernel-in-compiled-code.md"),
    *("keep-robots-apart.md", "prove-a-loop.md", "use-logs-of-real-robots.md"),
)


def draw_what_is_shown(shown: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Have only figures drawn that the page shows: pictures take more than half the time of a run."""
    draw = Figure.savefig

    def save(figure: Figure, target: Any, **options: Any) -> None:
        if isinstance(target, str | Path) and not any(stem in Path(target).name for stem in shown):
            Path(target).write_bytes(b"")
        else:
            draw(figure, target, **options)

    monkeypatch.setattr(Figure, "savefig", save)


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_every_example_of_a_page_does_what_the_page_says(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if (page.name == "exchange-fmus.md" or page.parent == ROOT) and not any(map(shutil.which, ("cc", "gcc", "clang"))):
        pytest.skip("there is no C compiler")
    if page.name == "run-in-a-physics-engine.md":
        require_renderer()
    (tmp_path / ".venv").symlink_to(sys.prefix)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    shown = [p for p in pictures(page) if p.kind == "picture" or is_example(p)]
    if not sizes.LONG:
        monkeypatch.setattr("fuzzyctl.analysis.prove.TIMEOUT", 3.0)  # a law that is refused uses it up
        draw_what_is_shown([Path(p.source if p.kind == "picture" else p.path).stem for p in shown], monkeypatch)
    again = page in FOLLOWED and (sizes.LONG or (page.name not in SLOW and any(written(page))))
    follow(page, tmp_path, 2 if again else 1)
    for picture in shown:
        drawn = tmp_path / (picture.source if picture.kind == "picture" else picture.path.name)
        assert excess(picture.path, drawn) == 0.0, picture
    if page.name in CHECKS:
        program, check = CHECKS[page.name]
        if shutil.which(program) is not None:
            check(page)


def c_compiles_and_agrees(_page: Path) -> None:
    strict = ["gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion"]
    for folder, user in (("build", "loop.c"), ("motor", "motor/timer.c")):
        subprocess.run([*strict, f"-I{folder}", "-c", user, "-o", "user.o"], check=True)
        sources = [str(p) for p in Path(folder).glob("*.c") if str(p) != user]
        subprocess.run([*strict, *sources, "-lm", "-o", "selftest"], check=True)
        done = subprocess.run(["./selftest"], capture_output=True, text=True, check=True)
        assert ", 0 failures" in done.stdout


#: Runs the script of a page with as much of a document as it needs: sliders are moved to 2 and 9.
DOCUMENT = """const moved = [], shown = {{}};
const form = {{ append() {{}}, addEventListener(_, call) {{ form.moved = call; }} }};
globalThis.document = {{
    forms: [form],
    querySelector: () => shown,
    createElement: (tag) => {{
        const made = {{ append() {{}} }};
        return tag === "input" ? moved[moved.push(made) - 1] : made;
    }},
}};
{script}
moved.forEach((slider, k) => (slider.valueAsNumber = [2, 9][k]));
form.moved();
console.log(shown.value, moved[0].max);
"""


def javascript_prints_what_the_page_says(page: Path) -> None:
    printed = re.findall(r"<!-- printed by: (\S+) -->\n```text\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    assert [file for file, _ in printed] == ["web/tipper.test.mjs", "web/run.mjs"]
    (script,) = re.findall(r'<script type="module">(.*)</script>', Path("web/page.html").read_text(), re.DOTALL)
    Path("web/page.mjs").write_text(DOCUMENT.format(script=script), encoding="utf-8")
    for file, text in [*printed, ("web/page.mjs", "tip = 16.82 % 10\n")]:
        done = subprocess.run(["node", file], capture_output=True, text=True, check=True)
        assert done.stdout.endswith(text), file


#: What is checked of the files that a page leaves, and the program that this needs.
CHECKS = {
    "run-on-a-microcontroller.md": ("gcc", c_compiles_and_agrees),
    "run-in-a-browser.md": ("node", javascript_prints_what_the_page_says),
}


def test_no_two_pages_write_a_file_of_one_name_with_other_contents() -> None:
    origins: dict[str, dict[str, Path]] = {}
    for page in PAGES:
        for name, origin in written(page):
            origins.setdefault(name, {}).setdefault(origin, page)
    shared = {name: set(by_origin.values()) for name, by_origin in origins.items()}
    assert not [(name, *map(str, owners)) for name, owners in shared.items() if len(owners) > 1]


def test_no_wrapped_line_of_a_paragraph_becomes_a_quotation_or_a_list() -> None:
    broken = re.compile(r"^(?!\d+\. )[^\s|<>#*+-][^\n]*\n *((?:>|[-+*]|\d+\.) [^\n]*)", re.MULTILINE)
    breaks = {str(page): [line for line in broken.findall(without_code(page)) if line] for page in PAGES}
    assert not {page: lines for page, lines in breaks.items() if lines}


class TestTheRunnerItself:
    """A runner that lets everything pass would be worse than none."""

    @pytest.mark.parametrize(
        "text",
        [
            "```console\n$ echo one\ntwo\n```\n",
            "```console\n$ false\n$ echo on\non\n```\n",
            "```console\n$ false\n```\n",
            "```console\n$ fuzzyctl --version\nnothing\n```\n",
            "```console\n$ fuzzyctl check none.fz\n...\n```\n",
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
            "```console\n$ fuzzyctl check none.fz\n...\n$ echo $?\n1\n$ fuzzyctl --version\nfuzzyctl, ...\n```\n",
            "```python\na = 1\n```\n\n```python\n>>> a + 1\n2\n```\n",
            "<!-- file: a.txt -->\n```text\nhello\n```\n\n```console\n$ cat a.txt\nhello\n```\n",
            "```fz\nparam a = 1  # not used\n```\n",
        ],
    )
    def test_a_right_example_passes(self, text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
        self.run(text, tmp_path)

    @pytest.mark.parametrize(
        "text",
        [
            "```console\n$ mkdir new\n```\n",
            "```console\n$ echo one >> a.txt\n$ cat a.txt\none\n```\n",
            "```python\nfrom pathlib import Path\nPath('new').mkdir()\n```\n",
            "<!-- once -->\n```console\n$ mkdir new\n```\n",
            2 * "<!-- once -->\n```console\n$ mkdir -p new\n```\n\n",
        ],
    )
    def test_a_page_that_holds_only_once_fails(
        self, text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.chdir(tmp_path)
        with pytest.raises((AssertionError, FileExistsError)):
            self.run(text, tmp_path, 2)

    @pytest.mark.parametrize(
        "text",
        [
            "<!-- file: a.txt -->\n```text\none\n```\n\n```console\n$ echo two >> a.txt\n$ cat a.txt\none\ntwo\n```\n",
            "<!-- once -->\n```console\n$ mkdir new\n```\n\n```console\n$ mkdir new\nmkdir: ...\n$ echo $?\n1\n```\n",
        ],
    )
    def test_a_page_that_says_what_differs_the_second_time_passes(
        self, text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.chdir(tmp_path)
        self.run(text, tmp_path, 3)

    def run(self, text: str, folder: Path, times: int = 1) -> None:
        page = folder / "page.md"
        page.write_text(text, encoding="utf-8")
        follow(page, folder, times)


@pytest.mark.parametrize(
    "command",
    [
        *("fuzzyctl --version", "fuzzyctl check none.fz", "fuzzyctl explain 'FZ203'", "fuzzyctl eval", "dwmr run papr"),
        *("CC=none MODE= fuzzyctl eval > said", "fuzzyctl check none.fz 2> said", "fuzzyctl explain > said"),
    ],
)
def test_a_command_does_in_this_process_what_it_does_in_a_shell(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    said = tmp_path / "said"
    found = []
    for is_long in (False, True):
        monkeypatch.setattr(sizes, "LONG", is_long)
        session = Session(tmp_path / "page.md", tmp_path)
        shown = session.shell(command)
        found.append((shown, session.status, said.exists() and said.read_bytes()))
        said.unlink(missing_ok=True)
    assert found[0] == found[1]


@pytest.mark.parametrize("page", [*PAGES, *own_files(ROOT / "apps", "*.md")], ids=lambda p: str(p.relative_to(ROOT)))
def test_every_relative_link_leads_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", without_code(page)):
        if "://" in target or target.startswith("mailto:"):
            continue
        name, _, anchor = target.partition("#")
        path = (page.parent / name).resolve() if name else page
        assert path.exists(), f"{page}: {target} leads nowhere"
        if anchor:
            assert anchor in anchors(path), f"{page}: {target}: {path.name} has no such heading"


#: How far a run may be from what a page prints: SMC chatters, so its numbers depend on the integration step.
BANDS = {"aifqsmc": 0.02, "fcafsmc": 0.02, "smc": 0.25}


class TestNumbersOfThePaper:
    """docs/explanation/the-paper.md prints a table of errors; the run must still give it."""

    def test_the_table_is_what_the_run_gives(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
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
