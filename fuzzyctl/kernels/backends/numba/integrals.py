"""Adaptive integrals in machine code: the text of `quadrature` with one set put in, so that the code can be kept.

Functions that take functions are compiled for each of them anew, and numba keeps no such code between runs.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
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
    )
}
#: What each of the functions that programs call needs besides itself.
_NEEDED: Final = {
    "moments": ("stretch", "rough_area", "summed", "integrals", "moments"),
    "half": ("stretch", "rough_area", "summed", "integrals", "within", "half"),
}
#: How functions are compiled that others call.
_PLAIN: Final = '@njit(error_model="numpy")'


def integral_lines(statement: Quadrature) -> Iterator[str]:
    """Yield the functions that integrate one set, its constants and the set itself."""
    yield from (f"{name} = {value!r}" for name, value in vars(quadrature).items() if name.isupper())
    yield from ("", "", _PLAIN, *printer.set_function(statement, SCALAR))
    if statement.marks:
        yield from ("", "", _PLAIN, ast.unparse(_PutIn("").visit(ast.parse(inspect.getsource(quadrature.marked)))))
    for name in _NEEDED[statement.kind]:
        tree = ast.parse(inspect.getsource(_FUNCTIONS[name]))
        yield from ("", "", _PLAIN, ast.unparse(_PutIn(statement.function).visit(tree)))


class _PutIn(ast.NodeTransformer):
    """Puts a set in for the function that is integrated, and drops types, whose names a module does not have."""

    def __init__(self, function: str) -> None:
        self.function = function

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        """Return a function without the argument that is a function."""
        self.generic_visit(node)
        node.name, node.returns = f"{node.name}_{self.function}" if self.function else node.name, None
        node.args.args = [ast.arg(a.arg) for a in node.args.args if a.arg != "function"]
        return node

    def visit_Call(self, node: ast.Call) -> ast.AST:
        """Return a call of the set, or of a function into which it is put."""
        self.generic_visit(node)
        if isinstance(node.func, ast.Name) and node.func.id == "function":
            node.func.id = self.function
        elif isinstance(node.func, ast.Name) and node.func.id in _FUNCTIONS:
            node.func.id = f"{node.func.id}_{self.function}"
            node.args = [a for a in node.args if not (isinstance(a, ast.Name) and a.id == "function")]
        return node
