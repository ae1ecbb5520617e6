"""Systems of all kinds, drawn at random: generated C, JavaScript, Python and the kernel are the same function."""

import math
import shutil
import subprocess

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl import FuzzyctlError
from fuzzyctl.codegen.files import expected_of, generate
from fuzzyctl.codegen.prepare import prepare
from tests.fuzzyctl.codegen.conftest import run_selftests
from tests.fuzzyctl.codegen.structured_text import differences
from tests.properties.drawn_systems import plain_systems, systems
from tests.properties.running import quick

STRICT = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion", "-Wdouble-promotion"]


any_system = systems() | plain_systems()
#: Those that hold a value have a state, which the self-test of C carries on.
held_system = systems(held=True)


def prepared(system, target="c", **options):
    """What source text is written of, None for adaptive integrals, which only JavaScript has."""
    try:
        unit = prepare(system, "", **options)
        list(generate(unit, target).files)
    except FuzzyctlError as error:
        assert "adaptive integral" in str(error)  # noqa: PT017 - both answers are honest
        assert target != "javascript"
        return None
    return unit


def compiled_and_run(unit, folder, flags):
    for name, text in generate(unit, "c").files.items():
        (folder / name).write_text(text, encoding="utf-8")
    sources = sorted(map(str, folder.glob("*.c")))
    subprocess.run(["gcc", *STRICT, *flags, *sources, "-o", str(folder / "test"), "-lm"], check=True)
    return subprocess.run([str(folder / "test")], capture_output=True, text=True, check=False)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
@quick(25, 6)
@given(system=any_system | held_system)
def test_c_agrees_with_the_kernel(tmp_path_factory, system):
    unit = prepared(system)
    if unit is None:
        return
    flags = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    done = compiled_and_run(unit, tmp_path_factory.mktemp("c"), flags)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
@quick(12, 5)
@given(system=any_system)
def test_single_precision_stays_within_its_tolerance(tmp_path_factory, system):
    unit = prepared(system, precision="float")
    if unit is None:
        return
    done = compiled_and_run(unit, tmp_path_factory.mktemp("c"), ["-O1"])
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
@quick(8, 1)
@given(drawn=st.lists(any_system | held_system, min_size=25, max_size=25))
def test_javascript_agrees_with_the_kernel(tmp_path_factory, drawn):
    units = [unit for unit in (prepared(system, "javascript") for system in drawn) if unit is not None]
    done = run_selftests([generate(u, "javascript").files for u in units], tmp_path_factory.mktemp("javascript"))
    assert done.code == 0, done.output
    assert done.output.count("0 failures") == len(units)


@quick(40)
@given(system=any_system | held_system)
def test_structured_text_agrees_with_the_kernel(system):
    try:
        assert differences(prepare(system, "")) <= 1.0
    except FuzzyctlError as error:
        honest = ("no standard function", "adaptive integral", "holds NaN at first")  # such as atan2
        assert any(t in str(error) for t in honest)  # noqa: PT017 - both answers are honest


@quick(60)
@given(system=any_system)
def test_the_python_module_agrees_with_the_kernel(system):
    unit = prepared(system, "python")
    if unit is None:
        return
    names = {"__name__": "generated"}
    ((path, text),) = generate(unit, "python").files.items()
    exec(compile(text, "generated", "exec"), names)
    function = names[path.removesuffix(".py")]
    for vector in expected_of(unit).vectors[::7]:
        if vector.refused:
            with pytest.raises(ArithmeticError):
                function(*vector.inputs)
            continue
        result = function(*vector.inputs)
        for k, (a, b) in enumerate(
            zip(result if isinstance(result, tuple) else (result,), vector.outputs, strict=True)
        ):
            assert (math.isnan(a) and math.isnan(b)) or abs(a - b) <= unit.tolerance(k)
