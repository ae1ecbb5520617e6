"""Generated C on emulated microcontrollers, where the tools are installed; `tests/targets/run.py` does all cases."""

from __future__ import annotations

import sys
import tempfile
from functools import cache
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.targets import run

FIXED = run.Case("ais_reaction", ("--fixed", "Q3.12"))
FIXED_CONTROLLER = run.Case("heater", ("--fixed", "Q7.8"), folder=run.HERE)
CONTROLLER = run.Case("valve", (), folder=run.HERE)


@cache
def texts_of(case: run.Case) -> dict[str, str]:
    """Return the files of a case, which one process writes for all tests."""
    with tempfile.TemporaryDirectory() as folder:
        run.generate(case, Path(folder))
        return {path.name: path.read_text(encoding="utf-8") for path in Path(folder).iterdir()}


def generated(case: run.Case, folder: Path) -> tuple[Path, Path]:
    """Write the C of a case and return its source and its self-test."""
    for name, text in texts_of(case).items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder / f"{case.file}.c", folder / f"{case.file}_selftest.c"


def required(job: str) -> str:
    """Return the job, or skip the test with the tools that it lacks."""
    if run.missing(job):
        pytest.skip(f"needs {' and '.join(run.missing(job))}, which are not installed")
    return job


@pytest.mark.parametrize("job", ["arm", "avr", "cppcheck"])
def test_integers_agree_on_a_target(job: str, tmp_path: Path) -> None:
    said = run.JOBS[required(job)][1](*generated(FIXED, tmp_path))
    assert "352 vectors agree" in said or said.startswith("no rule but")


@pytest.mark.parametrize("job", ["arm", "cppcheck"])
def test_a_controller_in_integers_agrees_on_a_target(job: str, tmp_path: Path) -> None:
    said = run.JOBS[required(job)][1](*generated(FIXED_CONTROLLER, tmp_path))
    assert "200 vectors agree" in said or said.startswith("no rule but")


@pytest.mark.parametrize("job", ["arm", "cppcheck", "host steps", "arm steps"])
def test_the_steps_of_a_controller_agree_on_a_target(job: str, tmp_path: Path) -> None:
    said = run.JOBS[required(job)][1](*generated(CONTROLLER, tmp_path))
    assert "200 vectors agree" in said or "10,000 steps agree" in said or said.startswith("no rule but")


@pytest.mark.parametrize("job", ["host steps", "arm steps"])
def test_a_wrong_step_is_found(job: str, tmp_path: Path) -> None:
    source, selftest = generated(CONTROLLER, tmp_path)
    required(job)
    text = source.read_text(encoding="utf-8")
    assert "0.8 * v14" in text
    source.write_text(text.replace("0.8 * v14", "0.800000001 * v14"), encoding="utf-8")
    with pytest.raises(run.FailedError, match="steps are off by"):
        run.JOBS[job][1](source, selftest)


@pytest.mark.parametrize("job", ["arm", "avr"])
def test_a_wrong_kernel_is_found(job: str, tmp_path: Path) -> None:
    source, selftest = generated(FIXED, tmp_path)
    required(job)
    text = source.read_text(encoding="utf-8")
    assert "INT32_C(4096)" in text
    source.write_text(text.replace("INT32_C(4096)", "INT32_C(4090)"), encoding="utf-8")
    with pytest.raises(run.FailedError, match="failures"):
        run.JOBS[job][1](source, selftest)


def test_every_case_names_jobs_and_a_rule_file() -> None:
    assert {job for case in run.CASES for job in case.tools} == set(run.JOBS)
    assert all((case.folder / f"{case.file}.fz").exists() for case in run.CASES)


def test_a_tool_that_fails_is_quoted() -> None:
    with pytest.raises(run.FailedError, match="no such thing"):
        run.call(sys.executable, "-c", "raise SystemExit('no such thing')")
