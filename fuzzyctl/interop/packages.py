"""Optional packages of the extra `interop`, imported when they are needed."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from fuzzyctl.diagnostics.diagnostic import FuzzyctlError


class MissingPackageError(FuzzyctlError, ImportError):
    """Raised when a package of the extra `interop` is not installed, or cannot be imported.

    Args:
        package: Its name, as `pip` knows it.
        reason: The error of the import.
    """

    def __init__(self, package: str, reason: str) -> None:
        self.package, self.reason = package, reason
        super().__init__(f"{package} cannot be imported ({reason}): pip install 'fuzzyctl[interop]'")


def required(module: str, package: str) -> Any:
    """Import a module of an optional package.

    Raises:
        MissingPackageError: Where it cannot be imported.
    """
    try:
        return import_module(module)
    except ImportError as error:
        raise MissingPackageError(package, str(error)) from error
