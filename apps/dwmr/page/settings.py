"""Rows of the settings table: key, value, unit, meaning."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from pydantic import BaseModel


class Row(NamedTuple):
    """One setting."""

    key: str
    value: str
    unit: str
    doc: str


def rows(section: BaseModel, prefix: str = "") -> Iterator[Row]:
    """Yield every setting of a section and of those in it, by its key in the scenario file.

    Args:
        section: A scenario or a part of one.
        prefix: Key of the section, with a dot at its end.
    """
    for name, field in type(section).model_fields.items():
        extra = field.json_schema_extra
        unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
        yield from _of(f"{prefix}{name}", getattr(section, name), unit, field.description or "")
    for name, value in (section.model_extra or {}).items():
        yield from _of(f"{prefix}{name}", value, "", "")


def _of(key: str, value: Any, unit: str, doc: str) -> Iterator[Row]:
    if isinstance(value, BaseModel):
        yield from rows(value, f"{key}.")
    elif isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _of(f"{key}.{name}", inner, "", "")
    elif isinstance(value, tuple | list) and any(isinstance(one, BaseModel) for one in value):
        for k, one in enumerate(value):
            yield from _of(f"{key}[{k}]", one, unit, doc)
    elif value is not None:
        yield Row(key, _shown(value), "" if unit == "-" else unit, doc)


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple | list):
        return ", ".join(_shown(one) for one in value)
    return repr(value) if isinstance(value, float) else str(value)
