"""Imports between modules, as their texts say: anywhere in a file, for types only or inside of functions."""

import ast
from functools import cache


def imported(path):
    """Yield the dotted names that a module imports, packages of imported names included."""
    for module, name in _imports(path.read_text(encoding="utf-8")):
        yield module
        if name:
            yield f"{module}.{name}"


@cache
def _imports(text):
    """Return modules and the names that are imported from them, "" for the modules themselves."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found += ((alias.name, "") for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            assert node.level == 0, f"relative import of {node.module}"
            found += ((node.module, alias.name) for alias in node.names)
    return found


def imports_between(packages):
    """Return for each module of some packages, given by name and folder, the modules of these that it imports.

    The `__init__.py` of a whole package, which hands on names of its modules, is left out.
    """
    paths = {}
    for top, folder in packages:
        for path in folder.rglob("*.py"):
            parts = path.relative_to(folder).with_suffix("").parts
            if parts != ("__init__",):
                paths[".".join([top, *(p for p in parts if p != "__init__")])] = path
    graph = {}
    for name, path in paths.items():
        read = _imports(path.read_text(encoding="utf-8"))
        found = {f"{module}.{own}" if f"{module}.{own}" in paths else module for module, own in read}
        graph[name] = found & set(paths)
    return graph


def circles(graph):
    """Return the sets of modules that import each other, directly or through others."""
    reached = {name: set() for name in graph}
    for name in graph:
        waiting = list(graph[name])
        while waiting:
            other = waiting.pop()
            if other not in reached[name]:
                reached[name].add(other)
                waiting.extend(graph[other])
    found = []
    for name in sorted(graph):
        if name in reached[name]:
            circle = {name} | {other for other in reached[name] if name in reached[other]}
            if circle not in found:
                found.append(circle)
    return found
