"""Rule files in a scenario: the name of each file and values for its params."""

from __future__ import annotations

from pydantic import ConfigDict, Field

from dwmr.config.quantities import Section


class RuleFile(Section):
    """A rule file and values for its params."""

    model_config = ConfigDict(frozen=True, extra="allow", allow_inf_nan=False, strict=True)
    __pydantic_extra__: dict[str, float] = Field(init=False)

    file: str = Field(description="name of the rule file", min_length=1)

    @property
    def params(self) -> dict[str, float]:
        """Values for params of the file, by name."""
        return {name: float(value) for name, value in (self.__pydantic_extra__ or {}).items()}
