"""Base class of the sections of a scenario, frozen and strict, and declaration of numbers with units and bounds."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field

#: Farthest place that a scenario may name, and its largest lengths [m].
FARTHEST = 1e9


class Section(BaseModel):
    """One table of a scenario file."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)


def place(doc: str, unit: str = "m") -> Any:
    """Declare a coordinate, which may be as far from 0 as `FARTHEST`."""
    return quantity(doc, unit, ge=-FARTHEST, le=FARTHEST)


def quantity(doc: str, unit: str, **bounds: Any) -> Any:
    """Declare a number with its meaning, its unit and its bounds."""
    return Field(description=doc, json_schema_extra={"unit": unit}, **bounds)
