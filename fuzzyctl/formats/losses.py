"""Losses: what a format cannot express of a system."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, order=True)
class Loss:
    """One thing that a written file does not say, or says in another way.

    Args:
        where: The part of the system, such as `output 'tip'`, `rule 3` or `system 'tipper'`.
        what: The thing itself, such as `hedge 'seldom'`, `param 'k_s'` or `guarantees`.
        why: What the format has instead, one line without a full stop.
        exact: Whether the written file still computes the same numbers, as it does without titles, units and params.
    """

    where: str
    what: str
    why: str
    exact: bool = False

    def __str__(self) -> str:
        return f"{self.where}: {self.what}: {self.why}"
