"""`fuzzyctl doctor`: the installed packages, the backend in use and the reason, the folder of compiled kernels."""

from __future__ import annotations

import os
import platform
import re
import shutil
from collections import Counter
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, requires, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

import click

import fuzzyctl
from fuzzyctl.cli.common import DONE, FAILED, FORMAT, answers_with_diagnostics, report
from fuzzyctl.cli.streams import write_json
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.support import private_folders
from fuzzyctl.support.cores import cores

#: Packages that fuzzyctl needs; those that some commands need come with extras.
NEEDED: Final = ("lark", "pydantic", "click", "rich", "numpy", "scipy", "matplotlib", "numba", "pygments")
#: Extras that are left out: the union of the others, and packages of the project's own tests.
LEFT_OUT: Final = ("all", "test")

#: Folders of compiled code within the cache: of systems and of simulations.
PARTS: Final = ("kernels", "dwmr")


@click.command()
@click.option("--clear-cache", is_flag=True, help="Remove compiled kernels; they are compiled anew when needed.")
@FORMAT
@answers_with_diagnostics
def doctor(clear_cache: bool, form: str) -> int:
    """Report what is installed and in use.

    Names the backend that evaluates systems, and why, and the folder of compiled kernels.

    Exit code 1 if something that fuzzyctl needs is missing or cannot be used, or if files of the cache cannot be
    removed; evaluation works without numba, slower.
    """
    data = examined()
    if clear_cache and data["cache"]["folder"]:
        removed, problems = _clear(Path(data["cache"]["folder"]))
        data["cache"] = {**_cache(), "removed": removed}
        data["problems"] += problems
    if form == "json":
        write_json(data)
    else:
        report("\n".join(_lines(data)))
    return FAILED if data["problems"] else DONE


def examined() -> dict[str, Any]:
    """Return all findings as plain data."""
    packages = {name: _version(name) for name in NEEDED}
    backend, reason = _backend(packages["numba"])
    problems = [f"{name} is not installed: pip install {name}" for name in NEEDED if packages[name] is None]
    if packages["numba"] is not None and backend != "numba":
        problems.append(f"numba is installed but cannot be used: {reason}")
    return {
        "fuzzyctl": fuzzyctl.__version__,
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "cores": cores(),
        "packages": packages,
        "optional": {name: {"version": _version(name), "extra": extra} for name, extra in optional().items()},
        "backend": backend,
        "reason": reason,
        "c_compiler": next((path for name in ("cc", "gcc", "clang") if (path := shutil.which(name))), None),
        "cache": _cache(),
        "problems": problems,
    }


def optional() -> dict[str, str]:
    """Return the packages of all extras, each with its extra, from the metadata of the installation."""
    try:
        needs = requires("fuzzyctl") or ()
    except PackageNotFoundError:  # a copy of the sources
        needs = ()
    pairs = (re.match(r"""([\w.-]+).*; *extra *== *["']([\w-]+)["']""", need) for need in needs)
    return {pair[1]: pair[2] for pair in pairs if pair is not None and pair[2] not in LEFT_OUT}


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _backend(numba_version: str | None) -> tuple[str, str]:
    """Return which backend `auto` takes, and why."""
    if numba_version is None and find_spec("numba") is None:
        return "numpy", "numba is not installed; single points take generated Python, arrays numpy"
    from fuzzyctl.kernels.compile import numba_is_missing

    reason = numba_is_missing()
    return ("numba", "it is installed and can be imported") if reason is None else ("numpy", reason)


def _cache() -> dict[str, Any]:
    try:
        folder = private_folders.cache_folder()
    except RuntimeError:  # a user without a home, as in some containers
        return {"folder": None, "writable": False, "danger": None, "files": 0, "bytes": 0}
    try:
        sizes = [f.stat().st_size for f in folder.rglob("*") if f.is_file()] if folder.is_dir() else []
        writable = _is_writable(folder)
        # As compiled code is kept for systems and for control laws; folders that do not exist are made private.
        folders = [f for f in (folder, *(folder / part for part in PARTS)) if f.is_dir()]
        danger = next(private_folders.dangers(folders), None)
    except OSError:  # a folder that may not be looked into, or a name that no file system takes
        sizes, writable, danger = [], False, None
    return {
        "folder": str(folder),
        "writable": writable,
        "danger": danger,
        "files": len(sizes),
        "bytes": sum(sizes),
    }


def _is_writable(folder: Path) -> bool:
    """Return whether the folder, or the nearest one above it that there is, can be written to."""
    existing = next((f for f in (folder, *folder.parents) if f.exists()), folder)
    return existing.is_dir() and os.access(existing, os.W_OK)


def _clear(folder: Path) -> tuple[int, list[str]]:
    """Clear the cache; return the number of removed files, and the reasons why others remain."""
    count = 0
    failures: Counter[tuple[str, str | None]] = Counter()
    closed: list[OSError] = []
    parts = [folder / part for part in PARTS]
    links = [f"{part} is a link, behind which nothing is removed" for part in parts if part.is_symlink()]
    for part in (p for p in parts if not p.is_symlink()):
        for place, folders, names in os.walk(part, topdown=False, onerror=closed.append) if part.is_dir() else ():
            for name in (*names, *(f for f in folders if Path(place, f).is_symlink())):
                try:
                    Path(place, name).unlink()
                    count += 1
                except OSError as error:
                    failures[place, error.strerror] += 1
            with suppress(OSError):  # a folder that is not empty: its files are reported
                Path(place).rmdir()
    problems = [f"{counted(n, 'file')} of {place} cannot be removed: {why}" for (place, why), n in failures.items()]
    return count, [*links, *problems, *(f"{e.filename} cannot be looked into: {e.strerror}" for e in closed)]


def _lines(data: dict[str, Any]) -> list[str]:
    cache = data["cache"]
    files = f"{cache['files']} files, {cache['bytes'] / 2**20:.1f} MiB"
    if "removed" in cache:
        files = f"{counted(cache['removed'], 'file')} removed"
    writable = "" if cache["writable"] else "; cannot be written to, so every process compiles anew"
    if cache["danger"]:
        writable = f"; not used, so every process compiles anew: {cache['danger']}. {private_folders.REPAIR}"
    lines = [
        f"fuzzyctl {data['fuzzyctl']}, Python {data['python']}, {data['platform']}, {data['cores']} cores",
        f"backend: {data['backend']}: {data['reason']}",
        f"cache: {cache['folder'] or 'none, as there is no home and FUZZYCTL_CACHE_DIR is not set'}: {files}{writable}",
        f"C compiler: {data['c_compiler'] or 'none found; only tests of generated C need one'}",
        "packages: " + ", ".join(f"{n} {v or 'missing'}" for n, v in data["packages"].items()),
    ]
    for name, package in data["optional"].items():
        how = package["version"] or f"not installed; pip install 'fuzzyctl[{package['extra']}]' brings it"
        lines.append(f"optional: {name}: {how}")
    return [*lines, *(f"problem: {p}" for p in data["problems"])]
