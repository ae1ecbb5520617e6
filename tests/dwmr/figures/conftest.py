"""Figures of commands, as matplotlib has them before they become pictures."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from tests.dwmr.process import here


@pytest.fixture(scope="session")
def figures_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., dict[str, Figure]]:
    """A function (command, scenario, *arguments, sets=()) -> figures by the names of the files that they would fill."""

    def draw(*arguments: object, sets: tuple[str, ...] = ()) -> dict[str, Figure]:
        drawn: dict[str, Figure] = {}

        def kept(figure: Figure, path: Path, **options: Any) -> None:
            drawn[Path(path).name] = figure
            Path(path).touch()

        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(Figure, "savefig", kept)
            options = [word for one in sets for word in ("--set", one)]
            here(*arguments, *options, "-o", tmp_path_factory.mktemp("drawn"))
        return drawn

    return draw


@pytest.fixture
def film_of(monkeypatch: pytest.MonkeyPatch, recorded: Callable[..., None], tmp_path: Path) -> Callable[..., Any]:
    """A function (trajectory, t, *sets, scenario=) -> the panel of the picture of a film at a time [s]."""
    made: list[Figure] = []
    begin = Figure.__init__

    def kept(figure: Figure, *arguments: Any, **options: Any) -> None:
        made.append(figure)
        begin(figure, *arguments, **options)

    def draw(trajectory: Any, t: float, *sets: str, scenario: object = "paper") -> Any:
        recorded(trajectory)
        monkeypatch.setattr(Figure, "__init__", kept)
        options = [word for one in sets for word in ("--set", one)]
        law = ("--controller", trajectory.controller)
        here("animate", scenario, *law, *options, "--at", t, "-o", tmp_path / "film.png")
        (axes,) = made[-1].axes
        return axes

    return draw
