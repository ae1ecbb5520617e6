"""Adaptive integrals in machine code: the text of `quadrature` with one set put in, so that the code can be kept.

Functions that take functions are compiled for each of them anew, and numba keeps no such code between runs.
"""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Final

from fuzzyctl.kernels.program import printer, quadrature
from fuzzyctl.kernels.program.program import Quadrature

#: Scalar Python as numba compiles it.
SCALAR: Final = replace(
    printer.SCALAR,
    integral=lambda s, given, marks: (
        f"{s.kind}_{s.function}({f'marked({s.places}, {marks})' if s.marks else s.places}, {given})"
    ),
)

_FUNCTIONS: Final = {
    f.__name__: f
    for f in (
        quadrature.stretch,
        quadrature.rough_area,
        quadrature.summed,
        quadrature.integrals,
        quadrature.moments,
        quadrature.within,
        quadrature.half,
        quadrature.speed,
        quadrature.jumps,
    )
}
#: Other functions that each function of programs needs.
_NEEDED: Final = {
    "moments": ("stretch", "rough_area", "summed", "integrals", "moments"),
    "half": ("stretch", "rough_area", "summed", "integrals", "within", "half"),
    "jumps": ("stretch", "rough_area", "speed", "jumps"),
}
#: How functions are compiled that only compiled functions call: without what Python and C would call.
INNER: Final = '@njit(error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)'
#: Names of a letter and a number, which differ between sets that are the same.
_NUMBERED: Final = re.compile(r"(?<![A-Za-z0-9])[A-Za-z]\d+(?![A-Za-z0-9])")


def integrals_lines(statements: Iterable[Quadrature], tables: Iterable[str]) -> Iterator[str]:
    """Yield the functions that integrate some sets; sets that differ in names only, as in a second call, share one.

    Args:
        statements: The integrals of a program.
        tables: Names of its tables, which functions share.
    """
    functions: dict[str, str] = {}
    kept = set(tables)
    for statement in statements:
        lines = list(integral_lines(statement))
        names: dict[str, str] = {}

        def renamed(found: re.Match[str], names: dict[str, str] = names) -> str:
            return found[0] if found[0] in kept else names.setdefault(found[0], f"#{len(names)}")

        key = _NUMBERED.sub(renamed, "\n".join([statement.kind, *lines]))
        name = f"{statement.kind}_{statement.function}"
        if key in functions:
            yield from ("", "", f"{name} = {functions[key]}")
        else:
            functions[key] = name
            yield from lines


def integral_lines(statement: Quadrature) -> Iterator[str]:
    """Yield the functions that integrate one set, its constants and the set itself."""
    yield from (f"{name} = {value!r}" for name, value in vars(quadrature).items() if name.isupper())
    for line in printer.set_functions(statement, SCALAR):
        yield from ("", "", INNER, line) if line.startswith("def ") else (line,)
    if statement.marks:
        yield from ("", "", INNER, ast.unparse(_PutIn("", "").visit(ast.parse(inspect.getsource(quadrature.marked)))))
    for name in _NEEDED[statement.kind]:
        tree = ast.parse(inspect.getsource(_FUNCTIONS[name]))
        yield from ("", "", INNER, ast.unparse(_PutIn(statement.function, statement.crossing_function).visit(tree)))


class _PutIn(ast.NodeTransformer):
    """Puts a set in for the function that is integrated, and drops types, whose names a module does not have."""

    def __init__(self, function: str, crossing: str) -> None:
        self.function, self.put_in = function, {"function": function, "crossing": crossing}

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        """Return a function without the arguments that are functions."""
        self.generic_visit(node)
        node.name, node.returns = f"{node.name}_{self.function}" if self.function else node.name, None
        node.args.args = [ast.arg(a.arg) for a in node.args.args if a.arg not in self.put_in]
        return node

    def visit_Call(self, node: ast.Call) -> ast.AST:
        """Return a call of the set, or of a function into which it is put."""
        self.generic_visit(node)
        if isinstance(node.func, ast.Name) and node.func.id in self.put_in:
            node.func.id = self.put_in[node.func.id]
        elif isinstance(node.func, ast.Name) and node.func.id in _FUNCTIONS:
            node.func.id = f"{node.func.id}_{self.function}"
            node.args = [a for a in node.args if not (isinstance(a, ast.Name) and a.id in self.put_in)]
        return node
