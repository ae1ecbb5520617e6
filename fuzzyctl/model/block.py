"""The base of systems, controllers, plants and loops: what all blocks of a rule file have."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

from fuzzyctl.displayed import Printed
from fuzzyctl.expr import Expr, evaluate
from fuzzyctl.model.guarantee import Param
from fuzzyctl.model.node import Node
from fuzzyctl.model.params import ParamValues


@dataclass(frozen=True, kw_only=True, repr=False)
class Block(Node, Printed):
    """A system, controller, plant or loop.

    Args:
        name: Its identifier.
        title: What it is, for people.
        citation: Where it comes from.
        params: Named constants, as expressions.
        path: The file it was read from, or an empty string.
    """

    #: The word of the rule file that begins such a block.
    kind: ClassVar[str]

    name: str
    title: str = ""
    citation: str = ""
    params: tuple[Param, ...] = ()
    path: str = field(default="", compare=False, repr=False)

    if TYPE_CHECKING:  # fields of systems and of the other blocks, whose parts have other types

        @property
        def inputs(self) -> tuple[Any, ...]:
            """The inputs in the order of declaration."""

        @property
        def outputs(self) -> tuple[Any, ...]:
            """The outputs in the order of declaration."""

        def range_of(self, signal: Any) -> tuple[float, float]:
            """Return the ends of the range of an input or output; infinite without a range."""

    @property
    def identity(self) -> dict[str, str]:
        """What says in JSON which block it is."""
        return {self.kind: self.name}

    @cached_property
    def param_values(self) -> ParamValues:
        """Values of the params as far as they can be computed, and why others cannot."""
        return ParamValues(self.params)

    @cached_property
    def values(self) -> dict[str, float]:
        """Values of all params.

        Raises:
            ExprError: If a param cannot be computed; a loaded block has none such.
        """
        computed = self.param_values
        if computed.errors:
            raise computed.errors[0]
        return computed.values

    def number(self, expr: Expr) -> float:
        """Compute an expression over the params."""
        return evaluate(expr, self.values)
