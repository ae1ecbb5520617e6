"""The base of all model types: frozen, closed, and compared without regard to where they were written."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import field, fields, replace
from functools import cache
from types import UnionType
from typing import Any, Literal, NamedTuple, Self, Union, get_args, get_origin, get_type_hints

from fuzzyctl.diagnostics.diagnostic import ValueOutOfBoundsError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.operations import Described
from fuzzyctl.records import dataclass


@dataclass(frozen=True, kw_only=True, repr=False)
class Node(Described):
    """A frozen part of a fuzzy system; `span` says where it was written and takes no part in equality.

    A list in place of a tuple is taken as one.

    Raises:
        ValueOutOfBoundsError: When a field has a value of another type than declared, or a float that is not finite.
    """

    span: Span | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        kind: Any = type(self)
        values = self.__dict__
        for name, plain, takes in _fields_of(kind):
            value = values[name]
            if isinstance(value, plain):
                continue
            if isinstance(value, list):
                value = tuple(value)
                object.__setattr__(self, name, value)
            if not takes(value):
                declared = kind.__dataclass_fields__[name].type
                raise ValueOutOfBoundsError(f"{kind.__name__}.{name}", value, f"of type {declared}")

    def __dir__(self) -> list[str]:
        """Return the names to complete; `model_copy` is for code that copies either kind of model."""
        return [name for name in super().__dir__() if name != "model_copy"]

    def model_copy(self, *, update: Mapping[str, Any] | None = None) -> Self:
        """Return a copy with some fields changed."""
        return replace(self, **(update or {}))


class _Accepted(NamedTuple):
    """The values that a field accepts: instances of some types, words, finite numbers, tuples of accepted items."""

    plain: tuple[type, ...]
    words: tuple[str, ...]
    number: bool
    items: _Accepted | None

    def takes(self, value: object) -> bool:
        """Return whether a value is accepted."""
        if isinstance(value, tuple) and self.items is not None:
            plain, takes = self.items.plain, self.items.takes
            return not [item for item in value if not isinstance(item, plain) and not takes(item)]
        if isinstance(value, float | int):
            return isinstance(value, self.plain) or (self.number and abs(value) <= sys.float_info.max)
        return isinstance(value, self.plain) or (isinstance(value, str) and value in self.words)


@cache
def _fields_of(kind: Any) -> tuple[tuple[str, tuple[type, ...], Callable[[object], bool]], ...]:
    """Return the fields of a model type with the types that they accept, and a function that checks a value."""
    hints = get_type_hints(kind)
    accepted = [(f.name, _accepted(hints[f.name])) for f in fields(kind)]
    return tuple((name, a.plain, a.takes) for name, a in accepted)


def _accepted(declared: Any) -> _Accepted:
    plain: list[type] = []
    words: tuple[str, ...] = ()
    items = None
    for part in get_args(declared) if get_origin(declared) in (Union, UnionType) else (declared,):
        if get_origin(part) is Literal:
            words += get_args(part)
        elif get_origin(part) is tuple:
            items = _accepted(get_args(part)[0])
        elif part is not float:
            plain.append(get_origin(part) or part)
    return _Accepted(tuple(plain), words, float in (declared, *get_args(declared)), items)
