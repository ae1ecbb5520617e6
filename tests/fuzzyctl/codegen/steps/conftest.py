"""Steps of all kinds, and what compiles and runs their self-tests."""

import shutil
import subprocess

import pytest

from fuzzyctl.codegen.files import generate
from tests.fuzzyctl.codegen.conftest import Built
from tests.fuzzyctl.codegen.steps.targets import STRICT
from tests.fuzzyctl.codegen.steps.texts import TEXTS


def pytest_generate_tests(metafunc):
    """Run a test that takes a `text` for controllers of all kinds."""
    if "text" in metafunc.fixturenames:
        metafunc.parametrize("text", TEXTS.values(), ids=TEXTS)


@pytest.fixture
def gcc():
    """Skip a test where there is no compiler."""
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")


@pytest.fixture
def compiled(gcc, tmp_path):
    """Write a step as C, compile it with its self-test, run that."""

    def build(unit, flags=(), change=None):
        for name, content in generate(unit, "c").files.items():
            (tmp_path / name).write_text(change(name, content) if change else content, encoding="utf-8")
        sources = sorted(map(str, tmp_path.glob("*.c")))
        subprocess.run(["gcc", *STRICT, *flags, *sources, "-o", str(tmp_path / "test"), "-lm"], check=True)
        run = subprocess.run([str(tmp_path / "test")], capture_output=True, text=True, check=False)
        return Built(run.returncode, run.stdout + run.stderr)

    return build
