"""Errors of code generation."""

from __future__ import annotations

from fuzzyctl.diagnostics.diagnostic import FuzzyctlError
from fuzzyctl.kernels.program.program import Quadrature, Statement


class CodegenError(FuzzyctlError):
    """Raised for a system that cannot be written for a target, with the reason.

    Args:
        reason: Why.
        function: The function that the target has not; empty for another reason.
    """

    def __init__(self, reason: str, function: str = "") -> None:
        super().__init__(reason)
        self.function = function


def unprintable(statement: Statement) -> CodegenError:
    """Return the error for a statement that a target has no text for."""
    if not isinstance(statement, Quadrature):
        return CodegenError(f"a statement {type(statement).__name__} cannot be printed")
    exact = "bisector" if statement.kind == "half" else "centroid"
    return CodegenError(
        f"the exact {exact} of these sets is an adaptive integral, which only JavaScript of all generated code has; "
        f"sample it, such as 'defuzzifier {exact}(resolution=1000)'"
    )
