"""Params, hedges and guarantees."""

from __future__ import annotations

from pydantic import InstanceOf

from fuzzyctl.expr import Expr
from fuzzyctl.model.node import Node


class Param(Node):
    """A named constant; its expression may use params declared anywhere in the system."""

    name: str
    expression: InstanceOf[Expr]
    unit: str = ""


class Hedge(Node):
    """A hedge of the user's own: `hedge NAME(x) = expression`, over its parameter and params."""

    name: str
    parameter: str
    expression: InstanceOf[Expr]


class Guarantee(Node):
    """A claim over the whole input box: `require CLAIM within TOLERANCE when REGION`."""

    claim: InstanceOf[Expr]
    within: InstanceOf[Expr] | None = None
    when: InstanceOf[Expr] | None = None
