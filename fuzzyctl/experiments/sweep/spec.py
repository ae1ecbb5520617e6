"""Model of a SPEC: scenario, varied values, number of repetitions and recorded measures of a sweep."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, Strict, model_validator

Pair = Annotated[tuple[float, float], Strict(False)]


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)


class Distribution(_Table):
    """How a value is drawn: one of the distributions, and what the drawn number is to the scenario's own value."""

    uniform: Pair | None = Field(default=None, description="least and greatest value")
    normal: Pair | None = Field(default=None, description="mean and standard deviation")
    loguniform: Pair | None = Field(default=None, description="least and greatest value, uniform in its logarithm")
    choice: Annotated[tuple[Any, ...], Strict(False)] | None = Field(default=None, description="values, equally likely")
    relative: Literal["no", "factor", "offset"] = Field(
        default="no", description="whether the number multiplies the scenario's value, or is added to it"
    )

    @model_validator(mode="after")
    def _possible(self) -> Distribution:
        given = [name for name in DISTRIBUTIONS if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"must have exactly one of {', '.join(DISTRIBUTIONS)}, has {', '.join(given) or 'none'}")
        low, high = self.uniform or self.loguniform or (0.0, 0.0)
        if low > high:
            raise ValueError(f"{given[0]}: {low:g} is greater than {high:g}")
        if self.loguniform and not low > 0.0:
            raise ValueError(f"loguniform: both values must be > 0, got {low:g}")
        if self.normal and self.normal[1] < 0.0:
            raise ValueError(f"normal: the standard deviation must be >= 0, got {self.normal[1]:g}")
        if self.uniform and not math.isfinite(high - low):
            raise ValueError("uniform: the values are too far apart")
        if self.choice is not None and not self.choice:
            raise ValueError("choice: there is nothing to choose from")
        if self.relative != "no" and any(
            isinstance(v, bool) or not isinstance(v, int | float) for v in self.choice or ()
        ):
            raise ValueError("choice: a factor or an offset must be a number")
        return self


DISTRIBUTIONS = ("uniform", "normal", "loguniform", "choice")


class Spec(_Table):
    """What a SPEC file says; the keys of `set`, `grid` and `random` are those of `--set`.

    An application whose measures are known in advance declares them in a class of its own.
    """

    scenario: str = Field(min_length=1, description="shipped name, or a file beside the SPEC")
    controllers: Annotated[tuple[str, ...], Strict(False)] | None = Field(
        default=None, min_length=1, description="what the scenario is run under; its own when absent"
    )
    runs: int = Field(default=1, ge=1, le=1_000_000, description="repetitions at every point of the grid")
    seed: int = Field(default=0, ge=0, le=2**63 - 1, description="first number of all that is drawn")
    measures: Annotated[tuple[str, ...], Strict(False)] = Field(default=(), description="what to keep of each run")
    set: dict[str, Any] = Field(default={}, description="values that replace those of the scenario in every run")
    grid: dict[str, Annotated[tuple[Any, ...], Strict(False), Field(min_length=1)]] = Field(
        default={}, description="lists of values; every combination of them is run"
    )
    random: dict[str, Distribution] = Field(default={}, description="values drawn anew for every repetition")
