"""A package of the extra that is missing is named, with what installs it."""

import subprocess
import sys

import pytest

import fuzzyctl
from fuzzyctl.interop.control import nlsys
from fuzzyctl.interop.gymnasium import environment


@pytest.fixture(scope="module")
def tank():
    return fuzzyctl.load("water_tank", block=fuzzyctl.Plant)


@pytest.mark.parametrize(
    ("package", "call"),
    [
        ("control", nlsys),
        ("gymnasium", lambda plant: environment(plant, reward=lambda s: 0.0, dt=0.1, duration=1.0)),
    ],
)
def test_it_is_named_with_the_extra(monkeypatch, tank, package, call):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(
        fuzzyctl.FuzzyctlError, match=rf"{package} cannot be imported .*pip install 'fuzzyctl\[interop\]'"
    ):
        call(tank)


def test_nothing_is_imported_before_it_is_called():
    modules = ", ".join(f"fuzzyctl.interop.{name}" for name in ("control", "gymnasium", "plants", "scipy"))
    code = f"import sys, {modules}; print(sorted({{'control', 'gymnasium', 'scipy', 'numba'}} & sys.modules.keys()))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout == "[]\n"
