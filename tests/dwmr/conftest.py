"""Runs shared by the tests: the paper's scenario under each control law, once per session."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from dwmr.cli.main import main
from dwmr.control.fuzzy_gains import Rules
from dwmr.results.metrics import measure
from dwmr.scenario.file import ScenarioFile, find, read
from dwmr.simulation import simulate


@cache
def _run(scenario: str, law: str, overrides: tuple[str, ...]) -> tuple[ScenarioFile, simulate.Trajectory]:
    file = read(find(scenario), overrides)
    rules = Rules(file.scenario.rules, (), file.places)
    return file, simulate.run(simulate.prepare(file, law, rules))


@pytest.fixture(scope="session")
def run_paper() -> Callable[..., tuple[ScenarioFile, simulate.Trajectory]]:
    """A function (law, *overrides) -> (file, trajectory) of the paper's scenario; equal calls share one run."""

    def run(law: str, *overrides: str) -> tuple[ScenarioFile, simulate.Trajectory]:
        return _run("paper", law, tuple(overrides))

    return run


@pytest.fixture(scope="session")
def run_with_limits() -> Callable[..., tuple[ScenarioFile, simulate.Trajectory]]:
    """As `run_paper`, of the paper's run with the limits and the lag of drives."""

    def run(law: str, *overrides: str) -> tuple[ScenarioFile, simulate.Trajectory]:
        return _run("paper-with-limits", law, tuple(overrides))

    return run


@pytest.fixture(scope="session")
def measured(run_paper: Callable[..., Any]) -> Callable[..., dict[str, Any]]:
    """A function (law, *overrides) -> measures of the paper's scenario; equal calls share one result."""

    @cache
    def run(law: str, *overrides: str) -> dict[str, Any]:
        file, trajectory = run_paper(law, *overrides)
        return measure(trajectory, file.scenario)

    return run


@pytest.fixture(scope="session")
def measured_with_limits(run_with_limits: Callable[..., Any]) -> Callable[..., dict[str, Any]]:
    """As `measured`, of the paper's run with the limits and the lag of drives."""

    @cache
    def run(law: str, *overrides: str) -> dict[str, Any]:
        file, trajectory = run_with_limits(law, *overrides)
        return measure(trajectory, file.scenario)

    return run


@pytest.fixture
def dwmr(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., tuple[Any, str, str]]:
    """A function that runs a command in an empty folder: (status, standard output, standard error)."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: object) -> tuple[Any, str, str]:
        status: Any = 0
        try:
            main(list(map(str, arguments)))
        except SystemExit as stop:
            status = stop.code
        said = capsys.readouterr()
        return status, said.out, said.err

    return run
