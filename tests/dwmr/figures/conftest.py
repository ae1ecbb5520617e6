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
