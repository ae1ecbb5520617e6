"""The base of all model types: frozen, closed, and compared without regard to where they were written."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field, InstanceOf

from fuzzyctl.diagnostics.source import Span


class Node(BaseModel):
    """A frozen part of a fuzzy system; `span` says where it was written and takes no part in equality."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    span: InstanceOf[Span] | None = Field(default=None, repr=False, exclude=True)

    def _meaning(self) -> tuple[Any, ...]:
        return tuple(getattr(self, name) for name in type(self).model_fields if name not in _PLACES)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Node) and type(self) is type(other) and self._meaning() == other._meaning()

    def __hash__(self) -> int:
        return hash((type(self).__name__, self._meaning()))


#: Fields that say where something came from, not what it means.
_PLACES = frozenset({"span", "spans", "path"})
