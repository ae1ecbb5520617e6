"""Who may import whom, and what must not be imported at all before it is needed."""

import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from fuzzyctl import _HOMES
from tests.imported import circles, imported, imports_between
from tests.own_files import own_files

ROOT = Path(__file__).parent.parent

#: Packages of fuzzyctl from the bottom up; a module may import its own package and those on lower lines.
ORDER = [
    ["operations"],
    ["records"],
    ["diagnostics"],
    ["expr", "support"],
    ["experiments", "formulas"],
    ["lang", "model"],
    ["kernels", "resolve"],
    ["formats"],
    ["simulation"],
    ["comparison", "explain", "loading"],
    ["analysis", "building", "interop", "plot", "sweep"],
    ["codegen", "convert", "display"],
    ["editor", "page"],
    ["studio"],
    ["cli"],
    ["ros", "testing"],
    ["__main__"],
]
#: The same for the sub-packages of packages.
SUBORDER = {
    "analysis": [["coverage", "multilinear"], ["branch_and_bound"], ["induction", "reach"]],
    "codegen": [["fixed", "fmu"]],
    "formats": [["common"], ["fll"], ["fcl", "fis"], ["fml"]],
    "kernels": [["program"], ["interval", "plan"], ["inference"], ["algorithms"], ["backends"]],
    "kernels/backends": [["numba"]],
    "kernels/inference": [["defuzzify"]],
    "model": [["checks"]],
    "studio": [["arrays"]],
}

#: Third parties and the only places that may import them.
HOMES = {
    "lark": {"fuzzyctl/lang"},
    "numba": {
        "fuzzyctl/kernels/backends/numba/machine_code.py",
        "fuzzyctl/kernels/backends/numba/source.py",
        "fuzzyctl/kernels/backends/numba/intrinsics.py",
        "fuzzyctl/kernels/backends/numba/disk_cache.py",
        "apps/dwmr",
    },
    "llvmlite": {"fuzzyctl/kernels/backends/numba/machine_code.py"},
    "matplotlib": {"fuzzyctl/plot", "apps/dwmr/figures"},
    "mpl_toolkits": {"fuzzyctl/plot", "apps/dwmr/figures"},
    "click": {"fuzzyctl/cli", "fuzzyctl/testing.py", "apps/dwmr/cli"},
    "pydantic": {
        "apps/dwmr",
        "fuzzyctl/experiments/sweep_spec.py",
        "fuzzyctl/experiments/sweep_variables.py",
        "fuzzyctl/sweep/loop_files.py",
    },
    "PIL": {"apps/dwmr/figures", "apps/gallery"},
    "lsprotocol": {"fuzzyctl/editor/server.py", "fuzzyctl/editor/session.py", "fuzzyctl/editor/requests.py"},
    "pygls": {
        "fuzzyctl/editor/protocol.py",
        "fuzzyctl/editor/requests.py",
        "fuzzyctl/editor/server.py",
        "fuzzyctl/editor/session.py",
    },
    "pygments": {"fuzzyctl/lang/highlight.py"},
    "pyarrow": {"fuzzyctl/experiments/parquet.py", "apps/dwmr/output/data.py"},
    "distributed": {"fuzzyctl/experiments/dask_workers.py"},
    "control": {"apps/gallery/beside_upa.py"},  # elsewhere by name, when it is called
    "fmpy": set(),  # by name, when a loop with an FMU is run
    "rosbags": {"apps/dwmr/output/bag.py", "apps/dwmr/results/logs.py"},
    "rclpy": set(),  # by name, when the node starts
    "casadi": set(),  # by name, when a run has the control law mpc
    "mujoco": set(),  # by name, when a scenario's robots are rigid bodies
    "gymnasium": {"fuzzyctl/interop/environments.py"},
    "scipy": {
        "apps/dwmr/output/data.py",
        "apps/dwmr/results/identification.py",
        "fuzzyctl/experiments/estimates.py",
        "fuzzyctl/simulation/members.py",
        "fuzzyctl/simulation/simulate.py",
    },
}


def modules():
    return [*sorted((ROOT / "fuzzyctl").rglob("*.py")), *own_files(ROOT / "apps", "*.py")]


def ranks(order):
    return {part: rank for rank, parts in enumerate(order) for part in parts}


def folders(package):
    return {p.name for p in (ROOT / "fuzzyctl" / package).iterdir() if p.is_dir() and p.name != "__pycache__"}


def package_arrows(package, order):
    """Yield the imports of one part of a package by another, as `module imports module`, against their order."""
    rank = ranks(order)
    dotted = ".".join(["fuzzyctl", *Path(package).parts])
    for name, found in graph().items():
        for other in found:
            if not (name.startswith(dotted + ".") and other.startswith(dotted + ".")):
                continue
            part, below = (n.removeprefix(dotted + ".").split(".")[0] for n in (name, other))
            if part != below and part in rank and below in rank and rank[below] >= rank[part]:
                yield f"{name} imports {other}"


@cache
def graph():
    return imports_between([("fuzzyctl", ROOT / "fuzzyctl")])


def test_packages_import_only_packages_below_them():
    assert list(package_arrows("", ORDER)) == []


@pytest.mark.parametrize("package", SUBORDER)
def test_sub_packages_import_only_sub_packages_below_them(package):
    assert list(package_arrows(package, SUBORDER[package])) == []


def test_every_package_has_its_rank():
    loose = {p.stem for p in (ROOT / "fuzzyctl").glob("*.py")} - {"__init__"}
    assert folders("") | loose == set(ranks(ORDER))
    nested = {p.parent.relative_to(ROOT / "fuzzyctl") for p in (ROOT / "fuzzyctl").glob("*/**/__init__.py")}
    found = {}
    for path in nested:
        if path.parent != Path():
            found.setdefault(path.parent.as_posix(), set()).add(path.name)
    assert found == {package: set(ranks(order)) for package, order in SUBORDER.items()}


def test_files_import_each_other_in_no_circle():
    assert circles(graph()) == []


def test_a_circle_of_types_and_lazy_imports_is_found(tmp_path):
    for name, text in {
        "__init__": "from p.a import x",
        "a": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from p.b import B",
        "b": "def f():\n    from p import c",
        "c": "import p.d",
        "d": "import json",
    }.items():
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
    assert circles(imports_between([("p", tmp_path)])) == []
    (tmp_path / "d.py").write_text("from p.b import f", encoding="utf-8")
    assert circles(imports_between([("p", tmp_path)])) == [{"p.b", "p.c", "p.d"}]
    (tmp_path / "d.py").write_text("from p import d", encoding="utf-8")
    assert circles(imports_between([("p", tmp_path)])) == [{"p.d"}]


def test_fuzzyctl_imports_nothing_of_its_applications():
    for path in modules():
        if path.is_relative_to(ROOT / "fuzzyctl"):
            assert [name for name in imported(path) if name.split(".")[0] == "dwmr"] == [], path


def strangers(path):
    """Yield the third parties that a module imports outside of their homes."""
    inside = path.relative_to(ROOT).as_posix()
    for top in {name.split(".")[0] for name in imported(path)} & set(HOMES):
        if not any(inside == home or inside.startswith(home + "/") for home in HOMES[top]):
            yield f"{inside} imports {top}"


def test_third_parties_have_one_home():
    assert [found for path in modules() for found in strangers(path)] == []


def test_the_reference_interpreter_shares_only_the_model_with_the_kernels():
    names = {name for path in (ROOT / "tests" / "reference").glob("*.py") for name in imported(path)}
    homes = {_HOMES.get(n.removeprefix("fuzzyctl."), n) for n in names - {"fuzzyctl"} if n.split(".")[0] == "fuzzyctl"}
    assert {".".join(n.split(".")[:2]) for n in homes} == {"fuzzyctl.expr", "fuzzyctl.model"}


def test_dwmr_takes_fuzzyctl_through_two_modules_of_control():
    users = {
        p.name
        for p in (ROOT / "apps" / "dwmr").rglob("*.py")
        if any("kernels" in n or n == "fuzzyctl" for n in imported(p))
    }
    assert users <= {"fuzzy_gains.py", "law_text.py", "jit.py", "summary.py", "common.py", "run.py"}


def loaded_after(code):
    script = f"import sys\n{code}\nprint(' '.join(sorted({{m.split('.')[0] for m in sys.modules}})))"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(run.stdout.split("\n")[-2].split())


HEAVY = {"numpy", "scipy", "numba", "matplotlib", "pydantic"}


def test_the_module_for_building_is_there_without_an_import_of_its_own():
    loaded_after("import fuzzyctl\nassert 'build' in dir(fuzzyctl)\nfuzzyctl.build.partition('a b')")


def test_importing_fuzzyctl_loads_nothing_heavy():
    assert loaded_after("import fuzzyctl") & (HEAVY | {"lark", "click", "rich"}) == set()


@pytest.mark.parametrize(
    "arguments",
    [
        ["--help"],
        ["check", "{rules}/ais_reaction.fz"],
        ["check", "--format", "sarif", "{rules}/ais_reaction.fz"],
        ["eval", "{rules}/ais_reaction.fz", "sigma=0", "dsigma=0"],
        ["explain", "FZ203"],
        ["new", "heater", "-o", "{folder}/heater.fz"],
        ["fmt", "--diff", "{rules}/ais_reaction.fz"],
    ],
)
def test_a_light_command_loads_nothing_heavy(arguments, tmp_path):
    arguments = [a.format(rules=ROOT / "rules", folder=tmp_path) for a in arguments]
    code = (
        "from click.testing import CliRunner\nfrom fuzzyctl.cli.main import main\n"
        f"result = CliRunner().invoke(main, {arguments!r})\nassert result.exit_code == 0, result.output"
    )
    assert loaded_after(code) & HEAVY == set()


def test_a_check_without_findings_imports_neither_other_formats_nor_the_compiler_nor_what_writes_fixes():
    code = f"import fuzzyctl, fuzzyctl.cli.check\nfuzzyctl.check({str(ROOT / 'rules' / 'tipper.fz')!r})\n"
    others = ("formats.foreign", "kernels.compile", "loading.policy", "cli.unified_diff", "support.writing")
    unused = [f"fuzzyctl.{m}" for m in others]
    loaded_after(f"{code}assert [m for m in {unused} if m in sys.modules] == []")


def test_a_file_of_controllers_is_read_without_plants_and_loops():
    code = f"import fuzzyctl\nfuzzyctl.load({str(ROOT / 'rules' / 'smc.fz')!r}, block=fuzzyctl.Controller)\n"
    unused = [f"fuzzyctl.{m}" for m in ("resolve.plants", "resolve.linear", "resolve.loops", "loading.block_files")]
    loaded_after(f"{code}assert [m for m in {unused} if m in sys.modules] == []")


def test_every_name_of_the_facade_exists_and_stands_in_order():
    import fuzzyctl

    assert fuzzyctl.__all__ == sorted(fuzzyctl.__all__, key=lambda n: n.lower()) or fuzzyctl.__all__ == sorted(
        fuzzyctl.__all__
    )
    for name in fuzzyctl.__all__:
        assert getattr(fuzzyctl, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nope'"):
        _ = fuzzyctl.nope


def test_no_submodule_takes_the_place_of_a_function():
    import fuzzyctl

    submodules = {p.stem for p in (ROOT / "fuzzyctl").iterdir()}
    assert submodules & set(fuzzyctl.__all__) == set()


def test_commands_print_through_one_module():
    """Text of a file would control the terminal otherwise, or fail for its encoding; what is painted says so itself."""
    allowed = {"streams.py", "common.py", "show.py", "explain.py"}
    folders = [ROOT / "fuzzyctl" / "cli", ROOT / "apps" / "dwmr" / "cli"]
    users = {p.name for folder in folders for p in folder.glob("*.py") if "click.echo(" in p.read_text("utf-8")}
    assert users <= allowed


#: The documented modules, and the largest number of other modules that tests import; it may only fall.
PUBLIC = {"fuzzyctl", "fuzzyctl.building.build", "fuzzyctl.plot", "fuzzyctl.testing", "dwmr"}
MOST_INTERNAL = 93


def test_tests_speak_through_the_public_api():
    """Each internal module that a test imports has to keep its place and its names when code moves."""
    known = {".".join(p.relative_to(ROOT).with_suffix("").parts) for p in modules()}
    known = {m.removesuffix(".__init__").removeprefix("apps.") for m in known}
    names = {name for path in (ROOT / "tests").rglob("*.py") for name in imported(path)}
    internal = {name for name in names & known - PUBLIC if not name.startswith("fuzzyctl.interop.")}
    packages = {name for name in internal if any(other.startswith(f"{name}.") for other in internal)}
    assert len(internal - packages) <= MOST_INTERNAL, sorted(internal - packages)
