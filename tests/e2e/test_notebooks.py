"""Executes the notebooks of docs/, and looks at what they show."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

FOLDER = Path(__file__).parents[2] / "docs" / "tutorial" / "notebooks"
#: The last one draws into figures of pyplot.
NAMES = ["a-system", "why", "guarantees", "a-loop", "a-surface"]


@pytest.fixture(scope="module")
def shown() -> dict[str, list[dict[str, Any]]]:
    """By notebook what each cell of code shows, by kind; one process executes all, with nothing kept between them."""
    together = nbformat.v4.new_notebook()
    owners: list[str] = []
    for name in NAMES:
        cells = [c for c in nbformat.read(FOLDER / f"{name}.ipynb", as_version=4).cells if c.cell_type == "code"]
        together.cells += [
            nbformat.v4.new_code_cell("%reset -f\nimport sys; 'matplotlib.pyplot' in sys.modules"),
            *cells,
        ]
        owners += [f"pyplot before {name}", *[name] * len(cells)]
    NotebookClient(together, timeout=300, resources={"metadata": {"path": str(FOLDER)}}).execute()
    found: dict[str, list[dict[str, Any]]] = {}
    for owner, cell in zip(owners, together.cells, strict=True):
        assert not [o for o in cell.outputs if o.output_type == "stream" and o.name == "stderr"], cell.outputs
        data: dict[str, Any] = {}
        for output in cell.outputs:
            data |= output.get("data", {"print": output.get("text", "")})
        found.setdefault(owner, []).append(data)
    return found


class Tags(HTMLParser):
    """Counts tags, and refuses one that is closed in the wrong place."""

    def __init__(self) -> None:
        super().__init__()
        self.names: list[str] = []
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.names.append(tag)
        assert not [name for name, _ in attrs if name.startswith("on")]
        if tag not in ("img", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def tags(html: str) -> list[str]:
    """Return the names of the tags of well-formed HTML without script."""
    parser = Tags()
    parser.feed(html)
    assert parser.open == []
    assert "script" not in parser.names
    assert "@media (prefers-color-scheme: dark)" in html
    return parser.names


def test_all_notebooks_are_executed_and_kept_without_results() -> None:
    assert sorted(NAMES) == sorted(p.stem for p in FOLDER.glob("*.ipynb"))
    for path in FOLDER.glob("*.ipynb"):
        assert '"outputs": []' in path.read_text("utf-8")
        assert not re.search(r'"execution_count": \d', path.read_text("utf-8"))


def test_a_system_is_tables_and_prints_what_the_command_prints(shown: dict[str, list[dict[str, Any]]]) -> None:
    system, printed, line, food, terms = shown["a-system"]
    assert tags(system["text/html"]).count("table") == 5
    for part in (
        "gaussian(5, 1.5)",
        "if service is good then tip is average",
        "centroid, exact",
        "bounded(tip, 0, 30)",
    ):
        assert part in system["text/html"]
    assert system["text/plain"] == "FuzzySystem(tipper: service, food -> tip; 3 rules)"
    assert line["text/plain"] == repr(system["text/plain"])
    assert printed["print"].startswith("tipper: Tip for service and food\n")
    assert "image/png" in food
    assert "<svg" in terms["image/svg+xml"]


def test_a_kernel_shows_its_surface_and_plots_are_shown(shown: dict[str, list[dict[str, Any]]]) -> None:
    kernel, curve, drawn, results = shown["a-surface"]
    assert tags(kernel["text/html"]).count("img") == 1
    assert "data:image/png;base64," in kernel["text/html"]
    assert "image/png" in curve
    assert "image/png" in drawn
    assert re.findall(r"near|far", results["text/plain"]) == ["near", "far"]


def test_why_shows_the_rule_viewer(shown: dict[str, list[dict[str, Any]]]) -> None:
    found, printed, viewer = shown["why"]
    assert tags(found["text/html"]).count("img") == 1
    assert "data:image/svg+xml;base64," in found["text/html"]
    assert "54.9%" in found["text/html"]
    assert printed["print"].startswith("tip = 20.34")
    assert "<svg" in viewer["image/svg+xml"]


def test_a_verdict_shows_its_witness(shown: dict[str, list[dict[str, Any]]]) -> None:
    verdicts, refuted, point = shown["guarantees"]
    assert tags(verdicts["text/html"]).count("tr") == 4
    assert "Witness" in refuted["text/html"]
    assert "-0.008" in refuted["text/html"]
    assert tags(refuted["text/html"]).count("table") == 2
    assert point["text/plain"] == "{'sigma': 0.0, 'dsigma': 0.0}"


def test_loops_and_runs_are_shown(shown: dict[str, list[dict[str, Any]]]) -> None:
    loop, plant, run, runs = shown["a-loop"]
    assert "largest &lt;= 0.25" in loop["text/html"]
    assert "Derivatives" in plant["text/html"]
    assert tags(run["text/html"]).count("img") == 1
    assert "holds" in run["text/html"]
    assert "<svg" in runs["image/svg+xml"]


def test_nothing_of_it_loads_pyplot(shown: dict[str, list[dict[str, Any]]]) -> None:
    assert shown["pyplot before a-surface"][0]["text/plain"] == "False"
