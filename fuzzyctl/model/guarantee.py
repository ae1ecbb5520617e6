"""Params, hedges and guarantees."""

from __future__ import annotations

from dataclasses import dataclass

from fuzzyctl.expr import Expr
from fuzzyctl.model.node import Node


@dataclass(frozen=True, kw_only=True)
class Bounds(Node):
    """A range of numbers; each end belongs to it unless it is left out."""

    lower: Expr
    upper: Expr
    without_lower: bool = False
    without_upper: bool = False


@dataclass(frozen=True, kw_only=True)
class Param(Node):
    """A named constant; its expression may use params declared anywhere in the system."""

    name: str
    expression: Expr
    unit: str = ""
    bounds: Bounds | None = None


@dataclass(frozen=True, kw_only=True)
class Hedge(Node):
    """A hedge of the user's own: `hedge NAME(x) = expression`, over its parameter and params."""

    name: str
    parameter: str
    expression: Expr


@dataclass(frozen=True, kw_only=True)
class Guarantee(Node):
    """A claim over the whole input box: `require CLAIM within TOLERANCE when REGION`."""

    claim: Expr
    within: Expr | None = None
    when: Expr | None = None
