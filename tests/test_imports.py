"""Who may import whom, and what must not be imported at all before it is needed."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

#: From the bottom up; a module may import what stands on a lower line, or on its own line within its own part.
ORDER = [
    ["records"],
    ["source", "codes", "peer_words", "spelling", "numerals", "private_folders"],
    ["misspelt", "terminal"],
    ["errors"],
    ["files", "shipped", "reading", "arguments", "machine_code", "cores"],
    ["expr"],
    ["formulas"],
    ["lang", "model"],
    ["resolve", "formats", "assembly", "linking"],
    ["loading", "fragments"],
    ["as_file", "values"],
    ["cells", "partition"],
    ["build"],
    ["kernels"],
    ["analysis", "plot"],
    ["checking", "highlight", "codegen", "comparison"],
    ["document"],
    ["conversion"],
    ["cli"],
]
RANK = {part: i for i, parts in enumerate(ORDER) for part in parts}

#: Imports against the order, each with its reason.
ALLOWED = {
    # Calling a system is the one place where the model looks up; the import happens at the first call.
    ("model/system.py", "kernels"),
    # Interval arithmetic finds where an own hedge turns; the import happens at the first such hedge under an integral.
    ("kernels/turning_points.py", "analysis"),
}

#: Third parties and the only places that may import them.
HOMES = {
    "lark": {"fuzzyctl/lang"},
    "numba": {
        "fuzzyctl/kernels/backends/numba/native.py",
        "fuzzyctl/kernels/backends/numba/source.py",
        "fuzzyctl/kernels/backends/numba/intrinsics.py",
        "fuzzyctl/kernels/backends/numba/disk_cache.py",
        "apps/dwmr",
    },
    "llvmlite": {"fuzzyctl/kernels/backends/numba/vectorcall.py", "fuzzyctl/kernels/backends/numba/native.py"},
    "matplotlib": {"fuzzyctl/plot", "apps/dwmr/figures"},
    "mpl_toolkits": {"fuzzyctl/plot", "apps/dwmr/figures"},
    "click": {"fuzzyctl/cli", "apps/dwmr/cli"},
    "plotly": {"apps/dwmr/page/plots.py"},
    "PIL": {"apps/dwmr/figures"},
    "pygments": {"fuzzyctl/lang/highlight.py"},
    "pyarrow": {"apps/dwmr/output/data/parquet_file.py"},
    "distributed": {"apps/dwmr/sweep/cluster.py"},
    "scipy": {"apps/dwmr/calibration/search.py", "apps/dwmr/output/data/mat_file.py", "apps/dwmr/sweep/intervals.py"},
}


def modules():
    return [*sorted((ROOT / "fuzzyctl").rglob("*.py")), *sorted((ROOT / "apps").rglob("*.py"))]


def imported(path):
    """Yield the dotted names that a module imports anywhere, also inside functions."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            assert node.level == 0, f"{path}: relative import"
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@pytest.mark.parametrize("path", [p for p in modules() if p.parts[len(ROOT.parts)] == "fuzzyctl"], ids=str)
def test_a_module_imports_only_what_stands_below_it(path):
    inside = path.relative_to(ROOT / "fuzzyctl")
    part = inside.parts[0].removesuffix(".py")
    if part == "__init__":
        return
    for name in imported(path):
        if not name.startswith("fuzzyctl."):
            assert not name.startswith("dwmr"), f"{inside} imports {name}"
            continue
        other = name.split(".")[1]
        if other not in RANK or other == part or (inside.as_posix(), other) in ALLOWED:
            continue
        assert RANK[other] < RANK[part], f"{inside} ({part}) imports {name}"


def test_every_part_has_its_rank():
    parts = {p.relative_to(ROOT / "fuzzyctl").parts[0].removesuffix(".py") for p in (ROOT / "fuzzyctl").rglob("*.py")}
    assert parts - {"__init__", "__pycache__"} == set(RANK)


@pytest.mark.parametrize("path", modules(), ids=str)
def test_third_parties_have_one_home(path):
    inside = path.relative_to(ROOT).as_posix()
    for name in imported(path):
        top = name.split(".")[0]
        if top in HOMES:
            assert any(inside == home or inside.startswith(home + "/") for home in HOMES[top]), (
                f"{inside} imports {top}"
            )


def test_dwmr_takes_fuzzyctl_through_one_module_of_control():
    users = {
        p.name
        for p in (ROOT / "apps" / "dwmr").rglob("*.py")
        if any("kernels" in n or n == "fuzzyctl" for n in imported(p))
    }
    assert users <= {"fuzzy_gains.py", "summary.py", "common.py", "run.py"}


def loaded_after(code):
    script = f"import sys\n{code}\nprint(' '.join(sorted({{m.split('.')[0] for m in sys.modules}})))"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(run.stdout.split("\n")[-2].split())


HEAVY = {"numpy", "scipy", "numba", "matplotlib"}


def test_the_module_for_building_is_there_without_an_import_of_its_own():
    assert "pydantic" in loaded_after(
        "import fuzzyctl\nassert 'build' in dir(fuzzyctl)\nfuzzyctl.build.partition('a b')"
    )
    assert "pydantic" not in loaded_after("import fuzzyctl\ndir(fuzzyctl)")


def test_importing_fuzzyctl_loads_nothing_heavy():
    assert loaded_after("import fuzzyctl") & (HEAVY | {"lark", "pydantic", "click", "rich"}) == set()


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


def test_a_file_of_plain_lines_is_read_without_the_grammar():
    code = f"import fuzzyctl\nfuzzyctl.load({str(ROOT / 'rules' / 'ais_reaction.fz')!r})"
    assert "pydantic" in loaded_after(code)
    assert "lark" not in loaded_after(code)


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
    allowed = {"streams.py", "common.py", "show.py", "explain.py", "fmt.py"}
    folders = [ROOT / "fuzzyctl" / "cli", ROOT / "apps" / "dwmr" / "cli"]
    users = {p.name for folder in folders for p in folder.glob("*.py") if "click.echo(" in p.read_text("utf-8")}
    assert users <= allowed
