"""The order of the packages of dwmr, and that no files import each other in a circle."""

import ast
from pathlib import Path

DWMR = Path(__file__).parent.parent.parent / "apps" / "dwmr"

#: From the bottom up; a module may import packages on lower lines and modules of its own package.
DWMR_ORDER = [
    ["core", "config"],
    ["reference", "plant", "control"],
    ["control.laws"],
    ["scenario"],
    ["simulation"],
    ["results"],
    ["output.data", "figures", "calibration"],
    ["output"],
    ["sweep", "page"],
    ["cli"],
    ["__main__"],
]
RANK = {package: i for i, packages in enumerate(DWMR_ORDER) for package in packages}


def import_graph(folder):
    """Return the modules of a package by name, each with those it imports anywhere: in functions and for types, too."""
    files = {}
    for path in folder.rglob("*.py"):
        parts = path.relative_to(folder.parent).with_suffix("").parts
        files[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return {name: {other for other in _imported(path, files) if other != name} for name, path in files.items()}


def _imported(path, files):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in files)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            for name in (f"{node.module}.{alias.name}" for alias in node.names):
                if name in files or node.module in files:
                    yield name if name in files else node.module


def circle(graph):
    """Return the names of one circle in the order of their imports; an empty list where there is none."""
    while leaves := {name for name, imports in graph.items() if not imports & graph.keys()}:
        graph = {name: imports for name, imports in graph.items() if name not in leaves}
    path, name = [], min(graph, default="")
    while name and name not in path:
        path.append(name)
        name = min(graph[name] & graph.keys())
    return path[path.index(name) :] if path else []


def package(name):
    return max((one for one in RANK if f"{name}.".startswith(f"dwmr.{one}.")), key=len)


def test_a_module_imports_only_packages_below_its_own():
    graph = import_graph(DWMR)
    arrows = [(a, b) for a, imports in graph.items() for b in imports if package(a) != package(b)]
    assert len(arrows) > 100
    assert [f"{a} imports {b}" for a, b in arrows if RANK[package(b)] >= RANK[package(a)]] == []


def test_every_package_has_its_rank():
    folders = {path.parent.relative_to(DWMR).as_posix().replace("/", ".") for path in DWMR.rglob("__init__.py")}
    assert folders - {"."} | {"__main__"} == set(RANK)


def test_no_files_import_each_other_in_a_circle():
    found = circle(import_graph(DWMR))
    assert not found, " -> ".join([*found, found[0]])


def test_a_circle_of_types_and_lazy_imports_is_found(tmp_path):
    folder = tmp_path / "p"
    folder.mkdir()
    for name, text in {
        "__init__": "from p.a import x",
        "a": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from p.b import B",
        "b": "def f():\n    from p import c",
        "c": "import p.d",
        "d": "import json",
    }.items():
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
    assert circle(import_graph(folder)) == []
    (folder / "d.py").write_text("from p.b import f", encoding="utf-8")
    assert circle(import_graph(folder)) == ["p.b", "p.c", "p.d"]
