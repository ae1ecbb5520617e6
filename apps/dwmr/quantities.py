"""Base of everything read from a scenario file: frozen, strict, and every number with its unit."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field


class Section(BaseModel):
    """One table of a scenario file."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)


def quantity(doc: str, unit: str, **bounds: Any) -> Any:
    """Declare a number with its meaning, its unit and its bounds."""
    return Field(description=doc, json_schema_extra={"unit": unit}, **bounds)
