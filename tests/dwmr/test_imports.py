"""The order of the packages of dwmr, and that no files import each other in a circle."""

from functools import cache
from pathlib import Path

from tests.imported import circles, imports_between

DWMR = Path(__file__).parent.parent.parent / "apps" / "dwmr"

#: From the bottom up; a module may import packages on lower lines and modules of its own package.
DWMR_ORDER = [
    ["core", "config"],
    ["reference", "plant", "control"],
    ["control.laws"],
    ["scenario"],
    ["simulation"],
    ["results"],
    ["figures", "output"],
    ["sweep", "page"],
    ["cli", "ros"],
    ["__main__"],
]
RANK = {package: i for i, packages in enumerate(DWMR_ORDER) for package in packages}


@cache
def graph():
    return imports_between([("dwmr", DWMR)])


def package(name):
    return max((one for one in RANK if f"{name}.".startswith(f"dwmr.{one}.")), key=len)


def test_a_module_imports_only_packages_below_its_own():
    arrows = [(a, b) for a, imports in graph().items() for b in imports if package(a) != package(b)]
    assert len(arrows) > 100
    assert [f"{a} imports {b}" for a, b in arrows if RANK[package(b)] >= RANK[package(a)]] == []


def test_every_package_has_its_rank():
    folders = {path.parent.relative_to(DWMR).as_posix().replace("/", ".") for path in DWMR.rglob("__init__.py")}
    assert folders - {"."} | {"__main__"} == set(RANK)


def test_files_import_each_other_in_no_circle():
    assert circles(graph()) == []
