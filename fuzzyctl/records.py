"""Dataclasses with cheap classes, and records with cheap construction: frozen for type checkers, plain at run time.

A dataclass compiles each of its methods when its module is imported, and a command imports two hundred of them. The
ones here are compared, hashed and shown by shared functions, so that only their constructor is compiled.
A rule file becomes some eight hundred small objects, and a frozen dataclass sets each of its fields by a call. No code
of the project writes to one, which mypy proves, so that records do without the calls.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from operator import attrgetter
from reprlib import recursive_repr
from typing import TYPE_CHECKING, Any

__all__ = ["dataclass", "record"]

if TYPE_CHECKING:
    from dataclasses import dataclass
    from dataclasses import dataclass as record
else:

    def dataclass(
        cls: type | None = None,
        /,
        *,
        eq: bool = True,
        repr: bool = True,
        frozen: bool = False,
        unsafe_hash: bool = False,
        **options: bool,
    ) -> Any:
        """Return a class as `dataclasses.dataclass` does, or its decorator; the arguments are the same."""
        if cls is None:
            return lambda cls: dataclass(cls, eq=eq, repr=repr, frozen=frozen, unsafe_hash=unsafe_hash, **options)
        written = set(vars(cls))
        cls = dataclasses.dataclass(cls, eq=False, repr=False, frozen=frozen, **options)
        fields = dataclasses.fields(cls)
        methods: dict[str, Any] = {}
        if repr:
            methods["__repr__"] = _repr([f.name for f in fields if f.repr])
        if eq:
            methods["__eq__"] = _eq([f.name for f in fields if f.compare])
        if unsafe_hash or (eq and frozen):
            methods["__hash__"] = _hash([f.name for f in fields if (f.compare if f.hash is None else f.hash)])
        elif eq:
            methods["__hash__"] = None
        for name, method in methods.items():
            if name not in written:
                setattr(cls, name, method)
        return cls

    def record(*, frozen: bool, slots: bool = False, eq: bool = True) -> Any:
        """Return the decorator of a class that is compared and hashed by its fields, as a frozen dataclass is.

        Args:
            frozen: Always True, so that type checkers refuse to write to it.
            slots: Whether it has no room for other attributes.
            eq: Whether it is compared; otherwise it is equal to itself only, and has no repr of its fields.
        """
        assert frozen, "what may be written to is a dataclass"
        return dataclass(eq=eq, unsafe_hash=eq, repr=eq, slots=slots)


def _eq(names: list[str]) -> Callable[[Any, Any], Any]:
    def of_one(self: Any, other: Any) -> Any:
        return (get(self),) == (get(other),) if other.__class__ is self.__class__ else NotImplemented

    def of_several(self: Any, other: Any) -> Any:
        return get(self) == get(other) if other.__class__ is self.__class__ else NotImplemented

    get = attrgetter(*names) if names else lambda _: ()
    return of_one if len(names) == 1 else of_several


def _hash(names: list[str]) -> Callable[[Any], int]:
    def of_one(self: Any) -> int:
        return hash((get(self),))

    def of_several(self: Any) -> int:
        return hash(get(self))

    get = attrgetter(*names) if names else lambda _: ()
    return of_one if len(names) == 1 else of_several


def _repr(names: list[str]) -> Callable[[Any], str]:
    def __repr__(self: Any) -> str:  # noqa: N807
        return f"{type(self).__qualname__}({', '.join(f'{name}={getattr(self, name)!r}' for name in names)})"

    return recursive_repr("...")(__repr__)
