"""Runs shared by the tests: the paper's scenario under each control law, once per session."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from dwmr.cli.main import main
from dwmr.simulation import simulate
from tests.dwmr import scenarios


@pytest.fixture(scope="session")
def run_paper() -> Callable[..., Any]:
    """A function (law, *overrides) -> (file, trajectory) of the paper's scenario; equal calls share one run."""
    return partial(scenarios.shared, "paper")


@pytest.fixture(scope="session")
def run_with_limits() -> Callable[..., Any]:
    """As `run_paper`, of the paper's run with the limits and the lag of drives."""
    return partial(scenarios.shared, "paper-with-limits")


@pytest.fixture(scope="session")
def measured() -> Callable[..., Any]:
    """A function (law, *overrides) -> measures of the paper's scenario; equal calls share one result."""
    return partial(scenarios.measured, "paper")


@pytest.fixture(scope="session")
def measured_with_limits() -> Callable[..., Any]:
    """As `measured`, of the paper's run with the limits and the lag of drives."""
    return partial(scenarios.measured, "paper-with-limits")


@pytest.fixture
def recorded(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """A function (*trajectories) after which commands take these in place of runs, by the names of their laws.

    Several of one law are taken one after the other, the last one again and again.
    """

    def take(*trajectories: Any) -> None:
        runs: dict[str, list[Any]] = {}
        for one in trajectories:
            runs.setdefault(one.controller, []).append(one)

        def next_of(simulation: Any, report: Any = None) -> Any:
            waiting = runs[simulation.name]
            return waiting.pop(0) if len(waiting) > 1 else waiting[0]

        monkeypatch.setattr(simulate, "run", next_of)

    return take


@pytest.fixture
def dwmr(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Any]:
    """A function that runs a command in an empty folder: (status, standard output, standard error)."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: object) -> tuple[Any, str, str]:
        status: Any = 0
        try:
            main(list(map(str, arguments)))
        except SystemExit as stop:
            status = stop.code
        printed = capsys.readouterr()
        return status, printed.out, printed.err

    return run
