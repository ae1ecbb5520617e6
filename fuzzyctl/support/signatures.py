"""Signatures of objects that are called with inputs: notebooks complete and show the names of the inputs."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from inspect import Parameter, Signature
from typing import Any


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
