"""Executes the notebooks of docs/, and looks at what they show.

They are stored with what they show: numbers must come out again. After an intended change: FUZZYCTL_UPDATE_GOLDEN=1
python -m pytest tests/e2e/test_notebooks.py, then read the difference.
"""

from __future__ import annotations

import base64
import os
import re
from collections.abc import Iterator
from copy import deepcopy
from html.parser import HTMLParser
from io import BytesIO
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient
from PIL import Image

FOLDER = Path(__file__).parents[2] / "docs" / "tutorial" / "notebooks"
#: The last one draws into figures of pyplot.
NAMES = ["a-system", "why", "guarantees", "a-loop", "a-surface"]


def store(name: str, executed: list[Any]) -> None:
    """Write a notebook with the results of its cells."""
    path = FOLDER / f"{name}.ipynb"
    notebook = nbformat.read(path, as_version=4)
    for number, (cell, done) in enumerate(zip(code_of(notebook), executed, strict=True), start=1):
        cell.outputs, cell.execution_count, cell.metadata = deepcopy(done.outputs), number, {}
        for output in cell.outputs:
            if "execution_count" in output:
                output.execution_count = number
            if "data" in output:
                output.data = small(output.data)
    nbformat.write(notebook, path)


def small(data: dict[str, Any]) -> dict[str, Any]:
    """Return what a cell shows with pictures of few colours; one that is there as PNG is left out in other forms."""
    if "image/png" in data:
        return {"image/png": _fewer_colours(data["image/png"]), "text/plain": data["text/plain"]}
    prefix = "data:image/png;base64,"
    return {k: re.sub(rf"(?<={prefix})[\w+/=]+", lambda m: _fewer_colours(m[0]), v) for k, v in data.items()}


def _fewer_colours(encoded: str) -> str:
    with Image.open(BytesIO(base64.b64decode(encoded))) as picture:
        target = BytesIO()
        picture.convert("RGB").quantize(64, dither=Image.Dither.NONE).save(target, "PNG", optimize=True)
    return base64.b64encode(target.getvalue()).decode()


def code_of(notebook: Any) -> list[Any]:
    return [c for c in notebook.cells if c.cell_type == "code"]


#: Pictures within tables, and numbers.
_PICTURE = re.compile(r"data:image/[\w+]+;base64,[\w+/=\s]+")
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def texts_of(data: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield what a cell shows as text, by kind; of a picture its kind only."""
    for kind, value in sorted(data.items()):
        is_picture = kind.startswith("image/")
        yield kind, "" if is_picture else _PICTURE.sub("", "".join(value))


@pytest.fixture(scope="module")
def shown() -> dict[str, list[dict[str, Any]]]:
    """By notebook what each cell of code shows, by kind; one process executes all, with nothing kept between them."""
    together = nbformat.v4.new_notebook()
    owners: list[str] = []
    for name in NAMES:
        cells = code_of(nbformat.read(FOLDER / f"{name}.ipynb", as_version=4))
        together.cells += [
            nbformat.v4.new_code_cell("%reset -f\nimport sys; 'matplotlib.pyplot' in sys.modules"),
            *cells,
        ]
        owners += [f"pyplot before {name}", *[name] * len(cells)]
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("COLUMNS", "80")  # other tests of the process may have left another width
        client = NotebookClient(
            together, timeout=300, record_timing=False, resources={"metadata": {"path": str(FOLDER)}}
        )
        client.execute()
    if os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
        for name in NAMES:
            store(name, [cell for owner, cell in zip(owners, together.cells, strict=True) if owner == name])
    found: dict[str, list[dict[str, Any]]] = {}
    for owner, cell in zip(owners, together.cells, strict=True):
        assert not [o for o in cell.outputs if o.output_type == "stream" and o.name == "stderr"], cell.outputs
        found.setdefault(owner, []).append(data_of(cell))
    return found


def data_of(cell: Any) -> dict[str, Any]:
    """Return what a cell of code shows, by kind."""
    data: dict[str, Any] = {}
    for output in cell.outputs:
        data |= output.get("data", {"print": output.get("text", "")})
    return data


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


def test_all_notebooks_are_executed() -> None:
    assert sorted(NAMES) == sorted(p.stem for p in FOLDER.glob("*.ipynb"))
    assert sum(p.stat().st_size for p in FOLDER.glob("*.ipynb")) < 700_000


@pytest.mark.parametrize("name", NAMES)
def test_what_is_stored_comes_out_again(name: str, shown: dict[str, list[dict[str, Any]]]) -> None:
    stored = [data_of(cell) for cell in code_of(nbformat.read(FOLDER / f"{name}.ipynb", as_version=4))]
    for before, now in zip(stored, shown[name], strict=True):
        assert before
        kept = dict(texts_of(before))
        found = {kind: text for kind, text in texts_of(now) if kind in kept}
        assert {k: _NUMBER.sub("#", v) for k, v in kept.items()} == {k: _NUMBER.sub("#", v) for k, v in found.items()}
        for kind, text in kept.items():
            numbers = [float(n) for n in _NUMBER.findall(found[kind])]
            assert [float(n) for n in _NUMBER.findall(text)] == pytest.approx(numbers, rel=1e-9, abs=1e-12), kind


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
    assert "met" in run["text/html"]
    assert "<svg" in runs["image/svg+xml"]


def test_nothing_of_it_loads_pyplot(shown: dict[str, list[dict[str, Any]]]) -> None:
    assert shown["pyplot before a-surface"][0]["text/plain"] == "False"
