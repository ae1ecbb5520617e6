"""The base of systems, controllers, plants and loops: what all blocks of a rule file have."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable
from dataclasses import field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Self

from fuzzyctl.expr import Expr, evaluate
from fuzzyctl.model.block import Node, Param, ParamValues
from fuzzyctl.operations import Printed
from fuzzyctl.records import dataclass


@dataclass(frozen=True, kw_only=True, repr=False)
class Block(Node, Printed):
    """A system, controller, plant or loop.

    Args:
        name: Its identifier.
        title: A title for people.
        citation: Where it comes from.
        params: Named constants, as expressions.
        path: The file it was read from, or an empty string.
    """

    #: The word of the rule file that begins such a block.
    kind: ClassVar[str]
    #: Whether expressions call it; each other block is given a name, by `block NAME = ...`.
    is_function: ClassVar[bool] = False
    #: Whether it is sampled, so that its equations give the next state, and claims are about every step.
    is_sampled: ClassVar[bool] = False
    #: Why such a block has no claims to prove, an empty text for one that can have some.
    unclaimed: ClassVar[str] = ""

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

        @property
        def systems(self) -> tuple[Any, ...]:
            """The systems that it evaluates."""

        @property
        def definitions(self) -> tuple[Any, ...]:
            """The `let` lines."""

        def range_of(self, signal: Any) -> tuple[float, float]:
            """Return the ends of the range of an input or output; infinite without a range."""

        def with_params(self, **values: float) -> Self:
            """Return the block with some params set to numbers."""

        def with_systems(self, change: Callable[[Any], Any]) -> Self:
            """Return the block with each system that it evaluates changed, those of blocks inside among them."""

    @property
    def parts(self) -> tuple[Block, ...]:
        """The blocks that it calls, each behind those that it calls itself, and at last the block."""
        return (self,)

    @property
    def all_systems(self) -> tuple[Any, ...]:
        """The systems that it evaluates, those of blocks inside among them, each once."""
        return tuple({(s.name, s.path): s for part in self.parts for s in part.systems}.values())

    @property
    def lets(self) -> tuple[Any, ...]:
        """The lets of a system, which claims take by their values; those of other blocks are part of their steps."""
        return ()

    @property
    def states(self) -> tuple[Any, ...]:
        """The declared states in the order of declaration; systems declare none."""
        return ()

    @property
    def changes(self) -> tuple[Any, ...]:
        """The next value of each state, of a plant its derivative by time."""
        return ()

    @property
    def conditions(self) -> dict[str, Expr]:
        """The names of conditions, which claims may have in place of them; a let of a system is a number."""
        return {}

    @property
    def settable(self) -> list[str]:
        """The names of the params that can be set, those of a controller's instances among them."""
        return [p.name for p in self.params]

    @property
    def identity(self) -> dict[str, str]:
        """The keys that name the block in JSON."""
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

    def as_declared(self, name: str) -> str:
        """Return the name of an input as the file spells it: Python writes µ and some others in another form (NFKC)."""
        if name.isascii():
            return name
        return next((v.name for v in self.inputs if unicodedata.normalize("NFKC", v.name) == name), name)
