"""Frozen dataclasses with cheap construction: frozen for type checkers, plain at run time.

A rule file becomes some eight hundred small objects, and a frozen dataclass sets each of its fields by a call. Nothing
in the project writes to one, which mypy proves, so that the calls would buy nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

__all__ = ["record"]

if TYPE_CHECKING:
    from dataclasses import dataclass as record
else:

    def record(*, frozen: bool, slots: bool = False, eq: bool = True) -> Any:
        """Return the decorator of a class that is compared and hashed by its fields, as a frozen dataclass is.

        Args:
            frozen: Always True, so that type checkers refuse to write to it.
            slots: Whether it has no room for other attributes.
            eq: Whether it is compared; otherwise it is equal to itself only, and its class is made in half the time.
        """
        assert frozen, "what may be written to is a dataclass"
        return dataclass(eq=eq, unsafe_hash=eq, repr=eq, slots=slots)
