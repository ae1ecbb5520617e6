"""A built wheel in an empty environment outside the checkout runs both commands, rule files and scenarios included."""

import json
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", str(folder), str(ROOT)],
        check=True,
        capture_output=True,
    )
    (path,) = folder.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """An environment that sees the third-party packages of this one, but fuzzyctl only from the wheel."""
    folder = tmp_path_factory.mktemp("env")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    return folder


def run(installed, module, *arguments):
    # -I ignores the current folder and the environment; the editable install is taken off the path by name.
    script = (
        f"import sys; here = {[str(ROOT), str(ROOT / 'apps')]!r};"
        f"sys.path[:] = [{str(installed / 'site')!r}] + [p for p in sys.path if p not in here];"
        f"from {module} import main; import fuzzyctl; assert fuzzyctl.__file__.startswith({str(installed)!r});"
        f"main({list(arguments)!r})"
    )
    command = [sys.executable, "-I", "-c", script]
    return subprocess.run(command, cwd=installed, capture_output=True, text=True)


def test_the_wheel_holds_code_rules_and_scenarios_and_nothing_else(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    tops = {n.split("/")[0] for n in names if ".dist-info" not in n}
    assert tops == {"fuzzyctl", "dwmr"}
    for name in (
        "fuzzyctl/rules/ais_reaction.fz",
        "fuzzyctl/explanations/FZ203.md",
        "fuzzyctl/lang/grammar.lark",
        "fuzzyctl/lang/grammar.tables",
        "fuzzyctl/codegen/fmu/c/fmu_core.h",
        "fuzzyctl/annotations.pyi",
        "fuzzyctl/py.typed",
        "dwmr/scenarios/paper.toml",
        "dwmr/scenarios/csv-path.toml",
        "dwmr/scenarios/csv-path.csv",
    ):
        assert name in names
    assert any(n.endswith("licenses/LICENSE") for n in names)
    for folder in (ROOT, ROOT / "apps"):
        modules = {p.relative_to(folder).as_posix() for top in tops for p in (folder / top).rglob("*.py")}
        assert modules <= set(names)


def test_fuzzyctl_runs_from_the_wheel(installed):
    result = run(installed, "fuzzyctl.cli.main", "eval", "site/fuzzyctl/rules/tipper.fz", "service=2", "food=1")
    assert result.stdout.startswith("tip = 7.01506232"), result.stderr


def test_dwmr_checks_scenarios_from_the_wheel(installed):
    result = run(installed, "dwmr.cli.main", "check", "csv-path", "five-robots")
    assert result.returncode == 0, result.stderr


@pytest.mark.long  # it is compiled: the cache of the checkout does not serve the wheel
def test_dwmr_runs_from_the_wheel(installed):
    result = run(installed, "dwmr.cli.main", "run", "paper", "--set", "run.horizon=0.1", "-o", "out")
    assert result.returncode == 0, result.stderr
    summary = json.loads((installed / "out" / "summary.json").read_text())
    assert "aifqsmc" in summary["controllers"]
