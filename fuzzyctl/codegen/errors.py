"""Errors of code generation."""

from __future__ import annotations

from fuzzyctl.diagnostics.diagnostic import FuzzyctlError


class CodegenError(FuzzyctlError):
    """Raised for a system that cannot be written for a target, with the reason."""
