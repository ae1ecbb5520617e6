"""Settings of control laws in a scenario."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic import ConfigDict, Field

from dwmr.config.quantities import Section

if TYPE_CHECKING:
    from dwmr.control.fuzzy_gains import Rules


class LawSettings(Section):
    """Gains of a control law for one robot; those of a law in Python are fields of a class derived from it."""

    def prove(self, rules: Rules, robot: str) -> None:
        """Prove the assumptions of a law in Python; by default it has none.

        Raises:
            DiagnosticError: When a rule file has mistakes, does not fit its role, or breaks a guarantee.
        """


class TextSettings(LawSettings):
    """Gains of a law that is text: values for its params, by name."""

    model_config = ConfigDict(frozen=True, extra="allow", allow_inf_nan=False, strict=True)
    __pydantic_extra__: dict[str, float] = Field(init=False)
