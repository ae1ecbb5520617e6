"""Errors of code generation."""

from __future__ import annotations

from fuzzyctl.diagnostics.diagnostic import FuzzyctlError


class CodegenError(FuzzyctlError):
    """Raised for a system that cannot be written for a target, with the reason.

    Args:
        reason: Why.
        function: The function that the target has not; empty for another reason.
    """

    def __init__(self, reason: str, function: str = "") -> None:
        super().__init__(reason)
        self.function = function
