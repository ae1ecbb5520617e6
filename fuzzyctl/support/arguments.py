"""Argument checks of the public API: messages name the argument, the expected type and the value. Signatures."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterable, Mapping
from collections.abc import Set as AbstractSet
from inspect import Parameter, Signature
from numbers import Real
from typing import Any, Final, TypeVar

from fuzzyctl.diagnostics.diagnostic import ArgumentError, ValueOutOfBoundsError

#: Largest `max_bytes`; so much is set aside before a file is read.
MOST_BYTES: Final = 1 << 30

_NO_CHARACTER: Final = re.compile("[\\0\\ud800-\\udfff]")

_Kind = TypeVar("_Kind")


def wrong(name: str, due: str, given: object) -> ArgumentError:
    """Return the error for an argument of a wrong type; its text may be long."""
    return ArgumentError(f"{name} must be {due}, got {_called(given)}")


def _called(given: object) -> str:
    return "None" if given is None else type(given).__name__


def no_character(given: str) -> int | None:
    """Return the place of a character that no text file can hold: NUL, or half of a surrogate pair."""
    result = _NO_CHARACTER.search(given)
    return None if result is None else result.start()


def instance(name: str, kind: type[_Kind], due: str, given: object) -> _Kind:
    """Return an argument of one type.

    Raises:
        ArgumentError: For one of another.
    """
    if not isinstance(given, kind):
        raise wrong(name, due, given)
    return given


def text(name: str, given: object) -> str:
    """Return a text."""
    return instance(name, str, "a text", given)


def flag(name: str, given: object) -> bool:
    """Return True or False."""
    return instance(name, bool, "True or False", given)


def items(name: str, due: str, given: object) -> tuple[Any, ...]:
    """Return the items of a list or of another iterable with an order; a text is one thing, and no list of letters."""
    if isinstance(given, str | bytes | bytearray | memoryview | Mapping | AbstractSet) or not isinstance(
        given, Iterable
    ):
        raise wrong(name, due, given)
    try:
        return tuple(given)
    except TypeError:  # such as an array without a dimension
        raise wrong(name, due, given) from None


def items_of(name: str, kinds: tuple[type, ...], due: str, given: object) -> tuple[Any, ...]:
    """Return items of certain types; one of these types is not a list, though it may be iterable."""
    if isinstance(given, kinds):
        raise wrong(name, due, given)
    result = items(name, due, given)
    for item in result:
        if not isinstance(item, kinds):
            raise ArgumentError(f"{name} must be {due}, got one with {_called(item)} in it")
    return result


def names(name: str, given: object) -> tuple[str, ...]:
    """Return names given as a text separated by blanks or as a list."""
    due = "names in one text or in a list"
    return tuple(given.split()) if isinstance(given, str) else items_of(name, (str,), due, given)


def mapping(name: str, due: str, given: Any) -> dict[str, Any]:
    """Return values by name; a Series of pandas has the labels of its rows as names."""
    is_series = hasattr(given, "keys") and getattr(given, "ndim", None) == 1
    if not isinstance(given, Mapping) and not is_series:
        raise wrong(name, due, given)
    results: dict[str, Any] = dict(given)
    for key in results:
        if not isinstance(key, str):
            raise ArgumentError(f"{name} must be {due}, got one with {_called(key)} for a name")
    return results


def path(given: object, hint: str = "") -> str:
    """Return a path that a file system can have; `hint` is added to the message on another one."""
    name = os.fspath(given) if isinstance(given, str | os.PathLike) else None
    if not isinstance(name, str) or "\0" in name or not _encodable(name):
        shown = repr(given) if isinstance(given, str | bytes) else _called(given)
        raise ArgumentError(f"expected the path of a rule file, got {shown:.80}{hint}")
    return name


def _encodable(name: str) -> bool:
    try:
        os.fsencode(name)
    except UnicodeEncodeError:
        return False
    return True


def is_finite(given: object) -> bool:
    """Return whether an argument is a finite number."""
    try:
        return isinstance(given, Real) and math.isfinite(given)
    except OverflowError:  # an integer beyond all floats
        return False


def seconds(name: str, given: object) -> float:
    """Return a time that is not negative; infinity is one."""
    if isinstance(given, bool) or not isinstance(given, Real):
        raise wrong(name, "a number of seconds", given)
    try:
        value = float(given)
    except OverflowError:  # a whole number that no float comes near
        value = math.inf if abs(given) == given else -math.inf
    if not value >= 0.0:
        raise ValueOutOfBoundsError(name, value, ">= 0", "s")
    return value


def integer(name: str, given: object, least: int, most: int) -> int:
    """Return an argument that is an integer within bounds.

    Raises:
        ArgumentError: For a value that is not an integer.
        ValueOutOfBoundsError: For one outside the bounds.
    """
    if not isinstance(given, int) or isinstance(given, bool):
        raise wrong(name, "an integer", given)
    if not least <= given <= most:
        raise ValueOutOfBoundsError(name, given, f"from {least} to {most}")
    return given


def bytes_allowed(given: object) -> int:
    """Return `max_bytes`."""
    if isinstance(given, bool) or not isinstance(given, int):
        raise wrong("'max_bytes'", "a whole number", given)
    if not 1 <= given <= MOST_BYTES:
        shown: object = given if abs(given) < 1 << 63 else int  # longer ones have no text
        raise ValueOutOfBoundsError("'max_bytes'", shown, f"from 1 to {MOST_BYTES:,}")
    return given


class InputSignature:
    """What `inspect.signature` says of one object, whose class does not know its inputs.

    Args:
        positional: The names of an object's arguments by position.
        named: The names of those that are given by name only.
    """

    def __init__(
        self,
        positional: Callable[[Any], Iterable[str]] = lambda _: (),
        named: Callable[[Any], Iterable[str]] = lambda _: (),
    ) -> None:
        self._kinds = (Parameter.POSITIONAL_OR_KEYWORD, positional), (Parameter.KEYWORD_ONLY, named)

    def __get__(self, called: object | None, owner: type) -> Signature:
        """Return the signature.

        Raises:
            AttributeError: For the class, which has that of its constructor, and for names that Python cannot write;
                `inspect` then looks at `__call__`.
        """
        if called is None:
            raise AttributeError("__signature__")
        try:
            return Signature([Parameter(name, kind) for kind, names in self._kinds for name in names(called)])
        except ValueError as error:
            raise AttributeError(f"__signature__: {error}") from None
