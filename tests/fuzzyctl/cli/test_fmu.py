"""`fuzzyctl codegen --target fmu`: which block is meant, where the file goes, what is refused."""

import json
import zipfile
from pathlib import Path

import pytest

from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.fmu.archive import shared_library
from tests.commands import runner

run = runner("codegen", "--target", "fmu")
RULES = Path(__file__).resolve().parents[3] / "rules"
TANK = RULES / "loops" / "water_tank.fz"


@pytest.fixture(autouse=True)
def without_a_compiler(monkeypatch, tmp_path):
    """Write sources only, which is fast; a test that wants a compiler sets the path again."""
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.chdir(tmp_path)


def names(path):
    with zipfile.ZipFile(path) as archive:
        return sorted(archive.namelist())


def test_an_fmu_without_a_compiler_holds_its_source_and_says_so():
    result = run(RULES / "tipper.fz", "-o", "build/own.fmu")
    assert result.exit_code == 0
    assert result.stdout == "wrote build/own.fmu\n"
    assert "warning[FZ712]: there is no C compiler" in result.stderr
    assert "help: install a C compiler" in result.stderr
    assert names("build/own.fmu") == [
        "documentation/index.html",
        "modelDescription.xml",
        "sources/buildDescription.xml",
        "sources/fmi3.c",
        "sources/fmu_core.h",
        "sources/fmu_model.h",
        "sources/tipper.c",
        "sources/tipper.h",
    ]


@pytest.mark.parametrize(
    ("chosen", "kind", "name"),
    [
        ((), "controller", "fuzzy_pi"),
        (("--block", "tank"), "plant", "tank"),
        (("--block", "surface"), "system", "surface"),
    ],
)
def test_the_block_that_is_meant(chosen, kind, name):
    result = run(TANK, *chosen, "--format", "json", "--fmi", "2", "-q")
    assert json.loads(result.stdout) == {
        kind: name,
        "target": "fmu",
        "fmi": "2.0",
        "files": [f"{name}.fmu"],
        "binary": None,
        "errors": {},
    }
    with zipfile.ZipFile(f"{name}.fmu") as archive:
        assert f'modelName="{name}"' in archive.read("modelDescription.xml").decode()


def test_a_compiler_that_fails_is_an_error_and_nothing_is_written(monkeypatch):
    monkeypatch.setenv("CC", "/bin/false")
    result = run(RULES / "tipper.fz")
    assert result.exit_code == 1
    assert "the C compiler '/bin/false' refuses the source of the FMU:\nit said nothing; exit code 1" in result.stderr
    assert not Path("tipper.fmu").exists()


@pytest.mark.parametrize(("comment", "optimised"), [("", True), (" " * 600_000, False)])
def test_a_large_source_is_compiled_without_optimisation(comment, optimised, tmp_path):
    echo = tmp_path / "compiler"
    echo.write_text('#!/bin/sh\necho "$@" >&2\nexit 1\n', encoding="utf-8")
    echo.chmod(0o755)
    with pytest.raises(CodegenError) as raised:
        shared_library({"s.c": f"//{comment}\n"}, str(echo))
    options = str(raised.value).split()
    assert ("-O0" not in options) == optimised
    assert "-ffp-contract=off" in options


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((TANK, "--table", "9"), "a lookup table holds a system only"),
        ((TANK, "--block", "tank", "--float", "float"), "a plant is integrated in double precision"),
        ((RULES / "tipper.fz", "--free", "x"), "only controllers and plants have parameters"),
        ((TANK, "--fixed", "Q3.12"), "fixed point is written in C only"),
    ],
)
def test_options_that_do_not_go_with_it_are_wrong_usage(arguments, message):
    result = run(*arguments)
    assert result.exit_code == 2
    assert message in result.stderr


def test_only_params_that_are_named_are_free():
    assert run(TANK, "--block", "tank", "--free", "A", "-q").exit_code == 0
    with zipfile.ZipFile("tank.fmu") as archive:
        text = archive.read("modelDescription.xml").decode()
    assert 'name="A" valueReference="3" causality="parameter" variability="tunable"' in text
    assert 'name="b" valueReference="6" causality="local" variability="constant"' in text
    result = run(TANK, "--block", "tank", "--free", "q")
    assert (result.exit_code, result.stderr) == (2, "error: no free number 'q'; there are: A, a, b\n")


def test_a_version_is_given_for_an_fmu_only():
    result = runner("codegen")(RULES / "tipper.fz", "--target", "c", "--fmi", "2")
    assert result.exit_code == 2
    assert "an FMU is written with --target fmu, not c" in result.stderr
